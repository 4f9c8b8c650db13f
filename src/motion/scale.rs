//! The size of every state, against which errors are measured.

use std::ops::Range;

use super::problem::{Ask, Problem};
use super::signal::Signal;
use super::train::{Branch, Law, Train};
use crate::machine::direction::Direction;

/// Sizes of states.
///
/// A state of a machine is measured by the largest value it has had, at least a thousandth of the largest of its kind
/// (positions, speeds, inner states), where speeds count at least for what the forces at hand give in a step against inertia, dampers and
/// springs, `a h/(1 + h c/m + h² k/m)`, and positions for what the speeds do; so a start from rest has a size too. A state of a plain problem is measured by its present value, at least a millionth
/// of the largest that any has had.
#[derive(Debug, Clone)]
pub struct Scale {
    kinds: Vec<Range<usize>>,
    remembers: bool,
    share: f64,
    peaks: Vec<f64>,
    /// What forces at hand do; none for a plain problem.
    pushed: Vec<Pushed>,
}

/// A coordinate under the forces at hand.
#[derive(Debug, Clone, Copy)]
struct Pushed {
    /// m/s² or rad/s².
    acceleration: f64,
    /// Of the dampers on it over its inertia, 1/s.
    damping: f64,
    /// Of the springs on it over its inertia, 1/s².
    stiffness: f64,
}

impl Pushed {
    /// The speed after a step, at most.
    fn speed(&self, h: f64) -> f64 {
        self.acceleration * h / (1.0 + h * (self.damping + h * self.stiffness))
    }
}

impl Scale {
    /// For a machine from the start of a run to its end.
    pub fn of_train(train: &Train, ask: &Ask) -> Scale {
        let n = train.n();
        Scale {
            pushed: pushed(train, ask),
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
            pushed: Vec::new(),
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
fn pushed(train: &Train, ask: &Ask) -> Vec<Pushed> {
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
            + (signal.bursts.iter())
                .map(|b| b.largest([ask.from, ask.to]))
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
    let (mut stiff, mut damped) = (vec![0.0; n], vec![0.0; n]);
    for branch in &train.branches {
        // What always joins its ends.
        if let Law::Linear { stiffness, damping } = branch.law {
            for (i, a) in branch.direction.scaled() {
                stiff[i] += a * a * stiffness.abs();
                damped[i] += a * a * damping.abs();
            }
        }
    }
    let heavy = (0..n).filter(|&i| !train.is_light(i));
    let each = heavy.map(|i| Pushed {
        acceleration: sum[i],
        damping: damped[i] / train.mass.at(i, i),
        stiffness: stiff[i] / train.mass.at(i, i),
    });
    each.filter(|p| p.acceleration.is_finite()).collect()
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
