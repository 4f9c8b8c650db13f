//! Level crossings with hysteresis, interpolated between samples; state levels by histogram (IEEE 181).

use crate::base::code::Code;
use crate::base::error::Error;
use crate::spectrum::validation::{check_positive, check_samples};

/// Bins of the histogram in which the two states of a signal are looked for.
const BINS: usize = 100;

/// Half the width of the band around the middle in which a crossing is not yet believed, over the distance of the two states.
const HYSTERESIS: f64 = 0.2;

/// The two states of a signal and what lies between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateLevels {
    /// Low state.
    pub low: f64,
    /// High state.
    pub high: f64,
}

impl StateLevels {
    /// From the signal itself: the fullest bin of either half of its histogram, the method of IEEE Std 181-2011 for state levels.
    ///
    /// # Errors
    /// Samples not finite, a signal that never changes.
    pub fn from_samples(samples: &[f64]) -> Result<StateLevels, Error> {
        check_samples(samples, 2)?;
        let least = samples.iter().copied().fold(f64::INFINITY, f64::min);
        let most = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let width = (most - least) / BINS as f64;
        if !(width > 0.0 && width.is_finite()) {
            return Err(Error::new(
                Code::NoSignal,
                format!("the pulse signal is {least} throughout"),
            )
            .with_hint("check whether the tacho was connected, and whether this is its channel"));
        }
        let mut counts = [0_usize; BINS];
        for x in samples {
            counts[(((x - least) / width) as usize).min(BINS - 1)] += 1;
        }
        let fullest = |from: usize, to: usize| {
            let best = (from..to).max_by_key(|&b| counts[b]).unwrap_or(from);
            least + (best as f64 + 0.5) * width
        };
        Ok(StateLevels {
            low: fullest(0, BINS / 2),
            high: fullest(BINS / 2, BINS),
        })
    }

    fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }
}

/// A passage through the middle of two levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelCrossing {
    /// When, s from the first sample.
    pub time_s: f64,
    /// Upward.
    pub rising: bool,
}

/// Every passage from one state to the other. What turns back before it has gone a fifth of the way beyond the middle is noise.
///
/// The time is that of the last passage through the middle before the far side is reached, on the straight line between the two
/// samples around it: exact to about a hundredth of a sample where the edge is smooth over several samples, to half a sample where it is
/// steeper than the sampling.
///
/// # Errors
/// Samples not finite, a rate that is not positive.
pub fn level_crossings(
    samples: &[f64],
    rate_hz: f64,
    levels: StateLevels,
) -> Result<Vec<LevelCrossing>, Error> {
    check_samples(samples, 2)?;
    check_positive(rate_hz, "the sample rate, Hz,")?;
    check_positive(levels.high - levels.low, "the high level above the low one")?;
    let middle = levels.middle();
    let band = HYSTERESIS * (levels.high - levels.low);
    let mut found = Vec::new();
    let mut state = None; // unknown until the signal is clearly on one side
    let mut passage = 0.0;
    let mut before = samples[0];
    for (j, &x) in samples.iter().enumerate() {
        if (before < middle) != (x < middle) {
            passage = j as f64 - (x - middle) / (x - before);
        }
        before = x;
        let side = if x > middle + band {
            true
        } else if x < middle - band {
            false
        } else {
            continue;
        };
        if state == Some(!side) {
            found.push(LevelCrossing {
                time_s: passage / rate_hz,
                rising: side,
            });
        }
        state = Some(side);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A sine of low frequency with noise: one rising edge a period, none extra.
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
        let found = level_crossings(&x, 1.0, levels).unwrap();
        assert_eq!(found.iter().filter(|e| e.rising).count(), 20);
        assert!(found.windows(2).all(|w| w[0].rising != w[1].rising));
        let rising = found.iter().filter(|e| e.rising);
        assert!(
            rising
                .enumerate()
                .all(|(k, e)| (e.time_s - 500.0 - 1000.0 * k as f64).abs() < 30.0)
        );
    }

    /// A straight flank is timed to rounding, and the states of pulses that are high one hundredth of the time are found.
    #[test]
    fn exact_ramp_and_narrow_pulses() {
        let ramp: Vec<f64> = (0..10).map(|j| f64::from(j) - 4.3).collect();
        let found = level_crossings(
            &ramp,
            2.0,
            StateLevels {
                low: -4.0,
                high: 4.0,
            },
        )
        .unwrap();
        assert!(found.len() == 1 && (found[0].time_s - 2.15).abs() < 1e-15 && found[0].rising);
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
