//! Modal trajectory in closed form, `ζ̇ = λ ζ + β₀ + β₁ τ`, with resonant forcing.
//!
//! A complex modal coordinate obeys `ζ̇ = λ ζ + β`. A constant β gives `ζ(τ) = ζ₀ + μ₀ (e^{λτ} − 1)` with `μ₀ = ζ̇₀/λ`, without
//! cancellation for any λτ. `μ = μ₀ e^{λτ}` advances by one product per step; `ζ̈ = λ² μ`.

use super::dense::DenseTrajectory;
use super::event_evaluator::{EventEvaluator, LANES, SumLanes};
use super::modal_parts::{ModalParts, NonOscillatoryPart, PartIndex, ResonantForcing};
use super::phi;
use crate::numeric::Complex;

/// Modal parts of a linear system and its harmonics, which are complex coordinates with λ = iω.
#[derive(Debug)]
pub struct ForcedParts {
    /// Eigenvalues λ, 1/s: iω of every harmonic, then those of the oscillatory modes.
    pub eigenvalues: Vec<Complex>,
    /// Number of harmonics among the eigenvalues.
    pub known: usize,
    /// 1/λ, s.
    inverses: Vec<Complex>,
    /// Non-oscillatory modal parts.
    pub others: Vec<NonOscillatoryPart>,
    near: Vec<ResonantForcing>,
    /// Detuning κ = λ − iω of every near-resonant forcing, 1/s; zero for non-oscillatory parts.
    detunings: Vec<Complex>,
    /// Accelerations are exact rather than bounded.
    exact_accelerations: bool,
    /// Largest |λ| of the complex coordinates, 1/s.
    fastest: f64,
    /// Largest growth rate of any part, 1/s; zero if none grows.
    pub growth: f64,
}

/// Modal trajectory over one segment; reused for the next segment to avoid allocation.
#[derive(Debug, Default)]
pub struct ModalTrajectory {
    /// Present modal state: two states of every complex coordinate, then those of the other parts.
    pub sigma: Vec<f64>,
    /// Time since the start of the segment, s.
    pub tau: f64,
    zeta0: Vec<Complex>,
    mu0: Vec<Complex>,
    mu: Vec<Complex>,
    ramps: Vec<RampResponse>,
    others: Vec<NonOscillatoryTrajectory>,
    /// Complex amplitude `push · e^{iωt₀}` of every near-resonant forcing, per s.
    forcings: Vec<Complex>,
    resonances: Vec<ResonantResponse>,
    /// Propagator steps since the last evaluation by exponentials.
    strides: u32,
    /// Bounds on |σ|: of every complex coordinate, then of every other state.
    pub sizes: Vec<f64>,
    /// Bounds on the resonant share of |σ̈|, for oscillatory parts of |μ|, in the order of `sizes`; empty without resonance.
    resonance_bounds: Vec<f64>,
}

/// Response of an oscillatory part to the ramp `β₁ τ`: particular solution `drift τ`, or a series for small λτ.
#[derive(Debug, Clone, Copy)]
struct RampResponse {
    drift: Complex,
    rate: Complex,
    slope: Complex,
    small: f64,
}

/// Carrier `e^{iωτ}` and envelope `e^{κτ} − 1`, κ = λ − iω, of the resonant response `push e^{iωτ} (e^{κτ} − 1)/κ`. Neither factor grows
/// if the oscillation decays.
#[derive(Debug, Clone, Copy)]
struct ResonantResponse {
    carrier: Complex,
    envelope: Complex,
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
        drift: [f64; 2],
        bounds: [f64; 2],
    },
    Dense(DenseTrajectory),
}

/// Propagator over a step h: `e^{λh} − 1` of every complex coordinate, `e^{κh} − 1` of every detuning.
#[derive(Debug, Clone, Default)]
pub struct Propagator {
    /// Step size h, s.
    pub span: f64,
    coordinates: Vec<Complex>,
    envelopes: Vec<Complex>,
}

/// Number of propagator steps after which exponentials renew the state, to bound rounding.
const RESET_INTERVAL: u32 = 16;

