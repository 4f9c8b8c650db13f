//! Exponential Runge–Kutta method of stiff order 4, exact for the linear terms of a regime.
//!
//! Between two known discontinuities `M q̈ + C q̇ + K q = N(t, q, q̇)` with the initial tangent stiffness K and the modal damping C
//! diagonal in the modes of K. In these modes each stage is the exact response to a polynomial forcing. Source: Hochbruck and Ostermann,
//! Explicit exponential Runge–Kutta methods for semilinear parabolic problems, SIAM J. Numer. Anal. 43 (2005), pp. 1069–1090, eq. 5.19:
//! five stages, of order 4 independent of the stiffness of the linear terms. Two error estimates are used: the third stage in
//! place of the fifth, of order 3, for forces that vary with the state, and the residual of the polynomial at a quarter of the step for
//! forces that vary with time. Dense output is the response to the last polynomial.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::motion::algebraic;
use crate::motion::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::motion::equations::RegimeProblem;
use crate::motion::error_scale::{ErrorScale, error_norm};
use crate::motion::events;
use crate::motion::pencil::add_outer_product;
use crate::motion::problem::{IntegrationOptions, IntegrationStats, OdeProblem, SampleSink};
use crate::motion::progress::{check_options, clamp_time};
use crate::motion::segment::phi::damped_pair;
use crate::motion::stepper::{StepSizeRule, Stepper, equal_step};
use crate::numeric::{Matrix, symmetric};

use super::with_events::step_size;

/// Largest step relative to the shortest excitation period: the stages evaluate the start, the middle and the end of a step, and
/// aliasing would hide full periods.
const MAX_PERIOD_SHARE: f64 = 0.25;

/// Reason against the method for a model; absent if supported.
pub fn unsupported_reason(model: &DynamicModel) -> Option<String> {
    if model.internal_count() > 0 {
        let message = "a branch has an inner state (a delayed torque, a spring and a damper in series), which is not a mode";
        return Some(message.to_string());
    }
    if model.has_events() {
        let message = "something can switch (play, dry friction), and its steps span many oscillations, in which a switch would be missed";
        return Some(message.to_string());
    }
    algebraic::inertia_requirement(model)
}

/// Integrates a dynamic model by the exponential method.
///
/// # Errors
/// Those of [`events::run`].
pub fn exponential(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    let fastest = model.harmonics().fold(0.0, f64::max);
    let timed = |b: &ForceElement| {
        let waves = b.stiffness_wave.iter().chain(&b.angle_waves);
        waves.into_iter().any(|w| w.phase.angle().is_none())
    };
    let mut stepper = ExponentialRk {
        control: step_size(options),
        scale: ErrorScale::for_model(model, options),
        next: 0.0,
        longest: MAX_PERIOD_SHARE * TAU / fastest,
        timed: fastest > 0.0 || model.elements.iter().any(timed),
        modes: None,
        since: f64::NEG_INFINITY,
        last: None,
    };
    events::run(model, options, sink, &mut stepper)
}

/// Impulse response of `s̈ + d ṡ + ω² s = 0` from `s = 0`, `ṡ = 1`: ṡ, s and its first three integrals after an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhiKernel {
    /// Rate ṡ.
    pub rate: f64,
    /// Integrals s, ∫s, ∫∫s, ∫∫∫s.
    pub integrals: [f64; 4],
}

/// Number of terms of the power series, exact to rounding up to ωτ and dτ of one.
const TERMS: usize = 26;

impl PhiKernel {
    /// Kernel after τ for ω² of either sign and d.
    pub fn new((square, damping): (f64, f64), tau: f64) -> PhiKernel {
        let omega = square.abs().sqrt();
        if square > 0.0 && omega * tau >= 1.0 {
            let (even, s) = damped_pair(0.5 * damping, square, tau);
            let rate = even - 0.5 * damping * s;
            let first = (1.0 - rate - damping * s) / square;
            let second = (tau - s - damping * first) / square;
            let third = (0.5 * tau * tau - first - damping * second) / square;
            return PhiKernel {
                rate,
                integrals: [s, first, second, third],
            };
        }
        let fast = omega.max(damping.abs()) * tau;
        let doublings = fast.log2().ceil().clamp(0.0, 1100.0) as i32;
        let mut length = tau * f64::from(-doublings).exp2();
        let mut kernel = PhiKernel::series((square, damping), length);
        for _ in 0..doublings {
            kernel = kernel.double_time((square, damping), length);
            length *= 2.0;
        }
        kernel
    }

