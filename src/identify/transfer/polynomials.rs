//! Numerator and denominator polynomials of a transfer function, with the error of expansion.

use super::function::TransferFunction;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::Complex;

/// Polynomial coefficients by decreasing powers of s (rad/s), with the error of the expansion.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferPolynomials {
    /// Numerator, b₀ first.
    pub numerator: Vec<f64>,
    /// Denominator, leading coefficient 1 first.
    pub denominator: Vec<f64>,
    /// Largest difference from the pole–residue form at frequencies of and between the poles, relative to the largest value there;
    /// infinite if a coefficient overflows.
    pub error: f64,
}

/// Largest relative error of the polynomials without a warning.
const MAX_EXPANSION_ERROR: f64 = 1e-6;

impl TransferFunction {
    /// Numerator and denominator polynomials of the transfer function without its delay.
    ///
    /// # Errors
    /// Those of [`TransferFunction::zeros`].
    pub fn polynomials(&self) -> Result<TransferPolynomials, Error> {
        let zeros = self.zeros()?;
        let poles = self.poles_with_conjugates().into_iter().map(|t| t.0);
        let integrators = std::iter::repeat_n(Complex::ZERO, self.direct.integrators());
        let denominator = product(poles.chain(integrators));
        let numerator = product(zeros.zeros.iter().copied());
        let numerator: Vec<f64> = numerator.into_iter().map(|b| b * zeros.gain).collect();
        let mut polynomials = TransferPolynomials {
            numerator,
            denominator,
            error: 0.0,
        };
        polynomials.error = self.difference(&polynomials);
        Ok(polynomials)
    }

    /// Relative error of the polynomials, evaluated on the imaginary axis at the modulus of every pole and at the geometric means between.
    fn difference(&self, polynomials: &TransferPolynomials) -> f64 {
        let mut moduli: Vec<f64> = self
            .poles
            .iter()
            .map(|p| p.norm())
            .filter(|&x| x > 0.0)
            .collect();
        moduli.sort_by(f64::total_cmp);
        let midpoints = moduli.windows(2).map(|w| (w[0] * w[1]).sqrt());
        let mut lines: Vec<f64> = moduli.iter().copied().chain(midpoints).collect();
        if lines.is_empty() {
            lines.push(1.0);
        }
        let (mut max_difference, mut largest) = (0.0_f64, f64::MIN_POSITIVE);
        for w in lines {
            let s = Complex::new(0.0, w);
            let exact = self.value_without_delay(s);
            if !exact.norm().is_finite() {
                continue; // an undamped pole
            }
            let difference = (polynomials.value(s) - exact).norm();
            if !difference.is_finite() {
                return f64::INFINITY;
            }
            max_difference = max_difference.max(difference);
            largest = largest.max(exact.norm());
        }
        max_difference / largest
    }
}

impl TransferPolynomials {
    /// Value of the quotient at s, rad/s.
    pub fn value(&self, s: Complex) -> Complex {
        let horner = |list: &[f64]| list.iter().fold(Complex::ZERO, |sum, &c| sum * s + c);
        horner(&self.numerator) / horner(&self.denominator)
    }

    /// Data-quality warning if the rounding error of the expansion exceeds `MAX_EXPANSION_ERROR`.
    pub fn warning(&self) -> Option<Diagnostic> {
        let degree = self.denominator.len().saturating_sub(1);
        (self.error > MAX_EXPANSION_ERROR).then(|| Diagnostic {
            code: "coefficients-lose-digits",
            message: format!(
                "the polynomials of degree {degree} differ from the original poles and residues by {:.1e} of the largest value",
                self.error
            ),
            hint: Some("use the poles and residues, or the state space, which keep full precision".into()),
        })
    }
}

/// Coefficients of `Π (s − root)` by decreasing powers, real because roots occur in conjugate pairs; multiplied from the smallest root.
fn product(roots: impl Iterator<Item = Complex>) -> Vec<f64> {
    let mut roots: Vec<Complex> = roots.collect();
    roots.sort_by(|a, b| {
        a.norm()
            .total_cmp(&b.norm())
            .then(a.im.abs().total_cmp(&b.im.abs()))
    });
    let mut coefficients = vec![Complex::ONE];
    for root in roots {
        coefficients.push(Complex::ZERO);
        for k in (1..coefficients.len()).rev() {
            let higher = coefficients[k - 1];
            coefficients[k] -= higher * root;
        }
    }
    coefficients.into_iter().map(|c| c.re).collect()
}
