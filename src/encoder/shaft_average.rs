//! Synchronous average of each shaft, `ē(θ) = 1/K Σ_k e(θ + 2πk)`.
//!
//! In few turns the waves of the other shafts do not average out, and what stays of them hardly changes from turn to turn, so that no
//! scatter tells of it. The fitted orders that are no multiples of the shaft are therefore taken off first, and those that are come as
//! they are: what is averaged is the residual r of the fit, of whose square ē leaves `Σ r² − K Σ ē²`.

use std::f64::consts::TAU;

use super::fit::{HarmonicFit, add, fold};
use super::gear_train::GearTrain;
use super::orders::CandidateOrder;
use crate::numeric::fraction::Fraction;
use crate::numeric::vector_ops::dot;
use crate::numeric::{Complex, parallel};
use crate::spectrum::rotation::angular_resampling::AngularSignal;
use crate::spectrum::rotation::interpolation::{
    HALF_KERNEL, InterpolationWeights, SincInterpolator,
};

/// The mean turn of a shaft.
#[derive(Debug, Clone)]
pub struct ShaftAverage {
    /// Such as `input`.
    pub shaft: String,
    /// One turn over the angle of that shaft, from its mark where it has one, rad.
    pub values: Vec<f64>,
    /// Turns averaged, `K`.
    pub revolutions: usize,
    /// Standard error of the average at each angle, where what is left does not repeat, rad.
    pub standard_error: f64,
}

/// Fewer cells a turn of a shaft show less than its second multiple.
const MIN_CELLS: f64 = 8.0;

/// Averages of every shaft that turns twice or more, the output first. `input` is where the input's angle is zero, turns of the output.
pub fn shaft_averages(
    signal: &AngularSignal,
    fitted: &HarmonicFit,
    orders: &[CandidateOrder],
    teeth: &GearTrain,
    input: f64,
) -> Vec<ShaftAverage> {
    let mean_square = |values: &[f64]| dot(values, values) / values.len() as f64;
    let square = mean_square(&fitted.residual);
    let mut all = Vec::new();
    for member in teeth.shafts().into_iter().rev() {
        let zero = if member.name == "input" { input } else { 0.0 };
        let Some((values, revolutions)) = mean_turn(signal, &fitted.residual, &member.order, zero)
        else {
            continue;
        };
        let left = square - mean_square(&values);
        let (own, waves): (Vec<CandidateOrder>, Vec<Complex>) = (orders.iter().zip(&fitted.waves))
            .map(|(o, w)| {
                let multiple = CandidateOrder {
                    fraction: &o.fraction / &member.order,
                    value: o.value / member.order.to_f64(),
                    ..o.clone()
                };
                (multiple, w * Complex::from_polar(1.0, TAU * o.value * zero))
            })
            .filter(|(multiple, _)| multiple.fraction.is_integer())
            .unzip();
        let mut turn = AngularSignal {
            samples_per_rev: values.len(),
            first: 0,
            values,
        };
        add(&mut turn, &own, &waves);
        all.push(ShaftAverage {
            shaft: member.name,
            values: turn.values,
            revolutions,
            // Free of bias, over K − 1 of K turns.
            standard_error: (left.max(0.0) / (revolutions - 1) as f64).sqrt(),
        });
    }
    all
}

/// The mean turn of a shaft, from its zero at `zero` turns, and the number of turns; nothing of fewer than two.
///
/// Where the record holds twice the turns after which shaft and output meet again, it is averaged over these before it is resampled.
fn mean_turn(
    signal: &AngularSignal,
    residual: &[f64],
    order: &Fraction,
    zero: f64,
) -> Option<(Vec<f64>, usize)> {
    let cells = signal.samples_per_rev as f64 / order.to_f64();
    let revolutions = (residual.len() as f64 / cells) as usize;
    if cells < MIN_CELLS || revolutions < 2 {
        return None;
    }
    let per_turn = cells.ceil() as usize;
    let again = order.parts().and_then(|(own, turns)| {
        let period = usize::try_from(turns)
            .ok()?
            .checked_mul(signal.samples_per_rev)?;
        (period <= residual.len() / 2).then_some((usize::try_from(own).ok()?, period))
    });
    let (source, turns) = match again {
        // A turn of the output from its zero: the cells themselves.
        Some((1, period)) if period == per_turn && zero == 0.0 => {
            return Some((mean_over(residual, signal.first, period), revolutions));
        }
        Some((own, period)) => {
            let mean = mean_over(residual, signal.first, period);
            let reach = HALF_KERNEL + 1;
            let before = period - reach % period;
            let round = mean.into_iter().cycle().skip(before);
            (
                AngularSignal {
                    first: -(reach as i64),
                    values: round.take(period + 2 * reach).collect(),
                    ..*signal
                },
                own,
            )
        }
        None => (
            AngularSignal {
                values: residual.to_vec(),
                ..*signal
            },
            usize::MAX,
        ),
    };
    let mut turning = over_shaft_angle(&source, order, zero, per_turn);
    let turns = turns.min(turning.revolutions());
    turning.values.truncate(turns * per_turn);
    let revolutions = if again.is_some() { revolutions } else { turns };
    (turns > 0 && revolutions > 1).then(|| {
        let mean = mean_over(&turning.values, turning.first, per_turn);
        (mean, revolutions)
    })
}

/// Mean over each place of a period that a record holds at least once, the first at angle zero.
fn mean_over(values: &[f64], first: i64, period: usize) -> Vec<f64> {
    let start = first.rem_euclid(period as i64) as usize;
    let (whole, rest) = (values.len() / period, values.len() % period);
    let count = |place: usize| whole + usize::from((place + period - start) % period < rest);
    let sums = fold(values, first, period);
    let mean = |(place, sum): (usize, f64)| sum / count(place) as f64;
    sums.into_iter().enumerate().map(mean).collect()
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

    /// Over whole cycles the other waves average out: the mean turn is the shaft's own wave, from its zero on, whatever starts and ends the
    /// record.
    #[test]
    fn exact_mean_turn_of_cycles() {
        let (order, zero) = (Fraction::new(5, 3), 0.377);
        for (first, count) in [(-317, 3 * 576), (41, 20 * 576 + 13)] {
            let signal = AngularSignal {
                samples_per_rev: 192,
                first,
                values: Vec::new(),
            };
            let own = |turns: f64| (TAU * 2.0 * turns + 0.4).cos();
            let residual: Vec<f64> = (0..count)
                .map(|i| {
                    let turns = signal.angle(i) / TAU;
                    let others = (TAU * turns).cos() + (TAU * 4.0 / 3.0 * turns + 1.0).sin();
                    own((turns - zero) * 5.0 / 3.0) + if count == 3 * 576 { others } else { 0.0 }
                })
                .collect();
            let (mean, turns) = mean_turn(&signal, &residual, &order, zero).unwrap();
            assert_eq!((mean.len(), turns), (116, count * 5 / 576));
            for (i, e) in mean.iter().enumerate() {
                let expected = own(i as f64 / 116.0);
                assert!((e - expected).abs() < 2e-4, "{i}: {e} {expected}");
            }
        }
    }

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
