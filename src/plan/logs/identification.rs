//! From a log to modes and transfer functions: each stage once, in this order, and a trace kept.

use std::time::Instant;

use super::acquire::{self, Acquired, EstimateStudy, Look};
use super::doubts;
use super::found::{Evidence, FoundMode, Identification};
use super::functions::{transfer_functions, without_window};
use super::method::{Method, Needs};
use super::modal::{self, Modal};
use super::points::{PointRecord, Points};
use super::rational::{fitted, partials, rule};
use super::sound::{self, Sound, Use};
use super::study::IdentifyStudy;
use super::{
    course, free_decay, linearity, mains, operational, reciprocity, record, scaling, series, weak,
};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::words::counted;
use crate::identify::rational::Delay;
use crate::recording::names;
use crate::recording::responses::{FrequencyResponse, FrequencyResponses, Terminal};
use crate::recording::settle::no_channel;
use crate::recording::signals::Recording;

/// What is identified from.
pub enum Source<'a> {
    /// Signals.
    Signals(&'a Recording),
    /// Signals of other points in every record.
    Points(&'a [PointRecord]),
    /// Responses that somebody else estimated.
    Responses(FrequencyResponses),
}

/// The method asked for; else by what drives: a rational fit with an input, subspace identification without.
pub fn method(study: &IdentifyStudy, has_responses: bool) -> Method {
    match study.method {
        Some(method) => method,
        None if has_responses || !study.inputs.is_empty() => Method::Rational,
        None => Method::SsiCov,
    }
}

/// Identifies.
///
/// # Errors
/// Those of the stages: channels that are not there or hold nothing, nothing to fit, a band without lines; `usage` where the method does
/// not go with what is named.
pub fn identify(source: Source, study: &IdentifyStudy) -> Result<Identification, Error> {
    match source {
        Source::Responses(responses) => {
            let method = method(study, true);
            if method.needs() != Needs::Responses {
                let message = format!(
                    "{} starts from signals; the file holds frequency responses",
                    method.word()
                );
                return Err(Error::new(Code::Usage, message)
                    .hint("take a method from responses, such as --method plscf"));
            }
            check_flags(method, study)?;
            from_responses(method, chosen(responses, study)?, None, Vec::new(), study)
        }
        Source::Signals(recording) => {
            let mut found = of_recording(recording, study)?;
            found.add_rate_std(recording.rate_std);
            Ok(found)
        }
        Source::Points(records) => {
            let method = method(study, false);
            check_flags(method, study)?;
            if method.needs() != Needs::Responses {
                let message = format!(
                    "{} takes one record; the files hold different points",
                    method.word()
                );
                return Err(Error::new(Code::Usage, message)
                    .hint("take a method from responses, such as --method rational, or one file"));
            }
            let rate_std = records
                .iter()
                .map(|r| r.recording.rate_std)
                .fold(0.0, f64::max);
            let points = Points::new(records)?;
            let mut found = looked(method, points.has_gaps(), study, |look| {
                points.acquire(&study.estimate, look)
            })?;
            found.add_rate_std(rate_std);
            Ok(found)
        }
    }
}

/// Identifies from the signals of one recording.
fn of_recording(recording: &Recording, study: &IdentifyStudy) -> Result<Identification, Error> {
    let inputs = record::places(recording, &study.inputs)?;
    let outputs = record::places(recording, &study.outputs)?;
    let method = match method(study, false) {
        Method::SsiCov
            if study.method.is_none()
                && study.speed_hz.is_none()
                && !outputs.is_empty()
                && free_decay::are_decays(recording, &outputs)? =>
        {
            Method::FreeDecay
        }
        method => method,
    };
    check_flags(method, study)?;
    check_roles(method, &inputs, &outputs, recording)?;
    record::check(recording, &inputs, &outputs)?;
    let sound = sound::without_faults(recording, &inputs, &outputs)?;
    if method.needs() != Needs::Responses {
        if study.estimate != EstimateStudy::default() {
            let message = format!(
                "{} estimates no responses: --estimator, --window, --resolution, --overlap, --impact, --stepped and --dwells do nothing",
                method.word()
            );
            return Err(Error::new(Code::Usage, message)
                .hint("leave them out, or name what drives: --input"));
        }
        if method == Method::FreeDecay {
            return of_decays(&sound, &outputs, study);
        }
        let recording = sound.unclipped(Use::Longest);
        let mut found = from_signals(method, &recording.0, &inputs, &outputs, study)?;
        found.warnings.splice(0..0, recording.1);
        return Ok(found);
    }
    let has_gaps = sound.recording.stretches.len() > 1;
    looked(method, has_gaps, study, |look| {
        acquire::acquire(&sound, &inputs, &outputs, &study.estimate, look)
    })
}

impl Identification {
    /// Adds the standard deviation of the sample rate, relative, to those of the poles: they stretch with it.
    fn add_rate_std(&mut self, rate_std: f64) {
        let modes = self.modes.iter_mut().chain(&mut self.weak);
        modes.for_each(|m| m.mode.stretch(rate_std));
    }
}

/// Lines that the half-power band of the narrowest mode should hold, at least; where a second look is taken, so many are asked for.
const LINES_OF_MODE: f64 = 4.0;
const LINES_ASKED: f64 = 6.0;

/// Responses and their modes: a first look, and a second with lines nearer to each other where a mode found is narrow.
fn looked(
    method: Method,
    has_gaps: bool,
    study: &IdentifyStudy,
    acquire: impl Fn(Look) -> Result<Acquired, Error>,
) -> Result<Identification, Error> {
    let mut look = Look {
        band_hz: study.band_hz,
        apart_hz: None,
    };
    let mut trace = Vec::new();
    loop {
        let start = Instant::now();
        let mut acquired = acquire(look)?;
        trace.push(("frequency responses", start.elapsed().as_secs_f64()));
        let nearest = acquired.nearest_hz;
        let lines = &acquired.responses.frequency_hz;
        let apart = lines.get(1).zip(lines.first()).map_or(0.0, |(b, a)| b - a);
        let responses = std::mem::take(&mut acquired.responses);
        let mut found = from_responses(method, responses, Some(acquired), trace.clone(), study)?;
        if has_gaps {
            for no_mode in found.warnings.iter_mut().filter(|w| w.code == "no-mode") {
                let hint = "gaps cut the record into stretches: bridge short ones, --fill-gaps";
                no_mode.hint = Some(match no_mode.hint.take() {
                    Some(other) => format!("{hint}; or {other}"),
                    None => hint.to_string(),
                });
            }
        }
        let width = |m: &FoundMode| 2.0 * m.mode.pole.re.abs() / std::f64::consts::TAU;
        let all = found.modes.iter().chain(&found.weak);
        let narrowest = all.map(width).fold(f64::INFINITY, f64::min);
        // Lines somewhat nearer are not worth another fit.
        const NEARER: f64 = 0.8;
        let asked = (narrowest / LINES_ASKED).max(nearest.unwrap_or(apart));
        if look.apart_hz.is_some()
            || nearest.is_none()
            || narrowest >= LINES_OF_MODE * apart
            || asked > NEARER * apart
        {
            return Ok(found);
        }
        trace = found.trace;
        look.apart_hz = Some(asked);
    }
}

/// Refuses what the method would do nothing with.
fn check_flags(method: Method, study: &IdentifyStudy) -> Result<(), Error> {
    let idle = [
        (
            study.delay != Delay::None && method != Method::Rational,
            "--delay",
            "--method rational estimates delays",
        ),
        (
            study.allow_unstable && method != Method::Rational,
            "--allow-unstable",
            "--method rational may be let find unstable poles",
        ),
        (
            study.derivative.is_some() && method.needs() != Needs::Responses,
            "--kind",
            "it says what responses to an input are: name what drives, --input",
        ),
        (
            !study.driving_points.is_empty() && method.needs() != Needs::Responses,
            "--driving-point",
            "modal masses need a measured force: name it, --input",
        ),
        (
            study.memory_s.is_some() && method != Method::Rls,
            "--memory",
            "--method rls forgets",
        ),
    ];
    match idle.into_iter().find(|flag| flag.0) {
        Some((_, flag, hint)) => {
            let message = format!("{} does nothing with {flag}", method.word());
            Err(Error::new(Code::Usage, message).hint(hint))
        }
        None => Ok(()),
    }
}

/// Refuses inputs and outputs that the method cannot use.
fn check_roles(
    method: Method,
    inputs: &[usize],
    outputs: &[usize],
    recording: &Recording,
) -> Result<(), Error> {
    let word = method.word();
    if outputs.is_empty() {
        let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        let message = format!(
            "no channel is named as --output; the log has {}",
            names.join(", ")
        );
        return Err(Error::new(Code::Usage, message)
            .hint("name what answers: --output, and what drives, if it was measured: --input"));
    }
    let (message, hint) = match (method.needs(), inputs.len(), outputs.len()) {
        (Needs::Responses, 0, _) => (
            format!("{word} needs the channel that drives"),
            "name it: --input; or take a method from responses alone, such as --method ssi-cov",
        ),
        (Needs::Outputs | Needs::OneOutput, 1.., _) => (
            format!("{word} takes no input"),
            "leave --input out, or take a method that uses it, such as --method rational",
        ),
        (Needs::OneOutput, _, 2..) => (
            format!("{word} takes one output, of {} named", outputs.len()),
            "name one, or take --method ssi-cov for all of them",
        ),
        (Needs::OutputAndPerhapsInput, i, o) if i > 1 || o != 1 => (
            format!("{word} takes one output and at most one input, of {o} and {i} named"),
            "name one of each, or one output alone",
        ),
        (Needs::InputAndOutput, i, o) if i != 1 || o != 1 => (
            format!("{word} takes one input and one output, of {i} and {o} named"),
            "name one of each, or take --method rational for several",
        ),
        _ => return Ok(()),
    };
    Err(Error::new(Code::Usage, message).hint(hint))
}

fn from_signals(
    method: Method,
    recording: &Recording,
    inputs: &[usize],
    outputs: &[usize],
    study: &IdentifyStudy,
) -> Result<Identification, Error> {
    let start = Instant::now();
    let places: Vec<usize> = inputs.iter().chain(outputs).copied().collect();
    // Subspace methods have their own ladder of rates, so that a band only chooses among the modes of the whole record.
    let decimated = match method {
        Method::SsiCov | Method::SsiData => None,
        _ => study.band_hz,
    };
    let record = record::of(recording, &places, decimated, method.word())?;
    let mut trace = vec![("samples", start.elapsed().as_secs_f64())];
    let band_hz = study.band_hz.unwrap_or((0.0, record.rate_hz / 2.0));
    let start = Instant::now();
    let found = match method.needs() {
        Needs::OneOutput | Needs::InputAndOutput => {
            series::identify(method, &record, band_hz, study)?
        }
        Needs::OutputAndPerhapsInput => course::identify(&record, band_hz, study)?,
        _ => operational::identify(method, &record, band_hz, study)?,
    };
    trace.push((method.word(), start.elapsed().as_secs_f64()));
    let terminal = |&at: &usize| Terminal {
        name: recording.channels[at].name.clone(),
        unit: recording.channels[at].unit.clone(),
    };
    Ok(Identification {
        trace,
        method,
        how: record.how,
        rule: found.rule,
        hits: Vec::new(),
        outputs: outputs.iter().map(terminal).collect(),
        inputs: Vec::new(),
        reciprocity: Vec::new(),
        driving_point: None,
        responses: None,
        band_hz,
        evidence: found.evidence,
        modes: found.modes,
        weak: Vec::new(),
        harmonics: found.harmonics,
        functions: Vec::new(),
        fit_error: Vec::new(),
        warnings: found.warnings,
    })
}

/// Modes of the free decays of a record.
fn of_decays(
    sound: &Sound,
    outputs: &[usize],
    study: &IdentifyStudy,
) -> Result<Identification, Error> {
    let start = Instant::now();
    let recording = &sound.recording;
    let decays = free_decay::identify(recording, outputs, study)?;
    let mut warnings = [sound.stuck.clone(), sound.clipped_warnings()].concat();
    warnings.extend(decays.found.warnings);
    let terminal = |&at: &usize| Terminal {
        name: recording.channels[at].name.clone(),
        unit: recording.channels[at].unit.clone(),
    };
    let decay = |k: usize| Terminal {
        name: format!("decay {k}"),
        unit: String::new(),
    };
    Ok(Identification {
        trace: vec![("free decays", start.elapsed().as_secs_f64())],
        method: Method::FreeDecay,
        how: decays.how,
        rule: decays.found.rule,
        hits: Vec::new(),
        outputs: outputs.iter().map(terminal).collect(),
        inputs: match decays.count {
            1 => Vec::new(),
            n => (1..=n).map(decay).collect(),
        },
        reciprocity: Vec::new(),
        driving_point: None,
        responses: None,
        band_hz: decays.band_hz,
        evidence: decays.found.evidence,
        modes: decays.found.modes,
        weak: decays.weak,
        harmonics: Vec::new(),
        functions: Vec::new(),
        fit_error: decays.fit_error,
        warnings,
    })
}

fn from_responses(
    method: Method,
    responses: FrequencyResponses,
    acquired: Option<Acquired>,
    mut trace: Vec<(&'static str, f64)>,
    study: &IdentifyStudy,
) -> Result<Identification, Error> {
    let band_hz = band(&responses, study)?;
    let table = responses.table();
    let mut warnings = acquired.as_ref().map_or(Vec::new(), |a| a.warnings.clone());
    warnings.extend(doubts::of_kinds(&responses));
    warnings.extend(doubts::of_stated_kind(&responses, study.derivative));
    let start = Instant::now();
    let by_hit = acquired.as_ref().map_or(&[][..], |a| &a.by_hit);
    let fit = match method {
        Method::Rational | Method::VectorFitting | Method::Aaa => {
            Some(fitted(method, &responses, by_hit, band_hz, study)?)
        }
        _ => None,
    };
    let found = match fit {
        Some(fit) => {
            let decay = responses.window_decay;
            Modal {
                modes: (fit.modes.iter().enumerate())
                    .map(|(k, m)| {
                        let mut mode = FoundMode::of_table(without_window(m, decay), &table)?;
                        mode.departure = fit.departures.get(k).copied();
                        Ok(mode)
                    })
                    .collect::<Result<_, Error>>()?,
                rule: rule(method, fit.departs),
                functions: transfer_functions(&responses, &partials(&fit))?,
                fit_error: fit.fit_error.clone(),
                warnings: fit.warnings.clone(),
                evidence: Evidence::Rational(fit),
            }
        }
        None => modal::identify(method, &responses, band_hz, study)?,
    };
    let mut found = found;
    if !doubts::is_answered(&responses, band_hz) {
        found.modes.clear();
        warnings.push(Warning {
            code: "no-mode",
            message:
                "the outputs do not answer the input: no response stands out of its own variance"
                    .into(),
            hint: Some(
                "look whether input and output are the right channels, of one time base".into(),
            ),
        });
    }
    trace.push((method.word(), start.elapsed().as_secs_f64()));
    warnings.extend(found.warnings);
    // Doubts go by the bandwidth as measured, an exponential window on it.
    let on_record = |m: &FoundMode| without_window(&m.mode, -responses.window_decay);
    let as_measured: Vec<_> = found.modes.iter().map(on_record).collect();
    warnings.extend(doubts::of_modes(
        &responses,
        acquired.as_ref(),
        &as_measured,
    ));
    warnings.extend(mains::of_modes(&responses.frequency_hz, &as_measured));
    if let Some(acquired) = &acquired {
        let input = responses.functions.first().and_then(|f| f.input.as_ref());
        let unit = input.map_or("", |i| &i.unit);
        let lines = &responses.frequency_hz;
        warnings.extend(linearity::of_test(acquired, lines, &as_measured, unit));
    }
    let lines = &responses.frequency_hz;
    let apart = lines.get(1).zip(lines.first()).map_or(0.0, |(b, a)| b - a);
    let (mut modes, mut weak) = weak::apart(found.modes, apart);
    if study.all {
        modes.append(&mut weak);
        modes.sort_by(|a, b| a.frequency_hz().total_cmp(&b.frequency_hz()));
    }
    let (how, hits) = match acquired {
        Some(acquired) => (acquired.how, acquired.hits),
        None => {
            let (functions, lines) = (responses.functions.len(), responses.frequency_hz.len());
            let (functions, lines) = (counted(functions, "response"), counted(lines, "line"));
            let how = format!("{functions} over {lines}, as read");
            (how, Vec::new())
        }
    };
    let mut found = Identification {
        trace,
        method,
        how,
        rule: found.rule,
        hits,
        outputs: table
            .iter()
            .map(|row| responses.functions[row[0]].output.clone())
            .collect(),
        inputs: match &table[0][..] {
            [_] => Vec::new(),
            row => row
                .iter()
                .filter_map(|&f| responses.functions[f].input.clone())
                .collect(),
        },
        band_hz,
        evidence: found.evidence,
        modes,
        weak,
        harmonics: Vec::new(),
        functions: found.functions,
        fit_error: found.fit_error,
        reciprocity: Vec::new(),
        driving_point: None,
        responses: Some(responses),
        warnings,
    };
    let driven = study.driving_points.first().map(String::as_str);
    scaling::scale(&mut found, driven)?;
    if let Some(responses) = &found.responses {
        let points = scaling::driving_points(responses, &study.driving_points)?;
        found.reciprocity = reciprocity::pairs(responses, &points, band_hz);
        found
            .warnings
            .extend(reciprocity::warning(&found.reciprocity));
        let poor = doubts::of_fit(responses, band_hz, |f| found.fitted(f));
        found.warnings.extend(poor);
    }
    Ok(found)
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
    let mut outputs = Vec::new();
    for word in &study.outputs {
        let at = names::find(word, &known).ok_or_else(|| no_channel(word, &known))?;
        outputs.push(known[at].clone());
    }
    let drives = |f: &FrequencyResponse| {
        let driven = |i: &Terminal| {
            let name = std::slice::from_ref(&i.name);
            study
                .inputs
                .iter()
                .any(|word| names::find(word, name).is_some())
        };
        study.inputs.is_empty() || f.input.as_ref().is_some_and(driven)
    };
    responses
        .functions
        .retain(|f| drives(f) && (outputs.is_empty() || outputs.contains(&f.output.name)));
    if responses.functions.is_empty() {
        let message = "no response of the file is driven by the inputs asked for";
        return Err(Error::new(Code::NoChannel, message)
            .hint("leave --input out: the file says what drives"));
    }
    Ok(responses)
}

/// The lines fitted: as asked, else those known to be usable, else all.
fn band(responses: &FrequencyResponses, study: &IdentifyStudy) -> Result<(f64, f64), Error> {
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
    Ok(responses.usable_hz.unwrap_or((first, last)))
}
