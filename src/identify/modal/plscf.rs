//! Poly-reference least-squares complex frequency domain (pLSCF, PolyMAX): `H(ω) ≈ B(z) A(z)⁻¹`.
//!
//! Guillaume, Verboven, Vanlanduit, Van der Auweraer & Peeters, IMAC XXI (2003); Peeters, Van der Auweraer, Guillaume & Leuridan, Shock
//! and Vibration 11 (2004), 395–409. Elimination of the numerators gives the reduced normal equations `M α = 0`,
//! `M = Σ_o (T_o − S_oᵀ R⁻¹ S_o)`; its leading blocks are those of every lower order, so one Cholesky factor solves all orders.
//!
//! The constraint that the lowest coefficient is the unit matrix, `α ∝ M⁻¹ E₀`, moves noise poles out of the unit circle (Cauberghe,
//! Guillaume, Verboven, Vanlanduit & Parloo, Mech. Syst. Signal Process. 19 (2005), 989–1014), but biases the damping low under noise.
//! Here `α ∝ M⁻ⁿ E₀` with n = `INVERSE_ITERATIONS`: inverse iteration towards the eigenvectors of the smallest eigenvalues, the noise
//! subspace, which keeps the separation of noise poles and removes most of the damping bias.

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

/// Number of inverse iterations from the lowest-coefficient constraint.
pub const INVERSE_ITERATIONS: usize = 2;

/// Minimum number of spectral lines per polynomial coefficient.
const LINES_PER_COEFFICIENT: usize = 3;

/// Options of the pLSCF estimator.
#[derive(Debug, Clone, Copy, Default)]
pub struct PlscfOptions {
    /// Highest order of the denominator polynomial; an order n has n/2 poles in the band per input. `None`: 80 for one input,
    /// max(160/inputs, 20) for several, at most a third of the number of lines.
    pub max_order: Option<usize>,
}

/// Candidate poles inside the band for every second model order (every order with several inputs) up to the highest.
///
/// Effort: one transform per response, one factorisation of dimension `inputs · order`, and one eigenproblem of that dimension per order.
///
/// # Errors
/// `TooShort` for an order with fewer than three lines per coefficient; `IllPosed` if the normal equations are singular.
pub fn plscf(responses: &MeasuredFrf, options: &PlscfOptions) -> Result<Vec<OrderPoles>, Error> {
    let max_order = highest_order(responses, options)?;
    let equations = ReducedNormalEquations::new(responses, max_order)?;
    let stride = if responses.n_inputs() == 1 { 2 } else { 1 };
    (2..=max_order)
        .step_by(stride)
        .map(|order| equations.poles(order, responses.band_limits_hz()))
        .collect()
}

fn highest_order(responses: &MeasuredFrf, options: &PlscfOptions) -> Result<usize, Error> {
    let inputs = responses.n_inputs();
    let default = if inputs == 1 {
        80
    } else {
        (160 / inputs).max(20)
    };
    let largest = responses.n_lines() / LINES_PER_COEFFICIENT;
    match options.max_order {
        None => Ok(default.min(largest)),
        Some(order) if (2..=largest).contains(&order) => Ok(order),
        Some(order) => Err(Error::new(
            Code::TooShort,
            format!(
                "order {order} cannot be fitted to {} lines",
                responses.n_lines()
            ),
        )
        .with_hint(format!("request an order from 2 to {largest}"))),
    }
}

/// Reduced normal equations of the highest order.
struct ReducedNormalEquations<'a> {
    lags: LagSums<'a>,
    max_order: usize,
    inputs: usize,
    outputs: usize,
    /// RMS of each output and input, by which the responses are normalised so that units have no weight.
    output_rms: Vec<f64>,
    input_rms: Vec<f64>,
    /// `S_o` of all outputs, stacked.
    cross: Matrix,
    /// Cholesky factor of R.
    numerator: Matrix,
    /// Cholesky factor of M.
    denominator: NestedCholesky,
}

