//! Compression as in JPEG: blocks of 8×8, cosines, coarse steps. It blurs what is fine and rings at edges.

use metal_rl::num;
use std::f64::consts::PI;

/// Side of a block.
const SIDE: usize = 8;
type Block = [[f64; SIDE]; SIDE];

/// The cosines of a block, computed once.
#[derive(Clone, Debug)]
pub struct Compressor {
    /// Row u: the basis function of frequency u at the eight places, orthonormal.
    basis: Block,
    step: f64,
}

impl Compressor {
    /// Coarsens the lowest frequency in steps of `step` and higher ones more (0: leaves everything as it is).
    #[must_use]
    pub fn new(step: f64) -> Self {
        let mut basis = [[0.0; SIDE]; SIDE];
        for (u, row) in basis.iter_mut().enumerate() {
            let scale = if u == 0 { (1.0 / SIDE as f64).sqrt() } else { (2.0 / SIDE as f64).sqrt() };
            for (x, value) in row.iter_mut().enumerate() {
                *value = scale * num::cos(PI * u as f64 * (2 * x + 1) as f64 / (2 * SIDE) as f64);
            }
        }
        Self { basis, step }
    }

    /// Compresses a picture of `columns` columns in place; colours are coarsened twice as much as brightness.
    pub fn compress(&self, pixels: &mut [[f64; 3]], columns: usize) {
        if self.step <= 0.0 {
            return;
        }
        pixels.iter_mut().for_each(|p| *p = to_ycc(*p));
        let rows = pixels.len() / columns;
        for top in (0..rows).step_by(SIDE) {
            for left in (0..columns).step_by(SIDE) {
                for (channel, step) in [self.step, 2.0 * self.step, 2.0 * self.step].into_iter().enumerate() {
                    self.block(pixels, (columns, rows), (top, left), (channel, step));
                }
            }
        }
        pixels.iter_mut().for_each(|p| *p = to_rgb(*p));
    }

    /// One block of one channel; beyond the picture's edge its last pixels repeat.
    fn block(
        &self,
        pixels: &mut [[f64; 3]],
        (columns, rows): (usize, usize),
        (top, left): (usize, usize),
        (channel, step): (usize, f64),
    ) {
        let mut block: Block = [[0.0; SIDE]; SIDE];
        for (r, row) in block.iter_mut().enumerate() {
            for (c, value) in row.iter_mut().enumerate() {
                let at = (top + r).min(rows - 1) * columns + (left + c).min(columns - 1);
                *value = pixels[at][channel];
            }
        }
        let mut spectrum = transposed(&self.analysed(&transposed(&self.analysed(&block))));
        for (u, row) in spectrum.iter_mut().enumerate() {
            for (v, value) in row.iter_mut().enumerate() {
                let coarse = step * (1 + u + v) as f64;
                *value = (*value / coarse).round() * coarse;
            }
        }
        let block = transposed(&self.composed(&transposed(&self.composed(&spectrum))));
        for (r, row) in block.iter().enumerate().take(rows - top) {
            for (c, value) in row.iter().enumerate().take(columns - left) {
                pixels[(top + r) * columns + left + c][channel] = *value;
            }
        }
    }

    /// Every row as its spectrum.
    fn analysed(&self, block: &Block) -> Block {
        block.map(|row| self.basis.map(|wave| wave.iter().zip(row).map(|(w, x)| w * x).sum()))
    }

    /// Every row from its spectrum.
    fn composed(&self, block: &Block) -> Block {
        block.map(|row| std::array::from_fn(|x| (0..SIDE).map(|u| self.basis[u][x] * row[u]).sum()))
    }
}

fn transposed(block: &Block) -> Block {
    std::array::from_fn(|r| std::array::from_fn(|c| block[c][r]))
}

/// Brightness and two differences of colour, as in JPEG files.
fn to_ycc([r, g, b]: [f64; 3]) -> [f64; 3] {
    let y = 0.299 * r + 0.587 * g + 0.114 * b;
    [y, 0.564 * (b - y), 0.713 * (r - y)]
}

fn to_rgb([y, cb, cr]: [f64; 3]) -> [f64; 3] {
    let (r, b) = (y + cr / 0.713, y + cb / 0.564);
    [r, (y - 0.299 * r - 0.114 * b) / 0.587, b]
}

#[cfg(test)]
mod tests {
    use super::*;
    use metal_rl::random::Rng;

    fn picture(columns: usize, rows: usize) -> Vec<[f64; 3]> {
        let mut rng = Rng::new(5);
        (0..columns * rows).map(|_| std::array::from_fn(|_| rng.range(0.0, 255.0))).collect()
    }

    fn worst(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
        let differences = a.as_flattened().iter().zip(b.as_flattened()).map(|(x, y)| (x - y).abs());
        differences.fold(0.0, f64::max)
    }

    #[test]
    fn a_tiny_step_changes_nothing_and_a_large_one_much() {
        let (before, mut fine, mut coarse) = (picture(52, 39), picture(52, 39), picture(52, 39));
        Compressor::new(1e-9).compress(&mut fine, 52);
        Compressor::new(8.0).compress(&mut coarse, 52);
        assert!(worst(&before, &fine) < 1e-6);
        assert!(worst(&before, &coarse) > 20.0);
    }

    #[test]
    fn plain_pictures_stay_plain() {
        let mut plain = vec![[40.0, 150.0, 45.0]; 52 * 39];
        Compressor::new(4.0).compress(&mut plain, 52);
        assert!(worst(&plain, &vec![plain[0]; 52 * 39]) < 1e-9);
        assert!(
            plain[0].iter().zip([40.0, 150.0, 45.0]).all(|(a, b)| (a - b).abs() < 12.0),
            "{:?}",
            plain[0]
        );
    }
}
