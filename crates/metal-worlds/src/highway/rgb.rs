//! The second path from scene to features: a colour picture with light, blur and noise, classified pixel by pixel.

use super::camera::{COLUMNS, Camera, ROWS, Scene, Window};
use super::classify::ColourThresholds;
use super::ground::Material;
use metal_rl::random::Streams;
use serde::{Deserialize, Serialize};

/// How the colour picture comes about.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RgbConfig {
    /// Factor on every colour; 1 is the light the thresholds were chosen in.
    pub light: f64,
    /// Standard deviation of the noise of each channel, as a share of its range (Webots' meaning).
    pub noise: f64,
    /// Share of the light a pixel gets from its eight neighbours, 0 (sharp) to 0.75 (binomial 3×3).
    pub blur: f64,
    /// Thresholds between the classes.
    pub thresholds: ColourThresholds,
}

impl Default for RgbConfig {
    fn default() -> Self {
        Self { light: 1.0, noise: 0.0, blur: 0.0, thresholds: ColourThresholds::default() }
    }
}

/// Colour of a material in full light, each channel 0 to 255.
#[must_use]
pub fn colour(material: Material) -> [f64; 3] {
    match material {
        Material::Road => [28.0, 28.0, 30.0],
        Material::Line => [235.0, 235.0, 230.0],
        Material::RedBody => [200.0, 22.0, 20.0],
        Material::Grass => [40.0, 150.0, 45.0],
        Material::GreyBody => [100.0, 100.0, 105.0],
    }
}

/// Paints the colours of `window`: `paint` gets the pixel's index in the whole picture and its colour. `noise` is the
/// family of this very moment, so that looking again gives the same picture.
pub fn render(
    camera: &Camera,
    scene: &Scene,
    (config, noise): (&RgbConfig, Streams),
    window: Window,
    mut paint: impl FnMut(usize, [u8; 3]),
) {
    let mut materials = [Material::Grass; ROWS * COLUMNS];
    camera.render(scene, window.widened(), |index, material| materials[index] = material);
    for row in window.top..window.bottom {
        for column in window.left..window.right {
            let index = row * COLUMNS + column;
            let light = blurred(&materials, row, column, config.blur).map(|c| c * config.light);
            paint(index, digitised(light, config.noise, noise.nth(index as u64)));
        }
    }
}

/// The light of a pixel: its own and, by the binomial weights 1 2 1 in each direction, that of its neighbours.
fn blurred(materials: &[Material], row: usize, column: usize, blur: f64) -> [f64; 3] {
    let own = colour(materials[row * COLUMNS + column]);
    if blur <= 0.0 {
        return own;
    }
    let mut light = own.map(|c| c * (1.0 - blur));
    for (dr, dc, weight) in NEIGHBOURS {
        // The picture's edge repeats itself outwards.
        let r = row.saturating_add_signed(dr).min(ROWS - 1);
        let c = column.saturating_add_signed(dc).min(COLUMNS - 1);
        let other = colour(materials[r * COLUMNS + c]);
        light.iter_mut().zip(other).for_each(|(sum, o)| *sum += blur * weight * o);
    }
    light
}

const NEIGHBOURS: [(isize, isize, f64); 8] = [
    (-1, -1, 1.0 / 12.0),
    (-1, 0, 2.0 / 12.0),
    (-1, 1, 1.0 / 12.0),
    (0, -1, 2.0 / 12.0),
    (0, 1, 2.0 / 12.0),
    (1, -1, 1.0 / 12.0),
    (1, 0, 2.0 / 12.0),
    (1, 1, 1.0 / 12.0),
];

fn digitised(light: [f64; 3], noise: f64, moment: Streams) -> [u8; 3] {
    if noise <= 0.0 {
        return light.map(|c| c.round().clamp(0.0, 255.0) as u8);
    }
    let mut rng = moment.stream("pixel");
    light.map(|c| (c + 255.0 * noise * rng.normal()).round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_material_is_classified_as_its_class_in_a_range_of_light() {
        use Material::{Grass, GreyBody, Line, RedBody, Road};
        for light in [0.7, 1.0, 1.2] {
            for material in [Road, Line, RedBody, Grass, GreyBody] {
                let rgb = digitised(colour(material).map(|c| c * light), 0.0, Streams::new(0));
                assert_eq!(
                    ColourThresholds::default().classify(rgb),
                    material.class(),
                    "{material:?} {light}"
                );
            }
        }
    }

    #[test]
    fn blur_keeps_the_light_of_a_plain_picture() {
        let plain = [Material::Grass; ROWS * COLUMNS];
        for (row, column) in [(0, 0), (20, 20), (38, 51)] {
            let light = blurred(&plain, row, column, 0.5);
            assert!(light.iter().zip(colour(Material::Grass)).all(|(a, b)| (a - b).abs() < 1e-9));
        }
    }
}
