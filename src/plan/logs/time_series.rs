//! Modes from time-series models: structure by BIC, residual tests.

use super::frf_modes::natural_frequency_is_in_band;
use super::identification_result::{
    Evidence, IdentifiedMode, OrderSelection, SignalIdentification, split_harmonics,
};
use super::identify_study::IdentifyStudy;
use super::method::{self, IdentificationMethod};
use super::running;
use super::segment_samples::SegmentSamples;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::identify::modal::selection::SelectionRule;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::operational::harmonics::{BandSpectra, KURTOSIS_HALF_BANDWIDTHS, LINES};
use crate::identify::operational::response_channels::ResponseChannels;
use crate::identify::series::autoregressive;
use crate::identify::series::io_data;
use crate::identify::series::model::{ModeShares, ModelStructure, PolynomialModel};
use crate::identify::series::order::{self, OrderCriterion};
use crate::identify::series::residuals::{ResidualTest, cross_correlation, ljung_box};

/// The highest order of a recursion over orders, and of a linear fit for each.
const MAX_LINEAR_ORDER: usize = 60;

/// The highest order where each is iterated.
pub const MAX_ITERATIVE_ORDER: usize = 12;

/// Samples wanted for each unknown.
const SAMPLES_PER_UNKNOWN: usize = 10;

/// Lags tested beyond the coefficients.
const LAGS: usize = 20;

/// Residuals as unlikely as this leave something unmodelled.
const TEST_LEVEL: f64 = 0.01;

/// Identifies from an output, the last channel of the record, and from an input, the first of two.
///
/// # Errors
/// Those of the fit: too few samples, equations that do not determine the coefficients.
pub fn identify_time_series(
    method: IdentificationMethod,
    samples: &SegmentSamples,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<SignalIdentification, Error> {
    let record = to_io_data(samples)?;
    let output = record.output();
    let bearable = (output.len() / SAMPLES_PER_UNKNOWN).max(2);
    let orders: Vec<usize> = match study.order {
        Some(modes) => {
            check_cost(method, 2 * modes, output.len())?;
            vec![2 * modes]
        }
        None => {
            let most = match method {
                IdentificationMethod::Ar | IdentificationMethod::Arx => {
                    MAX_LINEAR_ORDER.min(bearable)
                }
                _ => MAX_ITERATIVE_ORDER.min(bearable),
            };
            (2..=most).step_by(2).collect()
        }
    };
    let last = orders.last().copied().unwrap_or(2);
    let (model, choice) = match (method, study.order) {
        (IdentificationMethod::Ar, _) => {
            let choice = order::select_ar_order(&record, last, OrderCriterion::Bic)?;
            let a = study
                .order
                .map_or(choice.family.parameter_count(), |m| 2 * m);
            let model = autoregressive::fit(&record, a, autoregressive::ArMethod::Burg)?;
            (model, choice)
        }
        _ => {
            let families: Vec<ModelStructure> = orders
                .iter()
                .map(|&n| structure_of_order(method, n))
                .collect();
            order::select_structure(&record, &families, OrderCriterion::Bic)?
        }
    };
    let mut diagnostics = samples.diagnostics.clone();
    let is_last = model.family == structure_of_order(method, last) && orders.len() > 1;
    if is_last && !choice.is_noise {
        diagnostics.push(Diagnostic {
            code: "order-limit",
            message: format!(
                "BIC still falls at {}, where the search ends",
                method::structure_text(model.family)
            ),
            hint: Some("state a higher --order, or narrow the --band".to_string()),
        });
    }
    let (modes, omitted) = match choice.is_noise {
        true => {
            diagnostics.push(Diagnostic {
                code: "no-mode",
                message: "no model has a smaller BIC than none at all: the output is noise, as far as this method sees".to_string(),
                hint: Some("check whether the channel is the right one; take a longer record".to_string()),
            });
            (Vec::new(), Vec::new())
        }
        false => classify_roots(&model, &record, band_hz)?,
    };
    let (modes, harmonics) = split_harmonics(modes);
    diagnostics.extend(running::harmonic_warning(&harmonics));
    let tests = residual_tests(&model, &record)?;
    diagnostics.extend(
        tests
            .iter()
            .filter_map(|(what, test)| residual_diagnostic(what, test)),
    );
    let rule = format!(
        "{} {}; {}",
        method::structure_text(model.family),
        match study.order {
            Some(_) => "as requested",
            None => "by the smallest BIC",
        },
        root_rule_text()
    );
    Ok(SignalIdentification {
        modes,
        weak: Vec::new(),
        harmonics,
        selection_rule: rule,
        evidence: Evidence::Orders(OrderSelection {
            chosen: model.family,
            candidates: std::iter::once(choice.white_noise)
                .chain(choice.candidates)
                .collect(),
            omitted,
            tests,
        }),
        diagnostics,
    })
}

/// An output, the last channel, and an input, the first of two.
///
/// # Errors
/// Those of [`record::Record`].
pub fn to_io_data(samples: &SegmentSamples) -> Result<io_data::InputOutputData<'_>, Error> {
    match samples.samples.as_slice() {
        [input, output] => {
            io_data::InputOutputData::new(output, samples.rate_hz)?.with_input(input)
        }
        all => io_data::InputOutputData::new(&all[0], samples.rate_hz),
    }
}

