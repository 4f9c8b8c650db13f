//! Order selection by AIC, BIC or MDL over candidates fitted on the same samples.
//!
//! Akaike (1974): `AIC = N ln σ² + 2p`; Schwarz (1978): `BIC = N ln σ² + p ln N`; Rissanen (1978): `MDL = BIC/2`, nats of the shortest
//! description. AIC tends to overestimate the order; BIC is consistent for long records.

use super::autoregressive::burg_path;
use super::io_data::{InputOutputData, check_order, remove_mean};
use super::model::{ModelStructure, PolynomialModel};
use super::prediction_error::fit_from;
use crate::base::code::Code;
use crate::base::error::Error;

/// Criterion of the order selection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OrderCriterion {
    /// Akaike's criterion.
    Aic,
    /// Schwarz's criterion; Rissanen's MDL gives the same ranking.
    #[default]
    Bic,
}

/// Fitted candidate of the order selection.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderCandidate {
    /// Structure and polynomial orders.
    pub family: ModelStructure,
    /// Mean square prediction error, in squared units of the output.
    pub error_variance: f64,
    /// Akaike's criterion.
    pub aic: f64,
    /// Schwarz's criterion.
    pub bic: f64,
    /// Rissanen's description length.
    pub mdl: f64,
}

/// Selected order with all candidates.
#[derive(Debug, Clone)]
pub struct OrderChoice {
    /// Structure with the smallest criterion.
    pub family: ModelStructure,
    /// Candidates that could be fitted, in the given order.
    pub candidates: Vec<OrderCandidate>,
    /// White-noise model of the output, without coefficients.
    pub white_noise: OrderCandidate,
    /// `true` if no candidate has a smaller criterion than the white-noise model.
    pub is_noise: bool,
}

impl OrderCandidate {
    fn new(family: ModelStructure, error_variance: f64, samples: usize) -> OrderCandidate {
        let (n, p) = (samples as f64, family.parameter_count() as f64);
        // Errors of rounding size do not support a further coefficient.
        let log = n * error_variance.max(f64::MIN_POSITIVE).ln();
        let bic = log + p * n.ln();
        OrderCandidate {
            family,
            error_variance,
            aic: log + 2.0 * p,
            bic,
            mdl: bic / 2.0,
        }
    }

    /// White-noise model without coefficients.
    fn white_noise(y: &[f64]) -> OrderCandidate {
        let variance = y.iter().map(|y| y * y).sum::<f64>() / y.len().max(1) as f64;
        OrderCandidate::new(ModelStructure::Ar { a: 0 }, variance, y.len())
    }

    fn value(&self, criterion: OrderCriterion) -> f64 {
        match criterion {
            OrderCriterion::Aic => self.aic,
            OrderCriterion::Bic => self.bic,
        }
    }
}

/// Selects the autoregressive order from 1 to `max_order` by Burg's recursion, which fits all orders at the cost of the highest.
///
/// # Errors
/// Those of [`InputOutputData`]; `OutOfRange` for a maximum order of 0; `TooShort`.
pub fn select_ar_order(
    record: &InputOutputData,
    max_order: usize,
    criterion: OrderCriterion,
) -> Result<OrderChoice, Error> {
    check_order(record.samples(), max_order, max_order)?;
    let (y, _) = remove_mean(record.output());
    let candidates = (burg_path(&y, max_order).into_iter())
        .map(|(a, variance)| {
            OrderCandidate::new(ModelStructure::Ar { a: a.len() }, variance, y.len())
        })
        .collect();
    choose(candidates, OrderCandidate::white_noise(&y), criterion)
}

/// Number of consecutive orders without a smaller criterion after which the search ends.
const MAX_ORDERS_WITHOUT_GAIN: usize = 2;

/// Selects the structure of `families` (sorted by increasing order) with the smallest criterion. Structures that the samples do not
/// determine are skipped; for iterative fits the search ends after two structures without improvement.
///
/// # Errors
/// Error of the first family if none can be fitted.
pub fn select_structure(
    record: &InputOutputData,
    families: &[ModelStructure],
    criterion: OrderCriterion,
) -> Result<(PolynomialModel, OrderChoice), Error> {
    let first = families
        .iter()
        .map(|f| f.orders().warm_up())
        .max()
        .unwrap_or(0);
    let mut candidates: Vec<OrderCandidate> = Vec::new();
    let mut models = Vec::new();
    let mut failure = None;
    let (y, _) = remove_mean(record.output());
    let white_noise = OrderCandidate::white_noise(&y[first.min(y.len())..]);
    let (mut min_value, mut n_without_gain) = (white_noise.value(criterion), 0);
    for &family in families {
        // Iterative fits converge slowly if poles and zeros cancel, which they do above the true order.
        let orders = family.orders();
        if orders.c + orders.f > 0 && n_without_gain >= MAX_ORDERS_WITHOUT_GAIN {
            break;
        }
        n_without_gain += 1;
        match fit_from(record, family, first) {
            Ok(model) => {
                let dofs = (model.samples - family.parameter_count()) as f64;
                let variance = model.noise_variance * dofs / model.samples as f64;
                let candidate = OrderCandidate::new(family, variance, model.samples);
                if candidate.value(criterion) < min_value {
                    (min_value, n_without_gain) = (candidate.value(criterion), 0);
                }
                candidates.push(candidate);
                models.push(model);
            }
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    if let (true, Some(error)) = (candidates.is_empty(), failure) {
        return Err(error);
    }
    let choice = choose(candidates, white_noise, criterion)?;
    // If poles and zeros cancel, as in noise, a few more samples may prevent convergence of the iteration.
    let fit = super::prediction_error::fit(record, choice.family);
    let model = fit.or_else(|error| {
        let candidate_model = models.into_iter().find(|m| m.family == choice.family);
        candidate_model.ok_or(error)
    })?;
    Ok((model, choice))
}

fn choose(
    candidates: Vec<OrderCandidate>,
    white_noise: OrderCandidate,
    criterion: OrderCriterion,
) -> Result<OrderChoice, Error> {
    let best = (candidates.iter())
        .min_by(|a, b| a.value(criterion).total_cmp(&b.value(criterion)))
        .map(|c| (c.family, c.value(criterion)));
    match best {
        Some((family, value)) => Ok(OrderChoice {
            family,
            candidates,
            is_noise: white_noise.value(criterion) <= value,
            white_noise,
        }),
        None => Err(Error::new(Code::OutOfRange, "no order to choose from")
            .with_hint("name at least one family of models")),
    }
}
