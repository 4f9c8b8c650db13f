//! Damped modes polished in modal coordinates: `(λ² I + λ C + Ω²) x = 0`.
//!
//! Inverse iteration on both sides with the Rayleigh functional `yᵀ(λ² I + λ C + Ω²) x = 0`: Schwetlick & Schreiber,
//! Nonlinear Rayleigh functionals, Linear Algebra Appl. 436 (2012), pp. 3991–4016; Lancaster, Lambda-matrices and
//! vibrating systems (1966), §5.4. Rows and columns are scaled by `1 / max(|λ|, ω_i)`, which takes the grading out of
//! the matrix, so that small eigenvalues keep digits that a linearisation loses to the largest.

use faer::linalg::solvers::{PartialPivLu, Solve};

use crate::base::code::Code;
use crate::base::error::Error;

use super::{Complex, ComplexMatrix, Matrix};

/// A damped mode.
#[derive(Debug, Clone)]
pub struct Polished {
    /// λ.
    pub value: Complex,
    /// x, of length one.
    pub vector: Vec<Complex>,
    /// `max w_i |r_i| / max w_i (|λ|² |x_i| + |λ| Σ|C_ij| |x_j| + ω_i² |x_i|)` with `w_i = 1 / max(|λ|, ω_i)`: rows
    /// weighed as the mode feels them.
    pub residual: f64,
    /// Iterations, one factorisation each.
    pub steps: usize,
}

/// Polishes one eigenvalue of `λ² I + λ C + diag(squares)` and its right vector, C symmetric or not.
///
/// It moves to an eigenvalue near the start, mostly the nearest: a start that has no digit may end at another.
/// Not for λ = 0, which rigid motion has exactly; that comes back unchanged.
///
/// Errors: `NoConvergence` with the last change of λ; `Overflow` where the numbers leave the range of doubles.
pub fn quadratic_refine(
    c: &Matrix,
    squares: &[f64],
    value: Complex,
    vector: &[Complex],
) -> Result<Polished, Error> {
    let n = squares.len();
    let (mut value, mut right, mut left) = (value, vector.to_vec(), vector.to_vec());
    let mut last = f64::INFINITY;
    for steps in 0..=MOST_STEPS {
        if value.norm() == 0.0 || n == 0 || last <= SETTLED {
            let residual = residual(c, squares, value, &right);
            return Ok(Polished {
                value,
                vector: right,
                residual,
                steps,
            });
        }
        let weight: Vec<f64> = squares
            .iter()
            .map(|s| 1.0 / value.norm().max(s.abs().sqrt()))
            .collect();
        let factor = factorise(c, squares, value, &weight);
        let slope =
            |i: usize, j: usize| c[(i, j)] + if i == j { 2.0 * value } else { Complex::ZERO };
        right = inverse_step(
            &weight,
            |i| (0..n).map(|j| slope(i, j) * right[j]).sum(),
            |b| factor.solve(b),
        );
        left = inverse_step(
            &weight,
            |i| (0..n).map(|j| slope(j, i) * left[j]).sum(),
            |b| factor.solve_transpose(b),
        );
        let next = rayleigh(c, squares, &left, &right, value);
        let change = (next - value).norm() / value.norm();
        if !change.is_finite() {
            return Err(Error::new(
                Code::Overflow,
                format!("polishing λ = {value} 1/s left the range of doubles"),
            ));
        }
        // Rounding may hold λ at a few ε of change; an iteration that no longer shrinks has arrived.
        last = if change < STALLED && change >= last {
            0.0
        } else {
            change
        };
        value = next;
    }
    let message =
        format!("polishing an eigenvalue near {value} 1/s still moves it by {last:.1e} of itself");
    Err(Error::new(Code::NoConvergence, message))
}

const MOST_STEPS: usize = 20; // cubic near the end: 3 or 4 from a start with two digits
const SETTLED: f64 = 2.0 * f64::EPSILON;
const STALLED: f64 = 1e-10; // relative change of λ below which cubic convergence is over in one step

/// LU factors of the scaled matrix; a pivot of exactly zero is avoided by shifting λ by ε.
fn factorise(c: &Matrix, squares: &[f64], value: Complex, weight: &[f64]) -> PartialPivLu<Complex> {
    let n = weight.len();
    let at = |value: Complex| {
        let entry = |i: usize, j: usize| {
            let diagonal = if i == j {
                value * value + squares[i]
            } else {
                Complex::ZERO
            };
            (value * c[(i, j)] + diagonal) * weight[i] * weight[j]
        };
        ComplexMatrix::from_fn(n, n, entry).partial_piv_lu()
    };
    let factor = at(value);
    let is_singular = (0..n).any(|i| factor.U()[(i, i)].norm() == 0.0);
    if is_singular {
        at(value * (1.0 + 4.0 * f64::EPSILON))
    } else {
        factor
    }
}

