//! Modes of undamped gyroscopic systems: `λ² I + λ G + K`, G skew, K symmetric.
//!
//! With `K = L Lᵀ` the state `(Lᵀη, η̇)` has a skew matrix (Meirovitch, AIAA J. 12 (1974), 1337–1342), so that −i times it is
//! Hermitian: every λ is on the imaginary axis exactly, and repeated ones have as many shapes as they should.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Complex, ComplexMatrix, Matrix, symmetric};

/// A frequency and its shape over the modal coordinates.
pub struct GyroscopicMode {
    /// λ = iω, rad/s.
    pub omega: f64,
    /// η.
    pub shape: Vec<Complex>,
}

/// The roots above zero, ascending, and the absolute error of each ω; nothing where K is not positive definite.
///
/// `held` are the coordinates K holds, `moving` those that take part; roots of zero are left out.
///
/// # Errors
/// No convergence; numbers out of range.
pub fn gyroscopic_modes(
    g: &Matrix,
    k: &Matrix,
    held: &[usize],
    moving: &[usize],
) -> Result<Option<(Vec<GyroscopicMode>, f64)>, Error> {
    let (np, nr) = (held.len(), moving.len());
    let n = np + nr;
    let block = Matrix::from_fn(np, np, |i, j| {
        (k[(held[i], held[j])] + k[(held[j], held[i])]) / 2.0
    });
    let Ok(root) = symmetric::cholesky(&block) else {
        return Ok(None);
    };
    let place: Vec<Option<usize>> = moving
        .iter()
        .map(|j| held.iter().position(|i| i == j))
        .collect();
    let mut h = ComplexMatrix::zeros(n, n);
    let mut size = 0.0f64;
    // −i [[0, Lᵀ], [−L, −G]]; the lower triangle.
    for r in 0..nr {
        for p in (0..np).filter(|&p| place[r].is_some_and(|q| p <= q)) {
            let l = place[r].map_or(0.0, |q| root[(q, p)]);
            h[(np + r, p)] = Complex::new(0.0, l);
            size += 2.0 * l * l;
        }
        for s in 0..r {
            let entry = g[(moving[r], moving[s])];
            h[(np + r, np + s)] = Complex::new(0.0, entry);
            size += 2.0 * entry * entry;
        }
    }
    let error = f64::EPSILON * size.sqrt();
    let (values, vectors) = symmetric::hermitian_eigen(&h)?;
    let nonzero = values
        .iter()
        .filter(|&&value| value > n as f64 * error)
        .count();
    if nonzero < np {
        let message = format!(
            "{} of {np} frequencies are below the rounding error of the highest",
            np - nonzero
        );
        return Err(Error::new(Code::Overflow, message).with_hint("check the size of speeds"));
    }
    let swings = (0..n)
        .filter(|&column| values[column] > n as f64 * error)
        .map(|column| {
            let omega = values[column];
            let mut shape = vec![Complex::ZERO; k.nrows()];
            moving.iter().enumerate().for_each(|(r, &j)| {
                shape[j] = vectors[(np + r, column)] / Complex::new(0.0, omega)
            });
            GyroscopicMode { omega, shape }
        });
    Ok(Some((swings.collect(), error)))
}
