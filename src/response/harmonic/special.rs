//! Folds, where the curve turns back and the motion jumps; and where a motion loses its stability without a fold: a multiplier
//! leaves the unit circle at −1 (period doubling), in a pair (Neimark–Sacker), or at +1 (branching).

use super::follower::{Follower, Place};
use super::point::{Found, Point, point};
use crate::motion::floquet::NEUTRAL;
use crate::motion::floquet::fold::{Course, fold};
use crate::motion::floquet::orbit::Orbit;

/// What happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The curve turns back: a saddle-node.
    Fold,
    /// A multiplier passes −1.
    PeriodDoubling,
    /// A pair of multipliers passes the unit circle.
    NeimarkSacker,
    /// A multiplier passes +1, and the curve goes on: another family of motions branches off.
    Branching,
}

/// A special place of the curve.
#[derive(Debug, Clone)]
pub struct Special {
    /// What happens.
    pub kind: Kind,
    /// The number of the point before it.
    pub after: usize,
    /// The motion there.
    pub point: Point,
}

/// Bisections of a step: eight digits of the largest step.
const BISECTIONS: usize = 30;

/// Of the frequency: a fold by events further from the fold of the balance is another.
const ANOTHER: f64 = 0.02;

/// All folds.
pub(super) fn folds(
    follower: &Follower,
    points: &[Point],
    places: &[Place],
    steps: &[f64],
) -> Vec<Special> {
    let mut found = Vec::new();
    for after in 0..points.len().saturating_sub(1).min(steps.len()) {
        if points[after].sense * points[after + 1].sense >= 0.0 {
            continue;
        }
        let turned =
            |place: &Place| place.tangent[place.tangent.len() - 1] * points[after].sense < 0.0;
        let place = first(follower, &places[after], steps[after], &turned);
        let Ok(mut at) = point(
            &mut follower.balance(place.orders),
            &place.x,
            &place.tangent,
            &follower.asked,
        ) else {
            continue;
        };
        if follower.asked.events
            && let Some((omega, orbit)) = by_events(follower, points, after, at.omega)
        {
            at.omega = omega;
            at.start = orbit.start;
            at.multipliers = orbit.multipliers;
            at.found = Found::Events;
        }
        found.push(Special {
            kind: Kind::Fold,
            after,
            point: at,
        });
    }
    found
}

/// The same fold with every switch located, from a motion a little before it.
fn by_events(
    follower: &Follower,
    points: &[Point],
    after: usize,
    near: f64,
) -> Option<(f64, Orbit)> {
    let family = |omega: f64| follower.family.at(omega);
    let before = (0..=after)
        .rev()
        .filter(|&at| points[at].found == Found::Events)
        .take(3);
    for at in before {
        let ahead = near - points[at].omega;
        if ahead * points[at].sense <= 0.0 {
            continue;
        }
        let course = Course {
            from: points[at].omega,
            step: 0.1 * ahead,
            most_steps: 400,
        };
        if let Ok((omega, orbit)) = fold(&family, &points[at].start, 1, course)
            && (omega - near).abs() < ANOTHER * near
        {
            return Some((omega, orbit));
        }
    }
    None
}

/// Where stability is lost or won, folds apart.
pub(super) fn losses(
    follower: &Follower,
    points: &[Point],
    places: &[Place],
    steps: &[f64],
    folds: &[Special],
) -> Vec<Special> {
    let mut found = Vec::new();
    for after in 0..points.len().saturating_sub(1).min(steps.len()) {
        let (one, other) = (&points[after], &points[after + 1]);
        if one.unstable() == other.unstable() {
            continue;
        }
        let kind = kind(one, other);
        let at_fold = folds.iter().any(|f| f.after.abs_diff(after) <= 1);
        if at_fold && kind == Kind::Branching {
            continue;
        }
        let known = one.unstable();
        let changed = |place: &Place| {
            let at = point(
                &mut follower.balance(place.orders),
                &place.x,
                &place.tangent,
                &follower.asked,
            );
            at.is_ok_and(|p| p.unstable() != known)
        };
        let place = first(follower, &places[after], steps[after], &changed);
        if let Ok(at) = point(
            &mut follower.balance(place.orders),
            &place.x,
            &place.tangent,
            &follower.asked,
        ) {
            found.push(Special {
                kind,
                after,
                point: at,
            });
        }
    }
    found
}

/// What passes the unit circle: of the more unstable of the two, the multiplier next to it outside.
fn kind(one: &Point, other: &Point) -> Kind {
    let unstable = if one.unstable() > other.unstable() {
        one
    } else {
        other
    };
    let outside = unstable
        .multipliers
        .iter()
        .filter(|m| m.norm() > 1.0 + NEUTRAL);
    match outside.min_by(|a, b| a.norm().total_cmp(&b.norm())) {
        Some(m) if m.im.abs() > 1e-6 * m.norm() => Kind::NeimarkSacker,
        Some(m) if m.re < 0.0 => Kind::PeriodDoubling,
        _ => Kind::Branching,
    }
}

/// The last place before `beyond` becomes true, along one step of the curve.
fn first(follower: &Follower, from: &Place, length: f64, beyond: &dyn Fn(&Place) -> bool) -> Place {
    let (mut low, mut high) = (0.0, length);
    let mut best = from.clone();
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let Ok((place, _)) = follower.on(from, middle) else {
            break;
        };
        if beyond(&place) {
            high = middle;
        } else {
            low = middle;
            best = place;
        }
    }
    best
}
