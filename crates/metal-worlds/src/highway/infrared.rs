//! The ring of eight infra-red proximity sensors, with the look-up table and the noise of the E-puck model.
//!
//! What reflects, and how a red body answers, is reading R53. Values are in units of the table, from 67 (nothing near) to 4095. Only cars reflect; lines and grass do not.
//! The rays climb 9 degrees, which over their 50 mm keeps them below a car's top.

use super::kinematics::BODY_RADIUS_M;
use super::pose::Pose;
use metal_rl::num;
use metal_rl::random::Streams;

/// Number of sensors.
pub const SENSORS: usize = 8;
/// Least reading: nothing near.
pub const LOW: f64 = 67.0;
/// Largest reading.
pub const HIGH: f64 = 4095.0;

/// x ahead and y left in metres, azimuth in degrees (left positive), of ps0 … ps7 (robots.md, 1.1).
pub const MOUNTS: [[f64; 3]; SENSORS] = [
    [0.030, -0.010, -17.23],
    [0.022, -0.025, -45.88],
    [0.000, -0.031, -90.00],
    [-0.030, -0.015, -151.49],
    [-0.030, 0.015, 151.22],
    [0.000, 0.031, 90.00],
    [0.022, 0.025, 45.79],
    [0.030, 0.010, 17.14],
];
/// The stream of the noise.
const NOISE: &str = "infrared";
/// Elevation of all rays, in degrees.
pub const ELEVATION_DEG: f64 = 9.17;
/// A red body (redness 0.85, roughness 0.5) answers as a white one this many times farther off would:
/// 0.8 · 0.85 · (1 − 0.5 · 0.5) + 0.2.
const RED_FACTOR: f64 = 0.71;

/// Distance in metres, reading, relative noise.
pub const TABLE: [[f64; 3]; 10] = [
    [0.0, 4095.0, 0.002],
    [0.005, 2133.33, 0.003],
    [0.01, 1465.73, 0.007],
    [0.015, 601.46, 0.0406],
    [0.02, 383.84, 0.01472],
    [0.03, 234.93, 0.0241],
    [0.04, 158.03, 0.0287],
    [0.05, 120.0, 0.04225],
    [0.06, 104.09, 0.03065],
    [0.07, 67.19, 0.04897],
];

/// The sensors' places and directions on the body.
#[derive(Clone, Debug)]
pub struct Infrared {
    /// x, y and direction (x, y) in the body's frame.
    mounts: [[f64; 4]; SENSORS],
    slant: f64,
}

impl Default for Infrared {
    fn default() -> Self {
        Self::new()
    }
}

impl Infrared {
    /// The E-puck's ring.
    #[must_use]
    pub fn new() -> Self {
        let radians = std::f64::consts::PI / 180.0;
        let mounts = MOUNTS.map(|[x, y, azimuth]| {
            let (sin, cos) = num::sin_cos(azimuth * radians);
            [x, y, cos, sin]
        });
        Self { mounts, slant: 1.0 / num::cos(ELEVATION_DEG * radians) }
    }

    /// Readings of all sensors of the body at `eye`. The noise belongs to `moment` (the family of this step), so that
    /// looking again, or in another order, gives the same readings.
    pub fn read(&self, eye: &Pose, cars: &[Pose], moment: Streams, out: &mut [f64]) {
        let noises: [f64; SENSORS] = moment.normals(NOISE);
        let distances = self.distances(&self.mounts, eye, cars);
        for ((reading, distance), noise) in out.iter_mut().zip(distances).zip(noises) {
            *reading = noisy(look_up(distance), noise);
        }
    }

    /// The reading of sensor `i` alone: what [`Self::read`] says of it.
    #[must_use]
    pub fn read_one(&self, i: usize, eye: &Pose, cars: &[Pose], moment: Streams) -> f64 {
        let noise = moment.nth(i as u64).stream(NOISE).normal();
        let [distance] = self.distances(&[self.mounts[i]], eye, cars);
        noisy(look_up(distance), noise)
    }

