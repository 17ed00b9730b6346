//! Local linear values: every component has a linear function for each thing whose worth is asked, of its own directions
//! and of what is known at all.
//!
//! Fitted by weighted least squares, one component at a time, with the share that a component has given *what is known*
//! as weight: the conditional means of a joint Gaussian of values and inputs, but for the moments as the student sees
//! them. Where a component has few moments, one linear function for all components stands in.

use crate::num;
use crate::num::cholesky;
use serde::{Deserialize, Serialize};

/// The shape of the functions of one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Shape {
    /// Things whose worth is asked.
    pub outputs: usize,
    /// Inputs: 1, the component's directions, and what they all have in common.
    pub inputs: usize,
    /// The component's own among them, behind the 1.
    pub own: usize,
    /// Groups of outputs that are fitted with weights of their own.
    pub groups: usize,
}

/// The functions of all components.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Heads {
    shape: Shape,
    /// Component × output × input.
    weights: Vec<f64>,
}

impl Heads {
    /// Functions that are 0 everywhere.
    pub fn new(shape: Shape, components: usize) -> Self {
        Self { shape, weights: vec![0.0; components * shape.outputs * shape.inputs] }
    }

    /// Their shape.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// How many numbers were learned.
    pub fn numbers(&self) -> usize {
        self.weights.len()
    }

    fn place(&self, component: usize, output: usize) -> std::ops::Range<usize> {
        let start = (component * self.shape.outputs + output) * self.shape.inputs;
        start..start + self.shape.inputs
    }

    /// The value of `output` by component `c`.
    pub fn value(&self, (c, output): (usize, usize), inputs: &[f64]) -> f64 {
        let weights = &self.weights[self.place(c, output)];
        weights.iter().zip(inputs).map(|(w, x)| w * x).sum()
    }

    /// Turns the values v of an output into gain·v + shift, in all components; inputs from `values` on are values
    /// themselves and change their unit with it.
    pub fn rescale(&mut self, output: usize, (gain, shift): (f64, f64), values: usize) {
        for c in 0..self.components() {
            let place = self.place(c, output);
            let weights = &mut self.weights[place];
            weights[..values].iter_mut().for_each(|w| *w *= gain);
            weights[0] += shift;
        }
    }

    fn components(&self) -> usize {
        self.weights.len() / (self.shape.outputs * self.shape.inputs)
    }

    /// Whether these are functions of this shape for so many components.
    pub fn is_sound(&self, shape: Shape, components: usize) -> bool {
        self.shape == shape && self.weights.len() == components * shape.outputs * shape.inputs
    }
}

/// Sums from which functions are fitted.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    shape: Shape,
    components: usize,
    /// Component × group × lower triangle of Σ w x xᵀ.
    squares: Vec<f64>,
    /// Component × output × Σ w x y.
    products: Vec<f64>,
}

/// What was seen of some outputs of one group in a moment.
#[derive(Clone, Copy)]
pub(super) struct Labels<'a> {
    /// The group.
    pub group: usize,
    /// Outputs and their labels.
    pub labels: &'a [(usize, f64)],
    /// How much they count.
    pub weight: f64,
}

impl Sums {
    /// Nothing seen yet.
    pub fn new(shape: Shape, components: usize) -> Self {
        let triangle = cholesky::size(shape.inputs);
        Self {
            shape,
            components,
            squares: vec![0.0; components * shape.groups * triangle],
            products: vec![0.0; components * shape.outputs * shape.inputs],
        }
    }

    /// What was seen counts this share of what is seen from now on.
    pub fn fade(&mut self, share: f64) {
        self.squares.iter_mut().chain(&mut self.products).for_each(|x| *x *= share);
    }

    /// Adds what component `c` is to learn from a moment.
    pub fn add(&mut self, c: usize, inputs: &[f64], seen: Labels<'_>) {
        let (n, triangle) = (self.shape.inputs, cholesky::size(self.shape.inputs));
        let start = (c * self.shape.groups + seen.group) * triangle;
        let squares = &mut self.squares[start..start + triangle];
        for i in 0..n {
            let scaled = seen.weight * inputs[i];
            let row = &mut squares[cholesky::at(i, 0)..=cholesky::at(i, i)];
            row.iter_mut().zip(inputs).for_each(|(sum, x)| *sum += scaled * x);
        }
        for &(output, label) in seen.labels {
            let start = (c * self.shape.outputs + output) * n;
            let products = &mut self.products[start..start + n];
            products.iter_mut().zip(inputs).for_each(|(sum, x)| *sum += seen.weight * label * x);
        }
    }

    fn squares(&self, c: usize, group: usize) -> &[f64] {
        let triangle = cholesky::size(self.shape.inputs);
        let start = (c * self.shape.groups + group) * triangle;
        &self.squares[start..start + triangle]
    }

    fn products(&self, c: usize, output: usize) -> &[f64] {
        let start = (c * self.shape.outputs + output) * self.shape.inputs;
        &self.products[start..start + self.shape.inputs]
    }

