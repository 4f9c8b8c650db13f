//! Modes over the time of a recording: document, tables, plot of frequency and damping.

use serde_json::{Value, json};

use super::axes::{draw_frame, linear_range};
use super::number_format::{INTERVAL_FOOTNOTE, four_digits, significant, with_deviation};
use super::svg::{
    Anchor, BLACK, BLUE, Colour, GREY, LABEL_SIZE, ORANGE, Panel, WIDTH, lighten, render_svg, ticks,
};
use super::table::{Table, exact, or_blank};
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::series::model_trajectory::{MemoryTrial, ModeTrack};
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

/// Draws frequency and damping over time, a bar of two standard deviations to either side at every point.
pub fn draw(course: &ModeTracking, title: &str) -> String {
    const COLOURS: [Colour; 4] = [BLUE, ORANGE, BLACK, GREY];
    const MARGIN_LEFT: f64 = 70.0;
    render_svg(WIDTH, 640.0, |canvas| {
        canvas.title(title, MARGIN_LEFT);
        let x = (0.0, course.time_s.last().copied().unwrap_or(1.0));
        type Accessor = fn(&ModalParameters) -> (f64, f64);
        let frequency: Accessor = |m| (m.frequency_hz(), m.frequency_std_hz().unwrap_or(0.0));
        let damping: Accessor = |m| {
            let std = m.damping_std().unwrap_or(0.0);
            (100.0 * m.damping_ratio(), 100.0 * std)
        };
        let panels = [
            ("frequency, Hz", frequency, (44.0, 364.0), None),
            ("damping, %", damping, (388.0, 588.0), Some("time, s")),
        ];
        for (name, pick, down, below) in panels {
            let values = (course.tracks.iter()).flat_map(|t| t.points.iter().map(|p| pick(&p.1).0));
            let Some(y) = linear_range(values) else {
                let spot = (WIDTH / 2.0, 0.5 * (down.0 + down.1));
                canvas.placeholder("no mode", spot);
                continue;
            };
            let panel = Panel::new((MARGIN_LEFT, WIDTH - 40.0), down, x, y);
            panel.draw_y_grid(canvas, &ticks(y, 6));
            draw_frame(&panel, canvas, name, below);
            for (k, track) in course.tracks.iter().enumerate() {
                let ink = COLOURS[k % COLOURS.len()];
                for (at, mode) in &track.points {
                    let (value, std) = pick(mode);
                    let ends = [value - 2.0 * std, value + 2.0 * std].map(|v| v.clamp(y.0, y.1));
                    let [low, high] = ends.map(|v| panel.to_canvas(course.time_s[*at], v));
                    canvas.line(low, high, lighten(ink), 1.4);
                }
                for (at, mode) in &track.points {
                    canvas.fill_circle(panel.to_canvas(course.time_s[*at], pick(mode).0), 1.6, ink);
                }
                if let Some((at, mode)) = track.points.last() {
                    let spot = panel.to_canvas(course.time_s[*at], pick(mode).0);
                    let label = (k + 1).to_string();
                    canvas.text(
                        &label,
                        (spot.0 + 8.0, spot.1),
                        LABEL_SIZE,
                        ink,
                        Anchor::Start,
                    );
                }
            }
        }
    })
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
    all.sort_by(|a, b| a.error_variance.total_cmp(&b.error_variance));
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
