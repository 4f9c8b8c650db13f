//! Poles as pictures: in the complex plane with zeros, and over the order of the model.

use super::axes::{decades, frame, runs, span};
use super::style::{
    Anchor, BLACK, BLUE, Canvas, FAINT, GREY, ORANGE, Panel, SMALL, Stroke, TITLE, WIDTH, picture,
    ticks,
};
use crate::numeric::Complex;

const LEFT: f64 = 70.0;
const HIGH: f64 = 420.0;
const TOP: f64 = 52.0;

/// Poles (crosses) and zeros (rings), upper half plane, rad/s.
pub fn pole_zero(title: &str, poles: &[Complex], zeros: &[Complex]) -> String {
    picture(WIDTH, TOP + HIGH + 52.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        canvas.text(
            "crosses: poles, rings: zeros",
            (WIDTH - 24.0, 16.0),
            SMALL,
            GREY,
            Anchor::End,
        );
        let upper: Vec<Complex> = zeros.iter().copied().filter(|z| z.im >= 0.0).collect();
        // Zeros far off would leave the poles in a corner.
        let reach = poles.iter().fold(0.0f64, |m, p| m.max(p.norm()));
        let near: Vec<Complex> = upper
            .iter()
            .copied()
            .filter(|z| z.norm() <= 1.5 * reach)
            .collect();
        let all = || poles.iter().chain(&near);
        let (Some(re), Some(im)) = (
            span(all().map(|z| z.re).chain([0.0])),
            span(all().map(|z| z.im).chain([0.0])),
        ) else {
            canvas.text(
                "no poles",
                (WIDTH / 2.0, TOP + HIGH / 2.0),
                TITLE,
                GREY,
                Anchor::Middle,
            );
            return;
        };
        let panel = Panel {
            across: (LEFT, WIDTH - 24.0),
            down: (TOP, TOP + HIGH),
            x: re,
            y: im,
        };
        panel.rule_y(canvas, &ticks(im, 6));
        frame(
            &panel,
            canvas,
            "imaginary part, rad/s",
            Some("real part, rad/s"),
        );
        let axis = panel.right_of(0.0);
        canvas.line((axis, panel.down.0), (axis, panel.down.1), GREY, 0.8);
        for z in &near {
            canvas.ring(panel.at(z.re, z.im), 4.0, ORANGE, 1.4);
        }
        for p in poles {
            cross(canvas, panel.at(p.re, p.im), 4.5);
        }
        let far = upper.len() - near.len();
        if far > 0 {
            let text = format!("{far} zeros further off");
            canvas.text(&text, (WIDTH - 24.0, 36.0), SMALL, GREY, Anchor::End);
        }
    })
}

fn cross(canvas: &mut Canvas, (x, y): (f64, f64), r: f64) {
    canvas.line((x - r, y - r), (x + r, y + r), BLUE, 1.4);
    canvas.line((x - r, y + r), (x + r, y - r), BLUE, 1.4);
}

/// How a pole of one order compares with those of the order before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Steadiness {
    /// Frequency, damping and shape agree.
    Stable,
    /// The frequency agrees.
    Frequency,
    /// Nothing agrees.
    New,
}

/// A stabilisation diagram as plain data.
#[derive(Debug, Clone, Default)]
pub struct Stabilisation {
    /// Above it.
    pub title: String,
    /// Poles: order, frequency Hz, how steady.
    pub poles: Vec<(usize, f64, Steadiness)>,
    /// Frequencies selected, Hz.
    pub selected_hz: Vec<f64>,
    /// Lines behind, Hz, and the level drawn over them.
    pub level: (Vec<f64>, Vec<f64>),
    /// The band, Hz.
    pub band_hz: (f64, f64),
}

/// Draws a stabilisation diagram.
pub fn stabilisation(shown: &Stabilisation) -> String {
    picture(WIDTH, TOP + HIGH + 52.0, |canvas| {
        canvas.text(&shown.title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let key = "discs: stable, rings: frequency only, dots: new, dotted: selected";
        canvas.text(key, (LEFT, 36.0), SMALL, GREY, Anchor::Start);
        let highest = shown.poles.iter().map(|p| p.0).max().unwrap_or(1);
        let panel = Panel {
            across: (LEFT, WIDTH - 24.0),
            down: (TOP, TOP + HIGH),
            x: shown.band_hz,
            y: (0.0, highest as f64 + 1.0),
        };
        let orders: Vec<f64> = ticks((0.0, highest as f64), 8)
            .into_iter()
            .filter(|t| t.fract() == 0.0)
            .collect();
        panel.rule_y(canvas, &orders);
        frame(&panel, canvas, "order", Some("frequency, Hz"));
        if let Some(y) = decades(shown.level.1.iter().copied()) {
            let behind = Panel { y, ..panel };
            let points = shown
                .level
                .0
                .iter()
                .copied()
                .zip(shown.level.1.iter().map(|v| v.log10()));
            for run in runs(&behind, points) {
                canvas.path(&run, FAINT, 1.6, Stroke::Solid);
            }
        }
        for &f in shown
            .selected_hz
            .iter()
            .filter(|f| (shown.band_hz.0..=shown.band_hz.1).contains(f))
        {
            let right = panel.right_of(f);
            canvas.path(
                &[(right, panel.down.0), (right, panel.down.1)],
                BLUE,
                0.8,
                Stroke::Dotted,
            );
        }
        for &(order, f, steadiness) in &shown.poles {
            if !(shown.band_hz.0..=shown.band_hz.1).contains(&f) {
                continue;
            }
            let spot = panel.at(f, order as f64);
            match steadiness {
                Steadiness::Stable => canvas.disc(spot, 2.4, BLUE),
                Steadiness::Frequency => canvas.ring(spot, 2.4, ORANGE, 1.0),
                Steadiness::New => canvas.disc(spot, 0.9, GREY),
            }
        }
    })
}
