//! Exponential Runge–Kutta of order 4: the linear part of a regime exact, what is left of the forces by stages.
//!
//! Between two switches `M q̈ + C q̇ + K q = N(t, q, q̇)`, K and C the tangents where the regime began, C only what modes do not share. In
//! modes of K each stage is the exact answer to a forcing that is a polynomial of time: Krogstad's method (J. Comput. Phys. 203 (2005),
//! pp. 72–88; Hochbruck and Ostermann, Exponential integrators, Acta Numerica 19 (2010), eq. 2.42). The error is estimated of order 3 with the
//! force at the end of the step: `h (4φ₃ − φ₂)(N₄ − N₅)` (Whalen, Brio and Moloney, J. Comput. Phys. 280 (2015)). Inside a step the last
//! polynomial is carried to any instant.

use super::stepping::control;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::events;
use crate::motion::pencil::add;
use crate::motion::problem::{Ask, Effort, Problem, Sink};
use crate::motion::progress::{check, inside};
use crate::motion::scale::{Scale, norm};
use crate::motion::segment::phi;
use crate::motion::stepper::{Control, Stepper, equal_part};
use crate::motion::train::{BranchStand, Frozen, Law, Train};
use crate::numeric::{Matrix, definite};

/// Ways a machine stands whose modes are kept.
const MOST_KEPT: usize = 64;

/// Step lengths whose kernels are kept.
const MOST_LENGTHS: usize = 8;

/// A machine by the exponential method.
///
/// # Errors
/// Those of [`events::run`].
pub fn etdrk4(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    let mut stepper = Exponential::new(control(ask), Scale::of_train(train, ask));
    events::run(train, ask, sink, &mut stepper)
}

/// The method between two steps.
pub struct Exponential {
    control: Control,
    scale: Scale,
    /// The step to try next, s; zero where none is known.
    next: f64,
    /// Modes by the way everything stands.
    kept: Vec<(Vec<BranchStand>, Modes)>,
    /// Which of them hold; none after a restart.
    present: Option<usize>,
    /// The instant and modal state the first forcing belongs to.
    known: Option<(f64, Vec<f64>, Vec<f64>)>,
    last: Option<Last>,
    since: f64,
}

/// Modes of a regime.
struct Modes {
    /// Φ, `ΦᵀMΦ = 1`.
    shapes: Matrix,
    /// ΦᵀM.
    back: Matrix,
    /// Of every mode ω² and what damps it, 1/s.
    pairs: Vec<(f64, f64)>,
    /// Rates of inner states, 1/s.
    inner: Vec<f64>,
    kernels: Vec<Kernels>,
}

/// Answers after a stretch of time.
#[derive(Clone)]
struct Kernels {
    length: f64,
    pairs: Vec<Kernel>,
    inner: Vec<[f64; 4]>,
}

/// `s̈ + d ṡ + ω² s = 0` from `s = 0`, `ṡ = 1`: s and ṡ after a stretch, and s integrated once, twice, thrice.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kernel {
    rate: f64,
    integrals: [f64; 4],
}

/// The last step: its start, its forcing as a polynomial of time.
struct Last {
    at: usize,
    h: f64,
    start: Vec<f64>,
    forcing: [Vec<f64>; 3],
}

impl Kernel {
    /// After τ.
    fn new((square, damping): (f64, f64), tau: f64) -> Kernel {
        let swing = square - 0.25 * damping * damping;
        let omega = square.abs().sqrt();
        if swing > 0.0 && omega * tau >= 1.0 {
            let w = swing.sqrt();
            let decay = (-0.5 * damping * tau).exp();
            let (sin, cos) = (w * tau).sin_cos();
            let s = decay * sin / w;
            let rate = decay * cos - 0.5 * damping * s;
            let first = (1.0 - rate - damping * s) / square;
            let second = (tau - s - damping * first) / square;
            let third = (0.5 * tau * tau - first - damping * second) / square;
            return Kernel {
                rate,
                integrals: [s, first, second, third],
            };
        }
        let doublings = (omega.max(damping.abs()) * tau).log2().ceil().max(0.0) as i32;
        let mut length = tau * f64::from(-doublings).exp2();
        let mut kernel = Kernel::series((square, damping), length);
        for _ in 0..doublings {
            kernel = kernel.doubled((square, damping), length);
            length *= 2.0;
        }
        kernel
    }

