//! From tests to a report: who is cheapest at each price, and by how much.

use super::PricesOptions;
use super::trial::{Subject, Tested, Who};
use crate::reproduce::subsets::name;
use crate::reproduce::table::over_seeds;
use crate::results::Estimate;
use metal_rl::num;
use serde::{Deserialize, Serialize};

/// Everything that was found. Rewards per motor step: negative is worse. Intervals are Student's over trainings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PricesReport {
    /// Title of the experiment.
    pub title: String,
    /// Registry name of the world.
    pub world: String,
    /// How much was measured.
    pub options: PricesOptions,
    /// Attention and its best rival at each factor.
    pub prices: Vec<At>,
    /// The fixed choices, all sensors last.
    pub fixed: Vec<Row>,
    /// Share of what the best fixed choice costs that attention saves, over all factors: the area between the two lines
    /// of total cost by the area below that of the best fixed choice. None with one factor.
    pub saved: Option<Estimate>,
}

/// One policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Who.
    pub name: String,
    /// Motor reward.
    pub motor: Estimate,
    /// Looks.
    pub looks: Estimate,
    /// What looks cost at the prices it was trained with.
    pub price: Estimate,
    /// Motor reward of each training.
    pub trainings: Vec<f64>,
}

/// One factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct At {
    /// What prices are multiplied by.
    pub factor: f64,
    /// Attention, trained at these prices.
    pub attention: Row,
    /// Its total.
    pub total: Estimate,
    /// The fixed choice that is cheapest here by its mean over the same trainings, which flatters it.
    pub best: String,
    /// Its motor reward.
    pub best_motor: Estimate,
    /// Its total.
    pub best_total: Estimate,
    /// Attention's total by that of the best fixed choice, paired by training; none where that costs nothing.
    pub ratio: Option<Estimate>,
}

/// All trainings of somebody.
type Trainings<'t> = &'t [Tested];

pub(super) fn write(subject: &Subject<'_>, everybody: &[Who], tested: &[Trainings<'_>]) -> PricesReport {
    let mut attention: Vec<(f64, Trainings<'_>)> = Vec::new();
    let mut fixed: Vec<(String, Trainings<'_>)> = Vec::new();
    for (who, &trainings) in everybody.iter().zip(tested) {
        match who {
            Who::Attention { factor } => attention.push((*factor, trainings)),
            Who::Fixed(rival) => fixed.push((name(subject.plan, *rival), trainings)),
        }
    }
    let costs = Costs::new(&attention, &fixed);
    PricesReport {
        title: subject.plan.file.title.clone(),
        world: subject.plan.spec.id.clone(),
        options: subject.options.clone(),
        prices: attention.iter().map(|&at| at_price(at, &fixed)).collect(),
        fixed: fixed.iter().map(|(name, trainings)| row(name, trainings)).collect(),
        saved: costs.saved(),
    }
}

fn estimate(trainings: Trainings<'_>, of: impl Fn(&Tested) -> f64) -> Estimate {
    let values: Vec<f64> = trainings.iter().map(of).collect();
    over_seeds(&values).unwrap_or(Estimate::point(f64::NAN, values.len()))
}

fn row(name: &str, trainings: Trainings<'_>) -> Row {
    Row {
        name: name.to_owned(),
        motor: estimate(trainings, |t| t.motor),
        looks: estimate(trainings, |t| t.looks),
        price: estimate(trainings, |t| t.price),
        trainings: trainings.iter().map(|t| t.motor).collect(),
    }
}

/// Total reward of a fixed choice where prices are multiplied by `factor`.
fn total_at(factor: f64) -> impl Fn(&Tested) -> f64 {
    move |t| t.motor - factor * t.price
}

/// The fixed choice with the best mean total at `factor`.
fn best_at<'f, 't>(factor: f64, fixed: &'f [(String, Trainings<'t>)]) -> &'f (String, Trainings<'t>) {
    let totals: Vec<f64> =
        fixed.iter().map(|(_, trainings)| trainings.iter().map(total_at(factor)).sum::<f64>()).collect();
    &fixed[num::argmax(&totals)]
}

