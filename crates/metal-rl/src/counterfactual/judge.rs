//! Judges: what every motor action would have been worth at a sight. The one here rolls all of them out in copies of
//! the world; a critic learned from logs can take its place where there are no copies (real robots).

use super::gaze::Gaze;
use super::sight::Sight;
use super::student::{Next, Scratch, Student};
use crate::decision::{Content, DecisionDims, DecisionState, Encoding};
use crate::environment::{End, Environment, EnvironmentError};
use crate::member::Member;
use crate::num;
use crate::random::Rng;
use crate::set::IndexSet;
use crate::view::{Percept, Scaling};

/// A sight with its labels: to learn from, through any set of looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// The network's input as if everybody had been looked at.
    pub full: Vec<f32>,
    /// Motor steps since the beginning of the episode.
    pub clock: usize,
    /// What moves are worth after different looks; the student's own looks come first.
    pub worths: Vec<Worth>,
    /// Value of the best motor action after the student's own looks.
    pub value: f64,
}

/// What moves are worth after some looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Worth {
    /// Slots that were looked at before the move, and are remembered after it.
    pub looks: IndexSet,
    /// Value of each motor action minus that of the best after the student's own looks.
    pub advantages: Vec<f64>,
}

impl Judged {
    /// The worth of moves after looks at `mask`, and whether it was judged for these very looks. Others stand in where
    /// it was not: those that differ least. What was seen matters to the future only through memory, so a student
    /// without memory is judged once for all looks.
    #[must_use]
    pub fn worth(&self, mask: IndexSet) -> (&[f64], bool) {
        let differ = |w: &Worth| w.looks.minus(mask).union(mask.minus(w.looks)).len();
        let nearest =
            self.worths.iter().reduce(|best, next| if differ(next) < differ(best) { next } else { best });
        nearest.map_or((&[], false), |w| (&w.advantages, self.worths.len() == 1 || w.looks == mask))
    }
}

/// The work of a judge on some sights: labels, and the motor steps simulated for them.
pub type Verdict = Result<(Vec<Judged>, usize), EnvironmentError>;

/// Says what every motor action is worth at a sight.
///
/// The values must be those under the student's *own* continuation, its looks paid at the pupil's share of their price: a
/// teacher who sees more than the student values what the student cannot do.
pub trait Judge {
    /// Labels for `sights`, in their order, and how many motor steps they took.
    ///
    /// # Errors
    /// If a world fails.
    fn judge(&self, sights: Vec<Sight>, pupil: &Pupil<'_>) -> Verdict;
}

/// Whose future is judged.
#[derive(Clone, Copy)]
pub struct Pupil<'a> {
    /// The student that drives on.
    pub student: &'a Student,
    /// All members of the mind.
    pub members: &'a [Member],
    /// Which of them each slot is.
    pub roster: &'a [usize],
    /// How readings are scaled.
    pub scaling: Scaling,
    /// Share of the price of looking that counts.
    pub price_share: f64,
}

/// Does independent pieces of work, perhaps several at a time. The mind starts no threads itself; results must not
/// depend on who does them when.
pub trait Workers: Sync {
    /// Calls `work` on every piece and returns the results in the order of the pieces.
    fn map(&self, pieces: Vec<Vec<Sight>>, work: &(dyn Fn(Vec<Sight>) -> Verdict + Sync)) -> Vec<Verdict>;
}

/// Does one piece after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Workers for Alone {
    fn map(&self, pieces: Vec<Vec<Sight>>, work: &(dyn Fn(Vec<Sight>) -> Verdict + Sync)) -> Vec<Verdict> {
        pieces.into_iter().map(work).collect()
    }
}

/// Sights in one piece of work.
const PIECE: usize = 64;

/// Roll-outs: at each sight the world is copied once per motor action, all copies with the same noise. The action is
/// carried out, the student drives on for `horizon` steps, and its own value stands for the rest.
pub struct RollOuts<'a> {
    /// Who does the work.
    pub workers: &'a dyn Workers,
}

