//! Rational fraction polynomials (RFP): `H ≈ B(s)/A(s)`, Forsythe polynomials, one denominator.
//!
//! Richardson & Formenti, IMAC I (1982), 167–181; over several responses IMAC III (1985). Forsythe's recurrence over ±ω,
//! `s q_k = b_{k+1} q_{k+1} − b_k q_{k−1}`, has real coefficients. A is orthogonal with weight `Σ|H|²`, B with weight 1; roots are the
//! eigenvalues of the comrade matrix, so that no power of s is ever formed.

use std::f64::consts::TAU;

use super::candidates::{CandidatePole, OrderPoles, half_power_band_is_inside};
use super::measured_frf::MeasuredFrf;
use super::nested_cholesky::NestedCholesky;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::eigen::eigenvalues;
use crate::numeric::{Complex, Matrix};

/// Powers the numerator has beyond the denominator, for the modes outside the band.
const EXTRA_NUMERATOR_ORDER: usize = 2;

/// Poles of orders 2, 4, … `max_order`; no shapes. The numerator keeps the degree `max_order + 2` for all of them.
///
/// # Errors
/// `TooShort` where the lines do not carry that order; `IllPosed` where the equations stay singular.
pub fn rfp(responses: &MeasuredFrf, max_order: usize) -> Result<Vec<OrderPoles>, Error> {
    let bearable = (responses.n_lines() / 2).saturating_sub(EXTRA_NUMERATOR_ORDER);
    if !(2..=bearable).contains(&max_order) {
        return Err(Error::new(
            Code::TooShort,
            format!(
                "order {max_order} cannot be fitted to {} lines",
                responses.n_lines()
            ),
        )
        .with_hint(format!("request an order from 2 to {bearable}")));
    }
    let (_, high) = responses.band_limits_hz();
    let all: Vec<Vec<Complex>> = (0..responses.n_outputs())
        .flat_map(|o| (0..responses.n_inputs()).map(move |i| (o, i)))
        .map(|(o, i)| to_unit_length(responses.response(o, i)))
        .collect();
    let x: Vec<f64> = responses.frequency_hz().iter().map(|f| f / high).collect();
    let weight = (0..x.len()).map(|k| all.iter().map(|h| h[k].norm_sqr()).sum());
    let (q, b) = forsythe_polynomials(&x, &weight.collect::<Vec<f64>>(), max_order + 1);
    let (p, _) = forsythe_polynomials(
        &x,
        &vec![1.0; x.len()],
        max_order + EXTRA_NUMERATOR_ORDER + 1,
    );
    let mut m = Matrix::identity(max_order + 1, max_order + 1);
    for h in &all {
        let projected = Matrix::from_fn(p.len(), q.len(), |i, j| {
            (0..x.len())
                .map(|k| (p[i][k].conj() * h[k] * q[j][k]).re)
                .sum::<f64>()
        });
        m -= projected.transpose() * &projected;
    }
    let nested = NestedCholesky::new(m)?;
    let scale = TAU * high;
    (2..=max_order)
        .step_by(2)
        .map(|order| {
            let poles = eigenvalues(&comrade_matrix(&nested.monic_minimum(order), &b))?
                .into_iter()
                .map(|s| s * scale)
                .filter(|&p| half_power_band_is_inside(p, responses.band_limits_hz()))
                .map(CandidatePole::from_pole);
            Ok(OrderPoles::new(order, poles.collect()))
        })
        .collect()
}

fn to_unit_length(h: &[Complex]) -> Vec<Complex> {
    let length = h.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
    h.iter().map(|z| z / length).collect()
}

/// `count` polynomials in s = ix over the lines, orthonormal in `Re Σ w q̄_j q_k`, and the b_k of their recurrence, b_0 unused.
fn forsythe_polynomials(x: &[f64], weight: &[f64], count: usize) -> (Vec<Vec<Complex>>, Vec<f64>) {
    let length = |q: &[Complex]| {
        let parts = q.iter().zip(weight).map(|(z, w)| w * z.norm_sqr());
        parts.sum::<f64>().sqrt()
    };
    let mut q = vec![vec![Complex::ONE; x.len()]];
    let mut b = vec![length(&q[0])];
    q[0].iter_mut().for_each(|z| *z /= b[0]);
    while q.len() < count {
        let n = q.len();
        let mut next: Vec<Complex> = (0..x.len())
            .map(|k| {
                let before = if n > 1 {
                    q[n - 2][k] * b[n - 1]
                } else {
                    Complex::ZERO
                };
                Complex::new(0.0, x[k]) * q[n - 1][k] + before
            })
            .collect();
        // once more against those of like parity: the recurrence alone loses orthogonality with the degree
        for other in q.iter().rev().skip(1).step_by(2) {
            let part: f64 = (0..x.len())
                .map(|k| weight[k] * (other[k].conj() * next[k]).re)
                .sum();
            next.iter_mut().zip(other).for_each(|(z, o)| *z -= o * part);
        }
        let size = length(&next);
        next.iter_mut().for_each(|z| *z /= size);
        b.push(size);
        q.push(next);
    }
    (q, b)
}

/// The matrix whose eigenvalues are the roots of `q_n + Σ c_k q_k`.
fn comrade_matrix(c: &[f64], b: &[f64]) -> Matrix {
    let n = c.len();
    let mut a = Matrix::zeros(n, n);
    for k in 0..n {
        if k > 0 {
            a[(k, k - 1)] = -b[k];
        }
        if k + 1 < n {
            a[(k, k + 1)] = b[k + 1];
        }
    }
    (0..n).for_each(|k| a[(n - 1, k)] -= b[n] * c[k]);
    a
}
