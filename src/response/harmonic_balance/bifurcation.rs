//! Bifurcations of the solution curve: fold, period doubling, Neimark–Sacker, branch point.

use super::continuation::{Continuation, CurvePoint};
use super::point::{PeriodicSolution, Refinement, periodic_solution};
use crate::motion::floquet::MULTIPLIER_TOLERANCE;
use crate::motion::floquet::fold::{FoldOptions, find_fold};
use crate::motion::floquet::orbit::PeriodicOrbit;

/// Kind of bifurcation of a periodic solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BifurcationKind {
    /// Saddle-node: the curve turns back in frequency.
    Fold,
    /// A Floquet multiplier passes −1.
    PeriodDoubling,
    /// A complex pair of multipliers crosses the unit circle.
    NeimarkSacker,
    /// A multiplier passes +1 without a fold: another family of periodic solutions branches off.
    BranchPoint,
}

/// A bifurcation on the solution curve.
#[derive(Debug, Clone)]
pub struct Bifurcation {
    /// Kind of the bifurcation.
    pub kind: BifurcationKind,
    /// Index of the curve point before it.
    pub after: usize,
    /// Periodic solution at the bifurcation.
    pub point: PeriodicSolution,
}

/// Maximum number of bisections of a step.
const MAX_BISECTIONS: usize = 30;

/// Fold tolerance relative to the frequency: a fold by shooting farther from that of the harmonic balance is another fold.
const FOLD_TOLERANCE: f64 = 0.02;

/// Folds of the solution curve.
pub(super) fn find_folds(
    curve: &Continuation,
    points: &[PeriodicSolution],
    curve_points: &[CurvePoint],
    steps: &[f64],
) -> Vec<Bifurcation> {
    let mut folds = Vec::new();
    for after in 0..points.len().saturating_sub(1).min(steps.len()) {
        if points[after].frequency_tangent * points[after + 1].frequency_tangent >= 0.0 {
            continue;
        }
        let is_past = |point: &CurvePoint| {
            point.tangent[point.tangent.len() - 1] * points[after].frequency_tangent < 0.0
        };
        let point = bisect_step(curve, &curve_points[after], steps[after], &is_past);
        let Ok(mut solution) = periodic_solution(
            &mut curve.balance(point.orders),
            &point.x,
            &point.tangent,
            &curve.options,
        ) else {
            continue;
        };
        if curve.options.events
            && let Some((omega, orbit)) = refine_fold(curve, points, after, solution.omega)
        {
            solution.omega = omega;
            solution.start = orbit.start;
            solution.multipliers = orbit.multipliers;
            solution.refinement = Refinement::Shooting;
        }
        folds.push(Bifurcation {
            kind: BifurcationKind::Fold,
            after,
            point: solution,
        });
    }
    folds
}

/// Frequency and orbit at the fold by shooting with located events, started from a solution before the fold.
fn refine_fold(
    curve: &Continuation,
    points: &[PeriodicSolution],
    after: usize,
    estimate: f64,
) -> Option<(f64, PeriodicOrbit)> {
    let family = |omega: f64| curve.family.relative_at(omega);
    let before = (0..=after)
        .rev()
        .filter(|&at| points[at].refinement == Refinement::Shooting)
        .take(3);
    for at in before {
        let offset = estimate - points[at].omega;
        if offset * points[at].frequency_tangent <= 0.0 {
            continue;
        }
        let fold_options = FoldOptions {
            from: points[at].omega,
            step: 0.1 * offset,
            max_steps: 400,
        };
        if let Ok((omega, orbit)) = find_fold(&family, &points[at].start, 1, fold_options)
            && (omega - estimate).abs() < FOLD_TOLERANCE * estimate
        {
            return Some((omega, orbit));
        }
    }
    None
}

/// Bifurcations other than folds at which stability is lost or gained.
pub(super) fn stability_changes(
    curve: &Continuation,
    points: &[PeriodicSolution],
    curve_points: &[CurvePoint],
    steps: &[f64],
    folds: &[Bifurcation],
) -> Vec<Bifurcation> {
    let mut bifurcations = Vec::new();
    for after in 0..points.len().saturating_sub(1).min(steps.len()) {
        let (lower, upper) = (&points[after], &points[after + 1]);
        if lower.unstable_count() == upper.unstable_count() {
            continue;
        }
        let kind = bifurcation_kind(lower, upper);
        let at_fold = folds.iter().any(|f| f.after.abs_diff(after) <= 1);
        if at_fold && kind == BifurcationKind::BranchPoint {
            continue;
        }
        let unstable_count = lower.unstable_count();
        let is_past = |point: &CurvePoint| {
            let solution = periodic_solution(
                &mut curve.balance(point.orders),
                &point.x,
                &point.tangent,
                &curve.options,
            );
            solution.is_ok_and(|p| p.unstable_count() != unstable_count)
        };
        let point = bisect_step(curve, &curve_points[after], steps[after], &is_past);
        if let Ok(solution) = periodic_solution(
            &mut curve.balance(point.orders),
            &point.x,
            &point.tangent,
            &curve.options,
        ) {
            bifurcations.push(Bifurcation {
                kind,
                after,
                point: solution,
            });
        }
    }
    bifurcations
}

/// Kind by the multiplier that crosses the unit circle: of those of the more unstable solution outside it, the nearest one.
fn bifurcation_kind(lower: &PeriodicSolution, upper: &PeriodicSolution) -> BifurcationKind {
    let unstable = if lower.unstable_count() > upper.unstable_count() {
        lower
    } else {
        upper
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

/// Last curve point before `is_past` becomes true, along one step of the curve.
fn bisect_step(
    curve: &Continuation,
    from: &CurvePoint,
    length: f64,
    is_past: &dyn Fn(&CurvePoint) -> bool,
) -> CurvePoint {
    let (mut low, mut high) = (0.0, length);
    let mut best = from.clone();
    for _ in 0..MAX_BISECTIONS {
        let middle = 0.5 * (low + high);
        let Ok((point, _)) = curve.advance(from, middle) else {
            break;
        };
        if is_past(&point) {
            high = middle;
        } else {
            low = middle;
            best = point;
        }
    }
    best
}
