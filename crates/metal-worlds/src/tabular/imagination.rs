//! Rows that nobody has seen: drawn from a model of those that somebody has.
//!
//! A few hundred rows are learned by heart before looks are learned. The model is a Bayes classifier in each of a few
//! clusters of rows, naive or with correlations; clusters are found without the classes, so what
//! only says how to read the rest (a context) becomes a cluster. Everything that must be chosen is chosen by the class's
//! log-loss on rows held out, seen through random columns.

use super::classes::{Class, Classes, Sample};
use super::mixture::{Matrix, clusters};
use super::scales::{Scale, Units};
use super::{Column, Data, Group, Verdict};
use metal_rl::belief::{Belief, Correlation, Hypothesis, Number, Whitener};
use metal_rl::random::{Rng, Streams};

/// Numbers of clusters that are tried.
const CLUSTERS: [usize; 5] = [1, 2, 3, 5, 8];
/// Rows' worth of belief that a class spreads in a column as all classes of its cluster do: what is tried.
const BELIEFS: [f64; 3] = [5.0, 20.0, 80.0];
/// Parts into which rows are cut for the choice.
const FOLDS: usize = 4;
/// Shares by which correlations within classes are taken to be less than they are in the rows: what is tried. 1 is a naive
/// Bayes classifier.
const INDEPENDENCES: [f64; 3] = [1.0, 0.4, 0.1];
/// Tables of more columns are taken as naive: a correlation for every pair is too much to learn, and to think of.
const MOST_CORRELATED: usize = 64;
/// A column of so few different values delivers no others.
const DISCRETE: usize = 16;

/// A model of rows with classes.
#[derive(Clone, Debug)]
pub struct Imagination {
    scales: Vec<Scale>,
    rows: Vec<usize>,
    shares: Vec<Vec<f64>>,
    classes: Classes,
    /// Of all columns of a class together, by cluster, then class.
    whiteners: Vec<Vec<Option<Whitener>>>,
}

/// How rows are modelled.
#[derive(Clone, Copy, Debug)]
struct Choice {
    units: Units,
    clusters: usize,
    belief: f64,
    independence: f64,
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
        let sample =
            Sample { matrix: &matrix, shares: &shares, labels: &labels, classes: data.classes.len() };
        let classes = Classes::of(sample, choice.belief);
        let scatter = classes.scatter(sample);
        let classes = classes.correlated(&scatter, (choice.belief, choice.independence));
        let whitener = |class: &Class| {
            class.correlation.as_ref().map(|correlation| {
                let mut whitener = Whitener::default();
                correlation.among(0..data.columns.len(), &mut whitener);
                whitener
            })
        };
        let whiteners = classes.0.iter().map(|cluster| cluster.iter().map(whitener).collect()).collect();
        Self { scales, rows: rows.to_vec(), shares, classes, whiteners }
    }

    /// A row that could have been: its cells, and its class. What is absent in it is absent in a row that was seen.
    #[must_use]
    pub fn draw(&self, data: &Data, rng: &mut Rng) -> (Vec<Option<f64>>, usize) {
        let place = rng.below(self.rows.len());
        let row = self.rows[place];
        let weights: Vec<f64> = self.shares.iter().map(|s| s[place]).collect();
        let label = data.labels[row];
        let cluster = rng.pick(&weights);
        let gauss = &self.classes.0[cluster][label].gauss;
        let mut distances: Vec<f64> = data.columns.iter().map(|_| rng.normal()).collect();
        if let Some(whitener) = &self.whiteners[cluster][label] {
            whitener.colour(&mut distances);
        }
        let cell = |(j, column): (usize, &Column)| {
            let z = gauss.mean[j] + gauss.variance[j].sqrt() * distances[j];
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
        let hypothesis = |(class, own): (usize, &Class)| Hypothesis {
            log_prior: own.log_prior,
            class,
            means: spread(&own.gauss.mean),
            variances: spread(&own.gauss.variance),
        };
        let hypotheses = self.classes.0.iter().flat_map(|cluster| cluster.iter().enumerate().map(hypothesis));
        let classes = data.classes.len();
        let reward =
            |class: usize, action: usize| if class == action { verdict.right } else { verdict.wrong };
        let rewards = (0..classes).map(|c| (0..classes).map(|a| reward(c, a)).collect()).collect();
        let belief = Belief::new(
            data.groups.iter().map(length).collect(),
            columns.iter().flat_map(number).collect(),
            hypotheses.collect(),
            rewards,
        );
        let owners: Vec<Option<usize>> = columns.iter().flat_map(|&c| owners(c, &data.columns[c])).collect();
        let all = self.classes.0.iter().flatten().filter_map(|own| own.correlation.as_ref());
        let correlations: Vec<Correlation> = all.map(|of| spread_out(of, &owners)).collect();
        if correlations.is_empty() { belief } else { belief.correlated(correlations) }
    }
}

