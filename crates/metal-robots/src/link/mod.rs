//! Links to bodies: bytes over TCP or a serial port, with time-outs, counters, and patience when a link breaks.

#[cfg(feature = "serial")]
pub mod serial;
pub mod tcp;

use crate::error::{BodyError, ProtocolError};
use std::io;
use std::time::{Duration, Instant};

/// Bytes to and from a body. Neither direction waits longer than the link's own time-out.
pub trait Link: Send {
    /// Sends all bytes.
    ///
    /// # Errors
    /// If the link is broken or does not take them in time.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Receives what there is, at least one byte; an error of kind `TimedOut` or `WouldBlock` if nothing comes.
    ///
    /// # Errors
    /// If the link is broken or nothing comes in time.
    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<usize>;

    /// Whether bytes wait to be received.
    ///
    /// # Errors
    /// If the link is broken.
    fn waiting(&mut self) -> io::Result<bool>;
}

/// Opens a link anew.
pub type Opener = Box<dyn Fn() -> Result<Box<dyn Link>, BodyError> + Send>;

/// What a link has cost so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Meter {
    /// Bytes sent to the body.
    pub sent_bytes: u64,
    /// Bytes received from it.
    pub received_bytes: u64,
    /// Time spent waiting for answers.
    pub waited: Duration,
}

impl Meter {
    /// Bytes in both directions.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.sent_bytes + self.received_bytes
    }

    /// What was added since `before`.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        Self {
            sent_bytes: self.sent_bytes - before.sent_bytes,
            received_bytes: self.received_bytes - before.received_bytes,
            waited: self.waited.saturating_sub(before.waited),
        }
    }
}

/// How long to wait for what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// For one answer.
    pub answer: Duration,
    /// Before the first attempt to reconnect; twice as long before each further one.
    pub first_pause: Duration,
    /// Attempts to reconnect.
    pub attempts: u32,
}

impl Default for Patience {
    /// An answer within 2 s (a whole picture takes 0.35 s over the slowest link), five attempts within 3.1 s.
    fn default() -> Self {
        Self { answer: Duration::from_secs(2), first_pause: Duration::from_millis(100), attempts: 5 }
    }
}

/// A link that counts, collects bytes until they mean something, and can be opened again.
pub struct Line {
    opener: Opener,
    link: Option<Box<dyn Link>>,
    patience: Patience,
    pending: Vec<u8>,
    meter: Meter,
}

impl Line {
    /// A line that is not open yet.
    #[must_use]
    pub fn new(opener: Opener, patience: Patience) -> Self {
        Self { opener, link: None, patience, pending: Vec::new(), meter: Meter::default() }
    }

    /// What the line has cost so far.
    #[must_use]
    pub fn meter(&self) -> Meter {
        self.meter
    }

