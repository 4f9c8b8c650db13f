//! Which order: every candidate fitted on the same samples, with the criteria side by side.
//!
//! Akaike (1974): `AIC = N ln σ² + 2p`; Schwarz (1978): `BIC = N ln σ² + p ln N`; Rissanen (1978): `MDL = BIC/2`, nats of the shortest
//! description. AIC keeps all that predicts and tends to too many; BIC finds the true order on long records.

use super::autoregressive::burg_path;
use super::model::{Family, SeriesModel};
use super::prediction_error::fit_from;
use super::record::{Record, centred, check_order};
use crate::base::code::Code;
use crate::base::error::Error;

/// What decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Criterion {
    /// Akaike's.
    Aic,
    /// Schwarz's, and with it Rissanen's, which ranks alike.
    #[default]
    Bic,
}

/// One order that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The polynomials.
    pub family: Family,
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
pub struct Choice {
    /// The smallest criterion.
    pub family: Family,
    /// All that could be fitted, in the order given.
    pub candidates: Vec<Candidate>,
}

impl Candidate {
    fn new(family: Family, error_variance: f64, samples: usize) -> Candidate {
        let (n, p) = (samples as f64, family.unknowns() as f64);
        // Errors of rounding size are no evidence for yet another coefficient.
        let log = n * error_variance.max(f64::MIN_POSITIVE).ln();
        let bic = log + p * n.ln();
        Candidate {
            family,
            error_variance,
            aic: log + 2.0 * p,
            bic,
            mdl: bic / 2.0,
        }
    }

    fn value(&self, criterion: Criterion) -> f64 {
        match criterion {
            Criterion::Aic => self.aic,
            Criterion::Bic => self.bic,
        }
    }
}

/// The autoregressive order from 1 to `highest`, by Burg's recursion: all orders cost as much as the highest.
///
/// # Errors
/// Those of [`Record`]; `OutOfRange` for a highest order of 0; `TooShort`.
pub fn autoregressive(
    record: &Record,
    highest: usize,
    criterion: Criterion,
) -> Result<Choice, Error> {
    check_order(record.samples(), highest, highest)?;
    let (y, _) = centred(record.output());
    let candidates = (burg_path(&y, highest).into_iter())
        .map(|(a, variance)| Candidate::new(Family::Ar { a: a.len() }, variance, y.len()))
        .collect();
    choose(candidates, criterion)
}

/// The best of `families`; those the samples do not determine are passed over.
///
/// # Errors
/// Of the first family, where none can be fitted.
pub fn among(
    record: &Record,
    families: &[Family],
    criterion: Criterion,
) -> Result<(SeriesModel, Choice), Error> {
    let first = families
        .iter()
        .map(|f| f.lengths().start())
        .max()
        .unwrap_or(0);
    let mut candidates = Vec::new();
    let mut failure = None;
    for &family in families {
        match fit_from(record, family, first) {
            Ok(model) => {
                let freedoms = (model.samples - family.unknowns()) as f64;
                let variance = model.noise_variance * freedoms / model.samples as f64;
                candidates.push(Candidate::new(family, variance, model.samples));
            }
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    if let (true, Some(error)) = (candidates.is_empty(), failure) {
        return Err(error);
    }
    let choice = choose(candidates, criterion)?;
    let model = super::prediction_error::fit(record, choice.family)?;
    Ok((model, choice))
}

fn choose(candidates: Vec<Candidate>, criterion: Criterion) -> Result<Choice, Error> {
    let best = (candidates.iter())
        .min_by(|a, b| a.value(criterion).total_cmp(&b.value(criterion)))
        .map(|c| c.family);
    match best {
        Some(family) => Ok(Choice { family, candidates }),
        None => Err(Error::new(Code::OutOfRange, "no order to choose from")
            .hint("name at least one family of models")),
    }
}
