//! How far around a place the plane looks the same, so that many rays can be answered at once.

use super::ground::Material;
use super::raster::Raster;

/// Cells of the raster across a tile of the map.
const TILE: usize = 4;
/// Steps of a radius in a cell of the raster.
const STEPS: f64 = 4.0;

/// Largest radius the map can hold.
const MOST_RADIUS: f64 = 16_383.0;

/// Price of a step to a neighbour beside, and across a corner, when distances are added up cell by cell.
const BESIDE: u16 = 5;
const CORNER: u16 = 7;
/// Farther than any cell is from another.
const FAR: u16 = u16::MAX / 2;
/// No sum of steps is larger than this multiple of the straight distance, in cells: (1 + 0.4 t)/√(1 + t²), t = 0.4.
const MOST_PER_CELL: f64 = 5.0 * 1.077_033;

/// For each tile of 4×4 cells the material of all points that are within a radius of any of its points.
#[derive(Clone, Debug)]
pub(super) struct Clearance {
    /// Radius in quarters of a cell, rounded down, times four, and the material.
    tiles: Vec<u16>,
    across: u32,
}

/// What a tile says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Around {
    packed: u16,
}

impl Around {
    /// Whether everything within a radius (from [`radius`]) of any point of the tile is of [`Self::material`].
    #[inline(always)]
    pub fn is_clear(self, radius: u16) -> bool {
        self.packed >> 2 >= radius
    }

    /// The material of the tile's cells, if they are all of one.
    #[inline(always)]
    pub fn material(self) -> Material {
        [Material::Road, Material::Line, Material::RedBody, Material::Grass][usize::from(self.packed & 3)]
    }
}

/// A radius in cells of the raster as the map counts it, rounded up.
pub(super) fn radius(cells: f64) -> u16 {
    // More than rounding moves a point, and never nothing: a tile of several materials is clear of nothing.
    (cells * STEPS + 1e-3).ceil().max(1.0) as u16
}

impl Clearance {
    /// The map of a raster, around which everything is grass.
    pub fn of(raster: &Raster) -> Self {
        let steps = Steps::of(raster);
        let [across, up] = [raster.columns, raster.rows].map(|cells| cells.div_ceil(TILE));
        let tile = |i: usize| steps.tile((i % across) * TILE, (i / across) * TILE);
        Self { tiles: (0..across * up).map(tile).collect(), across: across as u32 }
    }

    /// Place of the tile of a cell. Without branches, to be asked for many at once.
    #[inline(always)]
    pub fn place(&self, column: u32, row: u32) -> u32 {
        (row / TILE as u32).wrapping_mul(self.across).wrapping_add(column / TILE as u32)
    }

    /// What the tile at a place says.
    #[inline(always)]
    pub fn at(&self, place: u32) -> Around {
        Around { packed: self.tiles[place as usize] }
    }
}

/// Sums of steps from each cell's middle to the middle of the nearest cell of another material; the raster has a rim of
/// grass, one cell wide.
struct Steps {
    materials: Vec<Material>,
    sums: Vec<u16>,
    across: usize,
    size: [usize; 2],
}

impl Steps {
    fn of(raster: &Raster) -> Self {
        let (columns, rows) = (raster.columns, raster.rows);
        let across = columns + 2;
        let mut materials = vec![Material::Grass; across * (rows + 2)];
        for row in 0..rows {
            let out = &mut materials[(row + 1) * across + 1..][..columns];
            for (column, material) in out.iter_mut().enumerate() {
                *material = raster.at(raster.place(column as u32, row as u32));
            }
        }
        let sums = vec![FAR; materials.len()];
        let mut steps = Self { materials, sums, across, size: [columns, rows] };
        steps.sweep();
        steps
    }

    /// Two passes over all cells, as in a distance transform, but with the nearest *other* material as the source.
    /// A path to it needs at most two directions; it goes those of the first pass first.
    fn sweep(&mut self) {
        let (across, [columns, rows]) = (self.across, self.size);
        for row in 1..=rows {
            self.hear(row, row - 1);
            for i in row * across + 1..=row * across + columns {
                self.hear_beside(i, i - 1);
            }
        }
        for row in (1..=rows).rev() {
            self.hear(row, row + 1);
            for i in (row * across + 1..=row * across + columns).rev() {
                self.hear_beside(i, i + 1);
            }
        }
    }

