//! Prediction-error method (PEM): `Σ e_t²` minimised by damped Gauss–Newton; `e = (A y − B/F u)/C`.
//!
//! With `e = (A y − B/F u)/C` the gradient is a filtered copy of the signals (Ljung, System Identification, 2nd ed. (1999), §10.2–10.3):
//! `∂e_t/∂a_k = y_{t−k}/C`, `∂e_t/∂b_j = −u_{t−d−j}/(CF)`, `∂e_t/∂c_k = −e_{t−k}/C`, `∂e_t/∂f_k = w_{t−k}/(CF)`, `w = B/F u`. Each row
//! of it follows from the previous C rows by one recursion, so it is never stored. The Gauss–Newton steps are damped as by Marquardt
//! (1963). Initial estimates: Hannan & Rissanen, Biometrika 69 (1982), for C; Steiglitz & McBride, IEEE Trans. Autom. Control 10 (1965),
//! for F. The errors before the first predicted sample are set to zero, which shifts the estimate of N samples by the order of 1/N.

use std::collections::VecDeque;

use super::filter::{filter_inverse, is_stable, stabilise};
use super::io_data::{InputOutputData, check_order, remove_mean};
use super::model::{
    ModelStructure, PolynomialModel, PolynomialOrders, PolynomialRefs, no_input, prediction_errors,
};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::factorisations::{IncrementalQr, solve_from_r};

/// Fits a model of structure `family` after subtraction of the means. AR and ARX need one linear least-squares solution.
///
/// # Errors
/// `OutOfRange` for a model without coefficients; `NoSignal` if the model needs an input and the record has none; `TooShort`; `IllPosed`
/// if the samples do not determine the coefficients (orders too high, or insufficient excitation); `NoConvergence`.
pub fn fit(record: &InputOutputData, family: ModelStructure) -> Result<PolynomialModel, Error> {
    let lengths = family.orders();
    fit_from(record, family, lengths.warm_up())
}

/// Fits as [`fit`] with predictions from sample `first` on, so that several orders can be compared on the same samples.
pub(super) fn fit_from(
    record: &InputOutputData,
    family: ModelStructure,
    first: usize,
) -> Result<PolynomialModel, Error> {
    let n = family.orders();
    let first = first.max(n.warm_up());
    check_order(record.samples(), family.parameter_count(), first)?;
    let (y, output_mean) = remove_mean(record.output());
    let (u, input_mean) = match (n.b, record.input()) {
        (0, _) => (Vec::new(), 0.0),
        (_, Some(u)) => remove_mean(u),
        (_, None) => return Err(no_input()),
    };
    let signals = PemData { y, u, n, first };
    let (theta, iterations) = if n.c == 0 && n.f == 0 {
        (signals.linear(&signals.y, &signals.u, n)?.0, 0)
    } else {
        let start = if n.f > 0 {
            signals.steiglitz_mcbride()?
        } else {
            signals.hannan_rissanen()?
        };
        signals.iterate(start)?
    };
    let (triangle, loss) = signals.gradient(&theta);
    let samples = signals.y.len() - first;
    let noise_variance = loss / (samples - family.parameter_count()) as f64;
    let information = solve_from_r(&triangle)?;
    let size = theta.len();
    let covariance = Matrix::from_fn(size, size, |i, j| {
        information.inverse[(i, j)] * noise_variance
    });
    let parts = n.split(&theta);
    Ok(PolynomialModel {
        family,
        a: parts.a.to_vec(),
        b: parts.b.to_vec(),
        c: parts.c.to_vec(),
        f: parts.f.to_vec(),
        noise_variance,
        covariance,
        output_mean,
        input_mean,
        samples,
        rate_hz: record.rate_hz(),
        iterations,
    })
}

impl PolynomialOrders {
    /// Splits the vector of coefficients into the polynomials.
    fn split(self, theta: &[f64]) -> PolynomialRefs<'_> {
        let (a, rest) = theta.split_at(self.a);
        let (b, rest) = rest.split_at(self.b);
        let (c, f) = rest.split_at(self.c);
        PolynomialRefs {
            a,
            b,
            c,
            f,
            delay: self.delay,
        }
    }
}

/// Gauss–Newton stops if the predicted decrease of the loss is below this share of the variance of one sample: far below the scatter of the
/// estimate, which is one variance per coefficient.
const LOSS_TOLERANCE: f64 = 1e-9;

/// Maximum number of steps; 5 to 20 are usual.
const MAX_ITERATIONS: usize = 200;

/// Iterations of the Steiglitz–McBride initial estimate, which converges in a few.
const STEIGLITZ_MCBRIDE_ROUNDS: usize = 10;

struct PemData {
    y: Vec<f64>,
    u: Vec<f64>,
    n: PolynomialOrders,
    first: usize,
}

