//! Shift δp of a pole: a response near the pole changes by `A δp/(jω − p)² + a/(jω − p) + b` to first order, with A its residue.
//!
//! δp is fitted by least squares over the lines near the pole, orthogonal to the other two terms. Shifts beyond a quarter of the
//! half-power width are underestimated.

use std::f64::consts::TAU;

use crate::numeric::Complex;

/// Partial fractions `1/(jω − p)` and `1/(jω − p)²` at ω; ω and p in rad/s.
pub fn partial_fraction(omega: f64, pole: Complex) -> (Complex, Complex) {
    let first = Complex::new(1.0, 0.0) / (Complex::new(0.0, omega) - pole);
    (first, first * first)
}

/// Orthogonal basis of a pole shift on the lines near the pole, scaled to order one: with `first = |σ|/(jω − p)` a shift δp changes a
/// response by `a (δp/|σ|) first²`, a = A/|σ|.
pub struct ShiftBasis {
    /// Constant and `1/(jω − p)`, orthonormalised.
    lower: [Vec<Complex>; 2],
    /// `1/(jω − p)`, orthogonal to the constant.
    pole: Vec<Complex>,
    /// `1/(jω − p)²`, orthogonal to both.
    shift: Vec<Complex>,
}

impl ShiftBasis {
    /// Basis from the values of `1/(jω − p)` and `1/(jω − p)²` at each line and the decay rate |σ| of the pole, 1/s.
    pub fn new(terms: impl Iterator<Item = (Complex, Complex)>, decay_rate: f64) -> ShiftBasis {
        let (mut pole, mut shift): (Vec<Complex>, Vec<Complex>) = terms
            .map(|(first, second)| (first * decay_rate, second * decay_rate * decay_rate))
            .unzip();
        let constant = normalise(vec![Complex::new(1.0, 0.0); pole.len()]);
        project_out(&mut pole, &constant);
        let lower = [constant, normalise(pole.clone())];
        lower.iter().for_each(|b| project_out(&mut shift, b));
        ShiftBasis { lower, pole, shift }
    }

    /// `Σ |shift|²` over the lines.
    pub fn shift_power(&self) -> f64 {
        power(&self.shift)
    }

    /// Residue of a response divided by the decay rate.
    pub fn residue(&self, response: &[Complex]) -> Complex {
        inner_product(&self.pole, response) / power(&self.pole)
    }

    /// Coefficient of the shift in a departure; on return `departure` holds the part that no term explains.
    pub fn split_shift(&self, departure: &mut [Complex]) -> Complex {
        self.lower.iter().for_each(|b| project_out(departure, b));
        let coefficient = inner_product(&self.shift, departure) / self.shift_power();
        (departure.iter_mut().zip(&self.shift)).for_each(|(x, s)| *x -= coefficient * s);
        coefficient
    }
}

/// Shift of the natural frequency of a pole and its standard deviation, rad/s, from the misfit of a fit on the lines near the pole;
/// `measured` and `fitted` by response and line. `None` if the pole has no residue in any response.
pub fn shift_of_misfit(
    frequency_hz: &[f64],
    measured: &[Vec<Complex>],
    fitted: &[Vec<Complex>],
    pole: Complex,
) -> Option<(f64, f64)> {
    let terms = |f: &f64| partial_fraction(TAU * f, pole);
    let basis = ShiftBasis::new(frequency_hz.iter().map(terms), pole.re.abs());
    let norm = basis.shift_power();
    let (mut shift, mut weight, mut residual) = (Complex::new(0.0, 0.0), 0.0, 0.0);
    for (measured, fitted) in measured.iter().zip(fitted) {
        let residue = basis.residue(fitted);
        let mut misfit: Vec<Complex> = measured.iter().zip(fitted).map(|(m, f)| m - f).collect();
        let coefficient = basis.split_shift(&mut misfit);
        shift += residue.conj() * coefficient;
        weight += residue.norm_sqr();
        residual += misfit.iter().map(Complex::norm_sqr).sum::<f64>();
    }
    let dofs = (measured.len() * (frequency_hz.len() - 3)) as f64;
    let variance = residual / dofs / norm / weight;
    let sigma = pole.re.abs();
    (weight > 0.0).then(|| (sigma * (shift / weight).im, sigma * (0.5 * variance).sqrt()))
}

/// Squared norm `Σ |x|²`.
pub fn power(x: &[Complex]) -> f64 {
    x.iter().map(Complex::norm_sqr).sum()
}

/// Inner product `⟨b, x⟩ = Σ b* x`.
fn inner_product(b: &[Complex], x: &[Complex]) -> Complex {
    b.iter().zip(x).map(|(b, x)| b.conj() * x).sum()
}

/// Subtracts the projection of `x` on a unit vector.
fn project_out(x: &mut [Complex], unit_vector: &[Complex]) {
    let c = inner_product(unit_vector, x);
    x.iter_mut().zip(unit_vector).for_each(|(x, b)| *x -= c * b);
}

/// Divides a vector by its norm.
fn normalise(mut x: Vec<Complex>) -> Vec<Complex> {
    let size = power(&x).sqrt();
    x.iter_mut().for_each(|z| *z /= size);
    x
}
