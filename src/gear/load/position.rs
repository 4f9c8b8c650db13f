//! The mesh at one pinion angle: slices that can touch, their gaps and compliances, and the load they share.

use crate::base::error::Error;
use crate::numeric::complementarity::{ContactProblem, ContactSolution};
use crate::numeric::profile_matrix::ProfileMatrix;

use super::contact_path::ContactPlace;

/// A slice of a tooth pair that can touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshPoint {
    /// Place of its pair in the list of pairs.
    pub pair: usize,
    /// Place of contact.
    pub place: ContactPlace,
    /// Gap of the flanks with their modifications, m.
    pub gap: f64,
    /// Approach of the slice for a unit force, m/N.
    pub compliance: f64,
}

/// The mesh at one pinion angle.
#[derive(Debug, Clone)]
pub struct MeshPosition {
    /// Slices that can touch.
    pub points: Vec<MeshPoint>,
    problem: ContactProblem,
    /// Base radius of the pinion, m.
    base_radius: f64,
}

impl MeshPosition {
    /// The position of points on a pinion of a base radius.
    ///
    /// # Errors
    /// As `ContactProblem::new`.
    pub(super) fn new(points: Vec<MeshPoint>, base_radius: f64) -> Result<MeshPosition, Error> {
        let compliance = points.iter().map(|p| p.compliance).collect();
        let compliance = ProfileMatrix::diagonal(compliance);
        let arms = vec![1.0; points.len()];
        let gaps = points.iter().map(|p| p.gap).collect();
        Ok(MeshPosition {
            problem: ContactProblem::new(compliance, arms, gaps)?,
            points,
            base_radius,
        })
    }

    /// Transmission error without load, m.
    pub fn unloaded_te(&self) -> f64 {
        -self.problem.unloaded_approach()
    }

    /// Stiffness of a pair as one spring and the approach at which it touches.
    pub(super) fn spring(&self, pair: usize, solution: &ContactSolution) -> (f64, f64) {
        let (mut touch, mut load, mut whole) = (f64::INFINITY, 0.0, 0.0);
        for (i, point) in self
            .points
            .iter()
            .enumerate()
            .filter(|(_, p)| p.pair == pair)
        {
            touch = touch.min(point.gap);
            load += solution.forces[i];
            whole += point.compliance.recip();
        }
        match load > 0.0 {
            true => (load / (solution.approach - touch), touch),
            false => (whole, touch),
        }
    }

    /// Forces of the points and approach at a torque of the pinion, N·m; `start` is the active set of a similar load.
    ///
    /// # Errors
    /// As `ContactProblem::solve`.
    pub fn solve(&self, torque: f64, start: Option<&[bool]>) -> Result<ContactSolution, Error> {
        self.problem.solve(torque / self.base_radius, start)
    }

    /// Torques of the pinion at which the set of touching points changes, N·m, ascending: between them e is affine in the torque.
    ///
    /// # Errors
    /// As `ContactProblem::transitions`.
    pub fn transitions(&self, from: f64, to: f64) -> Result<Vec<f64>, Error> {
        let radius = self.base_radius;
        let transitions = self.problem.transitions(from / radius, to / radius)?;
        Ok(transitions.iter().map(|t| t.load * radius).collect())
    }
}
