//! Writing SVG elements into one drawing.

use std::fmt::Write;

use super::frame::Area;
use super::paint::Paint;

/// Where a text stands relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred on the point.
    Middle,
    /// The text ends at the point.
    End,
}

/// A drawing that grows by one element at a time. Units are CSS pixels, y grows downwards.
#[derive(Clone, Debug)]
pub struct Svg {
    width: f64,
    height: f64,
    body: String,
}

impl Svg {
    /// An empty drawing.
    #[must_use]
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// A rectangle.
    pub fn rect(&mut self, area: Area, paint: Paint) {
        let [x, y, w, h] = [area.x, area.y, area.width, area.height].map(short);
        self.push(format_args!("<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {paint}/>"));
    }

    /// A circle.
    pub fn circle(&mut self, centre: (f64, f64), radius: f64, paint: Paint) {
        let [x, y, r] = [centre.0, centre.1, radius].map(short);
        self.push(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" {paint}/>"));
    }

    /// A straight line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), paint: Paint) {
        self.path(&[from, to], false, paint);
    }

    /// A chain of straight lines, closed or open.
    pub fn path(&mut self, points: &[(f64, f64)], closed: bool, paint: Paint) {
        let mut d = String::new();
        for (i, &(x, y)) in points.iter().enumerate() {
            let command = if i == 0 { "M" } else { "L" };
            let _ = write!(d, "{command}{} {}", short(x), short(y));
        }
        let end = if closed { "Z" } else { "" };
        self.push(format_args!("<path d=\"{d}{end}\" {paint}/>"));
    }

    /// A line of text. `class` is one of `label`, `tick`, `title`, `small`, `badge`.
    pub fn text(&mut self, at: (f64, f64), anchor: Anchor, class: &str, text: &str) {
        self.text_with(at, anchor, class, (text, ""));
    }

    /// A line of text that is read upwards, centred on its point.
    pub fn upward_text(&mut self, at: (f64, f64), class: &str, text: &str) {
        let turn = format!(" transform=\"rotate(-90 {} {})\"", short(at.0), short(at.1));
        self.text_with(at, Anchor::Middle, class, (text, &turn));
    }

    fn text_with(&mut self, at: (f64, f64), anchor: Anchor, class: &str, (text, extra): (&str, &str)) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let [x, y] = [at.0, at.1].map(short);
        let text = escape(text);
        self.push(format_args!(
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" class=\"{class}\"{extra}>{text}</text>"
        ));
    }

    /// Markup that this writer made elsewhere.
    pub fn raw(&mut self, markup: &str) {
        self.push(format_args!("{markup}"));
    }

    /// The finished drawing as an `<svg>` element without colours of its own; `label` says what it shows to those who
    /// cannot see it.
    #[must_use]
    pub fn finish(self, label: &str) -> String {
        let Self { width, height, body } = self;
        let label = escape(label);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 {width} {height}\" \
             role=\"img\" aria-label=\"{label}\">\n{body}</svg>\n"
        )
    }

    fn push(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "{element}");
    }
}

/// A number for SVG: at most two decimals, no trailing zeros.
fn short(x: f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text made safe for XML.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_text_is_safe() {
        assert_eq!([1.0, -0.001, 2.505, 0.1 + 0.2].map(short), ["1", "0", "2.5", "0.3"]);
        assert_eq!(escape("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
