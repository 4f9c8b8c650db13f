//! A machine in one regime over its modes: `η̈ + D η̇ + (ω² + K) η = Σ a z + …`, `ż = s η̇ − z/T`.

use crate::numeric::Matrix;

/// The equations.
#[derive(Debug)]
pub struct Equations {
    /// rad/s, zero for the first ones.
    pub omega: Vec<f64>,
    /// Modes that nothing acts on and that act on nothing, but drag.
    pub free: usize,
    /// Modes whose position acts on nothing, the free ones among them.
    pub rigid: usize,
    /// Drag of the free modes, 1/s.
    pub drag: f64,
    /// D.
    pub damping: Damping,
    /// What stiffness there is beside the squares.
    pub stiffness: Option<Matrix>,
    /// Inner states.
    pub inner: Vec<Inner>,
}

/// D.
#[derive(Debug)]
pub enum Damping {
    /// Its diagonal: nothing is beside it.
    Diagonal(Vec<f64>),
    /// All of it.
    Full(Matrix),
}

/// An inner state.
#[derive(Debug)]
pub struct Inner {
    /// 1/T, 1/s.
    pub decay: f64,
    /// s, over the modes' rates.
    pub seen: Vec<f64>,
    /// a, over the modes.
    pub acts: Vec<f64>,
    /// z of one in units in which it is of the size of rates.
    pub scale: f64,
}

impl Equations {
    /// How many modes.
    pub fn count(&self) -> usize {
        self.omega.len()
    }

    /// D as a matrix.
    pub fn damping_matrix(&self) -> Matrix {
        match &self.damping {
            Damping::Full(d) => d.clone(),
            Damping::Diagonal(d) => Matrix::from_fn(d.len(), d.len(), |i, j| match i == j {
                true => d[i],
                false => 0.0,
            }),
        }
    }
}
