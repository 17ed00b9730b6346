//! Curves of a run while it learns: costs, looks, accidents, sizes of the models.

use super::{Studio, Wishes};
use crate::learned::{Episode, MOST_LOOKS, PhaseLog};
use metal_lab::figures::chart::{Ink, LineChart, LinePoint, Series, StackChart, StackColumn};
use metal_lab::figures::policy;

/// Points of a curve: enough to see its shape, few enough to average noise away.
const BLOCKS: usize = 30;

/// The curve called `name` of the phase that is wished for; the phase that learns now if none is.
pub fn draw(studio: &Studio, name: &str, wishes: &Wishes) -> Option<String> {
    let learned = studio.learned()?;
    let phase = wishes.get("phase").cloned().unwrap_or_else(|| learned.progress().phase);
    let log = learned.log(&phase).filter(|log| !log.episodes.is_empty())?;
    let words = phase.replace('_', " ");
    match name {
        "cost" => Some(cost(studio, &log, &words)),
        "looks" => Some(looks(&log, &words)),
        "histogram" => Some(histogram(&log, &words)),
        "accidents" => Some(accidents(&log, &words)),
        "sizes" => sizes(studio, &log, &words),
        _ => None,
    }
}

/// Consecutive parts of the episodes with the number of the last episode of each.
fn blocks(episodes: &[Episode]) -> Vec<(usize, &[Episode])> {
    let count = BLOCKS.min(episodes.len());
    let part = |b: usize| (b * episodes.len() / count, (b + 1) * episodes.len() / count);
    (0..count).map(part).map(|(from, to)| (to, &episodes[from..to])).collect()
}

/// Mean of `value` over the motor steps of each block.
fn per_step(episodes: &[Episode], value: impl Fn(&Episode) -> f64) -> Vec<LinePoint> {
    let mean = |part: &[Episode]| {
        let steps: u32 = part.iter().map(|e| e.steps).sum();
        part.iter().map(&value).sum::<f64>() / f64::from(steps.max(1))
    };
    blocks(episodes).into_iter().map(|(x, part)| point(x, mean(part))).collect()
}

fn point(x: usize, y: f64) -> LinePoint {
    LinePoint { x: x as f64, y, band: None }
}

fn line(label: &str, ink: Ink, points: Vec<LinePoint>) -> Series {
    Series { label: label.to_owned(), ink, width: 2.4, dashed: false, points }
}

fn total(e: &Episode) -> f64 {
    e.motor + e.perceptual
}

/// Motor, perceptual and total cost, and what others reached.
fn cost(studio: &Studio, log: &PhaseLog, phase: &str) -> String {
    let episodes = &log.episodes;
    let mut series = references(studio, episodes.len());
    series.push(line("motor", Ink("fixed"), per_step(episodes, |e| e.motor)));
    series.push(line("looks", Ink("lf"), per_step(episodes, |e| e.perceptual)));
    series.push(line("total", Ink("acl"), per_step(episodes, total)));
    chart(format!("Cost per motor step: {phase}"), "reward per motor step", series)
}

/// What the comparisons cost: from the finished run if there is one, else from this run's own phases, late in learning.
fn references(studio: &Studio, episodes: usize) -> Vec<Series> {
    ["foa", "fusion", "best_fixed"]
        .iter()
        .filter_map(|name| Some((*name, reference(studio, name)?)))
        .map(|(name, y)| Series {
            label: policy::short_label(name),
            ink: policy::ink(name),
            width: 1.5,
            dashed: true,
            points: vec![point(1, y), point(episodes.max(2), y)],
        })
        .collect()
}

