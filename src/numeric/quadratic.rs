//! Quadratic eigenproblem `(λ²J + λC + K + i sgn(Im λ) H) x = 0`: refinement of simple eigenvalues.
//!
//! Inverse iteration on both sides with the Rayleigh functional `yᵀ Q(λ) x = 0`: Schwetlick & Schreiber,
//! Nonlinear Rayleigh functionals, Linear Algebra Appl. 436 (2012), pp. 3991–4016; Lancaster, Lambda-matrices and
//! vibrating systems (1966), §5.4. Rows and columns are scaled by the magnitude of the diagonal at λ, which removes the
//! grading, so that small eigenvalues are relatively accurate, as they are not in a linearisation.

use faer::linalg::solvers::{PartialPivLu, Solve};

use crate::base::code::Code;
use crate::base::error::Error;

use super::{Complex, ComplexMatrix, Matrix, registers};

/// Quadratic eigenproblem with symmetric or unsymmetric C and K.
#[derive(Debug, Clone)]
pub struct QuadraticEigenproblem {
    /// Number of leading coordinates with unit inertia; the others have none.
    pub n_inertial: usize,
    /// Damping matrix C, including gyroscopic terms.
    pub damping: Matrix,
    /// Stiffness matrix K.
    pub stiffness: Matrix,
    /// Hysteretic damping matrix H of loss factors; its sign is that of Im λ, and it vanishes for real eigenvalues.
    pub hysteretic: Option<Matrix>,
}

/// Eigenvalue with right and left eigenvectors.
#[derive(Debug, Clone)]
pub struct QuadraticEigenpair {
    /// Eigenvalue λ, 1/s.
    pub value: Complex,
    /// Right eigenvector x, of length one.
    pub right: Vec<Complex>,
    /// Left eigenvector y, `yᵀ Q(λ) = 0`, of length one.
    pub left_vector: Vec<Complex>,
    /// Backward error `max w_i |(Q x)_i| / max w_i (|Q| |x|)_i` with weights w of the scaled problem.
    pub residual: f64,
    /// Iterations, one factorisation each.
    pub steps: usize,
}

impl QuadraticEigenproblem {
    /// Order of the problem.
    pub fn len(&self) -> usize {
        self.damping.nrows()
    }

    /// Whether the problem has no coordinate.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Refines an eigenvalue and its right eigenvector by two-sided Rayleigh-quotient iteration.
    ///
    /// The iteration converges to an eigenvalue near the start, usually the nearest; an inaccurate start may yield another.
    /// λ = 0, exact for rigid motion, is returned unchanged.
    ///
    /// # Errors
    /// `NoConvergence` with the last change of λ; `Overflow` beyond the range of doubles.
    pub fn polish(&self, value: Complex, vector: &[Complex]) -> Result<QuadraticEigenpair, Error> {
        let n = self.len();
        let (mut value, mut right) = (value, vector.to_vec());
        // The left vector starts from the conjugate: `xᵀx` of a whirling shape is zero.
        let mut left: Vec<Complex> = vector.iter().map(Complex::conj).collect();
        let mut last = f64::INFINITY;
        for steps in 0..=MAX_STEPS {
            if value.norm() == 0.0 || n == 0 || last <= CONVERGENCE_TOLERANCE {
                let residual = self.residual(value, &right);
                return Ok(QuadraticEigenpair {
                    value,
                    right,
                    left_vector: left,
                    residual,
                    steps,
                });
            }
            let weight = self.weights(value);
            let factor = self.factorise(value, &weight);
            let right_rhs = self.derivative_times(value, &right, false);
            right = inverse_step(&weight, &right_rhs, |b| factor.solve(b));
            let left_rhs = self.derivative_times(value, &left, true);
            left = inverse_step(&weight, &left_rhs, |b| factor.solve_transpose(b));
            let next = self.rayleigh(&left, &right, value);
            let change = (next - value).norm() / value.norm();
            if !change.is_finite() {
                let message = format!("polishing λ = {value} 1/s overflowed");
                return Err(Error::new(Code::Overflow, message));
            }
            // Rounding may limit the change of λ to a few ε; a change that no longer decreases has converged.
            last = if change < STAGNATION_TOLERANCE && change >= last {
                0.0
            } else {
                change
            };
            value = next;
        }
        let message = format!("root near {value} 1/s did not converge: relative change {last:.1e}");
        Err(Error::new(Code::NoConvergence, message))
    }

