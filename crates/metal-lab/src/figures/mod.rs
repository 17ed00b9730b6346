//! The figures of the report, one file each, on one small chart writer.
//!
//! Each `draw` takes the results and gives `None` when its data is missing, so that a report of a partial run says so.

pub mod chart;
mod drive;
mod headline;
mod learning;
mod look_map;
mod looks;
pub mod markdown;
pub mod number;
pub mod policy;
pub mod road;
mod road_view;
mod scenes;
mod sensitivity;
mod subset_front;

use crate::results::Results;

/// A finished figure: one or more drawings side by side, without colours of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Its name, fit for a file or an anchor.
    pub id: &'static str,
    /// What is to be seen, in a sentence or two.
    pub caption: String,
    /// The drawings as `<svg>` elements; they take their colours from [`chart::variables`].
    pub panels: Vec<String>,
}

impl Figure {
    /// Each drawing as the text of an `.svg` file that carries its own colours, light and dark.
    #[must_use]
    pub fn files(&self) -> Vec<String> {
        let style = format!("><style>{}</style>\n", chart::variables("svg.chart"));
        self.panels.iter().map(|panel| panel.replacen(">\n", &style, 1)).collect()
    }
}

/// How a figure is made from results.
pub type Draw = fn(&Results) -> Option<Figure>;

/// Every figure by its name, in the order of the report.
pub const FIGURES: [(&str, Draw); 9] = [
    ("headline", headline::draw),
    ("fig6", road_view::draw),
    ("fig8", learning::draw),
    ("fig9", looks::draw),
    ("table1", scenes::draw),
    ("fig11", drive::draw),
    ("look_map", look_map::draw),
    ("subset_front", subset_front::draw),
    ("sensitivity", sensitivity::draw),
];

/// The figure of this name, if there is one and its data is there.
#[must_use]
pub fn draw(name: &str, results: &Results) -> Option<Figure> {
    FIGURES.iter().find(|(id, _)| *id == name).and_then(|(_, draw)| draw(results))
}
