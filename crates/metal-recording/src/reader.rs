//! Reading the records of MCAP that our recordings consist of. Nothing takes a length at its word: a damaged or hostile file
//! is refused before memory is asked for. (The reader of the crate `mcap` 0.26 counts below zero or asks for gigabytes.)

use crate::tape::TapeError;
use std::collections::BTreeMap;

/// A message of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Message<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// Its time, in nanoseconds.
    pub time_ns: u64,
    /// What it says.
    pub data: &'a [u8],
}

/// What is on a recording.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contents<'a> {
    /// Records of facts, by name: their entries.
    pub facts: BTreeMap<&'a str, BTreeMap<&'a str, &'a str>>,
    /// Messages, in the order of the file.
    pub messages: Vec<Message<'a>>,
    topics: BTreeMap<u16, &'a str>,
}

const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const METADATA: u8 = 12;
const DATA_END: u8 = 15;

/// The contents of a recording.
///
/// # Errors
/// If it is no MCAP, compressed, cut or damaged.
pub(crate) fn contents(bytes: &[u8]) -> Result<Contents<'_>, TapeError> {
    let inside = bytes.strip_prefix(mcap::MAGIC).and_then(|b| b.strip_suffix(mcap::MAGIC));
    let mut left = Bytes(inside.ok_or_else(|| damaged("it does not begin and end as MCAP does"))?);
    let mut contents = Contents::default();
    while !left.0.is_empty() {
        let before = bytes.len() - mcap::MAGIC.len() - left.0.len();
        let (kind, mut record) = left.record()?;
        match kind {
            CHUNK => contents.chunk(record)?,
            // Behind the data everything is said once more, for who seeks in the file.
            DATA_END => {
                let sum = record.u32()?;
                if sum != 0 && sum != crc32fast::hash(&bytes[..before]) {
                    return Err(damaged("its checksum is wrong"));
                }
                return Ok(contents);
            }
            _ => contents.note(kind, record)?,
        }
    }
    Err(damaged("its end is missing"))
}

fn damaged(how: &str) -> TapeError {
    TapeError::Foreign(how.to_owned())
}

impl<'a> Contents<'a> {
    fn chunk(&mut self, mut chunk: Bytes<'a>) -> Result<(), TapeError> {
        // Times of the first and last message, and the size without compression.
        chunk.take(24)?;
        let (sum, compression) = (chunk.u32()?, chunk.text()?);
        if !compression.is_empty() {
            return Err(damaged("it is compressed"));
        }
        let length = chunk.length(8)?;
        let mut records = Bytes(chunk.take(length)?);
        if sum != 0 && sum != crc32fast::hash(records.0) {
            return Err(damaged("a chunk's checksum is wrong"));
        }
        while !records.0.is_empty() {
            let (kind, record) = records.record()?;
            self.note(kind, record)?;
        }
        Ok(())
    }

    fn note(&mut self, kind: u8, mut record: Bytes<'a>) -> Result<(), TapeError> {
        match kind {
            CHANNEL => {
                let (channel, _schema) = (record.u16()?, record.u16()?);
                self.topics.insert(channel, record.text()?);
            }
            MESSAGE => {
                let (channel, _sequence) = (record.u16()?, record.u32()?);
                let (time_ns, _published) = (record.u64()?, record.u64()?);
                let topic = self.topics.get(&channel).ok_or_else(|| damaged("a message without a topic"))?;
                self.messages.push(Message { topic, time_ns, data: record.0 });
            }
            METADATA => {
                let name = record.text()?;
                let length = record.length(4)?;
                let mut entries = Bytes(record.take(length)?);
                let facts = self.facts.entry(name).or_default();
                while !entries.0.is_empty() {
                    facts.insert(entries.text()?, entries.text()?);
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// What was not read yet.
#[derive(Clone, Copy, Debug)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], TapeError> {
        let (taken, left) =
            self.0.split_at_checked(count).ok_or_else(|| damaged("a record ends too early"))?;
        self.0 = left;
        Ok(taken)
    }

    /// A whole number of `size` bytes, low byte first.
    fn number(&mut self, size: usize) -> Result<u64, TapeError> {
        Ok(self.take(size)?.iter().rev().fold(0, |n, &byte| n << 8 | u64::from(byte)))
    }

    fn u16(&mut self) -> Result<u16, TapeError> {
        Ok(self.number(2)? as u16)
    }

    fn u32(&mut self) -> Result<u32, TapeError> {
        Ok(self.number(4)? as u32)
    }

    fn u64(&mut self) -> Result<u64, TapeError> {
        self.number(8)
    }

    /// How many bytes follow, by a number of `size` bytes.
    fn length(&mut self, size: usize) -> Result<usize, TapeError> {
        Ok(usize::try_from(self.number(size)?).unwrap_or(usize::MAX))
    }

    fn text(&mut self) -> Result<&'a str, TapeError> {
        let length = self.length(4)?;
        std::str::from_utf8(self.take(length)?).map_err(|e| TapeError::Foreign(e.to_string()))
    }

    /// The next record: its kind and its bytes.
    fn record(&mut self) -> Result<(u8, Self), TapeError> {
        let kind = self.number(1)? as u8;
        let length = self.length(8)?;
        Ok((kind, Self(self.take(length)?)))
    }
}
