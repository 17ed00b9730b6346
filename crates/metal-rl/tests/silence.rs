//! Sensors that deliver no numbers (reading R109): nothing of it reaches a learner, looks are paid, nobody is taught, and
//! every policy goes on.
#![allow(clippy::unwrap_used)]

use metal_rl::decision::{DecisionState, Encoding};
use metal_rl::environment::{
    End, Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, SensorSpec,
};
use metal_rl::explore::Schedule;
use metal_rl::fuse::Fuser;
use metal_rl::learner::{Dims, Learner, Rate, Sample};
use metal_rl::learners::{AbspConfig, BayesMixConfig, IgmnConfig, LearnerConfig, MlpConfig, TileConfig};
use metal_rl::member::{Member, decision_dims};
use metal_rl::observe::{Observer, Step};
use metal_rl::phase::{Budget, Lessons, Phase, Sensing, Teaching};
use metal_rl::policies::attention::{Consultable, MotorTarget, learner_dims};
use metal_rl::policies::{Attention, AttentionConfig, Fusion, RandomLooks, RestConfig, Solo};
use metal_rl::policy::Policy;
use metal_rl::random::{Rng, Streams};
use metal_rl::returns::Credit;
use metal_rl::run::{Stage, run};
use metal_rl::set::IndexSet;
use metal_rl::view::{Percept, Scaling, View};

/// Two sensors of two numbers each; a share of the readings holds what is no number.
struct Flaky {
    spec: EnvironmentSpec,
    rng: Rng,
    time: usize,
    share: f64,
    reward: f64,
}

impl Flaky {
    fn new(share: f64) -> Self {
        let feature = |name: &str| Feature { name: name.into(), low: 0.0, high: 1.0 };
        let sensor = |name: &str, price| SensorSpec {
            name: name.into(),
            features: vec![feature("x"), feature("y")],
            price,
        };
        let spec = EnvironmentSpec {
            id: "Flaky-v0".into(),
            sensors: vec![sensor("a", 1.0), sensor("b", 2.0)],
            actions: vec!["zero".into(), "one".into()],
            horizon: 10,
            measures: vec![],
        };
        Self { spec, rng: Rng::new(0), time: 0, share, reward: -1.0 }
    }
}

impl Environment for Flaky {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }
    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        (self.rng, self.time) = (Rng::new(seed), 0);
        Ok(())
    }
    fn sense(&mut self, _sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        out.fill_with(|| self.rng.uniform());
        if self.rng.chance(self.share) {
            out[self.rng.below(2)] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][self.rng.below(3)];
        }
        Ok(())
    }
    fn step(&mut self, _action: usize) -> Result<Outcome, EnvironmentError> {
        self.time += 1;
        let end = if self.time == self.spec.horizon { End::TimeLimit } else { End::Running };
        Ok(Outcome { motor_reward: self.reward, end })
    }
    fn measures(&self) -> &[f64] {
        &[]
    }
}

/// Any learner, watched: what reaches it is made of numbers in [0, 1].
#[derive(Clone)]
struct Guarded(Box<dyn Learner>);

fn assert_numbers(state: &[f64]) {
    assert!(state.iter().all(|x| (0.0..=1.0).contains(x)), "{state:?} reached a learner");
}

impl Learner for Guarded {
    fn dims(&self) -> Dims {
        self.0.dims()
    }
    fn values(&self, state: &[f64], out: &mut [f64]) {
        assert_numbers(state);
        self.0.values(state, out);
    }
    fn support(&self, state: &[f64], out: &mut [f64]) {
        assert_numbers(state);
        self.0.support(state, out);
    }
    fn learn(&mut self, sample: Sample<'_>, rate: Rate) -> f64 {
        assert_numbers(sample.state);
        assert!(sample.target.is_finite(), "{} was to be learned", sample.target);
        self.0.learn(sample, rate)
    }
    fn size(&self) -> (usize, &'static str) {
        self.0.size()
    }
    fn freeze(&self) -> Vec<u8> {
        self.0.freeze()
    }
    fn boxed_clone(&self) -> Box<dyn Learner> {
        Box::new(self.clone())
    }
}

