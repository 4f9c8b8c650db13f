//! The size of every state, against which errors are measured.

use std::ops::Range;

use super::problem::Problem;
use super::train::Train;

/// Sizes of states.
///
/// A state of a machine is measured by the largest value it has had, at least a thousandth of the largest of its kind
/// (positions, speeds, inner states). A state of a plain problem is measured by its present value, at least a millionth
/// of the largest that any has had.
#[derive(Debug, Clone)]
pub struct Scale {
    kinds: Vec<Range<usize>>,
    remembers: bool,
    share: f64,
    peaks: Vec<f64>,
}

impl Scale {
    /// For a machine.
    pub fn of_train(train: &Train) -> Scale {
        let n = train.n();
        Scale {
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
        }
    }

    /// Takes note of a state reached.
    pub fn note(&mut self, y: &[f64]) {
        for (peak, y) in self.peaks.iter_mut().zip(y) {
            *peak = peak.max(y.abs());
        }
    }

    /// The size of every state between `a` and `b`; above zero.
    pub fn sizes(&self, a: &[f64], b: &[f64]) -> Vec<f64> {
        let now = |i: usize| a[i].abs().max(b[i].abs());
        let mut sizes = vec![0.0; a.len()];
        for kind in &self.kinds {
            let largest = kind
                .clone()
                .map(|i| now(i).max(self.peaks[i]))
                .fold(0.0, f64::max);
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

/// Root mean square of errors over sizes.
pub fn norm(errors: &[f64], sizes: &[f64]) -> f64 {
    let sum: f64 = errors
        .iter()
        .zip(sizes)
        .map(|(e, s)| (e / s) * (e / s))
        .sum();
    (sum / errors.len().max(1) as f64).sqrt()
}
