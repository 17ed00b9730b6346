//! Learners, and minds made of them, as bytes: a format version, the learner's name, its complete state, and a checksum over all of it.

use crate::learner::LearnerError;
use serde::{Serialize, de::DeserializeOwned};

/// Version of the byte format; a change of any frozen structure raises it.
const VERSION: u32 = 1;

/// Length of the checksum at the end.
const CHECKSUM: usize = 8;

/// The bytes of `state`, to be opened again by [`open`] under the same name.
///
/// # Panics
/// If the state holds what has no bytes; numbers, texts, vectors and maps all have.
#[must_use]
pub fn seal<T: Serialize>(learner: &'static str, state: &T) -> Vec<u8> {
    let mut bytes =
        postcard::to_stdvec(&(VERSION, learner, state)).expect("numbers and vectors always become bytes");
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
    if version != VERSION || name != learner {
        return Err(damaged(format!("it holds a `{name}` of version {version}, not of version {VERSION}")));
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
}
