//! Recordings (MCAP) in the lab: any phase or policy of a finished run, lived again and written down, and recordings as
//! demonstrations.
//!
//! Nothing is recorded while a run is in a hurry. The same seed gives the same bits, so what is recorded afterwards is what
//! happened.

use crate::demonstrations::{Demonstrations, Header, Moment};
use crate::evaluate::{Candidate, Course, drive, ground};
use crate::mind::Mind;
use crate::plan::{Acting, Plan};
use crate::progress::Progress;
use crate::registry::{EnvironmentConfig, roads_name};
use crate::reproduce::{courses, seed_streams, tested_on};
use crate::store::{RunCard, Store, StoreError};
use crate::train::{RunError, Stretch, Watch, classroom, learn_stretch};
use metal_recording::{Beliefs, Recorder, Replay, Tape, TapeError, replay::Recorded};
use metal_rl::environment::{End, Environment, EnvironmentError, EnvironmentSpec};
use metal_rl::observe::{Observer, Step};
use metal_rl::random::Streams;

use std::cell::Cell;
use std::path::PathBuf;
use std::str::FromStr;

/// What is recorded, and where to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wish {
    /// Which piece of the run.
    pub piece: Piece,
    /// Of which training, from 0; [`Piece::Run`] has all of them.
    pub training: usize,
    /// The recording.
    pub file: PathBuf,
}

/// A piece of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// All there is: every phase of every training, and every policy's tests on every course.
    Run,
    /// Every phase of learning of one training, one after the other.
    Learning,
    /// One phase of learning.
    Phase(String),
    /// The tests of one policy, where it learned.
    Policy(String),
}

/// The forms that a wish is typed in.
const FORMS: &str = "FILE.mcap, run=FILE.mcap, phase.NAME=FILE.mcap or policy.NAME=FILE.mcap; of another training than \
                     the first one N.learning=FILE.mcap, N.phase.NAME=FILE.mcap or N.policy.NAME=FILE.mcap";

impl FromStr for Wish {
    type Err = String;

    /// `FILE.mcap`, `run=FILE.mcap`, or `phase.NAME=FILE.mcap`, `policy.NAME=FILE.mcap` and `learning=FILE.mcap`, the last
    /// three perhaps behind the number of a training, as in `2.phase.attention=FILE.mcap`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, file) = text.split_once('=').unwrap_or(("learning", text));
        if !file.ends_with(".mcap") {
            return Err(format!("wanted: {FORMS}"));
        }
        let number = name.split_once('.').and_then(|(n, rest)| Some((n.parse().ok()?, rest)));
        let (training, name) = number.unwrap_or((0, name));
        Ok(Self { piece: piece(name)?, training, file: file.into() })
    }
}

impl Wish {
    /// Refuses what a run of `plan` with so many trainings does not have.
    ///
    /// # Errors
    /// What is unknown, and what there is.
    pub fn check(&self, plan: &Plan, trainings: usize) -> Result<(), String> {
        if self.training >= trainings {
            return Err(format!("training {}: they count from 0, and there are {trainings}", self.training));
        }
        self.piece.check(plan)
    }
}

fn piece(name: &str) -> Result<Piece, String> {
    match name.split_once('.') {
        Some(("phase", name)) => Ok(Piece::Phase(name.to_owned())),
        Some(("policy", name)) => Ok(Piece::Policy(name.to_owned())),
        None if name == "run" => Ok(Piece::Run),
        None if name == "learning" => Ok(Piece::Learning),
        _ => Err(format!("`{name}`: wanted: {FORMS}")),
    }
}

impl Piece {
    /// Refuses a piece that the plan does not have.
    ///
    /// # Errors
    /// What is unknown, and what there is.
    pub fn check(&self, plan: &Plan) -> Result<(), String> {
        let refuse = |kind: &str, name: &str, known: Vec<&String>| {
            let names: Vec<&str> = known.into_iter().map(String::as_str).collect();
            Err(format!("no {kind} is called `{name}`: there are {}", names.join(", ")))
        };
        let file = &plan.file;
        match self {
            Self::Phase(name) if !file.phase.contains_key(name) => {
                refuse("phase", name, file.phase.keys().collect())
            }
            Self::Policy(name) if !file.policy.contains_key(name) => {
                refuse("policy", name, file.policy.keys().collect())
            }
            _ => Ok(()),
        }
    }
}

/// Why something could not be recorded.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// It could not be lived again.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The run folder.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The recording.
    #[error("{}: {reason}", path.display())]
    Tape {
        /// The recording.
        path: PathBuf,
        /// What is wrong.
        reason: TapeError,
    },
}

