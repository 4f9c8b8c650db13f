//! Levy's linearised least squares with Sanathanan–Koerner reweighting, orthogonal polynomials.
//!
//! Levy, IRE Trans. Automat. Control 4 (1959), pp. 37–43; Sanathanan & Koerner, IEEE Trans. Automat. Control 8 (1963), pp. 56–58.
//! The polynomials are made orthogonal over the lines with their weights, anew at every iteration, by Arnoldi's process on
//! `s`: Brubeck, Nakatsukasa & Trefethen, SIAM Rev. 63 (2021), pp. 405–415; d keeps its recurrence, and its roots are
//! eigenvalues of the recurrence's matrix less a rank-one term, so that no power of s is ever formed.

use super::elimination;
use super::partial_fractions;
use super::problem::{CommonPoleFit, CommonPoleOptions, CommonPoleProblem};
use crate::base::error::Error;
use crate::numeric::{Complex, Matrix, eigen, least_squares};

/// The largest relative spread of `|d/d_before|` over the lines at which the iteration ends.
const CONVERGENCE_TOLERANCE: f64 = 1e-12;

/// Common poles of responses over lines, Hz, weighed by 1/σ; `order` poles with conjugates. The answer is a start: in noise the
/// equations are biased towards damped poles.
///
/// # Errors
/// Those of [`super::vector_fitting::vector_fit`].
pub fn levy(
    frequency_hz: &[f64],
    responses: &[Vec<Complex>],
    weights: Option<&[Vec<f64>]>,
    order: usize,
    options: CommonPoleOptions,
) -> Result<CommonPoleFit, Error> {
    let problem = CommonPoleProblem::new(frequency_hz, responses, weights, order, options)?;
    let lines = problem.omega.len();
    let own = match (options.slope, options.constant) {
        (true, _) => order + 2,
        (false, true) => order + 1,
        _ => order,
    };
    // The share of 1/|d_before| at each line; the responses' own weights are applied in the reduction.
    let mut damper = vec![1.0; lines];
    let mut poles = Vec::new();
    let mut used = 0;
    while used < options.iterations.max(1) {
        used += 1;
        let (basis, recurrence) = orthogonal(&problem, &damper, (order + 2).min(2 * lines));
        let part = |count: usize| Matrix::from_fn(2 * lines, count, |i, j| basis[(i, j)]);
        let shared = part(order + 1);
        let common = elimination::common_rows(&problem, &part(own.min(basis.ncols())), &shared)?;
        let (denominator, _) = least_squares::smallest_singular(&common)?;
        poles = roots(&recurrence, &denominator)?;
        let values = &shared * Matrix::from_fn(order + 1, 1, |i, _| denominator[i]);
        let size = |k: usize| values[(k, 0)].hypot(values[(lines + k, 0)]);
        let sizes: Vec<f64> = (0..lines).map(size).collect();
        let (least, largest) = sizes
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(l, u), &x| (l.min(x), u.max(x)));
        if largest - least <= CONVERGENCE_TOLERANCE * largest {
            break;
        }
        let floor = f64::EPSILON * largest; // a line at an undamped pole
        damper
            .iter_mut()
            .zip(&sizes)
            .for_each(|(d, x)| *d *= largest / x.max(floor));
        let top = damper.iter().fold(0.0_f64, |t, &d| t.max(d));
        damper.iter_mut().for_each(|d| *d /= top);
    }
    problem.rescale_poles(&mut poles);
    partial_fractions::fit(&problem, &poles, used)
}

/// Columns `u φ_j(iω)`, orthonormal over the lines in the mean of all weights, and H with `s φ_j = Σ_{i ≤ j+1} h_ij φ_i`.
fn orthogonal(problem: &CommonPoleProblem, damper: &[f64], count: usize) -> (Matrix, Matrix) {
    let lines = damper.len();
    let mean = |k: usize| {
        problem
            .weights
            .iter()
            .map(|w| w[k] * w[k])
            .sum::<f64>()
            .sqrt()
    };
    let squares: Vec<f64> = (0..2 * lines).map(|k| mean(k % lines).powi(2)).collect();
    let inner = |a: &[f64], b: &[f64]| {
        a.iter()
            .zip(b)
            .zip(&squares)
            .map(|((a, b), w)| w * a * b)
            .sum::<f64>()
    };
    let mut basis = Matrix::zeros(2 * lines, count);
    let mut recurrence = Matrix::zeros(count, count);
    let mut column: Vec<f64> = damper
        .iter()
        .copied()
        .chain(std::iter::repeat_n(0.0, lines))
        .collect();
    for j in 0..count {
        // Twice is enough to be orthogonal to rounding (Kahan, in Parlett 1980, §6-9).
        for _ in 0..2 {
            for i in 0..j {
                let along = inner(basis.col_as_slice(i), &column);
                recurrence[(i, j - 1)] += along;
                column
                    .iter_mut()
                    .zip(basis.col_as_slice(i))
                    .for_each(|(c, b)| *c -= along * b);
            }
        }
        let length = inner(&column, &column).sqrt();
        if j > 0 {
            recurrence[(j, j - 1)] = length;
        }
        let own = basis.col_as_slice_mut(j);
        own.iter_mut()
            .zip(&column)
            .for_each(|(b, c)| *b = c / length);
        for (k, w) in problem.omega.iter().enumerate() {
            (column[k], column[lines + k]) = (-w * own[lines + k], w * own[k]);
        }
    }
    (basis, recurrence)
}

/// Roots of `Σ c_j φ_j`: `s [φ_0 … φ_{n−1}] = [φ_0 … φ_n] H`, with φ_n replaced by `−Σ_{j<n} (c_j/c_n) φ_j`.
fn roots(recurrence: &Matrix, coefficients: &[f64]) -> Result<Vec<Complex>, Error> {
    let n = coefficients.len() - 1;
    let lead = coefficients[n];
    let closing = recurrence[(n, n - 1)];
    let matrix = Matrix::from_fn(n, n, |i, j| {
        let last = if j == n - 1 {
            closing * coefficients[i] / lead
        } else {
            0.0
        };
        recurrence[(i, j)] - last
    });
    Ok(eigen::eigen(&matrix)?.values)
}
