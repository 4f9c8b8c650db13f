//! The curve of periodic motions over speed, followed by arc length (Keller 1977; Allgower and Georg 1990, ch. 6): around folds
//! and through bifurcations, stable or not.

use super::doubled::{Doubled, doubled};
use super::family::Family;
use super::follower::Follower;
pub use super::follower::{Course, TOLERANCE};
use super::lines::Lines;
use super::point::{Asked, Point};
use super::special::{Special, folds, losses};
use crate::base::code::Code;
use crate::base::error::Error;

/// A curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// In the order they were found.
    pub points: Vec<Point>,
    /// Folds and bifurcations, in that order.
    pub specials: Vec<Special>,
    /// Motions of two periods that doublings begin, where motions are refined by events.
    pub doubled: Vec<Doubled>,
    /// The number of unknowns was the limit of the orders at some points.
    pub limited: bool,
    /// The curve was given up before the end of the range, and why.
    pub ended: Option<Error>,
}

/// Steps shorter than this share of the largest find no curve any more.
const SHORTEST: f64 = 1e-7;

/// Where the curve bends by more than this between two points (cosine), the step is halved, unless it is short already.
const BEND: f64 = 0.9;

/// A solution further from where the tangent pointed than this share of the step is on another part of the curve.
const ASTRAY: f64 = 0.5;

/// The same of steps so short that a corner of the curve (contact begins to open) may lie in them.
const ASTRAY_SHORT: f64 = 4.0;

/// Follows the curve; `progress` hears how far it is, 0 to 1.
///
/// # Errors
/// A range that is none; `NoConvergence` where not even its first motion is found; those of the linear part.
pub fn follow(
    family: &Family,
    asked: Asked,
    course: Course,
    progress: &mut dyn FnMut(f64),
) -> Result<Curve, Error> {
    let fine = [course.from, course.to, course.step, course.tolerance]
        .iter()
        .all(|x| x.is_finite() && *x > 0.0);
    if !fine || course.from == course.to {
        let message = format!(
            "a curve from {} to {} rad/s in steps of {} cannot be",
            course.from, course.to, course.step
        );
        return Err(Error::new(Code::OutOfRange, message).hint("speeds lie above zero and differ"));
    }
    let lines = Lines::new(family);
    let mut follower = Follower::new(family, &lines, asked, course)?;
    along(&mut follower, progress)
}

fn along(follower: &mut Follower, progress: &mut dyn FnMut(f64)) -> Result<Curve, Error> {
    let Course {
        from,
        to,
        step,
        most,
        ..
    } = follower.course;
    let mut here = follower.first()?;
    let longest = step / follower.span;
    let mut length = 0.2 * longest;
    let mut curve = Curve {
        points: Vec::new(),
        specials: Vec::new(),
        doubled: Vec::new(),
        limited: false,
        ended: None,
    };
    let (mut places, mut steps) = (vec![here.clone()], Vec::new());
    curve.points.push(follower.point(&here)?);
    let (low, high) = (from.min(to), from.max(to));
    while curve.points.len() < most {
        let taken = follower.step(&here, length);
        let shortest = length <= SHORTEST * longest;
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
                let off = follower.off(&here, &next, length);
                if (turn < BEND && !short) || off > if short { ASTRAY_SHORT } else { ASTRAY } {
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
                curve.ended = Some(error);
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
                follower.ended_at(&here, &next, if omega < low { low } else { high })
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
    curve.limited = follower.limited;
    curve.specials = folds(follower, &curve.points, &places, &steps);
    let lost = losses(follower, &curve.points, &places, &steps, &curve.specials);
    curve.specials.extend(lost);
    curve.specials.sort_by_key(|s| s.after);
    if follower.asked.events {
        curve.doubled = doubled(
            follower.family,
            &follower.asked,
            &curve.points,
            &curve.specials,
        );
    }
    Ok(curve)
}
