//! A recording as an environment.

use crate::cdr::{read_bytes, read_floats, read_image};
use crate::reader::{Contents, contents};
use crate::recorder::topic;
use crate::tape::{SPEC, TapeError};
use metal_rl::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome, Picture};
use std::path::Path;
use std::sync::Arc;

/// One motor step on the tape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recorded {
    /// Readings of the sensors that were attended to, by sensor.
    pub readings: Vec<Option<Vec<f64>>>,
    /// Sensors in the order of looking.
    pub attended: Vec<u8>,
    /// Measures of the step.
    pub measures: Vec<f64>,
    /// The camera's picture of the step, if one was taken.
    pub picture: Option<Picture>,
    /// Motor action, and what it led to; none behind the last step of an episode, where only readings are left.
    pub moved: Option<(usize, Outcome)>,
}

/// A recording as an environment: whatever is asked is answered from the tape.
///
/// It goes on only with the action that was taken then, which is also its expert's advice: members learn from it as from
/// a demonstration. A sensor that nobody attended to then cannot be read now.
#[derive(Clone, Debug)]
pub struct Replay {
    spec: EnvironmentSpec,
    episodes: Arc<Vec<Vec<Recorded>>>,
    stubborn: bool,
    next: usize,
    episode: usize,
    step: usize,
}

impl Replay {
    /// Reads a recording.
    ///
    /// # Errors
    /// If the file cannot be read or is no recording of METAL.
    pub fn open(path: &Path) -> Result<Self, TapeError> {
        Self::of(&std::fs::read(path)?)
    }

    /// The recording in `bytes`.
    ///
    /// # Errors
    /// If they are no recording of METAL.
    pub fn of(bytes: &[u8]) -> Result<Self, TapeError> {
        let contents = contents(bytes)?;
        let spec = contract(&contents)?;
        let mut episodes = read_episodes(&contents, &spec)?;
        episodes.retain(|steps| steps.iter().any(|s| s.moved.is_some()));
        if episodes.is_empty() {
            return Err(TapeError::Foreign("it holds no motor step".to_owned()));
        }
        Ok(Self { spec, episodes: Arc::new(episodes), stubborn: false, next: 0, episode: 0, step: 0 })
    }

    /// Goes on with what was done then, whatever is done now, instead of refusing it: policies can be compared by what
    /// they look at, and not by where it leads.
    #[must_use]
    pub fn stubborn(self) -> Self {
        Self { stubborn: true, ..self }
    }

    /// Motor steps of each episode, and what was seen behind the last.
    #[must_use]
    pub fn episodes(&self) -> &[Vec<Recorded>] {
        &self.episodes
    }

    fn now(&self) -> Option<&Recorded> {
        self.episodes[self.episode].get(self.step)
    }

    fn refuse(&self, action: &str, reason: String) -> EnvironmentError {
        EnvironmentError::Motor { environment: self.spec.id.clone(), action: action.to_owned(), reason }
    }
}

fn contract(contents: &Contents<'_>) -> Result<EnvironmentSpec, TapeError> {
    let missing = || TapeError::Foreign(format!("the record `{SPEC}` is missing"));
    let facts = contents.facts.get(SPEC).ok_or_else(missing)?;
    Ok(serde_json::from_str(facts.get("json").copied().unwrap_or_default())?)
}

fn read_episodes(contents: &Contents<'_>, spec: &EnvironmentSpec) -> Result<Vec<Vec<Recorded>>, TapeError> {
    let topics: Vec<String> = spec.sensors.iter().map(|s| topic(&s.name)).collect();
    let blank = || Recorded { readings: vec![None; topics.len()], ..Recorded::default() };
    let (mut episodes, mut step): (Vec<Vec<Recorded>>, Recorded) = (Vec::new(), blank());
    // What was read behind the last step of an episode belongs to it.
    let close = |episodes: &mut Vec<Vec<Recorded>>, rest: Recorded| {
        if let Some(steps) = episodes.last_mut().filter(|_| rest.readings.iter().any(Option::is_some)) {
            steps.push(rest);
        }
    };
    for message in &contents.messages {
        match message.topic {
            "/episode" => {
                close(&mut episodes, std::mem::replace(&mut step, blank()));
                episodes.push(Vec::new());
            }
            "/attention" => step.attended = read_bytes(message.data)?,
            "/measures" => step.measures = read_floats(message.data)?,
            "/image_raw" => step.picture = Some(read_image(message.data)?),
            "/step" => {
                step.moved = Some(moved(&read_floats(message.data)?, spec)?);
                let missing = || TapeError::Foreign("a step before the first episode".to_owned());
                episodes.last_mut().ok_or_else(missing)?.push(std::mem::replace(&mut step, blank()));
            }
            name => {
                if let Some(sensor) = topics.iter().position(|t| t == name) {
                    step.readings[sensor] = Some(reading(message.data, spec.sensors[sensor].features.len())?);
                }
            }
        }
    }
    close(&mut episodes, step);
    Ok(episodes)
}

