//! Modal trajectory in closed form, `ζ̇ = λ ζ + β₀ + β₁ τ`, with resonant forcing.
//!
//! A number that turns obeys `ζ̇ = λ ζ + β`, so that `ζ(τ) = ζ₀ + μ₀ (e^{λτ} − 1)` with `μ₀ = ζ̇₀/λ` under a constant β: nothing
//! cancels, however small λτ is. `μ = μ₀ e^{λτ}` goes on by one product a stride, `ζ̈ = λ² μ`.

use super::dense::DenseTrajectory;
use super::event_evaluator::{EventEvaluator, LANES, SumLanes};
use super::modal_parts::{ModalParts, NonOscillatoryPart, PartIndex, ResonantForcing};
use super::phi;
use crate::numeric::Complex;

/// The parts of a machine and the harmonics it is pushed by, which are numbers that turn as well.
#[derive(Debug)]
pub struct ForcedParts {
    /// λ: iω of every harmonic, then those of the oscillatory modes.
    pub eigenvalues: Vec<Complex>,
    /// Number of these that are harmonics.
    pub known: usize,
    /// 1/λ.
    inverses: Vec<Complex>,
    /// Parts that are not complex modal coordinates.
    pub others: Vec<NonOscillatoryPart>,
    near: Vec<ResonantForcing>,
    /// `iω − λ` of the resonances of oscillations; zero for those of others.
    detunings: Vec<Complex>,
    /// All that bounds say of accelerations is what they are.
    exact_accelerations: bool,
    /// The largest |λ| of what turns.
    fastest: f64,
    /// The fastest growth, 1/s; zero where none grows.
    pub growth: f64,
}

/// A motion; used again for the next, so that nothing is allocated on the way.
#[derive(Debug, Default)]
pub struct ModalTrajectory {
    /// Present state: two states of every complex modal coordinate, then those of the others.
    pub sigma: Vec<f64>,
    /// For how long it has been going, s.
    pub tau: f64,
    start: Vec<Complex>,
    first: Vec<Complex>,
    moving: Vec<Complex>,
    ramps: Vec<RampResponse>,
    others: Vec<NonOscillatoryTrajectory>,
    /// `push · e^{iωt₀}` of every resonance, and where it is.
    pushes: Vec<Complex>,
    ringing: Vec<ResonantResponse>,
    /// Strides since it was set exactly.
    strides: u32,
    /// Bounds on |σ|, part by part: of every number that turns, then of every other state.
    pub sizes: Vec<f64>,
    /// Bounds on what resonances add to |σ̈|, of oscillations to |μ|, in the same order; empty where there are none.
    lasting: Vec<f64>,
}

/// Response of an oscillation to a rising β, in addition to turning: `drift τ`, by series for small λτ.
#[derive(Debug, Clone, Copy)]
struct RampResponse {
    drift: Complex,
    rate: Complex,
    slope: Complex,
    small: f64,
}

/// `e^{iωτ}` and `e^{κτ} − 1`, κ = λ − iω: the response is `push e^{iωτ} (e^{κτ} − 1)/κ`, of factors that do not grow where the oscillation
/// decays.
#[derive(Debug, Clone, Copy)]
struct ResonantResponse {
    turned: Complex,
    beaten: Complex,
}

#[derive(Debug, Clone)]
enum NonOscillatoryTrajectory {
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
        bounds: [f64; 2],
    },
    Dense(DenseTrajectory),
}

/// A stride: `e^{λh} − 1` of everything that turns, `e^{κh} − 1` of every beat.
#[derive(Debug, Clone, Default)]
pub struct Propagator {
    /// h, s.
    pub span: f64,
    turns: Vec<Complex>,
    detunings: Vec<Complex>,
}

/// After so many strides everything is set anew, so that rounding does not add up.
const RESET_INTERVAL: u32 = 16;

