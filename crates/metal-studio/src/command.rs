//! What a page may ask for. Everything here is data: no name of a file ever comes from a page.

use crate::faults::Fault;
use serde::Deserialize;

/// A request of a page, as JSON: `{"do": "speed", "times": 4}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// Take the wheel, if nobody holds it.
    TakeWheel,
    /// Let go of the wheel.
    ReleaseWheel,
    /// Show decision `n` again, to this page only.
    Recall {
        /// Number of the decision.
        decision: u64,
    },
    /// Stop the body's wheels at once, for good. Everybody may.
    Brake,
    /// Stop the clock.
    Pause,
    /// Let the clock run.
    Resume,
    /// One motor step.
    Step,
    /// Take back the last step of a demonstration.
    Undo,
    /// How fast the clock runs: times real time; 0 means as fast as possible.
    Speed {
        /// 0, or from 0.25 to 16.
        times: f64,
    },
    /// Put a person at the wheel.
    Demonstrate,
    /// Press a motor action: a step if the clock stands, a course to hold if it runs.
    Press {
        /// Motor action.
        action: usize,
    },
    /// Let a key go.
    Lift,
    /// Save what was demonstrated.
    Save,
    /// Begin a new episode.
    Reset,
    /// Put a mind at the wheel.
    Watch {
        /// Index among the drivers.
        driver: usize,
    },
    /// A second mind on the same road in the same traffic; none: alone again.
    Compare {
        /// Index among the drivers.
        driver: Option<usize>,
    },
    /// What episodes are about.
    Scenario {
        /// Name of the scenario.
        name: String,
    },
    /// A situation of Table 1.
    Scene {
        /// Index of the situation.
        index: usize,
    },
    /// Put a car somewhere.
    Place {
        /// 0: the learner; 1, 2: the red cars.
        body: usize,
        /// Metres.
        x: f64,
        /// Metres.
        y: f64,
        /// Radians; as it was if left out.
        heading: Option<f64>,
    },
    /// Break or mend a sensor.
    Fault {
        /// Index of the sensor.
        sensor: usize,
        /// What is wrong with it.
        fault: Fault,
    },
    /// Start training the experiment.
    Train {
        /// Whether Phase I shows the last saved demonstration instead of the expert.
        demonstrations: bool,
    },
    /// Hold the training run.
    PauseTraining,
    /// Let it go on.
    ResumeTraining,
    /// End it; minds of finished phases stay.
    StopTraining,
    /// Whether the stage shows the training run.
    ViewTraining {
        /// Or the studio's own drive.
        on: bool,
    },
    /// How fast the training run goes while one watches: motor steps per second; 0: as fast as it can.
    Pace {
        /// Motor steps per second.
        steps_per_sec: f64,
    },
}

impl Request {
    /// Whether only the holder of the wheel may ask for it.
    #[must_use]
    pub fn needs_wheel(&self) -> bool {
        !matches!(self, Self::TakeWheel | Self::ReleaseWheel | Self::Recall { .. } | Self::Brake)
    }

    /// Whether it makes sense while a body is watched, which no page can steer.
    #[must_use]
    pub fn suits_a_body(&self) -> bool {
        matches!(
            self,
            Self::Pause | Self::Resume | Self::Step | Self::Speed { .. } | Self::Reset | Self::Watch { .. }
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_strictly() {
        let read = |text: &str| serde_json::from_str::<Request>(text);
        assert_eq!(read(r#"{"do":"speed","times":4}"#).unwrap(), Request::Speed { times: 4.0 });
        assert_eq!(read(r#"{"do":"pause"}"#).unwrap(), Request::Pause);
        let fault = Request::Fault { sensor: 2, fault: Fault::Blind };
        assert_eq!(read(r#"{"do":"fault","sensor":2,"fault":"blind"}"#).unwrap(), fault);
        for bad in [r#"{"do":"format_disk"}"#, r#"{"do":"press"}"#, r#"{"do":"press","action":-1}"#, "[]", ""]
        {
            assert!(read(bad).is_err(), "{bad}");
        }
        assert!(read(r#"{"do":"speed","times":1,"path":"/etc/passwd"}"#).is_err());
        assert!(!Request::Brake.needs_wheel(), "whoever sees that something goes wrong can stop it");
        assert!(Request::Pause.suits_a_body() && !Request::Press { action: 0 }.suits_a_body());
        assert!(Request::Pause.needs_wheel() && !Request::Recall { decision: 1 }.needs_wheel());
    }
}
