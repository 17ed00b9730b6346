//! Any task with priced sensors, from wherever it comes: a built-in world, a table, somebody else's environment.
//!
//! A plan file ([`crate::plan`]) says everything about one experiment; here the only things said are a [`Task`] and a
//! [`Recipe`], and one tiny agent per sensor, a full observer and an attention controller follow from them.

mod learn;
mod method;
mod mind;
mod named;
mod recipe;
mod saved;
mod table;
mod trial;

pub use learn::learn;
pub(crate) use learn::phase;
pub use method::{AttentionMethod, ValuesMethod};
pub(crate) use mind::born;
pub use mind::{Controller, Learned};
pub use named::{NAMES, NamedTask};
pub use recipe::Recipe;
pub use saved::{Card, load, save};
pub use table::{Cell, GroupPrice, Prices, RawTable, TableTask};
pub use trial::{Driver, Score, trial};
pub(crate) use trial::{Seat, drive};

use crate::train::RunError;
use metal_rl::environment::Environment;

/// Where the worlds of a task come from.
pub trait Task: Sync {
    /// A world to learn in.
    ///
    /// # Errors
    /// If it cannot be built.
    fn training(&self) -> Result<Box<dyn Environment>, RunError>;

    /// A world to be tested in; the same as for learning where nothing is held back.
    ///
    /// # Errors
    /// If it cannot be built.
    fn testing(&self) -> Result<Box<dyn Environment>, RunError> {
        self.training()
    }

    /// A world in which an expert is watched (Phase I): the one to learn in, or a recording.
    ///
    /// # Errors
    /// If it cannot be built.
    fn watching(&self) -> Result<Box<dyn Environment>, RunError> {
        self.training()
    }

    /// Whether several of its worlds may be used at the same time.
    fn is_parallel(&self) -> bool {
        true
    }

    /// Sensors (by index) whose reading is an expert's finished opinion: one degree of support per motor action.
    fn opinions(&self) -> Vec<usize> {
        Vec::new()
    }
}
