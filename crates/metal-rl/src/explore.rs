//! How greedy values become a choice while learning: soft-max (the paper's, Sec. 3.2.3), a random share, or none.

use crate::num;
use crate::random::Rng;
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// Exploration over a phase; strengths fall geometrically from `from` to `to` at share `until` of the phase, then stay. Reading R11.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Schedule {
    /// Always the best.
    #[default]
    Greedy,
    /// Soft-max over values; `from`, `to`: temperatures in units of reward, > 0.
    SoftMax {
        /// Temperature at the start.
        from: f64,
        /// Temperature at the end.
        to: f64,
        /// Share of the phase, in (0, 1], after which `to` is reached.
        until: f64,
    },
    /// A uniformly random choice with this probability, else the best.
    Random {
        /// Probability at the start, > 0.
        from: f64,
        /// Probability at the end, > 0.
        to: f64,
        /// Share of the phase, in (0, 1], after which `to` is reached.
        until: f64,
    },
}

/// Exploration at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exploration {
    /// The best.
    Greedy,
    /// Soft-max with this temperature.
    SoftMax(f64),
    /// Uniform with this probability.
    Random(f64),
}

impl Schedule {
    /// Exploration at `progress` (0 at the start of the phase, 1 at its end).
    #[must_use]
    pub fn at(self, progress: f64) -> Exploration {
        let blend = |from: f64, to: f64, until: f64| from * num::pow(to / from, (progress / until).min(1.0));
        match self {
            Self::Greedy => Exploration::Greedy,
            Self::SoftMax { from, to, until } => Exploration::SoftMax(blend(from, to, until)),
            Self::Random { from, to, until } => Exploration::Random(blend(from, to, until)),
        }
    }
}

impl Exploration {
    /// Chooses among the `available` indices of `values`; the lowest index wins a tie. `values` is used as scratch.
    ///
    /// # Panics
    /// If nothing is available.
    pub fn choose(self, values: &mut [f64], available: IndexSet, rng: &mut Rng) -> usize {
        assert!(!available.is_empty(), "there must be something to choose from");
        for (i, value) in values.iter_mut().enumerate() {
            if !available.contains(i) {
                *value = f64::NEG_INFINITY;
            }
        }
        match self {
            Self::Random(p) if rng.chance(p) => {
                available.iter().nth(rng.below(available.len())).unwrap_or_else(|| num::argmax(values))
            }
            Self::Greedy | Self::Random(_) => num::argmax(values),
            Self::SoftMax(temperature) => {
                num::soft_max(values, temperature);
                rng.pick(values)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedules_fall_to_their_end() {
        let schedule = Schedule::SoftMax { from: 8.0, to: 0.5, until: 0.5 };
        let Exploration::SoftMax(middle) = schedule.at(0.25) else { panic!("soft-max stays soft-max") };
        assert!((middle - 2.0).abs() < 1e-12);
        assert_eq!(schedule.at(0.5), schedule.at(1.0));
    }

    #[test]
    fn what_is_unavailable_is_never_chosen() {
        let mut rng = Rng::new(1);
        let available = IndexSet::EMPTY.with(1).with(2);
        for exploration in [Exploration::Greedy, Exploration::SoftMax(10.0), Exploration::Random(0.9)] {
            for _ in 0..200 {
                assert!(available.contains(exploration.choose(
                    &mut [9.0, 1.0, 2.0, 8.0],
                    available,
                    &mut rng
                )));
            }
        }
        assert_eq!(Exploration::Greedy.choose(&mut [9.0, 1.0, 2.0, 8.0], available, &mut rng), 2);
    }
}
