//! Reading and writing packed little-endian bytes, as both the E-puck and Webots speak them.

use crate::error::ProtocolError;

/// A place in bytes that somebody else wrote.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    left: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Starts at the first byte.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { left: bytes }
    }

    /// Number of bytes that were not read yet.
    #[must_use]
    pub fn remaining(&self) -> usize {
        self.left.len()
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    /// If there are fewer.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], ProtocolError> {
        if count > self.left.len() {
            return Err(ProtocolError::Truncated { wanted: count, left: self.left.len() });
        }
        let (taken, left) = self.left.split_at(count);
        self.left = left;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], ProtocolError> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?);
        Ok(out)
    }

    /// A byte.
    ///
    /// # Errors
    /// If nothing is left.
    pub fn u8(&mut self) -> Result<u8, ProtocolError> {
        Ok(self.array::<1>()?[0])
    }

    /// A 16-bit number without sign.
    ///
    /// # Errors
    /// If too little is left.
    pub fn u16(&mut self) -> Result<u16, ProtocolError> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    /// A 16-bit number.
    ///
    /// # Errors
    /// If too little is left.
    pub fn i16(&mut self) -> Result<i16, ProtocolError> {
        Ok(i16::from_le_bytes(self.array()?))
    }

    /// A 32-bit number without sign.
    ///
    /// # Errors
    /// If too little is left.
    pub fn u32(&mut self) -> Result<u32, ProtocolError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    /// A 32-bit number.
    ///
    /// # Errors
    /// If too little is left.
    pub fn i32(&mut self) -> Result<i32, ProtocolError> {
        Ok(i32::from_le_bytes(self.array()?))
    }

    /// A single-precision number.
    ///
    /// # Errors
    /// If too little is left.
    pub fn f32(&mut self) -> Result<f32, ProtocolError> {
        Ok(f32::from_le_bytes(self.array()?))
    }

    /// A double-precision number.
    ///
    /// # Errors
    /// If too little is left.
    pub fn f64(&mut self) -> Result<f64, ProtocolError> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    /// `N` values, each read by `one`.
    ///
    /// # Errors
    /// If too little is left.
    pub fn many<T: Copy + Default, const N: usize>(
        &mut self,
        mut one: impl FnMut(&mut Self) -> Result<T, ProtocolError>,
    ) -> Result<[T; N], ProtocolError> {
        let mut out = [T::default(); N];
        for value in &mut out {
            *value = one(self)?;
        }
        Ok(out)
    }

    /// A text that ends with a zero byte.
    ///
    /// # Errors
    /// If no zero follows or the text is not UTF-8.
    pub fn text(&mut self) -> Result<String, ProtocolError> {
        let missing = ProtocolError::Truncated { wanted: self.left.len() + 1, left: self.left.len() };
        let length = self.left.iter().position(|&b| b == 0).ok_or(missing)?;
        let bytes = self.take(length)?;
        self.take(1)?;
        match std::str::from_utf8(bytes) {
            Ok(text) => Ok(text.to_owned()),
            Err(e) => Err(ProtocolError::Unexpected(format!("a text that is not UTF-8 ({e})"))),
        }
    }
}

/// Bytes for somebody else to read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    /// Nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// What was written.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// Appends bytes as they are.
    pub fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(bytes);
        self
    }

    /// Appends a byte.
    pub fn u8(&mut self, value: u8) -> &mut Self {
        self.raw(&[value])
    }

    /// Appends 1 for true and 0 for false.
    pub fn flag(&mut self, value: bool) -> &mut Self {
        self.u8(u8::from(value))
    }

    /// Appends a 16-bit number without sign.
    pub fn u16(&mut self, value: u16) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// Appends a 16-bit number.
    pub fn i16(&mut self, value: i16) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// Appends a 32-bit number without sign.
    pub fn u32(&mut self, value: u32) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// Appends a 32-bit number.
    pub fn i32(&mut self, value: i32) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// Appends a single-precision number.
    pub fn f32(&mut self, value: f32) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// Appends a double-precision number.
    pub fn f64(&mut self, value: f64) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// Appends several double-precision numbers.
    pub fn f64s(&mut self, values: &[f64]) -> &mut Self {
        values.iter().for_each(|&v| {
            self.f64(v);
        });
        self
    }

    /// Appends a text and its closing zero byte. A zero inside ends the text early, as it would for the reader.
    pub fn text(&mut self, text: &str) -> &mut Self {
        let end = text.find('\0').unwrap_or(text.len());
        self.raw(&text.as_bytes()[..end]).u8(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let mut w = Writer::new();
        w.u8(7).u16(513).i16(-2).u32(9).i32(-9).f32(0.5).f64(-0.25).text("ps0").flag(true);
        let bytes = w.into_bytes();
        assert_eq!(&bytes[1..3], [1, 2], "low byte first");
        let mut r = Reader::new(&bytes);
        assert_eq!((r.u8().unwrap(), r.u16().unwrap(), r.i16().unwrap()), (7, 513, -2));
        assert_eq!((r.u32().unwrap(), r.i32().unwrap()), (9, -9));
        assert_eq!((r.f32().unwrap(), r.f64().unwrap()), (0.5, -0.25));
        assert_eq!((r.text().unwrap().as_str(), r.u8().unwrap(), r.remaining()), ("ps0", 1, 0));
    }

    #[test]
    fn too_little_is_an_error_and_nothing_is_consumed() {
        let mut r = Reader::new(&[1, 2, 3]);
        assert!(matches!(r.u32(), Err(ProtocolError::Truncated { wanted: 4, left: 3 })));
        assert_eq!(r.remaining(), 3);
        assert!(r.text().is_err());
    }
}
