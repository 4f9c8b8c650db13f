//! MAC matrix as a figure, and the pairs of modes as JSON and as a table.

use serde_json::{Value, json};

use super::number_format::{percent, significant};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LABEL_SIZE, ORANGE, TITLE_SIZE, WIDTH,
    colour_from_rgb, hertz, render_svg, widest,
};
use super::table::Table;
use crate::plan::logs::identification_result::IdentificationResult;
use crate::plan::logs::mode_comparison::{ModeComparison, SAME_SHAPE_MAC};

/// Maximum number of modes along a side.
const MAX_MODES: usize = 40;

/// Cell side, points: minimum, maximum, and minimum for printed values.
const CELL: (f64, f64, f64) = (12.0, 46.0, 27.0);

/// Mode comparison for the JSON document.
pub fn json(result: &IdentificationResult, comparison: &ModeComparison) -> Value {
    let (mac, modes) = (&comparison.mac, &comparison.reference.modes);
    let row = |i: usize| (0..mac.ncols()).map(|j| mac[(i, j)]).collect();
    let pair = |(i, j): (usize, Option<usize>)| {
        let (mode_hz, other) = (result.modes[i].frequency_hz(), &modes[j?]);
        Some(
            json!({ "mode": i + 1, "other": other.number, "mac": mac[(i, j?)], "frequency_difference": mode_hz / other.frequency_hz - 1.0 }),
        )
    };
    json!({
        "file": comparison.reference.file,
        "common": comparison.common,
        "modes": modes.iter().map(|m| json!({ "mode": m.number, "frequency_hz": m.frequency_hz })).collect::<Vec<_>>(),
        "mac": (0..mac.nrows()).map(row).collect::<Vec<Vec<f64>>>(),
        "pairs": comparison.pairs().into_iter().enumerate().filter_map(pair).collect::<Vec<_>>(),
    })
}

/// Table of the paired modes.
pub fn text(result: &IdentificationResult, comparison: &ModeComparison) -> String {
    let mut table = Table::new("mode|frequency [Hz]|other|frequency [Hz]|difference [%]|MAC");
    for (i, j) in comparison.pairs().into_iter().enumerate() {
        let mode_hz = result.modes[i].frequency_hz();
        let mut row = vec![(i + 1).to_string(), significant(mode_hz)];
        match j {
            Some(j) => {
                let other = &comparison.reference.modes[j];
                let difference = mode_hz / other.frequency_hz - 1.0;
                row.extend([
                    other.number.to_string(),
                    significant(other.frequency_hz),
                    percent(difference),
                    format!("{:.3}", comparison.mac[(i, j)]),
                ]);
            }
            None => row.extend(["–"; 4].map(String::from)),
        }
        table.row(row);
    }
    format!(
        "\nmodes of {} with MAC above {SAME_SHAPE_MAC} at {}\n{}",
        comparison.reference.file,
        comparison.common.join(", "),
        table.text()
    )
}

/// Draws the MAC matrix.
pub fn draw(result: &IdentificationResult, comparison: &ModeComparison, title: &str) -> String {
    let rows = result.modes.len().min(MAX_MODES);
    let columns = comparison.reference.modes.len().min(MAX_MODES);
    let labels: Vec<String> = (0..rows)
        .map(|i| format!("{} · {}", i + 1, hertz(result.modes[i].frequency_hz())))
        .collect();
    let other_labels: Vec<String> = (comparison.reference.modes[..columns].iter())
        .map(|m| format!("{} · {}", m.number, hertz(m.frequency_hz)))
        .collect();
    let left = 44.0 + widest(&labels, LABEL_SIZE, 40.0);
    let cell = ((WIDTH - left - 130.0) / columns.max(1) as f64).clamp(CELL.0, CELL.1);
    let top = 64.0 + widest(&other_labels, LABEL_SIZE, 40.0);
    let height = (top + rows as f64 * cell + 28.0).max(top + 150.0);
    render_svg(WIDTH, height, |canvas| {
        canvas.title(title, 24.0);
        let limit_note = |all: usize| match all > MAX_MODES {
            true => format!(", first {MAX_MODES} of {all}"),
            false => String::new(),
        };
        let key = format!(
            "rows: this test{}; columns: {}{}; framed: above {SAME_SHAPE_MAC}",
            limit_note(result.modes.len()),
            comparison.reference.file,
            limit_note(comparison.reference.modes.len())
        );
        canvas.note(&key, (24.0, 36.0), Anchor::Start);
        for (i, name) in labels.iter().enumerate() {
            let y = top + (i as f64 + 0.5) * cell;
            canvas.label(name, (left - 6.0, y), Anchor::End);
        }
        for (j, name) in other_labels.iter().enumerate() {
            let x = left + (j as f64 + 0.5) * cell;
            canvas.vertical_text(name, (x, top - 6.0), LABEL_SIZE, BLACK, Anchor::Start);
        }
        canvas.upright("this test", (14.0, top + 0.5 * rows as f64 * cell));
        let corner = |i: usize, j: usize| (left + j as f64 * cell, top + i as f64 * cell);
        let cells = || (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
        for (i, j) in cells() {
            let (value, at) = (comparison.mac[(i, j)], corner(i, j));
            canvas.fill_rect(at, (at.0 + cell, at.1 + cell), shade(value));
            if cell >= CELL.2 {
                let ink = if value > 0.55 { shade(0.0) } else { BLACK };
                let middle = (at.0 + 0.5 * cell, at.1 + 0.5 * cell);
                canvas.text(
                    &format!("{value:.2}"),
                    middle,
                    LABEL_SIZE - 1.0,
                    ink,
                    Anchor::Middle,
                );
            }
        }
        canvas.stroke_rect(corner(0, 0), corner(rows, columns), GREY, 0.6);
        for (i, j) in cells().filter(|&at| comparison.mac[at] > SAME_SHAPE_MAC) {
            canvas.stroke_rect(corner(i, j), corner(i + 1, j + 1), ORANGE, 2.0);
        }
        draw_scale(canvas, (left + columns as f64 * cell + 24.0, top));
    })
}

/// Colour of a MAC value, from white at 0 to blue at 1.
fn shade(value: f64) -> Colour {
    let mix = |blue: u8| (255.0 + (f64::from(blue) - 255.0) * value.clamp(0.0, 1.0)).round() as u8;
    colour_from_rgb(mix(BLUE.0), mix(BLUE.1), mix(BLUE.2))
}

/// Draws the colour scale.
fn draw_scale(canvas: &mut Canvas, (left, top): (f64, f64)) {
    const STEPS: usize = 20;
    const HEIGHT: f64 = 120.0;
    const BAR: f64 = 14.0;
    canvas.text("MAC", (left, top - 12.0), TITLE_SIZE, BLACK, Anchor::Start);
    let height = |value: f64| top + HEIGHT * (1.0 - value);
    for k in 0..STEPS {
        let ends = [k, k + 1].map(|k| k as f64 / STEPS as f64);
        let middle = 0.5 * (ends[0] + ends[1]);
        canvas.fill_rect(
            (left, height(ends[1])),
            (left + BAR, height(ends[0])),
            shade(middle),
        );
    }
    canvas.stroke_rect((left, top), (left + BAR, top + HEIGHT), GREY, 0.6);
    for value in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
        canvas.label(
            &format!("{value:.1}"),
            (left + BAR + 5.0, height(value)),
            Anchor::Start,
        );
    }
}
