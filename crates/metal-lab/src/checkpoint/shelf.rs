//! The files of pieces of work in a folder.

use crate::store::{StoreError, at, write_whole};
use metal_rl::learners::frozen;
use serde::{Serialize, de::DeserializeOwned};
use std::path::PathBuf;

/// Version of the files; a change of what is in them raises it.
pub const FORMAT: u32 = 2;

/// First bytes of a piece of work.
const MAGIC: &[u8; 8] = b"METALCKP";

/// What is sealed in a piece of work.
const PIECE: &str = "checkpoint";

/// The pieces of one job in one folder.
#[derive(Debug)]
pub(super) struct Shelf {
    pub folder: PathBuf,
    /// What the job is known by in every file.
    pub key: u64,
}

impl Shelf {
    /// The file of a piece of work: a readable name, made unique by a hash of the whole one.
    pub fn path(&self, piece: &str) -> PathBuf {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-.+".contains(c) { c } else { '_' };
        let readable: String = piece.chars().map(plain).take(80).collect();
        self.folder.join(format!("{readable}-{:016x}.piece", super::job::hash(piece.as_bytes())))
    }

    /// Writes a piece of work, whole or not at all.
    pub fn keep<T: Serialize>(&self, piece: &str, what: &T) -> Result<(), StoreError> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(FORMAT.to_le_bytes());
        bytes.extend(frozen::seal(PIECE, &(self.key, piece, what)));
        write_whole(&self.path(piece), &bytes)
    }

    /// A piece of work, if it was kept.
    pub fn recall<T: DeserializeOwned>(&self, piece: &str) -> Result<Option<T>, StoreError> {
        let path = self.path(piece);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(at(&path, e)),
        };
        self.open(piece, &bytes).map(Some).map_err(|reason| StoreError::Damaged { path, reason })
    }

    fn open<T: DeserializeOwned>(&self, piece: &str, bytes: &[u8]) -> Result<T, String> {
        let body = bytes.strip_prefix(MAGIC.as_slice()).ok_or("not a piece of a checkpoint")?;
        let (format, body) = body.split_first_chunk().ok_or("cut off")?;
        let format = u32::from_le_bytes(*format);
        if format != FORMAT {
            return Err(format!("format {format}, this program reads {FORMAT}"));
        }
        // What belongs to another job may have another shape, so its owner is asked first.
        let (key, name) = frozen::open::<(u64, String)>(PIECE, body).map_err(|e| e.to_string())?;
        if key != self.key {
            return Err("it belongs to another run".into());
        }
        if name != piece {
            return Err(format!("it holds `{name}`"));
        }
        let (_, _, what) = frozen::open::<(u64, String, T)>(PIECE, body).map_err(|e| e.to_string())?;
        Ok(what)
    }

    /// Removes a piece of work, if it is there.
    pub fn forget(&self, piece: &str) -> Result<(), StoreError> {
        let path = self.path(piece);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(at(&path, e)),
            _ => Ok(()),
        }
    }
}