impl PemData {
    /// Linear least squares of `A y = B u`: coefficients, and residuals with zeros before the first.
    fn linear(
        &self,
        y: &[f64],
        u: &[f64],
        n: PolynomialOrders,
    ) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let first = self.first.max(n.warm_up());
        let size = n.a + n.b;
        let mut triangle = IncrementalQr::new(size + 1);
        let mut row = vec![0.0; size + 1];
        for t in first..y.len() {
            (0..n.a).for_each(|k| row[k] = -y[t - 1 - k]);
            (0..n.b).for_each(|j| row[n.a + j] = u[t - n.delay - j]);
            row[size] = y[t];
            triangle.push(&row);
        }
        let theta = solve_from_r(&triangle.finish())?.solution;
        let (a, b) = theta.split_at(n.a);
        let model = PolynomialRefs {
            a,
            b,
            c: &[],
            f: &[],
            delay: n.delay,
        };
        let errors = prediction_errors(model, y, u).errors;
        Ok((theta, errors))
    }

    /// Initial estimate by Hannan and Rissanen: a long AR or ARX model estimates the noise, then A, B and C are linear.
    fn hannan_rissanen(&self) -> Result<Vec<f64>, Error> {
        let n = self.n;
        let samples = self.y.len();
        // Order for the decay of 1/C: the usual (log N)², at most a tenth of the samples.
        let order = ((samples as f64).ln().powi(2) as usize).min(100);
        let order = order.max(2 * (n.a + n.c)).min(samples / 10).max(1);
        let b = if n.b > 0 {
            (n.b + n.c).max(order / 2)
        } else {
            0
        };
        let noise_model = PolynomialOrders {
            a: order,
            b,
            c: 0,
            f: 0,
            delay: n.delay,
        };
        let (_, noise) = self.linear(&self.y, &self.u, noise_model)?;
        let first = self.first.max(noise_model.warm_up()) + n.c;
        let size = n.a + n.b + n.c;
        if samples <= first + size {
            return Err(Error::new(
                Code::TooShort,
                format!("{samples} samples are too few to start a model of {size} unknowns with coloured noise"),
            )
            .with_hint("take a longer record, or lower the orders"));
        }
        let mut triangle = IncrementalQr::new(size + 1);
        let mut row = vec![0.0; size + 1];
        for t in first..samples {
            (0..n.a).for_each(|k| row[k] = -self.y[t - 1 - k]);
            (0..n.b).for_each(|j| row[n.a + j] = self.u[t - n.delay - j]);
            (0..n.c).for_each(|k| row[n.a + n.b + k] = noise[t - 1 - k]);
            row[size] = self.y[t];
            triangle.push(&row);
        }
        let mut theta = solve_from_r(&triangle.finish())?.solution;
        let c = stabilise(theta.split_off(n.a + n.b));
        theta.extend(c);
        Ok(theta)
    }

    /// Initial estimate by Steiglitz and McBride: iterates `F y = B u` with both signals filtered by the last 1/F.
    fn steiglitz_mcbride(&self) -> Result<Vec<f64>, Error> {
        let n = self.n;
        let linear = PolynomialOrders {
            a: n.f,
            b: n.b,
            c: 0,
            f: 0,
            delay: n.delay,
        };
        let mut best: Option<(f64, Vec<f64>)> = None;
        let mut f: Vec<f64> = Vec::new();
        for _ in 0..STEIGLITZ_MCBRIDE_ROUNDS {
            let (mut y, mut u) = (self.y.clone(), self.u.clone());
            filter_inverse(&mut y, &f);
            filter_inverse(&mut u, &f);
            let Ok((coefficients, _)) = self.linear(&y, &u, linear) else {
                break;
            };
            let (a, b) = coefficients.split_at(n.f);
            f = stabilise(a.to_vec());
            let theta = [b, f.as_slice()].concat();
            let loss = self.loss(&theta);
            if best.as_ref().is_none_or(|(min_loss, _)| loss < *min_loss) {
                best = Some((loss, theta));
            }
        }
        best.map(|(_, theta)| theta).ok_or_else(|| {
            Error::new(
                Code::IllPosed,
                "the input does not determine an output-error model of these orders",
            )
            .with_hint("lower the orders, or excite the machine at more frequencies")
        })
    }

    /// Loss `Σ e²`; infinite if C or F is unstable.
    fn loss(&self, theta: &[f64]) -> f64 {
        let model = self.n.split(theta);
        if !(is_stable(model.c) && is_stable(model.f)) {
            return f64::INFINITY;
        }
        let errors = self.errors(model);
        errors[self.first..].iter().map(|e| e * e).sum()
    }

    fn errors(&self, model: PolynomialRefs) -> Vec<f64> {
        prediction_errors(model, &self.y, &self.u).errors
    }

    /// QR triangle of `[∂e/∂θ, −e]`, and the loss `Σ e²`.
    fn gradient(&self, theta: &[f64]) -> (Matrix, f64) {
        let n = self.n;
        let model = n.split(theta);
        let prediction = prediction_errors(model, &self.y, &self.u);
        let (e, mut w, mut u) = (prediction.errors, prediction.noise_free, self.u.clone());
        filter_inverse(&mut w, model.f);
        filter_inverse(&mut u, model.f);
        let size = theta.len();
        let mut triangle = IncrementalQr::new(size + 1);
        let mut previous_rows: VecDeque<Vec<f64>> = VecDeque::new();
        let mut row = vec![0.0; size + 1];
        let lagged = |x: &[f64], t: usize, lag: usize| t.checked_sub(lag).map_or(0.0, |at| x[at]);
        let mut loss = 0.0;
        for t in prediction.first..e.len() {
            (0..n.a).for_each(|k| row[k] = lagged(&self.y, t, k + 1));
            (0..n.b).for_each(|j| row[n.a + j] = -lagged(&u, t, n.delay + j));
            (0..n.c).for_each(|k| row[n.a + n.b + k] = -lagged(&e, t, k + 1));
            (0..n.f).for_each(|k| row[n.a + n.b + n.c + k] = lagged(&w, t, k + 1));
            for (c, previous) in model.c.iter().zip(&previous_rows) {
                (row.iter_mut().zip(previous)).for_each(|(r, p)| *r -= c * p);
            }
            if n.c > 0 {
                let mut gradient_row = if previous_rows.len() == n.c {
                    previous_rows.pop_back().unwrap_or_default()
                } else {
                    Vec::new()
                };
                gradient_row.clear();
                gradient_row.extend_from_slice(&row[..size]);
                previous_rows.push_front(gradient_row);
            }
            if t >= self.first {
                row[size] = -e[t];
                loss += e[t] * e[t];
                triangle.push(&row);
            }
        }
        (triangle.finish(), loss)
    }

    /// Damped Gauss–Newton iteration from `theta`: coefficients and number of steps.
    fn iterate(&self, mut theta: Vec<f64>) -> Result<(Vec<f64>, usize), Error> {
        let samples = (self.y.len() - self.first) as f64;
        let mut damping = 1e-3;
        let mut loss = self.loss(&theta);
        for step in 1..=MAX_ITERATIONS {
            let (triangle, _) = self.gradient(&theta);
            loop {
                let change = damped_step(&triangle, damping)?;
                let decrease = predicted_decrease(&triangle, &change);
                let next: Vec<f64> = theta.iter().zip(&change).map(|(t, c)| t + c).collect();
                if decrease <= LOSS_TOLERANCE * loss / samples {
                    return Ok((theta, step));
                }
                let next_loss = self.loss(&next);
                if next_loss < loss {
                    (theta, loss) = (next, next_loss);
                    damping = (damping * 0.1).max(f64::EPSILON);
                    break;
                }
                damping *= 10.0;
            }
        }
        Err(Error::new(
            Code::NoConvergence,
            format!(
                "the fit of {} coefficients did not converge in {MAX_ITERATIONS} steps",
                theta.len()
            ),
        )
        .with_hint(
            "lower the orders: a pole and a zero that cancel leave the coefficients undetermined",
        ))
    }
}

