//! Linear stability: stiffness ratio, spectral abscissa, step limits of explicit methods.

use std::f64::consts::TAU;

use super::amplification::{EXPLICIT_METHODS, amplification_factor, stability_polynomial};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::Complex;
use crate::plan::linear_stability;
use crate::plan::modes_run;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::{MAX_DENSE_DOFS, ModesPlan};
use crate::scene::study::ModesStudy;

/// Linear stability of a machine with the contact states of its operating point.
pub struct LinearStability {
    /// Eigenvalues of all modes but the rigid ones, rad/s; of a conjugate pair that with the positive imaginary part.
    pub eigenvalues: Vec<Complex>,
    /// Ratio of the largest to the smallest |λ|.
    pub stiffness_ratio: f64,
    /// Largest real part, 1/s.
    pub spectral_abscissa: f64,
    /// Largest |λ|, rad/s.
    pub fastest: f64,
    /// Smallest |λ| above zero, rad/s; ∞ if there is none.
    pub slowest: f64,
    /// Explicit methods and their maximum stable step, s.
    pub max_steps: Vec<(&'static str, f64)>,
    /// Speed of the gyroscopic, centripetal and circulatory terms, rad/s; absent without such terms or without a speed.
    pub speed: Option<f64>,
    /// Diagnostics of unstable roots and omitted terms.
    pub diagnostics: Vec<Diagnostic>,
}

impl LinearStability {
    /// Maximum stable step of a method, s; absent if every step is stable.
    pub fn max_stable_step(&self, method: &str) -> Option<f64> {
        let mut limits = self.max_steps.iter();
        limits.find(|(name, _)| *name == method).map(|l| l.1)
    }

    /// Slowest period 2π/|λ|, s; one second if no mode oscillates or decays.
    pub fn slowest_period(&self) -> f64 {
        match self.slowest.is_finite() {
            true => TAU / self.slowest,
            false => 1.0,
        }
    }

    /// Default step, s: a twentieth of the slowest period.
    pub fn default_step(&self) -> f64 {
        const TWENTIETH: f64 = 0.05;
        TWENTIETH * TAU / self.slowest
    }
}

/// Refuses a machine too large for a full modal analysis.
///
/// # Errors
/// `BudgetExceeded`, with the number of coordinates and the limit.
pub fn check_study(machine: &PreparedMachine) -> Result<(), Error> {
    let n = machine.model.n;
    if n > MAX_DENSE_DOFS {
        let message = format!(
            "linear stability needs all modes; of {n} coordinates (limit {MAX_DENSE_DOFS}) only the lowest are computed"
        );
        let hint = "reduce the model (`modes --reduce` shows the error); `simulate --step` reports the longest stable step";
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(hint));
    }
    Ok(())
}

/// Computes the linear stability at a speed of the first node of `[speed]`, rad/s; by default the speed of the file.
///
/// # Errors
/// Errors of [`check_study`] and of complex modes.
pub fn linear_stability(
    prepared_machine: &PreparedMachine,
    speed: Option<f64>,
) -> Result<LinearStability, Error> {
    check_study(prepared_machine)?;
    let machine = &prepared_machine.machine;
    let stated = machine.speeds.first().map(|s| s.1);
    let study = ModesStudy {
        damped: true,
        // Without gyroscopic and rotating-frame terms the modes do not depend on the speed.
        speed: speed.or(stated).filter(|_| !machine.gyroscopic.is_empty()),
        ..ModesStudy::default()
    };
    let result = modes_run::run(
        prepared_machine,
        &study,
        &ModesPlan::plan_modes(prepared_machine, &study),
    )?;
    let eigenvalues: Vec<Complex> = result
        .modes
        .iter()
        .filter(|m| !m.rigid)
        .map(|m| m.eigenvalue)
        .collect();
    let moduli: Vec<f64> = eigenvalues
        .iter()
        .map(|z| z.norm())
        .filter(|x| *x > 0.0)
        .collect();
    let fastest = moduli.iter().copied().fold(0.0, f64::max);
    let slowest = moduli.iter().copied().fold(f64::INFINITY, f64::min);
    let real_parts = eigenvalues.iter().map(|z| z.re);
    let abscissa = real_parts.reduce(f64::max).unwrap_or(0.0);
    let limit = |name: &'static str| {
        Some((
            name,
            max_stable_step(&stability_polynomial(name)?, &eigenvalues, fastest),
        ))
    };
    let limits = EXPLICIT_METHODS.into_iter().filter_map(limit).collect();
    let codes = [linear_stability::UNSTABLE, linear_stability::LEFT_OUT];
    let mut diagnostics = result.diagnostics;
    diagnostics.retain(|w| codes.contains(&w.code));
    // Terms are omitted only if no speed is stated.
    for diagnostic in diagnostics
        .iter_mut()
        .filter(|w| w.code == linear_stability::LEFT_OUT)
    {
        diagnostic.hint =
            Some("state the speed in the model: [speed] with NODE = \"1000 rpm\"".to_string());
    }
    Ok(LinearStability {
        diagnostics,
        speed: study.speed,
        stiffness_ratio: fastest / slowest,
        spectral_abscissa: abscissa,
        fastest,
        slowest,
        max_steps: limits,
        eigenvalues,
    })
}

/// Tolerance of |R| above one, for undamped modes and methods without numerical damping.
const GROWTH_TOLERANCE: f64 = 1e-6;

/// Maximum step, s, at which no mode with a non-positive real part is amplified; ∞ if all eigenvalues are zero.
fn max_stable_step(coefficients: &[f64], eigenvalues: &[Complex], fastest: f64) -> f64 {
    if fastest == 0.0 {
        return f64::INFINITY;
    }
    let is_stable = |h: f64| {
        eigenvalues
            .iter()
            .filter(|z| z.re <= 0.0)
            .all(|z| amplification_factor(coefficients, *z * h) <= 1.0 + GROWTH_TOLERANCE)
    };
    // Stability regions are simply connected near the origin, so the first crossing is the limit.
    let mut low = 0.0;
    let mut high = 1e-3 / fastest;
    while is_stable(high) && high * fastest < 100.0 {
        low = high;
        high *= 1.02;
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if is_stable(middle) {
            low = middle
        } else {
            high = middle
        }
    }
    low
}
