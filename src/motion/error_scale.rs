//! Reference size of every state for the error norm.

use std::ops::Range;

use super::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use super::problem::{IntegrationOptions, OdeProblem};
use super::signal::Signal;
use crate::machine::direction::Direction;

/// Scale of every state for the error norm.
///
/// The scale of a state of a machine is its largest past value, at least a thousandth of the largest in its group (positions, velocities,
/// internal states). A lower bound of the velocities is the velocity that the initial forces give in a step, `a h/(1 + h c/m + h² k/m)`,
/// and of the positions that velocity times the step, so that the scale is positive at a start from rest. The scale of a state of a plain
/// problem is its present value, at least a millionth of the largest past value of all states.
#[derive(Debug, Clone)]
pub struct ErrorScale {
    groups: Vec<Range<usize>>,
    uses_peaks: bool,
    share: f64,
    peaks: Vec<f64>,
    /// Coordinates under the initial forces; empty for a plain problem.
    forced: Vec<ForcedCoordinate>,
}

/// Acceleration of a coordinate and its damping and stiffness per inertia.
#[derive(Debug, Clone, Copy)]
struct ForcedCoordinate {
    /// Acceleration from rest, m/s² or rad/s².
    acceleration: f64,
    /// Damping over inertia, 1/s.
    damping: f64,
    /// Stiffness over inertia, 1/s².
    stiffness: f64,
}

impl ForcedCoordinate {
    /// Upper bound of the velocity after a step h, s, from rest.
    fn speed(&self, h: f64) -> f64 {
        self.acceleration * h / (1.0 + h * (self.damping + h * self.stiffness))
    }
}

impl ErrorScale {
    /// Scale for a machine over a whole integration run.
    pub fn for_model(model: &DynamicModel, options: &IntegrationOptions) -> ErrorScale {
        let n = model.coordinate_count();
        ErrorScale {
            forced: acceleration_scale(model, options),
            groups: vec![0..n, n..2 * n, 2 * n..model.len()],
            uses_peaks: true,
            share: 1e-3,
            peaks: vec![0.0; model.len()],
        }
    }

    /// Scale for a plain problem of `n` states.
    pub fn plain(n: usize) -> ErrorScale {
        ErrorScale {
            groups: vec![0..n],
            uses_peaks: false,
            share: 1e-6,
            peaks: vec![0.0; n],
            forced: Vec::new(),
        }
    }

    /// Updates the past maxima with the state y.
    pub fn update(&mut self, y: &[f64]) {
        for (peak, y) in self.peaks.iter_mut().zip(y) {
            *peak = peak.max(y.abs());
        }
    }

    /// Scale of every state in a step of length h, s, from state `a` to state `b`; positive.
    pub fn sizes(&self, a: &[f64], b: &[f64], h: f64) -> Vec<f64> {
        let present = |i: usize| a[i].abs().max(b[i].abs());
        let mut sizes = vec![0.0; a.len()];
        let mut largest: Vec<f64> = self
            .groups
            .iter()
            .map(|group| {
                let values = group.clone().map(|i| present(i).max(self.peaks[i]));
                values.fold(0.0, f64::max)
            })
            .collect();
        if let [positions, speeds, _] = largest.as_mut_slice() {
            let bounds = self.forced.iter().map(|p| p.speed(h));
            *speeds = bounds.fold(*speeds, f64::max);
            *positions = positions.max(h * *speeds);
        }
        for (group, largest) in self.groups.iter().zip(largest) {
            for i in group.clone() {
                let value = match self.uses_peaks {
                    true => present(i).max(self.peaks[i]),
                    false => present(i),
                };
                sizes[i] = value.max(self.share * largest).max(1e-280);
            }
        }
        sizes
    }
}

/// Absolute accelerations, summed, of every coordinate by the initial state, applied forces, displacement excitations and friction.
fn acceleration_scale(model: &DynamicModel, options: &IntegrationOptions) -> Vec<ForcedCoordinate> {
    let n = model.coordinate_count();
    let mut dy = vec![0.0; model.len()];
    model.derivative(options.from, &options.initial_state, &mut dy);
    // Rows of massless coordinates contain no acceleration.
    let initial = |i: usize| {
        if model.is_massless(i) {
            0.0
        } else {
            dy[n + i].abs()
        }
    };
    let mut sum: Vec<f64> = (0..n).map(initial).collect();
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
        let mut accelerations = vec![0.0; n];
        direction
            .entries()
            .for_each(|(i, a)| accelerations[i] += a * force);
        model.apply_inverse_mass(&mut accelerations);
        sum.iter_mut()
            .zip(accelerations)
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
    let (mut k, mut c) = (vec![0.0; n], vec![0.0; n]);
    for branch in &model.elements {
        // Only linear elements act at all times.
        if let ForceLaw::Linear { stiffness, damping } = branch.law {
            for (i, a) in branch.direction.entries() {
                k[i] += a * a * stiffness.abs();
                c[i] += a * a * damping.abs();
            }
        }
    }
    let massive = (0..n).filter(|&i| !model.is_massless(i));
    let coordinates = massive.map(|i| ForcedCoordinate {
        acceleration: sum[i],
        damping: c[i] / model.mass.entry(i, i),
        stiffness: k[i] / model.mass.entry(i, i),
    });
    coordinates.filter(|p| p.acceleration.is_finite()).collect()
}

fn stiffness(branch: &ForceElement) -> f64 {
    match &branch.law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) => contact.stiffness,
        _ => 0.0,
    }
}

/// Root mean square of the errors relative to their scales.
pub fn error_norm(errors: &[f64], sizes: &[f64]) -> f64 {
    let sum: f64 = errors
        .iter()
        .zip(sizes)
        .map(|(e, s)| (e / s) * (e / s))
        .sum();
    (sum / errors.len().max(1) as f64).sqrt()
}
