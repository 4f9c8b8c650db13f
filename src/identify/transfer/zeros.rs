//! Zeros and gain of `H(s)` as eigenvalues of a state space, without polynomials.
//!
//! With `s = s₀ + 1/w` the form `C (s − A)⁻¹ B + D` becomes one of `Â = (A − s₀)⁻¹`, `B̂ = Â B`, `Ĉ = −C Â`, `D̂ = H(s₀)` with nonzero
//! direct term, so that the zeros are the eigenvalues of `Â − B̂ D̂⁻¹ Ĉ`: Emami-Naeini & Van Dooren, Automatica 18
//! (1982), pp. 415–430, eq. (6) for the zeros of a form with invertible D. Zeros at infinity are `w = 0`; their number follows
//! from the first moment `Σ R p^k` that does not vanish, which is also the leading coefficient. Newton's iteration on
//! `H(s)` restores the digits lost in the map.

use super::function::TransferFunction;
use super::realisation::Realisation;
use crate::base::error::Error;
use crate::numeric::sorting::sort_descending;
use crate::numeric::{Complex, Matrix, eigen, symmetric};

/// Largest magnitude of a vanishing moment, relative to the sum of the magnitudes of its terms: rounding of terms that cancel.
const MOMENT_TOLERANCE: f64 = 1e-12;

/// Number of Newton steps; each doubles the correct digits of a simple zero.
const NEWTON_STEPS: usize = 4;

/// Largest Newton correction of a simple zero, relative to the distance to its neighbour: zeros scattered about a double zero would each
/// move by a quarter.
const SIMPLE_ZERO_SHARE: f64 = 0.05;

/// Trial centres s₀ of the map in units of the mean pole modulus; the one farthest from a zero of H is chosen.
const CENTRES: [f64; 4] = [1.0, 0.6, 1.7, 2.9];

/// Zeros and gain of `H = gain Π(s − z) / Π(s − p)`.
#[derive(Debug, Clone, PartialEq)]
pub struct ZerosAndGain {
    /// Finite zeros, rad/s, conjugates included, by increasing modulus.
    pub zeros: Vec<Complex>,
    /// Leading coefficient: H tends to `gain s^(n_zeros − n_poles)` at high frequency.
    pub gain: f64,
}

impl TransferFunction {
    /// Zeros and leading coefficient of the transfer function without its delay; no zeros and gain 0 if the function is zero.
    ///
    /// # Errors
    /// `NoConvergence` of the eigenvalues; `Overflow` if a value exceeds the range of doubles.
    pub fn zeros(&self) -> Result<ZerosAndGain, Error> {
        let n = self.degree();
        let Some((relative_degree, gain)) = self.leading_term() else {
            return Ok(ZerosAndGain {
                zeros: Vec::new(),
                gain: 0.0,
            });
        };
        let n_finite = (n as i32 - relative_degree).max(0) as usize;
        if n_finite == 0 {
            return Ok(ZerosAndGain {
                zeros: Vec::new(),
                gain,
            });
        }
        let centre = self.map_centre();
        let mut inverse = self.mapped_zeros(centre)?;
        sort_descending(&mut inverse, |a| a.norm());
        inverse.truncate(n_finite);
        let zeros = inverse
            .into_iter()
            .filter(|w| *w != Complex::ZERO)
            .map(|w| w.inv() + centre);
        let estimates: Vec<Complex> = zeros.collect();
        let mut zeros: Vec<Complex> = (0..estimates.len())
            .map(|k| self.refine_zero(&estimates, k))
            .collect();
        zeros.sort_by(|a, b| a.norm().total_cmp(&b.norm()).then(b.im.total_cmp(&a.im)));
        Ok(ZerosAndGain { zeros, gain })
    }

    /// Number of poles, conjugates and integrators included.
    pub(super) fn degree(&self) -> usize {
        let n_poles: usize = self
            .poles
            .iter()
            .map(|p| if p.im > 0.0 { 2 } else { 1 })
            .sum();
        n_poles + self.direct.integrators()
    }

    /// Relative degree and leading coefficient of H at high frequency; `None` if H is zero.
    fn leading_term(&self) -> Option<(i32, f64)> {
        let direct = self.direct;
        for (coefficient, power) in [
            (direct.square, -2),
            (direct.slope, -1),
            (direct.constant, 0),
        ] {
            if coefficient != 0.0 {
                return Some((power, coefficient));
            }
        }
        let scale = self.mean_pole_modulus();
        let terms = self.poles_with_conjugates();
        let mut weights: Vec<Complex> = terms.iter().map(|t| t.1).collect();
        for k in 0..self.degree() as i32 {
            let lower = match k {
                0 => direct.inverse,
                1 => direct.inverse_square / scale,
                _ => 0.0,
            };
            let moment = weights.iter().map(|w| w.re).sum::<f64>() + lower;
            let magnitude = weights.iter().map(|w| w.norm()).sum::<f64>() + lower.abs();
            if moment.abs() > MOMENT_TOLERANCE * magnitude {
                return Some((k + 1, moment * scale.powi(k)));
            }
            weights
                .iter_mut()
                .zip(&terms)
                .for_each(|(w, t)| *w *= t.0 / scale);
        }
        None
    }

