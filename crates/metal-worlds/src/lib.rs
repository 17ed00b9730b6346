//! Worlds with priced sensors: the miniature highway of the METAL paper (Secs. 4.1-4.4), and small proving grounds.
//!
//! A world owns physics, sensors and prices, and nothing else. A world never imports a learner: trained minds that
//! steer other cars come in through a one-method trait ([`highway::Driver`]). A world has no hidden state outside
//! its seed: looking never changes it, and the same seed and actions give the same bits.
#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::float_cmp, reason = "exact values are expected exactly"))]

pub mod faulty;
pub mod highway;
pub mod maze;
pub mod miniature;
pub mod priced;
pub mod puddle;
pub mod tabular;
pub mod toy;
