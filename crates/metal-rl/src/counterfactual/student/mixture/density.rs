//! The joint density of what can be known and what moves are worth: a mixture of Gaussians with few directions each.
//!
//! Given its component and the place z along that component's directions, every feature is independent of the others.
//! So what is not known is left out of the sums, and that *is* the exact marginal: no set of looks needs matrices of
//! its own.
//!
//! # Formula
//! x = μ_c + Λ_c z + ε,  z ~ N(0, I),  ε ~ N(0, Ψ_c) with diagonal Ψ_c;  with O the known features:
//! M = I + Λ_Oᵀ Ψ_O⁻¹ Λ_O;  h = Λ_Oᵀ Ψ_O⁻¹ (x_O − μ_O);  z | x_O ~ N(M⁻¹ h, M⁻¹);
//! ln p_c(x_O) = −½ (Σ_O (x − μ)²/ψ − hᵀ M⁻¹ h + Σ_O ln 2πψ + ln |M|);
//! E\[x_U | x_O\] = Σ_c r_c (μ_U + Λ_U z_c),  r_c ∝ π_c p_c(x_O)

use super::config::MOST_FACTORS;
use crate::num;
use crate::num::cholesky;
use multiversion::multiversion;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Components that are computed side by side.
pub(super) const LANES: usize = 4;

/// One number of each of them.
pub(super) type Lane = [f64; LANES];

/// Log weight of a component that is not there.
const ABSENT: f64 = -1e300;

/// Shares below this are none.
const NEGLIGIBLE: f64 = 1e-4;

/// A component in plain numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Component {
    /// Its share of all data.
    pub weight: f64,
    /// μ, by feature.
    pub means: Vec<f64>,
    /// ψ, by feature.
    pub noises: Vec<f64>,
    /// Λ, features × factors.
    pub loadings: Vec<f64>,
}

/// The mixture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Density {
    factors: usize,
    components: usize,
    blocks: Vec<Range<usize>>,
    log_weights: Vec<f64>,
    /// Group × feature × (mean, 1/ψ, loadings).
    rows: Vec<Lane>,
    /// Group × block × (Σ ln 2πψ, lower triangle of Λᵀ Ψ⁻¹ Λ).
    sums: Vec<Lane>,
}

/// What is inferred from what is known.
#[derive(Clone, Debug, Default)]
pub(super) struct Belief {
    /// ln π_c p_c(x_O), by component.
    logs: Vec<f64>,
    /// E\[z\], group × factor.
    places: Vec<Lane>,
    /// Components that count, with their shares.
    pub active: Vec<(usize, f64)>,
    /// ln p(x_O).
    pub log_density: f64,
}

impl Belief {
    /// E\[z_j\] in component `c`, of `factors`.
    pub fn place(&self, c: usize, j: usize, factors: usize) -> f64 {
        self.places[c / LANES * factors + j][c % LANES]
    }
}

impl Density {
    /// A density of these components over features in these blocks.
    pub fn new(blocks: Vec<Range<usize>>, factors: usize, components: &[Component]) -> Self {
        let groups = components.len().div_ceil(LANES);
        let width = blocks.last().map_or(0, |block| block.end);
        let mut density = Self {
            factors,
            components: components.len(),
            log_weights: vec![ABSENT; groups * LANES],
            rows: vec![[0.0; LANES]; groups * width * (2 + factors)],
            sums: vec![[0.0; LANES]; groups * blocks.len() * (1 + cholesky::size(factors))],
            blocks,
        };
        for (c, component) in components.iter().enumerate() {
            density.set(c, component);
        }
        density
    }

    /// Number of components.
    pub fn components(&self) -> usize {
        self.components
    }

    /// Number of directions of each.
    pub fn factors(&self) -> usize {
        self.factors
    }

    /// The features of every block.
    pub fn blocks(&self) -> &[Range<usize>] {
        &self.blocks
    }

    /// Number of features.
    pub fn width(&self) -> usize {
        self.blocks.last().map_or(0, |block| block.end)
    }

    /// Numbers that were learned.
    pub fn numbers(&self) -> usize {
        self.components * (1 + self.width() * (2 + self.factors))
    }

    /// Whether all vectors have the lengths that the shape demands.
    pub fn is_sound(&self, blocks: &[Range<usize>], factors: usize) -> bool {
        let groups = self.components.div_ceil(LANES);
        self.blocks == blocks
            && self.factors == factors
            && self.log_weights.len() == groups * LANES
            && self.rows.len() == groups * self.width() * (2 + factors)
            && self.sums.len() == groups * blocks.len() * (1 + cholesky::size(factors))
    }

    fn row(&self, c: usize, feature: usize) -> usize {
        (c / LANES * self.width() + feature) * (2 + self.factors)
    }

