//! Curve of periodic solutions over speed by arc-length continuation.

use super::bifurcation::{Bifurcation, find_folds, stability_changes};
use super::continuation::Continuation;
pub use super::continuation::{ContinuationOptions, DEFAULT_TOLERANCE};
use super::family::SpeedFamily;
use super::linear_part::LinearPart;
use super::period_doubling::{PeriodDoubledBranch, follow_period_doublings};
use super::point::{PeriodicSolution, PointOptions};
use crate::base::code::Code;
use crate::base::error::Error;

/// Curve of periodic solutions over frequency with its bifurcations.
#[derive(Debug, Clone)]
pub struct SolutionCurve {
    /// Solutions in the order along the curve.
    pub points: Vec<PeriodicSolution>,
    /// Folds and other bifurcations in the order along the curve.
    pub bifurcations: Vec<Bifurcation>,
    /// Period-doubled branches; empty unless solutions are refined with events.
    pub period_doubled: Vec<PeriodDoubledBranch>,
    /// Whether the number of unknowns limited the orders at some points.
    pub order_limited: bool,
    /// Error that ended the curve before the end of the range.
    pub stopped_by: Option<Error>,
}

/// Smallest step, as a share of the largest; a corrector failure at it ends the curve.
const MIN_STEP: f64 = 1e-7;

/// Smallest cosine between successive tangents; below it the step is halved unless it is already short.
const MIN_COSINE: f64 = 0.9;

/// Largest predictor deviation, in steps; a larger one indicates a jump to another part of the curve.
const MAX_DEVIATION: f64 = 0.5;

/// Largest predictor deviation of a short step, which may contain a corner of the curve (onset of contact loss).
const MAX_DEVIATION_SHORT: f64 = 4.0;

/// Follows the curve of periodic solutions; `progress` is called with the completed share, 0 to 1.
///
/// # Errors
/// An invalid range; `NoConvergence` without a solution at the first speed; errors of the linear part.
pub fn continue_curve(
    family: &SpeedFamily,
    options: PointOptions,
    setup: ContinuationOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<SolutionCurve, Error> {
    let is_valid = [setup.from, setup.to, setup.step, setup.tolerance]
        .iter()
        .all(|x| x.is_finite() && *x > 0.0);
    if !is_valid || setup.from == setup.to {
        let message = format!(
            "a curve from {} to {} rad/s in steps of {} is impossible",
            setup.from, setup.to, setup.step
        );
        return Err(
            Error::new(Code::OutOfRange, message).with_hint("give two different speeds above zero")
        );
    }
    let lines = LinearPart::new(family);
    let mut path = Continuation::new(family, &lines, options, setup)?;
    trace(&mut path, progress)
}

fn trace(path: &mut Continuation, progress: &mut dyn FnMut(f64)) -> Result<SolutionCurve, Error> {
    let ContinuationOptions {
        from,
        to,
        step,
        max_points,
        ..
    } = path.setup;
    let mut current = path.first_point()?;
    let max_step = step / path.span;
    let mut length = 0.2 * max_step;
    let mut curve = SolutionCurve {
        points: Vec::new(),
        bifurcations: Vec::new(),
        period_doubled: Vec::new(),
        order_limited: false,
        stopped_by: None,
    };
    let (mut curve_points, mut steps) = (vec![current.clone()], Vec::new());
    curve.points.push(path.solution(&current)?);
    let (low, high) = (from.min(to), from.max(to));
    while curve.points.len() < max_points {
        let result = path.step(&current, length);
        let is_shortest = length <= MIN_STEP * max_step;
        let next = match result {
            Ok((next, iterations)) => {
                let cosine: f64 = match next.orders == current.orders {
                    true => next
                        .tangent
                        .iter()
                        .zip(&current.tangent)
                        .map(|(a, b)| a * b)
                        .sum(),
                    false => 1.0,
                };
                let is_short = length <= 1e-3 * max_step;
                let deviation = path.predictor_deviation(&current, &next, length);
                if (cosine < MIN_COSINE && !is_short)
                    || deviation
                        > if is_short {
                            MAX_DEVIATION_SHORT
                        } else {
                            MAX_DEVIATION
                        }
                {
                    length *= 0.5;
                    continue;
                }
                steps.push(length);
                if iterations <= 4 && cosine > 0.98 {
                    length = (length * 1.6).min(max_step);
                } else if iterations > 7 {
                    length *= 0.6;
                }
                next
            }
            Err(error) if is_shortest => {
                curve.stopped_by = Some(error);
                break;
            }
            Err(_) => {
                length *= 0.4;
                continue;
            }
        };
        let omega = path.balance(next.orders).omega(&next.x);
        if omega < low * (1.0 - 1e-12) || omega > high * (1.0 + 1e-12) {
            if let Some(last) = path.point_at(&current, &next, if omega < low { low } else { high })
            {
                curve.points.push(path.solution(&last)?);
                curve_points.push(last);
            }
            break;
        }
        progress(((omega - from) / (to - from)).clamp(0.0, 1.0));
        curve.points.push(path.solution(&next)?);
        curve_points.push(next.clone());
        current = next;
    }
    curve.order_limited = path.order_limited;
    curve.bifurcations = find_folds(path, &curve.points, &curve_points, &steps);
    let changes = stability_changes(
        path,
        &curve.points,
        &curve_points,
        &steps,
        &curve.bifurcations,
    );
    curve.bifurcations.extend(changes);
    curve.bifurcations.sort_by_key(|s| s.after);
    if path.options.events {
        curve.period_doubled = follow_period_doublings(
            path.family,
            &path.options,
            &curve.points,
            &curve.bifurcations,
        );
    }
    Ok(curve)
}
