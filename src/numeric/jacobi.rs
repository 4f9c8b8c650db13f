//! One-sided Jacobi: rotations `L V = U Σ` until all columns are orthogonal; Σ are then their lengths.
//!
//! Demmel & Veselić, Jacobi's method is more accurate than QR, SIAM J. Matrix Anal. Appl. 13 (1992), Algorithm 4.1;
//! pivoting of de Rijk, SIAM J. Sci. Stat. Comput. 10 (1989); applied to the rows of a triangular factor as by Drmač & Veselić,
//! New fast and accurate Jacobi SVD algorithm I, SIAM J. Matrix Anal. Appl. 29 (2008), pp. 1322–1342.

use crate::base::code::Code;
use crate::base::error::Error;

use super::pivoted_qr::{SAFE_SQUARES, dot, norm};

const MAX_SWEEPS: usize = 60; // 300 uniform discs take 11

/// Turns the columns until they are orthogonal; their lengths, and the sweeps it took.
pub(super) fn orthogonalise(columns: &mut [Vec<f64>]) -> Result<(Vec<f64>, usize), Error> {
    let orthogonal = (columns.first().map_or(0, Vec::len) as f64).sqrt() * f64::EPSILON; // LAPACK's dgesvj uses the same
    let mut lengths: Vec<f64> = columns.iter().map(|c| norm(c)).collect();
    let mut worst = 0.0;
    for sweep in 1..=MAX_SWEEPS {
        worst = 0.0;
        for p in 0..columns.len() {
            let longest = (p..columns.len())
                .reduce(|a, b| if lengths[b] > lengths[a] { b } else { a })
                .unwrap_or(p);
            columns.swap(p, longest);
            lengths.swap(p, longest);
            let (head, tail) = columns.split_at_mut(p + 1);
            for (q, y) in (p + 1..).zip(tail) {
                let x = &mut head[p];
                let cosine = cosine(x, y, lengths[p], lengths[q]);
                worst = cosine.abs().max(worst);
                if cosine.abs() > orthogonal {
                    rotate(x, y, rotation(lengths[p], lengths[q], cosine));
                    (lengths[p], lengths[q]) = (norm(x), norm(y));
                }
            }
        }
        if worst <= orthogonal {
            return Ok((lengths, sweep));
        }
    }
    let message = format!(
        "Jacobi rotations of {} columns did not converge: cosine {worst:.1e} after {MAX_SWEEPS} sweeps",
        columns.len()
    );
    Err(Error::new(Code::NoConvergence, message))
}

/// `xᵀ y / (‖x‖ ‖y‖)`; zero where a column is zero.
pub(super) fn cosine(x: &[f64], y: &[f64], x_length: f64, y_length: f64) -> f64 {
    let product = x_length * y_length;
    if SAFE_SQUARES.contains(&product) {
        return dot(x, y) / product;
    }
    if x_length == 0.0 || y_length == 0.0 {
        return 0.0;
    }
    x.iter()
        .zip(y)
        .map(|(x, y)| (x / x_length) * (y / y_length))
        .sum()
}

/// Cosine and sine of the smaller angle by which columns of these lengths become orthogonal: `ζ = (‖y‖² − ‖x‖²) / (2 xᵀy)`,
/// `t = ±1/(|ζ| + √(1 + ζ²))`.
pub(super) fn rotation(x_length: f64, y_length: f64, cosine: f64) -> (f64, f64) {
    let zeta = (y_length / x_length - x_length / y_length) / (2.0 * cosine);
    let t = 1.0_f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    (c, c * t)
}

/// `(c x − s y, s x + c y)` in place of x and y.
pub(super) fn rotate(x: &mut [f64], y: &mut [f64], (c, s): (f64, f64)) {
    for (x, y) in x.iter_mut().zip(y) {
        (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns (1, 0) and (1, h): σ₁σ₂ = h exactly, σ₁² + σ₂² = 2 + h².
    #[test]
    fn exact_nearly_parallel() {
        let h = 1e-12;
        let (lengths, _) = orthogonalise(&mut [vec![1.0, 0.0], vec![1.0, h]]).unwrap();
        assert!((lengths[0] - 2.0_f64.sqrt()).abs() < 1e-15);
        assert!(
            (lengths[1] / (h / 2.0_f64.sqrt()) - 1.0).abs() < 1e-3,
            "{lengths:?}"
        );
    }

    /// Columns whose lengths differ by 1e200 are turned without overflow.
    #[test]
    fn survives_lengths_far_apart() {
        let (lengths, _) = orthogonalise(&mut [vec![1e100, 1e100], vec![0.0, 1e-100]]).unwrap();
        assert!(
            (lengths[1] / (1e-100 / 2.0_f64.sqrt()) - 1.0).abs() < 1e-15,
            "{lengths:?}"
        );
    }

    #[test]
    fn survives_zero_columns() {
        assert_eq!(
            orthogonalise(&mut [vec![0.0], vec![2.0]]).unwrap().0,
            [2.0, 0.0]
        );
        assert_eq!(orthogonalise(&mut []).unwrap().1, 1);
    }
}
