//! The outermost layer: greeting, requests and answers.

use crate::bytes::{Reader, Writer};
use crate::error::ProtocolError;

/// The bytes with which a controller introduces itself.
#[must_use]
pub fn hello(robot: Option<&str>) -> Vec<u8> {
    let name = robot.map_or_else(String::new, |name| format!("\nRobot-Name: {}", escaped(name)));
    format!("CTR{name}").into_bytes()
}

/// The robot a controller asks for in its greeting, if it names one.
///
/// # Errors
/// If the bytes are no greeting.
pub fn read_hello(bytes: &[u8]) -> Result<Option<String>, ProtocolError> {
    let text = String::from_utf8_lossy(bytes);
    let refuse = || ProtocolError::Unexpected(format!("the greeting `{}`", text.escape_debug()));
    let rest = text.strip_prefix("CTR").ok_or_else(refuse)?;
    if rest.is_empty() {
        return Ok(None);
    }
    let name = rest.strip_prefix("\nRobot-Name: ").ok_or_else(refuse)?;
    Ok(Some(unescaped(name.trim_end())))
}

/// A name with everything but plain letters, digits and `-_.~` as %XX.
fn escaped(name: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-_.~".contains(&b);
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

fn unescaped(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = name.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let hex = tail.get(..2).and_then(|h| u8::from_str_radix(std::str::from_utf8(h).ok()?, 16).ok());
        match (first, hex) {
            (b'%', Some(byte)) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// What Webots answers to a greeting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Welcome {
    /// The robot listens.
    Connected,
    /// There is no such robot with an external controller.
    Failed,
    /// The world is still loading; ask again.
    Processing,
    /// Somebody else drives the robot, or this computer is not allowed to.
    Forbidden,
}

impl Welcome {
    const ALL: [Self; 4] = [Self::Connected, Self::Failed, Self::Processing, Self::Forbidden];

    /// The word on the wire; no zero and no line end follows it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Connected => "CONNECTED",
            Self::Failed => "FAILED",
            Self::Processing => "PROCESSING",
            Self::Forbidden => "FORBIDDEN",
        }
    }

    /// The meaning of what has come so far.
    ///
    /// # Errors
    /// [`ProtocolError::Truncated`] while a word is incomplete; another error if it cannot become one.
    pub fn read(bytes: &[u8]) -> Result<Self, ProtocolError> {
        if let Some(word) = Self::ALL.iter().find(|w| bytes == w.word().as_bytes()) {
            return Ok(*word);
        }
        if Self::ALL.iter().any(|w| w.word().as_bytes().starts_with(bytes)) {
            return Err(ProtocolError::Truncated { wanted: 1, left: 0 });
        }
        let text = String::from_utf8_lossy(bytes).escape_debug().to_string();
        Err(ProtocolError::Unexpected(format!("the answer `{text}` to the greeting")))
    }
}

/// Orders to the robot and its devices, and how long the simulation shall run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// Milliseconds of simulation; 0: answer at once.
    pub step_ms: u32,
    /// Tag of a device and its orders, one behind the other.
    pub orders: Vec<(u16, Vec<u8>)>,
}

/// The bytes behind the last request of a controller that leaves.
pub const GOODBYE: [u8; 4] = [0; 4];

impl Request {
    /// The bytes, their number first.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let orders: usize = self.orders.iter().map(|(_, payload)| 6 + payload.len()).sum();
        let mut w = Writer::new();
        w.u32(8 + orders as u32).u32(self.step_ms);
        for (tag, payload) in &self.orders {
            w.u16(*tag).i32(payload.len() as i32).raw(payload);
        }
        w.into_bytes()
    }

    /// The request at the beginning of `bytes` (none: the controller says goodbye) and its length.
    ///
    /// # Errors
    /// [`ProtocolError::Truncated`] while it is incomplete; another error if it means nothing.
    pub fn decode(bytes: &[u8]) -> Result<(Option<Self>, usize), ProtocolError> {
        let size = Reader::new(bytes).u32()? as usize;
        if size == 0 {
            return Ok((None, 4));
        }
        if !(8..=MOST_BYTES).contains(&size) {
            return Err(ProtocolError::Unexpected(format!("a request of {size} bytes")));
        }
        let mut r = Reader::new(Reader::new(bytes).take(size)?);
        r.u32()?;
        let inside = |_| ProtocolError::Unexpected("a request shorter than the orders in it".to_owned());
        let mut request = Self { step_ms: r.u32().map_err(inside)?, orders: Vec::new() };
        while r.remaining() > 0 {
            let tag = r.u16().map_err(inside)?;
            let length = usize::try_from(r.i32().map_err(inside)?).unwrap_or(usize::MAX);
            request.orders.push((tag, r.take(length).map_err(inside)?.to_vec()));
        }
        Ok((Some(request), size))
    }
}

/// No request and no answer of a small robot is larger.
const MOST_BYTES: usize = 64 << 20;

/// A picture in an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Tag of the camera.
    pub tag: u16,
    /// Whether it shows segments instead of colours.
    pub segments: bool,
    /// Blue, green, red, alpha of each pixel.
    pub bgra: Vec<u8>,
}

/// What the simulator answers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// Milliseconds the simulation is late; negative: nobody asked for this answer, the wanted one follows.
    pub delay_ms: i32,
    /// News of the devices, one behind the other, without lengths.
    pub news: Vec<u8>,
    /// Pictures.
    pub images: Vec<Image>,
}