    /// Replaces component `c`.
    pub fn set(&mut self, c: usize, component: &Component) {
        let (q, lane) = (self.factors, c % LANES);
        self.log_weights[c] = num::ln(component.weight.max(f64::MIN_POSITIVE));
        let length = 1 + cholesky::size(q);
        for b in 0..self.blocks.len() {
            let mut sums = vec![0.0; length];
            for i in self.blocks[b].clone() {
                let (row, precision) = (self.row(c, i), 1.0 / component.noises[i]);
                let loadings = &component.loadings[i * q..(i + 1) * q];
                self.rows[row][lane] = component.means[i];
                self.rows[row + 1][lane] = precision;
                sums[0] += num::ln(2.0 * std::f64::consts::PI * component.noises[i]);
                for j in 0..q {
                    self.rows[row + 2 + j][lane] = loadings[j];
                    for k in 0..=j {
                        sums[1 + cholesky::at(j, k)] += loadings[j] * loadings[k] * precision;
                    }
                }
            }
            let place = (c / LANES * self.blocks.len() + b) * length;
            for (to, sum) in self.sums[place..place + length].iter_mut().zip(sums) {
                to[lane] = sum;
            }
        }
    }

    /// Component `c` in plain numbers.
    pub fn component(&self, c: usize) -> Component {
        let (q, lane) = (self.factors, c % LANES);
        let number = |i: usize, k: usize| self.rows[self.row(c, i) + k][lane];
        let features = 0..self.width();
        Component {
            weight: num::exp(self.log_weights[c]),
            means: features.clone().map(|i| number(i, 0)).collect(),
            noises: features.clone().map(|i| 1.0 / number(i, 1)).collect(),
            loadings: features.flat_map(|i| (0..q).map(move |j| number(i, 2 + j))).collect(),
        }
    }

    /// Multiplies the features of the last block, the targets, by `gain`.
    pub fn scale_targets(&mut self, gain: f64) {
        let Some(targets) = self.blocks.last().cloned() else { return };
        let q = self.factors;
        for c in 0..self.components {
            let mut component = self.component(c);
            for i in targets.clone() {
                component.means[i] *= gain;
                component.noises[i] *= gain * gain;
                component.loadings[i * q..(i + 1) * q].iter_mut().for_each(|l| *l *= gain);
            }
            self.set(c, &component);
        }
    }

    /// Working memory of the right size.
    #[cfg(test)]
    pub fn belief(&self) -> Belief {
        let mut belief = Belief::default();
        self.make_room(&mut belief);
        belief
    }

    /// Gives working memory the right size; once it has it, nothing is allocated.
    fn make_room(&self, belief: &mut Belief) {
        belief.logs.resize(self.log_weights.len(), 0.0);
        belief.places.resize(self.log_weights.len() / LANES * self.factors, [0.0; LANES]);
        belief.active.clear();
        belief.active.reserve(self.components);
    }

    /// What is inferred from the features of the blocks that are `seen`.
    pub fn infer(&self, x: &[f64], seen: &[bool], belief: &mut Belief) {
        self.make_room(belief);
        let (q, groups) = (self.factors, self.log_weights.len() / LANES);
        let known = Known { blocks: &self.blocks, x, seen };
        let (rows, sums) = (self.width() * (2 + q), self.blocks.len() * (1 + cholesky::size(q)));
        for g in 0..groups {
            let parameters = (&self.rows[g * rows..(g + 1) * rows], &self.sums[g * sums..(g + 1) * sums]);
            let logs = weigh(q, parameters, known, &mut belief.places[g * q..(g + 1) * q]);
            let place = g * LANES..(g + 1) * LANES;
            let weights = &self.log_weights[place.clone()];
            for ((to, log), weight) in belief.logs[place].iter_mut().zip(logs).zip(weights) {
                *to = weight + log;
            }
        }
        self.share_out(belief);
    }

    /// From logarithms to shares.
    fn share_out(&self, belief: &mut Belief) {
        let logs = &belief.logs[..self.components];
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        for (c, &log) in logs.iter().enumerate().filter(|(_, log)| **log - most > -20.0) {
            let share = num::exp(log - most);
            sum += share;
            belief.active.push((c, share));
        }
        belief.log_density = most + num::ln(sum);
        belief.active.retain(|(_, share)| *share > NEGLIGIBLE * sum);
        let rest: f64 = belief.active.iter().map(|(_, share)| share).sum();
        belief.active.iter_mut().for_each(|(_, share)| *share /= rest);
    }

    /// E\[feature `i`\] in component `c`.
    pub fn expected(&self, (c, i): (usize, usize), belief: &Belief) -> f64 {
        let (row, lane) = (self.row(c, i), c % LANES);
        let along = |j: usize| self.rows[row + 2 + j][lane] * belief.place(c, j, self.factors);
        self.rows[row][lane] + (0..self.factors).map(along).sum::<f64>()
    }

