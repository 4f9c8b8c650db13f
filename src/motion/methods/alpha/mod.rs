//! Newmark, HHT and generalised-α methods: implicit, order 2, one factorisation per step size.
//!
//! `q₁ = q₀ + h v₀ + h² ((½ − β) a₀ + β a₁)`, `v₁ = v₀ + h ((1 − γ) a₀ + γ a₁)`, and the equation of motion holds for
//! `(1 − α_f) x₁ + α_f x₀` with the acceleration `(1 − α_m) a₁ + α_m a₀`.
//!
//! Sources: Newmark 1959; Hilber, Hughes and Taylor 1977; Chung and Hulbert 1993, equations 3 to 8 and 17, 25.

pub mod weights;

mod system;

mod step;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::motion::algebraic;
use crate::motion::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::motion::error_scale::{ErrorScale, error_norm};
use crate::motion::problem::{
    DenseOutput, IntegrationOptions, IntegrationStats, OdeProblem, SampleSink, StepSize,
};
use crate::motion::progress::{
    SampleEmitter, check_budget, check_options, clamp_time, next_discontinuity_within,
};
use step::{AlphaState, AlphaStep, interpolate, local_errors, step, switch_error};
use system::ConstantPart;
use weights::{GeneralizedAlpha, SPECTRAL_RADIUS};

/// Newmark's method of average acceleration.
///
/// # Errors
/// Those of [`run`].
pub fn newmark(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    run(&GeneralizedAlpha::newmark(), model, options, sink)
}

/// HHT-α method of Hilber, Hughes and Taylor with ρ∞ = 0.8 (α = −1/9).
///
/// # Errors
/// Those of [`run`].
pub fn hht(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    run(
        &GeneralizedAlpha::hht(SPECTRAL_RADIUS),
        model,
        options,
        sink,
    )
}

/// Generalised-α method of Chung and Hulbert with ρ∞ = 0.8.
///
/// # Errors
/// Those of [`run`].
pub fn generalized(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    run(
        &GeneralizedAlpha::generalized(SPECTRAL_RADIUS),
        model,
        options,
        sink,
    )
}

/// Reason why the method family does not support a model; `None` if it does.
pub fn unsupported_reason(model: &DynamicModel) -> Option<String> {
    let is_load_friction = |b: &&ForceElement| matches!(b.law, ForceLaw::LoadFriction(_));
    if let Some(b) = model.elements.iter().find(is_load_friction) {
        return Some(format!(
            "the friction of {} depends on the force of another branch, and this method solves each branch alone",
            b.name
        ));
    }
    if let Some(reason) = algebraic::inertia_requirement(model) {
        return Some(reason);
    }
    (model.internal_count() > 0).then(|| {
        "a branch has an inner state (a delayed torque, a spring and a damper in series), which is not of second order"
            .to_string()
    })
}

/// Binary logarithm of the number of parts of an interval under error control. Steps are powers of two of a part; the shortest step,
/// needed at a jump of the force, is near rounding.
const MAX_HALVINGS: u32 = 50;

/// Number of parts of an interval under error control.
const PARTS: u64 = 1 << MAX_HALVINGS;

