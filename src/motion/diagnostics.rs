//! Diagnostics of failed integration runs: nearest switch, most frequent switch, fastest mode.

use std::f64::consts::TAU;

use super::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::{format_instant, format_number};
use crate::base::text::pluralise;

/// Adds to the hint of an error the branch nearest to switching at time t, s, and state y.
#[must_use]
pub fn with_nearest_switch(mut error: Error, model: &DynamicModel, t: f64, y: &[f64]) -> Error {
    if let Some(name) = nearest_to_switch(model, t, y) {
        let hint = error.hint.unwrap_or_default();
        error.hint = Some(format!(
            "{hint}; at the last sample, t = {}, branch {name} is nearest to switching",
            format_instant(t)
        ));
    }
    error
}

/// Branch nearest to switching, by the distance of a contact from the end of its play over half the play, and by the rate of a
/// friction pair over its regularisation velocity.
pub fn nearest_to_switch<'a>(model: &'a DynamicModel, t: f64, y: &[f64]) -> Option<&'a str> {
    let n = model.coordinate_count();
    let (q, v) = (&y[..n], &y[n..2 * n]);
    let distance = |b: &ForceElement| {
        let piece = b.pieces_at(t);
        let (delta, rate) = b.deflection(t, q, v, piece);
        match &b.law {
            ForceLaw::Contact(contact) if contact.can_open() => Some(
                (delta.abs() - contact.half_play).abs() / contact.half_play.max(f64::MIN_POSITIVE),
            ),
            ForceLaw::Friction(friction) | ForceLaw::Clutch { friction, .. } => {
                Some(rate.abs() / friction.regularisation_velocity)
            }
            ForceLaw::LoadFriction(load_friction) => {
                Some(rate.abs() / load_friction.friction.regularisation_velocity)
            }
            _ => None,
        }
    };
    model
        .elements
        .iter()
        .filter_map(|b| distance(b).map(|d| (d, b.name.as_str())))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// Adds to a budget error the branch that switched most; `switches` holds the number of switches of each branch.
#[must_use]
pub fn with_most_switched(mut error: Error, model: &DynamicModel, switches: &[u64]) -> Error {
    let peak = (0..switches.len()).max_by_key(|&b| switches[b]);
    if let Some(b) = peak.filter(|&b| switches[b] > 0 && error.code == Code::BudgetExceeded) {
        let count = pluralise(switches[b] as usize, "time");
        error.message += &format!("; `{}` switched most, {count}", model.elements[b].name);
    }
    error
}

/// Adds to the hint of a budget error the fastest mode, which limits the step size.
#[must_use]
pub fn with_fastest_mode(mut error: Error, model: &DynamicModel) -> Error {
    if let Some(mode) = fastest_mode(model).filter(|_| error.code == Code::BudgetExceeded) {
        let hint = error.hint.unwrap_or_default();
        error.hint = Some(format!("{hint}; {}", mode.describe()));
    }
    error
}

/// Estimate of the mode with the highest natural frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FastestMode<'a> {
    /// Lower bound of its natural frequency, rad/s.
    pub rate: f64,
    /// Branch with the largest share of its strain energy.
    pub branch: &'a str,
    /// Share of that branch in the strain energy, 0 to 1.
    pub share: f64,
}

impl FastestMode<'_> {
    /// Description for error messages.
    pub fn describe(&self) -> String {
        let FastestMode {
            rate,
            branch,
            share,
        } = self;
        let frequency = match rate / TAU {
            f if f >= 1e12 => format!("{} Hz", format_number(f)),
            f if f >= 1e6 => format!("{:.1} MHz", 1e-6 * f),
            f if f >= 1e3 => format!("{:.1} kHz", 1e-3 * f),
            f => format!("{f:.1} Hz"),
        };
        format!(
            "the fastest free oscillation, {frequency}, has {:.0} % of its energy in `{branch}`",
            100.0 * share
        )
    }
}

/// Iterations of the power method; Rayleigh's quotient rises monotonically and is within a few per cent earlier.
const POWER_ITERATIONS: usize = 40;

/// Fastest mode with the springs that always act; `None` without such a spring.
pub fn fastest_mode(model: &DynamicModel) -> Option<FastestMode<'_>> {
    highest_mode(model, model.elements.iter().filter_map(least_k).collect())
}

/// Fastest mode with every contact closed and every stiffness wave at its maximum; `None` without a spring.
pub fn fastest_mode_closed(model: &DynamicModel) -> Option<FastestMode<'_>> {
    highest_mode(model, model.elements.iter().filter_map(peak_k).collect())
}

