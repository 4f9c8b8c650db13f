//! Rigid motions that gyroscopic terms couple to others: `η̈_F + C_Fk η̇_k = 0` conserves `η̇_F + C_Fk η_k`, so that both roots of each
//! are exactly zero and the others see `K_ik − C_iF C_Fk`.

use super::companion::is_free;
use crate::numeric::Complex;
use crate::numeric::quadratic::QuadraticEigenproblem;

/// Rigid motions taken out of the equations, and the way back.
pub(super) struct CyclicCoordinates {
    /// Modes that no stiffness holds.
    free: Vec<usize>,
    /// Each of them that is taken out, with `C_Fk`.
    rows: Vec<(usize, Vec<f64>)>,
}

/// Coupling of two rigid motions that is rounding, relative to the largest entry of C.
const ROUNDING_TOLERANCE: f64 = 1e-12;

impl CyclicCoordinates {
    /// Finds them among the first `n_rigid` modes; those that gyroscopic terms couple to one another are left alone.
    pub fn new(eigenproblem: &QuadraticEigenproblem, n_rigid: usize) -> CyclicCoordinates {
        let c = &eigenproblem.damping;
        let n = eigenproblem.len();
        let largest = (0..n)
            .flat_map(|j| (0..n).map(move |i| c[(i, j)].abs()))
            .fold(0.0, f64::max);
        let all: Vec<usize> = (0..n_rigid.min(n))
            .filter(|&j| is_free(eigenproblem, j))
            .collect();
        let coupled = |&j: &usize| {
            all.iter()
                .any(|&i| c[(i, j)].abs() > ROUNDING_TOLERANCE * largest)
        };
        let rows = all.iter().filter(|j| !coupled(j)).map(|&j| {
            let row = (0..n).map(|k| if all.contains(&k) { 0.0 } else { c[(j, k)] });
            (j, row.collect::<Vec<f64>>())
        });
        let rows = rows
            .filter(|(_, row)| row.iter().any(|x| *x != 0.0))
            .collect();
        CyclicCoordinates { free: all, rows }
    }

    /// The equations of the others.
    pub fn without(&self, mut eigenproblem: QuadraticEigenproblem) -> QuadraticEigenproblem {
        let n = eigenproblem.len();
        for (f, row) in &self.rows {
            // Two rigid motions see no more of each other than rounding.
            let others = (0..n).filter(|i| !self.free.contains(i));
            for i in others {
                let back = eigenproblem.damping[(i, *f)];
                for (k, x) in row.iter().enumerate().filter(|t| *t.1 != 0.0) {
                    eigenproblem.stiffness[(i, k)] -= back * x;
                }
            }
            for i in 0..n {
                eigenproblem.damping[(i, *f)] = 0.0;
                eigenproblem.damping[(*f, i)] = 0.0;
            }
        }
        eigenproblem
    }

    /// Their share in a mode: `λ η_F = −C_Fk η_k`.
    pub fn recover(&self, lambda: Complex, x: &mut [Complex]) {
        for (f, row) in &self.rows {
            let sum = row.iter().zip(x.iter()).map(|(c, x)| *x * *c);
            x[*f] = -sum.fold(Complex::ZERO, |s, t| s + t) / lambda;
        }
    }
}
