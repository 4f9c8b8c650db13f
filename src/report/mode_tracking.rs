//! Modes over the time of a recording: document, tables, plot of frequency and damping.

use serde_json::{Value, json};

use super::axes::linear_range;
use super::figure::{Axis, Curve, Ink, Mark, NamePlacement, Plot, PlotColumn};
use super::number_format::{INTERVAL_FOOTNOTE, four_digits, significant, with_deviation};
use super::table::{Table, exact, or_blank};
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::series::model_trajectory::{MemoryTrial, ModeTrack};
use crate::numeric::sorting::sort_ascending;
use crate::numeric::statistics::Z_95;
use crate::plan::logs::identification_result::ModeTracking;
use crate::plan::logs::method::structure_text;

/// Trials, for `evidence`.
pub fn trials(course: &ModeTracking) -> Value {
    let one = |t: &MemoryTrial| json!({ "model": structure_text(t.family), "memory_s": course.memory_s(t), "error_variance": t.error_variance, "accepted": *t == course.chosen });
    course.trials.iter().map(one).collect()
}

/// The tracks, point by point.
pub fn json(course: &ModeTracking) -> Value {
    let point = |(at, m): &(usize, ModalParameters)| json!({ "time_s": course.time_s[*at], "frequency_hz": m.frequency_hz(), "frequency_std_hz": m.frequency_std_hz(), "damping_ratio": m.damping_ratio(), "damping_std": m.damping_std() });
    let track = |(k, t): (usize, &ModeTrack)| json!({ "mode": k + 1, "points": t.points.iter().map(point).collect::<Vec<_>>() });
    course.tracks.iter().enumerate().map(track).collect()
}

/// The tracks, one row for each point.
pub fn points_table(course: &ModeTracking) -> Table<'static> {
    let mut table =
        Table::new("mode|time_s|frequency_hz|frequency_std_hz|damping_ratio|damping_std");
    for (k, track) in course.tracks.iter().enumerate() {
        for (at, m) in &track.points {
            table.row([
                (k + 1).to_string(),
                exact(course.time_s[*at]),
                exact(m.frequency_hz()),
                or_blank(m.frequency_std_hz(), exact),
                exact(m.damping_ratio()),
                or_blank(m.damping_std(), exact),
            ]);
        }
    }
    table
}

/// Frequency and damping over time, an interval of two standard deviations about every point.
pub fn figure(course: &ModeTracking, title: &str) -> PlotColumn {
    type Accessor = fn(&ModalParameters) -> (f64, f64);
    let frequency: Accessor = |m| (m.frequency_hz(), m.frequency_std_hz().unwrap_or(0.0));
    let damping: Accessor = |m| {
        let std = m.damping_std().unwrap_or(0.0);
        (100.0 * m.damping_ratio(), 100.0 * std)
    };
    let end = course.time_s.last().copied().unwrap_or(1.0);
    let panels = [
        ("frequency, Hz", frequency, 320.0),
        ("damping, %", damping, 200.0),
    ];
    let plot = |(name, pick, height): (&str, Accessor, f64)| {
        let track = |(k, track): (usize, &ModeTrack)| {
            let (x, y) = (track.points.iter())
                .map(|(at, mode)| (course.time_s[*at], pick(mode).0))
                .unzip();
            let interval = track.points.iter().map(|(_, mode)| {
                let (value, std) = pick(mode);
                (value - 2.0 * std, value + 2.0 * std)
            });
            Curve {
                interval: interval.collect(),
                ..Curve::new((k + 1).to_string(), Ink::Series(k), Mark::Discs(1.6), x, y)
            }
        };
        let values = (course.tracks.iter()).flat_map(|t| t.points.iter().map(|p| pick(&p.1).0));
        let y = Axis {
            range: linear_range(values),
            ..Axis::linear(name)
        };
        Plot {
            height,
            curves: course.tracks.iter().enumerate().map(track).collect(),
            names: NamePlacement::AtEnd,
            empty: "no mode",
            ..Plot::new(Axis::linear("time, s").over(0.0, end), y)
        }
    };
    PlotColumn {
        title: title.to_string(),
        linked: true,
        plots: panels.into_iter().map(plot).collect(),
        ..PlotColumn::default()
    }
}

/// One row for each mode: where it begins and ends, and the range between.
pub fn table(course: &ModeTracking) -> String {
    let mut table = Table::new(
        "mode|from [s]|to [s]|frequency [first, Hz]|[last, Hz]|[range, Hz]|damping [first, %]|[last, %]|seen at",
    );
    for (k, track) in course.tracks.iter().enumerate() {
        let (Some((from, first)), Some((to, last))) = (track.points.first(), track.points.last())
        else {
            continue;
        };
        let all = || track.points.iter().map(|p| p.1.frequency_hz());
        let (low, high) = all().fold((f64::INFINITY, 0.0f64), |(l, h), f| (l.min(f), h.max(f)));
        table.row([
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
    table.text() + INTERVAL_FOOTNOTE
}

/// Errors of prediction of what was tried, the best first.
pub fn trials_table(course: &ModeTracking) -> String {
    let mut table = Table::new("model|memory [s]|error of prediction [rms]|note");
    let mut all: Vec<&MemoryTrial> = course.trials.iter().collect();
    sort_ascending(&mut all, |a| a.error_variance);
    for trial in all.into_iter().take(MAX_ROWS) {
        let memory = course
            .memory_s(trial)
            .map_or("all".to_string(), four_digits);
        let note = if *trial == course.chosen { "taken" } else { "" };
        table.row([
            structure_text(trial.family),
            memory,
            significant(trial.error_variance.sqrt()),
            note.to_string(),
        ]);
    }
    table.text()
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
