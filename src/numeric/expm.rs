//! Matrix exponential `eᴬ` by scaling, a Padé approximant of degree 7 to 13, and squaring.
//!
//! Higham, The scaling and squaring method for the matrix exponential revisited, SIAM J. Matrix Anal. Appl. 26 (2005),
//! pp. 1179–1193, Algorithm 2.3 with the bounds of Table 2.3. The matrix is first balanced by powers of two, since position and
//! velocity of a stiff machine differ in scale: fewer squarings, smaller rounding errors (ibid., step 1; Parlett & Reinsch 1969).

use super::balance::balance;
use super::symmetric::lu_solve;
use super::{Matrix, check_finite};
use crate::base::code::Code;
use crate::base::error::Error;

/// Exponential `eᴬ` of a square matrix.
///
/// # Errors
/// `Overflow` if an entry of A or of the result is not finite.
pub fn expm(a: &Matrix) -> Result<Matrix, Error> {
    check_finite(a, "the exponent of a matrix exponential")?;
    if a.nrows() == 0 {
        return Ok(a.clone());
    }
    let (balanced, scale) = balance(a, |sum, x| sum + x.abs());
    let scaled = scaled_exponential(&balanced)?;
    let n = a.nrows();
    let result = Matrix::from_fn(n, n, |i, j| scaled[(i, j)] * (scale[i] / scale[j]));
    check_finite(&result, "a matrix exponential")?;
    Ok(result)
}

/// Norms up to which degrees 7 and 9 are exact to rounding, with their coefficients. Degrees 3 and 5 are exact relative to the norm,
/// but entries far below the norm, between distant masses, then have only 8 digits (`tests/machine/state_space.rs`).
const THETA_7_9: [(f64, &[f64]); 2] = [
    (
        9.504178996162932e-1,
        &[
            17297280.0, 8648640.0, 1995840.0, 277200.0, 25200.0, 1512.0, 56.0, 1.0,
        ],
    ),
    (
        2.097847961257068,
        &[
            17643225600.0,
            8821612800.0,
            2075673600.0,
            302702400.0,
            30270240.0,
            2162160.0,
            110880.0,
            3960.0,
            90.0,
            1.0,
        ],
    ),
];

/// Norm up to which degree 13 is exact to rounding; its coefficients follow.
const THETA_13: f64 = 5.371920351148152;
const PADE_13: [f64; 14] = [
    64764752532480000.0,
    32382376266240000.0,
    7771770303897600.0,
    1187353796428800.0,
    129060195264000.0,
    10559470521600.0,
    670442572800.0,
    33522128640.0,
    1323241920.0,
    40840800.0,
    960960.0,
    16380.0,
    182.0,
    1.0,
];

/// Maximum number of squarings; with more (a radius above 1e18) no digit is accurate.
const MAX_SQUARINGS: i32 = 60;

fn scaled_exponential(a: &Matrix) -> Result<Matrix, Error> {
    let norm = one_norm(a);
    for (bound, b) in THETA_7_9 {
        if norm <= bound {
            return pade(a, b);
        }
    }
    let squarings = if norm < 1e36 {
        n_squarings(a, norm)
    } else {
        i32::MAX
    };
    if squarings > MAX_SQUARINGS {
        let message = format!(
            "the exponential of a matrix of norm {norm:.1e} has no significant digit: the time step is too long"
        );
        return Err(Error::new(Code::Overflow, message)
            .with_hint("choose a shorter sample time, or remove the fastest states"));
    }
    let factor = (-f64::from(squarings)).exp2();
    let reduced = Matrix::from_fn(a.nrows(), a.nrows(), |i, j| a[(i, j)] * factor);
    let mut x = pade(&reduced, &PADE_13)?;
    for _ in 0..squarings {
        x = &x * &x;
    }
    Ok(x)
}

/// Number of squarings from roots of the norms of powers, which for a nearly triangular matrix are far below the norm, and from the
/// rounding error of `|A|²⁷` (Al-Mohy & Higham, SIAM J. Matrix Anal. Appl. 31 (2009), pp. 970–989, Algorithm 5.1).
fn n_squarings(a: &Matrix, norm: f64) -> i32 {
    let a2 = a * a;
    let (a4, a6) = (&a2 * &a2, &a2 * &a2 * &a2);
    let a8 = &a4 * &a4;
    let root = |m: &Matrix, power: f64| one_norm(m).powf(1.0 / power);
    let (r4, r6, r8) = (root(&a4, 4.0), root(&a6, 6.0), root(&a8, 8.0));
    let radius = r4.max(r6).min(r6.max(r8));
    let by_norm = (radius / THETA_13).log2().ceil().max(0.0);
    // ‖|A|²⁷‖₁ of the scaled A, by 27 products with a vector.
    let n = a.nrows();
    let factor = (-by_norm).exp2();
    let mut sums = vec![1.0; n];
    for _ in 0..27 {
        sums = (0..n)
            .map(|j| (0..n).map(|i| sums[i] * a[(i, j)].abs() * factor).sum())
            .collect();
    }
    let rounding = sums.iter().fold(0.0, |m: f64, &x| m.max(x)) / (norm * factor) / ROUNDING_27;
    let extra = ((rounding / (f64::EPSILON / 2.0)).log2() / 26.0)
        .ceil()
        .max(0.0);
    (by_norm + extra) as i32
}

/// Inverse of the first neglected coefficient of degree 13.
const ROUNDING_27: f64 = 113250775606021113483283660800000000.0;

