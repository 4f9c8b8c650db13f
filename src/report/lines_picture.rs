//! Spectra as pictures, their lines named.

use super::axes::{decades, frame, rule_decades, runs, span};
use super::style::{
    Anchor, BLACK, BLUE, FAINT, GREY, Ink, ORANGE, Panel, SMALL, Stroke, TITLE, WIDTH, picture,
    push_apart, ticks, width_of,
};

const LEFT: f64 = 70.0;
const HIGH: f64 = 420.0;

/// One spectrum with the names of its lines.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    /// Above it.
    pub title: String,
    /// Name of the horizontal axis.
    pub across: String,
    /// Name of the vertical axis.
    pub up: String,
    /// Curves: label, places, values.
    pub curves: Vec<(String, Vec<f64>, Vec<f64>)>,
    /// Labelled peaks: place, value, text.
    pub labels: Vec<(f64, f64, String)>,
    /// The vertical axis is logarithmic.
    pub logarithmic: bool,
}

/// Draws spectra: power spectral densities, amplitudes, orders, envelopes, cepstra.
pub fn lines(shown: &Lines) -> String {
    const INKS: [Ink; 4] = [BLUE, ORANGE, BLACK, GREY];
    let top = 76.0;
    picture(WIDTH, top + HIGH + 52.0, |canvas| {
        canvas.text(&shown.title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let mut right = LEFT;
        for ((label, ..), ink) in shown.curves.iter().zip(INKS) {
            canvas.line((right, 36.0), (right + 18.0, 36.0), ink, 2.0);
            canvas.text(label, (right + 23.0, 36.0), SMALL, BLACK, Anchor::Start);
            right += 39.0 + width_of(label, SMALL);
        }
        let values = || shown.curves.iter().flat_map(|c| c.2.iter().copied());
        let y = if shown.logarithmic {
            decades(values())
        } else {
            span(values().chain([0.0]))
        };
        let places = || shown.curves.iter().flat_map(|c| c.1.iter().copied());
        let x = places().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), f| {
            (l.min(f), h.max(f))
        });
        let (Some(y), true) = (y, x.0 < x.1) else {
            canvas.text(
                "nothing to show",
                (WIDTH / 2.0, top + HIGH / 2.0),
                TITLE,
                GREY,
                Anchor::Middle,
            );
            return;
        };
        let panel = Panel {
            across: (LEFT, WIDTH - 24.0),
            down: (top, top + HIGH),
            x,
            y,
        };
        match shown.logarithmic {
            true => rule_decades(&panel, canvas),
            false => panel.rule_y(canvas, &ticks(y, 6)),
        }
        frame(&panel, canvas, &shown.up, Some(&shown.across));
        let height = |v: f64| if shown.logarithmic { v.log10() } else { v };
        for ((_, places, values), ink) in shown.curves.iter().zip(INKS) {
            let points = places
                .iter()
                .copied()
                .zip(values.iter().map(|&v| height(v)));
            for run in runs(&panel, points) {
                canvas.path(&run, ink, 0.9, Stroke::Solid);
            }
        }
        let wanted: Vec<f64> = shown.labels.iter().map(|l| panel.right_of(l.0)).collect();
        let widest = shown
            .labels
            .iter()
            .map(|l| width_of(&l.2, 9.0))
            .fold(7.0, f64::max);
        let spread = push_apart(&wanted, widest + 6.0, (LEFT, WIDTH - 24.0));
        for ((place, value, text), right) in shown.labels.iter().zip(spread) {
            let spot = panel.at(*place, height(*value));
            canvas.line((right, top - 4.0), (spot.0, spot.1 - 3.0), FAINT, 0.7);
            canvas.ring(spot, 2.6, BLACK, 1.0);
            canvas.text(text, (right, top - 11.0), 9.0, BLACK, Anchor::Middle);
        }
    })
}
