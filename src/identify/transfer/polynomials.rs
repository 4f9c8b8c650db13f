//! Numerator and denominator polynomials of a transfer function, with the error of expansion.

use super::function::TransferFunction;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::Complex;

/// Coefficients by falling powers of s in rad/s, and how far to trust them.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferPolynomials {
    /// b₀ first.
    pub numerator: Vec<f64>,
    /// 1 first.
    pub denominator: Vec<f64>,
    /// Largest difference between their quotient and the poles' and residues' form near the poles and between them, as a
    /// share of the largest value there; infinite where a coefficient leaves the range of doubles.
    pub error: f64,
}

/// Above this the polynomials are no longer the function for engineering use.
const MAX_EXPANSION_ERROR: f64 = 1e-6;

impl TransferFunction {
    /// Numerator and denominator of the function without its dead time.
    ///
    /// # Errors
    /// Those of [`TransferFunction::zeros`].
    pub fn polynomials(&self) -> Result<TransferPolynomials, Error> {
        let found = self.zeros()?;
        let own = self.poles_with_conjugates().into_iter().map(|t| t.0);
        let integrators = std::iter::repeat_n(Complex::ZERO, self.direct.integrators());
        let denominator = product(own.chain(integrators));
        let numerator = product(found.zeros.iter().copied());
        let numerator: Vec<f64> = numerator.into_iter().map(|b| b * found.gain).collect();
        let mut polynomials = TransferPolynomials {
            numerator,
            denominator,
            error: 0.0,
        };
        polynomials.error = self.difference(&polynomials);
        Ok(polynomials)
    }

    /// Compared on the imaginary axis next to every pole and midway to the next.
    fn difference(&self, polynomials: &TransferPolynomials) -> f64 {
        let mut sizes: Vec<f64> = self
            .poles
            .iter()
            .map(|p| p.norm())
            .filter(|&x| x > 0.0)
            .collect();
        sizes.sort_by(f64::total_cmp);
        let between = sizes.windows(2).map(|w| (w[0] * w[1]).sqrt());
        let mut lines: Vec<f64> = sizes.iter().copied().chain(between).collect();
        if lines.is_empty() {
            lines.push(1.0);
        }
        let (mut worst, mut largest) = (0.0_f64, f64::MIN_POSITIVE);
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
            worst = worst.max(difference);
            largest = largest.max(exact.norm());
        }
        worst / largest
    }
}

impl TransferPolynomials {
    /// Their quotient at s, rad/s.
    pub fn value(&self, s: Complex) -> Complex {
        let horner = |list: &[f64]| list.iter().fold(Complex::ZERO, |sum, &c| sum * s + c);
        horner(&self.numerator) / horner(&self.denominator)
    }

    /// Data-quality warning where the expansion into polynomials has lost the function to rounding.
    pub fn warning(&self) -> Option<Diagnostic> {
        let degree = self.denominator.len().saturating_sub(1);
        (self.error > MAX_EXPANSION_ERROR).then(|| Diagnostic {
            code: "coefficients-lose-digits",
            message: format!(
                "the polynomials of degree {degree} differ from the poles and residues they were made from by {:.1e} of the largest value",
                self.error
            ),
            hint: Some("use the poles and residues, or the state space, which keep every digit".into()),
        })
    }
}

/// `Π (s − root)` by falling powers; real, as roots come in pairs. Multiplied from the smallest root on.
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
            let above = coefficients[k - 1];
            coefficients[k] -= above * root;
        }
    }
    coefficients.into_iter().map(|c| c.re).collect()
}
