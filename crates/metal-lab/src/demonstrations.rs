//! Demonstrations on disk: what a person showed at the wheel (Phase I), as lines of JSON that any language reads.
//!
//! The first line is the [`Header`]: whose sensors and actions these are. Every further line is a [`Moment`]: what all
//! sensors said, what the person then did, and what came of it. A moment without an action closes an episode that a
//! clock or the person cut: it shows where the last action led, so that learners can see past the cut.
//!
//! A recording (MCAP) in which every sensor was read before every step is such a set, too, whoever was at the wheel:
//! `metal drive --demonstrate` makes one on a robot.
//!
//! To learn, the set becomes a world of its own, [`Recording`]: it shows the readings again and advises the recorded
//! action, so Phase I runs through the one loop as ever.

use metal_rl::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome, SensorSpec};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the format; a reader refuses any other.
pub const VERSION: u32 = 1;

/// The first line of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// Version of the format.
    pub metal_demonstrations: u32,
    /// Registry name of the world, e.g. `Highway-v0`.
    pub environment: String,
    /// Sensors in the order of every moment's readings.
    pub sensors: Vec<SensorSpec>,
    /// Names of the motor actions.
    pub actions: Vec<String>,
    /// Program and version that wrote the set.
    pub made_with: String,
}

impl Header {
    /// The header of demonstrations in the world of `spec`.
    #[must_use]
    pub fn new(spec: &EnvironmentSpec) -> Self {
        Self {
            metal_demonstrations: VERSION,
            environment: spec.id.clone(),
            sensors: spec.sensors.clone(),
            actions: spec.actions.clone(),
            made_with: concat!("metal ", env!("CARGO_PKG_VERSION")).to_owned(),
        }
    }

    /// Why demonstrations with this header cannot teach in the world of `spec`.
    pub(crate) fn mismatch(&self, spec: &EnvironmentSpec) -> Option<String> {
        let names = |sensors: &[SensorSpec]| -> Vec<(String, usize)> {
            sensors.iter().map(|s| (s.name.clone(), s.features.len())).collect()
        };
        if self.metal_demonstrations != VERSION {
            return Some(format!("version {}, this program reads {VERSION}", self.metal_demonstrations));
        }
        if self.actions != spec.actions {
            return Some(format!("actions {:?}, {} has {:?}", self.actions, spec.id, spec.actions));
        }
        let (found, wanted) = (names(&self.sensors), names(&spec.sensors));
        (found != wanted).then(|| format!("sensors {found:?}, {} has {wanted:?}", spec.id))
    }
}

/// One moment of a demonstration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Moment {
    /// Episode, from 0.
    pub episode: usize,
    /// Motor step within the episode, from 0.
    pub step: usize,
    /// What each sensor said before the action, in its own unit.
    pub readings: Vec<Vec<f64>>,
    /// What the person did; none closes a cut episode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub action: Option<usize>,
    /// What the world's own expert would have done, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advice: Option<usize>,
    /// Reward of the action (a cost is negative).
    #[serde(default)]
    pub motor_reward: f64,
    /// Whether something was hit.
    #[serde(default)]
    pub accident: bool,
    /// Whether the episode is over after the action.
    #[serde(default = "running")]
    pub end: End,
}

fn running() -> End {
    End::Running
}

/// A set of demonstrations.
#[derive(Clone, Debug, PartialEq)]
pub struct Demonstrations {
    /// Whose sensors and actions these are.
    pub header: Header,
    /// All moments, in order.
    pub moments: Vec<Moment>,
}

/// How good a set is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quality {
    /// Motor steps shown.
    pub steps: usize,
    /// Steps in which something was hit.
    pub accidents: usize,
    /// Share of steps with advice in which the person did something else, in [0, 1].
    pub disagreement: f64,
    /// Mean motor reward per step.
    pub motor: f64,
}

/// Why a set cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("demonstrations {}{}: {reason}", path.display(), line.map(|l| format!(", line {l}")).unwrap_or_default())]
pub struct DemonstrationError {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1, if one is to blame.
    pub line: Option<usize>,
    /// What is wrong.
    pub reason: String,
}

impl Demonstrations {
    /// How good the set is.
    #[must_use]
    pub fn quality(&self) -> Quality {
        let acted = || self.moments.iter().filter(|m| m.action.is_some());
        let steps = acted().count();
        let advised = acted().filter(|m| m.advice.is_some()).count();
        let other = acted().filter(|m| m.advice.is_some() && m.advice != m.action).count();
        Quality {
            steps,
            accidents: acted().filter(|m| m.accident).count(),
            disagreement: other as f64 / advised.max(1) as f64,
            motor: acted().map(|m| m.motor_reward).sum::<f64>() / steps.max(1) as f64,
        }
    }

