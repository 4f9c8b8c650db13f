//! Frequency responses, coherences and spectra of a MATLAB file over its frequency vector.

use super::roles::{self, FrequencyData};
use super::variables::Variable;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::Complex;
use crate::recording::frequency_responses::{
    ChannelLabel, FrequencyResponse, FrequencyResponses, StoredSpectrum,
};
use crate::recording::raw::RawLog;

/// Takes the frequency vector and what lies over it out of `numbers`; whether there was any.
pub(super) fn take_spectra(numbers: &mut Vec<Variable>, log: &mut RawLog) -> Result<bool, Error> {
    let found = (0..numbers.len()).find_map(|at| Some((at, roles::frequencies_hz(&numbers[at])?)));
    let Some((at, lines)) = found else {
        return Ok(false);
    };
    let over = |v: &Variable| v.length() > 1 && !v.series(lines.len()).is_empty();
    let has_time = numbers
        .iter()
        .any(|v| roles::is_time(v) && v.re.len() == lines.len());
    let others = || {
        numbers
            .iter()
            .enumerate()
            .filter(|&(i, v)| i != at && over(v))
    };
    // A speed or frequency recorded over time lies among real signals of the same length.
    let is_signal = has_time && others().all(|(_, v)| v.im.is_none());
    if is_signal || others().next().is_none() {
        return Ok(false);
    }
    numbers.remove(at);
    let (taken, left) = numbers.drain(..).partition::<Vec<_>, _>(over);
    *numbers = left;

    let mut responses = FrequencyResponses {
        frequency_hz: lines.clone(),
        ..FrequencyResponses::default()
    };
    for variable in &taken {
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
    for coherence in taken.iter().filter(is_coherence) {
        attach_coherence(coherence, &mut responses, &mut log.diagnostics);
    }
    if !responses.responses.is_empty() {
        log.responses = Some(responses);
    }
    Ok(log.responses.is_some() || !log.spectra.is_empty())
}

/// Every row or column of a variable with its name.
fn for_each_series<T>(
    variable: &Variable,
    length: usize,
    make: impl Fn(String, Vec<Complex>) -> T,
) -> Vec<T> {
    let series = variable.series(length);
    let value = |&(start, step): &(usize, usize)| {
        let at = (0..length).map(move |k| start + k * step);
        let im = |i: usize| variable.im.as_ref().map_or(0.0, |im| im[i]);
        at.map(|i| Complex::new(variable.re[i], im(i))).collect()
    };
    let named = series.iter().enumerate();
    named
        .map(|(at, s)| make(variable.series_name(at, series.len()), value(s)))
        .collect()
}

/// Finds the responses a coherence belongs to: those of the same name without its mark, or the only ones there are.
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
    for (at, (name, values)) in measured.into_iter().enumerate() {
        let bare = base_name(&name);
        let matches: Vec<usize> = (0..count)
            .filter(|&i| base_name(&responses.responses[i].output.name) == bare)
            .collect();
        let place = match matches.as_slice() {
            &[one] => Some(one),
            _ if coherence.series(length).len() == count => Some(at),
            _ => None,
        };
        let largest = values.iter().fold(0.0_f64, |most, &c| most.max(c));
        match place.and_then(|place| responses.responses.get_mut(place)) {
            Some(function) => {
                if largest > 1.0 {
                    diagnostics.push(Diagnostic {
                        code: "coherence-above-one",
                        message: format!("the coherence `{name}` reaches {largest:.3}, and none can exceed 1"),
                        hint: Some("the analyser that wrote it averaged its spectra differently; weigh by it with care".into()),
                    });
                }
                function.coherence = Some(values);
            }
            None => diagnostics.push(Diagnostic {
                code: "coherence-left-out",
                message: format!("the coherence `{name}` belongs to none of the {count} frequency responses by its name"),
                hint: None,
            }),
        }
    }
}

/// A name without the marks of response and coherence, by which the two are matched.
fn base_name(name: &str) -> String {
    let mut bare: String = name
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric())
        .collect();
    for mark in ["coherence", "coher", "coh", "frf", "hf", "tf"] {
        bare = bare.replace(mark, "");
    }
    bare
}
