//! Writing while a mind lives: an environment that records what passes through it, and an observer for what is believed.

use crate::tape::Tape;
use metal_rl::environment::{End, Environment, EnvironmentError, EnvironmentSpec, Outcome};
use metal_rl::observe::{Observer, Step};
use metal_robots::{Picture, RobotEnvironment};
use metal_worlds::highway::Highway;
use metal_worlds::highway::camera::COLUMNS;

/// Who can show a picture that was taken anyway. To record must not make anybody look.
pub trait Pictured {
    /// The whole picture of this motor step, if there is one.
    fn picture(&self) -> Option<Picture>;
}

impl Pictured for RobotEnvironment {
    fn picture(&self) -> Option<Picture> {
        self.seen().cloned()
    }
}

impl Pictured for Highway {
    /// In a simulation to look costs nobody anything.
    fn picture(&self) -> Option<Picture> {
        Some(Picture { columns: COLUMNS, pixels: self.rgb_image() })
    }
}

/// An environment that writes down all that passes between it and a mind.
pub struct Recorder<E> {
    inner: E,
    tape: Tape,
    attended: Vec<u8>,
}

impl<E: Environment + Pictured> Recorder<E> {
    /// Records what happens in `inner`.
    #[must_use]
    pub fn new(inner: E, tape: Tape) -> Self {
        Self { inner, tape, attended: Vec::new() }
    }

    /// The environment again; the recording goes no further.
    #[must_use]
    pub fn into_inner(self) -> E {
        self.inner
    }

    /// The environment itself.
    #[must_use]
    pub fn inner(&self) -> &E {
        &self.inner
    }
}

impl<E: Environment + Pictured> Environment for Recorder<E> {
    fn spec(&self) -> &EnvironmentSpec {
        self.inner.spec()
    }

    fn reset(&mut self, seed: u64) -> Result<(), EnvironmentError> {
        self.inner.reset(seed)?;
        self.attended.clear();
        self.tape.advance();
        // Two halves: a float holds 53 bits, a seed 64.
        self.tape.floats("/episode", &[(seed >> 32) as f64, (seed & 0xFFFF_FFFF) as f64]);
        Ok(())
    }

    fn sense(&mut self, sensor: usize, out: &mut [f64]) -> Result<(), EnvironmentError> {
        self.inner.sense(sensor, out)?;
        self.attended.push(u8::try_from(sensor).unwrap_or(u8::MAX));
        self.tape.floats(&topic(&self.inner.spec().sensors[sensor].name), out);
        Ok(())
    }

    fn step(&mut self, action: usize) -> Result<Outcome, EnvironmentError> {
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
        self.tape.advance();
        self.attended.clear();
        Ok(outcome)
    }

    fn measures(&self) -> &[f64] {
        self.inner.measures()
    }

    fn advise(&mut self) -> Option<usize> {
        self.inner.advise()
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
