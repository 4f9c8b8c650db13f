//! Orthonormal bases of column spaces: `A = Q R` by Householder reflections (Householder 1958).

use faer::linalg::matmul::matmul;
use faer::{Accum, Par};

use super::{Matrix, registers};

/// `A = Q R` with as many columns of Q as of A.
#[derive(Debug, Clone)]
pub struct ThinQr {
    /// Orthonormal columns.
    pub q: Matrix,
    /// Upper triangle.
    pub r: Matrix,
}

/// A pivot of R below this share of a unit column says that the column lies in the span of those before it.
const DEPENDENT: f64 = 1e-14;

/// Factors a matrix with at least as many rows as columns.
pub fn thin_qr(a: &Matrix) -> ThinQr {
    if a.ncols() == 0 {
        return ThinQr {
            q: a.clone(),
            r: Matrix::zeros(0, 0),
        };
    }
    let qr = a.qr();
    let q = qr.compute_thin_Q();
    registers::zero_upper();
    ThinQr {
        q,
        r: qr.thin_R().to_owned(),
    }
}

impl ThinQr {
    /// `R⁻¹ B` for columns of A scaled to length one; what belongs to a dependent column is set to zero.
    pub fn solve(&self, b: &Matrix) -> Matrix {
        let n = self.r.nrows();
        let mut x = b.clone();
        for j in 0..x.ncols() {
            let column = x.col_as_slice_mut(j);
            for i in (0..n).rev() {
                let pivot = self.r[(i, i)];
                column[i] = if pivot.abs() > DEPENDENT {
                    column[i] / pivot
                } else {
                    0.0
                };
                let value = column[i];
                let above = &self.r.col_as_slice(i)[..i];
                column[..i]
                    .iter_mut()
                    .zip(above)
                    .for_each(|(c, r)| *c -= value * r);
            }
        }
        x
    }
}

/// `Aᵀ B`.
pub fn transposed_product(a: &Matrix, b: &Matrix) -> Matrix {
    let product = a.transpose() * b;
    registers::zero_upper();
    product
}

/// `A − B C`.
pub fn sub_product(a: &Matrix, b: &Matrix, c: &Matrix) -> Matrix {
    let mut left = a.clone();
    if b.ncols() > 0 {
        matmul(&mut left, Accum::Add, b, c, -1.0, Par::Seq);
        registers::zero_upper();
    }
    left
}

/// Rows `from..to` of a matrix.
pub fn rows(a: &Matrix, from: usize, to: usize) -> Matrix {
    a.subrows(from, to - from).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns come back from Q R, Q is orthonormal, a repeated column gets no share.
    #[test]
    fn law_factors_and_dependent_columns() {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut a = Matrix::from_fn(40, 5, |_, _| rng.f64() - 0.5);
        for j in 0..5 {
            let norm = a.col_as_slice(j).iter().map(|x| x * x).sum::<f64>().sqrt();
            a.col_as_slice_mut(j).iter_mut().for_each(|x| *x /= norm);
        }
        let qr = thin_qr(&a);
        let back = &qr.q * &qr.r;
        let gram = transposed_product(&qr.q, &qr.q);
        for i in 0..5 {
            for j in 0..5 {
                assert!((gram[(i, j)] - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
        assert!((0..40).all(|i| (0..5).all(|j| (back[(i, j)] - a[(i, j)]).abs() < 1e-14)));
        let first = a.col_as_slice(0).to_vec();
        a.col_as_slice_mut(4).copy_from_slice(&first);
        let qr = thin_qr(&a);
        let y = Matrix::from_fn(40, 1, |i, _| 2.0 * first[i]);
        let c = qr.solve(&transposed_product(&qr.q, &y));
        assert!((c[(0, 0)] - 2.0).abs() < 1e-13 && c[(4, 0)] == 0.0);
    }
}
