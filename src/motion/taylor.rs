//! Taylor series of waves, loads and motion about the middle of an interval.
//!
//! `q_{k+1} = half v_k/(k+1)`, `v_{k+1} = half a_k/(k+1)`, a from the coefficients of all forces; products are sums over coefficients.

use std::f64::consts::TAU;

use super::contact::ContactState;
use super::curve::TorqueSpeedCurve;
use super::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use super::signal::Harmonic;
use super::wave::{PeriodicFunction, WavePhase, Waveform};

/// Adds `amplitude · cos(angle + rate σ)`.
pub fn add_cosine(series: &mut [f64], amplitude: f64, angle: f64, rate: f64) {
    let (sin, cos) = angle.sin_cos();
    let turned = [cos, -sin, -cos, sin];
    let mut size = amplitude;
    for (k, x) in series.iter_mut().enumerate() {
        *x += size * turned[k % 4];
        size *= rate / (k + 1) as f64;
    }
}

/// Adds a harmonic; `middle` is an instant, s.
pub fn add_harmonic(series: &mut [f64], h: &Harmonic, middle: f64, half: f64) {
    add_cosine(
        series,
        h.amplitude,
        h.omega * middle + h.phase,
        h.omega * half,
    );
}

/// Adds a wave at imposed speed, on the piece that carries it at the middle.
pub fn add_wave(series: &mut [f64], wave: &PeriodicFunction, middle: f64, half: f64) {
    let WavePhase::Imposed { omega, start } = wave.phase else {
        return;
    };
    let angle = omega * middle + start;
    match &wave.waveform {
        Waveform::Fourier { mean, terms } => {
            series[0] += mean;
            for &(n, a, phi) in terms {
                let n = f64::from(n);
                add_cosine(series, a, n * angle + phi, n * omega * half);
            }
        }
        waveform => {
            let psi = angle / TAU;
            let piece = waveform.piece(psi);
            series[0] += waveform.value_in(psi, piece);
            series[1] += waveform.slope_in(psi, piece) * omega / TAU * half;
        }
    }
}

/// Forcing of a machine over an interval of time; omitted terms are zero.
#[derive(Debug, Clone, Default)]
pub struct ForcingSeries {
    /// f of every drive.
    pub drives: Vec<Vec<f64>>,
    /// e of every branch.
    pub errors: Vec<Vec<f64>>,
    /// The constant parts of the laws: play, stall torque.
    pub steady: bool,
}

impl ForcingSeries {
    /// e_k.
    pub fn error(&self, branch: usize, k: usize) -> f64 {
        let series = self.errors.get(branch);
        series.and_then(|s| s.get(k)).copied().unwrap_or(0.0)
    }

    fn drive(&self, drive: usize, k: usize) -> f64 {
        let series = self.drives.get(drive);
        series.and_then(|s| s.get(k)).copied().unwrap_or(0.0)
    }
}

/// A machine with every contact held in a state: linear, its stiffness a known function of time.
pub struct TimeVaryingModel<'a> {
    /// The machine.
    pub model: &'a DynamicModel,
    /// Linear elements of the branches.
    pub branches: Vec<TimeVaryingElement>,
    /// Half the interval, s.
    pub half: f64,
}

/// `F = κ(σ) (constant + deflection δ) + rate δ̇ + own + inner`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TimeVaryingElement {
    /// κ; empty: one.
    factor: Vec<f64>,
    constant: f64,
    deflection: f64,
    rate: f64,
    own: f64,
    inner: InternalSeries,
}

/// `F ∋ sign z`, `ż = gain · (w·v − ė) + constant − z/lag`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct InternalSeries {
    present: bool,
    sign: f64,
    gain: f64,
    constant: f64,
    decay: f64,
}

