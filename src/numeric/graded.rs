//! Singular values of graded matrices to high relative accuracy; static condensation.
//!
//! With `A = √k W M^-½` (a row per branch, a column per degree of freedom) the singular values are the natural frequencies,
//! `ω² x = Aᵀ A x`. Forming `K = AᵀA` loses all digits of ω below √ε times the largest. Instead `A = L D U` with
//! complete pivoting, `L D = Q R`, and one-sided Jacobi on the rows of `R U`: Demmel, Gu, Eisenstat, Slapničar,
//! Veselić & Drmač, Linear Algebra Appl. 299 (1999), pp. 21–80, Algorithm 3.1. Measured at a spread of 1e14 in
//! stiffness and 1e12 in inertia: 2e-15 relative (`tests/machine/numeric_graded.rs`).

use crate::base::code::Code;
use crate::base::error::Error;

use super::jacobi::orthogonalise;
use super::pivoted_qr::{back_substitute, dot, norm, pivoted_qr, subtract};
use super::rank_revealing::{RankRevealingLdu, null_vectors, rank_revealing_ldu, solve_upper};
use super::sorting::sort_ascending;
use super::{Matrix, check_finite};

/// Singular value decomposition of a graded matrix: singular values and right singular vectors.
#[derive(Debug, Clone)]
pub struct GradedSvd {
    /// Singular values, ascending, one per column of the matrix; those beyond the rank are exactly zero and come first.
    pub values: Vec<f64>,
    /// Right singular vectors as orthonormal columns, in the order of the values.
    pub vectors: Matrix,
    /// Number of Jacobi sweeps.
    pub sweeps: usize,
}

/// Singular value decomposition of a matrix of any shape to high relative accuracy.
///
/// `rank` is the rank known otherwise, such as from a graph: the remainder after so many steps is rounding and is
/// dropped. The default rank is the smaller dimension, less columns that vanish exactly.
///
/// Errors: `Overflow` if an entry is not finite or a value leaves the range of doubles; `NoConvergence`.
pub fn svd(a: &Matrix, rank: Option<usize>) -> Result<GradedSvd, Error> {
    let n = a.ncols();
    check_finite(a, "a graded matrix")?;
    let scale = middle_scale(a);
    let rows = (0..a.nrows())
        .map(|i| (0..n).map(|j| a[(i, j)] / scale).collect())
        .collect();
    let revealed = rank_revealing_ldu(rows, rank.unwrap_or(n));

    let mut rotated = rows_of_product(&revealed, n);
    let (lengths, sweeps) = orthogonalise(&mut rotated)?;
    let mut by_value: Vec<usize> = (0..rotated.len()).filter(|&i| lengths[i] > 0.0).collect();
    sort_ascending(&mut by_value, |&i| lengths[i]);
    let live: Vec<Vec<f64>> = by_value
        .iter()
        .map(|&i| rotated[i].iter().map(|x| x / lengths[i]).collect())
        .collect();

    let mut vectors = null_space(null_vectors(&revealed, n), &live, n);
    let mut values = vec![0.0; vectors.len()];
    vectors.extend(live);
    values.extend(by_value.iter().map(|&i| lengths[i] * scale));
    if values
        .iter()
        .chain(vectors.iter().flatten())
        .any(|x| !x.is_finite())
    {
        return Err(Error::new(
            Code::Overflow,
            format!(
                "a singular value of a {}×{n} matrix is too large",
                a.nrows()
            ),
        ));
    }
    Ok(GradedSvd {
        values,
        vectors: Matrix::from_fn(n, n, |i, j| vectors[j][i]),
        sweeps,
    })
}

/// Power of two at the geometric mean of the largest and the smallest entry.
fn middle_scale(a: &Matrix) -> f64 {
    let sizes = (0..a.ncols())
        .flat_map(|j| a.col_as_slice(j))
        .map(|x| x.abs())
        .filter(|&x| x > 0.0);
    let (small, large) = sizes.fold((f64::MAX, 0.0_f64), |(small, large), x| {
        (small.min(x), large.max(x))
    });
    if large == 0.0 {
        1.0
    } else {
        (0.5 * (small.log2() + large.log2())).round().exp2()
    }
}

/// Rows of `R Πᵀ U`, where `L D Π = Q R`: the factor of `A = L D U` without Q, which changes no right singular vector.
fn rows_of_product(revealed: &RankRevealingLdu, n: usize) -> Vec<Vec<f64>> {
    let rank = revealed.pivots.len();
    let r = pivoted_qr(revealed.lower.clone(), rank, rank, 0.0);
    let mut rows = vec![vec![0.0; n]; r.steps];
    for (column, &pivot) in r.columns.iter().zip(&r.order) {
        rows.iter_mut()
            .zip(column)
            .for_each(|(row, x)| subtract(row, -x, &revealed.upper[pivot]));
    }
    rows
}

