//! Phase III on the real highway: what nobody attended is never read, by nobody, at no moment. The world itself keeps
//! the minutes, and so do the policy and every learner; the closing decision behind a time limit is no exception.
#![allow(clippy::unwrap_used)]

use metal_lab::experiments;
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::train::train_phase;
use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome};
use metal_rl::learner::{Dims, Learner, Rate, Sample};
use metal_rl::observe::{Observer, Step};
use metal_rl::policy::{Choice, Experience, Policy, Situation};
use metal_rl::random::{Rng, Streams};
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

#[derive(Clone, Debug, PartialEq)]
enum Event {
    Reset,
    Sensed(usize),
    Stepped,
    Consulted(usize),
    Decided,
    /// After a motor step: what the observer was shown.
    Shown {
        read: IndexSet,
        attended: IndexSet,
    },
}

type Minutes = Arc<Mutex<Vec<Event>>>;

fn note(minutes: &Minutes, event: Event) {
    minutes.lock().unwrap().push(event);
}

/// A world that keeps the minutes.
struct Recording(Box<dyn Environment>, Minutes);

impl Environment for Recording {
    fn spec(&self) -> &EnvironmentSpec {
        self.0.spec()
    }
    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        note(&self.1, Event::Reset);
        self.0.reset(seed)
    }
    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        note(&self.1, Event::Sensed(sensor));
        self.0.sense(sensor, out)
    }
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        note(&self.1, Event::Stepped);
        self.0.step(action)
    }
    fn measures(&self) -> &[f64] {
        self.0.measures()
    }
    fn advise(&mut self) -> Option<usize> {
        panic!("nobody asks the expert in phase III")
    }
}

/// A policy that keeps the minutes.
struct Witness<'a>(&'a mut dyn Policy, Minutes);

impl Policy for Witness<'_> {
    fn choose(&mut self, situation: &Situation<'_>, rng: &mut Rng) -> Choice {
        assert_eq!(situation.advice, None);
        let choice = self.0.choose(situation, rng);
        note(
            &self.1,
            match choice {
                Choice::Consult(m) => Event::Consulted(m),
                Choice::Move(_) => Event::Decided,
            },
        );
        choice
    }
    fn experience(&mut self, experience: Experience) {
        self.0.experience(experience);
    }
    fn learn(&mut self) {
        self.0.learn();
    }
    fn begin(&mut self, learning: bool) {
        self.0.begin(learning);
    }
}

fn bits(state: &[f64]) -> Vec<u64> {
    state.iter().map(|x| x.to_bits()).collect()
}

/// A member's learner that may learn only from what it was shown when somebody asked it.
#[derive(Clone)]
struct Honest {
    learner: Box<dyn Learner>,
    shown: Arc<Mutex<BTreeSet<Vec<u64>>>>,
    learned: Arc<Mutex<usize>>,
}

impl Learner for Honest {
    fn dims(&self) -> Dims {
        self.learner.dims()
    }
    fn values(&self, state: &[f64], out: &mut [f64]) {
        self.learner.values(state, out);
    }
    fn support(&self, state: &[f64], out: &mut [f64]) {
        self.learner.support(state, out);
    }
    fn values_and_support(&self, state: &[f64], values: &mut [f64], support: &mut [f64]) {
        self.shown.lock().unwrap().insert(bits(state));
        self.learner.values_and_support(state, values, support);
    }
    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64 {
        assert!(sample.target.is_finite() && sample.state.iter().all(|x| x.is_finite()));
        assert!(
            self.shown.lock().unwrap().contains(&bits(sample.state)),
            "learned from a state it was not shown"
        );
        *self.learned.lock().unwrap() += 1;
        self.learner.learn(sample, rate)
    }
    fn size(&self) -> (usize, &'static str) {
        self.learner.size()
    }
    fn freeze(&self) -> Vec<u8> {
        self.learner.freeze()
    }
    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}

struct Shown(Minutes);

impl Observer for Shown {
    fn on_step(&mut self, step: &Step<'_>) {
        note(&self.0, Event::Shown { read: step.percept.read(), attended: step.state.attended() });
    }
}

const EPISODES: usize = 6;

