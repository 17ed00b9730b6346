//! A small SVG chart writer: just the kinds the report needs.
//!
//! An own writer rather than a plotting crate, because every colour here is a CSS variable: the same drawing follows the
//! page into light, dark and print. See [`variables`].

mod bars;
mod frame;
mod legend;
mod lines;
mod marks;
mod paint;
mod pixels;
mod scale;
mod stack;
mod svg;
mod theme;

pub use bars::{Bar, BarChart};
pub use frame::{Area, Axis, Frame};
pub use legend::{Key, legend_height, rows as legend_rows};
pub use lines::{LineChart, LinePoint, Series};
pub use marks::{Label, place_labels};
pub use paint::{Ink, Paint};
pub use pixels::{PIXELS_HEIGHT, PIXELS_WIDTH, pixels, region};
pub use scale::{Scale, ticks};
pub use stack::{StackChart, StackColumn};
pub use svg::{Anchor, Svg, escape};
pub use theme::{DARK, LIGHT, variables};