    /// Kernel by power series: with `cₙ = s⁽ⁿ⁾(0) τⁿ⁻¹` the k-th integral of s is `Σ cₙ τᵏ⁺¹/(n + k)!`.
    fn series((square, damping): (f64, f64), tau: f64) -> PhiKernel {
        let mut terms = [0.0; TERMS];
        terms[1] = 1.0;
        for n in 2..TERMS {
            terms[n] = -damping * tau * terms[n - 1] - square * tau * tau * terms[n - 2];
        }
        let sum = |k: i32| -> f64 {
            let mut factorial: f64 = (1..=k + 1).map(f64::from).product();
            let mut all = terms[1] / factorial;
            for (n, term) in (1..).zip(&terms[1..]).skip(1) {
                factorial *= f64::from(n + k);
                all += term / factorial;
            }
            all
        };
        PhiKernel {
            rate: sum(-1),
            integrals: [0, 1, 2, 3].map(|k| sum(k) * tau.powi(k + 1)),
        }
    }

    /// Kernel after twice the time: free response plus the response to the forcing `(τ + u)^k/k!`.
    fn double_time(self, (square, damping): (f64, f64), tau: f64) -> PhiKernel {
        let [s, first, second, third] = self.integrals;
        let position = self.rate + damping * s;
        let continued = |x: f64, v: f64| position * x + s * v;
        PhiKernel {
            rate: self.rate * self.rate - square * s * s,
            integrals: [
                continued(s, self.rate),
                continued(first, s) + first,
                continued(second, first) + second + tau * first,
                continued(third, second) + third + tau * second + 0.5 * tau * tau * first,
            ],
        }
    }
}

/// Undamped modes of the tangent stiffness of a regime.
struct TangentModes {
    /// Mode shapes Φ, `ΦᵀMΦ = I`.
    shapes: Matrix,
    /// Modal projection ΦᵀM.
    projection: Matrix,
    /// Squared frequency ω², 1/s², and damping d, 1/s, of every mode.
    pairs: Vec<(f64, f64)>,
}

impl TangentModes {
    fn new(frozen: &RegimeProblem, t: f64, y: &[f64]) -> Result<TangentModes, Error> {
        let model = frozen.model;
        let n = model.coordinate_count();
        let (mut k, mut c) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        for (element, b) in model.elements.iter().enumerate() {
            let is_smooth = matches!(
                b.law,
                ForceLaw::Linear { .. }
                    | ForceLaw::Contact(_)
                    | ForceLaw::Nonlinear { .. }
                    | ForceLaw::TorqueSpeed(_)
            );
            if is_smooth && b.force_direction.is_none() {
                let (_, stiffness, damping) =
                    model.element_force(element, Some(frozen.regime), t, y, 0.0);
                add_outer_product(&mut k, &b.direction, &b.direction, stiffness);
                add_outer_product(&mut c, &b.direction, &b.direction, damping);
            }
        }
        let mass = model.mass.matrix();
        let modes = symmetric::generalised_symmetric_eigen(&k, &mass)?;
        let projection = modes.vectors.transpose() * &mass;
        let damping_matrix = modes.vectors.transpose() * &c * &modes.vectors;
        let pairs = modes.values.iter().enumerate();
        Ok(TangentModes {
            pairs: pairs
                .map(|(r, square)| (*square, damping_matrix[(r, r)] + model.mass_damping))
                .collect(),
            projection,
            shapes: modes.vectors,
        })
    }

    fn to_modal(matrix: &Matrix, y: &[f64]) -> Vec<f64> {
        let n = matrix.nrows();
        let block = |from: usize| {
            move |i: usize| -> f64 { (0..n).map(|j| matrix[(i, j)] * y[from + j]).sum() }
        };
        (0..n).map(block(0)).chain((0..n).map(block(n))).collect()
    }

