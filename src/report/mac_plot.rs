//! MAC matrix as a picture, and the pairs of modes as document and table.

use serde_json::{Value, json};

use super::number_format::{percent, significant};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LABEL_SIZE, ORANGE, TITLE_SIZE, WIDTH,
    colour_from_rgb, hertz, render_svg, widest,
};
use super::table::Table;
use crate::plan::logs::identification_result::IdentificationResult;
use crate::plan::logs::mode_comparison::{ModeComparison, SAME_SHAPE_MAC};

/// Largest number of modes along a side.
const MAX_MODES: usize = 40;

/// Sides of a cell; values are printed in cells of the third or more.
const CELL: (f64, f64, f64) = (12.0, 46.0, 27.0);

/// The comparison as in documents.
pub fn json(result: &IdentificationResult, with: &ModeComparison) -> Value {
    let row = |i: usize| (0..with.mac.ncols()).map(|j| with.mac[(i, j)]).collect();
    let pair = |(i, j): (usize, Option<usize>)| {
        let other = &with.reference.modes[j?];
        let (own, other_hz) = (result.modes[i].frequency_hz(), other.frequency_hz);
        Some(
            json!({ "mode": i + 1, "other": other.number, "mac": with.mac[(i, j?)], "frequency_difference": own / other_hz - 1.0 }),
        )
    };
    json!({
        "file": with.reference.file,
        "common": with.common,
        "modes": with.reference.modes.iter().map(|m| json!({ "mode": m.number, "frequency_hz": m.frequency_hz })).collect::<Vec<_>>(),
        "mac": (0..with.mac.nrows()).map(row).collect::<Vec<Vec<f64>>>(),
        "pairs": with.pairs().into_iter().enumerate().filter_map(pair).collect::<Vec<_>>(),
    })
}

/// The pairs as a table.
pub fn text(result: &IdentificationResult, with: &ModeComparison) -> String {
    let mut table = Table::new("mode|frequency [Hz]|other|frequency [Hz]|difference [%]|MAC");
    for (i, j) in with.pairs().into_iter().enumerate() {
        let own = result.modes[i].frequency_hz();
        let mut row = vec![(i + 1).to_string(), significant(own)];
        match j {
            Some(j) => {
                let other = &with.reference.modes[j];
                let apart = own / other.frequency_hz - 1.0;
                row.extend([
                    other.number.to_string(),
                    significant(other.frequency_hz),
                    percent(apart),
                    format!("{:.3}", with.mac[(i, j)]),
                ]);
            }
            None => row.extend(["–"; 4].map(String::from)),
        }
        table.row(row);
    }
    format!(
        "\nmodes of {} with MAC above {SAME_SHAPE_MAC} at {}\n{}",
        with.reference.file,
        with.common.join(", "),
        table.text()
    )
}

/// Draws the matrix.
pub fn draw(result: &IdentificationResult, with: &ModeComparison, title: &str) -> String {
    let rows = result.modes.len().min(MAX_MODES);
    let columns = with.reference.modes.len().min(MAX_MODES);
    let own: Vec<String> = (0..rows)
        .map(|i| format!("{} · {}", i + 1, hertz(result.modes[i].frequency_hz())))
        .collect();
    let others: Vec<String> = (with.reference.modes[..columns].iter())
        .map(|m| format!("{} · {}", m.number, hertz(m.frequency_hz)))
        .collect();
    let left = 44.0 + widest(&own, LABEL_SIZE, 40.0);
    let cell = ((WIDTH - left - 130.0) / columns.max(1) as f64).clamp(CELL.0, CELL.1);
    let top = 64.0 + widest(&others, LABEL_SIZE, 40.0);
    let height = (top + rows as f64 * cell + 28.0).max(top + 150.0);
    render_svg(WIDTH, height, |canvas| {
        canvas.title(title, 24.0);
        let more = |all: usize| match all > MAX_MODES {
            true => format!(", first {MAX_MODES} of {all}"),
            false => String::new(),
        };
        let key = format!(
            "rows: this test{}; columns: {}{}; framed: above {SAME_SHAPE_MAC}",
            more(result.modes.len()),
            with.reference.file,
            more(with.reference.modes.len())
        );
        canvas.note(&key, (24.0, 36.0), Anchor::Start);
        for (i, name) in own.iter().enumerate() {
            let y = top + (i as f64 + 0.5) * cell;
            canvas.label(name, (left - 6.0, y), Anchor::End);
        }
        for (j, name) in others.iter().enumerate() {
            let x = left + (j as f64 + 0.5) * cell;
            canvas.vertical_text(name, (x, top - 6.0), LABEL_SIZE, BLACK, Anchor::Start);
        }
        canvas.upright("this test", (14.0, top + 0.5 * rows as f64 * cell));
        let corner = |i: usize, j: usize| (left + j as f64 * cell, top + i as f64 * cell);
        let cells = || (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
        for (i, j) in cells() {
            let (value, at) = (with.mac[(i, j)], corner(i, j));
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
        for (i, j) in cells().filter(|&at| with.mac[at] > SAME_SHAPE_MAC) {
            canvas.stroke_rect(corner(i, j), corner(i + 1, j + 1), ORANGE, 2.0);
        }
        scale(canvas, (left + columns as f64 * cell + 24.0, top));
    })
}

/// White to blue.
fn shade(value: f64) -> Colour {
    let part = |blue: u8| (255.0 + (f64::from(blue) - 255.0) * value.clamp(0.0, 1.0)).round() as u8;
    colour_from_rgb(part(BLUE.0), part(BLUE.1), part(BLUE.2))
}

/// The scale of colours.
fn scale(canvas: &mut Canvas, (left, top): (f64, f64)) {
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
