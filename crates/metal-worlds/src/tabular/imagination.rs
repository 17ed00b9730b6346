//! Rows that nobody has seen: drawn from a model of those that somebody has.
//!
//! A few hundred rows are learned by heart before looks are learned. The model is a naive Bayes classifier in each of a
//! few clusters of rows; clusters are found without the classes, so what only says how to read the rest (a context)
//! becomes a cluster. Everything that must be chosen is chosen by the class's log-loss on rows held out, seen through
//! random columns.

use super::mixture::{Gauss, Matrix, Moments, clusters, moments};
use super::scales::{Scale, Units};
use super::{Column, Data, Group, Verdict};
use metal_rl::belief::{Belief, Hypothesis, Number};
use metal_rl::num;
use metal_rl::random::{Rng, Streams};

/// Numbers of clusters that are tried.
const CLUSTERS: [usize; 5] = [1, 2, 3, 5, 8];
/// Rows' worth of belief that a class spreads in a column as all classes of its cluster do: what is tried.
const BELIEFS: [f64; 3] = [5.0, 20.0, 80.0];
/// Parts into which rows are cut for the choice.
const FOLDS: usize = 4;
/// Belief that there may be rows of a class where none was seen.
const UNSEEN: f64 = 0.05;
/// Smallest variance, in units of the column's own.
const SMALLEST: f64 = 0.02;
/// A column of so few different values delivers no others.
const DISCRETE: usize = 16;

/// A model of rows with classes.
#[derive(Clone, Debug)]
pub struct Imagination {
    scales: Vec<Scale>,
    rows: Vec<usize>,
    shares: Vec<Vec<f64>>,
    classes: Classes,
}

/// What classes look like in every cluster: prior (logarithm) and Gaussian by cluster, then class.
#[derive(Clone, Debug)]
struct Classes(Vec<Vec<(f64, Gauss)>>);

/// How rows are modelled.
#[derive(Clone, Copy, Debug)]
struct Choice {
    units: Units,
    clusters: usize,
    belief: f64,
}

impl Imagination {
    /// The model of `rows` of `data` (at least as many as folds) that tells classes best.
    #[must_use]
    pub fn of(data: &Data, rows: &[usize], streams: &Streams) -> Self {
        let choice = choose(data, rows, streams);
        let mut rng = streams.stream("clusters");
        let (scales, matrix) = scaled(data, (rows, rows), choice.units);
        let shares = clusters(&matrix, choice.clusters, &mut rng);
        let labels: Vec<usize> = rows.iter().map(|&r| data.labels[r]).collect();
        let classes = Classes::of(&matrix, &shares, (&labels, data.classes.len()), choice.belief);
        Self { scales, rows: rows.to_vec(), shares, classes }
    }

    /// A row that could have been: its cells, and its class. What is absent in it is absent in a row that was seen.
    #[must_use]
    pub fn draw(&self, data: &Data, rng: &mut Rng) -> (Vec<Option<f64>>, usize) {
        let place = rng.below(self.rows.len());
        let row = self.rows[place];
        let weights: Vec<f64> = self.shares.iter().map(|s| s[place]).collect();
        let label = data.labels[row];
        let (_, gauss) = &self.classes.0[rng.pick(&weights)][label];
        let cell = |(j, column): (usize, &Column)| {
            let z = gauss.mean[j] + gauss.variance[j].sqrt() * rng.normal();
            let value = self.scales[j].back(z).clamp(column.low, column.high);
            column.values[row].map(|_| self.scales[j].nearest(value, DISCRETE))
        };
        (data.columns.iter().enumerate().map(cell).collect(), label)
    }
}

