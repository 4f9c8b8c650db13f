//! Reference size of every state for the error norm.

use std::ops::Range;

use super::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use super::problem::{IntegrationOptions, OdeProblem};
use super::signal::Signal;
use crate::machine::direction::Direction;

/// Sizes of states.
///
/// A state of a machine is measured by the largest value it has had, at least a thousandth of the largest of its kind
/// (positions, speeds, inner states), where speeds count at least for what the forces at hand give in a step against inertia, dampers and
/// springs, `a h/(1 + h c/m + h² k/m)`, and positions for what the speeds do; so a start from rest has a size too. A state of a plain problem is measured by its present value, at least a millionth
/// of the largest that any has had.
#[derive(Debug, Clone)]
pub struct ErrorScale {
    kinds: Vec<Range<usize>>,
    remembers: bool,
    share: f64,
    peaks: Vec<f64>,
    /// Coordinates under the present forces; empty for a plain problem.
    pushed: Vec<ForcedCoordinate>,
}

/// A coordinate under the forces at hand.
#[derive(Debug, Clone, Copy)]
struct ForcedCoordinate {
    /// m/s² or rad/s².
    acceleration: f64,
    /// Damping on the coordinate over its inertia, 1/s.
    damping: f64,
    /// Stiffness on the coordinate over its inertia, 1/s².
    stiffness: f64,
}

impl ForcedCoordinate {
    /// The speed after a step, at most.
    fn speed(&self, h: f64) -> f64 {
        self.acceleration * h / (1.0 + h * (self.damping + h * self.stiffness))
    }
}

impl ErrorScale {
    /// For a machine from the start of a run to its end.
    pub fn for_model(model: &DynamicModel, options: &IntegrationOptions) -> ErrorScale {
        let n = model.coordinate_count();
        ErrorScale {
            pushed: acceleration_scale(model, options),
            kinds: vec![0..n, n..2 * n, 2 * n..model.len()],
            remembers: true,
            share: 1e-3,
            peaks: vec![0.0; model.len()],
        }
    }

    /// For a plain problem of `coordinate_count` states.
    pub fn plain(n: usize) -> ErrorScale {
        ErrorScale {
            kinds: vec![0..n],
            remembers: false,
            share: 1e-6,
            peaks: vec![0.0; n],
            pushed: Vec::new(),
        }
    }

    /// Takes note of a state reached.
    pub fn update(&mut self, y: &[f64]) {
        for (peak, y) in self.peaks.iter_mut().zip(y) {
            *peak = peak.max(y.abs());
        }
    }

    /// The size of every state in a step of length `h` from `a` to `b`; above zero.
    pub fn sizes(&self, a: &[f64], b: &[f64], h: f64) -> Vec<f64> {
        let now = |i: usize| a[i].abs().max(b[i].abs());
        let mut sizes = vec![0.0; a.len()];
        let mut largest: Vec<f64> = self
            .kinds
            .iter()
            .map(|kind| {
                let so_far = kind.clone().map(|i| now(i).max(self.peaks[i]));
                so_far.fold(0.0, f64::max)
            })
            .collect();
        if let [positions, speeds, _] = largest.as_mut_slice() {
            let given = self.pushed.iter().map(|p| p.speed(h));
            *speeds = given.fold(*speeds, f64::max);
            *positions = positions.max(h * *speeds);
        }
        for (kind, largest) in self.kinds.iter().zip(largest) {
            for i in kind.clone() {
                let own = match self.remembers {
                    true => now(i).max(self.peaks[i]),
                    false => now(i),
                };
                sizes[i] = own.max(self.share * largest).max(1e-280);
            }
        }
        sizes
    }
}

/// Every coordinate under forces at hand: at the start, by drives, imposed deflections and friction.
fn acceleration_scale(model: &DynamicModel, options: &IntegrationOptions) -> Vec<ForcedCoordinate> {
    let n = model.coordinate_count();
    let mut slope = vec![0.0; model.len()];
    model.derivative(options.from, &options.initial_state, &mut slope);
    // Rows of coordinates without inertia hold no acceleration.
    let of = |i: usize| {
        if model.is_massless(i) {
            0.0
        } else {
            slope[n + i].abs()
        }
    };
    let mut sum: Vec<f64> = (0..n).map(of).collect();
    let size = |signal: &Signal| -> f64 {
        let lines = signal
            .knots
            .iter()
            .map(|k| {
                let ends = [options.from.max(k.time), options.to];
                ends.map(|t| k.value_at(t).abs())
                    .into_iter()
                    .fold(0.0, f64::max)
            })
            .fold(0.0, f64::max);
        lines
            + signal
                .harmonics
                .iter()
                .map(|h| h.amplitude.abs())
                .sum::<f64>()
            + (signal.bursts.iter())
                .map(|b| b.largest([options.from, options.to]))
                .sum::<f64>()
    };
    let mut add = |direction: &Direction, force: f64| {
        let mut pushed = vec![0.0; n];
        direction
            .entries()
            .for_each(|(i, a)| pushed[i] += a * force);
        model.apply_inverse_mass(&mut pushed);
        sum.iter_mut()
            .zip(pushed)
            .for_each(|(sum, a)| *sum += a.abs());
    };
    for drive in &model.forces {
        add(&drive.direction, size(&drive.signal));
    }
    for branch in &model.elements {
        if let Some(e) = &branch.imposed_displacement {
            add(branch.force_direction(), stiffness(branch) * size(e));
        }
        if let ForceLaw::Friction(friction) | ForceLaw::Clutch { friction, .. } = &branch.law {
            add(branch.force_direction(), friction.breakaway);
        }
    }
    let (mut stiff, mut damped) = (vec![0.0; n], vec![0.0; n]);
    for branch in &model.elements {
        // What always joins its ends.
        if let ForceLaw::Linear { stiffness, damping } = branch.law {
            for (i, a) in branch.direction.entries() {
                stiff[i] += a * a * stiffness.abs();
                damped[i] += a * a * damping.abs();
            }
        }
    }
    let heavy = (0..n).filter(|&i| !model.is_massless(i));
    let each = heavy.map(|i| ForcedCoordinate {
        acceleration: sum[i],
        damping: damped[i] / model.mass.entry(i, i),
        stiffness: stiff[i] / model.mass.entry(i, i),
    });
    each.filter(|p| p.acceleration.is_finite()).collect()
}

fn stiffness(branch: &ForceElement) -> f64 {
    match &branch.law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) => contact.stiffness,
        _ => 0.0,
    }
}

/// Root mean square of errors over sizes.
pub fn error_norm(errors: &[f64], sizes: &[f64]) -> f64 {
    let sum: f64 = errors
        .iter()
        .zip(sizes)
        .map(|(e, s)| (e / s) * (e / s))
        .sum();
    (sum / errors.len().max(1) as f64).sqrt()
}
