//! Tacho pulses numbered from the first; missing and extra pulses detected by the median interval.

use super::level_crossings::{StateLevels, level_crossings};
use crate::base::code::Code;
use crate::base::error::Error;

/// Distances on either side that go into the median.
const MEDIAN_HALF_WIDTH: usize = 4;

/// Distances at either end that have too few neighbours to be judged by.
const EDGE_INTERVALS: usize = 2;

/// A pulse nearer than this to the last one is extra, and one farther than [`MISSING_RATIO`] has missed one; over the usual distance.
const EXTRA_RATIO: f64 = 0.5;

/// See [`EXTRA_RATIO`]: halfway between one distance and two.
const MISSING_RATIO: f64 = 1.5;

/// Which edge of a pulse counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EdgeDirection {
    /// Upward.
    #[default]
    Rising,
    /// Downward.
    Falling,
}

/// Pulse and its index after the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TachoPulse {
    /// When, s.
    pub time_s: f64,
    /// Number of its place, the first one's 0.
    pub index: usize,
}

/// Places without a pulse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MissingPulses {
    /// The pulse before, s.
    pub after_s: f64,
    /// Number of missing pulses.
    pub number: usize,
}

/// The pulses of a tacho.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TachoPulses {
    /// Those that count.
    pub pulses: Vec<TachoPulse>,
    /// Gaps in which pulses are missing; their places are counted.
    pub missing: Vec<MissingPulses>,
    /// Times of pulses between the places, s; not counted.
    pub extra_s: Vec<f64>,
}

/// The pulses of a signal; levels from the signal itself where none are given.
///
/// # Errors
/// A signal without pulses, samples not finite.
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
    let wanted = slope == EdgeDirection::Rising;
    let times: Vec<f64> = level_crossings(samples, rate_hz, levels)?
        .iter()
        .filter(|edge| edge.rising == wanted)
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

/// Numbers pulses at rising times.
///
/// The speed may change, by up to half from one pulse to the next; the first and last two distances are not judged.
pub fn number_pulses(times: &[f64]) -> TachoPulses {
    let mut found = TachoPulses::default();
    let Some((&first, rest)) = times.split_first() else {
        return found;
    };
    let usual = median_intervals(times);
    let mut last = TachoPulse {
        time_s: first,
        index: 0,
    };
    found.pulses.push(last);
    let mut at = 0; // in `rest`; `usual[at]` leads up to it
    while at < rest.len() {
        // of those before the next place but one, the nearest to the next place
        let over = |j: usize| (rest[j] - last.time_s) / usual[j];
        let within = (at..rest.len())
            .take_while(|&j| over(j) < MISSING_RATIO)
            .count();
        let off = |j: usize| (over(j) - 1.0).abs();
        let nearest = (at..at + within).min_by(|&a, &b| off(a).total_cmp(&off(b)));
        let next = match nearest {
            Some(j) if over(j) >= EXTRA_RATIO => j,
            _ => at + within,
        };
        found.extra_s.extend(&rest[at..next.min(rest.len())]);
        if next == rest.len() {
            break;
        }
        let places = (over(next).round() as usize).max(1);
        if places > 1 {
            found.missing.push(MissingPulses {
                after_s: last.time_s,
                number: places - 1,
            });
        }
        last = TachoPulse {
            time_s: rest[next],
            index: last.index + places,
        };
        found.pulses.push(last);
        at = next + 1;
    }
    found
}

/// The median of the distances around each; at the ends its own.
fn median_intervals(times: &[f64]) -> Vec<f64> {
    let distances: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    let n = distances.len();
    let mut near = Vec::with_capacity(2 * MEDIAN_HALF_WIDTH + 1);
    (0..n)
        .map(|i| {
            let reach = i.min(n - 1 - i).min(MEDIAN_HALF_WIDTH);
            if reach < EDGE_INTERVALS {
                return distances[i];
            }
            near.clear();
            near.extend_from_slice(&distances[i - reach..=i + reach]);
            near.sort_by(f64::total_cmp);
            near[reach]
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
        let found = number_pulses(&times);
        assert!(found.missing.is_empty() && found.extra_s.is_empty());
        assert!(
            found
                .pulses
                .iter()
                .enumerate()
                .all(|(k, p)| p.index == k && p.time_s == times[k])
        );
    }

    /// Pulses with 3 % jitter, some left out and some put in: every one is found at its place.
    #[test]
    fn law_missing_and_extra() {
        let mut rng = fastrand::Rng::with_seed(8);
        for _ in 0..50 {
            let (mut times, mut lost, mut put) = (Vec::new(), Vec::new(), Vec::new());
            let mut t = 0.0;
            for k in 0..300 {
                let d = 1.0 - f64::from(k) / 600.0;
                t += d;
                let time = t + 0.03 * d * (rng.f64() - 0.5);
                match k % 25 {
                    12 => lost.push(k as usize),
                    20 => {
                        times.push(time);
                        times.push(time + d * (0.15 + 0.7 * rng.f64()));
                        put.push(times[times.len() - 1]);
                    }
                    _ => times.push(time),
                }
            }
            let found = number_pulses(&times);
            assert_eq!(found.extra_s, put);
            assert_eq!(found.missing.len(), lost.len());
            assert!(found.missing.iter().all(|m| m.number == 1));
            assert!(
                lost.iter()
                    .all(|k| found.pulses.iter().all(|p| p.index != *k))
            );
            assert_eq!(found.pulses.last().unwrap().index, 299);
        }
    }

    /// Fifty-eight pulses and a gap of two, as on crankshafts.
    #[test]
    fn exact_gap_of_two() {
        let times: Vec<f64> = (0..600).filter(|k| k % 60 < 58).map(f64::from).collect();
        let found = number_pulses(&times);
        assert_eq!(found.missing.len(), 9); // the tenth gap has no pulse after it
        assert!(found.missing.iter().all(|m| m.number == 2));
        assert!(found.pulses.iter().all(|p| p.index as f64 == p.time_s));
    }

    #[test]
    fn survives_few_pulses() {
        assert!(number_pulses(&[]).pulses.is_empty());
        assert_eq!(number_pulses(&[1.0]).pulses.len(), 1);
        assert_eq!(number_pulses(&[1.0, 2.0, 3.0]).pulses.len(), 3);
    }
}
