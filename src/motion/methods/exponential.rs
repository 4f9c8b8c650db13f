//! Exponential Runge–Kutta method of stiff order 4; the linear part of a regime is exact.
//!
//! Between two known breaks `M q̈ + C q̇ + K q = N(t, q, q̇)`, K the tangents where it began, C what of the dampers modes of K share. In
//! these modes each stage is the exact answer to a forcing that is a polynomial of time. Source: Hochbruck and Ostermann, Explicit
//! exponential Runge–Kutta methods for semilinear parabolic problems, SIAM J. Numer. Anal. 43 (2005), pp. 1069–1090, eq. 5.19: five
//! stages, of order 4 however stiff the linear part is. The error is estimated by the third stage in place of the fifth, of order 3,
//! which sees what the state does to the forces, and by the forces a quarter of the step on, next to the polynomial, which
//! shows what time does to them. Inside a step the last polynomial acts up to any instant.

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

/// Largest step as a share of the shortest excitation period: the stages evaluate the beginning, the middle and the end of a step, and over
/// whole periods would see no change.
const MAX_PERIOD_SHARE: f64 = 0.25;

/// Why the method cannot take a machine; absent where it can.
pub fn unsupported_reason(model: &DynamicModel) -> Option<String> {
    if model.internal_count() > 0 {
        let message = "a branch has an inner state (a late torque, a spring and a damper in series), which is no mode";
        return Some(message.to_string());
    }
    if model.has_events() {
        let message = "something can switch (play, dry friction), and its steps span many oscillations, in which a switch would be missed";
        return Some(message.to_string());
    }
    algebraic::why_inertia_needed(model)
}

/// A machine by the exponential method.
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

/// `s̈ + d ṡ + ω² s = 0` from `s = 0`, `ṡ = 1`: after an interval ṡ, and s with what it leaves integrated once, twice, thrice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhiKernel {
    /// ṡ.
    pub rate: f64,
    /// s, ∫s, ∫∫s, ∫∫∫s.
    pub integrals: [f64; 4],
}

/// Terms of the power series, exact to rounding up to ωτ and dτ of one.
const TERMS: usize = 26;

impl PhiKernel {
    /// After τ, for ω² of either sign and d.
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

    /// By its power series: with `cₙ = s⁽ⁿ⁾(0) τⁿ⁻¹` s integrated k times is `Σ cₙ τᵏ⁺¹/(coordinate_count + k)!`.
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

    /// Kernel after twice the time: the free response continues, and `(τ + u)^k/k!` goes on forcing.
    fn double_time(self, (square, damping): (f64, f64), tau: f64) -> PhiKernel {
        let [s, first, second, third] = self.integrals;
        let place = self.rate + damping * s;
        let on = |x: f64, v: f64| place * x + s * v;
        PhiKernel {
            rate: self.rate * self.rate - square * s * s,
            integrals: [
                on(s, self.rate),
                on(first, s) + first,
                on(second, first) + second + tau * first,
                on(third, second) + third + tau * second + 0.5 * tau * tau * first,
            ],
        }
    }
}

/// Modes of a regime.
struct TangentModes {
    /// Φ, `ΦᵀMΦ = 1`.
    shapes: Matrix,
    /// ΦᵀM.
    back: Matrix,
    /// ω² and d of every mode.
    pairs: Vec<(f64, f64)>,
}

impl TangentModes {
    fn new(frozen: &RegimeProblem, t: f64, y: &[f64]) -> Result<TangentModes, Error> {
        let model = frozen.model;
        let n = model.coordinate_count();
        let (mut k, mut c) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        for (at, b) in model.elements.iter().enumerate() {
            let sums = matches!(
                b.law,
                ForceLaw::Linear { .. }
                    | ForceLaw::Contact(_)
                    | ForceLaw::Nonlinear { .. }
                    | ForceLaw::TorqueSpeed(_)
            );
            if sums && b.force_direction.is_none() {
                let (_, stiffness, damping) =
                    model.element_force(at, Some(frozen.regime), t, y, 0.0);
                add_outer_product(&mut k, &b.direction, &b.direction, stiffness);
                add_outer_product(&mut c, &b.direction, &b.direction, damping);
            }
        }
        let mass = model.mass.matrix();
        let found = symmetric::generalised_symmetric_eigen(&k, &mass)?;
        let back = found.vectors.transpose() * &mass;
        let shared = found.vectors.transpose() * &c * &found.vectors;
        let pairs = found.values.iter().enumerate();
        Ok(TangentModes {
            pairs: pairs
                .map(|(r, square)| (*square, shared[(r, r)] + model.mass_damping))
                .collect(),
            back,
            shapes: found.vectors,
        })
    }