/// Orthonormal complement of the vectors `live`: the known null vectors, extended to dimension n.
fn null_space(known: Vec<Vec<f64>>, live: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    let independent = 0.5 / (n as f64).sqrt(); // at least one unit vector has 1/√n of itself in the complement
    let mut null: Vec<Vec<f64>> = Vec::new();
    let units = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect());
    for mut x in known.into_iter().chain(units) {
        if null.len() + live.len() == n {
            break;
        }
        normalise(&mut x);
        if orthogonalise_against(&mut x, &null, live) < independent {
            continue;
        }
        normalise(&mut x);
        orthogonalise_against(&mut x, &null, live);
        normalise(&mut x);
        null.push(x);
    }
    null
}

/// Orthogonalises x against orthonormal vectors; returns its remaining norm.
fn orthogonalise_against(x: &mut [f64], null: &[Vec<f64>], live: &[Vec<f64>]) -> f64 {
    for known in null.iter().chain(live) {
        let component = dot(x, known);
        subtract(x, component, known);
    }
    norm(x)
}

fn normalise(x: &mut [f64]) {
    let length = norm(x);
    x.iter_mut().for_each(|x| *x /= length);
}

/// Static condensation of massless degrees of freedom from `A`.
#[derive(Debug, Clone)]
pub struct StaticCondensation {
    /// Condensed `A` on the remaining degrees of freedom, a column for each of them.
    pub condensed: Matrix,
    /// Recovery matrix: `x_first = recovery · x_rest`.
    pub recovery: Matrix,
    /// An undetermined degree of freedom among the first; its recovered value is zero.
    pub singular: Option<usize>,
}

