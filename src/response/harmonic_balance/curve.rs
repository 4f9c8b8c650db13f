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

/// Periodic solutions along the frequency, with their bifurcations.
#[derive(Debug, Clone)]
pub struct SolutionCurve {
    /// In the order they were found.
    pub points: Vec<PeriodicSolution>,
    /// Folds and bifurcations, in that order.
    pub bifurcations: Vec<Bifurcation>,
    /// Motions of two periods that doublings begin, where motions are refined by events.
    pub period_doubled: Vec<PeriodDoubledBranch>,
    /// The number of unknowns was the limit of the orders at some points.
    pub order_limited: bool,
    /// The curve was given up before the end of the range, and why.
    pub stopped_by: Option<Error>,
}

/// Steps shorter than this share of the largest find no curve any more.
const MIN_STEP: f64 = 1e-7;

/// Smallest cosine between the directions of successive points; below it the step is halved, unless it is short already.
const MIN_COSINE: f64 = 0.9;

/// A solution further from where the tangent pointed than this share of the step is on another part of the curve.
const MAX_DEVIATION: f64 = 0.5;

/// The same of steps so short that a corner of the curve (contact begins to open) may lie in them.
const MAX_DEVIATION_SHORT: f64 = 4.0;

/// Follows the curve; `progress` hears how far it is, 0 to 1.
///
/// # Errors
/// A range that is none; `NoConvergence` where not even its first motion is found; those of the linear part.
pub fn continue_curve(
    family: &SpeedFamily,
    options: PointOptions,
    course: ContinuationOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<SolutionCurve, Error> {
    let fine = [course.from, course.to, course.step, course.tolerance]
        .iter()
        .all(|x| x.is_finite() && *x > 0.0);
    if !fine || course.from == course.to {
        let message = format!(
            "a curve from {} to {} rad/s in steps of {} cannot be",
            course.from, course.to, course.step
        );
        return Err(
            Error::new(Code::OutOfRange, message).with_hint("speeds lie above zero and differ")
        );
    }
    let lines = LinearPart::new(family);
    let mut follower = Continuation::new(family, &lines, options, course)?;
    trace(&mut follower, progress)
}

fn trace(
    follower: &mut Continuation,
    progress: &mut dyn FnMut(f64),
) -> Result<SolutionCurve, Error> {
    let ContinuationOptions {
        from,
        to,
        step,
        max_points: most,
        ..
    } = follower.course;
    let mut here = follower.first()?;
    let longest = step / follower.span;
    let mut length = 0.2 * longest;
    let mut curve = SolutionCurve {
        points: Vec::new(),
        bifurcations: Vec::new(),
        period_doubled: Vec::new(),
        order_limited: false,
        stopped_by: None,
    };
    let (mut places, mut steps) = (vec![here.clone()], Vec::new());
    curve.points.push(follower.point(&here)?);
    let (low, high) = (from.min(to), from.max(to));
    while curve.points.len() < most {
        let taken = follower.step(&here, length);
        let shortest = length <= MIN_STEP * longest;
        let next = match taken {
            Ok((next, iterations)) => {
                let turn: f64 = match next.orders == here.orders {
                    true => next
                        .tangent
                        .iter()
                        .zip(&here.tangent)
                        .map(|(a, b)| a * b)
                        .sum(),
                    false => 1.0,
                };
                let short = length <= 1e-3 * longest;
                let off = follower.predictor_deviation(&here, &next, length);
                if (turn < MIN_COSINE && !short)
                    || off
                        > if short {
                            MAX_DEVIATION_SHORT
                        } else {
                            MAX_DEVIATION
                        }
                {
                    length *= 0.5;
                    continue;
                }
                steps.push(length);
                if iterations <= 4 && turn > 0.98 {
                    length = (length * 1.6).min(longest);
                } else if iterations > 7 {
                    length *= 0.6;
                }
                next
            }
            Err(error) if shortest => {
                curve.stopped_by = Some(error);
                break;
            }
            Err(_) => {
                length *= 0.4;
                continue;
            }
        };
        let omega = follower.balance(next.orders).omega(&next.x);
        if omega < low * (1.0 - 1e-12) || omega > high * (1.0 + 1e-12) {
            if let Some(last) =
                follower.point_at(&here, &next, if omega < low { low } else { high })
            {
                curve.points.push(follower.point(&last)?);
                places.push(last);
            }
            break;
        }
        progress(((omega - from) / (to - from)).clamp(0.0, 1.0));
        curve.points.push(follower.point(&next)?);
        places.push(next.clone());
        here = next;
    }
    curve.order_limited = follower.limited;
    curve.bifurcations = find_folds(follower, &curve.points, &places, &steps);
    let lost = stability_changes(
        follower,
        &curve.points,
        &places,
        &steps,
        &curve.bifurcations,
    );
    curve.bifurcations.extend(lost);
    curve.bifurcations.sort_by_key(|s| s.after);
    if follower.options.events {
        curve.period_doubled = follow_period_doublings(
            follower.family,
            &follower.options,
            &curve.points,
            &curve.bifurcations,
        );
    }
    Ok(curve)
}
