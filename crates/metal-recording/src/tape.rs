//! The file that is written: channels, schemas and messages, in the order of time.

use crate::cdr;
use crate::reader::contents;
use mcap::records::{MessageHeader, Metadata};
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

/// Topic and time (nanoseconds) of every message of a recording, in its order.
///
/// # Errors
/// If it is no MCAP.
pub fn index(bytes: &[u8]) -> Result<Vec<(String, u64)>, TapeError> {
    let messages = contents(bytes)?.messages;
    Ok(messages.into_iter().map(|message| (message.topic.to_owned(), message.time_ns)).collect())
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
