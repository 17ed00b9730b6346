//! What a single value of an experiment file may be.

use super::error::PlanError;
use metal_rl::explore::Schedule;
use metal_rl::learner::Rate;
use metal_rl::phase::Budget;
use metal_rl::policies::AttentionConfig;
use metal_rl::returns::Credit;

/// Most episodes or steps of anything: no machine gets there, and no sum of them overflows.
const MOST: usize = 100_000_000;

/// A name nobody on the list of `known` names has.
pub(crate) fn unknown<'a>(
    field: impl Into<String>,
    kind: &str,
    found: &str,
    known: impl Iterator<Item = &'a str>,
) -> PlanError {
    let known: Vec<&str> = known.collect();
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    PlanError::at(field, format!("unknown {kind} `{found}`; known: {known}"))
}

/// Names become file names, keys of results and parts of dotted paths.
pub(crate) fn name(table: &str, name: &str) -> Result<(), PlanError> {
    let plain = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(plain) {
        return Ok(());
    }
    Err(PlanError::at(table, format!("the name `{name}`: names are made of letters, digits, `_` and `-`")))
}

/// Whether a list says everything once.
pub(crate) fn once(field: &str, list: &[String]) -> Result<(), PlanError> {
    match list.iter().enumerate().find(|(i, entry)| list[..*i].contains(entry)) {
        Some((_, entry)) => Err(PlanError::at(field, format!("`{entry}` twice"))),
        None => Ok(()),
    }
}

/// A count that must be at least 1.
pub(crate) fn count(field: &str, n: usize, what: &str) -> Result<(), PlanError> {
    if (1..=MOST).contains(&n) {
        return Ok(());
    }
    Err(PlanError::at(field, format!("{n}: between 1 and {MOST} {what}")))
}

pub(crate) fn budget(field: &str, budget: Budget) -> Result<(), PlanError> {
    match budget {
        Budget::Episodes(n) => count(&format!("{field}.episodes"), n, "episodes"),
        Budget::Steps(n) => count(&format!("{field}.steps"), n, "motor steps"),
    }
}

pub(crate) fn rate(field: &str, rate: Rate) -> Result<(), PlanError> {
    let (kind, step) = match rate {
        Rate::Full => return Ok(()),
        Rate::Constant(step) => ("constant", step),
        Rate::Average(step) => ("average", step),
    };
    if step > 0.0 && step <= 1.0 {
        return Ok(());
    }
    Err(PlanError::at(format!("{field}.{kind}"), format!("{step}: a step size in (0, 1]")))
}

pub(crate) fn credit(field: &str, credit: Credit) -> Result<(), PlanError> {
    if !(0.0..1.0).contains(&credit.gamma) {
        return Err(PlanError::at(
            format!("{field}.gamma"),
            format!("{}: a discount in [0, 1)", credit.gamma),
        ));
    }
    share(&format!("{field}.lambda"), credit.lambda)
}

fn share(field: &str, value: f64) -> Result<(), PlanError> {
    if (0.0..=1.0).contains(&value) {
        return Ok(());
    }
    Err(PlanError::at(field, format!("{value}: a share in [0, 1]")))
}

pub(crate) fn schedule(field: &str, schedule: Schedule) -> Result<(), PlanError> {
    let (kind, from, to, until) = match schedule {
        Schedule::Greedy => return Ok(()),
        Schedule::SoftMax { from, to, until } => ("soft_max", from, to, until),
        Schedule::Random { from, to, until } => ("random", from, to, until),
    };
    for (end, value) in [("from", from), ("to", to)] {
        let field = format!("{field}.{kind}.{end}");
        if kind == "random" && !(value > 0.0 && value <= 1.0) {
            return Err(PlanError::at(field, format!("{value}: a probability in (0, 1]")));
        }
        if !(value > 0.0 && value.is_finite()) {
            return Err(PlanError::at(field, format!("{value}: a temperature above 0, and finite")));
        }
    }
    part(&format!("{field}.{kind}.until"), until)
}

/// A share that may not be nothing.
pub(crate) fn part(field: &str, value: f64) -> Result<(), PlanError> {
    if value > 0.0 && value <= 1.0 {
        return Ok(());
    }
    Err(PlanError::at(field, format!("{value}: a share in (0, 1]")))
}

pub(crate) fn attention(field: &str, s: &AttentionConfig) -> Result<(), PlanError> {
    credit(&format!("{field}.credit"), s.credit)?;
    rate(&format!("{field}.rate"), s.rate)?;
    share(&format!("{field}.price_ramp"), s.price_ramp)?;
    if !s.encoding.null.is_finite() {
        return Err(PlanError::at(
            format!("{field}.encoding.null"),
            format!("{}: a finite number", s.encoding.null),
        ));
    }
    if s.min_looks > s.max_looks {
        let message = format!("{} looks at least, but {} at most", s.min_looks, s.max_looks);
        return Err(PlanError::at(format!("{field}.min_looks"), message));
    }
    Ok(())
}
