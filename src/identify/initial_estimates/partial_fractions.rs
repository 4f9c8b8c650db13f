//! Partial-fraction basis in real arithmetic, and residues of known poles.
//!
//! Gustavsen & Semlyen, IEEE Trans. Power Delivery 14 (1999), pp. 1052–1061, appendix A, for the pairs.

use super::problem::{CommonPoleFit, CommonPoleOptions, CommonPoleProblem};
use crate::base::error::Error;
use crate::identify::transfer::function::DirectTerms;
use crate::numeric::{Complex, Matrix, least_squares};

/// Polynomial columns of the least-squares problem, in addition to those of the poles.
#[derive(Clone, Copy)]
pub struct PolynomialColumns {
    pub constant: bool,
    pub slope: bool,
}

impl From<CommonPoleOptions> for PolynomialColumns {
    fn from(options: CommonPoleOptions) -> PolynomialColumns {
        PolynomialColumns {
            constant: options.constant,
            slope: options.slope,
        }
    }
}

/// Rows: real parts of all lines, then imaginary parts; one column for each real unknown.
pub fn columns(poles: &[Complex], omega: &[f64], beside: PolynomialColumns) -> Matrix {
    let lines = omega.len();
    let count: usize = poles.iter().map(|p| if p.im > 0.0 { 2 } else { 1 }).sum();
    let more = usize::from(beside.constant) + usize::from(beside.slope);
    let mut a = Matrix::zeros(2 * lines, count + more);
    let mut at = 0;
    for &p in poles {
        for (k, &w) in omega.iter().enumerate() {
            let s = Complex::new(0.0, w);
            let own = (s - p).inv();
            if p.im > 0.0 {
                let twin = (s - p.conj()).inv();
                let (sum, difference) = (own + twin, own - twin);
                (a[(k, at)], a[(lines + k, at)]) = (sum.re, sum.im);
                (a[(k, at + 1)], a[(lines + k, at + 1)]) = (-difference.im, difference.re);
            } else {
                (a[(k, at)], a[(lines + k, at)]) = (own.re, own.im);
            }
        }
        at += if p.im > 0.0 { 2 } else { 1 };
    }
    if beside.constant {
        a.col_as_slice_mut(at)[..lines].fill(1.0);
        at += 1;
    }
    if beside.slope {
        a.col_as_slice_mut(at)[lines..].copy_from_slice(omega);
    }
    a
}

/// Rows of a line in real and imaginary part times its weight.
pub fn apply_weights(a: &mut Matrix, weight: &[f64]) {
    let lines = weight.len();
    for j in 0..a.ncols() {
        let (top, bottom) = a.col_as_slice_mut(j).split_at_mut(lines);
        for (k, w) in weight.iter().enumerate() {
            top[k] *= w;
            bottom[k] *= w;
        }
    }
}

/// Residues and direct terms of every response for given poles in shares of the highest line; the result is in rad/s.
pub fn fit(
    problem: &CommonPoleProblem,
    poles: &[Complex],
    iterations: usize,
) -> Result<CommonPoleFit, Error> {
    let plain = columns(poles, &problem.omega, problem.options.into());
    let lines = problem.omega.len();
    let right = |q: usize, weight: &[f64], k: usize| {
        let value = problem.responses[q][k % lines];
        weight[k % lines] * if k < lines { value.re } else { value.im }
    };
    let weighed = |weight: &[f64]| {
        let mut a = plain.clone();
        apply_weights(&mut a, weight);
        a
    };
    let count = problem.responses.len();
    let unknowns = if problem.weights.len() == 1 {
        let weight = problem.weight(0);
        let b = Matrix::from_fn(2 * lines, count, |k, q| right(q, weight, k));
        least_squares::solve(&weighed(weight), &b)?
    } else {
        let mut all = Matrix::zeros(plain.ncols(), count);
        for q in 0..count {
            let weight = problem.weight(q);
            let b = Matrix::from_fn(2 * lines, 1, |k, _| right(q, weight, k));
            let x = least_squares::solve(&weighed(weight), &b)?;
            all.col_as_slice_mut(q).copy_from_slice(x.col_as_slice(0));
        }
        all
    };
    let model = &plain * &unknowns;
    let scale = problem.scale;
    let mut fitted = CommonPoleFit {
        poles: poles.iter().map(|p| p * scale).collect(),
        residues: Vec::with_capacity(count),
        direct: Vec::with_capacity(count),
        errors: Vec::with_capacity(count),
        iterations,
    };
    for q in 0..count {
        let mut list = unknowns.col_as_slice(q).iter().copied();
        let mut next = || list.next().unwrap_or(0.0);
        let residue = |p: &Complex| {
            let re = next();
            Complex::new(re, if p.im > 0.0 { next() } else { 0.0 }) * scale
        };
        fitted.residues.push(poles.iter().map(residue).collect());
        let constant = if problem.options.constant {
            next()
        } else {
            0.0
        };
        let slope = if problem.options.slope {
            next() / scale
        } else {
            0.0
        };
        fitted.direct.push(DirectTerms {
            constant,
            slope,
            ..DirectTerms::default()
        });
        fitted
            .errors
            .push(misfit(&problem.responses[q], model.col_as_slice(q)));
    }
    Ok(fitted)
}

/// `‖model − response‖ / ‖response‖`; the norm of the model where the response is nil.
fn misfit(response: &[Complex], model: &[f64]) -> f64 {
    let lines = response.len();
    let (mut left, mut size) = (0.0_f64, 0.0_f64);
    for (k, value) in response.iter().enumerate() {
        left = left.hypot((Complex::new(model[k], model[lines + k]) - value).norm());
        size = size.hypot(value.norm());
    }
    if size > 0.0 { left / size } else { left }
}