impl Answer {
    /// The bytes: all news in one chunk, then the pictures.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let data = 4 + self.news.len();
        let mut w = Writer::new();
        w.u16(1 + self.images.len() as u16).i32(data as i32);
        w.i32(data as i32).u8(0).i32(self.delay_ms).raw(&self.news);
        for image in &self.images {
            w.i32(image.bgra.len() as i32).u8(1);
            w.u16(image.tag).u8(if image.segments { 9 } else { 0 }).raw(&image.bgra);
        }
        w.into_bytes()
    }

    /// The answer at the beginning of `bytes` and its length.
    ///
    /// # Errors
    /// [`ProtocolError::Truncated`] while it is incomplete; another error if it means nothing.
    pub fn decode(bytes: &[u8]) -> Result<(Self, usize), ProtocolError> {
        let mut r = Reader::new(bytes);
        let (chunks, total) = (r.u16()?, r.i32()?);
        let (mut data, mut images) = (Vec::new(), Vec::new());
        for _ in 0..chunks {
            let (size, kind) = (chunk_size(r.i32()?)?, r.u8()?);
            match kind {
                0 => data.extend_from_slice(r.take(size)?),
                1 => {
                    let (tag, what) = (r.u16()?, r.u8()?);
                    images.push(Image { tag, segments: what == 9, bgra: r.take(size)?.to_vec() });
                }
                _ => return Err(ProtocolError::Unexpected(format!("a chunk of kind {kind}"))),
            }
        }
        if usize::try_from(total) != Ok(data.len()) || data.len() < 4 {
            let found = data.len();
            return Err(ProtocolError::Unexpected(format!("{found} bytes of news, {total} announced")));
        }
        let delay_ms = Reader::new(&data).i32()?;
        Ok((Self { delay_ms, news: data.split_off(4), images }, bytes.len() - r.remaining()))
    }
}

fn chunk_size(size: i32) -> Result<usize, ProtocolError> {
    let within = usize::try_from(size).ok().filter(|s| *s <= MOST_BYTES);
    within.ok_or_else(|| ProtocolError::Unexpected(format!("a chunk of {size} bytes")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn greetings_have_the_documented_bytes() {
        assert_eq!(hello(None), b"CTR");
        assert_eq!(hello(Some("my robot")), b"CTR\nRobot-Name: my%20robot");
        assert_eq!(read_hello(b"CTR").unwrap(), None);
        assert_eq!(read_hello(b"CTR\nRobot-Name: my%20robot").unwrap().as_deref(), Some("my robot"));
        assert!(read_hello(b"GET / HTTP/1.1").is_err());
        assert_eq!(Welcome::read(b"CONNECTED").unwrap(), Welcome::Connected);
        assert!(matches!(Welcome::read(b"F"), Err(ProtocolError::Truncated { .. })));
        assert!(matches!(Welcome::read(b"FX"), Err(ProtocolError::Unexpected(_))));
    }

    #[test]
    fn a_request_has_the_documented_bytes() {
        let request = Request { step_ms: 32, orders: vec![(5, vec![2, 0, 9])] };
        assert_eq!(request.encode(), [17, 0, 0, 0, 32, 0, 0, 0, 5, 0, 3, 0, 0, 0, 2, 0, 9]);
        assert_eq!(Request::decode(&GOODBYE).unwrap(), (None, 4));
        assert!(matches!(Request::decode(&[9, 0, 0, 0, 0, 0, 0, 0, 1]), Err(ProtocolError::Unexpected(_))));
    }

    #[test]
    fn an_answer_has_the_documented_bytes() {
        let image = Image { tag: 9, segments: false, bgra: vec![1, 2, 3, 255] };
        let answer = Answer { delay_ms: 0, news: vec![0, 0, 2], images: vec![image] };
        let golden =
            [2, 0, 7, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 4, 0, 0, 0, 1, 9, 0, 0, 1, 2, 3, 255];
        assert_eq!(answer.encode(), golden);
        assert_eq!(Answer::decode(&golden).unwrap(), (answer, golden.len()));
    }

    proptest! {
        #[test]
        fn requests_survive_the_wire_in_pieces(
            step_ms: u32, orders in proptest::collection::vec((any::<u16>(), proptest::collection::vec(any::<u8>(), 0..20)), 0..5),
        ) {
            let request = Request { step_ms, orders };
            let bytes = request.encode();
            for cut in 0..bytes.len() {
                prop_assert!(Request::decode(&bytes[..cut]).unwrap_err().wants_more());
            }
            prop_assert_eq!(Request::decode(&bytes).unwrap(), (Some(request), bytes.len()));
        }

        #[test]
        fn answers_survive_the_wire_in_pieces(
            delay_ms: i32, news in proptest::collection::vec(any::<u8>(), 0..30),
            images in proptest::collection::vec((any::<u16>(), any::<bool>(), proptest::collection::vec(any::<u8>(), 0..20)), 0..3),
        ) {
            let images = images.into_iter().map(|(tag, segments, bgra)| Image { tag, segments, bgra }).collect();
            let answer = Answer { delay_ms, news, images };
            let bytes = answer.encode();
            for cut in 0..bytes.len() {
                prop_assert!(Answer::decode(&bytes[..cut]).unwrap_err().wants_more());
            }
            prop_assert_eq!(Answer::decode(&bytes).unwrap(), (answer, bytes.len()));
        }

        #[test]
        fn no_bytes_make_the_decoders_fall(bytes in proptest::collection::vec(any::<u8>(), 0..60), name in ".{0,12}") {
            let _ = (Request::decode(&bytes), Answer::decode(&bytes), Welcome::read(&bytes), read_hello(&bytes));
            prop_assert_eq!(unescaped(&escaped(&name)), name);
        }
    }
}
