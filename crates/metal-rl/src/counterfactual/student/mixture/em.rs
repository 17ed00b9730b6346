//! Expectation and maximisation: the density that makes the moments seen most likely, with what was not seen left out.

use super::density::{Belief, Component, Density};
use crate::num::cholesky;

/// Moments, row by row; what is unknown is never looked at.
#[derive(Clone, Debug, Default)]
pub(super) struct Moments {
    /// Moments × features.
    pub features: Vec<f64>,
    /// Moments × blocks.
    pub seen: Vec<bool>,
    /// Number of moments.
    pub count: usize,
}

impl Moments {
    /// The features and the known blocks of moment `n`.
    pub fn row(&self, n: usize) -> (&[f64], &[bool]) {
        let (width, blocks) = (self.features.len() / self.count, self.seen.len() / self.count);
        (&self.features[n * width..(n + 1) * width], &self.seen[n * blocks..(n + 1) * blocks])
    }
}

/// What features are like in all moments together, and how much that counts.
#[derive(Clone, Debug)]
pub(super) struct Prior {
    /// Mean by feature.
    pub means: Vec<f64>,
    /// Variance by feature.
    pub variances: Vec<f64>,
    /// Least variance of noise, as a share of that.
    pub least: f64,
    /// Observations that it counts for.
    pub count: f64,
}

impl Prior {
    /// What features are like in these moments. A feature that never changes is given a spread of a thousandth.
    pub fn of(moments: &Moments, density_blocks: &[std::ops::Range<usize>], least: f64, count: f64) -> Self {
        let width = density_blocks.last().map_or(0, |block| block.end);
        let (mut sums, mut squares, mut counts) = (vec![0.0; width], vec![0.0; width], vec![0.0; width]);
        for n in 0..moments.count {
            let (x, seen) = moments.row(n);
            for i in density_blocks.iter().zip(seen).filter(|(_, s)| **s).flat_map(|(block, _)| block.clone())
            {
                sums[i] += x[i];
                squares[i] += x[i] * x[i];
                counts[i] += 1.0;
            }
        }
        let mean = |i: usize| sums[i] / f64::max(counts[i], 1.0);
        let variance = |i: usize| (squares[i] / f64::max(counts[i], 1.0) - mean(i) * mean(i)).max(1e-6);
        Self {
            means: (0..width).map(mean).collect(),
            variances: (0..width).map(variance).collect(),
            least,
            count,
        }
    }
}

/// Sums over moments, weighted by the share that one component has in them.
#[derive(Clone, Debug)]
struct Share {
    mass: f64,
    /// Blocks × lower triangle of Σ r E\[(1, z)(1, z)ᵀ\].
    places: Vec<f64>,
    /// Features × Σ r x E\[(1, z)\].
    products: Vec<f64>,
    /// Features: Σ r x².
    squares: Vec<f64>,
}

impl Share {
    fn new(density: &Density) -> Self {
        let rows = 1 + density.factors();
        Self {
            mass: 0.0,
            places: vec![0.0; density.blocks().len() * cholesky::size(rows)],
            products: vec![0.0; density.width() * rows],
            squares: vec![0.0; density.width()],
        }
    }

    /// Adds a moment of which the component has the share `r`; `place` is E\[(1, z)\], `second` E\[(1, z)(1, z)ᵀ\].
    fn add(
        &mut self,
        blocks: &[std::ops::Range<usize>],
        moment: (&[f64], &[bool]),
        (r, place, second): (f64, &[f64], &[f64]),
    ) {
        let (rows, (x, seen)) = (place.len(), moment);
        self.mass += r;
        for (b, block) in blocks.iter().enumerate().filter(|(b, _)| seen[*b]) {
            let sums = &mut self.places[b * second.len()..(b + 1) * second.len()];
            sums.iter_mut().zip(second).for_each(|(sum, s)| *sum += r * s);
            for i in block.clone() {
                self.squares[i] += r * x[i] * x[i];
                let products = &mut self.products[i * rows..(i + 1) * rows];
                products.iter_mut().zip(place).for_each(|(sum, p)| *sum += r * x[i] * p);
            }
        }
    }

    /// The component that fits best, with the prior's observations at z = 0 around the common mean, and as many that
    /// draw directions towards none.
    fn component(&self, density: &Density, prior: &Prior, weight: f64) -> Component {
        let (q, rows, width) = (density.factors(), 1 + density.factors(), density.width());
        let (mut means, mut noises, mut loadings) =
            (vec![0.0; width], vec![0.0; width], vec![0.0; width * q]);
        let size = cholesky::size(rows);
        for (b, block) in density.blocks().iter().enumerate() {
            let mut factor = self.places[b * size..(b + 1) * size].to_vec();
            let count = factor[0] + prior.count;
            for j in 0..rows {
                factor[cholesky::at(j, j)] += prior.count;
            }
            cholesky::factor(&mut factor, rows);
            for i in block.clone() {
                let mut products = self.products[i * rows..(i + 1) * rows].to_vec();
                products[0] += prior.count * prior.means[i];
                let mut fitted = products.clone();
                cholesky::solve(&factor, rows, &mut fitted);
                let explained: f64 = fitted.iter().zip(&products).map(|(f, p)| f * p).sum();
                let (mean, variance) = (prior.means[i], prior.variances[i]);
                let squares = self.squares[i] + prior.count * (mean * mean + variance);
                means[i] = fitted[0];
                noises[i] = ((squares - explained) / count).max(prior.least * variance);
                loadings[i * q..(i + 1) * q].copy_from_slice(&fitted[1..]);
            }
        }
        Component { weight, means, noises, loadings }
    }
}

