//! What a model of a world believes of the situation at hand, given the readings that were looked at, and no others.
//!
//! The model is a naive Bayes classifier with clusters: a situation is one of finitely many *hypotheses* (a class in a
//! cluster), under each of which every number of a reading is normal and independent of the others. Classes say what
//! motor actions earn; clusters say only what else may be seen, such as a context that tells which readings matter.

use crate::num;
use crate::view::Scaling;
use serde::{Deserialize, Serialize};

/// Hypotheses less likely than this are left out of what further looks are expected to tell.
const UNLIKELY: f64 = 1e-4;

/// One number of a reading, in the order of the sensors' features.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Number {
    /// A value, in [0, 1] of its range, and what it is in the units of the model.
    Value {
        /// Value in [0, 1] → model's unit: piecewise linear, values rising, flat outside.
        ruler: Vec<[f64; 2]>,
        /// Whether the number that follows is 0 where this one is absent.
        nullable: bool,
    },
    /// Whether the number before is there at all.
    Known,
}

/// What the world looks like if a hypothesis is true.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hypothesis {
    /// Logarithm of its probability before any look, up to a constant.
    pub log_prior: f64,
    /// Its class.
    pub class: usize,
    /// Mean of each number, in the model's units.
    pub means: Vec<f64>,
    /// Variance of each number, > 0.
    pub variances: Vec<f64>,
}

/// A model of a world of one motor step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Belief {
    sensors: Vec<usize>,
    numbers: Vec<Number>,
    hypotheses: Vec<Hypothesis>,
    log_variances: Vec<Vec<f64>>,
    /// Reward of every motor action, by class.
    rewards: Vec<Vec<f64>>,
    scaling: Scaling,
}

/// What is believed at the moment, and what further looks are expected to tell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Opinion {
    /// Probability of every hypothesis.
    pub hypotheses: Vec<f64>,
    /// Probability of every class.
    pub classes: Vec<f64>,
    /// Expected reward of every motor action, minus that of whoever knew the class.
    pub moves: Vec<f64>,
    /// What every sensor is expected to tell.
    pub tells: Vec<Tells>,
    known: Vec<(usize, f64)>,
    sums: Sums,
}

/// What a look at a sensor is expected to tell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tells {
    /// About the class: ½ ln (variance / mean variance within classes), summed over the sensor's numbers.
    pub class: f64,
    /// About everything, clusters included: the same within hypotheses.
    pub all: f64,
    /// Between the two likeliest classes: squared distance of their means in units of the variance within hypotheses.
    pub duel: f64,
}

/// Moments of every number over hypotheses.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sums {
    mean: Vec<f64>,
    square: Vec<f64>,
    within: Vec<f64>,
    by_class: Vec<Vec<f64>>,
    classes: Vec<f64>,
}

impl Belief {
    /// The model of sensors that deliver so many numbers each; `rewards` are those of every motor action, by class.
    ///
    /// # Panics
    /// If sensors, numbers, hypotheses and classes do not fit together.
    #[must_use]
    pub fn new(
        sensors: Vec<usize>,
        numbers: Vec<Number>,
        hypotheses: Vec<Hypothesis>,
        rewards: Vec<Vec<f64>>,
    ) -> Self {
        assert_eq!(sensors.iter().sum::<usize>(), numbers.len(), "every number belongs to a sensor");
        assert!(!hypotheses.is_empty() && !rewards.is_empty(), "something must be possible");
        for h in &hypotheses {
            assert_eq!((h.means.len(), h.variances.len()), (numbers.len(), numbers.len()), "one per number");
            assert!(h.class < rewards.len() && h.variances.iter().all(|&v| v > 0.0), "a possible hypothesis");
        }
        let logs = |h: &Hypothesis| h.variances.iter().map(|&v| num::ln(v)).collect();
        let log_variances = hypotheses.iter().map(logs).collect();
        Self { log_variances, sensors, numbers, hypotheses, rewards, scaling: Scaling::Linear }
    }

