//! Writing while a mind lives: an environment that records what passes through it, and an observer for what is believed.

use crate::tape::Tape;
use metal_rl::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome, Picture};
use metal_rl::observe::{Observer, Step};
use metal_rl::set::IndexSet;

/// An environment that writes down all that passes between it and a mind.
#[expect(clippy::struct_excessive_bools, reason = "one wish and two independent facts about the last step")]
pub struct Recorder<E> {
    inner: E,
    tape: Tape,
    attended: Vec<u8>,
    seen: IndexSet,
    /// Whether everything is read before a step.
    thorough: bool,
    /// Whether a step has been made: the next thing that happens belongs to the next one.
    stepped: bool,
    /// Whether the world goes on behind the last step.
    cut: bool,
}

impl<E: Environment> Recorder<E> {
    /// Records what happens in `inner`.
    #[must_use]
    pub fn new(inner: E, tape: Tape) -> Self {
        Self {
            inner,
            tape,
            attended: Vec::new(),
            seen: IndexSet::EMPTY,
            thorough: false,
            stepped: false,
            cut: false,
        }
    }

    /// As [`Self::new`], and before every step reads what nobody attended to: only then all members can learn from the
    /// recording. `/attention` says who was attended to.
    #[must_use]
    pub fn thorough(inner: E, tape: Tape) -> Self {
        Self { thorough: true, ..Self::new(inner, tape) }
    }

    /// The environment again; the recording goes no further.
    #[must_use]
    pub fn into_inner(mut self) -> E {
        // What lies behind the last step is worth having, and not worth failing for.
        let _ = self.close();
        self.inner
    }

    /// Behind an episode that somebody cut there is a future, and learners want to see it.
    fn close(&mut self) -> Result<(), EnvironmentError> {
        if std::mem::take(&mut self.cut) && self.thorough { self.read_the_rest() } else { Ok(()) }
    }

    /// The environment itself.
    #[must_use]
    pub fn inner(&self) -> &E {
        &self.inner
    }

    fn read(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.inner.sense(sensor, out)?;
        self.next_step();
        self.seen = self.seen.with(sensor);
        self.tape.floats(&topic(&self.inner.spec().sensors[sensor].name), out);
        Ok(())
    }

    /// Time goes on with the first thing that happens after a step, so that what is believed of a step is told at its time.
    fn next_step(&mut self) {
        if std::mem::take(&mut self.stepped) {
            self.tape.advance();
        }
    }

    fn read_the_rest(&mut self) -> Result<(), EnvironmentError> {
        for sensor in 0..self.inner.spec().sensors.len() {
            if !self.seen.contains(sensor) {
                let mut out = vec![0.0; self.inner.spec().sensors[sensor].features.len()];
                self.read(sensor, &mut out)?;
            }
        }
        Ok(())
    }
}

impl<E: Environment> Environment for Recorder<E> {
    fn spec(&self) -> &EnvironmentSpec {
        self.inner.spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.close()?;
        self.inner.reset(seed)?;
        self.attended.clear();
        self.seen = IndexSet::EMPTY;
        self.stepped = true;
        self.next_step();
        // Two halves: a float holds 53 bits, a seed 64.
        self.tape.floats("/episode", &[(seed >> 32) as f64, (seed & 0xFFFF_FFFF) as f64]);
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.read(sensor, out)?;
        self.attended.push(u8::try_from(sensor).unwrap_or(u8::MAX));
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
        if self.thorough {
            self.read_the_rest()?;
        }
        self.next_step();
        if let Some(picture) = self.inner.picture() {
            self.tape.image("/image_raw", &picture);
        }
        let outcome = self.inner.step(action)?;
        self.tape.bytes("/attention", &self.attended);
        let end = match outcome.end {
            End::Running => 0.0,
            End::Terminal => 1.0,
            End::TimeLimit => 2.0,
        };
        self.tape.floats("/measures", self.inner.measures());
        self.tape.floats("/step", &[action as f64, outcome.motor_reward, end]);
        self.stepped = true;
        self.cut = outcome.end != End::Terminal;
        self.attended.clear();
        self.seen = IndexSet::EMPTY;
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

    /// A copy of the world. What is tried out in it did not happen, and is not recorded.
    fn fork(&self) -> Option<Box<dyn Environment>> {
        self.inner.fork()
    }
}

/// The topic of a sensor's readings.
#[must_use]
pub fn topic(sensor: &str) -> String {
    format!("/sensor/{sensor}")
}

/// Records what the members said: supports in the order of consulting, and what the looks of the step have cost.
pub struct Beliefs(pub Tape);

impl Observer for Beliefs {
    fn on_step(&mut self, step: &Step<'_>) {
        for &member in step.state.order() {
            if let Some(opinion) = step.state.opinion(member) {
                self.0.floats(&format!("/supports/{member}"), opinion.support);
            }
        }
        self.0.floats("/costs", &[-step.motor_reward, step.look_price]);
    }
}
