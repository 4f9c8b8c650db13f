//! Alternating frequency/time (AFT) transform of nonlinear forces, with exact Jacobian.

use std::f64::consts::TAU;

use super::family::SpeedFamily;
use super::linear_part::NonlinearElement;
use crate::motion::dynamic_model::ForceLaw;
use crate::motion::wave::{WavePhase, Waveform};
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

const ZERO: Complex = Complex::new(0.0, 0.0);

/// The transforms of a number of orders.
pub struct AftTransform {
    orders: usize,
    fft: RealFft,
    /// The stiffness wave of every active branch, sample by sample.
    factors: Vec<Option<Vec<f64>>>,
}

/// The force of one branch beyond its straight law.
pub struct ForceHarmonics {
    /// N_k, up to twice the orders.
    pub value: Vec<Complex>,
    /// Fourier coefficients of ∂F/∂δ less the straight one, up to twice the orders.
    stiffness: Vec<Complex>,
    /// The same of ∂F/∂δ̇.
    damping: Vec<Complex>,
    /// ∂N_k/∂ω while δ_k stays.
    pub by_omega: Vec<Complex>,
}

/// The law of a branch over a period.
pub struct PeriodSamples {
    /// δ.
    pub deflection: Vec<f64>,
    /// ∂F/∂δ.
    pub stiffness: Vec<f64>,
    /// ∂F/∂δ̇.
    pub damping: Vec<f64>,
    force: Vec<f64>,
    by_omega: Vec<f64>,
}

/// Samples to the period for each order: the force at a kink is then known to a thousandth of what the orders leave out.
const SAMPLES: usize = 32;

const MIN_SAMPLES: usize = 1024;

impl AftTransform {
    /// For so many orders.
    pub fn new(family: &SpeedFamily, active: &[NonlinearElement], orders: usize) -> AftTransform {
        let samples = (SAMPLES * orders).max(MIN_SAMPLES).next_power_of_two();
        let wave = |a: &NonlinearElement| {
            let wave = family.relative.model.elements[a.branch]
                .stiffness_wave
                .as_ref()?;
            let WavePhase::Imposed { omega, start } = wave.phase else {
                return None;
            };
            let turns = omega / family.base;
            Some(
                (0..samples)
                    .map(|j| {
                        average(
                            &wave.waveform,
                            turns * j as f64 / samples as f64 + start / TAU,
                            turns / samples as f64,
                        )
                    })
                    .collect(),
            )
        };
        AftTransform {
            orders,
            fft: RealFft::new(samples),
            factors: active.iter().map(wave).collect(),
        }
    }

    /// Samples to the period.
    pub fn samples(&self) -> usize {
        self.fft.samples()
    }

    /// `x(t) = x_0 + 2 Re Σ x_k e^{ikωt}` over a period.
    pub fn time_samples(&mut self, lines: &[Complex]) -> Vec<f64> {
        let samples = self.samples();
        let mut spectrum = vec![ZERO; self.fft.lines()];
        let scale = samples as f64;
        spectrum
            .iter_mut()
            .zip(lines)
            .for_each(|(s, x)| *s = x * scale);
        let mut time = vec![0.0; samples];
        self.fft.inverse(&mut spectrum, &mut time);
        time
    }

    fn harmonics(&mut self, mut time: Vec<f64>) -> Vec<Complex> {
        let mut spectrum = vec![ZERO; self.fft.lines()];
        let scale = 1.0 / time.len() as f64;
        self.fft.forward(&mut time, &mut spectrum);
        spectrum.truncate(2 * self.orders + 1);
        spectrum.iter_mut().for_each(|x| *x *= scale);
        spectrum
    }