    /// The same model for readings that were scaled like this.
    #[must_use]
    pub fn scaled(self, scaling: Scaling) -> Self {
        Self { scaling, ..self }
    }

    /// How many numbers each sensor delivers.
    #[must_use]
    pub fn sensors(&self) -> &[usize] {
        &self.sensors
    }

    /// Number of motor actions.
    #[must_use]
    pub fn actions(&self) -> usize {
        self.rewards[0].len()
    }

    /// The difference between the best and the worst that can happen.
    #[must_use]
    pub fn stake(&self) -> f64 {
        let all = || self.rewards.iter().flatten().copied();
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    }

    /// What is believed when the sensors for which `seen` is true showed their part of `readings`, all sensors' numbers
    /// in [0, 1], into `opinion`. Nothing else of `readings` is read.
    pub fn update(&self, readings: &[f32], seen: impl Fn(usize) -> bool, opinion: &mut Opinion) {
        self.take_in(readings, seen, &mut opinion.known);
        let Opinion { hypotheses, known, .. } = opinion;
        hypotheses.clear();
        for (h, logs) in self.hypotheses.iter().zip(&self.log_variances) {
            let mut log = h.log_prior;
            for &(j, z) in known.iter() {
                let off = z - h.means[j];
                log -= 0.5 * (off * off / h.variances[j] + logs[j]);
            }
            hypotheses.push(log);
        }
        let most = num::max(hypotheses);
        hypotheses.iter_mut().for_each(|log| *log = num::exp(*log - most));
        let sum: f64 = hypotheses.iter().sum();
        hypotheses.iter_mut().for_each(|p| *p /= sum);
        self.decide(opinion);
    }

    /// What was seen, in the units of the model; what is absent tells nothing.
    fn take_in(&self, readings: &[f32], seen: impl Fn(usize) -> bool, known: &mut Vec<(usize, f64)>) {
        known.clear();
        let mut at = 0;
        for (sensor, &length) in self.sensors.iter().enumerate() {
            for j in (at..at + length).filter(|_| seen(sensor)) {
                if let Number::Value { ruler, nullable } = &self.numbers[j]
                    && !(*nullable && readings[j + 1] < 0.5)
                {
                    known.push((j, measure(ruler, self.scaling.linear(f64::from(readings[j])))));
                }
            }
            at += length;
        }
    }

    /// Classes and moves from the hypotheses.
    fn decide(&self, opinion: &mut Opinion) {
        let Opinion { hypotheses, classes, moves, .. } = opinion;
        classes.clear();
        classes.resize(self.rewards.len(), 0.0);
        for (h, p) in self.hypotheses.iter().zip(hypotheses.iter()) {
            classes[h.class] += p;
        }
        moves.clear();
        moves.resize(self.actions(), 0.0);
        for (rewards, p) in self.rewards.iter().zip(classes.iter()) {
            let best = num::max(rewards);
            moves.iter_mut().zip(rewards).for_each(|(sum, r)| *sum += p * (r - best));
        }
    }

    /// What every sensor is expected to tell, after [`Self::update`].
    pub fn look_ahead(&self, opinion: &mut Opinion) {
        self.add_up(opinion);
        let (first, second) = two_likeliest(&opinion.classes);
        let Opinion { tells, sums, .. } = opinion;
        tells.clear();
        let mut at = 0;
        for &length in &self.sensors {
            let mut all = Tells::default();
            for j in at..at + length {
                if matches!(self.numbers[j], Number::Value { .. }) {
                    let one = sums.tells(j, (first, second));
                    all.class += one.class;
                    all.all += one.all;
                    all.duel += one.duel;
                }
            }
            tells.push(all);
            at += length;
        }
    }