impl Imagination {
    /// What the model believes, for whoever buys the groups of `data` at this verdict.
    #[must_use]
    pub fn belief(&self, data: &Data, verdict: Verdict) -> Belief {
        let columns: Vec<usize> = data.groups.iter().flat_map(|g| g.columns.iter().copied()).collect();
        let length = |g: &Group| g.columns.iter().map(|&c| numbers(&data.columns[c])).sum();
        let number = |&c: &usize| {
            let column = &data.columns[c];
            let value = Number::Value {
                ruler: self.scales[c].ruler(column.low, column.high),
                nullable: column.nullable,
            };
            std::iter::once(value).chain(column.nullable.then_some(Number::Known))
        };
        let spread = |of: &[f64]| -> Vec<f64> {
            columns.iter().flat_map(|&c| vec![of[c]; numbers(&data.columns[c])]).collect()
        };
        let hypothesis = |(class, (log_prior, gauss)): (usize, &(f64, Gauss))| Hypothesis {
            log_prior: *log_prior,
            class,
            means: spread(&gauss.mean),
            variances: spread(&gauss.variance),
        };
        let hypotheses = self.classes.0.iter().flat_map(|cluster| cluster.iter().enumerate().map(hypothesis));
        let classes = data.classes.len();
        let reward =
            |class: usize, action: usize| if class == action { verdict.right } else { verdict.wrong };
        let rewards = (0..classes).map(|c| (0..classes).map(|a| reward(c, a)).collect()).collect();
        Belief::new(
            data.groups.iter().map(length).collect(),
            columns.iter().flat_map(number).collect(),
            hypotheses.collect(),
            rewards,
        )
    }
}

/// How many numbers a column delivers.
fn numbers(column: &Column) -> usize {
    1 + usize::from(column.nullable)
}

impl Data {
    /// The same columns, groups and classes with `count` imagined rows in place of these.
    #[must_use]
    pub fn imagined(&self, rows: &[usize], count: usize, streams: &Streams) -> Self {
        self.drawn_from(&Imagination::of(self, rows, &streams.child("model")), count, streams)
    }

    /// The same with rows drawn from `model`.
    #[must_use]
    pub fn drawn_from(&self, model: &Imagination, count: usize, streams: &Streams) -> Self {
        let mut rng = streams.stream("draws");
        let empty = |c: &Column| Column { values: Vec::with_capacity(count), ..c.clone() };
        let mut columns: Vec<Column> = self.columns.iter().map(empty).collect();
        let mut labels = Vec::with_capacity(count);
        for _ in 0..count {
            let (cells, label) = model.draw(self, &mut rng);
            columns.iter_mut().zip(cells).for_each(|(column, cell)| column.values.push(cell));
            labels.push(label);
        }
        Self { columns, labels, ..self.clone() }
    }
}

/// The rows `shown` in the units of the rows `known`.
fn scaled(data: &Data, (known, shown): (&[usize], &[usize]), units: Units) -> (Vec<Scale>, Matrix) {
    let scale = |c: &Column| Scale::of(known.iter().filter_map(|&r| c.values[r]).collect(), units);
    let scales: Vec<Scale> = data.columns.iter().map(scale).collect();
    let width = data.columns.len();
    let mut values = Vec::with_capacity(shown.len() * width);
    for &row in shown {
        for (column, scale) in data.columns.iter().zip(&scales) {
            values.push(column.values[row].map_or(f64::NAN, |x| scale.there(x)));
        }
    }
    (scales, Matrix { values, width })
}

/// What tells classes best on rows held out.
fn choose(data: &Data, rows: &[usize], streams: &Streams) -> Choice {
    let mut order = rows.to_vec();
    streams.stream("folds").shuffle(&mut order);
    let mut best = (f64::INFINITY, Choice { units: Units::Spread, clusters: 1, belief: BELIEFS[1] });
    for units in [Units::Spread, Units::Ranks] {
        for clusters in CLUSTERS {
            let losses = losses(data, &order, (units, clusters), &streams.nth(clusters as u64));
            for (belief, loss) in BELIEFS.into_iter().zip(losses) {
                if loss < best.0 {
                    best = (loss, Choice { units, clusters, belief });
                }
            }
        }
    }
    best.1
}

/// Log-loss on rows held out, for every belief.
fn losses(
    data: &Data,
    order: &[usize],
    (units, count): (Units, usize),
    streams: &Streams,
) -> [f64; BELIEFS.len()] {
    let mut losses = [0.0; BELIEFS.len()];
    for fold in 0..FOLDS {
        let part = |held: bool| {
            let mine = order.iter().enumerate().filter(|(i, _)| (i % FOLDS == fold) == held);
            mine.map(|(_, r)| *r).collect::<Vec<usize>>()
        };
        let (known, held) = (part(false), part(true));
        let labels = |rows: &[usize]| rows.iter().map(|&r| data.labels[r]).collect::<Vec<usize>>();
        let (_, matrix) = scaled(data, (&known, &known), units);
        let (_, mut test) = scaled(data, (&known, &held), units);
        blindfold(&mut test, &mut streams.nth(fold as u64).stream("columns"));
        let shares = clusters(&matrix, count, &mut streams.nth(fold as u64).stream("clusters"));
        for (loss, belief) in losses.iter_mut().zip(BELIEFS) {
            let classes = Classes::of(&matrix, &shares, (&labels(&known), data.classes.len()), belief);
            *loss += classes.loss(&test, &labels(&held));
        }
    }
    losses
}

