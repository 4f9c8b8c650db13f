//! The first-order form of modal equations, over `(s η, η̇, y)` with the scale s of each position.

use super::basis::Basis;
use super::mode::modulus;
use crate::base::error::Error;
use crate::numeric::quadratic::Quadratic;
use crate::numeric::{Complex, Matrix, definite};

/// A mode that no stiffness holds, so that zero is its root.
pub(super) fn is_free(quadratic: &Quadratic, j: usize) -> bool {
    let k = &quadratic.stiffness;
    (0..quadratic.len()).all(|i| k[(i, j)] == 0.0 && k[(j, i)] == 0.0)
}

/// Which components the first-order form has: positions of some modes, rates of some, and y.
pub(super) struct State {
    pub(super) positions: Vec<usize>,
    pub(super) rates: Vec<usize>,
    pub(super) scale: Vec<f64>,
    pub(super) n_braked: usize,
    pub(super) n_modes: usize,
}

impl State {
    pub(super) fn new(quadratic: &Quadratic, basis: &Basis, n_undamped_rigid: usize) -> State {
        let m = quadratic.inertial;
        let positions: Vec<usize> = (0..m).filter(|&j| !is_free(quadratic, j)).collect();
        let alone = |j: usize| {
            j < n_undamped_rigid
                && is_free(quadratic, j)
                && (0..quadratic.len())
                    .all(|i| quadratic.damping[(i, j)] == 0.0 && quadratic.damping[(j, i)] == 0.0)
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
        State {
            positions,
            rates,
            scale,
            n_braked: quadratic.len() - m,
            n_modes: m,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.positions.len() + self.rates.len() + self.n_braked
    }

    pub(super) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The state matrix over `(s η, η̇, y)`, s the scale of each position.
    pub(super) fn matrix(&self, quadratic: &Quadratic) -> Result<Matrix, Error> {
        let (np, nr, ny, m) = (
            self.positions.len(),
            self.rates.len(),
            self.n_braked,
            self.n_modes,
        );
        let (c, k) = (&quadratic.damping, &quadratic.stiffness);
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
            let rate = definite::solve(&corner, &right)?;
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

    /// What H adds to the state matrix: it acts as an imaginary part of K.
    pub(super) fn hysteretic(&self, quadratic: &Quadratic, h: &Matrix) -> Result<Matrix, Error> {
        let with = |stiffness: Matrix| Quadratic {
            stiffness,
            hysteretic: None,
            ..quadratic.clone()
        };
        let n = quadratic.len();
        Ok(self.matrix(&with(h.clone()))? - self.matrix(&with(Matrix::zeros(n, n)))?)
    }

    /// (η, y) from an eigenvector of the state matrix.
    pub(super) fn positions(
        &self,
        quadratic: &Quadratic,
        lambda: Complex,
        v: &[Complex],
    ) -> Vec<Complex> {
        let (np, nr) = (self.positions.len(), self.rates.len());
        let mut x = vec![Complex::ZERO; quadratic.len()];
        for (r, &j) in self.rates.iter().enumerate() {
            // Where the root is far from zero the rate says the position too; else the stored position does.
            if modulus(lambda) > 0.0 {
                x[j] = v[np + r] / lambda;
            }
        }
        for (p, &j) in self.positions.iter().enumerate() {
            x[j] = v[p] / self.scale[p];
        }
        (0..self.n_braked).for_each(|y| x[self.n_modes + y] = v[np + nr + y]);
        x
    }
}
