//! A rational fit of measured responses: the lines known, hit by hit where there are hits, of the kind that fits better where none is
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

/// Poles that another method begins with: 20 pairs.
const INITIAL_ORDER: usize = 40;

/// Rule by which a rational fit separates modes from other poles.
pub fn rule(method: IdentificationMethod, departs: bool) -> String {
    match method {
        IdentificationMethod::Rational if departs => "pole pairs are added while each lowers the misfit by more than noise and the departures of the modes from the model would; a pole next to another is kept only if one pole less would not do".to_string(),
        IdentificationMethod::Rational => "pole pairs are added while each lowers the misfit by more than noise would, somewhere in the band".to_string(),
        _ => format!(
            "{INITIAL_ORDER} poles, refined together to the least misfit; the weakest pair is taken out while it lowers the misfit by no more than noise would, somewhere in the band"
        ),
    }
}

/// Modes of a fit with their departures, shapes over the outputs and inputs of a table, without the exponential window, 1/s, on the
/// responses.
///
/// # Errors
/// Those of the decomposition into shapes.
pub fn modes_over_table(
    fit: &RationalFit,
    table: &[Vec<usize>],
    window_decay: f64,
) -> Result<Vec<IdentifiedMode>, Error> {
    let one = |(k, mode): (usize, &ModalParameters)| {
        let mode = without_window(mode, window_decay);
        Ok(IdentifiedMode {
            departure: fit.departures.get(k).copied(),
            ..IdentifiedMode::mode_over_table(mode, table)?
        })
    };
    fit.modes.iter().enumerate().map(one).collect()
}

/// A fit as partial fractions.
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

/// Power of a fourth difference of neighbouring lines over that of their noise, under the exponential window on the blocks:
/// `Σ w² (2 sin πn/N)⁸ / Σ w²`, 70 without one.
fn fourth(responses: &FrequencyResponses) -> f64 {
    const SAMPLES: usize = 4096;
    let lines = &responses.frequency_hz;
    let apart = lines.get(1).zip(lines.first()).map_or(1.0, |(b, a)| b - a);
    let fall = 2.0 * responses.window_decay / apart;
    let (mut sum, mut total) = (0.0, 0.0);
    for n in 0..SAMPLES {
        let t = (n as f64 + 0.5) / SAMPLES as f64;
        let weight = (-fall * t).exp();
        sum += weight * (2.0 * (std::f64::consts::PI * t).sin()).powi(8);
        total += weight;
    }
    sum / total
}

/// Fewer hits do not say well how far they place a mode apart.
const MIN_HITS: usize = 3;

/// The interval of one hit lacks what hits differ by; that of two knows it by a single difference.
fn few_hits(hits: usize) -> Option<Diagnostic> {
    let message = match hits {
        1 => {
            "one hit, step or release used: how far repeats place a mode apart is not known, and no interval includes it"
        }
        2 => {
            "two hits, steps or releases used: their scatter rests on one difference, and where they differ intervals are 12.7 standard errors (Student's t with one degree of freedom)"
        }
        _ => return None,
    };
    Some(Diagnostic {
        code: "few-hits",
        message: message.to_string(),
        hint: Some(format!("use {MIN_HITS} or more")),
    })
}

/// Names the responses whose residues hold a delay that the fit does not, with its phase at the top of the band.
fn residual_delay_warning(
    fit: &RationalFit,
    responses: &FrequencyResponses,
    top_hz: f64,
) -> Option<Diagnostic> {
    let delays = residual_delays(fit);
    let all: Vec<String> = (delays.iter())
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
    (!all.is_empty()).then(|| Diagnostic {
        code: "residual-delay",
        message: format!(
            "the phases of the residues fall in proportion to frequency, as behind a delay or a filter on one channel: {}",
            all.join(", ")
        ),
        hint: Some(format!("fit it with {remedy}, or use equal filters on all channels")),
    })
}

/// Rational fit, from the poles of another method on request.
///
/// # Errors
/// Those of the fit.
pub fn fit_rational(
    method: IdentificationMethod,
    responses: &FrequencyResponses,
    estimated: Option<&EstimatedResponses>,
    band: (f64, f64),
    study: &IdentifyStudy,
) -> Result<RationalFit, Error> {
    let inside = |k: &usize| (band.0..=band.1).contains(&responses.frequency_hz[*k]);
    let known: Vec<usize> = (0..responses.frequency_hz.len())
        .filter(|&k| responses.is_determined(k))
        .filter(inside)
        .collect();
    let lines: Vec<f64> = known.iter().map(|&k| responses.frequency_hz[k]).collect();
    let values: Vec<Vec<Complex>> = (responses.responses.iter())
        .map(|f| known.iter().map(|&k| f.values[k]).collect())
        .collect();
    let variance: Option<Vec<Vec<f64>>> = (responses.responses.iter())
        .map(|f| {
            f.variance
                .as_ref()
                .map(|v| known.iter().map(|&k| v[k]).collect())
        })
        .collect();
    let start = start(method, &lines, &values)?;
    let of_hit = |hit: &HitResponses| -> Vec<Vec<Complex>> {
        let all = hit.value.iter();
        all.map(|h| known.iter().map(|&k| h[k]).collect()).collect()
    };
    let by_hit = estimated.map_or(&[][..], |e| &e.by_hit);
    let few_hits = few_hits(by_hit.len());
    // Each average takes one degree of freedom, and each input of them gives one back; hits have a variance of their own.
    let inputs = responses.index_matrix()[0].len() as f64;
    let variance_dof = (responses.averages)
        .map(|averages| averages - inputs)
        .filter(|dof| *dof > 0.0 && by_hit.len() < 2);
    let joined = by_hit.iter().map(|hit| hit.hits.len()).sum::<usize>() as f64;
    let by_hit: Vec<Vec<Vec<Complex>>> = by_hit.iter().map(of_hit).collect();
    let hits = (by_hit.len() > 1).then_some(ResponsesByHit {
        responses: &by_hit,
        joined: joined / by_hit.len() as f64,
        fourth: fourth(responses),
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
        match &start {
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
            // Receptance and accelerance differ in what modes outside the band leave in it: the better of the two. Where responses depart
            // from the model by more than their noise, that decides nothing.
            let plain = fit(0)?;
            let twice = match plain.departs {
                true => None,
                false => fit(2).ok(),
            };
            Ok(twice
                .filter(|twice| cost(twice) < cost(&plain))
                .unwrap_or(plain))
        }
        _ => fit(0),
    };
    fitted.map(|mut fit| {
        fit.diagnostics.extend(few_hits);
        let left = residual_delay_warning(&fit, responses, band.1);
        fit.diagnostics.extend(left);
        fit
    })
}

/// The poles a method begins with: as many as the lines carry.
fn start(
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

/// Likelihood and size of a fit in one number (Schwarz 1978). Each fit has a variance of its own, so that χ² alone compares nothing.
fn cost(fit: &RationalFit) -> f64 {
    let unknowns = fit.poles.len() * 2 * (1 + fit.residues.len());
    2.0 * fit.negative_log_likelihood + unknowns as f64 * (fit.dof.max(2.0)).ln()
}
