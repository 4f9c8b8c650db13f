//! The step that most rows make, by which gaps are distinguished from steps.

use super::BLOCK;
use crate::base::error::Error;
use crate::numeric::statistics::median;
use crate::recording::raw::TimeStamps;
use crate::recording::resolution::Resolution;

/// The step most rows make, only to tell gaps from steps, never to tell the rate.
pub(super) struct TypicalStep {
    pub median_s: f64,
    /// The mean of the steps that rounding may have made of one, where stamps are coarse; else the median.
    pub mean_s: f64,
}

pub(super) fn typical_step(
    stamps: &TimeStamps,
    resolution: &Resolution,
) -> Result<TypicalStep, Error> {
    let n = stamps.seconds.len();
    let mut ends = [0.0, 0.0];
    stamps.seconds.read(0, &mut ends[..1])?;
    stamps.seconds.read(n - 1, &mut ends[1..])?;
    let over_all = (ends[1] - ends[0]) / (n - 1) as f64;
    let mut some = vec![0.0; n.min(BLOCK)];
    stamps.seconds.read(0, &mut some)?;
    let resolution_s = resolution.unit_at(some[some.len() - 1]);
    let mut steps: Vec<f64> = some
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|s| s.is_finite())
        .collect();
    let Some(median_s) = median(&mut steps) else {
        return Ok(TypicalStep {
            median_s: over_all,
            mean_s: over_all,
        });
    };
    // Coarse stamps of even steps make them one unit longer or shorter: their median tells nothing.
    const COARSE_RESOLUTION: f64 = 2.0;
    let longest = median_s + 1.001 * resolution_s;
    let (count, sum) = (steps.iter().filter(|s| **s <= longest))
        .fold((0.0, 0.0), |(n, sum), s| (n + 1.0, sum + s));
    let mean_s = match sum / count {
        _ if median_s > COARSE_RESOLUTION * resolution_s => median_s,
        mean if mean > 0.0 => mean,
        _ => over_all,
    };
    Ok(TypicalStep { median_s, mean_s })
}
