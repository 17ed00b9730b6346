//! What looks are expected to tell.

use super::{Belief, Correlation, Hypothesis, Number, Opinion, Whitener};
use crate::num;

/// Hypotheses less likely than this are left out of what further looks are expected to tell.
const UNLIKELY: f64 = 1e-4;

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

/// Working memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Outlook {
    sums: Sums,
    prospect: Prospect,
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

/// What is expected of every number under one hypothesis, given what is known of others.
#[derive(Clone, Debug, Default, PartialEq)]
struct Prospect {
    /// Weights of a number on the whitened distances of what is known.
    weights: Vec<f64>,
    means: Vec<f64>,
    variances: Vec<f64>,
}

impl Belief {
    /// What every sensor is expected to tell, after [`Self::update`].
    pub fn look_ahead(&self, opinion: &mut Opinion) {
        self.add_up(opinion);
        let (first, second) = two_likeliest(&opinion.classes);
        let Opinion { tells, outlook: Outlook { sums, .. }, .. } = opinion;
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

    /// Moments of every number over hypotheses, given what is known.
    fn add_up(&self, opinion: &mut Opinion) {
        let Opinion { hypotheses, known, whiteners, whitened, outlook, .. } = opinion;
        let Outlook { sums, prospect } = outlook;
        sums.reset(self.numbers.len(), self.rewards.len());
        for (i, (h, &p)) in self.hypotheses.iter().zip(hypotheses.iter()).enumerate() {
            if p <= UNLIKELY {
                continue;
            }
            if let Some(correlation) = self.correlations.get(i) {
                let whitened = &whitened[i * known.len()..][..known.len()];
                prospect.under(h, (correlation, &whiteners[i]), whitened);
                sums.add(h.class, p, (&prospect.means, &prospect.variances));
            } else {
                sums.add(h.class, p, (&h.means, &h.variances));
            }
        }
    }
}

impl Prospect {
    /// What is expected under `h`, from whose means the known numbers are at these whitened distances.
    fn under(
        &mut self,
        h: &Hypothesis,
        (correlation, whitener): (&Correlation, &Whitener),
        whitened: &[f64],
    ) {
        let Self { weights, means, variances } = self;
        means.clear();
        variances.clear();
        for (j, variance) in h.variances.iter().enumerate() {
            weights.clear();
            let left = whitener.foretell(correlation, j, weights);
            let foretold: f64 = weights.iter().zip(whitened).map(|(u, t)| u * t).sum();
            means.push(h.means[j] + variance.sqrt() * foretold);
            variances.push(variance * left);
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

    /// A hypothesis of probability `p` expects these means and variances.
    fn add(&mut self, class: usize, p: f64, (means, variances): (&[f64], &[f64])) {
        self.classes[class] += p;
        let by_class = &mut self.by_class[class];
        for (j, of_class) in by_class.iter_mut().enumerate() {
            let mean = p * means[j];
            self.mean[j] += mean;
            *of_class += mean;
            self.square[j] += mean * means[j];
            self.within[j] += p * variances[j];
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_likeliest() {
        assert_eq!(two_likeliest(&[0.1, 0.6, 0.3]), (1, 2));
        assert_eq!(two_likeliest(&[1.0]), (0, 0));
    }
}