    fn to_modal(matrix: &Matrix, y: &[f64]) -> Vec<f64> {
        let n = matrix.nrows();
        let part = |from: usize| {
            move |i: usize| -> f64 { (0..n).map(|j| matrix[(i, j)] * y[from + j]).sum() }
        };
        (0..n).map(part(0)).chain((0..n).map(part(n))).collect()
    }

    /// N at a modal state.
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
            let pushed: f64 = (0..n).map(|j| self.back[(r, j)] * slope[n + j]).sum();
            pushed + square * x[r] + damping * x[n + r]
        };
        self.pairs.iter().enumerate().map(mode).collect()
    }

    fn kernels(&self, tau: f64) -> Vec<PhiKernel> {
        let pairs = self.pairs.iter();
        pairs.map(|&pair| PhiKernel::new(pair, tau)).collect()
    }

    /// From `x`, pushed by nothing.
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

/// `x += a h φ_k(cA) w`, the kernels those after c = `tau`.
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
    let at = |i: usize| terms.iter().map(|(a, x)| a * x[i]).sum();
    (0..length).map(at).collect()
}

/// A step: the kernels over it, where it ends, what it may be wrong by, and its forcing as a polynomial of time over its length.
struct ExponentialStep {
    whole: Vec<PhiKernel>,
    end: Vec<f64>,
    error: Vec<f64>,
    forcing: [Vec<f64>; 3],
}

impl TangentModes {
    /// A step of length h from a modal state, with N there.
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
        let (whole, halves) = (self.kernels(h), self.kernels(half));
        let mut at = |c: f64, state: &[f64]| self.forcing(problem, clock(t + c * h), state, stats);
        // h φ_k over half a step is twice half of it.
        let (to_half, to_end) = (self.homogeneous(&halves, x), self.homogeneous(&whole, x));
        let mut two = to_half.clone();
        add_forcing(&mut two, &halves, (1, half), 1.0, first);
        let second = at(0.5, &two);
        let mut three = two;
        add_forcing(
            &mut three,
            &halves,
            (2, half),
            2.0,
            &sum(&[(1.0, &second), (-1.0, first)]),
        );
        let third = at(0.5, &three);
        let both = sum(&[(1.0, &second), (1.0, &third)]);
        let mut four = to_end.clone();
        add_forcing(&mut four, &whole, (1, h), 1.0, first);
        add_forcing(
            &mut four,
            &whole,
            (2, h),
            1.0,
            &sum(&[(1.0, &both), (-2.0, first)]),
        );
        let fourth = at(1.0, &four);
        // a₅₂ = ½ φ₂(½) − φ₃ + ¼ φ₂ − ½ φ₃(½), of w₂ + w₃ − w₁ − w₄; next to it ½ φ₁(½) w₁ + ¼ φ₂(½) (w₄ − w₁).
        let mixed = sum(&[(1.0, &both), (-1.0, first), (-1.0, &fourth)]);
        let mut five = to_half;
        add_forcing(&mut five, &halves, (1, half), 1.0, first);
        add_forcing(
            &mut five,
            &halves,
            (2, half),
            0.5,
            &sum(&[(1.0, &fourth), (-1.0, first)]),
        );
        add_forcing(&mut five, &halves, (2, half), 1.0, &mixed);
        add_forcing(&mut five, &halves, (3, half), -1.0, &mixed);
        add_forcing(&mut five, &whole, (2, h), 0.25, &mixed);
        add_forcing(&mut five, &whole, (3, h), -1.0, &mixed);
        let fifth = at(0.5, &five);
        let slope = sum(&[(-3.0, first), (-1.0, &fourth), (4.0, &fifth)]);
        let bend = sum(&[(4.0, first), (4.0, &fourth), (-8.0, &fifth)]);
        let mut end = to_end;
        add_forcing(&mut end, &whole, (1, h), 1.0, first);
        add_forcing(&mut end, &whole, (2, h), 1.0, &slope);
        add_forcing(&mut end, &whole, (3, h), 1.0, &bend);
        let apart = sum(&[(1.0, &fifth), (-1.0, &third)]);
        let mut error = vec![0.0; x.len()];
        add_forcing(&mut error, &whole, (2, h), 4.0, &apart);
        add_forcing(&mut error, &whole, (3, h), -8.0, &apart);
        ExponentialStep {
            whole,
            end,
            error,
            forcing: [first.to_vec(), slope, bend],
        }
    }

    /// Error of a step whose forcing is not the parabola through three instants: with r the difference a quarter of the step on, a cubic
    /// that vanishes at the three has `⅔|r|` for the mean of its size.
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
        let there = self.forcing(problem, clock(t + ERROR_POINT * h), &state, stats);
        let [first, slope, bend] = &stepped.forcing;
        let r = sum(&[
            (1.0, &there),
            (-1.0, first),
            (-ERROR_POINT, slope),
            (-0.5 * ERROR_POINT * ERROR_POINT, bend),
        ]);
        let mut error = vec![0.0; x.len()];
        add_forcing(&mut error, &stepped.whole, (1, h), 2.0 / 3.0, &r);
        error
    }

    /// The modal state at a share of a step from x, under its forcing.
    fn dense_state(&self, x: &[f64], h: f64, forcing: &[Vec<f64>; 3], theta: f64) -> Vec<f64> {
        let tau = theta * h;
        let kernels = self.kernels(tau);
        let mut state = self.homogeneous(&kernels, x);
        for (k, w) in forcing.iter().enumerate() {
            // t^k/(h^k k!) pushes over θ h.
            add_forcing(&mut state, &kernels, (k + 1, tau), theta.powi(k as i32), w);
        }
        state
    }
}

