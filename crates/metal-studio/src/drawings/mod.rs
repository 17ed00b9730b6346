//! Drawings of the page, by the chart code of the report: curves, the timeline, beliefs, and the stage for export.

mod belief;
mod curves;
mod stage;
mod timeline;

use crate::hub::{Hub, lock};
use crate::learned::Learned;
use crate::stage::SharedTraining;
use metal_lab::plan::Plan;
use metal_lab::results::{CameraRegion, Results, RoadOutline};
use metal_worlds::highway::Ground;
use metal_worlds::highway::camera::{Region, Window};
use metal_worlds::highway::kinematics::BODY_RADIUS_M;
use metal_worlds::highway::road::BORDER_M;
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Everything that can be drawn.
pub struct Studio {
    /// The experiment.
    pub plan: Arc<Plan>,
    /// Decisions that are remembered.
    pub hub: Arc<Hub>,
    /// The run that trains, if there is one.
    pub training: SharedTraining,
    /// The roads of the world, and after them that of a body.
    pub roads: Vec<RoadOutline>,
    /// The numbers of the finished run that the studio was opened on.
    pub results: Option<Results>,
}

impl Studio {
    fn learned(&self) -> Option<Arc<Learned>> {
        lock(&self.training).clone()
    }
}

/// What a page may wish of a drawing.
pub type Wishes = BTreeMap<String, String>;

/// The drawing called `name`; `None` if there is none or nothing to draw yet. With the wish `file` it carries its colours.
#[must_use]
pub fn draw(studio: &Studio, name: &str, wishes: &Wishes) -> Option<String> {
    let svg = match name {
        "timeline" => timeline::draw(studio, wishes)?,
        "stage" => stage::draw(studio, number(wishes, "n"))?,
        "belief" => belief::draw(studio, wishes)?,
        curve => curves::draw(studio, curve, wishes)?,
    };
    Some(if wishes.contains_key("file") { coloured(&svg, wishes) } else { svg })
}

/// The wish `key` as a number.
fn number<T: std::str::FromStr>(wishes: &Wishes, key: &str) -> Option<T> {
    wishes.get(key)?.parse().ok()
}

/// The drawing as a file of its own: colours inside, in the scheme of the page, on a ground that is not transparent.
fn coloured(svg: &str, wishes: &Wishes) -> String {
    let scheme = if wishes.get("theme").is_some_and(|t| t == "dark") { "dark" } else { "light" };
    let style = metal_lab::figures::chart::variables("svg.chart");
    let root = format!("data-theme=\"{scheme}\"><style>{style}svg.chart{{background:var(--page)}}</style>\n");
    svg.replacen(">\n", &format!(" {root}"), 1)
}

/// The camera's regions.
fn regions() -> Vec<CameraRegion> {
    let named = |region: &Region| {
        let Window { top, bottom, left, right } = region.window();
        CameraRegion { name: region.name().to_owned(), top, bottom, left, right }
    };
    Region::ALL.iter().map(named).collect()
}

/// A road from above, in millimetres.
pub fn outline(ground: &Ground) -> RoadOutline {
    let round = |x: f64| (x * 1e3).round() / 1e3;
    let mut middle: Vec<[f64; 2]> = ground.road().outline().centre.iter().map(|p| p.map(round)).collect();
    // The drawing closes the line by itself.
    middle.pop();
    RoadOutline { middle, width_m: 2.0 * BORDER_M }
}

/// What never changes while the studio is open, for the page.
#[must_use]
pub fn world_json(studio: &Studio) -> String {
    let plan = &studio.plan;
    let sensors: Vec<_> = plan
        .spec
        .sensors
        .iter()
        .map(|s| {
            json!({ "name": s.name, "price": s.price, "features":
        s.features.iter().map(|f| f.name.as_str()).collect::<Vec<_>>() })
        })
        .collect();
    let members: Vec<_> =
        plan.members.iter().map(|m| json!({ "name": m.name, "sensors": m.sensors })).collect();
    let phases: Vec<_> = plan
        .order
        .iter()
        .map(|name| {
            json!({ "name": name,
        "attends": matches!(plan.file.phase[name].acting, metal_lab::plan::Acting::Attention(_)) })
        })
        .collect();
    json!({
        "title": plan.file.title,
        "actions": plan.spec.actions,
        "horizon": plan.spec.horizon,
        "sensors": sensors,
        "members": members,
        "phases": phases,
        "regions": regions(),
        "roads": studio.roads,
        "radius_m": BODY_RADIUS_M,
        "version": env!("CARGO_PKG_VERSION"),
    })
    .to_string()
}
