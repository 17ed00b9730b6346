//! Counterfactual policy iteration as a phase of an experiment: near the known optimum of the toy, home in the maze,
//! the same on any number of threads, blind to what it did not attend, and the same after a night in the freezer.
#![allow(clippy::unwrap_used)]

#[path = "common/maze.rs"]
mod common;

use metal_lab::checkpoint::Ledger;
use metal_lab::evaluate::{Candidate, Course, drive, measures, test};
use metal_lab::mind::Mind;
use metal_lab::plan::{self, Plan};
use metal_lab::progress::Silent;
use metal_lab::registry::Roads;
use metal_lab::reproduce::subsets::{Rival, name, screen, screened_count, subset_plan};
use metal_lab::trace::{Trace, Watcher};
use metal_lab::train::{RunError, Trained, Watch, learn_phase, train_seed};
use metal_lab::{experiments, mind::FrozenMind};
use metal_rl::counterfactual::Iterate;
use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome};
use metal_rl::observe::{Observer, Step};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use metal_worlds::toy::optimum;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

const ROSTER: [&str; 7] = ["MN", "MF", "LN", "RN", "LF", "RF", "IR"];

/// The toy of the program, with a controller that learns by counterfactual policy iteration.
fn toy(settings: &str, steps: usize) -> Plan {
    let text = experiments::TOY
        .replace("learner = \"acl\"\nsettings = { motor_target = \"myopic\", price_ramp = 0.0, rate = { constant = 0.05 } }", settings)
        .replace("budget = { episodes = 10000 }", &format!("budget = {{ steps = {steps} }}"));
    plan::parse(&text, &[]).unwrap()
}

/// Mean total and looks of policy `acl`.
fn tested(plan: &Plan, mind: &Mind, runs: usize) -> (f64, f64) {
    let row = &plan.file.policy["acl"];
    let roster = plan.roster(&row.roster);
    let candidate = Candidate { plan, mind, acting: &row.acting, roster, blind: 0 };
    let course = Course { scenario: "mix".into(), roads: Roads::Training, runs };
    let all = measures(&test(&candidate, &course, &Streams::new(77), &Silent).unwrap());
    let of = |name: &str| all.iter().find(|(n, _)| *n == name).unwrap().1;
    (of("total"), of("looks"))
}

fn trained(plan: &Plan, seed: u64) -> Trained {
    train_seed(plan, &Streams::new(seed), &Silent).unwrap().remove("attention").unwrap()
}

#[test]
fn the_toy_is_learned_to_near_its_optimum() {
    let plan = plan::parse(include_str!("../../../experiments/toy_counterfactual.toml"), &[]).unwrap();
    let trained = trained(&plan, 1);
    let (total, looks) = tested(&plan, &trained.mind, 10_000);
    assert!(total >= optimum().value / 0.95, "{total} per decision, at best {}", optimum().value);
    assert!((2.0..3.0).contains(&looks), "{looks} looks per decision");
    let steps = |of: fn(&Iterate) -> usize| trained.diary.iter().map(of).sum::<usize>();
    assert!(steps(|i| i.own_steps) <= 5000, "{} decisions", steps(|i| i.own_steps));
    assert_eq!(steps(|i| i.rolled_steps), 5 * steps(|i| i.own_steps), "each of five moves of every state");
}

const TOY: &str = "[attention.acl.counterfactual]
looks = { adaptive = { max_looks = 4 } }
iterations = 1
judged = 1.0
wide_eyed = 0
price_ramp = 0
validation_runs = 1
fit = { batches = 10000, own_looks = 0.9, weight_decay = 0.2, averaged = 0.5, final_rate = 0.02 }
network = { adam = { learning_rate = 0.005 } }";

#[test]
fn a_mixture_of_gaussians_comes_near_it_too() {
    let own = "network = { adam = { learning_rate = 0.005 } }";
    for (settings, share) in [
        ("draws = 20000, rounds = 3", 0.7),
        ("draws = 10000, rounds = 1, moves = \"marginal\", looks = \"expected\"", 0.5),
    ] {
        let plan = toy(&TOY.replace(own, &format!("{own}\nmixture = {{ {settings} }}")), 5000);
        let (total, looks) = tested(&plan, &trained(&plan, 1).mind, 10_000);
        println!("{settings}: {total} per decision, {looks} looks");
        assert!(total >= optimum().value / share, "{settings}: {total}, at best {}", optimum().value);
        assert!((1.0..3.5).contains(&looks), "{settings}: {looks} looks per decision");
    }
}

/// What `work` comes to with so many threads.
fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

fn frozen(mind: &Mind) -> FrozenMind {
    let roster = ROSTER.map(String::from).to_vec();
    mind.freeze(&BTreeMap::from([("acl".to_owned(), roster)]))
}