    /// Relative condition number of the eigenvalue for componentwise perturbations: `|yᵀ| |Q| |x| / (|λ| |yᵀ Q′ x|)`.
    pub fn condition(&self, root: &QuadraticEigenpair) -> f64 {
        let slope = self.derivative_times(root.value, &root.right, false);
        let denominator: Complex = root
            .left_vector
            .iter()
            .zip(&slope)
            .map(|(y, s)| y * s)
            .sum();
        let size = self.term_magnitudes(root.value, &root.right);
        let numerator: f64 = root
            .left_vector
            .iter()
            .zip(&size)
            .map(|(y, s)| y.norm() * s)
            .sum();
        numerator / (root.value.norm() * denominator.norm())
    }

    /// Derivative `Q′(λ) x = (2λ J + C) x`, or that of the transpose of Q.
    pub fn derivative_times(
        &self,
        value: Complex,
        x: &[Complex],
        transposed: bool,
    ) -> Vec<Complex> {
        let c = |i: usize, j: usize| {
            if transposed {
                self.damping[(j, i)]
            } else {
                self.damping[(i, j)]
            }
        };
        (0..self.len())
            .map(|i| {
                let damped: Complex = (0..self.len()).map(|j| x[j] * c(i, j)).sum();
                if i < self.n_inertial {
                    damped + value * x[i] * 2.0
                } else {
                    damped
                }
            })
            .collect()
    }

    fn entry(&self, value: Complex, i: usize, j: usize) -> Complex {
        let mut entry = value * self.damping[(i, j)] + self.stiffness[(i, j)];
        if let Some(h) = &self.hysteretic {
            entry += Complex::new(0.0, h[(i, j)] * sign(value));
        }
        if i == j && i < self.n_inertial {
            entry + value * value
        } else {
            entry
        }
    }

    /// Row sums of term magnitudes, `|Q|(|λ|) |x|`.
    fn term_magnitudes(&self, value: Complex, x: &[Complex]) -> Vec<f64> {
        let size = value.norm();
        let entry = |i: usize, j: usize| {
            let h = self.hysteretic.as_ref().map_or(0.0, |h| h[(i, j)].abs());
            let entry = size * self.damping[(i, j)].abs() + self.stiffness[(i, j)].abs() + h;
            if i == j && i < self.n_inertial {
                entry + size * size
            } else {
                entry
            }
        };
        (0..self.len())
            .map(|i| (0..self.len()).map(|j| entry(i, j) * x[j].norm()).sum())
            .collect()
    }

    fn weights(&self, value: Complex) -> Vec<f64> {
        let size = value.norm();
        let weight = |i: usize| {
            let damped = size * self.damping[(i, i)].abs();
            let inertia = if i < self.n_inertial {
                size * size
            } else {
                0.0
            };
            let diag = inertia.max(damped).max(self.stiffness[(i, i)].abs());
            if diag > 0.0 { 1.0 / diag.sqrt() } else { 1.0 }
        };
        (0..self.len()).map(weight).collect()
    }

    /// LU factors of the scaled matrix; a pivot of exactly zero is avoided by shifting λ by ε.
    fn factorise(&self, value: Complex, weight: &[f64]) -> PartialPivLu<Complex> {
        let n = self.len();
        let factor_at = |value: Complex| {
            let entry = |i: usize, j: usize| self.entry(value, i, j) * weight[i] * weight[j];
            let factor = ComplexMatrix::from_fn(n, n, entry).partial_piv_lu();
            registers::zero_upper();
            factor
        };
        let factor = factor_at(value);
        let is_singular = (0..n).any(|i| factor.U()[(i, i)].norm() == 0.0);
        if is_singular {
            factor_at(value * (1.0 + 4.0 * f64::EPSILON))
        } else {
            factor
        }
    }

