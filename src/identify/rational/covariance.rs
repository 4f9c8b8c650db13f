//! Covariance of the poles: the inverse of the Fisher information with the residues eliminated, `(JᵀJ)⁻¹`.

use std::borrow::Borrow;

use crate::numeric::Matrix;
use crate::numeric::definite::{cholesky, solve_lower, solve_lower_transposed};

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

/// For data of unit variance; `None` for all where the information is singular.
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
    let Ok(l) = cholesky(&scaled) else {
        return nothing;
    };
    let identity = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
    let inverse = solve_lower_transposed(&l, &solve_lower(&l, &identity));
    let entry = |i: usize, j: usize| inverse[(i, j)] / unit[i] / unit[j];
    Covariance {
        poles: (0..np)
            .map(|r| {
                let pole = &fitted.model.poles[r];
                let square = pole.sigma * pole.sigma;
                let sign = if pole.stable { -1.0 } else { 1.0 };
                let (w, x) = (2 * r, 2 * r + 1);
                Some([
                    square * entry(x, x),
                    square * entry(w, w),
                    sign * square * entry(w, x),
                ])
            })
            .collect(),
        delays: (2 * np..n).map(|i| Some(entry(i, i))).collect(),
    }
}
