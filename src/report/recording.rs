//! A log as it was read: document, table of its channels, table of its frequency-domain data.

use serde_json::{Value, json};

use super::number_format::four_digits;
use super::table::Table;
use crate::base::text::pluralise;
use crate::recording::channel_statistics::ChannelStatistics;
use crate::recording::frequency_responses::{FrequencyResponses, StoredSpectrum};
use crate::recording::raw::Repair;
use crate::recording::signals::Recording;
use crate::recording::write;

/// The document of a log of signals.
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
        "header": metadata_json(recording),
        "start": recording.start,
        "rate_hz": recording.rate_hz,
        "rate_source": recording.rate_source,
        "samples": recording.samples,
        "duration_s": recording.duration_s(),
        "segments": write::json::segments(recording),
        "channels": channels,
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
        return "no numbers".to_string();
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

/// Survey of a log as it was read.
pub fn survey(recording: &Recording, surveys: &[ChannelStatistics]) -> String {
    let mut text = format!("{}   {}\n", recording.path, recording.dialect);
    text += &format!(
        "  time base   {} Hz, {}\n",
        rate(recording.rate_hz),
        recording.rate_source
    );
    text += &format!(
        "              {}, {} s",
        pluralise(recording.samples, "sample"),
        four_digits(recording.duration_s())
    );
    text += &match recording.segments.len() {
        1 => "\n".to_string(),
        n => format!(" in {n} segments\n"),
    };
    if let Some(start) = &recording.start {
        text += &format!("  first sample   {start}\n");
    }
    let facts = || recording.metadata.iter().take(MAX_HEADER_ENTRIES);
    let width = facts().map(|(key, _)| key.chars().count()).max();
    for (key, value) in facts() {
        text += &format!("  {key:width$}   {value}\n", width = width.unwrap_or(0));
    }
    let mut table = Table::texts("  channel|unit|range|noise ≤|note");
    for (channel, survey) in recording.channels.iter().zip(surveys) {
        let (range, noise) = match survey.empty {
            true => ("–".to_string(), "–".to_string()),
            false => (
                format!(
                    "{} … {}",
                    four_digits(survey.range.0),
                    four_digits(survey.range.1)
                ),
                match survey.noise.is_finite() {
                    true => four_digits(survey.noise),
                    false => "–".to_string(),
                },
            ),
        };
        let unit = if channel.unit.is_empty() {
            "?"
        } else {
            &channel.unit
        };
        table.row([
            format!("  {}", channel.name),
            unit.to_string(),
            range,
            noise,
            survey_note(survey),
        ]);
    }
    text + &table.text()
}

/// Table of a file's frequency-domain data: responses and spectra; empty where there are none.
pub fn frequency_data_table(found: Option<&FrequencyResponses>, held: &[StoredSpectrum]) -> String {
    let mut text = found.map_or(String::new(), responses_table);
    if !held.is_empty() {
        text += &spectra_table(held);
    }
    text
}

/// `1601 lines, 0 … 800 Hz`.
fn lines(frequency_hz: &[f64]) -> String {
    let end = |f: Option<&f64>| f.map_or("–".to_string(), |&f| four_digits(f));
    format!(
        "{}, {} … {} Hz",
        pluralise(frequency_hz.len(), "line"),
        end(frequency_hz.first()),
        end(frequency_hz.last())
    )
}

/// A text from a file, or that it has none.
fn text_or_unknown(text: &str) -> String {
    match text {
        "" => "?".to_string(),
        text => text.to_string(),
    }
}

fn responses_table(found: &FrequencyResponses) -> String {
    let text = format!(
        "  {} over {}\n",
        pluralise(found.responses.len(), "frequency response"),
        lines(&found.frequency_hz)
    );
    let mut table = Table::texts("  response|unit|input|unit|coherence");
    for f in &found.responses {
        let input = f.input.clone().unwrap_or_default();
        let coherence = if f.coherence.is_some() { "yes" } else { "–" };
        table.row([
            format!("  {}", text_or_unknown(&f.output.name)),
            text_or_unknown(&f.output.unit),
            text_or_unknown(&input.name),
            text_or_unknown(&input.unit),
            coherence.to_string(),
        ]);
    }
    text + &table.text()
}

fn spectra_table(held: &[StoredSpectrum]) -> String {
    let mut table = Table::texts("  spectrum|unit|kind|over");
    for s in held {
        let unit = match s.is_decibel {
            true => format!("dB of {}", text_or_unknown(&s.unit)),
            false => text_or_unknown(&s.unit),
        };
        table.row([
            format!("  {}", text_or_unknown(&s.name)),
            unit,
            s.kind.to_string(),
            lines(&s.frequency_hz),
        ]);
    }
    table.text()
}

/// Facts of a header shown at once.
const MAX_HEADER_ENTRIES: usize = 6;

/// A rate with the digits a time base can have.
pub fn rate(rate_hz: f64) -> String {
    if !(1.0..1e9).contains(&rate_hz) {
        return four_digits(rate_hz);
    }
    let text = format!("{rate_hz:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