/// Power method on M⁻¹K, started from the branch with the highest isolated frequency. Rayleigh's quotient is a lower bound of the
/// largest ω² (Courant and Fischer).
fn highest_mode<'a>(
    model: &'a DynamicModel,
    springs: Vec<(&'a ForceElement, f64)>,
) -> Option<FastestMode<'a>> {
    let unit_response = |b: &ForceElement| {
        let mut x = vec![0.0; model.coordinate_count()];
        b.direction.entries().for_each(|(i, a)| x[i] += a);
        model.apply_inverse_mass(&mut x);
        x
    };
    let omega_squared = |(b, k): &(&ForceElement, f64)| k * b.direction.dot(&unit_response(b));
    let first = springs
        .iter()
        .max_by(|a, b| omega_squared(a).total_cmp(&omega_squared(b)))?;
    let mut x = unit_response(first.0);
    let (mut square, mut energies) = (0.0, Vec::new());
    for _ in 0..POWER_ITERATIONS {
        let inertia: f64 = model.momentum(&x).iter().zip(&x).map(|(p, v)| p * v).sum();
        let norm = inertia.sqrt();
        if !(norm > 0.0 && norm.is_finite()) {
            return None;
        }
        x.iter_mut().for_each(|x| *x /= norm);
        let mut force = vec![0.0; model.coordinate_count()];
        energies.clear();
        for (b, k) in &springs {
            let delta = b.direction.dot(&x);
            energies.push(k * delta * delta);
            b.direction
                .entries()
                .for_each(|(i, a)| force[i] += a * k * delta);
        }
        square = energies.iter().sum();
        model.apply_inverse_mass(&mut force);
        x = force;
    }
    let dominant = (0..springs.len()).max_by(|&a, &b| energies[a].total_cmp(&energies[b]))?;
    (square > 0.0 && square.is_finite()).then(|| FastestMode {
        rate: square.sqrt(),
        branch: &springs[dominant].0.name,
        share: energies[dominant] / square,
    })
}

/// Smallest stiffness of a branch that always acts.
fn least_k(branch: &ForceElement) -> Option<(&ForceElement, f64)> {
    let k = match &branch.law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) if !contact.can_open() && !branch.follows_load() => {
            contact.stiffness
        }
        _ => return None,
    };
    let smallest_factor = branch
        .stiffness_wave
        .as_ref()
        .map_or(1.0, |w| w.waveform.lower_bound());
    let is_symmetric = branch.force_direction.is_none();
    (is_symmetric && k * smallest_factor > 0.0).then_some((branch, k * smallest_factor))
}

/// Largest stiffness of a branch.
fn peak_k(branch: &ForceElement) -> Option<(&ForceElement, f64)> {
    let k = match &branch.law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) => contact.stiffness,
        _ => return None,
    };
    let largest = k * branch.max_factor();
    (branch.force_direction.is_none() && largest > 0.0).then_some((branch, largest))
}

/// Upper bound of the rates of a model with every contact closed, rad/s: the root of the largest row sum of `M^-½ K M^-½`, which bounds
/// its largest eigenvalue (Gershgorin), plus that of its damping; `None` if a law has no bounded slope.
pub fn rate_bound(model: &DynamicModel) -> Option<f64> {
    let mut stiffness = vec![0.0; model.coordinate_count()];
    let mut damping = vec![0.0; model.coordinate_count()];
    let mut internal_rate = 0.0f64;
    for branch in &model.elements {
        let factor = branch.max_factor();
        let (k, c) = match &branch.law {
            ForceLaw::Linear { stiffness, damping } => (*stiffness, *damping),
            ForceLaw::Contact(contact) => (contact.stiffness, contact.damping),
            ForceLaw::Maxwell { stiffness, damping } => {
                internal_rate = internal_rate.max(stiffness / damping);
                (*stiffness, 0.0)
            }
            // A sticking pair is a constraint; a sliding pair adds only the slope of its law.
            ForceLaw::Friction(_) | ForceLaw::AngleLocked { .. } => (0.0, 0.0),
            ForceLaw::LaggedTorque { lag, .. } => {
                internal_rate = internal_rate.max(1.0 / lag);
                (0.0, 0.0)
            }
            _ => return None,
        };
        let root = |i: usize| model.mass.entry(i, i).sqrt();
        let sum: f64 = branch
            .direction
            .entries()
            .map(|(i, a)| a.abs() / root(i))
            .sum();
        for (i, a) in branch.direction.entries() {
            let share = a.abs() / root(i) * sum;
            stiffness[i] += (k * factor).abs() * share;
            damping[i] += (c * factor).abs() * share;
        }
    }
    let largest = |sums: &[f64]| sums.iter().copied().fold(0.0, f64::max);
    Some(largest(&stiffness).sqrt() + largest(&damping) + internal_rate)
}
