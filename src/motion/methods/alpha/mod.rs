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

/// Newmark's average acceleration.
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

/// Hilber, Hughes and Taylor's with ρ = 0.8 (α = −1/9).
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

/// Chung and Hulbert's with ρ = 0.8.
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

/// Why the family cannot take a machine.
pub fn unsupported_reason(model: &DynamicModel) -> Option<String> {
    let pressed = |b: &&ForceElement| matches!(b.law, ForceLaw::LoadFriction(_));
    if let Some(b) = model.elements.iter().find(pressed) {
        return Some(format!(
            "the friction of {} depends on the force of another branch, and this method solves each branch alone",
            b.name
        ));
    }
    if let Some(why) = algebraic::why_inertia_needed(model) {
        return Some(why);
    }
    (model.internal_count() > 0).then(|| {
        "a branch has an inner state (a late torque, a spring and a damper in series), which is not of second order"
            .to_string()
    })
}

/// Parts an interval is divided into where the step is chosen by the error, as a power of two: steps are powers of two of them,
/// and the shortest, which a jump of the force needs, are near rounding.
const MAX_HALVINGS: u32 = 50;

/// As many.
const PARTS: u64 = 1 << MAX_HALVINGS;

/// Integrates a machine, with a fixed step or by a tolerance on positions and speeds. Contacts stand where each step's state puts
/// them, and dry friction is spread over its creep speed.
///
/// # Errors
/// `NoConvergence` of Newton's iteration, `Hopeless` beyond the budget, and what cannot be asked.
pub fn run(
    weights: &GeneralizedAlpha,
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    if let Some(why) = unsupported_reason(model) {
        return Err(Error::new(Code::Usage, why).with_hint("take radau5"));
    }
    let n = model.coordinate_count();
    let mut stats = IntegrationStats::default();
    let mut samples = SampleEmitter::new(options, sink);
    let mut constant = ConstantPart::new(weights, model);
    let mut scale = ErrorScale::for_model(model, options);
    scale.update(&options.initial_state);
    let mut y = options.initial_state.clone();
    samples.emit_until(options.from, &mut y, None, |_, _| ())?;
    let mut size = PARTS >> 10;
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
        let mut done = 0;
        let mut last: Option<(f64, Vec<f64>)> = None;
        // The step that a stands for.
        let mut meant = 0.0;
        while done < parts && samples.due().is_some() {
            let t = from + part * done as f64;
            let (h, taken) = match options.step_size {
                StepSize::Fixed(_) => (part, 1),
                // A step of a power of two begins at a multiple of itself.
                StepSize::Adaptive(_) => {
                    size = size.min(1 << done.trailing_zeros().min(MAX_HALVINGS));
                    (part * size as f64, size)
                }
            };
            let controlled = matches!(options.step_size, StepSize::Adaptive(_));
            if let Some((before, rise)) = last.as_ref().filter(|_| controlled) {
                state.rescale_acceleration(weights, (h - meant) / before, rise);
                meant = h;
            }
            let mut stepped = step(&mut constant, &state, t, h, clock, &scale, &mut stats);
            let mut first = None;
            // Before the first step only the motion tells how a changes.
            if let Ok(trial) = stepped.as_ref()
                && controlled
                && last.is_none()
            {
                let there = [&trial.end.q[..], &trial.end.v[..]].concat();
                model.derivative(clock(t + h), &there, &mut slope);
                stats.evaluations += 1;
                let rise: Vec<f64> = (0..n).map(|i| slope[n + i] - state.a[i]).collect();
                let carried = first.insert(state.clone());
                carried.rescale_acceleration(weights, 1.0, &rise);
                stepped = step(&mut constant, carried, t, h, clock, &scale, &mut stats);
            }
            let begun = first.as_ref().unwrap_or(&state);
            let AlphaStep {
                end: next,
                frozen_regime: held,
            } = match stepped {
                Err(_) if controlled && size > 1 => {
                    stats.rejected += 1;
                    size /= 2;
                    continue;
                }
                other => other?,
            };
            let mut reached = next.q.clone();
            reached.extend(&next.v);
            if let StepSize::Adaptive(tolerance) = options.step_size {
                let before: Vec<f64> = [state.q.clone(), state.v.clone()].concat();
                let sizes = scale.sizes(&before, &reached, h);
                let mut error = local_errors(weights, [begun, &next], h, last.as_ref());
                let times = [t, t + h].map(clock);
                let late =
                    switch_error(&constant, [begun, &next], times, held.as_ref(), &mut stats);
                for (error, late) in error[n..].iter_mut().zip(&late) {
                    *error = error.abs() + h * late.abs();
                }
                let error = error_norm(&error, &sizes[..2 * n]) / tolerance;
                if !(error <= 1.0) {
                    stats.rejected += 1;
                    if size == 1 {
                        return Err(Error::new(
                            Code::NoConvergence,
                            format!(
                                "no step from t = {} keeps the error within the tolerance",
                                format_instant(t)
                            ),
                        )
                        .with_hint("the motion jumps there: take a method that locates switches, or a coarser tolerance"));
                    }
                    size /= 2;
                    check_budget(options, &stats, t)?;
                    continue;
                }
                if error < 0.07 && size < PARTS {
                    size *= 2;
                }
            }
            stats.steps += 1;
            done += taken;
            let u = if done == parts {
                to
            } else {
                from + part * done as f64
            };
            check_budget(options, &stats, u)?;
            scale.update(&reached);
            let at = |due: f64, into: &mut [f64]| match due == u {
                true => into.copy_from_slice(&reached),
                false => interpolate(weights, [begun, &next], h, (due - t) / h, into),
            };
            options.observer.observe(DenseOutput {
                from: t,
                to: u,
                time_scale: h,
                regime: None,
                state: &mut { at },
            });
            samples.emit_until(u, &mut y, None, at)?;
            let rise = next.a.iter().zip(&begun.a).map(|(b, a)| b - a);
            last = Some((h, rise.collect()));
            meant = h;
            state = next;
        }
        y = [state.q, state.v].concat();
        from = to;
    }
    Ok(stats)
}
