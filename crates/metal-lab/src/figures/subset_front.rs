//! Price of looking against motor cost: fixed choices of sensors, the front they form, and the learned policies.

use super::chart::{
    Area, Axis, Frame, Ink, Key, Label, Paint, Svg, legend_height, legend_rows, place_labels,
};
use super::{Figure, policy};
use crate::results::{FrontPoint, Results, Stage};

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 360.0;
const LEFT: f64 = 70.0;

/// Draws the front; `None` unless some fixed subset was measured.
#[must_use]
pub fn draw(results: &Results) -> Option<Figure> {
    let subsets = &results.figures.subset_front;
    if subsets.is_empty() {
        return None;
    }
    let learned = learned(results);
    let legend = Area { x: LEFT, y: 8.0, width: WIDTH - LEFT - 20.0, height: 0.0 };
    let top = 18.0 + legend_height(legend.width, &keys());
    let mut svg = Svg::new(WIDTH, top + HEIGHT + 48.0);
    legend_rows(&mut svg, legend, &keys());
    let area = Area { x: LEFT, y: top, width: WIDTH - LEFT - 20.0, height: HEIGHT };
    let frame = draw_frame(&mut svg, area, (subsets, &learned));
    draw_front(&mut svg, &frame, subsets);
    let mut labels = draw_learned(&mut svg, &frame, &learned);
    labels.extend(draw_subsets(&mut svg, &frame, subsets));
    place_labels(&mut svg, area, &labels);
    let caption = "Each point is one way to look. “/2” is looked at at every second step. Up is better driving, left is cheaper looking; total cost is equal \
                   along the pale lines and falls towards the upper left. The line joins the \
                   best fixed choice (confirmed, if any is) for every budget: a learner that looks where it matters should lie above and to the left of it.";
    let panels = vec![svg.finish("Price of looks against motor cost")];
    Some(Figure { id: "subset_front", caption: caption.to_owned(), panels })
}

/// A learned policy: name, price of its looks, motor cost.
type Learned = (&'static str, f64, f64);

fn learned(results: &Results) -> Vec<Learned> {
    let find = |&policy: &&'static str| {
        let price = -results.estimate(policy, "mix", "perceptual")?.mean;
        Some((policy, price, results.estimate(policy, "mix", "motor")?.mean))
    };
    policy::ORDER.iter().filter(|&&name| name != "best_fixed").filter_map(find).collect()
}

fn keys() -> Vec<Key> {
    let key = |label: &str, paint, is_line| Key { label: label.to_owned(), paint, is_line };
    vec![
        key("fixed choice, confirmed", Paint::fill(Ink("fixed")), false),
        key("fixed choice, screened only", Paint::fill(Ink("fixed")).faded(0.35), false),
        key("front of the fixed choices", Paint::line(Ink("fixed"), 1.6), true),
        key("equal total cost", Paint::line(Ink::MUTED, 1.0).faded(0.45).dashed(), true),
    ]
}

fn draw_frame(svg: &mut Svg, area: Area, (subsets, learned): (&[FrontPoint], &[Learned])) -> Frame {
    let prices = subsets.iter().map(|s| s.price).chain(learned.iter().map(|l| l.1));
    let motors = subsets.iter().map(|s| s.motor.mean).chain(learned.iter().map(|l| l.2));
    let x_axis = Axis::around("price of looks per motor step", prices.chain([0.0]));
    let y_axis = Axis::around("motor cost per motor step", motors.chain([0.0]));
    let frame = Frame::draw(svg, area, &x_axis, &y_axis);
    let (left, right) = (x_axis.marks[0], x_axis.marks[x_axis.marks.len() - 1]);
    let (low, high) = (y_axis.marks[0], y_axis.marks[y_axis.marks.len() - 1]);
    for &total in &super::chart::ticks(low - right, high - left, 8) {
        // Along a line of equal total, motor = total + price; only the part inside the frame is drawn.
        let (from, to) = (left.max(low - total), right.min(high - total));
        if from < to {
            let ends = [frame.at(from, total + from), frame.at(to, total + to)];
            svg.line(ends[0], ends[1], Paint::line(Ink::MUTED, 1.0).faded(0.3).dashed());
        }
    }
    frame
}

/// The confirmed subsets where there are any, else all: the best motor cost for each price.
fn front(subsets: &[FrontPoint]) -> Vec<&FrontPoint> {
    let is_any_confirmed = subsets.iter().any(|s| s.stage == Stage::Confirmed);
    let mut sorted: Vec<_> =
        subsets.iter().filter(|s| !is_any_confirmed || s.stage == Stage::Confirmed).collect();
    sorted.sort_by(|a, b| a.price.total_cmp(&b.price).then(b.motor.mean.total_cmp(&a.motor.mean)));
    let mut best = f64::NEG_INFINITY;
    sorted.retain(|s| {
        let is_better = s.motor.mean > best;
        best = best.max(s.motor.mean);
        is_better
    });
    sorted
}

fn draw_front(svg: &mut Svg, frame: &Frame, subsets: &[FrontPoint]) {
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for point in front(subsets) {
        let at = frame.at(point.price, point.motor.mean);
        if let Some(&(_, y)) = steps.last() {
            steps.push((at.0, y));
        }
        steps.push(at);
    }
    if let Some(&(_, y)) = steps.last() {
        steps.push((frame.area.right(), y));
        svg.path(&steps, false, Paint::line(Ink("fixed"), 1.6));
    }
}

fn draw_learned(svg: &mut Svg, frame: &Frame, learned: &[Learned]) -> Vec<Label> {
    let mut labels = Vec::new();
    for &(name, price, motor) in learned {
        let (x, y) = frame.at(price, motor);
        let corners = [(x, y - 8.0), (x + 8.0, y), (x, y + 8.0), (x - 8.0, y)];
        svg.path(&corners, true, Paint::fill(policy::ink(name)).outlined(Ink::PAGE, 1.5));
        labels.push(Label { at: (x, y), text: policy::short_label(name), optional: false });
    }
    labels
}

fn draw_subsets(svg: &mut Svg, frame: &Frame, subsets: &[FrontPoint]) -> Vec<Label> {
    let on_front = front(subsets);
    let mut labels = Vec::new();
    let mut others = Vec::new();
    for subset in subsets {
        let at = frame.at(subset.price, subset.motor.mean);
        let (radius, opacity) = if subset.stage == Stage::Confirmed { (5.0, 1.0) } else { (4.0, 0.35) };
        svg.circle(at, radius, Paint::fill(Ink("fixed")).faded(opacity));
        let label = Label { at, text: name(subset), optional: true };
        let is_on_front = on_front.iter().any(|p| std::ptr::eq(*p, subset));
        if is_on_front {
            labels.push(label)
        } else if subset.stage == Stage::Confirmed {
            others.push(label)
        }
    }
    labels.append(&mut others);
    labels
}

/// The sensors; all of them together have a name that is too long for the chart.
fn name(subset: &FrontPoint) -> String {
    if subset.sensors.len() == policy::SENSORS.len() && subset.every == 1 {
        return "all sensors".to_owned();
    }
    subset.words("+")
}
