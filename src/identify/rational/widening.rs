//! Additional covariance of poles due to weights from few averages and to leakage of windowed blocks.
//!
//! Weights by sample variances of d complex degrees of freedom scatter, so that the variance of the fit is `(d − 1)/(d − 2)` times
//! the nominal variance: Carroll & Cline, An asymptotic theory for weighted least-squares with weights estimated by replication,
//! Biometrika 75 (1988), pp. 35–43. The noise scale of the resonance has the sum of the degrees of freedom of its lines: Meier, Variance of
//! a weighted mean, Biometrics 9 (1953), pp. 59–73.
//!
//! The mean of H1 over windowed blocks of noise is the response convolved with the window's `|W|²` (Bendat & Piersol, Random Data, 4th ed.
//! (2010), section 9.1): to second order in the standard deviation δ of `|W|²`, `R/z` with `z = s − p` becomes `R/z − δ² R/z³`.

use crate::numeric::{Complex, Matrix};

use super::basis::{ScaledPole, WhitenedProblem, residue, set_complex};
use super::projection::{ModelFit, fit_at, step_to};
use super::random_effects::student_factor;
use crate::numeric::thin_qr::{sub_product, transposed_product};

/// Minimum complex degrees of freedom of the variance of a line for an interval; the variance with such weights diverges at 2.
pub(super) const MIN_DOF: f64 = 2.5;

/// Factor on the standard deviation of a pole whose lines are weighted by variances of `dof` complex degrees of freedom, with `lines`
/// independent lines across the resonance; `None` below [`MIN_DOF`].
pub(super) fn estimated_weights_factor(dof: f64, lines: f64) -> Option<f64> {
    if !(dof >= MIN_DOF) {
        return None;
    }
    // `(d − 1)/(d − 2)`; 1 for a known variance.
    let scatter = (1.0 + 1.0 / (dof - 2.0)).sqrt();
    Some(scatter * student_factor(2.0 * dof * lines.max(1.0)))
}

/// Smearing by the window of averaged noise blocks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Smearing {
    /// Standard deviation of `|W|²` of the window, in units of the highest line.
    pub spread: f64,
    /// Power of the whitened residual of a single average.
    pub residual: f64,
}

/// Minimum share of the residual `δ² |∂H/∂ω|²` that leakage leaves in each average of noise. A smaller residual indicates a periodic input
/// without leakage.
const MIN_RESIDUAL_SHARE: f64 = 0.1;

/// Shift of each pole, `(w, σ)`, in units of the highest line, due to leakage: one Gauss–Newton step of the weighted fit with the leakage
/// term added to the response.
pub(super) fn leakage_shifts(
    problems: &[WhitenedProblem],
    fit: &ModelFit,
    numerators: usize,
    smearing: Smearing,
) -> Vec<(f64, f64)> {
    let poles = &fit.model.poles;
    let mut smeared = fit_at(problems, &fit.model, numerators);
    for (problem, fit) in problems.iter().zip(&mut smeared.fits) {
        let c = Matrix::from_fn(fit.c.nrows(), fit.c.ncols(), |j, i| {
            fit.c[(j, i)] / fit.column_norms[j]
        });
        let term = leakage(problem, poles, numerators, &c, smearing);
        fit.e = sub_product(&term, &fit.qr.q, &transposed_product(&fit.qr.q, &term));
    }
    let shift =
        step_to(problems, &smeared, numerators).unwrap_or_else(|| vec![0.0; 2 * poles.len()]);
    let scaled_shift = |(r, pole): (usize, &ScaledPole)| {
        (pole.sigma * shift[2 * r], pole.sigma * shift[2 * r + 1])
    };
    poles.iter().enumerate().map(scaled_shift).collect()
}

/// Leakage term `−δ² R/z³` in the data of a problem, from the coefficients `c` of the basis.
fn leakage(
    problem: &WhitenedProblem,
    poles: &[ScaledPole],
    numerators: usize,
    c: &Matrix,
    smearing: Smearing,
) -> Matrix {
    let n = problem.lines();
    let mut data = Matrix::zeros(2 * n, c.ncols());
    for i in 0..c.ncols() {
        let coefficients: Vec<f64> = (0..c.nrows()).map(|j| c[(j, i)]).collect();
        let column = data.col_as_slice_mut(i);
        for k in 0..n {
            let s = Complex::new(0.0, problem.x[k]);
            let (mut slope, mut curvature) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
            for (r, pole) in poles.iter().enumerate() {
                let residue = residue(&coefficients, pole, r, numerators);
                for (residue, z) in [
                    (residue, s - pole.value()),
                    (residue.conj(), s - pole.value().conj()),
                ] {
                    slope += residue / (z * z);
                    curvature += residue / (z * z * z);
                }
            }
            let square = smearing.spread * smearing.spread;
            let expected = square * (problem.factor[k] * slope).norm_sqr();
            if smearing.residual > MIN_RESIDUAL_SHARE * expected {
                set_complex(column, k, n, problem.factor[k] * curvature * -square);
            }
        }
    }
    data
}

