//! Roll-outs: every motor action is carried out in a copy of the world, and the student drives on there.

use crate::counterfactual::iterate::{CounterfactualError, School};
use crate::counterfactual::judge::eyes::Eyes;
use crate::counterfactual::judge::sight::{Sight, gather};
use crate::counterfactual::judge::{
    Appointed, Drive, Judge, Judged, Labels, Pupil, Stop, Verdict, Workers, other_looks,
};
use crate::counterfactual::student::appointment::{Appointment, Kept};
use crate::counterfactual::student::gaze::Gaze;
use crate::counterfactual::student::{Next, Scratch, Student};
use crate::environment::{End, Environment, EnvironmentError};
use crate::num;
use crate::observe::Observer;
use crate::set::IndexSet;

/// Appointments that are judged beside the student's own.
const OTHERS: usize = 4;

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
    fn labels(
        &mut self,
        school: &mut School<'_>,
        drive: &Drive<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Labels, CounterfactualError> {
        let Some((sights, trail)) = gather(school, drive, observer)? else {
            return Err(CounterfactualError::NoCopies(school.environment.spec().id.clone()));
        };
        let pupil = Pupil::of(school, drive);
        let (judged, rolled_steps) = self.judge(sights, &pupil)?;
        Ok(Labels { judged, trail, rolled_steps })
    }
}

impl RollOuts<'_> {
    /// Labels for `sights`, in their order, and how many motor steps they took.
    ///
    /// # Errors
    /// If a world fails.
    ///
    /// # Panics
    /// If the copy of a world cannot be copied itself.
    pub fn judge(&self, sights: Vec<Sight>, pupil: &Pupil<'_>) -> Verdict {
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

/// Whether two appointments are with the same slot a step apart, or at the same time.
fn is_near(one: Appointment, other: Appointment) -> bool {
    if one.slot == other.slot { one.wait.abs_diff(other.wait) == 1 } else { one.wait == other.wait }
}

/// Working memory of one worker.
struct Desk<'a> {
    pupil: Pupil<'a>,
    student: &'a Student,
    eyes: Eyes<'a>,
    scratch: Scratch,
    gaze: Gaze,
    steps: usize,
}

impl<'a> Desk<'a> {
    fn new(pupil: Pupil<'a>, world: &dyn Environment) -> Self {
        let student = pupil.student;
        Self {
            pupil,
            student,
            eyes: Eyes::new(pupil, world.spec()),
            scratch: student.scratch(),
            gaze: Gaze::new(student.layout()),
            steps: 0,
        }
    }

    fn judge(&mut self, mut sight: Sight) -> Result<Judged, EnvironmentError> {
        self.eyes.blink();
        self.gaze.clone_from(&sight.gaze);
        for slot in 0..self.student.layout().slots() {
            self.eyes.look(sight.world.as_mut(), slot, &mut self.gaze)?;
        }
        let full = self.gaze.input().to_vec();
        let own = sight.gaze.attended();
        let mut advantages = Vec::with_capacity(self.student.actions());
        for action in 0..self.student.actions() {
            advantages.push(self.worth(&sight, (&full, own), Some(action))?);
        }
        let value = num::max(&advantages);
        let appointments = self.appointments(&mut sight, &full, &advantages)?;
        let stops = self.stops(&mut sight, &full, &advantages)?;
        let relative = |s: Stop| Stop { worth: s.worth - value, ..s };
        let stops = stops.into_iter().map(relative).collect();
        advantages.iter_mut().for_each(|v| *v -= value);
        Ok(Judged { full, clock: sight.gaze.clock(), looks: own, advantages, value, stops, appointments })
    }

    /// What moving is worth after the student's own looks and after others, if that makes a difference.
    fn stops(
        &mut self,
        sight: &mut Sight,
        full: &[f32],
        values: &[f64],
    ) -> Result<Vec<Stop>, EnvironmentError> {
        if self.student.rule().appoints() || !self.student.remembers_free_looks() {
            return Ok(Vec::new());
        }
        let own = sight.gaze.attended();
        let action = self.preferred_move(sight, (full, own));
        let mut stops = vec![Stop { looks: own, worth: values[action] }];
        for looks in other_looks(self.student, own, &mut sight.streams.stream("looks")) {
            if stops.iter().all(|s| s.looks != looks) {
                stops.push(Stop { looks, worth: self.worth(sight, (full, looks), None)? });
            }
        }
        Ok(stops)
    }