    /// The set as it is written to disk.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn to_lines(&self) -> Result<String, serde_json::Error> {
        let mut text = serde_json::to_string(&self.header)? + "\n";
        for moment in &self.moments {
            text += &serde_json::to_string(moment)?;
            text.push('\n');
        }
        Ok(text)
    }

    /// Reads a set and checks that it can teach in the world of `spec`.
    ///
    /// # Errors
    /// If the file cannot be read, a line is not what it should be, or the set belongs to another world.
    pub fn read(path: &Path, spec: &EnvironmentSpec) -> Result<Self, DemonstrationError> {
        let unreadable =
            |e: std::io::Error| DemonstrationError { path: path.into(), line: None, reason: e.to_string() };
        let bytes = std::fs::read(path).map_err(unreadable)?;
        let blame = |reason| DemonstrationError { path: path.into(), line: None, reason };
        if bytes.starts_with(metal_recording::MAGIC) {
            return crate::recorded::demonstrations(&bytes, spec).map_err(blame);
        }
        let Ok(text) = String::from_utf8(bytes) else {
            return Err(blame("stream did not contain valid UTF-8".to_owned()));
        };
        Self::parse(&text, path, spec)
    }

    /// As [`Self::read`], from the text of the file; `path` is only named in what is said about it.
    ///
    /// # Errors
    /// If a line is not what it should be, or the set belongs to another world.
    pub fn parse(text: &str, path: &Path, spec: &EnvironmentSpec) -> Result<Self, DemonstrationError> {
        let blame = |line: Option<usize>, reason: String| DemonstrationError {
            path: path.to_path_buf(),
            line,
            reason,
        };
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let (_, first) = lines.next().ok_or_else(|| blame(None, "empty".to_owned()))?;
        let header: Header = serde_json::from_str(first).map_err(|e| blame(Some(1), e.to_string()))?;
        if let Some(reason) = header.mismatch(spec) {
            return Err(blame(Some(1), reason));
        }
        let mut moments = Vec::new();
        for (at, line) in lines {
            let moment = serde_json::from_str(line).map_err(|e| e.to_string());
            let checked = moment.and_then(|m: Moment| m.check(spec).map(|()| m));
            moments.push(checked.map_err(|reason| blame(Some(at + 1), reason))?);
        }
        if !moments.iter().any(|m| m.action.is_some()) {
            return Err(blame(None, "not one action in it".to_owned()));
        }
        Ok(Self { header, moments })
    }
}

impl Moment {
    fn check(&self, spec: &EnvironmentSpec) -> Result<(), String> {
        let shape = |s: &SensorSpec| s.features.len();
        let wanted: Vec<usize> = spec.sensors.iter().map(shape).collect();
        let found: Vec<usize> = self.readings.iter().map(Vec::len).collect();
        if found != wanted {
            return Err(format!("readings have the lengths {found:?}, not {wanted:?}"));
        }
        let actions = spec.actions.len();
        match [self.action, self.advice].into_iter().flatten().find(|&a| a >= actions) {
            Some(strange) => Err(format!("action {strange}: there are {actions}, counted from 0")),
            None => Ok(()),
        }
    }
}

/// Demonstrations as a world: it shows what was seen, advises what was done, and rewards as it was rewarded. Whatever
/// else a mind would like to do, the recording goes its own way; episodes come in their order, then again.
#[derive(Clone, Debug)]
pub struct Recording {
    spec: EnvironmentSpec,
    moments: Vec<Moment>,
    at: usize,
    begun: bool,
    measures: Vec<f64>,
}

impl Recording {
    /// The recording of `set` under the contract `spec` of its world.
    #[must_use]
    pub fn new(set: Demonstrations, spec: &EnvironmentSpec) -> Self {
        let measures = vec![0.0; spec.measures.len()];
        Self { spec: spec.clone(), moments: set.moments, at: 0, begun: false, measures }
    }

    fn here(&self) -> &Moment {
        &self.moments[self.at % self.moments.len()]
    }

    /// To the first moment of an episode that has an action; a set always has one.
    fn find_episode(&mut self) {
        let n = self.moments.len();
        let starts = |i: usize| {
            let (before, now) = (&self.moments[(i + n - 1) % n], &self.moments[i % n]);
            let new = i.is_multiple_of(n) || before.episode != now.episode || before.end != End::Running;
            new && now.action.is_some()
        };
        let from = if self.begun { self.at } else { 0 };
        self.at = (from..from + n).find(|&i| starts(i)).unwrap_or(0) % n;
        self.begun = true;
    }
}