impl Judge for RollOuts<'_> {
    /// # Panics
    /// If the copy of a world cannot be copied itself.
    fn judge(&self, sights: Vec<Sight>, pupil: &Pupil<'_>) -> Verdict {
        let mut pieces: Vec<Vec<Sight>> = Vec::new();
        for sight in sights {
            match pieces.last_mut() {
                Some(piece) if piece.len() < PIECE => piece.push(sight),
                _ => pieces.push(vec![sight]),
            }
        }
        let work = |piece: Vec<Sight>| {
            let Some(first) = piece.first() else { return Ok((Vec::new(), 0)) };
            let mut desk = Desk::new(*pupil, first.world.as_ref());
            let judged = piece.into_iter().map(|s| desk.judge(s)).collect::<Result<_, EnvironmentError>>()?;
            Ok((judged, desk.steps))
        };
        let (mut judged, mut steps) = (Vec::new(), 0);
        for verdict in self.workers.map(pieces, &work) {
            let (piece, taken) = verdict?;
            judged.extend(piece);
            steps += taken;
        }
        Ok((judged, steps))
    }
}

/// Working memory of one worker.
struct Desk<'a> {
    pupil: Pupil<'a>,
    student: &'a Student,
    encoding: Encoding,
    percept: Percept,
    state: DecisionState,
    block: Vec<f64>,
    scratch: Scratch,
    gaze: Gaze,
    steps: usize,
}

impl<'a> Desk<'a> {
    fn new(pupil: Pupil<'a>, world: &dyn Environment) -> Self {
        let student = pupil.student;
        let inputs = pupil.members.iter().map(|m| m.view.dims()).collect();
        let dims = DecisionDims { member_inputs: inputs, actions: student.actions() };
        Self {
            pupil,
            student,
            encoding: Encoding { content: student.config().content, ..Encoding::default() },
            percept: Percept::new(world.spec(), pupil.scaling),
            state: DecisionState::new(&dims),
            block: Vec::new(),
            scratch: student.scratch(),
            gaze: Gaze::new(student.layout()),
            steps: 0,
        }
    }

    fn judge(&mut self, mut sight: Sight) -> Result<Judged, EnvironmentError> {
        self.percept.clear();
        self.state.clear();
        self.gaze.clone_from(&sight.gaze);
        for slot in 0..self.pupil.roster.len() {
            self.look(sight.world.as_mut(), slot)?;
        }
        let full = self.gaze.input().to_vec();
        let own = sight.gaze.attended();
        let mut worths = vec![self.worth(&sight, &full, own)?];
        if self.student.remembers_free_looks() {
            let other = self.other_looks(own, &mut sight.streams.stream("looks"));
            worths.push(self.worth(&sight, &full, other)?);
        }
        let value = num::max(&worths[0].advantages);
        worths.iter_mut().flat_map(|w| &mut w.advantages).for_each(|v| *v -= value);
        Ok(Judged { full, clock: sight.gaze.clock(), worths, value })
    }

    /// Looks that the student could have taken instead of its own: one less or one more.
    fn other_looks(&self, own: IndexSet, rng: &mut Rng) -> IndexSet {
        let more = IndexSet::first(self.pupil.roster.len()).minus(own);
        let drop = !own.is_empty() && (more.is_empty() || rng.chance(0.5));
        let from = if drop { own } else { more };
        let slot = from.iter().nth(rng.below(from.len().max(1)));
        slot.map_or(own, |slot| if drop { own.without(slot) } else { own.with(slot) })
    }

    /// The value of every motor action after `looks`.
    fn worth(&mut self, sight: &Sight, full: &[f32], looks: IndexSet) -> Result<Worth, EnvironmentError> {
        let mut advantages = Vec::with_capacity(self.student.actions());
        for action in 0..self.student.actions() {
            let mut world = sight.world.fork().expect("a copied world can be copied");
            self.gaze.clone_from(&sight.gaze);
            self.gaze.see_through(self.student.layout(), full, looks);
            advantages.push(self.roll_out(world.as_mut(), action)?);
        }
        Ok(Worth { looks, advantages })
    }

