//! The page: static files inside the program.

use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};

/// Name, kind and text of every file.
const FILES: [(&str, &str, &str); 10] = [
    ("style.css", CSS, include_str!("../page/style.css")),
    ("app.js", JS, include_str!("../page/app.js")),
    ("link.js", JS, include_str!("../page/link.js")),
    ("road.js", JS, include_str!("../page/road.js")),
    ("eye.js", JS, include_str!("../page/eye.js")),
    ("thought.js", JS, include_str!("../page/thought.js")),
    ("wheel.js", JS, include_str!("../page/wheel.js")),
    ("explore.js", JS, include_str!("../page/explore.js")),
    ("curves.js", JS, include_str!("../page/curves.js")),
    ("keep.js", JS, include_str!("../page/keep.js")),
];
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";

/// The page itself.
pub fn page() -> Response {
    ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], include_str!("../page/index.html")).into_response()
}

/// One of its files.
pub fn file(name: &str) -> Response {
    match FILES.iter().find(|(known, _, _)| *known == name) {
        Some((_, kind, text)) => ([(header::CONTENT_TYPE, *kind)], *text).into_response(),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}
