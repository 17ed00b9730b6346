//! Recollection: what the student makes of everything it has looked at and done so far in an episode (Sec. 7, "expanding
//! attention control to the past observations"). Reading R134.
//!
//! A recurrent network carries it along. It learns to foretell what *all* sensors would show, on the student's own drives,
//! where everybody was read for the labels anyway; no state of the world beyond readings is used. Since looks move
//! nothing, drives can also be relived with other looks than the student's.

use crate::counterfactual::judge::Judged;
use crate::counterfactual::student::gaze::Layout;
use crate::counterfactual::student::units::Units;
use crate::learners::nn::recurrent::{Recurrent, Sequences};
use crate::learners::nn::{Adam, LANES};
use crate::num;
use crate::random::{Rng, Streams};
use crate::set::IndexSet;
use serde::{Deserialize, Serialize};

/// How the recollection is learned; its size is [`recollection`](crate::counterfactual::student::gaze::MemoryConfig::recurrent).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecollectionConfig {
    /// Training steps per iteration.
    pub batches: usize,
    /// Episodes per training step.
    pub batch: usize,
    /// Optimiser; its clip is in standard deviations of readings.
    pub adam: Adam,
    /// The step size falls to this share of itself over the training of an iteration, in (0, 1].
    pub final_rate: f64,
    /// Share of episodes that are relived with looks drawn at random instead of the student's own, in [0, 1].
    pub other_looks: f64,
}

impl Default for RecollectionConfig {
    fn default() -> Self {
        Self {
            batches: 100,
            batch: 16,
            adam: Adam { learning_rate: 3e-3, error_clip: 3.0, ..Adam::default() },
            final_rate: 0.3,
            other_looks: 0.5,
        }
    }
}

/// A motor step of a drive, for whoever wants to relive it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Footstep {
    /// Whether an episode begins here.
    pub first: bool,
    /// Readings that were looked at (null: zeros), and which they are, as the network's input begins.
    pub seen: Vec<f32>,
    /// The motor action.
    pub action: usize,
    /// Which of the drive's labels is of this moment, if it was judged.
    pub judged: Option<usize>,
}

/// A drive with its labels.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Lesson {
    /// The iteration it was driven in.
    pub iteration: usize,
    /// Labels of its judged moments.
    pub judged: Vec<Judged>,
    /// All of its motor steps; empty where nobody has a recollection.
    pub trail: Vec<Footstep>,
}

impl Lesson {
    /// Whether its trail is one of such a layout and its own labels.
    pub(in crate::counterfactual) fn fits(&self, layout: &Layout) -> bool {
        self.trail.iter().all(|step| {
            step.seen.len() == layout.seen()
                && step.action < layout.actions()
                && step.judged.is_none_or(|at| at < self.judged.len())
        })
    }
}

/// The network, and the units of what it foretells.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Recollection {
    network: Recurrent,
    units: Option<Units>,
}

/// Numbers of a recollection's input that fit on the stack.
const STACK: usize = 512;

fn shape(layout: &Layout) -> (usize, usize, usize) {
    let seen = layout.seen();
    (seen + layout.actions(), layout.recollection().len(), seen - layout.slots())
}

impl Recollection {
    /// A newborn recollection for a layout that has a place for it.
    pub(in crate::counterfactual) fn new(
        layout: &Layout,
        config: &RecollectionConfig,
        rng: &mut Rng,
    ) -> Self {
        Self { network: Recurrent::new(shape(layout), config.adam, rng), units: None }
    }

    /// Whether a thawed recollection fits this layout.
    pub(in crate::counterfactual) fn fits(&self, layout: &Layout) -> bool {
        self.network.fits(shape(layout)) && self.units.iter().all(|units| units.fits(layout))
    }

    pub(in crate::counterfactual) fn weights(&self) -> usize {
        self.network.weights()
    }

