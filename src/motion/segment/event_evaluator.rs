//! Evaluators of event functions: value, rates and bounds in one pass over the modal parts.

use super::modal_parts::NonOscillatoryPart;
use crate::numeric::Complex;

/// Lanes that evaluate a part, weighted by its coefficients in a switching function: p, ṗ, p, ṗ, p̈, p̈, the bound on p̈, that on the third
/// derivative.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(16))]
pub struct SumLanes(pub [f64; LANES]);

/// Number of sums that evaluate a switching function.
pub const LANES: usize = 8;

/// Weight of every part in each lane of a switching function's row c.
#[derive(Debug)]
pub struct EventEvaluator(pub Vec<SumLanes>);

impl EventEvaluator {
    /// Event evaluator of a row over the parts, of the row that gives ṗ, and of the sizes |c|.
    pub fn new(turning: &[Complex], row: &[f64], rate: &[f64], sizes: &[f64]) -> EventEvaluator {
        let pairs = row.chunks_exact(2).zip(rate.chunks_exact(2));
        let turning = turning.iter().zip(pairs).zip(sizes);
        let mut lanes: Vec<SumLanes> = turning
            .map(|((lambda, (c, r)), size)| {
                let bent = Complex::new(c[0], -c[1]) * lambda * lambda;
                let (fast, bound) = (lambda.norm(), size * lambda.norm_sqr());
                let [x, y] = [bent.re, -bent.im];
                SumLanes([c[0], r[0], c[1], r[1], x, y, bound, bound * fast])
            })
            .collect();
        let first = 2 * lanes.len();
        let others = row[first..].iter().zip(&rate[first..]);
        let other = |(&c, &r): (&f64, &f64)| SumLanes([c, r, 0.0, 0.0, c, 0.0, c.abs(), c.abs()]);
        lanes.extend(others.map(other));
        EventEvaluator(lanes)
    }

    /// +1 where it is the same, −1 where it reads the negative.
    pub fn sign(&self, other: &EventEvaluator) -> Option<f64> {
        let is = |sign: f64| {
            let mut pairs = self.0.iter().zip(&other.0);
            pairs.all(|(SumLanes(a), SumLanes(b))| (0..6).all(|k| a[k] == sign * b[k]))
        };
        [1.0, -1.0].into_iter().find(|sign| is(*sign))
    }
}

/// Removes from all evaluators the parts behind the first `turning` that none of them depends on; a flag for each of these parts.
pub fn prune_unused_parts(
    evaluators: &mut [EventEvaluator],
    turning: usize,
    others: &[NonOscillatoryPart],
) -> Vec<bool> {
    let mut unseen = Vec::with_capacity(others.len());
    let mut at = turning;
    for other in others {
        let states = at..at + other.count();
        let sees = |SumLanes(lane): &SumLanes| lane[0] != 0.0 || lane[1] != 0.0;
        let seen = evaluators
            .iter()
            .any(|s| s.0[states.clone()].iter().any(sees));
        match seen {
            true => at = states.end,
            false => evaluators.iter_mut().for_each(|s| {
                s.0.drain(states.clone());
            }),
        }
        unseen.push(!seen);
    }
    unseen
}