    /// Modal forcing N at a modal state.
    fn forcing(
        &self,
        problem: &RegimeProblem,
        t: f64,
        x: &[f64],
        stats: &mut IntegrationStats,
    ) -> Vec<f64> {
        let n = self.pairs.len();
        let mut slope = vec![0.0; 2 * n];
        problem.derivative(t, &TangentModes::to_modal(&self.shapes, x), &mut slope);
        stats.evaluations += 1;
        let mode = |(r, (square, damping)): (usize, &(f64, f64))| {
            let force: f64 = (0..n).map(|j| self.projection[(r, j)] * slope[n + j]).sum();
            force + square * x[r] + damping * x[n + r]
        };
        self.pairs.iter().enumerate().map(mode).collect()
    }

    fn kernels(&self, tau: f64) -> Vec<PhiKernel> {
        let pairs = self.pairs.iter();
        pairs.map(|&pair| PhiKernel::new(pair, tau)).collect()
    }

    /// Free response from the modal state x.
    fn homogeneous(&self, kernels: &[PhiKernel], x: &[f64]) -> Vec<f64> {
        let n = self.pairs.len();
        let mut out = vec![0.0; 2 * n];
        for (r, (kernel, (square, damping))) in kernels.iter().zip(&self.pairs).enumerate() {
            let s = kernel.integrals[0];
            out[r] = (kernel.rate + damping * s) * x[r] + s * x[n + r];
            out[n + r] = kernel.rate * x[n + r] - square * s * x[r];
        }
        out
    }
}

/// Adds the forced response, `x += a h φ_k(cA) w`, with the kernels after c = `tau`.
fn add_forcing(x: &mut [f64], kernels: &[PhiKernel], (k, tau): (usize, f64), a: f64, w: &[f64]) {
    let n = kernels.len();
    let factor = a / tau.powi(k as i32 - 1);
    for (r, kernel) in kernels.iter().enumerate() {
        x[r] += factor * kernel.integrals[k] * w[r];
        x[n + r] += factor * kernel.integrals[k - 1] * w[r];
    }
}

fn sum(terms: &[(f64, &[f64])]) -> Vec<f64> {
    let length = terms.first().map_or(0, |t| t.1.len());
    let entry = |i: usize| terms.iter().map(|(a, x)| a * x[i]).sum();
    (0..length).map(entry).collect()
}

/// Exponential step: its kernels, end state, error estimate and polynomial forcing.
struct ExponentialStep {
    kernels: Vec<PhiKernel>,
    end: Vec<f64>,
    error: Vec<f64>,
    forcing: [Vec<f64>; 3],
}