/// A world that keeps the minutes of what is read between two motor steps.
struct Minutes(Box<dyn Environment>, Arc<Mutex<IndexSet>>);

impl Environment for Minutes {
    fn spec(&self) -> &EnvironmentSpec {
        self.0.spec()
    }
    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.0.reset(seed)
    }
    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        let mut read = self.1.lock().unwrap();
        assert!(!read.contains(sensor), "sensor {sensor} was read twice in a motor step");
        *read = read.with(sensor);
        self.0.sense(sensor, out)
    }
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        self.0.step(action)
    }
    fn measures(&self) -> &[f64] {
        self.0.measures()
    }
    fn fork(&self) -> Option<Box<dyn Environment>> {
        panic!("nobody copies the world to act in it")
    }
}

/// Compares what was read with what was attended and paid, step by step.
struct Auditor {
    read: Arc<Mutex<IndexSet>>,
    prices: Vec<f64>,
    unread: usize,
}

impl Observer for Auditor {
    fn on_step(&mut self, step: &Step<'_>) {
        let read = std::mem::take(&mut *self.read.lock().unwrap());
        assert_eq!(read, step.state.attended(), "member i of the toy sees sensor i alone");
        let price: f64 = read.iter().map(|s| self.prices[s]).sum();
        assert!((step.look_price - price).abs() < 1e-12, "every look is paid");
        self.unread += self.prices.len() - read.len();
    }
}

#[test]
fn what_a_student_does_not_attend_is_never_read() {
    let plan = toy(SHORT, 600);
    let mind = trained(&plan, 4).mind;
    let row = &plan.file.policy["acl"];
    let roster = plan.roster(&row.roster);
    let candidate = Candidate { plan: &plan, mind: &mind, acting: &row.acting, roster, blind: 0 };
    let read = Arc::<Mutex<IndexSet>>::default();
    let mut world = Minutes(plan.file.environment.build().unwrap(), read.clone());
    let prices = plan.spec.sensors.iter().map(|s| s.price).collect();
    let mut auditor = Auditor { read, prices, unread: 0 };
    drive(&candidate, &mut world, (300, &Streams::new(9)), &mut auditor).unwrap();
    assert!(auditor.unread > 300, "it attends so much that this test shows nothing");
}

const SHORT: &str = "[attention.acl.counterfactual]
iterations = 3
validation_runs = 20
memory = { looks = 1, steps = 3, actions = 1 }
network = { ensemble = 2, caution = 0.5 }
fit = { batches = 60, averaged = 0.3 }";

#[test]
fn threads_change_nothing_and_a_frozen_student_goes_on() {
    let plan = toy(SHORT, 600);
    let on = |threads: usize| on_threads(threads, || frozen(&trained(&plan, 5).mind));
    let one = on(1);
    assert_eq!(one, on(4));
    let thawed = Mind::thaw(&plan, &one).unwrap();
    assert_eq!(frozen(&thawed), one);
    assert!(thawed.has_attention("acl"));
    let mixture = toy(&format!("{SHORT}\nmixture = {{ components = 9, draws = 500, rounds = 2 }}"), 600);
    let on = |threads: usize| on_threads(threads, || frozen(&trained(&mixture, 5).mind));
    let one_mixture = on(1);
    assert!(one_mixture == on(4) && one_mixture != one, "the same mixture on any number of threads");
    assert_eq!(frozen(&Mind::thaw(&mixture, &one_mixture).unwrap()), one_mixture);
    let other = toy(&SHORT.replace("steps = 3", "steps = 4"), 600);
    assert!(Mind::thaw(&other, &one).is_err(), "settings are part of a student");
}

const RECIPE: &str = "iterations = 6
price_ramp = 3
horizon = 12
gamma = 0.97
validation_runs = 60
fit = { batches = 400, final_rate = 0.05 }
network = { hidden = [32, 32], adam = { learning_rate = 0.005 } }";

/// A world of which nobody has a second one.
struct Unique(Box<dyn Environment>);

impl Environment for Unique {
    fn spec(&self) -> &EnvironmentSpec {
        self.0.spec()
    }
    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.0.reset(seed)
    }
    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.0.sense(sensor, out)
    }
    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        self.0.step(action)
    }
    fn measures(&self) -> &[f64] {
        self.0.measures()
    }
}

/// The maze learned where nothing can be copied: the mind, its diary, or why not.
fn learned_without_copies(plan: &Plan) -> Result<(Mind, Vec<Iterate>), RunError> {
    let streams = Streams::new(1);
    let mut mind = Mind::newborn(plan, &streams).unwrap();
    let mut world = Unique(plan.file.environment.build().unwrap());
    let observer = &mut Watcher { trace: Trace::new(&plan.spec), progress: &Silent };
    let watch = Watch { environment: &mut world, observer, ear: &mut |_| {}, progress: &Silent };
    let diary = learn_phase(plan, "attention", &mut mind, &streams, watch)?;
    Ok((mind, diary))
}

