//! Logs as tables for a terminal.

use super::number::{brief, with_deviation};
use super::recording::note;
use super::table::{finish, plain};
use crate::identify::mode::IdentifiedMode;
use crate::plan::logs::doubts::{coherence_at, window_damping};
use crate::plan::logs::identification::Identification;
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

/// Identified modes.
pub fn identified(found: &Identification) -> String {
    let mut text = format!("{}\n\n", found.how);
    if found.modes.is_empty() {
        text += "no mode is significant in the band\n";
        return text;
    }
    let coherent = found
        .responses
        .functions
        .iter()
        .any(|f| f.coherence.is_some());
    let mut table = plain();
    let mut heads = vec!["mode", "frequency", "damping"];
    let mut units = vec!["", "Hz", "%"];
    if coherent {
        heads.push("coherence");
        units.push("at peak");
    }
    heads.push("note");
    units.push("");
    table.add_row(heads);
    table.add_row(units);
    for (k, mode) in found.modes.iter().enumerate() {
        let frequency = with_deviation(mode.frequency_hz(), mode.frequency_std_hz().unwrap_or(0.0));
        let damping = with_deviation(
            100.0 * mode.damping_ratio(),
            100.0 * mode.damping_std().unwrap_or(0.0),
        );
        let mut row = vec![(k + 1).to_string(), frequency, damping];
        if coherent {
            row.push(
                coherence_at(&found.responses, mode.frequency_hz())
                    .map_or("–".to_string(), |c| format!("{c:.3}")),
            );
        }
        row.push(note_of(found, mode));
        table.add_row(row);
    }
    super::table::right_but_last(&mut table);
    text += &finish(&table);
    text += &format!(
        "± one standard deviation; fit error {} %\n",
        super::number::percent(super::identified::worst_error(found))
    );
    if let Some(last) = found.fit.evidence.iter().rev().find(|s| !s.accepted) {
        text += &format!("{}\n", last.words());
    }
    let decay = found.responses.window_decay;
    if decay > 0.0
        && let (Some(first), Some(last)) = (found.modes.first(), found.modes.last())
    {
        let shift = |m: &IdentifiedMode| {
            format!(
                "{} % at {} Hz",
                super::number::percent(window_damping(decay, m.frequency_hz())),
                brief(m.frequency_hz())
            )
        };
        text += &format!(
            "exponential window: taken off the damping, {} … {}\n",
            shift(first),
            shift(last)
        );
    }
    text
}

/// What is remarkable about a mode.
fn note_of(found: &Identification, mode: &IdentifiedMode) -> String {
    let near = |f: f64| (f - mode.frequency_hz()).abs() < 1e-3 * mode.frequency_hz();
    match found.fit.spread.iter().find(|s| near(s.frequency_hz)) {
        Some(s) => format!("responses differ by {} Hz", brief(s.frequency_spread_hz)),
        None => String::new(),
    }
}

/// Facts of a header shown at once.
const FACTS: usize = 6;

/// A rate with the digits a time base can have.
pub fn rate(rate_hz: f64) -> String {
    let text = format!("{rate_hz:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
