//! Period-doubled orbits, computed by shooting beyond a Floquet multiplier of −1 and followed over speed.

use std::ops::Range;

use super::bifurcation::{Bifurcation, BifurcationKind};
use super::family::SpeedFamily;
use super::point::{PeriodicSolution, PointOptions, Refinement, sample_with_events};
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::floquet::orbit::{find_orbit, return_map};

/// Branch of period-2 orbits born at a period doubling.
#[derive(Debug, Clone)]
pub struct PeriodDoubledBranch {
    /// Index of the period doubling in the bifurcations of the curve.
    pub bifurcation: usize,
    /// Orbits from the doubling on at the speeds of the curve, with the multipliers of two periods.
    pub points: Vec<PeriodicSolution>,
    /// Range of the curve points at the same speeds.
    point_range: Range<usize>,
}

impl PeriodDoubledBranch {
    /// Whether the branch covers the step of the curve after point `after`.
    pub fn covers_point(&self, after: usize) -> bool {
        (self.point_range.start..=self.point_range.end).contains(&(after + 1))
    }
}

/// Perturbations of the unstable orbit, relative to its size.
const PERTURBATIONS: [f64; 4] = [0.01, 0.03, 0.1, 0.3];

/// Relative residual after one period below which an orbit has period one.
const PERIOD_ONE_TOLERANCE: f64 = 1e-5;

/// Number of curve points beyond a doubling searched for the branch; close to it the period-2 orbit is too small to separate.
const MAX_POINTS_TRIED: usize = 6;

/// Iterations of the power method; the error falls by the ratio of the two largest multipliers in each.
const POWER_ITERATIONS: usize = 200;

/// Follows every period doubling of a curve whose solutions are refined with events.
pub(super) fn follow_period_doublings(
    family: &SpeedFamily,
    options: &PointOptions,
    points: &[PeriodicSolution],
    bifurcations: &[Bifurcation],
) -> Vec<PeriodDoubledBranch> {
    let mut branches: Vec<PeriodDoubledBranch> = Vec::new();
    for (number, b) in bifurcations.iter().enumerate() {
        if b.kind != BifurcationKind::PeriodDoubling || b.after + 1 >= points.len() {
            continue;
        }
        let (before, after) = (b.after, b.after + 1);
        let rising = points[after].unstable_count() > points[before].unstable_count();
        let interval = unstable_range(points, before, rising);
        // The other end of an interval that has been followed already.
        let is_known = |d: &PeriodDoubledBranch| {
            interval.contains(&d.point_range.start) || d.point_range.contains(&interval.start)
        };
        if branches.iter().any(is_known) {
            continue;
        }
        let order: Vec<usize> = match rising {
            true => interval.clone().collect(),
            false => interval.clone().rev().collect(),
        };
        let orbits = trace(family, options, points, &order);
        if !orbits.is_empty() {
            branches.push(PeriodDoubledBranch {
                bifurcation: number,
                points: orbits,
                point_range: interval,
            });
        }
    }
    branches
}

/// Contiguous unstable points on the unstable side of the step after point `before`.
fn unstable_range(points: &[PeriodicSolution], before: usize, rising: bool) -> Range<usize> {
    let is_unstable = |k: &usize| {
        points[*k].unstable_count() > 0 && points[*k].refinement == Refinement::Shooting
    };
    match rising {
        true => before + 1..before + 1 + (before + 1..points.len()).take_while(is_unstable).count(),
        false => before + 1 - (0..=before).rev().take_while(is_unstable).count()..before + 1,
    }
}

fn trace(
    family: &SpeedFamily,
    options: &PointOptions,
    points: &[PeriodicSolution],
    order: &[usize],
) -> Vec<PeriodicSolution> {
    let mut orbits: Vec<PeriodicSolution> = Vec::new();
    // Offset of the period-2 orbit from the period-1 orbit at the last speed.
    let mut offset: Option<Vec<f64>> = None;
    for (n_tried, &k) in order.iter().enumerate() {
        let single = &points[k];
        let model = family.relative_at(single.omega);
        let next = match &offset {
            Some(offset) => find_doubled_orbit(&model, single, std::slice::from_ref(offset)),
            None if n_tried < MAX_POINTS_TRIED => {
                find_doubled_orbit(&model, single, &unstable_directions(&model, single))
            }
            None => break,
        };
        let Some((start, multipliers)) = next else {
            match offset {
                Some(_) => break,
                None => continue,
            }
        };
        let Ok(outputs) = sample_with_events(family, single.omega, 2, &start, options.outputs)
        else {
            break;
        };
        offset = Some(
            start
                .iter()
                .zip(&single.start)
                .map(|(a, b)| a - b)
                .collect(),
        );
        orbits.push(PeriodicSolution {
            omega: single.omega,
            orders: single.orders,
            truncation_error: single.truncation_error,
            refinement: Refinement::Shooting,
            start,
            multipliers,
            outputs,
            frequency_tangent: single.frequency_tangent,
        });
    }
    orbits
}

/// Initial state and multipliers of a period-2 orbit near a period-1 orbit.
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
        let orbit = find_orbit(model, &guess, 2).ok()?;
        let period = return_map(model, &orbit.start, 1).ok()?;
        let size = |values: &[f64]| values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let has_period_one =
            size(&period.residual(&orbit.start)) <= PERIOD_ONE_TOLERANCE * size(&period.end);
        (!has_period_one).then_some((orbit.start, orbit.multipliers))
    })
}

/// Perturbations of several sizes along the dominant eigenvector of the monodromy matrix.
fn unstable_directions(model: &DynamicModel, single: &PeriodicSolution) -> Vec<Vec<f64>> {
    let Ok(map) = return_map(model, &single.start, 1) else {
        return Vec::new();
    };
    let n = map.end.len();
    let mut direction: Vec<f64> = (0..n).map(|i| 1.0 + 0.1 * i as f64).collect();
    for _ in 0..POWER_ITERATIONS {
        let next: Vec<f64> = map
            .jacobian
            .chunks_exact(n)
            .map(|row| row.iter().zip(&direction).map(|(a, b)| a * b).sum())
            .collect();
        let size = next.iter().fold(0.0f64, |m: f64, x: &f64| m.max(x.abs()));
        if !(size > 0.0 && size.is_finite()) {
            return Vec::new();
        }
        direction = next.iter().map(|x| x / size).collect();
    }
    let size = map.end.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let scaled = |factor: &f64| {
        let terms = direction.iter().zip(&map.units);
        terms.map(|(x, unit)| factor * size * x * unit).collect()
    };
    PERTURBATIONS.iter().map(scaled).collect()
}