/// Hides a random number of random columns of each row.
fn blindfold(matrix: &mut Matrix, rng: &mut Rng) {
    let mut columns: Vec<usize> = (0..matrix.width).collect();
    for row in 0..matrix.rows() {
        rng.shuffle(&mut columns);
        for &j in &columns[..rng.below(matrix.width)] {
            matrix.values[row * matrix.width + j] = f64::NAN;
        }
    }
}

impl Classes {
    fn of(matrix: &Matrix, shares: &[Vec<f64>], (labels, classes): (&[usize], usize), belief: f64) -> Self {
        let model = |weights: &Vec<f64>| {
            let whole = moments(matrix, weights);
            let own = |class: usize| {
                let weight = |(w, l): (&f64, &usize)| if *l == class { *w } else { 0.0 };
                let weights: Vec<f64> = weights.iter().zip(labels).map(weight).collect();
                (weights.iter().sum::<f64>(), moments(matrix, &weights))
            };
            let own: Vec<(f64, Moments)> = (0..classes).map(own).collect();
            let common = common(&own, matrix.width);
            let total = matrix.rows() as f64;
            let one = |(n, m): &(f64, Moments)| {
                (num::ln((n + UNSEEN) / total), gauss(m, (&whole.mean, &common), belief))
            };
            own.iter().map(one).collect()
        };
        Self(shares.iter().map(model).collect())
    }

    /// Sum of the log-losses of the classes of the rows.
    fn loss(&self, matrix: &Matrix, labels: &[usize]) -> f64 {
        let mut sum = 0.0;
        for (i, &label) in labels.iter().enumerate() {
            let row = matrix.row(i);
            let joint = |class: usize| {
                let logs: Vec<f64> =
                    self.0.iter().map(|c| c[class].0 + c[class].1.log_density(row)).collect();
                num::log_sum_exp(&logs)
            };
            let all: Vec<f64> = (0..self.0[0].len()).map(joint).collect();
            sum += num::log_sum_exp(&all) - all[label];
        }
        sum
    }
}

/// Variance within classes, column by column.
fn common(own: &[(f64, Moments)], width: usize) -> Vec<f64> {
    let column = |j: usize| {
        let scatter: f64 = own.iter().map(|(_, m)| m.scatter[j]).sum();
        let freedom: f64 = own.iter().map(|(_, m)| m.weight[j]).sum::<f64>() - own.len() as f64;
        scatter / freedom.max(1.0) + SMALLEST
    };
    (0..width).map(column).collect()
}

