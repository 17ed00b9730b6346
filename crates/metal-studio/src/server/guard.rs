//! Who may talk to the studio: whoever knows the token, from a page of the studio itself.
//!
//! Three things are asked of every request. The path begins with the token, which nobody can guess. The `Host` is this
//! machine or a bare address, so that a name which an attacker lets point here (DNS rebinding) is refused. And an
//! `Origin`, where a browser sends one, is the studio's own, so that no other page can speak for its reader; a WebSocket
//! must send one.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use metal_lab::store::Store;
use std::net::{IpAddr, Ipv6Addr};
use std::path::PathBuf;
use std::sync::Arc;

/// What every request is measured by.
#[derive(Clone, Debug)]
pub struct Guard {
    token: Arc<str>,
    only_loopback: bool,
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The path does not begin with the token.
    Token,
    /// The `Host` is a name that could point anywhere.
    Host,
    /// Another page sent it.
    Origin,
    /// Only reading is possible; what changes something goes through the WebSocket.
    Method,
}

/// Why there is no token.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// The system has no randomness.
    #[error("the system gives no random numbers: {0}")]
    Randomness(#[from] getrandom::Error),
    /// The kept token.
    #[error("{}: {source}", path.display())]
    File {
        /// Where it is kept.
        path: PathBuf,
        /// What is wrong.
        source: std::io::Error,
    },
}

/// A token of 128 random bits.
///
/// # Errors
/// If the system has no randomness.
pub fn token() -> Result<String, TokenError> {
    let mut bytes = [0_u8; 16];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|b| format!("{b:02x}")).collect())
}

/// The token of the run folder, which only its owner can read; a new one if there is none or it is no token.
///
/// # Errors
/// If it cannot be written.
pub fn kept(store: &Store) -> Result<String, TokenError> {
    let path = store.path("studio.token");
    if let Some(token) = std::fs::read_to_string(&path).ok().filter(|t| is_token(t)) {
        return Ok(token);
    }
    let token = token()?;
    write_privately(&path, &token).map_err(|source| TokenError::File { path, source })?;
    Ok(token)
}

fn is_token(text: &str) -> bool {
    text.len() == 32 && text.bytes().all(|b| b.is_ascii_hexdigit())
}

fn write_privately(path: &std::path::Path, token: &str) -> std::io::Result<()> {
    // A file that others may have made readable must not be reused.
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(e),
        _ => {}
    }
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    std::io::Write::write_all(&mut options.open(path)?, token.as_bytes())
}

impl Guard {
    /// A guard for a server that listens on `address`.
    #[must_use]
    pub fn new(token: &str, address: IpAddr) -> Self {
        Self { token: Arc::from(token), only_loopback: address.is_loopback() }
    }

    /// Whether a request may pass.
    ///
    /// # Errors
    /// The first thing that is wrong with it.
    pub fn check(&self, path: &str, headers: &HeaderMap) -> Result<(), Refusal> {
        let text = |name: header::HeaderName| headers.get(name).and_then(|v| v.to_str().ok());
        let host = text(header::HOST).filter(|host| self.knows_host(host)).ok_or(Refusal::Host)?;
        let first = path.trim_start_matches('/').split('/').next().unwrap_or_default();
        if !same(first.as_bytes(), self.token.as_bytes()) {
            return Err(Refusal::Token);
        }
        let own = format!("http://{host}");
        let upgrades = headers.contains_key(header::UPGRADE);
        match text(header::ORIGIN) {
            Some(origin) if origin != own => Err(Refusal::Origin),
            None if upgrades || headers.contains_key(header::ORIGIN) => Err(Refusal::Origin),
            _ if text(header::HeaderName::from_static("sec-fetch-site")) == Some("cross-site") => {
                Err(Refusal::Origin)
            }
            _ => Ok(()),
        }
    }

    /// Bare addresses and `localhost` cannot be made to point elsewhere. The port is not looked at: behind `ssh -L` it
    /// is another one.
    fn knows_host(&self, host: &str) -> bool {
        let name = match host.strip_prefix('[') {
            Some(rest) => rest.split(']').next().unwrap_or_default(),
            None => host.split(':').next().unwrap_or_default(),
        };
        let address = name.parse::<IpAddr>().or_else(|_| name.parse::<Ipv6Addr>().map(IpAddr::V6));
        match address {
            Ok(address) => address.is_loopback() || !self.only_loopback,
            Err(_) => name == "localhost",
        }
    }
}

/// Compares in the same time wherever the difference is.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |sum, (x, y)| sum | (x ^ y)) == 0
}

/// What may be loaded and who may frame the page: nothing from elsewhere, nobody.
const HEADERS: [(header::HeaderName, &str); 6] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; style-src-attr 'unsafe-inline'; \
         img-src 'self' data: blob:; media-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (header::HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
];

