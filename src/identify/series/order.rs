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
    /// The output as it is, without any coefficient: noise alone where no candidate has a smaller criterion.
    pub nothing: Candidate,
    /// None of the candidates has a smaller criterion than nothing.
    pub is_noise: bool,
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

    /// No coefficient at all: white noise.
    fn nothing(y: &[f64]) -> Candidate {
        let variance = y.iter().map(|y| y * y).sum::<f64>() / y.len().max(1) as f64;
        Candidate::new(Family::Ar { a: 0 }, variance, y.len())
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
    choose(candidates, Candidate::nothing(&y), criterion)
}

/// Orders one after the other that may leave the criterion where it is before the search ends.
const IN_VAIN: usize = 2;

/// The best of `families`, by rising order; those the samples do not determine are passed over, and where coefficients are iterated the
/// search ends after two that better nothing.
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
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut models = Vec::new();
    let mut failure = None;
    let (y, _) = centred(record.output());
    let nothing = Candidate::nothing(&y[first.min(y.len())..]);
    let (mut least, mut in_vain) = (nothing.value(criterion), 0);
    for &family in families {
        // What is iterated is slow where poles and zeros cancel, which they do beyond the right order.
        let lengths = family.lengths();
        if lengths.c + lengths.f > 0 && in_vain >= IN_VAIN {
            break;
        }
        in_vain += 1;
        match fit_from(record, family, first) {
            Ok(model) => {
                let freedoms = (model.samples - family.unknowns()) as f64;
                let variance = model.noise_variance * freedoms / model.samples as f64;
                let candidate = Candidate::new(family, variance, model.samples);
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
    candidates: Vec<Candidate>,
    nothing: Candidate,
    criterion: Criterion,
) -> Result<Choice, Error> {
    let best = (candidates.iter())
        .min_by(|a, b| a.value(criterion).total_cmp(&b.value(criterion)))
        .map(|c| (c.family, c.value(criterion)));
    match best {
        Some((family, value)) => Ok(Choice {
            family,
            candidates,
            is_noise: nothing.value(criterion) <= value,
            nothing,
        }),
        None => Err(Error::new(Code::OutOfRange, "no order to choose from")
            .hint("name at least one family of models")),
    }
}
