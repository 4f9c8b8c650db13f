//! Covariance of poles and delays: inverse Fisher information with residues eliminated, `(JᵀJ)⁻¹`.

use std::borrow::Borrow;

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::symmetric::{cholesky, solve_lower, solve_lower_transposed, symmetric_eigen};

use super::basis::WhitenedProblem;
use super::projection::{ModelFit, normal};

/// Covariance of what the search moves: of every pole `[σ²_re, σ²_im, σ_re,im]` in units of the highest line, and of the delays
/// their variance.
pub(super) struct PoleCovariance {
    /// By pole.
    pub poles: Vec<Option<[f64; 3]>>,
    /// By delay.
    pub delays: Vec<Option<f64>>,
}

/// For data of unit variance; `None` for what the data do not tell.
pub(super) fn covariance(
    problems: &[impl Borrow<WhitenedProblem>],
    fit: &ModelFit,
    numerators: usize,
) -> PoleCovariance {
    let np = fit.model.poles.len();
    let nothing = PoleCovariance {
        poles: vec![None; np],
        delays: vec![None; fit.model.delays.len()],
    };
    let information = normal(problems, &fit.model, numerators, &fit.fits).a;
    let n = information.nrows();
    // What rounding left of a parameter that is not told may be below zero: it stays so on the unit diagonal.
    let unit: Vec<f64> = (0..n)
        .map(|i| information[(i, i)].abs().sqrt().max(f64::MIN_POSITIVE))
        .collect();
    let scaled = Matrix::from_fn(n, n, |i, j| information[(i, j)] / unit[i] / unit[j]);
    let Ok(inverse) = inverse(&scaled, np) else {
        return nothing;
    };
    let entry = |i: usize, j: usize| inverse[(i, j)] / unit[i] / unit[j];
    PoleCovariance {
        poles: (0..np)
            .map(|r| {
                let pole = &fit.model.poles[r];
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

/// The inverse of the information, scaled to a diagonal of one, of `np` poles of two parameters each and delays of one. Where it is singular, as by two
/// poles that coincide, what has the largest part in the direction that is not told is taken as it stands, with an infinite variance,
/// until the rest is told.
fn inverse(information: &Matrix, np: usize) -> Result<Matrix, Error> {
    let n = information.nrows();
    let owner = |i: usize| if i < 2 * np { i / 2 } else { i - np };
    let told = |i: &usize| information[(*i, *i)] > 0.0;
    let whole = |i: &usize| (0..n).filter(|j| owner(*j) == owner(*i)).all(|j| told(&j));
    let mut kept: Vec<usize> = (0..n).filter(whole).collect();
    loop {
        let m = kept.len();
        let block = Matrix::from_fn(m, m, |i, j| information[(kept[i], kept[j])]);
        if let Ok(l) = cholesky(&block) {
            let identity = Matrix::from_fn(m, m, |i, j| f64::from(u8::from(i == j)));
            let own = solve_lower_transposed(&l, &solve_lower(&l, &identity));
            let place = |i: usize| kept.iter().position(|&k| k == i);
            return Ok(Matrix::from_fn(n, n, |i, j| match (place(i), place(j)) {
                (Some(i), Some(j)) => own[(i, j)],
                _ => f64::INFINITY,
            }));
        }
        let eigen = symmetric_eigen(&block)?;
        let least = (0..m).min_by(|&a, &b| eigen.values[a].total_cmp(&eigen.values[b]));
        let mut part = vec![0.0; np + n];
        for (i, &k) in kept.iter().enumerate() {
            part[owner(k)] += least.map_or(1.0, |at| eigen.vectors[(i, at)].powi(2));
        }
        let untold = (0..part.len()).max_by(|&a, &b| part[a].total_cmp(&part[b]));
        kept.retain(|&k| Some(owner(k)) != untold);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parameters of which the data determine only the sum, and two that are determined: these keep the inverse of their own block.
    #[test]
    fn survives_what_is_told_twice() -> Result<(), Error> {
        let own = [[1.0, 0.6], [0.6, 1.0]];
        let information = Matrix::from_fn(4, 4, |i, j| match (i < 2, j < 2) {
            (true, true) => own[i][j],
            (false, false) => 1.0,
            _ => 0.0,
        });
        let found = inverse(&information, 2)?;
        assert!((found[(0, 0)] - 1.0 / 0.64).abs() < 1e-13);
        assert!((found[(0, 1)] + 0.6 / 0.64).abs() < 1e-13);
        // Either of one pole: with it goes the other.
        assert!(found[(2, 2)] == f64::INFINITY && found[(3, 3)] == f64::INFINITY);
        Ok(())
    }
}
