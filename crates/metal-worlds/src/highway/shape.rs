//! The shape of a road: a closed, irregular, smooth curve drawn from a seed, redrawn until a car can drive it and it
//! is not an egg.

use metal_rl::num;
use metal_rl::random::{Rng, Streams};
use std::f64::consts::PI;

/// Points at which a curve is examined, per knot.
const POINTS_PER_KNOT: usize = 128;
/// Points farther apart than this along the road count as different stretches, in metres.
const STRETCH_M: f64 = 0.7;

/// The family of shapes a road is drawn from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeRange {
    /// Fewest and most knots of the spline.
    pub knots: (usize, usize),
    /// Least distance of a knot from the middle, as a share of the largest, which is 1.
    pub inmost: f64,
    /// Shift of a knot around the middle, as a share of the distance between knots.
    pub shift: f64,
    /// Length of the centre line, in metres.
    pub length_m: f64,
    /// Smallest radius of curvature of the centre line, in metres.
    pub min_radius_m: f64,
    /// The road bends at least this sharply against its own sense of rotation somewhere, in 1/m: it is irregular, and
    /// a driver meets bends to either side.
    pub min_counter_bend: f64,
    /// Smallest distance between two stretches of the centre line, in metres.
    pub min_clearance_m: f64,
}

impl ShapeRange {
    /// Roads for learning: about 6 m, bends of at least 0.3 m to either side.
    pub const TRAINING: Self = Self {
        knots: (8, 10),
        inmost: 0.35,
        shift: 0.30,
        length_m: 6.0,
        min_radius_m: 0.30,
        min_counter_bend: 0.8,
        min_clearance_m: 0.42,
    };
    /// Roads for the final test, visibly other shapes: longer, with more and sharper bends.
    pub const TEST: Self = Self {
        knots: (11, 14),
        inmost: 0.30,
        shift: 0.30,
        length_m: 7.5,
        min_radius_m: 0.25,
        min_counter_bend: 1.6,
        min_clearance_m: 0.42,
    };
}

/// One point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub x: f64,
    pub y: f64,
    pub tangent_rad: f64,
    pub curvature: f64,
}

/// A uniform periodic cubic B-spline: continuous up to its curvature, so that no steering angle ever jumps.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    knots: Vec<[f64; 2]>,
}

impl Curve {
    /// The first valid shape of `seed`: invalid ones are rejected and redrawn from the same stream.
    pub(super) fn draw(seed: u64, range: &ShapeRange) -> Self {
        let mut rng = Streams::new(seed).child("road").stream("shape");
        loop {
            let curve = Self::attempt(&mut rng, range);
            if curve.is_valid(range) {
                return curve;
            }
        }
    }

    fn attempt(rng: &mut Rng, range: &ShapeRange) -> Self {
        let count = range.knots.0 + rng.below(range.knots.1 - range.knots.0 + 1);
        let knots = (0..count)
            .map(|i| {
                let shift = rng.range(-range.shift, range.shift);
                let (sin, cos) = num::sin_cos(2.0 * PI * (i as f64 + shift) / count as f64);
                let radius = rng.range(range.inmost, 1.0);
                [radius * cos, radius * sin]
            })
            .collect();
        let mut curve = Self { knots };
        let scale = range.length_m / curve.length_m();
        curve.knots.iter_mut().flatten().for_each(|v| *v *= scale);
        curve
    }

