//! One natural mode: eigenvalue, damping ratio, shape, residual.

use crate::numeric::Complex;

/// One natural mode of a machine.
#[derive(Debug, Clone)]
pub struct Mode {
    /// λ, rad/s: `iω` where undamped, with the sign of the pair above the real axis; real for overdamped roots.
    pub eigenvalue: Complex,
    /// A rigid-body mode: strains nothing, its frequency is exactly zero.
    pub rigid: bool,
    /// ζ; `None` where there is no damping, or the root does not oscillate.
    pub damping_ratio: Option<f64>,
    /// Over all degrees of freedom of the machine: mass-normalised where real, `φᵀ(2λM + C)φ = 1` where complex.
    pub shape: Vec<Complex>,
    /// `‖(λ²M + λC + K) φ‖ / ‖(|λ|²M + |λ|C + K) |φ|‖`, entry by entry the largest.
    pub residual: f64,
    /// Decimal digits of λ that can be trusted; infinite for the exact zeros.
    pub trusted_digits: f64,
}

impl Mode {
    /// `|λ|`, rad/s.
    pub fn omega(&self) -> f64 {
        self.eigenvalue.re.hypot(self.eigenvalue.im)
    }

    /// `|λ|/2π`, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.omega() / std::f64::consts::TAU
    }

    /// True for an oscillatory mode: λ has an imaginary part.
    pub fn is_oscillatory(&self) -> bool {
        self.eigenvalue.im != 0.0
    }
}

/// The size of a complex number without overflow.
pub fn modulus(z: Complex) -> f64 {
    match z.im {
        0.0 => z.re.abs(),
        im => z.re.hypot(im),
    }
}

/// Gives a shape its sign: the first component within 1e-9 of the largest is positive (its real part, where complex).
pub fn orient(shape: &mut [Complex]) {
    let largest = shape.iter().fold(0.0f64, |m, &z| m.max(modulus(z)));
    let lead = shape
        .iter()
        .copied()
        .find(|&z| modulus(z) >= largest * (1.0 - 1e-9));
    let negative = lead.is_some_and(|z| z.re < 0.0 || (z.re == 0.0 && z.im < 0.0));
    if negative {
        shape
            .iter_mut()
            .for_each(|z| *z = Complex::new(-z.re, -z.im));
    }
}
