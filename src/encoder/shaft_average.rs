//! Synchronous average of each shaft, `ē(θ) = 1/K Σ_k e(θ + 2πk)`.
//!
//! In few turns the waves of the other shafts do not average out, and what stays of them hardly changes from turn to turn, so that no
//! scatter tells of it. The fitted orders that are no multiples of the shaft are therefore taken off first.

use super::fit::{HarmonicFit, add};
use super::gear_train::GearTrain;
use super::orders::CandidateOrder;
use crate::base::error::Error;
use crate::numeric::fraction::Fraction;
use crate::numeric::vector_ops::dot;
use crate::numeric::{Complex, parallel};
use crate::spectrum::rotation::angular_resampling::AngularSignal;
use crate::spectrum::rotation::interpolation::{
    HALF_KERNEL, InterpolationWeights, SincInterpolator,
};
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
            false => over_shaft_angle(&alone, &member.order, zero, cells.ceil() as usize),
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

/// Phases of the kernel that are tabulated at most, 80 weights each.
const MAX_PHASES: i64 = 1 << 14;

/// Values that a thread computes at a time.
const CHUNK: i64 = 1 << 16;

/// A signal over the angle of a shaft that turns `order` times as often, its zero at `zero` turns.
///
/// Orders are fractions, so that values fall on few phases between two cells: each phase has one set of weights.
fn over_shaft_angle(
    signal: &AngularSignal,
    order: &Fraction,
    zero: f64,
    per_turn: usize,
) -> AngularSignal {
    let (n, reach) = (signal.samples_per_rev as f64, HALF_KERNEL as f64);
    let origin = zero * n - signal.first as f64;
    // Cells from one value to the next.
    let step = &Fraction::new(signal.samples_per_rev as i64, per_turn as i64) / order;
    let cells = step.to_f64();
    let first = ((reach - origin) / cells).ceil() as i64;
    let last = ((signal.values.len() as f64 - 1.0 - reach - origin) / cells).floor() as i64;
    let kernel = SincInterpolator::default();
    let phases = step.parts().filter(|(_, count)| *count <= MAX_PHASES);
    let phases = phases.map(|(top, count)| KernelPhases::new(&kernel, origin, top, count));
    let value = |i: i64| match &phases {
        Some(phases) => phases.value_at(&signal.values, i),
        None => kernel.value_at(&signal.values, i as f64 * cells + origin, 1.0),
    };
    let starts: Vec<i64> = (first..=last).step_by(CHUNK as usize).collect();
    let chunks = parallel::map(&starts, |&start| -> Vec<f64> {
        (start..=last.min(start + CHUNK - 1)).map(value).collect()
    });
    AngularSignal {
        samples_per_rev: per_turn,
        first,
        values: chunks.concat(),
    }
}

/// Weights at the positions `origin + i top/count`, in samples, for any i.
struct KernelPhases {
    top: i64,
    count: i64,
    /// By `i top` modulo `count`.
    weights: Vec<InterpolationWeights>,
}

impl KernelPhases {
    fn new(kernel: &SincInterpolator, origin: f64, top: i64, count: i64) -> KernelPhases {
        let weights = (0..count).map(|phase| {
            let position = origin + phase as f64 / count as f64;
            let mut weights = kernel.weights_at(position - position.floor());
            weights.first += position.floor() as i64;
            weights
        });
        KernelPhases {
            top,
            count,
            weights: weights.collect(),
        }
    }

    /// The value at position i, where the kernel lies within the samples.
    fn value_at(&self, samples: &[f64], i: i64) -> f64 {
        let (whole, phase) = (
            (i * self.top).div_euclid(self.count),
            (i * self.top).rem_euclid(self.count),
        );
        let InterpolationWeights { first, weights } = &self.weights[phase as usize];
        // Rounding may let the last weight, next to nothing, fall beyond the ends.
        let from = (whole + first).max(0) as usize;
        let within = &samples[from.min(samples.len())..];
        dot(weights, &within[..weights.len().min(within.len())])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights by phase give what the kernel gives at each position.
    #[test]
    fn exact_phases() {
        let values: Vec<f64> = (0..4000)
            .map(|j| (0.37 * f64::from(j)).sin() + 2.0)
            .collect();
        let signal = AngularSignal {
            samples_per_rev: 192,
            first: -317,
            values,
        };
        let kernel = SincInterpolator::default();
        for (order, zero, per_turn) in [
            ((64, 21), 0.377, 63),
            ((5, 3), 0.0, 117),
            ((1, 7), -1.25, 1344),
        ] {
            let order = Fraction::new(order.0, order.1);
            let found = over_shaft_angle(&signal, &order, zero, per_turn);
            assert!(found.values.len() > 3000);
            for (i, value) in found.values.iter().enumerate() {
                let turns =
                    (found.first + i as i64) as f64 / per_turn as f64 / order.to_f64() + zero;
                let exact = kernel.value_at(&signal.values, turns * 192.0 + 317.0, 1.0);
                assert!((value - exact).abs() < 1e-11, "{value} {exact}");
            }
        }
    }
}
