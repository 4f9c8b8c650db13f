//! Poles and shapes per order from the extended observability matrix (shift invariance).
//!
//! Peeters & De Roeck, Mech. Syst. Signal Process. 13 (1999), eqs. (20)–(27).
//!
//! The columns of U that belong to the n largest singular values of H span `[C; CA; CA²; …]` in some basis, so that `U↓ = U↑ A` without
//! its first and last block row; `A φ = λ φ`, poles `rate · ln λ`, shapes `C φ`. With `U↑ᵀU↑` formed once, an order costs one small
//! solve and one eigenproblem.
//!
//! The projection of the future of all responses on the past of the references (Van Overschee & De Moor, Subspace Identification for
//! Linear Systems (1996), §3.3) has the left vectors of `H W`, `W Wᵀ` the inverse covariance of that past: the same covariances tell it.

use super::covariances::Covariances;
use crate::base::error::Error;
use crate::identify::modal::candidates::{CandidatePole, OrderPoles};
use crate::numeric::{Complex, Matrix, eigen, symmetric};

/// Right multiplier of the Hankel matrix.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Weighting {
    /// None: identification from covariances.
    #[default]
    Covariances,
    /// The inverse factor of the covariance of the past: identification from data by projection.
    Projection,
}

/// Right singular vectors kept for the parts of a record: twice the highest order, so that what is cut off does not couple.
const RETAINED_VECTORS: usize = 120;

/// Singular values below this share of the largest are rounding, for they come from squares.
const ROUNDING: f64 = 1e-7;

/// The observable subspace of a record, and of the record with each of its parts left out.
pub(super) struct Subspaces {
    /// From all parts.
    pub whole: Observability,
    /// Without each part.
    pub without: Vec<Observability>,
}

impl Subspaces {
    /// Up to the order `highest`, or to what the singular values carry.
    ///
    /// # Errors
    /// Those of the decompositions.
    pub fn new(
        covariances: &Covariances,
        weighting: Weighting,
        highest: usize,
    ) -> Result<Subspaces, Error> {
        let (nc, nr) = (covariances.channels, covariances.references.len());
        let columns = covariances.lags / 2;
        let hankel = |r: &[f64]| {
            Matrix::from_fn((columns + 1) * nc, columns * nr, |i, j| {
                r[((i / nc + j / nr + 1) * nr + j % nr) * nc + i % nc]
            })
        };
        let whole = hankel(&covariances.mean);
        let weight = match weighting {
            Weighting::Covariances => None,
            Weighting::Projection => Some(inverse_factor(covariances, columns)?),
        };
        let weighted = match &weight {
            None => whole.clone(),
            Some(weight) => &whole * weight,
        };
        let (values, right) = symmetric::right_svd(&weighted)?;
        let kept = RETAINED_VECTORS.min(right.ncols()).min(right.nrows());
        let right = right.subcols(0, kept).to_owned();
        let right = match &weight {
            None => right,
            Some(weight) => weight * &right,
        };
        let left = |r: &[f64]| -> Result<Observability, Error> {
            let projected = &hankel(r) * &right;
            let gram = projected.transpose() * &projected;
            let found = symmetric::symmetric_eigen(&gram)?;
            let largest = found.values.last().copied().unwrap_or(0.0).max(0.0).sqrt();
            let carried = (found.values.iter())
                .filter(|v| v.max(0.0).sqrt() > ROUNDING * largest)
                .count();
            let highest = highest.min(carried);
            let vectors = Matrix::from_fn(kept, highest, |i, j| {
                found.vectors[(i, kept - 1 - j)] / found.values[kept - 1 - j].sqrt()
            });
            Ok(Observability::new(&(&projected * &vectors), nc))
        };
        let carried = (values.iter())
            .filter(|v| **v > ROUNDING * values[0])
            .count();
        let size = highest.min(carried).min(kept);
        let vectors = Matrix::from_fn(kept, size, |i, j| match i == j {
            true => 1.0 / values[j],
            false => 0.0,
        });
        let projected = &(&whole * &right) * &vectors;
        Ok(Subspaces {
            whole: Observability::new(&projected, nc),
            without: (0..covariances.parts.len())
                .map(|k| left(&covariances.without(k)))
                .collect::<Result<_, Error>>()?,
        })
    }
}

/// `W` with `W Wᵀ = P⁻¹`, P the covariance of the references at `columns` consecutive samples, the latest first.
fn inverse_factor(covariances: &Covariances, columns: usize) -> Result<Matrix, Error> {
    /// Eigenvalues of P below this share of the largest are raised to it: a decimated signal has no power near half its rate, and what the
    /// estimate holds there may be negative.
    const MIN_EIGENVALUE_SHARE: f64 = 1e-4;
    let nr = covariances.references.len();
    let at = |lag: usize, a: usize, b: usize| covariances.value(lag, covariances.references[a], b);
    let size = columns * nr;
    let past = Matrix::from_fn(size, size, |i, j| {
        // column i holds reference i % nr at i / nr samples before
        let (later, earlier) = if i / nr <= j / nr { (i, j) } else { (j, i) };
        let lag = earlier / nr - later / nr;
        match lag {
            0 => 0.5 * (at(0, later % nr, earlier % nr) + at(0, earlier % nr, later % nr)),
            _ => at(lag, later % nr, earlier % nr),
        }
    });
    let found = symmetric::symmetric_eigen(&past)?;
    let least = MIN_EIGENVALUE_SHARE * found.values.last().copied().unwrap_or(0.0).max(0.0);
    Ok(Matrix::from_fn(size, size, |i, j| {
        found.vectors[(i, j)] / found.values[j].max(least).sqrt()
    }))
}

