//! Serial ports: a USB cable, or Bluetooth through `rfcomm`.

use super::{Link, Opener};
use crate::error::BodyError;
use serialport::SerialPort;
use std::io::{self, Read, Write};
use std::time::Duration;

/// Speed of the E-puck's serial line, in bits per second (8 data bits, no parity, 1 stop bit).
pub const BAUD: u32 = 115_200;
/// Bits on the wire for one byte.
pub const BITS_PER_BYTE: u32 = 10;

struct Serial(Box<dyn SerialPort>);

impl Link for Serial {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)?;
        self.0.flush()
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }

    fn waiting(&mut self) -> io::Result<bool> {
        Ok(self.0.bytes_to_read()? > 0)
    }
}

/// Opens the serial port at `path`.
#[must_use]
pub fn opener(path: String) -> Opener {
    Box::new(move || {
        let port = serialport::new(&path, BAUD).timeout(Duration::from_millis(100)).open();
        match port {
            Ok(port) => Ok(Box::new(Serial(port)) as Box<dyn Link>),
            Err(e) => Err(BodyError::Unreachable { address: path.clone(), reason: e.to_string() }),
        }
    })
}
