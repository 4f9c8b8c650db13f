//! Rank-revealing factorisation `A = L D U` with complete pivoting; D contains the grading.
//!
//! Demmel, Gu, Eisenstat, Slapničar, Veselić & Drmač, Computing the singular value decomposition with high relative
//! accuracy, Linear Algebra Appl. 299 (1999), pp. 21–80, §§2–4. For an acyclic sparsity pattern, such as that of a torsional tree,
//! no update subtracts, and every entry of L, D and U has full relative accuracy for any grading (§6 there).

use super::pivoted_qr::{dot, subtract};

/// Factors of a matrix, one column of L and one row of U per pivot.
pub(super) struct RankRevealingLdu {
    /// Columns of `L D`, in the row order of `A`.
    pub lower: Vec<Vec<f64>>,
    /// Rows of U, in the column order of `A`; one at the pivot of the row, zero at earlier pivots.
    pub upper: Vec<Vec<f64>>,
    /// Column of each pivot.
    pub pivots: Vec<usize>,
}

/// Factorises with the largest remaining entry as pivot, up to `steps` times or until the remainder is zero.
pub(super) fn rank_revealing_ldu(mut rows: Vec<Vec<f64>>, steps: usize) -> RankRevealingLdu {
    let mut factors = RankRevealingLdu {
        lower: vec![],
        upper: vec![],
        pivots: vec![],
    };
    while factors.pivots.len() < steps {
        let Some((row_index, column)) = largest(&rows) else {
            break;
        };
        let pivot = rows[row_index][column];
        let lower: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        let mut upper: Vec<f64> = rows[row_index].iter().map(|x| x / pivot).collect();
        upper[column] = 1.0;
        for (row, factor) in rows
            .iter_mut()
            .zip(&lower)
            .filter(|(_, factor)| **factor != 0.0)
        {
            subtract(row, *factor, &upper);
            row[column] = 0.0;
        }
        rows[row_index].fill(0.0);
        factors.lower.push(lower);
        factors.upper.push(upper);
        factors.pivots.push(column);
    }
    factors
}

/// Null vectors of U, one for every column without a pivot.
pub(super) fn null_vectors(factors: &RankRevealingLdu, n: usize) -> Vec<Vec<f64>> {
    let free = (0..n).filter(|j| !factors.pivots.contains(j));
    let solve = |j: usize| {
        let mut x = vec![0.0; n];
        x[j] = 1.0;
        solve_upper(factors, x, &vec![0.0; factors.pivots.len()])
    };
    free.map(solve).collect()
}

/// Solves `U x = rhs` for the entries of x at pivots; the other entries of x are given.
pub(super) fn solve_upper(factors: &RankRevealingLdu, mut x: Vec<f64>, rhs: &[f64]) -> Vec<f64> {
    for (k, &pivot) in factors.pivots.iter().enumerate().rev() {
        x[pivot] = rhs[k] - dot(&factors.upper[k], &x);
    }
    x
}

/// Row and column of the largest entry; `None` for a zero matrix.
fn largest(rows: &[Vec<f64>]) -> Option<(usize, usize)> {
    let mut best = (0.0, None);
    for (i, row) in rows.iter().enumerate() {
        let peak = row.iter().fold(0.0, |peak: f64, x| peak.max(x.abs()));
        if peak > best.0 {
            best = (
                peak,
                row.iter().position(|x| x.abs() == peak).map(|j| (i, j)),
            );
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The product of the factors equals the matrix, and the null vector of a rank-two matrix is exact.
    #[test]
    fn exact_product_and_null_vector() {
        let rows = vec![
            vec![-1.0, 1.0, 0.0],
            vec![0.0, -1e7, 1e7],
            vec![-2.0, 0.0, 2.0],
        ];
        let factors = rank_revealing_ldu(rows.clone(), 2);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let product: f64 = factors
                .lower
                .iter()
                .zip(&factors.upper)
                .map(|(l, u)| l[i] * u[j])
                .sum();
            assert!(
                (product - rows[i][j]).abs() <= 1e-15,
                "({i}, {j}): {product}"
            );
        }
        assert_eq!(null_vectors(&factors, 3), [[1.0, 1.0, 1.0]]);
    }
}
