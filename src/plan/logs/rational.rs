//! Rational fit of measured frequency responses: selection of the lines, responses by hit, and the motion quantity if none is
//! stated.

use super::frf_estimation::EstimatedResponses;
use super::identification_result::IdentifiedMode;
use super::identify_study::IdentifyStudy;
use super::method::IdentificationMethod;
use super::transfer_functions::{PartialFractions, without_window};
use crate::base::error::{Diagnostic, Error};
use crate::identify::initial_estimates::aaa::aaa;
use crate::identify::initial_estimates::problem::CommonPoleOptions;
use crate::identify::initial_estimates::vector_fitting::{InitialPoles, vector_fit};
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::rational::residual_delay::residual_delays;
use crate::identify::rational::{self, FrfData, RationalFit, RationalOptions, ResponsesByHit};
use crate::numeric::Complex;
use crate::recording::channel_unit::ResponseKind;
use crate::recording::frequency_responses::FrequencyResponses;
use crate::spectrum::impact::HitResponses;

/// Number of initial poles of another method: 20 pairs.
const INITIAL_ORDER: usize = 40;

/// Selection rule that separates modes from other poles of a rational fit, one sentence.
pub fn rule(method: IdentificationMethod, departs: bool) -> String {
    match method {
        IdentificationMethod::Rational if departs => "pole pairs are added while each lowers the misfit by more than noise and the departures of the modes from the model would; a pole next to another is kept only if the fit needs both".to_string(),
        IdentificationMethod::Rational => "pole pairs are added while each lowers the misfit by more than noise would, somewhere in the band".to_string(),
        _ => format!(
            "{INITIAL_ORDER} poles, refined together to the least misfit; the weakest pair is removed while it lowers the misfit by no more than noise would, somewhere in the band"
        ),
    }
}

/// Modes of a fit with their departures from linearity, shapes and participations over a table, corrected for the exponential
/// window, decay rate in 1/s.
///
/// # Errors
/// Errors of the decomposition into shapes.
pub fn modes_over_table(
    fit: &RationalFit,
    table: &[Vec<usize>],
    window_decay: f64,
) -> Result<Vec<IdentifiedMode>, Error> {
    let mode_over_table = |(k, mode): (usize, &ModalParameters)| {
        let mode = without_window(mode, window_decay);
        Ok(IdentifiedMode {
            departure: fit.departures.get(k).copied(),
            ..IdentifiedMode::mode_over_table(mode, table)?
        })
    };
    fit.modes.iter().enumerate().map(mode_over_table).collect()
}

/// Partial-fraction expansion of a fit.
pub fn partial_fractions(fit: &RationalFit) -> PartialFractions<'_> {
    PartialFractions {
        poles: &fit.poles,
        residues: &fit.residues,
        residual_terms: &fit.residual_terms,
        derivative: fit.derivative,
        delay_s: &fit.delay_s,
        fit_error: &fit.fit_error,
    }
}

/// Noise gain of the fourth difference of neighbouring lines, under the exponential window of the blocks:
/// `Σ w² (2 sin πn/N)⁸ / Σ w²`, 70 without one.
fn fourth_difference_gain(responses: &FrequencyResponses) -> f64 {
    const SAMPLES: usize = 4096;
    let lines = &responses.frequency_hz;
    let spacing_hz = lines.get(1).zip(lines.first()).map_or(1.0, |(b, a)| b - a);
    let decay = 2.0 * responses.window_decay / spacing_hz;
    let (mut sum, mut total) = (0.0, 0.0);
    for n in 0..SAMPLES {
        let t = (n as f64 + 0.5) / SAMPLES as f64;
        let weight = (-decay * t).exp();
        sum += weight * (2.0 * (std::f64::consts::PI * t).sin()).powi(8);
        total += weight;
    }
    sum / total
}

/// Minimum number of hits for the scatter of a mode between hits.
const MIN_HITS: usize = 3;

/// Warning about few hits: one hit gives no scatter between hits, two give a single difference.
fn few_hits(hits: usize) -> Option<Diagnostic> {
    let message = match hits {
        1 => {
            "one hit, step or release used: the scatter of repeats is unknown and not included in the intervals"
        }
        2 => {
            "two hits, steps or releases used: their scatter is estimated from one difference; intervals that include it are 12.7 standard errors (Student's t with one degree of freedom)"
        }
        _ => return None,
    };
    Some(Diagnostic {
        code: "few-hits",
        message: message.to_string(),
        hint: Some(format!("use {MIN_HITS} or more")),
    })
}

/// Warning about residual delays of the fit, with their phase at the top of the band.
fn residual_delay_warning(
    fit: &RationalFit,
    responses: &FrequencyResponses,
    top_hz: f64,
) -> Option<Diagnostic> {
    let delays = residual_delays(fit);
    let texts: Vec<String> = (delays.iter())
        .map(|d| {
            format!(
                "{} by {:.4} ± {:.4} ms ({:.1}° at {top_hz:.4} Hz)",
                responses.responses[d.response].output.name,
                1e3 * d.delay_s,
                1e3 * d.interval_s,
                360.0 * d.delay_s * top_hz
            )
        })
        .collect();
    let remedy = match delays.len() == responses.responses.len() {
        true => "--delay common",
        false => "--delay each",
    };
    (!texts.is_empty()).then(|| Diagnostic {
        code: "residual-delay",
        message: format!(
            "the phases of the residues fall in proportion to frequency, as behind a delay or a filter on one channel: {}",
            texts.join(", ")
        ),
        hint: Some(format!("fit it with {remedy}, or use equal filters on all channels")),
    })
}