    /// M⁻¹ of component `c`: how uncertain its place is when the blocks `seen` are known.
    pub fn spread(&self, c: usize, seen: &[bool], out: &mut [f64]) {
        let q = self.factors;
        let length = 1 + cholesky::size(q);
        let mut m = [0.0; MOST_FACTORS * (MOST_FACTORS + 1) / 2];
        for j in 0..q {
            m[cholesky::at(j, j)] = 1.0;
        }
        for b in (0..self.blocks.len()).filter(|&b| seen[b]) {
            let place = (c / LANES * self.blocks.len() + b) * length + 1;
            for (m, sum) in m.iter_mut().zip(&self.sums[place..place + length - 1]) {
                *m += sum[c % LANES];
            }
        }
        cholesky::factor(&mut m, q);
        cholesky::invert(&m, q, out, &mut [0.0; MOST_FACTORS]);
    }
}

/// What is known of a moment.
#[derive(Clone, Copy)]
struct Known<'a> {
    blocks: &'a [Range<usize>],
    x: &'a [f64],
    seen: &'a [bool],
}

/// ln p_c(x_O) of neighbouring components, and E\[z\] into `places`.
#[multiversion(targets("x86_64+avx2"))]
fn weigh(q: usize, parameters: (&[Lane], &[Lane]), known: Known<'_>, places: &mut [Lane]) -> Lane {
    match q {
        1 => weigh_by::<1>(parameters, known, places),
        2 => weigh_by::<2>(parameters, known, places),
        3 => weigh_by::<3>(parameters, known, places),
        4 => weigh_by::<4>(parameters, known, places),
        5 => weigh_by::<5>(parameters, known, places),
        6 => weigh_by::<6>(parameters, known, places),
        7 => weigh_by::<7>(parameters, known, places),
        _ => weigh_by::<8>(parameters, known, places),
    }
}

/// Sums over what is known.
struct Sums<const Q: usize> {
    /// Σ (x − μ)²/ψ + Σ ln 2πψ.
    distance: Lane,
    h: [Lane; Q],
    m: [[Lane; Q]; Q],
}

#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> Lane {
    std::array::from_fn(f)
}

#[inline(always)]
fn add_up<const Q: usize>((rows, sums): (&[Lane], &[Lane]), known: Known<'_>) -> Sums<Q> {
    let (mut distance, mut h, mut m) = ([0.0; LANES], [[0.0; LANES]; Q], [[[0.0; LANES]; Q]; Q]);
    for (j, row) in m.iter_mut().enumerate() {
        row[j] = [1.0; LANES];
    }
    let length = 1 + Q * (Q + 1) / 2;
    for (b, block) in known.blocks.iter().enumerate().filter(|(b, _)| known.seen[*b]) {
        let block_rows = &rows[block.start * (2 + Q)..block.end * (2 + Q)];
        for (row, &x) in block_rows.chunks_exact(2 + Q).zip(&known.x[block.clone()]) {
            let error = each(|l| x - row[0][l]);
            let scaled = each(|l| error[l] * row[1][l]);
            distance = each(|l| distance[l] + error[l] * scaled[l]);
            for j in 0..Q {
                h[j] = each(|l| h[j][l] + row[2 + j][l] * scaled[l]);
            }
        }
        let block_sums = &sums[b * length..(b + 1) * length];
        distance = each(|l| distance[l] + block_sums[0][l]);
        for j in 0..Q {
            for k in 0..=j {
                let sum = block_sums[1 + j * (j + 1) / 2 + k];
                m[j][k] = each(|l| m[j][k][l] + sum[l]);
            }
        }
    }
    Sums { distance, h, m }
}