    /// The law of active branch `own` over a period.
    pub fn period(
        &mut self,
        family: &SpeedFamily,
        active: &[NonlinearElement],
        own: usize,
        delta: &[Complex],
        omega: f64,
    ) -> PeriodSamples {
        let branch = active[own].branch;
        let steady = family.rates[branch] / family.base;
        let derived: Vec<Complex> = delta
            .iter()
            .enumerate()
            .map(|(k, x)| Complex::new(0.0, k as f64) * x)
            .collect();
        let (deflection, prime) = (self.time_samples(delta), self.time_samples(&derived));
        let mut period = PeriodSamples {
            stiffness: Vec::with_capacity(deflection.len()),
            damping: Vec::with_capacity(deflection.len()),
            force: Vec::with_capacity(deflection.len()),
            by_omega: Vec::with_capacity(deflection.len()),
            deflection,
        };
        let law = &family.relative.model.elements[branch].law;
        for (j, &prime) in prime.iter().enumerate() {
            let x = period.deflection[j];
            // A motor's curve moves along with the speed it is set to; what slips at a brake does not.
            let (rate, by_omega) = match law {
                ForceLaw::TorqueSpeed(_) => (family.rates[branch] + omega * prime, prime),
                _ => (omega * (steady + prime), steady + prime),
            };
            let factor = self.factors[own].as_ref().map_or(1.0, |f| f[j]);
            let (force, k, c) = force_and_slopes(law, x, rate, factor);
            period.force.push(force);
            period.stiffness.push(k);
            period.damping.push(c);
            period.by_omega.push(c * by_omega);
        }
        period
    }

    /// N of active branch `own` with its derivatives.
    pub fn forces(
        &mut self,
        family: &SpeedFamily,
        active: &[NonlinearElement],
        own: usize,
        delta: &[Complex],
        omega: f64,
    ) -> ForceHarmonics {
        let period = self.period(family, active, own, delta, omega);
        let NonlinearElement {
            stiffness: k,
            damping: c,
            ..
        } = active[own];
        let mut forces = ForceHarmonics {
            value: self.harmonics(period.force),
            stiffness: self.harmonics(period.stiffness),
            damping: self.harmonics(period.damping),
            by_omega: self.harmonics(period.by_omega),
        };
        forces.stiffness[0] -= k;
        forces.damping[0] -= c;
        for (order, x) in delta.iter().enumerate() {
            let ik = Complex::new(0.0, order as f64);
            forces.value[order] -= (ik * (omega * c) + k) * x;
            forces.by_omega[order] -= ik * c * x;
        }
        forces
    }
}

impl ForceHarmonics {
    /// ∂N_k by the real and by the imaginary part of δ_l.
    pub fn jacobian_block(&self, k: usize, l: usize, omega: f64) -> [Complex; 2] {
        let line = |of: &[Complex], n: isize| match n >= 0 {
            true => of[n as usize],
            false => of[n.unsigned_abs()].conj(),
        };
        let (less, more) = (k as isize - l as isize, (k + l) as isize);
        let (k_less, k_more) = (line(&self.stiffness, less), line(&self.stiffness, more));
        if l == 0 {
            return [k_less, ZERO];
        }
        let (c_less, c_more) = (line(&self.damping, less), line(&self.damping, more));
        let i = Complex::new(0.0, 1.0);
        let il = Complex::new(0.0, l as f64 * omega);
        [
            k_less + k_more + il * (c_less - c_more),
            i * (k_less - k_more) + il * i * (c_less + c_more),
        ]
    }
}

/// F, ∂F/∂δ, ∂F/∂δ̇.
fn force_and_slopes(law: &ForceLaw, delta: f64, rate: f64, factor: f64) -> (f64, f64, f64) {
    match law {
        ForceLaw::Contact(contact) => {
            let force = contact.force(contact.state(delta, rate, factor), factor);
            (force.value_at(delta, rate), force.deflection, force.rate)
        }
        ForceLaw::Friction(friction) => {
            let (force, slope) = friction.regularised(rate);
            (force, 0.0, slope)
        }
        law => law.force_and_slopes(delta, rate),
    }
}

/// A wave averaged over one sample: its jumps then fall between samples without a shift.
fn average(waveform: &Waveform, middle: f64, width: f64) -> f64 {
    let Waveform::Rectangular { high, low, duty } = waveform else {
        return waveform.value(middle);
    };
    // How much of the time up to ψ the stiffness was high.
    let risen = |psi: f64| psi.floor() * duty + (psi - psi.floor()).min(*duty);
    let half = 0.5 * width;
    let share = (risen(middle + half) - risen(middle - half)) / width;
    low + (high - low) * share
}