/// Static condensation of the `first` columns of `a`, which carry no inertia, without forming `K`.
///
/// With `A_first = L D U` and `[L D, A_rest] = Q [R₁₁ R₁₂; 0 R₂₂]` the energy `½‖A x‖²` is least over
/// `x_first = −U⁻¹ R₁₁⁻¹ R₁₂ x_rest`, where it is `½‖R₂₂ x_rest‖²`. The reflections lose no digit of a short row to a long one.
///
/// Errors: `Overflow` if an entry is not finite.
pub fn condense(a: &Matrix, first: usize) -> Result<StaticCondensation, Error> {
    check_finite(a, "a graded matrix")?;
    let first = first.min(a.ncols());
    let n_retained = a.ncols() - first;
    let columns: Vec<Vec<f64>> = (0..a.ncols()).map(|j| a.col_as_slice(j).to_vec()).collect();
    let negligible = 8.0 * (a.ncols() as f64) * f64::EPSILON; // of the row's size: its backward error, with a margin
    let qr = pivoted_qr(columns[..first].to_vec(), first, first, negligible);
    let rank = qr.steps;
    let singular = qr.order[rank..].iter().min().copied();

    let revealed = rank_revealing_ldu(
        (0..a.nrows())
            .map(|i| (0..first).map(|j| a[(i, j)]).collect())
            .collect(),
        rank,
    );
    let rank = revealed.pivots.len();
    let reduced = pivoted_qr(
        revealed
            .lower
            .iter()
            .chain(&columns[first..])
            .cloned()
            .collect(),
        rank,
        rank,
        0.0,
    );
    let condensed = Matrix::from_fn(a.nrows() - rank, n_retained, |i, j| {
        reduced.columns[rank + j][rank + i]
    });
    let mut recovery = Matrix::zeros(first, n_retained);
    for (j, solved) in back_substitute(&reduced, rank).iter().enumerate() {
        let mut right = vec![0.0; rank];
        solved
            .iter()
            .zip(&reduced.order)
            .for_each(|(x, &index)| right[index] = -x);
        let x = solve_upper(&revealed, vec![0.0; first], &right);
        x.iter()
            .enumerate()
            .for_each(|(i, x)| recovery[(i, j)] = *x);
    }
    Ok(StaticCondensation {
        condensed,
        recovery,
        singular,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> Matrix {
        Matrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    }

    fn assert_orthonormal(vectors: &Matrix) {
        let gram = vectors.transpose() * vectors;
        for (i, j) in (0..gram.nrows()).flat_map(|i| (0..gram.ncols()).map(move |j| (i, j))) {
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!(
                (gram[(i, j)] - expected).abs() < 1e-13,
                "({i}, {j}): {}",
                gram[(i, j)]
            );
        }
    }

    /// n equal discs, one end held: ω_j = 2 sin((2j − 1) π / (4n + 2)).
    #[test]
    fn exact_uniform_chain() {
        let n = 50;
        let a = Matrix::from_fn(n, n, |i, j| {
            [1.0, -1.0].get(i.wrapping_sub(j)).copied().unwrap_or(0.0)
        });
        let found = svd(&a, None).unwrap();
        for (j, value) in found.values.iter().enumerate() {
            let exact =
                2.0 * ((2 * j + 1) as f64 * std::f64::consts::PI / (4 * n + 2) as f64).sin();
            assert!((value / exact - 1.0).abs() < 2e-14, "{j}: {value} {exact}");
        }
        assert_orthonormal(&found.vectors);
    }

    /// Three discs on two springs, free: one exact zero with equal angles.
    #[test]
    fn exact_rigid_mode() {
        let found = svd(&matrix(&[&[-1.0, 1.0, 0.0], &[0.0, -1e7, 1e7]]), Some(2)).unwrap();
        assert_eq!(found.values[0], 0.0);
        assert!((0..3).all(|i| (found.vectors[(i, 0)].abs() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-15));
        assert!((found.values[1] / 1.5_f64.sqrt() - 1.0).abs() < 1e-13);
        assert_orthonormal(&found.vectors);
    }

    /// A x_j has length σ_j, and images of different vectors are orthogonal, for wide, tall and deficient shapes.
    #[test]
    fn law_images_are_orthogonal() {
        for (m, n) in [(3, 7), (7, 3), (6, 6)] {
            let a = Matrix::from_fn(m, n, |i, j| {
                ((7 * i * i + 3 * j + i * j * j) % 11) as f64 - 5.0
            });
            let found = svd(&a, None).unwrap();
            assert_orthonormal(&found.vectors);
            let images = &a * &found.vectors;
            let gram = images.transpose() * &images;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let expected = if i == j {
                    found.values[i] * found.values[i]
                } else {
                    0.0
                };
                assert!(
                    (gram[(i, j)] - expected).abs() < 1e-12,
                    "{m}×{n} ({i}, {j})"
                );
            }
        }
    }

    /// Entries from 1e-150 to 1e150.
    #[test]
    fn survives_the_range_of_doubles() {
        let found = svd(&matrix(&[&[1e150, 0.0], &[1e150, 1e-150]]), None).unwrap();
        assert!(
            (found.values[1] / 2.0_f64.sqrt() / 1e150 - 1.0).abs() < 1e-15,
            "{:?}",
            found.values
        );
        assert!(
            (found.values[0] * 2.0_f64.sqrt() / 1e-150 - 1.0).abs() < 1e-15,
            "{:?}",
            found.values
        );
    }

    #[test]
    fn survives_nothing_at_all() {
        assert!(svd(&Matrix::zeros(0, 0), None).unwrap().values.is_empty());
        let none = svd(&Matrix::zeros(0, 2), Some(0)).unwrap();
        assert_eq!(none.values, [0.0, 0.0]);
        assert_orthonormal(&none.vectors);
        assert_orthonormal(&svd(&Matrix::zeros(3, 2), None).unwrap().vectors);
    }

    #[test]
    fn refuses_what_is_not_finite() {
        assert_eq!(
            svd(&matrix(&[&[1.0, f64::NAN]]), None).unwrap_err().code,
            Code::Overflow
        );
        assert_eq!(
            condense(&matrix(&[&[f64::INFINITY]]), 1).unwrap_err().code,
            Code::Overflow
        );
    }

    /// Springs of 1 and 1e14 N·m/rad in series over a massless node: k = 1/(1 + 1e-14), the node moves with the stiff end.
    #[test]
    fn exact_springs_in_series() {
        // columns: massless node, stiff end, soft end
        let out = condense(&matrix(&[&[1.0, 0.0, -1.0], &[1e7, -1e7, 0.0]]), 1).unwrap();
        assert_eq!(out.singular, None);
        assert_eq!((out.condensed.nrows(), out.condensed.ncols()), (1, 2));
        assert!((out.condensed[(0, 0)].abs() - 1.0).abs() < 1e-13);
        assert!(
            (out.recovery[(0, 1)] / 1e-14 - 1.0).abs() < 1e-12,
            "{}",
            out.recovery[(0, 1)]
        );
        assert!((out.recovery[(0, 0)] - 1.0).abs() < 1e-13);
    }

    /// Two massless nodes joined to each other and to nothing else.
    #[test]
    fn survives_a_massless_node_that_nothing_holds() {
        let out = condense(&matrix(&[&[1.0, -1.0, 0.0], &[0.0, 0.0, 1.0]]), 2).unwrap();
        assert!(out.singular.is_some());
        assert!(out.condensed.nrows() >= 1 && out.recovery.ncols() == 1);
    }
}