impl Environment for Recording {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    fn reset(&mut self, _seed: u64) -> Result<(), EnvironmentError> {
        self.find_episode();
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        out.copy_from_slice(&self.here().readings[sensor]);
        Ok(())
    }

    fn step(&mut self, _action: usize) -> Result<Outcome, EnvironmentError> {
        let now = self.here();
        let (motor_reward, accident, mut end) = (now.motor_reward, now.accident, now.end);
        let episode = now.episode;
        self.at += 1;
        // Behind the last line there is nothing to see any more.
        let over = self.at == self.moments.len() || self.here().episode != episode;
        if end == End::Running && (over || self.here().action.is_none()) {
            end = End::TimeLimit;
        }
        if let Some(i) = self.spec.measure("accident") {
            self.measures[i] = f64::from(u8::from(accident));
        }
        Ok(Outcome { motor_reward, end })
    }

    fn measures(&self) -> &[f64] {
        &self.measures
    }

    fn advise(&mut self) -> Option<usize> {
        // At a closing moment nothing was done; what is asked there is not carried out.
        Some(self.here().action.unwrap_or(0))
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_rl::environment::Feature;

    fn spec() -> EnvironmentSpec {
        let feature = Feature { name: "x".into(), low: 0.0, high: 1.0 };
        EnvironmentSpec {
            id: "Line-v0".into(),
            sensors: vec![SensorSpec { name: "X".into(), features: vec![feature], price: 1.0 }],
            actions: vec!["Left".into(), "Right".into()],
            horizon: 3,
            measures: vec!["accident".into()],
        }
    }

    fn moment(episode: usize, step: usize, action: Option<usize>) -> Moment {
        let x = (10 * episode + step) as f64 / 100.0;
        let readings = vec![vec![x]];
        let (advice, end) = (action.map(|_| 1), End::Running);
        Moment { episode, step, readings, action, advice, motor_reward: -x, accident: step == 1, end }
    }

    fn set() -> Demonstrations {
        let mut last = moment(1, 1, Some(1));
        last.end = End::Terminal;
        let moments = vec![
            moment(0, 0, Some(0)),
            moment(0, 1, Some(1)),
            moment(0, 2, None),
            moment(1, 0, Some(1)),
            last,
        ];
        Demonstrations { header: Header::new(&spec()), moments }
    }

    fn read(text: &str) -> Result<Demonstrations, DemonstrationError> {
        let path = std::env::temp_dir().join(format!("metal-demo-{}-{}", std::process::id(), text.len()));
        std::fs::write(&path, text).unwrap();
        let set = Demonstrations::read(&path, &spec());
        std::fs::remove_file(&path).unwrap();
        set
    }

    #[test]
    fn what_is_written_is_read_again() {
        let text = set().to_lines().unwrap();
        assert_eq!(text.lines().count(), 6);
        assert_eq!(read(&text).unwrap(), set());
    }

    #[test]
    fn damage_is_named_with_its_line() {
        let text = set().to_lines().unwrap();
        let strange = text.replace("\"action\":0", "\"action\":7");
        let error = read(&strange).unwrap_err();
        assert!(error.line == Some(2) && error.reason.contains("action 7"), "{error}");
        assert!(read(&text.replace("Right", "Reverse")).unwrap_err().reason.contains("Reverse"));
        assert!(read(&text.replace("[0.01]", "[0.01,0.5]")).unwrap_err().reason.contains("[2]"));
        assert!(read(&text.replace("\"metal_demonstrations\":1", "\"metal_demonstrations\":2")).is_err());
    }

    #[test]
    fn quality_counts_accidents_and_other_opinions() {
        let quality = set().quality();
        assert_eq!((quality.steps, quality.accidents), (4, 2));
        assert!((quality.disagreement - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_recording_shows_its_episodes_in_order_and_again() {
        let mut world = Recording::new(set(), &spec());
        let mut seen = Vec::new();
        for _ in 0..3 {
            world.reset(0).unwrap();
            loop {
                let mut x = [0.0];
                world.sense(0, &mut x).unwrap();
                let action = world.advise().unwrap();
                let outcome = world.step(action).unwrap();
                seen.push((x[0], action, outcome.end));
                if outcome.end == End::TimeLimit {
                    // What lies behind the cut can be seen.
                    world.sense(0, &mut x).unwrap();
                    assert_eq!(x, [0.02]);
                }
                if outcome.end != End::Running {
                    break;
                }
            }
        }
        let first = [(0.0, 0, End::Running), (0.01, 1, End::TimeLimit)];
        let second = [(0.1, 1, End::Running), (0.11, 1, End::Terminal)];
        assert_eq!(seen, [first, second, first].concat());
    }
}