/// How many numbers a column delivers.
fn numbers(column: &Column) -> usize {
    1 + usize::from(column.nullable)
}

/// The column that every number of a column tells the value of; none for the number that says whether it is known.
fn owners(index: usize, column: &Column) -> impl Iterator<Item = Option<usize>> + use<> {
    std::iter::once(Some(index)).chain(column.nullable.then_some(None))
}

/// Correlations of numbers, from those of the columns whose values they are.
fn spread_out(columns: &Correlation, owners: &[Option<usize>]) -> Correlation {
    let of = |i: usize, j: usize| owners[i].zip(owners[j]).map_or(0.0, |(a, b)| columns.between(a, b));
    Correlation::new(owners.len(), of)
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
    let mut best: Option<(f64, Choice)> = None;
    for units in [Units::Spread, Units::Ranks] {
        for clusters in CLUSTERS {
            let choices = choices(units, clusters, data.columns.len());
            let losses = losses(data, &order, &choices, &streams.nth(clusters as u64));
            for (choice, loss) in choices.into_iter().zip(losses) {
                if best.is_none_or(|(record, _)| loss < record) {
                    best = Some((loss, choice));
                }
            }
        }
    }
    let naive = Choice { units: Units::Spread, clusters: 1, belief: BELIEFS[1], independence: 1.0 };
    best.map_or(naive, |(_, choice)| choice)
}

/// What is tried in these units with so many clusters.
fn choices(units: Units, clusters: usize, columns: usize) -> Vec<Choice> {
    let tried = if columns > MOST_CORRELATED { &INDEPENDENCES[..1] } else { &INDEPENDENCES };
    let of = |&independence: &f64| BELIEFS.map(|belief| Choice { units, clusters, belief, independence });
    tried.iter().flat_map(of).collect()
}

