//! Damped eigenvalues of weakly coupled modes, `(λ² + λ D + Ω²) x = 0`, by Gauss–Seidel iteration.
//!
//! With `x_j = 1` and D symmetric the sweep is `x_i = −λ Σ_{k≠i} d_ik x_k / (λ² + λ d_ii + ω_i²)`, and row j gives
//! `λ² + λ (d_jj + Σ d_jk x_k) + ω_j² = 0`. Every row is divided by its diagonal, so that slow eigenvalues are relatively accurate
//! next to fast ones, and undamped modes remain exactly imaginary. With close modes or strong dampers the iteration does not
//! converge, and the result is none.

use super::equations::ModalEquations;
use crate::numeric::{Complex, Matrix, symmetric};

/// Maximum number of Gauss–Seidel iterations.
const MAX_ITERATIONS: usize = 60;

/// Relative change of a converged iterate: rounding.
const ITERATION_TOLERANCE: f64 = 4.0 * f64::EPSILON;

/// Asymmetry of D, relative to its diagonal, that rounding explains.
const SYMMETRIC: f64 = 1e-13;

/// Damped eigenvalue with Im λ ≥ 0 and its eigenvector over the modes that are not free.
pub struct DampedRoot {
    /// Eigenvalue λ, 1/s.
    pub value: Complex,
    /// Eigenvector x.
    pub shape: Vec<Complex>,
}

/// Damped eigenvalues of all elastic modes and damped rigid motions; none if the iteration does not converge.
pub fn damped_roots(equations: &ModalEquations) -> Option<Vec<DampedRoot>> {
    if equations.stiffness.is_some() || !equations.inner.is_empty() {
        return None;
    }
    let first = equations.free;
    let omega = &equations.omega[first..];
    let (n, rigid) = (omega.len(), equations.rigid - first);
    let full = equations.damping_matrix();
    let mut d = Matrix::from_fn(n, n, |i, j| full[(first + i, first + j)]);
    let scale: Vec<f64> = (0..n).map(|i| d[(i, i)].abs().sqrt()).collect();
    for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let (a, b) = (d[(i, j)], d[(j, i)]);
        if (a - b).abs() > SYMMETRIC * scale[i] * scale[j] {
            return None;
        }
        let mean = 0.5 * (a + b);
        (d[(i, j)], d[(j, i)]) = (mean, mean);
    }
    let rotation = diagonalise_rigid(&mut d, rigid)?;
    let squares: Vec<f64> = omega.iter().map(|w| w * w).collect();
    let roots = (0..n).map(|j| {
        let mut root = match j < rigid {
            true => rigid_root(&d, &squares, j)?,
            false => elastic_root(&d, &squares, omega[j], j)?,
        };
        let x: Vec<Complex> = root.shape[..rigid].to_vec();
        for i in 0..rigid {
            root.shape[i] = (0..rigid).fold(Complex::ZERO, |sum, k| sum + x[k] * rotation[(i, k)]);
        }
        Some(root)
    });
    roots.collect()
}

/// Diagonalises the rigid block of D; returns the orthogonal transformation.
fn diagonalise_rigid(d: &mut Matrix, rigid: usize) -> Option<Matrix> {
    if rigid < 2 {
        return Some(Matrix::identity(rigid, rigid));
    }
    let n = d.nrows();
    let block = Matrix::from_fn(rigid, rigid, |i, j| d[(i, j)]);
    let eigen = symmetric::symmetric_eigen(&block).ok()?;
    let rotation = eigen.vectors;
    for j in rigid..n {
        let column: Vec<f64> = (0..rigid).map(|i| d[(i, j)]).collect();
        for i in 0..rigid {
            let sum = (0..rigid).map(|k| rotation[(k, i)] * column[k]).sum();
            (d[(i, j)], d[(j, i)]) = (sum, sum);
        }
    }
    for (i, j) in (0..rigid).flat_map(|i| (0..rigid).map(move |j| (i, j))) {
        d[(i, j)] = if i == j { eigen.values[i] } else { 0.0 };
    }
    Some(rotation)
}

/// Damped eigenvalue of an elastic mode.
fn elastic_root(d: &Matrix, squares: &[f64], omega: f64, j: usize) -> Option<DampedRoot> {
    let value = |b: Complex| -> Complex {
        let half = b * 0.5;
        let root = (Complex::new(squares[j], 0.0) - half * half).sqrt();
        Complex::new(-half.re - root.im, root.re - half.im)
    };
    let start = value(Complex::new(d[(j, j)], 0.0));
    (start.im > 0.5 * omega)
        .then(|| iterate_rows(d, squares, j, start, value))
        .flatten()
        .filter(|root| root.value.im > 0.5 * omega)
}

/// Real eigenvalue of a damped rigid motion.
fn rigid_root(d: &Matrix, squares: &[f64], j: usize) -> Option<DampedRoot> {
    let start = Complex::new(-d[(j, j)], 0.0);
    iterate_rows(d, squares, j, start, |b| -b).filter(|root| root.value.re < 0.0)
}

