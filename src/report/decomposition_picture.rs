//! A frequency-domain decomposition as a picture: singular values over frequency with the bells of the peaks, and how each bell's
//! autocovariance decays, `ln R(τ) = ln R₀ − 2πζ · fτ`: a straight line over cycles, as steep as the damping.

use super::axes::{decades, frame, rule_decades, runs};
use super::lines_picture::{name_peaks, nothing};
use super::style::{
    Anchor, BLACK, BLUE, Canvas, FAINT, GREY, Ink, ORANGE, Panel, SMALL, Stroke, TITLE, WIDTH,
    ink_of, picture,
};

const LEFT: f64 = 70.0;
const TOP: f64 = 76.0;

/// Of the singular values, and of the decays.
const HIGH: f64 = 330.0;
const LOW: f64 = 210.0;

/// From the lower edge of the one to the upper edge of the other.
const BETWEEN: f64 = 66.0;

/// Right of the decays, for what is written of each.
const WORDS: f64 = 190.0;

/// A row of it.
const ROW: f64 = 15.0;

/// A decomposition as plain data.
#[derive(Debug, Clone, Default)]
pub struct Shown {
    /// Above it.
    pub title: String,
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Singular values over these lines, the largest first.
    pub singular_values: Vec<Vec<f64>>,
    /// Labelled peaks: Hz, value, text.
    pub labels: Vec<(f64, f64, String)>,
    /// Bells by rising frequency.
    pub bells: Vec<ShownBell>,
    /// Between these shares of the decay its line is laid.
    pub fitted: (f64, f64),
}

/// A bell and its decay.
#[derive(Debug, Clone, Default)]
pub struct ShownBell {
    /// What is said of it beside the decays.
    pub words: String,
    /// Lines, Hz, and density.
    pub lines: Vec<(f64, f64)>,
    /// Cycles and share left.
    pub decay: Vec<(f64, f64)>,
    /// Natural logarithm at no lag, and its slope per cycle.
    pub line: Option<(f64, f64)>,
}

/// One ink after the other, so that neighbours differ.
fn ink(k: usize) -> Ink {
    [
        ORANGE,
        BLUE,
        ink_of(0x00, 0x80, 0x50),
        ink_of(0x90, 0x30, 0x90),
    ][k % 4]
}

/// Draws it: the decays only where there are some.
pub fn draw(shown: &Shown) -> String {
    let has_decays = shown.bells.iter().any(|b| !b.decay.is_empty());
    let below = if has_decays { BETWEEN + LOW } else { 0.0 };
    picture(WIDTH, TOP + HIGH + below + 52.0, |canvas| {
        canvas.text(&shown.title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let key = match shown.bells.is_empty() {
            true => "black: the largest singular value, grey: the others",
            false => {
                "black: the largest singular value, grey: the others, in colour: the bell of each peak, which has its shape"
            }
        };
        canvas.text(key, (LEFT, 36.0), SMALL, GREY, Anchor::Start);
        singular_values(canvas, shown);
        if has_decays {
            decays(canvas, shown, TOP + HIGH + BETWEEN);
        }
    })
}

fn singular_values(canvas: &mut Canvas, shown: &Shown) {
    let ends = shown.frequency_hz.first().zip(shown.frequency_hz.last());
    let all = shown.singular_values.iter().flatten().copied();
    let (Some((&from, &to)), Some(y)) = (ends.filter(|e| e.0 < e.1), decades(all)) else {
        nothing(canvas, TOP + HIGH / 2.0);
        return;
    };
    let panel = Panel {
        across: (LEFT, WIDTH - 24.0),
        down: (TOP, TOP + HIGH),
        x: (from, to),
        y,
    };
    rule_decades(&panel, canvas);
    frame(&panel, canvas, "singular values", Some("frequency, Hz"));
    for (k, values) in shown.singular_values.iter().enumerate().rev() {
        let points = shown.frequency_hz.iter().zip(values);
        for run in runs(&panel, points.map(|(f, v)| (*f, v.log10()))) {
            let (ink, width) = if k == 0 { (BLACK, 0.9) } else { (GREY, 0.5) };
            canvas.path(&run, ink, width, Stroke::Solid);
        }
    }
    for (k, bell) in shown.bells.iter().enumerate() {
        let points = bell.lines.iter().map(|(f, v)| (*f, v.log10()));
        for run in runs(&panel, points) {
            canvas.path(&run, ink(k), 2.2, Stroke::Solid);
        }
    }
    let logarithm = |(f, v, text): &(f64, f64, String)| (*f, v.log10(), text.clone());
    let labels: Vec<_> = shown.labels.iter().map(logarithm).collect();
    name_peaks(canvas, &panel, &labels);
}

fn decays(canvas: &mut Canvas, shown: &Shown, top: f64) {
    let points = || shown.bells.iter().flat_map(|b| &b.decay);
    let longest = points().map(|p| p.0).fold(0.0, f64::max);
    let Some(y) = decades(points().map(|p| p.1)).filter(|_| longest > 0.0) else {
        return;
    };
    let panel = Panel {
        across: (LEFT, WIDTH - 24.0 - WORDS),
        down: (top, top + LOW),
        x: (0.0, longest),
        y,
    };
    rule_decades(&panel, canvas);
    frame(&panel, canvas, "autocovariance of the bell", Some("cycles"));
    for share in [shown.fitted.0, shown.fitted.1] {
        let ends = [
            panel.at(0.0, share.log10()),
            panel.at(longest, share.log10()),
        ];
        canvas.path(&ends, GREY, 0.8, Stroke::Dotted);
    }
    let right = panel.across.1 + 14.0;
    let rows = ((LOW - ROW) / ROW) as usize;
    let count = shown.bells.len();
    for (k, bell) in shown.bells.iter().enumerate() {
        for &(cycles, share) in bell.decay.iter().filter(|p| p.1.log10() < y.1) {
            canvas.disc(panel.at(cycles, share.log10()), 1.1, ink(k));
        }
        if let Some((start, slope)) = bell.line {
            let decade = |cycles: f64| (start + slope * cycles) / std::f64::consts::LN_10;
            let end = bell.decay.last().map_or(0.0, |p| p.0);
            let line = [(0.0, decade(0.0)), (end, decade(end))];
            for run in runs(&panel, line.into_iter()) {
                canvas.path(&run, ink(k), 0.8, Stroke::Solid);
            }
        }
        let height = top + 8.0 + ROW * k as f64;
        if k < rows {
            canvas.disc((right, height), 3.0, ink(k));
            let spot = (right + 9.0, height);
            canvas.text(&bell.words, spot, SMALL, BLACK, Anchor::Start);
        }
    }
    if count > rows {
        let text = format!("{} more", count - rows);
        let spot = (right + 9.0, top + 8.0 + ROW * rows as f64);
        canvas.text(&text, spot, SMALL, GREY, Anchor::Start);
    }
    let note = "a line is laid through each between the dotted ones";
    let spot = (panel.across.1, panel.down.0 - 8.0);
    canvas.text(note, spot, SMALL, GREY, Anchor::End);
    canvas.line(
        (panel.across.0, panel.down.1),
        (panel.across.1, panel.down.1),
        FAINT,
        0.5,
    );
}
