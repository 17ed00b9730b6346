//! From the highway's own types to those of the results.

use crate::results::{PixelImage, Pose, RoadOutline};
use metal_worlds::highway::camera::COLUMNS;
use metal_worlds::highway::road::BORDER_M;
use metal_worlds::highway::{self, Class, Highway, Road};

/// What the learner's camera sees, one digit per pixel.
pub fn image(world: &Highway) -> PixelImage {
    world.class_image().chunks(COLUMNS).map(|row| row.iter().map(|&class| digit(class)).collect()).collect()
}

fn digit(class: Class) -> char {
    match class {
        Class::Black => '0',
        Class::White => '1',
        Class::Red => '2',
        Class::Green => '3',
    }
}

/// The road from above.
pub fn outline(road: &Road) -> RoadOutline {
    let mut middle = road.outline().centre;
    // The drawing closes the line by itself.
    middle.pop();
    RoadOutline { middle, width_m: 2.0 * BORDER_M }
}

/// A pose of the world as the results have it.
pub fn pose(pose: &highway::Pose) -> Pose {
    Pose { x: pose.x_m, y: pose.y_m, heading_rad: pose.heading_rad }
}
