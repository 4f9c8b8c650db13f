//! Log as it was read, as text and JSON.

use serde_json::{Value, json};

use super::json::warnings;
use super::number_format::four_digits;
use crate::recording::channel_statistics::ChannelStatistics;
use crate::recording::frequency_responses::{FrequencyResponses, StoredSpectrum};
use crate::recording::raw::{RawLog, Repair};
use crate::recording::signals::Recording;
use crate::recording::write;

/// The JSON document of `check LOG`, without its header.
pub fn json(recording: &Recording, surveys: &[ChannelStatistics]) -> Value {
    let channels: Vec<Value> = recording
        .channels
        .iter()
        .zip(surveys)
        .map(|(channel, survey)| {
            let known = |x: f64| (!survey.empty).then_some(x);
            json!({
                "name": channel.name,
                "unit": channel.unit,
                "minimum": known(survey.range.0),
                "maximum": known(survey.range.1),
                "mean": known(survey.mean),
                "standard_deviation": known(survey.std),
                "noise_rms": known(survey.noise),
                "constant": survey.constant,
                "empty": survey.empty,
                "overloads": survey.overloads,
                "clipped": survey.clipped.map(|(count, level)| json!({ "count": count, "level": level })),
            })
        })
        .collect();
    json!({
        "file": recording.path,
        "dialect": recording.dialect,
        "facts": metadata_json(recording),
        "start": recording.start,
        "rate_hz": recording.rate_hz,
        "rate_source": recording.rate_source,
        "samples": recording.samples,
        "duration_s": recording.duration_s(),
        "stretches": write::json::segments(recording),
        "channels": channels,
        "repairs": repairs(&recording.repairs),
        "warnings": warnings(&recording.diagnostics),
    })
}

fn metadata_json(recording: &Recording) -> Value {
    recording
        .metadata
        .iter()
        .map(|(key, text)| (key.clone(), json!(text)))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// Frequency responses in a file.
pub fn responses(found: &FrequencyResponses) -> Value {
    let functions: Vec<Value> = found
        .responses
        .iter()
        .map(|f| {
            json!({
                "input": f.input.as_ref().map(|t| t.name.clone()),
                "input_unit": f.input.as_ref().map(|t| t.unit.clone()),
                "output": f.output.name,
                "output_unit": f.output.unit,
                "coherence": f.coherence.is_some(),
            })
        })
        .collect();
    json!({
        "lines": found.frequency_hz.len(),
        "from_hz": found.frequency_hz.first(),
        "to_hz": found.frequency_hz.last(),
        "functions": functions,
    })
}

/// Spectra in a file.
pub fn spectra(found: &[StoredSpectrum]) -> Value {
    let spectrum = |s: &StoredSpectrum| {
        json!({
            "name": s.name,
            "unit": s.unit,
            "kind": s.kind,
            "decibel": s.is_decibel,
            "lines": s.frequency_hz.len(),
            "from_hz": s.frequency_hz.first(),
            "to_hz": s.frequency_hz.last(),
        })
    };
    found.iter().map(spectrum).collect()
}

/// The document of a file that holds nothing over time, without its header.
pub fn frequency_only_json(log: &RawLog) -> Value {
    json!({
        "file": log.path,
        "dialect": log.dialect,
        "repairs": repairs(&log.repairs),
        "warnings": warnings(&log.diagnostics),
    })
}

/// Repairs of the data, as a list.
pub fn repairs(list: &[Repair]) -> Value {
    list.iter()
        .map(|r| json!({ "kind": r.kind, "message": r.message }))
        .collect()
}

/// Remarkable findings of a survey, as text; empty where there are none.
pub fn survey_note(survey: &ChannelStatistics) -> String {
    let mut notes = Vec::new();
    if survey.empty {
        return "no number at all".to_string();
    }
    if survey.constant {
        notes.push("constant".to_string());
    }
    if let Some((count, level)) = survey.clipped {
        let times = if count == 1 {
            "once".to_string()
        } else {
            format!("{count} times")
        };
        notes.push(format!("clipped {times} at {}", four_digits(level)));
    }
    match survey.overloads {
        0 => {}
        1 => notes.push("1 overload".to_string()),
        n => notes.push(format!("{n} overloads")),
    }
    // A mean of so many deviations hides the signal next to it until it is taken off.
    const LARGE: f64 = 3.0;
    if !survey.constant && survey.mean.abs() > LARGE * survey.std {
        notes.push(format!("mean {}", four_digits(survey.mean)));
    }
    notes.join(", ")
}
