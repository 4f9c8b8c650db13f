//! Frequency-domain decomposition plot: singular values, SDOF bells, autocovariance decay.

use super::axes::{clip_to_panel, draw_curve, draw_frame, draw_log_grid, log_range};
use super::spectrum_plot::{draw_empty_note, name_peaks};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LIGHT_GREY, LineStyle, ORANGE, Panel, WIDTH,
    colour_from_rgb, render_svg,
};

const MARGIN_LEFT: f64 = 70.0;
const MARGIN_TOP: f64 = 76.0;

/// Height of the panels of singular values and of decays.
const HEIGHT: f64 = 330.0;
const LOW: f64 = 210.0;

/// From the lower edge of the one to the upper edge of the other.
const SPACING: f64 = 66.0;

/// Right of the decays, for what is written of each.
const WORDS: f64 = 190.0;

/// A row of it.
const ROW_HEIGHT: f64 = 15.0;

/// A decomposition as plain data.
#[derive(Debug, Clone, Default)]
pub struct FddPlot {
    /// Above it.
    pub title: String,
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Singular values over these lines, the largest first.
    pub singular_values: Vec<Vec<f64>>,
    /// Labelled peaks: Hz, value, text.
    pub labels: Vec<(f64, f64, String)>,
    /// Bells by rising frequency.
    pub bells: Vec<PlottedBell>,
    /// Between these shares of the decay its line is laid.
    pub fitted: (f64, f64),
}

/// A bell and its decay.
#[derive(Debug, Clone, Default)]
pub struct PlottedBell {
    /// Annotation next to the decays.
    pub words: String,
    /// Lines, Hz, and density.
    pub lines: Vec<(f64, f64)>,
    /// Cycles and share left.
    pub decay: Vec<(f64, f64)>,
    /// Natural logarithm at no lag, and its slope per cycle.
    pub line: Option<(f64, f64)>,
}

/// One ink after the other, so that neighbours differ.
fn ink(k: usize) -> Colour {
    [
        ORANGE,
        BLUE,
        colour_from_rgb(0x00, 0x80, 0x50),
        colour_from_rgb(0x90, 0x30, 0x90),
    ][k % 4]
}

/// Draws it: the decays only where there are some.
pub fn draw(shown: &FddPlot) -> String {
    let has_decays = shown.bells.iter().any(|b| !b.decay.is_empty());
    let below = if has_decays { SPACING + LOW } else { 0.0 };
    render_svg(WIDTH, MARGIN_TOP + HEIGHT + below + 52.0, |canvas| {
        canvas.title(&shown.title, MARGIN_LEFT);
        let key = match shown.bells.is_empty() {
            true => "black: the largest singular value, grey: the others",
            false => {
                "black: the largest singular value, grey: the others, in colour: the bell of each peak, which has its shape"
            }
        };
        canvas.note(key, (MARGIN_LEFT, 36.0), Anchor::Start);
        singular_values(canvas, shown);
        if has_decays {
            decays(canvas, shown, MARGIN_TOP + HEIGHT + SPACING);
        }
    })
}

fn singular_values(canvas: &mut Canvas, shown: &FddPlot) {
    let ends = shown.frequency_hz.first().zip(shown.frequency_hz.last());
    let all = shown.singular_values.iter().flatten().copied();
    let (Some((&from, &to)), Some(y)) = (ends.filter(|e| e.0 < e.1), log_range(all)) else {
        draw_empty_note(canvas, MARGIN_TOP + HEIGHT / 2.0);
        return;
    };
    let panel = Panel::new(
        (MARGIN_LEFT, WIDTH - 24.0),
        (MARGIN_TOP, MARGIN_TOP + HEIGHT),
        (from, to),
        y,
    );
    draw_log_grid(&panel, canvas);
    draw_frame(&panel, canvas, "singular values", Some("frequency, Hz"));
    for (k, values) in shown.singular_values.iter().enumerate().rev() {
        let points = shown.frequency_hz.iter().zip(values);
        for run in clip_to_panel(&panel, points.map(|(f, v)| (*f, v.log10()))) {
            let (ink, width) = if k == 0 { (BLACK, 0.9) } else { (GREY, 0.5) };
            canvas.polyline(&run, ink, width, LineStyle::Solid);
        }
    }
    for (k, bell) in shown.bells.iter().enumerate() {
        let points = bell.lines.iter().map(|(f, v)| (*f, v.log10()));
        draw_curve(canvas, &panel, points, ink(k), 2.2);
    }
    let logarithm = |(f, v, text): &(f64, f64, String)| (*f, v.log10(), text.clone());
    let labels: Vec<_> = shown.labels.iter().map(logarithm).collect();
    name_peaks(canvas, &panel, &labels);
}

fn decays(canvas: &mut Canvas, shown: &FddPlot, top: f64) {
    let points = || shown.bells.iter().flat_map(|b| &b.decay);
    let longest = points().map(|p| p.0).fold(0.0, f64::max);
    let Some(y) = log_range(points().map(|p| p.1)).filter(|_| longest > 0.0) else {
        return;
    };
    let panel = Panel::new(
        (MARGIN_LEFT, WIDTH - 24.0 - WORDS),
        (top, top + LOW),
        (0.0, longest),
        y,
    );
    draw_log_grid(&panel, canvas);
    draw_frame(&panel, canvas, "autocovariance of the bell", Some("cycles"));
    for share in [shown.fitted.0, shown.fitted.1] {
        let ends = [
            panel.to_canvas(0.0, share.log10()),
            panel.to_canvas(longest, share.log10()),
        ];
        canvas.polyline(&ends, GREY, 0.8, LineStyle::Dotted);
    }
    let right = panel.across.1 + 14.0;
    let rows = ((LOW - ROW_HEIGHT) / ROW_HEIGHT) as usize;
    let count = shown.bells.len();
    for (k, bell) in shown.bells.iter().enumerate() {
        for &(cycles, share) in bell.decay.iter().filter(|p| p.1.log10() < y.1) {
            canvas.fill_circle(panel.to_canvas(cycles, share.log10()), 1.1, ink(k));
        }
        if let Some((start, slope)) = bell.line {
            let decade = |cycles: f64| (start + slope * cycles) / std::f64::consts::LN_10;
            let end = bell.decay.last().map_or(0.0, |p| p.0);
            let line = [(0.0, decade(0.0)), (end, decade(end))];
            draw_curve(canvas, &panel, line.into_iter(), ink(k), 0.8);
        }
        let height = top + 8.0 + ROW_HEIGHT * k as f64;
        if k < rows {
            canvas.fill_circle((right, height), 3.0, ink(k));
            let spot = (right + 9.0, height);
            canvas.label(&bell.words, spot, Anchor::Start);
        }
    }
    if count > rows {
        let text = format!("{} more", count - rows);
        let spot = (right + 9.0, top + 8.0 + ROW_HEIGHT * rows as f64);
        canvas.note(&text, spot, Anchor::Start);
    }
    let note = "a line is laid through each between the dotted ones";
    let spot = (panel.across.1, panel.down.0 - 8.0);
    canvas.note(note, spot, Anchor::End);
    canvas.line(
        (panel.across.0, panel.down.1),
        (panel.across.1, panel.down.1),
        LIGHT_GREY,
        0.5,
    );
}
