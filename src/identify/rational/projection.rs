//! Variable projection (Golub & Pereyra 1973): `χ² = Σ |Y − Q Qᵀ Y|²` over the poles, by Levenberg–Marquardt with Kaufman's Jacobian.
//!
//! All responses share one QR and one Gram matrix of the derivatives.

use std::borrow::Borrow;

use crate::numeric::symmetric::{cholesky, solve_lower, solve_lower_transposed};
use crate::numeric::thin_qr::{ThinQr, sub_product, thin_qr, transposed_product};
use crate::numeric::{Complex, Matrix, registers};

use super::basis::{ScaledPole, WhitenedProblem};

/// Nonlinear parameters: poles and delays, in units of the angular frequency of the highest line and its inverse.
#[derive(Debug, Clone, Default)]
pub(super) struct PoleModel {
    /// Pole pairs.
    pub poles: Vec<ScaledPole>,
    /// Delays: none, one for all responses, or one per response.
    pub delays: Vec<f64>,
}

/// Linear least-squares fit of one problem at given poles.
#[derive(Debug, Clone)]
pub(super) struct LinearFit {
    /// QR factors of the basis with normalised columns.
    pub qr: ThinQr,
    /// Norms of the columns before normalisation.
    pub column_norms: Vec<f64>,
    /// Coefficients of the normalised columns, one column per response.
    pub c: Matrix,
    /// Whitened residual, one column per response.
    pub e: Matrix,
    /// `Σ e²` plus the energy of the omitted lines.
    pub chi2: f64,
}

/// Residual relative to the data (in squares) below which the projection is repeated to remove the rounding of the first.
const REPROJECT_SHARE: f64 = 1e-8;

/// Projects the data of a problem on the basis of a model.
pub(super) fn project(
    problem: &WhitenedProblem,
    model: &PoleModel,
    numerators: usize,
) -> LinearFit {
    let mut x = problem.basis(&model.poles, numerators);
    let column_norms: Vec<f64> = (0..x.ncols())
        .map(|j| {
            let column = x.col_as_slice_mut(j);
            let norm = column.iter().map(|v| v * v).sum::<f64>().sqrt();
            let norm = if norm > 0.0 { norm } else { 1.0 };
            column.iter_mut().for_each(|v| *v /= norm);
            norm
        })
        .collect();
    let qr = thin_qr(&x);
    let y = compensate_delays(problem, model);
    let y = y.as_ref().unwrap_or(&problem.y);
    let coefficients = transposed_product(&qr.q, y);
    let mut e = sub_product(y, &qr.q, &coefficients);
    let mut projections = coefficients;
    let mut squares = sum_of_squares(&e);
    if squares < REPROJECT_SHARE * sum_of_squares(&projections) {
        let correction = transposed_product(&qr.q, &e);
        e = sub_product(&e, &qr.q, &correction);
        projections += correction;
        squares = sum_of_squares(&e);
    }
    let c = qr.solve(&projections);
    let chi2 = problem.omitted_energy + squares;
    LinearFit {
        qr,
        column_norms,
        c,
        e,
        chi2,
    }
}

/// Squared Frobenius norm `Σ a²`.
pub(super) fn sum_of_squares(a: &Matrix) -> f64 {
    (0..a.ncols())
        .map(|i| a.col_as_slice(i).iter().map(|v| v * v).sum::<f64>())
        .sum()
}

/// Residual of the data of a problem with the coefficients of a fit to fewer lines.
pub(super) fn residual(
    problem: &WhitenedProblem,
    model: &PoleModel,
    numerators: usize,
    fit: &LinearFit,
) -> Matrix {
    let basis = problem.basis(&model.poles, numerators);
    let c = Matrix::from_fn(fit.c.nrows(), fit.c.ncols(), |row, i| {
        fit.c[(row, i)] / fit.column_norms[row]
    });
    let y = compensate_delays(problem, model);
    let residual = sub_product(y.as_ref().unwrap_or(&problem.y), &basis, &c);
    registers::zero_upper();
    residual
}

