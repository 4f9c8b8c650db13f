//! Poly-reference least-squares complex frequency domain (pLSCF, PolyMAX): `H(ω) ≈ B(z) A(z)⁻¹`.
//!
//! Guillaume, Verboven, Vanlanduit, Van der Auweraer & Peeters, IMAC XXI (2003); Peeters, Van der Auweraer, Guillaume & Leuridan, Shock
//! and Vibration 11 (2004), 395–409. With the numerators eliminated there remains `M α → least`,
//! `M = Σ_o (T_o − S_oᵀ R⁻¹ S_o)`, whose leading blocks serve every lower order, so that one Cholesky factor solves all of them.
//!
//! Holding the lowest coefficient at the unit matrix, `α ∝ M⁻¹ E₀`, drives the poles that model noise out of the unit circle (Cauberghe,
//! Guillaume, Verboven, Vanlanduit & Parloo, Mech. Syst. Signal Process. 19 (2005), 989–1014), but noise then pulls the damping down.
//! Here `α ∝ M⁻ⁿ E₀` with n = `INVERSE_ITERATIONS`: inverse iteration towards the smallest eigenvalues, the directions that noise alone fills,
//! which keeps the first and mends most of the second.

use super::candidates::{
    CandidatePole, OrderPoles, half_power_band_is_inside, normalize_to_largest,
};
use super::lags::LagSums;
use super::measured_frf::MeasuredFrf;
use super::nested_cholesky::{NestedCholesky, add_ridge};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::eigen::eigenvalues;
use crate::numeric::symmetric::{
    cholesky, hermitian_eigen, lu_solve, solve_lower, solve_lower_transposed,
};
use crate::numeric::{Complex, ComplexMatrix, Matrix};

/// Steps of inverse iteration from the lowest coefficient.
pub const INVERSE_ITERATIONS: usize = 2;

/// Lines wanted for every coefficient of a polynomial.
const LINES_PER_COEFFICIENT: usize = 3;

/// Options of the pLSCF estimator.
#[derive(Debug, Clone, Copy, Default)]
pub struct PlscfOptions {
    /// Highest order of the denominator; each order holds half as many poles a band as it has inputs. `None`: 80 for one input, 160 over
    /// the inputs and not below 20 for several, and never more than a third of the lines.
    pub max_order: Option<usize>,
}

/// Poles of every second order (every order with several inputs) up to the highest.
///
/// Effort: a transform a response, a factor of side `inputs · order`, and an eigenproblem of that side an order.
///
/// # Errors
/// `TooShort` where the lines do not reach for two coefficients; `IllPosed` where the equations stay singular.
pub fn plscf(responses: &MeasuredFrf, options: &PlscfOptions) -> Result<Vec<OrderPoles>, Error> {
    let most = highest_order(responses, options)?;
    let fraction = ReducedNormalEquations::new(responses, most)?;
    let stride = if responses.n_inputs() == 1 { 2 } else { 1 };
    (2..=most)
        .step_by(stride)
        .map(|order| fraction.poles(order, responses.band_limits_hz()))
        .collect()
}

fn highest_order(responses: &MeasuredFrf, options: &PlscfOptions) -> Result<usize, Error> {
    let inputs = responses.n_inputs();
    let usual = if inputs == 1 {
        80
    } else {
        (160 / inputs).max(20)
    };
    let bearable = responses.n_lines() / LINES_PER_COEFFICIENT;
    match options.max_order {
        None => Ok(usual.min(bearable)),
        Some(order) if (2..=bearable).contains(&order) => Ok(order),
        Some(order) => Err(Error::new(
            Code::TooShort,
            format!(
                "order {order} cannot be fitted to {} lines",
                responses.n_lines()
            ),
        )
        .with_hint(format!("request an order from 2 to {bearable}"))),
    }
}

/// The reduced normal equations of the highest order.
struct ReducedNormalEquations<'a> {
    lags: LagSums<'a>,
    max_order: usize,
    inputs: usize,
    outputs: usize,
    /// Root mean square of each output and input, taken out so that units do not weigh.
    output_size: Vec<f64>,
    input_size: Vec<f64>,
    /// `S_o` of all outputs, one below the other.
    cross: Matrix,
    /// Cholesky factor of R.
    numerator: Matrix,
    /// M.
    denominator: NestedCholesky,
}

