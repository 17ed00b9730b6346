//! How much a group of sensors tells of what the expert does: the share of the action's variance that a linear rule on
//! the group's readings explains in episodes that it was not learned from.
//!
//! # Formula
//! Actions are written as indicators y ∈ {0, 1}^|A|. For one half of the episodes B = (XᵀX + εn·1)⁻¹XᵀY, with a constant
//! among X; on the other half 1 − Σ|y − Bᵀx|² / Σ|y − ȳ|², ȳ the mean of the first half. The halves take turns; the mean of both
//! is *what the group tells*. Σ|y − ȳ|²/n is the Gini impurity of the expert's actions, so this is its relative drop.
//!
//! Why not mutual information: the joint readings of several cells never come twice, so counts would see information in
//! noise; held-out errors do not. Why linear: only sums of products enter, which are added up once; after that any of the
//! thousands of groups that an optimisation tries costs one small system of equations. What only a curved rule can read is missed.

use super::Shown;

/// ε: small against the variance of any reading that says something.
const RIDGE: f64 = 1e-4;

/// Sums of products of one half of the episodes.
#[derive(Clone, Debug)]
struct Half {
    moments: f64,
    /// Readings (and the constant) with each other.
    inputs: Vec<Vec<f64>>,
    /// Readings (and the constant) with the indicators of actions.
    both: Vec<Vec<f64>>,
}

/// What any group of sensors tells.
#[derive(Clone, Debug)]
pub struct Telling {
    places: Vec<std::ops::Range<usize>>,
    halves: [Half; 2],
    actions: usize,
}

impl Half {
    fn of(shown: &Shown, parity: usize) -> Self {
        let (dims, actions) = (shown.dims() + 1, shown.action_count());
        let mut half =
            Self { moments: 0.0, inputs: vec![vec![0.0; dims]; dims], both: vec![vec![0.0; actions]; dims] };
        for at in (0..shown.len()).filter(|&at| shown.episodes[at] % 2 == parity) {
            let mut x = shown.moment(at).to_vec();
            x.push(1.0);
            half.moments += 1.0;
            for (i, &a) in x.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                half.both[i][shown.actions[at]] += a;
                half.inputs[i].iter_mut().zip(&x).for_each(|(sum, b)| *sum += a * b);
            }
        }
        half
    }

    /// B, one column per action, learned from this half.
    fn rule(&self, columns: &[usize]) -> Vec<Vec<f64>> {
        let constant = self.inputs.len() - 1;
        let ridge = |i: usize| if i == constant { 0.0 } else { RIDGE * self.moments };
        let mut matrix: Vec<Vec<f64>> = columns
            .iter()
            .map(|&i| {
                columns.iter().map(|&j| self.inputs[i][j] + if i == j { ridge(i) } else { 0.0 }).collect()
            })
            .collect();
        let mut sides: Vec<Vec<f64>> = columns.iter().map(|&i| self.both[i].clone()).collect();
        solve(&mut matrix, &mut sides);
        sides
    }

    /// Σ|y − Bᵀx|² over this half.
    fn error(&self, columns: &[usize], rule: &[Vec<f64>]) -> f64 {
        // Every indicator vector has length 1.
        let mut sum = self.moments;
        for (k, &i) in columns.iter().enumerate() {
            for (a, &b) in rule[k].iter().enumerate() {
                let predicted: f64 = columns.iter().zip(rule).map(|(&j, r)| self.inputs[i][j] * r[a]).sum();
                sum += b * (predicted - 2.0 * self.both[i][a]);
            }
        }
        sum
    }
}

/// Replaces `sides` by the solution of a symmetric positive definite system (Cholesky). A direction without any weight
/// gets none.
fn solve(matrix: &mut [Vec<f64>], sides: &mut [Vec<f64>]) {
    let n = matrix.len();
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let rest = matrix[i][j] - dot;
            matrix[i][j] = match i == j {
                true => rest.max(0.0).sqrt(),
                false if matrix[j][j] > 0.0 => rest / matrix[j][j],
                false => 0.0,
            };
        }
    }
    let divide = |x: f64, by: f64| if by > 0.0 { x / by } else { 0.0 };
    for a in 0..sides.first().map_or(0, Vec::len) {
        for i in 0..n {
            let dot: f64 = (0..i).map(|k| matrix[i][k] * sides[k][a]).sum();
            sides[i][a] = divide(sides[i][a] - dot, matrix[i][i]);
        }
        for i in (0..n).rev() {
            let dot: f64 = (i + 1..n).map(|k| matrix[k][i] * sides[k][a]).sum();
            sides[i][a] = divide(sides[i][a] - dot, matrix[i][i]);
        }
    }
}

impl Telling {
    /// Adds up the sums of a demonstration. Its episodes with even and with odd numbers are the halves.
    #[must_use]
    pub fn of(shown: &Shown) -> Self {
        Self {
            places: (0..shown.sensors()).map(|s| shown.place(s)).collect(),
            halves: [Half::of(shown, 0), Half::of(shown, 1)],
            actions: shown.action_count(),
        }
    }

    /// What `group` tells: at most 1; 0 or less if it is better not to listen. 0 where the expert always does the same.
    #[must_use]
    pub fn of_group(&self, group: &[usize]) -> f64 {
        let constant = self.halves[0].inputs.len() - 1;
        let mut columns: Vec<usize> = group.iter().flat_map(|&s| self.places[s].clone()).collect();
        columns.sort_unstable();
        columns.push(constant);
        let turn = |learn: &Half, judge: &Half| {
            let nothing = judge.error(&[constant], &learn.rule(&[constant]));
            let error = judge.error(&columns, &learn.rule(&columns));
            if nothing > 1e-9 * judge.moments { 1.0 - error / nothing } else { 0.0 }
        };
        let [even, odd] = &self.halves;
        if self.actions == 0 || even.moments * odd.moments == 0.0 {
            return 0.0;
        }
        0.5 * (turn(even, odd) + turn(odd, even))
    }
}
