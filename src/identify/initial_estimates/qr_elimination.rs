//! QR elimination of each response's own unknowns: `min Σ_q ‖N x_q − F_q S c‖²` (Deschrijver et al.).
//!
//! Deschrijver, Mrozowski, Dhaene & De Zutter, IEEE Microw. Wirel. Compon. Lett. 18 (2008), pp. 383–385, eqs. (7)–(9).

use super::partial_fractions::apply_weights;
use super::problem::CommonPoleProblem;
use crate::numeric::{Complex, Matrix, least_squares};

/// Rows R with `‖R c‖² = Σ_q min_x ‖w_q (N x − F_q S c)‖²`: N and S unweighted, real above imaginary parts.
pub fn common_rows(problem: &CommonPoleProblem, numerator: &Matrix, shared: &Matrix) -> Matrix {
    let n = shared.ncols();
    let orthonormal = |weight: &[f64]| {
        let mut own = numerator.clone();
        apply_weights(&mut own, weight);
        least_squares::orthonormal_basis(&own)
    };
    let alike = (problem.weights.len() == 1).then(|| orthonormal(problem.weight(0)));
    let mut stack = Matrix::zeros(0, n);
    let mut heights: Vec<Matrix> = Vec::new();
    for (q, response) in problem.responses.iter().enumerate() {
        if problem.factors[q] == 0.0 {
            continue;
        }
        let weight = problem.weight(q);
        let driven = times(shared, response, weight, problem.factors[q]);
        let beside = match &alike {
            Some(basis) => least_squares::project_out(basis, &driven),
            None => least_squares::project_out(&orthonormal(weight), &driven),
        };
        heights.push(least_squares::qr_r(&beside));
        if heights.len() == STACK_LEN {
            stack = least_squares::qr_r(&vstack(&stack, &heights));
            heights.clear();
        }
    }
    least_squares::qr_r(&vstack(&stack, &heights))
}

/// Triangles brought to one at a time: few enough to stay small, enough to be worth a reduction.
const STACK_LEN: usize = 16;

/// One above the other.
pub fn vstack(first: &Matrix, more: &[Matrix]) -> Matrix {
    let n = first.ncols();
    let rows = first.nrows() + more.iter().map(|m| m.nrows()).sum::<usize>();
    let mut all = Matrix::zeros(rows, n);
    for j in 0..n {
        let mut at = 0;
        for part in std::iter::once(first).chain(more) {
            all.col_as_slice_mut(j)[at..at + part.nrows()].copy_from_slice(part.col_as_slice(j));
            at += part.nrows();
        }
    }
    all
}

/// `w F S`, complex products of real and imaginary rows.
fn times(shared: &Matrix, response: &[Complex], weight: &[f64], factor: f64) -> Matrix {
    let lines = response.len();
    let values: Vec<Complex> = response
        .iter()
        .zip(weight)
        .map(|(f, w)| f * (w * factor))
        .collect();
    let mut product = Matrix::zeros(2 * lines, shared.ncols());
    for j in 0..shared.ncols() {
        let (re, im) = shared.col_as_slice(j).split_at(lines);
        let (top, bottom) = product.col_as_slice_mut(j).split_at_mut(lines);
        for (k, f) in values.iter().enumerate() {
            top[k] = f.re * re[k] - f.im * im[k];
            bottom[k] = f.re * im[k] + f.im * re[k];
        }
    }
    product
}
