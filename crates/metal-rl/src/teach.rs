//! What members learn from an episode: each from the moments it was attended, and from nothing else. Eqs. (3, 4).

use crate::decision::DecisionState;
use crate::learner::Sample;
use crate::member::Member;
use crate::num;
use crate::phase::{Lessons, Teaching};
use crate::returns::{Link, lambda_returns};
use crate::set::IndexSet;

/// An episode as the members saw it: for every motor step who was attended, what they read and what it was worth.
#[derive(Clone, Debug)]
pub struct Episode {
    offsets: Vec<usize>,
    readings: Vec<f64>,
    state_values: Vec<f64>,
    attended: Vec<IndexSet>,
    moves: Vec<(usize, f64)>,
    terminal: bool,
    links: Vec<Link>,
    targets: Vec<f64>,
    seen_at: Vec<usize>,
}

impl Episode {
    /// Room for an episode of `members`.
    #[must_use]
    pub fn new(members: &[Member]) -> Self {
        let mut offsets = vec![0];
        for m in members {
            offsets.push(offsets[offsets.len() - 1] + m.view.dims());
        }
        Self {
            offsets,
            readings: Vec::new(),
            state_values: Vec::new(),
            attended: Vec::new(),
            moves: Vec::new(),
            terminal: false,
            links: Vec::new(),
            targets: Vec::new(),
            seen_at: Vec::new(),
        }
    }

    /// Forgets the episode.
    pub fn clear(&mut self) {
        self.readings.clear();
        self.state_values.clear();
        self.attended.clear();
        self.moves.clear();
        self.terminal = false;
    }