    fn add_up(&self, opinion: &mut Opinion) {
        let (n, sums) = (self.numbers.len(), &mut opinion.sums);
        sums.reset(n, self.rewards.len());
        for (h, &p) in self.hypotheses.iter().zip(&opinion.hypotheses).filter(|(_, p)| **p > UNLIKELY) {
            sums.classes[h.class] += p;
            let by_class = &mut sums.by_class[h.class];
            for (j, of_class) in by_class.iter_mut().enumerate() {
                let mean = p * h.means[j];
                sums.mean[j] += mean;
                *of_class += mean;
                sums.square[j] += mean * h.means[j];
                sums.within[j] += p * h.variances[j];
            }
        }
    }
}

impl Sums {
    fn reset(&mut self, numbers: usize, classes: usize) {
        let zero = |v: &mut Vec<f64>, n: usize| {
            v.clear();
            v.resize(n, 0.0);
        };
        zero(&mut self.mean, numbers);
        zero(&mut self.square, numbers);
        zero(&mut self.within, numbers);
        zero(&mut self.classes, classes);
        self.by_class.resize_with(classes, Vec::new);
        self.by_class.iter_mut().for_each(|v| zero(v, numbers));
    }

    fn tells(&self, j: usize, (first, second): (usize, usize)) -> Tells {
        let whole: f64 = self.classes.iter().sum();
        let mean = self.mean[j] / whole;
        let within = self.within[j] / whole;
        let variance = (within + self.square[j] / whole - mean * mean).max(within);
        let part = |(sums, &p): (&Vec<f64>, &f64)| if p > 0.0 { sums[j] * sums[j] / p } else { 0.0 };
        let between = self.by_class.iter().zip(&self.classes).map(part).sum::<f64>() / whole - mean * mean;
        let rest = (variance - between.max(0.0)).max(within);
        let class_mean =
            |c: usize| if self.classes[c] > 0.0 { self.by_class[c][j] / self.classes[c] } else { mean };
        let apart = class_mean(first) - class_mean(second);
        Tells {
            class: 0.5 * num::ln(variance / rest),
            all: 0.5 * num::ln(variance / within),
            duel: apart * apart / within,
        }
    }
}

/// The likeliest class and the next; the same where there is only one.
fn two_likeliest(classes: &[f64]) -> (usize, usize) {
    let first = num::argmax(classes);
    let mut second = first;
    for (c, &p) in classes.iter().enumerate().filter(|(c, _)| *c != first) {
        if second == first || p > classes[second] {
            second = c;
        }
    }
    (first, second)
}

