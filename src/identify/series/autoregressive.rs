//! AR models by four methods: Burg, Yule–Walker, least squares, forward–backward (Kay 1988).
//!
//! Kay, Modern Spectral Estimation (1988), ch. 7. For spectra of short records Burg or forward–backward; Yule–Walker is always
//! stable but widens sharp resonances; least squares is what the other families reduce to.

use super::io_data::{InputOutputData, check_order, remove_mean};
use super::model::{ModelStructure, PolynomialModel};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::factorisations::{IncrementalQr, solve_from_r};
use crate::numeric::{Matrix, symmetric};

/// Estimation method of the coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArMethod {
    /// Reflection coefficients that minimise the forward and backward errors of a lattice (Burg 1967); always stable.
    #[default]
    Burg,
    /// The equations of the biased autocovariance (Yule 1927, Walker 1931) by Levinson's recursion; always stable.
    YuleWalker,
    /// Smallest forward errors, also called the covariance method.
    LeastSquares,
    /// Smallest forward and backward errors together, also called the modified covariance method.
    ForwardBackward,
}

/// An autoregressive model of order `order`.
///
/// # Errors
/// `OutOfRange` for order 0; `TooShort`; `IllPosed` where the samples do not determine the coefficients.
pub fn fit(
    record: &InputOutputData,
    order: usize,
    method: ArMethod,
) -> Result<PolynomialModel, Error> {
    check_order(record.samples(), order, order)?;
    let (y, output_mean) = remove_mean(record.output());
    let predicted = y.len() - order;
    let (a, noise_variance, covariance) = match method {
        ArMethod::Burg => with_covariance(&y, burg_path(&y, order).pop(), predicted)?,
        ArMethod::YuleWalker => {
            let steps = levinson_path(&autocovariance(&y, order)).pop();
            with_covariance(&y, steps, predicted)?
        }
        ArMethod::LeastSquares => regression(&y, order, false)?,
        ArMethod::ForwardBackward => regression(&y, order, true)?,
    };
    Ok(PolynomialModel {
        family: ModelStructure::Ar { a: order },
        a,
        b: Vec::new(),
        c: Vec::new(),
        f: Vec::new(),
        noise_variance,
        covariance,
        output_mean,
        input_mean: 0.0,
        samples: predicted,
        rate_hz: record.rate_hz(),
        iterations: 0,
    })
}

/// Coefficients and variance of the errors of one order.
pub(super) type OrderFit = (Vec<f64>, f64);

/// Orders 1 to `order` by Burg's recursion; `y` without its mean.
pub(super) fn burg_path(y: &[f64], order: usize) -> Vec<OrderFit> {
    let n = y.len();
    let (mut forward, mut backward) = (y.to_vec(), y.to_vec());
    let mut variance = y.iter().map(|y| y * y).sum::<f64>() / n as f64;
    let mut a: Vec<f64> = Vec::with_capacity(order);
    let mut path = Vec::with_capacity(order);
    for m in 1..=order {
        // forward[t] and backward[t − 1] are the errors of order m − 1 on either side.
        let (mut top, mut bottom) = (0.0, 0.0);
        for t in m..n {
            let (f, b) = (forward[t], backward[t - 1]);
            top += f * b;
            bottom += f * f + b * b;
        }
        let k = if bottom > 0.0 {
            -2.0 * top / bottom
        } else {
            0.0
        };
        for t in (m..n).rev() {
            let (f, b) = (forward[t], backward[t - 1]);
            forward[t] = f + k * b;
            backward[t] = b + k * f;
        }
        levinson_step(&mut a, k);
        variance *= 1.0 - k * k;
        path.push((a.clone(), variance));
    }
    path
}

/// Orders 1 to n from autocovariances of lags 0 to n.
fn levinson_path(r: &[f64]) -> Vec<OrderFit> {
    let mut variance = r[0];
    let mut a: Vec<f64> = Vec::new();
    let mut path = Vec::new();
    for m in 1..r.len() {
        let sum: f64 = r[m] + (1..m).map(|i| a[i - 1] * r[m - i]).sum::<f64>();
        let k = if variance > 0.0 { -sum / variance } else { 0.0 };
        levinson_step(&mut a, k);
        variance *= 1.0 - k * k;
        path.push((a.clone(), variance));
    }
    path
}

