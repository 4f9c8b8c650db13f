//! Angular backlash `p(φ) = c₂ − c₁ + Σ (A₂ − A₁) cos` from both directions of rotation.
//!
//! The mean is the mean difference of the readings of both directions, over which the steps of the encoders average out. The variation
//! consists of the orders in which the flanks differ significantly: the difference of single readings is dominated by the steps.

use super::fit::add;
use super::flank::{FALSE_ALARM_RATE, FlankEvaluation, OrderEstimate};
use super::orders::CandidateOrder;
use crate::numeric::Complex;
use crate::numeric::statistics::extremes;
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Angular backlash at the output from both directions of rotation.
#[derive(Debug, Clone)]
pub struct AngularBacklash {
    /// Mean over the angles passed in both directions, rad.
    pub mean: f64,
    /// Variation over the angle; `None` where a direction is too short for orders.
    pub variation: Option<BacklashVariation>,
}

/// Backlash over the angle of the output, composed of the significant fitted orders.
#[derive(Debug, Clone)]
pub struct BacklashVariation {
    /// Backlash in the cells passed in both directions, rad.
    pub signal: AngularSignal,
    /// Minimum and maximum, rad.
    pub range: (f64, f64),
    /// Standard deviation at each angle, from all fitted orders, rad.
    pub deviation: f64,
}

/// Values per cell for the minimum and maximum: with at least four cells per wave, the error is at most 1/200 of its amplitude.
const SUBSAMPLES: usize = 8;

/// Mean difference of the readings of both directions, rad, with the first cell and the number of cells that both passed.
pub fn mean_backlash(
    forward: &AngularSignal,
    backward: &AngularSignal,
) -> Option<(f64, i64, usize)> {
    let end = |s: &AngularSignal| s.first + s.values.len() as i64;
    let first = forward.first.max(backward.first);
    let last = end(forward).min(end(backward));
    let value = |s: &AngularSignal, i: i64| s.values[(i - s.first) as usize];
    let sum: f64 = (first..last)
        .map(|i| value(backward, i) - value(forward, i))
        .sum();
    let count = usize::try_from(last - first).ok().filter(|n| *n > 0)?;
    Some((sum / count as f64, first, count))
}

/// Variation of the backlash over the angle; `None` without orders of both flanks.
pub fn backlash_variation(
    flanks: &[FlankEvaluation],
    first: i64,
    count: usize,
) -> Option<BacklashVariation> {
    let flank = |is_forward| flanks.iter().find(|f| f.forward == is_forward);
    let (forward, backward) = (flank(true)?, flank(false)?);
    let mut fine = AngularSignal {
        samples_per_rev: forward.signal.samples_per_rev * SUBSAMPLES,
        first: first * SUBSAMPLES as i64,
        values: vec![backward.mean - forward.mean; count * SUBSAMPLES],
    };
    let (orders, waves) = differing_orders(forward, backward);
    add(&mut fine, &orders, &waves);
    let range = extremes(fine.values.iter().copied());
    Some(BacklashVariation {
        signal: AngularSignal {
            samples_per_rev: forward.signal.samples_per_rev,
            first,
            values: fine.values.into_iter().step_by(SUBSAMPLES).collect(),
        },
        range,
        // The fitted deviation refers to a range, the difference at two angles; √2 converts it to one angle.
        deviation: forward.fitted.deviation.hypot(backward.fitted.deviation) / 2f64.sqrt(),
    })
}

/// Orders in which the flanks differ at the significance level [`FALSE_ALARM_RATE`], with the complex differences.
fn differing_orders(
    forward: &FlankEvaluation,
    backward: &FlankEvaluation,
) -> (Vec<CandidateOrder>, Vec<Complex>) {
    let mut differences: Vec<(&OrderEstimate, Complex, f64)> = Vec::new();
    for (flank, sign) in [(backward, 1.0), (forward, -1.0)] {
        for line in &flank.lines {
            let wave = Complex::from_polar(sign * line.amplitude, line.phase);
            let variance = line.deviation.powi(2);
            match differences
                .iter_mut()
                .find(|l| l.0.order.fraction == line.order.fraction)
            {
                Some(sum) => (sum.1, sum.2) = (sum.1 + wave, sum.2 + variance),
                None => differences.push((line, wave, variance)),
            }
        }
    }
    let threshold = (differences.len().max(1) as f64 / FALSE_ALARM_RATE).ln();
    let is_significant = |(_, wave, variance): &&(&OrderEstimate, Complex, f64)| {
        wave.norm_sqr() > 2.0 * variance * threshold
    };
    let rows = differences.iter().filter(is_significant);
    rows.map(|(line, wave, _)| (line.order.clone(), *wave))
        .unzip()
}
