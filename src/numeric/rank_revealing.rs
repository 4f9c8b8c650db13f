//! Rank-revealing `A = L D U` with complete pivoting; the grading goes into D.
//!
//! Demmel, Gu, Eisenstat, Slapničar, Veselić & Drmač, Computing the singular value decomposition with high relative
//! accuracy, Linear Algebra Appl. 299 (1999), pp. 21–80, §§2–4. Where the nonzeros form no cycle, as those of a
//! torsional tree, no update subtracts, and every entry of L, D and U has all its digits whatever the spread (§6 there).

use super::pivoted_qr::{dot, subtract};

/// The factors, as many steps as pivots were found.
pub(super) struct RankRevealingLdu {
    /// `L D` by columns, in the order of the rows of `A`.
    pub lower: Vec<Vec<f64>>,
    /// U by rows, in the order of the columns of `A`; one at its own pivot, zero at those before it.
    pub upper: Vec<Vec<f64>>,
    /// The column of each pivot.
    pub pivots: Vec<usize>,
}

/// Takes out the largest entry left, with its row and column, up to `steps` times or until nothing is left.
pub(super) fn rank_revealing_ldu(mut rows: Vec<Vec<f64>>, steps: usize) -> RankRevealingLdu {
    let mut found = RankRevealingLdu {
        lower: vec![],
        upper: vec![],
        pivots: vec![],
    };
    while found.pivots.len() < steps {
        let Some((at, column)) = largest(&rows) else {
            break;
        };
        let pivot = rows[at][column];
        let lower: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        let mut upper: Vec<f64> = rows[at].iter().map(|x| x / pivot).collect();
        upper[column] = 1.0;
        for (row, factor) in rows
            .iter_mut()
            .zip(&lower)
            .filter(|(_, factor)| **factor != 0.0)
        {
            subtract(row, *factor, &upper);
            row[column] = 0.0;
        }
        rows[at].fill(0.0);
        found.lower.push(lower);
        found.upper.push(upper);
        found.pivots.push(column);
    }
    found
}

/// Vectors that U maps to zero, one for every column without a pivot.
pub(super) fn null_vectors(found: &RankRevealingLdu, n: usize) -> Vec<Vec<f64>> {
    let free = (0..n).filter(|j| !found.pivots.contains(j));
    let solve = |j: usize| {
        let mut x = vec![0.0; n];
        x[j] = 1.0;
        solve_upper(found, x, &vec![0.0; found.pivots.len()])
    };
    free.map(solve).collect()
}

/// x with `U x = right`; the columns without a pivot keep what x holds.
pub(super) fn solve_upper(found: &RankRevealingLdu, mut x: Vec<f64>, right: &[f64]) -> Vec<f64> {
    for (k, &pivot) in found.pivots.iter().enumerate().rev() {
        x[pivot] = right[k] - dot(&found.upper[k], &x);
    }
    x
}

/// Row and column of the largest entry.
fn largest(rows: &[Vec<f64>]) -> Option<(usize, usize)> {
    let mut best = (0.0, None);
    for (i, row) in rows.iter().enumerate() {
        let size = row.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        if size > best.0 {
            best = (
                size,
                row.iter().position(|x| x.abs() == size).map(|j| (i, j)),
            );
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The product gives the matrix back, and the null vector of a rank-two matrix is the known one.
    #[test]
    fn exact_product_and_null_vector() {
        let rows = vec![
            vec![-1.0, 1.0, 0.0],
            vec![0.0, -1e7, 1e7],
            vec![-2.0, 0.0, 2.0],
        ];
        let found = rank_revealing_ldu(rows.clone(), 2);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let product: f64 = found
                .lower
                .iter()
                .zip(&found.upper)
                .map(|(l, u)| l[i] * u[j])
                .sum();
            assert!(
                (product - rows[i][j]).abs() <= 1e-15,
                "({i}, {j}): {product}"
            );
        }
        assert_eq!(null_vectors(&found, 3), [[1.0, 1.0, 1.0]]);
    }
}
