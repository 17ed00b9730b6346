//! Colours by name, and how a shape is painted.

use std::fmt;

/// A colour of the theme, by the name of its CSS variable (`--foa` is `Ink("foa")`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ink(pub &'static str);

impl Ink {
    /// Text and axes.
    pub const TEXT: Self = Self("text");
    /// Less important text.
    pub const MUTED: Self = Self("muted");
    /// Grid lines.
    pub const GRID: Self = Self("grid");
    /// The page.
    pub const PAGE: Self = Self("page");
}

/// How a shape is filled and outlined.
#[derive(Clone, Copy, Debug)]
pub struct Paint {
    fill: Option<Ink>,
    stroke: Option<Ink>,
    width: f64,
    opacity: f64,
    dashed: bool,
}

impl Paint {
    const NONE: Self = Self { fill: None, stroke: None, width: 0.0, opacity: 1.0, dashed: false };

    /// Filled, no outline.
    #[must_use]
    pub fn fill(ink: Ink) -> Self {
        Self { fill: Some(ink), ..Self::NONE }
    }

    /// A line of `width` pixels, not filled.
    #[must_use]
    pub fn line(ink: Ink, width: f64) -> Self {
        Self { stroke: Some(ink), width, ..Self::NONE }
    }

    /// The same with an outline.
    #[must_use]
    pub fn outlined(self, ink: Ink, width: f64) -> Self {
        Self { stroke: Some(ink), width, ..self }
    }

    /// The same, partly transparent.
    #[must_use]
    pub fn faded(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// The same, dashed.
    #[must_use]
    pub fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }
}

/// Written as SVG attributes; colours go into `style`, where CSS variables are allowed.
impl fmt::Display for Paint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fill {
            Some(ink) => write!(f, "style=\"fill:var(--{})", ink.0)?,
            None => write!(f, "style=\"fill:none")?,
        }
        if let Some(ink) = self.stroke {
            write!(f, ";stroke:var(--{})", ink.0)?;
        }
        write!(f, "\"")?;
        if self.stroke.is_some() {
            write!(f, " stroke-width=\"{}\" stroke-linejoin=\"round\" stroke-linecap=\"round\"", self.width)?;
        }
        if self.dashed {
            write!(f, " stroke-dasharray=\"6 4\"")?;
        }
        if self.opacity < 1.0 {
            write!(f, " opacity=\"{}\"", self.opacity)?;
        }
        Ok(())
    }
}