/// Lives pieces of the finished run in `store` again, at most so many `episodes` of each, and records them.
///
/// # Errors
/// If a world fails, a file cannot be written, or the user interrupts.
pub fn record(
    store: &Store,
    wishes: &[Wish],
    episodes: usize,
    progress: &dyn Progress,
) -> Result<(), RecordError> {
    let (plan, card) = store.read_run()?;
    let run = Run { plan: &plan, card: &card, store, episodes, progress };
    for wish in wishes {
        let at = |reason| RecordError::Tape { path: wish.file.clone(), reason };
        let tape = Tape::create(&wish.file, &plan.spec).map_err(at)?;
        let lived = run.live(wish, &tape);
        // What was recorded until something failed is worth keeping.
        tape.finish().map_err(at)?;
        lived?;
    }
    Ok(())
}

/// A finished run.
struct Run<'a> {
    plan: &'a Plan,
    card: &'a RunCard,
    store: &'a Store,
    episodes: usize,
    progress: &'a dyn Progress,
}

impl Run<'_> {
    fn live(&self, wish: &Wish, tape: &Tape) -> Result<(), RecordError> {
        let training = wish.training;
        match &wish.piece {
            Piece::Run => self.everything(tape),
            Piece::Learning => self.learn_all(training, tape),
            Piece::Phase(name) => self.learn(name, training, tape),
            Piece::Policy(name) => self.test((name, &tested_on(self.plan, self.card.seeds)), training, tape),
        }
    }

    fn everything(&self, tape: &Tape) -> Result<(), RecordError> {
        for training in 0..self.card.seeds {
            tape.floats("/training", &[training as f64]);
            self.learn_all(training, tape)?;
            for course in courses(self.plan, self.card.seeds) {
                for name in self.plan.file.policy.keys() {
                    self.test((name, &course), training, tape)?;
                }
            }
        }
        Ok(())
    }

    fn learn_all(&self, training: usize, tape: &Tape) -> Result<(), RecordError> {
        self.plan.order.iter().try_for_each(|name| self.learn(name, training, tape))
    }

    /// The mind that `phase` left behind in a training, or a newborn one.
    fn mind(&self, phase: Option<&String>, training: usize) -> Result<Mind, RecordError> {
        match phase {
            Some(phase) => Ok(self.store.read_mind(self.plan, training, phase)?),
            None => {
                let streams = seed_streams(self.card.seed, training);
                Ok(Mind::newborn(self.plan, &streams).map_err(RunError::from)?)
            }
        }
    }

    fn learn(&self, name: &str, training: usize, tape: &Tape) -> Result<(), RecordError> {
        let mut mind = self.mind(self.plan.file.phase[name].after.as_ref(), training)?;
        let take = Take { episodes: self.episodes, progress: self.progress };
        let streams = seed_streams(self.card.seed, training);
        tape.text("/phase", name);
        Ok(take.learning((self.plan, name), &mut mind, &streams, tape)?)
    }

    fn test(&self, (name, course): (&str, &Course), training: usize, tape: &Tape) -> Result<(), RecordError> {
        let row = &self.plan.file.policy[name];
        let candidate = Candidate {
            plan: self.plan,
            mind: &self.mind(row.after.as_ref(), training)?,
            acting: &row.acting,
            roster: self.plan.roster(&row.roster),
            blind: self.card.blind,
        };
        let runs = if self.episodes == 0 { course.runs } else { course.runs.min(self.episodes) };
        let (environment, streams) = ground(self.plan, course, &seed_streams(self.card.seed, training))?;
        let mut world = Recorder::new(environment, tape.clone());
        tape.text("/policy", name);
        tape.text("/course", &format!("{} on {}", course.scenario, roads_name(&course.roads)));
        drive(&candidate, &mut world, (runs, &streams), &mut Beliefs(tape.clone()))?;
        if self.progress.interrupted() { Err(RunError::Interrupted.into()) } else { Ok(()) }
    }
}

/// How a phase of learning is recorded.
pub struct Take<'a> {
    /// Episodes at most; 0: all.
    pub episodes: usize,
    /// Asked whether to go on.
    pub progress: &'a dyn Progress,
}

impl Take<'_> {
    /// Records phase `name` of `plan`, learned by `mind` with the streams of its training.
    ///
    /// # Errors
    /// If the world fails.
    pub fn learning(
        &self,
        of: (&Plan, &str),
        mind: &mut Mind,
        streams: &Streams,
        tape: &Tape,
    ) -> Result<(), RunError> {
        let mut world = recorder(of, classroom(of.0, of.1)?, tape);
        let seen = Cell::new(0);
        let enough = || self.episodes > 0 && seen.get() >= self.episodes;
        let mut observer = Clerk { beliefs: Beliefs(tape.clone()), seen: &seen, enough: &enough };
        let watch = Watch {
            environment: &mut world,
            observer: &mut observer,
            ear: &mut |_| {},
            progress: self.progress,
        };
        let pause = &mut || enough() || self.progress.interrupted();
        learn_stretch(of, mind, streams, watch, &mut Stretch::first(pause))?;
        drop(world.into_inner());
        tape.go_on();
        if self.progress.interrupted() { Err(RunError::Interrupted) } else { Ok(()) }
    }
}

