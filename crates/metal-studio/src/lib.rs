//! The studio: a local web page that shows a mind learning and attending, and lets a person demonstrate.
//!
//! Three threads share one [`hub`]: the [`stage`] (worlds, clock, whoever drives), the [`training`] run if one was
//! started, and the [`server`]. Whoever publishes never waits for a page: pages get the latest frame, or miss it. The
//! page is plain HTML, CSS and ES modules inside the program; curves are drawn by the chart code of the report.
#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::float_cmp, reason = "exact values are expected exactly"))]

pub mod command;
pub mod faults;
pub mod frame;
pub mod hub;

pub mod subject;

pub mod clock;
pub mod demonstration;
pub mod lane;
pub mod robot;
pub mod seated;
pub mod situations;
pub mod stage;
pub mod status;

pub mod learned;
pub mod training;

pub mod drawings;
pub mod server;
