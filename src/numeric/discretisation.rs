//! Discretisation of `ẋ = A x + B u`: zero- and first-order hold, bilinear, impulse-invariant.
//!
//! Zero- and first-order hold by one exponential: Van Loan, IEEE Trans. Automat. Control 23 (1978), pp. 395–404; Franklin,
//! Powell & Workman, Digital Control of Dynamic Systems, 3rd ed. (1998), pp. 204–206, for the ramp. Bilinear: `s = (2/h) (z − 1)/(z + 1)`.

use super::expm::expm;
use super::{Matrix, symmetric};
use crate::base::error::Error;

/// `exp [A B; 0 0] h = [A_d B_d; 0 1]`: inputs that are constant between samples; returns A, B, C, D.
///
/// # Errors
/// `Overflow` where the exponential keeps no digit.
pub fn zero_order([a, b, c, d]: [&Matrix; 4], h: f64) -> Result<[Matrix; 4], Error> {
    let (n, m) = (a.nrows(), b.ncols());
    let exponential = expm(&augmented(a, b, h, n + m))?;
    Ok([
        part(&exponential, 0, n, n),
        part(&exponential, n, n, m),
        c.clone(),
        d.clone(),
    ])
}

/// `exp [A B 0; 0 0 1/h; 0 0 0] h = [Φ Γ₁ Γ₂; …]`: `ξ = x − Γ₂ u` is the state, `B_d = Γ₁ − Γ₂ + Φ Γ₂`, `D_d = D + C Γ₂`.
///
/// # Errors
/// Those of [`zero_order`].
pub fn first_order([a, b, c, d]: [&Matrix; 4], h: f64) -> Result<[Matrix; 4], Error> {
    let (n, m) = (a.nrows(), b.ncols());
    let mut exponent = augmented(a, b, h, n + 2 * m);
    (0..m).for_each(|j| exponent[(n + j, n + m + j)] = 1.0);
    let exponential = expm(&exponent)?;
    let phi = part(&exponential, 0, n, n);
    let (gamma1, gamma2) = (part(&exponential, n, n, m), part(&exponential, n + m, n, m));
    let through = d + c * &gamma2;
    let b = &gamma1 - &gamma2 + &phi * &gamma2;
    Ok([phi, b, c.clone(), through])
}

/// `A_d = (1 − A h/2)⁻¹ (1 + A h/2)`, `B_d = (1 − A h/2)⁻¹ B h`, `C_d = C (1 − A h/2)⁻¹`, `D_d = D + ½ C B_d`.
///
/// A step `(2/ω) tan(ω h/2)` in place of h makes the response exact at ω (prewarping).
///
/// # Errors
/// `Indefinite` where 2/h is a pole.
pub fn bilinear([a, b, c, d]: [&Matrix; 4], h: f64) -> Result<[Matrix; 4], Error> {
    let n = a.nrows();
    let step = |sign: f64| {
        Matrix::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) + sign * 0.5 * h * a[(i, j)]
        })
    };
    let back = step(-1.0);
    let a = symmetric::lu_solve(&back, &step(1.0))?;
    let b = symmetric::lu_solve(&back, &Matrix::from_fn(n, b.ncols(), |i, j| h * b[(i, j)]))?;
    let through = c * &b;
    let c = symmetric::lu_solve(&back.transpose().to_owned(), &c.transpose().to_owned())?
        .transpose()
        .to_owned();
    let d = Matrix::from_fn(d.nrows(), d.ncols(), |i, j| {
        d[(i, j)] + 0.5 * through[(i, j)]
    });
    Ok([a, b, c, d])
}

/// `A_d = exp A h`, `B_d = h A_d B`, `D_d = h C B`: the response to a unit sample is h times the impulse response at `k h`.
///
/// A direct term, whose impulse response is no function of time, is left out: the caller refuses it.
///
/// # Errors
/// Those of [`zero_order`].
pub fn impulse_invariant([a, b, c]: [&Matrix; 3], h: f64) -> Result<[Matrix; 4], Error> {
    let exponential = expm(&Matrix::from_fn(a.nrows(), a.nrows(), |i, j| h * a[(i, j)]))?;
    let scaled = Matrix::from_fn(b.nrows(), b.ncols(), |i, j| h * b[(i, j)]);
    let (input, through) = (&exponential * &scaled, c * &scaled);
    Ok([exponential, input, c.clone(), through])
}

/// `[A B; 0 0] h` with room.
fn augmented(a: &Matrix, b: &Matrix, h: f64, size: usize) -> Matrix {
    let (n, m) = (a.nrows(), b.ncols());
    Matrix::from_fn(size, size, |i, j| match (i < n, j < n, j < n + m) {
        (true, true, _) => h * a[(i, j)],
        (true, false, true) => h * b[(i, j - n)],
        _ => 0.0,
    })
}

/// The first `rows` rows of `columns` columns from `from` on.
fn part(a: &Matrix, from: usize, rows: usize, columns: usize) -> Matrix {
    Matrix::from_fn(rows, columns, |i, j| a[(i, from + j)])
}
