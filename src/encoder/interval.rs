//! Confidence interval of an amplitude under noise (Rice's distribution).
//!
//! `P(R ≤ r | A) = Σ_j Poisson(j; A²/2σ²) P(j + 1, r²/2σ²)` (S. O. Rice, Bell Syst. Tech. J. 24 (1945); the χ² form is Patnaik's, 1949).

use crate::numeric::statistics::{normal_cdf, student_t_quantile};

/// Probability left out on either side.
const TAIL: f64 = 0.025;

/// Above this ratio of amplitude to deviation the length is normal to three digits of its quantiles.
const NORMAL_RATIO: f64 = 12.0;

/// Halvings of a bracket: beyond the digits of any estimate of noise.
const MAX_HALVINGS: usize = 40;

/// The amplitudes between which the true one lies with 95 %, where `found` was measured with the standard deviation `deviation` of
/// either quadrature, estimated with so many `freedoms`.
pub fn amplitude_interval(found: f64, deviation: f64, dofs: f64) -> (f64, f64) {
    if !(deviation > 0.0 && deviation.is_finite() && found.is_finite()) {
        return (found, found);
    }
    // A deviation that is itself estimated: wider by what Student's t is beyond the normal one.
    let wider = match dofs >= 1.0 {
        true => student_t_quantile(1.0 - TAIL, dofs) / student_t_quantile(1.0 - TAIL, 1e6),
        false => f64::INFINITY,
    };
    let sigma = deviation * wider;
    if !sigma.is_finite() {
        return (0.0, f64::INFINITY);
    }
    let r = found / sigma;
    let upper = invert_rice(r, TAIL);
    let lower = invert_rice(r, 1.0 - TAIL);
    (sigma * lower, sigma * upper)
}

/// The A at which a length of `r` or less has probability `p`; 0 where it is less probable even without amplitude. Falls with p.
fn invert_rice(r: f64, p: f64) -> f64 {
    if rice_cdf(r, 0.0) <= p {
        return 0.0;
    }
    let (mut low, mut high) = ((r - 10.0).max(0.0), r + 10.0);
    for _ in 0..MAX_HALVINGS {
        let middle = 0.5 * (low + high);
        if rice_cdf(r, middle) > p {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// `P(R ≤ r | a)` for unit deviation.
fn rice_cdf(r: f64, a: f64) -> f64 {
    if a > NORMAL_RATIO || r > NORMAL_RATIO {
        // Mean and variance to the next order in 1/a.
        let mean = if a > 0.0 { a + 0.5 / a } else { 0.0 };
        return normal_cdf(r - mean);
    }
    let (lambda, x) = (0.5 * a * a, 0.5 * r * r);
    // P(j + 1, x) = 1 − e⁻ˣ Σ_{i ≤ j} xⁱ/i!
    let (mut poisson, mut term) = ((-lambda).exp(), (-x).exp());
    let (mut head, mut sum) = (term, 0.0);
    const TERMS: u32 = 400;
    for j in 0..TERMS {
        sum += poisson * (1.0 - head).max(0.0);
        let next = f64::from(j + 1);
        poisson *= lambda / next;
        term *= x / next;
        head += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without amplitude the length is Rayleigh's, 1 − exp(−r²/2); far out the interval is ±1.96 deviations.
    #[test]
    fn exact_limits() {
        for r in [0.3, 1.0, 2.5] {
            assert!((rice_cdf(r, 0.0) - (1.0 - (-0.5f64 * r * r).exp())).abs() < 1e-12);
        }
        let (low, high) = amplitude_interval(1000.0, 1.0, 1e6);
        assert!((low - 998.04).abs() < 0.01 && (high - 1001.96).abs() < 0.01);
        // both forms meet
        let (a, b) = (NORMAL_RATIO - 1e-9, NORMAL_RATIO + 1e-9);
        assert!((rice_cdf(11.5, a) - rice_cdf(11.5, b)).abs() < 2e-3);
        assert_eq!(amplitude_interval(1.0, 0.0, 9.0), (1.0, 1.0));
    }

    /// The intervals cover the true amplitude in 95 % of 4000 draws at each size, to sampling error; at zero no fewer.
    #[test]
    fn law_coverage() {
        let mut rng = fastrand::Rng::with_seed(4);
        let mut normal = || {
            let radius = (-2.0 * (1.0 - rng.f64()).ln()).sqrt();
            radius * (std::f64::consts::TAU * rng.f64()).cos()
        };
        for truth in [0.0, 0.5, 1.5, 4.0, 20.0] {
            let mut inside = 0;
            for _ in 0..1000 {
                let found = f64::hypot(truth + normal(), normal());
                let (low, high) = amplitude_interval(found, 1.0, 1e6);
                inside += u32::from(low <= truth && truth <= high);
            }
            assert!((925..=990).contains(&inside), "{truth}: {inside}");
        }
    }
}