    /// The point at parameter `u` in [0, period).
    pub(super) fn at(&self, u: f64) -> Point {
        let n = self.knots.len();
        let i = (u.floor() as usize) % n;
        let t = u - u.floor();
        let s = 1.0 - t;
        let value =
            [s * s * s, 3.0 * t * t * t - 6.0 * t * t + 4.0, 3.0 * s * s * s - 6.0 * s * s + 4.0, t * t * t];
        let slope = [-s * s, 3.0 * t * t - 4.0 * t, -3.0 * s * s + 4.0 * s, t * t];
        let bend = [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t];
        let sum = |w: &[f64; 4], axis: usize| -> f64 {
            w.iter().enumerate().map(|(k, w)| w * self.knots[(i + k) % n][axis]).sum()
        };
        let (dx, dy) = (0.5 * sum(&slope, 0), 0.5 * sum(&slope, 1));
        let speed2 = dx * dx + dy * dy;
        Point {
            x: sum(&value, 0) / 6.0,
            y: sum(&value, 1) / 6.0,
            tangent_rad: num::atan2(dy, dx),
            curvature: (dx * sum(&bend, 1) - dy * sum(&bend, 0)) / (speed2 * speed2.sqrt()),
        }
    }

    /// Parameters at a fine, even grid with the length run until each; the last entry closes the loop.
    pub(super) fn lengths(&self) -> Vec<(f64, f64)> {
        let n = self.knots.len() * POINTS_PER_KNOT;
        let mut run = 0.0;
        let mut last = self.at(0.0);
        let mut table = vec![(0.0, 0.0)];
        for k in 1..=n {
            let u = k as f64 / POINTS_PER_KNOT as f64;
            let point = self.at(u);
            run += num::hypot(point.x - last.x, point.y - last.y);
            table.push((u, run));
            last = point;
        }
        table
    }

    fn length_m(&self) -> f64 {
        self.lengths().last().map_or(0.0, |&(_, run)| run)
    }

    /// Whether a car can drive the road (no bend too sharp, no two stretches too close) and meets bends to either side.
    fn is_valid(&self, range: &ShapeRange) -> bool {
        let table = self.lengths();
        let points: Vec<(Point, f64)> = table.iter().step_by(8).map(|&(u, run)| (self.at(u), run)).collect();
        let bends = || table.iter().map(|&(u, _)| self.at(u).curvature);
        bends().all(|bend| bend.abs() * range.min_radius_m <= 1.0)
            && bends().any(|bend| bend <= -range.min_counter_bend)
            && keeps_clear(&points, range)
    }
}

/// Whether any two stretches of the polyline keep the clearance of `range`.
fn keeps_clear(points: &[(Point, f64)], range: &ShapeRange) -> bool {
    points.iter().enumerate().all(|(i, (a, run_a))| {
        points[i + 1..].iter().all(|(b, run_b)| {
            let apart = (run_b - run_a).min(range.length_m - (run_b - run_a));
            let (dx, dy) = (b.x - a.x, b.y - a.y);
            apart < STRETCH_M || dx * dx + dy * dy >= range.min_clearance_m * range.min_clearance_m
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_can_be_driven_and_is_redrawn_alike() {
        for range in [ShapeRange::TRAINING, ShapeRange::TEST] {
            for seed in 0..150 {
                let curve = Curve::draw(seed, &range);
                assert!((curve.length_m() - range.length_m).abs() < 1e-9, "seed {seed}");
                let sharpest = (0..4000)
                    .map(|k| curve.at(curve.knots.len() as f64 * f64::from(k) / 4000.0).curvature.abs())
                    .fold(0.0, f64::max);
                assert!(sharpest <= 1.002 / range.min_radius_m, "seed {seed}: {sharpest}");
                if seed < 5 {
                    assert_eq!(curve, Curve::draw(seed, &range));
                }
            }
        }
    }

    #[test]
    fn curvature_and_tangent_agree_with_differences() {
        let curve = Curve::draw(4, &ShapeRange::TRAINING);
        for k in 0..200 {
            let u = curve.knots.len() as f64 * f64::from(k) / 200.0;
            let (a, b) = (curve.at(u), curve.at(u + 1e-5));
            let step = num::hypot(b.x - a.x, b.y - a.y);
            let turn = num::wrap_angle(b.tangent_rad - a.tangent_rad);
            assert!((turn / step - a.curvature).abs() < 1e-2);
            assert!(num::wrap_angle(num::atan2(b.y - a.y, b.x - a.x) - a.tangent_rad).abs() < 1e-3);
        }
    }
}