/// Fits a rational model, with the initial poles of vector fitting or AAA on request.
///
/// # Errors
/// Errors of the fit.
pub fn fit_rational(
    method: IdentificationMethod,
    responses: &FrequencyResponses,
    estimated: Option<&EstimatedResponses>,
    band: (f64, f64),
    study: &IdentifyStudy,
) -> Result<RationalFit, Error> {
    let is_in_band = |k: &usize| (band.0..=band.1).contains(&responses.frequency_hz[*k]);
    let used: Vec<usize> = (0..responses.frequency_hz.len())
        .filter(|&k| responses.is_determined(k))
        .filter(is_in_band)
        .collect();
    let lines: Vec<f64> = used.iter().map(|&k| responses.frequency_hz[k]).collect();
    let values: Vec<Vec<Complex>> = (responses.responses.iter())
        .map(|f| used.iter().map(|&k| f.values[k]).collect())
        .collect();
    let variance: Option<Vec<Vec<f64>>> = (responses.responses.iter())
        .map(|f| {
            f.variance
                .as_ref()
                .map(|v| used.iter().map(|&k| v[k]).collect())
        })
        .collect();
    let poles = initial_poles(method, &lines, &values)?;
    let select_lines = |hit: &HitResponses| -> Vec<Vec<Complex>> {
        let all = hit.value.iter();
        all.map(|h| used.iter().map(|&k| h[k]).collect()).collect()
    };
    let by_hit = estimated.map_or(&[][..], |e| &e.hit_responses);
    let few_hits = few_hits(by_hit.len());
    // The variance has one degree of freedom per average less one per input; hits have a separate variance.
    let inputs = responses.index_matrix()[0].len() as f64;
    let variance_dof = (responses.averages)
        .map(|averages| averages - inputs)
        .filter(|dof| *dof > 0.0 && by_hit.len() < 2);
    let joined = by_hit.iter().map(|hit| hit.hits.len()).sum::<usize>() as f64;
    let by_hit: Vec<Vec<Vec<Complex>>> = by_hit.iter().map(select_lines).collect();
    let hits = (by_hit.len() > 1).then_some(ResponsesByHit {
        responses: &by_hit,
        hits_per_group: joined / by_hit.len() as f64,
        fourth_difference_gain: fourth_difference_gain(responses),
    });
    let fit = |derivative: u8| {
        let options = RationalOptions {
            band_hz: Some(band),
            order: study.order,
            allow_unstable: study.allow_unstable,
            delay: study.delay,
            ..RationalOptions::default()
        };
        let measured = FrfData {
            frequency_hz: &lines,
            responses: &values,
            variance: variance.as_deref(),
            variance_dof,
            smearing_hz: estimated.map_or(0.0, |e| e.smearing_hz),
            line_independence: responses.independent_lines_per_line.unwrap_or(1.0),
            derivative,
            hits,
        };
        match &poles {
            Some(poles) => rational::fit_from_poles(&measured, &options, poles),
            None => rational::fit(&measured, &options),
        }
    };
    let kinds: Vec<ResponseKind> = responses
        .responses
        .iter()
        .map(|f| ResponseKind::from_units(f.input.as_ref().map_or("", |i| &i.unit), &f.output.unit))
        .collect();
    let fitted = match (study.derivative, kinds.first()) {
        (Some(times), _) => fit(times),
        (None, Some(ResponseKind::MotionOverForce(times)))
            if kinds.iter().all(|k| k == &kinds[0]) =>
        {
            fit(*times)
        }
        (None, Some(ResponseKind::Unknown)) => {
            // Receptance and accelerance differ in the residual terms of modes outside the band: the better fit is used, unless the
            // departures from the model exceed the noise.
            let receptance = fit(0)?;
            let accelerance = match receptance.departs {
                true => None,
                false => fit(2).ok(),
            };
            Ok(accelerance
                .filter(|accelerance| cost(accelerance) < cost(&receptance))
                .unwrap_or(receptance))
        }
        _ => fit(0),
    };
    fitted.map(|mut fit| {
        fit.diagnostics.extend(few_hits);
        let delay_warning = residual_delay_warning(&fit, responses, band.1);
        fit.diagnostics.extend(delay_warning);
        fit
    })
}

/// Initial poles of a method, limited by the number of lines.
fn initial_poles(
    method: IdentificationMethod,
    lines: &[f64],
    values: &[Vec<Complex>],
) -> Result<Option<Vec<Complex>>, Error> {
    let order = INITIAL_ORDER.min(lines.len() / 4 * 2);
    let options = CommonPoleOptions::default();
    let poles = match method {
        IdentificationMethod::VectorFitting => {
            vector_fit(lines, values, None, InitialPoles::Order(order), options)?.poles
        }
        IdentificationMethod::Aaa => aaa(lines, values, order, options)?.poles,
        _ => return Ok(None),
    };
    Ok(Some(poles))
}

/// Bayesian information criterion of a fit (Schwarz 1978). The variance differs between fits, so χ² alone is not comparable.
fn cost(fit: &RationalFit) -> f64 {
    let unknowns = fit.poles.len() * 2 * (1 + fit.residues.len());
    2.0 * fit.negative_log_likelihood + unknowns as f64 * (fit.dof.max(2.0)).ln()
}
