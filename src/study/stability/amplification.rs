//! Amplification factor of each integration method as a function of hλ.

use std::f64::consts::TAU;

use crate::base::error::Error;
use crate::motion::methods::alpha::weights::{GeneralizedAlpha, SPECTRAL_RADIUS};
use crate::motion::methods::dop853_table::STAGES;
use crate::numeric::{Complex, Matrix, eigen};

/// Explicit methods, whose step has a stability limit.
pub const EXPLICIT_METHODS: [&str; 3] = ["rk4", "dopri5", "dop853"];

/// Stability polynomial `R(z) = Σ c_k z^k` of an explicit method: its coefficients `c_k`.
///
/// Sources: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, II.4 (Runge–Kutta of order 4)
/// and II.5, Table 5.2 (Dormand–Prince 5(4), seven stages, of which the seventh is the first of the next step); order 8 from
/// its Butcher tableau.
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
        "dop853" => Some(polynomial_from_stages()),
        _ => None,
    }
}

/// Stability polynomial from the stages `k_i = 1 + z Σ a_ij k_j`; row 12 is the end of the step.
fn polynomial_from_stages() -> Vec<f64> {
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

/// Modulus of a polynomial at z = hλ; of a stability polynomial the amplification factor |R(z)|.
pub fn amplification_factor(coefficients: &[f64], z: Complex) -> f64 {
    value(coefficients, z).norm()
}

/// Polynomial `Σ c_k z^k`.
fn value(c: &[f64], z: Complex) -> Complex {
    let terms = c.iter().rev();
    terms.fold(Complex::ZERO, |sum, &c| sum * z + Complex::new(c, 0.0))
}

/// Derivative `Σ k c_k z^(k−1)`.
fn slope(c: &[f64], z: Complex) -> Complex {
    let terms = c.iter().enumerate().skip(1).rev();
    terms.fold(Complex::ZERO, |sum, (k, &c)| {
        sum * z + Complex::new(k as f64 * c, 0.0)
    })
}

/// Numerator P and denominator Q of the stability function `R = P/Q` of a method.
fn stability_function(method: &str) -> Option<(Vec<f64>, Vec<f64>)> {
    match method {
        "radau5" => Some((RADAU.0.to_vec(), RADAU.1.to_vec())),
        _ => Some((stability_polynomial(method)?, vec![1.0])),
    }
}

/// Boundary |R| = 1 of the stability region from the origin upwards, traced by the argument of R; empty without a stability function.
pub fn stability_boundary(method: &str) -> Vec<Complex> {
    let Some((numerator, denominator)) = stability_function(method) else {
        return Vec::new();
    };
    const STEPS: usize = 400;
    const MAX_ITERATIONS: usize = 20;
    let degree = numerator.len().max(denominator.len()) - 1;
    let mut z = Complex::ZERO;
    let mut boundary = vec![z];
    for k in 1..=STEPS * degree {
        let angle = TAU * k as f64 / STEPS as f64;
        let target = Complex::new(angle.cos(), angle.sin());
        for _ in 0..MAX_ITERATIONS {
            let (p, q) = (value(&numerator, z), value(&denominator, z));
            let dr_dz = (slope(&numerator, z) * q - p * slope(&denominator, z)) / (q * q);
            let step = (p / q - target) / dr_dz;
            z -= step;
            if step.norm() < 1e-12 {
                break;
            }
        }
        boundary.push(z);
        if z.im < -0.05 {
            break;
        }
    }
    boundary
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
    /// Method name.
    pub method: &'static str,
    /// Factor of the fastest mode.
    pub fastest: f64,
    /// Factor of the slowest mode.
    pub slowest: f64,
    /// Numerical damping ratio of the slowest mode; negative if the method removes damping.
    pub added_damping: f64,
}

/// Amplification factors per step of `h`, s, for the fastest and the slowest eigenvalue, rad/s, by method; empty without modes.
///
/// # Errors
/// `NoConvergence` where the eigenvalues of an amplification matrix are not found.
pub fn amplification_factors(
    eigenvalues: &[Complex],
    h: f64,
) -> Result<Vec<AmplificationFactors>, Error> {
    let by_size = |a: &&Complex, b: &&Complex| a.norm().total_cmp(&b.norm());
    let nonzero = || eigenvalues.iter().filter(|z| z.norm() > 0.0);
    let (Some(&fastest), Some(&slowest)) = (nonzero().max_by(by_size), nonzero().min_by(by_size))
    else {
        return Ok(Vec::new());
    };
    let factors = |method: &'static str| {
        let slowest_factor = step_amplification(method, slowest, h)?;
        Ok(AmplificationFactors {
            method,
            fastest: step_amplification(method, fastest, h)?,
            slowest: slowest_factor,
            added_damping: (slowest.re * h - slowest_factor.ln()) / (slowest.norm() * h),
        })
    };
    METHODS.into_iter().map(factors).collect()
}

