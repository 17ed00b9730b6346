//! Small symmetric systems. A matrix is its lower triangle, row by row.

/// Place of row `i`, column `j` ≤ `i`.
pub(crate) fn at(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

/// Numbers in a lower triangle of `n` rows.
pub(crate) fn size(n: usize) -> usize {
    at(n, 0)
}

/// Replaces a positive definite matrix by its Cholesky factor. Where rounding took away what makes it so, a pivot is
/// raised to a trifle of its matrix's diagonal.
pub(crate) fn factor(a: &mut [f64], n: usize) {
    let largest = (0..n).map(|i| a[at(i, i)]).fold(f64::MIN_POSITIVE, f64::max);
    for i in 0..n {
        for j in 0..=i {
            let (row, other) = (at(i, 0), at(j, 0));
            let known: f64 = (0..j).map(|k| a[row + k] * a[other + k]).sum();
            let rest = a[row + j] - known;
            a[row + j] = if i == j { rest.max(1e-12 * largest).sqrt() } else { rest / a[other + j] };
        }
    }
}

/// Solves L x = b, given the factor L of A; x takes the place of b.
pub(crate) fn solve_lower(factor: &[f64], n: usize, b: &mut [f64]) {
    for i in 0..n {
        let known: f64 = (0..i).map(|k| factor[at(i, k)] * b[k]).sum();
        b[i] = (b[i] - known) / factor[at(i, i)];
    }
}

/// L b, given the factor L of A, in the place of b.
pub(crate) fn multiply_lower(factor: &[f64], n: usize, b: &mut [f64]) {
    for i in (0..n).rev() {
        b[i] = (0..=i).map(|k| factor[at(i, k)] * b[k]).sum();
    }
}

/// Solves A x = b, given A's factor; x takes the place of b.
pub(crate) fn solve(factor: &[f64], n: usize, b: &mut [f64]) {
    solve_lower(factor, n, b);
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| factor[at(k, i)] * b[k]).sum();
        b[i] = (b[i] - known) / factor[at(i, i)];
    }
}

/// The inverse of A, given A's factor, into `out`.
pub(crate) fn invert(factor: &[f64], n: usize, out: &mut [f64], column: &mut [f64]) {
    for j in 0..n {
        column[..n].fill(0.0);
        column[j] = 1.0;
        solve(factor, n, &mut column[..n]);
        for i in j..n {
            out[at(i, j)] = column[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn systems_are_solved_and_inverted_as_by_others() {
        let full = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, -0.5, 1.0, 3.0, 0.2, -0.5, 0.2, 2.0]);
        let mut a = vec![4.0, 1.0, 3.0, -0.5, 0.2, 2.0];
        factor(&mut a, 3);
        let mut x = [1.0, -2.0, 0.5];
        let expected = full.clone().lu().solve(&DVector::from_row_slice(&x)).unwrap();
        solve(&a, 3, &mut x);
        assert!(x.iter().zip(expected.iter()).all(|(x, e)| (x - e).abs() < 1e-12));
        let (mut inverse, mut column) = ([0.0; 6], [0.0; 3]);
        invert(&a, 3, &mut inverse, &mut column);
        let expected = full.try_inverse().unwrap();
        for i in 0..3 {
            for j in 0..=i {
                assert!((inverse[at(i, j)] - expected[(i, j)]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn half_a_solution_is_undone_by_its_factor() {
        let mut a = vec![4.0, 1.0, 3.0, -0.5, 0.2, 2.0];
        factor(&mut a, 3);
        let mut x = [1.0, -2.0, 0.5];
        solve_lower(&a, 3, &mut x);
        let squares: f64 = x.iter().map(|x| x * x).sum();
        multiply_lower(&a, 3, &mut x);
        assert!(x.iter().zip([1.0, -2.0, 0.5]).all(|(x, y)| (x - y).abs() < 1e-12));
        let mut whole = [1.0, -2.0, 0.5];
        solve(&a, 3, &mut whole);
        let expected: f64 = whole.iter().zip(x).map(|(a, b)| a * b).sum();
        assert!((squares - expected).abs() < 1e-12, "both are b A⁻¹ b");
    }

    #[test]
    fn a_matrix_at_the_edge_is_still_factored() {
        let mut a = vec![1.0, 1.0, 1.0];
        factor(&mut a, 2);
        assert!(a.iter().all(|x| x.is_finite()) && a[2] > 0.0);
    }
}
