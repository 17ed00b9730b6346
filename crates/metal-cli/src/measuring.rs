//! What measurements have in common whose tables, numbers and drawings may be kept in a folder: `metal ceiling`, `metal
//! prices`, `metal faults`.

use crate::args::Printing;
use crate::bar::Bar;
use crate::commands::{keep_clear, listen_to_ctrl_c, say, say_json, use_threads};
use clap::Args;
use metal_lab::store::Store;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Flags of such a measurement.
#[derive(Debug, Args)]
pub struct Measuring {
    /// Folder for tables, numbers and drawings (nothing is written if it is not given)
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace what is in the folder
    #[arg(long, requires = "out")]
    force: bool,
    /// The one number all randomness comes from
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Override a field of the experiment: dotted key = TOML value; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    #[command(flatten)]
    printing: Printing,
    /// Threads (0: one per core); results do not depend on it
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: u16,
}

/// How the report of a measurement is shown.
pub struct Shown<R> {
    /// Its files are called `NAME.json`, `NAME.md` and `NAME-DRAWING.svg`.
    pub name: &'static str,
    /// The tables.
    pub text: fn(&R) -> String,
    /// Drawings by name, as SVG.
    pub draw: fn(&R) -> Vec<(String, String)>,
}

impl Measuring {
    /// Measures (in so many motor steps), prints the report, and writes it if there is a folder for it.
    pub fn carry_out<R: Serialize>(
        &self,
        shown: &Shown<R>,
        planned: usize,
        measure: impl FnOnce(&Bar) -> anyhow::Result<R>,
    ) -> anyhow::Result<()> {
        if let Some(out) = &self.out {
            keep_clear(&out.join(format!("{}.json", shown.name)), self.force)?;
        }
        use_threads(self.threads)?;
        listen_to_ctrl_c()?;
        let bar = Bar::new(planned as u64);
        let report = measure(&bar);
        bar.finish();
        let report = report?;
        if let Some(out) = &self.out {
            shown.write(&report, out)?;
        }
        if self.printing.json { say_json(&report) } else { say(&(shown.text)(&report)) }
    }
}

impl<R: Serialize> Shown<R> {
    fn write(&self, report: &R, out: &Path) -> anyhow::Result<()> {
        let (store, name) = (Store::create(out)?, self.name);
        store.write(&format!("{name}.md"), (self.text)(report).as_bytes())?;
        for (drawing, svg) in (self.draw)(report) {
            store.write(&format!("{name}-{drawing}.svg"), svg.as_bytes())?;
        }
        store.write(&format!("{name}.json"), serde_json::to_string_pretty(report)?.as_bytes())?;
        Ok(())
    }
}
