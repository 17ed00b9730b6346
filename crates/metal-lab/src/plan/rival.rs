//! Fixed choices of sensors, and how they are written: `MN+MF`, or `MN+MF/2` for every second motor step.

use super::limits::unknown;
use super::{Plan, PlanError};
use metal_rl::set::IndexSet;

/// A fixed choice of sensors: the rival of attention.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rival {
    /// Sensors, as indices into the spec.
    pub sensors: IndexSet,
    /// Motor steps from look to look; 1: it always looks.
    pub every: usize,
}

impl Rival {
    /// Who always looks at `sensors`.
    #[must_use]
    pub fn always(sensors: IndexSet) -> Self {
        Self { sensors, every: 1 }
    }

    /// The rival written as `words` among the sensors of `plan`.
    ///
    /// # Errors
    /// If a sensor is unknown, or the rhythm is no number from 1 on; `field` is where the words stand.
    pub fn parse(plan: &Plan, field: &str, words: &str) -> Result<Self, PlanError> {
        let (names, every) = words.split_once('/').unwrap_or((words, "1"));
        let mut sensors = IndexSet::EMPTY;
        for name in names.split('+') {
            let known = || plan.spec.sensors.iter().map(|s| s.name.as_str());
            let index = known().position(|known| known == name);
            sensors = sensors.with(index.ok_or_else(|| unknown(field, "sensor", name, known()))?);
        }
        match every.parse() {
            Ok(every) if every > 0 => Ok(Self { sensors, every }),
            _ => Err(PlanError::at(
                field,
                format!("`{words}`: motor steps from look to look, at least 1, after `/`"),
            )),
        }
    }

    /// As it is written: `MN+MF`, or `MN+MF/2` if it looks every second time.
    #[must_use]
    pub fn words(&self, plan: &Plan) -> String {
        let names: Vec<&str> = self.sensors.iter().map(|s| plan.spec.sensors[s].name.as_str()).collect();
        let rhythm = if self.every == 1 { String::new() } else { format!("/{}", self.every) };
        format!("{}{rhythm}", names.join("+"))
    }
}
