//! The report as drawings: motor cost against the price of looks, ceilings and learned policies.

use super::{CeilingReport, Line, Point};
use crate::figures::chart::{
    Area, Axis, Frame, Ink, Key, Label, Paint, Svg, legend_height, legend_rows, place_labels, ticks,
};
use crate::figures::{Figure, policy};

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 380.0;
const LEFT: f64 = 70.0;

/// Name → drawing as an `.svg` file with its own colours: everything, and the corner where looks are cheap.
#[must_use]
pub fn draw(report: &CeilingReport) -> Vec<(String, String)> {
    let dear = report.points.iter().map(|p| p.price).fold(0.0, f64::max);
    let views = [("all", dear), ("cheap", dear / 3.0)];
    let panels = views.map(|(name, limit)| (name.to_owned(), panel(report, limit)));
    let drawn = panels.into_iter().flat_map(|(name, svg)| {
        let figure = Figure { id: "ceiling", caption: String::new(), panels: vec![svg] };
        figure.files().into_iter().map(move |file| (name.clone(), file)).collect::<Vec<_>>()
    });
    drawn.collect()
}

/// A place in the drawing: price of looks, motor reward.
type Spot = (f64, f64);

const PLAIN: Ink = Ink("foa");
const MINDFUL: Ink = Ink("fixed");
const ADAPTIVE: Ink = Ink("acl");
const LEARNED: Ink = Ink("fusion");

fn keys() -> Vec<Key> {
    let key = |label: &str, paint, is_line| Key { label: label.to_owned(), paint, is_line };
    vec![
        key("ceiling of a subset, no memory", Paint::fill(PLAIN).faded(0.5), false),
        key("ceiling of a subset at a rhythm, memory", Paint::fill(MINDFUL).faded(0.5), false),
        key("fronts: ceilings; dashed, at the wheel", Paint::line(MINDFUL, 1.6), true),
        key("ceiling of adaptive looks", Paint::fill(ADAPTIVE), false),
        key("they at the wheel", Paint::line(ADAPTIVE, 1.6), false),
        key("a fixed choice at the wheel", Paint::line(MINDFUL, 1.2), false),
        key("learned", Paint::fill(LEARNED), false),
        key("equal total cost", Paint::line(Ink::MUTED, 1.0).faded(0.45).dashed(), true),
    ]
}

fn spot(point: &Point) -> Spot {
    (point.price, point.motor)
}

/// Where a fixed choice is at the wheel.
fn wheel(point: &Point) -> Spot {
    (point.driven_price, point.driven_motor)
}

fn panel(report: &CeilingReport, limit: f64) -> String {
    let legend = Area { x: LEFT, y: 8.0, width: WIDTH - LEFT - 20.0, height: 0.0 };
    let top = 18.0 + legend_height(legend.width, &keys());
    let mut svg = Svg::new(WIDTH, top + HEIGHT + 48.0);
    legend_rows(&mut svg, legend, &keys());
    let area = Area { x: LEFT, y: top, width: WIDTH - LEFT - 20.0, height: HEIGHT };
    let lowest = lowest(report, limit);
    let shown = |&(price, motor): &Spot| price <= limit + 1e-9 && motor >= lowest;
    let frame = frame(&mut svg, area, report, &shown);
    for (remembers, ink) in [(false, PLAIN), (true, MINDFUL)] {
        let points = report.points.iter().filter(|p| p.remembers == remembers).map(spot);
        points
            .filter(&shown)
            .for_each(|(x, y)| svg.circle(frame.at(x, y), 3.0, Paint::fill(ink).faded(0.35)));
    }
    for at in report.points.iter().filter(|p| p.remembers).map(wheel).filter(&shown) {
        svg.circle(frame.at(at.0, at.1), 3.5, Paint::line(MINDFUL, 1.2).faded(0.6));
    }
    let paint = Paint::line(MINDFUL, 1.6);
    let mut labels = front(report, &shown, wheel).draw(&mut svg, &frame, paint.dashed());
    labels.extend(front(report, &shown, spot).draw(&mut svg, &frame, paint));
    labels.extend(draw_adaptive(&mut svg, &frame, report, &shown));
    for l in report.learned.iter().filter(|l| shown(&(l.price, l.motor.mean))) {
        labels.push(diamond(
            &mut svg,
            frame.at(l.price, l.motor.mean),
            LEARNED,
            policy::short_label(&l.name),
        ));
    }
    labels.reverse();
    place_labels(&mut svg, area, &labels);
    svg.finish("Price of looks against motor cost: what the sensors allow")
}

/// The worst motor reward that is shown. Where looks are cheap it is what is worth showing beside the best: all ceilings, and
/// as much again.
fn lowest(report: &CeilingReport, limit: f64) -> f64 {
    let motors = || report.points.iter().map(|p| p.motor);
    if limit >= report.points.iter().map(|p| p.price).fold(0.0, f64::max) {
        return f64::NEG_INFINITY;
    }
    let (best, worst) = (motors().fold(f64::NEG_INFINITY, f64::max), motors().fold(f64::INFINITY, f64::min));
    worst - 2.0 * (best - worst).max(0.05 * best.abs())
}