#[inline(always)]
fn weigh_by<const Q: usize>(parameters: (&[Lane], &[Lane]), known: Known<'_>, places: &mut [Lane]) -> Lane {
    let Sums { distance, h: mut u, mut m } = add_up::<Q>(parameters, known);
    let (mut determinant, mut explained) = ([1.0; LANES], [0.0; LANES]);
    // Cholesky, and u = L⁻¹ h on the way; the diagonal of `m` holds 1/L afterwards. M ≥ I, so no pivot is below 1 but
    // for rounding.
    for j in 0..Q {
        for k in 0..j {
            for i in 0..k {
                m[j][k] = each(|l| m[j][k][l] - m[j][i][l] * m[k][i][l]);
            }
            m[j][k] = each(|l| m[j][k][l] * m[k][k][l]);
            u[j] = each(|l| u[j][l] - m[j][k][l] * u[k][l]);
        }
        let pivot = each(|l| {
            let known: f64 = (0..j).map(|i| m[j][i][l] * m[j][i][l]).sum();
            f64::max(m[j][j][l] - known, 1e-9)
        });
        determinant = each(|l| determinant[l] * pivot[l]);
        m[j][j] = each(|l| 1.0 / pivot[l].sqrt());
        u[j] = each(|l| u[j][l] * m[j][j][l]);
        explained = each(|l| explained[l] + u[j][l] * u[j][l]);
    }
    for j in (0..Q).rev() {
        for k in j + 1..Q {
            u[j] = each(|l| u[j][l] - m[k][j][l] * u[k][l]);
        }
        u[j] = each(|l| u[j][l] * m[j][j][l]);
    }
    places.copy_from_slice(&u);
    each(|l| -0.5 * (distance[l] - explained[l] + num::ln(determinant[l])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two features, one direction: covariance ΛΛᵀ + Ψ.
    fn plane(weight: f64, means: [f64; 2], loadings: [f64; 2]) -> Component {
        Component { weight, means: means.to_vec(), noises: vec![0.5, 0.25], loadings: loadings.to_vec() }
    }

    fn mixture() -> Density {
        let components = [plane(0.3, [0.0, 1.0], [1.0, 0.5]), plane(0.7, [2.0, -1.0], [0.5, -1.0])];
        Density::new(vec![0..1, 1..2], 1, &components)
    }

    fn normal(x: f64, mean: f64, variance: f64) -> f64 {
        num::exp(-0.5 * (x - mean) * (x - mean) / variance) / (2.0 * std::f64::consts::PI * variance).sqrt()
    }

    /// E\[second | first\] from the mixture.
    fn conditional(density: &Density, x: f64) -> (f64, Belief) {
        let mut belief = density.belief();
        density.infer(&[x, f64::NAN], &[true, false], &mut belief);
        let mean = belief.active.iter().map(|&(c, share)| share * density.expected((c, 1), &belief)).sum();
        (mean, belief)
    }

    #[test]
    fn conditional_means_are_those_computed_by_hand() {
        for x in [-1.0, 0.4, 1.7] {
            // Σ₁₁ = λ₁² + ψ₁, Σ₂₁ = λ₂λ₁: regressions 1 + 0.5/1.5 (x − 0) and −1 − 0.5/0.75 (x − 2).
            let (a, b) = (0.3 * normal(x, 0.0, 1.5), 0.7 * normal(x, 2.0, 0.75));
            let (first, second) = (1.0 + x / 3.0, -1.0 - (x - 2.0) / 1.5);
            let expected = (a * first + b * second) / (a + b);
            let (mean, belief) = conditional(&mixture(), x);
            assert!((mean - expected).abs() < 1e-9, "{mean} for {expected}");
            assert!((num::exp(belief.log_density) - (a + b)).abs() < 1e-9);
        }
    }

    #[test]
    fn leaving_a_feature_out_is_integrating_over_it() {
        let (density, x) = (mixture(), 0.8);
        let mut belief = density.belief();
        let (step, mut mass, mut moment) = (0.01, 0.0, 0.0);
        for i in -1200..1200 {
            let y = f64::from(i) * step;
            density.infer(&[x, y], &[true, true], &mut belief);
            let p = num::exp(belief.log_density) * step;
            mass += p;
            moment += p * y;
        }
        let (mean, marginal) = conditional(&density, x);
        assert!((mass - num::exp(marginal.log_density)).abs() < 1e-6);
        assert!((moment / mass - mean).abs() < 1e-6, "{} for {mean}", moment / mass);
    }

    #[test]
    fn what_is_missing_is_not_zero() {
        let density = mixture();
        let (mut missing, mut zero) = (density.belief(), density.belief());
        density.infer(&[0.0, 0.0], &[false, false], &mut missing);
        density.infer(&[0.0, 0.0], &[true, false], &mut zero);
        assert!(missing.active.iter().any(|&(c, share)| c == 0 && (share - 0.3).abs() < 1e-12));
        assert!(zero.active.iter().any(|&(c, share)| c == 0 && share > 0.5), "{:?}", zero.active);
        let prior: f64 = missing.active.iter().map(|&(c, r)| r * density.expected((c, 1), &missing)).sum();
        assert!((prior - (0.3 - 0.7)).abs() < 1e-12);
    }

    #[test]
    fn components_come_back_as_they_went_in_and_targets_take_any_unit() {
        let mut density = mixture();
        let component = density.component(1);
        assert!((component.noises[1] - 0.25).abs() < 1e-12 && component.loadings == [0.5, -1.0]);
        let before = conditional(&density, 0.4).0;
        density.scale_targets(3.0);
        let (after, belief) = conditional(&density, 0.4);
        assert!((after - 3.0 * before).abs() < 1e-9);
        let mut spread = [0.0];
        density.spread(0, &[true, false], &mut spread);
        assert!((spread[0] - 1.0 / 3.0).abs() < 1e-12, "1/(1 + λ²/ψ) with what is known: {spread:?}");
        assert!(belief.active.len() == 2);
    }
}
