//! Diagnostics of failed runs: nearest switch, most frequent switch, fastest mode.

use std::f64::consts::TAU;

use super::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::{format_instant, format_number};
use crate::base::text::pluralise;

/// The error, with the branch nearest to a switch named in its hint.
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

/// The branch nearest to a switch: a contact by its distance from the edge over its play, a friction pair by its rate over
/// its creep speed.
pub fn nearest_to_switch<'t>(model: &'t DynamicModel, t: f64, y: &[f64]) -> Option<&'t str> {
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
            ForceLaw::LoadFriction(pressed) => {
                Some(rate.abs() / pressed.friction.regularisation_velocity)
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

/// Adds to a budget error the branch that switched most: `switches` of each.
#[must_use]
pub fn with_most_switched(mut error: Error, model: &DynamicModel, switches: &[u64]) -> Error {
    let most = (0..switches.len()).max_by_key(|&at| switches[at]);
    if let Some(at) = most.filter(|&at| switches[at] > 0 && error.code == Code::BudgetExceeded) {
        let times = pluralise(switches[at] as usize, "time");
        error.message += &format!("; `{}` switched most, {times}", model.elements[at].name);
    }
    error
}

/// Adds to a budget error the fastest free motion: where steps follow it, it sets the cost.
#[must_use]
pub fn with_fastest_mode(mut error: Error, model: &DynamicModel) -> Error {
    if let Some(found) = fastest_mode(model).filter(|_| error.code == Code::BudgetExceeded) {
        let hint = error.hint.unwrap_or_default();
        error.hint = Some(format!("{hint}; {}", found.describe()));
    }
    error
}

/// The fastest free motion of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FastestMode<'t> {
    /// At least so fast, rad/s.
    pub rate: f64,
    /// The branch that holds the largest share of its strain energy.
    pub branch: &'t str,
    /// That share.
    pub share: f64,
}

impl FastestMode<'_> {
    /// In words.
    pub fn describe(&self) -> String {
        let FastestMode {
            rate,
            branch,
            share,
        } = self;
        let told = match rate / TAU {
            f if f >= 1e12 => format!("{} Hz", format_number(f)),
            f if f >= 1e6 => format!("{:.1} MHz", 1e-6 * f),
            f if f >= 1e3 => format!("{:.1} kHz", 1e-3 * f),
            f => format!("{f:.1} Hz"),
        };
        format!(
            "the fastest free motion, {told}, is that of `{branch}` ({:.0} % of its energy)",
            100.0 * share
        )
    }
}

/// Rounds of the power method; the value never falls, and has settled to a few per cent long before.
const POWER_ITERATIONS: usize = 40;

/// The fastest free motion over the springs that always act. Absent where none does.
pub fn fastest_mode(model: &DynamicModel) -> Option<FastestMode<'_>> {
    fastest_of(model, model.elements.iter().filter_map(spring).collect())
}

/// The fastest free motion while every contact carries and every stiffness wave is at its crest. Absent where there is no spring.
pub fn fastest_mode_closed(model: &DynamicModel) -> Option<FastestMode<'_>> {
    fastest_of(model, model.elements.iter().filter_map(closed).collect())
}

/// By the power method on M⁻¹K from the branch that would be fastest by itself; Rayleigh's quotient is no larger than the largest ω²
/// (Courant and Fischer).
fn fastest_of<'t>(
    model: &'t DynamicModel,
    springs: Vec<(&'t ForceElement, f64)>,
) -> Option<FastestMode<'t>> {
    let along = |b: &ForceElement| {
        let mut x = vec![0.0; model.coordinate_count()];
        b.direction.entries().for_each(|(i, a)| x[i] += a);
        model.apply_inverse_mass(&mut x);
        x
    };
    let alone = |(b, k): &(&ForceElement, f64)| k * b.direction.dot(&along(b));
    let first = springs
        .iter()
        .max_by(|a, b| alone(a).total_cmp(&alone(b)))?;
    let mut x = along(first.0);
    let (mut square, mut energies) = (0.0, Vec::new());
    for _ in 0..POWER_ITERATIONS {
        let inertia: f64 = model.momentum(&x).iter().zip(&x).map(|(p, v)| p * v).sum();
        let size = inertia.sqrt();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        x.iter_mut().for_each(|x| *x /= size);
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
    let at = (0..springs.len()).max_by(|&a, &b| energies[a].total_cmp(&energies[b]))?;
    (square > 0.0 && square.is_finite()).then(|| FastestMode {
        rate: square.sqrt(),
        branch: &springs[at].0.name,
        share: energies[at] / square,
    })
}

/// The least stiffness of a branch that always acts.
fn spring(branch: &ForceElement) -> Option<(&ForceElement, f64)> {
    let k = match &branch.law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) if !contact.can_open() && !branch.follows_load() => {
            contact.stiffness
        }
        _ => return None,
    };
    let least = branch
        .stiffness_wave
        .as_ref()
        .map_or(1.0, |w| w.waveform.lower_bound());
    let same = branch.force_direction.is_none();
    (same && k * least > 0.0).then_some((branch, k * least))
}

/// The greatest stiffness of a branch.
fn closed(branch: &ForceElement) -> Option<(&ForceElement, f64)> {
    let k = match &branch.law {
        ForceLaw::Linear { stiffness, .. } => *stiffness,
        ForceLaw::Contact(contact) => contact.stiffness,
        _ => return None,
    };
    let greatest = k * branch.max_factor();
    (branch.force_direction.is_none() && greatest > 0.0).then_some((branch, greatest))
}

/// Bound of the rates of a model, rad/s, every contact closed: the roots of the largest row sums of `M^-½ K M^-½`, which bound its largest
/// eigenvalue (Gershgorin), and those of its damping; absent where a law has no greatest slope.
pub fn rate_bound(model: &DynamicModel) -> Option<f64> {
    let mut stiffness = vec![0.0; model.coordinate_count()];
    let mut damping = vec![0.0; model.coordinate_count()];
    let mut inner = 0.0f64;
    for branch in &model.elements {
        let factor = branch.max_factor();
        let (k, c) = match &branch.law {
            ForceLaw::Linear { stiffness, damping } => (*stiffness, *damping),
            ForceLaw::Contact(contact) => (contact.stiffness, contact.damping),
            ForceLaw::Maxwell { stiffness, damping } => {
                inner = inner.max(stiffness / damping);
                (*stiffness, 0.0)
            }
            // What sticks is held, and what slides has the slope of its law alone.
            ForceLaw::Friction(_) | ForceLaw::AngleLocked { .. } => (0.0, 0.0),
            ForceLaw::LaggedTorque { lag, .. } => {
                inner = inner.max(1.0 / lag);
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
    let largest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    Some(largest(&stiffness).sqrt() + largest(&damping) + inner)
}