/// Integrates a machine, with a fixed step or with error control of positions and velocities. Contact states follow from the state
/// in each step, and dry friction is regularised.
///
/// # Errors
/// `NoConvergence` of Newton's iteration, `BudgetExceeded`, and invalid options.
pub fn run(
    weights: &GeneralizedAlpha,
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    if let Some(reason) = unsupported_reason(model) {
        return Err(Error::new(Code::Usage, reason).with_hint("take radau5"));
    }
    let n = model.coordinate_count();
    let mut stats = IntegrationStats::default();
    let mut samples = SampleEmitter::new(options, sink);
    let mut constant = ConstantPart::new(weights, model);
    let mut scale = ErrorScale::for_model(model, options);
    scale.update(&options.initial_state);
    let mut y = options.initial_state.clone();
    samples.emit_until(options.from, &mut y, None, |_, _| ())?;
    let mut count = PARTS >> 10;
    let mut from = options.from;
    while samples.due().is_some() && from < options.to {
        let to = next_discontinuity_within(|t| model.next_discontinuity(t), from, options.to);
        let clock = |t: f64| clamp_time(t, from, to);
        let mut slope = vec![0.0; model.len()];
        model.derivative(clock(from), &y, &mut slope);
        let mut state = AlphaState {
            q: y[..n].to_vec(),
            v: y[n..2 * n].to_vec(),
            a: slope[n..2 * n].to_vec(),
        };
        let parts = match options.step_size {
            StepSize::Fixed(h) => ((to - from) / h - 1e-6).ceil().max(1.0) as u64,
            StepSize::Adaptive(_) => PARTS,
        };
        let part = (to - from) / parts as f64;
        let mut n_done = 0;
        let mut previous: Option<(f64, Vec<f64>)> = None;
        // Step size that the algorithmic acceleration refers to.
        let mut h_of_a = 0.0;
        while n_done < parts && samples.due().is_some() {
            let t = from + part * n_done as f64;
            let (h, n_parts) = match options.step_size {
                StepSize::Fixed(_) => (part, 1),
                // A step of 2^k parts begins at a multiple of 2^k parts.
                StepSize::Adaptive(_) => {
                    count = count.min(1 << n_done.trailing_zeros().min(MAX_HALVINGS));
                    (part * count as f64, count)
                }
            };
            let controlled = matches!(options.step_size, StepSize::Adaptive(_));
            if let Some((before, rise)) = previous.as_ref().filter(|_| controlled) {
                state.rescale_acceleration(weights, (h - h_of_a) / before, rise);
                h_of_a = h;
            }
            let mut stepped = step(&mut constant, &state, t, h, clock, &scale, &mut stats);
            let mut corrected = None;
            // The rate of change of a before the first step follows from a trial step.
            if let Ok(trial) = stepped.as_ref()
                && controlled
                && previous.is_none()
            {
                let trial_state = [&trial.end.q[..], &trial.end.v[..]].concat();
                model.derivative(clock(t + h), &trial_state, &mut slope);
                stats.evaluations += 1;
                let rise: Vec<f64> = (0..n).map(|i| slope[n + i] - state.a[i]).collect();
                let initial = corrected.insert(state.clone());
                initial.rescale_acceleration(weights, 1.0, &rise);
                stepped = step(&mut constant, initial, t, h, clock, &scale, &mut stats);
            }
            let y0 = corrected.as_ref().unwrap_or(&state);
            let AlphaStep {
                end: next,
                frozen_regime: regime,
            } = match stepped {
                Err(_) if controlled && count > 1 => {
                    stats.rejected += 1;
                    count /= 2;
                    continue;
                }
                result => result?,
            };
            let mut end_state = next.q.clone();
            end_state.extend(&next.v);
            if let StepSize::Adaptive(tolerance) = options.step_size {
                let before: Vec<f64> = [state.q.clone(), state.v.clone()].concat();
                let sizes = scale.sizes(&before, &end_state, h);
                let mut error = local_errors(weights, [y0, &next], h, previous.as_ref());
                let times = [t, t + h].map(clock);
                let lag = switch_error(&constant, [y0, &next], times, regime.as_ref(), &mut stats);
                for (error, lag) in error[n..].iter_mut().zip(&lag) {
                    *error = error.abs() + h * lag.abs();
                }
                let error = error_norm(&error, &sizes[..2 * n]) / tolerance;
                if !(error <= 1.0) {
                    stats.rejected += 1;
                    if count == 1 {
                        return Err(Error::new(
                            Code::NoConvergence,
                            format!(
                                "no step from t = {} keeps the error within the tolerance",
                                format_instant(t)
                            ),
                        )
                        .with_hint("the motion jumps there: take a method that locates switches, or a coarser tolerance"));
                    }
                    count /= 2;
                    check_budget(options, &stats, t)?;
                    continue;
                }
                if error < 0.07 && count < PARTS {
                    count *= 2;
                }
            }
            stats.steps += 1;
            n_done += n_parts;
            let u = if n_done == parts {
                to
            } else {
                from + part * n_done as f64
            };
            check_budget(options, &stats, u)?;
            scale.update(&end_state);
            let at = |t_sample: f64, out: &mut [f64]| match t_sample == u {
                true => out.copy_from_slice(&end_state),
                false => interpolate(weights, [y0, &next], h, (t_sample - t) / h, out),
            };
            options.observer.observe(DenseOutput {
                from: t,
                to: u,
                time_scale: h,
                regime: None,
                state: &mut { at },
            });
            samples.emit_until(u, &mut y, None, at)?;
            let rise = next.a.iter().zip(&y0.a).map(|(b, a)| b - a);
            previous = Some((h, rise.collect()));
            h_of_a = h;
            state = next;
        }
        y = [state.q, state.v].concat();
        from = to;
    }
    Ok(stats)
}
