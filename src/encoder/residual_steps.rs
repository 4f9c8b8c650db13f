//! Steps in the residual of the order fit: lost counts hidden by the mesh orders.
//!
//! `D_m = mean(r_m … r_{m+w}) − mean(r_{m−w} … r_m)` of the residual r over a pitch on either side says where. How large a step is comes
//! out of a fit of all orders and steps at once: with s⊥ what the orders leave of a step, `a = G⁻¹ ⟨s⊥, r⟩`, `G = ⟨s⊥, s⊥⟩`.

use std::borrow::Cow;
use std::ops::Range;

use super::fit::fit_orders;
use super::orders::CandidateOrder;
use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::statistics::median;
use crate::numeric::symmetric::lu_solve;
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// A step of the error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualStep {
    /// The first cell after it.
    pub cell: usize,
    /// By how much the error steps, rad of the output.
    pub size: f64,
}

/// A place is followed up where the residual steps by this share of a count: the orders of few turns take the rest.
const MIN_STEP_SHARE: f64 = 0.3;

/// And by so many deviations of what it does elsewhere.
const STEP_THRESHOLD: f64 = 8.0;

/// A step has at least this share of a count, and its joint fit no more than so many times what shows at its place.
const SHARE: (f64, f64) = (0.6, 4.0);

/// Places followed up.
const MAX_CANDIDATES: usize = 40;

/// Fewest cells on either side of a place.
const NARROW: usize = 8;

/// Fewest cells of a step of size 1 that the orders leave: with fewer the record does not resolve it from them.
const MIN_REMAINDER: f64 = 4.0;

/// The steps, in their order. `residual` is what `orders` leave of `signal`, `pitch` the cells of a tooth, `count` the smallest step that
/// a count of either encoder makes, rad of the output.
///
/// # Errors
/// Those of the fit.
pub fn find_residual_steps(
    signal: &AngularSignal,
    orders: &[CandidateOrder],
    residual: &[f64],
    pitch: usize,
    count: f64,
) -> Result<Vec<ResidualStep>, Error> {
    let n = residual.len();
    let wide = pitch.max(NARROW);
    if !(count > 0.0 && count.is_finite()) || n < 4 * wide {
        return Ok(Vec::new());
    }
    let mut masked: Vec<Range<usize>> = Vec::new();
    let mut left = Cow::Borrowed(residual);
    let mut found: Vec<(usize, Vec<f64>)> = Vec::new();
    let mut sizes: Vec<f64> = Vec::new();
    for _ in 0..MAX_CANDIDATES {
        let Some((cell, shows)) = strongest(&left, wide, &masked) else {
            break;
        };
        if shows.abs() < (MIN_STEP_SHARE * count).max(STEP_THRESHOLD * deviation(&left, wide)) {
            break;
        }
        masked.push(cell.saturating_sub(wide)..cell + wide);
        let after = |m: usize| if m < cell { 0.0 } else { 1.0 };
        let step = AngularSignal {
            values: (0..n).map(after).collect(),
            ..signal.clone()
        };
        found.push((cell, fit_orders(&step, orders)?.residual));
        let fitted = fit_jointly(&found, residual)?;
        let size = fitted.last().copied().unwrap_or(0.0);
        let is_step = size.abs() > SHARE.0 * count && size.abs() < SHARE.1 * shows.abs();
        if !is_step || product(&found[found.len() - 1].1, &found[found.len() - 1].1) < MIN_REMAINDER
        {
            found.pop();
            continue;
        }
        left = Cow::Borrowed(residual);
        for ((_, shape), size) in found.iter().zip(&fitted) {
            left.to_mut()
                .iter_mut()
                .zip(shape)
                .for_each(|(r, s)| *r -= size * s);
        }
        sizes = fitted;
    }
    let mut all: Vec<ResidualStep> = (found.iter().zip(&sizes))
        .map(|(&(cell, _), &size)| ResidualStep { cell, size })
        .filter(|step| step.size.abs() > SHARE.0 * count)
        .collect();
    all.sort_by_key(|step| step.cell);
    Ok(all)
}

/// Cells and D there, wherever both windows fit.
fn differences(values: &[f64], wide: usize) -> impl Iterator<Item = (usize, f64)> {
    let sum = |part: &[f64]| part.iter().sum::<f64>();
    let mut step = sum(&values[wide..2 * wide]) - sum(&values[..wide]);
    let ends = values.iter().zip(&values[wide..]).zip(&values[2 * wide..]);
    ends.enumerate().map(move |(m, ((before, here), after))| {
        let found = (m + wide, step / wide as f64);
        step += before - 2.0 * here + after;
        found
    })
}

fn strongest(values: &[f64], wide: usize, masked: &[Range<usize>]) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for (m, d) in differences(values, wide) {
        let is_more = best.is_none_or(|b| d.abs() >= b.1.abs());
        if is_more && !masked.iter().any(|cells| cells.contains(&m)) {
            best = Some((m, d));
        }
    }
    best
}

/// Deviation of D, from the median of its size at every window: between them it hardly changes.
fn deviation(values: &[f64], wide: usize) -> f64 {
    let all = differences(values, wide).step_by(wide);
    let mut sizes: Vec<f64> = all.map(|(_, d)| d.abs()).collect();
    // The median of the size of a normal variable is 0.6745 of its deviation.
    median(&mut sizes).unwrap_or(0.0) / 0.6745
}

/// The sizes of all steps at once.
fn fit_jointly(found: &[(usize, Vec<f64>)], residual: &[f64]) -> Result<Vec<f64>, Error> {
    let n = found.len();
    let gram = Matrix::from_fn(n, n, |i, j| product(&found[i].1, &found[j].1));
    let right = Matrix::from_fn(n, 1, |i, _| product(&found[i].1, residual));
    let x = lu_solve(&gram, &right)?;
    Ok((0..n).map(|i| x[(i, 0)]).collect())
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
