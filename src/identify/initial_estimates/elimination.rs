//! Elimination of each response's own unknowns: `min Σ_q ‖N x_q − F_q S c‖²` (Deschrijver et al.).
//!
//! Deschrijver, Mrozowski, Dhaene & De Zutter, IEEE Microw. Wirel. Compon. Lett. 18 (2008), pp. 383–385, eqs. (7)–(9). The common
//! triangle comes from two Cholesky factorisations instead of a QR of each response, the first one shifted: Fukaya, Kannan,
//! Nakatsukasa, Yamamoto & Yanagisawa, SIAM J. Sci. Comput. 42 (2020), A477–A503. Products of matrices are several times as fast as
//! reflections of thin ones.

use super::partial_fractions::apply_weights;
use super::problem::CommonPoleProblem;
use crate::base::error::Error;
use crate::numeric::parallel;
use crate::numeric::symmetric::{cholesky, product, solve_lower};
use crate::numeric::thin_qr::{sub_product, transposed_product};
use crate::numeric::{Complex, Matrix, least_squares};

/// A triangle R with `‖R c‖² = Σ_q min_x ‖w_q (N x − F_q S c)‖²`: N and S unweighted, real above imaginary parts.
///
/// # Errors
/// `Overflow` where a product is not finite.
pub fn common_rows(
    problem: &CommonPoleProblem,
    numerator: &Matrix,
    shared: &Matrix,
) -> Result<Matrix, Error> {
    let orthonormal = |weight: &[f64]| {
        let mut own = numerator.clone();
        apply_weights(&mut own, weight);
        line_blocks(&least_squares::orthonormal_basis(&own))
    };
    let alike = (problem.weights.len() == 1).then(|| orthonormal(problem.weight(0)));
    let used: Vec<usize> = (0..problem.responses.len())
        .filter(|&q| problem.factors[q] != 0.0)
        .collect();
    let n = shared.ncols();
    // Gram matrix of the columns w F S of a response less their part along its basis, and the coefficients of that part.
    let reduce = |q: usize, shared: &[Matrix], known: Option<Matrix>| {
        let (response, weight) = (&problem.responses[q], problem.weight(q));
        let own = alike.is_none().then(|| orthonormal(weight));
        let basis = own.as_ref().or(alike.as_ref()).map_or(&[][..], |b| b);
        let driven = |block: usize| {
            let from = block * BLOCK_LINES;
            let lines = from..(from + BLOCK_LINES).min(response.len());
            let (response, weight) = (&response[lines.clone()], &weight[lines]);
            times(&shared[block], response, weight, problem.factors[q])
        };
        let along = known.unwrap_or_else(|| {
            let zero = Matrix::zeros(numerator.ncols(), n);
            let parts = basis.iter().enumerate();
            parts.fold(zero, |sum, (k, b)| sum + transposed_product(b, &driven(k)))
        });
        let mut gram = Matrix::zeros(n, n);
        for (k, basis) in basis.iter().enumerate() {
            let columns = sub_product(&driven(k), basis, &along);
            gram += transposed_product(&columns, &columns);
        }
        (gram, along)
    };
    let sum = |reduced: &[(Matrix, Matrix)]| {
        let zero = Matrix::zeros(n, n);
        reduced.iter().fold(zero, |sum, (gram, _)| sum + gram)
    };
    let blocks = line_blocks(shared);
    let reduced = parallel::map(&used, |&q| reduce(q, &blocks, None));
    let first = shifted_cholesky(sum(&reduced))?;
    let inverse = solve_lower(&first, &Matrix::identity(n, n));
    let inverse = inverse.transpose().to_owned();
    let blocks: Vec<Matrix> = blocks.iter().map(|b| product(b, &inverse)).collect();
    let known: Vec<(usize, Matrix)> = (used.iter().zip(&reduced))
        .map(|(&q, (_, along))| (q, product(along, &inverse)))
        .collect();
    let reduced = parallel::map(&known, |(q, along)| {
        reduce(*q, &blocks, Some(along.clone()))
    });
    let second = shifted_cholesky(sum(&reduced))?;
    Ok(product(&first, &second).transpose().to_owned())
}

/// Lines whose rows of a matrix stay in the processor's cache.
const BLOCK_LINES: usize = 128;

/// Rows of real parts, then of imaginary parts, by blocks of lines.
fn line_blocks(all: &Matrix) -> Vec<Matrix> {
    let lines = all.nrows() / 2;
    let block = |from: usize| {
        let count = BLOCK_LINES.min(lines - from);
        let row = |k: usize| from + k % count + if k < count { 0 } else { lines };
        Matrix::from_fn(2 * count, all.ncols(), |k, j| all[(row(k), j)])
    };
    (0..lines).step_by(BLOCK_LINES).map(block).collect()
}

/// Share of a diagonal entry added to it, some times the rounding of sums over all lines.
const SHIFT: f64 = 1e-13;

/// Lower L with `L Lᵀ = G`, but for the shift; a column of zeros has a row of L below all others.
fn shifted_cholesky(mut gram: Matrix) -> Result<Matrix, Error> {
    for j in 0..gram.ncols() {
        gram[(j, j)] += (SHIFT * gram[(j, j)]).max(f64::MIN_POSITIVE);
    }
    cholesky(&gram)
}

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
