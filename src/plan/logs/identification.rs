//! From a log to modes and transfer functions: each stage once, in this order, and a trace kept.

use std::time::Instant;

use super::acquire::{self, Acquired, EstimateStudy};
use super::doubts;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::identify::mode::IdentifiedMode;
use crate::identify::rational::{self, Delay, Measured, RationalFit, RationalOptions};
use crate::identify::transfer::function::{Direct, TransferFunction};
use crate::numeric::Complex;
use crate::recording::quantity::ResponseKind;
use crate::recording::responses::{FrequencyResponse, FrequencyResponses};
use crate::recording::settle::no_channel;
use crate::recording::signals::Recording;
use crate::spectrum::impact::Hit;

/// What is asked of a log.
#[derive(Debug, Clone, Default)]
pub struct IdentifyStudy {
    /// Channels that drive.
    pub inputs: Vec<String>,
    /// Channels that answer.
    pub outputs: Vec<String>,
    /// How responses are estimated.
    pub estimate: EstimateStudy,
    /// Lines used, Hz.
    pub band_hz: Option<(f64, f64)>,
    /// Pole pairs; as many as are significant where `None`.
    pub order: Option<usize>,
    /// A delay to be estimated.
    pub delay: Delay,
    /// Poles may be unstable.
    pub allow_unstable: bool,
    /// How often the motion in every response was differentiated, where the units do not tell.
    pub derivative: Option<u8>,
}

