//! Newmark's method and its kin, implicit, of order 2: one linear system of constant parts factored once per step length,
//! and a correction of low rank for the branches that are not constant.
//!
//! `q₁ = q₀ + h v₀ + h² ((½ − β) a₀ + β a₁)`, `v₁ = v₀ + h ((1 − γ) a₀ + γ a₁)`, and the equation of motion holds for
//! `(1 − α_f) x₁ + α_f x₀` with the acceleration `(1 − α_m) a₁ + α_m a₀`.
//!
//! Sources: Newmark 1959; Hilber, Hughes and Taylor 1977; Chung and Hulbert 1993, equations 3 to 8 and 17, 25.

/// Weights.
pub mod weights;

/// The system of a step.
mod system;

/// A step.
mod step;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::instant;
use crate::motion::light;
use crate::motion::problem::{Ask, Effort, Problem, Sink, Stretch, Wanted};
use crate::motion::progress::{Samples, check, inside, next_stop, within_budget};
use crate::motion::scale::{Scale, norm};
use crate::motion::train::{Branch, Law, Train};
use step::{State, Stepped, between, late, local_errors, step};
use system::Constant;
use weights::{Alpha, RADIUS};

/// Newmark's average acceleration.
///
/// # Errors
/// Those of [`run`].
pub fn newmark(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    run(&Alpha::newmark(), train, ask, sink)
}

/// Hilber, Hughes and Taylor's with ρ = 0.8 (α = −1/9).
///
/// # Errors
/// Those of [`run`].
pub fn hht(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    run(&Alpha::hht(RADIUS), train, ask, sink)
}

/// Chung and Hulbert's with ρ = 0.8.
///
/// # Errors
/// Those of [`run`].
pub fn generalized(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    run(&Alpha::generalized(RADIUS), train, ask, sink)
}

/// Why the family cannot take a machine.
pub fn refuses(train: &Train) -> Option<String> {
    let pressed = |b: &&Branch| matches!(b.law, Law::Pressed(_));
    if let Some(b) = train.branches.iter().find(pressed) {
        return Some(format!(
            "the friction of {} goes by the force of another branch, and each branch is solved by itself here",
            b.name
        ));
    }
    if let Some(why) = light::refused(train) {
        return Some(why);
    }
    (train.inner() > 0).then(|| {
        "a branch has an inner state (a late torque, a spring and a damper in series), which is not of second order"
            .to_string()
    })
}

/// Parts a stretch is divided into where the step is chosen by the error, as a power of two: steps are powers of two of them, and the
/// shortest, which a jump of the force needs, are near rounding.
const HALVINGS: u32 = 50;

/// As many.
const PARTS: u64 = 1 << HALVINGS;

