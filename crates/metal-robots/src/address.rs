//! Where a body is: `epuck2://192.168.1.10:1000`, `epuck:///dev/rfcomm0`, `webots://localhost:1234/learner`.

use crate::bodies::{Epuck2, Webots};
use crate::body::Body;
use crate::error::BodyError;
use crate::link::{Patience, tcp};

/// Port of the e-puck2's own server.
const EPUCK2_PORT: u16 = 1000;
/// Port on which Webots waits for controllers.
const WEBOTS_PORT: u16 = 1234;

/// Where a body is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// An E-puck on a serial line.
    Epuck {
        /// Path of the port.
        path: String,
        /// Whether the camera is cropped to the attended region.
        crop: bool,
        /// Whether it is an e-puck2 in its compatible mode.
        second: bool,
    },
    /// An e-puck2 on the network: host and port.
    Epuck2(String),
    /// A robot in Webots: host and port, and its name.
    Webots(String, Option<String>),
}

impl std::str::FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let help = "epuck:///dev/rfcomm0 (with ?crop and ?second, if wanted), epuck2://HOST[:PORT] or webots://HOST[:PORT][/ROBOT]";
        let refuse = || format!("`{text}` is no body's address: {help}");
        let (scheme, rest) = text.split_once("://").ok_or_else(refuse)?;
        let found = match scheme {
            "epuck" => serial(rest),
            "epuck2" => with_port(rest, EPUCK2_PORT).map(Self::Epuck2),
            "webots" => {
                let (host, robot) = rest.split_once('/').map_or((rest, None), |(h, r)| (h, Some(r)));
                let robot = robot.filter(|r| !r.is_empty()).map(str::to_owned);
                with_port(host, WEBOTS_PORT).map(|host| Self::Webots(host, robot))
            }
            _ => None,
        };
        found.ok_or_else(refuse)
    }
}

fn serial(rest: &str) -> Option<Address> {
    let (path, options) = rest.split_once('?').unwrap_or((rest, ""));
    let mut address = (false, false);
    for option in options.split('&').filter(|o| !o.is_empty()) {
        match option {
            "crop" => address.0 = true,
            "second" => address.1 = true,
            _ => return None,
        }
    }
    let (crop, second) = address;
    if path.is_empty() { None } else { Some(Address::Epuck { path: path.to_owned(), crop, second }) }
}

fn with_port(host: &str, port: u16) -> Option<String> {
    match host.rsplit_once(':') {
        Some((name, digits)) if !name.is_empty() => digits.parse::<u16>().ok().map(|_| host.to_owned()),
        None if !host.is_empty() => Some(format!("{host}:{port}")),
        _ => None,
    }
}

impl Address {
    /// Finds the body and stops it.
    ///
    /// # Errors
    /// If nobody answers there, or what answers is no such body.
    pub fn connect(&self, patience: Patience) -> Result<Box<dyn Body>, BodyError> {
        match self {
            Self::Epuck { path, crop, second } => connect_serial(path, (*crop, *second), patience),
            Self::Epuck2(host) => Ok(Box::new(Epuck2::connect(tcp::opener(host.clone()), patience)?)),
            Self::Webots(host, robot) => {
                Ok(Box::new(Webots::connect(tcp::opener(host.clone()), patience, robot.as_deref())?))
            }
        }
    }
}

#[cfg(feature = "serial")]
fn connect_serial(
    path: &str,
    (crop, second): (bool, bool),
    patience: Patience,
) -> Result<Box<dyn Body>, BodyError> {
    use crate::bodies::epuck1::{Epuck1, Options};
    use crate::epuck::binary::Firmware;
    let firmware = if second { Firmware::Second } else { Firmware::First };
    let opener = crate::link::serial::opener(path.to_owned());
    Ok(Box::new(Epuck1::connect(opener, patience, Options { firmware, crop })?))
}

#[cfg(not(feature = "serial"))]
fn connect_serial(path: &str, _: (bool, bool), _: Patience) -> Result<Box<dyn Body>, BodyError> {
    Err(BodyError::Unsupported(format!("{path}: this program was built without serial ports")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_and_others_refused_with_help() {
        let read = |text: &str| text.parse::<Address>();
        assert_eq!(read("epuck2://10.0.0.7"), Ok(Address::Epuck2("10.0.0.7:1000".to_owned())));
        assert_eq!(read("epuck2://h:11000"), Ok(Address::Epuck2("h:11000".to_owned())));
        let webots = Address::Webots("localhost:1234".to_owned(), Some("learner".to_owned()));
        assert_eq!(read("webots://localhost/learner"), Ok(webots));
        let path = "/dev/rfcomm0".to_owned();
        assert_eq!(read("epuck:///dev/rfcomm0?crop"), Ok(Address::Epuck { path, crop: true, second: false }));
        for wrong in
            ["epuck2://", "epuck2://:1", "epuck://", "http://x", "x", "epuck2://h:port", "epuck:///d?x"]
        {
            assert!(read(wrong).unwrap_err().contains("epuck2://HOST"), "{wrong}");
        }
    }
}