/// Data compensated for the delays, `Y e^{jxτ}`; `None` without delays.
fn compensate_delays(problem: &WhitenedProblem, model: &PoleModel) -> Option<Matrix> {
    if model.delays.is_empty() {
        return None;
    }
    let n = problem.lines();
    let mut y = problem.y.clone();
    for i in 0..y.ncols() {
        let delay = model.delays[(problem.first + i).min(model.delays.len() - 1)];
        let column = y.col_as_slice_mut(i);
        for k in 0..n {
            let (sin, cos) = (problem.x[k] * delay).sin_cos();
            let z = Complex::new(column[k], column[n + k]) * Complex::new(cos, sin);
            super::basis::set_complex(column, k, n, z);
        }
    }
    Some(y)
}

/// Gauss–Newton equations: half the Hessian and half the gradient of χ², over `(w/σ, ln σ)` of every pole, then the delays.
#[derive(Debug, Clone)]
pub(super) struct GaussNewtonEquations {
    /// `JᵀJ`.
    pub a: Matrix,
    /// `JᵀE`.
    pub g: Vec<f64>,
}

/// Gauss–Newton equations summed over all problems.
pub(super) fn normal_equations(
    problems: &[impl Borrow<WhitenedProblem>],
    model: &PoleModel,
    numerators: usize,
    fits: &[LinearFit],
) -> GaussNewtonEquations {
    let size = 2 * model.poles.len() + model.delays.len();
    let mut sum = GaussNewtonEquations {
        a: Matrix::zeros(size, size),
        g: vec![0.0; size],
    };
    for (problem, fit) in problems.iter().zip(fits) {
        add_poles(problem.borrow(), model, numerators, fit, &mut sum);
    }
    sum
}

fn add_poles(
    problem: &WhitenedProblem,
    model: &PoleModel,
    numerators: usize,
    fit: &LinearFit,
    sum: &mut GaussNewtonEquations,
) {
    let d = problem.derivatives(&model.poles, numerators, &fit.column_norms);
    let gram = gram(&d, fit);
    let slope = transposed_product(&d, &fit.e);
    add_responses(model.poles.len(), numerators, &gram, &slope, &fit.c, sum);
    if !model.delays.is_empty() {
        add_delays(problem, model, numerators, fit, &d, sum);
    }
}

/// Gram matrix of the derivatives after projecting out the basis.
fn gram(d: &Matrix, fit: &LinearFit) -> Matrix {
    let in_span = transposed_product(&fit.qr.q, d);
    transposed_product(d, d) - transposed_product(&in_span, &in_span)
}

/// Gauss–Newton equations of each group of responses of a problem, without delays.
pub(super) fn normal_by_group(
    problem: &WhitenedProblem,
    model: &PoleModel,
    numerators: usize,
    fit: &LinearFit,
    groups: &[Vec<usize>],
) -> Vec<GaussNewtonEquations> {
    let size = 2 * model.poles.len();
    let d = problem.derivatives(&model.poles, numerators, &fit.column_norms);
    let gram = gram(&d, fit);
    let slope = transposed_product(&d, &fit.e);
    let select_columns = |m: &Matrix, group: &[usize]| {
        Matrix::from_fn(m.nrows(), group.len(), |row, i| m[(row, group[i])])
    };
    let equations = |group: &Vec<usize>| {
        let mut sum = GaussNewtonEquations {
            a: Matrix::zeros(size, size),
            g: vec![0.0; size],
        };
        let (slope, c) = (select_columns(&slope, group), select_columns(&fit.c, group));
        add_responses(size / 2, numerators, &gram, &slope, &c, &mut sum);
        sum
    };
    groups.iter().map(equations).collect()
}

/// Adds the equations of `np` poles for responses with coefficients `c`.
fn add_responses(
    np: usize,
    numerators: usize,
    gram: &Matrix,
    slope: &Matrix,
    c: &Matrix,
    sum: &mut GaussNewtonEquations,
) {
    let no = c.ncols();
    let products = c * c.transpose();
    for p in 0..2 * np {
        for b in 0..numerators {
            let row = (p / 2) * numerators + b;
            let at = p * numerators + b;
            sum.g[p] -= (0..no).map(|i| c[(row, i)] * slope[(at, i)]).sum::<f64>();
        }
    }
    for p2 in 0..2 * np {
        let to = sum.a.col_as_slice_mut(p2);
        for b2 in 0..numerators {
            let gram = gram.col_as_slice(p2 * numerators + b2);
            let products = products.col_as_slice((p2 / 2) * numerators + b2);
            for (p, to) in to[..2 * np].iter_mut().enumerate() {
                for b in 0..numerators {
                    *to += gram[p * numerators + b] * products[(p / 2) * numerators + b];
                }
            }
        }
    }
}

