//! Cholesky factor `M = L Lᵀ` of a mass matrix, a row of square roots where M is diagonal.

use super::vector_ops::dot;
use super::{Matrix, symmetric};
use crate::base::error::Error;

/// `L` of `M = L Lᵀ`.
#[derive(Debug)]
pub enum MassFactor {
    /// Square roots of the diagonal.
    Diagonal(Vec<f64>),
    /// Lower triangle.
    Lower(Matrix),
}

impl MassFactor {
    /// Factor of a diagonal mass matrix, all entries positive.
    pub fn diagonal(mass: impl Iterator<Item = f64>) -> MassFactor {
        MassFactor::Diagonal(mass.map(f64::sqrt).collect())
    }

    /// Factor of a full mass matrix.
    ///
    /// # Errors
    /// A mass matrix that is not positive definite.
    pub fn full(mass: &Matrix) -> Result<MassFactor, Error> {
        symmetric::cholesky(mass).map(MassFactor::Lower)
    }

    /// `L⁻¹ w`: a direction over the mass-normalised coordinates `x = Lᵀ q`.
    pub fn solve(&self, w: &[f64]) -> Vec<f64> {
        match self {
            MassFactor::Diagonal(root) => w.iter().zip(root).map(|(w, r)| w / r).collect(),
            MassFactor::Lower(l) => {
                let column = Matrix::from_fn(w.len(), 1, |i, _| w[i]);
                let solved = symmetric::solve_lower(l, &column);
                (0..w.len()).map(|i| solved[(i, 0)]).collect()
            }
        }
    }

    /// `L⁻ᵀ V`: shapes over q.
    pub fn solve_transposed(&self, v: &Matrix) -> Matrix {
        match self {
            MassFactor::Diagonal(root) => {
                Matrix::from_fn(v.nrows(), v.ncols(), |i, j| v[(i, j)] / root[i])
            }
            MassFactor::Lower(l) => symmetric::solve_lower_transposed(l, v),
        }
    }

    /// `A L⁻ᵀ`.
    pub fn right_divide(&self, a: &Matrix) -> Matrix {
        match self {
            MassFactor::Diagonal(root) => {
                Matrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / root[j])
            }
            MassFactor::Lower(l) => symmetric::solve_lower(l, &a.transpose().to_owned())
                .transpose()
                .to_owned(),
        }
    }

    /// `L V`.
    pub fn times(&self, v: &Matrix) -> Matrix {
        match self {
            MassFactor::Diagonal(root) => {
                Matrix::from_fn(v.nrows(), v.ncols(), |i, j| v[(i, j)] * root[i])
            }
            MassFactor::Lower(l) => l * v,
        }
    }

    /// `Lᵀ p`.
    pub fn transposed_times(&self, p: &[f64]) -> Vec<f64> {
        match self {
            MassFactor::Diagonal(root) => root.iter().zip(p).map(|(root, p)| root * p).collect(),
            MassFactor::Lower(l) => (0..l.ncols())
                .map(|j| dot(&l.col_as_slice(j)[j..], &p[j..]))
                .collect(),
        }
    }
}
