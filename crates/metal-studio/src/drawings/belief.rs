//! What a tiny agent would do over two of its features: the plane coloured by its best action, with its Gaussians where
//! its learner has them.

use super::{Studio, Wishes, number};
use metal_lab::figures::chart::{
    Anchor, Area, Axis, Frame, Ink, Key, Paint, Svg, legend_height, legend_rows,
};
use metal_rl::learner::Learner;
use metal_rl::member::Member;
use metal_rl::num;

const WIDTH: f64 = 460.0;
const SIDE: f64 = 300.0;
/// Cells along each side.
const CELLS: usize = 30;
/// Cells from one number on the plane to the next.
const PITCH: usize = 6;
/// Colours of the actions. The numbers on the plane say the same to whoever cannot tell colours apart.
const INKS: [Ink; 5] = [Ink("mn"), Ink("fixed"), Ink("lf"), Ink("rf"), Ink("mf")];

/// The plane of features `x` and `y` of member `member`; all other features as they were read last, or at rest.
pub fn draw(studio: &Studio, wishes: &Wishes) -> Option<String> {
    let members = studio.learned()?.members(wishes.get("phase").map(String::as_str))?;
    let member = members.get(number::<usize>(wishes, "member").unwrap_or(0))?;
    let dims = member.view.dims();
    let axes = [number::<usize>(wishes, "x").unwrap_or(0), number::<usize>(wishes, "y").unwrap_or(2)];
    let axes = axes.map(|axis| axis.min(dims - 1));
    let names = names(studio, member);
    let title = format!("{}: best action over {} and {}", member.name, names[axes[0]], names[axes[1]]);
    let keys = keys(studio);
    let top = 40.0 + legend_height(WIDTH - 60.0, &keys);
    let mut svg = Svg::new(WIDTH, top + SIDE + 52.0);
    svg.text((60.0, 18.0), Anchor::Start, "title", &title);
    legend_rows(&mut svg, Area { x: 60.0, y: 32.0, width: WIDTH - 70.0, height: 0.0 }, &keys);
    let [x, y] = axes.map(|axis| Axis::around(&names[axis], [0.0, 1.0]));
    let area = Area { x: 62.0, y: top, width: WIDTH - 82.0, height: SIDE };
    let frame = Frame::draw(&mut svg, area, &x, &y);
    paint_plane(&mut svg, &frame, (member.learner.as_ref(), base(studio, member), axes));
    draw_gaussians(&mut svg, &frame, (member.learner.as_ref(), axes));
    Some(svg.finish(&title))
}

fn names(studio: &Studio, member: &Member) -> Vec<String> {
    let sensors = member.view.sensors().iter().map(|&s| &studio.plan.spec.sensors[s]);
    sensors.flat_map(|s| s.features.iter().map(|f| format!("{} {}", s.name, f.name))).collect()
}

fn keys(studio: &Studio) -> Vec<Key> {
    let key = |(choice, label): (usize, &String)| Key {
        label: format!("{} {label}", choice + 1),
        paint: Paint::fill(ink(choice)),
        is_line: false,
    };
    studio.plan.spec.actions.iter().enumerate().map(key).collect()
}

fn ink(choice: usize) -> Ink {
    INKS[choice % INKS.len()]
}

/// The number of an action, as in the legend.
fn write_number(svg: &mut Svg, (x, y): (f64, f64), choice: usize) {
    svg.text((x, y + 3.5), Anchor::Middle, "small", &(choice + 1).to_string());
}

/// Where the member last stood in its space, if somebody asked it lately.
fn base(studio: &Studio, member: &Member) -> Vec<f64> {
    let index = studio.plan.member(&member.name);
    let asked = studio.hub.lately(200).into_iter().rev().find_map(|frame| {
        frame.lanes.first()?.opinions.get(index?)?.as_ref().map(|opinion| opinion.reading.clone())
    });
    asked.filter(|r| r.len() == member.view.dims()).unwrap_or_else(|| vec![0.0; member.view.dims()])
}

