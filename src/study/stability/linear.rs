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

/// The linear facts of a machine with its contacts as the operating point has them.
pub struct LinearStability {
    /// Every eigenvalue with a frequency or a decay, rad/s; of a conjugate pair the upper one.
    pub eigenvalues: Vec<Complex>,
    /// Largest over smallest |λ|.
    pub stiffness_ratio: f64,
    /// The largest real part, 1/s.
    pub spectral_abscissa: f64,
    /// The largest |λ|, rad/s.
    pub fastest: f64,
    /// The smallest, rad/s.
    pub slowest: f64,
    /// Explicit methods and the longest step with which no mode grows that should not, s.
    pub max_steps: Vec<(&'static str, f64)>,
    /// The speed whose gyroscopic, centripetal and circulatory terms are counted, rad/s; absent where there are none, or no speed.
    pub speed: Option<f64>,
    /// Roots that grow, terms that were left out.
    pub diagnostics: Vec<Diagnostic>,
}

impl LinearStability {
    /// The longest step of a method, s; absent where any is stable.
    pub fn max_stable_step(&self, method: &str) -> Option<f64> {
        let mut limits = self.max_steps.iter();
        limits.find(|(name, _)| *name == method).map(|l| l.1)
    }

    /// Slowest period: 2π over the slowest |λ|, s; a second where nothing oscillates or decays.
    pub fn slowest_period(&self) -> f64 {
        match self.slowest.is_finite() {
            true => TAU / self.slowest,
            false => 1.0,
        }
    }

    /// A twentieth of the slowest period, s: a step that shows it well.
    pub fn default_step(&self) -> f64 {
        const TWENTIETH: f64 = 0.05;
        TWENTIETH * TAU / self.slowest
    }
}

/// Refuses a machine whose modes would not all be found.
///
/// # Errors
/// `BudgetExceeded`, with the number of coordinates and the limit.
pub fn refuse(machine: &PreparedMachine) -> Result<(), Error> {
    let n = machine.model.n;
    if n > MAX_DENSE_DOFS {
        let message = format!(
            "the linear facts need all modes, the fastest among them, and of {n} coordinates, more than {MAX_DENSE_DOFS}, only the lowest are found"
        );
        let hint = "reduce the model (`modes --reduce` shows what that costs); `simulate --step` reports the longest stable step";
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(hint));
    }
    Ok(())
}

/// Finds the linear facts, at a speed of the first node of `[speed]`, rad/s, by default at that of the file.
///
/// # Errors
/// Those of [`refuse`]; those of complex modes.
pub fn linear_stability(
    prepared_machine: &PreparedMachine,
    speed: Option<f64>,
) -> Result<LinearStability, Error> {
    refuse(prepared_machine)?;
    let machine = &prepared_machine.machine;
    let stated = machine.speeds.first().map(|s| s.1);
    let study = ModesStudy {
        damped: true,
        // Where nothing tilts or stands in a frame that turns, the modes are those at rest.
        speed: speed.or(stated).filter(|_| !machine.gyroscopic.is_empty()),
        ..ModesStudy::default()
    };
    let answer = modes_run::run(
        prepared_machine,
        &study,
        &ModesPlan::plan_modes(prepared_machine, &study),
    )?;
    let eigenvalues: Vec<Complex> = answer
        .modes
        .iter()
        .filter(|m| !m.rigid)
        .map(|m| m.eigenvalue)
        .collect();
    let sizes: Vec<f64> = eigenvalues
        .iter()
        .map(|z| z.norm())
        .filter(|x| *x > 0.0)
        .collect();
    let fastest = sizes.iter().copied().fold(0.0, f64::max);
    let slowest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    let real = eigenvalues.iter().map(|z| z.re);
    let abscissa = real.reduce(f64::max).unwrap_or(0.0);
    let of = |name: &'static str| {
        Some((
            name,
            max_stable_step(&stability_polynomial(name)?, &eigenvalues, fastest),
        ))
    };
    let limits = EXPLICIT_METHODS.into_iter().filter_map(of).collect();
    let own = [linear_stability::UNSTABLE, linear_stability::LEFT_OUT];
    let mut diagnostics = answer.diagnostics;
    diagnostics.retain(|w| own.contains(&w.code));
    // Only a machine without a stated speed is taken at rest.
    for left_out in diagnostics
        .iter_mut()
        .filter(|w| w.code == linear_stability::LEFT_OUT)
    {
        left_out.hint =
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

/// Growth of a step that counts as none: undamped modes of a method that neither gains nor loses end within it.
const GROWTH_TOLERANCE: f64 = 1e-6;

/// The longest step with which no mode that does not grow by itself is amplified; ∞ where nothing is fast.
fn max_stable_step(coefficients: &[f64], eigenvalues: &[Complex], fastest: f64) -> f64 {
    if fastest == 0.0 {
        return f64::INFINITY;
    }
    let stays = |h: f64| {
        eigenvalues
            .iter()
            .filter(|z| z.re <= 0.0)
            .all(|z| amplification_factor(coefficients, *z * h) <= 1.0 + GROWTH_TOLERANCE)
    };
    // Regions are simply connected near the origin: the first crossing counts.
    let mut low = 0.0;
    let mut high = 1e-3 / fastest;
    while stays(high) && high * fastest < 100.0 {
        low = high;
        high *= 1.02;
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if stays(middle) {
            low = middle
        } else {
            high = middle
        }
    }
    low
}
