//! Writes pictures of the highway as PPM files: every road from above, and what the robot sees in each situation.
//!
//! `cargo run --release -p metal-worlds --example look -- target/pictures`

use metal_worlds::highway::camera::{COLUMNS, ROWS, Region};
use metal_worlds::highway::kinematics::BODY_RADIUS_M;
use metal_worlds::highway::{
    Class, Highway, HighwayConfig, Pose, RoadSet, Scenario, Situation, Steering, rgb,
};
use std::io::Write;
use std::path::Path;

const PIXEL_M: f64 = 0.006;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "target/pictures".to_owned());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    for (name, roads) in
        [("training", RoadSet::Training), ("validation", RoadSet::Validation), ("test", RoadSet::Test)]
    {
        let world = Highway::new(HighwayConfig::new(roads, Scenario::Mix), Steering::Scripted);
        for seed in 0..8 {
            let mut world = world.clone();
            world.reset_to(seed, Situation::Blocked);
            from_above(&world, &folder.join(format!("above-{name}-{seed}.ppm")))?;
        }
    }
    let mut world = Highway::new(HighwayConfig::default(), Steering::Scripted);
    for (i, situation) in Situation::ALL.into_iter().enumerate() {
        world.reset_to(0, situation);
        let image = world.rgb_image();
        write(&folder.join(format!("view-{i}.ppm")), (COLUMNS, ROWS), |r, c| image[r * COLUMNS + c])?;
        let classes = world.class_image();
        write(&folder.join(format!("classes-{i}.ppm")), (COLUMNS, ROWS), |r, c| {
            class_colour(classes[r * COLUMNS + c], r, c)
        })?;
    }
    Ok(())
}

/// The road and everybody on it, 6 mm a pixel.
fn from_above(world: &Highway, path: &Path) -> std::io::Result<()> {
    let grounds = world.grounds();
    let [low, high] = world.road().bounds_m();
    let ground = grounds.iter().find(|g| g.road().bounds_m() == [low, high]).expect("the world's own road");
    let size = [0, 1].map(|k| ((high[k] - low[k]) / PIXEL_M) as usize);
    write(path, (size[0], size[1]), |row, column| {
        let point = Pose {
            x_m: low[0] + column as f64 * PIXEL_M,
            y_m: high[1] - row as f64 * PIXEL_M,
            heading_rad: 0.0,
        };
        if world.cars().iter().any(|car| car.distance_m(&point) < BODY_RADIUS_M) {
            [220, 30, 30]
        } else if world.learner().distance_m(&point) < BODY_RADIUS_M {
            let nose = world.learner().bearing_rad(&point).abs() < 0.4;
            if nose { [250, 220, 0] } else { [120, 120, 160] }
        } else {
            rgb::colour(ground.at(point.x_m, point.y_m)).map(|c| c as u8)
        }
    })
}

/// The class's colour, darker along the borders between regions.
fn class_colour(class: Class, row: usize, column: usize) -> [u8; 3] {
    let edge = Region::ALL.iter().map(|r| r.window()).any(|w| {
        (w.top == row && row > 0 && (w.left..w.right).contains(&column))
            || (w.left == column && column > 0 && (w.top..w.bottom).contains(&row))
    });
    if edge {
        return [80, 80, 200];
    }
    match class {
        Class::Black => [20, 20, 20],
        Class::White => [240, 240, 240],
        Class::Red => [220, 30, 30],
        Class::Green => [40, 150, 45],
    }
}

/// Writes a picture as PPM, row by row.
fn write(
    path: &Path,
    (columns, rows): (usize, usize),
    colour: impl Fn(usize, usize) -> [u8; 3],
) -> std::io::Result<()> {
    let mut bytes = format!("P6\n{columns} {rows}\n255\n").into_bytes();
    for row in 0..rows {
        for column in 0..columns {
            bytes.extend(colour(row, column));
        }
    }
    std::fs::File::create(path)?.write_all(&bytes)
}