/// Adds the equations of the delays: `∂E_i/∂τ_i = P⊥ (jx Ŷ_i)`.
fn add_delays(
    problem: &WhitenedProblem,
    model: &PoleModel,
    numerators: usize,
    fit: &LinearFit,
    d: &Matrix,
    sum: &mut GaussNewtonEquations,
) {
    let np = model.poles.len();
    let n = problem.lines();
    let mut derivatives = &fit.qr.q * (&fit.qr.r * &fit.c);
    for i in 0..derivatives.ncols() {
        let column = derivatives.col_as_slice_mut(i);
        for k in 0..n {
            let z = Complex::new(column[k], column[n + k]) * Complex::new(0.0, problem.x[k]);
            super::basis::set_complex(column, k, n, z);
        }
    }
    let projections = transposed_product(&fit.qr.q, &derivatives);
    let derivatives = sub_product(&derivatives, &fit.qr.q, &projections);
    let cross = transposed_product(d, &derivatives);
    for i in 0..derivatives.ncols() {
        let at = 2 * np + (problem.first + i).min(model.delays.len() - 1);
        let column = derivatives.col_as_slice(i);
        sum.a[(at, at)] += column.iter().map(|v| v * v).sum::<f64>();
        let e = fit.e.col_as_slice(i);
        sum.g[at] += column.iter().zip(e).map(|(a, b)| a * b).sum::<f64>();
        for p in 0..2 * np {
            let value: f64 = (0..numerators)
                .map(|b| fit.c[((p / 2) * numerators + b, i)] * cross[(p * numerators + b, i)])
                .sum();
            sum.a[(at, p)] -= value;
            sum.a[(p, at)] -= value;
        }
    }
}

/// Termination criteria of the refinement.
#[derive(Debug, Clone, Copy)]
pub(super) struct StopCriteria {
    /// Maximum number of steps.
    pub steps: usize,
    /// Predicted decrease of χ² below which the iteration ends.
    pub min_decrease: f64,
    /// Predicted decrease relative to χ² below which the iteration ends.
    pub min_relative_decrease: f64,
}

/// Pole model with its linear fits.
#[derive(Debug, Clone)]
pub(super) struct ModelFit {
    /// Poles and delays.
    pub model: PoleModel,
    /// Linear fits, one per problem.
    pub fits: Vec<LinearFit>,
    /// χ² summed over the problems.
    pub chi2: f64,
    /// Number of trial steps.
    pub steps: usize,
}

/// Linear fit at a fixed pole model.
pub(super) fn fit_at(
    problems: &[impl Borrow<WhitenedProblem>],
    model: &PoleModel,
    numerators: usize,
) -> ModelFit {
    let fits: Vec<LinearFit> = problems
        .iter()
        .map(|p| project(p.borrow(), model, numerators))
        .collect();
    ModelFit {
        model: model.clone(),
        chi2: fits.iter().map(|f| f.chi2).sum(),
        fits,
        steps: 0,
    }
}

/// Initial Levenberg–Marquardt damping, and its factors after an accepted and a rejected step.
const DAMPING: (f64, f64, f64) = (1e-3, 0.1, 8.0);

/// Damping above which steps are negligible and the iteration ends.
const MAX_DAMPING: f64 = 1e10;