/// A class in a cluster. Its means are pulled to the cluster's the more, the less they stand out of their own error
/// (James and Stein): most columns tell nothing, and what they seem to tell by chance must not add up.
fn gauss(own: &Moments, (centre, common): (&[f64], &[f64]), belief: f64) -> Gauss {
    let mean = |j: usize| {
        let off = own.mean[j] - centre[j];
        let error = common[j] / own.weight[j].max(1e-9);
        centre[j] + off * (1.0 - error / (off * off).max(1e-12)).max(0.0)
    };
    let variance = |j: usize| (own.scatter[j] + belief * common[j]) / (own.weight[j] + belief);
    let width = 0..centre.len();
    Gauss::new(width.clone().map(mean).collect(), width.map(variance).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{CubeConfig, CubeNmConfig, cube, cube_nm};
    use super::*;

    fn rows(data: &Data) -> Vec<usize> {
        (0..data.labels.len()).collect()
    }

    #[test]
    fn imagined_rows_of_the_cube_have_its_corners() {
        let data = cube(&CubeConfig { rows: 300, ..CubeConfig::default() });
        let imagined = data.imagined(&rows(&data), 4000, &Streams::new(1));
        // Class 3 is the corner (1, 1, 0) in columns 3, 4, 5; elsewhere noise around 0.5.
        for (column, wanted, spread) in [(3, 1.0, 0.1), (4, 1.0, 0.1), (5, 0.0, 0.1), (12, 0.5, 0.3)] {
            let mine = |r: &usize| imagined.labels[*r] == 3;
            let cells: Vec<f64> = rows(&imagined)
                .iter()
                .filter(|r| mine(r))
                .filter_map(|&r| imagined.columns[column].values[r])
                .collect();
            let mean = cells.iter().sum::<f64>() / cells.len() as f64;
            let sd = (cells.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / cells.len() as f64).sqrt();
            assert!((mean - wanted).abs() < 0.1, "column {column}: {mean}");
            assert!((sd - spread).abs() < 0.12, "column {column}: {sd}");
        }
    }

    #[test]
    fn contexts_become_clusters() {
        let data = cube_nm(&CubeNmConfig { rows: 300, contexts: 2, ..CubeNmConfig::default() });
        let imagined = data.imagined(&rows(&data), 2000, &Streams::new(1));
        // Where both context columns are far from 0 and 1, nobody knows which block to read.
        let clear = |r: &usize| {
            let (a, b) = (imagined.columns[0].values[*r], imagined.columns[1].values[*r]);
            a.zip(b).is_some_and(|(a, b)| (a - b).abs() > 0.6)
        };
        let share = rows(&imagined).iter().filter(|r| clear(r)).count() as f64 / 2000.0;
        assert!(share > 0.9, "{share}");
    }

    #[test]
    fn what_is_absent_or_discrete_stays_so() {
        let values = |f: &dyn Fn(usize) -> Option<f64>| (0..60).map(f).collect::<Vec<_>>();
        let columns = vec![
            Column::new("holes", values(&|i| (i % 3 != 0).then_some(i as f64))),
            Column::new("bit", values(&|i| Some((i % 2) as f64))),
        ];
        let groups = vec![super::super::Group { name: "g".into(), columns: vec![0, 1], price: 0.1 }];
        let labels = (0..60).map(|i| i % 2).collect();
        let data = Data::new("X-v0", columns, groups, (vec!["a".into(), "b".into()], labels)).unwrap();
        let imagined = data.imagined(&rows(&data), 3000, &Streams::new(2));
        let holes = imagined.columns[0].values.iter().filter(|v| v.is_none()).count() as f64 / 3000.0;
        assert!((holes - 1.0 / 3.0).abs() < 0.05, "{holes}");
        assert!(imagined.columns[1].values.iter().flatten().all(|&x| x == 0.0 || x == 1.0));
        let told =
            (0..3000).filter(|&r| imagined.columns[1].values[r] == Some(imagined.labels[r] as f64)).count();
        assert!(told > 2900, "{told}");
    }

    /// Everything that a sensor of the table delivers for a row, in [0, 1] of its range.
    fn readings(data: &Data, row: usize) -> Vec<f32> {
        let cells = data.groups.iter().flat_map(|g| &g.columns).map(|&c| &data.columns[c]);
        let reading = |c: &Column| {
            let value = c.values[row].map_or(0.5, |x| (x - c.low) / (c.high - c.low)) as f32;
            let known = c.values[row].map_or(0.0, |_| 1.0);
            std::iter::once(value).chain(c.nullable.then_some(known))
        };
        cells.flat_map(reading).collect()
    }

    #[test]
    fn belief_is_the_models_own_probability_of_classes() {
        let mut data = cube(&CubeConfig { rows: 200, ..CubeConfig::default() });
        let holes = data.columns[4].values.iter_mut().step_by(3);
        holes.for_each(|value| *value = None);
        data.columns[4] = Column::new("holes", std::mem::take(&mut data.columns[4].values));
        let model = Imagination::of(&data, &rows(&data), &Streams::new(1));
        let belief = model.belief(&data, Verdict::default());
        let mut opinion = metal_rl::belief::Opinion::default();
        for row in [0, 1, 3, 50] {
            belief.update(&readings(&data, row), |_| true, &mut opinion);
            let cell = |(c, s): (&Column, &Scale)| c.values[row].map_or(f64::NAN, |x| s.there(x));
            let values = data.columns.iter().zip(&model.scales).map(cell).collect();
            let matrix = Matrix { values, width: data.columns.len() };
            let label = data.labels[row];
            let loss = model.classes.loss(&matrix, &[label]);
            assert!((num::exp(-loss) - opinion.classes[label]).abs() < 1e-3, "row {row}: {loss} {opinion:?}");
        }
    }
}
