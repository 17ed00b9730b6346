//! What all components of one action say about one state: the inner loop of the mixtures.
//!
//! Compiled once for any processor and once for 256-bit vectors with fused multiply-add. Each lane adds its own terms in the
//! order of the groups, and the lanes are added at the end in one fixed order, so both give the same bits.

use super::frame::Frame;
use super::gaussians::{LANES, Lane};
use super::mixture::{Facts, Mixture, NEGLIGIBLE};
use crate::num;
use multiversion::multiversion;
use std::ops::Range;

/// Groups whose log densities are worked out before any of them is added: nothing in that loop depends on what was found
/// before, so that the processor need not guess. Most mixtures are one block.
const BLOCK: usize = 16;

/// Space for what is worked out of a block.
pub(super) const NO_BLOCK: [Lane; BLOCK] = [[0.0; LANES]; BLOCK];

/// All groups of a mixture, a block at a time.
#[inline(always)]
pub(super) fn blocks(mixture: &Mixture) -> impl Iterator<Item = Range<usize>> + use<> {
    let groups = mixture.gaussians.groups();
    (0..groups).step_by(BLOCK).map(move |start| start..groups.min(start + BLOCK))
}

/// What lies this far below a reference is 0: e to this power is still a number of full precision.
const FARTHEST: f64 = -700.0;

/// Sums over the components of one action for one state, all times exp(−reference).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scan {
    pub reference: f64,
    mass: f64,
    value: f64,
    success: f64,
}

impl Scan {
    /// Q(s, a).
    pub fn value(&self) -> f64 {
        self.value / self.mass
    }

    /// Density of states in which the action was tried, times its prior, and of those in which it succeeded, both times
    /// exp(−reference).
    pub fn masses(&self) -> [f64; 2] {
        [self.mass, self.success]
    }

    /// Responsibility of a component of this weight and log density.
    pub fn responsibility(&self, weight: f64, l: f64) -> f64 {
        weight * num::exp(l - self.reference) / self.mass
    }

    /// Responsibility of the background.
    pub fn background_share(&self, frame: &Frame) -> f64 {
        self.responsibility(frame.background_mass, 0.0)
    }
}

/// The sums of a [`Scan`] before the lanes are added.
struct Tally {
    reference: f64,
    mass: Lane,
    value: Lane,
    success: Lane,
}

impl Tally {
    /// The background alone, in the first lane: uniform density 1, so its log density is 0.
    #[inline(always)]
    fn background(frame: &Frame) -> Self {
        let first = |x: f64| std::array::from_fn(|lane| if lane == 0 { x } else { 0.0 });
        let n0 = frame.background_mass;
        Self {
            reference: 0.0,
            mass: first(n0),
            value: first(n0 * frame.background_value),
            success: first(n0),
        }
    }

    /// Takes in groups with log densities `logs`, which are used up.
    #[inline(always)]
    fn absorb(&mut self, frame: &Frame, logs: &mut [Lane], facts: &[Facts]) {
        let top = highest(logs);
        if top > self.reference {
            self.refer_to(top);
        }
        to_densities(logs, self.reference);
        let (mut mass, mut value, mut success) = (self.mass, self.value, self.success);
        for (e, facts) in logs.iter().zip(facts) {
            let mut part = [0.0; LANES];
            for lane in 0..LANES {
                part[lane] = facts.weight(frame, lane) * e[lane];
            }
            for lane in 0..LANES {
                mass[lane] += part[lane];
            }
            for lane in 0..LANES {
                value[lane] = num::fused(part[lane], facts.value[lane], value[lane]);
            }
            for lane in 0..LANES {
                success[lane] = num::fused(facts.success[lane], e[lane], success[lane]);
            }
        }
        (self.mass, self.value, self.success) = (mass, value, success);
    }

    /// Raises the reference.
    #[inline(always)]
    fn refer_to(&mut self, top: f64) {
        let below = self.reference - top;
        let factor = if below > FARTHEST { num::exp_of_negative(below) } else { 0.0 };
        for lane in 0..LANES {
            self.mass[lane] *= factor;
            self.value[lane] *= factor;
            self.success[lane] *= factor;
        }
        self.reference = top;
    }

    fn total(&self) -> Scan {
        let [mass, value, success] = [&self.mass, &self.value, &self.success].map(sum);
        Scan { reference: self.reference, mass, value, success }
    }
}

/// Everything about one state in one pass.
pub(super) fn scan(mixture: &Mixture, frame: &Frame, s: &[f64]) -> Scan {
    let mut space = NO_BLOCK;
    tally(mixture, frame, s, &mut space).total()
}

