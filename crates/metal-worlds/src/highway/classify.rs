//! From a colour to one of the four dominant classes, by hue, saturation and value. A real robot uses the same file.

use super::ground::Class;
use serde::{Deserialize, Serialize};

/// Thresholds between the four classes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColourThresholds {
    /// Value (the largest channel, 0 to 1) below which everything is black.
    pub dark_below: f64,
    /// Saturation (0 to 1) below which a colour counts as grey.
    pub grey_below: f64,
    /// Value from which a grey is white.
    pub white_from: f64,
    /// Largest distance from pure red on the circle of hues, in degrees.
    pub red_within_deg: f64,
}

impl Default for ColourThresholds {
    fn default() -> Self {
        Self { dark_below: 0.18, grey_below: 0.35, white_from: 0.55, red_within_deg: 50.0 }
    }
}

impl ColourThresholds {
    /// The class of an 8-bit colour [red, green, blue].
    #[must_use]
    pub fn classify(&self, rgb: [u8; 3]) -> Class {
        let [r, g, b] = rgb.map(|c| f64::from(c) / 255.0);
        let (high, low) = (r.max(g).max(b), r.min(g).min(b));
        if high < self.dark_below {
            Class::Black
        } else if high - low < self.grey_below * high {
            if high < self.white_from { Class::Black } else { Class::White }
        } else if hue_distance_from_red_deg(r, g, b) <= self.red_within_deg {
            Class::Red
        } else {
            Class::Green
        }
    }
}

/// Distance from pure red on the circle of hues, 0 to 180 degrees; the colour must not be grey.
fn hue_distance_from_red_deg(r: f64, g: f64, b: f64) -> f64 {
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let span = high - low;
    if r >= high {
        60.0 * (g - b).abs() / span
    } else if g >= high {
        (120.0 + 60.0 * (b - r) / span).min(180.0)
    } else {
        (120.0 + 60.0 * (g - r) / span).min(180.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_colours_have_their_classes() {
        let thresholds = ColourThresholds::default();
        for (rgb, class) in [
            ([0, 0, 0], Class::Black),
            ([90, 90, 95], Class::Black),
            ([255, 255, 255], Class::White),
            ([200, 190, 200], Class::White),
            ([220, 30, 30], Class::Red),
            ([200, 20, 90], Class::Red),
            ([40, 160, 40], Class::Green),
            ([120, 200, 40], Class::Green),
            ([20, 40, 20], Class::Black),
        ] {
            assert_eq!(thresholds.classify(rgb), class, "{rgb:?}");
        }
    }
}
