//! The inner loops of the camera: what many rays meet at once, compiled once for any processor and once for those with
//! 256-bit vectors, with the same bits from both.

use super::blocks::BLOCK;
use super::ground::{CELL_M, Material};
use super::kinematics::BODY_RADIUS_M;
use super::raster::Raster;
use multiversion::multiversion;
use std::ops::Range;

/// The ray of one pixel, in the frame of the lens: x ahead, y left, on the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Direction on the plane, of length 1.
    pub direction: [f64; 2],
    /// Distance on the plane at which the ray meets the ground, in metres.
    pub reach_m: f64,
}

/// Many rays, one vector per number.
#[derive(Clone, Debug, Default)]
pub(super) struct Rays {
    x: Vec<f64>,
    y: Vec<f64>,
    reach_m: Vec<f64>,
    /// Where the ray meets the ground, in raster cells ahead of the lens.
    ahead: Vec<f64>,
    /// The same to its left.
    left: Vec<f64>,
}

impl FromIterator<Ray> for Rays {
    fn from_iter<I: IntoIterator<Item = Ray>>(rays: I) -> Self {
        let mut all = Self::default();
        for ray in rays {
            let [x, y] = ray.direction;
            all.x.push(x);
            all.y.push(y);
            all.reach_m.push(ray.reach_m);
            all.ahead.push(x * ray.reach_m / CELL_M);
            all.left.push(y * ray.reach_m / CELL_M);
        }
        all
    }
}

impl Rays {
    /// Where the rays of each block meet the ground, in raster cells ahead of the lens and to its left.
    pub fn points(&self) -> impl Iterator<Item = (&[f64], &[f64])> {
        self.ahead.chunks(BLOCK).zip(self.left.chunks(BLOCK))
    }

    /// What the rays from `start` find on the ground.
    #[inline(always)]
    pub fn look<const N: usize>(&self, start: usize, lens: &Lens, raster: &Raster, out: &mut [Material; N]) {
        let (ahead, left) = (&self.ahead[start..start + N], &self.left[start..start + N]);
        let (columns, rows) = (raster.columns as f64, raster.rows as f64);
        let (cells, outside) = (raster.cells(), raster.outside());
        let mut places = [0_u32; N];
        for ((&ahead, &left), place) in ahead.iter().zip(left).zip(&mut places) {
            let [column, row] = lens.cell(ahead, left);
            let inside = (column >= 0.0) & (row >= 0.0) & (column < columns) & (row < rows);
            let at = raster.place(whole(column), whole(row));
            *place = if inside { at } else { outside };
        }
        for (&place, out) in places.iter().zip(out) {
            *out = cells[place as usize];
        }
    }
}

/// Where the lens is, in raster cells, and where it points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    pub column: f64,
    pub row: f64,
    pub sin: f64,
    pub cos: f64,
}

impl Lens {
    /// Raster coordinates of a point that many cells ahead and to the left.
    #[inline(always)]
    pub fn cell(&self, ahead: f64, left: f64) -> [f64; 2] {
        [self.column + ahead * self.cos - left * self.sin, self.row + ahead * self.sin + left * self.cos]
    }
}

/// A body in the frame of the lens: metres ahead and to the left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visible {
    pub ahead: f64,
    pub left: f64,
    pub material: Material,
}

impl Visible {
    pub const NONE: Self = Self { ahead: 0.0, left: 0.0, material: Material::Grass };

    /// Squared distance of its centre, in square metres.
    pub fn distance2(&self) -> f64 {
        self.ahead * self.ahead + self.left * self.left
    }

    /// Whether the ray meets the body before it meets the ground.
    #[inline(always)]
    pub fn hides(&self, ray: &Ray) -> bool {
        let [x, y] = ray.direction;
        let along = self.ahead * x + self.left * y;
        let beside = self.left * x - self.ahead * y;
        let half2 = BODY_RADIUS_M * BODY_RADIUS_M - beside * beside;
        // Entry at along − √half2, asked without the root and without a branch, so that rays can be asked in fours.
        let short = along - ray.reach_m;
        (half2 > 0.0) & (along > 0.0) & ((short < 0.0) | (short * short < half2))
    }
}

/// The largest whole number up to `x`, 0 ≤ x < 2³² (anything for others): as a cast, but in vectors on any processor.
#[inline(always)]
pub(super) fn whole(x: f64) -> u32 {
    /// From here on the last bit of a number means 1, so that adding it to a smaller one leaves that one's whole part,
    /// rounded, in the low bits.
    const UNIT_LAST: f64 = 4_503_599_627_370_496.0;
    let shifted = x + UNIT_LAST;
    (shifted.to_bits() as u32).wrapping_sub(u32::from(shifted - UNIT_LAST > x))
}

/// Paints `body` over what the rays `range` show, where it hides that.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn put_before(rays: &Rays, range: Range<usize>, body: &Visible, out: &mut [Material]) {
    let directions = rays.x[range.clone()].iter().zip(&rays.y[range.clone()]);
    for (((&x, &y), &reach_m), out) in directions.zip(&rays.reach_m[range]).zip(out) {
        let hidden = body.hides(&Ray { direction: [x, y], reach_m });
        *out = if hidden { body.material } else { *out };
    }
}

/// How many of `materials` are of each class.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn count_classes(materials: &[Material]) -> [u32; 4] {
    let mut counts = [0; 4];
    // A byte holds the count of a chunk.
    for chunk in materials.chunks(128) {
        let (mut white, mut red, mut green) = (0_u8, 0_u8, 0_u8);
        for &material in chunk {
            white += u8::from(material == Material::Line);
            red += u8::from(material == Material::RedBody);
            green += u8::from(material == Material::Grass);
        }
        let coloured = [white, red, green].map(u32::from);
        counts[0] += chunk.len() as u32 - coloured.iter().sum::<u32>();
        counts[1..].iter_mut().zip(coloured).for_each(|(sum, n)| *sum += n);
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn whole_numbers_and_their_neighbours_are_cut_as_by_a_cast() {
        for k in [0.0, 1.0, 2.0, 3.0, 1023.0, 1024.0, 65_535.0, 4_294_967_295.0_f64] {
            for x in [k, k.next_up(), k.next_down().max(0.0), k + 0.5, (k + 0.5).next_down()] {
                assert_eq!(whole(x), x as u32, "{x}");
            }
        }
    }

    proptest! {
        #[test]
        fn any_number_is_cut_as_by_a_cast(x in 0.0..1e6) {
            prop_assert_eq!(whole(x), x as u32);
        }
    }
}
