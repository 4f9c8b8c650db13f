//! An exponential Runge–Kutta method of stiff order 4: the linear part of a regime exact, what is left of the forces by stages.
//!
//! Between two known breaks `M q̈ + C q̇ + K q = N(t, q, q̇)`, K the tangents where it began, C what of the dampers modes of K share. In
//! these modes each stage is the exact answer to a forcing that is a polynomial of time. Source: Hochbruck and Ostermann, Explicit
//! exponential Runge–Kutta methods for semilinear parabolic problems, SIAM J. Numer. Anal. 43 (2005), pp. 1069–1090, eq. 5.19: five
//! stages, of order 4 however stiff the linear part is. The error is estimated by the third stage in place of the fifth, of order 3,
//! which sees what the state does to the forces, and by the forces a quarter of the step on, beside the polynomial, which shows what
//! time does to them. Inside a step the last polynomial acts up to any instant.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::instant;
use crate::motion::equations::Frozen;
use crate::motion::events;
use crate::motion::light;
use crate::motion::pencil::add;
use crate::motion::problem::{Ask, Effort, Problem, Sink};
use crate::motion::progress::{check, inside};
use crate::motion::scale::{Scale, norm};
use crate::motion::segment::phi::faded;
use crate::motion::stepper::{Control, Stepper, equal_part};
use crate::motion::train::{Branch, Law, Train};
use crate::numeric::{Matrix, definite};

use super::stepping::control;

/// Of the shortest period of what drives: the stages see the beginning, the middle and the end of a step, and over whole periods they would
/// see nothing happen.
const SHARE: f64 = 0.25;

/// Why the method cannot take a machine; absent where it can.
pub fn refuses(train: &Train) -> Option<String> {
    if train.inner() > 0 {
        let message = "a branch has an inner state (a late torque, a spring and a damper in series), which is no mode";
        return Some(message.to_string());
    }
    if train.has_events() {
        let message = "something can switch (play, dry friction), and its steps go over many swings at once, in which no switch would be seen";
        return Some(message.to_string());
    }
    light::refused(train)
}

/// A machine by the exponential method.
///
/// # Errors
/// Those of [`events::run`].
pub fn exponential(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    let fastest = train.harmonics().fold(0.0, f64::max);
    let timed = |b: &Branch| {
        let waves = b.variation.iter().chain(&b.followed);
        waves.into_iter().any(|w| w.phase.angle().is_none())
    };
    let mut stepper = Exponential {
        control: control(ask),
        scale: Scale::of_train(train, ask),
        next: 0.0,
        longest: SHARE * TAU / fastest,
        timed: fastest > 0.0 || train.branches.iter().any(timed),
        modes: None,
        since: f64::NEG_INFINITY,
        last: None,
    };
    events::run(train, ask, sink, &mut stepper)
}

/// `s̈ + d ṡ + ω² s = 0` from `s = 0`, `ṡ = 1`: after a stretch ṡ, and s with what it leaves integrated once, twice, thrice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    /// ṡ.
    pub rate: f64,
    /// s, ∫s, ∫∫s, ∫∫∫s.
    pub integrals: [f64; 4],
}

/// Terms of the power series, exact to rounding up to ωτ and dτ of one.
const TERMS: usize = 26;

impl Kernel {
    /// After τ, for ω² of either sign and d.
    pub fn new((square, damping): (f64, f64), tau: f64) -> Kernel {
        let omega = square.abs().sqrt();
        if square > 0.0 && omega * tau >= 1.0 {
            let (even, s) = faded(0.5 * damping, square, tau);
            let rate = even - 0.5 * damping * s;
            let first = (1.0 - rate - damping * s) / square;
            let second = (tau - s - damping * first) / square;
            let third = (0.5 * tau * tau - first - damping * second) / square;
            return Kernel {
                rate,
                integrals: [s, first, second, third],
            };
        }
        let fast = omega.max(damping.abs()) * tau;
        let doublings = fast.log2().ceil().clamp(0.0, 1100.0) as i32;
        let mut length = tau * f64::from(-doublings).exp2();
        let mut kernel = Kernel::series((square, damping), length);
        for _ in 0..doublings {
            kernel = kernel.doubled((square, damping), length);
            length *= 2.0;
        }
        kernel
    }

