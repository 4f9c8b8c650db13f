//! Modes in the course of a record: JSON, CSV, and the picture of frequency and damping over time.

use serde_json::{Value, json};

use super::axes::{frame, span};
use super::number::or_blank;
use super::style::{
    Anchor, BLACK, BLUE, GREY, Ink, ORANGE, Panel, SMALL, TITLE, WIDTH, paler, picture, ticks,
};
use crate::identify::mode::IdentifiedMode;
use crate::identify::series::course::{Track, Trial};
use crate::plan::logs::found::ModeCourse;
use crate::plan::logs::method::family;

/// What was tried, for `evidence`.
pub fn trials(course: &ModeCourse) -> Value {
    let one = |t: &Trial| json!({ "model": family(t.family), "memory_s": course.memory_s(t), "error_variance": t.error_variance, "accepted": *t == course.taken });
    course.tried.iter().map(one).collect()
}

/// The tracks, point by point.
pub fn json(course: &ModeCourse) -> Value {
    let point = |(at, m): &(usize, IdentifiedMode)| json!({ "time_s": course.time_s[*at], "frequency_hz": m.frequency_hz(), "frequency_std_hz": m.frequency_std_hz(), "damping_ratio": m.damping_ratio(), "damping_std": m.damping_std() });
    let track = |(k, t): (usize, &Track)| json!({ "mode": k + 1, "points": t.points.iter().map(point).collect::<Vec<_>>() });
    course.tracks.iter().enumerate().map(track).collect()
}

/// The tracks, one row for each point.
pub fn csv(course: &ModeCourse) -> String {
    let mut text =
        String::from("mode,time_s,frequency_hz,frequency_std_hz,damping_ratio,damping_std\n");
    for (k, track) in course.tracks.iter().enumerate() {
        for (at, m) in &track.points {
            text += &format!(
                "{},{:?},{:?},{},{:?},{}\n",
                k + 1,
                course.time_s[*at],
                m.frequency_hz(),
                or_blank(m.frequency_std_hz()),
                m.damping_ratio(),
                or_blank(m.damping_std())
            );
        }
    }
    text
}

/// Draws frequency and damping over time, a bar of two standard deviations to either side at every point.
pub fn draw(course: &ModeCourse, title: &str) -> String {
    const INKS: [Ink; 4] = [BLUE, ORANGE, BLACK, GREY];
    const LEFT: f64 = 70.0;
    picture(WIDTH, 640.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let x = (0.0, course.time_s.last().copied().unwrap_or(1.0));
        type Pick = fn(&IdentifiedMode) -> (f64, f64);
        let frequency: Pick = |m| (m.frequency_hz(), m.frequency_std_hz().unwrap_or(0.0));
        let damping: Pick = |m| {
            let std = m.damping_std().unwrap_or(0.0);
            (100.0 * m.damping_ratio(), 100.0 * std)
        };
        let panels = [
            ("frequency, Hz", frequency, (44.0, 364.0), None),
            ("damping, %", damping, (388.0, 588.0), Some("time, s")),
        ];
        for (name, pick, down, below) in panels {
            let values = (course.tracks.iter()).flat_map(|t| t.points.iter().map(|p| pick(&p.1).0));
            let Some(y) = span(values) else {
                let spot = (WIDTH / 2.0, 0.5 * (down.0 + down.1));
                canvas.text("no mode", spot, TITLE, GREY, Anchor::Middle);
                continue;
            };
            let panel = Panel {
                across: (LEFT, WIDTH - 40.0),
                down,
                x,
                y,
            };
            panel.rule_y(canvas, &ticks(y, 6));
            frame(&panel, canvas, name, below);
            for (k, track) in course.tracks.iter().enumerate() {
                let ink = INKS[k % INKS.len()];
                for (at, mode) in &track.points {
                    let (value, std) = pick(mode);
                    let ends = [value - 2.0 * std, value + 2.0 * std].map(|v| v.clamp(y.0, y.1));
                    let [low, high] = ends.map(|v| panel.at(course.time_s[*at], v));
                    canvas.line(low, high, paler(ink), 1.4);
                }
                for (at, mode) in &track.points {
                    canvas.disc(panel.at(course.time_s[*at], pick(mode).0), 1.6, ink);
                }
                if let Some((at, mode)) = track.points.last() {
                    let spot = panel.at(course.time_s[*at], pick(mode).0);
                    let label = (k + 1).to_string();
                    canvas.text(&label, (spot.0 + 8.0, spot.1), SMALL, ink, Anchor::Start);
                }
            }
        }
    })
}