/// One round on all moments; returns the mean log density before it, and the mass of every component.
pub(super) fn sweep(density: &mut Density, moments: &Moments, prior: &Prior) -> (f64, Vec<f64>) {
    let (q, k) = (density.factors(), density.components());
    let mut shares = vec![Share::new(density); k];
    let (mut belief, mut spread) = (Belief::default(), vec![0.0; cholesky::size(q)]);
    let (mut place, mut second) = (vec![1.0; 1 + q], vec![0.0; cholesky::size(1 + q)]);
    let mut likelihood = 0.0;
    for n in 0..moments.count {
        let (x, seen) = moments.row(n);
        density.infer(x, seen, &mut belief);
        likelihood += belief.log_density;
        for &(c, r) in &belief.active {
            density.spread(c, seen, &mut spread);
            second_moment((c, &belief), &spread, &mut place, &mut second);
            shares[c].add(density.blocks(), (x, seen), (r, &place, &second));
        }
    }
    let all = moments.count as f64 + k as f64;
    for (c, share) in shares.iter().enumerate() {
        let component = share.component(density, prior, (share.mass + 1.0) / all);
        density.set(c, &component);
    }
    (likelihood / moments.count.max(1) as f64, shares.iter().map(|share| share.mass).collect())
}

/// E\[(1, z)\] and E\[(1, z)(1, z)ᵀ\] in component `c`, given the covariance of z.
fn second_moment((c, belief): (usize, &Belief), spread: &[f64], place: &mut [f64], second: &mut [f64]) {
    let q = place.len() - 1;
    for j in 0..q {
        place[1 + j] = belief.place(c, j, q);
    }
    for i in 0..=q {
        for j in 0..=i {
            let extra = if j > 0 { spread[cholesky::at(i - 1, j - 1)] } else { 0.0 };
            second[cholesky::at(i, j)] = place[i] * place[j] + extra;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::start::start;
    use super::*;
    use crate::random::Rng;

    /// Two clouds in three dimensions, the second block missing in every third moment.
    pub(super) fn clouds(count: usize) -> Moments {
        let mut rng = Rng::new(8);
        let mut moments = Moments { count, ..Moments::default() };
        for n in 0..count {
            let (side, slope) = if n % 2 == 0 { (-6.0, 0.8) } else { (6.0, -0.5) };
            let first = side + rng.normal();
            let second = slope * (first - side) + 0.3 * rng.normal();
            moments.features.extend([first, second, second + first + 0.1 * rng.normal()]);
            moments.seen.extend([true, n % 3 != 0]);
        }
        moments
    }

    #[test]
    fn every_round_makes_the_moments_likelier() {
        let (moments, blocks) = (clouds(600), vec![0..1, 1..3]);
        let prior = Prior::of(&moments, &blocks, 1e-4, 1e-6);
        let mut density = start((blocks, 1, 2), &moments, &prior, &mut Rng::new(3));
        let likelihoods: Vec<f64> = (0..60).map(|_| sweep(&mut density, &moments, &prior).0).collect();
        let rises = likelihoods.windows(2).all(|pair| pair[1] > pair[0] - 1e-6);
        assert!(rises && likelihoods[59] > likelihoods[0] + 0.3, "{likelihoods:?}");
        // Given the first feature of the left cloud, the second follows its slope.
        let mut belief = density.belief();
        let mut mean = |x: f64| {
            density.infer(&[x, 0.0, 0.0], &[true, false], &mut belief);
            belief.active.iter().map(|&(c, r)| r * density.expected((c, 1), &belief)).sum::<f64>()
        };
        assert!((mean(-6.5) - mean(-7.5) - 0.8).abs() < 0.15, "{} {}", mean(-6.5), mean(-7.5));
        assert!((mean(6.5) - mean(5.5) + 0.5).abs() < 0.15);
    }

    #[test]
    fn a_component_without_moments_is_what_all_are_like() {
        let (moments, blocks) = (clouds(50), vec![0..1, 1..3]);
        let prior = Prior::of(&moments, &blocks, 1e-2, 4.0);
        let density = start((blocks, 1, 2), &moments, &prior, &mut Rng::new(3));
        let lonely = Share::new(&density).component(&density, &prior, 0.0);
        assert!((lonely.means[1] - prior.means[1]).abs() < 1e-9 && lonely.loadings == [0.0; 3]);
        assert!(lonely.noises.iter().all(|&noise| noise > 0.0));
    }
}