    /// By its power series, for ωτ and dτ up to one: 24 terms are exact to rounding.
    fn series((square, damping): (f64, f64), tau: f64) -> Kernel {
        // Terms are the derivatives of s at zero over factorials.
        let mut terms = [0.0; 26];
        terms[1] = 1.0;
        for n in 0..24 {
            terms[n + 2] = -damping * terms[n + 1] - square * terms[n];
        }
        let sum = |lift: usize| {
            // τⁿ⁺ˡ/(n + l)!, from n = 1 on.
            let mut power = (1..=lift + 1).fold(1.0, |p, k| p * tau / k as f64);
            let mut all = 0.0;
            for (n, term) in terms.iter().enumerate().skip(1) {
                all += term * power;
                power *= tau / (n + lift + 1) as f64;
            }
            all
        };
        let mut power = 1.0;
        let mut rate = 0.0;
        for (n, term) in terms.iter().enumerate().skip(1) {
            rate += term * power;
            power *= tau / n as f64;
        }
        Kernel {
            rate,
            integrals: [sum(0), sum(1), sum(2), sum(3)],
        }
    }

    /// After twice the time: `Pₖ(2τ) = e^{τA} Pₖ(τ) + Σ τ^{k−j}/(k−j)! Pⱼ(τ)`.
    fn doubled(self, (square, damping): (f64, f64), tau: f64) -> Kernel {
        let [s, first, second, third] = self.integrals;
        let place = self.rate + damping * s;
        // e^{τA} on a place and its rate; the rate of an integral is the one before it.
        let on = |x: f64, v: f64| place * x + s * v;
        let half = 0.5 * tau * tau;
        Kernel {
            rate: -square * s * s + self.rate * self.rate,
            integrals: [
                on(s, self.rate),
                on(first, s) + first,
                on(second, first) + second + tau * first,
                on(third, second) + third + tau * second + half * first,
            ],
        }
    }
}

impl Modes {
    fn new(frozen: &Frozen, t: f64, y: &[f64]) -> Result<Modes, Error> {
        let train = frozen.train;
        let n = train.n();
        let (mut k, mut c) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        let mut inner = Vec::new();
        for (at, b) in train.branches.iter().enumerate() {
            let (_, stiffness, damping) = match &b.law {
                Law::Linear { .. } | Law::Contact(_) | Law::Nonlinear { .. } | Law::Curve(_)
                    if b.force.is_none() =>
                {
                    train.force(at, Some(frozen.regime), t, y, 0.0)
                }
                Law::Lagged { lag, .. } => {
                    inner.push(-1.0 / lag);
                    continue;
                }
                Law::Maxwell { stiffness, damping } => {
                    inner.push(-stiffness / damping);
                    continue;
                }
                _ => continue,
            };
            add(&mut k, &b.direction, &b.direction, stiffness);
            add(&mut c, &b.direction, &b.direction, damping);
        }
        let mass = Matrix::from_fn(n, n, |i, j| {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            train.momentum(&unit)[i]
        });
        let found = definite::pencil(&k, &mass)?;
        let back = found.vectors.transpose() * &mass;
        let shared = found.vectors.transpose() * &c * &found.vectors;
        let pairs = found.values.iter().enumerate();
        Ok(Modes {
            pairs: pairs
                .map(|(r, x)| (*x, shared[(r, r)] + train.drag))
                .collect(),
            shapes: found.vectors,
            back,
            inner,
            kernels: Vec::new(),
        })
    }

    fn modal(&self, y: &[f64]) -> Vec<f64> {
        self.through(&self.back, y)
    }

