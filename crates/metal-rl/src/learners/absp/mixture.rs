//! The Gaussians of one action: what they know, how they answer, and how they learn.

use super::frame::{Frame, Shape};
use super::gaussians::{Gaussians, LANES, Lane, MAX_FULL};
use super::scan::{Kept, NO_BLOCK, Scan, blocks, log_densities, responsibilities, scan, scan_and_keep};
use crate::learner::Rate;
use crate::num;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Log densities this far below the largest one are beneath rounding.
pub(crate) const NEGLIGIBLE: f64 = -40.0;

/// Responsibility below which a component does not learn.
pub(crate) const TOUCHED: f64 = 1e-6;

/// Floor of the success mass, so that its logarithm exists.
const LEAST_SUCCESS: f64 = 1e-9;

/// What the components of one group know, one lane each.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Facts {
    /// n: sum of responsibilities.
    pub mass: Lane,
    /// g: sum of responsibilities in successes, decaying in failures.
    pub success: Lane,
    /// q: value.
    pub value: Lane,
    /// κ: number of targets behind the value, forgetting included.
    pub count: Lane,
    /// Weighted sum of squared deviations of those targets.
    pub scatter: Lane,
    /// Updates since creation.
    pub age: Lane,
}

/// All components of one action.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Mixture {
    pub gaussians: Gaussians,
    pub facts: Vec<Facts>,
    /// What the state being learned is to every component.
    #[serde(skip)]
    kept: Kept,
}

/// What one sample tells a mixture.
#[derive(Clone, Copy)]
pub(crate) struct Lesson<'a> {
    pub state: &'a [f64],
    pub target: f64,
    /// Target − value before.
    pub error: f64,
    pub success: bool,
    pub rate: Rate,
    /// Error in units of its running spread, clipped to ±1.
    pub surprise: f64,
}

/// Runs `body` with one row per dimension of working space on the stack: small where that is enough.
#[inline(always)]
pub(crate) fn with_rows<T>(full_dims: usize, body: impl FnOnce(&mut [Lane]) -> T) -> T {
    if full_dims <= 8 { body(&mut [[0.0; LANES]; 8]) } else { body(&mut [[0.0; LANES]; MAX_FULL]) }
}

impl Mixture {
    /// No component yet.
    pub fn new(frame: &Frame) -> Self {
        let gaussians = Gaussians::new(frame.full, vec![frame.smallest_width; frame.dims]);
        Self { gaussians, facts: Vec::new(), kept: Kept::default() }
    }