#[test]
fn a_critic_finds_the_shortest_way_where_nothing_can_be_copied() {
    let without = plan::parse(&common::maze(RECIPE, 3000), &[]).unwrap();
    let refused = learned_without_copies(&without).err().unwrap().to_string();
    assert!(refused.contains("cannot be copied") && refused.contains("`judge`"), "{refused}");
    // What is far away counts less: policies are evaluated one step at a time, not twelve.
    let judge = "judge = { critic = { batches = 800 } }\niterations = 10\nwide_eyed = 3\nfirst_drives = 0\n";
    let text = common::maze(RECIPE, 3000)
        .replace("iterations = 6\n", judge)
        .replace("gamma = 0.97", "gamma = 0.9")
        .replace("batches = 400, ", "batches = 1000, unit = \"mean_absolute\", ")
        .replace("steps = 3000", "steps = 6000");
    let plan = plan::parse(&text, &[]).unwrap();
    let (mind, diary) = learned_without_copies(&plan).unwrap();
    let (total, looks) = tested(&plan, &mind, 200);
    assert!(total >= -1.25, "{total} per step with {looks} looks");
    assert!(diary.iter().all(|i| i.rolled_steps == 0));
    let short = text.replace("batches = 800", "batches = 30").replace("batches = 1000", "batches = 30");
    let short = plan::parse(&short.replace("steps = 6000", "steps = 600"), &[]).unwrap();
    let roster = BTreeMap::from([("acl".to_owned(), vec!["X".to_owned(), "Y".to_owned()])]);
    let student = || learned_without_copies(&short).unwrap().0.freeze(&roster);
    assert_eq!(student(), student(), "the same seed, the same student");
}

#[test]
fn the_maze_is_left_by_the_shortest_way_with_both_looks() {
    let plan = plan::parse(&common::maze(RECIPE, 3000), &[]).unwrap();
    let trained = trained(&plan, 1);
    let (total, looks) = tested(&plan, &trained.mind, 200);
    // One look at a coordinate tells whether to go on along it: −1 per step and 0.1 to 0.2 for looks.
    assert!(total >= -1.25, "{total} per step with {looks} looks");
    assert!(trained.diary.iter().any(|i| i.price_share == 1.0));
}

#[test]
fn what_costs_nothing_is_always_known() {
    let text = common::maze(RECIPE, 3000)
        .replace("[environment.maze]", "[environment.maze]\nlook_price = 0.0")
        .replace("max_looks = 2", "max_looks = 1")
        + "\n[attention.acl.counterfactual.memory]\nlooks = 1\nsteps = 4\nactions = 1\n";
    let text = text.replace("steps = 3000", "steps = 900").replace("batches = 400", "batches = 60");
    let plan = plan::parse(&text, &[]).unwrap();
    let trained = trained(&plan, 1);
    let (_, looks) = tested(&plan, &trained.mind, 50);
    assert_eq!(looks, 2.0, "both, although one look may be chosen");
    // Also where chance takes looks away while it learns.
    assert!(trained.diary.iter().all(|i| i.looks == 2.0));
}

#[test]
fn appointed_looks_are_all_that_is_read_and_threads_change_nothing() {
    let text = common::maze(RECIPE, 3000)
        .replace("steps = 3000", "steps = 900")
        .replace("batches = 400", "batches = 60")
        .replace("{ adaptive = { max_looks = 2 } }", "{ appointed = { max_looks = 2, ahead = 3 } }")
        .replace(
            "horizon = 12",
            "horizon = 12\nmemory = { recurrent = 16 }\nrecollection = { batches = 10 }",
        );
    let plan = plan::parse(&text, &[]).unwrap();
    let roster = BTreeMap::from([("acl".to_owned(), vec!["X".to_owned(), "Y".to_owned()])]);
    let on = |threads: usize| on_threads(threads, || trained(&plan, 5).mind.freeze(&roster));
    let one = on(1);
    assert_eq!(one, on(4));
    let mind = Mind::thaw(&plan, &one).unwrap();
    assert_eq!(mind.freeze(&roster), one);
    let row = &plan.file.policy["acl"];
    let everybody = plan.roster(&row.roster);
    let candidate = Candidate { plan: &plan, mind: &mind, acting: &row.acting, roster: everybody, blind: 0 };
    let read = Arc::<Mutex<IndexSet>>::default();
    let mut world = Minutes(plan.file.environment.build().unwrap(), read.clone());
    let prices = plan.spec.sensors.iter().map(|s| s.price).collect();
    let mut auditor = Auditor { read, prices, unread: 0 };
    drive(&candidate, &mut world, (40, &Streams::new(9)), &mut auditor).unwrap();
    assert!(auditor.unread > 40, "it attends so much that this test shows nothing");
}

