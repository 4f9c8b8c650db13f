//! Vector operations on slices: dot, axpy, linear combinations, outer products.

use super::Matrix;

/// `x / norm`, or x where the norm is zero.
pub fn normalised(mut x: Vec<f64>, norm: f64) -> Vec<f64> {
    if norm != 0.0 {
        x.iter_mut().for_each(|x| *x /= norm);
    }
    x
}

/// `Σ factors[row][column] basis[row]` for every column, in pieces that stay in the cache.
pub fn linear_combinations(basis: &[Vec<f64>], factors: &[Vec<f64>]) -> Vec<Vec<f64>> {
    const PIECE: usize = 512;
    let n = basis[0].len();
    let mut sums = vec![vec![0.0; n]; factors[0].len()];
    for start in (0..n).step_by(PIECE) {
        let piece = start..n.min(start + PIECE);
        for (row, v) in basis.iter().enumerate().take(factors.len()) {
            sums.iter_mut()
                .zip(&factors[row])
                .for_each(|(sum, &f)| axpy(&mut sum[piece.clone()], f, &v[piece.clone()]));
        }
    }
    sums
}

/// `x + factor v`.
pub fn axpy(x: &mut [f64], factor: f64, v: &[f64]) {
    x.iter_mut().zip(v).for_each(|(x, v)| *x += factor * v);
}

/// `out + Σ x_j column_j`, four columns at a time, then two; columns are of one length, and what of `out` is beyond stays.
pub fn gemv<'a>(out: &mut [f64], x: &[f64], column: impl Fn(usize) -> &'a [f64]) {
    let n = match x {
        [] => return,
        _ => out.len().min(column(0).len()),
    };
    let (out, column) = (&mut out[..n], |j: usize| &column(j)[..n]);
    let (fours, rest) = x.as_chunks::<4>();
    for (at, [p, q, r, s]) in fours.iter().enumerate() {
        let [a, b, c, d] = std::array::from_fn(|k| column(4 * at + k));
        for i in 0..n {
            out[i] += (a[i] * p + b[i] * q) + (c[i] * r + d[i] * s);
        }
    }
    let done = 4 * fours.len();
    let (twos, last) = rest.as_chunks::<2>();
    for [p, q] in twos {
        let (a, b) = (column(done), column(done + 1));
        for i in 0..n {
            out[i] += a[i] * p + b[i] * q;
        }
    }
    if let [x] = last {
        axpy(out, *x, column(done + 2 * twos.len()));
    }
}

/// `aᵀb`, in eight partial sums: faster, and with less rounding, than one.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    if a.len() < 8 {
        return a.iter().zip(b).map(|(a, b)| a * b).sum();
    }
    let mut sums = [0.0; 8];
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a
        .remainder()
        .iter()
        .zip(b.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in a.zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// `Σ a`, in eight partial sums as [`dot`].
pub fn sum(a: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let a = a.chunks_exact(8);
    let rest: f64 = a.remainder().iter().sum();
    for a in a {
        for lane in 0..8 {
            sums[lane] += a[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// `A += value · u wᵀ` from row and column `from` on.
pub fn add_outer(a: &mut Matrix, value: f64, u: &[f64], w: &[f64], from: usize) {
    for j in from..w.len() {
        if value != 0.0 && w[j] != 0.0 {
            for i in from..u.len() {
                a[(i, j)] += value * u[i] * w[j];
            }
        }
    }
}
