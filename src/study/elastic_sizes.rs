//! The sizes of states without what rigid motions carry them along: `q − R (RᵀMR)⁻¹ RᵀM q`.

use crate::motion::dynamic_model::DynamicModel;
use crate::motion::problem::OdeProblem;
use crate::numeric::vector_ops::dot;
use crate::numeric::{Matrix, symmetric};

/// The largest size of every state, and of its part that deforms something.
pub struct ElasticSizes {
    rigid: Vec<Vec<f64>>,
    momenta: Vec<Vec<f64>>,
    inertia: Matrix,
    n: usize,
    whole: Vec<f64>,
    elastic: Vec<f64>,
}

/// A deformation below this, relative to the motion it is the rest of, is rounding.
const ROUNDING_TOLERANCE: f64 = 1e-12;

impl ElasticSizes {
    /// Sizes for a machine with these rigid motions.
    pub fn new(model: &DynamicModel, rigid: &[Vec<f64>]) -> ElasticSizes {
        let momenta: Vec<Vec<f64>> = rigid.iter().map(|r| model.momentum(r)).collect();
        let inertia = Matrix::from_fn(rigid.len(), rigid.len(), |i, j| dot(&rigid[i], &momenta[j]));
        let states = model.len();
        ElasticSizes {
            rigid: rigid.to_vec(),
            momenta,
            inertia,
            n: model.coordinate_count(),
            whole: vec![0.0; states],
            elastic: vec![0.0; states],
        }
    }

    /// Takes note of a state.
    pub fn note(&mut self, y: &[f64]) {
        let mut rest = y.to_vec();
        for part in [0..self.n, self.n..2 * self.n] {
            let right: Vec<f64> = self
                .momenta
                .iter()
                .map(|p| dot(p, &y[part.clone()]))
                .collect();
            let Ok(shares) = symmetric::solve_semidefinite(&self.inertia, &right) else {
                continue;
            };
            for (r, share) in self.rigid.iter().zip(shares) {
                rest[part.clone()]
                    .iter_mut()
                    .zip(r)
                    .for_each(|(x, r)| *x -= share * r);
            }
        }
        for (i, y) in y.iter().enumerate() {
            self.whole[i] = self.whole[i].max(y.abs());
            self.elastic[i] = self.elastic[i].max(rest[i].abs());
        }
    }

    /// The sizes of deformations; where nothing deforms, of the states themselves.
    pub fn sizes(self) -> Vec<f64> {
        let largest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
        let positions = 0..self.n;
        match largest(&self.elastic[positions.clone()])
            > ROUNDING_TOLERANCE * largest(&self.whole[positions])
        {
            true => self.elastic,
            false => self.whole,
        }
    }
}