fn at_price((factor, trainings): (f64, Trainings<'_>), fixed: &[(String, Trainings<'_>)]) -> At {
    let (best, theirs) = best_at(factor, fixed);
    let own = |t: &Tested| t.motor - t.price;
    let pairs = || trainings.iter().zip(*theirs).map(|(a, b)| (own(a), total_at(factor)(b)));
    let ratios: Vec<f64> = pairs().map(|(a, b)| a / b).collect();
    At {
        factor,
        attention: row("attention", trainings),
        total: estimate(trainings, own),
        best: best.clone(),
        best_motor: estimate(theirs, |t| t.motor),
        best_total: estimate(theirs, total_at(factor)),
        ratio: if pairs().all(|(_, b)| b < 0.0) { over_seeds(&ratios) } else { None },
    }
}

/// Total costs by factor, training by training: attention, and the best fixed choice.
struct Costs {
    factors: Vec<f64>,
    /// One list per training: both costs at every factor.
    trainings: Vec<Vec<[f64; 2]>>,
}

impl Costs {
    fn new(attention: &[(f64, Trainings<'_>)], fixed: &[(String, Trainings<'_>)]) -> Self {
        let count = attention.first().map_or(0, |(_, trainings)| trainings.len());
        let at = |i: usize, (factor, trainings): &(f64, Trainings<'_>)| {
            let (_, theirs) = best_at(*factor, fixed);
            [trainings[i].price - trainings[i].motor, -total_at(*factor)(&theirs[i])]
        };
        let training = |i: usize| attention.iter().map(|row| at(i, row)).collect();
        Self {
            factors: attention.iter().map(|(factor, _)| *factor).collect(),
            trainings: (0..count).map(training).collect(),
        }
    }

    fn saved(&self) -> Option<Estimate> {
        if self.factors.len() < 2 {
            return None;
        }
        let one = |costs: &Vec<[f64; 2]>| {
            let [ours, theirs] = [0, 1].map(|k| area(&self.factors, costs.iter().map(|c| c[k])));
            (theirs - ours) / theirs
        };
        over_seeds(&self.trainings.iter().map(one).collect::<Vec<_>>())
    }
}

/// Area below a line through these points.
fn area(x: &[f64], y: impl Iterator<Item = f64>) -> f64 {
    let y: Vec<f64> = y.collect();
    let pieces = x.windows(2).zip(y.windows(2));
    pieces.map(|(x, y)| 0.5 * (y[0] + y[1]) * (x[1] - x[0])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tested(motor: f64, price: f64) -> Tested {
        Tested { motor, price, looks: price }
    }

    #[test]
    fn a_fixed_choice_pays_by_the_factor_and_the_best_is_chosen_at_each() {
        let (few, many) = ([tested(-4.0, 1.0), tested(-6.0, 1.0)], [tested(-1.0, 7.0), tested(-1.0, 7.0)]);
        let fixed = vec![("few".to_owned(), &few[..]), ("many".to_owned(), &many[..])];
        assert_eq!(best_at(0.0, &fixed).0, "many");
        assert_eq!(best_at(1.0, &fixed).0, "few");
        let own = [tested(-2.0, 1.0), tested(-4.0, 1.0)];
        let at = at_price((1.0, &own), &fixed);
        assert_eq!((at.best.as_str(), at.best_total.mean, at.total.mean), ("few", -6.0, -4.0));
        let ratio = at.ratio.unwrap();
        assert!((ratio.mean - 0.5 * (3.0 / 5.0 + 5.0 / 7.0)).abs() < 1e-12, "paired by training");
    }

    #[test]
    fn what_is_saved_is_the_area_between_by_the_area_below() {
        // The best fixed choice costs 2 at factor 0 and 4 at factor 2; attention half of that.
        let fixed_runs = [tested(-2.0, 1.0), tested(-2.0, 1.0)];
        let fixed = vec![("one".to_owned(), &fixed_runs[..])];
        let (free, dear) = ([tested(-1.0, 0.0); 2], [tested(-1.5, 0.5); 2]);
        let attention: Vec<(f64, Trainings<'_>)> = vec![(0.0, &free[..]), (2.0, &dear[..])];
        let saved = Costs::new(&attention, &fixed).saved().unwrap();
        assert!((saved.mean - 0.5).abs() < 1e-12);
        assert_eq!(Costs::new(&attention[..1], &fixed).saved(), None, "one price has no area");
    }

    #[test]
    fn where_the_rival_costs_nothing_there_is_no_ratio() {
        let idle = [tested(0.0, 0.0)];
        let at = at_price((1.0, &[tested(-1.0, 0.0)]), &[("idle".to_owned(), &idle[..])]);
        assert_eq!(at.ratio, None);
    }
}
