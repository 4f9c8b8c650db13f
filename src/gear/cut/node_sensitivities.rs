//! Sensitivity matrix of all nodes: a column per machine setting, rotations of the work projected out, singular value decomposition.

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::factorisations::{Svd, svd};
use crate::numeric::vector_ops::dot;

/// Jacobian of the normal displacements of nodes and weighted root points with respect to settings and rotations of the work, with SVD.
#[derive(Debug, Clone)]
pub struct NodeSensitivities {
    /// Sensitivities to the settings, m per reach of the setting.
    columns: Matrix,
    /// Sensitivities to a rotation of the work for each flank, m/rad.
    turns: Matrix,
    /// SVD of the columns after projection orthogonal to the rotations.
    svd: Svd,
}

/// Correction of settings and rotations of the work by truncated singular value decomposition.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquaresStep {
    /// Changes of the settings, in units of their reach.
    pub changes: Vec<f64>,
    /// Rotations of the work by flank, rad.
    pub turns: Vec<f64>,
    /// Root mean square of the deviations that the step corrects, m.
    pub removed: f64,
}

impl NodeSensitivities {
    /// Decomposes the sensitivities; every row depends on at most one rotation.
    ///
    /// # Errors
    /// Columns that are not finite.
    pub fn new(columns: Matrix, turns: Matrix) -> Result<NodeSensitivities, Error> {
        let mut projected = columns.clone();
        for j in 0..projected.ncols() {
            project_out(&turns, projected.col_as_slice_mut(j));
        }
        let svd = match projected.ncols() {
            0 => Svd {
                u: Matrix::zeros(projected.nrows(), 0),
                values: Vec::new(),
                v: Matrix::zeros(0, 0),
            },
            _ => svd(&projected)?,
        };
        Ok(NodeSensitivities {
            columns,
            turns,
            svd,
        })
    }

    /// Singular values as rms displacement of the nodes, m per unit direction of the settings.
    pub fn singular_values(&self) -> Vec<f64> {
        let scale = 1.0 / (self.columns.nrows() as f64).sqrt();
        self.svd.values.iter().map(|value| scale * value).collect()
    }

    /// Right singular vector: a unit direction of the settings, in units of their reach.
    pub fn direction(&self, index: usize) -> &[f64] {
        self.svd.v.col_as_slice(index)
    }

    /// Numerical rank: number of singular values above `tolerance`, m rms.
    pub fn numerical_rank(&self, tolerance: f64) -> usize {
        let values = self.singular_values();
        values.iter().filter(|value| **value > tolerance).count()
    }

    /// Displacements of the rows by changes of the settings, rotations projected out, m.
    pub fn displacements(&self, changes: &[f64]) -> Vec<f64> {
        let mut displacements = vec![0.0; self.columns.nrows()];
        for (j, change) in changes.iter().enumerate() {
            let column = self.columns.col_as_slice(j);
            (displacements.iter_mut().zip(column)).for_each(|(d, c)| *d += change * c);
        }
        project_out(&self.turns, &mut displacements);
        displacements
    }

    /// Least-squares correction of `deviations` by the first `rank` directions of the settings and by the rotations.
    pub fn step(&self, deviations: &[f64], rank: usize) -> LeastSquaresStep {
        let mut projected = deviations.to_vec();
        project_out(&self.turns, &mut projected);
        let mut changes = vec![0.0; self.columns.ncols()];
        let mut removed = 0.0;
        for k in 0..rank {
            let component = dot(self.svd.u.col_as_slice(k), &projected);
            removed += component * component;
            let amount = component / self.svd.values[k];
            for (change, v) in changes.iter_mut().zip(self.direction(k)) {
                *change += amount * v;
            }
        }
        let mut residual = deviations.to_vec();
        for (j, change) in changes.iter().enumerate() {
            let column = self.columns.col_as_slice(j);
            (residual.iter_mut().zip(column)).for_each(|(r, c)| *r -= change * c);
        }
        let turns: Vec<f64> = (0..self.turns.ncols())
            .map(|f| projection_coefficient(self.turns.col_as_slice(f), &residual))
            .collect();
        for (f, turn) in turns.iter().enumerate() {
            removed += turn * turn * dot(self.turns.col_as_slice(f), self.turns.col_as_slice(f));
        }
        LeastSquaresStep {
            changes,
            turns,
            removed: (removed / deviations.len().max(1) as f64).sqrt(),
        }
    }

    /// Residual of a shape after the first `rank` directions, relative to its root mean square without rotation; `None` for a shape
    /// that is a rotation.
    pub fn residual_share(&self, shape: &[f64], rank: usize) -> Option<f64> {
        let mut projected = shape.to_vec();
        // Rows of root points are zero: a shape does not change the depth of the slot.
        projected.resize(self.columns.nrows(), 0.0);
        project_out(&self.turns, &mut projected);
        let before = dot(&projected, &projected).sqrt();
        for k in 0..rank {
            let u = self.svd.u.col_as_slice(k);
            let component = dot(u, &projected);
            (projected.iter_mut().zip(u)).for_each(|(r, u)| *r -= component * u);
        }
        let is_rotation = before <= PURE_ROTATION * dot(shape, shape).sqrt();
        (!is_rotation).then(|| dot(&projected, &projected).sqrt() / before)
    }
}

/// Maximum share of a pure rotation that remains after projection.
const PURE_ROTATION: f64 = 1e-9;

/// Subtracts from a vector its projections on columns, which are orthogonal.
fn project_out(columns: &Matrix, vector: &mut [f64]) {
    for j in 0..columns.ncols() {
        let column = columns.col_as_slice(j);
        let coefficient = projection_coefficient(column, vector);
        (vector.iter_mut().zip(column)).for_each(|(r, c)| *r -= coefficient * c);
    }
}

/// Projection coefficient `a·b/a·a` of b on a; 0 for a zero column.
fn projection_coefficient(a: &[f64], b: &[f64]) -> f64 {
    let square = dot(a, a);
    if square > 0.0 {
        dot(a, b) / square
    } else {
        0.0
    }
}