impl<'a> ReducedNormalEquations<'a> {
    fn new(responses: &MeasuredFrf<'a>, most: usize) -> Result<ReducedNormalEquations<'a>, Error> {
        let (inputs, outputs, n) = (
            responses.n_inputs(),
            responses.n_outputs(),
            responses.n_lines(),
        );
        let mut lags = LagSums::new(responses.frequency_hz(), most);
        let (output_size, input_size) = sizes(responses);
        let scaled = |o: usize, a: usize, k: usize| {
            responses.response(o, a)[k] / (output_size[o] * input_size[a])
        };
        let mean = |sums: Vec<f64>| -> Vec<f64> { sums.iter().map(|s| s / n as f64).collect() };
        let side = most + 1;
        let ones = mean(lags.sum(|_| Complex::ONE));
        let mut r = Matrix::from_fn(side, side, |j, k| ones[most + k - j]);
        add_ridge(&mut r);
        let numerator = cholesky(&r).map_err(|_| singular(most))?;

        let mut m = Matrix::zeros(inputs * side, inputs * side);
        for a in 0..inputs {
            for b in 0..inputs {
                let power = mean(lags.sum(|k| {
                    (0..outputs).fold(Complex::ZERO, |s, o| {
                        s + scaled(o, a, k).conj() * scaled(o, b, k)
                    })
                }));
                for k in 0..side {
                    for j in 0..side {
                        m[(j * inputs + a, k * inputs + b)] = power[most + k - j];
                    }
                }
            }
        }
        let mut cross = Matrix::zeros(outputs * side, inputs * side);
        for o in 0..outputs {
            for a in 0..inputs {
                let sums = mean(lags.sum(|k| scaled(o, a, k)));
                for k in 0..side {
                    for j in 0..side {
                        cross[(o * side + j, k * inputs + a)] = -sums[most + k - j];
                    }
                }
            }
            let block = cross.subrows(o * side, side).to_owned();
            let half = solve_lower(&numerator, &block);
            m -= half.transpose() * &half;
        }
        let denominator = NestedCholesky::new(m)?;
        Ok(ReducedNormalEquations {
            lags,
            max_order: most,
            inputs,
            outputs,
            output_size,
            input_size,
            cross,
            numerator,
            denominator,
        })
    }

    /// Poles of one order inside the band, left of the axis.
    fn poles(&self, order: usize, ends_hz: (f64, f64)) -> Result<OrderPoles, Error> {
        let alpha = self.coefficients(order);
        let mut found = Vec::new();
        let Some(companion) = companion(&alpha, self.inputs, order) else {
            return Ok(OrderPoles::new(order, found)); // no pole is determined where the leading coefficient vanishes
        };
        let beta = self.numerators(&alpha);
        for z in eigenvalues(&companion)? {
            let Some(pole) = self.lags.to_s_plane(z) else {
                continue;
            };
            if half_power_band_is_inside(pole, ends_hz) {
                found.push(self.candidate(z, pole, &alpha, &beta)?);
            }
        }
        Ok(OrderPoles::new(order, found))
    }

    /// α of one order: `M⁻ⁿ E₀` on the leading block, columns orthonormal.
    fn coefficients(&self, order: usize) -> Matrix {
        let n = self.inputs * (order + 1);
        let mut alpha = Matrix::identity(n, self.inputs);
        for _ in 0..INVERSE_ITERATIONS {
            for a in 0..self.inputs {
                let column = alpha.col_as_slice_mut(a);
                self.denominator.solve(column);
            }
            orthonormalise(&mut alpha);
        }
        alpha
    }

    /// `−R⁻¹ S_o α`, column `o · inputs + a`, rows by power of z.
    fn numerators(&self, alpha: &Matrix) -> Matrix {
        let side = self.max_order + 1;
        let product = self.cross.subcols(0, alpha.nrows()) * alpha;
        let stacked = Matrix::from_fn(side, self.outputs * self.inputs, |j, column| {
            -product[(column / self.inputs * side + j, column % self.inputs)]
        });
        solve_lower_transposed(&self.numerator, &solve_lower(&self.numerator, &stacked))
    }

    fn candidate(
        &self,
        z: Complex,
        pole: Complex,
        alpha: &Matrix,
        beta: &Matrix,
    ) -> Result<CandidatePole, Error> {
        let m = self.inputs;
        let powers: Vec<Complex> =
            std::iter::successors(Some(Complex::ONE), |power| Some(power * z))
                .take(self.max_order + 1)
                .collect();
        let sum = |from: &dyn Fn(usize) -> f64, terms: usize| {
            (0..terms).fold(Complex::ZERO, |s, j| s + powers[j] * from(j))
        };
        let (right, left) = if m == 1 {
            (vec![Complex::ONE], vec![Complex::ONE])
        } else {
            let terms = alpha.nrows() / m;
            let a = ComplexMatrix::from_fn(m, m, |i, k| sum(&|j| alpha[(j * m + i, k)], terms));
            let transposed = a.transpose().to_owned();
            (null_vector(&a)?, null_vector(&transposed)?)
        };
        let shape = (0..self.outputs).map(|o| {
            let part = |a: usize| sum(&|j| beta[(j, o * m + a)], self.max_order + 1) * right[a];
            (0..m).fold(Complex::ZERO, |s, a| s + part(a)) * self.output_size[o]
        });
        let participation = left.iter().zip(&self.input_size).map(|(w, size)| w * size);
        Ok(CandidatePole {
            pole,
            shape: normalize_to_largest(shape.collect()),
            participation: normalize_to_largest(participation.collect()),
        })
    }
}

/// Root mean squares by output, then by input of what is left.
fn sizes(responses: &MeasuredFrf) -> (Vec<f64>, Vec<f64>) {
    let power = |o: usize, a: usize| {
        let h = responses.response(o, a);
        h.iter().map(Complex::norm_sqr).sum::<f64>() / h.len() as f64
    };
    let (outputs, inputs) = (responses.n_outputs(), responses.n_inputs());
    let mean = |sum: f64, count: usize| (sum / count as f64).sqrt();
    let output: Vec<f64> = (0..outputs)
        .map(|o| mean((0..inputs).map(|a| power(o, a)).sum(), inputs))
        .collect();
    let input = (0..inputs)
        .map(|a| {
            let parts = (0..outputs).map(|o| power(o, a) / output[o].powi(2));
            mean(parts.sum(), outputs)
        })
        .collect();
    (output, input)
}

fn singular(order: usize) -> Error {
    Error::new(
        Code::IllPosed,
        format!("the normal equations of order {order} are singular"),
    )
    .with_hint("request a lower order or a wider band")
}

/// Gram–Schmidt, twice is enough; a column that vanishes stays.
fn orthonormalise(a: &mut Matrix) {
    for k in 0..a.ncols() {
        let length = a.col(k).norm_l2();
        if length > 0.0 {
            a.col_as_slice_mut(k).iter_mut().for_each(|x| *x /= length);
        }
        for _ in 0..2 {
            for before in 0..k {
                let other = a.col_as_slice(before).to_vec();
                let column = a.col_as_slice_mut(k);
                let part: f64 = column.iter().zip(&other).map(|(x, y)| x * y).sum();
                column
                    .iter_mut()
                    .zip(&other)
                    .for_each(|(x, y)| *x -= part * y);
            }
            let length = a.col(k).norm_l2();
            if length > 0.0 {
                a.col_as_slice_mut(k).iter_mut().for_each(|x| *x /= length);
            }
        }
    }
}

/// Block companion matrix of `Σ z^j α_j`; nothing where the leading block is singular.
fn companion(alpha: &Matrix, m: usize, order: usize) -> Option<Matrix> {
    let block = |j: usize| alpha.subrows(j * m, m).to_owned();
    let leading = block(order);
    let n = m * order;
    let mut companion = Matrix::zeros(n, n);
    (m..n).for_each(|i| companion[(i, i - m)] = 1.0);
    for j in 0..order {
        let top = lu_solve(&leading, &block(order - 1 - j)).ok()?;
        for a in 0..m {
            for b in 0..m {
                companion[(a, j * m + b)] = -top[(a, b)];
            }
        }
    }
    Some(companion)
}

/// The unit vector that `a` shortens most.
fn null_vector(a: &ComplexMatrix) -> Result<Vec<Complex>, Error> {
    let (_, vectors) = hermitian_eigen(&(a.adjoint() * a))?;
    Ok((0..a.ncols()).map(|i| vectors[(i, 0)]).collect())
}
