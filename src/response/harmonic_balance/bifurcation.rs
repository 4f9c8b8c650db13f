//! Bifurcations of the solution curve: fold, period doubling, Neimark–Sacker, branch point.

use super::continuation::{Continuation, CurvePoint};
use super::point::{PeriodicSolution, Refinement, periodic_solution};
use crate::motion::floquet::MULTIPLIER_TOLERANCE;
use crate::motion::floquet::fold::{FoldOptions, find_fold};
use crate::motion::floquet::orbit::PeriodicOrbit;

/// What happens.
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
    /// What happens.
    pub kind: BifurcationKind,
    /// The number of the point before it.
    pub after: usize,
    /// The motion there.
    pub solution: PeriodicSolution,
}

/// Bisections of a step: eight digits of the largest step.
const MAX_BISECTIONS: usize = 30;

/// Of the frequency: a fold by events further from the fold of the balance is another.
const FOLD_TOLERANCE: f64 = 0.02;

/// All folds.
pub(super) fn find_folds(
    continuation: &Continuation,
    solutions: &[PeriodicSolution],
    curve_points: &[CurvePoint],
    steps: &[f64],
) -> Vec<Bifurcation> {
    let mut found = Vec::new();
    for after in 0..solutions.len().saturating_sub(1).min(steps.len()) {
        if solutions[after].sense * solutions[after + 1].sense >= 0.0 {
            continue;
        }
        let turned = |curve_point: &CurvePoint| {
            curve_point.tangent[curve_point.tangent.len() - 1] * solutions[after].sense < 0.0
        };
        let curve_point = bisect_step(continuation, &curve_points[after], steps[after], &turned);
        let Ok(mut at) = periodic_solution(
            &mut continuation.balance(curve_point.orders),
            &curve_point.x,
            &curve_point.tangent,
            &continuation.options,
        ) else {
            continue;
        };
        if continuation.options.events
            && let Some((omega, orbit)) = refine_fold(continuation, solutions, after, at.omega)
        {
            at.omega = omega;
            at.start = orbit.start;
            at.multipliers = orbit.multipliers;
            at.refinement = Refinement::Shooting;
        }
        found.push(Bifurcation {
            kind: BifurcationKind::Fold,
            after,
            solution: at,
        });
    }
    found
}

/// The same fold with every switch located, from a motion a little before it.
fn refine_fold(
    continuation: &Continuation,
    solutions: &[PeriodicSolution],
    after: usize,
    near: f64,
) -> Option<(f64, PeriodicOrbit)> {
    let family = |omega: f64| continuation.family.relative_at(omega);
    let before = (0..=after)
        .rev()
        .filter(|&at| solutions[at].refinement == Refinement::Shooting)
        .take(3);
    for at in before {
        let ahead = near - solutions[at].omega;
        if ahead * solutions[at].sense <= 0.0 {
            continue;
        }
        let options = FoldOptions {
            from: solutions[at].omega,
            step: 0.1 * ahead,
            max_steps: 400,
        };
        if let Ok((omega, orbit)) = find_fold(&family, &solutions[at].start, 1, options)
            && (omega - near).abs() < FOLD_TOLERANCE * near
        {
            return Some((omega, orbit));
        }
    }
    None
}

/// Where stability is lost or won, folds apart.
pub(super) fn stability_changes(
    continuation: &Continuation,
    solutions: &[PeriodicSolution],
    curve_points: &[CurvePoint],
    steps: &[f64],
    folds: &[Bifurcation],
) -> Vec<Bifurcation> {
    let mut found = Vec::new();
    for after in 0..solutions.len().saturating_sub(1).min(steps.len()) {
        let (one, other) = (&solutions[after], &solutions[after + 1]);
        if one.unstable_count() == other.unstable_count() {
            continue;
        }
        let kind = kind(one, other);
        let at_fold = folds.iter().any(|f| f.after.abs_diff(after) <= 1);
        if at_fold && kind == BifurcationKind::BranchPoint {
            continue;
        }
        let known = one.unstable_count();
        let changed = |curve_point: &CurvePoint| {
            let at = periodic_solution(
                &mut continuation.balance(curve_point.orders),
                &curve_point.x,
                &curve_point.tangent,
                &continuation.options,
            );
            at.is_ok_and(|p| p.unstable_count() != known)
        };
        let curve_point = bisect_step(continuation, &curve_points[after], steps[after], &changed);
        if let Ok(at) = periodic_solution(
            &mut continuation.balance(curve_point.orders),
            &curve_point.x,
            &curve_point.tangent,
            &continuation.options,
        ) {
            found.push(Bifurcation {
                kind,
                after,
                solution: at,
            });
        }
    }
    found
}

/// What passes the unit circle: of the more unstable of the two, the multiplier next to it outside.
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
    continuation: &Continuation,
    from: &CurvePoint,
    length: f64,
    beyond: &dyn Fn(&CurvePoint) -> bool,
) -> CurvePoint {
    let (mut low, mut high) = (0.0, length);
    let mut best = from.clone();
    for _ in 0..MAX_BISECTIONS {
        let middle = 0.5 * (low + high);
        let Ok((point, _)) = continuation.advance(from, middle) else {
            break;
        };
        if beyond(&point) {
            high = middle;
        } else {
            low = middle;
            best = point;
        }
    }
    best
}
