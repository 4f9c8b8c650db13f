//! Modes from difference equations: the order by Schwarz's criterion, the residuals tested.

use super::found::{Evidence, FoundMode, Orders};
use super::method::{self, Method};
use super::modal::within;
use super::record::Record;
use super::study::IdentifyStudy;
use crate::base::error::{Error, Warning};
use crate::identify::modal::selection::SelectionRule;
use crate::identify::series::autoregressive;
use crate::identify::series::model::{Family, SeriesModel};
use crate::identify::series::order::{self, Criterion};
use crate::identify::series::record;
use crate::identify::series::residuals::{cross_correlation, ljung_box};

/// What such a method answers.
pub struct Series {
    /// Modes.
    pub modes: Vec<FoundMode>,
    /// How they were told from other poles.
    pub rule: String,
    /// Orders tried, and tests.
    pub evidence: Evidence,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// The highest order of a recursion over orders, and of a linear fit for each.
const LINEAR: usize = 60;

/// The highest order where each is iterated.
const ITERATED: usize = 12;

/// Samples wanted for each unknown.
const SAMPLES_PER_UNKNOWN: usize = 10;

/// Lags tested beyond the coefficients.
const LAGS: usize = 20;

/// Residuals as unlikely as this leave something unmodelled.
const UNLIKELY: f64 = 0.01;

/// Identifies from an output, the last channel of the record, and from an input, the first of two.
///
/// # Errors
/// Those of the fit: too few samples, equations that do not determine the coefficients.
pub fn identify(
    method: Method,
    samples: &Record,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<Series, Error> {
    let (output, input) = match samples.samples.as_slice() {
        [input, output] => (output, Some(input)),
        all => (&all[0], None),
    };
    let mut record = record::Record::new(output, samples.rate_hz)?;
    if let Some(input) = input {
        record = record.driven_by(input)?;
    }
    let bearable = (output.len() / SAMPLES_PER_UNKNOWN).max(2);
    let orders: Vec<usize> = match study.order {
        Some(modes) => vec![2 * modes],
        None => {
            let most = match method {
                Method::Ar | Method::Arx => LINEAR.min(bearable),
                _ => ITERATED.min(bearable),
            };
            (2..=most).step_by(2).collect()
        }
    };
    let (model, candidates) = match (method, study.order) {
        (Method::Ar, None) => {
            let most = orders.last().copied().unwrap_or(2);
            let choice = order::autoregressive(&record, most, Criterion::Bic)?;
            let a = choice.family.unknowns();
            let model = autoregressive::fit(&record, a, autoregressive::Method::Burg)?;
            (model, choice.candidates)
        }
        (Method::Ar, Some(modes)) => {
            let model = autoregressive::fit(&record, 2 * modes, autoregressive::Method::Burg)?;
            (model, Vec::new())
        }
        _ => {
            let families: Vec<Family> = orders.iter().map(|&n| of_order(method, n)).collect();
            let (model, choice) = order::among(&record, &families, Criterion::Bic)?;
            (model, choice.candidates)
        }
    };
    let most_damping = SelectionRule::default().most_damping;
    let is_mode = |m: &FoundMode| {
        let damping = m.mode.damping_ratio();
        damping > 0.0 && damping <= most_damping && within(m.mode.pole, band_hz)
    };
    let modes = model
        .modes()?
        .into_iter()
        .map(FoundMode::from)
        .filter(is_mode)
        .collect();
    let tests = tests(&model, &record)?;
    let mut warnings = samples.warnings.clone();
    for (what, test) in &tests {
        if test.probability < UNLIKELY {
            let message = format!(
                "the residuals are not {what}: chance gives as much with p = {:.1e}, so the intervals are too narrow",
                test.probability
            );
            warnings.push(Warning {
                code: "residuals",
                message,
                hint: Some("state a higher --order, or take another family of models".to_string()),
            });
        }
    }
    let rule = format!(
        "{} by the smallest BIC; roots with a damping ratio up to {most_damping} inside the band are modes",
        method::family(model.family)
    );
    Ok(Series {
        modes,
        rule,
        evidence: Evidence::Orders(Orders {
            chosen: model.family,
            candidates,
            tests,
        }),
        warnings,
    })
}

fn of_order(method: Method, n: usize) -> Family {
    match method {
        Method::Arma => Family::Arma { a: n, c: n - 1 },
        Method::Arx => Family::Arx {
            a: n,
            b: n + 1,
            delay: 0,
        },
        Method::Armax => Family::Armax {
            a: n,
            b: n + 1,
            c: n,
            delay: 0,
        },
        Method::OutputError => Family::OutputError {
            b: n + 1,
            f: n,
            delay: 0,
        },
        _ => Family::Ar { a: n },
    }
}

/// Whether the residuals are white, and unrelated to the input.
fn tests(
    model: &SeriesModel,
    record: &record::Record,
) -> Result<Vec<(&'static str, crate::identify::series::residuals::Test)>, Error> {
    let all = model.residuals(record)?;
    // The first ones only start the recursion.
    let start = model.family.unknowns().min(all.len());
    let residuals = &all[start..];
    let fitted = model.a.len() + model.c.len();
    let mut tests = vec![("white", ljung_box(residuals, fitted + LAGS, fitted)?)];
    if let Some(input) = record.input().filter(|_| !model.b.is_empty()) {
        let test = cross_correlation(residuals, &input[start..], LAGS)?;
        tests.push(("unrelated to the input", test));
    }
    Ok(tests)
}
