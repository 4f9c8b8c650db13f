//! Identification run: recording or FRFs to modes and transfer functions, with a trace of stages.

use std::time::Instant;

use super::diagnostics;
use super::fault_free::{self, CheckedRecording, SegmentUse};
use super::frf_estimation::{self, EstimatedResponses, FrfStudy, ResolutionRequest};
use super::frf_modes::{self, ModalIdentification};
use super::identification_result::{Evidence, IdentificationResult, IdentifiedMode};
use super::identify_study::IdentifyStudy;
use super::method::{IdentificationMethod, RequiredData};
use super::points::{PointRecord, Points};
use super::rational::{fit_rational, modes_over_table, partial_fractions, rule};
use super::transfer_functions::{transfer_functions, without_window};
use super::{
    free_decay, level_linearity, linearity, mains, modal_mass, mode_tracking, operational_modes,
    pole_consistency, segment_samples, time_series, weak,
};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::rational::DelayModel;
use crate::identify::reciprocity;
use crate::recording::channel_names;
use crate::recording::frequency_responses::{
    ChannelLabel, FrequencyResponse, FrequencyResponses, line_spacing_hz,
};
use crate::recording::preprocess::unknown_channel;
use crate::recording::signals::Recording;

/// Input of an identification.
pub enum IdentificationInput<'a> {
    /// One recording.
    Signals(&'a Recording),
    /// Records of one test, each of other points.
    Points(&'a [PointRecord]),
    /// Frequency responses of a file.
    Responses(FrequencyResponses),
}

/// Requested method; by default a rational fit with a measured excitation, subspace identification without.
pub fn method(study: &IdentifyStudy, has_responses: bool) -> IdentificationMethod {
    match study.method {
        Some(method) => method,
        None if has_responses || !study.inputs.is_empty() => IdentificationMethod::Rational,
        None => IdentificationMethod::SsiCov,
    }
}

/// Identifies modes and transfer functions by any method.
///
/// # Errors
/// Errors of the stages: missing or constant channels, no data to fit, a band without lines; `usage` if the method contradicts the named
/// channels or flags.
pub fn identify(
    source: IdentificationInput,
    study: &IdentifyStudy,
) -> Result<IdentificationResult, Error> {
    match source {
        IdentificationInput::Responses(responses) => {
            let method = method(study, true);
            if method.required_data() != RequiredData::Responses {
                let message = format!(
                    "{} needs signals; the file has frequency responses",
                    method.name()
                );
                return Err(Error::new(Code::Usage, message)
                    .with_hint("use a method for responses, such as --method plscf"));
            }
            check_flags(method, study)?;
            identify_responses(
                method,
                select_responses(responses, study)?,
                None,
                Vec::new(),
                study,
            )
        }
        IdentificationInput::Signals(recording) => {
            let mut result = identify_recording(recording, study)?;
            result.add_rate_std(recording.rate_std);
            Ok(result)
        }
        IdentificationInput::Points(records) => {
            let method = method(study, false);
            check_flags(method, study)?;
            if method.required_data() != RequiredData::Responses {
                let message = format!(
                    "{} takes one record; the files have different points",
                    method.name()
                );
                return Err(Error::new(Code::Usage, message).with_hint(
                    "use a method for responses, such as --method rational, or one file",
                ));
            }
            let rate_std = records
                .iter()
                .map(|r| r.recording.rate_std)
                .fold(0.0, f64::max);
            let points = Points::new(records)?;
            let mut result = estimate_and_fit(method, points.has_gaps(), study, |request| {
                points.acquire(&study.estimate, request)
            })?;
            if let (Some(fit), Some(responses)) = (result.fit(), &result.responses) {
                let differing = pole_consistency::check_files(&points.files(), responses, fit);
                result.diagnostics.extend(differing);
            }
            result.add_rate_std(rate_std);
            Ok(result)
        }
    }
}

/// Identifies modes from the signals of one recording.
fn identify_recording(
    recording: &Recording,
    study: &IdentifyStudy,
) -> Result<IdentificationResult, Error> {
    let inputs = segment_samples::channel_indices(recording, &study.inputs)?;
    let outputs = segment_samples::channel_indices(recording, &study.outputs)?;
    let mut method = method(study, false);
    let mut not_decaying = None;
    let is_default = method == IdentificationMethod::SsiCov
        && study.method.is_none()
        && study.speed_hz.is_none();
    if (is_default || method == IdentificationMethod::FreeDecay) && !outputs.is_empty() {
        let decays = free_decay::decaying_segments(recording, &outputs)?;
        not_decaying = free_decay::files_without_decay(recording, &decays);
        if is_default {
            if let Some(message) = not_decaying {
                return Err(Error::new(Code::Conflict, message).with_hint(
                    "omit it; or name the method: --method free-decay takes all files as decays, --method ssi-cov the longest as driven by noise",
                ));
            }
            if !decays.is_empty() && decays.iter().all(|d| *d) {
                method = IdentificationMethod::FreeDecay;
            }
        }
    }
    check_flags(method, study)?;
    check_roles(method, &inputs, &outputs, recording)?;
    segment_samples::check_channels(recording, &inputs, &outputs)?;
    let checked = fault_free::without_faults(recording, &inputs, &outputs)?;
    if method.required_data() != RequiredData::Responses {
        if study.estimate != FrfStudy::default() {
            let message = format!(
                "{} estimates no responses: --estimator, --window, --resolution, --overlap, --impact, --stepped and --dwells do nothing",
                method.name()
            );
            return Err(Error::new(Code::Usage, message)
                .with_hint("omit them, or name the excitation channel: --input"));
        }
        if method == IdentificationMethod::FreeDecay {
            let mut result = identify_decays(&checked, &outputs, study)?;
            result.diagnostics.extend(not_decaying.map(|message| {
                Diagnostic {
                    code: "no-decay",
                    message,
                    hint: Some(
                        "omit the record: its motion is forced, but the fit treats it as a decay"
                            .to_string(),
                    ),
                }
            }));
            return Ok(result);
        }
        let recording = checked.unclipped(SegmentUse::Longest);
        let mut result = identify_signals(method, &recording.0, &inputs, &outputs, study)?;
        result.diagnostics.splice(0..0, recording.1);
        return Ok(result);
    }
    let has_gaps = checked.recording.segments.len() > recording.files.len().max(1);
    let mut result = estimate_and_fit(method, has_gaps, study, |request| {
        frf_estimation::estimate_responses(&checked, &inputs, &outputs, &study.estimate, request)
    })?;
    if recording.files.len() > 1 {
        for diagnostic in result
            .diagnostics
            .iter_mut()
            .filter(|w| w.code == "low-coherence")
        {
            diagnostic.hint = Some("use --roving to join files of several points; otherwise excite more strongly there, take more averages, or check for a second source".to_string());
        }
    }
    if let ([input], true) = (&inputs[..], result.hits.is_empty()) {
        let modes: Vec<ModalParameters> = result.modes.iter().map(|m| m.mode.clone()).collect();
        let (record, _) = checked.unclipped(SegmentUse::Blocks);
        let level_shifts = level_linearity::level_shift_warning(&record, *input, &outputs, &modes)?;
        result.diagnostics.extend(level_shifts);
    }
    Ok(result)
}

impl IdentificationResult {
    /// Adds the relative standard deviation of the sample rate to the uncertainty of the poles.
    fn add_rate_std(&mut self, rate_std: f64) {
        let modes = self.modes.iter_mut().chain(&mut self.weak);
        modes.for_each(|m| m.mode.add_scale_uncertainty(rate_std));
    }
}

/// Minimum number of lines in the half-power band of the narrowest mode, and the number a second estimate requests.
const MIN_LINES_PER_MODE: f64 = 4.0;
const LINES_PER_MODE_REQUESTED: f64 = 6.0;

/// Estimates responses and fits their modes, again at a finer resolution if an identified mode is too narrow.
fn estimate_and_fit(
    method: IdentificationMethod,
    has_gaps: bool,
    study: &IdentifyStudy,
    acquire: impl Fn(ResolutionRequest) -> Result<EstimatedResponses, Error>,
) -> Result<IdentificationResult, Error> {
    let mut request = ResolutionRequest {
        band_hz: study.band_hz,
        frequency_resolution_hz: None,
    };
    let mut trace = Vec::new();
    loop {
        let start = Instant::now();
        let mut estimated_responses = acquire(request)?;
        trace.push(("frequency responses", start.elapsed().as_secs_f64()));
        let finest = estimated_responses.finest_resolution_hz;
        let spacing = line_spacing_hz(&estimated_responses.responses.frequency_hz);
        let responses = std::mem::take(&mut estimated_responses.responses);
        let mut trial = identify_responses(
            method,
            responses,
            Some(estimated_responses),
            trace.clone(),
            study,
        )?;
        if has_gaps {
            for no_mode in trial.diagnostics.iter_mut().filter(|w| w.code == "no-mode") {
                let hint = "gaps split the record: interpolate short ones, --fill-gaps";
                no_mode.hint = Some(match no_mode.hint.take() {
                    Some(previous_hint) => format!("{hint}; or {previous_hint}"),
                    None => hint.to_string(),
                });
            }
        }
        let width = |m: &IdentifiedMode| 2.0 * m.mode.pole.re.abs() / std::f64::consts::TAU;
        let modes = trial.modes.iter().chain(&trial.weak);
        let narrowest = modes.map(width).fold(f64::INFINITY, f64::min);
        // Minimum refinement of the line spacing for another fit.
        const RESOLUTION_GAIN: f64 = 0.8;
        let requested = (narrowest / LINES_PER_MODE_REQUESTED).max(finest.unwrap_or(spacing));
        if request.frequency_resolution_hz.is_some()
            || finest.is_none()
            || narrowest >= MIN_LINES_PER_MODE * spacing
            || requested > RESOLUTION_GAIN * spacing
        {
            return Ok(trial);
        }
        trace = trial.trace;
        request.frequency_resolution_hz = Some(requested);
    }
}

/// Rejects flags without effect on the method.
fn check_flags(method: IdentificationMethod, study: &IdentifyStudy) -> Result<(), Error> {
    let unused = [
        (
            study.delay != DelayModel::None && method != IdentificationMethod::Rational,
            "--delay",
            "use --method rational to estimate delays",
        ),
        (
            study.allow_unstable && method != IdentificationMethod::Rational,
            "--allow-unstable",
            "use --method rational to allow unstable poles",
        ),
        (
            study.derivative.is_some() && method.required_data() != RequiredData::Responses,
            "--kind",
            "it applies to responses to an input: name the excitation channel, --input",
        ),
        (
            !study.driving_points.is_empty() && method.required_data() != RequiredData::Responses,
            "--driving-point",
            "modal masses need a measured force: name it, --input",
        ),
        (
            study.memory_s.is_some() && method != IdentificationMethod::Rls,
            "--memory",
            "it applies to --method rls",
        ),
    ];
    match unused.into_iter().find(|flag| flag.0) {
        Some((_, flag, hint)) => {
            let message = format!("{} does nothing with {flag}", method.name());
            Err(Error::new(Code::Usage, message).with_hint(hint))
        }
        None => Ok(()),
    }
}

/// Rejects inputs and outputs that the method cannot use.
fn check_roles(
    method: IdentificationMethod,
    inputs: &[usize],
    outputs: &[usize],
    recording: &Recording,
) -> Result<(), Error> {
    let name = method.name();
    if outputs.is_empty() {
        let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        let message = format!(
            "no channel is named as --output; the log has {}",
            names.join(", ")
        );
        return Err(Error::new(Code::Usage, message).with_hint(
            "name the response channels, --output, and the excitation channel if it was measured, --input",
        ));
    }
    let (message, hint) = match (method.required_data(), inputs.len(), outputs.len()) {
        (RequiredData::Responses, 0, _) => (
            format!("{name} needs the excitation channel"),
            "name it: --input; or use an output-only method, such as --method ssi-cov",
        ),
        (RequiredData::Outputs | RequiredData::OneOutput, 1.., _) => (
            format!("{name} takes no input"),
            "omit --input, or use a method that uses it, such as --method rational",
        ),
        (RequiredData::OneOutput, _, 2..) => (
            format!("{name} takes one output, of {} named", outputs.len()),
            "name one, or use --method ssi-cov for all of them",
        ),
        (RequiredData::OutputWithOptionalInput, i, o) if i > 1 || o != 1 => (
            format!("{name} takes one output and at most one input, of {o} and {i} named"),
            "name one of each, or one output alone",
        ),
        (RequiredData::InputAndOutput, i, o) if i != 1 || o != 1 => (
            format!("{name} takes one input and one output, of {i} and {o} named"),
            "name one of each, or use --method rational for several",
        ),
        _ => return Ok(()),
    };
    Err(Error::new(Code::Usage, message).with_hint(hint))
}

fn identify_signals(
    method: IdentificationMethod,
    recording: &Recording,
    inputs: &[usize],
    outputs: &[usize],
    study: &IdentifyStudy,
) -> Result<IdentificationResult, Error> {
    let start = Instant::now();
    let channels: Vec<usize> = inputs.iter().chain(outputs).copied().collect();
    // Subspace methods decimate in several steps; the band only selects among the modes of the record.
    let band = match method {
        IdentificationMethod::SsiCov | IdentificationMethod::SsiData => None,
        _ => study.band_hz,
    };
    let record = segment_samples::load_segment(recording, &channels, band, method.name())?;
    let mut trace = vec![("samples", start.elapsed().as_secs_f64())];
    let band_hz = study.band_hz.unwrap_or((0.0, record.rate_hz / 2.0));
    let start = Instant::now();
    let signal_result = match method.required_data() {
        RequiredData::OneOutput | RequiredData::InputAndOutput => {
            time_series::identify_time_series(method, &record, band_hz, study)?
        }
        RequiredData::OutputWithOptionalInput => {
            mode_tracking::identify_tracking(&record, band_hz, study)?
        }
        _ => operational_modes::identify_operational(method, &record, band_hz, study)?,
    };
    trace.push((method.name(), start.elapsed().as_secs_f64()));
    let label = |&channel: &usize| ChannelLabel {
        name: recording.channels[channel].name.clone(),
        unit: recording.channels[channel].unit.clone(),
    };
    Ok(IdentificationResult {
        trace,
        method,
        method_text: record.method_text,
        selection_rule: signal_result.selection_rule,
        hits: Vec::new(),
        outputs: outputs.iter().map(label).collect(),
        inputs: Vec::new(),
        reciprocity: Vec::new(),
        driving_point: None,
        point_shapes: None,
        comparison: None,
        responses: None,
        band_hz,
        evidence: signal_result.evidence,
        modes: signal_result.modes,
        weak: signal_result.weak,
        harmonics: signal_result.harmonics,
        functions: Vec::new(),
        fit_error: Vec::new(),
        diagnostics: signal_result.diagnostics,
    })
}

/// Modes of the free decays of a record.
fn identify_decays(
    checked: &CheckedRecording,
    outputs: &[usize],
    study: &IdentifyStudy,
) -> Result<IdentificationResult, Error> {
    let start = Instant::now();
    let recording = &checked.recording;
    let decays = free_decay::identify(recording, outputs, study)?;
    let mut diagnostics = [checked.stuck.clone(), checked.clipped_warnings()].concat();
    diagnostics.extend(decays.identification.diagnostics);
    let label = |&channel: &usize| ChannelLabel {
        name: recording.channels[channel].name.clone(),
        unit: recording.channels[channel].unit.clone(),
    };
    let decay_label = |k: usize| ChannelLabel {
        name: format!("decay {k}"),
        unit: String::new(),
    };
    Ok(IdentificationResult {
        trace: vec![("free decays", start.elapsed().as_secs_f64())],
        method: IdentificationMethod::FreeDecay,
        method_text: decays.method_text,
        selection_rule: decays.identification.selection_rule,
        hits: Vec::new(),
        outputs: outputs.iter().map(label).collect(),
        inputs: match decays.count {
            1 => Vec::new(),
            n => (1..=n).map(decay_label).collect(),
        },
        reciprocity: Vec::new(),
        driving_point: None,
        point_shapes: None,
        comparison: None,
        responses: None,
        band_hz: decays.band_hz,
        evidence: decays.identification.evidence,
        modes: decays.identification.modes,
        weak: decays.identification.weak,
        harmonics: Vec::new(),
        functions: Vec::new(),
        fit_error: decays.fit_error,
        diagnostics,
    })
}

fn identify_responses(
    method: IdentificationMethod,
    responses: FrequencyResponses,
    estimated_responses: Option<EstimatedResponses>,
    mut trace: Vec<(&'static str, f64)>,
    study: &IdentifyStudy,
) -> Result<IdentificationResult, Error> {
    let band_hz = band(&responses, study)?;
    let table = responses.index_matrix();
    let mut diagnostics = estimated_responses
        .as_ref()
        .map_or(Vec::new(), |a| a.diagnostics.clone());
    diagnostics.extend(diagnostics::check_response_kinds(&responses));
    diagnostics.extend(diagnostics::check_stated_kind(&responses, study.derivative));
    let start = Instant::now();
    let fit = match method {
        IdentificationMethod::Rational
        | IdentificationMethod::VectorFitting
        | IdentificationMethod::Aaa => {
            let estimated = estimated_responses.as_ref();
            Some(fit_rational(method, &responses, estimated, band_hz, study)?)
        }
        _ => None,
    };
    let mut modal = match fit {
        Some(fit) => ModalIdentification {
            modes: modes_over_table(&fit, &table, responses.window_decay)?,
            selection_rule: rule(method, fit.departs),
            functions: transfer_functions(&responses, &partial_fractions(&fit))?,
            fit_error: fit.fit_error.clone(),
            diagnostics: fit.diagnostics.clone(),
            evidence: Evidence::Rational(fit),
        },
        None => frf_modes::identify_modal(method, &responses, band_hz, study)?,
    };
    if !diagnostics::has_significant_response(&responses, band_hz) {
        modal.modes.clear();
        diagnostics.push(Diagnostic {
            code: "no-mode",
            message:
                "the outputs do not respond to the input: no response rises above its own variance"
                    .into(),
            hint: Some(
                "check whether input and output are the right channels, of one time base".into(),
            ),
        });
    } else if modal.modes.is_empty() && !matches!(modal.evidence, Evidence::Rational(_)) {
        diagnostics.push(Diagnostic {
            code: "no-mode",
            message: "the responses rise above their variance, but no pole is stable over the orders: the band may contain more modes than the method resolves".into(),
            hint: Some("narrow the band: --band, or use another --method".into()),
        });
    }
    trace.push((method.name(), start.elapsed().as_secs_f64()));
    diagnostics.extend(modal.diagnostics);
    // Warnings use the measured bandwidth, including the exponential window.
    let with_window = |m: &IdentifiedMode| without_window(&m.mode, -responses.window_decay);
    let as_measured: Vec<_> = modal.modes.iter().map(with_window).collect();
    diagnostics.extend(diagnostics::check_modes(
        &responses,
        estimated_responses.as_ref(),
        &as_measured,
    ));
    diagnostics.extend(mains::mode_warnings(&responses.frequency_hz, &as_measured));
    for (mode, measured) in modal.modes.iter_mut().zip(&as_measured) {
        mode.on_mains = mains::as_line(measured, line_spacing_hz(&responses.frequency_hz));
    }
    if let Some(estimated_responses) = &estimated_responses {
        let input = responses.responses.first().and_then(|f| f.input.as_ref());
        let unit = input.map_or("", |i| &i.unit);
        let lines = &responses.frequency_hz;
        diagnostics.extend(linearity::check_test(
            estimated_responses,
            lines,
            &as_measured,
            unit,
        ));
    }
    let spacing_hz = line_spacing_hz(&responses.frequency_hz);
    let coherence = |m: &IdentifiedMode| diagnostics::coherence_at(&responses, m.frequency_hz());
    let is_unresolved = (estimated_responses.as_ref()).is_some_and(|a| a.has_unresolved_pulses);
    let is_weak = |m: &IdentifiedMode| {
        let pulse_reason = is_unresolved.then_some(weak::UNRESOLVED_PULSE);
        weak::reason(m, spacing_hz, coherence(m)).or(pulse_reason)
    };
    let (modes, weak) = weak::split_weak(modal.modes, is_weak, study.all);
    let (method_text, hits) = match estimated_responses {
        Some(estimated_responses) => (estimated_responses.method_text, estimated_responses.hits),
        None => {
            let (functions, lines) = (responses.responses.len(), responses.frequency_hz.len());
            let (functions, lines) = (pluralise(functions, "response"), pluralise(lines, "line"));
            let method_text = format!("{functions} over {lines}, as read");
            (method_text, Vec::new())
        }
    };
    let mut result = IdentificationResult {
        trace,
        method,
        method_text,
        selection_rule: modal.selection_rule,
        hits,
        outputs: table
            .iter()
            .map(|row| responses.responses[row[0]].output.clone())
            .collect(),
        inputs: match &table[0][..] {
            [_] => Vec::new(),
            row => row
                .iter()
                .filter_map(|&f| responses.responses[f].input.clone())
                .collect(),
        },
        band_hz,
        evidence: modal.evidence,
        modes,
        weak,
        harmonics: Vec::new(),
        functions: modal.functions,
        fit_error: modal.fit_error,
        reciprocity: Vec::new(),
        driving_point: None,
        point_shapes: None,
        comparison: None,
        responses: Some(responses),
        diagnostics,
    };
    let driving_point = study.driving_points.first().map(String::as_str);
    modal_mass::add_modal_masses(&mut result, driving_point)?;
    if let Some(responses) = &result.responses {
        let points = modal_mass::driving_points(responses, &study.driving_points)?;
        result.reciprocity = reciprocity::pairs(responses, &points, band_hz);
        result
            .diagnostics
            .extend(reciprocity::warning(&result.reciprocity));
        let misfit = diagnostics::check_fit(responses, band_hz, |f| result.synthesise(f));
        result.diagnostics.extend(misfit);
    }
    Ok(result)
}

/// Selects the requested responses of a file.
fn select_responses(
    mut responses: FrequencyResponses,
    study: &IdentifyStudy,
) -> Result<FrequencyResponses, Error> {
    let known: Vec<String> = responses
        .responses
        .iter()
        .map(|f| f.output.name.clone())
        .collect();
    let mut outputs = Vec::new();
    for pattern in &study.outputs {
        let index = channel_names::find_channel(pattern, &known)
            .ok_or_else(|| unknown_channel(pattern, &known))?;
        outputs.push(known[index].clone());
    }
    let has_input = |f: &FrequencyResponse| {
        let is_named = |i: &ChannelLabel| {
            let name = std::slice::from_ref(&i.name);
            study
                .inputs
                .iter()
                .any(|pattern| channel_names::find_channel(pattern, name).is_some())
        };
        study.inputs.is_empty() || f.input.as_ref().is_some_and(is_named)
    };
    responses
        .responses
        .retain(|f| has_input(f) && (outputs.is_empty() || outputs.contains(&f.output.name)));
    if responses.responses.is_empty() {
        let message = "no response of the file belongs to the requested inputs";
        return Err(Error::new(Code::NoChannel, message)
            .with_hint("omit --input: the file names the excitation"));
    }
    Ok(responses)
}

/// Frequency band of the fit, Hz: as requested, else the usable band, else all lines.
fn band(responses: &FrequencyResponses, study: &IdentifyStudy) -> Result<(f64, f64), Error> {
    let lines = &responses.frequency_hz;
    let (Some(&first), Some(&last)) = (lines.first(), lines.last()) else {
        return Err(Error::new(Code::EmptyLog, "there are no lines to fit"));
    };
    if let Some((low, high)) = study.band_hz {
        let n_lines = lines.iter().filter(|f| (low..=high).contains(f)).count();
        if n_lines == 0 {
            let message = format!(
                "no line lies in the band {low} … {high} Hz; lines extend from {first} to {last} Hz"
            );
            return Err(Error::new(Code::OutOfRange, message));
        }
        return Ok((low, high));
    }
    Ok(responses.usable_band_hz.unwrap_or((first, last)))
}
