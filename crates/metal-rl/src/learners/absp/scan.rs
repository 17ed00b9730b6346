//! What all components of one action say about one state: the inner loop of the mixtures.
//!
//! Compiled once for any processor and once for 256-bit vectors. Terms are worked out side by side and added one after
//! the other, in the order of the components, so both give the bits of the plain loop.

use super::frame::Frame;
use super::gaussians::{LANES, Lane};
use super::mixture::{Facts, Mixture, NEGLIGIBLE};
use crate::num;
use multiversion::multiversion;

/// Groups whose log densities are worked out before the first of them is added: nothing in that loop depends on what was
/// found before, so that the processor need not guess.
const BLOCK: usize = 16;

/// Sums over the components of one action for one state, all times exp(−reference).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scan {
    pub reference: f64,
    mass: f64,
    value: f64,
    success: f64,
}

impl Scan {
    /// The background alone: uniform density 1, so its log density is 0.
    #[inline(always)]
    fn background(frame: &Frame) -> Self {
        let n0 = frame.background_mass;
        Self { reference: 0.0, mass: n0, value: n0 * frame.background_value, success: n0 }
    }

    /// Takes in the components of a group with log densities `l`.
    #[inline(always)]
    fn absorb(&mut self, frame: &Frame, l: &Lane, facts: &Facts) {
        let top = highest(l);
        if top - self.reference <= NEGLIGIBLE {
            return;
        }
        if top > self.reference {
            let factor = num::exp(self.reference - top);
            self.mass *= factor;
            self.value *= factor;
            self.success *= factor;
            self.reference = top;
        }
        let e = densities(l, self.reference);
        let (mut mass, mut value, mut success) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            mass[lane] = facts.weight(frame, lane) * e[lane];
            value[lane] = mass[lane] * facts.value[lane];
            success[lane] = facts.success[lane] * e[lane];
        }
        self.mass = mass.iter().fold(self.mass, |sum, x| sum + x);
        self.value = value.iter().fold(self.value, |sum, x| sum + x);
        self.success = success.iter().fold(self.success, |sum, x| sum + x);
    }

    /// Q(s, a).
    pub fn value(&self) -> f64 {
        self.value / self.mass
    }

    /// ln of the density of states in which the action succeeded, times its prior.
    pub fn log_success(&self) -> f64 {
        self.reference + num::ln(self.success)
    }

    /// ln of the density of states in which the action was tried, times its prior.
    pub fn log_mass(&self) -> f64 {
        self.reference + num::ln(self.mass)
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

/// Everything about one state in one pass.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn scan(mixture: &Mixture, frame: &Frame, s: &[f64]) -> Scan {
    let mut scan = Scan::background(frame);
    let mut logs = [[0.0; LANES]; BLOCK];
    let groups = mixture.gaussians.groups();
    for start in (0..groups).step_by(BLOCK) {
        let block = start..groups.min(start + BLOCK);
        mixture.for_each_group_of(block.clone(), (frame, s), |group, l, _| logs[group - start] = *l);
        for (l, facts) in logs.iter().zip(&mixture.facts[block]) {
            scan.absorb(frame, l, facts);
        }
    }
    scan
}

/// Adds responsibilities and squared distances of all groups to `work`; `scan` is that of the state.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn responsibilities(of: (&Mixture, &Frame, &[f64]), scan: &Scan, work: &mut Vec<(Lane, Lane)>) {
    let (mixture, frame, s) = of;
    mixture.for_each_group(frame, s, |group, l, d2| {
        let mut rho = densities(l, scan.reference);
        for (lane, rho) in rho.iter_mut().enumerate() {
            *rho = mixture.facts[group].weight(frame, lane) * *rho / scan.mass;
        }
        work.push((rho, *d2));
    });
}

/// exp(l − reference), 0 where that is negligible or not a number; no l exceeds the reference.
#[inline(always)]
fn densities(l: &Lane, reference: f64) -> Lane {
    let mut e = [0.0; LANES];
    for lane in 0..LANES {
        let x = l[lane] - reference;
        let power = num::exp_of_negative(x);
        e[lane] = if x > NEGLIGIBLE { power } else { 0.0 };
    }
    e
}

/// Largest number of a group that is one.
#[inline(always)]
fn highest(l: &Lane) -> f64 {
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let mut best = [f64::NEG_INFINITY; LANES / 2];
    for lane in 0..LANES / 2 {
        best[lane] = larger(larger(best[lane], l[lane]), l[lane + LANES / 2]);
    }
    larger(larger(best[0], best[2]), larger(best[1], best[3]))
}

#[cfg(test)]
mod tests {
    use super::super::frame::Shape;
    use super::*;
    use crate::random::Rng;

    /// [`densities`] compiled for wide vectors where the processor has them.
    #[multiversion(targets("x86_64+avx2"))]
    fn wide(l: &Lane, reference: f64) -> Lane {
        densities(l, reference)
    }

    #[test]
    fn every_lane_has_the_bits_of_the_scalar() {
        let mut rng = Rng::new(3);
        for _ in 0..50_000 {
            let l: Lane = std::array::from_fn(|_| rng.range(-60.0, 20.0));
            let top = highest(&l);
            assert_eq!(top, num::max(&l));
            for (lane, e) in wide(&l, top).into_iter().enumerate() {
                let x = l[lane] - top;
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

    #[test]
    fn blocks_give_the_bits_of_one_group_after_the_other() {
        let mut rng = Rng::new(5);
        for full in [false, true] {
            let (frame, mixture) = scattered(full, &mut rng);
            for _ in 0..1000 {
                let s: [f64; 3] = std::array::from_fn(|_| rng.range(-0.2, 1.2));
                let mut plain = Scan::background(&frame);
                mixture.for_each_group(&frame, &s, |g, l, _| plain.absorb(&frame, l, &mixture.facts[g]));
                let blocks = mixture.scan(&frame, &s);
                let bits =
                    |scan: Scan| [scan.reference, scan.mass, scan.value, scan.success].map(f64::to_bits);
                assert_eq!(bits(blocks), bits(plain));
            }
        }
    }

    #[test]
    fn what_is_no_number_counts_nothing() {
        let l = [f64::NAN, -1.0, f64::NEG_INFINITY, f64::NAN, -2.0, -50.0, f64::NAN, -3.0];
        assert_eq!(highest(&l), -1.0);
        let e = wide(&l, -1.0);
        assert_eq!([e[0], e[1], e[2], e[3], e[5], e[6]], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