fn frame(svg: &mut Svg, area: Area, report: &CeilingReport, shown: &dyn Fn(&Spot) -> bool) -> Frame {
    let points = report.points.iter().map(spot);
    let learned = report.learned.iter().map(|l| (l.price, l.motor.mean));
    let driven = report.points.iter().filter(|p| p.remembers).map(wheel);
    let spots: Vec<Spot> = points.chain(learned).chain(lines(report)).chain(driven).filter(shown).collect();
    let x_axis = Axis::around("price of looks per motor step", spots.iter().map(|s| s.0).chain([0.0]));
    let y_axis = Axis::around("motor cost per motor step", spots.iter().map(|s| s.1));
    let frame = Frame::draw(svg, area, &x_axis, &y_axis);
    let ends = |marks: &[f64]| (marks[0], marks[marks.len() - 1]);
    let ((left, right), (low, high)) = (ends(&x_axis.marks), ends(&y_axis.marks));
    for &total in &ticks(low - right, high - left, 8) {
        // Along a line of equal total, motor = total + price; only the part inside the frame is drawn.
        let (from, to) = (left.max(low - total), right.min(high - total));
        if from < to {
            let paint = Paint::line(Ink::MUTED, 1.0).faded(0.3).dashed();
            svg.line(frame.at(from, total + from), frame.at(to, total + to), paint);
        }
    }
    frame
}

/// Looks by need: the ceiling, and at the wheel.
fn lines(report: &CeilingReport) -> impl Iterator<Item = Spot> {
    by_need(report).flat_map(|line| {
        let driven = line.driven.as_ref().map(|d| (d.motor.mean - d.total.mean, d.motor.mean));
        std::iter::once((line.price.mean, line.motor.mean)).chain(driven)
    })
}

fn by_need(report: &CeilingReport) -> impl Iterator<Item = &Line> {
    report.lines.iter().filter(|line| line.choice.is_none())
}

/// Points of which none is both dearer and worse than another.
struct Front(Vec<(Spot, String)>);

fn front(report: &CeilingReport, shown: &dyn Fn(&Spot) -> bool, at: fn(&Point) -> Spot) -> Front {
    let mut points: Vec<&Point> = report.points.iter().filter(|p| p.remembers && shown(&at(p))).collect();
    points.sort_by(|a, b| at(a).0.total_cmp(&at(b).0).then(at(b).1.total_cmp(&at(a).1)));
    let mut best = f64::NEG_INFINITY;
    points.retain(|p| {
        let is_better = at(p).1 > best;
        best = best.max(at(p).1);
        is_better
    });
    Front(points.into_iter().map(|p| (at(p), name(p))).collect())
}

impl Front {
    fn draw(self, svg: &mut Svg, frame: &Frame, paint: Paint) -> Vec<Label> {
        let mut steps: Vec<(f64, f64)> = Vec::new();
        let at = |spot: Spot| frame.at(spot.0, spot.1);
        for place in self.0.iter().map(|(spot, _)| at(*spot)) {
            steps.extend(steps.last().map(|&(_, y)| (place.0, y)));
            steps.push(place);
        }
        steps.extend(steps.last().map(|&(_, y)| (frame.area.right(), y)));
        svg.path(&steps, false, paint);
        self.0.into_iter().map(|(spot, text)| Label { at: at(spot), text, optional: true }).collect()
    }
}

fn name(point: &Point) -> String {
    let rhythm = if point.every > 1 { format!("/{}", point.every) } else { String::new() };
    if point.members.is_empty() { "nobody".to_owned() } else { point.members.join("+") + &rhythm }
}

fn draw_adaptive(
    svg: &mut Svg,
    frame: &Frame,
    report: &CeilingReport,
    shown: &dyn Fn(&Spot) -> bool,
) -> Vec<Label> {
    let mut labels = Vec::new();
    for line in by_need(report) {
        let words = format!("{}{}", line.name, if line.remembers { ", memory" } else { "" });
        let at = (line.price.mean, line.motor.mean);
        if shown(&at) {
            labels.push(diamond(svg, frame.at(at.0, at.1), ADAPTIVE, words));
        }
        let Some(driven) = &line.driven else { continue };
        let wheel = (driven.motor.mean - driven.total.mean, driven.motor.mean);
        if shown(&wheel) {
            svg.circle(frame.at(wheel.0, wheel.1), 5.0, Paint::line(ADAPTIVE, 1.6));
        }
    }
    labels
}

fn diamond(svg: &mut Svg, (x, y): (f64, f64), ink: Ink, text: String) -> Label {
    let corners = [(x, y - 8.0), (x + 8.0, y), (x, y + 8.0), (x - 8.0, y)];
    svg.path(&corners, true, Paint::fill(ink).outlined(Ink::PAGE, 1.5));
    Label { at: (x, y), text, optional: false }
}