    /// What appointments are worth that could be made here, where the student makes one; now and then as if one look
    /// less had been taken, so that the way to the last look is judged, too.
    fn appointments(
        &mut self,
        sight: &mut Sight,
        full: &[f32],
        values: &[f64],
    ) -> Result<Option<Appointed>, EnvironmentError> {
        if !sight.gaze.has_appointed() {
            return Ok(None);
        }
        let mut rng = sight.streams.stream("appointments");
        let own = sight.gaze.attended();
        let before = own.len() > 1 || (own.len() == 1 && sight.gaze.clock() == 0);
        let taken = if before && rng.chance(0.5) { own.iter().nth(rng.below(own.len())) } else { None };
        let looks = taken.map_or(own, |slot| own.without(slot));
        let action = self.preferred_move(sight, (full, looks));
        let Some(choice) = self.student.preferred_appointment(looks, &self.scratch) else { return Ok(None) };
        let base = if looks == own && choice.wait > 0 && sight.gaze.appointment() == Some(choice) {
            values[action]
        } else {
            self.keep(sight, (full, looks), (choice, action))?
        };
        let mut kept = vec![Kept { appointment: choice, worth: 0.0 }];
        let open: Vec<Appointment> = self.student.open_appointments(looks).collect();
        for _ in 0..OTHERS {
            let near = rng.chance(0.5);
            let some: Vec<Appointment> =
                open.iter().copied().filter(|a| !near || is_near(*a, choice)).collect();
            let Some(&other) = some.get(rng.below(some.len().max(1))) else { continue };
            if kept.iter().all(|k| k.appointment != other) {
                let worth = self.keep(sight, (full, looks), (other, action))? - base;
                kept.push(Kept { appointment: other, worth });
            }
        }
        Ok(Some(Appointed { looks, kept }))
    }

    /// What it is worth to keep an appointment that is made after some looks, with `action` as the move until then.
    fn keep(
        &mut self,
        sight: &Sight,
        seen: (&[f32], IndexSet),
        (appointment, action): (Appointment, usize),
    ) -> Result<f64, EnvironmentError> {
        let mut world = sight.world.fork().expect("a copied world can be copied");
        self.see(sight, seen);
        self.gaze.appoint(Some(appointment));
        if appointment.wait > 0 {
            return self.roll_out(world.as_mut(), action);
        }
        let (action, price) = self.decide(world.as_mut())?;
        Ok(self.roll_out(world.as_mut(), action)? - price)
    }

    /// The gaze of `sight` as if `looks` were all that was looked at.
    fn see(&mut self, sight: &Sight, (full, looks): (&[f32], IndexSet)) {
        self.gaze.clone_from(&sight.gaze);
        self.gaze.see_through(self.student.layout(), full, looks);
    }

    fn preferred_move(&mut self, sight: &Sight, seen: (&[f32], IndexSet)) -> usize {
        self.see(sight, seen);
        self.student.evaluate(self.gaze.input(), &mut self.scratch);
        self.student.best_move(&self.scratch)
    }