fn learners() -> Vec<LearnerConfig> {
    vec![
        LearnerConfig::Absp(AbspConfig::default()),
        LearnerConfig::BayesMix(BayesMixConfig::default()),
        LearnerConfig::Igmn(IgmnConfig::default()),
        LearnerConfig::Tile(TileConfig::default()),
        LearnerConfig::Mlp(MlpConfig { hidden: vec![8], ..MlpConfig::default() }),
    ]
}

fn born(config: &LearnerConfig, inputs: usize, choices: usize) -> Box<dyn Learner> {
    Box::new(Guarded(config.build(Dims { inputs, choices }, 1).unwrap()))
}

/// Two who see one sensor each, and one who sees both.
fn members(spec: &EnvironmentSpec, config: &LearnerConfig) -> Vec<Member> {
    let views: [&[usize]; 3] = [&[0], &[1], &[0, 1]];
    let member = |sensors: &[usize]| {
        let view = View::new(spec, sensors);
        Member { name: format!("{sensors:?}"), learner: born(config, view.dims(), 2), view }
    };
    views.map(member).into_iter().collect()
}

fn phase(roster: IndexSet) -> Phase {
    Phase {
        name: "test".into(),
        roster,
        sensing: Sensing::OnDemand,
        lessons: Lessons {
            teaching: Teaching::Attended,
            rate: Rate::Constant(0.2),
            credit: Credit { gamma: 0.9, lambda: 0.5 },
            bootstrap: None,
            demonstrated: false,
        },
        policy_learns: true,
        exploration: Schedule::Random { from: 0.3, to: 0.3, until: 1.0 },
        budget: Budget::Episodes(30),
    }
}

/// Checks that every look is paid, and that whoever is heard has something to say.
#[derive(Default)]
struct Bill {
    looks: usize,
    silent: usize,
}

impl Observer for Bill {
    fn on_step(&mut self, step: &Step<'_>) {
        let read = step.percept.read();
        // Not `sum`: of nothing it is −0.
        let price = read.iter().fold(0.0, |total: f64, s| total + [1.0, 2.0][s]);
        assert_eq!(price.to_bits(), step.look_price.to_bits());
        self.looks += read.len();
        self.silent += step.percept.silent().len();
        for m in step.state.attended().iter() {
            let opinion = step.state.opinion(m);
            assert_eq!(opinion.is_some(), step.state.heard().contains(m));
            assert!(opinion.is_none_or(|o| o.values.iter().chain(o.support).all(|x| x.is_finite())));
        }
    }
}

fn policies(spec: &EnvironmentSpec, members: &[Member], config: &LearnerConfig) -> Vec<Box<dyn Policy>> {
    let attention = |motor_target| {
        let config_of_attention = AttentionConfig { motor_target, ..AttentionConfig::default() };
        let dims = decision_dims(members, spec);
        let shape = learner_dims(&config_of_attention, &dims, &[0, 1]);
        let consultable = Consultable { members: vec![0, 1], prices: vec![1.0, 2.0] };
        let learner = born(config, shape.inputs, shape.choices);
        Box::new(Attention::new(config_of_attention, learner, &dims, consultable)) as Box<dyn Policy>
    };
    let everybody = IndexSet::first(3);
    vec![
        Box::new(Solo::new(2, 2)),
        Box::new(Solo::new(0, 2)),
        Box::new(Fusion::new(Fuser::MaxConfidence, everybody, 2)),
        Box::new(RandomLooks::new(Fuser::LogOpinionPool, everybody, 1.5, 2)),
        attention(MotorTarget::MacroReturn),
        attention(MotorTarget::Literal),
    ]
}

#[test]
fn nothing_that_is_no_number_reaches_a_learner() {
    for config in learners() {
        for share in [0.3, 1.0] {
            let mut world = Flaky::new(share);
            let spec = world.spec.clone();
            for mut policy in policies(&spec, &members(&spec, &config), &config) {
                let mut members = members(&spec, &config);
                let mut stage = Stage {
                    environment: &mut world,
                    members: &mut members,
                    policy: policy.as_mut(),
                    scaling: Scaling::SquareRoot,
                };
                let mut bill = Bill::default();
                run(&mut stage, &phase(IndexSet::first(3)), &Streams::new(5), &mut bill).unwrap();
                assert!(bill.looks > 0 && bill.silent > 0, "{config:?}: nothing was tried");
                assert!(share < 1.0 || bill.silent == bill.looks);
            }
        }
    }
}