/// Piecewise linear, flat outside.
fn measure(ruler: &[[f64; 2]], x: f64) -> f64 {
    let above = ruler.partition_point(|knot| knot[0] < x);
    if above == 0 || above == ruler.len() {
        return ruler[above.min(ruler.len() - 1)][1];
    }
    let ([x0, z0], [x1, z1]) = (ruler[above - 1], ruler[above]);
    z0 + (z1 - z0) * (x - x0) / (x1 - x0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value() -> Number {
        Number::Value { ruler: vec![[0.0, 0.0], [1.0, 4.0]], nullable: false }
    }

    fn hypothesis(class: usize, means: &[f64], variances: &[f64]) -> Hypothesis {
        Hypothesis { log_prior: num::ln(0.25), class, means: means.to_vec(), variances: variances.to_vec() }
    }

    /// Right earns 0, wrong costs 1.
    fn verdict() -> Vec<Vec<f64>> {
        vec![vec![0.0, -1.0], vec![-1.0, 0.0]]
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-6
    }

    #[test]
    fn a_look_moves_probability_by_the_rule_of_bayes() {
        let hypotheses = vec![hypothesis(0, &[0.0], &[1.0]), hypothesis(1, &[2.0], &[1.0])];
        let belief = Belief::new(vec![1], vec![value()], hypotheses, verdict());
        let mut opinion = Opinion::default();
        belief.update(&[f32::NAN], |_| false, &mut opinion);
        assert_eq!((&opinion.classes[..], &opinion.moves[..]), (&[0.5, 0.5][..], &[-0.5, -0.5][..]));
        // 0.5 of the range is 2 in the model's units: densities exp(-2) and 1.
        belief.update(&[0.5], |_| true, &mut opinion);
        let wrong = num::exp(-2.0) / (1.0 + num::exp(-2.0));
        assert!(near(opinion.classes[0], wrong) && near(opinion.moves[1], -wrong), "{opinion:?}");
        let squared = belief.clone().scaled(Scaling::SquareRoot);
        squared.update(&[0.5f32.sqrt()], |_| true, &mut opinion);
        assert!(near(opinion.classes[0], wrong), "however readings are scaled: {opinion:?}");
        assert!(near(belief.stake(), 1.0));
    }

    #[test]
    fn what_is_absent_tells_nothing() {
        let numbers =
            vec![Number::Value { ruler: vec![[0.0, 0.0], [1.0, 4.0]], nullable: true }, Number::Known];
        let hypotheses = vec![hypothesis(0, &[0.0; 2], &[1.0; 2]), hypothesis(1, &[4.0; 2], &[1.0; 2])];
        let belief = Belief::new(vec![2], numbers, hypotheses, verdict());
        let mut opinion = Opinion::default();
        belief.update(&[1.0, 0.0], |_| true, &mut opinion);
        assert_eq!(opinion.classes, [0.5, 0.5]);
        belief.update(&[1.0, 1.0], |_| true, &mut opinion);
        assert!(opinion.classes[1] > 0.99);
        belief.look_ahead(&mut opinion);
        assert_eq!(opinion.tells.len(), 1);
    }

    /// A context (0 or 1) says whether the other number tells the class (0 or 1 if it does, 1/2 if not).
    fn contexts() -> Belief {
        let ruler = || Number::Value { ruler: vec![[0.0, 0.0], [1.0, 1.0]], nullable: false };
        let h = |class, context: f64, mean: f64| hypothesis(class, &[context, mean], &[0.01, 0.25]);
        let hypotheses = vec![h(0, 0.0, 0.0), h(1, 0.0, 1.0), h(0, 1.0, 0.5), h(1, 1.0, 0.5)];
        Belief::new(vec![1, 1], vec![ruler(), ruler()], hypotheses, verdict())
    }

    #[test]
    fn a_context_tells_nothing_of_the_class_and_much_of_the_rest() {
        let (belief, mut opinion) = (contexts(), Opinion::default());
        belief.update(&[0.0, 0.0], |_| false, &mut opinion);
        belief.look_ahead(&mut opinion);
        let half_ln = |x: f64| 0.5 * num::ln(x);
        let [context, other] = opinion.tells[..] else { panic!("two sensors") };
        // Variance 0.01 + 1/4, of which the classes explain nothing.
        assert!(near(context.class, 0.0) && near(context.all, half_ln(26.0)) && near(context.duel, 0.0));
        // Means 0, 1, 1/2, 1/2: variance 0.25 + 0.125, of which the classes (1/4, 3/4) explain 0.0625.
        assert!(near(other.class, half_ln(0.375 / 0.3125)) && near(other.all, half_ln(1.5)));
        assert!(near(other.duel, 1.0));
        // The context was read: the other number's classes are 0 and 1 now, apart by 1 at a variance of 1/4.
        belief.update(&[0.0, 0.0], |sensor| sensor == 0, &mut opinion);
        belief.look_ahead(&mut opinion);
        assert!(near(opinion.classes[0], 0.5), "{opinion:?}");
        assert!(near(opinion.tells[1].class, half_ln(2.0)) && near(opinion.tells[1].duel, 4.0));
    }

    #[test]
    fn rulers_are_flat_outside_and_straight_between() {
        let ruler = [[0.2, -1.0], [0.4, 1.0], [0.8, 2.0]];
        let expected = [(0.0, -1.0), (0.3, 0.0), (0.4, 1.0), (0.6, 1.5), (1.0, 2.0)];
        assert!(expected.iter().all(|&(x, z)| near(measure(&ruler, x), z)));
        assert_eq!(two_likeliest(&[0.1, 0.6, 0.3]), (1, 2));
        assert_eq!(two_likeliest(&[1.0]), (0, 0));
    }
}
