//! What a linear machine does by itself, in parts that do not act on each other, each known in closed form.

use super::dense::{Dense, DenseRun};
use super::phi;
use crate::numeric::Complex;

/// The parts. Their states σ stand one after the other: two of every swing, then those of the others.
#[derive(Debug, Clone, Default)]
pub struct Spectrum {
    /// λ with Im λ > 0: `ζ̇ = λ ζ + β`, σ = (Re ζ, Im ζ).
    pub swings: Vec<Complex>,
    /// The rest.
    pub others: Vec<Other>,
}

/// A part that does not swing, or cannot be told from the others.
#[derive(Debug, Clone)]
pub enum Other {
    /// `ẋ = λ x + β`.
    Decay(f64),
    /// `ṗ = v`, `v̇ = λ v + β`; σ = (p, v). Rigid motions, braked or not.
    Coast(f64),
    /// `η̈ + d η̇ + w² η = β` with d near 2w, where two exponentials would cancel; σ = (η, η̇).
    Critical {
        /// 1/s.
        d: f64,
        /// 1/s².
        square: f64,
    },
    /// All states at once, by matrix exponentials: where eigenvectors nearly coincide.
    Dense(Box<Dense>),
}

impl Other {
    /// How many states it has.
    pub fn count(&self) -> usize {
        match self {
            Other::Decay(_) => 1,
            Other::Coast(_) | Other::Critical { .. } => 2,
            Other::Dense(dense) => dense.count(),
        }
    }
}

/// A harmonic so near a root that their responses must not be taken apart.
#[derive(Debug, Clone)]
pub struct Resonance {
    /// Which swing, or which of the others.
    pub part: Part,
    /// Which harmonic, by its place in the list of frequencies.
    pub frequency: usize,
    /// ω, rad/s.
    pub omega: f64,
    /// The push on ζ per `e^{iωt}`; for a coast on v, the real part counting.
    pub push: Complex,
}

/// A part by its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// Of the swings.
    Swing(usize),
    /// Of the others: its number and its first state.
    Other(usize, usize),
}

/// What a harmonic leaves behind for good.
#[derive(Debug, Clone)]
pub struct Steady {
    /// Phasors of σ.
    pub answer: Vec<Complex>,
    /// Phasors of the push on σ that is not in the answer.
    pub left: Vec<Complex>,
    /// Where that goes.
    pub near: Vec<Resonance>,
}

/// Motion of the parts from given states under `β₀ + β₁ τ` and resonances.
#[derive(Debug, Clone, Default)]
pub struct Run {
    swings: Vec<SwingRun>,
    others: Vec<OtherRun>,
    /// `push · e^{iωt₀}` of every resonance.
    pushes: Vec<Complex>,
    /// Bounds on |σ̈| at τ = 0, fading as `fade` says: of every swing |ζ̈|, then of every other state.
    pub bounds: Vec<f64>,
    /// Bounds on what resonances add to |σ̈|, which do not fade.
    pub lasting: Vec<f64>,
    /// Bounds on |σ|, in the same order.
    pub sizes: Vec<f64>,
}

/// `ζ = still + drift τ + moving e^{λτ}`, or by series for small λτ.
#[derive(Debug, Clone)]
struct SwingRun {
    still: Complex,
    drift: Complex,
    moving: Complex,
    start: Complex,
    rate: Complex,
    ramp: Complex,
    /// |λτ| below one half means τ below this.
    small: f64,
}

#[derive(Debug, Clone)]
enum OtherRun {
    Decay {
        lambda: f64,
        start: f64,
        push: [f64; 2],
    },
    Coast {
        lambda: f64,
        start: [f64; 2],
        push: [f64; 2],
    },
    Critical {
        half: f64,
        square: f64,
        start: [f64; 2],
        still: [f64; 2],
    },
    Dense(DenseRun),
}

impl Spectrum {
    /// How many states there are.
    pub fn count(&self) -> usize {
        2 * self.swings.len() + self.others.iter().map(Other::count).sum::<usize>()
    }