/// Each cell in the colour of its best action, and here and there its number; the surer the member, the stronger the
/// colour.
fn paint_plane(
    svg: &mut Svg,
    frame: &Frame,
    (learner, mut state, axes): (&dyn Learner, Vec<f64>, [usize; 2]),
) {
    let actions = learner.dims().choices;
    let (mut values, mut support) = (vec![0.0; actions], vec![0.0; actions]);
    let cell = 1.0 / CELLS as f64;
    let mut numbers = Vec::new();
    svg.raw("<g shape-rendering=\"crispEdges\">");
    for (row, column) in (0..CELLS).flat_map(|r| (0..CELLS).map(move |c| (r, c))) {
        let (x, y) = (column as f64 * cell, row as f64 * cell);
        (state[axes[0]], state[axes[1]]) = (x + cell / 2.0, y + cell / 2.0);
        learner.values_and_support(&state, &mut values, &mut support);
        let best = num::argmax(&values);
        let (left, bottom) = frame.at(x, y);
        let (right, top) = frame.at(x + cell, y + cell);
        let area = Area { x: left, y: top, width: right - left, height: bottom - top };
        let sure = 0.25 + 0.6 * support[best];
        svg.rect(area, Paint::fill(ink(best)).faded(sure));
        if row % PITCH == PITCH / 2 && column % PITCH == PITCH / 2 {
            numbers.push((((left + right) / 2.0, (top + bottom) / 2.0), best));
        }
    }
    svg.raw("</g>");
    numbers.into_iter().for_each(|(at, best)| write_number(svg, at, best));
}

/// One ellipse per Gaussian, at one standard deviation along the two features, with the number of its action.
fn draw_gaussians(svg: &mut Svg, frame: &Frame, (learner, axes): (&dyn Learner, [usize; 2])) {
    for bump in learner.bumps() {
        let [x, y] = axes.map(|axis| bump.mean[axis]);
        let [dx, dy] = axes.map(|axis| bump.deviation[axis]);
        let outline: Vec<(f64, f64)> = (0..36)
            .map(|i| {
                let (sin, cos) = num::sin_cos(std::f64::consts::TAU * f64::from(i) / 36.0);
                frame.at((x + dx * cos).clamp(0.0, 1.0), (y + dy * sin).clamp(0.0, 1.0))
            })
            .collect();
        svg.path(&outline, true, Paint::line(Ink::TEXT, 2.4).faded(0.35));
        svg.path(&outline, true, Paint::line(ink(bump.choice), 1.4));
        write_number(svg, frame.at(x.clamp(0.0, 1.0), y.clamp(0.0, 1.0)), bump.choice);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_rl::learner::{Dims, Rate, Sample};
    use metal_rl::learners::{AbspConfig, LearnerConfig};

    /// Two actions over a plane: the first is right on its left half, the second on its right.
    fn drawn() -> (Box<dyn Learner>, String) {
        let dims = Dims { inputs: 2, choices: 2 };
        let mut learner = LearnerConfig::Absp(AbspConfig::default()).build(dims, 1).unwrap();
        for k in 0..200 {
            let (x, y) = (f64::from(k % 10) / 10.0 + 0.05, f64::from(k / 10 % 10) / 10.0 + 0.05);
            for choice in 0..2 {
                let target = if (x < 0.5) == (choice == 0) { 1.0 } else { -1.0 };
                let sample = Sample { state: &[x, y], choice, target, demonstrated: false };
                learner.learn(sample, Rate::Full);
            }
        }
        let mut svg = Svg::new(WIDTH, SIDE);
        let [x, y] = ["x", "y"].map(|name| Axis::around(name, [0.0, 1.0]));
        let frame = Frame::draw(&mut svg, Area { x: 0.0, y: 0.0, width: WIDTH, height: SIDE }, &x, &y);
        paint_plane(&mut svg, &frame, (learner.as_ref(), vec![0.0; 2], [0, 1]));
        draw_gaussians(&mut svg, &frame, (learner.as_ref(), [0, 1]));
        (learner, svg.finish("belief"))
    }

    #[test]
    fn every_gaussian_has_its_ellipse_and_the_number_of_its_action() {
        let (learner, svg) = drawn();
        let bumps = learner.bumps();
        assert!(bumps.iter().any(|b| b.choice == 0) && bumps.iter().any(|b| b.choice == 1));
        assert_eq!(svg.matches("Z\"").count() / 2, bumps.len(), "{svg}");
        let numbers = svg.matches("class=\"small\">1<").count() + svg.matches("class=\"small\">2<").count();
        assert_eq!(numbers, bumps.len() + (CELLS / PITCH) * (CELLS / PITCH));
    }

    #[test]
    fn the_plane_is_told_apart_without_colours() {
        let (_, svg) = drawn();
        for number in ["class=\"small\">1<", "class=\"small\">2<"] {
            assert!(svg.matches(number).count() > 10, "{number}");
        }
    }
}