impl ForcedParts {
    /// Forced parts under harmonics of given frequencies, rad/s, and near-resonant forcings.
    pub fn new(
        spectrum: ModalParts,
        frequencies: &[f64],
        near: Vec<ResonantForcing>,
    ) -> ForcedParts {
        let growth = spectrum.growth();
        let known = frequencies.iter().map(|&omega| Complex::new(0.0, omega));
        let detunings = near.iter().map(|near| match near.part {
            PartIndex::Oscillatory(k) => {
                let lambda = spectrum.oscillatory[k];
                Complex::new(lambda.re, lambda.im - near.omega)
            }
            PartIndex::Other(..) => Complex::ZERO,
        });
        let detunings = detunings.collect();
        let eigenvalues: Vec<Complex> = known.chain(spectrum.oscillatory).collect();
        let is_exact = |other: &NonOscillatoryPart| {
            matches!(
                other,
                NonOscillatoryPart::Decay(_) | NonOscillatoryPart::RigidMotion(_)
            )
        };
        ForcedParts {
            known: frequencies.len(),
            fastest: eigenvalues.iter().map(|l| modulus(*l)).fold(0.0, f64::max),
            inverses: eigenvalues.iter().map(|lambda| lambda.inv()).collect(),
            exact_accelerations: near.is_empty() && spectrum.others.iter().all(is_exact),
            others: spectrum.others,
            eigenvalues,
            near,
            detunings,
            growth,
        }
    }

    /// Whether accelerations are exact rather than bounded.
    pub fn has_exact_accelerations(&self) -> bool {
        self.exact_accelerations
    }

    /// Largest phase advance of an oscillatory mode within `span` seconds and before it decays to rounding, rad.
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

    /// Time scale of the fastest part, `1/max |λ|`, s.
    pub fn time_scale(&self) -> f64 {
        let rates = self.others.iter().map(NonOscillatoryPart::rate);
        1.0 / rates.fold(self.fastest, f64::max)
    }

    /// Propagator over a step h, s.
    pub fn propagator(&self, h: f64) -> Propagator {
        let mut decay = ExpCache::default();
        let roots = self.eigenvalues.iter();
        Propagator {
            span: h,
            coordinates: roots.map(|&lambda| decay.exp_m1(lambda, h)).collect(),
            envelopes: self
                .detunings
                .iter()
                .map(|&kappa| decay.exp_m1(kappa, h))
                .collect(),
        }
    }

    /// Upper bound of the growth factor of any part by τ.
    #[inline(never)]
    fn growth_bound(&self, tau: f64) -> f64 {
        (self.growth * tau).exp()
    }

    /// Index of the first non-oscillatory state.
    fn first_other(&self) -> usize {
        2 * self.eigenvalues.len()
    }

    /// Whether a harmonic is near an eigenvalue.
    pub fn is_resonant(&self) -> bool {
        !self.near.is_empty()
    }

    /// Number of complex coordinates and of other states.
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
    /// Initialises a segment of `span` seconds from [`ModalTrajectory::sigma`] under `β₀ + β₁ τ`. The first states are `e^{iωt₀}` of
    /// every harmonic; the other states exclude the steady-state responses.
    pub fn start(&mut self, parts: &ForcedParts, (b0, b1): (&[f64], &[f64]), span: f64) {
        self.tau = 0.0;
        self.strides = 0;
        self.ramps.clear();
        self.others.clear();
        let n_states = 2 * parts.eigenvalues.len();
        let states = self.sigma[..n_states].as_chunks::<2>().0.iter();
        self.zeta0.clear();
        self.zeta0.extend(states.map(|&[x, y]| Complex::new(x, y)));
        let pushes = b0.as_chunks::<2>().0.iter().zip(&parts.inverses);
        let mu0 = |(start, (&[x, y], inverse)): (&Complex, (&[f64; 2], &Complex))| {
            start + Complex::new(x, y) * inverse
        };
        self.mu0.clear();
        self.mu0.extend(self.zeta0.iter().zip(pushes).map(mu0));
        let pairs = self.zeta0.iter().zip(&self.mu0);
        self.sizes.clear();
        self.sizes
            .extend(pairs.map(|(start, mu)| modulus(*start) + 2.0 * modulus(*mu)));
        if b1[..n_states].iter().any(|slope| *slope != 0.0) {
            self.start_ramps(parts, b1, span);
        }
        self.start_others(parts, (b0, b1), span);
        self.start_resonances(parts, span);
        self.mu.clone_from(&self.mu0);
    }

