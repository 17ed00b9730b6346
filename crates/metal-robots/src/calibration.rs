//! What differs from room to room and from robot to robot: light, and the level of the infra-red sensors. `metal
//! calibrate` writes it, everything that drives a body reads it.

use crate::body::{INFRARED, InfraredScale};
use crate::picture::Picture;
use metal_worlds::highway::camera::Region;
use metal_worlds::highway::classify::ColourThresholds;
use metal_worlds::highway::infrared::{HIGH, LOW};
use serde::{Deserialize, Serialize};

/// Classes of the pixels of a patch that is all road, line, red or grass, by the thresholds' own words.
const NAMES: [&str; 4] = ["black", "white", "red", "green"];

/// A calibration, as it is written to TOML.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Thresholds between the four colours, as the simulator's colour path uses them.
    pub colours: ColourThresholds,
    /// How infra-red readings are to be understood.
    pub infrared: InfraredScale,
}

/// Why a calibration could not be made or read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CalibrationError {
    /// A colour was not seen often enough.
    #[error(
        "too little {0} was seen: show road, a line, a red car and grass in the frames (at least 40 pixels of each)"
    )]
    Unseen(&'static str),
    /// Two colours cannot be told apart in this light.
    #[error("{0} cannot be told apart: give more light, or less")]
    Ambiguous(&'static str),
    /// The file means nothing.
    #[error("the calibration cannot be read: {0}")]
    File(String),
}

/// Fewest pixels of a colour that count as having seen it.
const ENOUGH: usize = 40;

impl Calibration {
    /// A body's own, before anybody calibrated it.
    #[must_use]
    pub fn of(infrared: InfraredScale) -> Self {
        Self { colours: ColourThresholds::default(), infrared }
    }

    /// The TOML text.
    ///
    /// # Errors
    /// Never, as long as every number is finite.
    pub fn to_toml(&self) -> Result<String, CalibrationError> {
        toml::to_string(self).map_err(|e| CalibrationError::File(e.to_string()))
    }

    /// The calibration in a TOML text.
    ///
    /// # Errors
    /// If a key is missing, unknown or of the wrong type, or the factor is not above 0.
    pub fn from_toml(text: &str) -> Result<Self, CalibrationError> {
        let read: Self = toml::from_str(text).map_err(|e| CalibrationError::File(e.to_string()))?;
        if read.infrared.factor > 0.0 && read.infrared.factor.is_finite() {
            return Ok(read);
        }
        Err(CalibrationError::File(format!("infrared.factor = {}: above 0", read.infrared.factor)))
    }

    /// Share of black, white, red and green of `part`, a picture of one region.
    #[must_use]
    pub fn shares(&self, part: &Picture) -> [f64; 4] {
        let mut counts = [0_u32; 4];
        part.pixels.iter().for_each(|&rgb| counts[self.colours.classify(rgb) as usize] += 1);
        counts.map(|count| f64::from(count) / part.pixels.len().max(1) as f64)
    }

    /// Infra-red readings in the units the mind has learned with.
    #[must_use]
    pub fn infrared(&self, raw: [f64; INFRARED]) -> [f64; INFRARED] {
        let InfraredScale { idle, factor } = self.infrared;
        raw.map(|r| (LOW + (r - idle) * factor).clamp(LOW, HIGH))
    }

    /// A calibration from frames that show road, line, red and grass, and from readings with nothing near.
    ///
    /// # Formula
    /// Pixels are first sorted by what light cannot change: saturated ones by hue into red and green, the others into the
    /// darker and the lighter half of their values' range. Each threshold is then the middle between the classes' edges
    /// (their 5 % and 95 % quantiles).
    ///
    /// # Errors
    /// If a colour is missing or two of them overlap.
    pub fn learn(frames: &[Picture], free: &[[f64; INFRARED]]) -> Result<Self, CalibrationError> {
        let pixels: Vec<Pixel> = frames.iter().flat_map(|f| &f.pixels).map(|&rgb| Pixel::of(rgb)).collect();
        let (greys, coloured): (Vec<Pixel>, Vec<Pixel>) =
            pixels.iter().partition(|p| p.span < 0.12 || p.saturation() < 0.3);
        let lightest = greys.iter().map(|p| p.value).fold(0.0, f64::max);
        let (whites, blacks): (Vec<Pixel>, Vec<Pixel>) = greys.iter().partition(|p| p.value > 0.5 * lightest);
        let (reds, greens): (Vec<Pixel>, Vec<Pixel>) = coloured.iter().partition(|p| p.red_deg < 60.0);
        for (class, name) in [&blacks, &whites, &reds, &greens].into_iter().zip(NAMES) {
            if class.len() < ENOUGH {
                return Err(CalibrationError::Unseen(name));
            }
        }
        let values = |class: &[Pixel]| quantiles(class.iter().map(|p| p.value).collect());
        let saturations = |class: &[Pixel]| quantiles(class.iter().map(Pixel::saturation).collect());
        let hues = |class: &[Pixel]| quantiles(class.iter().map(|p| p.red_deg).collect());
        let between = |low: f64, high: f64, what| {
            if low < high { Ok(0.5 * (low + high)) } else { Err(CalibrationError::Ambiguous(what)) }
        };
        let darkest_colour = values(&reds)[0].min(values(&greens)[0]);
        let palest = saturations(&reds)[0].min(saturations(&greens)[0]);
        let colours = ColourThresholds {
            dark_below: between(
                values(&blacks)[1].min(0.6 * darkest_colour),
                darkest_colour,
                "road and colours",
            )?,
            grey_below: between(saturations(&whites)[1], palest, "white and colours")?,
            white_from: between(values(&blacks)[1], values(&whites)[0], "black and white")?,
            red_within_deg: between(hues(&reds)[1], hues(&greens)[0], "red and green")?,
        };
        let count = (free.len() * INFRARED).max(1) as f64;
        let idle = free.iter().flatten().sum::<f64>() / count;
        Ok(Self { colours, infrared: InfraredScale { idle, factor: 1.0 } })
    }
}

/// Number of features a region delivers; the same for each.
pub const COLOURS: usize = NAMES.len();

const _: () = assert!(Region::ALL.len() == 6);

#[derive(Clone, Copy, Debug)]
struct Pixel {
    value: f64,
    span: f64,
    red_deg: f64,
}

impl Pixel {
    fn of(rgb: [u8; 3]) -> Self {
        let [r, g, b] = rgb.map(|c| f64::from(c) / 255.0);
        let (high, low) = (r.max(g).max(b), r.min(g).min(b));
        let span = high - low;
        let safe = span.max(1e-9);
        let red_deg = if r >= high {
            60.0 * (g - b).abs() / safe
        } else if g >= high {
            120.0 + 60.0 * (b - r) / safe
        } else {
            120.0 + 60.0 * (g - r) / safe
        };
        Self { value: high, span, red_deg: red_deg.min(180.0) }
    }

    fn saturation(&self) -> f64 {
        self.span / self.value.max(1e-9)
    }
}

/// The 5 % and the 95 % quantile; 0 of nothing.
fn quantiles(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [0.05, 0.95].map(|q| values.get((q * values.len() as f64) as usize).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_rl::random::Rng;
    use metal_worlds::highway::{Class, Material, rgb};

    /// A frame with equal parts of all four materials, in some light and noise.
    fn frame(light: f64, noise: f64, seed: u64) -> Picture {
        let mut rng = Rng::new(seed);
        let materials = [Material::Road, Material::Line, Material::RedBody, Material::Grass];
        let pixels = (0..400).map(|i| {
            rgb::colour(materials[i % 4])
                .map(|c| (light * c + 255.0 * noise * rng.normal()).clamp(0.0, 255.0) as u8)
        });
        Picture { columns: 20, pixels: pixels.collect() }
    }

    #[test]
    fn in_half_the_light_the_learned_thresholds_work_and_the_default_ones_do_not() {
        let dim = frame(0.5, 0.01, 1);
        let learned = Calibration::learn(&[dim], &[[70.0; INFRARED]]).unwrap();
        let shares = learned.shares(&frame(0.5, 0.01, 2));
        assert!(shares.iter().all(|s| (s - 0.25).abs() < 0.02), "{shares:?}");
        let default = Calibration::of(learned.infrared).shares(&frame(0.5, 0.01, 2));
        assert_eq!(default[Class::White as usize], 0.0, "white looks black in the dark");
        assert_eq!(learned.infrared.idle, 70.0);
        assert_eq!(learned.infrared([70.0; INFRARED]), [67.0; INFRARED]);
    }

    #[test]
    fn what_was_not_seen_is_named() {
        let mut frame = frame(1.0, 0.0, 1);
        frame.pixels.retain(|p| !(p[0] > 150 && p[1] < 60));
        frame.columns = 1;
        assert_eq!(Calibration::learn(&[frame], &[]), Err(CalibrationError::Unseen("red")));
    }

    #[test]
    fn a_calibration_survives_its_file_and_a_wrong_one_is_refused() {
        let calibration = Calibration::of(InfraredScale { idle: 3.0, factor: 1.5 });
        let text = calibration.to_toml().unwrap();
        assert_eq!(Calibration::from_toml(&text).unwrap(), calibration);
        assert!(Calibration::from_toml(&text.replace("idle", "idlest")).is_err());
        assert!(
            Calibration::from_toml(&text.replace("1.5", "0.0")).unwrap_err().to_string().contains("above 0")
        );
    }
}