    /// What is recollected after `action`, in place, where `input` holds what was seen before it and what was recollected
    /// until then.
    pub(in crate::counterfactual) fn turn(&self, layout: &Layout, action: usize, input: &mut [f32]) {
        let seen = layout.seen();
        let width = seen + layout.actions();
        if width <= STACK {
            self.turn_in(layout, action, input, &mut [0.0; STACK][..width]);
        } else {
            self.turn_in(layout, action, input, &mut vec![0.0; width]);
        }
    }

    fn turn_in(&self, layout: &Layout, action: usize, input: &mut [f32], lived: &mut [f32]) {
        let seen = layout.seen();
        lived[..seen].copy_from_slice(&input[..seen]);
        lived[seen + action] = 1.0;
        self.network.step(lived, &mut input[layout.recollection()]);
    }

    /// What every sensor would show now, in the members' units, if `input` holds what is recollected.
    pub fn foretell(&self, layout: &Layout, input: &[f32], out: &mut [f32]) {
        self.network.foretell(&input[layout.recollection()], out);
        if let Some(units) = &self.units {
            units.undo(out);
        }
    }

    /// Learns from drives, now and then as if some of the first `slots` had been looked at instead, beside all of the second; returns
    /// the mean loss over the last half of the training steps.
    pub(in crate::counterfactual) fn learn<'l>(
        &mut self,
        (layout, config): (&Layout, &RecollectionConfig),
        lessons: impl Iterator<Item = &'l Lesson> + Clone,
        slots: (IndexSet, IndexSet),
        streams: &Streams,
    ) -> f64 {
        let full = lessons.clone().flat_map(|l| l.judged.iter().map(|j| &j.full[..]));
        let units = self.units.get_or_insert_with(|| Units::of(layout, full)).clone();
        let episodes: Vec<Episode<'_>> = lessons.flat_map(episodes).collect();
        if episodes.is_empty() {
            return 0.0;
        }
        let mut page = Page::new(layout, units, slots, streams.stream("recollection"));
        let (mut sum, mut count) = (0.0, 0.0);
        for batch in 0..config.batches {
            let progress = batch as f64 / config.batches as f64;
            let rate = config.adam.learning_rate * num::pow(config.final_rate, progress) as f32;
            self.network.set_learning_rate(rate);
            page.fill(&episodes, config);
            let loss = self.network.train(&page.sequences(config.batch));
            if 2 * batch >= config.batches {
                sum += loss;
                count += 1.0;
            }
        }
        sum / f64::max(count, 1.0)
    }

    /// Relives a drive: what its judged moments would have been recollected at, by what is known now.
    pub(in crate::counterfactual) fn relive(&self, layout: &Layout, lesson: &mut Lesson) {
        let mut input = vec![0.0; layout.width()];
        for step in &lesson.trail {
            if step.first {
                input[layout.recollection()].fill(0.0);
            }
            if let Some(judged) = step.judged.and_then(|at| lesson.judged.get_mut(at)) {
                judged.full[layout.recollection()].copy_from_slice(&input[layout.recollection()]);
            }
            input[..layout.seen()].copy_from_slice(&step.seen);
            self.turn(layout, step.action, &mut input);
        }
    }
}

/// The motor steps of one episode, and the labels they point to.
#[derive(Clone, Copy)]
struct Episode<'l> {
    steps: &'l [Footstep],
    judged: &'l [Judged],
}

fn episodes(lesson: &Lesson) -> impl Iterator<Item = Episode<'_>> {
    let pieces = lesson.trail.chunk_by(|_, next| !next.first);
    pieces.map(|steps| Episode { steps, judged: &lesson.judged })
}

impl Episode<'_> {
    /// Everybody's readings at step `t`, if it was judged.
    fn full(&self, t: usize) -> Option<&[f32]> {
        self.steps[t].judged.and_then(|at| self.judged.get(at)).map(|judged| &judged.full[..])
    }
}

/// One training step's episodes, side by side.
struct Page<'a> {
    layout: &'a Layout,
    units: Units,
    kept: IndexSet,
    gifts: IndexSet,
    rng: Rng,
    inputs: Vec<f32>,
    targets: Vec<f32>,
    weights: Vec<f32>,
    masked: Vec<f32>,
}