/// Log-losses on rows held out of choices that share units and clusters.
fn losses(data: &Data, order: &[usize], choices: &[Choice], streams: &Streams) -> Vec<f64> {
    let (units, count) = (choices[0].units, choices[0].clusters);
    let mut losses = vec![0.0; choices.len()];
    for fold in 0..FOLDS {
        let part = |held: bool| {
            let mine = order.iter().enumerate().filter(|(i, _)| (i % FOLDS == fold) == held);
            mine.map(|(_, r)| *r).collect::<Vec<usize>>()
        };
        let (known, held) = (part(false), part(true));
        let labels = |rows: &[usize]| rows.iter().map(|&r| data.labels[r]).collect::<Vec<usize>>();
        let (known_labels, held_labels) = (labels(&known), labels(&held));
        let (_, matrix) = scaled(data, (&known, &known), units);
        let (_, mut test) = scaled(data, (&known, &held), units);
        blindfold(&mut test, &mut streams.nth(fold as u64).stream("columns"));
        let shares = clusters(&matrix, count, &mut streams.nth(fold as u64).stream("clusters"));
        let sample =
            Sample { matrix: &matrix, shares: &shares, labels: &known_labels, classes: data.classes.len() };
        let scatter = Classes::of(sample, BELIEFS[0]).scatter(sample);
        for (loss, choice) in losses.iter_mut().zip(choices) {
            let classes =
                Classes::of(sample, choice.belief).correlated(&scatter, (choice.belief, choice.independence));
            *loss += classes.loss(&test, &held_labels);
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

#[cfg(test)]
mod tests {
    use super::super::{CubeConfig, CubeNmConfig, cube, cube_nm};
    use super::*;
    use metal_rl::num;

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

    /// Two columns that say the same but for a little, of which only the first tells the class; the second has holes.
    fn twins() -> Data {
        let mut rng = Streams::new(5).stream("twins");
        let labels: Vec<usize> = (0..200).map(|i| i % 2).collect();
        let shared: Vec<f64> = labels.iter().map(|_| rng.normal()).collect();
        let first = |(l, s): (&usize, &f64)| Some(0.8 * *l as f64 + s);
        let a = labels.iter().zip(&shared).map(first).collect();
        let b = shared.iter().enumerate().map(|(i, s)| (i % 9 != 0).then(|| s + 0.2 * rng.normal()));
        let columns = vec![Column::new("tells", a), Column::new("shows the noise", b.collect())];
        let group = |c: usize| super::super::Group { name: format!("g{c}"), columns: vec![c], price: 0.1 };
        let names = vec!["a".into(), "b".into()];
        Data::new("X-v0", columns, vec![group(0), group(1)], (names, labels)).unwrap()
    }

    #[test]
    fn columns_that_vary_together_are_imagined_and_believed_so() {
        let data = twins();
        let model = Imagination::of(&data, &rows(&data), &Streams::new(1));
        let own = &model.classes.0[0][0];
        let correlation = own.correlation.as_ref().expect("naive classes are told apart worse");
        assert!(correlation.between(0, 1) > 0.3, "{correlation:?}");
        let imagined = data.drawn_from(&model, 4000, &Streams::new(2));
        let both = |&r: &usize| imagined.columns[0].values[r].zip(imagined.columns[1].values[r]);
        let pairs: Vec<(f64, f64, usize)> = rows(&imagined)
            .iter()
            .filter_map(|r| both(r).map(|(a, b)| (a, b, imagined.labels[*r])))
            .collect();
        // The difference is the class, and little else.
        let mean = |class: usize| {
            let mine: Vec<f64> = pairs.iter().filter(|p| p.2 == class).map(|p| p.0 - p.1).collect();
            mine.iter().sum::<f64>() / mine.len() as f64
        };
        assert!((mean(1) - mean(0) - 0.8).abs() < 0.2, "{} {}", mean(0), mean(1));
        let belief = model.belief(&data, Verdict::default());
        let mut opinion = metal_rl::belief::Opinion::default();
        let sure = |seen: usize, opinion: &mut metal_rl::belief::Opinion| {
            let one = |row: usize| {
                belief.update(&readings(&data, row), |sensor| sensor < seen, opinion);
                usize::from(num::argmax(&opinion.classes) == data.labels[row])
            };
            (0..200).map(one).sum::<usize>()
        };
        let (alone, together) = (sure(1, &mut opinion), sure(2, &mut opinion));
        assert!(alone < 150 && together > 180, "right with the first {alone}, with both {together} of 200");
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
        let mut holes = cube(&CubeConfig { rows: 200, ..CubeConfig::default() });
        holes.columns[4].values.iter_mut().step_by(3).for_each(|value| *value = None);
        holes.columns[4] = Column::new("holes", std::mem::take(&mut holes.columns[4].values));
        for data in [holes, twins()] {
            believes_what_its_model_says(&data);
        }
    }

    fn believes_what_its_model_says(data: &Data) {
        let model = Imagination::of(data, &rows(data), &Streams::new(1));
        let belief = model.belief(data, Verdict::default());
        let mut opinion = metal_rl::belief::Opinion::default();
        for row in [0, 1, 3, 50] {
            belief.update(&readings(data, row), |_| true, &mut opinion);
            let cell = |(c, s): (&Column, &Scale)| c.values[row].map_or(f64::NAN, |x| s.there(x));
            let values = data.columns.iter().zip(&model.scales).map(cell).collect();
            let matrix = Matrix { values, width: data.columns.len() };
            let label = data.labels[row];
            let loss = model.classes.loss(&matrix, &[label]);
            assert!((num::exp(-loss) - opinion.classes[label]).abs() < 1e-3, "row {row}: {loss} {opinion:?}");
        }
    }
}
