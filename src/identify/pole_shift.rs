//! Shift of a pole: near it a response departs by `A δp/(jω − p)² + a/(jω − p) + b`, to first order, A its residue.
//!
//! δp by least squares over the lines near the pole, its part along the other two terms taken off. Shifts beyond a quarter of the
//! half-power width are understated.

use std::f64::consts::TAU;

use crate::numeric::Complex;

/// `1/(jω − p)` and `1/(jω − p)²` at ω, rad/s.
pub fn partial_fraction(omega: f64, pole: Complex) -> (Complex, Complex) {
    let first = Complex::new(1.0, 0.0) / (Complex::new(0.0, omega) - pole);
    (first, first * first)
}

/// The terms of a shift on the lines near a pole, scaled to sizes about one: `first = |σ|/(jω − p)`, so that a shift δp of residue
/// A is `a (δp/|σ|) first²`.
pub struct ShiftBasis {
    /// A constant and `1/(jω − p)`, orthonormal.
    others: [Vec<Complex>; 2],
    /// `1/(jω − p)` without its part along the constant.
    own: Vec<Complex>,
    /// `1/(jω − p)²` without its parts along both.
    shift: Vec<Complex>,
}

impl ShiftBasis {
    /// The basis of `1/(jω − p)` and `1/(jω − p)²` on lines, and the decay rate of the pole, 1/s.
    pub fn new(terms: impl Iterator<Item = (Complex, Complex)>, decay_rate: f64) -> ShiftBasis {
        let (mut own, mut shift): (Vec<Complex>, Vec<Complex>) = terms
            .map(|(first, second)| (first * decay_rate, second * decay_rate * decay_rate))
            .unzip();
        let level = unit(vec![Complex::new(1.0, 0.0); own.len()]);
        take_off(&mut own, &level);
        let others = [level, unit(own.clone())];
        others.iter().for_each(|b| take_off(&mut shift, b));
        ShiftBasis { others, own, shift }
    }

    /// `Σ |shift|²` over the lines.
    pub fn shift_power(&self) -> f64 {
        power(&self.shift)
    }

    /// The residue of a response, over the decay rate.
    pub fn residue(&self, response: &[Complex]) -> Complex {
        along(&self.own, response) / power(&self.own)
    }

    /// The coefficient of the shift in a departure; what no term explains is left of the departure.
    pub fn split_shift(&self, departure: &mut [Complex]) -> Complex {
        self.others.iter().for_each(|b| take_off(departure, b));
        let part = along(&self.shift, departure) / self.shift_power();
        (departure.iter_mut().zip(&self.shift)).for_each(|(x, s)| *x -= part * s);
        part
    }
}

/// Shift of the natural frequency of a pole in some responses, rad/s, and its standard deviation, from what a fit misses on the lines near
/// the pole: `measured` and `fitted` by response and line. None where no response shows the pole.
pub fn shift_of_misfit(
    frequency_hz: &[f64],
    measured: &[Vec<Complex>],
    fitted: &[Vec<Complex>],
    pole: Complex,
) -> Option<(f64, f64)> {
    let terms = |f: &f64| partial_fraction(TAU * f, pole);
    let basis = ShiftBasis::new(frequency_hz.iter().map(terms), pole.re.abs());
    let norm = basis.shift_power();
    let (mut shift, mut weight, mut left) = (Complex::new(0.0, 0.0), 0.0, 0.0);
    for (measured, fitted) in measured.iter().zip(fitted) {
        let residue = basis.residue(fitted);
        let mut misfit: Vec<Complex> = measured.iter().zip(fitted).map(|(m, f)| m - f).collect();
        let part = basis.split_shift(&mut misfit);
        shift += residue.conj() * part;
        weight += residue.norm_sqr();
        left += misfit.iter().map(Complex::norm_sqr).sum::<f64>();
    }
    let dofs = (measured.len() * (frequency_hz.len() - 3)) as f64;
    let variance = left / dofs / norm / weight;
    let size = pole.re.abs();
    (weight > 0.0).then(|| (size * (shift / weight).im, size * (0.5 * variance).sqrt()))
}

/// `Σ |x|²`.
pub fn power(x: &[Complex]) -> f64 {
    x.iter().map(Complex::norm_sqr).sum()
}

/// `⟨b, x⟩`, b conjugated.
fn along(b: &[Complex], x: &[Complex]) -> Complex {
    b.iter().zip(x).map(|(b, x)| b.conj() * x).sum()
}

/// Takes the part of `x` along a unit vector off.
fn take_off(x: &mut [Complex], unit: &[Complex]) {
    let part = along(unit, x);
    x.iter_mut().zip(unit).for_each(|(x, b)| *x -= part * b);
}

/// A vector over its length.
fn unit(mut x: Vec<Complex>) -> Vec<Complex> {
    let size = power(&x).sqrt();
    x.iter_mut().for_each(|z| *z /= size);
    x
}
