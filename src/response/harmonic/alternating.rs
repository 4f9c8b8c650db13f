//! Forces of the branches that are not linear, from time to orders and back: `N_k` of `δ_k` by fast Fourier transforms of the
//! law over a period, and its exact derivative by those of ∂F/∂δ and ∂F/∂δ̇ (Cameron and Griffin 1989).

use std::f64::consts::TAU;

use super::family::Family;
use super::lines::Active;
use crate::motion::train::Law;
use crate::motion::wave::{Phase, Shape};
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

const ZERO: Complex = Complex::new(0.0, 0.0);

/// The transforms of a number of orders.
pub struct Alternating {
    orders: usize,
    fft: RealFft,
    /// The stiffness wave of every active branch, sample by sample.
    factors: Vec<Option<Vec<f64>>>,
}

/// The force of one branch beyond its straight law.
pub struct Forces {
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
pub struct Period {
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

const LEAST_SAMPLES: usize = 1024;

impl Alternating {
    /// For so many orders.
    pub fn new(family: &Family, active: &[Active], orders: usize) -> Alternating {
        let samples = (SAMPLES * orders).max(LEAST_SAMPLES).next_power_of_two();
        let wave = |a: &Active| {
            let wave = family.relative.train.branches[a.branch]
                .variation
                .as_ref()?;
            let Phase::Imposed { omega, start } = wave.phase else {
                return None;
            };
            let turns = omega / family.base;
            Some(
                (0..samples)
                    .map(|j| {
                        average(
                            &wave.shape,
                            turns * j as f64 / samples as f64 + start / TAU,
                            turns / samples as f64,
                        )
                    })
                    .collect(),
            )
        };
        Alternating {
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
    pub fn over_period(&mut self, lines: &[Complex]) -> Vec<f64> {
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

    fn lines_of(&mut self, mut time: Vec<f64>) -> Vec<Complex> {
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
        family: &Family,
        active: &[Active],
        own: usize,
        delta: &[Complex],
        omega: f64,
    ) -> Period {
        let branch = active[own].branch;
        let steady = family.rates[branch] / family.base;
        let derived: Vec<Complex> = delta
            .iter()
            .enumerate()
            .map(|(k, x)| Complex::new(0.0, k as f64) * x)
            .collect();
        let (deflection, prime) = (self.over_period(delta), self.over_period(&derived));
        let mut period = Period {
            stiffness: Vec::with_capacity(deflection.len()),
            damping: Vec::with_capacity(deflection.len()),
            force: Vec::with_capacity(deflection.len()),
            by_omega: Vec::with_capacity(deflection.len()),
            deflection,
        };
        let law = &family.relative.train.branches[branch].law;
        for (j, &prime) in prime.iter().enumerate() {
            let x = period.deflection[j];
            // A motor's curve moves along with the speed it is set to; what slips at a brake does not.
            let (rate, by_omega) = match law {
                Law::Curve(_) => (family.rates[branch] + omega * prime, prime),
                _ => (omega * (steady + prime), steady + prime),
            };
            let factor = self.factors[own].as_ref().map_or(1.0, |f| f[j]);
            let (force, k, c) = of(law, x, rate, factor);
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
        family: &Family,
        active: &[Active],
        own: usize,
        delta: &[Complex],
        omega: f64,
    ) -> Forces {
        let period = self.period(family, active, own, delta, omega);
        let Active {
            stiffness: k,
            damping: c,
            ..
        } = active[own];
        let mut forces = Forces {
            value: self.lines_of(period.force),
            stiffness: self.lines_of(period.stiffness),
            damping: self.lines_of(period.damping),
            by_omega: self.lines_of(period.by_omega),
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

impl Forces {
    /// ∂N_k by the real and by the imaginary part of δ_l.
    pub fn slope(&self, k: usize, l: usize, omega: f64) -> [Complex; 2] {
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
fn of(law: &Law, delta: f64, rate: f64, factor: f64) -> (f64, f64, f64) {
    match law {
        Law::Contact(contact) => {
            let force = contact.force(contact.stand(delta, rate, factor), factor);
            (force.at(delta, rate), force.deflection, force.rate)
        }
        Law::Friction(friction) => {
            let (force, slope) = friction.smoothed(rate);
            (force, 0.0, slope)
        }
        law => law.force_and_slopes(delta, rate),
    }
}

/// A wave averaged over one sample: its jumps then fall between samples without a shift.
fn average(shape: &Shape, middle: f64, width: f64) -> f64 {
    let Shape::Rectangular { high, low, duty } = shape else {
        return shape.value(middle);
    };
    // How much of the time up to ψ the stiffness was high.
    let risen = |psi: f64| psi.floor() * duty + (psi - psi.floor()).min(*duty);
    let half = 0.5 * width;
    let share = (risen(middle + half) - risen(middle - half)) / width;
    low + (high - low) * share
}
