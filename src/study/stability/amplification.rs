//! Amplification factor of each integration method as a function of hλ.

use std::f64::consts::TAU;

use crate::base::error::Error;
use crate::motion::methods::alpha::weights::{GeneralizedAlpha, SPECTRAL_RADIUS};
use crate::motion::methods::dop853_table::STAGES;
use crate::numeric::{Complex, Matrix, eigen};

/// Explicit methods whose steps have a limit.
pub const EXPLICIT_METHODS: [&str; 3] = ["rk4", "dopri5", "dop853"];

/// The stability polynomial `R(z) = Σ c_k z^k` of an explicit method.
///
/// Sources: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, II.4 (Runge–Kutta of order 4)
/// and II.5, Table 5.2 (Dormand–Prince 5(4), seven stages, of which the seventh is the first of the next step); order 8 from
/// its table of stages.
pub fn stability_polynomial(method: &str) -> Option<Vec<f64>> {
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
        "dop853" => Some(polynomial_of_stages()),
        _ => None,
    }
}

/// `k_i = 1 + z Σ a_ij k_j` as polynomials; row 12 is the end of the step.
fn polynomial_of_stages() -> Vec<f64> {
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
pub fn amplification_factor(coefficients: &[f64], z: Complex) -> f64 {
    value(coefficients, z).norm()
}

/// `Σ c_k z^k`.
fn value(c: &[f64], z: Complex) -> Complex {
    let terms = c.iter().rev();
    terms.fold(Complex::ZERO, |sum, &c| sum * z + Complex::new(c, 0.0))
}

/// `Σ k c_k z^(k−1)`.
fn slope(c: &[f64], z: Complex) -> Complex {
    let terms = c.iter().enumerate().skip(1).rev();
    terms.fold(Complex::ZERO, |sum, (k, &c)| {
        sum * z + Complex::new(k as f64 * c, 0.0)
    })
}

/// P and Q of the rational function `R = P/Q` of a method of which a step makes R(hλ) of a mode.
fn stability_function(method: &str) -> Option<(Vec<f64>, Vec<f64>)> {
    match method {
        "radau5" => Some((RADAU.0.to_vec(), RADAU.1.to_vec())),
        _ => Some((stability_polynomial(method)?, vec![1.0])),
    }
}

/// The curve |R| = 1 from the origin upwards, followed as R turns round the circle; nothing for methods that are no function of hλ.
pub fn stability_boundary(method: &str) -> Vec<Complex> {
    let Some((above, below)) = stability_function(method) else {
        return Vec::new();
    };
    const STEPS: usize = 400;
    const MAX_ITERATIONS: usize = 20;
    let degree = above.len().max(below.len()) - 1;
    let mut z = Complex::ZERO;
    let mut all = vec![z];
    for k in 1..=STEPS * degree {
        let angle = TAU * k as f64 / STEPS as f64;
        let wanted = Complex::new(angle.cos(), angle.sin());
        for _ in 0..MAX_ITERATIONS {
            let (p, q) = (value(&above, z), value(&below, z));
            let turns = (slope(&above, z) * q - p * slope(&below, z)) / (q * q);
            let move_by = (p / q - wanted) / turns;
            z -= move_by;
            if move_by.norm() < 1e-12 {
                break;
            }
        }
        all.push(z);
        if z.im < -0.05 {
            break;
        }
    }
    all
}

/// Methods with an amplification factor.
pub const METHODS: [&str; 7] = [
    "rk4",
    "dopri5",
    "dop853",
    "radau5",
    "newmark",
    "hht",
    "generalized-alpha",
];

/// Amplification factors per step of a method for the fastest and the slowest mode.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplificationFactors {
    /// The method.
    pub method: &'static str,
    /// The factor on the fastest mode.
    pub fastest: f64,
    /// The factor on the slowest mode.
    pub slowest: f64,
    /// The damping ratio that the method adds to the slowest mode by itself; below zero where it takes some away.
    pub added_damping: f64,
}

/// Amplification factors per step of `h` of each method for the fastest and the slowest of modes; none where there are no modes.
///
/// # Errors
/// `NoConvergence` where the eigenvalues of an amplification matrix are not found.
pub fn amplification_factors(
    eigenvalues: &[Complex],
    h: f64,
) -> Result<Vec<AmplificationFactors>, Error> {
    let by_size = |a: &&Complex, b: &&Complex| a.norm().total_cmp(&b.norm());
    let moving = || eigenvalues.iter().filter(|z| z.norm() > 0.0);
    let (Some(&fastest), Some(&slowest)) = (moving().max_by(by_size), moving().min_by(by_size))
    else {
        return Ok(Vec::new());
    };
    let of = |method: &'static str| {
        let slow = step_amplification(method, slowest, h)?;
        Ok(AmplificationFactors {
            method,
            fastest: step_amplification(method, fastest, h)?,
            slowest: slow,
            added_damping: (slowest.re * h - slow.ln()) / (slowest.norm() * h),
        })
    };
    METHODS.into_iter().map(of).collect()
}

/// Amplification factors of each method per step, over the size of hλ.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplificationChart {
    /// The step, s.
    pub step: f64,
    /// Curves of all methods.
    pub methods: Vec<AmplificationCurve>,
}