impl<'a> Page<'a> {
    fn new(layout: &'a Layout, units: Units, (kept, gifts): (IndexSet, IndexSet), rng: Rng) -> Self {
        let none = Vec::new;
        let masked = vec![0.0; layout.width()];
        Self { layout, units, kept, gifts, rng, inputs: none(), targets: none(), weights: none(), masked }
    }

    fn sequences(&self, count: usize) -> Sequences<'_> {
        Sequences { count, inputs: &self.inputs, targets: &self.targets, weights: &self.weights }
    }

    /// Draws episodes and writes them down.
    fn fill(&mut self, episodes: &[Episode<'_>], config: &RecollectionConfig) {
        let drawn: Vec<Episode<'_>> =
            (0..config.batch).map(|_| episodes[self.rng.below(episodes.len())]).collect();
        let times = drawn.iter().map(|e| e.steps.len()).max().unwrap_or(0);
        let (width, _, outputs) = shape(self.layout);
        for (numbers, per_row) in
            [(&mut self.inputs, width), (&mut self.targets, outputs), (&mut self.weights, outputs)]
        {
            numbers.clear();
            numbers.resize(times * drawn.len() * per_row, 0.0);
        }
        for (s, episode) in drawn.iter().enumerate() {
            let often = self.rng.chance(config.other_looks).then(|| self.rng.uniform());
            for t in 0..episode.steps.len() {
                let row = t * drawn.len() + s;
                self.write(row, episode, t, often);
            }
        }
    }

    /// Step `t` of an episode as one row: with its own looks, or with random ones as `often` as that.
    fn write(&mut self, row: usize, episode: &Episode<'_>, t: usize, often: Option<f64>) {
        let (width, _, outputs) = shape(self.layout);
        let seen = self.layout.seen();
        let input = &mut self.inputs[row * width..(row + 1) * width];
        let step = &episode.steps[t];
        input[..seen].copy_from_slice(&step.seen);
        input[seen + step.action] = 1.0;
        let Some(full) = episode.full(t) else { return };
        if let Some(often) = often {
            let looks = if self.rng.chance(often) { some(self.kept, &mut self.rng) } else { IndexSet::EMPTY };
            self.layout.mask(full, looks.union(self.gifts), &mut self.masked);
            input[..seen].copy_from_slice(&self.masked[..seen]);
        }
        let targets = &mut self.targets[row * outputs..(row + 1) * outputs];
        targets.copy_from_slice(self.layout.readings_of(full));
        self.units.convert_readings(targets);
        self.weights[row * outputs..(row + 1) * outputs].fill(1.0);
    }
}

/// One slot of `among`, or two.
fn some(among: IndexSet, rng: &mut Rng) -> IndexSet {
    let mut looks = IndexSet::EMPTY;
    for _ in 0..1 + rng.below(2) {
        looks = among.iter().nth(rng.below(among.len().max(1))).map_or(looks, |slot| looks.with(slot));
    }
    looks
}

