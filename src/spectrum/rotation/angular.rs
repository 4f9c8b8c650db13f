//! Signals at equal steps of angle: `y_i = x(t(θ_i))`, `θ_i = 2πi/N`, by band-limited interpolation (computed order tracking:
//! K. R. Fyfe, E. D. S. Munck, Mech. Syst. Signal Process. 11 (1997), 187–205).
//!
//! Where `N` values a turn come more slowly than the samples, the signal is low-passed at the pace of the turning: orders up to
//! `0.85 N/2` are kept to 10⁻⁴ and those above `N/2` are 80 dB down, at every speed. Where they come faster, it is 0.85 of half the
//! sample rate that is kept.

use std::f64::consts::TAU;

use super::angle::AngleCurve;
use super::interpolation::{Interpolator, PASS, REACH};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::spectrum::samples::{check, check_count, check_positive};

/// A signal over the angle of a shaft.
#[derive(Debug, Clone)]
pub struct AngularSignal {
    /// Values a turn.
    pub per_turn: usize,
    /// Number of the first value: its angle is `2π first/per_turn`.
    pub first: i64,
    /// The values.
    pub values: Vec<f64>,
}

impl AngularSignal {
    /// Angle of value `i`, rad.
    pub fn angle(&self, i: usize) -> f64 {
        (self.first + i as i64) as f64 * TAU / self.per_turn as f64
    }

    /// The highest order that is kept whole, as long as the sample rate is not the narrower gate.
    pub fn pass_order(&self) -> f64 {
        PASS * self.per_turn as f64 / 2.0
    }

    /// Whole turns it holds.
    pub fn turns(&self) -> usize {
        self.values.len() / self.per_turn
    }

    /// Refuses fewer turns than `least`.
    pub fn check_turns(&self, least: usize) -> Result<(), Error> {
        if self.per_turn > 0 && self.turns() >= least {
            return Ok(());
        }
        Err(Error::new(
            Code::TooShort,
            format!(
                "{} values at {} a turn, where {least} whole turns are needed",
                self.values.len(),
                self.per_turn
            ),
        )
        .hint("take a longer stretch of the record, or fewer turns at once"))
    }
}

/// The signal at `per_turn` equal steps a turn, wherever the angle is known and the kernel lies inside the samples.
///
/// # Errors
/// Samples not finite, fewer than two values a turn, an angle and samples that overlap by less than a turn.
pub fn resample(
    samples: &[f64],
    rate_hz: f64,
    curve: &AngleCurve,
    per_turn: usize,
) -> Result<AngularSignal, Error> {
    check(samples, 2)?;
    check_positive(rate_hz, "the sample rate, Hz,")?;
    check_count(per_turn, 2, "the number of values a turn")?;
    let (low, high) = curve.angles();
    let step = TAU / per_turn as f64;
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    let positions: Vec<f64> = (first..=last)
        .filter_map(|i| curve.time_at((i as f64 * step).clamp(low, high)))
        .map(|t| t * rate_hz)
        .collect();
    // samples from one value to the next: above one, the kernel is stretched by it
    let stretch = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(positions.len() - 1));
        ((positions[b] - positions[a]) / (b - a).max(1) as f64).max(1.0)
    };
    let end = samples.len() as f64 - 1.0;
    let starts = |i: &usize| positions[*i] - REACH as f64 * stretch(*i) >= 0.0;
    let fits = |i: &usize| positions[*i] + REACH as f64 * stretch(*i) <= end;
    let from = (0..positions.len()).find(starts).unwrap_or(positions.len());
    let to = from + (from..positions.len()).take_while(fits).count();
    let kernel = Interpolator::default();
    let value = |i: usize| kernel.at(samples, positions[i], stretch(i));
    let signal = AngularSignal {
        per_turn,
        first: first + from as i64,
        values: (from..to).map(value).collect(),
    };
    signal.check_turns(1)?;
    Ok(signal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_less_than_a_turn() {
        let curve = AngleCurve::steady(1.0, 6.0).unwrap();
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
