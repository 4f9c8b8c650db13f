//! Zeros and gain of `H(s)` as eigenvalues of a state space, without polynomials.
//!
//! With `s = s₀ + 1/w` a form `C (s − A)⁻¹ B + D` becomes one of `Â = (A − s₀)⁻¹`, `B̂ = Â B`, `Ĉ = −C Â`, `D̂ = H(s₀)`, whose
//! direct term is not nil, so that the zeros are the eigenvalues of `Â − B̂ D̂⁻¹ Ĉ`: Emami-Naeini & Van Dooren, Automatica 18
//! (1982), pp. 415–430, eq. (6) for the zeros of a form with invertible D. Zeros at infinity are `w = 0`; their number is known
//! from the first moment `Σ R p^k` that does not vanish, and the leading coefficient is that moment. Newton's iteration on
//! `H(s)` gives back the digits that the map lost.

use super::function::TransferFunction;
use super::realisation::Realisation;
use crate::base::error::Error;
use crate::numeric::sorting::sort_falling;
use crate::numeric::{Complex, Matrix, eigen, symmetric};

/// A moment below this share of the sum of its terms' magnitudes is rounding of terms that cancel.
const MOMENT_TOLERANCE: f64 = 1e-12;

/// Steps of Newton's iteration, which doubles the digits of a simple zero at each.
const NEWTON_STEPS: usize = 4;

/// A zero that Newton's iteration moves by more than this share of the way to its neighbour is not simple: of two that scatter
/// about one, it would move each by a quarter.
const SIMPLE_ZERO_SHARE: f64 = 0.05;

/// Centres of the map, in units of the mean size of the poles; the one where H is least near a zero is taken.
const CENTRES: [f64; 4] = [1.0, 0.6, 1.7, 2.9];

/// `H = gain Π(s − z) / Π(s − p)`.
#[derive(Debug, Clone, PartialEq)]
pub struct ZerosAndGain {
    /// Every finite zero, rad/s, conjugates included, by rising size.
    pub zeros: Vec<Complex>,
    /// The leading coefficient: H at high frequency is `gain s^(zeros − poles)`.
    pub gain: f64,
}

impl TransferFunction {
    /// Zeros and leading coefficient of the function without its dead time; none and nil for a function that is nil.
    ///
    /// # Errors
    /// `NoConvergence` of the eigenvalues; `Overflow` where sizes leave the range of doubles.
    pub fn zeros(&self) -> Result<ZerosAndGain, Error> {
        let n = self.degree();
        let Some((relative_degree, gain)) = self.leading_term() else {
            return Ok(ZerosAndGain {
                zeros: Vec::new(),
                gain: 0.0,
            });
        };
        let finite = (n as i32 - relative_degree).max(0) as usize;
        if finite == 0 {
            return Ok(ZerosAndGain {
                zeros: Vec::new(),
                gain,
            });
        }
        let centre = self.map_centre();
        let mut inverse = self.mapped_zeros(centre)?;
        sort_falling(&mut inverse, |a| a.norm());
        inverse.truncate(finite);
        let zeros = inverse
            .into_iter()
            .filter(|w| *w != Complex::ZERO)
            .map(|w| w.inv() + centre);
        let rough: Vec<Complex> = zeros.collect();
        let mut zeros: Vec<Complex> = (0..rough.len())
            .map(|k| self.polish_zero(&rough, k))
            .collect();
        zeros.sort_by(|a, b| a.norm().total_cmp(&b.norm()).then(b.im.total_cmp(&a.im)));
        Ok(ZerosAndGain { zeros, gain })
    }

    /// Poles counted with conjugates and integrators.
    pub(super) fn degree(&self) -> usize {
        let own: usize = self
            .poles
            .iter()
            .map(|p| if p.im > 0.0 { 2 } else { 1 })
            .sum();
        own + self.direct.integrators()
    }

