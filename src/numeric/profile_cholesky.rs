//! `A = L Lᵀ` of chosen rows and columns of a symmetric matrix within its profile: what is left of the first entry of a row stays empty.
//!
//! A diagonal matrix costs n operations, a full one n³/3 (George and Liu, Computer Solution of Large Sparse Positive Definite Systems,
//! 1981, ch. 4).

use crate::base::code::Code;
use crate::base::error::Error;

/// The factor of some rows and columns; each row of L begins where the row of A does.
pub struct ProfileCholesky {
    rows: Vec<Vec<f64>>,
    /// Column of the first entry of each row.
    begins: Vec<usize>,
}

impl ProfileCholesky {
    /// The factor of the rows and columns `set`, ascending, of a matrix of `n` rows, row by row; the lower triangle is read.
    ///
    /// Errors: `IllPosed` where a pivot is not positive.
    pub fn new(matrix: &[f64], n: usize, set: &[usize]) -> Result<ProfileCholesky, Error> {
        let mut factor = ProfileCholesky {
            rows: Vec::with_capacity(set.len()),
            begins: Vec::with_capacity(set.len()),
        };
        for (i, &at) in set.iter().enumerate() {
            let entries = &matrix[at * n..(at + 1) * n];
            let mut columns = set[..i].iter();
            let begin = columns.position(|&j| entries[j] != 0.0).unwrap_or(i);
            let mut row: Vec<f64> = set[begin..=i].iter().map(|&j| entries[j]).collect();
            for j in begin..i {
                let common = begin.max(factor.begins[j]);
                let other = &factor.rows[j];
                let left = &row[common - begin..j - begin];
                let product: f64 = dot(left, &other[common - factor.begins[j]..]);
                row[j - begin] = (row[j - begin] - product) / other[j - factor.begins[j]];
            }
            let pivot = row[i - begin] - dot(&row[..i - begin], &row[..i - begin]);
            if !(pivot > 0.0 && pivot.is_finite()) {
                let message = format!(
                    "a symmetric matrix of {n} rows is not positive definite (pivot {pivot} at row {at})"
                );
                return Err(Error::new(Code::IllPosed, message));
            }
            row[i - begin] = pivot.sqrt();
            factor.rows.push(row);
            factor.begins.push(begin);
        }
        Ok(factor)
    }

    /// `A x = b`; b becomes x.
    pub fn solve(&self, b: &mut [f64]) {
        for (i, (row, &begin)) in self.rows.iter().zip(&self.begins).enumerate() {
            let known = dot(&row[..i - begin], &b[begin..i]);
            b[i] = (b[i] - known) / row[i - begin];
        }
        for (i, (row, &begin)) in self.rows.iter().zip(&self.begins).enumerate().rev() {
            b[i] /= row[i - begin];
            let x = b[i];
            let above = b[begin..i].iter_mut().zip(row);
            above.for_each(|(b, l)| *b -= l * x);
        }
    }
}

/// Sum of products over the shorter of two slices.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