    fn physical(&self, x: &[f64]) -> Vec<f64> {
        self.through(&self.shapes, x)
    }

    fn through(&self, matrix: &Matrix, y: &[f64]) -> Vec<f64> {
        let n = matrix.nrows();
        let part = |from: usize| {
            move |i: usize| -> f64 { (0..n).map(|j| matrix[(i, j)] * y[from + j]).sum() }
        };
        let mut all: Vec<f64> = (0..n).map(part(0)).chain((0..n).map(part(n))).collect();
        all.extend_from_slice(&y[2 * n..]);
        all
    }

    /// N at a modal state.
    fn forcing(&self, problem: &Frozen, t: f64, x: &[f64], effort: &mut Effort) -> Vec<f64> {
        let n = self.pairs.len();
        let y = self.physical(x);
        let mut slope = vec![0.0; y.len()];
        problem.slope(t, &y, &mut slope);
        effort.evaluations += 1;
        let mode = |(r, (square, damping)): (usize, &(f64, f64))| {
            let pushed: f64 = (0..n).map(|j| self.back[(r, j)] * slope[n + j]).sum();
            pushed + square * x[r] + damping * x[n + r]
        };
        let inner = self.inner.iter().enumerate();
        let inner = inner.map(|(i, rate)| slope[2 * n + i] - rate * x[2 * n + i]);
        self.pairs
            .iter()
            .enumerate()
            .map(mode)
            .chain(inner)
            .collect()
    }

    /// Answers after `tau`, found once for each length.
    fn kernels(&mut self, tau: f64) -> Kernels {
        if let Some(found) = self.kernels.iter().find(|k| k.length == tau) {
            return found.clone();
        }
        let made = self.fresh(tau);
        if self.kernels.len() == MOST_LENGTHS {
            self.kernels.remove(0);
        }
        self.kernels.push(made.clone());
        made
    }

    fn fresh(&self, tau: f64) -> Kernels {
        Kernels {
            length: tau,
            pairs: self
                .pairs
                .iter()
                .map(|&pair| Kernel::new(pair, tau))
                .collect(),
            inner: self
                .inner
                .iter()
                .map(|&rate| phi::real(rate, tau))
                .collect(),
        }
    }

    /// From `x` under the forcing `Σ wₖ τ^k/k!`, parts of which are absent.
    fn flow(&self, kernels: &Kernels, x: Option<&[f64]>, w: [Option<&[f64]>; 3]) -> Vec<f64> {
        let n = self.pairs.len();
        let mut out = vec![0.0; 2 * n + self.inner.len()];
        for (r, (kernel, (square, damping))) in kernels.pairs.iter().zip(&self.pairs).enumerate() {
            let Kernel { rate, integrals } = kernel;
            if let Some(x) = x {
                let s = integrals[0];
                out[r] = (rate + damping * s) * x[r] + s * x[n + r];
                out[n + r] = rate * x[n + r] - square * s * x[r];
            }
            for (k, w) in w.iter().enumerate() {
                if let Some(w) = w {
                    out[r] += integrals[k + 1] * w[r];
                    out[n + r] += integrals[k] * w[r];
                }
            }
        }
        for (i, kernel) in kernels.inner.iter().enumerate() {
            if let Some(x) = x {
                out[2 * n + i] = kernel[0] * x[2 * n + i];
            }
            for (k, w) in w.iter().enumerate() {
                if let Some(w) = w {
                    out[2 * n + i] += kernel[k + 1] * w[n + i];
                }
            }
        }
        out
    }
}

/// `Σ a x`.
fn sum(terms: &[(f64, &[f64])]) -> Vec<f64> {
    let length = terms.first().map_or(0, |t| t.1.len());
    let at = |i: usize| terms.iter().map(|(a, x)| a * x[i]).sum();
    (0..length).map(at).collect()
}

impl Exponential {
    /// Before the first step.
    pub fn new(control: Control, scale: Scale) -> Exponential {
        Exponential {
            control,
            scale,
            next: 0.0,
            kept: Vec::new(),
            present: None,
            known: None,
            last: None,
            since: f64::NEG_INFINITY,
        }
    }

