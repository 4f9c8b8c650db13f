//! What the scatter of the covariances does to the poles, to first order.
//!
//! For a change ΔH of the Hankel matrix `H = U Σ Vᵀ`, with `G = Uᵀ ΔH V`, the first n left vectors turn out of their span by
//! `ΔU_j = Σ_{i>n} U_i X_ij`, `X_ij = (σ_j G_ij + σ_i G_ji)/(σ_j² − σ_i²)`; what happens inside the span is a change of basis, which
//! no pole sees. With `A = (U↑ᵀU↑)⁻¹U↑ᵀU↓`, `v = (U↑ᵀU↑)⁻¹χ`, `w = U↑v` and `e = U↓φ − λU↑φ`
//! `Δλ = wᴴ(ΔU↓φ − λΔU↑φ) + vᴴΔU↑ᵀe`. Reynders, Pintelon & De Roeck, Mech. Syst. Signal Process. 22 (2008); Döhler & Mevel, ibid. 38
//! (2013). The covariance is that of Δλ over the blocks; blocks that follow each other are not quite independent, which the weights of
//! Newey & West, Econometrica 55 (1987), take into account.

use super::covariances::Covariances;
use super::realisation::{Eigenpair, Observability};
use crate::numeric::factors::Svd;
use crate::numeric::{Complex, Matrix, definite};

/// Blocks whose neighbours are taken as related.
const RELATED: usize = 2;

/// Deviations of the blocks in the basis of the singular vectors.
pub(super) struct Scatter {
    sigma: Vec<f64>,
    /// `G_ij` of each block, i over all left vectors, j below the highest order.
    forward: Vec<Matrix>,
    /// `G_ji`, i over all right vectors, j below the highest order; transposed.
    backward: Vec<Matrix>,
}

impl Scatter {
    /// Of the Hankel matrices that `hankel` makes of each block's deviation.
    pub fn new(
        covariances: &Covariances,
        svd: &Svd,
        highest: usize,
        hankel: impl Fn(&[f64]) -> Matrix,
    ) -> Scatter {
        let v = svd.v.subcols(0, highest);
        let u = svd.u.subcols(0, highest);
        let (mut forward, mut backward) = (Vec::new(), Vec::new());
        for deviation in &covariances.deviations {
            let change = hankel(deviation);
            forward.push(svd.u.transpose() * (&change * v));
            backward.push(svd.v.transpose() * (change.transpose() * u));
        }
        Scatter {
            sigma: svd.values.clone(),
            forward,
            backward,
        }
    }

    /// Covariance of the real and imaginary part of the pole `rate · ln λ` of an eigenpair of order n.
    pub fn pole_covariance(
        &self,
        basis: &Observability,
        pair: &Eigenpair,
        rate_hz: f64,
    ) -> Option<[f64; 3]> {
        let n = pair.right.len();
        let weights = self.weights(basis, pair)?;
        let scale = pair.value.inv() * rate_hz;
        let changes: Vec<Complex> = (self.forward.iter().zip(&self.backward))
            .map(|(forward, backward)| {
                let mut sum = Complex::new(0.0, 0.0);
                for j in 0..n {
                    let (f, b) = (
                        &forward.col_as_slice(j)[n..],
                        &backward.col_as_slice(j)[n..],
                    );
                    let (wf, wb) = &weights[j];
                    sum += wf.iter().zip(f).map(|(w, g)| w * g).sum::<Complex>();
                    sum += wb.iter().zip(b).map(|(w, g)| w * g).sum::<Complex>();
                }
                sum * scale
            })
            .collect();
        long_run_covariance(&changes)
    }

    /// `∂λ/∂G_ij` and `∂λ/∂G_ji` for each j below n, i from n on.
    #[allow(clippy::type_complexity)] // two lists a column, named in the line above
    fn weights(
        &self,
        basis: &Observability,
        pair: &Eigenpair,
    ) -> Option<Vec<(Vec<Complex>, Vec<Complex>)>> {
        let n = pair.right.len();
        let rows = basis.rows;
        let all = basis.u.nrows();
        let gram = basis.gram.submatrix(0, 0, n, n).to_owned();
        let parts = Matrix::from_fn(n, 2, |i, k| {
            if k == 0 {
                pair.left[i].re
            } else {
                pair.left[i].im
            }
        });
        let solved = definite::solve(&gram, &parts).ok()?;
        let v: Vec<Complex> = (0..n)
            .map(|i| Complex::new(solved[(i, 0)], solved[(i, 1)]))
            .collect();
        let zero = Complex::new(0.0, 0.0);
        // U φ and U v over all rows.
        let (mut u_phi, mut u_v) = (vec![zero; all], vec![zero; all]);
        for j in 0..n {
            for (i, &u) in basis.u.col_as_slice(j).iter().enumerate() {
                u_phi[i] += pair.right[j] * u;
                u_v[i] += v[j] * u;
            }
        }
        // Row vectors with Δλ = Σ_j (alpha · ΔU_j) φ_j + (beta · ΔU_j) v̄_j.
        let kept = all - rows;
        let (mut alpha, mut beta) = (vec![zero; all], vec![zero; all]);
        for i in 0..kept {
            let w = u_v[i].conj();
            alpha[i + rows] += w;
            alpha[i] -= pair.value * w;
            beta[i] = u_phi[i + rows] - pair.value * u_phi[i];
        }
        let along = |row: &[Complex], i: usize| -> Complex {
            let column = basis.u.col_as_slice(i);
            row.iter().zip(column).map(|(r, u)| r * u).sum()
        };
        let ahead: Vec<(Complex, Complex)> = (n..all)
            .map(|i| (along(&alpha, i), along(&beta, i)))
            .collect();
        let right_vectors = self.backward.first().map_or(0, Matrix::nrows);
        Some(
            (0..n)
                .map(|j| {
                    let share = |k: usize| ahead[k].0 * pair.right[j] + ahead[k].1 * v[j].conj();
                    let sj = self.sigma[j];
                    let si = |i: usize| self.sigma.get(i).copied().unwrap_or(0.0);
                    let gap = |i: usize| (sj - si(i)) * (sj + si(i));
                    let forward = (n..all).map(|i| share(i - n) * (sj / gap(i))).collect();
                    let backward = (n..right_vectors)
                        .map(|i| match i < all {
                            true => share(i - n) * (si(i) / gap(i)),
                            false => zero,
                        })
                        .collect();
                    (forward, backward)
                })
                .collect(),
        )
    }
}

/// `Σ Σ w_{|k−l|} d_k d_lᵀ` of the real and imaginary parts, corrected for the mean that was taken off.
fn long_run_covariance(changes: &[Complex]) -> Option<[f64; 3]> {
    let blocks = changes.len();
    if blocks < 2 * (RELATED + 1) {
        return None;
    }
    let mut sums = [0.0; 3];
    for lag in 0..=RELATED {
        let weight = 1.0 - lag as f64 / (RELATED + 1) as f64;
        let both = if lag == 0 { weight } else { 2.0 * weight };
        for (a, b) in changes.iter().zip(&changes[lag..]) {
            sums[0] += both * a.re * b.re;
            sums[1] += both * a.im * b.im;
            sums[2] += both * 0.5 * (a.re * b.im + a.im * b.re);
        }
    }
    let correction = blocks as f64 / (blocks - 1) as f64;
    let found = sums.map(|s| s * correction);
    found.iter().all(|x| x.is_finite()).then_some(found)
}
