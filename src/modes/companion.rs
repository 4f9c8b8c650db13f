//! Companion (first-order) form of the modal equations over `(s η, η̇, y)`.

use super::modal_basis::ModalBasis;
use super::mode::modulus;
use crate::base::error::Error;
use crate::numeric::quadratic::QuadraticEigenproblem;
use crate::numeric::{Complex, Matrix, symmetric};

/// A mode that no stiffness holds, so that zero is its root.
pub(super) fn is_free(eigenproblem: &QuadraticEigenproblem, j: usize) -> bool {
    let k = &eigenproblem.stiffness;
    (0..eigenproblem.len()).all(|i| k[(i, j)] == 0.0 && k[(j, i)] == 0.0)
}

/// Which components the first-order form has: positions of some modes, rates of some, and y.
pub(super) struct CompanionForm {
    pub(super) positions: Vec<usize>,
    pub(super) rates: Vec<usize>,
    pub(super) scale: Vec<f64>,
    pub(super) n_damped_massless: usize,
    pub(super) n_modes: usize,
}

impl CompanionForm {
    pub(super) fn new(
        eigenproblem: &QuadraticEigenproblem,
        basis: &ModalBasis,
        n_undamped_rigid: usize,
    ) -> CompanionForm {
        let m = eigenproblem.n_inertial;
        let positions: Vec<usize> = (0..m).filter(|&j| !is_free(eigenproblem, j)).collect();
        let alone = |j: usize| {
            j < n_undamped_rigid
                && is_free(eigenproblem, j)
                && (0..eigenproblem.len()).all(|i| {
                    eigenproblem.damping[(i, j)] == 0.0 && eigenproblem.damping[(j, i)] == 0.0
                })
        };
        let rates = (0..m).filter(|&j| !alone(j)).collect();
        let scale = positions
            .iter()
            .map(|&j| {
                if basis.omega[j] > 0.0 {
                    basis.omega[j]
                } else {
                    1.0
                }
            })
            .collect();
        CompanionForm {
            positions,
            rates,
            scale,
            n_damped_massless: eigenproblem.len() - m,
            n_modes: m,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.positions.len() + self.rates.len() + self.n_damped_massless
    }

    pub(super) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The state matrix over `(s η, η̇, y)`, s the scale of each position.
    pub(super) fn matrix(&self, eigenproblem: &QuadraticEigenproblem) -> Result<Matrix, Error> {
        let (np, nr, ny, m) = (
            self.positions.len(),
            self.rates.len(),
            self.n_damped_massless,
            self.n_modes,
        );
        let (c, k) = (&eigenproblem.damping, &eigenproblem.stiffness);
        let n = self.len();
        let mut a = Matrix::zeros(n, n);
        for (p, &j) in self.positions.iter().enumerate() {
            if let Some(r) = self.rates.iter().position(|&i| i == j) {
                a[(p, np + r)] = self.scale[p];
            }
        }
        // Force rows of every mode and of y, over the state: −K(position, y) − C(rate).
        let row = |i: usize| -> Vec<f64> {
            let mut row = vec![0.0; n];
            self.positions
                .iter()
                .enumerate()
                .for_each(|(p, &j)| row[p] = -k[(i, j)] / self.scale[p]);
            self.rates
                .iter()
                .enumerate()
                .for_each(|(r, &j)| row[np + r] = -c[(i, j)]);
            (0..ny).for_each(|y| row[np + nr + y] = -k[(i, m + y)]);
            row
        };
        if ny > 0 {
            let corner = Matrix::from_fn(ny, ny, |i, j| c[(m + i, m + j)]);
            let rows: Vec<Vec<f64>> = (0..ny).map(|y| row(m + y)).collect();
            let right = Matrix::from_fn(ny, n, |y, s| rows[y][s]);
            let rate = symmetric::lu_solve(&corner, &right)?;
            (0..ny).for_each(|y| (0..n).for_each(|s| a[(np + nr + y, s)] = rate[(y, s)]));
        }
        for (r, &i) in self.rates.iter().enumerate() {
            let force = row(i);
            for s in 0..n {
                let braked: f64 = (0..ny).map(|y| c[(i, m + y)] * a[(np + nr + y, s)]).sum();
                a[(np + r, s)] = force[s] - braked;
            }
        }
        Ok(a)
    }

    /// Contribution of H to the state matrix: it acts as an imaginary part of K.
    pub(super) fn hysteretic(
        &self,
        eigenproblem: &QuadraticEigenproblem,
        h: &Matrix,
    ) -> Result<Matrix, Error> {
        let with = |stiffness: Matrix| QuadraticEigenproblem {
            stiffness,
            hysteretic: None,
            ..eigenproblem.clone()
        };
        let n = eigenproblem.len();
        Ok(self.matrix(&with(h.clone()))? - self.matrix(&with(Matrix::zeros(n, n)))?)
    }

    /// (η, y) from an eigenvector of the state matrix.
    pub(super) fn positions(
        &self,
        eigenproblem: &QuadraticEigenproblem,
        lambda: Complex,
        v: &[Complex],
    ) -> Vec<Complex> {
        let (np, nr) = (self.positions.len(), self.rates.len());
        let mut x = vec![Complex::ZERO; eigenproblem.len()];
        for (r, &j) in self.rates.iter().enumerate() {
            // Where the root is far from zero the rate says the position too; else the stored position does.
            if modulus(lambda) > 0.0 {
                x[j] = v[np + r] / lambda;
            }
        }
        for (p, &j) in self.positions.iter().enumerate() {
            x[j] = v[p] / self.scale[p];
        }
        (0..self.n_damped_massless).for_each(|y| x[self.n_modes + y] = v[np + nr + y]);
        x
    }
}