/// Modes and transfer functions, and how they were had.
#[derive(Debug)]
pub struct Identification {
    /// Stages that ran, with seconds.
    pub trace: Vec<(&'static str, f64)>,
    /// How the responses were had, in words.
    pub how: String,
    /// Hits of an impact test.
    pub hits: Vec<Hit>,
    /// The responses that were fitted.
    pub responses: FrequencyResponses,
    /// Lines that were fitted, Hz.
    pub band_hz: (f64, f64),
    /// The fit as it came out, an exponential window still on it.
    pub fit: RationalFit,
    /// Modes, the window taken off.
    pub modes: Vec<IdentifiedMode>,
    /// One transfer function for each response, the window taken off.
    pub functions: Vec<TransferFunction>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// What is identified from.
pub enum Source<'a> {
    /// Signals.
    Signals(&'a Recording),
    /// Responses that somebody else estimated.
    Responses(FrequencyResponses),
}

/// Identifies.
///
/// # Errors
/// Those of the stages: channels that are not there, nothing to fit, a band without lines.
pub fn identify(source: Source, study: &IdentifyStudy) -> Result<Identification, Error> {
    let mut trace = Vec::new();
    let (responses, acquired) = match source {
        Source::Responses(responses) => (chosen(responses, study)?, None),
        Source::Signals(recording) => {
            let start = Instant::now();
            let acquired = estimate(recording, study)?;
            trace.push(("frequency responses", start.elapsed().as_secs_f64()));
            (acquired.responses.clone(), Some(acquired))
        }
    };
    let band = band(&responses, acquired.as_ref(), study)?;
    let start = Instant::now();
    let fit = fitted(&responses, acquired.as_ref(), band, study)?;
    trace.push(("rational fit", start.elapsed().as_secs_f64()));
    let decay = responses.window_decay;
    let modes: Vec<IdentifiedMode> = fit
        .modes
        .iter()
        .map(|mode| without_window(mode, decay))
        .collect();
    let start = Instant::now();
    let functions = transfer_functions(&responses, &fit, decay)?;
    trace.push(("transfer functions", start.elapsed().as_secs_f64()));
    let mut warnings = acquired.as_ref().map_or(Vec::new(), |a| a.warnings.clone());
    warnings.extend(doubts::of_kinds(&responses));
    warnings.extend(fit.warnings.iter().cloned());
    warnings.extend(doubts::of_modes(&responses, acquired.as_ref(), &fit.modes));
    let (how, hits) = match acquired {
        Some(acquired) => (acquired.how, acquired.hits),
        None => (
            format!(
                "{} responses over {} lines, as read",
                responses.functions.len(),
                responses.frequency_hz.len()
            ),
            Vec::new(),
        ),
    };
    Ok(Identification {
        trace,
        how,
        hits,
        responses,
        band_hz: band,
        fit,
        modes,
        functions,
        warnings,
    })
}

/// Of the responses in a file those that are asked for.
fn chosen(
    mut responses: FrequencyResponses,
    study: &IdentifyStudy,
) -> Result<FrequencyResponses, Error> {
    let known: Vec<String> = responses
        .functions
        .iter()
        .map(|f| f.output.name.clone())
        .collect();
    for name in &study.outputs {
        if !known.contains(name) {
            return Err(no_channel(name, &known));
        }
    }
    let is_input = |f: &FrequencyResponse| {
        study.inputs.is_empty()
            || f.input
                .as_ref()
                .is_some_and(|i| study.inputs.contains(&i.name))
    };
    responses.functions.retain(|f| {
        is_input(f) && (study.outputs.is_empty() || study.outputs.contains(&f.output.name))
    });
    if responses.functions.is_empty() {
        let message = "no response of the file is driven by the inputs asked for";
        return Err(Error::new(Code::NoChannel, message)
            .hint("leave --input out: the file says what drives"));
    }
    Ok(responses)
}

fn estimate(recording: &Recording, study: &IdentifyStudy) -> Result<Acquired, Error> {
    let place = |name: &String| {
        recording
            .channels
            .iter()
            .position(|c| c.name == *name)
            .ok_or_else(|| {
                let known: Vec<String> =
                    recording.channels.iter().map(|c| c.name.clone()).collect();
                no_channel(name, &known)
            })
    };
    let inputs = study
        .inputs
        .iter()
        .map(place)
        .collect::<Result<Vec<usize>, Error>>()?;
    let outputs = study
        .outputs
        .iter()
        .map(place)
        .collect::<Result<Vec<usize>, Error>>()?;
    acquire::acquire(recording, &inputs, &outputs, &study.estimate)
}

/// The lines fitted: as asked, else where the input has power, else all that are not at an edge.
fn band(
    responses: &FrequencyResponses,
    acquired: Option<&Acquired>,
    study: &IdentifyStudy,
) -> Result<(f64, f64), Error> {
    let lines = &responses.frequency_hz;
    let (Some(&first), Some(&last)) = (lines.first(), lines.last()) else {
        return Err(Error::new(Code::EmptyLog, "there are no lines to fit"));
    };
    if let Some((low, high)) = study.band_hz {
        let inside = lines.iter().filter(|f| (low..=high).contains(f)).count();
        if inside == 0 {
            let message = format!(
                "no line lies in the band {low} … {high} Hz; there are lines from {first} to {last} Hz"
            );
            return Err(Error::new(Code::OutOfRange, message));
        }
        return Ok((low, high));
    }
    if let Some(driven) = acquired.and_then(|a| a.driven_hz) {
        return Ok(driven);
    }
    // The window's main lobe spreads the mean over the first lines; filters bend the last ones.
    const EDGE: f64 = 0.95;
    match acquired {
        Some(_) => Ok((lines.get(3).copied().unwrap_or(first), EDGE * last)),
        None => Ok((first, last)),
    }
}

fn fitted(
    responses: &FrequencyResponses,
    acquired: Option<&Acquired>,
    band: (f64, f64),
    study: &IdentifyStudy,
) -> Result<RationalFit, Error> {
    let values: Vec<Vec<Complex>> = responses
        .functions
        .iter()
        .map(|f| f.value.clone())
        .collect();
    let variance: Option<Vec<Vec<f64>>> = responses
        .functions
        .iter()
        .map(|f| f.variance.clone())
        .collect();
    let options = RationalOptions {
        band_hz: Some(band),
        order: study.order,
        allow_unstable: study.allow_unstable,
        delay: study.delay,
        ..RationalOptions::default()
    };
    let fit = |derivative: u8| {
        let measured = Measured {
            frequency_hz: &responses.frequency_hz,
            responses: &values,
            variance: variance.as_deref(),
            variance_trusted: false,
            line_independence: acquired.map_or(1.0, |a| a.line_independence),
            derivative,
        };
        rational::fit(&measured, &options)
    };
    let kinds: Vec<ResponseKind> = responses
        .functions
        .iter()
        .map(|f| ResponseKind::of(f.input.as_ref().map_or("", |i| &i.unit), &f.output.unit))
        .collect();
    match (study.derivative, kinds.first()) {
        (Some(times), _) => fit(times),
        (None, Some(ResponseKind::Compliance(times))) if kinds.iter().all(|k| k == &kinds[0]) => {
            fit(*times)
        }
        (None, Some(ResponseKind::Unknown)) => {
            // Receptance and accelerance differ in what modes outside the band leave in it: the better of the two.
            let (plain, twice) = (fit(0)?, fit(2)?);
            Ok(if cost(&twice) < cost(&plain) {
                twice
            } else {
                plain
            })
        }
        _ => fit(0),
    }
}

/// Misfit and size of a fit in one number (Schwarz 1978).
fn cost(fit: &RationalFit) -> f64 {
    let unknowns = fit.poles.len() * 2 * (1 + fit.residues.len());
    fit.chi2 + unknowns as f64 * (fit.dof.max(2.0)).ln()
}

/// A mode without the exponential window that lay on its record: the pole moves right by its rate.
fn without_window(mode: &IdentifiedMode, decay: f64) -> IdentifiedMode {
    IdentifiedMode {
        pole: mode.pole + decay,
        ..mode.clone()
    }
}

/// Partial fractions of each response: `s^q/(s − p) = p^q/(s − p)` and a polynomial, the window taken off by `H(s) = H_w(s − σ)`.
fn transfer_functions(
    responses: &FrequencyResponses,
    fit: &RationalFit,
    decay: f64,
) -> Result<Vec<TransferFunction>, Error> {
    let mut all = Vec::new();
    for (i, f) in responses.functions.iter().enumerate() {
        let mut direct = Direct::default();
        let [lower, upper] = fit.residual_terms[i];
        match fit.derivative {
            0 => (direct.inverse_square, direct.constant) = (lower, upper),
            1 => (direct.inverse, direct.slope) = (lower, upper),
            _ => (direct.constant, direct.square) = (lower, upper),
        }
        let mut residues = Vec::new();
        for (&p, &r) in fit.poles.iter().zip(&fit.residues[i]) {
            let both = |z: Complex| if p.im == 0.0 { z.re } else { 2.0 * z.re };
            match fit.derivative {
                0 => residues.push(r),
                1 => {
                    residues.push(p * r);
                    direct.constant += both(r);
                }
                _ => {
                    residues.push(p * p * r);
                    direct.slope += both(r);
                    direct.constant += both(p * r);
                }
            }
        }
        let poles = fit.poles.iter().map(|p| p + decay).collect();
        let delay = fit
            .delay_s
            .get(i.min(fit.delay_s.len().saturating_sub(1)))
            .copied()
            .unwrap_or(0.0);
        let mut function = TransferFunction::new(poles, residues, direct)?
            .between(f.input.clone(), f.output.clone());
        if delay > 0.0 {
            function = function.delayed(delay)?;
        }
        function.fit_error = fit.fit_error.get(i).copied();
        all.push(function);
    }
    Ok(all)
}