impl TimeVaryingElement {
    /// Linear element of a branch in a contact state; none where its law is not linear there.
    pub fn new(branch: &ForceElement, state: Option<ContactState>) -> Option<TimeVaryingElement> {
        let plain = TimeVaryingElement::default();
        match (&branch.law, state) {
            (ForceLaw::Linear { stiffness, damping }, _) => Some(TimeVaryingElement {
                deflection: *stiffness,
                rate: *damping,
                ..plain
            }),
            (ForceLaw::Contact(contact), Some(state)) => {
                let force = contact.force(state, 1.0);
                Some(TimeVaryingElement {
                    constant: force.constant,
                    deflection: force.deflection,
                    rate: force.rate,
                    ..plain
                })
            }
            (ForceLaw::TorqueSpeed(TorqueSpeedCurve::Linear { stall, idle }), _) => {
                Some(TimeVaryingElement {
                    own: -stall,
                    rate: stall / idle,
                    ..plain
                })
            }
            (
                ForceLaw::LaggedTorque {
                    curve: TorqueSpeedCurve::Linear { stall, idle },
                    lag,
                },
                _,
            ) => Some(TimeVaryingElement {
                inner: InternalSeries {
                    present: true,
                    sign: -1.0,
                    gain: -stall / idle / lag,
                    constant: stall / lag,
                    decay: 1.0 / lag,
                },
                ..plain
            }),
            (ForceLaw::Maxwell { stiffness, damping }, _) => Some(TimeVaryingElement {
                inner: InternalSeries {
                    present: true,
                    sign: 1.0,
                    gain: *stiffness,
                    constant: 0.0,
                    decay: stiffness / damping,
                },
                ..plain
            }),
            _ => None,
        }
    }
}

impl TimeVaryingElement {
    /// The same with a factor on its stiffness.
    #[must_use]
    pub fn with_factor(mut self, factor: Vec<f64>) -> TimeVaryingElement {
        self.factor = factor;
        self
    }

    /// Whether it holds anything in place.
    pub fn is_elastic(&self) -> bool {
        self.deflection != 0.0
    }

    /// Coefficient k of a series times κ.
    pub fn times_stiffness(&self, series: &[f64], k: usize) -> f64 {
        match self.factor.is_empty() {
            true => series[k],
            false => (0..=k)
                .map(|j| self.factor.get(j).copied().unwrap_or(0.0) * series[k - j])
                .sum(),
        }
    }
}

impl TimeVaryingModel<'_> {
    /// The motion from a state `[q, v, z]` at the middle: coefficients of `[q, z]`, order by order.
    pub fn motion_series(&self, start: &[f64], sources: &ForcingSeries, terms: usize) -> Vec<f64> {
        let (n, half) = (self.model.coordinate_count(), self.half);
        let rows = start.len() - n;
        let mut out = vec![0.0; terms * rows];
        let mut v = vec![0.0; terms * n];
        out[..n].copy_from_slice(&start[..n]);
        out[n..rows].copy_from_slice(&start[2 * n..]);
        v[..n].copy_from_slice(&start[n..2 * n]);
        let mut deltas = vec![0.0; terms * self.branches.len()];
        let mut g = vec![0.0; n];
        for k in 0..terms - 1 {
            let share = half / (k + 1) as f64;
            let now = &out[k * rows..(k + 1) * rows];
            let speed = &v[k * n..(k + 1) * n];
            let mut inner_rates = Vec::new();
            g.fill(0.0);
            for (at, drive) in self.model.forces.iter().enumerate() {
                let f = sources.drive(at, k);
                drive.direction.entries().for_each(|(i, a)| g[i] += a * f);
            }
            for (at, (b, held)) in self.model.elements.iter().zip(&self.branches).enumerate() {
                let steady = f64::from(sources.steady && k == 0);
                let delta = b.direction.dot(&now[..n]) - sources.error(at, k);
                let error_rate = (k + 1) as f64 / half * sources.error(at, k + 1);
                let rate = b.direction.dot(speed) - error_rate;
                let history = &mut deltas[at * terms..(at + 1) * terms];
                history[k] = steady * held.constant + held.deflection * delta;
                let mut force =
                    held.times_stiffness(history, k) + held.rate * rate + steady * held.own;
                if held.inner.present {
                    let z = now[n + inner_rates.len()];
                    force += held.inner.sign * z;
                    inner_rates.push(
                        held.inner.gain * rate + steady * held.inner.constant
                            - held.inner.decay * z,
                    );
                }
                b.force_direction()
                    .entries()
                    .for_each(|(i, a)| g[i] -= a * force);
            }
            if let Some((stiffness, damping)) = &self.model.global_matrices {
                for i in 0..n {
                    g[i] -= (0..n)
                        .map(|j| stiffness[(i, j)] * now[j] + damping[(i, j)] * speed[j])
                        .sum::<f64>();
                }
            }
            self.model.apply_inverse_mass(&mut g);
            for i in 0..n {
                out[(k + 1) * rows + i] = share * v[k * n + i];
                v[(k + 1) * n + i] = share * (g[i] - self.model.mass_damping * v[k * n + i]);
            }
            for (i, rate) in inner_rates.iter().enumerate() {
                out[(k + 1) * rows + n + i] = share * rate;
            }
        }
        out
    }
}
