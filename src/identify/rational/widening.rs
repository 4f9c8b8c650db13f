//! Widening of a pole's covariance beyond the information in the data: weights by variances of few averages, leakage of windowed blocks.
//!
//! Weights by sample variances of d complex degrees of freedom scatter, so that the variance of the fit is `(d − 1)/(d − 2)` times what
//! they claim: Carroll & Cline, An asymptotic theory for weighted least-squares with weights estimated by replication, Biometrika 75
//! (1988), pp. 35–43. The lines of the resonance together know the scale of their noise with the sum of their degrees of freedom: Meier,
//! Variance of a weighted mean, Biometrics 9 (1953), pp. 59–73.
//!
//! The mean of H1 over windowed blocks of noise is the response convolved with the window's `|W|²` (Bendat & Piersol, Random Data, 4th ed.
//! (2010), section 9.1): to second order in the standard deviation δ of `|W|²`, `R/z` with `z = s − p` becomes `R/z − δ² R/z³`.

use crate::numeric::{Complex, Matrix};

use super::basis::{ScaledPole, WhitenedProblem, residue, set_complex};
use super::projection::{ModelFit, fit_at, step_to};
use super::random_effects::student_factor;
use crate::numeric::thin_qr::{sub_product, transposed_product};

/// With fewer complex degrees of freedom of a line's variance the variance of weights by it grows without bound, at 2, and no interval
/// is stated.
pub(super) const MIN_DOF: f64 = 2.5;

/// Factor on the standard deviation of a pole whose lines are weighed by variances of `dof` complex degrees of freedom, `lines` of them
/// independent across the resonance; `None` where they carry no interval.
pub(super) fn estimated_weights_factor(dof: f64, lines: f64) -> Option<f64> {
    if !(dof >= MIN_DOF) {
        return None;
    }
    // `(d − 1)/(d − 2)`, of a known variance 1.
    let scatter = (1.0 + 1.0 / (dof - 2.0)).sqrt();
    Some(scatter * student_factor(2.0 * dof * lines.max(1.0)))
}

/// Window of averaged blocks of noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Smearing {
    /// Standard deviation of its `|W|²`, in units of the highest line.
    pub spread: f64,
    /// Power of the whitened residual of a single average.
    pub residual: f64,
}

/// Leakage leaves a residual of `δ² |∂H/∂ω|²` in each average of noise. A residual of less than this share of it says that the input
/// repeats in every block, where nothing leaks.
const MIN_RESIDUAL_SHARE: f64 = 0.1;

/// Shift of each pole, `(w, σ)`, in units of the highest line, by leakage: what the fit, under its own weights, makes of what the window
/// adds to the response.
pub(super) fn leakage_shifts(
    problems: &[WhitenedProblem],
    fit: &ModelFit,
    numerators: usize,
    smearing: Smearing,
) -> Vec<(f64, f64)> {
    let poles = &fit.model.poles;
    let mut smeared = fit_at(problems, &fit.model, numerators);
    for (problem, own) in problems.iter().zip(&mut smeared.fits) {
        let c = Matrix::from_fn(own.c.nrows(), own.c.ncols(), |j, i| {
            own.c[(j, i)] / own.column_norms[j]
        });
        let added = leakage(problem, poles, numerators, &c, smearing);
        own.e = sub_product(&added, &own.qr.q, &transposed_product(&own.qr.q, &added));
    }
    let shift =
        step_to(problems, &smeared, numerators).unwrap_or_else(|| vec![0.0; 2 * poles.len()]);
    let of = |(r, pole): (usize, &ScaledPole)| {
        (pole.sigma * shift[2 * r], pole.sigma * shift[2 * r + 1])
    };
    poles.iter().enumerate().map(of).collect()
}

/// Addition of leakage to the data of a problem, by the coefficients `c` of the basis: `−δ² R/z³`.
fn leakage(
    problem: &WhitenedProblem,
    poles: &[ScaledPole],
    numerators: usize,
    c: &Matrix,
    smearing: Smearing,
) -> Matrix {
    let n = problem.lines();
    let mut added = Matrix::zeros(2 * n, c.ncols());
    for i in 0..c.ncols() {
        let own: Vec<f64> = (0..c.nrows()).map(|j| c[(j, i)]).collect();
        let column = added.col_as_slice_mut(i);
        for k in 0..n {
            let s = Complex::new(0.0, problem.x[k]);
            let (mut slope, mut curvature) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
            for (r, pole) in poles.iter().enumerate() {
                let residue = residue(&own, pole, r, numerators);
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
    added
}

#[cfg(test)]
mod tests {
    use super::super::projection::PoleModel;
    use super::*;

    /// One pole under even weights: of `exp(−σt) (1 − δ²t²/2)` the part along `exp(−σt)` and `t exp(−σt)` is a pole of the decay rate
    /// `σ + δ²/σ`. An input that repeats in every block leaves no residual, and shifts nothing.
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

    /// Means of normal numbers of one mean, weighed by the inverse of sample variances of d complex degrees of freedom each: their variance
    /// over that which the weights claim, corrected by the weighted misfit as a fit corrects it.
    #[test]
    fn law_weights_of_few_averages_scatter() {
        let mut rng = fastrand::Rng::with_seed(11);
        let mut normal = || (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0;
        for dof in [3, 5, 8] {
            let (lines, repeats) = (60, 1500);
            let (mut outside, mut plain) = (0, 0);
            for _ in 0..repeats {
                let (mut sum, mut top, mut misfit) = (0.0, 0.0, Vec::new());
                for _ in 0..lines {
                    let own = (0..2 * dof).map(|_| normal().powi(2)).sum::<f64>();
                    let weight = 2.0 * dof as f64 / own;
                    let value = normal();
                    sum += weight;
                    top += weight * value;
                    misfit.push((weight, value));
                }
                let mean = top / sum;
                let chi2: f64 = misfit.iter().map(|(w, y)| w * (y - mean).powi(2)).sum();
                let std = (chi2 / (lines as f64 - 1.0) / sum).sqrt();
                let factor = estimated_weights_factor(dof as f64, lines as f64).unwrap();
                outside += usize::from(mean.abs() > 1.96 * factor * std);
                plain += usize::from(mean.abs() > 1.96 * std);
            }
            let share = |n: usize| n as f64 / repeats as f64;
            // 0.6 % standard deviation of a share of 5 %; the misfit of d = 3 has no variance.
            assert!(
                (0.025..0.075).contains(&share(outside)),
                "{dof}: {}",
                share(outside)
            );
            assert!(share(plain) > share(outside), "{dof}: {}", share(plain));
        }
        assert_eq!(estimated_weights_factor(2.0, 5.0), None);
        assert_eq!(estimated_weights_factor(f64::INFINITY, 5.0), Some(1.0));
        assert!((estimated_weights_factor(1e6, 5.0).unwrap() - 1.0).abs() < 1e-4);
    }
}