    /// Number of components.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.gaussians.len()
    }

    /// Components in a group.
    #[inline(always)]
    fn used(&self, group: usize) -> usize {
        (self.len() - group * LANES).min(LANES)
    }

    /// Calls `each` with (group, log densities) of every group; places without a component have the density 0.
    fn for_each_group(&self, frame: &Frame, s: &[f64], mut each: impl FnMut(usize, &Lane)) {
        let mut space = NO_BLOCK;
        for block in blocks(self) {
            let logs = &mut space[..block.len()];
            log_densities((self, frame, s), block.clone(), logs);
            block.zip(logs).for_each(|(group, l)| each(group, l));
        }
    }

    /// Squared distances of some groups become log densities. Inlined, so that a caller compiled for wide vectors has it
    /// wide.
    #[inline(always)]
    pub fn to_log_densities(&self, frame: &Frame, groups: Range<usize>, distances: &mut [Lane]) {
        let last = self.gaussians.groups().wrapping_sub(1);
        let log_dets = &self.gaussians.log_dets()[groups.clone()];
        for (l, log_det) in distances.as_flattened_mut().iter_mut().zip(log_dets.as_flattened()) {
            *l = frame.log_density(*log_det, *l);
        }
        if groups.contains(&last) {
            distances[last - groups.start][self.used(last)..].fill(f64::NEG_INFINITY);
        }
    }

    /// Everything about one state in one pass.
    pub fn scan(&self, frame: &Frame, s: &[f64]) -> Scan {
        scan(self, frame, s)
    }

    /// ln Σ exp(q/T) N(s), background included: the Gibbs prior instead of visits.
    pub fn log_gibbs(&self, frame: &Frame, s: &[f64], temperature: f64) -> f64 {
        let mut top = num::ln(frame.background_mass) + frame.background_value / temperature;
        let mut sum = 1.0;
        self.for_each_group(frame, s, |g, l| {
            for (lane, &l) in l[..self.used(g)].iter().enumerate() {
                let x = l + self.facts[g].value[lane] / temperature;
                if x > top {
                    sum = sum * num::exp(top - x) + 1.0;
                    top = x;
                } else if x - top > NEGLIGIBLE {
                    sum += num::exp(x - top);
                }
            }
        });
        top + num::ln(sum)
    }

    /// Expectation of `of(facts, lane)` under the responsibilities, the background counting `background`.
    pub fn expect(
        &self,
        frame: &Frame,
        s: &[f64],
        background: f64,
        of: impl Fn(&Facts, usize) -> f64,
    ) -> f64 {
        let scan = self.scan(frame, s);
        let mut sum = scan.background_share(frame) * background;
        self.for_each_group(frame, s, |g, l| {
            for (lane, &l) in l[..self.used(g)].iter().enumerate() {
                if l - scan.reference > NEGLIGIBLE {
                    let weight = self.facts[g].weight(frame, lane);
                    sum += scan.responsibility(weight, l) * of(&self.facts[g], lane);
                }
            }
        });
        sum
    }

    /// As [`Self::scan`], and keeps what [`Self::learn`] needs of it.
    pub fn study(&mut self, frame: &Frame, s: &[f64]) -> Scan {
        let mut kept = std::mem::take(&mut self.kept);
        let scan = scan_and_keep(self, frame, s, &mut kept);
        self.kept = kept;
        scan
    }

    /// Whether the state that was studied lies outside every component's gate.
    fn is_new(&self, frame: &Frame) -> bool {
        let nearest = |(group, d2): (usize, &Lane)| num::min(&d2[..self.used(group)]);
        let nearest = self.kept.distances.iter().enumerate().map(nearest);
        frame.is_novel(nearest.fold(f64::INFINITY, f64::min))
    }

    /// Learns one sample, whose state was [studied](Self::study) last, with this result; `scratch` has `dims` numbers. True if a
    /// component was added.
    pub fn learn(&mut self, frame: &Frame, lesson: &Lesson<'_>, scan: &Scan, scratch: &mut [f64]) -> bool {
        if self.is_new(frame) {
            self.create(frame, lesson);
            return true;
        }
        let mut kept = std::mem::take(&mut self.kept);
        responsibilities((self, frame), scan, &mut kept.shares);
        for (group, (rho, d2)) in kept.shares.iter().zip(&kept.distances).enumerate() {
            for lane in 0..self.used(group) {
                if rho[lane] >= TOUCHED {
                    self.facts[group].learn(lane, rho[lane], lesson);
                    self.reshape(frame, lesson, (group * LANES + lane, rho[lane], d2[lane]), scratch);
                }
            }
        }
        self.kept = kept;
        false
    }

    /// A new component at the sample; readings R25 and R28.
    fn create(&mut self, frame: &Frame, lesson: &Lesson<'_>) {
        let c = self.gaussians.push(lesson.state, |_| frame.first_width);
        self.facts.resize_with(self.gaussians.groups(), Facts::default);
        let (facts, lane) = (&mut self.facts[c / LANES], c % LANES);
        let prior = frame.prior_count;
        facts.mass[lane] = 1.0;
        facts.success[lane] = if lesson.success { 1.0 } else { 0.5 };
        facts.count[lane] = 1.0 + prior;
        facts.value[lane] = (prior * (lesson.target - lesson.error) + lesson.target) / (1.0 + prior);
        facts.scatter[lane] = prior / (1.0 + prior) * lesson.error * lesson.error;
        facts.age[lane] = 0.0;
    }

    /// Moves and stretches one component (index, responsibility, squared distance) by the shape rule.
    fn reshape(&mut self, frame: &Frame, lesson: &Lesson<'_>, who: (usize, f64, f64), e: &mut [f64]) {
        let (c, rho, d2) = who;
        match frame.shape {
            Shape::Signed { step } if lesson.surprise >= 0.0 => {
                let w = step * rho * (0.2 + 0.8 * lesson.surprise);
                self.gaussians.attract(c, lesson.state, w, e);
            }
            Shape::Signed { step } => {
                let b = (step * rho * -lesson.surprise).min(0.5) / d2.max(1.0);
                self.gaussians.shrink(c, lesson.state, b, e);
            }
            Shape::Resp { least } => {
                let mass = self.facts[c / LANES].mass[c % LANES];
                let w = (rho / mass).max(least * rho).min(0.5);
                self.gaussians.attract(c, lesson.state, w, e);
            }
        }
    }

    /// Removes a component; the last one takes its index.
    pub fn swap_remove(&mut self, c: usize) {
        let last = self.len() - 1;
        for fact in Facts::ALL {
            let value = std::mem::take(fact(&mut self.facts[last / LANES], last % LANES));
            if c != last {
                *fact(&mut self.facts[c / LANES], c % LANES) = value;
            }
        }
        self.gaussians.swap_remove(c);
        self.facts.truncate(self.gaussians.groups());
    }

    /// Whether thawed vectors fit together.
    pub fn is_sound(&self, frame: &Frame) -> bool {
        self.gaussians.is_sound()
            && self.gaussians.dims() == frame.dims
            && self.gaussians.is_full() == frame.full
            && self.facts.len() == self.gaussians.groups()
    }
}

