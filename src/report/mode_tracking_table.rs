//! Modes over the time of a record as tables: one row for each, and the trials.

use super::modes_table::{finish, plain, right_but_last};
use super::number_format::{INTERVAL_FOOTNOTE, four_digits, significant, with_deviation};
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::series::model_trajectory::MemoryTrial;
use crate::numeric::statistics::Z_95;
use crate::plan::logs::identification_result::ModeTracking;
use crate::plan::logs::method::structure_text;

/// One row for each mode: where it begins and ends, and the range between.
pub fn table(course: &ModeTracking) -> String {
    let mut table = plain();
    table.add_row(vec![
        "mode",
        "from",
        "to",
        "frequency",
        "",
        "",
        "damping",
        "",
        "seen at",
    ]);
    table.add_row(vec![
        "",
        "s",
        "s",
        "first, Hz",
        "last, Hz",
        "range, Hz",
        "first, %",
        "last, %",
        "",
    ]);
    for (k, track) in course.tracks.iter().enumerate() {
        let (Some((from, first)), Some((to, last))) = (track.points.first(), track.points.last())
        else {
            continue;
        };
        let all = || track.points.iter().map(|p| p.1.frequency_hz());
        let (low, high) = all().fold((f64::INFINITY, 0.0f64), |(l, h), f| (l.min(f), h.max(f)));
        table.add_row(vec![
            (k + 1).to_string(),
            four_digits(course.time_s[*from]),
            four_digits(course.time_s[*to]),
            frequency(first),
            frequency(last),
            format!("{} … {}", significant(low), significant(high)),
            damping(first),
            damping(last),
            format!("{} of {} instants", track.points.len(), course.time_s.len()),
        ]);
    }
    right_but_last(&mut table);
    finish(&table) + INTERVAL_FOOTNOTE
}

/// Errors of prediction of what was tried, the best first.
pub fn trials_table(course: &ModeTracking) -> String {
    let mut table = plain();
    table.add_row(vec!["model", "memory", "error of prediction", "note"]);
    table.add_row(vec!["", "s", "rms", ""]);
    let mut all: Vec<&MemoryTrial> = course.trials.iter().collect();
    all.sort_by(|a, b| a.error_variance.total_cmp(&b.error_variance));
    for trial in all.into_iter().take(MAX_ROWS) {
        let memory = course
            .memory_s(trial)
            .map_or("all".to_string(), four_digits);
        let note = if *trial == course.chosen { "taken" } else { "" };
        table.add_row(vec![
            structure_text(trial.family),
            memory,
            significant(trial.error_variance.sqrt()),
            note.to_string(),
        ]);
    }
    right_but_last(&mut table);
    finish(&table)
}

/// Trials shown.
const MAX_ROWS: usize = 6;

fn frequency(mode: &ModalParameters) -> String {
    with_deviation(
        mode.frequency_hz(),
        Z_95 * mode.frequency_std_hz().unwrap_or(0.0),
    )
}

fn damping(mode: &ModalParameters) -> String {
    let half = Z_95 * mode.damping_std().unwrap_or(0.0);
    with_deviation(100.0 * mode.damping_ratio(), 100.0 * half)
}