/// Refines poles and delays to a local minimum of χ² by Levenberg–Marquardt.
pub(super) fn refine(
    problems: &[impl Borrow<WhitenedProblem>],
    start: ModelFit,
    numerators: usize,
    criteria: StopCriteria,
) -> ModelFit {
    let mut best = start;
    if best.model.poles.is_empty() && best.model.delays.is_empty() {
        return best;
    }
    let mut damping = DAMPING.0;
    let mut n_steps = 0;
    'outer: while n_steps < criteria.steps {
        let normal = normal_equations(problems, &best.model, numerators, &best.fits);
        loop {
            let Some((step, decrease)) = step(&normal, damping) else {
                damping *= DAMPING.2;
                if damping > MAX_DAMPING {
                    break 'outer;
                }
                continue;
            };
            if decrease
                < criteria
                    .min_decrease
                    .max(criteria.min_relative_decrease * best.chi2)
            {
                break 'outer;
            }
            let next = fit_at(problems, &apply_step(&best.model, &step), numerators);
            n_steps += 1;
            if next.chi2 < best.chi2 {
                best = ModelFit { steps: 0, ..next };
                damping = (damping * DAMPING.1).max(1e-12);
                break;
            }
            damping *= DAMPING.2;
            if damping > MAX_DAMPING || n_steps >= criteria.steps {
                break 'outer;
            }
        }
    }
    best.steps = n_steps;
    best
}

/// Undamped Gauss–Newton step from a fit, over `(w/σ, ln σ)` of every pole, then the delays; `None` if the equations are singular.
pub(super) fn step_to(
    problems: &[impl Borrow<WhitenedProblem>],
    fit: &ModelFit,
    numerators: usize,
) -> Option<Vec<f64>> {
    let normal = normal_equations(problems, &fit.model, numerators, &fit.fits);
    step(&normal, 0.0).map(|(step, _)| step)
}

/// Damped step and its predicted decrease of χ²; `None` if the equations are singular.
fn step(normal: &GaussNewtonEquations, damping: f64) -> Option<(Vec<f64>, f64)> {
    let n = normal.g.len();
    let scale: Vec<f64> = (0..n)
        .map(|i| {
            if normal.a[(i, i)] > 0.0 {
                1.0 / normal.a[(i, i)].sqrt()
            } else {
                0.0
            }
        })
        .collect();
    let damped = Matrix::from_fn(n, n, |i, j| {
        let value = normal.a[(i, j)] * scale[i] * scale[j];
        if i == j { 1.0 + damping } else { value }
    });
    let rhs = Matrix::from_fn(n, 1, |i, _| -normal.g[i] * scale[i]);
    let l = cholesky(&damped).ok()?;
    let solution = solve_lower_transposed(&l, &solve_lower(&l, &rhs));
    let step: Vec<f64> = (0..n).map(|i| solution[(i, 0)] * scale[i]).collect();
    let mut decrease = 0.0;
    for i in 0..n {
        decrease -= 2.0 * normal.g[i] * step[i];
        decrease -= (0..n)
            .map(|j| step[i] * normal.a[(i, j)] * step[j])
            .sum::<f64>();
    }
    decrease.is_finite().then_some((step, decrease))
}

/// Ranges of the frequencies and real parts of poles, in units of the highest line.
const FREQUENCY_RANGE: (f64, f64) = (1e-6, 4.0);
const REAL_PART_RANGE: (f64, f64) = (1e-13, 8.0);

/// Applies a step, limited to one half-width in frequency and a factor e in damping for each pole.
fn apply_step(model: &PoleModel, step: &[f64]) -> PoleModel {
    let np = model.poles.len();
    let poles = model
        .poles
        .iter()
        .enumerate()
        .map(|(r, pole)| {
            let scale = step[2 * r].abs().max(step[2 * r + 1].abs()).max(1.0);
            let (dw, ds) = (step[2 * r] / scale, step[2 * r + 1] / scale);
            ScaledPole {
                w: (pole.w + pole.sigma * dw)
                    .max(0.5 * pole.w)
                    .clamp(FREQUENCY_RANGE.0, FREQUENCY_RANGE.1),
                sigma: (pole.sigma * ds.exp()).clamp(REAL_PART_RANGE.0, REAL_PART_RANGE.1),
                stable: pole.stable,
            }
        })
        .collect();
    let delays = model
        .delays
        .iter()
        .zip(&step[2 * np..])
        .map(|(d, s)| d + s.clamp(-1.0, 1.0))
        .collect();
    PoleModel { poles, delays }
}
