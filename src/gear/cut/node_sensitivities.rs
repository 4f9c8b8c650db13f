//! Sensitivities of all nodes as one matrix: columns in units of what a machine can set, turns of the work projected out, singular values.

use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::factorisations::{Svd, svd};
use crate::numeric::vector_ops::dot;

/// Jacobian of the normal displacements of nodes (and weighted root points) over machine settings and rotation of the work, with its SVD.
#[derive(Debug, Clone)]
pub struct NodeSensitivities {
    /// A column for each setting, m for its reach.
    columns: Matrix,
    /// A column for each flank, m a radian of the work.
    turns: Matrix,
    /// Singular values and vectors of the columns without turns.
    svd: Svd,
}

/// Correction of settings and rotation of the work by truncated singular values.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquaresStep {
    /// Changes of the settings, in their reach.
    pub changes: Vec<f64>,
    /// Turns of the flanks, rad.
    pub turns: Vec<f64>,
    /// Root mean square of the deviations that the step takes away, m.
    pub removed: f64,
}

impl NodeSensitivities {
    /// The system of columns of settings and of turns; the turns touch no row in common.
    ///
    /// # Errors
    /// Columns that are not finite.
    pub fn new(columns: Matrix, turns: Matrix) -> Result<NodeSensitivities, Error> {
        let mut free = columns.clone();
        for j in 0..free.ncols() {
            project_out(&turns, free.col_as_slice_mut(j));
        }
        let svd = match free.ncols() {
            0 => Svd {
                u: Matrix::zeros(free.nrows(), 0),
                values: Vec::new(),
                v: Matrix::zeros(0, 0),
            },
            _ => svd(&free)?,
        };
        Ok(NodeSensitivities {
            columns,
            turns,
            svd,
        })
    }

    /// Singular values as root mean squares over the nodes, m for a unit direction of settings in their reach.
    pub fn singular_values(&self) -> Vec<f64> {
        let scale = 1.0 / (self.columns.nrows() as f64).sqrt();
        self.svd.values.iter().map(|value| scale * value).collect()
    }

    /// A direction of settings in their reach, of unit length.
    pub fn direction(&self, index: usize) -> &[f64] {
        self.svd.v.col_as_slice(index)
    }

    /// The number of directions that move the flank by more than `least`, m rms.
    pub fn seen(&self, least: f64) -> usize {
        let values = self.singular_values();
        values.iter().filter(|value| **value > least).count()
    }

    /// Displacements of the rows by changes of settings in their reach, without turns, m.
    pub fn displacements(&self, changes: &[f64]) -> Vec<f64> {
        let mut moved = vec![0.0; self.columns.nrows()];
        for (j, change) in changes.iter().enumerate() {
            let column = self.columns.col_as_slice(j);
            (moved.iter_mut().zip(column)).for_each(|(m, c)| *m += change * c);
        }
        project_out(&self.turns, &mut moved);
        moved
    }

    /// The change of settings along the first `kept` directions and the turns that leave least of `deviations`.
    pub fn step(&self, deviations: &[f64], kept: usize) -> LeastSquaresStep {
        let mut free = deviations.to_vec();
        project_out(&self.turns, &mut free);
        let mut changes = vec![0.0; self.columns.ncols()];
        let mut removed = 0.0;
        for k in 0..kept {
            let share = dot(self.svd.u.col_as_slice(k), &free);
            removed += share * share;
            let amount = share / self.svd.values[k];
            for (change, v) in changes.iter_mut().zip(self.direction(k)) {
                *change += amount * v;
            }
        }
        let mut rest = deviations.to_vec();
        for (j, change) in changes.iter().enumerate() {
            let column = self.columns.col_as_slice(j);
            (rest.iter_mut().zip(column)).for_each(|(r, c)| *r -= change * c);
        }
        let turns: Vec<f64> = (0..self.turns.ncols())
            .map(|f| share_of(self.turns.col_as_slice(f), &rest))
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

    /// Share of a shape's root mean square that the first `kept` directions leave, the turn taken off before; none for a shape that is a
    /// turn.
    pub fn share_left(&self, shape: &[f64], kept: usize) -> Option<f64> {
        let mut free = shape.to_vec();
        // The slot keeps its depth.
        free.resize(self.columns.nrows(), 0.0);
        project_out(&self.turns, &mut free);
        let before = dot(&free, &free).sqrt();
        for k in 0..kept {
            let u = self.svd.u.col_as_slice(k);
            let share = dot(u, &free);
            (free.iter_mut().zip(u)).for_each(|(r, u)| *r -= share * u);
        }
        let is_turn = before <= TURN_ONLY * dot(shape, shape).sqrt();
        (!is_turn).then(|| dot(&free, &free).sqrt() / before)
    }
}

/// A shape of which the turn leaves less than this share is a turn.
const TURN_ONLY: f64 = 1e-9;

/// Takes the columns off a vector, each by itself.
fn project_out(columns: &Matrix, from: &mut [f64]) {
    for j in 0..columns.ncols() {
        let column = columns.col_as_slice(j);
        let share = share_of(column, from);
        (from.iter_mut().zip(column)).for_each(|(r, c)| *r -= share * c);
    }
}

/// `a·b/a·a`, 0 for a zero column.
fn share_of(a: &[f64], b: &[f64]) -> f64 {
    let square = dot(a, a);
    if square > 0.0 {
        dot(a, b) / square
    } else {
        0.0
    }
}
