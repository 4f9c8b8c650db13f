//! Drift of the clock rate during a log.

use std::ops::Range;

use super::BLOCK;
use crate::base::error::Error;
use crate::numeric::statistics::median;
use crate::recording::raw::TimeStamps;

/// Standard deviation of what stamps are off from one to the next without regularity, s: by the median of second differences, to
/// which a clock that drifts adds nothing.
fn jitter(stamps: &TimeStamps, rows: &Range<usize>) -> Result<f64, Error> {
    let mut some = vec![0.0; rows.len().min(BLOCK)];
    stamps.seconds.read(rows.start, &mut some)?;
    let mut bends: Vec<f64> = some
        .windows(3)
        .map(|w| (w[0] - 2.0 * w[1] + w[2]).abs())
        .collect();
    // Σ(1,2,1)² = 6; a normal variable is above 0.6745 of its deviation half of the time.
    Ok(median(&mut bends).map_or(0.0, |median| median / 6f64.sqrt() / 0.674_489_75))
}

/// The lowest and the highest rate over the tenths of the longest segment, Hz; the rate itself where they differ by no more than
/// what single stamps are off makes of one.
pub(super) fn drift(
    stamps: &TimeStamps,
    segments: &[Range<usize>],
    rate_hz: f64,
) -> Result<(f64, f64), Error> {
    const PARTS: usize = 10;
    let longest = segments.iter().max_by_key(|s| s.len()).cloned();
    let Some(rows) = longest.filter(|s| s.len() > 2 * PARTS) else {
        return Ok((rate_hz, rate_hz));
    };
    let length = (rows.len() - 1) / PARTS;
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for part in 0..PARTS {
        let first = rows.start + part * length;
        let mut ends = [0.0, 0.0];
        stamps.seconds.read(first, &mut ends[..1])?;
        stamps.seconds.read(first + length, &mut ends[1..])?;
        let rate = length as f64 / (ends[1] - ends[0]);
        if rate.is_finite() {
            (low, high) = (low.min(rate), high.max(rate));
        }
    }
    // Of ten numbers some lie five deviations apart hardly ever.
    const SIGNIFICANCE_SIGMA: f64 = 5.0;
    let by_chance = std::f64::consts::SQRT_2 * jitter(stamps, &rows)? * rate_hz / length as f64;
    if high / low - 1.0 < SIGNIFICANCE_SIGMA * by_chance {
        return Ok((rate_hz, rate_hz));
    }
    Ok((low.min(rate_hz), high.max(rate_hz)))
}
