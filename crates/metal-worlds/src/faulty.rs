//! Any world behind sensors that fail: which fault, how often and in which sensors is data.
//!
//! Faults change what is read and never the world. Everything random about them comes from the episode's seed and from
//! nothing else, and a sensor that fails at one rate fails at every higher one, so that rates are compared on the same
//! episodes.

use metal_rl::environment::{Environment, EnvironmentError, EnvironmentSpec, Feature, Outcome, Picture};
use metal_rl::random::Streams;
use metal_rl::set::IndexSet;
use serde::{Deserialize, Serialize};

/// What is wrong with a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// Without power: every number is the lowest it can be.
    Dead,
    /// It shows for ever what it saw when the episode began, or when it broke.
    Frozen,
    /// It answers, but not with numbers.
    Nan,
    /// What it shows is this many motor steps old (at the beginning of an episode: its first reading).
    Delayed(usize),
    /// Readings jump around by this share of their range (standard deviation).
    Noisy(f64),
    /// Something lies on it: a camera region is black all over, any other sensor meets nothing.
    Blinded,
    /// Somebody takes it away at a random moment of the episode: from then on it says nothing that is a number.
    Removed,
    /// Somebody plugs it in at a random moment of the episode: until then it says nothing that is a number.
    Added,
}

impl Fault {
    /// Name in tables and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Dead => "dead",
            Self::Frozen => "frozen",
            Self::Nan => "nan",
            Self::Delayed(_) => "delayed",
            Self::Noisy(_) => "noisy",
            Self::Blinded => "blinded",
            Self::Removed => "removed",
            Self::Added => "added",
        }
    }

    /// One of each kind: a delay of two motor steps, noise of 15 % of the range.
    pub const ALL: [Self; 8] = [
        Self::Dead,
        Self::Frozen,
        Self::Nan,
        Self::Delayed(2),
        Self::Noisy(0.15),
        Self::Blinded,
        Self::Removed,
        Self::Added,
    ];
}

/// Faults of a world's sensors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Faults {
    /// What fails.
    pub fault: Option<Fault>,
    /// Probability, in [0, 1], that a sensor fails in an episode; every sensor and episode for itself.
    pub rate: f64,
    /// Sensors that may fail; empty: all.
    pub sensors: Vec<String>,
    /// Motor steps of an episode in which a failing sensor is broken: the first of them, and the one in which it is mended;
    /// none: from the beginning to the end.
    pub during: Option<(usize, usize)>,
    /// Two sensors that answer in each other's place.
    pub crossed: Option<(String, String)>,
    /// Sensors of another make, which show the lowest for the highest and the highest for the lowest: they tell as much, in
    /// another language.
    pub inverted: Vec<String>,
}

/// Why a world cannot have these faults: the field, and what was found and is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {message}")]
pub struct FaultError {
    /// Field of [`Faults`].
    pub field: &'static str,
    /// What was found, and what is allowed.
    pub message: String,
}

/// Longest delay, in motor steps.
const LONGEST_DELAY: usize = 1000;

impl Faults {
    fn check(&self, spec: &EnvironmentSpec) -> Result<(), FaultError> {
        let refuse = |field, message: String| Err(FaultError { field, message });
        if !(0.0..=1.0).contains(&self.rate) {
            return refuse("rate", format!("{}: in [0, 1]", self.rate));
        }
        if let Some((from, until)) = self.during.filter(|(from, until)| from >= until) {
            return refuse("during", format!("[{from}, {until}]: mended after it broke"));
        }
        match self.fault {
            Some(Fault::Noisy(x)) if !(0.0..=1.0).contains(&x) => {
                return refuse("fault.noisy", format!("{x}: in [0, 1]"));
            }
            Some(Fault::Delayed(n)) if n > LONGEST_DELAY => {
                return refuse("fault.delayed", format!("{n}: at most {LONGEST_DELAY} motor steps"));
            }
            _ => {}
        }
        for (field, names) in [("sensors", &self.sensors), ("inverted", &self.inverted)] {
            if let Some(name) = names.iter().find(|name| spec.sensor(name).is_none()) {
                return refuse(field, format!("`{name}` is no sensor of {}", spec.id));
            }
        }
        let Some((a, b)) = &self.crossed else { return Ok(()) };
        let length = |name: &str| spec.sensor(name).map(|s| spec.sensors[s].features.len());
        if length(a).is_some() && length(a) == length(b) {
            return Ok(());
        }
        refuse("crossed", format!("`{a}` and `{b}`: two sensors of {} that are alike", spec.id))
    }

    /// Whether a failing sensor is broken in this motor step of an episode.
    fn broken_at(&self, step: usize) -> bool {
        self.during.is_none_or(|(from, until)| (from..until).contains(&step))
    }