#[test]
fn fixed_subsets_learn_by_the_same_recipe_and_keep_to_their_looks() {
    let subsets = "\n[subsets]\nlike = \"attention\"\nbudget_of = [\"attention\"]\nevery = [1, 2]\n\
                   screening_share = 0.5\nscreening_seeds = 1\nscreening_runs = 5\nconfirmed = 1\n";
    let text = toml::to_string(&toy(SHORT, 600).file).unwrap() + subsets;
    let plan = plan::parse(&text, &[]).unwrap();
    let rows = plan.file.subsets.as_ref().unwrap();
    let rival = Rival { sensors: IndexSet::EMPTY.with(1).with(6), every: 2 };
    assert_eq!(name(&plan, rival), "fixed:MF+IR/2");
    assert_eq!(Rival::parse(&plan, "here", "IR+MF/2"), Ok(rival));
    let derived = subset_plan(&plan, rows, rival, 0.5).unwrap();
    assert_eq!(derived.budget_steps("subset"), 300);
    let (_, config) = derived.counterfactual("subset").unwrap();
    assert_eq!((config.fit.batches, config.judged), (30, 1.0), "as many roll-outs as with free looks");
    let subset =
        metal_lab::reproduce::subsets::train_subset(&plan, rows, (rival, 0.5), &Streams::new(2), &Silent)
            .unwrap();
    let course = Course { scenario: "mix".into(), roads: Roads::Training, runs: 50 };
    let runs = test(&subset.candidate(), &course, &Streams::new(3), &Silent).unwrap();
    assert!(
        runs.iter().all(|r| r.looks == [2]),
        "every episode of the toy is one step, at which looks are due"
    );
}

#[test]
fn rivals_that_are_named_are_the_only_ones_screened() {
    let subsets = "\n[subsets]\nlike = \"attention\"\nbudget_of = [\"attention\"]\namong = [\"MF/2\", \"MN+IR\"]\n\
                   screening_share = 0.1\nscreening_seeds = 1\nscreening_runs = 5\nconfirmed = 1\n";
    let plan = plan::parse(&(toml::to_string(&toy(SHORT, 600).file).unwrap() + subsets), &[]).unwrap();
    let rows = plan.file.subsets.as_ref().unwrap();
    let screened = screen(&plan, rows, false, &Streams::new(2), &Ledger::none(&Silent)).unwrap();
    let words: Vec<String> = screened.iter().map(|s| s.rival.words(&plan)).collect();
    assert_eq!(words, ["MF/2", "MN+IR"]);
    assert_eq!(screened_count(7, false, rows), 2);
}

#[test]
fn what_cannot_be_is_refused_where_it_stands() {
    let refused = |from: &str, to: &str| {
        let text = toml::to_string(&toy(SHORT, 600).file).unwrap();
        assert!(text.contains(from), "{from} in {text}");
        plan::parse(&text.replacen(from, to, 1), &[]).unwrap_err().to_string()
    };
    let gamma = refused("gamma = 0.93", "gamma = 1.5");
    assert!(gamma.contains("attention.acl.counterfactual.gamma") && gamma.contains("[0, 1)"), "{gamma}");
    let teaching = refused("teaching = \"nobody\"", "teaching = \"attended\"");
    assert!(teaching.contains("phase.attention.teaching") && teaching.contains("nobody"), "{teaching}");
    let units = refused("recurrent = 0", "recurrent = 20");
    assert!(units.contains("memory.recurrent") && units.contains("multiple of 16"), "{units}");
    let both = refused(
        "[attention.acl.counterfactual]",
        "[attention.acl]\nlearner = \"acl\"\n[attention.acl.counterfactual]",
    );
    assert!(both.contains("attention.acl.learner") && both.contains("leave `learner` out"), "{both}");
    let stranger = refused(
        "[attention.acl.counterfactual.looks.adaptive]\nmin_looks = 0\nmax_looks = 4",
        "[attention.acl.counterfactual.looks]\nfixed = [\"XX\"]",
    );
    assert!(stranger.contains("counterfactual.looks") && stranger.contains("`XX`"), "{stranger}");
}

#[test]
fn the_shipped_experiment_is_sound() {
    let plan = plan::parse(experiments::ATTENTION, &[]).unwrap();
    assert!(plan.counterfactual("attention").is_some());
    assert!(plan.counterfactual("attention_phase3").is_none());
}
