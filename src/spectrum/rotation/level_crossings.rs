//! Level crossings with hysteresis, interpolated between samples; state levels by histogram (IEEE 181).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::spectrum::validation::{check_positive, check_samples};

/// Number of bins of the histogram of a signal with two states.
const BINS: usize = 100;

/// Half-width of the hysteresis band around the middle level, relative to the distance of the two states.
const HYSTERESIS: f64 = 0.2;

/// Low and high state level of a signal with two states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateLevels {
    /// Low state.
    pub low: f64,
    /// High state.
    pub high: f64,
}

impl StateLevels {
    /// Estimates the levels from samples: the fullest bin of either half of the histogram, the method of IEEE Std 181-2011.
    ///
    /// # Errors
    /// Non-finite samples, a constant signal.
    pub fn from_samples(samples: &[f64]) -> Result<StateLevels, Error> {
        check_samples(samples, 2)?;
        let min = samples.iter().copied().fold(f64::INFINITY, f64::min);
        let max = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let width = (max - min) / BINS as f64;
        if !(width > 0.0 && width.is_finite()) {
            return Err(Error::new(
                Code::NoSignal,
                format!("the pulse signal is {min} throughout"),
            )
            .with_hint("check whether the tacho was connected, and whether this is its channel"));
        }
        let mut counts = [0_usize; BINS];
        for x in samples {
            counts[(((x - min) / width) as usize).min(BINS - 1)] += 1;
        }
        let level = |from: usize, to: usize| {
            let bin = (from..to).max_by_key(|&b| counts[b]).unwrap_or(from);
            min + (bin as f64 + 0.5) * width
        };
        Ok(StateLevels {
            low: level(0, BINS / 2),
            high: level(BINS / 2, BINS),
        })
    }

    fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }
}

/// Crossing of the middle level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelCrossing {
    /// Time from the first sample, s.
    pub time_s: f64,
    /// True for a rising edge.
    pub rising: bool,
}

/// Crossings from one state to the other; an excursion of less than a fifth of the state distance beyond the middle is noise.
///
/// The time is that of the last crossing of the middle before the other state is reached, by linear interpolation between the adjacent
/// samples: accurate to about a hundredth of a sample for an edge that is smooth over several samples, to half a sample for an edge
/// steeper than the sampling.
///
/// # Errors
/// Non-finite samples, a rate that is not positive.
pub fn level_crossings(
    samples: &[f64],
    rate_hz: f64,
    levels: StateLevels,
) -> Result<Vec<LevelCrossing>, Error> {
    check_samples(samples, 2)?;
    check_positive(rate_hz, "the sample rate, Hz,")?;
    check_positive(levels.high - levels.low, "the high level minus the low one")?;
    let middle = levels.middle();
    let band = HYSTERESIS * (levels.high - levels.low);
    let mut crossings = Vec::new();
    let mut state = None; // unknown until the signal leaves the hysteresis band
    let mut crossing = 0.0;
    let mut previous = samples[0];
    for (j, &x) in samples.iter().enumerate() {
        if (previous < middle) != (x < middle) {
            crossing = j as f64 - (x - middle) / (x - previous);
        }
        previous = x;
        let is_high = if x > middle + band {
            true
        } else if x < middle - band {
            false
        } else {
            continue;
        };
        if state == Some(!is_high) {
            crossings.push(LevelCrossing {
                time_s: crossing / rate_hz,
                rising: is_high,
            });
        }
        state = Some(is_high);
    }
    Ok(crossings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A sine of low frequency with noise has exactly one rising edge per period.
    #[test]
    fn law_noise_makes_no_edges() {
        let mut rng = fastrand::Rng::with_seed(1);
        let x: Vec<f64> = (0..20_000)
            .map(|j| (TAU * (f64::from(j) + 500.0) / 1000.0).sin() + 0.3 * (rng.f64() - 0.5))
            .collect();
        let levels = StateLevels {
            low: -1.0,
            high: 1.0,
        };
        let crossings = level_crossings(&x, 1.0, levels).unwrap();
        assert_eq!(crossings.iter().filter(|e| e.rising).count(), 20);
        assert!(crossings.windows(2).all(|w| w[0].rising != w[1].rising));
        let rising = crossings.iter().filter(|e| e.rising);
        assert!(
            rising
                .enumerate()
                .all(|(k, e)| (e.time_s - 500.0 - 1000.0 * k as f64).abs() < 30.0)
        );
    }

    /// A ramp is timed to rounding, and the levels of pulses with a duty cycle of one hundredth are estimated.
    #[test]
    fn exact_ramp_and_narrow_pulses() {
        let ramp: Vec<f64> = (0..10).map(|j| f64::from(j) - 4.3).collect();
        let edges = level_crossings(
            &ramp,
            2.0,
            StateLevels {
                low: -4.0,
                high: 4.0,
            },
        )
        .unwrap();
        assert!(edges.len() == 1 && (edges[0].time_s - 2.15).abs() < 1e-15 && edges[0].rising);
        let pulses: Vec<f64> = (0..1000)
            .map(|j| if j % 100 == 7 { 5.0 } else { 0.2 })
            .collect();
        let levels = StateLevels::from_samples(&pulses).unwrap();
        assert!((levels.low - 0.2).abs() < 0.05 && (levels.high - 5.0).abs() < 0.05);
        assert_eq!(level_crossings(&pulses, 1.0, levels).unwrap().len(), 20);
    }

    #[test]
    fn refuses_a_dead_channel() {
        assert_eq!(
            StateLevels::from_samples(&[1.0; 5]).unwrap_err().code,
            Code::NoSignal
        );
        assert_eq!(
            StateLevels::from_samples(&[]).unwrap_err().code,
            Code::TooShort
        );
        let upside_down = StateLevels {
            low: 1.0,
            high: 0.0,
        };
        assert_eq!(
            level_crossings(&[0.0, 1.0], 1.0, upside_down)
                .unwrap_err()
                .code,
            Code::OutOfRange
        );
    }
}
