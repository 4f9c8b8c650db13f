//! FRFs, coherences and spectra of a MATLAB file over its frequency vector.

use super::roles::{self, FrequencyData};
use super::variables::Variable;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::Complex;
use crate::recording::frequency_responses::{
    ChannelLabel, FrequencyResponse, FrequencyResponses, StoredSpectrum,
};
use crate::recording::raw::RawLog;

/// Moves the frequency vector and the data over it from `numbers` to the log; returns true if there are any.
pub(super) fn take_spectra(numbers: &mut Vec<Variable>, log: &mut RawLog) -> Result<bool, Error> {
    let vector = (0..numbers.len()).find_map(|at| Some((at, roles::frequencies_hz(&numbers[at])?)));
    let Some((at, lines)) = vector else {
        return Ok(false);
    };
    let spans_lines = |v: &Variable| v.length() > 1 && !v.series(lines.len()).is_empty();
    let has_time_vector = numbers
        .iter()
        .any(|v| roles::is_time(v) && v.re.len() == lines.len());
    let other_spectra = || {
        numbers
            .iter()
            .enumerate()
            .filter(|&(i, v)| i != at && spans_lines(v))
    };
    // With a time vector of the same length, real variables are signals, and the frequency vector is a signal too.
    let is_signal = has_time_vector && other_spectra().all(|(_, v)| v.im.is_none());
    if is_signal || other_spectra().next().is_none() {
        return Ok(false);
    }
    numbers.remove(at);
    let (spectra, remaining) = numbers.drain(..).partition::<Vec<_>, _>(spans_lines);
    *numbers = remaining;

    let mut responses = FrequencyResponses {
        frequency_hz: lines.clone(),
        ..FrequencyResponses::default()
    };
    for variable in &spectra {
        match roles::frequency_data(variable) {
            FrequencyData::Response => {
                responses
                    .responses
                    .extend(for_each_series(variable, lines.len(), |name, value| {
                        FrequencyResponse {
                            output: ChannelLabel {
                                name,
                                unit: String::new(),
                            },
                            values: value,
                            ..FrequencyResponse::default()
                        }
                    }))
            }
            FrequencyData::Spectrum(kind) => {
                log.spectra
                    .extend(for_each_series(variable, lines.len(), |name, value| {
                        StoredSpectrum {
                            name,
                            kind,
                            frequency_hz: lines.clone(),
                            values: value,
                            ..StoredSpectrum::default()
                        }
                    }))
            }
            FrequencyData::Coherence => {}
        }
    }
    let is_coherence = |v: &&Variable| roles::frequency_data(v) == FrequencyData::Coherence;
    for coherence in spectra.iter().filter(is_coherence) {
        attach_coherence(coherence, &mut responses, &mut log.diagnostics);
    }
    if !responses.responses.is_empty() {
        log.responses = Some(responses);
    }
    Ok(log.responses.is_some() || !log.spectra.is_empty())
}

/// Applies `make` to every row or column of a variable, with its name.
fn for_each_series<T>(
    variable: &Variable,
    length: usize,
    make: impl Fn(String, Vec<Complex>) -> T,
) -> Vec<T> {
    let series = variable.series(length);
    let value = |&(start, step): &(usize, usize)| {
        let rows = (0..length).map(move |k| start + k * step);
        let im = |i: usize| variable.im.as_ref().map_or(0.0, |im| im[i]);
        rows.map(|i| Complex::new(variable.re[i], im(i))).collect()
    };
    let numbered = series.iter().enumerate();
    numbered
        .map(|(k, s)| make(variable.series_name(k, series.len()), value(s)))
        .collect()
}

/// Assigns a coherence to the responses of the same base name, or to all responses in order if their number agrees.
fn attach_coherence(
    coherence: &Variable,
    responses: &mut FrequencyResponses,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let length = responses.frequency_hz.len();
    let measured = for_each_series(coherence, length, |name, value| {
        (name, value.iter().map(|v| v.re).collect::<Vec<f64>>())
    });
    let count = responses.responses.len();
    for (position, (name, values)) in measured.into_iter().enumerate() {
        let stem = base_name(&name);
        let matches: Vec<usize> = (0..count)
            .filter(|&i| base_name(&responses.responses[i].output.name) == stem)
            .collect();
        let target = match matches.as_slice() {
            &[index] => Some(index),
            _ if coherence.series(length).len() == count => Some(position),
            _ => None,
        };
        let largest = values.iter().fold(0.0_f64, |most, &c| most.max(c));
        match target.and_then(|target| responses.responses.get_mut(target)) {
            Some(function) => {
                if largest > 1.0 {
                    diagnostics.push(Diagnostic {
                        code: "coherence-above-one",
                        message: format!("the coherence `{name}` reaches {largest:.3} (limit 1)"),
                        hint: Some("the analyser that wrote it averaged its spectra differently; weigh by it with care".into()),
                    });
                }
                function.coherence = Some(values);
            }
            None => diagnostics.push(Diagnostic {
                code: "coherence-left-out",
                message: format!("the name of the coherence `{name}` matches none of the {count} frequency responses"),
                hint: None,
            }),
        }
    }
}

/// Name without the abbreviations of response and coherence, by which the two are matched.
fn base_name(name: &str) -> String {
    let mut stem: String = name
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric())
        .collect();
    for abbreviation in ["coherence", "coher", "coh", "frf", "hf", "tf"] {
        stem = stem.replace(abbreviation, "");
    }
    stem
}