    /// Powers by which H falls at high frequency, and its coefficient; nothing where H is nil.
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
        let scale = self.mean_pole_size();
        let terms = self.poles_with_conjugates();
        let mut weights: Vec<Complex> = terms.iter().map(|t| t.1).collect();
        for k in 0..self.degree() as i32 {
            let lower = match k {
                0 => direct.inverse,
                1 => direct.inverse_square / scale,
                _ => 0.0,
            };
            let moment = weights.iter().map(|w| w.re).sum::<f64>() + lower;
            let size = weights.iter().map(|w| w.norm()).sum::<f64>() + lower.abs();
            if moment.abs() > MOMENT_TOLERANCE * size {
                return Some((k + 1, moment * scale.powi(k)));
            }
            weights
                .iter_mut()
                .zip(&terms)
                .for_each(|(w, t)| *w *= t.0 / scale);
        }
        None
    }

    /// Mean size of the poles that are not at zero, rad/s; 1 without one.
    fn mean_pole_size(&self) -> f64 {
        let sizes = self.poles.iter().map(|p| p.norm()).filter(|&x| x > 0.0);
        let logs: Vec<f64> = sizes.map(f64::ln).collect();
        if logs.is_empty() {
            return 1.0;
        }
        (logs.iter().sum::<f64>() / logs.len() as f64).exp()
    }

    fn map_centre(&self) -> f64 {
        let scale = self.mean_pole_size();
        let clear = |centre: &f64| {
            let s = Complex::new(centre * scale, 0.0);
            let terms = self
                .poles_with_conjugates()
                .iter()
                .map(|&(p, r)| (r / (s - p)).norm())
                .sum::<f64>();
            let share = self.value_without_delay(s).norm() / terms.max(f64::MIN_POSITIVE);
            if share.is_finite() { share } else { 0.0 }
        };
        let best = CENTRES.iter().max_by(|a, b| clear(a).total_cmp(&clear(b)));
        best.copied().unwrap_or(1.0) * scale
    }

    /// `1/(z − s₀)` of every zero z, and zeros for those at infinity.
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
        let inverted = if n == 0 {
            identity_and_b
        } else {
            symmetric::lu_solve(&shifted, &identity_and_b)?
        };
        let through = self.value_without_delay(Complex::new(centre, 0.0)).re;
        // E s and Q s² are (E + 2Q s₀)/w and Q/w²: one or two integrators in w.
        let (slope, square) = (
            self.direct.slope + 2.0 * self.direct.square * centre,
            self.direct.square,
        );
        let state = |i: usize, j: usize| match (i < n, j < n) {
            (true, true) => inverted[(i, j)],
            (false, false) => f64::from(u8::from(i == j + 1)),
            _ => 0.0,
        };
        let input = |i: usize| match i {
            i if i < n => inverted[(i, n)],
            i => f64::from(u8::from(i == n)),
        };
        let output = |j: usize| match j {
            j if j < n => -(0..n).map(|i| c[(0, i)] * inverted[(i, j)]).sum::<f64>(),
            j if j == n => slope,
            _ => square,
        };
        let rows: Vec<f64> = (0..n + excess).map(output).collect();
        let closed = Matrix::from_fn(n + excess, n + excess, |i, j| {
            state(i, j) - input(i) * rows[j] / through
        });
        Ok(eigen::eigen(&closed)?.values)
    }

    /// Newton's iteration, each step kept only while H shrinks, and all of them only for an isolated zero: those of a repeated zero scatter
    /// about it, and only together keep the digits of their sum and product.
    fn polish_zero(&self, zeros: &[Complex], k: usize) -> Complex {
        let mut zero = zeros[k];
        let others = (0..zeros.len())
            .filter(|&j| j != k)
            .map(|j| (zeros[j] - zeros[k]).norm());
        let room = SIMPLE_ZERO_SHARE * others.fold(f64::INFINITY, f64::min);
        let mut size = self.value_without_delay(zero).norm();
        for _ in 0..NEWTON_STEPS {
            let mut next =
                zero - self.value_without_delay(zero) / self.derivative_without_delay(zero);
            if zero.im == 0.0 {
                next.im = 0.0;
            }
            let smaller = self.value_without_delay(next).norm();
            if smaller >= size || !smaller.is_finite() {
                break;
            }
            if (next - zeros[k]).norm() > room {
                return zeros[k];
            }
            (zero, size) = (next, smaller);
        }
        zero
    }
}
