//! Order selection by AIC, BIC or MDL over candidates fitted on the same samples.
//!
//! Akaike (1974): `AIC = N ln σ² + 2p`; Schwarz (1978): `BIC = N ln σ² + p ln N`; Rissanen (1978): `MDL = BIC/2`, nats of the shortest
//! description. AIC keeps all that predicts and tends to too many; BIC finds the true order on long records.

use super::autoregressive::burg_path;
use super::io_data::{InputOutputData, check_order, remove_mean};
use super::model::{ModelStructure, PolynomialModel};
use super::prediction_error::fit_from;
use crate::base::code::Code;
use crate::base::error::Error;

/// Criterion of the order selection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OrderCriterion {
    /// Akaike's.
    Aic,
    /// Schwarz's, and with it Rissanen's, which ranks alike.
    #[default]
    Bic,
}

/// One order that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderCandidate {
    /// The polynomials.
    pub family: ModelStructure,
    /// Mean square of the prediction errors, output squared.
    pub error_variance: f64,
    /// Akaike's criterion.
    pub aic: f64,
    /// Schwarz's criterion.
    pub bic: f64,
    /// Rissanen's description length.
    pub mdl: f64,
}

/// The order taken, and all that were tried as evidence.
#[derive(Debug, Clone)]
pub struct OrderChoice {
    /// The smallest criterion.
    pub family: ModelStructure,
    /// All that could be fitted, in the order given.
    pub candidates: Vec<OrderCandidate>,
    /// The output as it is, without any coefficient: noise alone where no candidate has a smaller criterion.
    pub white_noise: OrderCandidate,
    /// None of the candidates has a smaller criterion than nothing.
    pub is_noise: bool,
}

impl OrderCandidate {
    fn new(family: ModelStructure, error_variance: f64, samples: usize) -> OrderCandidate {
        let (n, p) = (samples as f64, family.parameter_count() as f64);
        // Errors of rounding size are no evidence for yet another coefficient.
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

    /// No coefficient at all: white noise.
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

/// The autoregressive order from 1 to `highest`, by Burg's recursion: all orders cost as much as the highest.
///
/// # Errors
/// Those of [`InputOutputData`]; `OutOfRange` for a highest order of 0; `TooShort`.
pub fn select_ar_order(
    record: &InputOutputData,
    highest: usize,
    criterion: OrderCriterion,
) -> Result<OrderChoice, Error> {
    check_order(record.samples(), highest, highest)?;
    let (y, _) = remove_mean(record.output());
    let candidates = (burg_path(&y, highest).into_iter())
        .map(|(a, variance)| {
            OrderCandidate::new(ModelStructure::Ar { a: a.len() }, variance, y.len())
        })
        .collect();
    choose(candidates, OrderCandidate::white_noise(&y), criterion)
}

/// Orders one after the other that may leave the criterion where it is before the search ends.
const MAX_ORDERS_WITHOUT_GAIN: usize = 2;

/// The best of `families`, by rising order; those the samples do not determine are passed over, and where coefficients are iterated the
/// search ends after two that better nothing.
///
/// # Errors
/// Of the first family, where none can be fitted.
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
    let nothing = OrderCandidate::white_noise(&y[first.min(y.len())..]);
    let (mut least, mut in_vain) = (nothing.value(criterion), 0);
    for &family in families {
        // What is iterated is slow where poles and zeros cancel, which they do beyond the right order.
        let lengths = family.orders();
        if lengths.c + lengths.f > 0 && in_vain >= MAX_ORDERS_WITHOUT_GAIN {
            break;
        }
        in_vain += 1;
        match fit_from(record, family, first) {
            Ok(model) => {
                let dofs = (model.samples - family.parameter_count()) as f64;
                let variance = model.noise_variance * dofs / model.samples as f64;
                let candidate = OrderCandidate::new(family, variance, model.samples);
                if candidate.value(criterion) < least {
                    (least, in_vain) = (candidate.value(criterion), 0);
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
    let choice = choose(candidates, nothing, criterion)?;
    // Where poles and zeros cancel, as in noise, a few samples more may keep the iteration from settling.
    let whole = super::prediction_error::fit(record, choice.family);
    let model = whole.or_else(|error| {
        let own = models.into_iter().find(|m| m.family == choice.family);
        own.ok_or(error)
    })?;
    Ok((model, choice))
}

fn choose(
    candidates: Vec<OrderCandidate>,
    nothing: OrderCandidate,
    criterion: OrderCriterion,
) -> Result<OrderChoice, Error> {
    let best = (candidates.iter())
        .min_by(|a, b| a.value(criterion).total_cmp(&b.value(criterion)))
        .map(|c| (c.family, c.value(criterion)));
    match best {
        Some((family, value)) => Ok(OrderChoice {
            family,
            candidates,
            is_noise: nothing.value(criterion) <= value,
            white_noise: nothing,
        }),
        None => Err(Error::new(Code::OutOfRange, "no order to choose from")
            .with_hint("name at least one family of models")),
    }
}