/// Lets through what the guard lets through.
pub async fn watch(State(guard): State<Guard>, request: Request, next: Next) -> Response {
    let passed = match *request.method() {
        axum::http::Method::GET => guard.check(request.uri().path(), request.headers()),
        _ => Err(Refusal::Method),
    };
    let mut response = match passed {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.into_response(),
    };
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let (status, why) = match self {
            Self::Token => (StatusCode::FORBIDDEN, "open the whole address that `metal studio` printed"),
            Self::Host => (StatusCode::MISDIRECTED_REQUEST, "this name is not one of the studio's"),
            Self::Origin => (StatusCode::FORBIDDEN, "only the studio's own page may ask"),
            Self::Method => (StatusCode::METHOD_NOT_ALLOWED, "only GET"),
        };
        (status, format!("{why}\n")).into_response()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(address: &str, path: &str, headers: &[(&'static str, &str)]) -> Result<(), Refusal> {
        let mut map = HeaderMap::new();
        for (name, value) in headers {
            map.insert(*name, HeaderValue::from_str(value).unwrap());
        }
        Guard::new("0123abcd", address.parse().unwrap()).check(path, &map)
    }

    const LOCAL: &str = "127.0.0.1";

    #[test]
    fn the_token_opens_and_nothing_else_does() {
        assert_eq!(check(LOCAL, "/0123abcd/", &[("host", "127.0.0.1:8471")]), Ok(()));
        for path in
            ["/", "/0123abce/", "/0123abc", "/0123abcdd/", "//x/0123abcd", "/../0123abcd/", "/?0123abcd"]
        {
            assert_eq!(check(LOCAL, path, &[("host", "localhost")]), Err(Refusal::Token), "{path}");
        }
    }

    #[test]
    fn names_that_can_point_anywhere_are_refused() {
        for host in
            ["evil.example", "evil.example:8471", "localhost.evil.example", "127.0.0.1.evil.example", ""]
        {
            assert_eq!(check(LOCAL, "/0123abcd/", &[("host", host)]), Err(Refusal::Host), "{host}");
        }
        assert_eq!(check(LOCAL, "/0123abcd/", &[]), Err(Refusal::Host));
        assert_eq!(check(LOCAL, "/0123abcd/", &[("host", "192.168.1.7:8471")]), Err(Refusal::Host));
        for host in ["localhost:9", "127.0.0.1", "[::1]:8471", "127.9.9.9:1"] {
            assert_eq!(check(LOCAL, "/0123abcd/", &[("host", host)]), Ok(()), "{host}");
        }
        assert_eq!(check("0.0.0.0", "/0123abcd/", &[("host", "192.168.1.7:8471")]), Ok(()));
        assert_eq!(check("0.0.0.0", "/0123abcd/", &[("host", "robot.evil")]), Err(Refusal::Host));
    }

    #[test]
    fn other_pages_cannot_speak_for_their_reader() {
        let ask = |origin: &str| check(LOCAL, "/0123abcd/x", &[("host", "localhost:1"), ("origin", origin)]);
        assert_eq!(ask("http://localhost:1"), Ok(()));
        for origin in ["http://localhost:2", "https://localhost:1", "null", "http://evil.example", ""] {
            assert_eq!(ask(origin), Err(Refusal::Origin), "{origin}");
        }
        let socket = [("host", "localhost:1"), ("upgrade", "websocket")];
        assert_eq!(
            check(LOCAL, "/0123abcd/live", &socket),
            Err(Refusal::Origin),
            "a socket shows its origin"
        );
        let strange = [("host", "localhost:1"), ("sec-fetch-site", "cross-site")];
        assert_eq!(check(LOCAL, "/0123abcd/", &strange), Err(Refusal::Origin));
    }

    #[test]
    fn tokens_are_long_and_differ() {
        let (a, b) = (token().unwrap(), token().unwrap());
        assert!(is_token(&a) && is_token(&b) && a != b);
    }

    #[test]
    fn a_kept_token_stays_and_is_private() {
        let folder = std::env::temp_dir().join(format!("metal-studio-token-{}", std::process::id()));
        let store = Store::create(&folder).unwrap();
        let token = kept(&store).unwrap();
        assert_eq!(kept(&store).unwrap(), token);
        #[cfg(unix)]
        {
            let mode = std::fs::metadata(store.path("studio.token")).unwrap();
            assert_eq!(std::os::unix::fs::PermissionsExt::mode(&mode.permissions()) & 0o777, 0o600);
        }
        store.write("studio.token", b"guess").unwrap();
        assert!(is_token(&kept(&store).unwrap()), "a damaged one is replaced");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
