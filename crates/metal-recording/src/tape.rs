//! The file that is written: channels, schemas and messages, in the order of time.

use crate::cdr;
use mcap::records::{MessageHeader, Metadata, Record};
use metal_rl::environment::{EnvironmentSpec, Picture};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Time between two motor steps on the tape, in nanoseconds: the duration of a motor action.
pub const STEP_NS: u64 = 500_000_000;
/// Name of the record that holds the environment's contract.
pub const SPEC: &str = "metal.spec";

/// Why a recording could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum TapeError {
    /// The file.
    #[error("{0}")]
    File(#[from] std::io::Error),
    /// The format.
    #[error("{0}")]
    Mcap(#[from] mcap::McapError),
    /// A message.
    #[error("{0}")]
    Message(#[from] cdr::CdrError),
    /// The contract inside.
    #[error("the contract in the recording means nothing: {0}")]
    Spec(#[from] serde_json::Error),
    /// Something is missing or doubled.
    #[error("this is no recording of METAL: {0}")]
    Foreign(String),
}

struct Inner {
    writer: mcap::Writer<BufWriter<File>>,
    channels: BTreeMap<String, u16>,
    time_ns: u64,
    sequence: u32,
    error: Option<TapeError>,
    resting: bool,
}

/// A recording being written. Clones write into the same file.
#[derive(Clone)]
pub struct Tape(Arc<Mutex<Inner>>);

impl Tape {
    /// Begins a recording of an environment with this contract.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path, spec: &EnvironmentSpec) -> Result<Self, TapeError> {
        let options = mcap::WriteOptions::new().compression(None).profile("ros2").library("metal");
        let mut writer = options.create(BufWriter::new(File::create(path)?))?;
        let metadata = BTreeMap::from([("json".to_owned(), serde_json::to_string(spec)?)]);
        writer.write_metadata(&Metadata { name: SPEC.to_owned(), metadata })?;
        let channels = BTreeMap::new();
        Ok(Self(Arc::new(Mutex::new(Inner {
            writer,
            channels,
            time_ns: 0,
            sequence: 0,
            error: None,
            resting: false,
        }))))
    }

    /// Writes a message of numbers.
    pub fn floats(&self, topic: &str, values: &[f64]) {
        self.message((topic, cdr::FLOATS), |_| cdr::floats(values));
    }

    /// Writes a message of bytes.
    pub fn bytes(&self, topic: &str, values: &[u8]) {
        self.message((topic, cdr::BYTES), |_| cdr::bytes(values));
    }

    /// Writes a message of words.
    pub fn text(&self, topic: &str, words: &str) {
        self.message((topic, cdr::TEXT), |_| cdr::text(words));
    }

    /// Writes a picture.
    pub fn image(&self, topic: &str, picture: &Picture) {
        self.message((topic, cdr::IMAGE), |time_ns| cdr::image(picture, time_ns));
    }

    /// The next motor step begins.
    pub fn advance(&self) {
        self.with(|inner| {
            inner.time_ns += STEP_NS;
            Ok(())
        });
    }

    /// Nothing is written any more, until [`Self::go_on`].
    pub fn rest(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).resting = true;
    }

    /// Ends a rest.
    pub fn go_on(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).resting = false;
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// What any write since the beginning failed with.
    pub fn finish(&self) -> Result<(), TapeError> {
        let mut inner = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = inner.error.take() {
            return Err(error);
        }
        inner.writer.finish()?;
        Ok(())
    }

    fn message(&self, (topic, schema): (&str, &str), data: impl FnOnce(u64) -> Vec<u8>) {
        self.with(|inner| {
            let channel_id = inner.channel(topic, schema)?;
            inner.sequence += 1;
            let (sequence, time) = (inner.sequence, inner.time_ns);
            let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
            Ok(inner.writer.write_to_known_channel(&header, &data(time))?)
        });
    }

    /// A run does not end because its recording failed: the first error is kept for [`Self::finish`].
    fn with(&self, write: impl FnOnce(&mut Inner) -> Result<(), TapeError>) {
        let mut inner = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if inner.error.is_none()
            && !inner.resting
            && let Err(error) = write(&mut inner)
        {
            inner.error = Some(error);
        }
    }
}

/// The messages of a recording, in its order, if its records fill its chunks.
///
/// The reader of the crate `mcap` 0.26 counts down what is left of a chunk without asking whether a record inside claims
/// more, and then panics or reads on for ever. So that is asked first.
///
/// # Errors
/// If it is no MCAP, or a chunk is damaged.
pub(crate) fn messages(bytes: &[u8]) -> Result<mcap::MessageStream<'_>, TapeError> {
    for record in mcap::read::LinearReader::new(bytes)? {
        if let Record::Chunk { header, data } = record?
            && header.compression.is_empty()
            && (header.compressed_size != data.len() as u64 || !is_filled(&data))
        {
            return Err(TapeError::Foreign("a chunk is damaged".to_owned()));
        }
    }
    Ok(mcap::MessageStream::new(bytes)?)
}

/// Whether `chunk` is made of whole records: a byte for the kind, eight for the length, and as many as that says.
fn is_filled(mut chunk: &[u8]) -> bool {
    while let Some(([_, length @ ..], rest)) = chunk.split_first_chunk::<9>() {
        let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
        let Some((_, behind)) = rest.split_at_checked(length) else { return false };
        chunk = behind;
    }
    chunk.is_empty()
}

/// Topic and time (nanoseconds) of every message of a recording, in its order.
///
/// # Errors
/// If it is no MCAP.
pub fn index(bytes: &[u8]) -> Result<Vec<(String, u64)>, TapeError> {
    let mut rows = Vec::new();
    for message in messages(bytes)? {
        let message = message?;
        rows.push((message.channel.topic.clone(), message.log_time));
    }
    Ok(rows)
}

impl Inner {
    fn channel(&mut self, topic: &str, schema: &str) -> Result<u16, TapeError> {
        if let Some(id) = self.channels.get(topic) {
            return Ok(*id);
        }
        let schema_id = self.writer.add_schema(schema, "ros2msg", cdr::definition(schema).as_bytes())?;
        let id = self.writer.add_channel(schema_id, topic, "cdr", &BTreeMap::new())?;
        self.channels.insert(topic.to_owned(), id);
        Ok(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chunk_is_filled_by_whole_records_and_nothing_else() {
        let record = |claimed: u64, bytes: &[u8]| [&[5][..], &claimed.to_le_bytes(), bytes].concat();
        assert!(is_filled(&[]));
        assert!(is_filled(&[record(2, &[1, 2]), record(0, &[])].concat()));
        assert!(!is_filled(&record(3, &[1, 2])), "longer than the chunk");
        assert!(!is_filled(&record(u64::MAX, &[1, 2])));
        assert!(!is_filled(&[record(2, &[1, 2]), vec![5, 0, 0]].concat()), "half a header");
    }
}