    /// What `action` is worth from here: r + γ (looks and moves of the student) + … + its own value of what is left.
    fn roll_out(&mut self, world: &mut dyn Environment, mut action: usize) -> Result<f64, EnvironmentError> {
        let (horizon, gamma) = (self.student.config().horizon, self.student.config().gamma);
        let (mut total, mut discount) = (0.0, 1.0);
        for step in 1.. {
            let outcome = world.step(action)?;
            self.steps += 1;
            total += discount * outcome.motor_reward;
            discount *= gamma;
            if outcome.end == End::Terminal {
                break;
            }
            self.gaze.advance(self.student.layout(), action);
            let (next, price) = self.decide(world)?;
            total -= discount * price;
            if step == horizon || outcome.end == End::TimeLimit {
                if self.student.config().bootstrap {
                    total += discount * self.student.worth(&self.gaze, next, &self.scratch);
                }
                break;
            }
            action = next;
        }
        Ok(total)
    }

    /// The student's looks, then its move; and the price of the looks as it is learned from.
    fn decide(&mut self, world: &mut dyn Environment) -> Result<(usize, f64), EnvironmentError> {
        self.percept.clear();
        self.state.clear();
        let mut price = 0.0;
        loop {
            match self.student.next(&self.gaze, &mut self.scratch) {
                Next::Move(action) => return Ok((action, self.pupil.price_share * price)),
                Next::Look(slot) => price += self.look(world, slot)?,
            }
        }
    }