/// Picks one fact of one lane.
type Pick = fn(&mut Facts, usize) -> &mut f64;

impl Facts {
    /// Every fact.
    const ALL: [Pick; 6] = [
        |f, k| &mut f.mass[k],
        |f, k| &mut f.success[k],
        |f, k| &mut f.value[k],
        |f, k| &mut f.count[k],
        |f, k| &mut f.scatter[k],
        |f, k| &mut f.age[k],
    ];

    /// What a component's mass counts in responsibilities.
    #[inline(always)]
    pub fn weight(&self, frame: &Frame, lane: usize) -> f64 {
        // Not `min`, which asks for numbers that are none: an instruction instead of four.
        if self.mass[lane] < frame.most_mass { self.mass[lane] } else { frame.most_mass }
    }

    /// Takes in one sample with responsibility `rho`.
    ///
    /// # Formula
    /// success: g += ρ;  failure: g *= 1 − ρ/2, so that g tends to twice the odds of success, not to visits.
    /// Full (α = 1) and Constant(α): q += α ρ δ.
    /// Average(α): κ += ρ, q += max(ρ/κ, α ρ)(y − q), κ ≤ 1/α.
    fn learn(&mut self, lane: usize, rho: f64, lesson: &Lesson<'_>) {
        self.mass[lane] += rho;
        self.age[lane] += 1.0;
        let g = &mut self.success[lane];
        *g = if lesson.success { *g + rho } else { (*g * (1.0 - 0.5 * rho)).max(LEAST_SUCCESS) };
        let residual = lesson.target - self.value[lane];
        self.count[lane] += rho;
        let (alpha, share, change) = match lesson.rate {
            Rate::Full => (1.0, rho, rho * lesson.error),
            Rate::Constant(alpha) => (alpha, alpha * rho, alpha * rho * lesson.error),
            Rate::Average(alpha) => {
                let share = (rho / self.count[lane]).max(alpha * rho);
                (alpha, share, share * residual)
            }
        };
        self.value[lane] += change;
        self.scatter[lane] += rho * (1.0 - share.min(1.0)) * residual * residual;
        self.forget(lane, alpha);
    }

    /// Limits the count to 1/α, the scatter with it.
    fn forget(&mut self, lane: usize, alpha: f64) {
        let most = 1.0 / alpha;
        if self.count[lane] > most {
            self.scatter[lane] *= most / self.count[lane];
            self.count[lane] = most;
        }
    }
}
