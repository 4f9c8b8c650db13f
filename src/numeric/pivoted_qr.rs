//! Householder QR with row and column exchanges, `P A Π = Q R`, row-wise backward stable.
//!
//! Powell & Reid, On applying Householder transformations to linear least squares problems, IFIP 1968 (1969),
//! pp. 122–126; Cox & Higham, Stability of Householder QR factorization for weighted least squares problems,
//! Numerical Analysis 1997 (1998), pp. 57–73: with column pivoting, the largest entry of the pivot column brought to
//! row k, and `r_kk = −sign(a_kk) ‖a_k‖`, the error of row i is a few ε times the largest entry row i ever had.
//! (Sorting the rows once is not enough here: a row whose leading part is spent may still be long in other columns,
//! and would swamp a short row it is reflected into.)

pub(super) use super::vector_ops::dot;

/// Partial factorisation of `A` after reflections: `R` in the rows above `steps`, the reduced rest below.
pub(super) struct PivotedQr {
    /// Columns in pivoted order, each as long as `A` has rows.
    pub columns: Vec<Vec<f64>>,
    /// Column j here is column `order[j]` of `A`.
    pub order: Vec<usize>,
    /// Reflections made.
    pub steps: usize,
}

/// Reflects away up to `steps` of the `leading` columns.
///
/// Ends early where no entry left in these exceeds `negligible` times the ∞-norm its row had in them.
pub(super) fn pivoted_qr(
    mut columns: Vec<Vec<f64>>,
    leading: usize,
    steps: usize,
    negligible: f64,
) -> PivotedQr {
    let n_rows = columns.first().map_or(0, Vec::len);
    let size_of = |i: usize| {
        columns[..leading]
            .iter()
            .map(|c| c[i].abs())
            .fold(0.0, f64::max)
    };
    let mut size: Vec<f64> = (0..n_rows).map(size_of).collect();
    let mut order: Vec<usize> = (0..columns.len()).collect();
    for k in 0..steps.min(leading).min(n_rows) {
        let is_left = |column: &Vec<f64>| {
            column[k..]
                .iter()
                .zip(&size[k..])
                .any(|(x, size)| x.abs() > negligible * size)
        };
        let candidates = (k..leading).filter(|&j| is_left(&columns[j]));
        let Some((pivot, length)) = candidates
            .map(|j| (j, norm(&columns[j][k..])))
            .reduce(|best, next| if next.1 > best.1 { next } else { best })
        else {
            return PivotedQr {
                columns,
                order,
                steps: k,
            };
        };
        columns.swap(k, pivot);
        order.swap(k, pivot);
        let row = (k..n_rows)
            .reduce(|a, b| {
                if columns[k][b].abs() > columns[k][a].abs() {
                    b
                } else {
                    a
                }
            })
            .unwrap_or(k);
        size.swap(k, row);
        columns.iter_mut().for_each(|column| column.swap(k, row));
        reflect(&mut columns, k, length);
    }
    let steps = steps.min(leading).min(n_rows);
    PivotedQr {
        columns,
        order,
        steps,
    }
}

/// `R₁₁⁻¹ R₁₂`: one column for every pivoted column from `from` on, entry i belonging to pivoted column i.
pub(super) fn back_substitute(model: &PivotedQr, from: usize) -> Vec<Vec<f64>> {
    let r = &model.columns;
    let solve = |right: &Vec<f64>| {
        let mut x = right[..model.steps].to_vec();
        for j in (0..model.steps).rev() {
            x[j] /= r[j][j];
            let (above, at) = x.split_at_mut(j);
            subtract(above, at[0], &r[j][..j]);
        }
        x
    };
    r[from..].iter().map(solve).collect()
}

/// `H = I − τ v vᵀ`, `v_k = 1`, turns column k below row k into `r_kk`; applied to all columns after it.
fn reflect(columns: &mut [Vec<f64>], k: usize, length: f64) {
    let (head, tail) = columns.split_at_mut(k + 1);
    let pivot = &mut head[k][k..];
    let r = if pivot[0] > 0.0 { -length } else { length };
    let lead = pivot[0] - r;
    let tau = -lead / r;
    pivot[1..].iter_mut().for_each(|x| *x /= lead);
    for column in tail {
        let column = &mut column[k..];
        let along = tau * (column[0] + dot(&pivot[1..], &column[1..]));
        column[0] -= along;
        subtract(&mut column[1..], along, &pivot[1..]);
    }
    pivot.fill(0.0);
    pivot[0] = r;
}

/// `y − a x` in place of y.
pub(super) fn subtract(y: &mut [f64], a: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y -= a * x);
}

/// `‖x‖`, also where the squares leave the range of doubles.
pub(super) fn norm(x: &[f64]) -> f64 {
    let squared = dot(x, x);
    if SAFE_SQUARES.contains(&squared) {
        return squared.sqrt();
    }
    let largest = x.iter().fold(0.0, |big: f64, x| big.max(x.abs()));
    if largest == 0.0 {
        return 0.0;
    }
    largest * x.iter().map(|x| (x / largest).powi(2)).sum::<f64>().sqrt()
}

/// Sums of products within this range have lost nothing to underflow or overflow.
pub(super) const SAFE_SQUARES: std::ops::Range<f64> = 1e-280..1e280;

#[cfg(test)]
mod tests {
    use super::*;

    /// 3-4-5 at both ends of the range of doubles.
    #[test]
    fn exact_norm_does_not_overflow() {
        assert!((norm(&[3e-200, 4e-200]) / 5e-200 - 1.0).abs() < 4.0 * f64::EPSILON);
        assert!((norm(&[3e200, 4e200]) / 5e200 - 1.0).abs() < 4.0 * f64::EPSILON);
        assert_eq!(norm(&[0.0, 0.0]), 0.0);
    }

    /// RᵀR = AᵀA on a small matrix, columns in pivoted order.
    #[test]
    fn law_lengths_and_angles_stay() {
        let a = vec![
            vec![1.0, -2.0, 0.5, 3.0],
            vec![0.0, 4.0, -1.0, 2.0],
            vec![2.0, 2.0, 7.0, -1.0],
        ];
        let model = pivoted_qr(a.clone(), 3, 3, 0.0);
        for i in 0..3 {
            for j in 0..3 {
                let before = dot(&a[model.order[i]], &a[model.order[j]]);
                assert!((dot(&model.columns[i], &model.columns[j]) - before).abs() < 1e-14 * 60.0);
            }
        }
    }

    /// A dependent column ends the reduction.
    #[test]
    fn exact_rank_one() {
        let model = pivoted_qr(
            vec![vec![1.0, 2.0], vec![2.0, 4.0]],
            2,
            2,
            4.0 * f64::EPSILON,
        );
        assert_eq!(model.steps, 1);
    }
}
