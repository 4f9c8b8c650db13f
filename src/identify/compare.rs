//! Comparison of mode shapes and responses: MAC, MPC, mean phase, FRAC, synthesis error.
//!
//! MAC: Allemang, Sound & Vibration 37 (2003), no. 8, 14–23. Phase collinearity: Pappa, Elliott & Schenk, J. Guid. Control Dyn. 16 (1993),
//! 852–858. FRAC: Heylen & Lammens, ISMA (1996). Mean phase: Reynders, Houbrechts & De Roeck, Mech. Syst. Signal Process. 29 (2012), §3.2.

use std::f64::consts::PI;

use crate::numeric::mac::{self, hermitian_product};
use crate::numeric::{Complex, Matrix};

/// MAC of every shape of `a` with every shape of `b`.
pub fn mac(a: &[Vec<Complex>], b: &[Vec<Complex>]) -> Matrix {
    Matrix::from_fn(a.len(), b.len(), |i, j| mac::mac(&a[i], &b[j]))
}

/// MAC of shapes with each other; large off the diagonal where the outputs do not distinguish two modes.
pub fn auto_mac(shapes: &[Vec<Complex>]) -> Matrix {
    mac(shapes, shapes)
}

/// Sums `x·x, y·y, x·y` of the real and imaginary parts.
fn moment_sums(shape: &[Complex]) -> (f64, f64, f64) {
    shape.iter().fold((0.0, 0.0, 0.0), |(xx, yy, xy), z| {
        (xx + z.re * z.re, yy + z.im * z.im, xy + z.re * z.im)
    })
}

/// Modal phase collinearity, 0 to 1: 1 if all components lie on one line through the origin.
///
/// `((xx − yy)² + 4 xy²) / (xx + yy)²`; 0 for a zero shape.
pub fn phase_collinearity(shape: &[Complex]) -> f64 {
    let (xx, yy, xy) = moment_sums(shape);
    let value = ((xx - yy).powi(2) + 4.0 * xy * xy) / (xx + yy).powi(2);
    if value.is_finite() { value } else { 0.0 }
}

/// Mean phase of a shape, rad, −π/2 to π/2: the line through the origin that fits its components by least squares.
pub fn mean_phase(shape: &[Complex]) -> f64 {
    let (xx, yy, xy) = moment_sums(shape);
    (2.0 * xy).atan2(xx - yy) / 2.0
}

/// Mean deviation of the components' phases from the mean phase, weighted by their moduli, rad, 0 to π/2.
pub fn mean_phase_deviation(shape: &[Complex]) -> f64 {
    let line = Complex::new(0.0, -mean_phase(shape)).exp();
    let (mut sum, mut weights) = (0.0, 0.0);
    for z in shape {
        let rotated = z * line;
        sum += z.norm() * rotated.im.abs().atan2(rotated.re.abs());
        weights += z.norm();
    }
    if weights > 0.0 {
        (sum / weights).min(PI / 2.0)
    } else {
        0.0
    }
}

/// Share of the squared norm of a shape perpendicular to its mean phase: 0 for a real shape, at most one half.
pub fn off_axis_share(shape: &[Complex]) -> f64 {
    (1.0 - phase_collinearity(shape).sqrt()) / 2.0
}

/// Frequency response assurance criterion of a measured and a fitted response, 0 to 1; independent of a common factor.
pub fn frac(measured: &[Complex], fitted: &[Complex]) -> f64 {
    mac::mac(measured, fitted)
}

/// Relative error `‖fitted − measured‖ / ‖measured‖`; `None` if the measured response is zero or the lengths differ.
pub fn synthesis_error(measured: &[Complex], fitted: &[Complex]) -> Option<f64> {
    let diff: Vec<Complex> = measured.iter().zip(fitted).map(|(m, f)| f - m).collect();
    let error =
        (hermitian_product(&diff, &diff).re / hermitian_product(measured, measured).re).sqrt();
    (measured.len() == fitted.len() && error.is_finite()).then_some(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A real shape rotated by a phase is collinear; (1, i) is as complex as a shape can be; (1, i/2) has xx = 1, yy = ¼.
    #[test]
    fn exact_collinearity() {
        let z = Complex::new;
        let rotation = z(0.0, 0.4).exp();
        let real: Vec<Complex> = [1.0, -0.5, 0.2].iter().map(|&x| rotation * x).collect();
        assert!((phase_collinearity(&real) - 1.0).abs() < 1e-14);
        assert!((mean_phase(&real) - 0.4).abs() < 1e-14);
        assert!(mean_phase_deviation(&real) < 1e-7 && off_axis_share(&real) < 1e-14);
        assert!(phase_collinearity(&[z(1.0, 0.0), z(0.0, 1.0)]) < 1e-15);
        let half = [z(1.0, 0.0), z(0.0, 0.5)];
        assert!((phase_collinearity(&half) - 0.36).abs() < 1e-15);
        assert!((off_axis_share(&half) - 0.2).abs() < 1e-15);
        assert!((mean_phase_deviation(&half) - PI / 6.0).abs() < 1e-15);
    }

    #[test]
    fn exact_synthesis_error() {
        let measured = [Complex::new(3.0, 0.0), Complex::new(0.0, 4.0)];
        let fitted = [Complex::new(3.0, 0.5), Complex::new(0.0, 4.0)];
        assert!((synthesis_error(&measured, &fitted).unwrap() - 0.1).abs() < 1e-15);
        assert!(synthesis_error(&[Complex::ZERO], &[Complex::ONE]).is_none());
        assert!(frac(&measured, &measured.map(|z| z * 3.0)) > 1.0 - 1e-15);
    }
}
