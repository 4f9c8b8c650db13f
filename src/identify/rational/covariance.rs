//! Covariance of the poles: the inverse of the Fisher information with the residues eliminated, `(JᵀJ)⁻¹`.

use std::borrow::Borrow;

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::definite::{cholesky, solve_lower, solve_lower_transposed, symmetric};

use super::basis::Problem;
use super::projection::{Fitted, normal};

/// Covariance of what the search moves: of every pole `[σ²_re, σ²_im, σ_re,im]` in units of the highest line, and of the delays
/// their variance.
pub(super) struct Covariance {
    /// By pole.
    pub poles: Vec<Option<[f64; 3]>>,
    /// By delay.
    pub delays: Vec<Option<f64>>,
}

/// For data of unit variance; `None` for what the data do not tell.
pub(super) fn covariance(
    problems: &[impl Borrow<Problem>],
    fitted: &Fitted,
    numerators: usize,
) -> Covariance {
    let np = fitted.model.poles.len();
    let nothing = Covariance {
        poles: vec![None; np],
        delays: vec![None; fitted.model.delays.len()],
    };
    let information = normal(problems, &fitted.model, numerators, &fitted.fits).a;
    let n = information.nrows();
    if n == 0 || (0..n).any(|i| !(information[(i, i)] > 0.0)) {
        return nothing;
    }
    let unit: Vec<f64> = (0..n).map(|i| information[(i, i)].sqrt()).collect();
    let scaled = Matrix::from_fn(n, n, |i, j| information[(i, j)] / unit[i] / unit[j]);
    let Ok(inverse) = inverse(&scaled) else {
        return nothing;
    };
    let entry = |i: usize, j: usize| inverse[(i, j)] / unit[i] / unit[j];
    Covariance {
        poles: (0..np)
            .map(|r| {
                let pole = &fitted.model.poles[r];
                let square = pole.sigma * pole.sigma;
                let sign = if pole.stable { -1.0 } else { 1.0 };
                let (w, x) = (2 * r, 2 * r + 1);
                let known = entry(x, x).is_finite() && entry(w, w).is_finite();
                known.then(|| {
                    [
                        square * entry(x, x),
                        square * entry(w, w),
                        sign * square * entry(w, x),
                    ]
                })
            })
            .collect(),
        delays: (2 * np..n)
            .map(|i| Some(entry(i, i)).filter(|v| v.is_finite()))
            .collect(),
    }
}

/// Of unit diagonal: a direction of the information below this share of the largest is none, rounding of as many lines.
const NOTHING: f64 = 1e-13;

/// A parameter has a part in such a direction above this share, squared: what rounding leaves there is far below.
const PART: f64 = 1e-9;

/// The inverse of the information of unit diagonal. Where it is singular, as by two poles that coincide, what the lost directions hold
/// a part of has an infinite variance, and the others theirs.
fn inverse(information: &Matrix) -> Result<Matrix, Error> {
    let n = information.nrows();
    if let Ok(l) = cholesky(information) {
        let identity = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
        return Ok(solve_lower_transposed(&l, &solve_lower(&l, &identity)));
    }
    let eigen = symmetric(information)?;
    let largest = eigen.values.iter().fold(0.0f64, |m, x| m.max(*x));
    let (told, lost): (Vec<usize>, Vec<usize>) =
        (0..n).partition(|&k| eigen.values[k] > NOTHING * largest);
    let v = |i: usize, k: usize| eigen.vectors[(i, k)];
    let is_lost = |i: usize| lost.iter().map(|&k| v(i, k).powi(2)).sum::<f64>() > PART;
    Ok(Matrix::from_fn(n, n, |i, j| {
        match is_lost(i) || is_lost(j) {
            true => f64::INFINITY,
            false => told
                .iter()
                .map(|&k| v(i, k) * v(j, k) / eigen.values[k])
                .sum(),
        }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parameters that only their sum is told of, beside two that are told: these keep the inverse of their own block.
    #[test]
    fn survives_what_is_told_twice() {
        let own = [[1.0, 0.6], [0.6, 1.0]];
        let information = Matrix::from_fn(4, 4, |i, j| match (i < 2, j < 2) {
            (true, true) => own[i][j],
            (false, false) => 1.0,
            _ => 0.0,
        });
        let found = inverse(&information).expect("a symmetric matrix");
        assert!((found[(0, 0)] - 1.0 / 0.64).abs() < 1e-13);
        assert!((found[(0, 1)] + 0.6 / 0.64).abs() < 1e-13);
        assert!(found[(2, 2)] == f64::INFINITY && found[(3, 3)] == f64::INFINITY);
    }
}
