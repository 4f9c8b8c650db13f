//! Modes from time-series models (AR, ARMA, ARX, ARMAX, OE): model order by BIC, residual tests.

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
use crate::identify::operational::harmonics::{BAND_LINES, BandSpectra, KURTOSIS_HALF_BANDWIDTHS};
use crate::identify::operational::response_channels::ResponseChannels;
use crate::identify::series::autoregressive;
use crate::identify::series::io_data;
use crate::identify::series::model::{ModeShares, ModelStructure, PolynomialModel};
use crate::identify::series::order::{self, OrderCriterion};
use crate::identify::series::residuals::{ResidualTest, cross_correlation, ljung_box};

/// Highest order of AR and ARX models, which need no iteration.
const MAX_LINEAR_ORDER: usize = 60;

/// Highest order of iteratively fitted models.
pub const MAX_ITERATIVE_ORDER: usize = 12;

/// Minimum number of samples per unknown.
const SAMPLES_PER_UNKNOWN: usize = 10;

/// Number of tested lags beyond the number of coefficients.
const LAGS: usize = 20;

/// Significance level of the residual tests.
const TEST_LEVEL: f64 = 0.01;

/// Identifies modes from the output, the last channel of the record; the first of two channels is the input.
///
/// # Errors
/// Errors of the fit: too few samples, or equations that do not determine the coefficients.
pub fn identify_time_series(
    method: IdentificationMethod,
    samples: &SegmentSamples,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<SignalIdentification, Error> {
    let record = to_io_data(samples)?;
    let output = record.output();
    let max_order = (output.len() / SAMPLES_PER_UNKNOWN).max(2);
    let orders: Vec<usize> = match study.order {
        Some(modes) => {
            check_cost(method, 2 * modes, output.len())?;
            vec![2 * modes]
        }
        None => {
            let highest = match method {
                IdentificationMethod::Ar | IdentificationMethod::Arx => {
                    MAX_LINEAR_ORDER.min(max_order)
                }
                _ => MAX_ITERATIVE_ORDER.min(max_order),
            };
            (2..=highest).step_by(2).collect()
        }
    };
    let last_order = orders.last().copied().unwrap_or(2);
    let (model, choice) = match (method, study.order) {
        (IdentificationMethod::Ar, _) => {
            let choice = order::select_ar_order(&record, last_order, OrderCriterion::Bic)?;
            let a = study
                .order
                .map_or(choice.family.parameter_count(), |m| 2 * m);
            let model = autoregressive::fit(&record, a, autoregressive::ArMethod::Burg)?;
            (model, choice)
        }
        _ => {
            let structures: Vec<ModelStructure> = orders
                .iter()
                .map(|&n| structure_of_order(method, n))
                .collect();
            order::select_structure(&record, &structures, OrderCriterion::Bic)?
        }
    };
    let mut diagnostics = samples.diagnostics.clone();
    let is_last = model.family == structure_of_order(method, last_order) && orders.len() > 1;
    if is_last && !choice.is_noise {
        diagnostics.push(Diagnostic {
            code: "order-limit",
            message: format!(
                "BIC still falls at {}, the end of the search",
                method::structure_text(model.family)
            ),
            hint: Some("state a higher --order, or narrow the --band".to_string()),
        });
    }
    let (modes, omitted) = match choice.is_noise {
        true => {
            diagnostics.push(Diagnostic {
                code: "no-mode",
                message: "no model lowers the BIC below that of none: the output is indistinguishable from noise".to_string(),
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
            .filter_map(|(property, test)| residual_diagnostic(property, test)),
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

/// Input and output of the samples: the last channel is the output, the first of two the input.
///
/// # Errors
/// Errors of [`io_data::InputOutputData`].
pub fn to_io_data(samples: &SegmentSamples) -> Result<io_data::InputOutputData<'_>, Error> {
    match samples.samples.as_slice() {
        [input, output] => {
            io_data::InputOutputData::new(output, samples.rate_hz)?.with_input(input)
        }
        channels => io_data::InputOutputData::new(&channels[0], samples.rate_hz),
    }
}

/// Rejects an order with more unknowns than half the samples, or with a fit beyond the time limit.
pub fn check_cost(method: IdentificationMethod, order: usize, samples: usize) -> Result<(), Error> {
    /// Time limit of a fit, s; number of iterations of a slow fit; operations per second.
    const TIME_LIMIT_S: f64 = 300.0;
    const STEPS: f64 = 100.0;
    const OPERATIONS_PER_S: f64 = 1e9;
    let unknowns = structure_of_order(method, order).parameter_count();
    if unknowns * 2 > samples {
        let message = format!(
            "--order {} makes {} with {unknowns} unknowns; {samples} samples support {} at most",
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
        let limit = (TIME_LIMIT_S * OPERATIONS_PER_S / steps / samples as f64).sqrt() as usize;
        let per_mode = unknowns / (order / 2).max(1);
        let message = format!(
            "{} over {samples} samples would take about {seconds:.0} s",
            method::structure_text(structure_of_order(method, order))
        );
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(format!(
            "request {} modes at most, take a part of the record (--before), or narrow the --band, which decimates",
            (limit / per_mode.max(1)).max(1)
        )));
    }
    Ok(())
}

/// Minimum share of a root in the response at its natural frequency for a mode.
const MIN_PEAK_SHARE: f64 = 0.5;

/// Minimum share of a root in the power of the output for a mode.
const MIN_POWER_SHARE: f64 = 1e-4;

/// Roots inside the band: modes, and rejected roots with the reason.
type ClassifiedRoots = (Vec<IdentifiedMode>, Vec<(ModalParameters, &'static str)>);

/// Separates modes from roots that only fill up the polynomial.
fn classify_roots(
    model: &PolynomialModel,
    record: &io_data::InputOutputData,
    band_hz: (f64, f64),
) -> Result<ClassifiedRoots, Error> {
    let signals = [record.output()];
    let channels = ResponseChannels::new(&signals, model.rate_hz)?;
    // The response to a measured harmonic input has a constant envelope without a harmonic of the running speed.
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
        let half_band_hz = (KURTOSIS_HALF_BANDWIDTHS * damping * f).max(BAND_LINES * spacing);
        let harmonic = (bands.as_ref())
            .map(|b| b.examine_band(0, mode.damped_frequency_hz(), half_band_hz, None));
        modes.push(IdentifiedMode {
            harmonic,
            ..IdentifiedMode::from(mode)
        });
    }
    Ok((modes, omitted))
}

/// Reason why a root is rejected; `None` for a mode.
pub fn rejection_reason(mode: &ModalParameters, shares: ModeShares) -> Option<&'static str> {
    let max_damping = SelectionRule::default().max_damping_ratio;
    let (damping, f) = (mode.damping_ratio(), mode.frequency_hz());
    let std = mode.frequency_std_hz().unwrap_or(0.0);
    match () {
        () if damping <= 0.0 => Some("it is unstable"),
        () if damping > max_damping => Some("its damping is too high for a resonance"),
        () if std > damping * f => Some("its frequency uncertainty exceeds its half-power width"),
        () if shares.at_peak < MIN_PEAK_SHARE || shares.power < MIN_POWER_SHARE => {
            Some("other roots dominate the response at its frequency")
        }
        () => None,
    }
}

/// Rule that separates modes from other roots, as text.
pub fn root_rule_text() -> String {
    format!(
        "a root inside the band is a mode if its damping ratio is up to {}, its frequency known to half its bandwidth, and it makes \
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

/// Warning for residuals whose test is significant: part of the response is not modelled.
pub(super) fn residual_diagnostic(what: &str, test: &ResidualTest) -> Option<Diagnostic> {
    (test.probability < TEST_LEVEL).then(|| Diagnostic {
        code: "residuals",
        message: format!(
            "the residuals are not {what} ({}): the intervals are too narrow",
            match test.probability < 1e-16 {
                true => "p below 1e-16".to_string(),
                false => format!("p = {:.1e}", test.probability),
            }
        ),
        hint: Some("state a higher --order, or use another model structure".to_string()),
    })
}

/// Ljung–Box test of whiteness of residuals; `fitted` is the number of fitted coefficients.
pub(super) fn whiteness_test(residuals: &[f64], fitted: usize) -> Result<ResidualTest, Error> {
    ljung_box(residuals, fitted + LAGS, fitted)
}

/// Tests whether the residuals are white, and uncorrelated with the input.
fn residual_tests(
    model: &PolynomialModel,
    record: &io_data::InputOutputData,
) -> Result<Vec<(&'static str, ResidualTest)>, Error> {
    let errors = model.residuals(record)?;
    // The first residuals contain the start-up transient of the recursion.
    let start = model.family.parameter_count().min(errors.len());
    let residuals = &errors[start..];
    let fitted = model.a.len() + model.c.len();
    let mut tests = vec![("white", whiteness_test(residuals, fitted)?)];
    if let Some(input) = record.input().filter(|_| !model.b.is_empty()) {
        let test = cross_correlation(residuals, &input[start..], LAGS)?;
        tests.push(("uncorrelated with the input", test));
    }
    Ok(tests)
}