/// Amplification factors of a method per step.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplificationCurve {
    /// The method.
    pub method: &'static str,
    /// True for a method with a stability limit of the step.
    pub conditionally_stable: bool,
    /// |hλ| and the factor on modes without damping.
    pub undamped: Vec<(f64, f64)>,
    /// The same of each eigenvalue.
    pub eigenvalues: Vec<(f64, f64)>,
}

impl AmplificationChart {
    /// Amplification factors of each method at the eigenvalues, rad/s, in a step, s.
    ///
    /// # Errors
    /// `NoConvergence` where the eigenvalues of an amplification matrix are not found.
    pub fn new(eigenvalues: &[Complex], step: f64) -> Result<AmplificationChart, Error> {
        const POINTS: i32 = 300;
        let sizes = eigenvalues.iter().map(|z| z.norm() * step);
        let (low, high) = range(sizes.filter(|x| *x > 0.0));
        let size = |k: i32| 10f64.powf(low + (high - low) * f64::from(k) / f64::from(POINTS));
        let of = |method: &'static str| {
            let at = |z: Complex| Ok((z.norm(), step_amplification(method, z, 1.0)?));
            let line = (0..=POINTS).map(|k| at(Complex::new(0.0, size(k))));
            let moving = eigenvalues.iter().filter(|z| z.norm() > 0.0);
            let marks = moving.map(|z| at(*z * step));
            Ok(AmplificationCurve {
                method,
                conditionally_stable: EXPLICIT_METHODS.contains(&method),
                undamped: line.collect::<Result<_, Error>>()?,
                eigenvalues: marks.collect::<Result<_, Error>>()?,
            })
        };
        let methods = METHODS.into_iter().map(of).collect::<Result<_, Error>>()?;
        Ok(AmplificationChart { step, methods })
    }

    /// Methods of which no step is too long for a mode that does not grow by itself.
    pub fn unconditionally_stable(&self) -> impl Iterator<Item = &'static str> {
        let free = self.methods.iter().filter(|m| !m.conditionally_stable);
        free.map(|m| m.method)
    }

    /// The smallest and the largest |hλ| looked at, in powers of ten.
    pub fn decade_range(&self) -> (f64, f64) {
        let line = self.methods.first().map_or(&[][..], |m| &m.undamped);
        range(line.iter().map(|p| p.0))
    }
}

/// The range of sizes in powers of ten, at least from a tenth to ten.
fn range(sizes: impl Iterator<Item = f64>) -> (f64, f64) {
    sizes.fold((-1.0, 1.0), |(low, high), x| {
        (low.min(x.log10()), high.max(x.log10()))
    })
}

/// The factor by which a step of `h` of a method multiplies a mode λ: |R(hλ)|, or the spectral radius of the amplification matrix.
///
/// # Errors
/// `NoConvergence` where the eigenvalues of that matrix are not found.
pub fn step_amplification(method: &str, lambda: Complex, h: f64) -> Result<f64, Error> {
    match method {
        "newmark" => alpha_amplification(&GeneralizedAlpha::newmark(), lambda, h),
        "hht" => alpha_amplification(&GeneralizedAlpha::hht(SPECTRAL_RADIUS), lambda, h),
        "generalized-alpha" => {
            alpha_amplification(&GeneralizedAlpha::generalized(SPECTRAL_RADIUS), lambda, h)
        }
        _ => Ok(
            stability_function(method).map_or(f64::NAN, |(above, below)| {
                amplification_factor(&above, lambda * h) / amplification_factor(&below, lambda * h)
            }),
        ),
    }
}

/// P and Q of Radau IIA of order 5, `R = (1 + 2z/5 + z²/20)/(1 − 3z/5 + 3z²/20 − z³/60)`.
///
/// Source: Hairer and Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, IV.3, Table 3.1 (Padé's, 2 over 3).
const RADAU: ([f64; 3], [f64; 4]) = (
    [1.0, 2.0 / 5.0, 1.0 / 20.0],
    [1.0, -3.0 / 5.0, 3.0 / 20.0, -1.0 / 60.0],
);

/// The spectral radius of a step of the generalised α family on a mode, in `x, h v, h² a`; on a real root in `v, h a`.
///
/// Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371, equations 3 to 10.
fn alpha_amplification(w: &GeneralizedAlpha, lambda: Complex, h: f64) -> Result<f64, Error> {
    let (m, f) = (1.0 - w.alpha_m, 1.0 - w.alpha_f);
    let matrix = if lambda.im == 0.0 {
        let c = -lambda.re * h;
        let below = m + c * f * w.gamma;
        let a = [-c / below, -(w.alpha_m + c * f * (1.0 - w.gamma)) / below];
        let v = [1.0 + w.gamma * a[0], 1.0 - w.gamma + w.gamma * a[1]];
        Matrix::from_fn(2, 2, |i, j| [v, a][i][j])
    } else {
        let (c, k) = (-2.0 * lambda.re * h, lambda.norm_sqr() * h * h);
        let below = m + c * f * w.gamma + k * f * w.beta;
        let a = [
            -k / below,
            -(c + k * f) / below,
            -(w.alpha_m + c * f * (1.0 - w.gamma) + k * f * (0.5 - w.beta)) / below,
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
    let roots = eigen::eigenvalues(&matrix)?;
    Ok(roots.iter().map(|z| z.norm()).fold(0.0, f64::max))
}
