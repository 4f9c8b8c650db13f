//! Reduced machine `M_r r̈ + C_r ṙ + K_r r = T_rᵀ f`, `q = T_r r` with q all degrees of freedom, and its error.

use std::f64::consts::TAU;

use crate::machine::linear::LinearModel;
use crate::modes::reduction::BandError;
use crate::numeric::to_rows;
use crate::plan::modes_run::ReductionResult;

/// A reduced machine; matrices row by row.
#[derive(Debug, Clone)]
pub struct Reduction {
    /// Names of the reduced coordinates r.
    pub coordinates: Vec<String>,
    /// T_r, degrees of freedom (in the order of [`crate::Modes::dofs`]) × coordinates.
    pub transformation: Vec<Vec<f64>>,
    /// M_r, coordinates × coordinates.
    pub mass: Vec<Vec<f64>>,
    /// C_r, coordinates × coordinates.
    pub damping: Vec<Vec<f64>>,
    /// K_r, coordinates × coordinates.
    pub stiffness: Vec<Vec<f64>>,
    /// Undamped natural frequencies of the reduced machine, Hz.
    pub frequency_hz: Vec<f64>,
    /// As many of the full machine, Hz.
    pub full_frequency_hz: Vec<f64>,
    /// Relative error of the responses between the kept degrees of freedom.
    pub error: BandError,
}

impl Reduction {
    pub(super) fn new(model: &LinearModel, result: ReductionResult) -> Reduction {
        let hertz = |omega: &[f64]| omega.iter().map(|omega| omega / TAU).collect();
        let matrices = result.model.matrices;
        let t = &matrices.transform;
        let columns = (0..t.ncols()).map(|j| model.expand(t.col_as_slice(j)));
        let columns: Vec<Vec<f64>> = columns.collect();
        let row = |dof: usize| columns.iter().map(|column| column[dof]).collect();
        Reduction {
            transformation: (0..model.transform.len()).map(row).collect(),
            mass: to_rows(&matrices.mass),
            damping: to_rows(&matrices.damping),
            stiffness: to_rows(&matrices.stiffness),
            frequency_hz: hertz(&result.omega),
            full_frequency_hz: hertz(&result.full),
            error: result.error,
            coordinates: matrices.names,
        }
    }
}
