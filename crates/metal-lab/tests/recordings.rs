//! Recordings in experiments: a run that is recorded is the run, and a mind learns from a recording what it learned live.
#![allow(clippy::unwrap_used)]

use metal_lab::ceiling::CeilingOptions;
use metal_lab::finish;
use metal_lab::mind::Mind;
use metal_lab::plan::{Plan, parse};
use metal_lab::progress::Silent;
use metal_lab::recorded::{Piece, Take, Wish, demonstrations, show};
use metal_lab::reproduce::{Options, courses, execute};
use metal_lab::store::Store;
use metal_lab::train::{Trained, train_seed};
use metal_recording::{Recorder, Replay, Tape};
use metal_rl::random::Streams;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const MINDS: &str = r#"
[learner.tiny.mlp]
[member.MN]
sensors = ["MN"]
learner = "tiny"
[member.IR]
sensors = ["IR"]
learner = "tiny"
[phase.demonstration]
roster = ["MN", "IR"]
acting = "advisor"
sensing = "everyone"
rate = "full"
budget = { steps = 25 }
[phase.fusion]
after = "demonstration"
roster = ["MN", "IR"]
acting = { fusion = "max_confidence" }
rate = "full"
budget = { episodes = 4 }
[policy.oracle]
acting = "advisor"
[policy.near]
after = "demonstration"
roster = ["MN"]
acting = { solo = "MN" }
[evaluation]
runs = 1
"#;

fn plan(environment: &str) -> Plan {
    parse(&format!("title = \"Recorded\"\n{environment}\n{MINDS}"), &[]).unwrap()
}