#[cfg(test)]
mod tests {
    use super::super::projection::PoleModel;
    use super::*;

    /// One pole with uniform weights: the projection of `exp(−σt) (1 − δ²t²/2)` on `exp(−σt)` and `t exp(−σt)` is a pole of decay rate
    /// `σ + δ²/σ`. A periodic input leaves no residual and causes no shift.
    #[test]
    fn exact_shift_by_leakage() {
        let (n, spread) = (4000, 1e-4);
        let pole = ScaledPole::new(Complex::new(-0.005, 0.5), 1.0);
        let mut problem = WhitenedProblem {
            x: (1..=n).map(|k| k as f64 / n as f64).collect(),
            factor: vec![Complex::new(1.0, 0.0); n],
            pole_free_columns: Matrix::zeros(2 * n, 0),
            y: Matrix::zeros(2 * n, 1),
            first: 0,
            line_spacing: 1.0 / n as f64,
            omitted_energy: 0.0,
        };
        problem.y = problem.basis(&[pole], 2) * Matrix::from_fn(2, 1, |j, _| [1.0, 0.4][j]);
        let model = PoleModel {
            poles: vec![pole],
            delays: Vec::new(),
        };
        let problems = [problem];
        let fit = fit_at(&problems, &model, 2);
        let shift = |residual: f64| {
            let smearing = Smearing { spread, residual };
            leakage_shifts(&problems, &fit, 2, smearing)[0]
        };
        let (w, sigma) = shift(f64::INFINITY);
        let expected = spread * spread / 0.005;
        assert!((sigma / expected - 1.0).abs() < 0.02, "{sigma} {expected}");
        assert!(w.abs() < 0.02 * expected, "{w}");
        assert_eq!(shift(0.0), (0.0, 0.0));
    }

    /// Coverage of the 95 % interval of a mean of normal variates weighted by inverse sample variances of d complex dof, with
    /// the variance scaled by the weighted misfit as in a fit.
    #[test]
    fn law_weights_of_few_averages_scatter() {
        let mut rng = fastrand::Rng::with_seed(11);
        let mut normal = || (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0;
        for dof in [3, 5, 8] {
            let (lines, repeats) = (60, 1500);
            let (mut outside, mut nominal) = (0, 0);
            for _ in 0..repeats {
                let (mut sum, mut weighted_sum, mut misfit) = (0.0, 0.0, Vec::new());
                for _ in 0..lines {
                    let sum_of_squares = (0..2 * dof).map(|_| normal().powi(2)).sum::<f64>();
                    let weight = 2.0 * dof as f64 / sum_of_squares;
                    let value = normal();
                    sum += weight;
                    weighted_sum += weight * value;
                    misfit.push((weight, value));
                }
                let mean = weighted_sum / sum;
                let chi2: f64 = misfit.iter().map(|(w, y)| w * (y - mean).powi(2)).sum();
                let std = (chi2 / (lines as f64 - 1.0) / sum).sqrt();
                let factor = estimated_weights_factor(dof as f64, lines as f64).unwrap();
                outside += usize::from(mean.abs() > 1.96 * factor * std);
                nominal += usize::from(mean.abs() > 1.96 * std);
            }
            let share = |n: usize| n as f64 / repeats as f64;
            // 0.6 % standard deviation of a share of 5 %; the misfit of d = 3 has no variance.
            assert!(
                (0.025..0.075).contains(&share(outside)),
                "{dof}: {}",
                share(outside)
            );
            assert!(share(nominal) > share(outside), "{dof}: {}", share(nominal));
        }
        assert_eq!(estimated_weights_factor(2.0, 5.0), None);
        assert_eq!(estimated_weights_factor(f64::INFINITY, 5.0), Some(1.0));
        assert!((estimated_weights_factor(1e6, 5.0).unwrap() - 1.0).abs() < 1e-4);
    }
}
