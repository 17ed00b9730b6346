//! What a run is to do, as it stands in `checkpoint/job.toml`: two runs with the same job end with the same bits.

use super::{CheckpointError, FORMAT};
use crate::plan::{Acting, Plan, PlanFile};
use crate::reproduce::Options;
use crate::store::{Store, StoreError, at};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Everything that decides on the numbers of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    format: u32,
    program: String,
    seed: u64,
    seeds: usize,
    quick: bool,
    all_subsets: bool,
    /// Checksum of every file of demonstrations.
    demonstrations: BTreeMap<String, String>,
    plan: PlanFile,
}

impl Job {
    /// The job of running `plan` with `options` by this program.
    ///
    /// # Errors
    /// If a file of demonstrations cannot be read.
    pub fn new(plan: &Plan, options: &Options) -> Result<Self, CheckpointError> {
        let mut demonstrations = BTreeMap::new();
        for row in plan.file.phase.values() {
            if let Acting::Demonstrations(path) = &row.acting {
                let bytes = std::fs::read(path).map_err(|e| at(path, e))?;
                demonstrations.insert(path.display().to_string(), format!("{:016x}", hash(&bytes)));
            }
        }
        Ok(Self {
            format: FORMAT,
            program: program(),
            seed: options.seed,
            seeds: options.seeds,
            quick: options.quick,
            all_subsets: options.all_subsets,
            demonstrations,
            plan: plan.file.clone(),
        })
    }

    /// The job that a finished run was, as far as its folder knows: what it does not know is taken from `job`.
    pub(super) fn of_run(store: &Store, job: &Self) -> Result<Self, StoreError> {
        let (plan, card) = store.read_run()?;
        let Self { program, demonstrations, .. } = job.clone();
        let (seed, seeds, quick, all_subsets) = (card.seed, card.seeds, card.quick, job.all_subsets);
        Ok(Self { format: FORMAT, program, seed, seeds, quick, all_subsets, demonstrations, plan: plan.file })
    }

    pub(super) fn read(path: &Path) -> Result<Self, StoreError> {
        let text = std::fs::read_to_string(path).map_err(|e| at(path, e))?;
        let damaged = |reason: String| StoreError::Damaged { path: path.to_path_buf(), reason };
        toml::from_str(&text).map_err(|e| damaged(format!("damaged: {}", e.message())))
    }

    pub(super) fn text(&self) -> Result<String, CheckpointError> {
        toml::to_string(self).map_err(|e| CheckpointError::Job(e.to_string()))
    }

    /// Number of trainings.
    pub(super) fn seeds(&self) -> usize {
        self.seeds
    }

    /// The experiment.
    pub(super) fn into_plan(self) -> PlanFile {
        self.plan
    }

    /// A number that stands for the job in every file.
    pub(super) fn key(&self) -> Result<u64, CheckpointError> {
        Ok(hash(self.text()?.as_bytes()))
    }

    /// The first thing in which `now` differs, in words; none if they are the same.
    pub(super) fn difference(&self, now: &Self) -> Option<String> {
        let table =
            |job: &Self| toml::Value::try_from(job).map(|value| fields("", &value)).unwrap_or_default();
        let (was, is) = (table(self), table(now));
        let changed = was.keys().chain(is.keys()).find(|key| was.get(*key) != is.get(*key))?;
        let show = |fields: &BTreeMap<String, String>| {
            fields.get(changed).cloned().unwrap_or_else(|| "absent".to_owned())
        };
        Some(format!("{changed} was {} and is {}", show(&was), show(&is)))
    }
}

/// Dotted key → value of everything in `value`; the plan's keys as they stand in its file.
fn fields(key: &str, value: &toml::Value) -> BTreeMap<String, String> {
    let toml::Value::Table(table) = value else {
        return BTreeMap::from([(key.to_owned(), value.to_string())]);
    };
    let below = |(name, value): (&String, &toml::Value)| {
        let key = if key.is_empty() || key == "plan" { name.clone() } else { format!("{key}.{name}") };
        fields(&key, value)
    };
    // An empty table is a choice, too: `acting = "blind"` and `[environment.toy]` say something by being there.
    let itself = table.is_empty().then(|| (key.to_owned(), "{}".to_owned()));
    table.iter().flat_map(below).chain(itself).collect()
}

fn program() -> String {
    format!("metal {} ({})", env!("CARGO_PKG_VERSION"), env!("METAL_GIT_REVISION"))
}

/// FNV-1a, 64 bits: the same on every machine.
pub(super) fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3))
}