/// Whether a recollection may have so many units.
pub(in crate::counterfactual) fn is_size(units: usize) -> bool {
    units.is_multiple_of(LANES) && units <= crate::learners::nn::recurrent::MOST_UNITS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counterfactual::student::gaze::{Gaze, MemoryConfig};

    fn layout() -> Layout {
        Layout::new(&[1, 1], MemoryConfig { recurrent: 16, ..MemoryConfig::default() }, 2)
    }

    fn newborn(layout: &Layout) -> Recollection {
        Recollection::new(layout, &RecollectionConfig::default(), &mut Streams::new(4).stream("recollection"))
    }

    /// Episodes of eight steps on a line: action 1 goes up by a tenth, action 0 down. Slot 0 shows the place, slot 1
    /// nothing of interest. The driver looks at slot 0 in its first step only.
    fn drive(layout: &Layout, episodes: usize, seed: u64) -> Lesson {
        let mut rng = Streams::new(seed).stream("drive");
        let (mut judged, mut trail) = (Vec::new(), Vec::new());
        for _ in 0..episodes {
            let mut place = 0.4 + 0.2 * rng.uniform();
            for t in 0..8 {
                let mut gaze = Gaze::new(layout);
                if t == 0 {
                    gaze.look(layout, 0, &[place]);
                }
                let seen = gaze.input()[..layout.seen()].to_vec();
                gaze.look(layout, 0, &[place]);
                gaze.look(layout, 1, &[0.5]);
                let action = rng.below(2);
                trail.push(Footstep { first: t == 0, seen, action, judged: Some(judged.len()) });
                judged.push(Judged {
                    full: gaze.input().to_vec(),
                    clock: t,
                    looks: IndexSet::EMPTY,
                    advantages: vec![0.0; 2],
                    value: 0.0,
                    stops: Vec::new(),
                    appointments: None,
                });
                place += if action == 1 { 0.1 } else { -0.1 };
            }
        }
        Lesson { iteration: 0, judged, trail }
    }

    /// Root mean square of what `recollection` foretells of slot 0 in the last steps of `lesson`, against what it shows.
    fn error(recollection: &Recollection, layout: &Layout, lesson: &mut Lesson) -> f64 {
        recollection.relive(layout, lesson);
        let last: Vec<&Judged> = lesson.judged.iter().filter(|j| j.clock == 7).collect();
        let square = |judged: &&Judged| {
            let mut told = [0.0; 2];
            recollection.foretell(layout, &judged.full, &mut told);
            f64::from(told[0] - judged.full[0]).powi(2)
        };
        (last.iter().map(square).sum::<f64>() / last.len() as f64).sqrt()
    }

    #[test]
    fn who_knows_where_it_was_and_what_it_did_knows_where_it_is() {
        let (layout, config) =
            (layout(), RecollectionConfig { batches: 1500, ..RecollectionConfig::default() });
        let (lesson, mut fresh) = (drive(&layout, 200, 1), drive(&layout, 100, 2));
        let mut recollection = newborn(&layout);
        recollection.learn(
            (&layout, &config),
            [&lesson].into_iter(),
            (IndexSet::first(2), IndexSet::EMPTY),
            &Streams::new(3),
        );
        // After seven random moves the place is spread by 0.26.
        let after = error(&recollection, &layout, &mut fresh);
        assert!(after < 0.06, "{after}");
    }

    #[test]
    fn what_was_not_looked_at_is_not_recollected() {
        let layout = layout();
        let recollection = newborn(&layout);
        let turned = |looks: IndexSet, hidden: f64| {
            let mut all = Gaze::new(&layout);
            all.look(&layout, 0, &[0.3]);
            all.look(&layout, 1, &[hidden]);
            let mut gaze = Gaze::new(&layout);
            gaze.see_through(&layout, all.input(), looks);
            gaze.recollect(&layout, &recollection, 1);
            gaze.input()[layout.recollection()].to_vec()
        };
        let first = IndexSet::EMPTY.with(0);
        assert_eq!(turned(first, 0.1), turned(first, 0.9));
        assert_ne!(turned(IndexSet::first(2), 0.1), turned(IndexSet::first(2), 0.9));
        assert_ne!(turned(IndexSet::EMPTY, 0.0), turned(IndexSet::EMPTY.with(1), 0.0), "null is no zero");
    }

    #[test]
    fn a_drive_is_relived_as_it_was_lived() {
        let layout = layout();
        let recollection = newborn(&layout);
        let mut lesson = drive(&layout, 2, 7);
        let mut gaze = Gaze::new(&layout);
        let mut lived = Vec::new();
        for step in &lesson.trail {
            if step.first {
                gaze.reset();
            }
            lived.push(gaze.input()[layout.recollection()].to_vec());
            if step.first {
                gaze.look(&layout, 0, &[f64::from(step.seen[0])]);
            }
            gaze.recollect(&layout, &recollection, step.action);
            gaze.advance(&layout, step.action);
        }
        recollection.relive(&layout, &mut lesson);
        for (judged, lived) in lesson.judged.iter().zip(&lived) {
            assert_eq!(&judged.full[layout.recollection()], &lived[..]);
        }
        assert!(lived[8].iter().all(|&x| x == 0.0), "a new episode begins with nothing");
    }
}