/// Padé approximant `q(A)⁻¹ p(A)` with `p = V + U`, `q = V − U`, where U holds the odd and V the even powers.
fn pade(a: &Matrix, b: &[f64]) -> Result<Matrix, Error> {
    let n = a.nrows();
    let identity = Matrix::identity(n, n);
    let a2 = a * a;
    let scale = |c: f64, m: &Matrix| Matrix::from_fn(n, n, |i, j| c * m[(i, j)]);
    let (odd, even) = if b.len() == PADE_13.len() {
        let a4 = &a2 * &a2;
        let a6 = &a2 * &a4;
        let sum3 = |c: [f64; 3]| scale(c[0], &a6) + scale(c[1], &a4) + scale(c[2], &a2);
        let odd =
            &a6 * sum3([b[13], b[11], b[9]]) + sum3([b[7], b[5], b[3]]) + scale(b[1], &identity);
        let even =
            &a6 * sum3([b[12], b[10], b[8]]) + sum3([b[6], b[4], b[2]]) + scale(b[0], &identity);
        (odd, even)
    } else {
        let (mut odd, mut even) = (scale(b[1], &identity), scale(b[0], &identity));
        let mut power = identity;
        for k in 1..b.len() / 2 {
            power = &power * &a2;
            odd += scale(b[2 * k + 1], &power);
            even += scale(b[2 * k], &power);
        }
        (odd, even)
    };
    let u = a * odd;
    lu_solve(&(&even - &u), &(&even + &u))
}

fn one_norm(a: &Matrix) -> f64 {
    (0..a.ncols())
        .map(|j| (0..a.nrows()).map(|i| a[(i, j)].abs()).sum())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> Matrix {
        Matrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    }

    fn assert_near(result: &Matrix, exact: &Matrix, relative: f64) {
        let error = (result - exact).norm_max() / exact.norm_max();
        assert!(error <= relative, "{error:.1e}\n{result:?}\n{exact:?}");
    }

    /// Moler & Van Loan, Nineteen dubious ways, SIAM Review 45 (2003), pp. 3–49, method 1: Taylor's series fails on it, e^A = X e^Λ X⁻¹.
    #[test]
    fn ref_moler_van_loan() {
        let (fast, slow) = ((-17.0f64).exp(), (-1.0f64).exp());
        let result = expm(&matrix(&[&[-49.0, 24.0], &[-64.0, 31.0]])).unwrap();
        // Λ = −1, −17 with vectors (1, 2), (3, 4): e^A = [−2s + 3f, 3/2 (s − f); −4 (s − f), 3s − 2f].
        let exact = Matrix::from_fn(2, 2, |i, j| match (i, j) {
            (0, 0) => 3.0 * fast - 2.0 * slow,
            (0, 1) => 1.5 * (slow - fast),
            (1, 0) => -4.0 * (slow - fast),
            _ => 3.0 * slow - 2.0 * fast,
        });
        assert_near(&result, &exact, 1e-14);
    }

    /// Rotations by angles that use every degree of the approximant and the squarings.
    #[test]
    fn exact_turns() {
        for angle in [1e-9, 0.01, 0.2, 0.9, 2.0, 5.0, 50.0, 1e4] {
            let result = expm(&matrix(&[&[0.0, -angle], &[angle, 0.0]])).unwrap();
            let (s, c) = f64::sin_cos(angle);
            assert_near(
                &result,
                &matrix(&[&[c, -s], &[s, c]]),
                f64::EPSILON * (8.0 + 8.0 * angle),
            );
        }
    }

    /// Nilpotent exponent, whose series is finite.
    #[test]
    fn exact_nilpotent() {
        let result = expm(&matrix(&[
            &[0.0, 1e6, 0.0],
            &[0.0, 0.0, 1e6],
            &[0.0, 0.0, 0.0],
        ]))
        .unwrap();
        assert_near(
            &result,
            &matrix(&[&[1.0, 1e6, 5e11], &[0.0, 1.0, 1e6], &[0.0, 0.0, 1.0]]),
            1e-15,
        );
    }

    /// Oscillator of 1e6 rad/s over one radian: ‖A h‖ = 1e6, balanced 1; without balancing six digits are lost.
    #[test]
    fn exact_stiff_oscillator() {
        let (omega, h) = (1e6, 1e-6);
        let result = expm(&matrix(&[&[0.0, h], &[-omega * omega * h, 0.0]])).unwrap();
        let (s, c) = 1f64.sin_cos();
        for (entry, exact) in [
            ((0, 0), c),
            ((0, 1), s / omega),
            ((1, 0), -s * omega),
            ((1, 1), c),
        ] {
            assert!(
                (result[entry] / exact - 1.0).abs() < 1e-14,
                "{entry:?}: {} {exact}",
                result[entry]
            );
        }
    }

    /// Inverse: `eᴬ e⁻ᴬ = 1`.
    #[test]
    fn law_inverse() {
        let a = Matrix::from_fn(7, 7, |i, j| {
            ((5 * i + 3 * j * j + i * i * j) % 13) as f64 / 13.0 - 0.5
        });
        let negative = Matrix::from_fn(7, 7, |i, j| -a[(i, j)]);
        assert_near(
            &(expm(&a).unwrap() * expm(&negative).unwrap()),
            &Matrix::identity(7, 7),
            1e-14,
        );
    }

    #[test]
    fn survives_nothing_at_all() {
        assert_eq!(expm(&Matrix::zeros(0, 0)).unwrap().nrows(), 0);
    }

    #[test]
    fn refuses_what_is_not_finite_or_hopeless() {
        assert_eq!(
            expm(&matrix(&[&[f64::NAN]])).unwrap_err().code,
            Code::Overflow
        );
        assert_eq!(expm(&matrix(&[&[1e30]])).unwrap_err().code, Code::Overflow);
    }
}
