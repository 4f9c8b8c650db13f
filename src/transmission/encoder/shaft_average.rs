//! Synchronous average of each shaft, `ē(θ) = 1/K Σ_k e(θ + 2πk)`.
//!
//! In few turns the waves of the other shafts do not average out, and what stays of them hardly changes from turn to turn, so that no
//! scatter tells of it. The fitted orders that are no multiples of the shaft are therefore taken off first.

use super::fit::{HarmonicFit, add};
use super::gear_train::GearTrain;
use super::orders::CandidateOrder;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::spectrum::rotation::angular_resampling::AngularSignal;
use crate::spectrum::rotation::interpolation::{HALF_KERNEL, SincInterpolator};
use crate::spectrum::rotation::synchronous_average::SynchronousAverage;

/// The mean turn of a shaft.
#[derive(Debug, Clone)]
pub struct ShaftAverage {
    /// Such as `input`.
    pub shaft: String,
    /// Over the angle of that shaft, from its mark where it has one.
    pub average: SynchronousAverage,
}

/// Fewer cells a turn of a shaft show less than its second multiple.
const MIN_CELLS: f64 = 8.0;

/// Averages of every shaft that turns twice or more, the output first. `input` is where the input's angle is zero, turns of the output.
///
/// # Errors
/// Those of the averages.
pub fn shaft_averages(
    signal: &AngularSignal,
    fitted: &HarmonicFit,
    orders: &[CandidateOrder],
    teeth: &GearTrain,
    input: f64,
) -> Result<Vec<ShaftAverage>, Error> {
    let mut all = Vec::new();
    for member in teeth.shafts().into_iter().rev() {
        let (own, waves): (Vec<CandidateOrder>, Vec<Complex>) = (orders.iter().zip(&fitted.waves))
            .filter(|(o, _)| (&o.fraction / &member.order).is_integer())
            .map(|(o, w)| (o.clone(), *w))
            .unzip();
        let mut alone = AngularSignal {
            values: fitted.residual.clone(),
            ..*signal
        };
        add(&mut alone, &own, &waves);
        let order = member.order.to_f64();
        let cells = signal.samples_per_rev as f64 / order;
        let zero = if member.name == "input" { input } else { 0.0 };
        let turning = match member.name == "output" {
            true => alone,
            false if cells < MIN_CELLS => continue,
            false => over_shaft_angle(&alone, order, zero, cells.ceil() as usize),
        };
        if turning.revolutions() >= 2 {
            all.push(ShaftAverage {
                average: SynchronousAverage::new(&turning)?,
                shaft: member.name,
            });
        }
    }
    Ok(all)
}

/// A signal over the angle of a shaft that turns `order` times as often, its zero at `zero` turns.
fn over_shaft_angle(
    signal: &AngularSignal,
    order: f64,
    zero: f64,
    per_turn: usize,
) -> AngularSignal {
    let (n, reach) = (signal.samples_per_rev as f64, HALF_KERNEL as f64);
    let own = |cell: f64| ((signal.first as f64 + cell) / n - zero) * order * per_turn as f64;
    let first = own(reach).ceil() as i64;
    let last = own(signal.values.len() as f64 - 1.0 - reach).floor() as i64;
    let kernel = SincInterpolator::default();
    let value = |i: i64| {
        let turns = i as f64 / per_turn as f64 / order + zero;
        kernel.value_at(&signal.values, turns * n - signal.first as f64, 1.0)
    };
    AngularSignal {
        samples_per_rev: per_turn,
        first,
        values: (first..=last).map(value).collect(),
    }
}
