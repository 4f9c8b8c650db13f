//! Angular backlash `p(φ) = c₂ − c₁ + Σ (A₂ − A₁) cos` from both directions of rotation.
//!
//! Its mean is that of both directions' readings, over which the steps of the encoders average out. Over the angle it is told by those
//! orders in which the flanks differ beyond the noise of both: the difference of readings would be mostly steps.

use super::fit::add;
use super::flank::{FALSE_ALARM_RATE, FlankEvaluation, OrderEstimate};
use super::orders::CandidateOrder;
use crate::numeric::Complex;
use crate::numeric::statistics::extremes;
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Backlash between both directions of rotation, as an angle of the output.
#[derive(Debug, Clone)]
pub struct AngularBacklash {
    /// Over all angles that passed in both directions, rad.
    pub mean: f64,
    /// Over the angle; absent where a direction is too short for orders.
    pub variation: Option<BacklashVariation>,
}

/// Backlash over the angle of the output, of the significant fitted orders.
#[derive(Debug, Clone)]
pub struct BacklashVariation {
    /// In the cells that passed in both directions, rad.
    pub signal: AngularSignal,
    /// Least and most, rad.
    pub range: (f64, f64),
    /// Standard deviation at each angle, of all fitted orders, rad.
    pub deviation: f64,
}

/// Values a cell from which least and most are read: with four cells a wave at least, 1/200 of its size is missed at most.
const SUBSAMPLES: usize = 8;

/// Mean of the difference of the readings where both directions passed, and the first cell and number of cells it is over.
pub fn mean_backlash(
    forward: &AngularSignal,
    backward: &AngularSignal,
) -> Option<(f64, i64, usize)> {
    let end = |s: &AngularSignal| s.first + s.values.len() as i64;
    let first = forward.first.max(backward.first);
    let last = end(forward).min(end(backward));
    let at = |s: &AngularSignal, i: i64| s.values[(i - s.first) as usize];
    let sum: f64 = (first..last)
        .map(|i| at(backward, i) - at(forward, i))
        .sum();
    let count = usize::try_from(last - first).ok().filter(|n| *n > 0)?;
    Some((sum / count as f64, first, count))
}

/// The play over the angle, of both flanks.
pub fn backlash_variation(
    flanks: &[FlankEvaluation],
    first: i64,
    count: usize,
) -> Option<BacklashVariation> {
    let of = |forward| flanks.iter().find(|f| f.forward == forward);
    let (up, down) = (of(true)?, of(false)?);
    let mut fine = AngularSignal {
        samples_per_rev: up.signal.samples_per_rev * SUBSAMPLES,
        first: first * SUBSAMPLES as i64,
        values: vec![down.mean - up.mean; count * SUBSAMPLES],
    };
    let (orders, waves) = differing_orders(up, down);
    add(&mut fine, &orders, &waves);
    let range = extremes(fine.values.iter().copied());
    Some(BacklashVariation {
        signal: AngularSignal {
            samples_per_rev: up.signal.samples_per_rev,
            first,
            values: fine.values.into_iter().step_by(SUBSAMPLES).collect(),
        },
        range,
        // That of a range is of two angles.
        deviation: up.fitted.deviation.hypot(down.fitted.deviation) / 2f64.sqrt(),
    })
}

/// Orders in which the back flank differs from the other by more than noise makes of one in a thousand records, and by what.
fn differing_orders(
    up: &FlankEvaluation,
    down: &FlankEvaluation,
) -> (Vec<CandidateOrder>, Vec<Complex>) {
    let mut all: Vec<(&OrderEstimate, Complex, f64)> = Vec::new();
    for (flank, sign) in [(down, 1.0), (up, -1.0)] {
        for line in &flank.lines {
            let wave = Complex::from_polar(sign * line.amplitude, line.phase);
            let variance = line.deviation.powi(2);
            match all
                .iter_mut()
                .find(|l| l.0.order.fraction == line.order.fraction)
            {
                Some(both) => (both.1, both.2) = (both.1 + wave, both.2 + variance),
                None => all.push((line, wave, variance)),
            }
        }
    }
    let least = (all.len().max(1) as f64 / FALSE_ALARM_RATE).ln();
    let stand_out = |(_, wave, variance): &&(&OrderEstimate, Complex, f64)| {
        wave.norm_sqr() > 2.0 * variance * least
    };
    let kept = all.iter().filter(stand_out);
    kept.map(|(line, wave, _)| (line.order.clone(), *wave))
        .unzip()
}