    /// Whether an input is a component's own.
    fn is_own(&self, input: usize) -> bool {
        (1..=self.shape.own).contains(&input)
    }

    /// The functions that fit best; `group` says to which group an output belongs, `prior` how many moments the function
    /// for all counts for.
    pub fn fit(&self, heads: &mut Heads, group: &dyn Fn(usize) -> usize, prior: f64) {
        for g in 0..self.shape.groups {
            let outputs: Vec<usize> = (0..self.shape.outputs).filter(|&o| group(o) == g).collect();
            let (common, scale) = self.common(g, &outputs);
            for c in 0..self.components {
                let mut factor = self.squares(c, g).to_vec();
                for i in 0..self.shape.inputs {
                    factor[cholesky::at(i, i)] += prior * scale[i];
                }
                cholesky::factor(&mut factor, self.shape.inputs);
                for (&output, common) in outputs.iter().zip(&common) {
                    let mut weights = self.products(c, output).to_vec();
                    for i in 0..weights.len() {
                        weights[i] += prior * scale[i] * common[i];
                    }
                    cholesky::solve(&factor, self.shape.inputs, &mut weights);
                    let place = heads.place(c, output);
                    heads.weights[place].copy_from_slice(&weights);
                }
            }
        }
    }

    /// The functions of a group's outputs for all components together, 0 in the components' own inputs; and the mean
    /// square of every input.
    fn common(&self, group: usize, outputs: &[usize]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let n = self.shape.inputs;
        let mut squares = vec![0.0; cholesky::size(n)];
        for c in 0..self.components {
            squares.iter_mut().zip(self.squares(c, group)).for_each(|(sum, s)| *sum += s);
        }
        let mass = squares[0].max(1e-9);
        let scale: Vec<f64> = (0..n).map(|i| (squares[cholesky::at(i, i)] / mass).max(1e-6)).collect();
        for i in 0..n {
            for j in 0..i {
                if self.is_own(i) || self.is_own(j) {
                    squares[cholesky::at(i, j)] = 0.0;
                }
            }
            squares[cholesky::at(i, i)] += 1e-3 * scale[i] * mass.min(1.0) + 1e-9;
        }
        cholesky::factor(&mut squares, n);
        let fit = |&output: &usize| {
            let mut weights = vec![0.0; n];
            for c in 0..self.components {
                weights.iter_mut().zip(self.products(c, output)).for_each(|(sum, p)| *sum += p);
            }
            (0..n).filter(|&i| self.is_own(i)).for_each(|i| weights[i] = 0.0);
            cholesky::solve(&squares, n, &mut weights);
            weights
        };
        (outputs.iter().map(fit).collect(), scale)
    }
}

/// The largest of some values.
pub(super) fn largest(values: &[f64]) -> f64 {
    values[num::argmax(values)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape = Shape { outputs: 2, inputs: 3, own: 1, groups: 2 };

    /// Two components: y = 1 + 2z + 3b in the first, 1 − z + 3b in the second; the other output is 7 everywhere.
    fn taught(moments: usize, prior: f64) -> Heads {
        let mut sums = Sums::new(SHAPE, 2);
        for n in 0..moments {
            let (c, z, b) = (n % 2, (n % 7) as f64 / 3.0 - 1.0, (n % 3) as f64 - 1.0);
            let slope = if c == 0 { 2.0 } else { -1.0 };
            let labels = [(0, 1.0 + slope * z + 3.0 * b)];
            sums.add(c, &[1.0, z, b], Labels { group: 0, labels: &labels, weight: 0.5 });
            sums.add(c, &[1.0, z, b], Labels { group: 1, labels: &[(1, 7.0)], weight: 1.0 });
        }
        let mut heads = Heads::new(SHAPE, 2);
        sums.fit(&mut heads, &|output| output, prior);
        heads
    }

    #[test]
    fn every_component_finds_its_slope() {
        let mut heads = taught(600, 1e-6);
        assert!((heads.value((0, 0), &[1.0, 0.5, 2.0]) - 8.0).abs() < 1e-3);
        assert!((heads.value((1, 0), &[1.0, 0.5, 2.0]) - 6.5).abs() < 1e-3);
        assert!((heads.value((1, 1), &[1.0, 0.5, 2.0]) - 7.0).abs() < 1e-3);
        heads.rescale(1, (2.0, -1.0), 3);
        assert!((heads.value((0, 1), &[1.0, 0.5, 2.0]) - 13.0).abs() < 1e-2);
    }

    #[test]
    fn who_has_seen_nothing_believes_what_holds_for_all() {
        let mut sums = Sums::new(SHAPE, 2);
        for n in 0..300 {
            let b = (n % 3) as f64 - 1.0;
            let labels = [(0, 4.0 - 2.0 * b)];
            sums.add(0, &[1.0, 0.0, b], Labels { group: 0, labels: &labels, weight: 1.0 });
        }
        let mut heads = Heads::new(SHAPE, 2);
        sums.fit(&mut heads, &|output| output, 2.0);
        assert!((heads.value((1, 0), &[1.0, 5.0, 1.0]) - 2.0).abs() < 0.02);
    }
}
