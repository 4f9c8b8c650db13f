//! Massless coordinates in the modal equations: damped ones keep a state, others are condensed.

use super::modal_matrices::ModalMatrices;
use crate::base::error::Error;
use crate::numeric::quadratic::QuadraticEigenproblem;
use crate::numeric::{Complex, Matrix, symmetric};

/// The massless coordinates in a basis of those a damper brakes (y) and those that follow statically (z).
pub(super) struct MasslessReduction {
    n_modes: usize,
    /// Columns over d: y first, then z.
    turn: Matrix,
    n_braked: usize,
    /// `z = recovery · (η, y)`.
    recovery: Matrix,
}

impl MasslessReduction {
    pub(super) fn new(modal: &ModalMatrices) -> Result<MasslessReduction, Error> {
        let (m, l) = (modal.n_modes, modal.n_massless);
        let block = Matrix::from_fn(l, l, |i, j| {
            (modal.damping[(m + i, m + j)] + modal.damping[(m + j, m + i)]) / 2.0
        });
        let eigen = symmetric::symmetric_eigen(&block)?;
        let largest = eigen.values.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        // Relative to the largest damper on a massless coordinate: below this is rounding of the rank-one sums.
        let braked: Vec<bool> = eigen
            .values
            .iter()
            .map(|&v| v.abs() > 1e-13 * largest)
            .collect();
        let order: Vec<usize> = (0..l)
            .filter(|&k| braked[k])
            .chain((0..l).filter(|&k| !braked[k]))
            .collect();
        let turn = Matrix::from_fn(l, l, |i, k| eigen.vectors[(i, order[k])]);
        let n_braked = braked.iter().filter(|&&b| b).count();
        Ok(MasslessReduction {
            n_modes: m,
            turn,
            n_braked,
            recovery: Matrix::zeros(l - n_braked, m + n_braked),
        })
    }

    pub(super) fn condense(&self, modal: &ModalMatrices) -> Result<QuadraticEigenproblem, Error> {
        let (m, l) = (modal.n_modes, modal.n_massless);
        let keep = m + self.n_braked;
        let turned = |a: &Matrix| -> Matrix {
            let full = Matrix::from_fn(m + l, m + l, |i, j| match (i < m, j < m) {
                (true, true) => f64::from(u8::from(i == j)),
                (false, false) => self.turn[(i - m, j - m)],
                _ => 0.0,
            });
            if l == 0 {
                a.clone()
            } else {
                full.transpose() * a * &full
            }
        };
        let (damping, stiffness) = (turned(&modal.damping), turned(&modal.stiffness));
        let cut = |a: &Matrix| Matrix::from_fn(keep, keep, |i, j| a[(i, j)]);
        let mut eigenproblem = QuadraticEigenproblem {
            n_inertial: m,
            damping: cut(&damping),
            stiffness: cut(&stiffness),
            hysteretic: modal.hysteretic.as_ref().map(|h| cut(&turned(h))),
        };
        if keep < m + l {
            let follow = self.static_recovery(&stiffness, keep, m + l)?;
            let up = Matrix::from_fn(keep, m + l - keep, |i, j| stiffness[(i, keep + j)]);
            eigenproblem.stiffness = &eigenproblem.stiffness + &up * &follow;
        }
        Ok(eigenproblem)
    }

    pub(super) fn static_recovery(
        &self,
        stiffness: &Matrix,
        keep: usize,
        all: usize,
    ) -> Result<Matrix, Error> {
        let corner = Matrix::from_fn(all - keep, all - keep, |i, j| {
            stiffness[(keep + i, keep + j)]
        });
        let side = Matrix::from_fn(all - keep, keep, |i, j| -stiffness[(keep + i, j)]);
        symmetric::lu_solve(&corner, &side)
    }

    /// (η, d) from (η, y); what follows statically beyond the undamped shapes is nil where the strain energy is a sum of squares.
    pub(super) fn expand(&self, x: &[Complex]) -> Vec<Complex> {
        let m = self.n_modes;
        let mut z: Vec<Complex> = x[..m].to_vec();
        for i in 0..self.turn.nrows() {
            let braked = (0..self.n_braked).map(|k| x[m + k] * self.turn[(i, k)]);
            let follows = (0..self.recovery.nrows()).map(|k| {
                let value = (0..x.len())
                    .map(|j| x[j] * self.recovery[(k, j)])
                    .fold(Complex::ZERO, |s, t| s + t);
                value * self.turn[(i, self.n_braked + k)]
            });
            z.push(braked.chain(follows).fold(Complex::ZERO, |s, t| s + t));
        }
        z
    }
}
