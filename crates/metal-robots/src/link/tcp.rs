//! TCP, with a time-out on everything.

use super::{Link, Opener};
use crate::error::BodyError;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// How long the attempt to connect may take.
const CONNECT: Duration = Duration::from_secs(3);
/// How long one read or write may wait before its caller looks at the clock.
const SLICE: Duration = Duration::from_millis(100);

struct Tcp(TcpStream);

impl Link for Tcp {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }

    fn waiting(&mut self) -> io::Result<bool> {
        self.0.set_nonblocking(true)?;
        let peeked = self.0.peek(&mut [0]);
        self.0.set_nonblocking(false)?;
        match peeked {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(_) => Ok(true),
            Err(e) if e.kind() == ErrorKind::WouldBlock => Ok(false),
            Err(e) => Err(e),
        }
    }
}

/// Opens a connection to `host:port`.
#[must_use]
pub fn opener(address: String) -> Opener {
    Box::new(move || connect(&address).map(|stream| Box::new(Tcp(stream)) as Box<dyn Link>))
}

fn connect(address: &str) -> Result<TcpStream, BodyError> {
    let fail = |e: io::Error| BodyError::Unreachable { address: address.to_owned(), reason: e.to_string() };
    let mut last = ErrorKind::AddrNotAvailable.into();
    for socket in address.to_socket_addrs().map_err(fail)? {
        match TcpStream::connect_timeout(&socket, CONNECT).and_then(prepared) {
            Ok(stream) => return Ok(stream),
            Err(e) => last = e,
        }
    }
    Err(fail(last))
}

fn prepared(stream: TcpStream) -> io::Result<TcpStream> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(SLICE))?;
    stream.set_write_timeout(Some(Duration::from_secs(2)))?;
    Ok(stream)
}