    fn members(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Remembers who was attended and what they saw, before a move (or after the last one, to bootstrap).
    pub fn record_state(&mut self, state: &DecisionState) {
        // Whose sensors were silent saw nothing to learn from.
        self.attended.push(state.heard());
        for m in 0..self.members() {
            let opinion = state.opinion(m);
            self.state_values.push(opinion.map_or(f64::NAN, |o| num::max(o.values)));
            match opinion {
                Some(o) => self.readings.extend_from_slice(o.reading),
                None => self
                    .readings
                    .resize(self.readings.len() + self.offsets[m + 1] - self.offsets[m], f64::NAN),
            }
        }
    }

    /// Remembers the move and what it earned.
    pub fn record_move(&mut self, action: usize, motor_reward: f64, terminal: bool) {
        self.moves.push((action, motor_reward));
        self.terminal = terminal;
    }

    fn reading(&self, step: usize, member: usize) -> &[f64] {
        let row = step * self.offsets[self.members()];
        &self.readings[row + self.offsets[member]..row + self.offsets[member + 1]]
    }

    /// V of `member` at `step`, from what `source` (itself by default) saw there.
    fn value(&self, step: usize, source: usize) -> f64 {
        self.state_values[step * self.members() + source]
    }

    /// Lets every attended member of `roster` learn. The order of members never matters: each learns from its own
    /// chain, with values as they were when it was asked.
    pub fn teach(&mut self, members: &mut [Member], roster: IndexSet, lessons: &Lessons) {
        if lessons.teaching == Teaching::Nobody {
            return;
        }
        for m in roster.iter() {
            self.chain(m, lessons);
            let mut targets = std::mem::take(&mut self.targets);
            targets.clear();
            targets.resize(self.links.len(), 0.0);
            lambda_returns(&self.links, lessons.credit.lambda, &mut targets);
            for (&step, &target) in self.seen_at.iter().zip(&targets) {
                let sample = Sample {
                    state: self.reading(step, m),
                    choice: self.moves[step].0,
                    target,
                    demonstrated: lessons.demonstrated,
                };
                members[m].learner.learn(sample, lessons.rate);
            }
            self.targets = targets;
        }
    }

    /// The moments at which `member` was attended before a move, linked by what happened in between.
    fn chain(&mut self, member: usize, lessons: &Lessons) {
        self.links.clear();
        self.seen_at.clear();
        self.seen_at.extend((0..self.moves.len()).filter(|&step| self.attended[step].contains(member)));
        let source = lessons.bootstrap.unwrap_or(member);
        for k in 0..self.seen_at.len() {
            let stop = self.seen_at.get(k + 1).copied().unwrap_or(self.moves.len());
            let link = self.link(self.seen_at[k]..stop, source, lessons.credit.gamma);
            self.links.push(link);
        }
    }

    /// Over the `steps`: discounted reward, discount, and the value of where they lead.
    ///
    /// If the episode was cut where `source` did not look, the value where it last looked stands in: an unattended
    /// sensor is never read, not even to bootstrap (reading R5).
    fn link(&self, steps: std::ops::Range<usize>, source: usize, gamma: f64) -> Link {
        let (mut reward, mut discount) = (0.0, 1.0);
        for &(_, r) in &self.moves[steps.clone()] {
            reward += discount * r;
            discount *= gamma;
        }
        if steps.end == self.moves.len() && self.terminal {
            return Link { reward, discount, next_value: 0.0 };
        }
        let last_seen =
            (0..=steps.end.min(self.attended.len() - 1)).rev().find(|&t| self.attended[t].contains(source));
        Link { reward, discount, next_value: last_seen.map_or(0.0, |t| self.value(t, source)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::{EnvironmentSpec, Feature, SensorSpec};
    use crate::learner::{Dims, Learner, Rate};
    use crate::returns::Credit;
    use crate::view::View;
    use std::sync::{Arc, Mutex};

    /// What a recording learner was told: state, choice, target.
    type Heard = Arc<Mutex<Vec<(Vec<f64>, usize, f64)>>>;

    /// A learner that writes down what it is told.
    #[derive(Clone)]
    struct Recorder(Heard);

    impl Learner for Recorder {
        fn dims(&self) -> Dims {
            Dims { inputs: 1, choices: 2 }
        }
        fn values(&self, state: &[f64], out: &mut [f64]) {
            out.copy_from_slice(&[-10.0 * state[0], -100.0]);
        }
        fn support(&self, _state: &[f64], out: &mut [f64]) {
            out.fill(0.5);
        }
        fn learn(&mut self, s: Sample<'_>, _rate: Rate) -> f64 {
            self.0.lock().expect("tests do not poison").push((s.state.to_vec(), s.choice, s.target));
            0.0
        }
        fn size(&self) -> (usize, &'static str) {
            (0, "notes")
        }
        fn freeze(&self) -> Vec<u8> {
            Vec::new()
        }
        fn boxed_clone(&self) -> Box<dyn Learner> {
            Box::new(self.clone())
        }
    }

    fn mind() -> (Vec<Member>, Vec<Heard>) {
        let sensor = |name: &str| SensorSpec {
            name: name.into(),
            features: vec![Feature { name: "x".into(), low: 0.0, high: 1.0 }],
            price: 1.0,
        };
        let spec = EnvironmentSpec {
            id: "Test-v0".into(),
            sensors: vec![sensor("a"), sensor("b")],
            actions: vec!["l".into(), "r".into()],
            horizon: 3,
            measures: vec![],
        };
        let heard = vec![Heard::default(), Heard::default()];
        let members = (0..2)
            .map(|i| Member {
                name: format!("m{i}"),
                view: View::new(&spec, &[i]),
                learner: Box::new(Recorder(heard[i].clone())),
            })
            .collect();
        (members, heard)
    }

    fn say(episode: &mut Episode, members: &[Member], readings: &[Option<f64>]) {
        let dims = crate::decision::DecisionDims { member_inputs: vec![1, 1], actions: 2 };
        let mut state = DecisionState::new(&dims);
        for (m, reading) in readings.iter().enumerate() {
            if let Some(x) = reading {
                let (r, v, s) = state.attend(m);
                r[0] = *x;
                members[m].learner.values_and_support(&[*x], v, s);
            }
        }
        episode.record_state(&state);
    }

    fn lessons(bootstrap: Option<usize>) -> Lessons {
        Lessons {
            teaching: Teaching::Attended,
            rate: Rate::Full,
            credit: Credit { gamma: 0.5, lambda: 0.0 },
            bootstrap,
            demonstrated: false,
        }
    }

    #[test]
    fn rewards_add_up_until_a_member_is_attended_again() {
        let (mut members, heard) = mind();
        let mut episode = Episode::new(&members);
        say(&mut episode, &members, &[Some(0.1), Some(0.1)]);
        episode.record_move(1, -2.0, false);
        say(&mut episode, &members, &[None, Some(0.2)]);
        episode.record_move(0, -4.0, false);
        say(&mut episode, &members, &[Some(0.3), None]);
        episode.teach(&mut members, IndexSet::first(2), &lessons(None));
        // Member 0 was blind in between: r + γ r' + γ² V(0.3); it is told nothing of the step it did not see.
        assert_eq!(*heard[0].lock().unwrap(), vec![(vec![0.1], 1, -2.0 - 2.0 + 0.25 * -3.0)]);
        // Member 1 did not look where the time limit fell: its last look (0.2) stands in.
        let told = heard[1].lock().unwrap().clone();
        assert_eq!(told, vec![(vec![0.1], 1, -2.0 + 0.5 * -2.0), (vec![0.2], 0, -4.0 + 0.5 * -2.0)]);
    }

    #[test]
    fn a_terminal_end_has_no_future_and_another_member_may_lend_its_value() {
        let (mut members, heard) = mind();
        let mut episode = Episode::new(&members);
        say(&mut episode, &members, &[Some(0.1), Some(0.9)]);
        episode.record_move(1, -2.0, false);
        say(&mut episode, &members, &[Some(0.5), Some(0.8)]);
        episode.record_move(0, -4.0, true);
        episode.teach(&mut members, IndexSet::first(2), &lessons(Some(1)));
        assert_eq!(heard[0].lock().unwrap()[0].2, -2.0 + 0.5 * -8.0);
        assert_eq!(heard[0].lock().unwrap()[1].2, -4.0);
    }
}