/// Everything that each of several mixtures says about one state; `tell` is told the number of the first of some, and of them.
pub(super) fn scan_each(
    mixtures: &[Mixture],
    frame: &Frame,
    s: &[f64],
    mut tell: impl FnMut(usize, &[Scan]),
) {
    let mut scans = [Tally::background(frame).total(); LANES];
    let mut space = NO_BLOCK;
    for (some, mixtures) in mixtures.chunks(LANES).enumerate() {
        for (scan, mixture) in scans.iter_mut().zip(mixtures) {
            *scan = tally(mixture, frame, s, &mut space).total();
        }
        tell(some * LANES, &scans[..mixtures.len()]);
    }
}

/// The sums of every lane. Lanes are added outside of it, because compilers that see that addition pair lanes by it all the way
/// back into the loops.
#[multiversion(targets("x86_64+avx2+fma"))]
fn tally(mixture: &Mixture, frame: &Frame, s: &[f64], space: &mut [Lane; BLOCK]) -> Tally {
    tally_inlined(mixture, frame, s, space)
}

#[inline(always)]
fn tally_inlined(mixture: &Mixture, frame: &Frame, s: &[f64], space: &mut [Lane; BLOCK]) -> Tally {
    let mut tally = Tally::background(frame);
    for block in blocks(mixture) {
        let logs = &mut space[..block.len()];
        mixture.gaussians.distances_of(block.clone(), s, logs);
        mixture.to_log_densities(frame, block.clone(), logs);
        tally.absorb(frame, logs, &mixture.facts[block]);
    }
    tally
}

/// Log densities of some groups.
#[multiversion(targets("x86_64+avx2+fma"))]
pub(super) fn log_densities(of: (&Mixture, &Frame, &[f64]), groups: Range<usize>, logs: &mut [Lane]) {
    let (mixture, frame, s) = of;
    mixture.gaussians.distances_of(groups.clone(), s, logs);
    mixture.to_log_densities(frame, groups, logs);
}

/// What a state that is being learned is to every component.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kept {
    /// Squared distances.
    pub distances: Vec<Lane>,
    /// Log densities, which become [`responsibilities`].
    pub shares: Vec<Lane>,
}

/// As [`scan`], and keeps distances and log densities.
pub(super) fn scan_and_keep(mixture: &Mixture, frame: &Frame, s: &[f64], kept: &mut Kept) -> Scan {
    tally_and_keep(mixture, frame, s, kept).total()
}

#[multiversion(targets("x86_64+avx2+fma"))]
fn tally_and_keep(mixture: &Mixture, frame: &Frame, s: &[f64], kept: &mut Kept) -> Tally {
    let groups = mixture.gaussians.groups();
    kept.distances.resize(groups, [0.0; LANES]);
    kept.shares.resize(groups, [0.0; LANES]);
    let mut tally = Tally::background(frame);
    let mut space = NO_BLOCK;
    for block in blocks(mixture) {
        let (distances, logs) = (&mut kept.distances[block.clone()], &mut kept.shares[block.clone()]);
        mixture.gaussians.distances_of(block.clone(), s, distances);
        logs.copy_from_slice(distances);
        mixture.to_log_densities(frame, block.clone(), logs);
        let space = &mut space[..block.len()];
        space.copy_from_slice(logs);
        tally.absorb(frame, space, &mixture.facts[block]);
    }
    tally
}

/// Log densities become responsibilities; `scan` is that of their state.
#[multiversion(targets("x86_64+avx2+fma"))]
pub(super) fn responsibilities(of: (&Mixture, &Frame), scan: &Scan, shares: &mut [Lane]) {
    let (mixture, frame) = of;
    to_densities(shares, scan.reference);
    for (rho, facts) in shares.iter_mut().zip(&mixture.facts) {
        for (lane, rho) in rho.iter_mut().enumerate() {
            *rho *= facts.weight(frame, lane) / scan.mass;
        }
    }
}

/// l becomes exp(l − reference), 0 where that is negligible or not a number; no l exceeds the reference.
#[inline(always)]
fn to_densities(logs: &mut [Lane], reference: f64) {
    let (many, rest) = logs.as_flattened_mut().as_chunks_mut::<{ 3 * LANES }>();
    // No closures: they are compiled for any processor.
    for logs in many {
        some_to_densities(logs, reference);
    }
    let (few, _) = rest.as_chunks_mut::<LANES>();
    for logs in few {
        some_to_densities(logs, reference);
    }
}

#[inline(always)]
fn some_to_densities<const N: usize>(logs: &mut [f64; N], reference: f64) {
    let mut x = *logs;
    for x in &mut x {
        *x -= reference;
    }
    let powers = num::exp_of_negatives(&x);
    for ((l, x), power) in logs.iter_mut().zip(x).zip(powers) {
        *l = if x > NEGLIGIBLE { power } else { 0.0 };
    }
}

/// Largest number of some groups that is one.
#[inline(always)]
fn highest(logs: &[Lane]) -> f64 {
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let mut best = [f64::NEG_INFINITY; LANES];
    for l in logs {
        for lane in 0..LANES {
            best[lane] = larger(best[lane], l[lane]);
        }
    }
    // Halves upon halves: three steps, where one after the other would be eight.
    for half in [4, 2, 1] {
        for lane in 0..half {
            best[lane] = larger(best[lane], best[lane + half]);
        }
    }
    best[0]
}