    /// Rayleigh functional: the root of `a λ² + b λ + c = 0` nearer to `near`, with `a = yᵀJx`, `b = yᵀCx`, `c = yᵀ(K + i sgn H)x`.
    fn rayleigh(&self, y: &[Complex], x: &[Complex], near: Complex) -> Complex {
        let n = self.len();
        let form = |m: &Matrix| -> Complex {
            (0..n)
                .map(|i| y[i] * (0..n).map(|j| x[j] * m[(i, j)]).sum::<Complex>())
                .sum()
        };
        let a: Complex = (0..self.n_inertial).map(|i| y[i] * x[i]).sum();
        let b = form(&self.damping);
        let h = self.hysteretic.as_ref().map_or(Complex::ZERO, &form);
        let c = form(&self.stiffness) + h * Complex::new(0.0, sign(near));
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

    /// Backward error of an eigenpair, `max w_i |(Q x)_i| / max w_i (|Q| |x|)_i`.
    pub fn residual(&self, value: Complex, x: &[Complex]) -> f64 {
        let weight = self.weights(value);
        let size = self.term_magnitudes(value, x);
        let row_residual = |i: usize| {
            (0..self.len())
                .map(|j| self.entry(value, i, j) * x[j])
                .sum::<Complex>()
                .norm()
        };
        let worst = (0..self.len())
            .map(|i| weight[i] * row_residual(i))
            .fold(0.0, f64::max);
        let scale = (0..self.len())
            .map(|i| weight[i] * size[i])
            .fold(0.0, f64::max);
        if scale > 0.0 { worst / scale } else { 0.0 }
    }
}

const MAX_STEPS: usize = 20; // cubic convergence: 3 or 4 from a start with two correct digits
const CONVERGENCE_TOLERANCE: f64 = 2.0 * f64::EPSILON;
const STAGNATION_TOLERANCE: f64 = 1e-10; // relative change of λ below which cubic convergence is over in one step

fn sign(value: Complex) -> f64 {
    if value.im == 0.0 {
        0.0
    } else {
        value.im.signum()
    }
}

/// Inverse iteration step `D S⁻¹ D b`, normalised to length one.
fn inverse_step(
    weight: &[f64],
    b: &[Complex],
    solve: impl Fn(&ComplexMatrix) -> ComplexMatrix,
) -> Vec<Complex> {
    let n = weight.len();
    let solved = solve(&ComplexMatrix::from_fn(n, 1, |i, _| b[i] * weight[i]));
    registers::zero_upper();
    let largest = solved.norm_max();
    let mut x: Vec<Complex> = (0..n)
        .map(|i| solved[(i, 0)] / largest * weight[i])
        .collect();
    let length = x.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
    x.iter_mut().for_each(|x| *x /= length);
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn undamped(squares: &[f64], damping: Matrix) -> QuadraticEigenproblem {
        let n = squares.len();
        let stiffness = Matrix::from_fn(n, n, |i, j| if i == j { squares[i] } else { 0.0 });
        QuadraticEigenproblem {
            n_inertial: n,
            damping,
            stiffness,
            hysteretic: None,
        }
    }

    fn start(n: usize, at: usize) -> Vec<Complex> {
        (0..n)
            .map(|i| Complex::new(if i == at { 1.0 } else { 0.01 }, 0.0))
            .collect()
    }

    /// Proportional damping: λ_i² + c_i λ_i + ω_i² = 0 for every mode; overdamped eigenvalues are real.
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
            let found = undamped(&squares, c.clone())
                .polish(exact * 1.02, &start(3, i))
                .unwrap();
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
            let found = undamped(&squares, c.clone())
                .polish(guess, &start(3, i))
                .unwrap();
            assert!(found.residual < 1e-14, "{i}: {found:?}");
        }
    }

    #[test]
    fn survives_a_rigid_mode() {
        let found = undamped(&[0.0], Matrix::zeros(1, 1))
            .polish(Complex::ZERO, &start(1, 0))
            .unwrap();
        assert_eq!((found.value, found.residual), (Complex::ZERO, 0.0));
    }

    #[test]
    fn refuses_what_is_not_a_number() {
        let error = undamped(&[f64::NAN], Matrix::zeros(1, 1))
            .polish(Complex::ONE, &start(1, 0))
            .unwrap_err();
        assert_eq!(error.code, Code::Overflow);
    }

    /// One spring with a loss factor: λ² = −ω² (1 + iη).
    #[test]
    fn exact_loss_factor() {
        let (squares, eta) = (400.0, 0.1);
        let mut problem = undamped(&[squares], Matrix::zeros(1, 1));
        problem.hysteretic = Some(Matrix::from_fn(1, 1, |_, _| eta * squares));
        let exact = (Complex::new(-squares, -eta * squares)).sqrt();
        let exact = if exact.im < 0.0 { -exact } else { exact };
        let found = problem
            .polish(Complex::new(0.0, 20.0), &start(1, 0))
            .unwrap();
        assert!(
            (found.value - exact).norm() < 1e-14 * 20.0,
            "{} {exact}",
            found.value
        );
        assert!(found.value.re < 0.0);
    }

    /// A coordinate without inertia on a damper: the root is −k/c.
    #[test]
    fn exact_without_inertia() {
        let mut problem = undamped(&[8.0], Matrix::from_fn(1, 1, |_, _| 2.0));
        problem.n_inertial = 0;
        let found = problem
            .polish(Complex::new(-3.5, 0.0), &start(1, 0))
            .unwrap();
        assert_eq!(found.value, Complex::new(-4.0, 0.0));
    }
}
