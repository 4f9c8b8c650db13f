//! Scatter of the poles over hits, or responses: shifts of every group's own poles from the common ones, to first order.

use crate::numeric::Matrix;
use crate::numeric::symmetric::{cholesky, solve_lower, solve_lower_transposed};

use super::basis::WhitenedProblem;
use super::projection::{ModelFit, normal_by_group};

/// A shift is held to about a half-width: where the data say little the group follows the others.
const PRIOR: f64 = 1.0;

/// Most scatter of a pole, half-widths: beyond, it is no longer one resonance.
const MAX_SCATTER: f64 = 1.0;

/// Fewer groups have no scatter to speak of.
pub(super) const MIN_GROUPS: usize = 3;

/// Standard deviation of each pole's frequency over the groups beyond what noise gives, in half-widths; zero for fewer groups than three.
pub(super) fn scatter(
    problem: &WhitenedProblem,
    fit: &ModelFit,
    numerators: usize,
    groups: &[Vec<usize>],
) -> Vec<f64> {
    let np = fit.model.poles.len();
    if groups.len() < MIN_GROUPS || np == 0 {
        return vec![0.0; np];
    }
    let normals = normal_by_group(problem, &fit.model, numerators, &fit.fits[0], groups);
    let n = 2 * np;
    let mut shifts = vec![Vec::new(); np];
    let mut noise = vec![0.0; np];
    for normal in &normals {
        let damped = Matrix::from_fn(n, n, |i, j| {
            normal.a[(i, j)] + if i == j { PRIOR } else { 0.0 }
        });
        let Ok(l) = cholesky(&damped) else {
            return vec![0.0; np];
        };
        let solve = |b: &Matrix| solve_lower_transposed(&l, &solve_lower(&l, b));
        let shift = solve(&Matrix::from_fn(n, 1, |i, _| -normal.g[i]));
        let inverse = solve(&Matrix::identity(n, n));
        for r in 0..np {
            shifts[r].push(shift[(2 * r, 0)]);
            noise[r] += inverse[(2 * r, 2 * r)] / normals.len() as f64;
        }
    }
    let of = |(shifts, noise): (&Vec<f64>, &f64)| {
        let mean = shifts.iter().sum::<f64>() / shifts.len() as f64;
        let square: f64 = shifts.iter().map(|s| (s - mean).powi(2)).sum();
        let variance = square / (shifts.len() as f64 - 1.0) - noise;
        variance.max(0.0).sqrt().min(MAX_SCATTER)
    };
    shifts.iter().zip(&noise).map(of).collect()
}