    /// The sensors that may fail.
    fn suspects(&self, spec: &EnvironmentSpec) -> IndexSet {
        if self.sensors.is_empty() {
            return IndexSet::first(spec.sensors.len());
        }
        self.sensors.iter().filter_map(|name| spec.sensor(name)).collect()
    }
}

/// A world whose sensors fail.
pub struct Faulty {
    inner: Box<dyn Environment>,
    faults: Faults,
    suspects: IndexSet,
    crossed: Option<(usize, usize)>,
    inverted: IndexSet,
    episode: Streams,
    step: usize,
    /// Who fails in this episode.
    failing: IndexSet,
    /// Motor step in which something changes, by sensor.
    onset: Vec<usize>,
    /// What a frozen or delayed sensor measured, by sensor: its readings one after the other.
    past: Vec<Vec<f64>>,
}

impl Faulty {
    /// `inner` behind these faults.
    ///
    /// # Errors
    /// If the world cannot have them.
    pub fn new(inner: Box<dyn Environment>, faults: Faults) -> Result<Self, FaultError> {
        let spec = inner.spec();
        faults.check(spec)?;
        let sensors = spec.sensors.len();
        let crossed = faults.crossed.as_ref().and_then(|(a, b)| Some((spec.sensor(a)?, spec.sensor(b)?)));
        Ok(Self {
            suspects: faults.suspects(spec),
            inverted: faults.inverted.iter().filter_map(|name| spec.sensor(name)).collect(),
            crossed,
            faults,
            inner,
            episode: Streams::new(0),
            step: 0,
            failing: IndexSet::EMPTY,
            onset: vec![0; sensors],
            past: vec![Vec::new(); sensors],
        })
    }

    /// The sensor that answers when `sensor` is asked.
    fn wired(&self, sensor: usize) -> usize {
        match self.crossed {
            Some((a, b)) if sensor == a => b,
            Some((a, b)) if sensor == b => a,
            _ => sensor,
        }
    }

    /// What the device at the place of `sensor` shows while nothing is wrong with it.
    fn show(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.inner.sense(self.wired(sensor), out)?;
        if self.inverted.contains(sensor) {
            let features = &self.inner.spec().sensors[sensor].features;
            out.iter_mut().zip(features).for_each(|(x, feature)| *x = feature.low + feature.high - *x);
        }
        Ok(())
    }

    fn draw(&mut self, seed: u64) {
        self.episode = Streams::new(seed).child("faults");
        self.failing = IndexSet::EMPTY;
        for sensor in self.suspects.iter() {
            let mut rng = self.episode.nth(sensor as u64).stream("fails");
            if self.faults.fault.is_some() && rng.uniform() < self.faults.rate {
                self.failing = self.failing.with(sensor);
            }
            self.onset[sensor] = rng.below(self.inner.spec().horizon.max(1));
        }
    }

    /// A frozen or delayed device goes on measuring whether it is asked or not; nobody else is read unasked.
    fn measure(&mut self) -> Result<(), EnvironmentError> {
        let wanted = match self.faults.fault {
            Some(Fault::Frozen) => self.step == self.faults.during.map_or(0, |(from, _)| from),
            Some(Fault::Delayed(_)) => true,
            _ => false,
        };
        if !wanted {
            return Ok(());
        }
        for sensor in self.failing.iter() {
            let mut past = std::mem::take(&mut self.past[sensor]);
            let (from, n) = (past.len(), self.inner.spec().sensors[sensor].features.len());
            past.resize(from + n, 0.0);
            let shown = self.show(sensor, &mut past[from..]);
            self.past[sensor] = past;
            shown?;
        }
        Ok(())
    }

    /// What a failing sensor shows instead of `out`.
    fn spoil(&self, fault: Fault, sensor: usize, out: &mut [f64]) {
        let features = &self.inner.spec().sensors[sensor].features;
        match fault {
            Fault::Dead => fill(features, out, |feature| feature.low),
            Fault::Blinded => {
                fill(features, out, |f| if f.name == "black" { f.high } else { f.low });
            }
            Fault::Frozen => out.copy_from_slice(&self.past[sensor][..out.len()]),
            Fault::Delayed(steps) => {
                let at = self.step.saturating_sub(steps) * out.len();
                out.copy_from_slice(&self.past[sensor][at..at + out.len()]);
            }
            Fault::Noisy(spread) => self.add_noise(spread, sensor, out),
            Fault::Nan => out.fill(f64::NAN),
            Fault::Removed if self.step >= self.onset[sensor] => out.fill(f64::NAN),
            Fault::Added if self.step < self.onset[sensor] => out.fill(f64::NAN),
            Fault::Removed | Fault::Added => {}
        }
    }

