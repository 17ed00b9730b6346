//! The exact optimum of the toy, by dynamic programming over what the experts may have reported.

use super::model::{ACTIONS, EXPERTS, Situation};

/// What the best possible attention policy achieves per episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optimum {
    /// Expected return: motor reward minus prices of looks.
    pub value: f64,
    /// Expected number of looks.
    pub looks: f64,
    /// Probability of the right motor action.
    pub accuracy: f64,
}

/// The optimum over discrete reports. It is an upper bound for learners, who see them only through a Dirichlet blur.
///
/// # Formula
/// V(h) = max( maxₐ E[r(a) | h], maxᵢ −cᵢ + Σ_g P(g | h) V(h, g) ),  h: reports so far, cᵢ: price of expert i,
/// g: its report
#[must_use]
pub fn optimum() -> Optimum {
    let size = EXPERTS.iter().map(|e| e.groups + 1).product();
    let mut table = Table { solved: vec![None; size] };
    table.solve(0, Situation::all().map(Situation::probability).collect())
}

/// What is known is a number of mixed radix: digit i is 0 if expert i was not asked, else its report + 1.
struct Table {
    solved: Vec<Option<Optimum>>,
}

impl Table {
    /// The optimum of the rest of the episode; `joint` is P(situation, reports so far).
    fn solve(&mut self, known: usize, joint: Vec<f64>) -> Optimum {
        if let Some(done) = self.solved[known] {
            return done;
        }
        let mut best = best_action(&joint);
        let mut place = 1;
        for (i, expert) in EXPERTS.iter().enumerate() {
            let unasked = (known / place).is_multiple_of(expert.groups + 1);
            if unasked {
                let look = self.look(i, known, place, &joint);
                if look.value > best.value {
                    best = look;
                }
            }
            place *= expert.groups + 1;
        }
        self.solved[known] = Some(best);
        best
    }

    /// The optimum after asking expert `i`, averaged over its reports.
    fn look(&mut self, i: usize, known: usize, place: usize, joint: &[f64]) -> Optimum {
        let total: f64 = joint.iter().sum();
        let mut average = Optimum { value: -EXPERTS[i].price, looks: 1.0, accuracy: 0.0 };
        for group in 0..EXPERTS[i].groups {
            let after: Vec<f64> = Situation::all()
                .zip(joint)
                .map(|(s, p)| p * EXPERTS[i].report_probability(group, s))
                .collect();
            let chance = after.iter().sum::<f64>() / total;
            let rest = self.solve(known + (group + 1) * place, after);
            average.value += chance * rest.value;
            average.looks += chance * rest.looks;
            average.accuracy += chance * rest.accuracy;
        }
        average
    }
}

/// Moving now.
fn best_action(joint: &[f64]) -> Optimum {
    let total: f64 = joint.iter().sum();
    let mean = |f: &dyn Fn(Situation) -> f64| {
        Situation::all().zip(joint).map(|(s, p)| p * f(s)).sum::<f64>() / total
    };
    let mut best = Optimum { value: f64::NEG_INFINITY, looks: 0.0, accuracy: 0.0 };
    for action in 0..ACTIONS.len() {
        let value = mean(&|s| s.reward(action));
        if value > best.value {
            let accuracy = mean(&|s| f64::from(u8::from(s.right_action() == action)));
            best = Optimum { value, looks: 0.0, accuracy };
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_optimum_is_the_published_one() {
        let best = optimum();
        assert!((best.value + 5.2609).abs() < 5e-5, "{best:?}");
        assert!((best.looks - 2.480).abs() < 5e-4, "{best:?}");
        assert!((best.accuracy - 0.9096).abs() < 5e-5, "{best:?}");
    }

    #[test]
    fn without_a_look_slowing_down_is_best() {
        let joint: Vec<f64> = Situation::all().map(Situation::probability).collect();
        assert!((best_action(&joint).value + 12.25).abs() < 1e-12);
        assert!((joint.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
