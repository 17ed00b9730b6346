//! What a model of a world believes of the situation at hand, given the readings that were looked at, and no others.
//!
//! The model is a Bayes classifier with clusters: a situation is one of finitely many *hypotheses* (a class in a cluster),
//! under each of which the numbers of readings are normal, independent of each other (a naive Bayes classifier) or with
//! correlations of its own. Classes say what motor actions earn; clusters say only what else may be seen, such as a context that
//! tells which readings matter.

mod correlation;
mod tells;

pub use correlation::{Correlation, Whitener};
pub use tells::Tells;

use crate::num;
use crate::view::Scaling;
use serde::{Deserialize, Serialize};

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
    /// Of the numbers under every hypothesis; none at all where they are independent.
    correlations: Vec<Correlation>,
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
    /// Of what is known, by hypothesis.
    whiteners: Vec<Whitener>,
    /// Whitened distances of what is known from the means, hypothesis after hypothesis.
    whitened: Vec<f64>,
    outlook: tells::Outlook,
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
        let scaling = Scaling::Linear;
        Self { log_variances, sensors, numbers, hypotheses, correlations: Vec::new(), rewards, scaling }
    }

    /// The same model with numbers that vary together; one matrix per hypothesis.
    ///
    /// # Panics
    /// If there are more or fewer, or they are of another number of numbers.
    #[must_use]
    pub fn correlated(self, correlations: Vec<Correlation>) -> Self {
        assert_eq!(correlations.len(), self.hypotheses.len(), "one per hypothesis");
        assert!(correlations.iter().all(|c| c.fits(self.numbers.len())), "one row per number");
        Self { correlations, ..self }
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
        if self.correlations.is_empty() {
            self.weigh(opinion);
        } else {
            self.weigh_together(opinion);
        }
        let hypotheses = &mut opinion.hypotheses;
        let most = num::max(hypotheses);
        hypotheses.iter_mut().for_each(|log| *log = num::exp(*log - most));
        let sum: f64 = hypotheses.iter().sum();
        hypotheses.iter_mut().for_each(|p| *p /= sum);
        self.decide(opinion);
    }

    /// Logarithms of the hypotheses' probabilities, up to a constant, where numbers are independent.
    fn weigh(&self, opinion: &mut Opinion) {
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
    }

    /// The same where they are correlated.
    fn weigh_together(&self, opinion: &mut Opinion) {
        let Opinion { hypotheses, known, whiteners, whitened, .. } = opinion;
        whiteners.resize_with(self.hypotheses.len(), Whitener::default);
        hypotheses.clear();
        whitened.clear();
        let models = self.hypotheses.iter().zip(&self.log_variances).zip(&self.correlations);
        for (((h, logs), correlation), whitener) in models.zip(whiteners) {
            correlation.among(known.iter().map(|(j, _)| *j), whitener);
            let start = whitened.len();
            whitened.extend(known.iter().map(|&(j, z)| (z - h.means[j]) / h.variances[j].sqrt()));
            whitener.whiten(&mut whitened[start..]);
            let squares: f64 = whitened[start..].iter().map(|t| t * t).sum();
            let logs: f64 = known.iter().map(|(j, _)| logs[*j]).sum();
            hypotheses.push(h.log_prior - 0.5 * (squares + logs + whitener.log_determinant()));
        }
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
    }

    /// Two numbers that vary together; only the first differs between the classes.
    fn together(correlation: f64) -> Belief {
        let hypotheses =
            vec![hypothesis(0, &[0.0, 0.0], &[1.0, 4.0]), hypothesis(1, &[2.0, 0.0], &[1.0, 4.0])];
        let belief = Belief::new(vec![1, 1], vec![value(), value()], hypotheses, verdict());
        belief.correlated(vec![Correlation::new(2, |_, _| correlation); 2])
    }

    #[test]
    fn correlated_numbers_are_weighed_together() {
        let (belief, mut opinion) = (together(0.8), Opinion::default());
        // Values 2 and 2: distances (2, 1) and (0, 1) in standard deviations; e R⁻¹ e = (e₁² − 1.6 e₁e₂ + e₂²) / 0.36.
        belief.update(&[0.5, 0.5], |_| true, &mut opinion);
        let log = |first: f64| -0.5 * (first * first - 1.6 * first + 1.0) / 0.36;
        let odds = num::exp(log(2.0) - log(0.0));
        assert!(near(opinion.classes[0] / opinion.classes[1], odds), "{opinion:?}");
    }

    #[test]
    fn a_number_without_classes_of_its_own_tells_how_to_read_another() {
        let (belief, mut opinion) = (together(0.8), Opinion::default());
        belief.update(&[0.0, 0.0], |_| false, &mut opinion);
        belief.look_ahead(&mut opinion);
        assert!(near(opinion.tells[1].all, 0.0), "by itself it tells nothing");
        // The first is 1, between the classes: the second is expected at 2 · 0.8 · (±1), with variance 4 · 0.36.
        belief.update(&[0.25, 0.0], |sensor| sensor == 0, &mut opinion);
        belief.look_ahead(&mut opinion);
        assert!(near(opinion.tells[1].duel, 3.2 * 3.2 / 1.44), "{opinion:?}");
        assert!(near(opinion.tells[0].all, 0.0), "what is known tells nothing more");
    }

    #[test]
    fn without_correlations_it_is_naive() {
        let (naive, none) = (contexts(), contexts().correlated(vec![Correlation::new(2, |_, _| 0.0); 4]));
        let (mut a, mut b) = (Opinion::default(), Opinion::default());
        for seen in [0, 1, 2] {
            naive.update(&[0.1, 0.7], |sensor| sensor < seen, &mut a);
            none.update(&[0.1, 0.7], |sensor| sensor < seen, &mut b);
            assert!(a.hypotheses.iter().zip(&b.hypotheses).all(|(a, b)| near(*a, *b)));
            naive.look_ahead(&mut a);
            none.look_ahead(&mut b);
            let alike =
                |a: &Tells, b: &Tells| near(a.class, b.class) && near(a.all, b.all) && near(a.duel, b.duel);
            assert!((seen..2).all(|open| alike(&a.tells[open], &b.tells[open])), "{a:?} {b:?}");
        }
    }

    #[test]
    fn classes_may_differ_in_nothing_but_what_goes_together() {
        let hypotheses = vec![hypothesis(0, &[2.0, 2.0], &[1.0; 2]), hypothesis(1, &[2.0, 2.0], &[1.0; 2])];
        let belief = Belief::new(vec![1, 1], vec![value(), value()], hypotheses, verdict());
        let belief = belief.correlated([0.6, -0.6].map(|r| Correlation::new(2, |_, _| r)).to_vec());
        let mut opinion = Opinion::default();
        // Distances (1, 1): squares 2 / (1 + r) = 1.25 and 5, determinants the same.
        belief.update(&[0.75, 0.75], |_| true, &mut opinion);
        assert!(near(opinion.classes[1], 1.0 / (1.0 + num::exp(1.875))), "{opinion:?}");
        belief.update(&[0.75, 0.75], |sensor| sensor == 0, &mut opinion);
        belief.look_ahead(&mut opinion);
        // Expected at ±0.6 with variance 0.64.
        assert!(near(opinion.tells[1].duel, 1.44 / 0.64) && near(opinion.classes[0], 0.5), "{opinion:?}");
    }
}