/// Amplification factors of each method per step, over |hλ|.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplificationChart {
    /// Step size, s.
    pub step: f64,
    /// Curve of each method.
    pub methods: Vec<AmplificationCurve>,
}

/// Amplification factor of a method per step, over |hλ|.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplificationCurve {
    /// Method name.
    pub method: &'static str,
    /// True if the step has a stability limit.
    pub conditionally_stable: bool,
    /// |hλ| and factor of undamped modes.
    pub undamped: Vec<(f64, f64)>,
    /// |hλ| and factor of each nonzero eigenvalue.
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
        let row = |method: &'static str| {
            let point = |z: Complex| Ok((z.norm(), step_amplification(method, z, 1.0)?));
            let undamped = (0..=POINTS).map(|k| point(Complex::new(0.0, size(k))));
            let nonzero = eigenvalues.iter().filter(|z| z.norm() > 0.0);
            let points = nonzero.map(|z| point(*z * step));
            Ok(AmplificationCurve {
                method,
                conditionally_stable: EXPLICIT_METHODS.contains(&method),
                undamped: undamped.collect::<Result<_, Error>>()?,
                eigenvalues: points.collect::<Result<_, Error>>()?,
            })
        };
        let methods = METHODS.into_iter().map(row).collect::<Result<_, Error>>()?;
        Ok(AmplificationChart { step, methods })
    }

    /// Methods that are stable at any step for modes that do not grow.
    pub fn unconditionally_stable(&self) -> impl Iterator<Item = &'static str> {
        let stable = self.methods.iter().filter(|m| !m.conditionally_stable);
        stable.map(|m| m.method)
    }

    /// Smallest and largest |hλ| of the chart, in powers of ten.
    pub fn decade_range(&self) -> (f64, f64) {
        let curve = self.methods.first().map_or(&[][..], |m| &m.undamped);
        range(curve.iter().map(|p| p.0))
    }
}

/// Range of sizes in powers of ten, at least from a tenth to ten.
fn range(sizes: impl Iterator<Item = f64>) -> (f64, f64) {
    sizes.fold((-1.0, 1.0), |(low, high), x| {
        (low.min(x.log10()), high.max(x.log10()))
    })
}

/// Amplification factor per step of `h`, s, of a mode λ, rad/s: |R(hλ)|, or the spectral radius of the amplification matrix.
///
/// # Errors
/// `NoConvergence` if the eigenvalues of that matrix are not found.
pub fn step_amplification(method: &str, lambda: Complex, h: f64) -> Result<f64, Error> {
    match method {
        "newmark" => alpha_amplification(&GeneralizedAlpha::newmark(), lambda, h),
        "hht" => alpha_amplification(&GeneralizedAlpha::hht(SPECTRAL_RADIUS), lambda, h),
        "generalized-alpha" => {
            alpha_amplification(&GeneralizedAlpha::generalized(SPECTRAL_RADIUS), lambda, h)
        }
        _ => Ok(stability_function(method).map_or(f64::NAN, |(p, q)| {
            amplification_factor(&p, lambda * h) / amplification_factor(&q, lambda * h)
        })),
    }
}

/// Numerator and denominator of the stability function of Radau IIA of order 5, `R = (1 + 2z/5 + z²/20)/(1 − 3z/5 + 3z²/20 − z³/60)`.
///
/// Source: Hairer and Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, IV.3, Table 3.1 (Padé approximation of degrees 2 over 3).
const RADAU: ([f64; 3], [f64; 4]) = (
    [1.0, 2.0 / 5.0, 1.0 / 20.0],
    [1.0, -3.0 / 5.0, 3.0 / 20.0, -1.0 / 60.0],
);

/// Spectral radius of the amplification matrix of the generalised-α family for a mode, in `x, h v, h² a`; on a real root in `v, h a`.
///
/// Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371, equations 3 to 10.
fn alpha_amplification(w: &GeneralizedAlpha, lambda: Complex, h: f64) -> Result<f64, Error> {
    let (m, f) = (1.0 - w.alpha_m, 1.0 - w.alpha_f);
    let matrix = if lambda.im == 0.0 {
        let c = -lambda.re * h;
        let m_eff = m + c * f * w.gamma;
        let a = [-c / m_eff, -(w.alpha_m + c * f * (1.0 - w.gamma)) / m_eff];
        let v = [1.0 + w.gamma * a[0], 1.0 - w.gamma + w.gamma * a[1]];
        Matrix::from_fn(2, 2, |i, j| [v, a][i][j])
    } else {
        let (c, k) = (-2.0 * lambda.re * h, lambda.norm_sqr() * h * h);
        let m_eff = m + c * f * w.gamma + k * f * w.beta;
        let a = [
            -k / m_eff,
            -(c + k * f) / m_eff,
            -(w.alpha_m + c * f * (1.0 - w.gamma) + k * f * (0.5 - w.beta)) / m_eff,
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