    /// The modes of the regime, made where it has not been met.
    fn enter(
        &mut self,
        problem: &Frozen,
        t: f64,
        y: &[f64],
        effort: &mut Effort,
    ) -> Result<usize, Error> {
        if let Some(at) = self.present {
            return Ok(at);
        }
        let stands = &problem.regime.stands;
        let at = match self.kept.iter().position(|k| k.0 == *stands) {
            Some(at) => at,
            None => {
                if self.kept.len() == MOST_KEPT {
                    self.kept.remove(0);
                }
                effort.machines += 1;
                let modes = Modes::new(problem, t, y)?;
                self.kept.push((stands.clone(), modes));
                self.kept.len() - 1
            }
        };
        self.present = Some(at);
        Ok(at)
    }

    /// A first step from the sizes of the state and its slope, s.
    fn first(&self, y: &[f64], slope: &[f64], left: f64) -> f64 {
        let sizes = self.scale.sizes(y, y, 1e-3 * left);
        let sensible = 0.01 * norm(y, &sizes) / norm(slope, &sizes);
        match sensible > 0.0 && sensible.is_finite() {
            true => sensible.clamp(1e-10 * left, 1e-2 * left),
            false => 1e-6 * left,
        }
    }
}

impl<'f> Stepper<Frozen<'f>> for Exponential {
    fn restart(&mut self) {
        self.present = None;
        self.known = None;
        self.last = None;
    }

    fn step(
        &mut self,
        problem: &Frozen<'f>,
        (t, y): (f64, &[f64]),
        end: f64,
        effort: &mut Effort,
    ) -> Result<(f64, Vec<f64>), Error> {
        if self.present.is_none() {
            self.since = t;
        }
        let since = self.since;
        let clock = move |t: f64| inside(t, since, end);
        let at = self.enter(problem, clock(t), y, effort)?;
        self.scale.note(y);
        let left = end - t;
        let wanted = match self.control {
            Control::Fixed(h) => equal_part(left, h),
            Control::Tolerance(_) if self.next > 0.0 => self.next,
            Control::Tolerance(_) => {
                let mut slope = vec![0.0; y.len()];
                problem.slope(clock(t), y, &mut slope);
                effort.evaluations += 1;
                self.first(y, &slope, left)
            }
        };
        let modes = &mut self.kept[at].1;
        let x = modes.modal(y);
        let n1 = match self.known.take() {
            Some((u, known, n1)) if u == t && known == y => n1,
            _ => modes.forcing(problem, clock(t), &x, effort),
        };
        let mut h = wanted.min(left);
        let mut refused = false;
        loop {
            if !(h > 4.0 * f64::EPSILON * t.abs() && h > 0.0) && h < left {
                return Err(Error::new(
                    Code::NoConvergence,
                    format!("no step from t = {t:?} s keeps the error within the tolerance"),
                )
                .hint("what is not linear is stiff or jumps there: take radau5, or a coarser tolerance"));
            }
            let (half, whole) = (modes.kernels(0.5 * h), modes.kernels(h));
            let middle = clock(t + 0.5 * h);
            let second = modes.flow(&half, Some(&x), [Some(&n1), None, None]);
            let n2 = modes.forcing(problem, middle, &second, effort);
            let lean = sum(&[(4.0 / h, &n2), (-4.0 / h, &n1)]);
            let third = modes.flow(&half, Some(&x), [Some(&n1), Some(&lean), None]);
            let n3 = modes.forcing(problem, middle, &third, effort);
            let lean = sum(&[(2.0 / h, &n3), (-2.0 / h, &n1)]);
            let fourth = modes.flow(&whole, Some(&x), [Some(&n1), Some(&lean), None]);
            let n4 = modes.forcing(problem, clock(t + h), &fourth, effort);
            let lean = [(-3.0, &n1), (2.0, &n2), (2.0, &n3), (-1.0, &n4)];
            let lean = sum(&lean.map(|(a, n)| (a / h, &n[..])));
            let bend = [(4.0, &n1), (-4.0, &n2), (-4.0, &n3), (4.0, &n4)];
            let bend = sum(&bend.map(|(a, n)| (a / (h * h), &n[..])));
            let end_x = modes.flow(&whole, Some(&x), [Some(&n1), Some(&lean), Some(&bend)]);
            let reached = modes.physical(&end_x);
            let n5 = modes.forcing(problem, clock(t + h), &end_x, effort);
            let error = match self.control {
                Control::Fixed(_) => 0.0,
                Control::Tolerance(tolerance) => {
                    let off = sum(&[(1.0, &n4), (-1.0, &n5)]);
                    let lean = sum(&[(-1.0 / h, &off)]);
                    let bend = sum(&[(4.0 / (h * h), &off)]);
                    let error = modes.flow(&whole, None, [None, Some(&lean), Some(&bend)]);
                    let sizes = self.scale.sizes(y, &reached, h);
                    norm(&modes.physical(&error), &sizes) / tolerance
                }
            };
            let factor = 0.9 * error.powf(-0.25);
            if error < 1.0 {
                let u = if h == left { end } else { t + h };
                // Few lengths, so that their kernels are found again.
                let grown = h * factor.clamp(0.3, if refused { 1.0 } else { 4.0 });
                let grown = if (h..1.3 * h).contains(&grown) {
                    h
                } else {
                    grown
                };
                self.next = match h == left {
                    true => grown.max(self.next),
                    false => grown,
                };
                self.scale.note(&reached);
                self.known = Some((u, reached.clone(), n5));
                self.last = Some(Last {
                    at,
                    h,
                    start: x,
                    forcing: [n1, lean, bend],
                });
                return Ok((u, reached));
            }
            effort.rejected += 1;
            refused = true;
            h *= match error.is_finite() {
                true => factor.clamp(0.1, 0.9),
                false => 0.1,
            };
            self.next = h;
        }
    }

