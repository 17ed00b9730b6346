//! How far a long computation is: the lab reports, the command draws.

/// Told how many motor steps are planned and done. Called from many threads.
pub trait Progress: Sync {
    /// `steps` more motor steps were simulated.
    fn steps(&self, steps: usize);

    /// What is being done now, in words for a person.
    fn stage(&self, _what: &str) {}

    /// Something was not as it should be, but the work goes on; in words for a person.
    fn warn(&self, _what: &str) {}

    /// Whether the user wants to stop; asked between episodes of training and between tests.
    fn interrupted(&self) -> bool {
        false
    }
}

/// Tells nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn steps(&self, _steps: usize) {}
}
