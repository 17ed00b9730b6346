//! Our highway as a world for Webots: the same road code paints the texture and the simulator's own raster.
//!
//! Nothing of Cyberbotics or GCtronic is copied: the cars are of our own [`mini_car`] PROTO, the learner is one, too.

mod car;
mod png;

pub use car::mini_car;
pub use png::encode as encode_png;
pub use png::encode_rgb as encode_png_rgb;

use metal_worlds::highway::camera::{FIELD_OF_VIEW_RAD, PITCH_RAD};
use metal_worlds::highway::ground::CELL_M;
use metal_worlds::highway::scenario::Start;
use metal_worlds::highway::{Ground, Material, Pose, rgb};
use std::fmt::Write;

/// The release whose syntax the files have.
pub const HEADER: &str = "#VRML_SIM R2025a utf8";

/// A file of a world: its path below the project's folder, and its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// Path with `/`.
    pub path: &'static str,
    /// What is in it.
    pub bytes: Vec<u8>,
}

/// The files of the world with this ground in which an episode begins at `start`.
#[must_use]
pub fn files(ground: &Ground, start: &Start) -> Vec<File> {
    vec![
        File { path: "worlds/highway.wbt", bytes: world(ground, start).into_bytes() },
        File { path: "worlds/textures/highway.png", bytes: texture(ground) },
        File { path: "protos/MiniCar.proto", bytes: mini_car().into_bytes() },
    ]
}

/// The ground from above, north up, a pixel for each cell of the raster.
#[must_use]
pub fn texture(ground: &Ground) -> Vec<u8> {
    let (columns, rows) = ground.size();
    let materials = [Material::Road, Material::Line, Material::Grass, Material::RedBody];
    let palette = materials.map(|m| rgb::colour(m).map(|c| c as u8));
    let index = |column: usize, row: usize| {
        // Pictures begin at the top, the raster at the bottom.
        let material = ground.at_cell(column as f64, (rows - 1 - row) as f64);
        materials.iter().position(|m| *m == material).unwrap_or(2) as u8
    };
    encode_png([columns, rows], palette, index)
}

/// The world file.
#[must_use]
pub fn world(ground: &Ground, start: &Start) -> String {
    let (columns, rows) = ground.size();
    let (width, height) = (columns as f64 * CELL_M, rows as f64 * CELL_M);
    let [low, _] = ground.road().bounds_m();
    let (x, y) = (low[0] + 0.5 * width, low[1] + 0.5 * height);
    let up = 1.3 * width.max(height);
    let mut text = format!(
        r#"{HEADER}
EXTERNPROTO "../protos/MiniCar.proto"
WorldInfo {{
  info [ "The miniature highway of METAL, written by `metal world`" ]
  title "METAL highway"
  basicTimeStep 32
  randomSeed 1
}}
Viewpoint {{
  orientation -0.5773502691896258 0.5773502691896258 0.5773502691896258 2.0943951023931953
  position {x} {y} {up}
}}
Background {{
  skyColor [ 0.6 0.75 0.9 ]
}}
DirectionalLight {{
  ambientIntensity 1
  direction 0.1 -0.2 -1
  intensity 1
  castShadows FALSE
}}
DEF ROAD Solid {{
  translation {x} {y} 0
  children [
    Shape {{
      appearance PBRAppearance {{
        baseColorMap ImageTexture {{
          url [ "textures/highway.png" ]
          repeatS FALSE
          repeatT FALSE
          filtering 4
        }}
        roughness 1
        metalness 0
      }}
      geometry DEF GROUND Plane {{
        size {width} {height}
      }}
    }}
  ]
  name "road"
  boundingObject USE GROUND
  locked TRUE
}}
"#
    );
    let learner = "controller \"<extern>\"\n  supervisor TRUE";
    push_car(&mut text, ("LEARNER", "learner"), &start.learner, learner);
    for (i, car) in start.cars[..start.car_count].iter().enumerate() {
        let (def, name) = (format!("RED{}", i + 1), format!("red car {}", i + 1));
        push_car(&mut text, (&def, &name), car, "controller \"<none>\"\n  bodyColor 0.85 0.05 0.05");
    }
    text
}

fn push_car(text: &mut String, (def, name): (&str, &str), pose: &Pose, rest: &str) {
    let Pose { x_m, y_m, heading_rad } = pose;
    // Writing to a text cannot fail.
    let _ = write!(
        text,
        "DEF {def} MiniCar {{\n  translation {x_m} {y_m} 0\n  rotation 0 0 1 {heading_rad}\n  name \"{name}\"\n  {rest}\n}}\n"
    );
}

/// The camera's two angles, in radians: across, and down.
pub(crate) const CAMERA_RAD: [f64; 2] = [FIELD_OF_VIEW_RAD, PITCH_RAD];

#[cfg(test)]
mod tests {
    use super::*;
    use metal_rl::random::Streams;
    use metal_worlds::highway::{RoadSet, Scenario};

    fn ground() -> Ground {
        RoadSet::Seeds(vec![1]).build()[0].clone()
    }

    #[test]
    fn the_world_holds_everybody_and_braces_match() {
        let ground = ground();
        let start = Scenario::Mix.start(ground.road(), &Streams::new(5));
        let text = world(&ground, &start);
        let count = |what: &str| text.matches(what).count();
        assert_eq!(count("MiniCar {"), 1 + start.car_count);
        assert_eq!(count("{"), count("}"));
        assert_eq!(count("["), count("]"));
        assert!(text.starts_with(HEADER) && text.contains("DEF LEARNER") && text.contains("supervisor TRUE"));
        let car = mini_car();
        assert_eq!(car.matches('{').count(), car.matches('}').count());
        assert_eq!(car.matches("DistanceSensor {").count(), 8);
    }

    #[test]
    fn the_texture_shows_the_road_the_simulator_drives_on() {
        let ground = ground();
        let (columns, rows) = ground.size();
        let pixels = png::decode_stored(&texture(&ground));
        assert_eq!((pixels.columns, pixels.indices.len()), (columns, columns * rows));
        for (row, column) in
            [(0, 0), (rows / 2, columns / 3), (rows / 4, columns / 2), (rows - 1, columns - 1)]
        {
            let material = ground.at_cell(column as f64, (rows - 1 - row) as f64);
            let colour = pixels.palette[usize::from(pixels.indices[row * columns + column])];
            assert_eq!(colour, rgb::colour(material).map(|c| c as u8), "({row}, {column})");
        }
        let road = pixels.indices.iter().filter(|&&i| i == 0).count();
        assert!(road * 20 > pixels.indices.len(), "there is a road");
    }
}
