//! Period-doubled orbits: found by shooting where a multiplier passes −1, followed over speed.

use std::ops::Range;

use super::bifurcation::{Bifurcation, BifurcationKind};
use super::family::SpeedFamily;
use super::point::{PeriodicSolution, PointOptions, Refinement, sample_with_events};
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::floquet::orbit::{find_orbit, return_map};

/// The motions of two periods that a doubling begins.
#[derive(Debug, Clone)]
pub struct PeriodDoubledBranch {
    /// The number of the doubling among the special places.
    pub bifurcation: usize,
    /// From the doubling on, at the speeds of the curve; multipliers are those of two periods.
    pub points: Vec<PeriodicSolution>,
    /// Range of points of the curve at the same speeds.
    point_range: Range<usize>,
}

impl PeriodDoubledBranch {
    /// They end or begin in the step of the curve after this point.
    pub fn covers_point(&self, after: usize) -> bool {
        (self.point_range.start..=self.point_range.end).contains(&(after + 1))
    }
}

/// Displacements tried to leave the motion that lost its stability, of the size of the motion.
const PERTURBATIONS: [f64; 4] = [0.01, 0.03, 0.1, 0.3];

/// A motion that comes back this near after one period already, of its size, is no doubled one.
const PERIOD_ONE_TOLERANCE: f64 = 1e-5;

/// Number of curve points beyond a doubling that are searched for its motions: nearer ones are too small to be distinguished from it.
const MAX_POINTS_TRIED: usize = 6;

/// Iterations of the power method: each separates the fastest-growing disturbance from the rest by the ratio of their multipliers.
const POWER_ITERATIONS: usize = 200;

/// Follows every doubling of a curve whose motions are refined by events.
pub(super) fn follow_period_doublings(
    family: &SpeedFamily,
    options: &PointOptions,
    points: &[PeriodicSolution],
    specials: &[Bifurcation],
) -> Vec<PeriodDoubledBranch> {
    let mut all: Vec<PeriodDoubledBranch> = Vec::new();
    for (born, special) in specials.iter().enumerate() {
        if special.kind != BifurcationKind::PeriodDoubling || special.after + 1 >= points.len() {
            continue;
        }
        let (one, other) = (special.after, special.after + 1);
        let rising = points[other].unstable_count() > points[one].unstable_count();
        let interval = unstable_range(points, one, rising);
        // The other end of an interval that has been followed from here.
        let known = |d: &PeriodDoubledBranch| {
            interval.contains(&d.point_range.start) || d.point_range.contains(&interval.start)
        };
        if all.iter().any(known) {
            continue;
        }
        let order: Vec<usize> = match rising {
            true => interval.clone().collect(),
            false => interval.clone().rev().collect(),
        };
        let followed = trace(family, options, points, &order);
        if !followed.is_empty() {
            all.push(PeriodDoubledBranch {
                bifurcation: born,
                points: followed,
                point_range: interval,
            });
        }
    }
    all
}

/// Numbers of the points on the unstable side of the step after `one`, as far as they are unstable.
fn unstable_range(points: &[PeriodicSolution], one: usize, rising: bool) -> Range<usize> {
    let counts = |k: &usize| {
        points[*k].unstable_count() > 0 && points[*k].refinement == Refinement::Shooting
    };
    match rising {
        true => one + 1..one + 1 + (one + 1..points.len()).take_while(counts).count(),
        false => one + 1 - (0..=one).rev().take_while(counts).count()..one + 1,
    }
}

fn trace(
    family: &SpeedFamily,
    options: &PointOptions,
    points: &[PeriodicSolution],
    order: &[usize],
) -> Vec<PeriodicSolution> {
    let mut found: Vec<PeriodicSolution> = Vec::new();
    // From the motion of one period to that of two, at the last speed.
    let mut beside: Option<Vec<f64>> = None;
    for (tried, &at) in order.iter().enumerate() {
        let single = &points[at];
        let model = family.relative_at(single.omega);
        let next = match &beside {
            Some(offset) => find_doubled_orbit(&model, single, std::slice::from_ref(offset)),
            None if tried < MAX_POINTS_TRIED => {
                find_doubled_orbit(&model, single, &unstable_directions(&model, single))
            }
            None => break,
        };
        let Some((start, multipliers)) = next else {
            match beside {
                Some(_) => break,
                None => continue,
            }
        };
        let Ok(outputs) = sample_with_events(family, single.omega, 2, &start, options.outputs)
        else {
            break;
        };
        beside = Some(
            start
                .iter()
                .zip(&single.start)
                .map(|(a, b)| a - b)
                .collect(),
        );
        found.push(PeriodicSolution {
            omega: single.omega,
            orders: single.orders,
            truncation_error: single.truncation_error,
            refinement: Refinement::Shooting,
            start,
            multipliers,
            outputs,
            sense: single.sense,
        });
    }
    found
}

/// Start and multipliers of a motion of two periods next to one of one.
fn find_doubled_orbit(
    model: &DynamicModel,
    single: &PeriodicSolution,
    offsets: &[Vec<f64>],
) -> Option<(Vec<f64>, Vec<crate::numeric::Complex>)> {
    offsets.iter().find_map(|offset| {
        let guess: Vec<f64> = single
            .start
            .iter()
            .zip(offset)
            .map(|(y, o)| y + o)
            .collect();
        let found = find_orbit(model, &guess, 2).ok()?;
        let once = return_map(model, &found.start, 1).ok()?;
        let size = |values: &[f64]| values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let comes_back =
            size(&once.residual(&found.start)) <= PERIOD_ONE_TOLERANCE * size(&once.end);
        (!comes_back).then_some((found.start, found.multipliers))
    })
}

/// Displacements along what grows most in a period, of several sizes.
fn unstable_directions(model: &DynamicModel, single: &PeriodicSolution) -> Vec<Vec<f64>> {
    let Ok(back) = return_map(model, &single.start, 1) else {
        return Vec::new();
    };
    let n = back.end.len();
    let mut along: Vec<f64> = (0..n).map(|i| 1.0 + 0.1 * i as f64).collect();
    for _ in 0..POWER_ITERATIONS {
        let next: Vec<f64> = back
            .jacobian
            .chunks_exact(n)
            .map(|row| row.iter().zip(&along).map(|(a, b)| a * b).sum())
            .collect();
        let size = next.iter().fold(0.0f64, |m: f64, x: &f64| m.max(x.abs()));
        if !(size > 0.0 && size.is_finite()) {
            return Vec::new();
        }
        along = next.iter().map(|x| x / size).collect();
    }
    let size = back.end.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let sized = |share: &f64| {
        let each = along.iter().zip(&back.units);
        each.map(|(x, unit)| share * size * x * unit).collect()
    };
    PERTURBATIONS.iter().map(sized).collect()
}
