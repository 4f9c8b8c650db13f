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

/// Rounds of Newton's iteration; from the tenth on half steps, which end cycles about a corner.
const MAX_NEWTON: u32 = 60;

/// A share of the old and the rest of the new.
fn blend_states(old: &[f64], new: &[f64], share: f64) -> Vec<f64> {
    let pairs = old.iter().zip(new);
    pairs
        .map(|(old, new)| share * old + (1.0 - share) * new)
        .collect()
}

/// A state with its acceleration.
#[derive(Clone)]
pub struct AlphaState {
    /// q.
    pub q: Vec<f64>,
    /// q̇.
    pub v: Vec<f64>,
    /// The method's q̈.
    pub a: Vec<f64>,
}

/// Result of a step.
pub struct AlphaStep {
    /// At its end.
    pub end: AlphaState,
    /// Contact states frozen during the step; absent where the mixed state determined them.
    pub frozen_regime: Option<Regime>,
}

impl AlphaState {
    /// Rescales the method's a, which belongs to an instant `(α_m − α_f) h` after the state's, to another step, longer by a share of that
    /// in which a rose by so much. Left as it is, a rings by the difference for some steps (Arnold and Brüls 2007).
    pub fn rescale_acceleration(&mut self, weights: &GeneralizedAlpha, longer: f64, rise: &[f64]) {
        let share = (weights.alpha_m - weights.alpha_f) * longer;
        for (a, rise) in self.a.iter_mut().zip(rise) {
            *a += share * rise;
        }
    }
}

impl GeneralizedAlpha {
    /// Positions and speeds for which the equation of motion holds in a step.
    fn mixed(&self, from: &AlphaState, to: &AlphaState) -> Vec<f64> {
        [
            blend_states(&from.q, &to.q, self.alpha_f),
            blend_states(&from.v, &to.v, self.alpha_f),
        ]
        .concat()
    }
}

/// Local errors of a step of length `h` in positions and speeds. `last` is the step before it with the rise of a in it: both rises give
/// ä. Where there is none, h² ä is taken as large as the whole rise of a, so that first steps are short rather than unseen.
pub fn local_errors(
    weights: &GeneralizedAlpha,
    [from, to]: [&AlphaState; 2],
    h: f64,
    last: Option<&(f64, Vec<f64>)>,
) -> Vec<f64> {
    let rise: Vec<f64> = to.a.iter().zip(&from.a).map(|(b, a)| b - a).collect();
    let of_speed = |i: usize| match last {
        Some((before, rose)) => {
            let ratio = h / before;
            2.0 * (rise[i] - ratio * rose[i]) / (1.0 + 1.0 / ratio)
        }
        None => rise[i],
    };
    let positions = rise.iter().map(|rise| weights.local_error() * h * h * rise);
    let speeds = (0..rise.len()).map(|i| weights.local_error_of_speed() * h * of_speed(i));
    positions.chain(speeds).collect()
}

/// Jump of a at the end of a step because the contact states there differ from those of the step, which knows the mixed state alone: the
/// switch came too late for it. Empty where nothing does.
pub fn switch_error(
    constant: &ConstantPart,
    [from, to]: [&AlphaState; 2],
    [begin, end]: [f64; 2],
    held: Option<&Regime>,
    stats: &mut IntegrationStats,
) -> Vec<f64> {
    let (model, w) = (constant.model, constant.weights);
    if constant.contacts.is_empty() {
        return Vec::new();
    }
    stats.evaluations += 1;
    let u = w.alpha_f * begin + (1.0 - w.alpha_f) * end;
    let mixed = || model.contact_regime(u, &w.mixed(from, to));
    let stood = held.map_or_else(|| Cow::Owned(mixed()), Cow::Borrowed);
    let y = [&to.q[..], &to.v[..]].concat();
    let mut jump = vec![0.0; model.coordinate_count()];
    for &b in &constant.contacts {
        let force = |regime| model.element_force(b, regime, end, &y, 0.0).0;
        let more = force(None) - force(Some(&*stood));
        let acts = model.elements[b].force_direction();
        acts.entries().for_each(|(i, a)| jump[i] -= a * more);
    }
    model.apply_inverse_mass(&mut jump);
    jump
}

