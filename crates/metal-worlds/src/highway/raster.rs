//! The picture of the plane in memory: small, and such that neighbours in any direction are near.

use super::ground::Material;

/// Cells of a tile: a square of 8×8, one line of a processor's cache.
const TILE: usize = 64;

/// Materials of the plane, tile by tile from the lower left, and then one cell for everything outside.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    cells: Vec<Material>,
    /// Cells to skip, so that tiles begin where cache lines do.
    start: usize,
    tiles_across: u32,
    /// Cells across.
    pub columns: usize,
    /// Cells from the bottom to the top.
    pub rows: usize,
}

impl Raster {
    /// Grass everywhere.
    pub fn grass(columns: usize, rows: usize) -> Self {
        let across = columns.div_ceil(8);
        let cells = vec![Material::Grass; TILE + across * rows.div_ceil(8) * TILE + 1];
        let start = cells.as_ptr().align_offset(TILE).min(TILE);
        Self { cells, start, tiles_across: across as u32, columns, rows }
    }

    /// All cells by their places; the last is everything outside.
    pub fn cells(&self) -> &[Material] {
        let end = self.cells.len() - (TILE - self.start);
        &self.cells[self.start..end]
    }

    /// Place of a cell: its tile, its row there and its column there. Without branches, to be asked for many at once.
    #[inline(always)]
    pub fn place(&self, column: u32, row: u32) -> u32 {
        let tile = (row >> 3).wrapping_mul(self.tiles_across).wrapping_add(column >> 3);
        (tile << 6) | ((row & 7) << 3) | (column & 7)
    }

    /// Place of everything outside.
    pub fn outside(&self) -> u32 {
        (self.cells().len() - 1) as u32
    }

    /// The material at a place.
    pub fn at(&self, place: u32) -> Material {
        self.cells()[place as usize]
    }

    /// Paints a cell.
    pub fn set(&mut self, column: usize, row: usize, material: Material) {
        let place = self.place(column as u32, row as u32) as usize;
        self.cells[self.start + place] = material;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_painted_is_there_and_nowhere_else() {
        let mut raster = Raster::grass(40, 33);
        let material =
            |c: u32, r: u32| [Material::Road, Material::Line, Material::Grass][(7 * c + 3 * r) as usize % 3];
        let cells = || (0..33).flat_map(|r| (0..40).map(move |c| (c, r)));
        cells().for_each(|(c, r)| raster.set(c as usize, r as usize, material(c, r)));
        for (c, r) in cells() {
            assert_eq!(raster.at(raster.place(c, r)), material(c, r), "{c} {r}");
        }
        assert_eq!(raster.at(raster.outside()), Material::Grass);
    }
}
