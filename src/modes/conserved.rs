//! Rigid-body modes with gyroscopic coupling: `η̈_F + C_Fk η̇_k = 0` conserves `η̇_F + C_Fk η_k`, so that both roots of each are exactly
//! zero and the other modes have the stiffness `K_ik − C_iF C_Fk`.

use super::companion::is_free;
use crate::numeric::Complex;
use crate::numeric::quadratic::QuadraticEigenproblem;

/// Rigid-body modes eliminated from the equations, with the coefficients to recover them.
pub(super) struct CyclicCoordinates {
    /// Indices of the modes without stiffness.
    free: Vec<usize>,
    /// Index and row `C_Fk` of each eliminated mode.
    rows: Vec<(usize, Vec<f64>)>,
}

/// Largest coupling of two rigid-body modes that counts as rounding, relative to the largest entry of C.
const ROUNDING_TOLERANCE: f64 = 1e-12;

impl CyclicCoordinates {
    /// Eliminates modes among the first `n_rigid`, except those that gyroscopic terms couple to one another.
    pub fn new(eigenproblem: &QuadraticEigenproblem, n_rigid: usize) -> CyclicCoordinates {
        let c = &eigenproblem.damping;
        let n = eigenproblem.len();
        let largest = (0..n)
            .flat_map(|j| (0..n).map(move |i| c[(i, j)].abs()))
            .fold(0.0, f64::max);
        let free: Vec<usize> = (0..n_rigid.min(n))
            .filter(|&j| is_free(eigenproblem, j))
            .collect();
        let is_coupled = |&j: &usize| {
            free.iter()
                .any(|&i| c[(i, j)].abs() > ROUNDING_TOLERANCE * largest)
        };
        let rows = free.iter().filter(|j| !is_coupled(j)).map(|&j| {
            let row = (0..n).map(|k| if free.contains(&k) { 0.0 } else { c[(j, k)] });
            (j, row.collect::<Vec<f64>>())
        });
        let rows = rows
            .filter(|(_, row)| row.iter().any(|x| *x != 0.0))
            .collect();
        CyclicCoordinates { free, rows }
    }

    /// Eigenproblem after the elimination.
    pub fn eliminate(&self, mut eigenproblem: QuadraticEigenproblem) -> QuadraticEigenproblem {
        let n = eigenproblem.len();
        for (f, row) in &self.rows {
            // The coupling between two rigid-body modes is rounding and is ignored.
            let elastic = (0..n).filter(|i| !self.free.contains(i));
            for i in elastic {
                let coupling = eigenproblem.damping[(i, *f)];
                for (k, x) in row.iter().enumerate().filter(|t| *t.1 != 0.0) {
                    eigenproblem.stiffness[(i, k)] -= coupling * x;
                }
            }
            for i in 0..n {
                eigenproblem.damping[(i, *f)] = 0.0;
                eigenproblem.damping[(*f, i)] = 0.0;
            }
        }
        eigenproblem
    }

    /// Recovers the eliminated components of a mode shape from `λ η_F = −C_Fk η_k`.
    pub fn recover(&self, lambda: Complex, x: &mut [Complex]) {
        for (f, row) in &self.rows {
            let sum = row.iter().zip(x.iter()).map(|(c, x)| *x * *c);
            x[*f] = -sum.fold(Complex::ZERO, |s, t| s + t) / lambda;
        }
    }
}
