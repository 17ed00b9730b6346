//! The few ROS 2 messages that a recording consists of, in CDR (little-endian): arrays of numbers, and pictures.

use metal_rl::environment::Picture;

/// Why bytes are no message of ours.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// There is less than there has to be.
    #[error("the message ends too early: {wanted} bytes wanted, {left} left")]
    Truncated {
        /// Bytes wanted.
        wanted: usize,
        /// Bytes left.
        left: usize,
    },
    /// Another kind of message.
    #[error("unexpected: {0}")]
    Unexpected(&'static str),
}

/// Name of the message of floating-point numbers.
pub const FLOATS: &str = "std_msgs/msg/Float64MultiArray";
/// Name of the message of bytes.
pub const BYTES: &str = "std_msgs/msg/UInt8MultiArray";
/// Name of the message of words.
pub const TEXT: &str = "std_msgs/msg/String";
/// Name of the message of pictures.
pub const IMAGE: &str = "sensor_msgs/msg/Image";

const LINE: &str = "================================================================================\n";
const LAYOUT: &str = "MSG: std_msgs/MultiArrayLayout\nMultiArrayDimension[] dim\nuint32 data_offset\n";
const DIMENSION: &str = "MSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n";
const HEADER: &str = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
const TIME: &str = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const PICTURE: &str = "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n";

/// The definition of a message, with those of its parts.
#[must_use]
pub fn definition(name: &str) -> String {
    match name {
        IMAGE => format!("{PICTURE}{LINE}{HEADER}{LINE}{TIME}"),
        TEXT => "string data\n".to_owned(),
        BYTES => format!("MultiArrayLayout layout\nuint8[] data\n{LINE}{LAYOUT}{LINE}{DIMENSION}"),
        _ => format!("MultiArrayLayout layout\nfloat64[] data\n{LINE}{LAYOUT}{LINE}{DIMENSION}"),
    }
}

/// Low byte first, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Bytes in CDR: every number at a multiple of its own size, counted behind the encapsulation.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new() -> Self {
        Self(ENCAPSULATION.to_vec())
    }

    fn align(&mut self, size: usize) {
        while !(self.0.len() - ENCAPSULATION.len()).is_multiple_of(size) {
            self.0.push(0);
        }
    }

    fn u32(&mut self, value: u32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.bytes().chain([0]));
    }
}

/// A message of numbers.
#[must_use]
pub fn floats(values: &[f64]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    // No dimensions, no offset.
    cdr.u32(0);
    cdr.u32(0);
    cdr.u32(values.len() as u32);
    if !values.is_empty() {
        cdr.align(8);
    }
    values.iter().for_each(|v| cdr.0.extend(v.to_le_bytes()));
    cdr.0
}

/// A message of bytes.
#[must_use]
pub fn bytes(values: &[u8]) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.u32(0);
    cdr.u32(0);
    cdr.u32(values.len() as u32);
    cdr.0.extend(values);
    cdr.0
}

/// A message of words.
#[must_use]
pub fn text(words: &str) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.text(words);
    cdr.0
}

/// A picture taken at `time_ns`.
#[must_use]
pub fn image(picture: &Picture, time_ns: u64) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.u32((time_ns / 1_000_000_000) as u32);
    cdr.u32((time_ns % 1_000_000_000) as u32);
    cdr.text("camera");
    cdr.u32(picture.rows() as u32);
    cdr.u32(picture.columns as u32);
    cdr.text("rgb8");
    cdr.0.push(0);
    cdr.u32(3 * picture.columns as u32);
    cdr.u32(3 * picture.pixels.len() as u32);
    cdr.0.extend(picture.pixels.as_flattened());
    cdr.0
}

/// The numbers in a message that [`floats`] wrote.
///
/// # Errors
/// If it is no such message.
pub fn read_floats(message: &[u8]) -> Result<Vec<f64>, CdrError> {
    let (count, rest) = start(message)?;
    // The encapsulation has 4 bytes, the three counters 12: already a multiple of 8 behind 4 more.
    let (_, rest) = take(rest, if count > 0 { 4 } else { 0 })?;
    let (numbers, _) = take(rest, count.saturating_mul(8))?;
    Ok(numbers.as_chunks().0.iter().copied().map(f64::from_le_bytes).collect())
}