impl TangentModes {
    /// Exponential step of size h, s, from a modal state with the forcing `first`.
    fn step(
        &self,
        problem: &RegimeProblem,
        clock: impl Fn(f64) -> f64,
        (t, x): (f64, &[f64]),
        h: f64,
        first: &[f64],
        stats: &mut IntegrationStats,
    ) -> ExponentialStep {
        let half = 0.5 * h;
        let (full, halves) = (self.kernels(h), self.kernels(half));
        let mut n = |c: f64, state: &[f64]| self.forcing(problem, clock(t + c * h), state, stats);
        // h φ_k over half a step is twice half of it.
        let (to_half, to_end) = (self.homogeneous(&halves, x), self.homogeneous(&full, x));
        let mut stage2 = to_half.clone();
        add_forcing(&mut stage2, &halves, (1, half), 1.0, first);
        let second = n(0.5, &stage2);
        let mut stage3 = stage2;
        add_forcing(
            &mut stage3,
            &halves,
            (2, half),
            2.0,
            &sum(&[(1.0, &second), (-1.0, first)]),
        );
        let third = n(0.5, &stage3);
        let pair_sum = sum(&[(1.0, &second), (1.0, &third)]);
        let mut stage4 = to_end.clone();
        add_forcing(&mut stage4, &full, (1, h), 1.0, first);
        add_forcing(
            &mut stage4,
            &full,
            (2, h),
            1.0,
            &sum(&[(1.0, &pair_sum), (-2.0, first)]),
        );
        let fourth = n(1.0, &stage4);
        // a₅₂ = ½ φ₂(½) − φ₃ + ¼ φ₂ − ½ φ₃(½), of w₂ + w₃ − w₁ − w₄; next to it ½ φ₁(½) w₁ + ¼ φ₂(½) (w₄ − w₁).
        let mixed = sum(&[(1.0, &pair_sum), (-1.0, first), (-1.0, &fourth)]);
        let mut stage5 = to_half;
        add_forcing(&mut stage5, &halves, (1, half), 1.0, first);
        add_forcing(
            &mut stage5,
            &halves,
            (2, half),
            0.5,
            &sum(&[(1.0, &fourth), (-1.0, first)]),
        );
        add_forcing(&mut stage5, &halves, (2, half), 1.0, &mixed);
        add_forcing(&mut stage5, &halves, (3, half), -1.0, &mixed);
        add_forcing(&mut stage5, &full, (2, h), 0.25, &mixed);
        add_forcing(&mut stage5, &full, (3, h), -1.0, &mixed);
        let fifth = n(0.5, &stage5);
        let slope = sum(&[(-3.0, first), (-1.0, &fourth), (4.0, &fifth)]);
        let curve = sum(&[(4.0, first), (4.0, &fourth), (-8.0, &fifth)]);
        let mut end = to_end;
        add_forcing(&mut end, &full, (1, h), 1.0, first);
        add_forcing(&mut end, &full, (2, h), 1.0, &slope);
        add_forcing(&mut end, &full, (3, h), 1.0, &curve);
        let difference = sum(&[(1.0, &fifth), (-1.0, &third)]);
        let mut error = vec![0.0; x.len()];
        add_forcing(&mut error, &full, (2, h), 4.0, &difference);
        add_forcing(&mut error, &full, (3, h), -8.0, &difference);
        ExponentialStep {
            kernels: full,
            end,
            error,
            forcing: [first.to_vec(), slope, curve],
        }
    }

    /// Error estimate of a forcing that is no parabola through three instants: with the residual r at a quarter of the step, a cubic
    /// that vanishes at these instants has the mean magnitude `⅔|r|`.
    fn step_error(
        &self,
        problem: &RegimeProblem,
        clock: impl Fn(f64) -> f64,
        (t, x): (f64, &[f64]),
        h: f64,
        stepped: &ExponentialStep,
        stats: &mut IntegrationStats,
    ) -> Vec<f64> {
        const ERROR_POINT: f64 = 0.25;
        let state = self.dense_state(x, h, &stepped.forcing, ERROR_POINT);
        let forcing = self.forcing(problem, clock(t + ERROR_POINT * h), &state, stats);
        let [first, slope, curve] = &stepped.forcing;
        let r = sum(&[
            (1.0, &forcing),
            (-1.0, first),
            (-ERROR_POINT, slope),
            (-0.5 * ERROR_POINT * ERROR_POINT, curve),
        ]);
        let mut error = vec![0.0; x.len()];
        add_forcing(&mut error, &stepped.kernels, (1, h), 2.0 / 3.0, &r);
        error
    }

    /// Dense output: modal state at a fraction θ of a step from x.
    fn dense_state(&self, x: &[f64], h: f64, forcing: &[Vec<f64>; 3], theta: f64) -> Vec<f64> {
        let tau = theta * h;
        let kernels = self.kernels(tau);
        let mut state = self.homogeneous(&kernels, x);
        for (k, w) in forcing.iter().enumerate() {
            // The forcing t^k/(h^k k!) acts over θ h.
            add_forcing(&mut state, &kernels, (k + 1, tau), theta.powi(k as i32), w);
        }
        state
    }
}

/// Exponential Runge–Kutta stepper.
pub struct ExponentialRk {
    control: StepSizeRule,
    scale: ErrorScale,
    /// Proposed next step, s; zero if unknown.
    next: f64,
    /// Largest adaptive step, s, limited by the excitation period.
    longest: f64,
    /// Forces depend explicitly and nonlinearly on time.
    timed: bool,
    /// Tangent modes of the present regime; absent after a restart.
    modes: Option<TangentModes>,
    since: f64,
    /// Last step: size, s, initial modal state and polynomial forcing.
    last: Option<(f64, Vec<f64>, [Vec<f64>; 3])>,
}

