//! Matrix–vector and matrix–matrix products into preallocated storage.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatRef, Par};

use super::vector_ops::gemv;
use super::{Matrix, registers};

/// A matrix column after column, without gaps.
#[derive(Debug)]
pub struct ColumnMatrix {
    rows: usize,
    entries: Vec<f64>,
}

impl ColumnMatrix {
    /// Converts a matrix.
    pub fn from_matrix(a: &Matrix) -> ColumnMatrix {
        let columns = (0..a.ncols()).flat_map(|j| a.col_as_slice(j).iter().copied());
        ColumnMatrix {
            rows: a.nrows(),
            entries: columns.collect(),
        }
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn n_columns(&self) -> usize {
        self.entries.len().checked_div(self.rows).unwrap_or(0)
    }

    /// `out = A x`.
    pub fn mul_vec(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let column = |j: usize| &self.entries[j * self.rows..][..self.rows];
        gemv(out, x, column);
    }

    /// The first `n_columns` columns of `A B`, into those of `out`.
    pub fn mul_leading_columns(&self, b: &Matrix, count: usize, out: &mut Matrix) {
        let columns = out.as_mut().subcols_mut(0, count);
        let a = MatRef::from_column_major_slice(&self.entries, self.rows, self.n_columns());
        matmul(
            columns,
            Accum::Replace,
            a,
            b.subcols(0, count),
            1.0,
            Par::Seq,
        );
        registers::zero_upper();
    }
}
