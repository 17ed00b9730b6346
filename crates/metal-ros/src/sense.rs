//! From what a body feels to what ROS says of it: metres, frames, quaternions.

use crate::messages::{
    CameraInfo, CompressedImage, Header, Image, Imu, LaserScan, Odometry, Pose, Quaternion, Range, Transform,
    TransformStamped, Vector3,
};
use crate::node::header;
use metal_rl::num;
use metal_robots::Picture;
use metal_robots::body::{Feelings, INFRARED};
use metal_worlds::highway::camera::{COLUMNS, FIELD_OF_VIEW_RAD, ROWS};
use metal_worlds::highway::infrared::TABLE;

/// Distance of the ring's sensors from the centre, in metres, as the robot's drivers in ROS have it.
pub const RING_M: f64 = 0.035;
/// Directions of ps0 … ps7 in degrees, left positive, as those drivers round them.
pub const RING_DEG: [f64; INFRARED] = [-15.0, -45.0, -90.0, -150.0, 150.0, 90.0, 45.0, 15.0];
/// Nearest and farthest distance that an infra-red sensor tells apart, in metres.
pub const RANGE_M: [f64; 2] = [0.005, 0.05];
/// Opening of an infra-red sensor, in radians.
const OPENING_RAD: f64 = 0.1;
/// Farthest distance of the time-of-flight sensor, in metres.
const AHEAD_M: f64 = 2.0;
/// Steps of the scan, and their size in degrees: −150° to 150°.
const SCAN: (usize, f64) = (21, 15.0);
/// Kind of radiation of all range sensors here.
const INFRARED_LIGHT: u8 = 1;

/// Distance for a reading in the simulator's units (67: nothing near): the table backwards.
#[must_use]
pub fn distance_m(reading: f64) -> f64 {
    let inside = TABLE.windows(2).find(|pair| reading >= pair[1][1]);
    let Some([[d0, v0, _], [d1, v1, _]]) = inside.map(|pair| [pair[0], pair[1]]) else { return TABLE[9][0] };
    if reading >= v0 { d0 } else { d0 + (v0 - reading) / (v0 - v1) * (d1 - d0) }
}

/// The reading of one infra-red sensor. Beyond its reach it is infinite (REP 117).
#[must_use]
pub fn range(frame: &str, reading: f64) -> Range {
    let found = distance_m(reading);
    let [near, far] = RANGE_M;
    let range = if found > far { f32::INFINITY } else { found.max(near) as f32 };
    Range { range, max_range: far as f32, min_range: near as f32, ..blank(frame) }
}

/// The time-of-flight sensor.
#[must_use]
pub fn ahead(metres: f64) -> Range {
    let range = if metres >= AHEAD_M { f32::INFINITY } else { metres as f32 };
    Range { range, max_range: AHEAD_M as f32, min_range: 0.005, field_of_view: 0.44, ..blank("tof") }
}

fn blank(frame: &str) -> Range {
    let field_of_view = OPENING_RAD as f32;
    Range { header: header(frame), radiation_type: INFRARED_LIGHT, field_of_view, ..Range::default() }
}

/// The ring as a scan from the centre; directions without a sensor hold no number.
#[must_use]
pub fn scan(ring: &[f64; INFRARED], secs: f64) -> LaserScan {
    let (count, step_deg) = SCAN;
    let mut ranges = vec![f32::NAN; count];
    for (reading, degrees) in ring.iter().zip(RING_DEG) {
        let found = distance_m(*reading);
        let metres = if found > RANGE_M[1] { f64::INFINITY } else { found.max(RANGE_M[0]) + RING_M };
        ranges[((degrees + 150.0) / step_deg).round() as usize] = metres as f32;
    }
    LaserScan {
        header: header("laser_scanner"),
        angle_min: -150.0_f32.to_radians(),
        angle_max: 150.0_f32.to_radians(),
        angle_increment: (step_deg as f32).to_radians(),
        time_increment: 0.0,
        scan_time: secs as f32,
        range_min: (RANGE_M[0] + RING_M) as f32,
        range_max: (RANGE_M[1] + RING_M) as f32,
        ranges,
        intensities: Vec::new(),
    }
}

/// A picture in red, green and blue.
#[must_use]
pub fn image(picture: &Picture) -> Image {
    Image {
        header: header("camera"),
        height: picture.rows() as u32,
        width: picture.columns as u32,
        encoding: "rgb8".to_owned(),
        is_bigendian: 0,
        step: 3 * picture.columns as u32,
        data: picture.pixels.as_flattened().to_vec(),
    }
}

/// The same as PNG.
#[must_use]
pub fn compressed(picture: &Picture) -> CompressedImage {
    let data = metal_robots::world::encode_png_rgb(picture.columns, picture.pixels.as_flattened());
    CompressedImage { header: header("camera"), format: "rgb8; png compressed rgb8".to_owned(), data }
}

