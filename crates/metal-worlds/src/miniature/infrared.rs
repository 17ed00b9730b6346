//! The infra-red ring after Enki's model: other azimuths, an inverse-square law with a longer reach, additive noise.
//!
//! The law is Enki 1.6.99 as measured against a flat wall (mean by distance from the hull). A body's idle level is taken
//! out before a mind sees the reading, as the drivers of the robots do; here it is 0, so the simulator's own is added.

use crate::highway::Pose;
use crate::highway::infrared::{HIGH, LOW, SENSORS};
use crate::highway::kinematics::BODY_RADIUS_M;
use metal_rl::num;
use metal_rl::random::Streams;

/// Distance from the body's centre in metres, and azimuth in degrees (left positive), of ps0 … ps7.
const MOUNTS: [[f64; 2]; SENSORS] = [
    [0.0351, -18.0],
    [0.0347, -45.0],
    [0.0330, -90.0],
    [0.0350, -142.0],
    [0.0350, 142.0],
    [0.0330, 90.0],
    [0.0347, 45.0],
    [0.0351, 18.0],
];
/// Each sensor looks along these directions beside its own, in degrees.
const RAYS_DEG: [f64; 3] = [-15.0, 0.0, 15.0];
/// Standard deviation of the noise at any distance.
const NOISE: f64 = 10.0;

/// Distance of a wall from the hull in metres, mean reading.
const LAW: [[f64; 2]; 13] = [
    [0.0, 3670.0],
    [0.005, 2345.0],
    [0.01, 1250.0],
    [0.015, 719.0],
    [0.02, 452.0],
    [0.03, 224.0],
    [0.04, 131.0],
    [0.05, 85.0],
    [0.06, 61.0],
    [0.07, 46.0],
    [0.08, 34.0],
    [0.10, 23.0],
    [0.12, 4.0],
];

/// Readings of the ring of the body at `eye`, in the simulator's units. The noise belongs to `moment`.
pub fn read(eye: &Pose, obstacles: &[Pose], moment: Streams, out: &mut [f64]) {
    let mut rng = moment.stream("infrared");
    for ([radius, azimuth], reading) in MOUNTS.into_iter().zip(out) {
        let (sin, cos) = num::sin_cos(eye.heading_rad + azimuth.to_radians());
        let from = [eye.x_m + radius * cos, eye.y_m + radius * sin];
        let mean: f64 = RAYS_DEG
            .map(|beside| {
                let (sin, cos) = num::sin_cos(eye.heading_rad + (azimuth + beside).to_radians());
                let nearest = obstacles.iter().map(|o| distance(from, [cos, sin], o));
                law(nearest.fold(f64::INFINITY, f64::min) - (BODY_RADIUS_M - radius))
            })
            .iter()
            .sum::<f64>()
            / RAYS_DEG.len() as f64;
        *reading = (LOW + (mean + NOISE * rng.normal()).max(0.0)).min(HIGH);
    }
}

/// Distance along a ray to the side of a body, in metres; infinite if it misses.
fn distance(from: [f64; 2], direction: [f64; 2], body: &Pose) -> f64 {
    let (dx, dy) = (body.x_m - from[0], body.y_m - from[1]);
    let along = dx * direction[0] + dy * direction[1];
    let beside = dy * direction[0] - dx * direction[1];
    let half2 = BODY_RADIUS_M * BODY_RADIUS_M - beside * beside;
    if half2 <= 0.0 || along <= 0.0 { f64::INFINITY } else { (along - half2.sqrt()).max(0.0) }
}

/// Mean reading at a distance from the hull: linear between the measured points, 0 beyond.
fn law(distance_m: f64) -> f64 {
    let distance_m = distance_m.max(0.0);
    let pair = LAW.windows(2).find(|pair| distance_m < pair[1][0]);
    pair.map_or(0.0, |pair| {
        let t = (distance_m - pair[0][0]) / (pair[1][0] - pair[0][0]);
        pair[0][1] + t * (pair[1][1] - pair[0][1])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(obstacles: &[Pose]) -> [f64; SENSORS] {
        let mut out = [0.0; SENSORS];
        read(&Pose::default(), obstacles, Streams::new(3), &mut out);
        out
    }

    #[test]
    fn the_side_an_object_is_on_answers_from_farther_than_webots_would() {
        let readings = ring(&[Pose { x_m: 0.0, y_m: 2.0 * BODY_RADIUS_M + 0.03, heading_rad: 0.0 }]);
        assert_eq!(num::argmax(&readings), 5);
        // Measured: 283, and 69 on the other side, where the idle level is 67.
        assert!(readings[5] > 200.0 && readings[2] < 120.0, "{readings:?}");
    }

    #[test]
    fn the_law_falls_and_ends() {
        let readings: Vec<f64> = (0..=130).map(|mm| law(f64::from(mm) / 1000.0)).collect();
        assert!(readings.windows(2).all(|w| w[0] > w[1] || w[1] == 0.0));
        assert_eq!((law(0.0), law(0.13), law(f64::INFINITY)), (3670.0, 0.0, 0.0));
    }
}
