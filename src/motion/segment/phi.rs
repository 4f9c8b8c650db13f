//! The functions `φ` of exponential integration, without loss of digits near zero.
//!
//! With `E = e^{λτ}`: `Φ₁ = (E − 1)/λ`, `Φ₂ = (Φ₁ − τ)/λ`, `Φ₃ = (Φ₂ − τ²/2)/λ`: what a constant, a straight line and its
//! integral leave after τ (Hochbruck & Ostermann, Exponential integrators, Acta Numerica 19 (2010), §2).

use crate::numeric::Complex;

/// 1/0! … 1/23!.
const INVERSE_FACTORIALS: [f64; 24] = {
    let mut all = [1.0; 24];
    let mut n = 1;
    while n < all.len() {
        all[n] = all[n - 1] / n as f64;
        n += 1;
    }
    all
};

/// `E, Φ₁, Φ₂, Φ₃` of a real λ after τ.
pub fn phi_real(lambda: f64, tau: f64) -> [f64; 4] {
    if lambda == 0.0 {
        let half = 0.5 * tau * tau;
        return [1.0, tau, half, half * tau / 3.0];
    }
    let x = lambda * tau;
    if x.abs() < 1.0 {
        // Σ xⁿ/(n+3)! by even and odd powers: 10 pairs are exact to rounding below one, 7 below a third, 5 below a sixteenth.
        let pairs = match x.abs() {
            size if size < 0.0625 => 5,
            size if size < 0.35 => 7,
            _ => 10,
        };
        let square = x * x;
        let sums = |[even, odd]: [f64; 2], n: usize| {
            let next = [INVERSE_FACTORIALS[2 * n + 3], INVERSE_FACTORIALS[2 * n + 4]];
            [even * square + next[0], odd * square + next[1]]
        };
        let [even, odd] = (0..pairs).rev().fold([0.0; 2], sums);
        let series = even + odd * x;
        let third = series * tau * tau * tau;
        let second = 0.5 * tau * tau + lambda * third;
        let first = tau + lambda * second;
        return [1.0 + lambda * first, first, second, third];
    }
    let first = x.exp_m1() / lambda;
    let second = (first - tau) / lambda;
    [x.exp(), first, second, (second - 0.5 * tau * tau) / lambda]
}

/// `eˣ − 1` by seven terms of its series, for |x| below a fiftieth.
pub fn exp_m1(x: Complex) -> Complex {
    let sum = |sum: Complex, n: usize| sum * x + INVERSE_FACTORIALS[n];
    (1..7)
        .rev()
        .fold(Complex::new(INVERSE_FACTORIALS[7], 0.0), sum)
        * x
}

/// `(eˣ − 1)/x` and `(eˣ − 1 − x)/x²` by their series, for |x| below [`SERIES_RADIUS`].
pub fn phi_series(x: Complex) -> (Complex, Complex) {
    let second = (0..14)
        .rev()
        .fold(Complex::ZERO, |sum, n| sum * x + INVERSE_FACTORIALS[n + 2]);
    (second * x + 1.0, second)
}

/// Radius within which [`phi_series`] is exact to rounding.
pub const SERIES_RADIUS: f64 = 0.5;

/// `(e^{κτ} − 1)/κ`, also where κ is zero or nearly so.
pub fn phi_1(kappa: Complex, tau: f64) -> Complex {
    let x = kappa * tau;
    match x.norm() < SERIES_RADIUS {
        true => phi_series(x).0 * tau,
        false => (x.exp() - 1.0) / kappa,
    }
}

