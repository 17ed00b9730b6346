//! A learned mind as one file: safetensors with the frozen learners, and a card in JSON that says what it is.

use super::mind::Learned;
use super::recipe::Recipe;
use crate::plan::PlanError;
use crate::train::RunError;
use metal_rl::environment::EnvironmentSpec;
use metal_rl::learner::LearnerError;
use metal_rl::random::Streams;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Everything about a mind but its learners' bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// Version of the file's layout.
    pub format: u32,
    /// Version of the program that trained.
    pub version: String,
    /// Revision of the program's source.
    #[serde(default)]
    pub git: String,
    /// The contract of the task.
    pub spec: EnvironmentSpec,
    /// Sensors that are experts' opinions.
    pub opinions: Vec<usize>,
    /// How it was learned.
    pub recipe: Recipe,
    /// The seed it was learned from.
    pub seed: u64,
    /// What the trainer wants to keep with it: metrics, a revision, remarks.
    pub notes: BTreeMap<String, String>,
}

/// Version of the layout.
const FORMAT: u32 = 1;
/// Where the card stands in the file's metadata.
const CARD: &str = "metal";
/// Name of the controller's bytes.
const CONTROLLER: &str = "attention";
/// Prefix of the members' bytes.
const MEMBER: &str = "member.";

/// Writes `mind` to `path`, whole or not at all.
///
/// # Errors
/// If the file cannot be written.
pub fn save(mind: &Learned, path: &Path, seed: u64, notes: BTreeMap<String, String>) -> Result<(), RunError> {
    let card = Card {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        git: env!("METAL_GIT_REVISION").to_owned(),
        spec: mind.spec.clone(),
        opinions: mind.opinions.clone(),
        recipe: mind.recipe.clone(),
        seed,
        notes,
    };
    let frozen = mind.members.iter().map(|m| (format!("{MEMBER}{}", m.name), m.learner.freeze()));
    let controller = mind.controller.iter().map(|c| (CONTROLLER.to_owned(), c.freeze()));
    let bytes: Vec<(String, Vec<u8>)> = frozen.chain(controller).collect();
    let mut views = Vec::new();
    for (name, bytes) in &bytes {
        let view = TensorView::new(Dtype::U8, vec![bytes.len()], bytes).map_err(|e| refuse(path, &e))?;
        views.push((name.as_str(), view));
    }
    let card = serde_json::to_string(&card).map_err(|e| refuse(path, &e))?;
    let metadata = Some([(CARD.to_owned(), card)].into_iter().collect());
    let whole = safetensors::serialize(views, metadata).map_err(|e| refuse(path, &e))?;
    write_whole(path, &whole).map_err(|e| refuse(path, &e))
}

/// A file that is there whole or not at all.
fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".tmp");
    std::fs::write(&name, bytes)?;
    std::fs::rename(&name, path)
}

/// The mind in `path`, and its card.
///
/// # Errors
/// If the file cannot be read, is no mind, or is damaged.
pub fn load(path: &Path) -> Result<(Learned, Card), RunError> {
    let bytes = std::fs::read(path).map_err(|e| refuse(path, &e))?;
    let card = card(&bytes).map_err(|reason| refuse(path, &reason))?;
    let tensors = SafeTensors::deserialize(&bytes).map_err(|e| refuse(path, &e))?;
    let mut mind = Learned::newborn(&card.spec, &card.opinions, &card.recipe, &Streams::new(0))?;
    for m in 0..mind.members.len() {
        let name = format!("{MEMBER}{}", mind.members[m].name);
        let data = tensors.tensor(&name).map_err(|e| refuse(path, &e))?;
        mind.members[m].learner = thaw_member(&mind, m, data.data())?;
    }
    if let Ok(data) = tensors.tensor(CONTROLLER) {
        mind.controller = Some(mind.thaw_controller(data.data())?);
    }
    Ok((mind, card))
}

fn thaw_member(
    mind: &Learned,
    m: usize,
    bytes: &[u8],
) -> Result<Box<dyn metal_rl::learner::Learner>, LearnerError> {
    let given = metal_rl::learners::LearnerConfig::Given(metal_rl::learners::GivenConfig {});
    let config = match m {
        m if m == mind.observer() => &mind.recipe.observer,
        m if mind.opinions.contains(&m) => &given,
        _ => &mind.recipe.tiny,
    };
    let learner = config.thaw(bytes)?;
    if learner.dims() == mind.members[m].learner.dims() {
        return Ok(learner);
    }
    let reason = format!("`{}` has another shape than the task", mind.members[m].name);
    Err(LearnerError::Frozen { learner: "member", reason })
}

fn card(bytes: &[u8]) -> Result<Card, String> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| e.to_string())?;
    let text = metadata.metadata().as_ref().and_then(|m| m.get(CARD)).ok_or("no card of a mind in it")?;
    let card: Card = serde_json::from_str(text).map_err(|e| e.to_string())?;
    if card.format == FORMAT {
        return Ok(card);
    }
    Err(format!("layout {}, this program reads {FORMAT}", card.format))
}

fn refuse(path: &Path, reason: &dyn std::fmt::Display) -> RunError {
    PlanError::at(path.display().to_string(), reason.to_string()).into()
}
