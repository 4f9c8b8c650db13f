//! Balancing by a diagonal of powers of two, which costs no digit: Parlett & Reinsch, Numer. Math. 13 (1969), pp. 293–304.

use super::Matrix;

/// `D⁻¹ A D` with rows and columns of like size, and the powers of two in D.
///
/// `add` takes one more entry into the size of a row or column: [`f64::hypot`] for lengths, `|sum, x| sum + x.abs()` for sums.
pub fn balance(a: &Matrix, add: impl Fn(f64, f64) -> f64) -> (Matrix, Vec<f64>) {
    let n = a.nrows();
    let (mut b, mut scale) = (a.clone(), vec![1.0; n]);
    for _ in 0..MAX_PASSES {
        let mut settled = true;
        for i in 0..n {
            let others = || (0..n).filter(|&j| j != i);
            let column = others().fold(0.0, |sum, j| add(sum, b[(j, i)]));
            let row = others().fold(0.0, |sum, j| add(sum, b[(i, j)]));
            if column == 0.0 || row == 0.0 {
                continue;
            }
            let f = (0.5 * (row.log2() - column.log2()))
                .round()
                .clamp(-500.0, 500.0)
                .exp2();
            if column * f + row / f < MIN_REDUCTION * (column + row) {
                settled = false;
                scale[i] *= f;
                others().for_each(|j| b[(j, i)] *= f);
                others().for_each(|j| b[(i, j)] /= f);
            }
        }
        if settled {
            break;
        }
    }
    (b, scale)
}

const MIN_REDUCTION: f64 = 0.95; // of Parlett & Reinsch
const MAX_PASSES: usize = 100; // a handful in practice