/// Refuses an order that the samples do not bear, or that would take too long.
pub fn check_cost(method: IdentificationMethod, order: usize, samples: usize) -> Result<(), Error> {
    /// Seconds worth waiting for, steps of a slow iteration, and operations a second.
    const TIME_LIMIT_S: f64 = 300.0;
    const STEPS: f64 = 100.0;
    const OPERATIONS_PER_S: f64 = 1e9;
    let unknowns = structure_of_order(method, order).parameter_count();
    if unknowns * 2 > samples {
        let message = format!(
            "--order {} makes {} with {unknowns} unknowns; {samples} samples bear {} at most",
            order / 2,
            method::structure_text(structure_of_order(method, order)),
            samples / 2
        );
        return Err(
            Error::new(Code::TooShort, message).with_hint("lower --order, or take a longer record")
        );
    }
    let steps = match method {
        IdentificationMethod::Ar | IdentificationMethod::Arx => 1.0,
        _ => STEPS,
    };
    let seconds = steps * samples as f64 * (unknowns * unknowns) as f64 / OPERATIONS_PER_S;
    if seconds > TIME_LIMIT_S {
        let bearable = (TIME_LIMIT_S * OPERATIONS_PER_S / steps / samples as f64).sqrt() as usize;
        let per_mode = unknowns / (order / 2).max(1);
        let message = format!(
            "{} over {samples} samples would take about {seconds:.0} s",
            method::structure_text(structure_of_order(method, order))
        );
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(format!(
            "request {} modes at most, take a part of the record (--before), or narrow the --band, which decimates",
            (bearable / per_mode.max(1)).max(1)
        )));
    }
    Ok(())
}

/// Share of the response at its own frequency that makes a root a mode.
const MIN_PEAK_SHARE: f64 = 0.5;

/// Share of the power of the output below which a root is noise, whatever its shape.
const MIN_POWER_SHARE: f64 = 1e-4;