fn reference(studio: &Studio, name: &str) -> Option<f64> {
    if let Some(results) = &studio.results {
        let key = if name == "best_fixed" { results.best_fixed.clone()? } else { name.to_owned() };
        let scenario = studio.plan.file.environment.training_scenario();
        return Some(results.policies.get(&key)?.get(&scenario)?.get("total")?.mean);
    }
    // A phase that has only begun says nothing yet.
    let log = studio.learned()?.log(name).filter(|log| log.progress >= 1.0)?;
    let late = &log.episodes[log.episodes.len() * 3 / 4..];
    let steps: u32 = late.iter().map(|e| e.steps).sum();
    (steps > 0).then(|| late.iter().map(total).sum::<f64>() / f64::from(steps))
}

fn chart(title: String, y_label: &str, series: Vec<Series>) -> String {
    LineChart { title, x_label: "episodes".to_owned(), y_label: y_label.to_owned(), series }.draw()
}

fn looks(log: &PhaseLog, phase: &str) -> String {
    let count = |e: &Episode| e.looks.iter().enumerate().map(|(k, &n)| k as f64 * f64::from(n)).sum();
    let series = vec![line("", Ink("acl"), per_step(&log.episodes, count))];
    chart(format!("Looks before a decision: {phase}"), "sensors read per motor step", series)
}

/// Fig. 9, live: shares of decisions after 0, 1, 2 … looks by age of training.
fn histogram(log: &PhaseLog, phase: &str) -> String {
    let column = |(last, part): (usize, &[Episode])| {
        let steps: u32 = part.iter().map(|e| e.steps).sum();
        let count = |k: usize| f64::from(part.iter().map(|e| e.looks[k]).sum::<u32>());
        let shares = (0..MOST_LOOKS).map(|k| count(k) / f64::from(steps.max(1))).collect();
        StackColumn { label: last.to_string(), shares }
    };
    let name = |k: usize| match k {
        0 => "no look".to_owned(),
        1 => "1 look".to_owned(),
        k => format!("{k} looks"),
    };
    StackChart {
        title: format!("Looks by share: {phase}"),
        x_label: "episodes".to_owned(),
        layers: (0..MOST_LOOKS).map(|k| (name(k), policy::looks_ink(k))).collect(),
        columns: blocks(&log.episodes).into_iter().map(column).collect(),
        width: 460.0,
    }
    .draw()
}

fn accidents(log: &PhaseLog, phase: &str) -> String {
    let share = |part: &[Episode]| {
        100.0 * part.iter().filter(|e| e.accident).count() as f64 / part.len().max(1) as f64
    };
    let points = blocks(&log.episodes).into_iter().map(|(x, part)| point(x, share(part))).collect();
    chart(format!("Episodes with an accident: {phase}"), "per cent", vec![line("", Ink("car"), points)])
}

/// How large every tiny agent's model is: Gaussians, where its learner has them.
fn sizes(studio: &Studio, log: &PhaseLog, phase: &str) -> Option<String> {
    let unit = log.units.first()?;
    let member = |m: usize, name: &str| {
        let points = log.sizes.iter().map(|(episode, sizes)| point(*episode, sizes[m] as f64)).collect();
        line(name, policy::sensor_ink(Some(name)), points)
    };
    let tiny = studio.plan.members.iter().enumerate().filter(|(_, m)| m.sensors.len() == 1);
    let series = tiny.map(|(m, plan)| member(m, &plan.name)).collect();
    Some(chart(format!("Sizes of the tiny agents: {phase}"), unit, series))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_every_episode_once() {
        let episodes = vec![Episode { steps: 50, motor: -50.0, ..Episode::default() }; 1801];
        let parts = blocks(&episodes);
        assert_eq!((parts.len(), parts.last().unwrap().0), (BLOCKS, 1801));
        assert_eq!(parts.iter().map(|(_, part)| part.len()).sum::<usize>(), 1801);
        assert!(per_step(&episodes, |e| e.motor).iter().all(|p| (p.y + 1.0).abs() < 1e-12));
        assert_eq!(blocks(&episodes[..3]).len(), 3);
        assert!(blocks(&[]).is_empty());
    }
}
