//! Modal equations of one regime, `η̈ + D η̇ + (ω² + K) η = Σ a z`, `ż = s η̇ − z/T`.

use crate::numeric::Matrix;

/// Equations of motion in modal coordinates.
#[derive(Debug)]
pub struct ModalEquations {
    /// rad/s, zero for the first ones.
    pub omega: Vec<f64>,
    /// Modes that nothing acts on and that act on nothing, but drag.
    pub free: usize,
    /// Modes whose position acts on nothing, the free ones among them.
    pub rigid: usize,
    /// Drag of the free modes, 1/s.
    pub drag: f64,
    /// D.
    pub damping: ModalDamping,
    /// Stiffness in addition to the squares.
    pub stiffness: Option<Matrix>,
    /// Inner states.
    pub inner: Vec<InternalState>,
}

/// Modal damping matrix D.
#[derive(Debug)]
pub enum ModalDamping {
    /// Diagonal damping, without off-diagonal terms.
    Diagonal(Vec<f64>),
    /// All of it.
    Full(Matrix),
}

/// An inner state.
#[derive(Debug)]
pub struct InternalState {
    /// 1/T, 1/s.
    pub decay: f64,
    /// s, over the modes' rates.
    pub velocity_row: Vec<f64>,
    /// a, over the modes.
    pub force_column: Vec<f64>,
    /// z of one in units in which it is of the size of rates.
    pub scale: f64,
}

impl ModalEquations {
    /// Number of modes.
    pub fn count(&self) -> usize {
        self.omega.len()
    }

    /// D as a matrix.
    pub fn damping_matrix(&self) -> Matrix {
        match &self.damping {
            ModalDamping::Full(d) => d.clone(),
            ModalDamping::Diagonal(d) => Matrix::from_fn(d.len(), d.len(), |i, j| match i == j {
                true => d[i],
                false => 0.0,
            }),
        }
    }
}
