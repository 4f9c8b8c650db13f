//! Modal parameters: pole with covariance, and mode shape over the outputs.

use std::f64::consts::TAU;

use crate::numeric::Complex;

/// An identified mode; every method ends in these.
#[derive(Debug, Clone)]
pub struct ModalParameters {
    /// The pole of the upper half plane, rad/s.
    pub pole: Complex,
    /// Covariance of the real and imaginary part of the pole: `[σ²_re, σ²_im, σ_re,im]`, rad²/s²; `None` where the method gives none.
    pub pole_covariance: Option<[f64; 3]>,
    /// Shape over the outputs, in their order; the largest component is 1. Empty where the method gives none.
    pub shape: Vec<Complex>,
}

impl ModalParameters {
    /// Natural frequency `|p|/2π`, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.pole.norm() / TAU
    }

    /// Damped frequency `Im p/2π`, Hz.
    pub fn damped_frequency_hz(&self) -> f64 {
        self.pole.im / TAU
    }

    /// Damping ratio `−Re p/|p|`.
    pub fn damping_ratio(&self) -> f64 {
        -self.pole.re / self.pole.norm()
    }

    /// Standard deviation of the natural frequency, Hz, by the gradient `(σ, ω)/|p|`.
    pub fn frequency_std_hz(&self) -> Option<f64> {
        let (a, b, w) = (self.pole.re, self.pole.im, self.pole.norm());
        self.pole_covariance.map(|[aa, bb, ab]| {
            ((a * a * aa + b * b * bb + 2.0 * a * b * ab).max(0.0)).sqrt() / w / TAU
        })
    }

    /// Adds the uncertainty of a factor on the pole, of this relative standard deviation, as that of a sample rate is.
    pub fn add_scale_uncertainty(&mut self, std: f64) {
        let (a, b) = (std * self.pole.re, std * self.pole.im);
        if let Some([aa, bb, ab]) = &mut self.pole_covariance {
            *aa += a * a;
            *bb += b * b;
            *ab += a * b;
        }
    }

    /// Standard deviation of the damping ratio, by the gradient `(−ω², σω)/|p|³`.
    pub fn damping_std(&self) -> Option<f64> {
        let (a, b, w) = (self.pole.re, self.pole.im, self.pole.norm());
        let (da, db) = (-b * b / w.powi(3), a * b / w.powi(3));
        self.pole_covariance.map(|[aa, bb, ab]| {
            (da * da * aa + db * db * bb + 2.0 * da * db * ab)
                .max(0.0)
                .sqrt()
        })
    }
}