    /// A row takes in what the row above or below it knows.
    fn hear(&mut self, row: usize, other: usize) {
        let columns = self.size[0];
        let [start, other] = [row, other].map(|row| row * self.across);
        let materials = |from: usize| &self.materials[from..][..columns];
        let (own, corner, middle, far) =
            (materials(start + 1), materials(other), materials(other + 1), materials(other + 2));
        let (before, after) = self.sums.split_at_mut(start.max(other));
        let (low, high) = (&mut before[start.min(other)..][..self.across], &mut after[..self.across]);
        let (sums, known) = if start > other { (high, low) } else { (low, high) };
        let sums = &mut sums[1..][..columns];
        let [a, b, c] = [0, 1, 2].map(|shift| &known[shift..][..columns]);
        let through = |same: bool, sum: u16, step: u16| if same { sum + step } else { step };
        for i in 0..columns {
            let left = through(corner[i] == own[i], a[i], CORNER);
            let across = through(middle[i] == own[i], b[i], BESIDE);
            let right = through(far[i] == own[i], c[i], CORNER);
            sums[i] = sums[i].min(left).min(across).min(right);
        }
    }

    /// A cell takes in what its neighbour in the row knows.
    #[inline(always)]
    fn hear_beside(&mut self, cell: usize, other: usize) {
        let same = self.materials[other] == self.materials[cell];
        let sum = if same { self.sums[other] + BESIDE } else { BESIDE };
        self.sums[cell] = self.sums[cell].min(sum);
    }

    /// The tile whose lower left cell is (`column`, `row`).
    fn tile(&self, column: usize, row: usize) -> u16 {
        let [columns, rows] = self.size;
        let line = |r: usize| {
            let start = (r + 1) * self.across + 1;
            start + column..start + (column + TILE).min(columns)
        };
        let sums = (row..(row + TILE).min(rows)).flat_map(|r| &self.sums[line(r)]);
        let least = sums.copied().min().unwrap_or(0);
        // From a point to the middle of its cell, and likewise at the other end, is half a diagonal.
        let cells = f64::from(least) / MOST_PER_CELL - std::f64::consts::SQRT_2;
        let steps = (cells * STEPS).floor().clamp(0.0, MOST_RADIUS) as u16;
        (steps << 2) | self.materials[line(row).start] as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_rl::random::Rng;

    /// A raster of 45×38 cells with some rectangles.
    fn patchwork(seed: u64) -> Raster {
        let (mut raster, mut rng) = (Raster::grass(45, 38), Rng::new(seed));
        for material in [Material::Road, Material::Line, Material::Grass, Material::Road] {
            let (left, bottom) = (rng.below(45), rng.below(38));
            let (right, top) = ((left + 1 + rng.below(20)).min(45), (bottom + 1 + rng.below(20)).min(38));
            (bottom..top).for_each(|r| (left..right).for_each(|c| raster.set(c, r, material)));
        }
        raster
    }

    /// The material at a point; grass outside.
    fn at(raster: &Raster, [x, y]: [f64; 2]) -> Material {
        let outside = x < 0.0 || y < 0.0 || x >= 45.0 || y >= 38.0;
        if outside { Material::Grass } else { raster.at(raster.place(x as u32, y as u32)) }
    }

    #[test]
    fn nothing_else_is_within_the_radius() {
        let mut rng = Rng::new(5);
        let mut told = 0;
        for seed in 0..40 {
            let raster = patchwork(seed);
            let map = Clearance::of(&raster);
            for _ in 0..2000 {
                let [x, y] = [rng.range(-9.0, 54.0), rng.range(-9.0, 47.0)];
                let [column, row] = [x.clamp(0.0, 44.0), y.clamp(0.0, 37.0)];
                let around = map.at(map.place(column as u32, row as u32));
                let (angle, size) = (rng.range(0.0, 6.3), rng.range(0.0, 12.0));
                if around.is_clear(radius(size)) {
                    let (sin, cos) = metal_rl::num::sin_cos(angle);
                    assert_eq!(at(&raster, [x + size * cos, y + size * sin]), around.material());
                    told += 1;
                }
            }
        }
        assert!(told > 4000, "{told} of 80000");
    }

    #[test]
    fn a_wide_field_is_known_to_be_wide() {
        let mut raster = Raster::grass(200, 200);
        (0..200).for_each(|r| raster.set(0, r, Material::Line));
        let map = Clearance::of(&raster);
        assert!(map.at(map.place(100, 100)).is_clear(radius(90.0)));
        assert!(!map.at(map.place(100, 100)).is_clear(radius(101.0)));
        assert_eq!(map.at(map.place(100, 100)).material(), Material::Grass);
    }
}
