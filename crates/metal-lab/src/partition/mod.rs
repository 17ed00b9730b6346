//! `metal partition`: which sensors should make one tiny agent, proposed from a demonstration. Sec. 4.2, reading R132.
//!
//! In the order of the data: `watch` (the expert drives, every sensor is read) → groups of sensors
//! ([`metal_rl::partition`]) → [`Proposal`] with its table (`print`), its picture (`draw`) and an experiment whose members
//! are the groups (`file`).

mod draw;
mod file;
mod options;
mod print;
#[cfg(test)]
mod tests;
mod watch;

pub use draw::draw;
pub use options::{Criterion, PartitionOptions};
pub use print::text;

use crate::plan::{Plan, PlanError};
use crate::progress::Progress;
use crate::train::RunError;
use metal_rl::partition::alike::distances;
use metal_rl::partition::growth::{Worth, grown};
use metal_rl::partition::linkage::{best_silhouette, clustered, silhouette};
use metal_rl::partition::telling::Telling;
use metal_rl::partition::{Groups, Shown, dealt};
use metal_rl::random::Streams;
use serde::Serialize;

/// A group of sensors: a tiny agent to be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Name of the member.
    pub name: String,
    /// Its sensors, in the order of the world.
    pub sensors: Vec<String>,
    /// Price of a look at all of them.
    pub price: f64,
    /// Share of the variance of the expert's actions that the group explains in episodes it was not fitted to.
    pub tells: f64,
    /// Mean distance of its sensors from each other: 0 alike, 1 independent; none if there is only one.
    pub apart: Option<f64>,
}

/// What is proposed.
#[derive(Clone, Debug, Serialize)]
pub struct Proposal {
    /// Name of the world.
    pub world: String,
    /// How it was found.
    pub options: PartitionOptions,
    /// Episodes of the demonstration.
    pub episodes: usize,
    /// How often the expert did what, in the order of the world's actions.
    pub actions: Vec<(String, usize)>,
    /// The groups, who tells most first.
    pub groups: Vec<Group>,
    /// What all sensors together tell.
    pub everything: f64,
    /// Mean silhouette of the groups.
    pub silhouette: f64,
    /// The experiment with the groups as members.
    #[serde(skip)]
    pub plan: Plan,
}

/// Watches the expert and proposes members. The same plan and options give the same proposal.
///
/// # Errors
/// If options do not fit the plan, nobody demonstrates in its world, the world fails, the groups cannot take the places
/// of the plan's members, or the user interrupts.
pub fn run(plan: &Plan, options: &PartitionOptions, progress: &dyn Progress) -> Result<Proposal, RunError> {
    options.check()?;
    let template = file::Template::of(plan, options)?;
    let streams = Streams::new(options.seed).child("partition");
    let shown = watch::watch(plan, &template.sensors, options, (&streams, progress))?;
    let desk = Desk::new(plan, &template, &shown, options);
    let groups = desk.named(desk.groups(&streams)?, &template);
    let count = |a: usize| shown.actions.iter().filter(|&&done| done == a).count();
    Ok(Proposal {
        world: plan.spec.id.clone(),
        options: options.clone(),
        episodes: shown.episodes.last().map_or(0, |last| last + 1),
        actions: plan.spec.actions.iter().enumerate().map(|(a, name)| (name.clone(), count(a))).collect(),
        everything: desk.telling.of_group(&desk.everything()),
        silhouette: silhouette(&desk.places(&groups), &desk.distances),
        plan: template.filled(plan, &groups, options)?,
        groups,
    })
}

/// What a demonstration says about its sensors.
struct Desk<'a> {
    names: Vec<&'a str>,
    prices: Vec<f64>,
    distances: Vec<Vec<f64>>,
    telling: Telling,
    options: &'a PartitionOptions,
}

impl<'a> Desk<'a> {
    fn new(plan: &'a Plan, template: &file::Template, shown: &Shown, options: &'a PartitionOptions) -> Self {
        let spec = |s: &usize| &plan.spec.sensors[*s];
        Self {
            names: template.sensors.iter().map(|s| spec(s).name.as_str()).collect(),
            prices: template.sensors.iter().map(|s| spec(s).price).collect(),
            distances: distances(shown, options.levels),
            telling: Telling::of(shown),
            options,
        }
    }

    fn groups(&self, streams: &Streams) -> Result<Groups, PlanError> {
        let (sensors, wanted) = (self.names.len(), self.options.groups);
        if wanted.is_some_and(|groups| groups > sensors) {
            let message = format!("{}: at most {sensors}, one per sensor", wanted.unwrap_or_default());
            return Err(PlanError::at("groups", message));
        }
        let most = self.options.most.min(sensors);
        Ok(match self.options.by {
            Criterion::Alike => match wanted {
                Some(groups) => clustered(&self.distances, groups),
                None => best_silhouette(&self.distances, most),
            },
            Criterion::Worth => {
                self.check_telling()?;
                grown(&Worth::new(&self.telling, &self.prices, self.options.thrift), wanted.unwrap_or(most))
            }
            Criterion::Random => dealt(sensors, wanted.unwrap_or(most), &mut streams.stream("deal")),
        })
    }

    /// Where nothing can be told there is nothing to weigh prices against.
    fn check_telling(&self) -> Result<(), PlanError> {
        if self.telling.of_group(&self.everything()) > 0.0 {
            return Ok(());
        }
        let message = format!(
            "{}: too few, or there is nothing to see: all sensors together tell nothing of what the expert does in \
             episodes they were not fitted to",
            self.options.steps
        );
        Err(PlanError::at("steps", message))
    }

    fn everything(&self) -> Vec<usize> {
        (0..self.names.len()).collect()
    }

    /// Groups with what they tell, the most telling first.
    fn named(&self, groups: Groups, template: &file::Template) -> Vec<Group> {
        let mut rated: Vec<(f64, Vec<usize>)> =
            groups.into_iter().map(|group| (self.telling.of_group(&group), group)).collect();
        rated.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
        let one = |((tells, group), name): ((f64, Vec<usize>), String)| Group {
            name,
            price: group.iter().map(|&s| self.prices[s]).sum(),
            tells,
            apart: self.apart(&group),
            sensors: group.iter().map(|&s| self.names[s].to_owned()).collect(),
        };
        rated.into_iter().zip(template.free_names()).map(one).collect()
    }

    fn apart(&self, group: &[usize]) -> Option<f64> {
        let pairs = || group.iter().enumerate().flat_map(|(n, &i)| group[..n].iter().map(move |&j| (i, j)));
        let sum: f64 = pairs().map(|(i, j)| self.distances[i][j]).sum();
        (group.len() > 1).then(|| sum / pairs().count() as f64)
    }

    fn places(&self, groups: &[Group]) -> Groups {
        let place = |name: &String| self.names.iter().position(|known| known == name);
        groups.iter().map(|group| group.sensors.iter().filter_map(place).collect()).collect()
    }
}
