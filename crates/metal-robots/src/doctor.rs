//! `metal doctor`: what is wrong with a body, one check after the other. The wheels do not turn.

use crate::body::{Body, Feelings, INFRARED};
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
        Ok(facts) => {
            let name = body.name().to_owned();
            checks.extend(facts.into_iter().map(|(what, found)| fact(&name, what, found)));
        }
        Err(error) => {
            checks.push(bad("link", format!("{error}; is the robot on, near and alone on the link?")))
        }
    }
    checks.push(ring(body, calibration));
    checks.push(other_sensors(body));
    checks.extend(camera(body, calibration));
    checks
}

/// Whether what a body says of itself is as it should be.
fn fact(body: &str, what: String, found: String) -> Check {
    match (body, what.as_str()) {
        ("epuck", "firmware") if !found.contains("ersion") => {
            let advice = "BTcom and the advanced sercom answer with their version; flash one of them";
            doubtful(&what, format!("`{found}`: {advice}"))
        }
        ("epuck2", "selector") if found != "15" => doubtful(&what, format!("{found}; Wi-Fi wants 15")),
        ("webots", "supervisor") if found != "yes" => doubtful(
            &what,
            format!("{found}: rewards are felt, not known, and nobody is placed for an episode"),
        ),
        _ => good(what, found),
    }
}

/// Wheels, acceleration, light and whatever else there is.
fn other_sensors(body: &mut dyn Body) -> Check {
    const WHAT: &str = "other sensors";
    match body.feel() {
        Ok(felt) => told(WHAT, &felt),
        Err(error) => {
            bad(WHAT, format!("{error}; an e-puck2 on a serial line needs `?second`, a first E-puck none"))
        }
    }
}

fn told(what: &str, felt: &Feelings) -> Check {
    let named = [
        ("step counters", felt.rolled_m.is_some()),
        ("light", felt.ambient.is_some()),
        ("acceleration", felt.acceleration_mps2.is_some()),
        ("turning rates", felt.turn_radps.is_some()),
        ("ground", felt.ground.is_some()),
        ("time of flight", felt.ahead_m.is_some()),
    ];
    let there: Vec<&str> = named.iter().filter(|(_, there)| *there).map(|(name, _)| *name).collect();
    let names = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
    match felt.acceleration_mps2 {
        Some([_, _, up]) if !(7.0..13.0).contains(&up) => {
            doubtful(what, format!("{names}; upwards {up:.1} m/s², not 9.8: does the robot lie on its side?"))
        }
        _ => good(what, names),
    }
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
    Ok((answers, format!("{bytes:.0} bytes and {ms:.2} ms a look")))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(body: &str, what: &str, found: &str) -> Verdict {
        fact(body, what.to_owned(), found.to_owned()).verdict
    }

    #[test]
    fn facts_that_are_wrong_for_the_body_are_to_be_looked_at() {
        assert_eq!(verdict("epuck", "firmware", "Version 1.1.3 September 2011"), Verdict::Good);
        assert_eq!(verdict("epuck", "firmware", "hello"), Verdict::Doubtful);
        assert_eq!(verdict("epuck2", "selector", "15"), Verdict::Good);
        assert_eq!(verdict("epuck2", "selector", "3"), Verdict::Doubtful);
        assert_eq!(verdict("epuck", "selector", "3"), Verdict::Good, "only Wi-Fi wants 15");
        assert_eq!(verdict("webots", "supervisor", "no"), Verdict::Doubtful);
    }

    #[test]
    fn a_robot_on_its_side_is_noticed() {
        let lying = |up| Feelings { acceleration_mps2: Some([0.0, 0.0, up]), ..Feelings::default() };
        assert_eq!(told("x", &lying(9.8)).verdict, Verdict::Good);
        assert_eq!(told("x", &lying(0.3)).verdict, Verdict::Doubtful);
        assert_eq!(told("x", &Feelings::default()).finding, "none");
    }
}
