//! Covariance of poles and delays: inverse Fisher information with residues eliminated, `(JᵀJ)⁻¹`.

use std::borrow::Borrow;

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::symmetric::{cholesky, solve_lower, solve_lower_transposed, symmetric_eigen};

use super::basis::WhitenedProblem;
use super::projection::{ModelFit, normal_equations};

/// Covariance of the nonlinear parameters: `[σ²_re, σ²_im, σ_re,im]` of each pole and the variance of each delay, in units of the
/// highest line.
pub(super) struct PoleCovariance {
    /// Covariance of each pole; `None` if undetermined.
    pub poles: Vec<Option<[f64; 3]>>,
    /// Variance of each delay; `None` if undetermined.
    pub delays: Vec<Option<f64>>,
}

/// Computes the covariance for data of unit variance; `None` for parameters that the data do not determine.
pub(super) fn covariance(
    problems: &[impl Borrow<WhitenedProblem>],
    fit: &ModelFit,
    numerators: usize,
) -> PoleCovariance {
    let np = fit.model.poles.len();
    let undetermined = PoleCovariance {
        poles: vec![None; np],
        delays: vec![None; fit.model.delays.len()],
    };
    let information = normal_equations(problems, &fit.model, numerators, &fit.fits).a;
    let n = information.nrows();
    // Rounding may make the diagonal entry of an undetermined parameter negative; the scaled diagonal keeps its sign.
    let unit: Vec<f64> = (0..n)
        .map(|i| information[(i, i)].abs().sqrt().max(f64::MIN_POSITIVE))
        .collect();
    let scaled = Matrix::from_fn(n, n, |i, j| information[(i, j)] / unit[i] / unit[j]);
    let Ok(inverse) = inverse(&scaled, np) else {
        return undetermined;
    };
    let entry = |i: usize, j: usize| inverse[(i, j)] / unit[i] / unit[j];
    PoleCovariance {
        poles: (0..np)
            .map(|r| {
                let pole = &fit.model.poles[r];
                let variance_scale = pole.sigma * pole.sigma;
                let sign = if pole.stable { -1.0 } else { 1.0 };
                let (w, x) = (2 * r, 2 * r + 1);
                let is_determined = entry(x, x).is_finite() && entry(w, w).is_finite();
                is_determined.then(|| {
                    [
                        variance_scale * entry(x, x),
                        variance_scale * entry(w, w),
                        sign * variance_scale * entry(w, x),
                    ]
                })
            })
            .collect(),
        delays: (2 * np..n)
            .map(|i| Some(entry(i, i)).filter(|v| v.is_finite()))
            .collect(),
    }
}

/// Inverts the information matrix, scaled to a unit diagonal, of `np` poles (two parameters each) and of the delays (one each). If it is
/// singular, as for two coincident poles, the pole or delay with the largest share in the null direction is removed and gets an infinite
/// variance, until the remaining matrix is positive definite.
fn inverse(information: &Matrix, np: usize) -> Result<Matrix, Error> {
    let n = information.nrows();
    let owner = |i: usize| if i < 2 * np { i / 2 } else { i - np };
    let is_determined = |i: usize| information[(i, i)] > 0.0;
    let is_complete = |i: &usize| (0..n).filter(|j| owner(*j) == owner(*i)).all(is_determined);
    let mut active: Vec<usize> = (0..n).filter(is_complete).collect();
    loop {
        let m = active.len();
        let block = Matrix::from_fn(m, m, |i, j| information[(active[i], active[j])]);
        if let Ok(l) = cholesky(&block) {
            let identity = Matrix::from_fn(m, m, |i, j| f64::from(u8::from(i == j)));
            let block_inverse = solve_lower_transposed(&l, &solve_lower(&l, &identity));
            let index = |i: usize| active.iter().position(|&k| k == i);
            return Ok(Matrix::from_fn(n, n, |i, j| match (index(i), index(j)) {
                (Some(i), Some(j)) => block_inverse[(i, j)],
                _ => f64::INFINITY,
            }));
        }
        let eigen = symmetric_eigen(&block)?;
        let smallest = (0..m).min_by(|&a, &b| eigen.values[a].total_cmp(&eigen.values[b]));
        let mut shares = vec![0.0; np + n];
        for (i, &k) in active.iter().enumerate() {
            shares[owner(k)] += smallest.map_or(1.0, |column| eigen.vectors[(i, column)].powi(2));
        }
        let weakest = (0..shares.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
        active.retain(|&k| Some(owner(k)) != weakest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parameters of which the data determine only the sum get infinite variances; two determined ones get the inverse of their block.
    #[test]
    fn survives_what_is_told_twice() -> Result<(), Error> {
        let block = [[1.0, 0.6], [0.6, 1.0]];
        let information = Matrix::from_fn(4, 4, |i, j| match (i < 2, j < 2) {
            (true, true) => block[i][j],
            (false, false) => 1.0,
            _ => 0.0,
        });
        let inverted = inverse(&information, 2)?;
        assert!((inverted[(0, 0)] - 1.0 / 0.64).abs() < 1e-13);
        assert!((inverted[(0, 1)] + 0.6 / 0.64).abs() < 1e-13);
        // Both parameters belong to one pole and are removed together.
        assert!(inverted[(2, 2)] == f64::INFINITY && inverted[(3, 3)] == f64::INFINITY);
        Ok(())
    }
}