/// Phase III of `plan`, minuted; the counts say how often each member learned.
fn attention(plan: &Plan) -> (Vec<Event>, Vec<usize>) {
    let streams = Streams::new(3);
    let mut mind = Mind::newborn(plan, &streams).unwrap();
    for phase in ["demonstration", "fusion"] {
        mind = train_phase(plan, phase, mind, &streams, &Silent).unwrap().mind;
    }
    let phase = plan.phase("attention_phase3");
    let mut acl = mind.take_attention(plan, "acl_phase3", phase.roster, &streams).unwrap();
    let counts: Vec<Arc<Mutex<usize>>> = mind.members.iter().map(|_| Arc::default()).collect();
    for (member, learned) in mind.members.iter_mut().zip(&counts) {
        let learner = member.learner.clone();
        member.learner = Box::new(Honest { learner, shown: Arc::default(), learned: learned.clone() });
    }
    let minutes = Minutes::default();
    let mut world = Recording(plan.file.environment.build().unwrap(), minutes.clone());
    let mut policy = Witness(&mut acl, minutes.clone());
    let (members, scaling) = (&mut mind.members, plan.file.scaling);
    let mut stage = Stage { environment: &mut world, members, policy: &mut policy, scaling };
    run(&mut stage, &phase, &streams, &mut Shown(minutes.clone())).unwrap();
    let events = minutes.lock().unwrap().clone();
    (events, counts.iter().map(|c| *c.lock().unwrap()).collect())
}

/// The sensors that the looks of one decision must read, in order: those of each consulted member, but none twice.
fn due(plan: &Plan, consulted: &[usize]) -> Vec<usize> {
    let mut sensors = Vec::new();
    for &m in consulted {
        sensors.extend(
            plan.members[m].sensors.iter().filter(|s| !sensors.contains(*s)).copied().collect::<Vec<_>>(),
        );
    }
    sensors
}

#[test]
fn what_nobody_attends_is_never_read() {
    let sets = [
        "phase.demonstration.budget.steps=100",
        "phase.fusion.budget.episodes=2",
        "environment.highway.horizon=25",
    ];
    let mut sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    sets.push(format!("phase.attention_phase3.budget.episodes={EPISODES}"));
    let plan = plan::parse(experiments::PAPER, &sets).unwrap();
    let (events, learned) = attention(&plan);

    let (mut consulted, mut sensed, mut decided) = (Vec::new(), Vec::new(), false);
    let (mut steps, mut decisions, mut closing, mut unattended) = (0, 0, 0, 0);
    let mut last = IndexSet::EMPTY;
    for event in &events {
        match event {
            Event::Consulted(m) => consulted.push(*m),
            Event::Sensed(s) => {
                assert!(!decided, "a sensor was read between a decision and its move");
                sensed.push(*s);
                assert_eq!(sensed[..], due(&plan, &consulted)[..sensed.len()], "only what was just paid for");
            }
            Event::Decided => {
                assert_eq!(sensed, due(&plan, &consulted), "all of it was read");
                last = consulted.iter().copied().collect();
                unattended += plan.spec.sensors.len() - sensed.len();
                (decided, decisions) = (true, decisions + 1);
                (consulted, sensed) = (Vec::new(), Vec::new());
            }
            Event::Stepped => {
                assert!(decided, "a move without a decision");
                (decided, steps) = (false, steps + 1);
            }
            Event::Shown { read, attended } => {
                assert_eq!(*attended, last, "the observer is shown who was consulted");
                let views = last.iter().flat_map(|m| plan.members[m].sensors.clone());
                assert_eq!(*read, views.collect::<IndexSet>());
            }
            Event::Reset => {
                closing += usize::from(decided);
                decided = false;
                assert!(consulted.is_empty() && sensed.is_empty(), "looks before the first decision");
            }
        }
    }
    closing += usize::from(decided);
    assert_eq!(
        (steps, closing),
        (EPISODES * 25, EPISODES),
        "every episode was cut, and closed by one more decision"
    );
    assert_eq!(decisions, steps + closing);
    assert!(unattended > decisions, "attention leaves sensors alone, or this test shows nothing");
    let tiny: Vec<usize> =
        plan.roster(&plan.file.phase["attention_phase3"].roster).iter().map(|m| learned[m]).collect();
    assert!(tiny.iter().all(|&n| n > 0 && n <= steps), "{tiny:?}");
    assert_eq!(learned[plan.member("FOA").unwrap()], 0, "the full observer is gone in phase III");
}
