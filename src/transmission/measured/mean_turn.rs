//! Mean turns of the shafts between two encoders, what repeats with each of them: `ē(θ) = 1/K Σ_k e(θ + 2πk)`.
//!
//! In few turns the waves of the other shafts do not average out, and what stays of them hardly changes from turn to turn, so that no
//! scatter tells of it. The fitted orders that are no multiples of the shaft are therefore taken off first.

use super::fit::{Fit, add};
use super::orders::Order;
use super::teeth::Teeth;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::spectrum::rotation::angular::AngularSignal;
use crate::spectrum::rotation::averaging::TurnAverage;
use crate::spectrum::rotation::interpolation::{Interpolator, REACH};

/// The mean turn of a shaft.
#[derive(Debug, Clone)]
pub struct MeanTurn {
    /// Such as `input`.
    pub shaft: String,
    /// Over the angle of that shaft, from its mark where it has one.
    pub average: TurnAverage,
}

/// Fewer cells a turn of a shaft show less than its second multiple.
const FEWEST: f64 = 8.0;

/// Of every shaft that turns twice or more, the output first. `input` is where the input's angle is zero, turns of the output.
///
/// # Errors
/// Those of the averages.
pub fn mean_turns(
    signal: &AngularSignal,
    fitted: &Fit,
    orders: &[Order],
    teeth: &Teeth,
    input: f64,
) -> Result<Vec<MeanTurn>, Error> {
    let mut all = Vec::new();
    for member in teeth.shafts().into_iter().rev() {
        let (own, waves): (Vec<Order>, Vec<Complex>) = (orders.iter().zip(&fitted.waves))
            .filter(|(o, _)| (&o.exact / &member.order).is_whole())
            .map(|(o, w)| (o.clone(), *w))
            .unzip();
        let mut alone = AngularSignal {
            values: fitted.residual.clone(),
            ..*signal
        };
        add(&mut alone, &own, &waves);
        let order = member.order.value();
        let cells = signal.per_turn as f64 / order;
        let zero = if member.name == "input" { input } else { 0.0 };
        let turning = match member.name == "output" {
            true => alone,
            false if cells < FEWEST => continue,
            false => over(&alone, order, zero, cells.ceil() as usize),
        };
        if turning.turns() >= 2 {
            all.push(MeanTurn {
                average: TurnAverage::new(&turning)?,
                shaft: member.name,
            });
        }
    }
    Ok(all)
}

/// A signal over the angle of a shaft that turns `order` times as often, its zero at `zero` turns.
fn over(signal: &AngularSignal, order: f64, zero: f64, per_turn: usize) -> AngularSignal {
    let (n, reach) = (signal.per_turn as f64, REACH as f64);
    let own = |cell: f64| ((signal.first as f64 + cell) / n - zero) * order * per_turn as f64;
    let first = own(reach).ceil() as i64;
    let last = own(signal.values.len() as f64 - 1.0 - reach).floor() as i64;
    let kernel = Interpolator::default();
    let value = |i: i64| {
        let turns = i as f64 / per_turn as f64 / order + zero;
        kernel.at(&signal.values, turns * n - signal.first as f64, 1.0)
    };
    AngularSignal {
        per_turn,
        first,
        values: (first..=last).map(value).collect(),
    }
}
