//! `metal drive --learn`: a trained mind learns on, on a body.

use anyhow::ensure;
use metal_lab::learn_on::{can_learn_on, learn_on};
use metal_lab::mind::Mind;
use metal_lab::plan::Plan;
use metal_lab::store::{RunCard, Store};
use metal_rl::environment::Environment;
use metal_rl::observe::Observer;
use metal_rl::random::Streams;
use std::path::Path;

/// A mind of a run.
pub struct Pupil<'a> {
    /// The run's folder.
    pub store: &'a Store,
    /// Its plan.
    pub plan: &'a Plan,
    /// Its card.
    pub card: &'a RunCard,
    /// Which training.
    pub seed: usize,
    /// The phase that left the mind behind.
    pub phase: &'a str,
}

impl Pupil<'_> {
    /// Refuses a mind that cannot learn on, before anybody connects to a body.
    pub fn check(&self) -> anyhow::Result<()> {
        let acting = &self.plan.file.phase[self.phase].acting;
        ensure!(
            !acting.is_watched(),
            "--learn: in phase `{}` the mind only watches: --demonstrate records what it can learn from",
            self.phase
        );
        let by_steps = |phase: &&String| {
            can_learn_on(self.plan, phase) && !self.plan.file.phase[*phase].acting.is_watched()
        };
        let others: Vec<&str> = self.plan.file.phase.keys().filter(by_steps).map(String::as_str).collect();
        let others = if others.is_empty() { "no phase of this plan".into() } else { others.join(", ") };
        ensure!(
            can_learn_on(self.plan, self.phase),
            "--learn: phase `{}` is learned by counterfactual policy iteration, in a world that can be copied; a mind learns on \
             from {others}",
            self.phase
        );
        Ok(())
    }

    /// Lets the mind learn on in `world` and writes it to `out`, a run of one training; also if the world fails meanwhile.
    pub fn learn_on(
        &self,
        (mind, world): (&Mind, &mut dyn Environment),
        rest: (usize, &Streams),
        observer: &mut dyn Observer,
        out: &Path,
    ) -> anyhow::Result<()> {
        let (learned, outcome) = learn_on((self.plan, self.phase), mind, world, rest, observer)?;
        self.write(&learned, out)?;
        Ok(outcome?)
    }

    /// The run with this one mind in place of the old one; the minds of other phases stay as they are.
    fn write(&self, learned: &Mind, out: &Path) -> anyhow::Result<()> {
        let store = Store::create(out)?;
        for phase in self.plan.file.phase.keys().filter(|phase| *phase != self.phase) {
            // A run keeps the minds that its policies need, not those of every phase.
            if let Ok(mind) = self.store.read_mind(self.plan, self.seed, phase) {
                store.write_mind(0, phase, &mind.freeze_for(self.plan))?;
            }
        }
        store.write_mind(0, self.phase, &learned.freeze_for(self.plan))?;
        store.write_run(self.plan, &RunCard { seeds: 1, ..self.card.clone() })?;
        Ok(())
    }
}
