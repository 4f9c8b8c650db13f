//! One generalised-α step: Newton iteration, local error, dense output.

use std::borrow::Cow;

use super::system::ConstantPart;
use super::weights::GeneralizedAlpha;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::{format_instant, format_time};
use crate::motion::dynamic_model::Regime;
use crate::motion::error_scale::{ErrorScale, error_norm};
use crate::motion::problem::IntegrationStats;

/// Maximum number of Newton iterations; from the tenth on with half corrections, which end cycles about a corner.
const MAX_NEWTON: u32 = 60;

/// Weighted mean `weight · old + (1 − weight) · new`.
fn blend_states(old: &[f64], new: &[f64], weight: f64) -> Vec<f64> {
    let pairs = old.iter().zip(new);
    pairs
        .map(|(old, new)| weight * old + (1.0 - weight) * new)
        .collect()
}

/// State of the generalised-α method.
#[derive(Clone)]
pub struct AlphaState {
    /// Positions q.
    pub q: Vec<f64>,
    /// Velocities q̇.
    pub v: Vec<f64>,
    /// Acceleration-like variables a of the method.
    pub a: Vec<f64>,
}

/// Result of a step.
pub struct AlphaStep {
    /// State at the end of the step.
    pub end: AlphaState,
    /// Contact states frozen during the step; `None` if the weighted mean state determined them.
    pub frozen_regime: Option<Regime>,
}

impl AlphaState {
    /// Shifts a, which belongs to the instant `(α_m − α_f) h` after the state, to another step size: `longer` is the relative increase of h
    /// over the step in which a rose by `rise`. Without the shift a oscillates for some steps (Arnold and Brüls 2007).
    pub fn rescale_acceleration(&mut self, weights: &GeneralizedAlpha, longer: f64, rise: &[f64]) {
        let factor = (weights.alpha_m - weights.alpha_f) * longer;
        for (a, rise) in self.a.iter_mut().zip(rise) {
            *a += factor * rise;
        }
    }
}

impl GeneralizedAlpha {
    /// Weighted mean positions and velocities at which a step satisfies the equation of motion.
    fn mixed(&self, from: &AlphaState, to: &AlphaState) -> Vec<f64> {
        [
            blend_states(&from.q, &to.q, self.alpha_f),
            blend_states(&from.v, &to.v, self.alpha_f),
        ]
        .concat()
    }
}

/// Local errors of a step of length `h`, s, in positions and velocities. `last` is the length of the previous step with its rise of a; both
/// rises give ä. Without a previous step the estimate of h² ä is the rise of a, which is conservative for first steps.
pub fn local_errors(
    weights: &GeneralizedAlpha,
    [from, to]: [&AlphaState; 2],
    h: f64,
    last: Option<&(f64, Vec<f64>)>,
) -> Vec<f64> {
    let rise: Vec<f64> = to.a.iter().zip(&from.a).map(|(b, a)| b - a).collect();
    let velocity_rise = |i: usize| match last {
        Some((h_last, rise_last)) => {
            let ratio = h / h_last;
            2.0 * (rise[i] - ratio * rise_last[i]) / (1.0 + 1.0 / ratio)
        }
        None => rise[i],
    };
    let positions = rise.iter().map(|rise| weights.local_error() * h * h * rise);
    let speeds = (0..rise.len()).map(|i| weights.local_error_of_speed() * h * velocity_rise(i));
    positions.chain(speeds).collect()
}

/// Jump of a at the end of a step whose contact states differ from those at the weighted mean state, because the switch occurred after the
/// mean instant. Empty for a model without contacts.
pub fn switch_error(
    constant: &ConstantPart,
    [from, to]: [&AlphaState; 2],
    [begin, end]: [f64; 2],
    frozen: Option<&Regime>,
    stats: &mut IntegrationStats,
) -> Vec<f64> {
    let (model, w) = (constant.model, constant.weights);
    if constant.contacts.is_empty() {
        return Vec::new();
    }
    stats.evaluations += 1;
    let u = w.alpha_f * begin + (1.0 - w.alpha_f) * end;
    let mixed = || model.contact_regime(u, &w.mixed(from, to));
    let regime = frozen.map_or_else(|| Cow::Owned(mixed()), Cow::Borrowed);
    let y = [&to.q[..], &to.v[..]].concat();
    let mut jump = vec![0.0; model.coordinate_count()];
    for &b in &constant.contacts {
        let force = |states| model.element_force(b, states, end, &y, 0.0).0;
        let excess = force(None) - force(Some(&*regime));
        let acts = model.elements[b].force_direction();
        acts.entries().for_each(|(i, a)| jump[i] -= a * excess);
    }
    model.apply_inverse_mass(&mut jump);
    jump
}

