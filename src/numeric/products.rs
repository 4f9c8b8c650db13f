//! Products of matrices into room that is there.

use faer::linalg::matmul::matmul;
use faer::{Accum, Par};

use super::{Matrix, registers};

/// The first `count` columns of `A B`, into those of `out`.
pub fn first_columns(a: &Matrix, b: &Matrix, count: usize, out: &mut Matrix) {
    let columns = out.as_mut().subcols_mut(0, count);
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