    /// The noise belongs to the step and the sensor, so looking twice sees the same.
    fn add_noise(&self, spread: f64, sensor: usize, out: &mut [f64]) {
        let features = &self.inner.spec().sensors[sensor].features;
        let mut rng = self.episode.nth(sensor as u64).child("noise").nth(self.step as u64).stream("noise");
        for (value, feature) in out.iter_mut().zip(features) {
            let error = spread * (feature.high - feature.low) * rng.normal();
            *value = (*value + error).clamp(feature.low, feature.high);
        }
    }
}

fn fill(features: &[Feature], out: &mut [f64], value: impl Fn(&Feature) -> f64) {
    out.iter_mut().zip(features).for_each(|(out, feature)| *out = value(feature));
}

impl Environment for Faulty {
    fn spec(&self) -> &EnvironmentSpec {
        self.inner.spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.inner.reset(seed)?;
        self.step = 0;
        self.past.iter_mut().for_each(Vec::clear);
        self.draw(seed);
        self.measure()
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.show(sensor, out)?;
        let broken = self.failing.contains(sensor) && self.faults.broken_at(self.step);
        if let Some(fault) = self.faults.fault.filter(|_| broken) {
            self.spoil(fault, sensor, out);
        }
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        let outcome = self.inner.step(action)?;
        self.step += 1;
        self.measure()?;
        Ok(outcome)
    }

    fn measures(&self) -> &[f64] {
        self.inner.measures()
    }

    fn picture(&self) -> Option<Picture> {
        self.inner.picture()
    }

    fn advise(&mut self) -> Option<usize> {
        self.inner.advise()
    }

    fn fork(&self) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.around(self.inner.fork()?)))
    }

    fn imagine(&self, streams: &Streams) -> Option<Box<dyn Environment>> {
        Some(Box::new(self.around(self.inner.imagine(streams)?)))
    }
}

