//! Computed order tracking: signals resampled at equal angle increments, `y_i = x(t(2πi/N))`.
//!
//! K. R. Fyfe, E. D. S. Munck, Analysis of computed order tracking, Mech. Syst. Signal Process. 11 (1997), 187–205.
//!
//! Where `N` values per revolution come at a lower rate than the samples, the signal is low-passed in proportion to the speed: orders up
//! to `0.85 N/2` are kept to 10⁻⁴ and those above `N/2` are attenuated by 80 dB, at every speed. Elsewhere the pass band ends at 0.85
//! of half the sample rate.

use std::f64::consts::TAU;

use super::angle_curve::AngleCurve;
use super::interpolation::{HALF_KERNEL, PASS_BAND, SincInterpolator};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::spectrum::validation::{check_count, check_positive, check_samples};

/// Signal sampled at equal angle increments of a shaft.
#[derive(Debug, Clone)]
pub struct AngularSignal {
    /// Samples per revolution.
    pub samples_per_rev: usize,
    /// Index of the first sample: its angle is `2π first/samples_per_rev`, rad.
    pub first: i64,
    /// Samples.
    pub values: Vec<f64>,
}

impl AngularSignal {
    /// Angle of sample `i`, rad.
    pub fn angle(&self, i: usize) -> f64 {
        (self.first + i as i64) as f64 * TAU / self.samples_per_rev as f64
    }

    /// Highest order in the pass band, unless the sample rate limits it further.
    pub fn pass_order(&self) -> f64 {
        PASS_BAND * self.samples_per_rev as f64 / 2.0
    }

    /// Number of complete revolutions.
    pub fn revolutions(&self) -> usize {
        self.values.len() / self.samples_per_rev
    }

    /// Refuses fewer than `min` complete revolutions.
    pub fn check_revolutions(&self, min: usize) -> Result<(), Error> {
        if self.samples_per_rev > 0 && self.revolutions() >= min {
            return Ok(());
        }
        Err(Error::new(
            Code::TooShort,
            format!(
                "{} values at {} per turn are too few (minimum {min} whole turns)",
                self.values.len(),
                self.samples_per_rev
            ),
        )
        .with_hint("take a longer segment of the record, or fewer turns per block"))
    }
}

/// Resamples a signal at `per_turn` equal angle increments, wherever the angle is known and the kernel lies inside the samples.
///
/// # Errors
/// Non-finite samples, fewer than two values per revolution, an angle curve that covers less than one revolution of the samples.
pub fn resample(
    samples: &[f64],
    rate_hz: f64,
    curve: &AngleCurve,
    per_turn: usize,
) -> Result<AngularSignal, Error> {
    check_samples(samples, 2)?;
    check_positive(rate_hz, "the sample rate, Hz,")?;
    check_count(per_turn, 2, "the number of values per turn")?;
    let (low, high) = curve.angle_range();
    let step = TAU / per_turn as f64;
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    let positions: Vec<f64> = (first..=last)
        .filter_map(|i| curve.time_at((i as f64 * step).clamp(low, high)))
        .map(|t| t * rate_hz)
        .collect();
    // Input samples per output sample; above one, the kernel is widened by it.
    let spacing = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(positions.len() - 1));
        ((positions[b] - positions[a]) / (b - a).max(1) as f64).max(1.0)
    };
    let end = samples.len() as f64 - 1.0;
    let starts = |i: &usize| positions[*i] - HALF_KERNEL as f64 * spacing(*i) >= 0.0;
    let ends = |i: &usize| positions[*i] + HALF_KERNEL as f64 * spacing(*i) <= end;
    let from = (0..positions.len()).find(starts).unwrap_or(positions.len());
    let to = from + (from..positions.len()).take_while(ends).count();
    let kernel = SincInterpolator::default();
    let value = |i: usize| kernel.value_at(samples, positions[i], spacing(i));
    let signal = AngularSignal {
        samples_per_rev: per_turn,
        first: first + from as i64,
        values: (from..to).map(value).collect(),
    };
    signal.check_revolutions(1)?;
    Ok(signal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_less_than_a_turn() {
        let curve = AngleCurve::constant_speed(1.0, 6.0).unwrap();
        let x = vec![0.0; 6000];
        assert_eq!(
            resample(&x, 1000.0, &curve, 16).unwrap_err().code,
            Code::TooShort
        );
        assert_eq!(
            resample(&x, 1000.0, &curve, 0).unwrap_err().code,
            Code::OutOfRange
        );
        assert_eq!(
            resample(&x[..1], 1000.0, &curve, 8).unwrap_err().code,
            Code::TooShort
        );
    }
}
