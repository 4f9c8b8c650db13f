//! Tacho pulses numbered from the first; missing and extra pulses detected by the median interval.

use super::level_crossings::{StateLevels, level_crossings};
use crate::base::code::Code;
use crate::base::error::Error;

/// Number of intervals on either side in the running median.
const MEDIAN_HALF_WIDTH: usize = 4;

/// Number of intervals at either end with too few neighbours for a median.
const EDGE_INTERVALS: usize = 2;

/// Ratio of an interval to the median interval below which its pulse is extra.
const EXTRA_RATIO: f64 = 0.5;

/// Ratio of an interval to the median interval above which pulses are missing: halfway between one interval and two.
const MISSING_RATIO: f64 = 1.5;

/// Edge of a pulse that is timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EdgeDirection {
    /// Rising edge.
    #[default]
    Rising,
    /// Falling edge.
    Falling,
}

/// Tacho pulse with its index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TachoPulse {
    /// Time, s.
    pub time_s: f64,
    /// Index, 0 for the first pulse; missing pulses are counted.
    pub index: usize,
}

/// Gap with missing pulses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MissingPulses {
    /// Time of the pulse before the gap, s.
    pub after_s: f64,
    /// Number of missing pulses.
    pub number: usize,
}

/// Numbered pulses of a tacho, with missing and extra ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TachoPulses {
    /// Accepted pulses.
    pub pulses: Vec<TachoPulse>,
    /// Gaps in which pulses are missing; the index counts them.
    pub missing: Vec<MissingPulses>,
    /// Times of extra pulses, s; the index does not count them.
    pub extra_pulses_s: Vec<f64>,
}

/// Detects the pulses of a signal; by default the levels are estimated from it.
///
/// # Errors
/// A signal without pulses, non-finite samples.
pub fn find_tacho_pulses(
    samples: &[f64],
    rate_hz: f64,
    slope: EdgeDirection,
    levels: Option<StateLevels>,
) -> Result<TachoPulses, Error> {
    let levels = match levels {
        Some(levels) => levels,
        None => StateLevels::from_samples(samples)?,
    };
    let rising = slope == EdgeDirection::Rising;
    let times: Vec<f64> = level_crossings(samples, rate_hz, levels)?
        .iter()
        .filter(|edge| edge.rising == rising)
        .map(|edge| edge.time_s)
        .collect();
    if times.len() < 2 {
        return Err(Error::new(
            Code::NoSignal,
            format!(
                "{} pulses between the levels {} and {}",
                times.len(),
                levels.low,
                levels.high
            ),
        )
        .with_hint("state the levels of the tacho, or check whether this is its channel"));
    }
    Ok(number_pulses(&times))
}

/// Numbers pulses at rising times, s.
///
/// The speed may change by up to half from one pulse to the next; the first and last two intervals are not checked.
pub fn number_pulses(times: &[f64]) -> TachoPulses {
    let mut tacho = TachoPulses::default();
    let Some((&first, later)) = times.split_first() else {
        return tacho;
    };
    let medians = median_intervals(times);
    let mut last = TachoPulse {
        time_s: first,
        index: 0,
    };
    tacho.pulses.push(last);
    let mut start = 0; // index in `later`; `medians[start]` belongs to the interval before it
    while start < later.len() {
        // Among the pulses within `MISSING_RATIO`, the one nearest to one interval.
        let ratio = |j: usize| (later[j] - last.time_s) / medians[j];
        let count = (start..later.len())
            .take_while(|&j| ratio(j) < MISSING_RATIO)
            .count();
        let deviation = |j: usize| (ratio(j) - 1.0).abs();
        let nearest = (start..start + count).min_by(|&a, &b| deviation(a).total_cmp(&deviation(b)));
        let next = match nearest {
            Some(j) if ratio(j) >= EXTRA_RATIO => j,
            _ => start + count,
        };
        tacho
            .extra_pulses_s
            .extend(&later[start..next.min(later.len())]);
        if next == later.len() {
            break;
        }
        let steps = (ratio(next).round() as usize).max(1);
        if steps > 1 {
            tacho.missing.push(MissingPulses {
                after_s: last.time_s,
                number: steps - 1,
            });
        }
        last = TachoPulse {
            time_s: later[next],
            index: last.index + steps,
        };
        tacho.pulses.push(last);
        start = next + 1;
    }
    tacho
}

/// Running median of the intervals; at the ends the interval itself.
fn median_intervals(times: &[f64]) -> Vec<f64> {
    let intervals: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    let n = intervals.len();
    let mut neighbours = Vec::with_capacity(2 * MEDIAN_HALF_WIDTH + 1);
    (0..n)
        .map(|i| {
            let half_width = i.min(n - 1 - i).min(MEDIAN_HALF_WIDTH);
            if half_width < EDGE_INTERVALS {
                return intervals[i];
            }
            neighbours.clear();
            neighbours.extend_from_slice(&intervals[i - half_width..=i + half_width]);
            neighbours.sort_by(f64::total_cmp);
            neighbours[half_width]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run-up from standstill, θ = ½αt²: pulse k at √k; nothing is missing or extra.
    #[test]
    fn exact_run_up_is_left_alone() {
        let times: Vec<f64> = (0..200).map(|k| f64::from(k).sqrt()).collect();
        let tacho = number_pulses(&times);
        assert!(tacho.missing.is_empty() && tacho.extra_pulses_s.is_empty());
        assert!(
            tacho
                .pulses
                .iter()
                .enumerate()
                .all(|(k, p)| p.index == k && p.time_s == times[k])
        );
    }

    /// Pulses with 3 % jitter, some missing and some extra, are numbered correctly.
    #[test]
    fn law_missing_and_extra() {
        let mut rng = fastrand::Rng::with_seed(8);
        for _ in 0..50 {
            let (mut times, mut gaps, mut extra) = (Vec::new(), Vec::new(), Vec::new());
            let mut t = 0.0;
            for k in 0..300 {
                let d = 1.0 - f64::from(k) / 600.0;
                t += d;
                let time = t + 0.03 * d * (rng.f64() - 0.5);
                match k % 25 {
                    12 => gaps.push(k as usize),
                    20 => {
                        times.push(time);
                        times.push(time + d * (0.15 + 0.7 * rng.f64()));
                        extra.push(times[times.len() - 1]);
                    }
                    _ => times.push(time),
                }
            }
            let tacho = number_pulses(&times);
            assert_eq!(tacho.extra_pulses_s, extra);
            assert_eq!(tacho.missing.len(), gaps.len());
            assert!(tacho.missing.iter().all(|m| m.number == 1));
            assert!(
                gaps.iter()
                    .all(|k| tacho.pulses.iter().all(|p| p.index != *k))
            );
            assert_eq!(tacho.pulses.last().unwrap().index, 299);
        }
    }

    /// Fifty-eight pulses and a gap of two, as on crankshafts.
    #[test]
    fn exact_gap_of_two() {
        let times: Vec<f64> = (0..600).filter(|k| k % 60 < 58).map(f64::from).collect();
        let tacho = number_pulses(&times);
        assert_eq!(tacho.missing.len(), 9); // the tenth gap has no pulse after it
        assert!(tacho.missing.iter().all(|m| m.number == 2));
        assert!(tacho.pulses.iter().all(|p| p.index as f64 == p.time_s));
    }

    #[test]
    fn survives_few_pulses() {
        assert!(number_pulses(&[]).pulses.is_empty());
        assert_eq!(number_pulses(&[1.0]).pulses.len(), 1);
        assert_eq!(number_pulses(&[1.0, 2.0, 3.0]).pulses.len(), 3);
    }
}