impl Faulty {
    /// The same faults, as they stand, around `inner`.
    fn around(&self, inner: Box<dyn Environment>) -> Self {
        Self {
            inner,
            faults: self.faults.clone(),
            onset: self.onset.clone(),
            past: self.past.clone(),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::highway::{Highway, HighwayConfig, Steering};
    use std::sync::LazyLock;

    static ROAD: LazyLock<Highway> =
        LazyLock::new(|| Highway::new(HighwayConfig::default(), Steering::Scripted));

    fn road() -> Box<dyn Environment> {
        Box::new(ROAD.clone())
    }

    fn faulty(fault: Fault) -> Faulty {
        Faulty::new(road(), Faults { fault: Some(fault), rate: 1.0, ..Faults::default() }).unwrap()
    }

    fn read(world: &mut dyn Environment, sensor: usize) -> Vec<f64> {
        let mut out = vec![0.0; world.spec().sensors[sensor].features.len()];
        world.sense(sensor, &mut out).unwrap();
        out
    }

    #[test]
    fn faults_change_what_is_read_and_never_the_world() {
        for fault in Fault::ALL {
            let (mut plain, mut broken) = (road(), faulty(fault));
            plain.reset(5).unwrap();
            broken.reset(5).unwrap();
            for action in [0, 3, 4, 1] {
                let twice = [read(&mut broken, 2), read(&mut broken, 2)].map(|r| format!("{r:?}"));
                assert_eq!(twice[0], twice[1], "looking twice sees the same");
                let mut copy = broken.fork().unwrap();
                assert_eq!(broken.step(action).unwrap(), plain.step(action).unwrap());
                copy.step(action).unwrap();
                assert_eq!(format!("{:?}", read(copy.as_mut(), 3)), format!("{:?}", read(&mut broken, 3)));
                assert_eq!(broken.measures(), plain.measures());
            }
        }
    }

    #[test]
    fn every_fault_is_what_it_says() {
        let mut plain = road();
        plain.reset(5).unwrap();
        let mut past = vec![read(plain.as_mut(), 0)];
        let mut worlds = Fault::ALL.map(faulty);
        worlds.iter_mut().for_each(|w| w.reset(5).unwrap());
        let onset = |w: &Faulty| w.onset[0];
        for step in 0..40 {
            let now = past[step].clone();
            assert_eq!(read(&mut worlds[0], 0), [0.0; 4]);
            assert_eq!(read(&mut worlds[1], 0), past[0]);
            assert!(read(&mut worlds[2], 0).iter().all(|x| x.is_nan()));
            assert_eq!(read(&mut worlds[3], 0), past[step.saturating_sub(2)]);
            assert!(read(&mut worlds[4], 0).iter().all(|x| (0.0..=1.0).contains(x)));
            assert_eq!(read(&mut worlds[5], 0), [1.0, 0.0, 0.0, 0.0]);
            let (gone, here) = (read(&mut worlds[6], 0), read(&mut worlds[7], 0));
            assert!(if step >= onset(&worlds[6]) { gone[0].is_nan() } else { gone == now });
            assert!(if step < onset(&worlds[7]) { here[0].is_nan() } else { here == now });
            plain.step(step % 5).unwrap();
            for world in &mut worlds {
                world.step(step % 5).unwrap();
            }
            past.push(read(plain.as_mut(), 0));
        }
    }

    #[test]
    fn a_sensor_can_break_and_be_mended_within_an_episode() {
        for fault in [Fault::Nan, Fault::Frozen, Fault::Delayed(2)] {
            let during = Some((3, 6));
            let faults = Faults { fault: Some(fault), rate: 1.0, during, ..Faults::default() };
            let (mut plain, mut broken) = (road(), Faulty::new(road(), faults).unwrap());
            plain.reset(5).unwrap();
            broken.reset(5).unwrap();
            let mut past = Vec::new();
            for step in 0..10 {
                past.push(read(plain.as_mut(), 0));
                let now = read(&mut broken, 0);
                match fault {
                    _ if !(3..6).contains(&step) => assert_eq!(now, past[step], "{fault:?}, step {step}"),
                    Fault::Nan => assert!(now.iter().all(|x| x.is_nan())),
                    Fault::Frozen => assert_eq!(now, past[3]),
                    _ => assert_eq!(now, past[step - 2]),
                }
                plain.step(step % 5).unwrap();
                broken.step(step % 5).unwrap();
            }
        }
    }

    #[test]
    fn a_sensor_of_another_make_shows_the_opposite() {
        let inverted = vec!["LN".to_owned(), "IR".to_owned()];
        let mut plain = road();
        let mut other = Faulty::new(road(), Faults { inverted, ..Faults::default() }).unwrap();
        plain.reset(5).unwrap();
        other.reset(5).unwrap();
        let spec = plain.spec().clone();
        for (sensor, told) in spec.sensors.iter().enumerate() {
            let (was, is) = (read(plain.as_mut(), sensor), read(&mut other, sensor));
            for ((was, is), feature) in was.into_iter().zip(is).zip(&told.features) {
                let turned = ["LN", "IR"].contains(&told.name.as_str());
                assert_eq!(is, if turned { feature.low + feature.high - was } else { was }, "{}", told.name);
            }
        }
        let frozen = Faults {
            fault: Some(Fault::Frozen),
            rate: 1.0,
            inverted: vec!["LN".to_owned()],
            ..Faults::default()
        };
        let mut frozen = Faulty::new(road(), frozen).unwrap();
        frozen.reset(5).unwrap();
        assert_eq!(read(&mut frozen, 1), read(&mut other, 1));
        frozen.step(0).unwrap();
        assert_eq!(read(&mut frozen, 1), read(&mut other, 1), "what it showed when the episode began");
    }

    #[test]
    fn a_sensor_that_fails_at_one_rate_fails_at_every_higher_one() {
        let failing = |rate, seed| {
            let faults = Faults { fault: Some(Fault::Dead), rate, ..Faults::default() };
            let mut world = Faulty::new(road(), faults).unwrap();
            world.draw(seed);
            world.failing
        };
        let mut count = 0;
        for seed in 0..300 {
            let (few, many) = (failing(0.25, seed), failing(0.5, seed));
            assert!(few.minus(many).is_empty());
            assert_eq!((failing(0.0, seed).len(), failing(1.0, seed).len()), (0, 7));
            count += few.len();
        }
        assert!((450..600).contains(&count), "{count} of 2100 at a quarter");
    }

    #[test]
    fn crossed_wires_and_impossible_faults() {
        let cross =
            |a: &str, b: &str| Faults { crossed: Some((a.to_owned(), b.to_owned())), ..Faults::default() };
        let (mut plain, mut crossed) = (road(), Faulty::new(road(), cross("LN", "RN")).unwrap());
        assert_eq!(read(plain.as_mut(), 1), read(&mut crossed, 2));
        assert_eq!(read(plain.as_mut(), 2), read(&mut crossed, 1));
        assert_eq!(read(plain.as_mut(), 0), read(&mut crossed, 0));
        let refused = |faults| Faulty::new(road(), faults).err().unwrap().to_string();
        assert!(refused(cross("LN", "IR")).contains("alike"));
        assert!(refused(Faults { rate: 1.5, ..Faults::default() }).contains("in [0, 1]"));
        assert!(refused(Faults { sensors: vec!["EAR".into()], ..Faults::default() }).contains("no sensor"));
        assert!(refused(Faults { inverted: vec!["EAR".into()], ..Faults::default() }).contains("inverted"));
        assert!(refused(Faults { during: Some((4, 4)), ..Faults::default() }).contains("during: [4, 4]"));
        let noisy = Faults { fault: Some(Fault::Noisy(f64::NAN)), ..Faults::default() };
        assert!(refused(noisy).contains("noisy"));
    }
}