    /// Whether the line is open, as far as anybody knows.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.link.is_some()
    }

    /// Opens the line.
    ///
    /// # Errors
    /// If nobody answers at its address.
    pub fn open(&mut self) -> Result<(), BodyError> {
        self.close();
        self.link = Some((self.opener)()?);
        Ok(())
    }

    /// Opens the line again after a loss: attempts with pauses that double.
    ///
    /// # Errors
    /// What the last attempt failed with.
    pub fn reopen(&mut self) -> Result<(), BodyError> {
        let mut pause = self.patience.first_pause;
        let mut last = self.open();
        for _ in 1..self.patience.attempts {
            if last.is_ok() {
                break;
            }
            std::thread::sleep(pause);
            pause *= 2;
            last = self.open();
        }
        last
    }

    /// Closes the line and forgets what was pending.
    pub fn close(&mut self) {
        self.link = None;
        self.pending.clear();
    }

    /// Sends bytes.
    ///
    /// # Errors
    /// If the line is broken; it is closed then.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), BodyError> {
        let sent = self.open_link()?.send(bytes);
        if let Err(error) = sent {
            return Err(self.lose(error));
        }
        self.meter.sent_bytes += bytes.len() as u64;
        Ok(())
    }

    /// Receives until `read` finds a meaning; `read` gets all that came and says how much of it it used. The time-out
    /// counts from now.
    ///
    /// # Errors
    /// If the line is broken or silent or `read` refuses; the line is closed then, for nobody knows where the next
    /// message begins.
    pub fn receive<T>(
        &mut self,
        mut read: impl FnMut(&[u8]) -> Result<(T, usize), ProtocolError>,
    ) -> Result<T, BodyError> {
        let start = Instant::now();
        let outcome = loop {
            match read(&self.pending) {
                Ok((value, used)) => {
                    self.pending.drain(..used);
                    break Ok(value);
                }
                Err(error) if !error.wants_more() => break Err(error.into()),
                Err(_) => {}
            }
            if let Err(error) = self.more(start) {
                break Err(error);
            }
        };
        self.meter.waited += start.elapsed();
        if outcome.is_err() {
            self.close();
        }
        outcome
    }

    /// Takes in what waits, without waiting.
    ///
    /// # Errors
    /// If the line is broken.
    pub fn collect(&mut self) -> Result<(), BodyError> {
        while self.open_link()?.waiting()? {
            self.more(Instant::now())?;
        }
        Ok(())
    }

    /// Drops everything that has come so far.
    ///
    /// # Errors
    /// If the line is broken.
    pub fn forget(&mut self) -> Result<(), BodyError> {
        self.collect()?;
        self.pending.clear();
        Ok(())
    }

    /// Everything that has come and was not read yet.
    #[must_use]
    pub fn pending(&self) -> &[u8] {
        &self.pending
    }

    fn more(&mut self, start: Instant) -> Result<(), BodyError> {
        let mut buffer = [0; 4096];
        loop {
            match self.open_link()?.receive(&mut buffer) {
                Ok(0) => return Err(self.lose(io::Error::from(io::ErrorKind::UnexpectedEof))),
                Ok(count) => {
                    self.pending.extend_from_slice(&buffer[..count]);
                    self.meter.received_bytes += count as u64;
                    return Ok(());
                }
                Err(e) if is_pause(&e) && start.elapsed() < self.patience.answer => {}
                Err(e) if is_pause(&e) => return Err(BodyError::Silent(self.patience.answer)),
                Err(e) => return Err(self.lose(e)),
            }
        }
    }

    fn open_link(&mut self) -> Result<&mut Box<dyn Link>, BodyError> {
        self.link.as_mut().ok_or_else(|| BodyError::Lost("the line is closed".to_owned()))
    }

    fn lose(&mut self, error: io::Error) -> BodyError {
        self.close();
        error.into()
    }
}

fn is_pause(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    struct Script(Vec<Vec<u8>>);

    impl Link for Script {
        fn send(&mut self, _: &[u8]) -> io::Result<()> {
            Ok(())
        }

        fn receive(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let Some(piece) = self.0.pop() else { return Err(io::ErrorKind::TimedOut.into()) };
            buffer[..piece.len()].copy_from_slice(&piece);
            Ok(piece.len())
        }

        fn waiting(&mut self) -> io::Result<bool> {
            Ok(!self.0.is_empty())
        }
    }

    fn patience() -> Patience {
        Patience { answer: Duration::from_millis(20), first_pause: Duration::from_millis(5), attempts: 4 }
    }

    fn pair(bytes: &[u8]) -> Result<([u8; 2], usize), ProtocolError> {
        let mut r = crate::bytes::Reader::new(bytes);
        Ok((r.many(crate::bytes::Reader::u8)?, 2))
    }

    #[test]
    fn messages_are_put_together_and_counted_and_silence_ends() {
        let opener = || Ok(Box::new(Script(vec![vec![4], vec![2, 3], vec![1]])) as Box<dyn Link>);
        let mut line = Line::new(Box::new(opener), patience());
        line.open().unwrap();
        assert_eq!(line.receive(pair).unwrap(), [1, 2]);
        assert_eq!(line.receive(pair).unwrap(), [3, 4]);
        assert_eq!(line.meter().received_bytes, 4);
        assert!(matches!(line.receive(pair), Err(BodyError::Silent(_))));
        assert!(!line.is_open(), "after silence nobody knows where a message begins");
    }

    #[test]
    fn reopening_backs_off_and_gives_up() {
        let count = Arc::new(AtomicU32::new(0));
        let seen = Arc::clone(&count);
        let opener = move || {
            seen.fetch_add(1, Ordering::Relaxed);
            Err(BodyError::Lost("nobody".to_owned()))
        };
        let mut line = Line::new(Box::new(opener), patience());
        let start = Instant::now();
        assert!(line.reopen().is_err());
        assert_eq!(count.load(Ordering::Relaxed), 4);
        assert!(start.elapsed() >= Duration::from_millis(5 + 10 + 20));
    }
}
