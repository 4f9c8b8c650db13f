//! Products of matrices and vectors into room that is there.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatRef, Par};

use super::slices::add_columns;
use super::{Matrix, registers};

/// A matrix column after column, without gaps.
#[derive(Debug)]
pub struct Columns {
    rows: usize,
    entries: Vec<f64>,
}

impl Columns {
    /// Of a matrix.
    pub fn of(a: &Matrix) -> Columns {
        let columns = (0..a.ncols()).flat_map(|j| a.col_as_slice(j).iter().copied());
        Columns {
            rows: a.nrows(),
            entries: columns.collect(),
        }
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many columns.
    pub fn count(&self) -> usize {
        self.entries.len().checked_div(self.rows).unwrap_or(0)
    }

    /// `out = A x`.
    pub fn times(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let column = |j: usize| &self.entries[j * self.rows..][..self.rows];
        add_columns(out, x, column);
    }

    /// The first `count` columns of `A B`, into those of `out`.
    pub fn first_columns(&self, b: &Matrix, count: usize, out: &mut Matrix) {
        let columns = out.as_mut().subcols_mut(0, count);
        let a = MatRef::from_column_major_slice(&self.entries, self.rows, self.count());
        matmul(
            columns,
            Accum::Replace,
            a,
            b.subcols(0, count),
            1.0,
            Par::Seq,
        );
        registers::clear();
    }
}
