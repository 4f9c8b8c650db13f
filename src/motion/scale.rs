//! The size of every state, against which errors are measured.

use std::ops::Range;

use super::problem::{Ask, Problem};
use super::signal::Signal;
use super::train::{Branch, Law, Train};
use crate::machine::direction::Direction;

/// Sizes of states.
///
/// A state of a machine is measured by the largest value it has had, at least a thousandth of the largest of its kind
/// (positions, speeds, inner states), where speeds count at least for what the forces at hand give in a step, and positions
/// for what the speeds do; so a start from rest has a size too. A state of a plain problem is measured by its present value, at least a millionth
/// of the largest that any has had.
#[derive(Debug, Clone)]
pub struct Scale {
    kinds: Vec<Range<usize>>,
    remembers: bool,
    share: f64,
    peaks: Vec<f64>,
    /// The largest acceleration that forces at hand give, m/s² or rad/s²; zero for a plain problem.
    acceleration: f64,
}

impl Scale {
    /// For a machine from the start of a run to its end.
    pub fn of_train(train: &Train, ask: &Ask) -> Scale {
        let n = train.n();
        Scale {
            acceleration: acceleration(train, ask),
            kinds: vec![0..n, n..2 * n, 2 * n..train.len()],
            remembers: true,
            share: 1e-3,
            peaks: vec![0.0; train.len()],
        }
    }

    /// For a plain problem of `n` states.
    pub fn plain(n: usize) -> Scale {
        Scale {
            kinds: vec![0..n],
            remembers: false,
            share: 1e-6,
            peaks: vec![0.0; n],
            acceleration: 0.0,
        }
    }

    /// Takes note of a state reached.
    pub fn note(&mut self, y: &[f64]) {
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
            *speeds = speeds.max(h * self.acceleration);
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

/// The largest acceleration of a coordinate by forces at hand: at the start, by drives, imposed deflections and friction.
fn acceleration(train: &Train, ask: &Ask) -> f64 {
    let n = train.n();
    let mut slope = vec![0.0; train.len()];
    train.slope(ask.from, &ask.start, &mut slope);
    // Rows of coordinates without inertia hold no acceleration.
    let of = |i: usize| {
        if train.is_light(i) {
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
                let ends = [ask.from.max(k.time), ask.to];
                ends.map(|t| k.line(t).abs())
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
    };
    let mut add = |direction: &Direction, force: f64| {
        let mut pushed = vec![0.0; n];
        direction.scaled().for_each(|(i, a)| pushed[i] += a * force);
        train.accelerate(&mut pushed);
        sum.iter_mut()
            .zip(pushed)
            .for_each(|(sum, a)| *sum += a.abs());
    };
    for drive in &train.drives {
        add(&drive.direction, size(&drive.signal));
    }
    for branch in &train.branches {
        if let Some(e) = &branch.imposed {
            add(branch.acts(), stiffness(branch) * size(e));
        }
        if let Law::Friction(friction) | Law::Clutch { friction, .. } = &branch.law {
            add(branch.acts(), friction.breakaway);
        }
    }
    sum.into_iter()
        .filter(|a| a.is_finite())
        .fold(0.0, f64::max)
}

fn stiffness(branch: &Branch) -> f64 {
    match &branch.law {
        Law::Linear { stiffness, .. } => *stiffness,
        Law::Contact(contact) => contact.stiffness,
        _ => 0.0,
    }
}

/// Root mean square of errors over sizes.
pub fn norm(errors: &[f64], sizes: &[f64]) -> f64 {
    let sum: f64 = errors
        .iter()
        .zip(sizes)
        .map(|(e, s)| (e / s) * (e / s))
        .sum();
    (sum / errors.len().max(1) as f64).sqrt()
}