    fn inside(&self, theta: f64, y: &mut [f64]) {
        let Some(last) = &self.last else { return };
        let modes = &self.kept[last.at].1;
        let kernels = modes.fresh(theta * last.h);
        let forcing = last.forcing.each_ref().map(|w| Some(&w[..]));
        y.copy_from_slice(&modes.physical(&modes.flow(&kernels, Some(&last.start), forcing)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed form and the doubled series agree where they meet, and with what is known of single cases.
    #[test]
    fn law_kernels_meet() {
        for (square, damping) in [(4.0, 0.1), (4.0, 3.99), (9.0, 0.0)] {
            let tau = 1.0 / f64::sqrt(square);
            let near = Kernel::new((square, damping), tau * (1.0 - 1e-9));
            let far = Kernel::new((square, damping), tau * (1.0 + 1e-9));
            for (a, b) in near.integrals.iter().zip(far.integrals) {
                assert!((a - b).abs() < 1e-7 * a.abs(), "{a} {b}");
            }
        }
        // A free mass; one that is braked; a strongly overdamped one, against the sum of two exponentials.
        let free = Kernel::new((0.0, 0.0), 3.0);
        assert_eq!(free.integrals, [3.0, 4.5, 4.5, 27.0 / 8.0]);
        let braked = Kernel::new((0.0, 2.0), 5.0);
        assert!((braked.integrals[0] - 0.5 * (1.0 - f64::exp(-10.0))).abs() < 1e-15);
        assert!((braked.integrals[1] - 0.5 * (5.0 - braked.integrals[0])).abs() < 1e-14);
        let (a, b) = (-1.0, -999.0);
        let stiff = Kernel::new((999.0, 1000.0), 2.0);
        let exact = (f64::exp(2.0 * a) - f64::exp(2.0 * b)) / (a - b);
        assert!((stiff.integrals[0] - exact).abs() < 1e-13 * exact);
        assert!((stiff.rate - a * exact).abs() < 1e-13);
    }
}