/// One step of length `h` from `t`.
pub fn step(
    constant: &mut ConstantPart,
    from: &AlphaState,
    t: f64,
    h: f64,
    clock: impl Fn(f64) -> f64,
    scale: &ErrorScale,
    stats: &mut IntegrationStats,
) -> Result<AlphaStep, Error> {
    let at = constant.system(h, stats)?;
    let (model, w) = (constant.model, constant.weights);
    let n = model.coordinate_count();
    let u = clock(t + (1.0 - w.alpha_f) * h);
    let start = [from.q.clone(), from.v.clone()].concat();
    let sizes = scale.sizes(&start, &start, h);
    let reach: Vec<f64> = (0..n)
        .map(|i| {
            sizes[i]
                .max(h * from.v[i].abs())
                .max(h * h * from.a[i].abs())
        })
        .collect();
    // Foot: acceleration carried on.
    let mut to = AlphaState {
        q: (0..n)
            .map(|i| from.q[i] + h * from.v[i] + 0.5 * h * h * from.a[i])
            .collect(),
        v: (0..n).map(|i| from.v[i] + h * from.a[i]).collect(),
        a: from.a.clone(),
    };
    let mut held: Option<Regime> = None;
    for round in 0..MAX_NEWTON {
        let y = w.mixed(from, &to);
        let a = blend_states(&from.a, &to.a, w.alpha_m);
        let pushed = model.applied_forces(held.as_ref(), u, &y);
        stats.evaluations += 1;
        let carried: Vec<f64> = (0..n)
            .map(|i| a[i] + model.mass_damping * y[n + i])
            .collect();
        let mut change: Vec<f64> = model
            .momentum(&carried)
            .iter()
            .zip(&pushed)
            .map(|(p, g)| g - p)
            .collect();
        let slopes: Vec<f64> = constant
            .varying
            .iter()
            .map(|&b| {
                let (_, k, c) = model.element_force(b, held.as_ref(), u, &y, 0.0);
                (1.0 - w.alpha_f) * (k + c * w.gamma / (w.beta * h))
            })
            .collect();
        constant.correct(&constant.systems[at], &slopes, &mut change)?;
        let share = if round < 10 { 1.0 } else { 0.5 };
        for i in 0..n {
            let change = share * change[i];
            to.q[i] += change;
            to.v[i] += w.gamma / (w.beta * h) * change;
            to.a[i] += change / (w.beta * h * h);
        }
        let size = error_norm(&change, &reach);
        if !size.is_finite() {
            break;
        }
        if size < 1e-13 || constant.varying.is_empty() {
            return Ok(AlphaStep {
                end: to,
                frozen_regime: held,
            });
        }
        // A contact whose force jumps may have no solution at its switching surface: it stands as it stood.
        let only_contacts = || {
            let law = |&b: &usize| model.elements[b].law.is_dry();
            !constant.varying.iter().any(law)
        };
        if round == MAX_NEWTON / 2 && only_contacts() {
            held = Some(model.regime(u, &start));
        }
    }
    let hint = match constant
        .varying
        .iter()
        .any(|&b| model.elements[b].law.is_dry())
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

/// The motion inside a step: the cubic through both ends' positions and speeds. How far the mean speed is from the mean of the speeds
/// comes from a, `h (γ/2 − β) (a₀ − a₁)` by the method's two lines: as a difference of positions it would drown in rounding where a
/// switch makes steps short.
pub fn interpolate(
    weights: &GeneralizedAlpha,
    [from, to]: [&AlphaState; 2],
    h: f64,
    theta: f64,
    y: &mut [f64],
) {
    let n = from.q.len();
    for i in 0..n {
        let (v, gain) = (from.v[i], to.v[i] - from.v[i]);
        let apart = h * (0.5 * weights.gamma - weights.beta) * (from.a[i] - to.a[i]);
        let bulge = theta * theta * (3.0 - 2.0 * theta) * apart;
        y[i] = from.q[i] + h * (theta * (v + 0.5 * theta * gain) + bulge);
        y[n + i] = v + theta * (gain + 6.0 * (1.0 - theta) * apart);
    }
}