    fn start_ramps(&mut self, parts: &ForcedParts, b1: &[f64], span: f64) {
        for (k, slope) in b1.chunks_exact(2).take(parts.eigenvalues.len()).enumerate() {
            let (lambda, inverse) = (parts.eigenvalues[k], parts.inverses[k]);
            let slope = Complex::new(slope[0], slope[1]);
            let drift = -(slope * inverse);
            self.ramps.push(RampResponse {
                drift,
                rate: lambda * self.mu0[k],
                slope,
                small: phi::SERIES_RADIUS / modulus(lambda),
            });
            let correction = drift * inverse;
            self.mu0[k] -= correction;
            self.sizes[k] += 2.0 * modulus(correction) + modulus(drift) * span;
        }
    }

    fn start_others(&mut self, parts: &ForcedParts, (b0, b1): (&[f64], &[f64]), span: f64) {
        let mut i = parts.first_other();
        for other in &parts.others {
            let sigma = &self.sigma;
            match other {
                NonOscillatoryPart::Decay(lambda) => {
                    self.sizes.push(sigma[i].abs() + (b0[i] * span).abs());
                    self.others.push(NonOscillatoryTrajectory::Decay {
                        lambda: *lambda,
                        start: sigma[i],
                        push: [b0[i], b1[i]],
                    });
                }
                NonOscillatoryPart::RigidMotion(lambda) => {
                    let (push, ramp) = (b0[i + 1], b1[i + 1]);
                    let speed = sigma[i + 1].abs() + push.abs() * span;
                    self.sizes.extend([sigma[i].abs(), speed]);
                    self.others.push(NonOscillatoryTrajectory::Coast {
                        lambda: *lambda,
                        start: [sigma[i], sigma[i + 1]],
                        push: [push, ramp],
                    });
                }
                NonOscillatoryPart::Critical { d, square } => {
                    let push = [b0[i + 1], b1[i + 1]];
                    self.start_critical((*d, *square), i, push, span);
                }
                NonOscillatoryPart::Dense(dense) => {
                    let phasors = self.zeta0[..parts.known].iter();
                    let phasors: Vec<Complex> = phasors.copied().collect();
                    let started = dense.start((&sigma[i..], &b0[i..], &b1[i..]), &phasors, span);
                    self.sizes.extend(started.sizes());
                    self.others.push(NonOscillatoryTrajectory::Dense(started));
                }
            }
            i += other.count();
        }
    }

    #[inline(never)]
    fn start_critical(&mut self, (d, square): (f64, f64), i: usize, push: [f64; 2], span: f64) {
        let slope = push[1] / square;
        let drift = [(push[0] - d * slope) / square, slope];
        let start = [self.sigma[i] - drift[0], self.sigma[i + 1] - slope];
        let w = square.sqrt();
        let energy = (w * start[0]).hypot(start[1]);
        let fast = d.abs() + w;
        self.sizes.extend([
            energy / w + drift[0].abs() + (slope * span).abs(),
            energy + slope.abs(),
        ]);
        self.others.push(NonOscillatoryTrajectory::Critical {
            half: 0.5 * d,
            square,
            start,
            drift,
            bounds: [fast * energy, fast * fast * energy],
        });
    }

