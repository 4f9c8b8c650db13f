//! Steps in the residual of the order fit: lost counts hidden by the mesh orders.
//!
//! `D_m = mean(r_m … r_{m+w}) − mean(r_{m−w} … r_m)` of the residual r over a pitch on either side locates the steps. Their heights follow
//! from a joint fit of orders and steps: `a = G⁻¹ ⟨s⊥, r⟩`, `G = ⟨s⊥, s⊥⟩`, s⊥ the residuals of unit steps after the order fit.

use std::borrow::Cow;
use std::ops::Range;

use super::fit::fit_orders;
use super::orders::CandidateOrder;
use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::statistics::median;
use crate::numeric::symmetric::lu_solve;
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Step of the transmission error in the residual of the order fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualStep {
    /// First cell after the step.
    pub cell: usize,
    /// Height of the step, rad of the output.
    pub size: f64,
}

/// Least step of the residual at a candidate, in counts; in short records the orders absorb most of a step.
const MIN_STEP_SHARE: f64 = 0.3;

/// Least step of the residual at a candidate, in standard deviations of D.
const STEP_THRESHOLD: f64 = 8.0;

/// Limits of the fitted height: least in counts, largest as a multiple of D at the step.
const HEIGHT: (f64, f64) = (0.6, 4.0);

/// Maximum number of candidate steps.
const MAX_CANDIDATES: usize = 40;

/// Least window on either side of a step, cells.
const MIN_WINDOW: usize = 8;

/// Least `⟨s⊥, s⊥⟩` of a unit step, cells: below it the record does not resolve the step from the orders.
const MIN_REMAINDER: f64 = 4.0;

/// Steps of the residual in the order of the cells. `residual`: of the fit of `orders` to `signal`; `pitch`: cells per tooth; `count`:
/// smaller count angle of the two encoders, rad of the output.
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
    let window = pitch.max(MIN_WINDOW);
    if !(count > 0.0 && count.is_finite()) || n < 4 * window {
        return Ok(Vec::new());
    }
    let mut masked: Vec<Range<usize>> = Vec::new();
    let mut remaining = Cow::Borrowed(residual);
    let mut steps: Vec<(usize, Vec<f64>)> = Vec::new();
    let mut sizes: Vec<f64> = Vec::new();
    for _ in 0..MAX_CANDIDATES {
        let Some((cell, d)) = strongest(&remaining, window, &masked) else {
            break;
        };
        if d.abs() < (MIN_STEP_SHARE * count).max(STEP_THRESHOLD * deviation(&remaining, window)) {
            break;
        }
        masked.push(cell.saturating_sub(window)..cell + window);
        let after = |m: usize| if m < cell { 0.0 } else { 1.0 };
        let step = AngularSignal {
            values: (0..n).map(after).collect(),
            ..signal.clone()
        };
        steps.push((cell, fit_orders(&step, orders)?.residual));
        let fitted = fit_jointly(&steps, residual)?;
        let size = fitted.last().copied().unwrap_or(0.0);
        let is_step = size.abs() > HEIGHT.0 * count && size.abs() < HEIGHT.1 * d.abs();
        if !is_step || product(&steps[steps.len() - 1].1, &steps[steps.len() - 1].1) < MIN_REMAINDER
        {
            steps.pop();
            continue;
        }
        remaining = Cow::Borrowed(residual);
        for ((_, residual_step), size) in steps.iter().zip(&fitted) {
            for (r, s) in remaining.to_mut().iter_mut().zip(residual_step) {
                *r -= size * s;
            }
        }
        sizes = fitted;
    }
    let mut accepted: Vec<ResidualStep> = (steps.iter().zip(&sizes))
        .map(|(&(cell, _), &size)| ResidualStep { cell, size })
        .filter(|step| step.size.abs() > HEIGHT.0 * count)
        .collect();
    accepted.sort_by_key(|step| step.cell);
    Ok(accepted)
}

/// Cells and D, for all cells with both windows inside the record.
fn differences(values: &[f64], w: usize) -> impl Iterator<Item = (usize, f64)> {
    let sum = |cells: &[f64]| cells.iter().sum::<f64>();
    let mut step = sum(&values[w..2 * w]) - sum(&values[..w]);
    let ends = values.iter().zip(&values[w..]).zip(&values[2 * w..]);
    ends.enumerate().map(move |(m, ((before, middle), after))| {
        let result = (m + w, step / w as f64);
        step += before - 2.0 * middle + after;
        result
    })
}

fn strongest(values: &[f64], window: usize, masked: &[Range<usize>]) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for (m, d) in differences(values, window) {
        let is_larger = best.is_none_or(|b| d.abs() >= b.1.abs());
        if is_larger && !masked.iter().any(|cells| cells.contains(&m)) {
            best = Some((m, d));
        }
    }
    best
}

/// Standard deviation of D, by the median of |D| at one cell per window; D hardly varies within a window.
fn deviation(values: &[f64], window: usize) -> f64 {
    let sampled = differences(values, window).step_by(window);
    let mut sizes: Vec<f64> = sampled.map(|(_, d)| d.abs()).collect();
    // The median of the size of a normal variable is 0.6745 of its deviation.
    median(&mut sizes).unwrap_or(0.0) / 0.6745
}

/// Joint least-squares fit of the heights of all steps.
fn fit_jointly(steps: &[(usize, Vec<f64>)], residual: &[f64]) -> Result<Vec<f64>, Error> {
    let n = steps.len();
    let gram = Matrix::from_fn(n, n, |i, j| product(&steps[i].1, &steps[j].1));
    let right = Matrix::from_fn(n, 1, |i, _| product(&steps[i].1, residual));
    let x = lu_solve(&gram, &right)?;
    Ok((0..n).map(|i| x[(i, 0)]).collect())
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