/// Integrates a machine, with a fixed step or by a tolerance on positions and speeds. Contacts stand where each step's state puts
/// them, and dry friction is spread over its creep speed.
///
/// # Errors
/// `NoConvergence` of Newton's iteration, `Hopeless` beyond the budget, and what cannot be asked.
pub fn run(weights: &Alpha, train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    if let Some(why) = refuses(train) {
        return Err(Error::new(Code::Usage, why).hint("take radau5"));
    }
    let n = train.n();
    let mut effort = Effort::default();
    let mut samples = Samples::new(ask, sink);
    let mut constant = Constant::new(weights, train);
    let mut scale = Scale::of_train(train, ask);
    scale.note(&ask.start);
    let mut y = ask.start.clone();
    samples.give_until(ask.from, &mut y, None, |_, _| ())?;
    let mut size = PARTS >> 10;
    let mut from = ask.from;
    while samples.due().is_some() && from < ask.to {
        let to = next_stop(|t| train.next_break(t), from, ask.to);
        let clock = |t: f64| inside(t, from, to);
        let mut slope = vec![0.0; train.len()];
        train.slope(clock(from), &y, &mut slope);
        let mut state = State {
            q: y[..n].to_vec(),
            v: y[n..2 * n].to_vec(),
            a: slope[n..2 * n].to_vec(),
        };
        let parts = match ask.effort {
            Wanted::Step(h) => ((to - from) / h - 1e-6).ceil().max(1.0) as u64,
            Wanted::Tolerance(_) => PARTS,
        };
        let part = (to - from) / parts as f64;
        let mut done = 0;
        let mut last: Option<(f64, Vec<f64>)> = None;
        // The step that a stands for.
        let mut meant = 0.0;
        while done < parts && samples.due().is_some() {
            let t = from + part * done as f64;
            let (h, taken) = match ask.effort {
                Wanted::Step(_) => (part, 1),
                // A step of a power of two begins at a multiple of itself.
                Wanted::Tolerance(_) => {
                    size = size.min(1 << done.trailing_zeros().min(HALVINGS));
                    (part * size as f64, size)
                }
            };
            let controlled = matches!(ask.effort, Wanted::Tolerance(_));
            if let Some((before, rise)) = last.as_ref().filter(|_| controlled) {
                state.carry(weights, (h - meant) / before, rise);
                meant = h;
            }
            let mut stepped = step(&mut constant, &state, t, h, clock, &scale, &mut effort);
            let mut first = None;
            // Before the first step only the motion tells how a changes.
            if let Ok(trial) = stepped.as_ref()
                && controlled
                && last.is_none()
            {
                let there = [&trial.to.q[..], &trial.to.v[..]].concat();
                train.slope(clock(t + h), &there, &mut slope);
                effort.evaluations += 1;
                let rise: Vec<f64> = (0..n).map(|i| slope[n + i] - state.a[i]).collect();
                let carried = first.insert(state.clone());
                carried.carry(weights, 1.0, &rise);
                stepped = step(&mut constant, carried, t, h, clock, &scale, &mut effort);
            }
            let begun = first.as_ref().unwrap_or(&state);
            let Stepped { to: next, held } = match stepped {
                Err(_) if controlled && size > 1 => {
                    effort.rejected += 1;
                    size /= 2;
                    continue;
                }
                other => other?,
            };
            let mut reached = next.q.clone();
            reached.extend(&next.v);
            if let Wanted::Tolerance(tolerance) = ask.effort {
                let before: Vec<f64> = [state.q.clone(), state.v.clone()].concat();
                let sizes = scale.sizes(&before, &reached, h);
                let mut error = local_errors(weights, [begun, &next], h, last.as_ref());
                let times = [t, t + h].map(clock);
                let late = late(&constant, [begun, &next], times, held.as_ref(), &mut effort);
                for (error, late) in error[n..].iter_mut().zip(&late) {
                    *error = error.abs() + h * late.abs();
                }
                let error = norm(&error, &sizes[..2 * n]) / tolerance;
                if !(error <= 1.0) {
                    effort.rejected += 1;
                    if size == 1 {
                        return Err(Error::new(
                            Code::NoConvergence,
                            format!(
                                "no step from t = {} keeps the error within the tolerance",
                                instant(t)
                            ),
                        )
                        .hint("the motion jumps there: take a method that locates switches, or a coarser tolerance"));
                    }
                    size /= 2;
                    within_budget(ask, &effort, t)?;
                    continue;
                }
                if error < 0.07 && size < PARTS {
                    size *= 2;
                }
            }
            effort.steps += 1;
            done += taken;
            let u = if done == parts {
                to
            } else {
                from + part * done as f64
            };
            within_budget(ask, &effort, u)?;
            scale.note(&reached);
            let at = |due: f64, into: &mut [f64]| match due == u {
                true => into.copy_from_slice(&reached),
                false => between(weights, [begun, &next], h, (due - t) / h, into),
            };
            ask.follower.follow(Stretch {
                from: t,
                to: u,
                grain: h,
                regime: None,
                state: &mut { at },
            });
            samples.give_until(u, &mut y, None, at)?;
            let rise = next.a.iter().zip(&begun.a).map(|(b, a)| b - a);
            last = Some((h, rise.collect()));
            meant = h;
            state = next;
        }
        y = [state.q, state.v].concat();
        from = to;
    }
    Ok(effort)
}
