//! Synchronous average of each shaft, `ē(θ) = 1/K Σ_k e(θ + 2πk)`.
//!
//! Over few revolutions the orders of other shafts do not average out, and their remainder hardly varies between revolutions, so that
//! the scatter does not contain it. The average is therefore that of the residual r of the order fit, plus the fitted multiples of the
//! shaft order; the residual variance follows from `Σ r² − K Σ ē²`.

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

/// Synchronous average of the transmission error over one shaft revolution.
#[derive(Debug, Clone)]
pub struct ShaftAverage {
    /// Name of the shaft, such as `input`.
    pub shaft: String,
    /// Average over the angle of the shaft, from its index mark if present, rad of the output.
    pub values: Vec<f64>,
    /// Number of revolutions averaged, `K`.
    pub revolutions: usize,
    /// Standard error of the average at each angle, for a residual without periodicity, rad of the output.
    pub standard_error: f64,
}

/// Minimum number of cells per shaft revolution, for two harmonics.
const MIN_CELLS: f64 = 8.0;

/// Synchronous averages of all shafts with two revolutions or more, output first; `input`: origin of the input angle, output revolutions.
pub fn shaft_averages(
    signal: &AngularSignal,
    fitted: &HarmonicFit,
    orders: &[CandidateOrder],
    teeth: &GearTrain,
    input: f64,
) -> Vec<ShaftAverage> {
    let mean_square = |values: &[f64]| dot(values, values) / values.len() as f64;
    let variance = mean_square(&fitted.residual);
    let mut averages = Vec::new();
    for shaft in teeth.shafts().into_iter().rev() {
        let zero = if shaft.name == "input" { input } else { 0.0 };
        let Some((values, revolutions)) = mean_turn(signal, &fitted.residual, &shaft.order, zero)
        else {
            continue;
        };
        let residual_variance = variance - mean_square(&values);
        let (terms, waves) = (orders.iter().zip(&fitted.waves))
            .map(|(o, w)| {
                let multiple = CandidateOrder {
                    fraction: &o.fraction / &shaft.order,
                    value: o.value / shaft.order.to_f64(),
                    ..o.clone()
                };
                (multiple, w * Complex::from_polar(1.0, TAU * o.value * zero))
            })
            .filter(|(multiple, _)| multiple.fraction.is_integer())
            .unzip::<_, _, Vec<_>, Vec<_>>();
        let mut average = AngularSignal {
            samples_per_rev: values.len(),
            first: 0,
            values,
        };
        add(&mut average, &terms, &waves);
        averages.push(ShaftAverage {
            shaft: shaft.name,
            values: average.values,
            revolutions,
            // Unbiased with K − 1 degrees of freedom of K revolutions.
            standard_error: (residual_variance.max(0.0) / (revolutions - 1) as f64).sqrt(),
        });
    }
    averages
}

