//! The proposal as a picture: what the camera sees, its cells coloured by group, and the infra-red ring beside it.

use super::Proposal;
use crate::drives::picture::image;
use crate::figures::Figure;
use crate::figures::chart::{
    Anchor, Area, Ink, Key, PIXELS_HEIGHT, PIXELS_WIDTH, Paint, Svg, legend_height, legend_rows, pixels,
    region,
};
use crate::figures::number::fixed;
use crate::registry::highway;
use crate::results::CameraRegion;
use metal_rl::environment::Environment;
use metal_worlds::highway::camera::Window;
use metal_worlds::highway::infrared::MOUNTS;
use metal_worlds::highway::senses::{Fitted, Organ, organs};

/// Colours of groups, in their order; beyond, they begin again, and the numbers in the cells tell them apart.
const INKS: [Ink; 12] = [
    Ink("mn"),
    Ink("mf"),
    Ink("rn"),
    Ink("lf"),
    Ink("rf"),
    Ink("ln"),
    Ink("look1"),
    Ink("look6"),
    Ink("car"),
    Ink("look3"),
    Ink("fusion-pool"),
    Ink("random"),
];

const GAP: f64 = 24.0;
const RING: f64 = 56.0;
const WIDTH: f64 = PIXELS_WIDTH + 2.0 * (GAP + RING) + 8.0;

/// The picture as an `.svg` file with its own colours; none in worlds without a camera.
#[must_use]
pub fn draw(proposal: &Proposal) -> Option<String> {
    let (config, steering) = proposal.plan.file.environment.as_highway()?;
    let senses = organs(config.senses, &config.task);
    let mut world = highway(config, steering);
    world.reset(proposal.options.seed).ok()?;
    let keys: Vec<Key> = proposal.groups.iter().enumerate().map(key).collect();
    let legend = Area { x: 0.0, y: PIXELS_HEIGHT + 12.0, width: WIDTH, height: 0.0 };
    let mut svg = Svg::new(WIDTH, legend.y + legend_height(WIDTH, &keys) + 4.0);
    pixels(&mut svg, (0.0, 0.0), &image(&world));
    ring_outline(&mut svg);
    for (g, group) in proposal.groups.iter().enumerate() {
        senses
            .iter()
            .filter(|fitted| group.sensors.contains(&fitted.name))
            .for_each(|fitted| mark(&mut svg, g, fitted));
    }
    legend_rows(&mut svg, legend, &keys);
    let label = format!("The sensors of {} in {} groups", proposal.world, proposal.groups.len());
    let figure = Figure { id: "partition", caption: String::new(), panels: vec![svg.finish(&label)] };
    figure.files().into_iter().next()
}

fn key((g, group): (usize, &super::Group)) -> Key {
    let label = format!("{}: tells {} for {}", group.name, fixed(group.tells, 2), fixed(group.price, 2));
    Key { label, paint: Paint::fill(INKS[g % INKS.len()]), is_line: false }
}

fn middle_of_ring() -> (f64, f64) {
    (PIXELS_WIDTH + GAP + RING, PIXELS_HEIGHT / 2.0)
}

fn ring_outline(svg: &mut Svg) {
    let (x, y) = middle_of_ring();
    svg.circle((x, y), RING - 14.0, Paint::line(Ink::MUTED, 1.0));
    svg.text((x, y + 4.0), Anchor::Middle, "small", "infra-red");
}

/// Paints one sensor in the colour of its group.
fn mark(svg: &mut Svg, g: usize, fitted: &Fitted) {
    let (ink, number) = (INKS[g % INKS.len()], (g + 1).to_string());
    match fitted.organ {
        Organ::Area(Window { top, bottom, left, right }) => {
            let window = CameraRegion { name: String::new(), top, bottom, left, right };
            let area = region((0.0, 0.0), &window);
            svg.rect(area, Paint::fill(ink).faded(0.55));
            svg.rect(area, Paint::line(Ink("px-shade"), 0.8));
            let middle = (area.x + area.width / 2.0, area.y + area.height / 2.0 + 4.0);
            svg.text(middle, Anchor::Middle, "onpicture", &number);
        }
        Organ::Ring => (0..MOUNTS.len()).for_each(|i| dot(svg, i, ink, &number)),
        Organ::Proximity(i) => dot(svg, i, ink, &number),
        // Nothing to be cut: it has no place in the picture.
        Organ::Truth(_) => {}
    }
}

/// A sensor of the ring, seen from above, ahead is up.
fn dot(svg: &mut Svg, i: usize, ink: Ink, number: &str) {
    let [x_m, y_m, _] = MOUNTS[i];
    let length = (x_m * x_m + y_m * y_m).sqrt();
    let (x, y) = middle_of_ring();
    let at = (x - (RING - 14.0) * y_m / length, y - (RING - 14.0) * x_m / length);
    svg.circle(at, 10.0, Paint::fill(ink).outlined(Ink("px-shade"), 0.8));
    svg.text((at.0, at.1 + 4.0), Anchor::Middle, "onpicture", number);
}
