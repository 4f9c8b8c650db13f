//! Stabilisation diagram: poles over rising order, marked by agreement with the order before.
//!
//! Plain data for a plot.
//!
//! Heylen, Lammens & Sas, Modal Analysis Theory and Testing (1997), §A.3.3; tolerances as commonly used there.

use super::candidates::{CandidatePole, OrderPoles};
use crate::numeric::mac::mac;

/// Tolerances within which a pole matches one of the order before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StabilisationTolerances {
    /// Relative, of |p|.
    pub frequency: f64,
    /// Relative, of the damping ratio.
    pub damping: f64,
    /// Least MAC of the shapes, and of the participations with several inputs.
    pub mac: f64,
}

impl Default for StabilisationTolerances {
    /// 1 %, 5 %, 0.95.
    fn default() -> Self {
        StabilisationTolerances {
            frequency: 0.01,
            damping: 0.05,
            mac: 0.95,
        }
    }
}

/// Agreement of a pole with the nearest one of the order before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoleStability {
    /// No pole near.
    New,
    /// Frequency repeats.
    Frequency,
    /// Frequency and damping repeat, the shape does not.
    Damping,
    /// Frequency and shape repeat, the damping does not.
    Shape,
    /// All repeat.
    Stable,
}

/// A point of the diagram.
#[derive(Debug, Clone)]
pub struct StabilisationPole {
    /// Order of the model.
    pub order: usize,
    /// `|p|/2π`, Hz.
    pub frequency_hz: f64,
    /// `−Re p/|p|`.
    pub damping_ratio: f64,
    /// Stability mark of the pole.
    pub stability: PoleStability,
}

/// All points, by order, then frequency.
pub fn stabilisation(
    orders: &[OrderPoles],
    tolerances: &StabilisationTolerances,
) -> Vec<StabilisationPole> {
    let mut points = Vec::new();
    for (at, now) in orders.iter().enumerate() {
        let before = at.checked_sub(1).map_or(&[][..], |i| &orders[i].poles);
        for candidate in &now.poles {
            points.push(StabilisationPole {
                order: now.order,
                frequency_hz: candidate.pole.norm() / std::f64::consts::TAU,
                damping_ratio: candidate.damping_ratio(),
                stability: classify(candidate, before, tolerances),
            });
        }
    }
    points
}

fn classify(
    now: &CandidatePole,
    before: &[CandidatePole],
    tolerances: &StabilisationTolerances,
) -> PoleStability {
    let apart = |other: &&CandidatePole| (other.pole - now.pole).norm();
    let nearest = before.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
    let Some(other) = nearest else {
        return PoleStability::New;
    };
    let repeats = |a: f64, b: f64, tolerance: f64| (a - b).abs() <= tolerance * b.abs();
    if !repeats(now.pole.norm(), other.pole.norm(), tolerances.frequency) {
        return PoleStability::New;
    }
    let damping = repeats(
        now.damping_ratio(),
        other.damping_ratio(),
        tolerances.damping,
    );
    match (damping, min_mac(now, other) >= tolerances.mac) {
        (true, true) => PoleStability::Stable,
        (true, false) => PoleStability::Damping,
        (false, true) => PoleStability::Shape,
        (false, false) => PoleStability::Frequency,
    }
}

/// The lesser MAC of shapes and of participations; 1 where a single component says nothing.
pub fn min_mac(a: &CandidatePole, b: &CandidatePole) -> f64 {
    let alike = |x: &[crate::numeric::Complex], y: &[crate::numeric::Complex]| {
        if x.len() < 2 || x.len() != y.len() {
            1.0
        } else {
            mac(x, y)
        }
    };
    alike(&a.shape, &b.shape).min(alike(&a.participation, &b.participation))
}