    /// How far away the nearest car seems to the sensors at `mounts`, in metres; infinite where there is none.
    fn distances<const N: usize>(&self, mounts: &[[f64; 4]; N], eye: &Pose, cars: &[Pose]) -> [f64; N] {
        let (sin, cos) = num::sin_cos(eye.heading_rad);
        let rays = mounts.map(|[x, y, ahead, left]| {
            let from = [eye.x_m + x * cos - y * sin, eye.y_m + x * sin + y * cos];
            (from, [ahead * cos - left * sin, ahead * sin + left * cos])
        });
        let mut nearest = [f64::INFINITY; N];
        for car in cars {
            for (nearest, (from, direction)) in nearest.iter_mut().zip(rays) {
                *nearest = nearest.min(hit(from, direction, car));
            }
        }
        nearest.map(|distance| distance * self.slant / RED_FACTOR)
    }
}

/// Distance along a ray at which it meets a car's side, in metres; 0 from inside, infinite if it misses. Without branches,
/// so that the rays of a ring are asked side by side.
#[inline(always)]
fn hit(from: [f64; 2], direction: [f64; 2], car: &Pose) -> f64 {
    let (dx, dy) = (car.x_m - from[0], car.y_m - from[1]);
    let along = dx * direction[0] + dy * direction[1];
    let beside = dy * direction[0] - dx * direction[1];
    let half2 = BODY_RADIUS_M * BODY_RADIUS_M - beside * beside;
    let half = half2.sqrt();
    let meets = (half2 > 0.0) & (along + half >= 0.0);
    if meets { (along - half).max(0.0) } else { f64::INFINITY }
}

fn noisy((mean, spread): (f64, f64), noise: f64) -> f64 {
    (mean * (1.0 + spread * noise)).clamp(LOW, HIGH)
}

/// Reading and relative noise at a distance: linear between the table's entries, constant outside.
fn look_up(distance_m: f64) -> (f64, f64) {
    for pair in TABLE.windows(2) {
        let ([d0, r0, n0], [d1, r1, n1]) = (pair[0], pair[1]);
        if distance_m < d1 {
            let t = (distance_m - d0) / (d1 - d0);
            return (r0 + t * (r1 - r0), n0 + t * (n1 - n0));
        }
    }
    let [_, reading, noise] = TABLE[TABLE.len() - 1];
    (reading, noise)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(cars: &[Pose], step: u64) -> [f64; SENSORS] {
        let mut out = [0.0; SENSORS];
        Infrared::new().read(&Pose::default(), cars, Streams::new(9).nth(step), &mut out);
        out
    }

    #[test]
    fn the_side_a_car_is_on_answers() {
        let left = Pose { x_m: 0.0, y_m: 0.085, heading_rad: 0.0 };
        let readings = read(&[left], 0);
        assert_eq!(num::argmax(&readings), 5);
        assert!(readings[2] < 90.0);
        // From the sensor to the body's side, along a slanted ray, and as far as red makes it look.
        let distance = (0.085 - 0.037 - 0.031) / num::cos(9.17_f64.to_radians()) / RED_FACTOR;
        let (mean, spread) = look_up(distance);
        assert!((readings[5] / mean - 1.0).abs() < 5.0 * spread);
    }

    #[test]
    fn one_sensor_alone_reads_what_it_reads_in_the_ring() {
        let car = Pose { x_m: 0.07, y_m: 0.03, heading_rad: 0.0 };
        let ring = read(&[car], 4);
        let alone = |i| Infrared::new().read_one(i, &Pose::default(), &[car], Streams::new(9).nth(4));
        assert_eq!(std::array::from_fn(alone), ring);
    }

    #[test]
    fn noise_depends_on_the_moment_only() {
        assert_eq!(read(&[], 3), read(&[], 3));
        assert_ne!(read(&[], 3), read(&[], 4));
    }

    #[test]
    fn the_table_falls_with_distance_and_is_constant_outside() {
        let mut last = f64::INFINITY;
        for k in 0..700 {
            let (reading, _) = look_up(f64::from(k) * 1e-4);
            assert!(reading < last);
            last = reading;
        }
        assert_eq!(look_up(f64::INFINITY), (67.19, 0.04897));
        assert_eq!(look_up(0.0).0, 4095.0);
    }
}