/// Roots inside the band: modes, and what is none, with the reason.
type ClassifiedRoots = (Vec<IdentifiedMode>, Vec<(ModalParameters, &'static str)>);

/// Tells modes from roots that only fill up the polynomial.
fn classify_roots(
    model: &PolynomialModel,
    record: &io_data::InputOutputData,
    band_hz: (f64, f64),
) -> Result<ClassifiedRoots, Error> {
    let signals = [record.output()];
    let channels = ResponseChannels::new(&signals, model.rate_hz)?;
    // A response to a measured input may be as constant as that is.
    let bands = (record.input().is_none()).then(|| BandSpectra::new(&channels));
    let spacing = model.rate_hz / record.output().len() as f64;
    let (mut modes, mut omitted) = (Vec::new(), Vec::new());
    for (mode, shares) in model.modes()?.into_iter().zip(model.mode_shares()?) {
        if !natural_frequency_is_in_band(mode.pole, band_hz) {
            continue;
        }
        if let Some(reason) = rejection_reason(&mode, shares) {
            omitted.push((mode, reason));
            continue;
        }
        let (damping, f) = (mode.damping_ratio(), mode.frequency_hz());
        let half = (KURTOSIS_HALF_BANDWIDTHS * damping * f).max(LINES * spacing);
        let harmonic =
            (bands.as_ref()).map(|b| b.examine_band(0, mode.damped_frequency_hz(), half, None));
        modes.push(IdentifiedMode {
            harmonic,
            ..IdentifiedMode::from(mode)
        });
    }
    Ok((modes, omitted))
}

/// Why a root is no mode.
pub fn rejection_reason(mode: &ModalParameters, shares: ModeShares) -> Option<&'static str> {
    let most_damping = SelectionRule::default().max_damping_ratio;
    let (damping, f) = (mode.damping_ratio(), mode.frequency_hz());
    let std = mode.frequency_std_hz().unwrap_or(0.0);
    match () {
        () if damping <= 0.0 => Some("it grows"),
        () if damping > most_damping => Some("it is damped too much for a resonance"),
        () if std > damping * f => Some("its frequency is less certain than its half-power width"),
        () if shares.at_peak < MIN_PEAK_SHARE || shares.power < MIN_POWER_SHARE => Some(
            "it fills up the polynomial: other roots make most of the response at its frequency",
        ),
        () => None,
    }
}

/// Rule that separates modes from other roots, as text.
pub fn root_rule_text() -> String {
    format!(
        "a root inside the band is a mode where its damping ratio is up to {}, its frequency known to half its bandwidth, and it makes \
         up {} % of the response at its own frequency",
        SelectionRule::default().max_damping_ratio,
        100.0 * MIN_PEAK_SHARE
    )
}

fn structure_of_order(method: IdentificationMethod, n: usize) -> ModelStructure {
    match method {
        IdentificationMethod::Arma => ModelStructure::Arma { a: n, c: n - 1 },
        IdentificationMethod::Arx => ModelStructure::Arx {
            a: n,
            b: n + 1,
            delay: 0,
        },
        IdentificationMethod::Armax => ModelStructure::Armax {
            a: n,
            b: n + 1,
            c: n,
            delay: 0,
        },
        IdentificationMethod::OutputError => ModelStructure::OutputError {
            b: n + 1,
            f: n,
            delay: 0,
        },
        _ => ModelStructure::Ar { a: n },
    }
}

/// That residuals hold what should have been modelled, where chance does not give as much.
pub(super) fn residual_diagnostic(what: &str, test: &ResidualTest) -> Option<Diagnostic> {
    (test.probability < TEST_LEVEL).then(|| Diagnostic {
        code: "residuals",
        message: format!(
            "the residuals are not {what}: chance gives as much with {}, so the intervals are too narrow",
            match test.probability < 1e-16 {
                true => "p below 1e-16".to_string(),
                false => format!("p = {:.1e}", test.probability),
            }
        ),
        hint: Some("state a higher --order, or take another family of models".to_string()),
    })
}

/// Whether residuals of a model of so many fitted coefficients are white.
pub(super) fn whiteness_test(residuals: &[f64], fitted: usize) -> Result<ResidualTest, Error> {
    ljung_box(residuals, fitted + LAGS, fitted)
}

/// Whether the residuals are white, and unrelated to the input.
fn residual_tests(
    model: &PolynomialModel,
    record: &io_data::InputOutputData,
) -> Result<Vec<(&'static str, ResidualTest)>, Error> {
    let all = model.residuals(record)?;
    // The first ones only start the recursion.
    let start = model.family.parameter_count().min(all.len());
    let residuals = &all[start..];
    let fitted = model.a.len() + model.c.len();
    let mut tests = vec![("white", whiteness_test(residuals, fitted)?)];
    if let Some(input) = record.input().filter(|_| !model.b.is_empty()) {
        let test = cross_correlation(residuals, &input[start..], LAGS)?;
        tests.push(("unrelated to the input", test));
    }
    Ok(tests)
}
