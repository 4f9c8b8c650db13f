//! Least-squares complex exponential (LSCE): `Σ_j β_j h(n + j) = 0`, roots `exp(p_r Δt)`.
//!
//! Brown, Allemang, Zimmerman & Mergeay, Parameter estimation techniques for modal analysis, SAE 790221 (1979). The impulse responses are
//! those of the band alone: what is cut off at its ends leaks, so that poles near the ends and heavily damped ones are poor.

use super::candidates::{CandidatePole, OrderPoles, half_power_band_is_inside};
use super::lags::LagSums;
use super::measured_frf::MeasuredFrf;
use super::nested_cholesky::NestedCholesky;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::eigen::eigenvalues;

/// Equations for every coefficient of the highest order: more average noise, fewer stay where the impulse response is above it.
const EQUATIONS_PER_COEFFICIENT: usize = 4;

/// Poles of every second order up to `max_order`; no shapes. All inputs and outputs together are one set of responses.
///
/// # Errors
/// `TooShort` where the lines do not carry that order; `IllPosed` where the equations stay singular.
pub fn lsce(responses: &MeasuredFrf, max_order: usize) -> Result<Vec<OrderPoles>, Error> {
    let bearable = responses.n_lines() * 2 / (EQUATIONS_PER_COEFFICIENT + 1);
    if !(2..=bearable).contains(&max_order) {
        return Err(Error::new(
            Code::TooShort,
            format!(
                "order {max_order} cannot be fitted to the impulse responses of {} lines",
                responses.n_lines()
            ),
        )
        .with_hint(format!("request an order from 2 to {bearable}")));
    }
    let equations = EQUATIONS_PER_COEFFICIENT * max_order;
    let mut lags = LagSums::new(responses.frequency_hz(), equations + max_order);
    let side = max_order + 1;
    let mut c = Matrix::zeros(side, side);
    for output in 0..responses.n_outputs() {
        for input in 0..responses.n_inputs() {
            let value = responses.response(output, input);
            let sums = lags.sum(|k| value[k]);
            let h = &sums[equations + max_order..];
            let size = h.iter().map(|x| x * x).sum::<f64>();
            add_products(&mut c, h, equations, 1.0 / size);
        }
    }
    let nested = NestedCholesky::new(c)?;
    let mut orders = Vec::new();
    for order in (2..=max_order).step_by(2) {
        let beta = nested.monic_minimum(order);
        let companion = Matrix::from_fn(order, order, |i, j| match i {
            0 => -beta[order - 1 - j],
            _ => f64::from(u8::from(i == j + 1)),
        });
        let poles = eigenvalues(&companion)?
            .into_iter()
            .filter_map(|z| lags.to_s_plane(z))
            .filter(|&p| half_power_band_is_inside(p, responses.band_limits_hz()));
        orders.push(OrderPoles::new(
            order,
            poles.map(CandidatePole::from_pole).collect(),
        ));
    }
    Ok(orders)
}

/// Adds `weight Σ_n h(n + j) h(n + k)`, n from 1: h(0) carries half of a jump.
fn add_products(c: &mut Matrix, h: &[f64], equations: usize, weight: f64) {
    let side = c.nrows();
    for j in 0..side {
        for k in 0..=j {
            let sum: f64 = (1..equations).map(|n| h[n + j] * h[n + k]).sum();
            c[(j, k)] += weight * sum;
            if j != k {
                c[(k, j)] += weight * sum;
            }
        }
    }
}
