//! Modes from an extended observability matrix, order by order.
//!
//! The columns of U that belong to the n largest singular values span `[C; CA; CA²; …]` in some basis, so that `U↓ = U↑ A` without
//! its first and last block row; `A φ = λ φ`, poles `rate · ln λ`, shapes `C φ`. Peeters & De Roeck, Mech. Syst. Signal Process. 13
//! (1999), eqs. (20)–(27). With `U↑ᵀU↑` formed once, an order costs one small solve and one eigenproblem.

use crate::base::error::Error;
use crate::identify::mode::IdentifiedMode;
use crate::numeric::factors::Svd;
use crate::numeric::{Complex, ComplexMatrix, Matrix, definite, general};

/// Modes of one order.
#[derive(Debug, Clone)]
pub struct OrderModes {
    /// States of the model.
    pub order: usize,
    /// All with a pole above the real axis, by rising frequency; those that are only noise among them.
    pub modes: Vec<IdentifiedMode>,
}

/// The left singular vectors, and the products every order is cut from.
pub(super) struct Observability {
    /// Square.
    pub u: Matrix,
    /// Rows of a block: responses.
    pub rows: usize,
    /// `U↑ᵀU↑`.
    pub gram: Matrix,
    /// `U↑ᵀU↓`.
    pub shifted: Matrix,
}

/// One eigenpair of one order.
pub(super) struct Eigenpair {
    pub value: Complex,
    /// `A φ = λ φ`.
    pub right: Vec<Complex>,
    /// `χᴴ A = λ χᴴ`, `χᴴ φ = 1`.
    pub left: Vec<Complex>,
}

impl Observability {
    /// Of the first `highest` columns.
    pub fn new(svd: &Svd, rows: usize, highest: usize) -> Observability {
        let u = svd.u.clone();
        let kept = u.nrows() - rows;
        let up = u.submatrix(0, 0, kept, highest);
        let down = u.submatrix(rows, 0, kept, highest);
        Observability {
            gram: up.transpose() * up,
            shifted: up.transpose() * down,
            rows,
            u,
        }
    }

    /// Eigenpairs of order `n` above the real axis.
    pub fn eigenpairs(&self, n: usize) -> Result<Vec<Eigenpair>, Error> {
        let gram = self.gram.submatrix(0, 0, n, n).to_owned();
        let shifted = self.shifted.submatrix(0, 0, n, n).to_owned();
        let a = definite::solve(&gram, &shifted)?;
        let found = general::eigen(&a)?;
        let column = |m: &ComplexMatrix, k: usize| m.col_as_slice(k).to_vec();
        Ok((0..n)
            .filter(|&k| found.values[k].im > 0.0)
            .map(|k| Eigenpair {
                value: found.values[k],
                right: column(&found.right, k),
                left: column(&found.left, k),
            })
            .collect())
    }

    /// The shape `C φ` in the units of the responses, its largest component 1.
    pub fn shape(&self, pair: &Eigenpair, scale: &[f64]) -> Vec<Complex> {
        let mut shape: Vec<Complex> = (0..self.rows)
            .map(|c| {
                let sum: Complex = (pair.right.iter().enumerate())
                    .map(|(j, &x)| x * self.u[(c, j)])
                    .sum();
                sum * scale[c]
            })
            .collect();
        let largest = (shape.iter().copied())
            .max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()))
            .unwrap_or(Complex::new(1.0, 0.0));
        if largest.norm() > 0.0 {
            shape.iter_mut().for_each(|x| *x /= largest);
        }
        shape
    }
}

/// The continuous pole of a discrete one, rad/s.
pub(super) fn continuous(value: Complex, rate_hz: f64) -> Complex {
    Complex::new(value.norm().ln(), value.im.atan2(value.re)) * rate_hz
}
