//! Symmetric matrices within their profile, of each row the entries from the first that is not zero to the diagonal, and `A = L Lᵀ` of chosen
//! rows and columns, which keeps the profile.
//!
//! A diagonal matrix costs n operations, blocks on the diagonal the sum of theirs, a full matrix n³/3 (George and Liu, Computer Solution of
//! Large Sparse Positive Definite Systems, 1981, ch. 4).

use super::vector_ops::dot;
use crate::base::code::Code;
use crate::base::error::Error;

/// A symmetric matrix within its profile, or the factor L of one.
#[derive(Debug, Clone, Default)]
pub struct ProfileMatrix {
    /// Row by row.
    entries: Vec<f64>,
    /// Number of entries up to the end of each row, which is its diagonal.
    ends: Vec<usize>,
}

impl ProfileMatrix {
    /// The diagonal matrix of these entries.
    pub fn diagonal(entries: Vec<f64>) -> ProfileMatrix {
        ProfileMatrix {
            ends: (1..=entries.len()).collect(),
            entries,
        }
    }

    /// Blocks along the diagonal, each as its lower triangle row by row.
    pub fn from_blocks(blocks: impl Iterator<Item = Vec<f64>>) -> ProfileMatrix {
        let mut matrix = ProfileMatrix::default();
        for block in blocks {
            let (mut begin, mut length) = (0, 1);
            while begin < block.len() {
                matrix.push(&block[begin..begin + length]);
                (begin, length) = (begin + length, length + 1);
            }
        }
        matrix
    }

    /// The matrix of `n` rows, row by row; the lower triangle is read.
    pub fn from_rows(rows: &[f64], n: usize) -> ProfileMatrix {
        let mut matrix = ProfileMatrix::default();
        for (i, row) in rows.chunks_exact(n).enumerate() {
            let begin = row[..i].iter().position(|x| *x != 0.0).unwrap_or(i);
            matrix.push(&row[begin..=i]);
        }
        matrix
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.ends.len()
    }

    /// Entries within the profile, row by row.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// `A x`.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; x.len()];
        for i in 0..self.rows() {
            let (begin, row) = self.row(i);
            product[i] += dot(row, &x[begin..=i]);
            let above = product[begin..i].iter_mut().zip(row);
            above.for_each(|(p, a)| *p += a * x[i]);
        }
        product
    }

    /// The factor of the rows and columns `set`, ascending.
    ///
    /// Errors: `IllPosed` where a pivot is not positive.
    pub fn cholesky(&self, set: &[usize]) -> Result<Cholesky, Error> {
        let mut factor = ProfileMatrix::default();
        let mut row = Vec::new();
        for (i, &at) in set.iter().enumerate() {
            let (column, entries) = self.row(at);
            let begin = set[..i].partition_point(|&j| j < column);
            row.clear();
            row.extend(set[begin..=i].iter().map(|&j| entries[j - column]));
            for j in begin..i {
                let (other_begin, other) = factor.row(j);
                let common = begin.max(other_begin);
                let left = &row[common - begin..j - begin];
                let product = dot(left, &other[common - other_begin..j - other_begin]);
                row[j - begin] = (row[j - begin] - product) / other[j - other_begin];
            }
            let pivot = row[i - begin] - dot(&row[..i - begin], &row[..i - begin]);
            if !(pivot > 0.0 && pivot.is_finite()) {
                let n = self.rows();
                let message = format!(
                    "a symmetric matrix of {n} rows is not positive definite (pivot {pivot} at row {at})"
                );
                return Err(Error::new(Code::IllPosed, message));
            }
            row[i - begin] = pivot.sqrt();
            factor.push(&row);
        }
        Ok(Cholesky(factor))
    }

    fn push(&mut self, row: &[f64]) {
        self.entries.extend_from_slice(row);
        self.ends.push(self.entries.len());
    }

    /// Column of the first entry of a row, and its entries.
    fn row(&self, i: usize) -> (usize, &[f64]) {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        let row = &self.entries[start..self.ends[i]];
        (i + 1 - row.len(), row)
    }
}

/// The factor L of some rows and columns of a matrix.
pub struct Cholesky(ProfileMatrix);

impl Cholesky {
    /// `A x = b`; b becomes x.
    pub fn solve(&self, b: &mut [f64]) {
        let n = self.0.rows();
        for i in 0..n {
            let (begin, row) = self.0.row(i);
            let known = dot(&row[..i - begin], &b[begin..i]);
            b[i] = (b[i] - known) / row[i - begin];
        }
        for i in (0..n).rev() {
            let (begin, row) = self.0.row(i);
            b[i] /= row[i - begin];
            let x = b[i];
            let above = b[begin..i].iter_mut().zip(row);
            above.for_each(|(b, l)| *b -= l * x);
        }
    }
}
