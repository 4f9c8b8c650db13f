//! Bifurcations of the solution curve: fold, period doubling, Neimark–Sacker, branch point.

use super::continuation::{Continuation, CurvePoint};
use super::point::{PeriodicSolution, Refinement, periodic_solution};
use crate::motion::floquet::MULTIPLIER_TOLERANCE;
use crate::motion::floquet::fold::{FoldOptions, find_fold};
use crate::motion::floquet::orbit::PeriodicOrbit;

/// Kinds of bifurcations of periodic solutions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BifurcationKind {
    /// The curve turns back: a saddle-node.
    Fold,
    /// A multiplier passes −1.
    PeriodDoubling,
    /// A pair of multipliers passes the unit circle.
    NeimarkSacker,
    /// A multiplier passes +1, and the curve goes on: another family of motions branches off.
    BranchPoint,
}

/// A special place of the curve.
#[derive(Debug, Clone)]
pub struct Bifurcation {
    /// Kind of the bifurcation.
    pub kind: BifurcationKind,
    /// The number of the point before it.
    pub after: usize,
    /// The motion there.
    pub point: PeriodicSolution,
}

/// Bisections of a step: eight digits of the largest step.
const MAX_BISECTIONS: usize = 30;

/// Fold tolerance relative to the frequency: a fold by events further from the fold of the balance is another.
const FOLD_TOLERANCE: f64 = 0.02;

/// All folds.
pub(super) fn find_folds(
    follower: &Continuation,
    points: &[PeriodicSolution],
    places: &[CurvePoint],
    steps: &[f64],
) -> Vec<Bifurcation> {
    let mut found = Vec::new();
    for after in 0..points.len().saturating_sub(1).min(steps.len()) {
        if points[after].sense * points[after + 1].sense >= 0.0 {
            continue;
        }
        let turned =
            |span: &CurvePoint| span.tangent[span.tangent.len() - 1] * points[after].sense < 0.0;
        let span = bisect_step(follower, &places[after], steps[after], &turned);
        let Ok(mut at) = periodic_solution(
            &mut follower.balance(span.orders),
            &span.x,
            &span.tangent,
            &follower.options,
        ) else {
            continue;
        };
        if follower.options.events
            && let Some((omega, orbit)) = refine_fold(follower, points, after, at.omega)
        {
            at.omega = omega;
            at.start = orbit.start;
            at.multipliers = orbit.multipliers;
            at.refinement = Refinement::Shooting;
        }
        found.push(Bifurcation {
            kind: BifurcationKind::Fold,
            after,
            point: at,
        });
    }
    found
}

/// The same fold with every switch located, from a motion a little before it.
fn refine_fold(
    follower: &Continuation,
    points: &[PeriodicSolution],
    after: usize,
    near: f64,
) -> Option<(f64, PeriodicOrbit)> {
    let family = |omega: f64| follower.family.relative_at(omega);
    let before = (0..=after)
        .rev()
        .filter(|&at| points[at].refinement == Refinement::Shooting)
        .take(3);
    for at in before {
        let ahead = near - points[at].omega;
        if ahead * points[at].sense <= 0.0 {
            continue;
        }
        let course = FoldOptions {
            from: points[at].omega,
            step: 0.1 * ahead,
            max_steps: 400,
        };
        if let Ok((omega, orbit)) = find_fold(&family, &points[at].start, 1, course)
            && (omega - near).abs() < FOLD_TOLERANCE * near
        {
            return Some((omega, orbit));
        }
    }
    None
}

/// Points where stability is lost or gained, folds excepted.
pub(super) fn stability_changes(
    follower: &Continuation,
    points: &[PeriodicSolution],
    places: &[CurvePoint],
    steps: &[f64],
    folds: &[Bifurcation],
) -> Vec<Bifurcation> {
    let mut found = Vec::new();
    for after in 0..points.len().saturating_sub(1).min(steps.len()) {
        let (one, other) = (&points[after], &points[after + 1]);
        if one.unstable_count() == other.unstable_count() {
            continue;
        }
        let kind = kind(one, other);
        let at_fold = folds.iter().any(|f| f.after.abs_diff(after) <= 1);
        if at_fold && kind == BifurcationKind::BranchPoint {
            continue;
        }
        let known = one.unstable_count();
        let changed = |span: &CurvePoint| {
            let at = periodic_solution(
                &mut follower.balance(span.orders),
                &span.x,
                &span.tangent,
                &follower.options,
            );
            at.is_ok_and(|p| p.unstable_count() != known)
        };
        let span = bisect_step(follower, &places[after], steps[after], &changed);
        if let Ok(at) = periodic_solution(
            &mut follower.balance(span.orders),
            &span.x,
            &span.tangent,
            &follower.options,
        ) {
            found.push(Bifurcation {
                kind,
                after,
                point: at,
            });
        }
    }
    found
}

/// Bifurcation kind by the multiplier that crosses the unit circle: of the more unstable solution, the one outside nearest to it.
fn kind(one: &PeriodicSolution, other: &PeriodicSolution) -> BifurcationKind {
    let unstable = if one.unstable_count() > other.unstable_count() {
        one
    } else {
        other
    };
    let outside = unstable
        .multipliers
        .iter()
        .filter(|m| m.norm() > 1.0 + MULTIPLIER_TOLERANCE);
    match outside.min_by(|a, b| a.norm().total_cmp(&b.norm())) {
        Some(m) if m.im.abs() > 1e-6 * m.norm() => BifurcationKind::NeimarkSacker,
        Some(m) if m.re < 0.0 => BifurcationKind::PeriodDoubling,
        _ => BifurcationKind::BranchPoint,
    }
}

/// The last place before `beyond` becomes true, along one step of the curve.
fn bisect_step(
    follower: &Continuation,
    from: &CurvePoint,
    length: f64,
    beyond: &dyn Fn(&CurvePoint) -> bool,
) -> CurvePoint {
    let (mut low, mut high) = (0.0, length);
    let mut best = from.clone();
    for _ in 0..MAX_BISECTIONS {
        let middle = 0.5 * (low + high);
        let Ok((span, _)) = follower.advance(from, middle) else {
            break;
        };
        if beyond(&span) {
            high = middle;
        } else {
            low = middle;
            best = span;
        }
    }
    best
}