/// The camera: a pinhole without distortion, with the E-puck's opening.
#[must_use]
pub fn camera_info() -> CameraInfo {
    let (width, height) = (COLUMNS as f64, ROWS as f64);
    let focal = 0.5 * width / num::tan(0.5 * FIELD_OF_VIEW_RAD);
    let (cx, cy) = (0.5 * width, 0.5 * height);
    CameraInfo {
        header: header("camera"),
        height: ROWS as u32,
        width: COLUMNS as u32,
        distortion_model: "plumb_bob".to_owned(),
        d: vec![0.0; 5],
        k: [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        ..CameraInfo::default()
    }
}

/// A turn about the vertical.
#[must_use]
pub fn yaw(angle_rad: f64) -> Quaternion {
    let (z, w) = num::sin_cos(0.5 * angle_rad);
    Quaternion { x: 0.0, y: 0.0, z, w }
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

/// Acceleration and turning rates; the orientation is not known (−1, as the message says it).
#[must_use]
pub fn imu(felt: &Feelings) -> Option<Imu> {
    let mut imu = Imu { header: header("imu"), ..Imu::default() };
    imu.orientation.w = 1.0;
    imu.orientation_covariance[0] = -1.0;
    match (felt.acceleration_mps2, felt.turn_radps) {
        (None, None) => return None,
        (acceleration, turn) => {
            imu.linear_acceleration = vector(acceleration.unwrap_or_default());
            imu.angular_velocity = vector(turn.unwrap_or_default());
            imu.linear_acceleration_covariance[0] = if acceleration.is_some() { 0.0 } else { -1.0 };
            imu.angular_velocity_covariance[0] = if turn.is_some() { 0.0 } else { -1.0 };
        }
    }
    Some(imu)
}

/// The way so far, and the motion of now (m/s, rad/s).
#[must_use]
pub fn odometry(pose: &metal_worlds::highway::Pose, [speed, turn]: [f64; 2]) -> Odometry {
    let mut way =
        Odometry { header: header("odom"), child_frame_id: "base_link".to_owned(), ..Odometry::default() };
    way.pose.pose = Pose { position: vector([pose.x_m, pose.y_m, 0.0]), orientation: yaw(pose.heading_rad) };
    way.twist.twist.linear.x = speed;
    way.twist.twist.angular.z = turn;
    way
}

/// Where `child` is in `parent`.
#[must_use]
pub fn transform(parent: &str, child: &str, place: [f64; 3], turn_rad: f64) -> TransformStamped {
    let transform = Transform { translation: vector(place), rotation: yaw(turn_rad) };
    let header: Header = header(parent);
    TransformStamped { header, child_frame_id: child.to_owned(), transform }
}

/// Where the sensors are on the body.
#[must_use]
pub fn frames() -> Vec<TransformStamped> {
    let ring = RING_DEG.iter().enumerate().map(|(i, degrees)| {
        let angle = degrees.to_radians();
        let (sin, cos) = num::sin_cos(angle);
        transform("base_link", &format!("ps{i}"), [RING_M * cos, RING_M * sin, 0.034], angle)
    });
    let rest = [
        ("camera", [0.03, 0.0, 0.028]),
        ("tof", [0.034, 0.0, 0.033]),
        ("imu", [0.0; 3]),
        ("laser_scanner", [0.0, 0.0, 0.033]),
    ];
    let rest = rest.map(|(name, place)| transform("base_link", name, place, 0.0));
    ring.chain(rest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_become_the_distances_of_the_table() {
        for [distance, reading, _] in TABLE {
            assert!((distance_m(reading) - distance).abs() < 1e-12, "{reading}");
        }
        assert!((distance_m(0.5 * (1465.73 + 2133.33)) - 0.0075).abs() < 1e-12);
        assert_eq!(distance_m(67.0), 0.07, "nothing near");
        assert_eq!(distance_m(9000.0), 0.0);
        assert_eq!(range("ps0", 67.0).range, f32::INFINITY);
    }

    #[test]
    fn the_scan_has_the_ring_in_its_directions_and_nothing_between() {
        let mut ring = [67.0; INFRARED];
        ring[6] = 383.84;
        let scan = scan(&ring, 0.064);
        assert_eq!(scan.ranges.iter().filter(|r| r.is_nan()).count(), 21 - 8);
        // 45° to the left is step 13, 20 mm and 35 mm away.
        assert!((scan.ranges[13] - 0.055).abs() < 1e-6);
        assert_eq!(scan.ranges[9], f32::INFINITY, "ps0, −15°");
        assert!((scan.angle_min + 9.0 * scan.angle_increment - (-15.0_f32).to_radians()).abs() < 1e-6);
    }
}