    /// The fastest growth of a part, 1/s; zero where none grows.
    pub fn growth(&self) -> f64 {
        let swings = self.swings.iter().map(|l| l.re);
        let others = self.others.iter().map(|other| match other {
            Other::Decay(lambda) | Other::Coast(lambda) => *lambda,
            Other::Critical { d, .. } => -d,
            Other::Dense(dense) => dense.growth(),
        });
        swings.chain(others).fold(0.0, f64::max)
    }

    /// The largest angle that a swing turns through while there is something left of it, within `span` seconds, rad.
    pub fn turned(&self, span: f64) -> f64 {
        const GONE: f64 = 36.0; // e⁻³⁶ is below rounding
        let angle = |l: &Complex| match l.re < 0.0 {
            true => l.im * span.min(GONE / -l.re),
            false => l.im * span,
        };
        self.swings.iter().map(angle).fold(0.0, f64::max)
    }

    /// `Λ` applied to the left: the row c Λ.
    pub fn rate_of(&self, c: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; c.len()];
        for (k, l) in self.swings.iter().enumerate() {
            out[2 * k] = c[2 * k] * l.re + c[2 * k + 1] * l.im;
            out[2 * k + 1] = c[2 * k + 1] * l.re - c[2 * k] * l.im;
        }
        let mut at = 2 * self.swings.len();
        for other in &self.others {
            match other {
                Other::Decay(lambda) => out[at] = c[at] * lambda,
                Other::Coast(lambda) => out[at + 1] = c[at] + c[at + 1] * lambda,
                Other::Critical { d, square } => {
                    out[at] = -square * c[at + 1];
                    out[at + 1] = c[at] - d * c[at + 1];
                }
                Other::Dense(dense) => dense.rate_of(&c[at..], &mut out[at..]),
            }
            at += other.count();
        }
        out
    }

    /// `|c|` in the order of [`Run::bounds`].
    pub fn sizes_of(&self, c: &[f64]) -> Vec<f64> {
        let two = 2 * self.swings.len();
        let swings = c[..two].chunks_exact(2).map(|c| c[0].hypot(c[1]));
        swings.chain(c[two..].iter().map(|c| c.abs())).collect()
    }

    /// The steady answer to `Re(b e^{iωt})`; pushes too near a root are left out. `span` is the length of the run, s.
    pub fn steady(&self, b: &[Complex], (frequency, omega): (usize, f64), span: f64) -> Steady {
        let i = Complex::new(0.0, 1.0);
        let s = i * omega;
        let mut out = vec![Complex::ZERO; b.len()];
        let mut left = out.clone();
        let mut near = Vec::new();
        for (k, &lambda) in self.swings.iter().enumerate() {
            let (x, y) = (b[2 * k], b[2 * k + 1]);
            // β(t) = P e^{iωt} + Q e^{−iωt}
            let p = (x + i * y) * 0.5;
            let q = (x.conj() + i * y.conj()) * 0.5;
            let mut turn = |push: Complex, signed: f64| {
                let kappa = i * signed - lambda;
                if push == Complex::ZERO {
                    return Complex::ZERO;
                }
                if kappa.norm() < NEAR * lambda.norm() {
                    let (real, imaginary) = match signed == omega {
                        true => (push, -i * push),
                        false => (push.conj(), i * push.conj()),
                    };
                    left[2 * k] += real;
                    left[2 * k + 1] += imaginary;
                    near.push(Resonance {
                        part: Part::Swing(k),
                        frequency,
                        omega: signed,
                        push,
                    });
                    return Complex::ZERO;
                }
                push / kappa
            };
            let forward = turn(p, omega);
            let backward = turn(q, -omega).conj();
            out[2 * k] = forward + backward;
            out[2 * k + 1] = (forward - backward) * -i;
        }
        let mut at = 2 * self.swings.len();
        for (number, other) in self.others.iter().enumerate() {
            let mut slow = |state: usize| {
                left[state] = b[state];
                near.push(Resonance {
                    part: Part::Other(number, at),
                    frequency,
                    omega,
                    push: b[state],
                });
            };
            match other {
                Other::Decay(lambda) if omega.abs().max(lambda.abs()) * span < 1.0 => slow(at),
                Other::Decay(lambda) => out[at] = b[at] / (s - lambda),
                Other::Coast(_) if omega.abs() * span < 1.0 => slow(at + 1),
                Other::Coast(lambda) => {
                    out[at + 1] = b[at + 1] / (s - lambda);
                    out[at] = out[at + 1] / s;
                }
                Other::Critical { d, square } => {
                    out[at] = b[at + 1] / (s * s + s * d + square);
                    out[at + 1] = out[at] * s;
                }
                // It knows its harmonics itself.
                Other::Dense(dense) => {
                    left[at..at + dense.count()].copy_from_slice(&b[at..at + dense.count()])
                }
            }
            at += other.count();
        }
        Steady {
            answer: out,
            left,
            near,
        }
    }

    /// Starts the motion: σ₀ without the steady answers, `β₀`, `β₁`; `turns` holds `e^{iωt₀}` of every frequency,
    /// `span` the time it will be used for, s.
    #[allow(clippy::too_many_arguments)]
    pub fn start(
        &self,
        run: &mut Run,
        sigma: &[f64],
        (b0, b1): (&[f64], &[f64]),
        resonances: &[Resonance],
        turns: &[Complex],
        span: f64,
    ) {
        run.swings.clear();
        run.others.clear();
        run.bounds.clear();
        run.sizes.clear();
        for (k, &lambda) in self.swings.iter().enumerate() {
            let pair = |v: &[f64]| Complex::new(v[2 * k], v[2 * k + 1]);
            let (start, push, ramp) = (pair(sigma), pair(b0), pair(b1));
            let rate = lambda * start + push;
            let inverse = lambda.inv();
            let mut moving = rate * inverse;
            let mut drift = Complex::ZERO;
            if ramp != Complex::ZERO {
                drift = -(ramp * inverse);
                moving -= drift * inverse;
            }
            let still = start - moving;
            run.bounds.push(size_of(lambda * rate + ramp));
            run.sizes
                .push(size_of(still) + size_of(moving) + size_of(drift) * span);
            run.swings.push(SwingRun {
                still,
                drift,
                moving,
                start,
                rate,
                ramp,
                small: phi::SMALL / size_of(lambda),
            });
        }
        let mut at = 2 * self.swings.len();
        for other in &self.others {
            match other {
                Other::Decay(lambda) => {
                    let rate = lambda * sigma[at] + b0[at];
                    run.bounds.push((lambda * rate + b1[at]).abs());
                    run.sizes.push(sigma[at].abs() + (b0[at] * span).abs());
                    run.others.push(OtherRun::Decay {
                        lambda: *lambda,
                        start: sigma[at],
                        push: [b0[at], b1[at]],
                    });
                }
                Other::Coast(lambda) => {
                    let (push, ramp) = (b0[at + 1], b1[at + 1]);
                    let rate = lambda * sigma[at + 1] + push;
                    // v̇ is monotone: its largest value is at an end.
                    let last = match *lambda > 0.0 {
                        true => rate.abs() + (ramp * span).abs(),
                        false => {
                            let [e, f1, ..] = phi::real(*lambda, span);
                            (rate * e + ramp * f1).abs()
                        }
                    };
                    run.bounds
                        .extend([rate.abs().max(last), (lambda * rate + ramp).abs()]);
                    run.sizes
                        .extend([sigma[at].abs(), sigma[at + 1].abs() + push.abs() * span]);
                    run.others.push(OtherRun::Coast {
                        lambda: *lambda,
                        start: [sigma[at], sigma[at + 1]],
                        push: [push, ramp],
                    });
                }
                Other::Critical { d, square } => {
                    let slope = b1[at + 1] / square;
                    let still = [(b0[at + 1] - d * slope) / square, slope];
                    let start = [sigma[at] - still[0], sigma[at + 1] - slope];
                    let w = square.sqrt();
                    let energy = (w * start[0]).hypot(start[1]);
                    let fast = d.abs() + w;
                    run.bounds.extend([fast * energy, fast * fast * energy]);
                    run.sizes.extend([
                        energy / w + still[0].abs() + (slope * span).abs(),
                        energy + slope.abs(),
                    ]);
                    run.others.push(OtherRun::Critical {
                        half: 0.5 * d,
                        square: *square,
                        start,
                        still,
                    });
                }
                Other::Dense(dense) => {
                    let started = dense.start((&sigma[at..], &b0[at..], &b1[at..]), turns, span);
                    run.bounds.extend(started.bounds());
                    run.sizes.extend(started.sizes());
                    run.others.push(OtherRun::Dense(started));
                }
            }
            at += other.count();
        }
        run.pushes.clear();
        run.lasting.clear();
        run.lasting.resize(run.bounds.len(), 0.0);
        for near in resonances {
            let turn = turns[near.frequency];
            let turn = if near.omega < 0.0 && matches!(near.part, Part::Swing(_)) {
                turn.conj()
            } else {
                turn
            };
            let push = near.push * turn;
            run.pushes.push(push);
            let (size, omega) = (push.norm(), near.omega.abs());
            match near.part {
                Part::Swing(k) => {
                    let lambda = self.swings[k];
                    let kappa = Complex::new(-lambda.re, near.omega - lambda.im).norm();
                    let longest = span.min(2.0 / kappa);
                    run.lasting[k] += size * (omega + lambda.norm() + lambda.norm_sqr() * longest);
                    run.sizes[k] += size * longest;
                }
                Part::Other(number, at) => {
                    let place = at - self.swings.len();
                    match self.others[number] {
                        Other::Decay(l) => {
                            run.lasting[place] += size * (2.0 * l.abs() + omega);
                        }
                        Other::Coast(l) => {
                            run.lasting[place] += 2.0 * size;
                            run.lasting[place + 1] += size * (2.0 * l.abs() + omega);
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// σ after τ; `fade` learns how much is left of every swing, one where that was not needed.
    pub fn at(
        &self,
        run: &Run,
        resonances: &[Resonance],
        tau: f64,
        sigma: &mut [f64],
        fade: &mut [f64],
    ) {
        let mut decay = Decay::default();
        let parts = self.swings.iter().zip(&run.swings);
        let places = sigma.chunks_exact_mut(2).zip(fade);
        for ((&lambda, part), (out, fade)) in parts.zip(places) {
            let zeta = if tau < part.small {
                *fade = 1.0;
                part.beginning(lambda, tau)
            } else {
                *fade = decay.after(lambda.re, tau);
                part.still + part.drift * tau + turn(lambda, tau, *fade) * part.moving
            };
            out[0] = zeta.re;
            out[1] = zeta.im;
        }
        self.others_at(run, tau, sigma);
        if !resonances.is_empty() {
            self.resound(run, resonances, tau, sigma);
        }
    }

    /// Prepares equal strides of h: `e^{λh}` of every swing.
    pub fn stride(&self, h: f64, strides: &mut Strides) {
        let mut decay = Decay::default();
        strides.turns.clear();
        let turns = self.swings.iter();
        let turns = turns.map(|&lambda| turn(lambda, h, decay.after(lambda.re, h)));
        strides.turns.extend(turns);
        strides.left = 0;
    }

    /// σ after τ, one stride after the last time it was asked for: every swing is turned on, and set anew now and then.
    pub fn after_stride(
        &self,
        run: &Run,
        resonances: &[Resonance],
        tau: f64,
        sigma: &mut [f64],
        strides: &mut Strides,
    ) {
        if strides.left == 0 {
            let mut decay = Decay::default();
            strides.moving.clear();
            let parts = self.swings.iter().zip(&run.swings);
            let moving = parts.map(|(&l, part)| turn(l, tau, decay.after(l.re, tau)) * part.moving);
            strides.moving.extend(moving);
            strides.left = ANCHORED;
        } else {
            let turns = strides.moving.iter_mut().zip(&strides.turns);
            turns.for_each(|(moving, turn)| *moving *= turn);
        }
        strides.left -= 1;
        let parts = self.swings.iter().zip(&run.swings).zip(&strides.moving);
        for (((&lambda, part), moving), out) in parts.zip(sigma.chunks_exact_mut(2)) {
            let zeta = match tau < part.small {
                true => part.beginning(lambda, tau),
                false => part.still + part.drift * tau + moving,
            };
            out[0] = zeta.re;
            out[1] = zeta.im;
        }
        self.others_at(run, tau, sigma);
        if !resonances.is_empty() {
            self.resound(run, resonances, tau, sigma);
        }
    }

    fn others_at(&self, run: &Run, tau: f64, sigma: &mut [f64]) {
        let mut at = 2 * self.swings.len();
        for (part, other) in run.others.iter().zip(&self.others) {
            match part {
                OtherRun::Decay {
                    lambda,
                    start,
                    push,
                } => {
                    let [e, f1, f2, _] = phi::real(*lambda, tau);
                    sigma[at] = start * e + push[0] * f1 + push[1] * f2;
                }
                OtherRun::Coast {
                    lambda,
                    start,
                    push,
                } => {
                    let [e, f1, f2, f3] = phi::real(*lambda, tau);
                    sigma[at] = start[0] + start[1] * f1 + push[0] * f2 + push[1] * f3;
                    sigma[at + 1] = start[1] * e + push[0] * f1 + push[1] * f2;
                }
                OtherRun::Critical {
                    half,
                    square,
                    start: [y, v],
                    still,
                } => {
                    let (c, s) = faded(*half, *square, tau);
                    sigma[at] = y * c + (v + half * y) * s + still[0] + still[1] * tau;
                    sigma[at + 1] = v * c - (square * y + half * v) * s + still[1];
                }
                OtherRun::Dense(started) => {
                    if let Other::Dense(dense) = other {
                        dense.at(started, tau, &mut sigma[at..at + dense.count()]);
                    }
                }
            }
            at += other.count();
        }
    }

    fn resound(&self, run: &Run, resonances: &[Resonance], tau: f64, sigma: &mut [f64]) {
        for (near, &push) in resonances.iter().zip(&run.pushes) {
            match near.part {
                Part::Swing(k) => {
                    let lambda = self.swings[k];
                    let kappa = Complex::new(-lambda.re, near.omega - lambda.im);
                    let answer = push * (lambda * tau).exp() * phi::first(kappa, tau);
                    sigma[2 * k] += answer.re;
                    sigma[2 * k + 1] += answer.im;
                }
                Part::Other(number, at) => match self.others[number] {
                    Other::Decay(lambda) => {
                        sigma[at] += (push * phi::pushed(lambda, near.omega, tau).0).re;
                    }
                    Other::Coast(lambda) => {
                        let (rate, place) = phi::pushed(lambda, near.omega, tau);
                        sigma[at] += (push * place).re;
                        sigma[at + 1] += (push * rate).re;
                    }
                    _ => {}
                },
            }
        }
    }

    /// How much of [`Run::bounds`] is left from τ on, for `horizon` seconds at most; [`Spectrum::at`] was there.
    pub fn fade(&self, tau: f64, horizon: f64, fade: &mut [f64]) {
        for (out, lambda) in fade.iter_mut().zip(&self.swings) {
            if lambda.re > 0.0 {
                *out = (lambda.re * (tau + horizon)).exp();
            }
        }
        let mut at = self.swings.len();
        for other in &self.others {
            match other {
                Other::Decay(lambda) => fade[at] = faded_bound(*lambda, tau, horizon),
                Other::Coast(lambda) => {
                    let grown = faded_bound(lambda.max(0.0), tau, horizon);
                    fade[at] = grown;
                    fade[at + 1] = faded_bound(*lambda, tau, horizon);
                }
                Other::Critical { d, .. } => {
                    let grown = faded_bound((-d).max(0.0), tau, horizon);
                    fade[at] = grown;
                    fade[at + 1] = grown;
                }
                Other::Dense(dense) => {
                    let grown = faded_bound(dense.growth(), tau, horizon);
                    fade[at..at + dense.count()].fill(grown);
                }
            }
            at += other.count();
        }
    }
}

/// What moves, in equal strides.
#[derive(Debug, Default)]
pub struct Strides {
    /// `e^{λh}`.
    turns: Vec<Complex>,
    /// `moving e^{λτ}`.
    moving: Vec<Complex>,
    /// Strides until it is set anew.
    left: u32,
}

/// After so many strides every swing is set anew, so that its rounding does not add up.
const ANCHORED: u32 = 16;

/// |iω − λ| below this share of |λ| is taken as resonance: apart, a digit would go.
const NEAR: f64 = 0.1;

/// The last exponential taken: modes with the same drag share it.
#[derive(Debug, Clone, Copy)]
struct Decay {
    exponent: f64,
    value: f64,
}

impl Default for Decay {
    fn default() -> Decay {
        Decay {
            exponent: 0.0,
            value: 1.0,
        }
    }
}

impl Decay {
    /// `e^{re τ}`.
    fn after(&mut self, re: f64, tau: f64) -> f64 {
        let exponent = re * tau;
        if exponent != self.exponent {
            self.exponent = exponent;
            self.value = exponent.exp();
        }
        self.value
    }
}

/// `e^{re τ}`, and for what grows the value at the end of the horizon.
fn faded_bound(re: f64, tau: f64, horizon: f64) -> f64 {
    match re {
        0.0 => 1.0,
        re if re > 0.0 => (re * (tau + horizon)).exp(),
        re => (re * tau).exp(),
    }
}

/// `e^{−aτ} cosh √D τ` and `e^{−aτ} sinh √D τ / √D`, `D = a² − w²`.
fn faded(a: f64, square: f64, tau: f64) -> (f64, f64) {
    let d = a * a - square;
    let x = d * tau * tau;
    if x.abs() < 0.01 {
        let e = (-a * tau).exp();
        // Σ xⁿ/(2n)! and Σ xⁿ/(2n+1)!
        let c = 1.0 + x / 2.0 * (1.0 + x / 12.0 * (1.0 + x / 30.0 * (1.0 + x / 56.0)));
        let s = 1.0 + x / 6.0 * (1.0 + x / 20.0 * (1.0 + x / 42.0 * (1.0 + x / 72.0)));
        return (e * c, e * s * tau);
    }
    let root = d.abs().sqrt();
    if d > 0.0 {
        let (slow, fast) = (((root - a) * tau).exp(), ((-root - a) * tau).exp());
        (0.5 * (slow + fast), 0.5 * (slow - fast) / root)
    } else {
        let e = (-a * tau).exp();
        let (s, c) = (root * tau).sin_cos();
        (e * c, e * s / root)
    }
}

impl SwingRun {
    fn beginning(&self, lambda: Complex, tau: f64) -> Complex {
        let (first, second) = phi::small(lambda * tau);
        self.start + (first * self.rate + second * self.ramp * tau) * tau
    }
}

/// `e^{λτ}`, with `decay = e^{Re λ τ}`.
fn turn(lambda: Complex, tau: f64, decay: f64) -> Complex {
    let (s, c) = (lambda.im * tau).sin_cos();
    Complex::new(c * decay, s * decay)
}

/// |z|, or up to a twelfth more.
fn size_of(z: Complex) -> f64 {
    let (re, im) = (z.re.abs(), z.im.abs());
    re.max(im) + (std::f64::consts::SQRT_2 - 1.0) * re.min(im)
}
