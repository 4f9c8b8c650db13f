//! Key of a figure of an SVG file: a sign and a name for each curve and each kind of event.

use super::figure::{Ink, Mark, NamePlacement, PlotColumn};
use super::figure_marks::{EVENT_ROW, colour, cross};
use super::svg::{Anchor, Canvas, LABEL_SIZE, Point2, text_width};

/// Height of a row of the key.
pub(super) const KEY_ROW: f64 = 16.0;

/// An entry of the key: a name with its sign, that of a curve or a tick for an event.
pub(super) struct KeyEntry<'a> {
    name: &'a str,
    ink: Ink,
    mark: Option<Mark>,
}

/// Named curves and events in rows of the key of this width, points; each name once.
pub(super) fn key_rows(figure: &PlotColumn, across: f64) -> Vec<Vec<KeyEntry<'_>>> {
    let mut rows: Vec<Vec<KeyEntry>> = Vec::new();
    let mut room = 0.0;
    let plots = figure
        .plots
        .iter()
        .filter(|p| p.names == NamePlacement::Key);
    let curves = plots.flat_map(|p| &p.curves).map(|c| KeyEntry {
        name: &c.name,
        ink: c.ink,
        mark: Some(c.shown_mark()),
    });
    let events = figure.events.iter().map(|e| KeyEntry {
        name: &e.name,
        ink: Ink::Series(e.ink),
        mark: None,
    });
    for entry in curves.chain(events) {
        let known = rows.iter().flatten().any(|c| c.name == entry.name);
        if entry.name.is_empty() || known {
            continue;
        }
        let width = entry_width(&entry);
        match rows.last_mut() {
            Some(row) if width <= room => row.push(entry),
            _ => {
                rows.push(vec![entry]);
                room = across;
            }
        }
        room -= width;
    }
    rows
}

/// Width of a sign and its name with the space behind them.
pub(super) fn entry_width(entry: &KeyEntry) -> f64 {
    39.0 + text_width(entry.name, LABEL_SIZE)
}

/// A sign and its name; returns the right end.
pub(super) fn key_entry(canvas: &mut Canvas, (left, height): Point2, entry: &KeyEntry) -> f64 {
    let ink = colour(entry.ink);
    let middle = (left + 9.0, height);
    let Some(mark) = entry.mark else {
        let half = 0.5 * EVENT_ROW;
        canvas.line(
            (middle.0, height - half),
            (middle.0, height + half),
            ink,
            1.4,
        );
        return name_entry(canvas, (left, height), entry.name);
    };
    match mark {
        Mark::Line(width, style) => {
            let ends = [(left, height), (left + 18.0, height)];
            canvas.polyline(&ends, ink, width.max(1.8), style);
        }
        Mark::Discs(radius) => canvas.fill_circle(middle, radius.max(2.4), ink),
        Mark::Stems => canvas.fill_circle(middle, 2.2, ink),
        Mark::Rings(radius) => canvas.stroke_circle(middle, radius, ink, 1.2),
        Mark::Crosses(radius) => cross(canvas, middle, radius, ink),
    }
    name_entry(canvas, (left, height), entry.name)
}

fn name_entry(canvas: &mut Canvas, (left, height): Point2, name: &str) -> f64 {
    canvas.label(name, (left + 23.0, height), Anchor::Start);
    left + 23.0 + text_width(name, LABEL_SIZE)
}
