//! The rays of a region, some side by side at a time: what a whole block meets is often known from its middle.
//!
//! Answers are those of each ray alone, bit by bit: a block is answered at once only where the map of clearances says
//! that nothing else is as near as its farthest ray.

use super::camera::{LARGEST_PATCH, Window};
use super::clearance::radius;
use super::ground::{Ground, Material};
use super::sight::{Lens, Ray, Rays, whole};
use metal_rl::num;
use multiversion::multiversion;

/// Rays in a block.
pub(super) const BLOCK: usize = 16;
/// Blocks of the largest region.
const MOST_BLOCKS: usize = LARGEST_PATCH.div_ceil(BLOCK);
/// What a region's rays find; more than the region's pixels, for whole blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found([[Material; BLOCK]; MOST_BLOCKS]);

impl Default for Found {
    fn default() -> Self {
        Self([[Material::Grass; BLOCK]; MOST_BLOCKS])
    }
}

impl Found {
    /// Ray by ray.
    pub fn as_flattened_mut(&mut self) -> &mut [Material] {
        self.0.as_flattened_mut()
    }
}

/// The rays of a region, block by block, upper rows first; the last block is filled up with rays that count nothing.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    pub rays: Rays,
    /// Rays that count.
    pub pixels: usize,
    /// Middle of the points that a block shows, in raster cells ahead of the lens.
    ahead: Vec<f64>,
    /// The same to its left.
    left: Vec<f64>,
    /// Distance of a block's farthest point from that middle, as the map of clearances counts it.
    radius: Vec<u16>,
    /// Farthest point on the ground that a block or any after it shows, in metres.
    reach_m: Vec<f64>,
}

impl Blocks {
    /// The blocks of a window of a picture `columns` wide.
    pub fn new(picture: &[Ray], columns: usize, window: Window) -> Self {
        let order = winding(window).into_iter().map(|[row, column]| picture[row * columns + column]);
        let mut rays: Vec<Ray> = order.collect();
        let pixels = rays.len();
        rays.resize(pixels.next_multiple_of(BLOCK), rays[pixels - 1]);
        let mut reach_m: Vec<f64> = rays.chunks(BLOCK).map(farthest_m).collect();
        for block in (1..reach_m.len()).rev() {
            reach_m[block - 1] = reach_m[block - 1].max(reach_m[block]);
        }
        let rays: Rays = rays.into_iter().collect();
        let circles = rays.points().map(|(ahead, left)| circle(ahead, left));
        let (middles, radius): (Vec<[f64; 2]>, Vec<u16>) = circles.unzip();
        let (ahead, left) = middles.into_iter().map(|[ahead, left]| (ahead, left)).unzip();
        Self { rays, pixels, ahead, left, radius, reach_m }
    }

    /// How many blocks, from the first, may show something that is `distance_m` away.
    pub fn reaching(&self, distance_m: f64) -> usize {
        self.reach_m.partition_point(|&reach| reach > distance_m)
    }

    /// Number of blocks.
    fn len(&self) -> usize {
        self.radius.len()
    }
}

/// The pixels of a window from the upper left, winding: right and down, then left and down. Near rows are taken by
/// twos, because a pixel shows more of the plane lengthwise than across, and more so far away.
fn winding(window: Window) -> Vec<[usize; 2]> {
    /// From this row on a pixel is less than four times as long as wide.
    const BY_TWOS: usize = 13;
    let mut order = Vec::new();
    let (mut row, mut leftward) = (window.top, false);
    while row < window.bottom {
        let height = if row >= BY_TWOS { 2.min(window.bottom - row) } else { 1 };
        for step in 0..window.right - window.left {
            let column = if leftward { window.right - 1 - step } else { window.left + step };
            order.extend((row..row + height).map(|row| [row, column]));
        }
        (row, leftward) = (row + height, !leftward);
    }
    order
}

fn farthest_m(rays: &[Ray]) -> f64 {
    rays.iter().map(|ray| ray.reach_m).fold(0.0, f64::max)
}

/// Middle and radius of some points.
fn circle(ahead: &[f64], left: &[f64]) -> ([f64; 2], u16) {
    let middle = [ahead, left].map(|x| 0.5 * (num::min(x) + num::max(x)));
    let distances = ahead.iter().zip(left).map(|(x, y)| num::hypot(x - middle[0], y - middle[1]));
    (middle, radius(distances.fold(0.0, f64::max)))
}

/// What all rays of the blocks find on the ground.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn look_at_blocks(blocks: &Blocks, lens: &Lens, ground: &Ground, found: &mut Found) {
    let (raster, clearance) = (ground.raster(), ground.clearance());
    let [last_column, last_row] = [raster.columns, raster.rows].map(|cells| cells as f64 - 1.0);
    let mut places = [0_u32; MOST_BLOCKS];
    for ((&ahead, &left), place) in blocks.ahead.iter().zip(&blocks.left).zip(&mut places) {
        let [column, row] = lens.cell(ahead, left);
        // Outside there is only grass, so the nearest point inside knows what is around.
        let column = whole(column.max(0.0).min(last_column));
        *place = clearance.place(column, whole(row.max(0.0).min(last_row)));
    }
    let (mut mixed, mut count) = ([0_usize; MOST_BLOCKS], 0);
    for (block, (&place, &radius)) in places.iter().zip(&blocks.radius).enumerate() {
        let around = clearance.at(place);
        found.0[block] = [around.material(); BLOCK];
        mixed[count] = block;
        count += usize::from(!around.is_clear(radius));
    }
    for &block in &mixed[..count.min(blocks.len())] {
        blocks.rays.look(block * BLOCK, lens, raster, &mut found.0[block]);
    }
}