    /// The value of `action`, or of the move that the student prefers, after some looks.
    fn worth(
        &mut self,
        sight: &Sight,
        seen: (&[f32], IndexSet),
        action: Option<usize>,
    ) -> Result<f64, EnvironmentError> {
        let action = action.unwrap_or_else(|| self.preferred_move(sight, seen));
        let mut world = sight.world.fork().expect("a copied world can be copied");
        self.see(sight, seen);
        self.roll_out(world.as_mut(), action)
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
            self.student.advance(&mut self.gaze, action);
            let (next, price) = self.decide(world)?;
            total -= discount * price;
            if step == horizon || outcome.end == End::TimeLimit {
                if self.student.config().bootstrap {
                    total += discount * self.student.worth(next, &self.scratch);
                }
                break;
            }
            action = next;
        }
        Ok(total)
    }

    /// The student's looks, then its move; and the price of the looks as it is learned from.
    fn decide(&mut self, world: &mut dyn Environment) -> Result<(usize, f64), EnvironmentError> {
        self.eyes.blink();
        let mut price = 0.0;
        loop {
            match self.student.next(&mut self.gaze, &mut self.scratch) {
                Next::Move(action) => return Ok((action, self.pupil.price_share * price)),
                Next::Look(slot) => price += self.eyes.look(world, slot, &mut self.gaze)?,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::config::CounterfactualConfig;
    use crate::counterfactual::judge::Alone;
    use crate::counterfactual::student::StudentShape;
    use crate::counterfactual::student::gaze::MemoryConfig;
    use crate::counterfactual::student::rule::{LookRule, Rule};
    use crate::environment::{EnvironmentSpec, Feature, Outcome, SensorSpec};
    use crate::learners::{LearnerConfig, TileConfig};
    use crate::member::Member;
    use crate::observe::Unobserved;
    use crate::phase::{Budget, Phase};
    use crate::random::Streams;
    use crate::view::{Scaling, View};
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
        judged_by_chance(rule, memory, 4)
    }

    /// Somebody who sees one sensor.
    fn member(world: &Counter, sensor: usize) -> Member {
        Member {
            name: format!("m{sensor}"),
            view: View::new(&world.spec, &[sensor]),
            learner: LearnerConfig::Tile(TileConfig::default())
                .build(crate::learner::Dims { inputs: 1, choices: 2 }, 0)
                .unwrap(),
        }
    }

    fn judged_by_chance(
        rule: Rule,
        memory: MemoryConfig,
        chance: u64,
    ) -> (Judged, usize, Vec<(usize, usize)>) {
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
        let members: Vec<Member> = (0..3).map(|sensor| member(&world, sensor)).collect();
        let shape = StudentShape { blocks: vec![1; 3], prices: vec![1.0, 2.0, 3.0], actions: 2, rule };
        let student = Student::new(&config, &shape, &Streams::new(1)).unwrap();
        let mut gaze = Gaze::new(student.layout());
        gaze.look(student.layout(), 2, &[0.5]);
        if rule.appoints() {
            gaze.appoint(Some(Appointment { slot: 0, wait: 2 }));
        }
        let log = world.looks.clone();
        let sight = Sight { gaze, world: Box::new(world), streams: Streams::new(chance) };
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
        assert_eq!((judged.value, &judged.advantages[..]), (-0.75, &[0.0, -4.0][..]));
        assert_eq!((judged.stops.len(), steps), (0, 2));
        assert_eq!(judged.stop(IndexSet::first(2), 1), (-4.0, true), "looks leave no trace");
        // All three sensors once, for the label; in roll-outs what the student attends, and nothing else.
        let rolled: Vec<_> = looks.iter().filter(|(time, _)| *time > 0).collect();
        assert_eq!(rolled, [&(1, 2), &(1, 2)]);
        assert_eq!(looks.iter().filter(|(time, _)| *time == 0).count(), 3);
    }

    #[test]
    fn with_memory_other_looks_are_judged_beside_its_own() {
        let memory = MemoryConfig { looks: 1, steps: 2, ..MemoryConfig::default() };
        let (judged, steps, looks) = judged(Rule::Adaptive { min_looks: 0, max_looks: 2 }, memory);
        let own = IndexSet::EMPTY.with(2);
        assert_eq!((judged.looks, judged.stops[0].looks), (own, own));
        assert!(judged.stop(IndexSet::EMPTY, 0).1, "the student may always look at nobody");
        assert!(judged.stops[1..].iter().all(|s| s.looks != own));
        // Two moves after its own looks, one after each other set; everybody once, for the label.
        assert_eq!(steps, 2 + judged.stops.len() - 1);
        assert_eq!(looks.iter().filter(|(time, _)| *time == 0).count(), 3);
        assert!(!judged.stop(IndexSet::first(3), 0).1);
    }

    #[test]
    fn whoever_drives_the_students_future_is_judged() {
        let world = world();
        let config = CounterfactualConfig {
            horizon: 1,
            gamma: 0.5,
            bootstrap: false,
            judged: 1.0,
            ..CounterfactualConfig::default()
        };
        // One looks at the third slot before every move, the other one at the first.
        let [student, driver] = [2, 0].map(|slot| {
            let rule = Rule::Scheduled { slots: IndexSet::EMPTY.with(slot), every: 1 };
            let shape = StudentShape { blocks: vec![1; 3], prices: vec![1.0, 2.0, 3.0], actions: 2, rule };
            Student::new(&config, &shape, &Streams::new(1)).unwrap()
        });
        let mut members: Vec<Member> = (0..3).map(|sensor| member(&world, sensor)).collect();
        let mut school = School {
            environment: &mut world.clone(),
            validation: &mut world.clone(),
            members: &mut members,
            roster: vec![0, 1, 2],
            scaling: Scaling::Linear,
            workers: &Alone,
            interrupted: &|| false,
            ear: &mut |_| {},
        };
        let phase = Phase { budget: Budget::Steps(5), ..Phase::evaluation("drive", IndexSet::first(3), 0) };
        let streams = Streams::new(2);
        let drive = Drive { student: &student, driver: &driver, phase, limit: 5, price_share: 1.0, streams };
        let labels = RollOuts { workers: &Alone }.labels(&mut school, &drive, &mut Unobserved).unwrap();
        assert_eq!(labels.judged.len(), 5);
        for judged in &labels.judged {
            assert_eq!(judged.looks, IndexSet::EMPTY.with(0), "where the driver went");
            assert_eq!(judged.value, -1.5, "γ times the price of the student's next look");
        }
    }

    #[test]
    fn appointments_are_worth_what_they_cost_within_sight() {
        // With one step in sight, a look after one step costs γ · share · price, and a later one nothing. Who looks at once
        // may move otherwise, too.
        let price = |a: Appointment| if a.wait == 1 { 0.25 * [1.0, 2.0, 3.0][a.slot] } else { 0.0 };
        let mut told_apart = 0;
        for chance in 0..10 {
            let rule = Rule::Appointed { max_looks: 1, ahead: 2 };
            let (judged, _, looks) = judged_by_chance(rule, MemoryConfig::default(), chance);
            let made = judged.appointments.expect("an appointment was made");
            assert_eq!(made.kept[0].worth, 0.0, "the student's own choice is what others are counted from");
            let later: Vec<&Kept> = made.kept.iter().filter(|k| k.appointment.wait > 0).collect();
            for pair in later.windows(2) {
                let expected = price(pair[0].appointment) - price(pair[1].appointment);
                assert!((pair[1].worth - pair[0].worth - expected).abs() < 1e-12, "{pair:?}");
                told_apart += usize::from(expected != 0.0);
            }
            assert!(looks.iter().all(|(time, _)| *time <= 1));
        }
        assert!(told_apart > 5, "{told_apart}");
    }
}