impl<'a> ReducedNormalEquations<'a> {
    fn new(responses: &MeasuredFrf<'a>, max_order: usize) -> Result<Self, Error> {
        let (inputs, outputs, n) = (
            responses.n_inputs(),
            responses.n_outputs(),
            responses.n_lines(),
        );
        let mut lags = LagSums::new(responses.frequency_hz(), max_order);
        let (output_rms, input_rms) = channel_rms(responses);
        let scaled = |o: usize, a: usize, k: usize| {
            responses.response(o, a)[k] / (output_rms[o] * input_rms[a])
        };
        let mean = |sums: Vec<f64>| -> Vec<f64> { sums.iter().map(|s| s / n as f64).collect() };
        let side = max_order + 1;
        let ones = mean(lags.sum(|_| Complex::ONE));
        let mut r = Matrix::from_fn(side, side, |j, k| ones[max_order + k - j]);
        add_ridge(&mut r);
        let numerator = cholesky(&r).map_err(|_| singular(max_order))?;

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
                        m[(j * inputs + a, k * inputs + b)] = power[max_order + k - j];
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
                        cross[(o * side + j, k * inputs + a)] = -sums[max_order + k - j];
                    }
                }
            }
            let block = cross.subrows(o * side, side).to_owned();
            let reduced = solve_lower(&numerator, &block);
            m -= reduced.transpose() * &reduced;
        }
        let denominator = NestedCholesky::new(m)?;
        Ok(ReducedNormalEquations {
            lags,
            max_order,
            inputs,
            outputs,
            output_rms,
            input_rms,
            cross,
            numerator,
            denominator,
        })
    }

    /// Stable poles of one order inside the band limits, Hz.
    fn poles(&self, order: usize, band_hz: (f64, f64)) -> Result<OrderPoles, Error> {
        let alpha = self.coefficients(order);
        let mut poles = Vec::new();
        let Some(companion) = companion(&alpha, self.inputs, order) else {
            return Ok(OrderPoles::new(order, poles)); // no pole is determined where the leading coefficient vanishes
        };
        let beta = self.numerators(&alpha);
        for z in eigenvalues(&companion)? {
            let Some(pole) = self.lags.to_s_plane(z) else {
                continue;
            };
            if half_power_band_is_inside(pole, band_hz) {
                poles.push(self.candidate(z, pole, &alpha, &beta)?);
            }
        }
        Ok(OrderPoles::new(order, poles))
    }

    /// Denominator coefficients α of one order: `M⁻ⁿ E₀` on the leading block, with orthonormal columns.
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

    /// Numerator coefficients `−R⁻¹ S_o α` in column `o · inputs + a`, rows by power of z.
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
        let series = |coefficient: &dyn Fn(usize) -> f64, terms: usize| {
            (0..terms).fold(Complex::ZERO, |s, j| s + powers[j] * coefficient(j))
        };
        let (right, left) = if m == 1 {
            (vec![Complex::ONE], vec![Complex::ONE])
        } else {
            let terms = alpha.nrows() / m;
            let a = ComplexMatrix::from_fn(m, m, |i, k| series(&|j| alpha[(j * m + i, k)], terms));
            let transposed = a.transpose().to_owned();
            (null_vector(&a)?, null_vector(&transposed)?)
        };
        let shape = (0..self.outputs).map(|o| {
            let term = |a: usize| series(&|j| beta[(j, o * m + a)], self.max_order + 1) * right[a];
            (0..m).fold(Complex::ZERO, |s, a| s + term(a)) * self.output_rms[o]
        });
        let participation = left.iter().zip(&self.input_rms).map(|(w, rms)| w * rms);
        Ok(CandidatePole {
            pole,
            shape: normalize_to_largest(shape.collect()),
            participation: normalize_to_largest(participation.collect()),
        })
    }
}

/// RMS by output, and by input after normalisation by output.
fn channel_rms(responses: &MeasuredFrf) -> (Vec<f64>, Vec<f64>) {
    let power = |o: usize, a: usize| {
        let h = responses.response(o, a);
        h.iter().map(Complex::norm_sqr).sum::<f64>() / h.len() as f64
    };
    let (outputs, inputs) = (responses.n_outputs(), responses.n_inputs());
    let rms = |sum: f64, count: usize| (sum / count as f64).sqrt();
    let output: Vec<f64> = (0..outputs)
        .map(|o| rms((0..inputs).map(|a| power(o, a)).sum(), inputs))
        .collect();
    let input = (0..inputs)
        .map(|a| {
            let normalised = (0..outputs).map(|o| power(o, a) / output[o].powi(2));
            rms(normalised.sum(), outputs)
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

/// Orthonormalises the columns by Gram–Schmidt with reorthogonalisation; a zero column stays zero.
fn orthonormalise(a: &mut Matrix) {
    for k in 0..a.ncols() {
        let length = a.col(k).norm_l2();
        if length > 0.0 {
            a.col_as_slice_mut(k).iter_mut().for_each(|x| *x /= length);
        }
        for _ in 0..2 {
            for j in 0..k {
                let previous = a.col_as_slice(j).to_vec();
                let column = a.col_as_slice_mut(k);
                let projection: f64 = column.iter().zip(&previous).map(|(x, y)| x * y).sum();
                column
                    .iter_mut()
                    .zip(&previous)
                    .for_each(|(x, y)| *x -= projection * y);
            }
            let length = a.col(k).norm_l2();
            if length > 0.0 {
                a.col_as_slice_mut(k).iter_mut().for_each(|x| *x /= length);
            }
        }
    }
}

/// Block companion matrix of `Σ z^j α_j`; `None` if the leading coefficient is singular.
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

/// Right singular vector of the smallest singular value of `a`.
fn null_vector(a: &ComplexMatrix) -> Result<Vec<Complex>, Error> {
    let (_, vectors) = hermitian_eigen(&(a.adjoint() * a))?;
    Ok((0..a.ncols()).map(|i| vectors[(i, 0)]).collect())
}