/// A recorder around the `world` in which a phase is learned; it reads everything if that is worth it.
pub fn recorder<E: Environment>(of: (&Plan, &str), world: E, tape: &Tape) -> Recorder<E> {
    let start = if shows_itself(of) { Recorder::thorough } else { Recorder::new };
    start(world, tape.clone())
}

/// Whether the world's own expert drives: what it shows is worth being seen by all sensors.
fn shows_itself((plan, name): (&Plan, &str)) -> bool {
    let replayed = matches!(plan.file.environment, EnvironmentConfig::Replay(_));
    plan.file.phase[name].acting == Acting::Advisor && !replayed
}

/// Writes what is believed, and closes the tape when there is enough on it: not every way to learn can be paused.
struct Clerk<'a> {
    beliefs: Beliefs,
    seen: &'a Cell<usize>,
    enough: &'a dyn Fn() -> bool,
}

impl Observer for Clerk<'_> {
    fn on_step(&mut self, step: &Step<'_>) {
        self.beliefs.on_step(step);
    }

    fn on_episode(&mut self, _episode: usize, _progress: f64) {
        self.seen.set(self.seen.get() + 1);
        if (self.enough)() {
            self.beliefs.0.rest();
        }
    }
}

/// Lets the expert of `world` drive: a demonstration, if somebody records it.
///
/// # Errors
/// If the world fails or has no expert.
pub fn show(world: &mut dyn Environment, (episodes, streams): (usize, &Streams)) -> Result<(), RunError> {
    for episode in 0..episodes {
        world.reset(streams.nth(episode as u64).child("world").seed())?;
        loop {
            let Some(action) = world.advise() else { return Err(no_expert(world).into()) };
            if world.step(action)?.end != End::Running {
                break;
            }
        }
    }
    Ok(())
}

fn no_expert(world: &dyn Environment) -> EnvironmentError {
    EnvironmentError::Motor {
        environment: world.spec().id.clone(),
        action: "demonstrate".to_owned(),
        reason: "nobody knows the way here: where a supervisor knows the road, say --road-seed; elsewhere let a mind \
                 show it, with --run"
            .to_owned(),
    }
}

/// The recording in `bytes` as demonstrations for the world of `spec`.
///
/// # Errors
/// If it is no recording, belongs to other sensors or actions, or somebody did not look at everything in it.
pub fn demonstrations(bytes: &[u8], spec: &EnvironmentSpec) -> Result<Demonstrations, String> {
    let replay = Replay::of(bytes).map_err(|e| e.to_string())?;
    let header = Header::new(replay.spec());
    if let Some(reason) = header.mismatch(spec) {
        return Err(reason);
    }
    let accident = replay.spec().measure("accident");
    let mut moments = Vec::new();
    for (episode, steps) in replay.episodes().iter().enumerate() {
        for (step, recorded) in steps.iter().enumerate().filter(|(_, r)| r.moved.is_some()) {
            let moment = moment(recorded, accident);
            let unseen = |i: usize| {
                let sensor = &spec.sensors[i].name;
                format!(
                    "nobody attended to {sensor} in step {step} of episode {episode}: \
                     a demonstration shows every sensor, see `metal drive --demonstrate`"
                )
            };
            moments.push(Moment { episode, step, ..moment.map_err(unseen)? });
        }
        close(&mut moments, steps.last());
    }
    Ok(Demonstrations { header, moments })
}

/// What was seen behind an episode that somebody cut, or else what was seen last.
fn close(moments: &mut Vec<Moment>, last: Option<&Recorded>) {
    let Some(before) = moments.last().filter(|m| m.end != End::Terminal).cloned() else { return };
    let behind = |i: usize| last.filter(|r| r.moved.is_none())?.readings[i].clone();
    let seen = |(i, then): (usize, &Vec<f64>)| behind(i).unwrap_or_else(|| then.clone());
    let readings = before.readings.iter().enumerate().map(seen).collect();
    let (step, end) = (before.step + 1, End::Running);
    moments.push(Moment { step, readings, action: None, motor_reward: 0.0, accident: false, end, ..before });
}

/// A recorded step as a moment of the first episode, or the first sensor that was not read.
fn moment(recorded: &Recorded, accident: Option<usize>) -> Result<Moment, usize> {
    let readings = recorded.readings.iter().enumerate();
    let readings = readings.map(|(i, r)| r.clone().ok_or(i)).collect::<Result<_, _>>()?;
    let hit = accident.and_then(|i| recorded.measures.get(i)).is_some_and(|&a| a > 0.0);
    Ok(Moment {
        episode: 0,
        step: 0,
        readings,
        action: recorded.moved.map(|(action, _)| action),
        advice: None,
        motor_reward: recorded.moved.map_or(0.0, |(_, outcome)| outcome.motor_reward),
        accident: hit,
        end: recorded.moved.map_or(End::Running, |(_, outcome)| outcome.end),
    })
}