/// Iterates to convergence; `value` gives λ from `d_jj + Σ d_jk x_k`.
fn iterate_rows(
    d: &Matrix,
    squares: &[f64],
    j: usize,
    start: Complex,
    value: impl Fn(Complex) -> Complex,
) -> Option<DampedRoot> {
    let n = squares.len();
    let mut lambda = start;
    let mut x = vec![[0.0; 2]; n];
    x[j] = [1.0, 0.0];
    for _ in 0..MAX_ITERATIONS {
        // Squared relative change of x and λ.
        let mut change: f64 = 0.0;
        let (inverse, fast) = (lambda.inv(), lambda.norm_sqr());
        for i in (0..n).filter(|&i| i != j) {
            // D is symmetric: its columns are its rows.
            let row = d.col_as_slice(i);
            let pivot = match squares[i] {
                // λ is a factor of every term.
                0.0 => -(lambda + row[i]),
                square => -(lambda + row[i] + inverse * square),
            };
            let before = Complex::new(x[i][0], x[i][1]);
            let next = (coupling_sum(row, &x) - before * row[i]) * pivot.conj() / pivot.norm_sqr();
            change = change.max((next - before).norm_sqr() * (squares[i] / fast).max(1.0));
            x[i] = [next.re, next.im];
        }
        let next = value(coupling_sum(d.col_as_slice(j), &x));
        change = change.max((next - lambda).norm_sqr() / next.norm_sqr());
        lambda = next;
        if !change.is_finite() || lambda == Complex::ZERO {
            return None;
        }
        if change <= ITERATION_TOLERANCE * ITERATION_TOLERANCE {
            return Some(DampedRoot {
                value: lambda,
                shape: x.iter().map(|x| Complex::new(x[0], x[1])).collect(),
            });
        }
    }
    None
}

/// `Σ d_k x_k`, in two partial sums.
fn coupling_sum(d: &[f64], x: &[[f64; 2]]) -> Complex {
    let ((d_pairs, last), (x_pairs, remainder)) = (d.as_chunks::<2>(), x.as_chunks::<2>());
    let (mut even, mut odd) = ([0.0; 2], [0.0; 2]);
    for ([d, e], [x, y]) in d_pairs.iter().zip(x_pairs) {
        even = [even[0] + d * x[0], even[1] + d * x[1]];
        odd = [odd[0] + e * y[0], odd[1] + e * y[1]];
    }
    for (d, x) in last.iter().zip(remainder) {
        even = [even[0] + d * x[0], even[1] + d * x[1]];
    }
    Complex::new(even[0] + odd[0], even[1] + odd[1])
}

#[cfg(test)]
mod tests {
    use super::super::equations::ModalDamping;
    use super::*;

    fn equations(omega: &[f64], rigid: usize, damping: Matrix) -> ModalEquations {
        ModalEquations {
            omega: omega.to_vec(),
            free: 0,
            rigid,
            drag: 0.0,
            damping: ModalDamping::Full(damping),
            stiffness: None,
            inner: Vec::new(),
        }
    }

    /// Modal damping matrix of three dampers.
    fn dampers(n: usize, size: f64) -> Matrix {
        let row = |b: usize, j: usize| (1.3 * (b * n + j) as f64 + 0.4).sin();
        Matrix::from_fn(n, n, |i, j| {
            (0..3).map(|b| size * row(b, i) * row(b, j)).sum()
        })
    }

    /// Every root solves its equation to rounding, fast ones next to slow ones, with two rigid motions; strong dampers
    /// give none.
    #[test]
    fn law_roots_solve_the_quadratic() {
        let omega = [0.0, 0.0, 1.0, 3.0, 700.0, 2e5];
        let n = omega.len();
        let found = damped_roots(&equations(&omega, 2, dampers(n, 0.02))).unwrap();
        assert_eq!(found.len(), n);
        let d = dampers(n, 0.02);
        for root in &found {
            let x = &root.shape;
            for i in 0..n {
                let square = root.value * root.value + omega[i] * omega[i];
                let coupling = (0..n).fold(Complex::ZERO, |sum, k| sum + x[k] * d[(i, k)]);
                let size = (root.value.norm() + omega[i]).powi(2) * (1e-3 + x[i].norm());
                let r = (square * x[i] + root.value * coupling).norm();
                assert!(r < 1e-14 * size, "{:?} row {i}: {r:e}", root.value);
            }
            assert!(root.value.re < 0.0);
        }
        assert_eq!(found.iter().filter(|r| r.value.im == 0.0).count(), 2);
        assert!(damped_roots(&equations(&[1.0, 1.1], 0, dampers(2, 3.0))).is_none());
    }

    /// A mode without damper is exactly undamped.
    #[test]
    fn exact_unseen_mode() {
        let d = Matrix::from_fn(3, 3, |i, j| match (i, j) {
            (1, _) | (_, 1) => 0.0,
            _ => 0.1,
        });
        let found = damped_roots(&equations(&[1.0, 2.0, 4.0], 0, d)).unwrap();
        assert_eq!(found[1].value, Complex::new(0.0, 2.0));
    }
}