impl ForcedParts {
    /// Forced parts of a machine, the harmonics that push it, and those of them that are near a root.
    pub fn new(
        spectrum: ModalParts,
        frequencies: &[f64],
        near: Vec<ResonantForcing>,
    ) -> ForcedParts {
        let growth = spectrum.growth();
        let known = frequencies.iter().map(|&omega| Complex::new(0.0, omega));
        let beats = near.iter().map(|near| match near.part {
            PartIndex::Oscillatory(k) => {
                let lambda = spectrum.oscillatory[k];
                Complex::new(lambda.re, lambda.im - near.omega)
            }
            PartIndex::Other(..) => Complex::ZERO,
        });
        let beats = beats.collect();
        let turning: Vec<Complex> = known.chain(spectrum.oscillatory).collect();
        let plain = |other: &NonOscillatoryPart| {
            matches!(
                other,
                NonOscillatoryPart::Decay(_) | NonOscillatoryPart::RigidMotion(_)
            )
        };
        ForcedParts {
            known: frequencies.len(),
            fastest: turning.iter().map(|l| size_of(*l)).fold(0.0, f64::max),
            inverses: turning.iter().map(|lambda| lambda.inv()).collect(),
            exact_accelerations: near.is_empty() && spectrum.others.iter().all(plain),
            others: spectrum.others,
            eigenvalues: turning,
            near,
            detunings: beats,
            growth,
        }
    }

    /// Whether accelerations are known, not only bounds on them.
    pub fn has_exact_accelerations(&self) -> bool {
        self.exact_accelerations
    }

    /// The largest angle that an oscillation turns through while there is something left of it, within `span` seconds, rad.
    pub fn max_phase(&self, span: f64) -> f64 {
        const DECAYED: f64 = 36.0; // e⁻³⁶ is below rounding
        let angle = |l: &Complex| match l.re < 0.0 {
            true => l.im * span.min(DECAYED / -l.re),
            false => l.im * span,
        };
        self.eigenvalues[self.known..]
            .iter()
            .map(angle)
            .fold(0.0, f64::max)
    }

    /// A time in which nothing turns through more than a radian or decays to less than 1/e, s.
    pub fn time_scale(&self) -> f64 {
        let rates = self.others.iter().map(NonOscillatoryPart::rate);
        1.0 / rates.fold(self.fastest, f64::max)
    }

    /// A stride of h.
    pub fn propagator(&self, h: f64) -> Propagator {
        let mut decay = ExpCache::default();
        let turns = self.eigenvalues.iter();
        Propagator {
            span: h,
            turns: turns.map(|&lambda| decay.exp_m1(lambda, h)).collect(),
            detunings: self
                .detunings
                .iter()
                .map(|&kappa| decay.exp_m1(kappa, h))
                .collect(),
        }
    }

    /// Growth factor that no part exceeds by τ.
    #[inline(never)]
    fn grown(&self, tau: f64) -> f64 {
        (self.growth * tau).exp()
    }

    /// Index of the first state of the others.
    fn first_other(&self) -> usize {
        2 * self.eigenvalues.len()
    }

    /// Whether a harmonic is near a root.
    pub fn is_resonant(&self) -> bool {
        !self.near.is_empty()
    }

    /// Number of complex modal coordinates and other states.
    fn count(&self) -> usize {
        self.eigenvalues.len()
            + self
                .others
                .iter()
                .map(NonOscillatoryPart::count)
                .sum::<usize>()
    }
}

impl ModalTrajectory {
    /// Starts at [`ModalTrajectory::sigma`], whose first numbers hold `e^{iωt₀}` of every harmonic and whose rest is without the
    /// steady-state responses, under `β₀` and `β₁`; `span` is the time it will be used for, s.
    pub fn start(&mut self, parts: &ForcedParts, (b0, b1): (&[f64], &[f64]), span: f64) {
        self.tau = 0.0;
        self.strides = 0;
        self.ramps.clear();
        self.others.clear();
        let turning = 2 * parts.eigenvalues.len();
        let numbers = self.sigma[..turning].as_chunks::<2>().0.iter();
        self.start.clear();
        self.start.extend(numbers.map(|&[x, y]| Complex::new(x, y)));
        let pushes = b0.as_chunks::<2>().0.iter().zip(&parts.inverses);
        let moved = |(start, (&[x, y], inverse)): (&Complex, (&[f64; 2], &Complex))| {
            start + Complex::new(x, y) * inverse
        };
        self.first.clear();
        self.first.extend(self.start.iter().zip(pushes).map(moved));
        let both = self.start.iter().zip(&self.first);
        self.sizes.clear();
        self.sizes
            .extend(both.map(|(start, moving)| size_of(*start) + 2.0 * size_of(*moving)));
        if b1[..turning].iter().any(|slope| *slope != 0.0) {
            self.start_ramps(parts, b1, span);
        }
        self.start_others(parts, (b0, b1), span);
        self.start_resonances(parts, span);
        self.moving.clone_from(&self.first);
    }

