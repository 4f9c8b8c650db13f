//! Poles as plots: in the complex plane with zeros, and over the order of the model.

use super::axes::{draw_curve, draw_frame, linear_range, log_range};
use super::svg::{Anchor, BLUE, Canvas, GREY, LIGHT_GREY, ORANGE, Panel, WIDTH, render_svg, ticks};
use crate::numeric::Complex;

const MARGIN_LEFT: f64 = 70.0;
const HEIGHT: f64 = 420.0;
const MARGIN_TOP: f64 = 52.0;

/// Poles (crosses) and zeros (rings), upper half plane, rad/s.
pub fn pole_zero(title: &str, poles: &[Complex], zeros: &[Complex]) -> String {
    render_svg(WIDTH, MARGIN_TOP + HEIGHT + 52.0, |canvas| {
        canvas.title(title, MARGIN_LEFT);
        canvas.note(
            "crosses: poles, rings: zeros",
            (WIDTH - 24.0, 16.0),
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
            linear_range(all().map(|z| z.re).chain([0.0])),
            linear_range(all().map(|z| z.im).chain([0.0])),
        ) else {
            canvas.placeholder("no poles", (WIDTH / 2.0, MARGIN_TOP + HEIGHT / 2.0));
            return;
        };
        let panel = Panel::new(
            (MARGIN_LEFT, WIDTH - 24.0),
            (MARGIN_TOP, MARGIN_TOP + HEIGHT),
            re,
            im,
        );
        panel.draw_y_grid(canvas, &ticks(im, 6));
        draw_frame(
            &panel,
            canvas,
            "imaginary part, rad/s",
            Some("real part, rad/s"),
        );
        let axis = panel.canvas_x(0.0);
        panel.draw_vertical(canvas, axis, GREY, 0.8);
        for z in &near {
            canvas.stroke_circle(panel.to_canvas(z.re, z.im), 4.0, ORANGE, 1.4);
        }
        for p in poles {
            cross(canvas, panel.to_canvas(p.re, p.im), 4.5);
        }
        let far = upper.len() - near.len();
        if far > 0 {
            let text = format!("{far} zeros further off");
            canvas.note(&text, (WIDTH - 24.0, 36.0), Anchor::End);
        }
    })
}

fn cross(canvas: &mut Canvas, (x, y): (f64, f64), r: f64) {
    canvas.line((x - r, y - r), (x + r, y + r), BLUE, 1.4);
    canvas.line((x - r, y + r), (x + r, y - r), BLUE, 1.4);
}

/// Stability of a pole of one order relative to those of the order before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlottedStability {
    /// Frequency, damping and shape agree.
    Stable,
    /// The frequency agrees.
    Frequency,
    /// Nothing agrees.
    New,
}

/// A stabilisation diagram as plain data.
#[derive(Debug, Clone, Default)]
pub struct StabilisationPlot {
    /// Above it.
    pub title: String,
    /// Poles: order, frequency Hz, how steady.
    pub poles: Vec<(usize, f64, PlottedStability)>,
    /// Frequencies selected, Hz.
    pub selected_hz: Vec<f64>,
    /// Lines behind, Hz, and the level drawn over them.
    pub level: (Vec<f64>, Vec<f64>),
    /// The band, Hz.
    pub band_hz: (f64, f64),
}

/// Draws a stabilisation diagram.
pub fn stabilisation(shown: &StabilisationPlot) -> String {
    render_svg(WIDTH, MARGIN_TOP + HEIGHT + 52.0, |canvas| {
        canvas.title(&shown.title, MARGIN_LEFT);
        let key = "discs: stable, rings: frequency only, dots: new, dotted: selected";
        canvas.note(key, (MARGIN_LEFT, 36.0), Anchor::Start);
        let highest = shown.poles.iter().map(|p| p.0).max().unwrap_or(1);
        let panel = Panel::new(
            (MARGIN_LEFT, WIDTH - 24.0),
            (MARGIN_TOP, MARGIN_TOP + HEIGHT),
            shown.band_hz,
            (0.0, highest as f64 + 1.0),
        );
        let orders: Vec<f64> = ticks((0.0, highest as f64), 8)
            .into_iter()
            .filter(|t| t.fract() == 0.0)
            .collect();
        panel.draw_y_grid(canvas, &orders);
        draw_frame(&panel, canvas, "order", Some("frequency, Hz"));
        if let Some(y) = log_range(shown.level.1.iter().copied()) {
            let behind = Panel { y, ..panel };
            let points = shown
                .level
                .0
                .iter()
                .copied()
                .zip(shown.level.1.iter().map(|v| v.log10()));
            draw_curve(canvas, &behind, points, LIGHT_GREY, 1.6);
        }
        for &f in shown
            .selected_hz
            .iter()
            .filter(|f| (shown.band_hz.0..=shown.band_hz.1).contains(f))
        {
            let right = panel.canvas_x(f);
            panel.draw_dotted(canvas, right, BLUE, 0.8);
        }
        for &(order, f, steadiness) in &shown.poles {
            if !(shown.band_hz.0..=shown.band_hz.1).contains(&f) {
                continue;
            }
            let spot = panel.to_canvas(f, order as f64);
            match steadiness {
                PlottedStability::Stable => canvas.fill_circle(spot, 2.4, BLUE),
                PlottedStability::Frequency => canvas.stroke_circle(spot, 2.4, ORANGE, 1.0),
                PlottedStability::New => canvas.fill_circle(spot, 0.9, GREY),
            }
        }
    })
}