/// Levinson's step to the next order with reflection coefficient `k`.
fn levinson_step(a: &mut Vec<f64>, k: f64) {
    let n = a.len();
    let before = a.clone();
    (0..n).for_each(|i| a[i] += k * before[n - 1 - i]);
    a.push(k);
}

/// Biased autocovariance of lags 0 to `lags`; `y` without its mean.
pub(super) fn autocovariance(y: &[f64], lags: usize) -> Vec<f64> {
    (0..=lags)
        .map(|lag| {
            let products = y.iter().zip(y.iter().skip(lag)).map(|(a, b)| a * b);
            products.sum::<f64>() / y.len() as f64
        })
        .collect()
}

/// The asymptotic covariance `σ² Γ⁻¹/N` next to coefficients that a recursion found.
fn with_covariance(
    y: &[f64],
    step: Option<OrderFit>,
    samples: usize,
) -> Result<(Vec<f64>, f64, Matrix), Error> {
    let (a, variance) = step.unwrap_or_default();
    if !(variance > 0.0) {
        return Err(unpredictable_error(a.len()));
    }
    let n = a.len();
    let r = autocovariance(y, n);
    let gamma = Matrix::from_fn(n, n, |i, j| r[i.abs_diff(j)]);
    let inverse = symmetric::lu_solve(&gamma, &Matrix::identity(n, n))?;
    let covariance = Matrix::from_fn(n, n, |i, j| inverse[(i, j)] * variance / samples as f64);
    Ok((a, variance, covariance))
}

/// Least squares of forward errors, and of backward errors too.
fn regression(y: &[f64], order: usize, backward: bool) -> Result<(Vec<f64>, f64, Matrix), Error> {
    let n = y.len();
    let mut triangle = IncrementalQr::new(order + 1);
    let mut row = vec![0.0; order + 1];
    for t in order..n {
        (0..order).for_each(|k| row[k] = -y[t - 1 - k]);
        row[order] = y[t];
        triangle.push(&row);
        if backward {
            let s = t - order; // the sample that those after it predict
            (0..order).for_each(|k| row[k] = -y[s + 1 + k]);
            row[order] = y[s];
            triangle.push(&row);
        }
    }
    let found = solve_from_r(&triangle.finish())?;
    // Both directions tell the same twice: twice the rows, no more knowledge.
    let twice = if backward { 2.0 } else { 1.0 };
    let dofs = (n - 2 * order).max(1) as f64;
    let variance = found.residual_square / twice / dofs;
    let covariance = Matrix::from_fn(order, order, |i, j| {
        found.inverse[(i, j)] * variance * twice
    });
    Ok((found.solution, variance, covariance))
}

fn unpredictable_error(order: usize) -> Error {
    Error::new(
        Code::IllPosed,
        format!("a model of order {order} predicts the samples without error; further coefficients are undetermined"),
    )
    .with_hint("lower the order; a computed signal without noise needs two per tone")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levinson's recursion solves the Yule–Walker equations.
    #[test]
    fn exact_levinson() {
        let r = [2.0, 1.1, 0.3, -0.4];
        let path = levinson_path(&r);
        for (a, variance) in &path {
            let n = a.len();
            for m in 1..=n {
                let sum = r[m] + (1..=n).map(|k| a[k - 1] * r[m.abs_diff(k)]).sum::<f64>();
                assert!(sum.abs() < 1e-14);
            }
            let power = r[0] + (1..=n).map(|k| a[k - 1] * r[k]).sum::<f64>();
            assert!((variance - power).abs() < 1e-14);
        }
    }

    /// A damped oscillation without noise: forward errors vanish at its own coefficients.
    #[test]
    fn exact_oscillation_by_least_squares() {
        let (g, w) = (0.99_f64, 0.4_f64);
        let y: Vec<f64> = (0..60)
            .map(|t| g.powi(t) * (w * f64::from(t)).cos())
            .collect();
        let (a, _, _) = regression(&y, 2, false).unwrap();
        assert!((a[0] + 2.0 * g * w.cos()).abs() < 1e-12 && (a[1] - g * g).abs() < 1e-12);
    }
}
