//! The policies: everyone who can be at the wheel.

mod advisor;
pub mod attention;
mod blind;
mod counterfactual;
mod fusion;
mod random_looks;
mod rests;
mod solo;

pub use advisor::Advisor;
pub use attention::{Attention, AttentionConfig};
pub use blind::Blind;
pub use counterfactual::Counterfactual;
pub use fusion::Fusion;
pub use random_looks::RandomLooks;
pub use rests::RestConfig;
pub use solo::Solo;