/// The bytes in a message that [`bytes`] wrote.
///
/// # Errors
/// If it is no such message.
pub fn read_bytes(message: &[u8]) -> Result<Vec<u8>, CdrError> {
    let (count, rest) = start(message)?;
    Ok(take(rest, count)?.0.to_vec())
}

/// The picture in a message that [`image`] wrote.
///
/// # Errors
/// If it is no such message.
pub fn read_image(message: &[u8]) -> Result<Picture, CdrError> {
    let (encapsulation, rest) = take(message, 4)?;
    // Behind the time: `camera` with its zero, and one byte until the next multiple of four.
    let (frame, rest) = take(take(rest, 8)?.1, 12)?;
    if encapsulation != ENCAPSULATION || frame != b"\x07\0\0\0camera\0\0" {
        return Err(CdrError::Unexpected("a picture of somebody else"));
    }
    let (rows, rest) = whole(rest)?;
    let (columns, rest) = whole(rest)?;
    // `rgb8` with its zero, no big end, and two bytes until the next multiple of four.
    let (format, rest) = take(rest, 12)?;
    let (row_bytes, rest) = whole(rest)?;
    let (count, rest) = whole(rest)?;
    let fits = row_bytes == columns.saturating_mul(3) && count == rows.saturating_mul(row_bytes);
    if format != b"\x05\0\0\0rgb8\0\0\0\0" || !fits || columns == 0 {
        return Err(CdrError::Unexpected("a picture of another format"));
    }
    Ok(Picture { columns, pixels: take(rest, count)?.0.as_chunks().0.to_vec() })
}

/// A whole number, and what stands behind it.
fn whole(bytes: &[u8]) -> Result<(usize, &[u8]), CdrError> {
    let (number, rest) = take(bytes, 4)?;
    Ok((number.iter().rev().fold(0, |n, &byte| n << 8 | usize::from(byte)), rest))
}

/// The number of entries, and what stands behind it.
fn start(message: &[u8]) -> Result<(usize, &[u8]), CdrError> {
    let (encapsulation, rest) = take(message, 4)?;
    if encapsulation != ENCAPSULATION {
        return Err(CdrError::Unexpected("a message that is not little-endian CDR"));
    }
    let (layout, rest) = take(rest, 8)?;
    if layout != [0; 8] {
        return Err(CdrError::Unexpected("an array with dimensions"));
    }
    whole(rest)
}

fn take(bytes: &[u8], wanted: usize) -> Result<(&[u8], &[u8]), CdrError> {
    bytes.split_at_checked(wanted).ok_or(CdrError::Truncated { wanted, left: bytes.len() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_stand_at_multiples_of_eight() {
        let message = floats(&[1.0]);
        let golden =
            [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F];
        assert_eq!(message, golden);
        let picture = Picture { columns: 1, pixels: vec![[7, 8, 9]] };
        let message = image(&picture, 1_500_000_000);
        assert_eq!(message[4..12], [1, 0, 0, 0, 0, 0x65, 0xCD, 0x1D]);
        assert_eq!(message[message.len() - 7..], [3, 0, 0, 0, 7, 8, 9]);
    }

    proptest! {
        #[test]
        fn pictures_survive_and_no_cut_is_taken_for_whole(
            columns in 1..5_usize, rows in 0..4_usize, time_ns: u64, seed: u8, cut in 0..100_usize,
        ) {
            let pixels = (0..columns * rows).map(|i| [seed.wrapping_add(i as u8), i as u8, seed]).collect();
            let picture = Picture { columns, pixels };
            let message = image(&picture, time_ns);
            prop_assert_eq!(read_image(&message).unwrap(), picture);
            prop_assert!(read_image(&message[..message.len() * cut / 100]).is_err());
        }

        #[test]
        fn arrays_survive(values in proptest::collection::vec(any::<f64>(), 0..9), raw: Vec<u8>) {
            let again = read_floats(&floats(&values)).unwrap();
            prop_assert!(again.iter().zip(&values).all(|(a, b)| a.to_bits() == b.to_bits()));
            prop_assert_eq!(again.len(), values.len());
            prop_assert_eq!(read_bytes(&bytes(&raw)).unwrap(), raw.clone());
            let _ = (read_floats(&raw), read_bytes(&raw), read_image(&raw));
        }
    }
}
