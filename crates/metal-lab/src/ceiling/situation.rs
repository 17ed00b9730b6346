//! Situations: what a moment is like, by what the world reports of it. No student knows them.

use metal_rl::environment::EnvironmentSpec;

/// Most situations that are told apart.
pub(super) const MOST: usize = 5;

/// Situations of a driving world, gravest first.
const DRIVING: [&str; MOST] =
    ["touching a car", "car within 10 cm", "car within 25 cm", "out of the lane", "free"];
/// Everything, where the world reports nothing of the kind.
const ANYWHERE: [&str; 1] = ["anywhere"];

/// Distances to the nearest car that are told apart, in metres.
const GAPS_M: [f64; 2] = [0.1, 0.25];

/// Tells situations apart.
pub(super) struct Situations {
    columns: Option<[usize; 3]>,
}

impl Situations {
    pub fn new(spec: &EnvironmentSpec) -> Self {
        let column = |name: &str| spec.measure(name);
        let columns = || Some([column("accident")?, column("gap_m")?, column("cost_lane")?]);
        Self { columns: columns() }
    }

    pub fn names(&self) -> &'static [&'static str] {
        if self.columns.is_some() { &DRIVING } else { &ANYWHERE }
    }

    /// The situation after a step of which the world reports `measures`. Nothing is reported yet at the beginning of an
    /// episode: free.
    pub fn of(&self, measures: &[f64], clock: usize) -> usize {
        let Some([accident, gap, lane]) = self.columns else { return 0 };
        if clock == 0 {
            return DRIVING.len() - 1;
        }
        let near = GAPS_M.iter().position(|&limit| measures[gap] < limit);
        match near {
            _ if measures[accident] > 0.5 => 0,
            Some(i) => 1 + i,
            None if measures[lane] > 0.0 => 3,
            None => 4,
        }
    }
}
