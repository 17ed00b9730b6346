//! The experiment files that come with the program.

/// Every experiment of the paper, in one file.
pub const PAPER: &str = include_str!("../../../experiments/paper.toml");
/// How the red cars of `Highway-v0` learned to drive.
pub const TRAFFIC: &str = include_str!("../../../experiments/traffic.toml");
/// Attention control where the best possible is known.
pub const TOY: &str = include_str!("../../../experiments/toy.toml");
/// Attention against the best fixed choice of sensors, both by counterfactual policy iteration.
pub const ATTENTION: &str = include_str!("../../../experiments/attention.toml");
/// The highway's senses in raw cells, for tiny agents to be proposed.
pub const PARTITION: &str = include_str!("../../../experiments/partition.toml");
