//! `metal doctor`: what is wrong with a body, one check after the other. The wheels do not turn.

use crate::body::{Body, INFRARED};
use crate::calibration::Calibration;
use crate::picture::Picture;
use metal_worlds::highway::camera::{Region, Window};
use std::fmt::Write;
use std::time::Instant;

/// How often each device is asked, to see whether it changes and how long it takes.
const TIMES: usize = 5;

/// What a check found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// All is well.
    Good,
    /// It works, but something should be looked at.
    Doubtful,
    /// It does not work.
    Bad,
}

/// One check.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What was checked.
    pub what: String,
    /// The outcome.
    pub verdict: Verdict,
    /// What was found, and what to do about it.
    pub finding: String,
}

/// Checks a body that answers already: facts, infra-red ring, camera, and what looks cost.
pub fn examine(body: &mut dyn Body, calibration: &Calibration) -> Vec<Check> {
    let mut checks = Vec::new();
    match body.about() {
        Ok(facts) => checks.extend(facts.into_iter().map(|(what, found)| good(what, found))),
        Err(error) => {
            checks.push(bad("link", format!("{error}; is the robot on, near and alone on the link?")))
        }
    }
    checks.push(ring(body, calibration));
    checks.extend(camera(body, calibration));
    checks
}

fn good(what: impl Into<String>, finding: String) -> Check {
    Check { what: what.into(), verdict: Verdict::Good, finding }
}

fn doubtful(what: &str, finding: String) -> Check {
    Check { what: what.to_owned(), verdict: Verdict::Doubtful, finding }
}

fn bad(what: &str, finding: String) -> Check {
    Check { what: what.to_owned(), verdict: Verdict::Bad, finding }
}

/// Asks `TIMES` times: what came, and the cost of one time in words.
fn asked<T>(
    body: &mut dyn Body,
    mut ask: impl FnMut(&mut dyn Body) -> Result<T, crate::BodyError>,
) -> Result<(Vec<T>, String), crate::BodyError> {
    let (before, start) = (body.meter(), Instant::now());
    let answers = (0..TIMES).map(|_| ask(body)).collect::<Result<Vec<T>, _>>()?;
    let times = TIMES as f64;
    let ms = 1000.0 * start.elapsed().as_secs_f64() / times;
    let bytes = body.meter().since(&before).bytes() as f64 / times;
    Ok((answers, format!("{bytes:.0} bytes and {ms:.1} ms a look")))
}

fn ring(body: &mut dyn Body, calibration: &Calibration) -> Check {
    const WHAT: &str = "infra-red ring";
    let (readings, cost) = match asked(body, |b| b.proximity()) {
        Ok(found) => found,
        Err(error) => return bad(WHAT, error.to_string()),
    };
    let mean: [f64; INFRARED] =
        std::array::from_fn(|i| readings.iter().map(|r| r[i]).sum::<f64>() / readings.len() as f64);
    let seen = calibration.infrared(mean);
    let near: Vec<String> = (0..INFRARED).filter(|&i| seen[i] > 150.0).map(|i| format!("ps{i}")).collect();
    if mean.iter().all(|&m| m == mean[0]) && mean[0] >= 4095.0 {
        return bad(WHAT, "every sensor reads its maximum: switch the robot off and on".to_owned());
    }
    if near.len() > 4 {
        let names = near.join(", ");
        return doubtful(
            WHAT,
            format!("{names} report something near; free the robot and run `metal calibrate`"),
        );
    }
    good(
        WHAT,
        format!("{cost}; near: {}", if near.is_empty() { "nothing".to_owned() } else { near.join(", ") }),
    )
}

fn camera(body: &mut dyn Body, calibration: &Calibration) -> Vec<Check> {
    const WHAT: &str = "camera";
    let (pictures, cost) = match asked(body, |b| b.picture(Window::WHOLE)) {
        Ok(found) => found,
        Err(error) => return vec![bad(WHAT, error.to_string())],
    };
    let Some(last) = pictures.last() else { return vec![bad(WHAT, "no picture".to_owned())] };
    if last.pixels.iter().all(|p| p == &last.pixels[0]) {
        return vec![bad(
            WHAT,
            "every pixel is the same: is the lens covered, or the picture mode not set?".to_owned(),
        )];
    }
    let size = format!("{}×{} pixels, {cost}", last.columns, last.rows());
    vec![good(WHAT, size), colours(last, calibration)]
}

/// Shares of the colours in each region, so that one sees whether thresholds fit the light.
fn colours(picture: &Picture, calibration: &Calibration) -> Check {
    let whole = calibration.shares(picture);
    let mut finding = String::new();
    for region in Region::ALL {
        let w = region.window();
        let part = picture.cropped([w.left, w.top], [w.right - w.left, w.bottom - w.top]);
        let [black, white, red, green] = calibration.shares(&part).map(|s| (100.0 * s).round());
        // Writing to a text cannot fail.
        let _ = write!(finding, "{} {black}/{white}/{red}/{green} ", region.name());
    }
    let finding = format!("black/white/red/green in %: {}", finding.trim_end());
    if whole.iter().any(|&share| share > 0.97) {
        return doubtful(
            "colours",
            format!("{finding}; nearly one colour: run `metal calibrate` on the road"),
        );
    }
    good("colours", finding)
}

/// The checks as lines of text.
#[must_use]
pub fn text(checks: &[Check]) -> String {
    let line = |check: &Check| {
        let mark = match check.verdict {
            Verdict::Good => "ok   ",
            Verdict::Doubtful => "look ",
            Verdict::Bad => "BAD  ",
        };
        format!("{mark} {:<16} {}\n", check.what, check.finding)
    };
    checks.iter().map(line).collect()
}
