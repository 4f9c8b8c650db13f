//! A mean of estimates that differ by more than their own uncertainty: the mean of the population they are drawn from, as uncertain as
//! their differences make it. Homogeneity: Cochran (1954); variance between: Paule and Mandel (1982); interval: Hartung and Knapp (2001).

use crate::numeric::statistics::{chi_squared_sf, normal_quantile, student_t_quantile};

/// Estimates of one quantity differ where chance gives their differences less often than this; those of all quantities together where it
/// does so less often than that. By these the interval of a mean of three and more holds it 94 to 97 % of the time, whatever the
/// variance between (72 000 sets of normal numbers).
const SIGNIFICANCE: (f64, f64) = (0.05, 0.2);

/// A mean of several estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PooledMean {
    /// The mean.
    pub mean: f64,
    /// Variance of the mean, such that 1.96 standard deviations are the 95 % interval, whatever the number of estimates.
    pub variance: f64,
    /// Standard deviation between the estimates beyond their own.
    pub between_std: f64,
}

/// Cochran's Q: `Σ (y − ȳ)²/v`, a χ² variable of one degree of freedom less than estimates where these are of one number.
pub(super) fn heterogeneity(y: &[f64], v: &[f64]) -> f64 {
    let (mean, _) = weighted_mean(y, v, 0.0);
    (y.iter().zip(v)).map(|(y, v)| (y - mean).powi(2) / v).sum()
}

/// Whether estimates of one quantity differ by more than chance, from [`heterogeneity`] and its degrees of freedom.
pub(super) fn differ(q: f64, dof: f64) -> bool {
    dof > 0.0 && chi_squared_sf(q, dof) < SIGNIFICANCE.0
}

/// Whether those of several quantities do, from their sums.
pub(super) fn differ_together(q: f64, dof: f64) -> bool {
    dof > 0.0 && chi_squared_sf(q, dof) < SIGNIFICANCE.1
}

/// The mean of estimates y of variances v, taken to differ.
pub(super) fn pooled_mean(y: &[f64], v: &[f64]) -> PooledMean {
    let free = y.len() as f64 - 1.0;
    let between2 = between_variance(y, v, free);
    let (mean, total) = weighted_mean(y, v, between2);
    let seen: f64 = (y.iter().zip(v))
        .map(|(y, v)| (y - mean).powi(2) / (v + between2))
        .sum();
    let wider = student_factor(free);
    PooledMean {
        mean,
        variance: seen / free / total * wider * wider,
        between_std: between2.sqrt(),
    }
}

/// Ratio of the 97.5 % quantile of Student's distribution to the normal one: 6.48 for two estimates.
pub(super) fn student_factor(free: f64) -> f64 {
    student_t_quantile(0.975, free) / normal_quantile(0.975)
}

/// Mean and sum of the weights.
fn weighted_mean(y: &[f64], v: &[f64], between2: f64) -> (f64, f64) {
    let total: f64 = v.iter().map(|v| 1.0 / (v + between2)).sum();
    let sum: f64 = y.iter().zip(v).map(|(y, v)| y / (v + between2)).sum();
    (sum / total, total)
}

/// The variance between estimates for which `Σ (y − ȳ)²/(v + τ²)` is as large as expected, by bisection.
fn between_variance(y: &[f64], v: &[f64], free: f64) -> f64 {
    const MAX_HALVINGS: usize = 100;
    let surplus = |between2: f64| {
        let (mean, _) = weighted_mean(y, v, between2);
        let q: f64 = (y.iter().zip(v))
            .map(|(y, v)| (y - mean).powi(2) / (v + between2))
            .sum();
        q - free
    };
    if !(surplus(0.0) > 0.0) {
        return 0.0;
    }
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let mut low = 0.0;
    // At the sum of squares over one degree of freedom less the statistic is below what is expected.
    let mut high: f64 = y.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / free.max(1.0) * 2.0;
    for _ in 0..MAX_HALVINGS {
        let middle = 0.5 * (low + high);
        match surplus(middle) > 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal variances: the mean, the variance between less that of each, and Student's interval of the sample.
    #[test]
    fn exact_equal_variances() {
        let y = [1.0, 2.0, 4.0, 5.0];
        let found = pooled_mean(&y, &[0.5; 4]);
        let sample = 10.0 / 3.0;
        assert!((found.mean - 3.0).abs() < 1e-12);
        assert!((found.between_std.powi(2) - (sample - 0.5)).abs() < 1e-9);
        let half = 1.959964 * found.variance.sqrt();
        assert!((half - 3.182446 * (sample / 4.0f64).sqrt()).abs() < 1e-4);
        assert!((heterogeneity(&y, &[0.5; 4]) - 20.0).abs() < 1e-12);
    }

    /// Normal estimates with and without a variance between: the interval holds the mean of the population as often as it says.
    #[test]
    fn law_intervals_hold_the_mean() {
        let mut rng = fastrand::Rng::with_seed(5);
        let mut normal = || (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0;
        for (count, between) in [(2, 0.0), (2, 2.0), (3, 0.0), (3, 2.0), (5, 1.0), (8, 0.3)] {
            let mut covered = 0;
            for _ in 0..2000 {
                let v: Vec<f64> = (0..count).map(|k| 1.0 + 0.2 * k as f64).collect();
                let y: Vec<f64> = (v.iter())
                    .map(|v| v.sqrt() * normal() + between * normal())
                    .collect();
                let found = pooled_mean(&y, &v);
                covered += usize::from(found.mean.abs() < 1.96 * found.variance.sqrt());
            }
            let share = covered as f64 / 2000.0;
            assert!(
                (0.92..=0.975).contains(&share),
                "{count} {between}: {share}"
            );
        }
    }
}
