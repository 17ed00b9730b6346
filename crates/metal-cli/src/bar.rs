//! Progress on the terminal, with the time that is left.

use indicatif::{ProgressBar, ProgressStyle};
use metal_lab::progress::Progress;
use std::sync::atomic::{AtomicBool, Ordering};

/// A bar over motor steps.
pub struct Bar {
    bar: ProgressBar,
}

/// Set by Ctrl-C; asked between episodes.
pub static INTERRUPTED: AtomicBool = AtomicBool::new(false);

impl Bar {
    /// A bar over `steps` motor steps, drawn on standard error when it is a terminal.
    pub fn new(steps: u64) -> Self {
        let bar = ProgressBar::new(steps);
        let style = "{spinner} {msg:<34} {wide_bar} {percent:>3} %  {elapsed_precise} elapsed, {eta} left";
        bar.set_style(ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar }
    }

    /// Takes the bar off the screen.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn steps(&self, steps: usize) {
        self.bar.inc(steps as u64);
    }

    fn stage(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    fn warn(&self, what: &str) {
        self.bar.suspend(|| eprintln!("metal: warning: {what}"));
    }

    fn interrupted(&self) -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
    }
}
