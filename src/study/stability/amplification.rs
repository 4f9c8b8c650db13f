//! What a step of a method makes of a mode.

use crate::base::error::Error;
use crate::motion::methods::alpha::{Alpha, RADIUS};
use crate::motion::methods::dop853_table::STAGES;
use crate::numeric::{Complex, Matrix, general};

/// Explicit methods whose steps have a limit.
pub const EXPLICIT: [&str; 3] = ["rk4", "dopri5", "dop853"];

/// The stability polynomial `R(z) = Σ c_k z^k` of an explicit method.
///
/// Sources: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, II.4 (Runge–Kutta of order 4)
/// and II.5, Table 5.2 (Dormand–Prince 5(4), seven stages, of which the seventh is the first of the next step); order 8 from
/// its table of stages.
pub fn polynomial(method: &str) -> Option<Vec<f64>> {
    match method {
        "rk4" => Some(vec![1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0]),
        "dopri5" => Some(vec![
            1.0,
            1.0,
            1.0 / 2.0,
            1.0 / 6.0,
            1.0 / 24.0,
            1.0 / 120.0,
            1.0 / 600.0,
        ]),
        "dop853" => Some(of_stages()),
        _ => None,
    }
}

/// `k_i = 1 + z Σ a_ij k_j` as polynomials; row 12 is the end of the step.
fn of_stages() -> Vec<f64> {
    const END: usize = 12;
    let mut stages: Vec<Vec<f64>> = Vec::new();
    for row in &STAGES[..=END] {
        let mut stage = vec![0.0; END + 1];
        stage[0] = 1.0;
        for &(j, a) in *row {
            for k in 0..END {
                stage[k + 1] += a * stages[j][k];
            }
        }
        stages.push(stage);
    }
    stages.swap_remove(END)
}

/// |R(z)| of a stability polynomial, or of any other, at z = hλ.
pub fn amplification(coefficients: &[f64], z: Complex) -> f64 {
    let value = coefficients
        .iter()
        .rev()
        .fold(Complex::ZERO, |sum, &c| sum * z + Complex::new(c, 0.0));
    value.norm()
}

/// Methods whose amplification is told.
pub const TOLD: [&str; 7] = [
    "rk4",
    "dopri5",
    "dop853",
    "radau5",
    "newmark",
    "hht",
    "generalized-alpha",
];

/// What a step of a method makes of the fastest and of the slowest mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Amplified {
    /// The method.
    pub method: &'static str,
    /// The factor on the fastest mode.
    pub fastest: f64,
    /// The factor on the slowest mode.
    pub slowest: f64,
    /// The damping ratio that the method adds to the slowest mode by itself; below zero where it takes some away.
    pub added_damping: f64,
}

/// What a step of `h` of each method makes of the fastest and the slowest of modes; none where there are no modes.
///
/// # Errors
/// `NoConvergence` where the eigenvalues of an amplification matrix are not found.
pub fn amplified(eigenvalues: &[Complex], h: f64) -> Result<Vec<Amplified>, Error> {
    let by_size = |a: &&Complex, b: &&Complex| a.norm().total_cmp(&b.norm());
    let moving = || eigenvalues.iter().filter(|z| z.norm() > 0.0);
    let (Some(&fastest), Some(&slowest)) = (moving().max_by(by_size), moving().min_by(by_size))
    else {
        return Ok(Vec::new());
    };
    let of = |method: &'static str| {
        let slow = growth(method, slowest, h)?;
        Ok(Amplified {
            method,
            fastest: growth(method, fastest, h)?,
            slowest: slow,
            added_damping: (slowest.re * h - slow.ln()) / (slowest.norm() * h),
        })
    };
    TOLD.into_iter().map(of).collect()
}

/// The factor by which a step of `h` of a method multiplies a mode λ: |R(hλ)|, or the spectral radius of the amplification matrix.
///
/// # Errors
/// `NoConvergence` where the eigenvalues of that matrix are not found.
pub fn growth(method: &str, lambda: Complex, h: f64) -> Result<f64, Error> {
    match method {
        "radau5" => Ok(radau(lambda * h)),
        "newmark" => of_alpha(&Alpha::newmark(), lambda, h),
        "hht" => of_alpha(&Alpha::hht(RADIUS), lambda, h),
        "generalized-alpha" => of_alpha(&Alpha::generalized(RADIUS), lambda, h),
        _ => Ok(polynomial(method).map_or(f64::NAN, |c| amplification(&c, lambda * h))),
    }
}

/// |R(z)| of Radau IIA of order 5, `R = (1 + 2z/5 + z²/20)/(1 − 3z/5 + 3z²/20 − z³/60)`.
///
/// Source: Hairer and Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, IV.3, Table 3.1 (Padé's, 2 over 3).
fn radau(z: Complex) -> f64 {
    let above = amplification(&[1.0, 2.0 / 5.0, 1.0 / 20.0], z);
    above / amplification(&[1.0, -3.0 / 5.0, 3.0 / 20.0, -1.0 / 60.0], z)
}

/// The spectral radius of a step of the generalised α family on a mode, in `x, h v, h² a`; on a real root in `v, h a`.
///
/// Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371, equations 3 to 10.
fn of_alpha(w: &Alpha, lambda: Complex, h: f64) -> Result<f64, Error> {
    let (m, f) = (1.0 - w.inertia, 1.0 - w.force);
    let matrix = if lambda.im == 0.0 {
        let c = -lambda.re * h;
        let below = m + c * f * w.gamma;
        let a = [-c / below, -(w.inertia + c * f * (1.0 - w.gamma)) / below];
        let v = [1.0 + w.gamma * a[0], 1.0 - w.gamma + w.gamma * a[1]];
        Matrix::from_fn(2, 2, |i, j| [v, a][i][j])
    } else {
        let (c, k) = (-2.0 * lambda.re * h, lambda.norm_sqr() * h * h);
        let below = m + c * f * w.gamma + k * f * w.beta;
        let a = [
            -k / below,
            -(c + k * f) / below,
            -(w.inertia + c * f * (1.0 - w.gamma) + k * f * (0.5 - w.beta)) / below,
        ];
        let x = [
            1.0 + w.beta * a[0],
            1.0 + w.beta * a[1],
            0.5 - w.beta + w.beta * a[2],
        ];
        let v = [
            w.gamma * a[0],
            1.0 + w.gamma * a[1],
            1.0 - w.gamma + w.gamma * a[2],
        ];
        Matrix::from_fn(3, 3, |i, j| [x, v, a][i][j])
    };
    let roots = general::eigenvalues(&matrix)?;
    Ok(roots.iter().map(|z| z.norm()).fold(0.0, f64::max))
}