fn live() -> Plan {
    plan("[environment.highway_scripted]\nhorizon = 10")
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn streams() -> Streams {
    Streams::new(5)
}

fn learned(plan: &Plan) -> BTreeMap<String, Trained> {
    train_seed(plan, &streams(), &Silent).unwrap()
}

/// Records a phase that starts from `mind`.
fn record(name: &str, mut mind: Mind, episodes: usize) -> (PathBuf, Mind) {
    let path = file(&format!("{name}-{episodes}.mcap"));
    let tape = Tape::create(&path, &live().spec).unwrap();
    let take = Take { episodes, progress: &Silent };
    take.learning((&live(), name), &mut mind, &streams(), &tape).unwrap();
    tape.finish().unwrap();
    (path, mind)
}

fn newborn() -> Mind {
    Mind::newborn(&live(), &streams()).unwrap()
}

#[test]
fn what_is_recorded_afterwards_is_what_happened() {
    let run = learned(&live());
    let (path, mind) = record("fusion", run["demonstration"].mind.clone(), 0);
    assert!(mind.freeze_for(&live()) == run["fusion"].mind.freeze_for(&live()), "recording changes nothing");
    let replay = Replay::open(&path).unwrap();
    let paid = |steps: &[metal_recording::replay::Recorded]| -> f64 {
        steps.iter().filter_map(|s| s.moved).map(|(_, outcome)| outcome.motor_reward).sum()
    };
    let recorded: Vec<f64> = replay.episodes().iter().map(|steps| paid(steps)).collect();
    let happened: Vec<f64> = run["fusion"].trace.episodes.iter().map(|e| e.motor).collect();
    assert_eq!(recorded, happened);
    let (path, _) = record("fusion", run["demonstration"].mind.clone(), 2);
    assert_eq!(Replay::open(&path).unwrap().episodes().len(), 2, "no more than was wished for");
}

#[test]
fn a_recording_has_pictures_attention_command_supports_and_costs_of_every_step_at_its_time() {
    let (path, _) = record("fusion", learned(&live())["demonstration"].mind.clone(), 3);
    let bytes = std::fs::read(path).unwrap();
    let mut times: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    for (topic, time_ns) in metal_recording::tape::index(&bytes).unwrap() {
        times.entry(topic).or_default().push(time_ns);
    }
    let steps = &times["/step"];
    assert_eq!(steps.len(), 30);
    for topic in ["/image_raw", "/attention", "/measures", "/supports/0", "/supports/1", "/costs"] {
        assert_eq!(&times[topic], steps, "{topic}");
    }
    assert!(steps.windows(2).all(|pair| pair[0] < pair[1]));
    // Behind the time limit the learners look once more.
    assert_eq!(times["/sensor/MN"].len(), 33);
    assert!(!times.contains_key("/sensor/LF"), "nobody saw it");
}

#[test]
fn from_a_recording_is_learned_what_was_learned_live_to_the_bit() {
    let (path, mind) = record("demonstration", newborn(), 0);
    let mind = mind.freeze_for(&live());
    let text = format!("[environment.replay]\nfile = {:?}", path.to_str().unwrap());
    let replayed = plan(&text);
    assert_eq!(replayed.spec, live().spec);
    let run = train_seed(&replayed, &streams(), &Silent).unwrap();
    assert!(run["demonstration"].mind.freeze_for(&replayed) == mind, "as an environment");
    let mut watching = live().file;
    watching.watch_demonstrations(&path);
    let run = learned(&Plan::check(watching).unwrap());
    assert!(run["demonstration"].mind.freeze_for(&live()) == mind, "as demonstrations");
}

#[test]
fn a_whole_run_of_several_trainings_is_recorded_as_it_happened() {
    let folder = file("whole-run");
    let _ = std::fs::remove_dir_all(&folder);
    let store = Store::create(&folder).unwrap();
    let options = Options { seeds: 2, seed: 3, quick: false, all_subsets: false };
    let outcome = execute(live(), options, &Silent).unwrap();
    finish::write(&outcome, &store, "test").unwrap();
    let path = folder.join("run.mcap");
    let wish: Wish = format!("run={}", path.display()).parse().unwrap();
    metal_lab::recorded::record(&store, &[wish], 0, &Silent).unwrap();
    let replay = Replay::open(&path).unwrap();
    let paid = |steps: &[metal_recording::replay::Recorded]| -> f64 {
        steps.iter().filter_map(|s| s.moved).map(|(_, outcome)| outcome.motor_reward).sum()
    };
    let recorded: Vec<f64> = replay.episodes().iter().map(|steps| paid(steps)).collect();
    let mut happened: Vec<f64> = Vec::new();
    for training in 0..2 {
        for phase in ["demonstration", "fusion"] {
            happened.extend(outcome.trained[training][phase].trace.episodes.iter().map(|e| e.motor));
        }
        for course in courses(&live(), 2) {
            for policy in live().file.policy.keys() {
                let roads = &outcome.tables[&metal_lab::registry::roads_name(&course.roads)];
                happened.extend(roads[policy][&course.scenario][training].iter().map(|e| e.motor));
            }
        }
    }
    assert!(happened.len() > 20, "{}", happened.len());
    assert_eq!(recorded, happened, "both trainings, both phases, both policies on every course");
}

#[test]
fn a_whole_experiment_runs_on_a_recording() {
    let (path, _) = record("demonstration", newborn(), 0);
    let plan = plan(&format!("[environment.replay]\nfile = {:?}", path.to_str().unwrap()));
    let ceiling =
        metal_lab::ceiling::run(&plan, &CeilingOptions::default(), &Silent).unwrap_err().to_string();
    assert!(ceiling.starts_with("environment: ") && ceiling.contains("is a recording"), "{ceiling}");
    let options = Options { seeds: 1, seed: 1, quick: false, all_subsets: false };
    let outcome = execute(plan, options, &Silent).unwrap();
    let tables = &outcome.tables["training"];
    let motor = |name: &str| tables[name]["mix"][0][0].motor;
    assert_eq!(motor("near"), motor("oracle"), "a recording goes its own way");
}

#[test]
fn what_is_no_recording_or_shows_too_little_is_refused_by_name() {
    let missing = parse(&format!("title = \"x\"\n[environment.replay]\nfile = \"none.mcap\"\n{MINDS}"), &[]);
    let said = missing.unwrap_err().to_string();
    assert!(said.contains("environment.replay.file") && said.contains("none.mcap"), "{said}");
    let (path, _) = record("fusion", learned(&live())["demonstration"].mind.clone(), 1);
    let bytes = std::fs::read(path).unwrap();
    let said = demonstrations(&bytes, &live().spec).unwrap_err();
    assert!(said.contains("nobody attended to LN in step 0 of episode 0"), "{said}");
    let toy = metal_lab::registry::EnvironmentConfig::Toy(Default::default()).build().unwrap();
    assert!(demonstrations(&bytes, toy.spec()).unwrap_err().contains("actions"));
    let nobody = show(toy_without_expert().as_mut(), (1, &streams()));
    assert!(nobody.unwrap_err().to_string().contains("nobody knows the way here"));
}

/// A recording of a world hides nothing, but a wrapped world may have no expert.
fn toy_without_expert() -> Box<dyn metal_rl::environment::Environment> {
    use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Outcome};
    struct Mute(Box<dyn Environment>);
    impl Environment for Mute {
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
    Box::new(Mute(live().file.environment.build().unwrap()))
}

#[test]
fn an_expert_shows_how_it_is_done() {
    let path = file("shown.mcap");
    let tape = Tape::create(&path, &live().spec).unwrap();
    let mut world = Recorder::thorough(live().file.environment.build().unwrap(), tape.clone());
    show(&mut world, (3, &streams())).unwrap();
    drop(world.into_inner());
    tape.finish().unwrap();
    let set = demonstrations(&std::fs::read(path).unwrap(), &live().spec).unwrap();
    assert_eq!(set.quality().steps, 30);
    // Each episode is cut by the clock, and closed by what was seen behind it.
    assert_eq!(set.moments.iter().filter(|m| m.action.is_none()).count(), 3);
}

#[test]
fn wishes_are_typed_in_three_forms() {
    let of = |text: &str| text.parse::<Wish>();
    assert_eq!(of("a.mcap").unwrap().piece, Piece::Learning);
    let wish = of("policy.acl=runs/a.mcap").unwrap();
    assert_eq!((wish.piece, wish.file), (Piece::Policy("acl".to_owned()), "runs/a.mcap".into()));
    assert!(of("phase.fusion=a.bag").unwrap_err().contains("phase.NAME=FILE.mcap"));
    assert!(of("fusion=a.mcap").unwrap_err().contains("phase.NAME"));
    let wish = of("2.phase.fusion=a.mcap").unwrap();
    assert_eq!((wish.training, &wish.piece), (2, &Piece::Phase("fusion".to_owned())));
    assert!(wish.check(&live(), 3).is_ok());
    assert!(wish.check(&live(), 2).unwrap_err().contains("training 2"));
    assert_eq!(of("run=a.mcap").unwrap().piece, Piece::Run);
    assert_eq!(of("1.learning=a.mcap").unwrap().piece, Piece::Learning);
    let said = of("phase.fusoin=a.mcap").unwrap().piece.check(&live()).unwrap_err();
    assert!(said.contains("`fusoin`") && said.contains("demonstration, fusion"), "{said}");
}