    /// By its power series: with `cₙ = s⁽ⁿ⁾(0) τⁿ⁻¹` s integrated k times is `Σ cₙ τᵏ⁺¹/(n + k)!`.
    fn series((square, damping): (f64, f64), tau: f64) -> Kernel {
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
        Kernel {
            rate: sum(-1),
            integrals: [0, 1, 2, 3].map(|k| sum(k) * tau.powi(k + 1)),
        }
    }

    /// After twice the time: what was left swings on, and `(τ + u)^k/k!` goes on pushing.
    fn doubled(self, (square, damping): (f64, f64), tau: f64) -> Kernel {
        let [s, first, second, third] = self.integrals;
        let place = self.rate + damping * s;
        let on = |x: f64, v: f64| place * x + s * v;
        Kernel {
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
struct Modes {
    /// Φ, `ΦᵀMΦ = 1`.
    shapes: Matrix,
    /// ΦᵀM.
    back: Matrix,
    /// ω² and d of every mode.
    pairs: Vec<(f64, f64)>,
}

impl Modes {
    fn new(frozen: &Frozen, t: f64, y: &[f64]) -> Result<Modes, Error> {
        let train = frozen.train;
        let n = train.n();
        let (mut k, mut c) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        for (at, b) in train.branches.iter().enumerate() {
            let sums = matches!(
                b.law,
                Law::Linear { .. } | Law::Contact(_) | Law::Nonlinear { .. } | Law::Curve(_)
            );
            if sums && b.force.is_none() {
                let (_, stiffness, damping) = train.force(at, Some(frozen.regime), t, y, 0.0);
                add(&mut k, &b.direction, &b.direction, stiffness);
                add(&mut c, &b.direction, &b.direction, damping);
            }
        }
        let mass = train.mass.matrix();
        let found = definite::pencil(&k, &mass)?;
        let back = found.vectors.transpose() * &mass;
        let shared = found.vectors.transpose() * &c * &found.vectors;
        let pairs = found.values.iter().enumerate();
        Ok(Modes {
            pairs: pairs
                .map(|(r, square)| (*square, shared[(r, r)] + train.drag))
                .collect(),
            back,
            shapes: found.vectors,
        })
    }

    fn through(matrix: &Matrix, y: &[f64]) -> Vec<f64> {
        let n = matrix.nrows();
        let part = |from: usize| {
            move |i: usize| -> f64 { (0..n).map(|j| matrix[(i, j)] * y[from + j]).sum() }
        };
        (0..n).map(part(0)).chain((0..n).map(part(n))).collect()
    }

    /// N at a modal state.
    fn forcing(&self, problem: &Frozen, t: f64, x: &[f64], effort: &mut Effort) -> Vec<f64> {
        let n = self.pairs.len();
        let mut slope = vec![0.0; 2 * n];
        problem.slope(t, &Modes::through(&self.shapes, x), &mut slope);
        effort.evaluations += 1;
        let mode = |(r, (square, damping)): (usize, &(f64, f64))| {
            let pushed: f64 = (0..n).map(|j| self.back[(r, j)] * slope[n + j]).sum();
            pushed + square * x[r] + damping * x[n + r]
        };
        self.pairs.iter().enumerate().map(mode).collect()
    }

    fn kernels(&self, tau: f64) -> Vec<Kernel> {
        let pairs = self.pairs.iter();
        pairs.map(|&pair| Kernel::new(pair, tau)).collect()
    }

    /// From `x`, pushed by nothing.
    fn free(&self, kernels: &[Kernel], x: &[f64]) -> Vec<f64> {
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
fn push(x: &mut [f64], kernels: &[Kernel], (k, tau): (usize, f64), a: f64, w: &[f64]) {
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
struct Stepped {
    whole: Vec<Kernel>,
    end: Vec<f64>,
    error: Vec<f64>,
    forcing: [Vec<f64>; 3],
}

impl Modes {
    /// A step of length h from a modal state, with N there.
    fn step(
        &self,
        problem: &Frozen,
        clock: impl Fn(f64) -> f64,
        (t, x): (f64, &[f64]),
        h: f64,
        first: &[f64],
        effort: &mut Effort,
    ) -> Stepped {
        let half = 0.5 * h;
        let (whole, halves) = (self.kernels(h), self.kernels(half));
        let mut at = |c: f64, state: &[f64]| self.forcing(problem, clock(t + c * h), state, effort);
        // h φ_k over half a step is twice half of it.
        let (to_half, to_end) = (self.free(&halves, x), self.free(&whole, x));
        let mut two = to_half.clone();
        push(&mut two, &halves, (1, half), 1.0, first);
        let second = at(0.5, &two);
        let mut three = two;
        push(
            &mut three,
            &halves,
            (2, half),
            2.0,
            &sum(&[(1.0, &second), (-1.0, first)]),
        );
        let third = at(0.5, &three);
        let both = sum(&[(1.0, &second), (1.0, &third)]);
        let mut four = to_end.clone();
        push(&mut four, &whole, (1, h), 1.0, first);
        push(
            &mut four,
            &whole,
            (2, h),
            1.0,
            &sum(&[(1.0, &both), (-2.0, first)]),
        );
        let fourth = at(1.0, &four);
        // a₅₂ = ½ φ₂(½) − φ₃ + ¼ φ₂ − ½ φ₃(½), of w₂ + w₃ − w₁ − w₄; beside it ½ φ₁(½) w₁ + ¼ φ₂(½) (w₄ − w₁).
        let mixed = sum(&[(1.0, &both), (-1.0, first), (-1.0, &fourth)]);
        let mut five = to_half;
        push(&mut five, &halves, (1, half), 1.0, first);
        push(
            &mut five,
            &halves,
            (2, half),
            0.5,
            &sum(&[(1.0, &fourth), (-1.0, first)]),
        );
        push(&mut five, &halves, (2, half), 1.0, &mixed);
        push(&mut five, &halves, (3, half), -1.0, &mixed);
        push(&mut five, &whole, (2, h), 0.25, &mixed);
        push(&mut five, &whole, (3, h), -1.0, &mixed);
        let fifth = at(0.5, &five);
        let slope = sum(&[(-3.0, first), (-1.0, &fourth), (4.0, &fifth)]);
        let bend = sum(&[(4.0, first), (4.0, &fourth), (-8.0, &fifth)]);
        let mut end = to_end;
        push(&mut end, &whole, (1, h), 1.0, first);
        push(&mut end, &whole, (2, h), 1.0, &slope);
        push(&mut end, &whole, (3, h), 1.0, &bend);
        let apart = sum(&[(1.0, &fifth), (-1.0, &third)]);
        let mut error = vec![0.0; x.len()];
        push(&mut error, &whole, (2, h), 4.0, &apart);
        push(&mut error, &whole, (3, h), -8.0, &apart);
        Stepped {
            whole,
            end,
            error,
            forcing: [first.to_vec(), slope, bend],
        }
    }

    /// What a step may be wrong by because its forcing, a parabola through three instants, is none: with r the difference a quarter
    /// of the step on, a cubic that vanishes at the three has `⅔|r|` for the mean of its size.
    fn missed(
        &self,
        problem: &Frozen,
        clock: impl Fn(f64) -> f64,
        (t, x): (f64, &[f64]),
        h: f64,
        stepped: &Stepped,
        effort: &mut Effort,
    ) -> Vec<f64> {
        const ON: f64 = 0.25;
        let state = self.along(x, h, &stepped.forcing, ON);
        let there = self.forcing(problem, clock(t + ON * h), &state, effort);
        let [first, slope, bend] = &stepped.forcing;
        let r = sum(&[
            (1.0, &there),
            (-1.0, first),
            (-ON, slope),
            (-0.5 * ON * ON, bend),
        ]);
        let mut error = vec![0.0; x.len()];
        push(&mut error, &stepped.whole, (1, h), 2.0 / 3.0, &r);
        error
    }

    /// The modal state at a share of a step from x, under its forcing.
    fn along(&self, x: &[f64], h: f64, forcing: &[Vec<f64>; 3], theta: f64) -> Vec<f64> {
        let tau = theta * h;
        let kernels = self.kernels(tau);
        let mut state = self.free(&kernels, x);
        for (k, w) in forcing.iter().enumerate() {
            // t^k/(h^k k!) pushes over θ h.
            push(&mut state, &kernels, (k + 1, tau), theta.powi(k as i32), w);
        }
        state
    }
}

/// The method between two steps.
pub struct Exponential {
    control: Control,
    scale: Scale,
    /// The step to try next, s; zero where none is known.
    next: f64,
    /// The longest step that follows what drives, s; by its tolerance it takes none that is longer.
    longest: f64,
    /// Forces change with time itself, other than along lines.
    timed: bool,
    /// Of the present regime; absent after a restart.
    modes: Option<Modes>,
    since: f64,
    /// The last step: its length, its modal start, its forcing.
    last: Option<(f64, Vec<f64>, [Vec<f64>; 3])>,
}

impl Exponential {
    /// A first step: a hundredth of the time in which what is not linear would move the state, s.
    fn first(&self, y: &[f64], forcing: &[f64], left: f64) -> f64 {
        let sizes = self.scale.sizes(y, y, 1e-3 * left);
        let pushed: Vec<f64> = forcing.iter().chain(forcing).copied().collect();
        let sensible = 0.01 * norm(y, &sizes) / norm(&pushed, &sizes);
        match sensible > 0.0 && sensible.is_finite() {
            true => sensible.clamp(1e-8 * left, 1e-2 * left),
            false => 1e-4 * left,
        }
    }
}

impl<'f> Stepper<Frozen<'f>> for Exponential {
    fn restart(&mut self) {
        self.modes = None;
    }

    fn step(
        &mut self,
        problem: &Frozen<'f>,
        (t, y): (f64, &[f64]),
        end: f64,
        effort: &mut Effort,
    ) -> Result<(f64, Vec<f64>), Error> {
        let modes = match self.modes.take() {
            Some(modes) => modes,
            None => {
                self.since = t;
                effort.machines += 1;
                Modes::new(problem, t, y)?
            }
        };
        let since = self.since;
        let clock = move |t: f64| inside(t, since, end);
        self.scale.note(y);
        let x = Modes::through(&modes.back, y);
        let first = modes.forcing(problem, clock(t), &x, effort);
        let left = end - t;
        let wanted = match self.control {
            Control::Fixed(h) => equal_part(left, h),
            Control::Tolerance(_) if self.next > 0.0 => self.next.min(self.longest),
            Control::Tolerance(_) => self.first(y, &first, left).min(self.longest),
        };
        let mut h = wanted.min(left);
        let mut refused = false;
        loop {
            if !(h > 4.0 * f64::EPSILON * t.abs() && h > 0.0) && h < left {
                return Err(Error::new(
                    Code::NoConvergence,
                    format!("no step from t = {} keeps the error within the tolerance", instant(t)),
                )
                .hint("what is not linear is stiff or jumps there: take radau5, or a coarser tolerance"));
            }
            let stepped = modes.step(problem, clock, (t, &x), h, &first, effort);
            let reached = Modes::through(&modes.shapes, &stepped.end);
            let error = match self.control {
                Control::Fixed(_) => 0.0,
                Control::Tolerance(tolerance) => {
                    let sizes = self.scale.sizes(y, &reached, h);
                    let size = |modal: &[f64]| norm(&Modes::through(&modes.shapes, modal), &sizes);
                    let missed = match self.timed {
                        true => size(&modes.missed(problem, clock, (t, &x), h, &stepped, effort)),
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
                self.scale.note(&reached);
                self.last = Some((h, x, stepped.forcing));
                self.modes = Some(modes);
                return Ok((u, reached));
            }
            effort.rejected += 1;
            refused = true;
            h *= match error.is_finite() {
                true => factor.clamp(0.1, 0.9),
                false => 0.1,
            };
        }
    }

    fn inside(&self, theta: f64, y: &mut [f64]) {
        let (Some(modes), Some((h, x, forcing))) = (&self.modes, &self.last) else {
            return;
        };
        if theta * h == 0.0 {
            y.copy_from_slice(&Modes::through(&modes.shapes, x));
            return;
        }
        let state = modes.along(x, *h, forcing, theta);
        y.copy_from_slice(&Modes::through(&modes.shapes, &state));
    }
}