    fn look(&mut self, world: &mut dyn Environment, slot: usize) -> Result<f64, EnvironmentError> {
        let index = self.pupil.roster[slot];
        let member = &self.pupil.members[index];
        self.block.resize(self.student.layout().block(slot).len(), 0.0);
        let price = if self.encoding.content == Content::Readings {
            // What the member makes of its reading is not asked for, so it is not computed.
            member.read(world, &mut self.percept, &mut self.block)?
        } else {
            let price = member.consult(index, world, &mut self.percept, &mut self.state)?;
            if let Some(opinion) = self.state.opinion(index) {
                self.encoding.write(&opinion, &mut self.block);
            }
            price
        };
        self.gaze.look(self.student.layout(), slot, &self.block);
        Ok(price)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::config::CounterfactualConfig;
    use crate::counterfactual::gaze::MemoryConfig;
    use crate::counterfactual::rule::{LookRule, Rule};
    use crate::counterfactual::student::StudentShape;
    use crate::environment::{EnvironmentSpec, Feature, Outcome, SensorSpec};
    use crate::learners::{LearnerConfig, TileConfig};
    use crate::random::Streams;
    use crate::view::View;
    use std::sync::{Arc, Mutex};

    /// Action 1 costs 4, action 0 nothing; every look is written down by all copies together.
    #[derive(Clone)]
    struct Counter {
        spec: EnvironmentSpec,
        time: usize,
        looks: Arc<Mutex<Vec<(usize, usize)>>>,
    }

    impl Environment for Counter {
        fn spec(&self) -> &EnvironmentSpec {
            &self.spec
        }
        fn reset(&mut self, _seed: u64) -> Result<(), EnvironmentError> {
            self.time = 0;
            Ok(())
        }
        fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
            self.looks.lock().unwrap().push((self.time, sensor));
            out[0] = 0.5;
            Ok(())
        }
        fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
            self.time += 1;
            Ok(Outcome { motor_reward: -4.0 * action as f64, end: End::Running })
        }
        fn measures(&self) -> &[f64] {
            &[]
        }
        fn fork(&self) -> Option<Box<dyn Environment>> {
            Some(Box::new(self.clone()))
        }
    }

    fn world() -> Counter {
        let sensor = |name: &str, price| SensorSpec {
            name: name.into(),
            features: vec![Feature { name: "x".into(), low: 0.0, high: 1.0 }],
            price,
        };
        let spec = EnvironmentSpec {
            id: "Counter-v0".into(),
            sensors: vec![sensor("a", 1.0), sensor("b", 2.0), sensor("c", 3.0)],
            actions: vec!["free".into(), "dear".into()],
            horizon: 10,
            measures: vec![],
        };
        Counter { spec, time: 0, looks: Arc::default() }
    }

    /// One sight of a newborn student, judged; and what was looked at meanwhile.
    fn judged(rule: Rule, memory: MemoryConfig) -> (Judged, usize, Vec<(usize, usize)>) {
        let looks = LookRule::default();
        let config = CounterfactualConfig {
            looks,
            memory,
            horizon: 1,
            gamma: 0.5,
            bootstrap: false,
            ..CounterfactualConfig::default()
        };
        let world = world();
        let members: Vec<Member> = (0..3)
            .map(|s| Member {
                name: format!("m{s}"),
                view: View::new(&world.spec, &[s]),
                learner: LearnerConfig::Tile(TileConfig::default())
                    .build(crate::learner::Dims { inputs: 1, choices: 2 }, 0)
                    .unwrap(),
            })
            .collect();
        let shape = StudentShape { blocks: vec![1; 3], prices: vec![1.0, 2.0, 3.0], actions: 2, rule };
        let student = Student::new(&config, &shape, &Streams::new(1)).unwrap();
        let mut gaze = Gaze::new(student.layout());
        gaze.look(student.layout(), 2, &[0.5]);
        let log = world.looks.clone();
        let sight = Sight { gaze, world: Box::new(world), streams: Streams::new(4) };
        let pupil = Pupil {
            student: &student,
            members: &members,
            roster: &[0, 1, 2],
            scaling: Scaling::Linear,
            price_share: 0.5,
        };
        let (mut all, steps) = RollOuts { workers: &Alone }.judge(vec![sight], &pupil).unwrap();
        let looked = log.lock().unwrap().clone();
        (all.remove(0), steps, looked)
    }

    #[test]
    fn moves_are_worth_their_reward_and_the_students_next_looks() {
        let slots = IndexSet::EMPTY.with(2);
        let (judged, steps, looks) = judged(Rule::Scheduled { slots, every: 1 }, MemoryConfig::default());
        // γ · share · price of slot 2 = 0.5 · 0.5 · 3 after either move.
        assert_eq!((judged.value, &judged.worths[0].advantages[..]), (-0.75, &[0.0, -4.0][..]));
        assert_eq!((judged.worths.len(), steps), (1, 2));
        assert_eq!(judged.worth(IndexSet::first(2)), (&[0.0, -4.0][..], true), "looks leave no trace");
        // All three sensors once, for the label; in roll-outs what the student attends, and nothing else.
        let rolled: Vec<_> = looks.iter().filter(|(time, _)| *time > 0).collect();
        assert_eq!(rolled, [&(1, 2), &(1, 2)]);
        assert_eq!(looks.iter().filter(|(time, _)| *time == 0).count(), 3);
    }

    #[test]
    fn with_memory_other_looks_are_judged_beside_its_own() {
        let memory = MemoryConfig { looks: 1, steps: 2, action: false };
        let (judged, steps, _) = judged(Rule::Adaptive { min_looks: 0, max_looks: 2 }, memory);
        let own = IndexSet::EMPTY.with(2);
        let other = judged.worths[1].looks;
        assert_eq!((judged.worths[0].looks, steps), (own, 4));
        assert!(other.is_empty() || (other.len() == 2 && other.contains(2)), "{other:?}");
        assert!(judged.worth(own).1 && judged.worth(other).1);
        assert!(!judged.worth(IndexSet::first(3)).1);
    }
}