#[test]
fn a_member_is_null_only_if_none_of_its_sensors_answered() {
    let mut world = Flaky::new(0.0);
    let spec = world.spec.clone();
    let members = members(&spec, &LearnerConfig::Tile(TileConfig::default()));
    let dims = decision_dims(&members, &spec);
    let (mut percept, mut state) = (Percept::new(&spec, Scaling::Linear), DecisionState::new(&dims));
    world.share = 1.0;
    assert!((members[0].consult(0, &mut world, &mut percept, &mut state).unwrap() - 1.0).abs() < 1e-12);
    world.share = 0.0;
    assert!((members[2].consult(2, &mut world, &mut percept, &mut state).unwrap() - 2.0).abs() < 1e-12);
    assert!(state.opinion(0).is_none(), "asked, but null");
    assert_eq!((state.order(), state.heard()), ([0, 2].as_slice(), IndexSet::EMPTY.with(2)));
    assert_eq!((percept.reading(0), percept.silent()), (None, IndexSet::EMPTY.with(0)));
    let reading = state.opinion(2).unwrap().reading;
    assert_eq!(reading[..2], [0.0, 0.0], "a silent sensor beside another one saw nothing");
    assert_eq!(&reading[2..], percept.reading(1).unwrap());
    let encoding = Encoding::default();
    let mut out = vec![f64::NAN; encoding.len(&dims, &[0, 1])];
    encoding.encode(&state, &[0, 1], &mut out);
    assert_eq!(out, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0], "asked in vain is not the same as not asked");
}

#[test]
fn a_reward_that_is_no_number_is_refused() {
    for reward in [f64::NAN, f64::INFINITY] {
        let mut world = Flaky::new(0.0);
        world.reward = reward;
        let mut members = members(&world.spec.clone(), &LearnerConfig::Tile(TileConfig::default()));
        let mut policy = Solo::new(0, 2);
        let mut stage = Stage {
            environment: &mut world,
            members: &mut members,
            policy: &mut policy,
            scaling: Scaling::Linear,
        };
        let error = run(&mut stage, &phase(IndexSet::first(3)), &Streams::new(1), &mut Bill::default());
        assert!(error.unwrap_err().to_string().contains("not a finite number"));
    }
}

/// Looks of attention that must ask both members before every move, in three episodes of ten steps.
fn looks(rests: RestConfig, share: f64) -> usize {
    let mut world = Flaky::new(share);
    let spec = world.spec.clone();
    let config = LearnerConfig::Tile(TileConfig::default());
    let (mut members, attention) =
        (members(&spec, &config), AttentionConfig { min_looks: 2, rests, ..AttentionConfig::default() });
    let dims = decision_dims(&members, &spec);
    let shape = learner_dims(&attention, &dims, &[0, 1]);
    let consultable = Consultable { members: vec![0, 1], prices: vec![1.0, 2.0] };
    let learner = born(&config, shape.inputs, shape.choices);
    let mut policy = Attention::new(attention, learner, &dims, consultable);
    let mut stage = Stage {
        environment: &mut world,
        members: &mut members,
        policy: &mut policy,
        scaling: Scaling::SquareRoot,
    };
    let (mut bill, mut short) = (Bill::default(), phase(IndexSet::first(3)));
    short.budget = Budget::Episodes(3);
    run(&mut stage, &short, &Streams::new(5), &mut bill).unwrap();
    bill.looks
}

#[test]
fn who_gives_no_answer_is_left_alone_and_asked_again_in_the_next_episode() {
    let rests = RestConfig { after: 2, first: 8, longest: 64 };
    assert_eq!(looks(rests, 1.0), 3 * 2 * 2, "two silent looks at each, then a rest till the end");
    assert_eq!(looks(RestConfig { first: 3, ..rests }, 1.0), 3 * 3 * 2, "and one more after a short rest");
    assert_eq!(looks(RestConfig::NEVER, 1.0), 3 * 10 * 2);
    assert_eq!(looks(rests, 0.0), 3 * 10 * 2, "whoever answers is asked as before");
}
