//! Logs as tables for a terminal.

use super::number::brief;
use super::recording::note;
use super::table::{finish, plain};
use crate::recording::responses::FrequencyResponses;
use crate::recording::signals::Recording;
use crate::recording::survey::Survey;

/// What was understood of a log.
pub fn survey(recording: &Recording, surveys: &[Survey]) -> String {
    let mut text = format!("{}   {}\n", recording.path, recording.dialect);
    text += &format!(
        "  time base   {} Hz, {}\n",
        rate(recording.rate_hz),
        recording.rate_source
    );
    text += &format!(
        "              {} samples, {} s",
        recording.samples,
        brief(recording.duration_s())
    );
    text += &match recording.stretches.len() {
        1 => "\n".to_string(),
        n => format!(" in {n} stretches\n"),
    };
    for (key, value) in recording.facts.iter().take(FACTS) {
        text += &format!("  {key}   {value}\n");
    }
    let mut table = plain();
    table.add_row(vec!["  channel", "unit", "range", "noise", "note"]);
    for (channel, survey) in recording.channels.iter().zip(surveys) {
        let (range, noise) = match survey.empty {
            true => ("–".to_string(), "–".to_string()),
            false => (
                format!("{} … {}", brief(survey.range.0), brief(survey.range.1)),
                brief(survey.noise),
            ),
        };
        let unit = if channel.unit.is_empty() {
            "?"
        } else {
            &channel.unit
        };
        table.add_row(vec![
            format!("  {}", channel.name),
            unit.to_string(),
            range,
            noise,
            note(survey),
        ]);
    }
    text + &finish(&table)
}

/// What frequency responses a file holds.
pub fn responses(path: &str, dialect: &str, found: &FrequencyResponses) -> String {
    let ends = |f: Option<&f64>| f.map_or("–".to_string(), |&f| brief(f));
    let lines = &found.frequency_hz;
    let mut text = format!(
        "{path}   {dialect}\n  {} frequency responses over {} lines, {} … {} Hz\n",
        found.functions.len(),
        lines.len(),
        ends(lines.first()),
        ends(lines.last())
    );
    let mut table = plain();
    table.add_row(vec!["  response", "unit", "input", "unit", "coherence"]);
    for f in &found.functions {
        let input = f.input.clone().unwrap_or_default();
        let or = |text: &str| {
            if text.is_empty() {
                "?".to_string()
            } else {
                text.to_string()
            }
        };
        let coherence = if f.coherence.is_some() { "yes" } else { "–" };
        table.add_row(vec![
            format!("  {}", or(&f.output.name)),
            or(&f.output.unit),
            or(&input.name),
            or(&input.unit),
            coherence.to_string(),
        ]);
    }
    text += &finish(&table);
    text
}

/// Facts of a header shown at once.
const FACTS: usize = 6;

/// A rate with the digits a time base can have.
pub fn rate(rate_hz: f64) -> String {
    let text = format!("{rate_hz:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