impl ExponentialRk {
    /// Initial step, s: a hundredth of the time scale of the nonlinear forcing.
    fn first(&self, y: &[f64], forcing: &[f64], remaining: f64) -> f64 {
        let sizes = self.scale.sizes(y, y, 1e-3 * remaining);
        let forces: Vec<f64> = forcing.iter().chain(forcing).copied().collect();
        let step = 0.01 * error_norm(y, &sizes) / error_norm(&forces, &sizes);
        match step > 0.0 && step.is_finite() {
            true => step.clamp(1e-8 * remaining, 1e-2 * remaining),
            false => 1e-4 * remaining,
        }
    }
}

impl<'f> Stepper<RegimeProblem<'f>> for ExponentialRk {
    fn restart(&mut self) {
        self.modes = None;
    }

    fn step(
        &mut self,
        problem: &RegimeProblem<'f>,
        (t, y): (f64, &[f64]),
        end: f64,
        stats: &mut IntegrationStats,
    ) -> Result<(f64, Vec<f64>), Error> {
        let modes = match self.modes.take() {
            Some(modes) => modes,
            None => {
                self.since = t;
                stats.regimes += 1;
                TangentModes::new(problem, t, y)?
            }
        };
        let since = self.since;
        let clock = move |t: f64| clamp_time(t, since, end);
        self.scale.update(y);
        let x = TangentModes::to_modal(&modes.projection, y);
        let first = modes.forcing(problem, clock(t), &x, stats);
        let remaining = end - t;
        let proposed = match self.control {
            StepSizeRule::Fixed(h) => equal_step(remaining, h),
            StepSizeRule::Tolerance(_) if self.next > 0.0 => self.next.min(self.longest),
            StepSizeRule::Tolerance(_) => self.first(y, &first, remaining).min(self.longest),
        };
        let mut h = proposed.min(remaining);
        let mut rejected = false;
        loop {
            if !(h > 4.0 * f64::EPSILON * t.abs() && h > 0.0) && h < remaining {
                return Err(Error::new(
                    Code::NoConvergence,
                    format!("no step from t = {} keeps the error within the tolerance", format_instant(t)),
                )
                .with_hint("the nonlinear part is stiff or jumps there: take radau5, or a coarser tolerance"));
            }
            let stepped = modes.step(problem, clock, (t, &x), h, &first, stats);
            let y_end = TangentModes::to_modal(&modes.shapes, &stepped.end);
            let error = match self.control {
                StepSizeRule::Fixed(_) => 0.0,
                StepSizeRule::Tolerance(tolerance) => {
                    let sizes = self.scale.sizes(y, &y_end, h);
                    let size = |modal: &[f64]| {
                        error_norm(&TangentModes::to_modal(&modes.shapes, modal), &sizes)
                    };
                    let time_error = match self.timed {
                        true => {
                            size(&modes.step_error(problem, clock, (t, &x), h, &stepped, stats))
                        }
                        false => 0.0,
                    };
                    size(&stepped.error).max(time_error) / tolerance
                }
            };
            let factor = 0.9 * error.powf(-0.25);
            if error <= 1.0 {
                let u = if h == remaining { end } else { t + h };
                let next = h * factor.clamp(0.3, if rejected { 1.0 } else { 4.0 });
                self.next = match h == remaining {
                    true => next.max(self.next),
                    false => next,
                };
                self.scale.update(&y_end);
                self.last = Some((h, x, stepped.forcing));
                self.modes = Some(modes);
                return Ok((u, y_end));
            }
            stats.rejected += 1;
            rejected = true;
            h *= match error.is_finite() {
                true => factor.clamp(0.1, 0.9),
                false => 0.1,
            };
        }
    }

    fn interpolate(&self, theta: f64, y: &mut [f64]) {
        let (Some(modes), Some((h, x, forcing))) = (&self.modes, &self.last) else {
            return;
        };
        if theta * h == 0.0 {
            y.copy_from_slice(&TangentModes::to_modal(&modes.shapes, x));
            return;
        }
        let state = modes.dense_state(x, *h, forcing, theta);
        y.copy_from_slice(&TangentModes::to_modal(&modes.shapes, &state));
    }
}