/// The products every order is cut from.
pub(super) struct Observability {
    /// The first block row, C.
    output: Matrix,
    /// `U↑ᵀU↑`.
    gram: Matrix,
    /// `U↑ᵀU↓`.
    shifted: Matrix,
}

impl Observability {
    /// Observability matrix from left singular vectors with block rows of so many responses.
    fn new(u: &Matrix, responses: usize) -> Observability {
        let kept = u.nrows() - responses;
        let up = u.submatrix(0, 0, kept, u.ncols());
        let down = u.submatrix(responses, 0, kept, u.ncols());
        Observability {
            output: u.submatrix(0, 0, responses, u.ncols()).to_owned(),
            gram: up.transpose() * up,
            shifted: up.transpose() * down,
        }
    }

    /// The highest order.
    pub fn highest(&self) -> usize {
        self.gram.nrows()
    }

    /// Poles of order `n` above the real axis with their shapes; none where the order is beyond what the data carry.
    pub fn poles(&self, n: usize, rate_hz: f64) -> OrderPoles {
        let poles = match n <= self.highest() {
            true => self.eigenpairs(n, rate_hz).unwrap_or_default(),
            false => Vec::new(),
        };
        OrderPoles::new(n, poles)
    }

    fn eigenpairs(&self, n: usize, rate_hz: f64) -> Result<Vec<CandidatePole>, Error> {
        let gram = self.gram.submatrix(0, 0, n, n).to_owned();
        let shifted = self.shifted.submatrix(0, 0, n, n).to_owned();
        let a = symmetric::lu_solve(&gram, &shifted)?;
        let (values, right) = eigen::right_eigen(&a)?;
        let shape = |k: usize| {
            let component = |c: usize| {
                (0..n)
                    .map(|j| right[(j, k)] * self.output[(c, j)])
                    .sum::<Complex>()
            };
            (0..self.output.nrows()).map(component).collect()
        };
        Ok((0..n)
            .filter(|&k| values[k].im > 0.0)
            .map(|k| CandidatePole {
                pole: to_continuous(values[k], rate_hz),
                shape: shape(k),
                participation: Vec::new(),
            })
            .collect())
    }
}

/// The continuous pole of a discrete one, rad/s.
fn to_continuous(value: Complex, rate_hz: f64) -> Complex {
    Complex::new(value.norm().ln(), value.im.atan2(value.re)) * rate_hz
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// `R_τ = Σ_m φ_m g_mᵀ Re(λ_m^τ)` of two modes at three channels gives their poles and shapes, by both weightings.
    #[test]
    fn exact_from_exact_covariances() {
        let poles: [(f64, f64); 2] = [(6.0, 0.01), (17.0, 0.03)];
        let (rate, lags) = (100.0, 40);
        let shape = |m: usize, k: usize| ((m + 1) as f64 * (k + 1) as f64 * 0.7).sin();
        let mut mean = vec![0.0; (lags + 1) * 9];
        for (m, (f, zeta)) in poles.iter().enumerate() {
            let w = TAU * f;
            for lag in 0..=lags {
                let t = lag as f64 / rate;
                let wave = (-zeta * w * t).exp() * (w * f64::sqrt(1.0 - zeta * zeta) * t).cos();
                for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                    mean[(lag * 3 + r) * 3 + c] += shape(m, r) * shape(m, c) * wave;
                }
            }
        }
        let covariances = Covariances {
            channels: 3,
            references: vec![0, 1, 2],
            lags,
            counts: vec![500, 500],
            parts: vec![mean.clone(); 2],
            mean,
        };
        for weighting in [Weighting::Covariances, Weighting::Projection] {
            let found = Subspaces::new(&covariances, weighting, 60).unwrap();
            for subspace in found.without.iter().chain([&found.whole]) {
                assert_eq!(subspace.highest(), 4);
                let modes = subspace.poles(4, rate).poles;
                for (m, (mode, (f, zeta))) in modes.iter().zip(poles).enumerate() {
                    assert!((mode.pole.norm() / TAU / f - 1.0).abs() < 1e-8, "{mode:?}");
                    assert!((mode.damping_ratio() - zeta).abs() < 1e-8, "{mode:?}");
                    for k in 1..3 {
                        let ratio = mode.shape[k] / mode.shape[0];
                        assert!((ratio - shape(m, k) / shape(m, 0)).norm() < 1e-6);
                    }
                }
            }
        }
    }
}