    /// Geometric mean modulus of the nonzero poles, rad/s; 1 without any.
    fn mean_pole_modulus(&self) -> f64 {
        let moduli = self.poles.iter().map(|p| p.norm()).filter(|&x| x > 0.0);
        let logs: Vec<f64> = moduli.map(f64::ln).collect();
        if logs.is_empty() {
            return 1.0;
        }
        (logs.iter().sum::<f64>() / logs.len() as f64).exp()
    }

    fn map_centre(&self) -> f64 {
        let scale = self.mean_pole_modulus();
        let ratio = |centre: &f64| {
            let s = Complex::new(centre * scale, 0.0);
            let terms = self
                .poles_with_conjugates()
                .iter()
                .map(|&(p, r)| (r / (s - p)).norm())
                .sum::<f64>();
            let share = self.value_without_delay(s).norm() / terms.max(f64::MIN_POSITIVE);
            if share.is_finite() { share } else { 0.0 }
        };
        let best = CENTRES.iter().max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        best.copied().unwrap_or(1.0) * scale
    }

    /// Mapped zeros `1/(z − s₀)` of every zero z; 0 for zeros at infinity.
    fn mapped_zeros(&self, centre: f64) -> Result<Vec<Complex>, Error> {
        let mut proper = self.clone();
        (proper.direct.slope, proper.direct.square, proper.delay_s) = (0.0, 0.0, 0.0);
        let Realisation { a, b, c, .. } = Realisation::from_transfer_functions(&[proper])?;
        let (n, excess) = (a.nrows(), self.direct.polynomial_degree());
        let shifted = Matrix::from_fn(n, n, |i, j| a[(i, j)] - if i == j { centre } else { 0.0 });
        let identity_and_b = Matrix::from_fn(n, n + 1, |i, j| {
            if j < n {
                f64::from(u8::from(i == j))
            } else {
                b[(i, 0)]
            }
        });
        let inverse = if n == 0 {
            identity_and_b
        } else {
            symmetric::lu_solve(&shifted, &identity_and_b)?
        };
        let direct = self.value_without_delay(Complex::new(centre, 0.0)).re;
        // E s and Q s² are (E + 2Q s₀)/w and Q/w²: one or two integrators in w.
        let (slope, square) = (
            self.direct.slope + 2.0 * self.direct.square * centre,
            self.direct.square,
        );
        let state = |i: usize, j: usize| match (i < n, j < n) {
            (true, true) => inverse[(i, j)],
            (false, false) => f64::from(u8::from(i == j + 1)),
            _ => 0.0,
        };
        let input = |i: usize| match i {
            i if i < n => inverse[(i, n)],
            i => f64::from(u8::from(i == n)),
        };
        let output = |j: usize| match j {
            j if j < n => -(0..n).map(|i| c[(0, i)] * inverse[(i, j)]).sum::<f64>(),
            j if j == n => slope,
            _ => square,
        };
        let rows: Vec<f64> = (0..n + excess).map(output).collect();
        let zero_matrix = Matrix::from_fn(n + excess, n + excess, |i, j| {
            state(i, j) - input(i) * rows[j] / direct
        });
        Ok(eigen::eigen(&zero_matrix)?.values)
    }

    /// Refines a zero by Newton's iteration while |H| decreases. Zeros that are not isolated are returned unchanged: the zeros scattered
    /// about a repeated zero have an accurate sum and product only together.
    fn refine_zero(&self, zeros: &[Complex], k: usize) -> Complex {
        let mut zero = zeros[k];
        let distances = (0..zeros.len())
            .filter(|&j| j != k)
            .map(|j| (zeros[j] - zeros[k]).norm());
        let max_correction = SIMPLE_ZERO_SHARE * distances.fold(f64::INFINITY, f64::min);
        let mut magnitude = self.value_without_delay(zero).norm();
        for _ in 0..NEWTON_STEPS {
            let mut next =
                zero - self.value_without_delay(zero) / self.derivative_without_delay(zero);
            if zero.im == 0.0 {
                next.im = 0.0;
            }
            let next_magnitude = self.value_without_delay(next).norm();
            if next_magnitude >= magnitude || !next_magnitude.is_finite() {
                break;
            }
            if (next - zeros[k]).norm() > max_correction {
                return zeros[k];
            }
            (zero, magnitude) = (next, next_magnitude);
        }
        zero
    }
}