    fn start_resonances(&mut self, parts: &ForcedParts, span: f64) {
        self.forcings.clear();
        self.resonances.clear();
        self.resonance_bounds.clear();
        if parts.near.is_empty() {
            return;
        }
        self.resonance_bounds.resize(parts.count(), 0.0);
        for (near, kappa) in parts.near.iter().zip(&parts.detunings) {
            let phasor = self.zeta0[near.frequency];
            let phasor = match near.part {
                PartIndex::Oscillatory(_) if near.omega < 0.0 => phasor.conj(),
                _ => phasor,
            };
            let push = near.push * phasor;
            self.forcings.push(push);
            self.resonances.push(ResonantResponse {
                carrier: Complex::ONE,
                envelope: Complex::ZERO,
            });
            let (size, omega) = (push.norm(), near.omega.abs());
            match near.part {
                PartIndex::Oscillatory(k) => {
                    let lambda = parts.eigenvalues[parts.known + k];
                    let buildup_time = span.min(2.0 / kappa.norm());
                    let fast = omega + lambda.norm() + lambda.norm_sqr() * buildup_time;
                    // A bound on μ: the acceleration is |λ|² μ.
                    self.resonance_bounds[parts.known + k] += size * fast / lambda.norm_sqr();
                    self.sizes[parts.known + k] += size * buildup_time;
                }
                PartIndex::Other(number, i) => {
                    // Index in `sizes`: an oscillatory part counts once, not twice.
                    let oscillations = parts.eigenvalues.len() - parts.known;
                    let index = parts.known + i - oscillations;
                    match parts.others[number] {
                        NonOscillatoryPart::Decay(l) => {
                            self.resonance_bounds[index] += size * (2.0 * l.abs() + omega)
                        }
                        NonOscillatoryPart::RigidMotion(l) => {
                            self.resonance_bounds[index] += 2.0 * size;
                            self.resonance_bounds[index + 1] += size * (2.0 * l.abs() + omega);
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// Evaluates the state at τ by exponentials; the `unseen` parts follow by [`ModalTrajectory::update_unseen`].
    pub fn move_to(&mut self, parts: &ForcedParts, unseen: &[bool], tau: f64) {
        self.tau = tau;
        self.strides = 0;
        let mut decay = ExpCache::default();
        let pairs = self.mu0.iter().zip(&self.zeta0);
        let coordinates = parts.eigenvalues.iter().zip(pairs);
        let out = self.mu.iter_mut().zip(self.sigma.chunks_exact_mut(2));
        for ((&lambda, (mu0, start)), (mu, out)) in coordinates.zip(out) {
            let increment = mu0 * decay.exp_m1(lambda, tau);
            *mu = mu0 + increment;
            out[0] = start.re + increment.re;
            out[1] = start.im + increment.im;
        }
        for ((resonance, near), &kappa) in self
            .resonances
            .iter_mut()
            .zip(&parts.near)
            .zip(&parts.detunings)
        {
            if let PartIndex::Oscillatory(_) = near.part {
                resonance.carrier = decay.exp_m1(Complex::new(0.0, near.omega), tau) + 1.0;
                resonance.envelope = decay.exp_m1(kappa, tau);
            }
        }
        self.update_forced(parts, unseen);
    }

    /// Advances the state to τ by one propagator step.
    pub fn advance(&mut self, parts: &ForcedParts, unseen: &[bool], stride: &Propagator, tau: f64) {
        if self.strides == RESET_INTERVAL {
            return self.move_to(parts, unseen, tau);
        }
        self.tau = tau;
        self.strides += 1;
        let out = self.mu.iter_mut().zip(self.sigma.chunks_exact_mut(2));
        for ((mu, out), step) in out.zip(&stride.coordinates) {
            let increment = *mu * step;
            *mu += increment;
            out[0] += increment.re;
            out[1] += increment.im;
        }
        let detuned = parts.near.iter().zip(&stride.envelopes);
        for (resonance, (near, envelope)) in self.resonances.iter_mut().zip(detuned) {
            if let PartIndex::Oscillatory(_) = near.part {
                let step = stride.coordinates[near.frequency];
                let step = if near.omega < 0.0 { step.conj() } else { step };
                resonance.carrier += resonance.carrier * step;
                resonance.envelope += *envelope + resonance.envelope * envelope;
            }
        }
        if !self.resonances.is_empty() {
            // `update_forced` adds the resonant response to the free response.
            for (k, out) in self
                .sigma
                .chunks_exact_mut(2)
                .take(self.zeta0.len())
                .enumerate()
            {
                let free = self.zeta0[k] + (self.mu[k] - self.mu0[k]);
                (out[0], out[1]) = (free.re, free.im);
            }
        }
        self.update_forced(parts, unseen);
    }

    /// Whether the state comes from exponentials, not from propagator steps.
    pub fn is_exact(&self) -> bool {
        self.strides == 0
    }

    /// Shifts the state to a near τ by a series that is exact to rounding; false if τ is too distant.
    pub fn shift_to(&mut self, parts: &ForcedParts, unseen: &[bool], tau: f64) -> bool {
        const SHORT: f64 = 0.02; // x⁸/8! is below rounding
        let delta = tau - self.tau;
        let fast = parts.fastest * delta.abs() > SHORT;
        if fast || !parts.exact_accelerations || !self.ramps.is_empty() || !self.is_exact() {
            return false;
        }
        self.tau = tau;
        let out = self.mu.iter_mut().zip(self.sigma.as_chunks_mut::<2>().0);
        for ((mu, out), lambda) in out.zip(&parts.eigenvalues) {
            let increment = *mu * phi::exp_m1(lambda * delta);
            *mu += increment;
            out[0] += increment.re;
            out[1] += increment.im;
        }
        self.others_at(parts, unseen, false);
        true
    }

    /// Updates the ramp, non-oscillatory and resonant responses.
    fn update_forced(&mut self, parts: &ForcedParts, unseen: &[bool]) {
        let tau = self.tau;
        for (k, ramp) in self.ramps.iter().enumerate() {
            let zeta = if tau < ramp.small {
                let (first, second) = phi::phi_series(parts.eigenvalues[k] * tau);
                self.zeta0[k] + (first * ramp.rate + second * ramp.slope * tau) * tau
            } else {
                (self.zeta0[k] - self.mu0[k]) + ramp.drift * tau + self.mu[k]
            };
            (self.sigma[2 * k], self.sigma[2 * k + 1]) = (zeta.re, zeta.im);
        }
        self.others_at(parts, unseen, false);
        for (at, near) in parts.near.iter().enumerate() {
            let push = self.forcings[at];
            match near.part {
                PartIndex::Oscillatory(k) => {
                    let ResonantResponse { carrier, envelope } = self.resonances[at];
                    let kappa = parts.detunings[at];
                    let buildup = match kappa == Complex::ZERO {
                        true => Complex::new(tau, 0.0),
                        false => envelope / kappa,
                    };
                    let response = push * carrier * buildup;
                    let first = 2 * (parts.known + k);
                    self.sigma[first] += response.re;
                    self.sigma[first + 1] += response.im;
                }
                PartIndex::Other(number, state) => {
                    let first = 2 * parts.known + state;
                    match parts.others[number] {
                        NonOscillatoryPart::Decay(lambda) => {
                            let rate = phi::forced_response(lambda, near.omega, tau).0;
                            self.sigma[first] += (push * rate).re;
                        }
                        NonOscillatoryPart::RigidMotion(lambda) => {
                            let (rate, position) = phi::forced_response(lambda, near.omega, tau);
                            self.sigma[first] += (push * position).re;
                            self.sigma[first + 1] += (push * rate).re;
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// Updates the `unseen` non-oscillatory parts, which steps skip.
    pub fn update_unused(&mut self, parts: &ForcedParts, unseen: &[bool]) {
        self.others_at(parts, unseen, true);
    }

    fn others_at(&mut self, parts: &ForcedParts, unseen: &[bool], select: bool) {
        let (tau, sigma) = (self.tau, &mut self.sigma);
        let mut i = parts.first_other();
        for ((part, other), unseen) in self.others.iter().zip(&parts.others).zip(unseen) {
            if *unseen != select {
                i += other.count();
                continue;
            }
            match part {
                NonOscillatoryTrajectory::Decay {
                    lambda,
                    start,
                    push,
                } => {
                    let [e, f1, f2, _] = phi::phi_real(*lambda, tau);
                    sigma[i] = start * e + push[0] * f1 + push[1] * f2;
                }
                NonOscillatoryTrajectory::Coast {
                    lambda,
                    start,
                    push,
                } => {
                    let [e, f1, f2, f3] = phi::phi_real(*lambda, tau);
                    sigma[i] = start[0] + start[1] * f1 + push[0] * f2 + push[1] * f3;
                    sigma[i + 1] = start[1] * e + push[0] * f1 + push[1] * f2;
                }
                NonOscillatoryTrajectory::Critical {
                    half,
                    square,
                    start: [y, v],
                    drift,
                    ..
                } => {
                    let (c, s) = phi::damped_pair(*half, *square, tau);
                    sigma[i] = y * c + (v + half * y) * s + drift[0] + drift[1] * tau;
                    sigma[i + 1] = v * c - (square * y + half * v) * s + drift[1];
                }
                NonOscillatoryTrajectory::Dense(started) => {
                    if let NonOscillatoryPart::Dense(dense) = other {
                        dense.state_at(started, tau, &mut sigma[i..i + dense.count()]);
                    }
                }
            }
            i += other.count();
        }
    }

    /// Evaluates the sums of an event function at the present state; the bounds are valid for `horizon` seconds. A complex coordinate
    /// contributes ζ, ζ, μ and |μ|, any other state x, x, ẍ and bounds on ẍ and x⃛; `unseen` parts contribute nothing.
    pub fn evaluate(
        &self,
        parts: &ForcedParts,
        unseen: &[bool],
        horizon: f64,
        EventEvaluator(rows): &EventEvaluator,
    ) -> [f64; LANES] {
        let mut sums = [0.0; LANES];
        let mut accumulate = |SumLanes(row): &SumLanes, lane: [f64; LANES]| {
            for at in 0..LANES {
                sums[at] += row[at] * lane[at];
            }
        };
        let (coordinate_rows, other_rows) = rows.split_at(self.mu.len());
        let coordinates = self.mu.iter().zip(self.sigma.as_chunks::<2>().0);
        for (row, (mu, &[x, y])) in coordinate_rows.iter().zip(coordinates) {
            let size = modulus(*mu);
            accumulate(row, [x, x, y, y, mu.re, mu.im, size, size]);
        }
        let mut other_rows = other_rows.iter();
        let mut state = parts.first_other();
        for ((part, other), unseen) in self.others.iter().zip(&parts.others).zip(unseen) {
            if *unseen {
                state += other.count();
                continue;
            }
            let x = &self.sigma[state..];
            let mut add = |x: f64, accel: f64, bound: f64, jerk: f64| {
                if let Some(row) = other_rows.next() {
                    accumulate(row, [x, x, 0.0, 0.0, accel, 0.0, bound, jerk]);
                }
            };
            match part {
                NonOscillatoryTrajectory::Decay { lambda, push, .. } => {
                    let rate = lambda * x[0] + push[0] + push[1] * self.tau;
                    let accel = lambda * rate + push[1];
                    add(x[0], accel, accel.abs(), (lambda * accel).abs());
                }
                NonOscillatoryTrajectory::Coast { lambda, push, .. } => {
                    let accel = lambda * x[1] + push[0] + push[1] * self.tau;
                    let jerk = lambda * accel + push[1];
                    // The acceleration is monotonic; this is its largest later value.
                    let extreme = match *lambda > 0.0 {
                        true => accel.abs() + jerk.abs() * horizon,
                        false => (accel + jerk * horizon.min(-1.0 / lambda)).abs(),
                    };
                    add(x[0], accel, accel.abs().max(extreme), jerk.abs());
                    add(x[1], jerk, jerk.abs(), (lambda * jerk).abs());
                }
                NonOscillatoryTrajectory::Critical { bounds, .. } => {
                    let growth = parts.growth_bound(self.tau);
                    add(x[0], 0.0, bounds[0] * growth, 0.0);
                    add(x[1], 0.0, bounds[1] * growth, 0.0);
                }
                NonOscillatoryTrajectory::Dense(started) => {
                    let growth = parts.growth_bound(self.tau);
                    for x in &x[..other.count()] {
                        add(*x, 0.0, started.acceleration_bound() * growth, 0.0);
                    }
                }
            }
            state += other.count();
        }
        if parts.growth > 0.0 || !self.resonance_bounds.is_empty() {
            let (past_growth, growth) = (parts.growth_bound(self.tau), parts.growth_bound(horizon));
            let resonant = rows.iter().zip(&self.resonance_bounds);
            sums[6] += resonant
                .map(|(row, bound)| row.0[6] * bound * past_growth)
                .sum::<f64>();
            sums[6] *= growth;
            sums[7] *= growth;
        }
        sums
    }
}

/// Cache of the last real exponential, shared by parts of equal decay.
#[derive(Debug, Default)]
struct ExpCache {
    exponent: f64,
    /// `e^x − 1`.
    expm1: f64,
}

impl ExpCache {
    /// `e^{λτ} − 1`, accurate for small λτ too: `(e^a − 1) − 2 e^a sin²(b/2) + i e^a sin b`.
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

/// Upper bound of |z|, at most a twelfth too large.
fn modulus(z: Complex) -> f64 {
    let (re, im) = (z.re.abs(), z.im.abs());
    let (large, small) = if re > im { (re, im) } else { (im, re) };
    large + (std::f64::consts::SQRT_2 - 1.0) * small
}