/// `D S⁻¹ D b`, of length one.
fn inverse_step(
    weight: &[f64],
    b: impl Fn(usize) -> Complex,
    solve: impl Fn(&ComplexMatrix) -> ComplexMatrix,
) -> Vec<Complex> {
    let n = weight.len();
    let solved = solve(&ComplexMatrix::from_fn(n, 1, |i, _| b(i) * weight[i]));
    let largest = solved.norm_max();
    let mut x: Vec<Complex> = (0..n)
        .map(|i| solved[(i, 0)] / largest * weight[i])
        .collect();
    let length = x.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
    x.iter_mut().for_each(|x| *x /= length);
    x
}

/// The root of `a λ² + b λ + c = 0` nearer to `near`, with `a = yᵀx`, `b = yᵀCx`, `c = yᵀΩ²x`.
fn rayleigh(
    damping: &Matrix,
    squares: &[f64],
    y: &[Complex],
    x: &[Complex],
    near: Complex,
) -> Complex {
    let n = x.len();
    let a: Complex = (0..n).map(|i| y[i] * x[i]).sum();
    let b: Complex = (0..n)
        .map(|i| y[i] * (0..n).map(|j| x[j] * damping[(i, j)]).sum::<Complex>())
        .sum();
    let c: Complex = (0..n).map(|i| y[i] * x[i] * squares[i]).sum();
    let root = (b * b - 4.0 * a * c).sqrt();
    let sum = if (b + root).norm() >= (b - root).norm() {
        b + root
    } else {
        b - root
    };
    let (first, second) = (sum / a * -0.5, c / sum * -2.0);
    if (first - near).norm() < (second - near).norm() || second.is_nan() {
        first
    } else {
        second
    }
}

fn residual(c: &Matrix, squares: &[f64], value: Complex, x: &[Complex]) -> f64 {
    let n = x.len();
    let row = |i: usize| {
        let weight = 1.0 / value.norm().max(squares[i].abs().sqrt());
        let damped: Complex = (0..n).map(|j| x[j] * c[(i, j)]).sum();
        let damped_size: f64 = (0..n).map(|j| x[j].norm() * c[(i, j)].abs()).sum();
        let size = (value.norm_sqr() + squares[i].abs()) * x[i].norm() + value.norm() * damped_size;
        let off = (value * (value * x[i] + damped) + squares[i] * x[i]).norm();
        if size > 0.0 {
            (weight * off, weight * size)
        } else {
            (0.0, 0.0)
        }
    };
    let (off, size) = (0..n)
        .map(row)
        .fold((0.0, 0.0), |a: (f64, f64), b| (a.0.max(b.0), a.1.max(b.1)));
    if size > 0.0 { off / size } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start(n: usize, at: usize) -> Vec<Complex> {
        (0..n)
            .map(|i| Complex::new(if i == at { 1.0 } else { 0.01 }, 0.0))
            .collect()
    }

    /// Proportional damping: λ_i² + c_i λ_i + ω_i² = 0, whatever the others do; overdamped ones are real.
    #[test]
    fn exact_proportional_damping() {
        let (squares, damping) = ([1e-6, 4.0, 9e14], [1e-5, 50.0, 6e4]);
        let c = Matrix::from_fn(3, 3, |i, j| if i == j { damping[i] } else { 0.0 });
        let light = |i: usize| {
            Complex::new(
                -damping[i] / 2.0,
                (squares[i] - damping[i] * damping[i] / 4.0).sqrt(),
            )
        };
        let overdamped = Complex::new(-2.0 * 4.0 / (50.0 + 2484.0_f64.sqrt()), 0.0);
        for (i, exact) in [light(0), overdamped, light(2)].into_iter().enumerate() {
            let found = quadratic_refine(&c, &squares, exact * 1.02, &start(3, i)).unwrap();
            assert!(
                (found.value / exact - 1.0).norm() < 1e-15,
                "{i}: {} {exact}",
                found.value
            );
            assert!(found.residual < 1e-14 && found.steps < 8, "{found:?}");
        }
    }

    /// C with a gyroscopic part: the eigenvalue satisfies its equation to rounding, entry by entry.
    #[test]
    fn law_residual_without_symmetry() {
        let squares: [f64; 3] = [1.0, 1e6, 1e12];
        let c = Matrix::from_fn(3, 3, |i, j| {
            if i < j {
                3.0
            } else if i > j {
                -2.0
            } else {
                0.1
            }
        });
        for i in 0..3 {
            let guess = Complex::new(-0.05, squares[i].sqrt());
            let found = quadratic_refine(&c, &squares, guess, &start(3, i)).unwrap();
            assert!(found.residual < 1e-14, "{i}: {found:?}");
        }
    }

    #[test]
    fn survives_a_rigid_mode() {
        let found =
            quadratic_refine(&Matrix::zeros(1, 1), &[0.0], Complex::ZERO, &start(1, 0)).unwrap();
        assert_eq!((found.value, found.residual), (Complex::ZERO, 0.0));
    }

    #[test]
    fn refuses_what_is_not_a_number() {
        let error = quadratic_refine(
            &Matrix::zeros(1, 1),
            &[f64::NAN],
            Complex::ONE,
            &start(1, 0),
        )
        .unwrap_err();
        assert_eq!(error.code, Code::Overflow);
    }
}
