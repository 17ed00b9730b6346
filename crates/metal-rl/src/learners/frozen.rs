//! Learners, and minds made of them, as bytes: a format version, the learner's name, its complete state, and a checksum over all of it.

use crate::learner::LearnerError;
use serde::{Serialize, de::DeserializeOwned};

/// Versions of what is no longer frozen as it was at first, by name. A change of any frozen structure raises its version,
/// settings that are frozen along included: the bytes do not describe themselves. A kept run folder reminds whoever forgets
/// (metal-lab, `tests/kept_minds.rs`).
const VERSIONS: [(&str, u32); 1] = [("counterfactual", 3)];

/// The version in which `learner` is sealed and opened.
fn version_of(learner: &str) -> u32 {
    VERSIONS.iter().find(|(name, _)| *name == learner).map_or(1, |(_, version)| *version)
}

/// Length of the checksum at the end.
const CHECKSUM: usize = 8;

/// The bytes of `state`, to be opened again by [`open`] under the same name.
///
/// # Panics
/// If the state holds what has no bytes; numbers, texts, vectors and maps all have.
#[must_use]
pub fn seal<T: Serialize>(learner: &'static str, state: &T) -> Vec<u8> {
    seal_as(version_of(learner), learner, state)
}

fn seal_as<T: Serialize>(version: u32, learner: &'static str, state: &T) -> Vec<u8> {
    let mut bytes =
        postcard::to_stdvec(&(version, learner, state)).expect("numbers and vectors always become bytes");
    let sum = checksum(&bytes);
    bytes.extend_from_slice(&sum.to_le_bytes());
    bytes
}

/// The state in `bytes`, if they are whole and were sealed under the same name.
///
/// # Errors
/// If they are cut, changed, of another name or of another version.
pub fn open<T: DeserializeOwned>(learner: &'static str, bytes: &[u8]) -> Result<T, LearnerError> {
    let damaged = |reason: String| LearnerError::Frozen { learner, reason };
    let Some((body, sum)) = bytes.split_last_chunk::<CHECKSUM>() else {
        return Err(damaged(format!("{} bytes are too few", bytes.len())));
    };
    if checksum(body).to_le_bytes() != *sum {
        return Err(damaged("the checksum does not match".into()));
    }
    let ((version, name), rest): ((u32, &str), &[u8]) =
        postcard::take_from_bytes(body).map_err(|e| damaged(e.to_string()))?;
    let known = version_of(learner);
    if version != known || name != learner {
        let wanted = format!("this program reads `{learner}` of version {known}");
        return Err(damaged(format!("it holds `{name}` of version {version}, {wanted}")));
    }
    postcard::from_bytes(rest).map_err(|e| damaged(e.to_string()))
}

/// The error for a state that is whole but belongs to other settings.
pub(crate) fn foreign(learner: &'static str) -> LearnerError {
    LearnerError::Frozen { learner, reason: "it was frozen under other settings".into() }
}

/// FNV-1a, 64 bits: each step is one-to-one, so that a single changed byte is always found.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_sealed_comes_back_only_under_its_name() {
        let bytes = seal("tile", &vec![1.5_f64, -2.0]);
        assert_eq!(open::<Vec<f64>>("tile", &bytes).unwrap(), [1.5, -2.0]);
        assert!(open::<Vec<f64>>("mlp", &bytes).is_err());
    }

    #[test]
    fn another_version_is_refused_by_name() {
        let bytes = seal_as(1, "counterfactual", &vec![1.5_f64]);
        let said = open::<Vec<f64>>("counterfactual", &bytes).unwrap_err().to_string();
        let known = version_of("counterfactual");
        let wanted = format!(
            "it holds `counterfactual` of version 1, this program reads `counterfactual` of version {known}"
        );
        assert!(known > 1 && said.contains(&wanted), "{said}");
        assert!(open::<Vec<f64>>("tile", &seal_as(2, "tile", &vec![1.5_f64])).is_err());
    }
}