    fn start_ramps(&mut self, parts: &ForcedParts, b1: &[f64], span: f64) {
        for (k, slope) in b1.chunks_exact(2).take(parts.eigenvalues.len()).enumerate() {
            let (lambda, inverse) = (parts.eigenvalues[k], parts.inverses[k]);
            let slope = Complex::new(slope[0], slope[1]);
            let drift = -(slope * inverse);
            self.ramps.push(RampResponse {
                drift,
                rate: lambda * self.first[k],
                slope,
                small: phi::SERIES_RADIUS / size_of(lambda),
            });
            let more = drift * inverse;
            self.first[k] -= more;
            self.sizes[k] += 2.0 * size_of(more) + size_of(drift) * span;
        }
    }

    fn start_others(&mut self, parts: &ForcedParts, (b0, b1): (&[f64], &[f64]), span: f64) {
        let mut at = parts.first_other();
        for other in &parts.others {
            let sigma = &self.sigma;
            match other {
                NonOscillatoryPart::Decay(lambda) => {
                    self.sizes.push(sigma[at].abs() + (b0[at] * span).abs());
                    self.others.push(NonOscillatoryTrajectory::Decay {
                        lambda: *lambda,
                        start: sigma[at],
                        push: [b0[at], b1[at]],
                    });
                }
                NonOscillatoryPart::RigidMotion(lambda) => {
                    let (push, ramp) = (b0[at + 1], b1[at + 1]);
                    let fast = sigma[at + 1].abs() + push.abs() * span;
                    self.sizes.extend([sigma[at].abs(), fast]);
                    self.others.push(NonOscillatoryTrajectory::Coast {
                        lambda: *lambda,
                        start: [sigma[at], sigma[at + 1]],
                        push: [push, ramp],
                    });
                }
                NonOscillatoryPart::Critical { d, square } => {
                    let push = [b0[at + 1], b1[at + 1]];
                    self.start_critical((*d, *square), at, push, span);
                }
                NonOscillatoryPart::Dense(dense) => {
                    let turns = self.start[..parts.known].iter();
                    let turns: Vec<Complex> = turns.copied().collect();
                    let started = dense.start((&sigma[at..], &b0[at..], &b1[at..]), &turns, span);
                    self.sizes.extend(started.sizes());
                    self.others.push(NonOscillatoryTrajectory::Dense(started));
                }
            }
            at += other.count();
        }
    }

    #[inline(never)]
    fn start_critical(&mut self, (d, square): (f64, f64), at: usize, push: [f64; 2], span: f64) {
        let slope = push[1] / square;
        let still = [(push[0] - d * slope) / square, slope];
        let start = [self.sigma[at] - still[0], self.sigma[at + 1] - slope];
        let w = square.sqrt();
        let energy = (w * start[0]).hypot(start[1]);
        let fast = d.abs() + w;
        self.sizes.extend([
            energy / w + still[0].abs() + (slope * span).abs(),
            energy + slope.abs(),
        ]);
        self.others.push(NonOscillatoryTrajectory::Critical {
            half: 0.5 * d,
            square,
            start,
            still,
            bounds: [fast * energy, fast * fast * energy],
        });
    }

