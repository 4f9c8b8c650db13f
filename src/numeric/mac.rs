//! Modal assurance criterion: `|aᴴb|² / (aᴴa bᴴb)`.
//!
//! Modal assurance criterion: Allemang, Sound & Vibration 37 (2003), no. 8, 14–23.

use super::Complex;

/// `aᴴ b`.
pub fn hermitian_product(a: &[Complex], b: &[Complex]) -> Complex {
    a.iter()
        .zip(b)
        .fold(Complex::ZERO, |sum, (x, y)| sum + x.conj() * y)
}

/// `|aᴴb|² / (aᴴa bᴴb)`, 0 to 1; 0 where a vector is zero or not finite.
pub fn mac(a: &[Complex], b: &[Complex]) -> f64 {
    let mac = hermitian_product(a, b).norm_sqr()
        / (hermitian_product(a, a).re * hermitian_product(b, b).re);
    if mac.is_finite() { mac.min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A factor changes nothing, a right angle gives 0, (1, 0) and (1, i) one half.
    #[test]
    fn exact_angles() {
        let z = Complex::new;
        let a = [z(1.0, 2.0), z(-0.5, 0.0)];
        let turned: Vec<Complex> = a.iter().map(|x| x * z(0.3, -4.0)).collect();
        assert!((mac(&a, &turned) - 1.0).abs() < 1e-15);
        let (x, y) = ([z(1.0, 0.0), z(0.0, 0.0)], [z(0.0, 0.0), z(0.0, 3.0)]);
        assert_eq!(mac(&x, &y), 0.0);
        assert!((mac(&x, &[z(1.0, 0.0), z(0.0, 1.0)]) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn survives_zero_and_nan() {
        let zero = [Complex::ZERO; 2];
        assert_eq!(mac(&zero, &zero), 0.0);
        assert_eq!(mac(&[Complex::new(f64::NAN, 0.0)], &[Complex::ONE]), 0.0);
    }
}