/// `e^{λτ}` convolved with `e^{iωτ}`, and the integral of that, for a real λ and any ω: divided differences of the exponential
/// over (iω, λ) and (iω, λ, 0).
pub fn forced_response(lambda: f64, omega: f64, tau: f64) -> (Complex, Complex) {
    let (x, y) = (Complex::new(0.0, omega * tau), lambda * tau);
    if x.norm().max(y.abs()) < 1.0 {
        // Complete homogeneous polynomials h_n(x, y) over (n+1)! and (n+2)!.
        let (mut h, mut power) = (Complex::ONE, 1.0);
        let (mut rate, mut place) = (Complex::ZERO, Complex::ZERO);
        for n in 0..22 {
            rate += h * INVERSE_FACTORIALS[n + 1];
            place += h * INVERSE_FACTORIALS[n + 2];
            power *= y;
            h = h * x + power;
        }
        return (rate * tau, place * (tau * tau));
    }
    let kappa = Complex::new(-lambda, omega);
    let [e, by_lambda, ..] = phi_real(lambda, tau);
    let by_omega = phi_1(Complex::new(0.0, omega), tau);
    ((x.exp() - e) / kappa, (by_omega - by_lambda) / kappa)
}

/// `e^{−aτ} cosh √D τ` and `e^{−aτ} sinh √D τ / √D`, `D = a² − w²`.
pub fn damped_pair(a: f64, square: f64, tau: f64) -> (f64, f64) {
    let d = a * a - square;
    let x = d * tau * tau;
    if x.abs() < 0.01 {
        let e = (-a * tau).exp();
        // Σ xⁿ/(2n)! and Σ xⁿ/(2n+1)!
        let c = 1.0 + x / 2.0 * (1.0 + x / 12.0 * (1.0 + x / 30.0 * (1.0 + x / 56.0)));
        let s = 1.0 + x / 6.0 * (1.0 + x / 20.0 * (1.0 + x / 42.0 * (1.0 + x / 72.0)));
        return (e * c, e * s * tau);
    }
    let root = d.abs().sqrt();
    if d > 0.0 {
        let (slow, fast) = (((root - a) * tau).exp(), ((-root - a) * tau).exp());
        (0.5 * (slow + fast), 0.5 * (slow - fast) / root)
    } else {
        let e = (-a * tau).exp();
        let (s, c) = (root * tau).sin_cos();
        (e * c, e * s / root)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both branches agree where they meet, and the recurrence holds.
    #[test]
    fn law_branches_meet() {
        for lambda in [0.9999999, 1.0000001, -0.9999999, -1.0000001] {
            let [e, f1, f2, f3] = phi_real(lambda, 1.0);
            assert!((e - f64::exp(lambda)).abs() < 1e-15 * 4.0);
            assert!((1.0 + lambda * f1 - e).abs() < 4e-15);
            assert!((1.0 + lambda * f2 - f1).abs() < 4e-15);
            assert!((0.5 + lambda * f3 - f2).abs() < 8e-15);
        }
        for x in [0.4999999, 0.5000001] {
            let kappa = Complex::new(0.6, 0.8) * x;
            let exact = (kappa.exp() - 1.0) / kappa;
            assert!((phi_1(kappa, 1.0) - exact).norm() < 1e-15);
        }
    }

    /// Without λ and ω: τ and τ²/2; with both, against the integral by Gauss points.
    #[test]
    fn exact_limits() {
        assert_eq!(phi_real(0.0, 2.0), [1.0, 2.0, 2.0, 8.0 / 6.0]);
        let (rate, place) = forced_response(0.0, 0.0, 2.0);
        assert!((rate - 2.0).norm() < 1e-15 && (place - 2.0).norm() < 1e-15);
        let (rate, place) = forced_response(-0.0, 3.0, 2.0);
        assert!((rate - Complex::new(6f64.sin(), 1.0 - 6f64.cos()) / 3.0).norm() < 1e-15);
        assert!((place.re - (1.0 - 6f64.cos()) / 9.0).abs() < 1e-15);
        let near = forced_response(-0.3, 0.4999999, 2.0);
        let far = forced_response(-0.3, 0.5000001, 2.0);
        assert!((near.0 - far.0).norm() < 1e-6 && (near.1 - far.1).norm() < 1e-6);
    }
}