/// Sum of a group.
#[inline(always)]
fn sum(x: &Lane) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}

#[cfg(test)]
mod tests {
    use super::super::frame::Shape;
    use super::*;
    use crate::random::Rng;

    /// [`to_densities`] compiled for wide vectors where the processor has them.
    #[multiversion(targets("x86_64+avx2+fma"))]
    fn wide(logs: &mut [Lane], reference: f64) {
        to_densities(logs, reference);
    }

    #[test]
    fn every_lane_has_the_bits_of_the_scalar() {
        let mut rng = Rng::new(3);
        for _ in 0..50_000 {
            let l: Lane = std::array::from_fn(|_| rng.range(-60.0, 20.0));
            let mut e = [l];
            let top = highest(&e);
            assert_eq!(top, num::max(&l));
            wide(&mut e, top);
            for (l, e) in l.into_iter().zip(e[0]) {
                let x = l - top;
                let alone = if x > NEGLIGIBLE { num::exp_of_negative(std::hint::black_box(x)) } else { 0.0 };
                assert_eq!(e.to_bits(), alone.to_bits(), "{x}");
            }
        }
    }

    /// More Gaussians than two blocks hold, scattered over three dimensions.
    fn scattered(full: bool, rng: &mut Rng) -> (Frame, Mixture) {
        let (first_width, smallest_width, shape) = (0.1, 0.01, Shape::Resp { least: 0.1 });
        let frame = Frame {
            dims: 3,
            full,
            first_width,
            smallest_width,
            most_mass: 5.0,
            background_mass: 0.5,
            background_value: -1.0,
            prior_count: 1.0,
            shape,
            sharpness: 0.8,
            gate: 9.0,
            cap: 1000,
            prune_age: 1e3,
            prune_mass: 1e-3,
        };
        let mut mixture = Mixture::new(&frame);
        for _ in 0..2 * BLOCK * LANES + 3 {
            let mean: [f64; 3] = std::array::from_fn(|_| rng.uniform());
            mixture.gaussians.push(&mean, |_| first_width);
        }
        mixture.facts.resize_with(mixture.gaussians.groups(), Facts::default);
        for facts in &mut mixture.facts {
            for lane in [&mut facts.mass, &mut facts.success, &mut facts.value] {
                *lane = std::array::from_fn(|_| rng.range(0.1, 9.0));
            }
        }
        (frame, mixture)
    }

    /// Q(s, a) and the logarithms of both masses, one component after the other.
    fn plainly(frame: &Frame, mixture: &Mixture, s: &[f64]) -> [f64; 3] {
        let n0 = frame.background_mass;
        let (mut mass, mut value, mut success) = (n0, n0 * frame.background_value, n0);
        for c in 0..mixture.len() {
            let mut d2 = [[0.0; LANES]];
            mixture.gaussians.distances_of(c / LANES..c / LANES + 1, s, &mut d2);
            let facts = &mixture.facts[c / LANES];
            let density = num::exp(frame.log_density(mixture.gaussians.log_det(c), d2[0][c % LANES]));
            let part = facts.weight(frame, c % LANES) * density;
            mass += part;
            value += part * facts.value[c % LANES];
            success += facts.success[c % LANES] * density;
        }
        [value / mass, num::ln(mass), num::ln(success)]
    }

    #[test]
    fn vectors_give_the_sums_of_the_formula_and_the_same_bits_everywhere() {
        let mut rng = Rng::new(5);
        for full in [false, true] {
            let (frame, mixture) = scattered(full, &mut rng);
            let mut space = NO_BLOCK;
            for _ in 0..1000 {
                let s: [f64; 3] = std::array::from_fn(|_| rng.range(-0.2, 1.2));
                let [wide, narrow] =
                    [mixture.scan(&frame, &s), tally_inlined(&mixture, &frame, &s, &mut space).total()];
                let bits =
                    |scan: Scan| [scan.reference, scan.mass, scan.value, scan.success].map(f64::to_bits);
                assert_eq!(bits(wide), bits(narrow));
                let [mass, success] = wide.masses().map(|mass| wide.reference + num::ln(mass));
                let is = [wide.value(), mass, success];
                for (is, should) in is.into_iter().zip(plainly(&frame, &mixture, &s)) {
                    assert!((is - should).abs() < 1e-12 * should.abs().max(1.0), "{is} not {should}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_number_counts_nothing() {
        let mut e = [[f64::NAN, -1.0, f64::NEG_INFINITY, f64::NAN, -2.0, -50.0, f64::NAN, -3.0]];
        assert_eq!(highest(&e), -1.0);
        wide(&mut e, -1.0);
        let [e] = e;
        assert_eq!([e[0], e[1], e[2], e[3], e[5], e[6]], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
