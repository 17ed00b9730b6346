//! Made-up pictures and maps.

use metal_lab::paper;
use metal_lab::results::{
    CAMERA_COLUMNS, CAMERA_ROWS, CameraRegion, LooksMap, MapPoint, PixelImage, Pose, RoadOutline, RoadView,
    SceneRow, TestDrive,
};
use metal_rl::num;

pub fn regions() -> Vec<CameraRegion> {
    let region = |name: &str, (top, bottom): (usize, usize), (left, right): (usize, usize)| CameraRegion {
        name: name.to_owned(),
        top,
        bottom,
        left,
        right,
    };
    let (far, near) = ((8, 21), (23, 38));
    vec![
        region("LF", far, (1, 17)),
        region("MF", far, (18, 34)),
        region("RF", far, (35, 51)),
        region("LN", near, (1, 17)),
        region("MN", near, (18, 34)),
        region("RN", near, (35, 51)),
    ]
}

/// A straight road towards the horizon, with a car if `car` names its first column.
fn image(shift: f64, car: Option<usize>) -> PixelImage {
    let pixel = |row: usize, column: usize| {
        if row < 7 {
            return '4';
        }
        let depth = (row - 6) as f64 / 32.0;
        let side = (column as f64 - 26.0 - shift * (1.0 - depth)).abs();
        let is_car = car.is_some_and(|c| (14..27).contains(&row) && (c..c + 11).contains(&column));
        match side {
            _ if is_car => '2',
            s if s < 0.4 + depth && row % 8 < 5 => '1',
            s if s < 26.0 * depth + 2.0 => '0',
            s if s < 28.0 * depth + 3.5 => '1',
            _ => '3',
        }
    };
    (0..CAMERA_ROWS).map(|row| (0..CAMERA_COLUMNS).map(|column| pixel(row, column)).collect()).collect()
}

pub fn scenes() -> Vec<SceneRow> {
    let cars = [None, None, Some(6), Some(20), None, None];
    let scene = |(i, &(situation, looks, _)): (usize, &(&str, &[&str], &str))| SceneRow {
        situation: situation.to_owned(),
        image: image(i as f64 * 4.0 - 10.0, cars[i]),
        learned: super::names(&looks[..looks.len().min(3)]),
        agreement: 0.8,
        action: Some("Go Fast".to_owned()),
        paper: super::names(looks),
    };
    paper::TABLE1.iter().enumerate().map(scene).collect()
}

fn road() -> RoadOutline {
    let point = |i: u32| {
        let angle = f64::from(i) / 120.0 * 2.0 * std::f64::consts::PI;
        let (sin, cos) = num::sin_cos(angle);
        let radius = 0.8 + 0.18 * num::sin(3.0 * angle) + 0.08 * num::cos(2.0 * angle);
        [1.35 * radius * cos, radius * sin]
    };
    RoadOutline { middle: (0..120).map(point).collect(), width_m: 0.3 }
}

pub fn road_view() -> RoadView {
    let road = road();
    let pose = |i: usize, turn: f64| {
        let [here, there] = [road.middle[i], road.middle[i + 1]];
        let heading_rad = num::atan2(there[1] - here[1], there[0] - here[0]) + turn;
        Pose { x: here[0], y: here[1], heading_rad }
    };
    let (learner, cars) = (pose(10, 0.1), vec![pose(20, 0.0), pose(70, 3.1)]);
    RoadView { image: image(3.0, Some(30)), learner, cars, road }
}

pub fn test_drive() -> TestDrive {
    let reward: Vec<f64> =
        (0..150_u32).map(|i| -6.0 - f64::from(i * 13 % 7) - if i % 47 == 40 { 45.0 } else { 0.0 }).collect();
    let average = |i: usize| {
        let window = &reward[i.saturating_sub(4)..=i];
        window.iter().sum::<f64>() / window.len() as f64
    };
    let mut sum = 0.0;
    let mut accumulate = |r: &f64| {
        sum += r;
        sum
    };
    TestDrive {
        road: "test 1".to_owned(),
        moving_average: (0..reward.len()).map(average).collect(),
        accumulated: reward.iter().map(&mut accumulate).collect(),
        reward,
    }
}

pub fn look_map() -> LooksMap {
    let road = road();
    let firsts = [Some("MN"), Some("MN"), Some("MF"), Some("MN"), Some("IR"), None, Some("LN")];
    let point = |(i, p): (usize, &[f64; 2])| {
        let first = firsts[i / 17 % 7];
        let looks = if first.is_none() { 0 } else { 1 + (i / 13 % 5) as u32 };
        MapPoint { x: p[0] * 1.04, y: p[1] * 1.04, looks, first: first.map(str::to_owned) }
    };
    LooksMap { points: road.middle.iter().enumerate().map(point).collect(), road }
}