/// Minimises `‖J x − b‖² + damping Σ ‖J_j‖² x_j²` from the QR triangle of `[J b]`.
fn damped_step(triangle: &Matrix, damping: f64) -> Result<Vec<f64>, Error> {
    let size = triangle.ncols() - 1;
    let mut extended = IncrementalQr::new(size + 1);
    let mut row = vec![0.0; size + 1];
    for i in 0..=size {
        (0..=size).for_each(|j| row[j] = triangle[(i, j)]);
        extended.push(&row);
    }
    for j in 0..size {
        row.fill(0.0);
        let length = triangle
            .col_as_slice(j)
            .iter()
            .map(|x| x * x)
            .sum::<f64>()
            .sqrt();
        row[j] = damping.sqrt() * length;
        extended.push(&row);
    }
    Ok(solve_from_r(&extended.finish())?.solution)
}

/// Predicted decrease of the loss, `‖b‖² − ‖J x − b‖²`, from the QR triangle of `[J b]`.
fn predicted_decrease(triangle: &Matrix, x: &[f64]) -> f64 {
    let size = x.len();
    (0..size)
        .map(|i| {
            let b = triangle[(i, size)];
            let jx: f64 = (i..size).map(|j| triangle[(i, j)] * x[j]).sum();
            b * b - (jx - b) * (jx - b)
        })
        .sum()
}