/// Synchronous average of the residual from the origin `zero`, output revolutions, and the number of revolutions; `None` for fewer than two.
///
/// A record of two common periods of shaft and output or more is averaged over the common period before it is resampled.
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
    let common = order.parts().and_then(|(shaft_turns, turns)| {
        let period = usize::try_from(turns)
            .ok()?
            .checked_mul(signal.samples_per_rev)?;
        (period <= residual.len() / 2).then_some((usize::try_from(shaft_turns).ok()?, period))
    });
    let (source, turns) = match common {
        // The output angle from its origin needs no resampling.
        Some((1, period)) if period == per_turn && zero == 0.0 => {
            return Some((mean_over(residual, signal.first, period), revolutions));
        }
        Some((shaft_turns, period)) => {
            let mean = mean_over(residual, signal.first, period);
            let margin = HALF_KERNEL + 1;
            let before = period - margin % period;
            let periodic = mean.into_iter().cycle().skip(before);
            (
                AngularSignal {
                    first: -(margin as i64),
                    values: periodic.take(period + 2 * margin).collect(),
                    ..*signal
                },
                shaft_turns,
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
    let mut resampled = over_shaft_angle(&source, order, zero, per_turn);
    let turns = turns.min(resampled.revolutions());
    resampled.values.truncate(turns * per_turn);
    let revolutions = if common.is_some() { revolutions } else { turns };
    (turns > 0 && revolutions > 1).then(|| {
        let mean = mean_over(&resampled.values, resampled.first, per_turn);
        (mean, revolutions)
    })
}

/// Mean of each position of a period, the first at angle zero; the record covers one period or more.
fn mean_over(values: &[f64], first: i64, period: usize) -> Vec<f64> {
    let start = first.rem_euclid(period as i64) as usize;
    let (periods, extra) = (values.len() / period, values.len() % period);
    let count = |k: usize| periods + usize::from((k + period - start) % period < extra);
    let sums = fold(values, first, period);
    let mean = |(k, sum): (usize, f64)| sum / count(k) as f64;
    sums.into_iter().enumerate().map(mean).collect()
}

/// Maximum number of tabulated kernel phases, 80 weights each.
const MAX_PHASES: i64 = 1 << 14;

/// Number of values per task of a thread.
const CHUNK: i64 = 1 << 16;

/// Signal resampled over the angle of a shaft of the given order, with its origin at `zero` output revolutions.
///
/// Orders are fractions: the interpolation has few phases between two cells, each with one set of weights.
fn over_shaft_angle(
    signal: &AngularSignal,
    order: &Fraction,
    zero: f64,
    per_turn: usize,
) -> AngularSignal {
    let (n, margin) = (signal.samples_per_rev as f64, HALF_KERNEL as f64);
    let origin = zero * n - signal.first as f64;
    // Spacing of the values, cells.
    let step = &Fraction::new(signal.samples_per_rev as i64, per_turn as i64) / order;
    let cells = step.to_f64();
    let first = ((margin - origin) / cells).ceil() as i64;
    let last = ((signal.values.len() as f64 - 1.0 - margin - origin) / cells).floor() as i64;
    let kernel = SincInterpolator::default();
    let phases = step.parts().filter(|(_, count)| *count <= MAX_PHASES);
    let phases = phases.map(|(p, count)| KernelPhases::new(&kernel, origin, p, count));
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

/// Interpolation weights at the positions `origin + i numerator/count`, samples.
struct KernelPhases {
    numerator: i64,
    count: i64,
    /// Weights by `i numerator` modulo `count`.
    weights: Vec<InterpolationWeights>,
}

impl KernelPhases {
    fn new(kernel: &SincInterpolator, origin: f64, numerator: i64, count: i64) -> KernelPhases {
        let weights = (0..count).map(|phase| {
            let position = origin + phase as f64 / count as f64;
            let mut weights = kernel.weights_at(position - position.floor());
            weights.first += position.floor() as i64;
            weights
        });
        KernelPhases {
            numerator,
            count,
            weights: weights.collect(),
        }
    }

    /// Interpolated value at position i; the kernel lies within the samples.
    fn value_at(&self, samples: &[f64], i: i64) -> f64 {
        let (offset, phase) = (
            (i * self.numerator).div_euclid(self.count),
            (i * self.numerator).rem_euclid(self.count),
        );
        let InterpolationWeights { first, weights } = &self.weights[phase as usize];
        // By rounding the last weight, nearly zero, may lie beyond the ends.
        let start = (offset + first).max(0) as usize;
        let covered = &samples[start.min(samples.len())..];
        dot(weights, &covered[..weights.len().min(covered.len())])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over complete cycles the orders of other shafts average out: the average is the wave of the shaft from its origin, for any start
    /// and end of the record.
    #[test]
    fn exact_mean_turn_of_cycles() {
        let (order, zero) = (Fraction::new(5, 3), 0.377);
        for (first, count) in [(-317, 3 * 576), (41, 20 * 576 + 13)] {
            let signal = AngularSignal {
                samples_per_rev: 192,
                first,
                values: Vec::new(),
            };
            let wave = |turns: f64| (TAU * 2.0 * turns + 0.4).cos();
            let residual: Vec<f64> = (0..count)
                .map(|i| {
                    let turns = signal.angle(i) / TAU;
                    let others = (TAU * turns).cos() + (TAU * 4.0 / 3.0 * turns + 1.0).sin();
                    wave((turns - zero) * 5.0 / 3.0) + if count == 3 * 576 { others } else { 0.0 }
                })
                .collect();
            let (mean, turns) = mean_turn(&signal, &residual, &order, zero).unwrap();
            assert_eq!((mean.len(), turns), (116, count * 5 / 576));
            for (i, e) in mean.iter().enumerate() {
                let expected = wave(i as f64 / 116.0);
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