/// Takes one step of length `h`, s, from `t`; `clock` maps the instant of evaluation.
pub fn step(
    constant: &mut ConstantPart,
    from: &AlphaState,
    t: f64,
    h: f64,
    clock: impl Fn(f64) -> f64,
    scale: &ErrorScale,
    stats: &mut IntegrationStats,
) -> Result<AlphaStep, Error> {
    let system = constant.system(h, stats)?;
    let (model, w) = (constant.model, constant.weights);
    let n = model.coordinate_count();
    let u = clock(t + (1.0 - w.alpha_f) * h);
    let start = [from.q.clone(), from.v.clone()].concat();
    let sizes = scale.sizes(&start, &start, h);
    let scales: Vec<f64> = (0..n)
        .map(|i| {
            sizes[i]
                .max(h * from.v[i].abs())
                .max(h * h * from.a[i].abs())
        })
        .collect();
    // Predictor with constant acceleration.
    let mut to = AlphaState {
        q: (0..n)
            .map(|i| from.q[i] + h * from.v[i] + 0.5 * h * h * from.a[i])
            .collect(),
        v: (0..n).map(|i| from.v[i] + h * from.a[i]).collect(),
        a: from.a.clone(),
    };
    let mut frozen: Option<Regime> = None;
    for iteration in 0..MAX_NEWTON {
        let y = w.mixed(from, &to);
        let a = blend_states(&from.a, &to.a, w.alpha_m);
        let forces = model.applied_forces(frozen.as_ref(), u, &y);
        stats.evaluations += 1;
        let accelerations: Vec<f64> = (0..n)
            .map(|i| a[i] + model.mass_damping * y[n + i])
            .collect();
        let mut change: Vec<f64> = model
            .momentum(&accelerations)
            .iter()
            .zip(&forces)
            .map(|(p, g)| g - p)
            .collect();
        let slopes: Vec<f64> = constant
            .varying
            .iter()
            .map(|&b| {
                let (_, k, c) = model.element_force(b, frozen.as_ref(), u, &y, 0.0);
                (1.0 - w.alpha_f) * (k + c * w.gamma / (w.beta * h))
            })
            .collect();
        constant.correct(&constant.systems[system], &slopes, &mut change)?;
        let relaxation = if iteration < 10 { 1.0 } else { 0.5 };
        for i in 0..n {
            let change = relaxation * change[i];
            to.q[i] += change;
            to.v[i] += w.gamma / (w.beta * h) * change;
            to.a[i] += change / (w.beta * h * h);
        }
        let size = error_norm(&change, &scales);
        if !size.is_finite() {
            break;
        }
        if size < 1e-13 || constant.varying.is_empty() {
            return Ok(AlphaStep {
                end: to,
                frozen_regime: frozen,
            });
        }
        // A contact with a force jump may have no solution at its switching surface: its state at the start is frozen.
        let only_contacts = || {
            let law = |&b: &usize| model.elements[b].law.is_dry_friction();
            !constant.varying.iter().any(law)
        };
        if iteration == MAX_NEWTON / 2 && only_contacts() {
            frozen = Some(model.regime(u, &start));
        }
    }
    let hint = match constant
        .varying
        .iter()
        .any(|&b| model.elements[b].law.is_dry_friction())
    {
        true => "request a shorter step, or widen the creep speed of dry friction",
        false => "request a shorter step",
    };
    let message = format!(
        "Newton's iteration of a step of {} at t = {} does not converge",
        format_time(h),
        format_instant(t)
    );
    Err(Error::new(Code::NoConvergence, message).with_hint(hint))
}

/// Dense output: cubic Hermite interpolation of positions and velocities at θ in [0, 1]. The difference of the mean velocity from the mean
/// of the end velocities is computed from a as `h (γ/2 − β) (a₀ − a₁)`, because a difference of positions is dominated by rounding in the
/// short steps before a switch.
pub fn interpolate(
    weights: &GeneralizedAlpha,
    [from, to]: [&AlphaState; 2],
    h: f64,
    theta: f64,
    y: &mut [f64],
) {
    let n = from.q.len();
    for i in 0..n {
        let (v, rise) = (from.v[i], to.v[i] - from.v[i]);
        let offset = h * (0.5 * weights.gamma - weights.beta) * (from.a[i] - to.a[i]);
        let bulge = theta * theta * (3.0 - 2.0 * theta) * offset;
        y[i] = from.q[i] + h * (theta * (v + 0.5 * theta * rise) + bulge);
        y[n + i] = v + theta * (rise + 6.0 * (1.0 - theta) * offset);
    }
}
