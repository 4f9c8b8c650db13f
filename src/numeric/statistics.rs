//! Median, quantiles and tail probabilities of the normal, χ², F and t distributions.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// Standard deviations of a normal number in half its 95 % interval.
pub const Z_95: f64 = 1.96;

/// The middle value, of an even count the upper of the two; absent where there is none. The values change places.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Least and greatest value; `(∞, −∞)` of none.
pub fn extremes(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let widened = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
    values.into_iter().fold(none, widened)
}

/// Greatest less least value; zero of none.
pub fn peak_to_peak(values: &[f64]) -> f64 {
    // Lanes of comparisons need not wait for each other.
    const LANES: usize = 8;
    let (mut lows, mut highs) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    for part in values.chunks(LANES) {
        for ((&x, low), high) in part.iter().zip(&mut lows).zip(&mut highs) {
            *low = if x < *low { x } else { *low };
            *high = if x > *high { x } else { *high };
        }
    }
    match (extremes(lows).0, extremes(highs).1) {
        (low, high) if low > high => 0.0,
        (low, high) => high - low,
    }
}

/// The value a standard normal variable stays below with probability `p`, `0 < p < 1`.
pub fn normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// The probability that a standard normal variable stays below `x`.
pub fn normal_cdf(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// The value a χ² variable of `dofs` stays below with probability `p`; infinite where `dofs` is not positive.
pub fn chi_squared_quantile(p: f64, dofs: f64) -> f64 {
    ChiSquared::new(dofs).map_or(f64::INFINITY, |d| d.inverse_cdf(p))
}

/// The probability that a χ² variable of `dofs` exceeds `x`.
pub fn chi_squared_sf(x: f64, dofs: f64) -> f64 {
    ChiSquared::new(dofs).map_or(f64::NAN, |d| d.sf(x))
}

/// The probability that an F variable with `(d1, d2)` degrees of freedom exceeds `x`.
pub fn f_sf(x: f64, d1: f64, d2: f64) -> f64 {
    FisherSnedecor::new(d1, d2).map_or(f64::NAN, |d| d.sf(x))
}

/// The value Student's t of `dofs` stays below with probability `p`; of very many the first two terms of its series about the normal
/// one (Abramowitz & Stegun, Handbook of Mathematical Functions, 1964, eq. 26.7.5).
pub fn student_t_quantile(p: f64, dofs: f64) -> f64 {
    if dofs > 1e4 {
        let z = normal_quantile(p);
        return z + (z * z * z + z) / (4.0 * dofs);
    }
    StudentsT::new(0.0, 1.0, dofs).map_or(f64::INFINITY, |d| d.inverse_cdf(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_medians() {
        assert_eq!(median(&mut []), None);
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), Some(3.0));
    }

    /// Tabulated values to their printed digits (any table of these distributions).
    #[test]
    fn ref_tables() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 5e-4 * b.abs().max(1.0), "{a} {b}");
        close(normal_quantile(0.975), 1.960);
        close(chi_squared_quantile(0.95, 10.0), 18.307);
        close(chi_squared_sf(18.307, 10.0), 0.05);
        close(student_t_quantile(0.975, 10.0), 2.228);
        close(f_sf(3.326, 5.0, 10.0), 0.05);
        // exp(−x/2) for two degrees of freedom, far out in the tail
        let tail = chi_squared_sf(200.0, 2.0);
        assert!((tail / (-100.0_f64).exp() - 1.0).abs() < 1e-9);
    }
}
