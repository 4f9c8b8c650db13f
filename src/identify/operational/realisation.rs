//! Poles and shapes by model order from the shift invariance of the extended observability matrix, `U↓ = U↑ A`.
//!
//! Peeters & De Roeck, Mech. Syst. Signal Process. 13 (1999), eqs. (20)–(27).
//!
//! The left singular vectors U of the n largest singular values of the block Hankel matrix H span `[C; CA; CA²; …]`. U↓ is U without its
//! first, U↑ without its last block row; `A φ = λ φ`, poles `rate · ln λ`, shapes `C φ`. With `U↑ᵀU↑` formed once, each order costs one
//! small linear solve and one eigenproblem.
//!
//! The projection of the future responses on the past references (Van Overschee & De Moor, Subspace Identification for Linear Systems
//! (1996), §3.3) has the left singular vectors of `H W`, `W Wᵀ` the inverse covariance of the past, so the covariances suffice.

use super::covariances::Covariances;
use crate::base::error::Error;
use crate::identify::modal::candidates::{CandidatePole, OrderPoles};
use crate::numeric::{Complex, Matrix, eigen, symmetric};

/// Right weighting matrix W of the block Hankel matrix.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Weighting {
    /// `W = I`: covariance-driven identification.
    #[default]
    Covariances,
    /// Inverse factor of the covariance of the past references: data-driven identification by projection.
    Projection,
}

/// Right singular vectors used for the parts of a record: twice the highest order, so that truncation has no effect.
const RETAINED_VECTORS: usize = 120;

/// Relative singular value below which values are rounding, because they result from squares.
const ROUNDING: f64 = 1e-7;

/// Observable subspaces of a record and of its leave-one-out replicates.
pub(super) struct Subspaces {
    /// Subspace of the full record.
    pub full: Observability,
    /// Subspace without each part.
    pub leave_one_out: Vec<Observability>,
}

impl Subspaces {
    /// Subspaces up to the order `highest`, or up to the numerical rank.
    ///
    /// # Errors
    /// Errors of the decompositions.
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
        let full = hankel(&covariances.mean);
        let weight = match weighting {
            Weighting::Covariances => None,
            Weighting::Projection => Some(inverse_factor(covariances, columns)?),
        };
        let weighted = match &weight {
            None => full.clone(),
            Some(weight) => &full * weight,
        };
        let (values, right) = symmetric::right_svd(&weighted)?;
        let n_vectors = RETAINED_VECTORS.min(right.ncols()).min(right.nrows());
        let right = right.subcols(0, n_vectors).to_owned();
        let right = match &weight {
            None => right,
            Some(weight) => weight * &right,
        };
        let replicate = |r: &[f64]| -> Result<Observability, Error> {
            let projected = &hankel(r) * &right;
            let gram = projected.transpose() * &projected;
            let eigen = symmetric::symmetric_eigen(&gram)?;
            let largest = eigen.values.last().copied().unwrap_or(0.0).max(0.0).sqrt();
            let rank = (eigen.values.iter())
                .filter(|v| v.max(0.0).sqrt() > ROUNDING * largest)
                .count();
            let highest = highest.min(rank);
            let vectors = Matrix::from_fn(n_vectors, highest, |i, j| {
                eigen.vectors[(i, n_vectors - 1 - j)] / eigen.values[n_vectors - 1 - j].sqrt()
            });
            Ok(Observability::new(&(&projected * &vectors), nc))
        };
        let rank = (values.iter())
            .filter(|v| **v > ROUNDING * values[0])
            .count();
        let size = highest.min(rank).min(n_vectors);
        let vectors = Matrix::from_fn(n_vectors, size, |i, j| match i == j {
            true => 1.0 / values[j],
            false => 0.0,
        });
        let projected = &(&full * &right) * &vectors;
        Ok(Subspaces {
            full: Observability::new(&projected, nc),
            leave_one_out: (0..covariances.parts.len())
                .map(|k| replicate(&covariances.leave_out(k)))
                .collect::<Result<_, Error>>()?,
        })
    }
}

/// Factor W with `W Wᵀ = P⁻¹`; P: covariance of the references at `columns` consecutive samples, the latest first.
fn inverse_factor(covariances: &Covariances, columns: usize) -> Result<Matrix, Error> {
    /// Lower bound of the eigenvalues of P relative to the largest: a decimated signal has no power near half its sample rate, where the
    /// estimated eigenvalues may be negative.
    const MIN_EIGENVALUE_SHARE: f64 = 1e-4;
    let nr = covariances.references.len();
    let r = |lag: usize, a: usize, b: usize| covariances.value(lag, covariances.references[a], b);
    let size = columns * nr;
    let past = Matrix::from_fn(size, size, |i, j| {
        // index i is reference i % nr, i / nr samples before the latest
        let (later, earlier) = if i / nr <= j / nr { (i, j) } else { (j, i) };
        let lag = earlier / nr - later / nr;
        match lag {
            0 => 0.5 * (r(0, later % nr, earlier % nr) + r(0, earlier % nr, later % nr)),
            _ => r(lag, later % nr, earlier % nr),
        }
    });
    let eigen = symmetric::symmetric_eigen(&past)?;
    let least = MIN_EIGENVALUE_SHARE * eigen.values.last().copied().unwrap_or(0.0).max(0.0);
    Ok(Matrix::from_fn(size, size, |i, j| {
        eigen.vectors[(i, j)] / eigen.values[j].max(least).sqrt()
    }))
}

/// Matrix products of the observability matrix whose leading blocks give every order.
pub(super) struct Observability {
    /// First block row, C.
    output: Matrix,
    /// `U↑ᵀU↑`.
    gram: Matrix,
    /// `U↑ᵀU↓`.
    shifted: Matrix,
}

impl Observability {
    /// Products of left singular vectors `u` with block rows of `responses` rows.
    fn new(u: &Matrix, responses: usize) -> Observability {
        let rows = u.nrows() - responses;
        let up = u.submatrix(0, 0, rows, u.ncols());
        let down = u.submatrix(responses, 0, rows, u.ncols());
        Observability {
            output: u.submatrix(0, 0, responses, u.ncols()).to_owned(),
            gram: up.transpose() * up,
            shifted: up.transpose() * down,
        }
    }

    /// Highest available order.
    pub fn highest(&self) -> usize {
        self.gram.nrows()
    }

    /// Poles of order `n` with positive imaginary part, rad/s, and their shapes; empty above the highest available order.
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

/// Continuous-time pole `rate · ln λ` of a discrete-time eigenvalue, rad/s.
fn to_continuous(value: Complex, rate_hz: f64) -> Complex {
    Complex::new(value.norm().ln(), value.im.atan2(value.re)) * rate_hz
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Exact covariances of two modes at three channels, `R_τ = Σ_m φ_m g_mᵀ Re(λ_m^τ)`, give poles and shapes with both weightings.
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
                let decay = (-zeta * w * t).exp() * (w * f64::sqrt(1.0 - zeta * zeta) * t).cos();
                for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                    mean[(lag * 3 + r) * 3 + c] += shape(m, r) * shape(m, c) * decay;
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
            let subspaces = Subspaces::new(&covariances, weighting, 60).unwrap();
            for subspace in subspaces.leave_one_out.iter().chain([&subspaces.full]) {
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
