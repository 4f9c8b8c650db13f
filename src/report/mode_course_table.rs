//! Modes in the course of a record as tables: one row for each, and what was tried.

use super::number::{INTERVAL, brief, significant, with_deviation};
use super::table::{finish, plain, right_but_last};
use crate::identify::mode::IdentifiedMode;
use crate::identify::series::course::Trial;
use crate::numeric::statistics::HALF_INTERVAL;
use crate::plan::logs::found::ModeCourse;
use crate::plan::logs::method::family;

/// One row for each mode: where it begins and ends, and the range between.
pub fn table(course: &ModeCourse) -> String {
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
            brief(course.time_s[*from]),
            brief(course.time_s[*to]),
            frequency(first),
            frequency(last),
            format!("{} … {}", significant(low), significant(high)),
            damping(first),
            damping(last),
            format!("{} of {} instants", track.points.len(), course.time_s.len()),
        ]);
    }
    right_but_last(&mut table);
    finish(&table) + INTERVAL
}

/// Errors of prediction of what was tried, the best first.
pub fn tried(course: &ModeCourse) -> String {
    let mut table = plain();
    table.add_row(vec!["model", "memory", "error of prediction", "note"]);
    table.add_row(vec!["", "s", "rms", ""]);
    let mut all: Vec<&Trial> = course.tried.iter().collect();
    all.sort_by(|a, b| a.error_variance.total_cmp(&b.error_variance));
    for trial in all.into_iter().take(SHOWN) {
        let memory = course.memory_s(trial).map_or("all".to_string(), brief);
        let note = if *trial == course.taken { "taken" } else { "" };
        table.add_row(vec![
            family(trial.family),
            memory,
            significant(trial.error_variance.sqrt()),
            note.to_string(),
        ]);
    }
    right_but_last(&mut table);
    finish(&table)
}

/// Trials shown.
const SHOWN: usize = 6;

fn frequency(mode: &IdentifiedMode) -> String {
    with_deviation(
        mode.frequency_hz(),
        HALF_INTERVAL * mode.frequency_std_hz().unwrap_or(0.0),
    )
}

fn damping(mode: &IdentifiedMode) -> String {
    let half = HALF_INTERVAL * mode.damping_std().unwrap_or(0.0);
    with_deviation(100.0 * mode.damping_ratio(), 100.0 * half)
}