fn reading(data: &[u8], features: usize) -> Result<Vec<f64>, TapeError> {
    let values = read_floats(data)?;
    if values.len() == features && !values.iter().any(|v| v.is_infinite()) {
        return Ok(values);
    }
    Err(TapeError::Foreign(format!("a reading {values:?} of a sensor with {features} features")))
}

fn moved(values: &[f64], spec: &EnvironmentSpec) -> Result<(usize, Outcome), TapeError> {
    let foreign = || TapeError::Foreign(format!("the step {values:?}"));
    let [action, motor_reward, end] = values else { return Err(foreign()) };
    let known = *action >= 0.0 && (*action as usize) < spec.actions.len() && motor_reward.is_finite();
    let end = match *end as i64 {
        0 => End::Running,
        1 => End::Terminal,
        2 => End::TimeLimit,
        _ => return Err(foreign()),
    };
    if known { Ok((*action as usize, Outcome { motor_reward: *motor_reward, end })) } else { Err(foreign()) }
}

impl Environment for Replay {
    fn spec(&self) -> &EnvironmentSpec {
        &self.spec
    }

    /// Begins the next recorded episode, the first one after the last; the seed changes nothing.
    fn reset(&mut self, _seed: u64) -> Result<(), EnvironmentError> {
        (self.episode, self.step) = (self.next, 0);
        self.next = (self.next + 1) % self.episodes.len();
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        let steps = &self.episodes[self.episode];
        let last = steps.len() - 1;
        let mut reading = &steps[self.step.min(last)].readings[sensor];
        if reading.is_none() && self.now().is_none_or(|r| r.moved.is_none()) {
            // Behind the last step; what was last seen is the best that is known.
            reading = steps.iter().rev().map(|s| &s.readings[sensor]).find(|r| r.is_some()).unwrap_or(&None);
        }
        match reading {
            Some(values) => {
                out.copy_from_slice(values);
                Ok(())
            }
            None => Err(EnvironmentError::Sensor {
                environment: self.spec.id.clone(),
                sensor: self.spec.sensors[sensor].name.clone(),
                reason: format!("nobody attended to it in step {} of the recording", self.step),
            }),
        }
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let name = self.spec.actions.get(action).cloned().unwrap_or_default();
        let Some((taken, mut outcome)) = self.now().and_then(|r| r.moved) else {
            return Err(self.refuse(&name, "the recorded episode is over".to_owned()));
        };
        if action != taken && !self.stubborn {
            let then = &self.spec.actions[taken];
            return Err(self.refuse(&name, format!("the recording went on with `{then}`")));
        }
        self.step += 1;
        if outcome.end == End::Running && self.now().is_none_or(|r| r.moved.is_none()) {
            outcome.end = End::TimeLimit;
        }
        Ok(outcome)
    }

    fn measures(&self) -> &[f64] {
        let before = self.step.saturating_sub(1);
        &self.episodes[self.episode][before].measures
    }

    /// The picture of then, if one was taken in this step.
    fn picture(&self) -> Option<Picture> {
        self.now()?.picture.clone()
    }

    /// What was done then. Behind the last step nothing was done, and what is advised there is not carried out.
    fn advise(&mut self) -> Option<usize> {
        Some(self.now().and_then(|r| r.moved).map_or(0, |(action, _)| action))
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.clone()))
    }
}