/// The method between two steps.
pub struct ExponentialRk {
    control: StepSizeRule,
    scale: ErrorScale,
    /// The step to try next, s; zero where none is known.
    next: f64,
    /// The longest step that follows what drives, s; by its tolerance it takes none that is longer.
    longest: f64,
    /// Forces change with time itself, other than along lines.
    timed: bool,
    /// Tangent modes of the present regime; absent after a restart.
    modes: Option<TangentModes>,
    since: f64,
    /// The last step: its length, its modal start, its forcing.
    last: Option<(f64, Vec<f64>, [Vec<f64>; 3])>,
}

impl ExponentialRk {
    /// A first step: a hundredth of the time in which what is not linear would move the state, s.
    fn first(&self, y: &[f64], forcing: &[f64], left: f64) -> f64 {
        let sizes = self.scale.sizes(y, y, 1e-3 * left);
        let pushed: Vec<f64> = forcing.iter().chain(forcing).copied().collect();
        let sensible = 0.01 * error_norm(y, &sizes) / error_norm(&pushed, &sizes);
        match sensible > 0.0 && sensible.is_finite() {
            true => sensible.clamp(1e-8 * left, 1e-2 * left),
            false => 1e-4 * left,
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
        let x = TangentModes::to_modal(&modes.back, y);
        let first = modes.forcing(problem, clock(t), &x, stats);
        let left = end - t;
        let wanted = match self.control {
            StepSizeRule::Fixed(h) => equal_step(left, h),
            StepSizeRule::Tolerance(_) if self.next > 0.0 => self.next.min(self.longest),
            StepSizeRule::Tolerance(_) => self.first(y, &first, left).min(self.longest),
        };
        let mut h = wanted.min(left);
        let mut refused = false;
        loop {
            if !(h > 4.0 * f64::EPSILON * t.abs() && h > 0.0) && h < left {
                return Err(Error::new(
                    Code::NoConvergence,
                    format!("no step from t = {} keeps the error within the tolerance", format_instant(t)),
                )
                .with_hint("what is not linear is stiff or jumps there: take radau5, or a coarser tolerance"));
            }
            let stepped = modes.step(problem, clock, (t, &x), h, &first, stats);
            let reached = TangentModes::to_modal(&modes.shapes, &stepped.end);
            let error = match self.control {
                StepSizeRule::Fixed(_) => 0.0,
                StepSizeRule::Tolerance(tolerance) => {
                    let sizes = self.scale.sizes(y, &reached, h);
                    let size = |modal: &[f64]| {
                        error_norm(&TangentModes::to_modal(&modes.shapes, modal), &sizes)
                    };
                    let missed = match self.timed {
                        true => {
                            size(&modes.step_error(problem, clock, (t, &x), h, &stepped, stats))
                        }
                        false => 0.0,
                    };
                    size(&stepped.error).max(missed) / tolerance
                }
            };
            let factor = 0.9 * error.powf(-0.25);
            if error <= 1.0 {
                let u = if h == left { end } else { t + h };
                let grown = h * factor.clamp(0.3, if refused { 1.0 } else { 4.0 });
                self.next = match h == left {
                    true => grown.max(self.next),
                    false => grown,
                };
                self.scale.update(&reached);
                self.last = Some((h, x, stepped.forcing));
                self.modes = Some(modes);
                return Ok((u, reached));
            }
            stats.rejected += 1;
            refused = true;
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
