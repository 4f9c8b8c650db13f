//! Computed order tracking: signals resampled at equal angle increments, `y_i = x(t(2πi/N))`.
//!
//! K. R. Fyfe, E. D. S. Munck, Analysis of computed order tracking, Mech. Syst. Signal Process. 11 (1997), 187–205.
//!
//! Where `N` values a turn come more slowly than the samples, the signal is low-passed at the pace of the turning: orders up to
//! `0.85 N/2` are kept to 10⁻⁴ and those above `N/2` are 80 dB down, at every speed. Where they come faster, it is 0.85 of half the
//! sample rate that is kept.

use std::f64::consts::TAU;

use super::angle_curve::AngleCurve;
use super::interpolation::{HALF_KERNEL, PASS_BAND, SincInterpolator};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::spectrum::validation::{check_count, check_positive, check_samples};

/// A signal over the angle of a shaft.
#[derive(Debug, Clone)]
pub struct AngularSignal {
    /// Values a turn.
    pub samples_per_rev: usize,
    /// Number of the first value: its angle is `2π first/samples_per_rev`.
    pub first: i64,
    /// The values.
    pub values: Vec<f64>,
}

impl AngularSignal {
    /// Angle of value `i`, rad.
    pub fn angle(&self, i: usize) -> f64 {
        (self.first + i as i64) as f64 * TAU / self.samples_per_rev as f64
    }

    /// The highest order that is kept whole, as long as the sample rate is not the narrower gate.
    pub fn pass_order(&self) -> f64 {
        PASS_BAND * self.samples_per_rev as f64 / 2.0
    }

    /// Whole turns it holds.
    pub fn revolutions(&self) -> usize {
        self.values.len() / self.samples_per_rev
    }

    /// Refuses fewer turns than `least`.
    pub fn check_revolutions(&self, least: usize) -> Result<(), Error> {
        if self.samples_per_rev > 0 && self.revolutions() >= least {
            return Ok(());
        }
        Err(Error::new(
            Code::TooShort,
            format!(
                "{} values at {} a turn, where {least} whole turns are needed",
                self.values.len(),
                self.samples_per_rev
            ),
        )
        .with_hint("take a longer segment of the record, or fewer turns at once"))
    }
}

/// The signal at `samples_per_rev` equal steps a turn, wherever the angle is known and the kernel lies inside the samples.
///
/// # Errors
/// Samples not finite, fewer than two values a turn, an angle and samples that overlap by less than a turn.
pub fn resample(
    samples: &[f64],
    rate_hz: f64,
    curve: &AngleCurve,
    per_turn: usize,
) -> Result<AngularSignal, Error> {
    check_samples(samples, 2)?;
    check_positive(rate_hz, "the sample rate, Hz,")?;
    check_count(per_turn, 2, "the number of values a turn")?;
    let (low, high) = curve.angle_range();
    let step = TAU / per_turn as f64;
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    let positions: Vec<f64> = (first..=last)
        .filter_map(|i| curve.time_at((i as f64 * step).clamp(low, high)))
        .map(|t| t * rate_hz)
        .collect();
    // samples from one value to the next: above one, the kernel is stretched by it
    let segment = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(positions.len() - 1));
        ((positions[b] - positions[a]) / (b - a).max(1) as f64).max(1.0)
    };
    let end = samples.len() as f64 - 1.0;
    let starts = |i: &usize| positions[*i] - HALF_KERNEL as f64 * segment(*i) >= 0.0;
    let fits = |i: &usize| positions[*i] + HALF_KERNEL as f64 * segment(*i) <= end;
    let from = (0..positions.len()).find(starts).unwrap_or(positions.len());
    let to = from + (from..positions.len()).take_while(fits).count();
    let kernel = SincInterpolator::default();
    let value = |i: usize| kernel.value_at(samples, positions[i], segment(i));
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