    fn start_resonances(&mut self, parts: &ForcedParts, span: f64) {
        self.pushes.clear();
        self.ringing.clear();
        self.lasting.clear();
        if parts.near.is_empty() {
            return;
        }
        self.lasting.resize(parts.count(), 0.0);
        for (near, kappa) in parts.near.iter().zip(&parts.detunings) {
            let turn = self.start[near.frequency];
            let turn = match near.part {
                PartIndex::Oscillatory(_) if near.omega < 0.0 => turn.conj(),
                _ => turn,
            };
            let push = near.push * turn;
            self.pushes.push(push);
            self.ringing.push(ResonantResponse {
                turned: Complex::ONE,
                beaten: Complex::ZERO,
            });
            let (size, omega) = (push.norm(), near.omega.abs());
            match near.part {
                PartIndex::Oscillatory(k) => {
                    let lambda = parts.eigenvalues[parts.known + k];
                    let longest = span.min(2.0 / kappa.norm());
                    let fast = omega + lambda.norm() + lambda.norm_sqr() * longest;
                    // As of μ, of which |λ|² makes an acceleration.
                    self.lasting[parts.known + k] += size * fast / lambda.norm_sqr();
                    self.sizes[parts.known + k] += size * longest;
                }
                PartIndex::Other(number, at) => {
                    // Its number among all parts: oscillations count once, not twice.
                    let oscillations = parts.eigenvalues.len() - parts.known;
                    let place = parts.known + at - oscillations;
                    match parts.others[number] {
                        NonOscillatoryPart::Decay(l) => {
                            self.lasting[place] += size * (2.0 * l.abs() + omega)
                        }
                        NonOscillatoryPart::RigidMotion(l) => {
                            self.lasting[place] += 2.0 * size;
                            self.lasting[place + 1] += size * (2.0 * l.abs() + omega);
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// Goes to τ, exactly; the `unseen` others follow by [`ModalTrajectory::update_unseen`].
    pub fn move_to(&mut self, parts: &ForcedParts, unseen: &[bool], tau: f64) {
        self.tau = tau;
        self.strides = 0;
        let mut decay = ExpCache::default();
        let both = self.first.iter().zip(&self.start);
        let each = parts.eigenvalues.iter().zip(both);
        let out = self.moving.iter_mut().zip(self.sigma.chunks_exact_mut(2));
        for ((&lambda, (first, start)), (moving, out)) in each.zip(out) {
            let more = first * decay.exp_m1(lambda, tau);
            *moving = first + more;
            out[0] = start.re + more.re;
            out[1] = start.im + more.im;
        }
        for ((ringing, near), &kappa) in self
            .ringing
            .iter_mut()
            .zip(&parts.near)
            .zip(&parts.detunings)
        {
            if let PartIndex::Oscillatory(_) = near.part {
                ringing.turned = decay.exp_m1(Complex::new(0.0, near.omega), tau) + 1.0;
                ringing.beaten = decay.exp_m1(kappa, tau);
            }
        }
        self.update_forced(parts, unseen);
    }

    /// Goes on by a stride, to τ.
    pub fn propagator(
        &mut self,
        parts: &ForcedParts,
        unseen: &[bool],
        stride: &Propagator,
        tau: f64,
    ) {
        if self.strides == RESET_INTERVAL {
            return self.move_to(parts, unseen, tau);
        }
        self.tau = tau;
        self.strides += 1;
        let out = self.moving.iter_mut().zip(self.sigma.chunks_exact_mut(2));
        for ((moving, out), turn) in out.zip(&stride.turns) {
            let more = *moving * turn;
            *moving += more;
            out[0] += more.re;
            out[1] += more.im;
        }
        let turns = parts.near.iter().zip(&stride.detunings);
        for (ringing, (near, beat)) in self.ringing.iter_mut().zip(turns) {
            if let PartIndex::Oscillatory(_) = near.part {
                let turn = stride.turns[near.frequency];
                let turn = if near.omega < 0.0 { turn.conj() } else { turn };
                ringing.turned += ringing.turned * turn;
                ringing.beaten += *beat + ringing.beaten * beat;
            }
        }
        if !self.ringing.is_empty() {
            // What rings is added to what was there before.
            for (k, out) in self
                .sigma
                .chunks_exact_mut(2)
                .take(self.start.len())
                .enumerate()
            {
                let free = self.start[k] + (self.moving[k] - self.first[k]);
                (out[0], out[1]) = (free.re, free.im);
            }
        }
        self.update_forced(parts, unseen);
    }

    /// Whether no stride has led here.
    pub fn is_exact(&self) -> bool {
        self.strides == 0
    }

    /// Goes on, or back, to a τ so near that a few terms of a series are exact to rounding; false where it is not.
    pub fn shift_to(&mut self, parts: &ForcedParts, unseen: &[bool], tau: f64) -> bool {
        const SHORT: f64 = 0.02; // x⁸/8! is below rounding
        let delta = tau - self.tau;
        let fast = parts.fastest * delta.abs() > SHORT;
        if fast || !parts.exact_accelerations || !self.ramps.is_empty() || !self.is_exact() {
            return false;
        }
        self.tau = tau;
        let out = self
            .moving
            .iter_mut()
            .zip(self.sigma.as_chunks_mut::<2>().0);
        for ((moving, out), lambda) in out.zip(&parts.eigenvalues) {
            let more = *moving * phi::exp_m1(lambda * delta);
            *moving += more;
            out[0] += more.re;
            out[1] += more.im;
        }
        self.others_at(parts, unseen, false);
        true
    }

    /// All that is no product of turns.
    fn update_forced(&mut self, parts: &ForcedParts, unseen: &[bool]) {
        let tau = self.tau;
        for (k, ramp) in self.ramps.iter().enumerate() {
            let zeta = if tau < ramp.small {
                let (first, second) = phi::phi_series(parts.eigenvalues[k] * tau);
                self.start[k] + (first * ramp.rate + second * ramp.slope * tau) * tau
            } else {
                (self.start[k] - self.first[k]) + ramp.drift * tau + self.moving[k]
            };
            (self.sigma[2 * k], self.sigma[2 * k + 1]) = (zeta.re, zeta.im);
        }
        self.others_at(parts, unseen, false);
        for (at, near) in parts.near.iter().enumerate() {
            let push = self.pushes[at];
            match near.part {
                PartIndex::Oscillatory(k) => {
                    let ResonantResponse { turned, beaten } = self.ringing[at];
                    let kappa = parts.detunings[at];
                    let beat = match kappa == Complex::ZERO {
                        true => Complex::new(tau, 0.0),
                        false => beaten / kappa,
                    };
                    let answer = push * turned * beat;
                    let first = 2 * (parts.known + k);
                    self.sigma[first] += answer.re;
                    self.sigma[first + 1] += answer.im;
                }
                PartIndex::Other(number, state) => {
                    let first = 2 * parts.known + state;
                    match parts.others[number] {
                        NonOscillatoryPart::Decay(lambda) => {
                            let rate = phi::forced_response(lambda, near.omega, tau).0;
                            self.sigma[first] += (push * rate).re;
                        }
                        NonOscillatoryPart::RigidMotion(lambda) => {
                            let (rate, place) = phi::forced_response(lambda, near.omega, tau);
                            self.sigma[first] += (push * place).re;
                            self.sigma[first + 1] += (push * rate).re;
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// Brings up those of the others that were left out on the way.
    pub fn update_unseen(&mut self, parts: &ForcedParts, unseen: &[bool]) {
        self.others_at(parts, unseen, true);
    }

    fn others_at(&mut self, parts: &ForcedParts, unseen: &[bool], which: bool) {
        let (tau, sigma) = (self.tau, &mut self.sigma);
        let mut at = parts.first_other();
        for ((part, other), unseen) in self.others.iter().zip(&parts.others).zip(unseen) {
            if *unseen != which {
                at += other.count();
                continue;
            }
            match part {
                NonOscillatoryTrajectory::Decay {
                    lambda,
                    start,
                    push,
                } => {
                    let [e, f1, f2, _] = phi::phi_real(*lambda, tau);
                    sigma[at] = start * e + push[0] * f1 + push[1] * f2;
                }
                NonOscillatoryTrajectory::Coast {
                    lambda,
                    start,
                    push,
                } => {
                    let [e, f1, f2, f3] = phi::phi_real(*lambda, tau);
                    sigma[at] = start[0] + start[1] * f1 + push[0] * f2 + push[1] * f3;
                    sigma[at + 1] = start[1] * e + push[0] * f1 + push[1] * f2;
                }
                NonOscillatoryTrajectory::Critical {
                    half,
                    square,
                    start: [y, v],
                    still,
                    ..
                } => {
                    let (c, s) = phi::damped_pair(*half, *square, tau);
                    sigma[at] = y * c + (v + half * y) * s + still[0] + still[1] * tau;
                    sigma[at + 1] = v * c - (square * y + half * v) * s + still[1];
                }
                NonOscillatoryTrajectory::Dense(started) => {
                    if let NonOscillatoryPart::Dense(dense) = other {
                        dense.state_at(started, tau, &mut sigma[at..at + dense.count()]);
                    }
                }
            }
            at += other.count();
        }
    }

    /// Evaluates the sums of an event function at the present state; bounds hold from there on for `horizon` seconds at most. A number that
    /// turns gives ζ, ζ, μ
    /// and |μ|, any other state x, x, ẍ and bounds on ẍ and x⃛; `unseen` others are left out.
    pub fn evaluate(
        &self,
        parts: &ForcedParts,
        unseen: &[bool],
        horizon: f64,
        EventEvaluator(rows): &EventEvaluator,
    ) -> [f64; LANES] {
        let mut sums = [0.0; LANES];
        let mut count = |SumLanes(row): &SumLanes, lane: [f64; LANES]| {
            for at in 0..LANES {
                sums[at] += row[at] * lane[at];
            }
        };
        let (turning, rest) = rows.split_at(self.moving.len());
        let numbers = self.moving.iter().zip(self.sigma.as_chunks::<2>().0);
        for (row, (moving, &[x, y])) in turning.iter().zip(numbers) {
            let size = size_of(*moving);
            count(row, [x, x, y, y, moving.re, moving.im, size, size]);
        }
        let mut rest = rest.iter();
        let mut state = parts.first_other();
        for ((part, other), unseen) in self.others.iter().zip(&parts.others).zip(unseen) {
            if *unseen {
                state += other.count();
                continue;
            }
            let x = &self.sigma[state..];
            let mut lay = |x: f64, bent: f64, bound: f64, change: f64| {
                if let Some(row) = rest.next() {
                    count(row, [x, x, 0.0, 0.0, bent, 0.0, bound, change]);
                }
            };
            match part {
                NonOscillatoryTrajectory::Decay { lambda, push, .. } => {
                    let rate = lambda * x[0] + push[0] + push[1] * self.tau;
                    let bent = lambda * rate + push[1];
                    lay(x[0], bent, bent.abs(), (lambda * bent).abs());
                }
                NonOscillatoryTrajectory::Coast { lambda, push, .. } => {
                    let bent = lambda * x[1] + push[0] + push[1] * self.tau;
                    let change = lambda * bent + push[1];
                    // It goes one way from here on, by no more than this.
                    let last = match *lambda > 0.0 {
                        true => bent.abs() + change.abs() * horizon,
                        false => (bent + change * horizon.min(-1.0 / lambda)).abs(),
                    };
                    lay(x[0], bent, bent.abs().max(last), change.abs());
                    lay(x[1], change, change.abs(), (lambda * change).abs());
                }
                NonOscillatoryTrajectory::Critical { bounds, .. } => {
                    let grown = parts.grown(self.tau);
                    lay(x[0], 0.0, bounds[0] * grown, 0.0);
                    lay(x[1], 0.0, bounds[1] * grown, 0.0);
                }
                NonOscillatoryTrajectory::Dense(started) => {
                    let grown = parts.grown(self.tau);
                    for x in &x[..other.count()] {
                        lay(*x, 0.0, started.acceleration_bound() * grown, 0.0);
                    }
                }
            }
            state += other.count();
        }
        if parts.growth > 0.0 || !self.lasting.is_empty() {
            let (until, grown) = (parts.grown(self.tau), parts.grown(horizon));
            let lasting = rows.iter().zip(&self.lasting);
            sums[6] += lasting
                .map(|(row, more)| row.0[6] * more * until)
                .sum::<f64>();
            sums[6] *= grown;
            sums[7] *= grown;
        }
        sums
    }
}

/// The last exponential taken: parts with the same drag share it.
#[derive(Debug, Default)]
struct ExpCache {
    exponent: f64,
    /// `e^x − 1`.
    expm1: f64,
}

impl ExpCache {
    /// `e^{λτ} − 1`, also where λτ is small: `(e^a − 1) − 2 e^a sin²(b/2) + i e^a sin b`.
    fn exp_m1(&mut self, lambda: Complex, tau: f64) -> Complex {
        let exponent = lambda.re * tau;
        if exponent != self.exponent {
            self.exponent = exponent;
            self.expm1 = exponent.exp_m1();
        }
        let (s, c) = (0.5 * lambda.im * tau).sin_cos();
        let size = 1.0 + self.expm1;
        Complex::new(self.expm1 - 2.0 * s * s * size, 2.0 * s * c * size)
    }
}

/// |z|, or up to a twelfth more.
fn size_of(z: Complex) -> f64 {
    let (re, im) = (z.re.abs(), z.im.abs());
    let (large, small) = if re > im { (re, im) } else { (im, re) };
    large + (std::f64::consts::SQRT_2 - 1.0) * small
}
