//! Amplitude over speed: stable and unstable branches, folds, bifurcations, parametric bands.

use super::axes::{draw_frame, linear_range};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, GREY, LABEL_SIZE, LIGHT_GREY, LineStyle, ORANGE, Panel, Point2,
    WIDTH, render_svg, spread_labels, ticks, widest,
};

/// Contents of an amplitude plot.
#[derive(Debug, Clone, Default)]
pub struct AmplitudePlot {
    /// Above it.
    pub title: String,
    /// Name of the horizontal axis.
    pub across: String,
    /// Name of the vertical axis.
    pub up: String,
    /// Speed, amplitude and whether it is stable, along the curve.
    pub points: Vec<(f64, f64, bool)>,
    /// Curves next to it, of motions of two periods.
    pub others: Vec<Vec<(f64, f64, bool)>>,
    /// Places with a name: speed, amplitude, text.
    pub marks: Vec<(f64, f64, String)>,
    /// Jumps: speed, from, to.
    pub jumps: Vec<(f64, f64, f64)>,
    /// Bands of speed with a name.
    pub bands: Vec<(f64, f64, String)>,
}

const MARGIN_LEFT: f64 = 78.0;
const MARGIN_TOP: f64 = 76.0;
const HEIGHT: f64 = 420.0;

/// Draws it.
pub fn draw_amplitude(shown: &AmplitudePlot) -> String {
    render_svg(WIDTH, MARGIN_TOP + HEIGHT + 52.0, |canvas| {
        canvas.title(&shown.title, MARGIN_LEFT);
        canvas.line((MARGIN_LEFT, 36.0), (MARGIN_LEFT + 22.0, 36.0), BLUE, 1.6);
        canvas.label("stable", (MARGIN_LEFT + 27.0, 36.0), Anchor::Start);
        canvas.polyline(
            &[(MARGIN_LEFT + 84.0, 36.0), (MARGIN_LEFT + 106.0, 36.0)],
            ORANGE,
            1.4,
            LineStyle::Dashed,
        );
        canvas.label("unstable", (MARGIN_LEFT + 111.0, 36.0), Anchor::Start);
        if !shown.others.is_empty() {
            let words = "thin: motions of two periods";
            canvas.label(words, (MARGIN_LEFT + 190.0, 36.0), Anchor::Start);
        }
        let all = || shown.points.iter().chain(shown.others.iter().flatten());
        let x = linear_range(all().map(|p| p.0));
        let y = linear_range(all().map(|p| p.1).chain([0.0]));
        let (Some(x), Some(y)) = (x, y) else {
            canvas.placeholder("nothing to show", (WIDTH / 2.0, MARGIN_TOP + HEIGHT / 2.0));
            return;
        };
        let panel = Panel::new(
            (MARGIN_LEFT, WIDTH - 24.0),
            (MARGIN_TOP, MARGIN_TOP + HEIGHT),
            x,
            (0.0, y.1),
        );
        for (from, to, name) in &shown.bands {
            let (low, high) = (from.max(x.0), to.min(x.1));
            canvas.fill_rect(
                panel.to_canvas(low, panel.y.0),
                panel.to_canvas(high, panel.y.1),
                LIGHT_GREY,
            );
            let middle = panel.canvas_x(0.5 * (low + high));
            canvas.note(name, (middle, MARGIN_TOP + HEIGHT - 9.0), Anchor::Middle);
        }
        panel.draw_y_grid(canvas, &ticks(panel.y, 6));
        draw_frame(&panel, canvas, &shown.up, Some(&shown.across));
        for &(speed, from, to) in &shown.jumps {
            canvas.polyline(
                &[panel.to_canvas(speed, from), panel.to_canvas(speed, to)],
                GREY,
                0.8,
                LineStyle::Dotted,
            );
        }
        line_of(canvas, &panel, &shown.points, 1.6);
        for other in &shown.others {
            line_of(canvas, &panel, other, 0.8);
        }
        let wanted: Vec<f64> = shown.marks.iter().map(|m| panel.canvas_x(m.0)).collect();
        let widest = widest(shown.marks.iter().map(|m| &m.2), LABEL_SIZE, 7.0);
        let mut order: Vec<usize> = (0..wanted.len()).collect();
        order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]));
        let sorted: Vec<f64> = order.iter().map(|&at| wanted[at]).collect();
        let spread = spread_labels(
            &sorted,
            widest + 8.0,
            (MARGIN_LEFT + 0.5 * widest, WIDTH - 24.0 - 0.5 * widest),
        );
        for (&at, right) in order.iter().zip(spread) {
            let (speed, amplitude, text) = &shown.marks[at];
            let spot = panel.to_canvas(*speed, *amplitude);
            canvas.line(
                (right, MARGIN_TOP - 4.0),
                (spot.0, spot.1 - 4.0),
                LIGHT_GREY,
                0.7,
            );
            canvas.stroke_circle(spot, 3.4, BLACK, 1.2);
            canvas.label(text, (right, MARGIN_TOP - 11.0), Anchor::Middle);
        }
    })
}

/// A curve: stable motions as a line, unstable ones in dashes.
fn line_of(canvas: &mut Canvas, panel: &Panel, points: &[(f64, f64, bool)], width: f64) {
    let mut last: Option<(f64, f64, bool)> = None;
    for run in points.chunk_by(|a, b| a.2 == b.2) {
        // A run begins where the one before it ended, so that the curve has no gap.
        let all = last.iter().chain(run);
        let spots: Vec<Point2> = all.map(|p| panel.to_canvas(p.0, p.1)).collect();
        last = run.last().copied();
        match run[0].2 {
            true => canvas.polyline(&spots, BLUE, width, LineStyle::Solid),
            false => canvas.polyline(&spots, ORANGE, width - 0.2, LineStyle::Dashed),
        }
    }
}
