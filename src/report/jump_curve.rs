//! Amplitude over speed: stable motions as a line, unstable ones in dashes, folds and bifurcations named, parametric resonances
//! as bands.

use super::axes::{frame, span};
use super::style::{
    Anchor, BLACK, BLUE, Canvas, FAINT, GREY, ORANGE, Panel, SMALL, Spot, Stroke, TITLE, WIDTH,
    picture, push_apart, ticks, width_of,
};

/// What is shown.
#[derive(Debug, Clone, Default)]
pub struct JumpCurve {
    /// Above it.
    pub title: String,
    /// Name of the horizontal axis.
    pub across: String,
    /// Name of the vertical axis.
    pub up: String,
    /// Speed, amplitude and whether it is stable, along the curve.
    pub points: Vec<(f64, f64, bool)>,
    /// Curves beside it, of motions of two periods.
    pub others: Vec<Vec<(f64, f64, bool)>>,
    /// Places with a name: speed, amplitude, text.
    pub marks: Vec<(f64, f64, String)>,
    /// Jumps: speed, from, to.
    pub jumps: Vec<(f64, f64, f64)>,
    /// Bands of speed with a name.
    pub bands: Vec<(f64, f64, String)>,
}

const LEFT: f64 = 78.0;
const TOP: f64 = 76.0;
const HIGH: f64 = 420.0;

/// Draws it.
pub fn jump_curve(shown: &JumpCurve) -> String {
    picture(WIDTH, TOP + HIGH + 52.0, |canvas| {
        canvas.text(&shown.title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        canvas.line((LEFT, 36.0), (LEFT + 22.0, 36.0), BLUE, 1.6);
        canvas.text("stable", (LEFT + 27.0, 36.0), SMALL, BLACK, Anchor::Start);
        canvas.path(
            &[(LEFT + 84.0, 36.0), (LEFT + 106.0, 36.0)],
            ORANGE,
            1.4,
            Stroke::Dashed,
        );
        canvas.text(
            "unstable",
            (LEFT + 111.0, 36.0),
            SMALL,
            BLACK,
            Anchor::Start,
        );
        if !shown.others.is_empty() {
            let words = "thin: motions of two periods";
            canvas.text(words, (LEFT + 190.0, 36.0), SMALL, BLACK, Anchor::Start);
        }
        let all = || shown.points.iter().chain(shown.others.iter().flatten());
        let x = span(all().map(|p| p.0));
        let y = span(all().map(|p| p.1).chain([0.0]));
        let (Some(x), Some(y)) = (x, y) else {
            canvas.text(
                "nothing to show",
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
            x,
            y: (0.0, y.1),
        };
        for (from, to, name) in &shown.bands {
            let (low, high) = (from.max(x.0), to.min(x.1));
            canvas.block(panel.at(low, panel.y.0), panel.at(high, panel.y.1), FAINT);
            let middle = panel.right_of(0.5 * (low + high));
            canvas.text(
                name,
                (middle, TOP + HIGH - 9.0),
                SMALL,
                GREY,
                Anchor::Middle,
            );
        }
        panel.rule_y(canvas, &ticks(panel.y, 6));
        frame(&panel, canvas, &shown.up, Some(&shown.across));
        for &(speed, from, to) in &shown.jumps {
            canvas.path(
                &[panel.at(speed, from), panel.at(speed, to)],
                GREY,
                0.8,
                Stroke::Dotted,
            );
        }
        line_of(canvas, &panel, &shown.points, 1.6);
        for other in &shown.others {
            line_of(canvas, &panel, other, 0.8);
        }
        let wanted: Vec<f64> = shown.marks.iter().map(|m| panel.right_of(m.0)).collect();
        let widest = shown
            .marks
            .iter()
            .map(|m| width_of(&m.2, SMALL))
            .fold(7.0, f64::max);
        let mut order: Vec<usize> = (0..wanted.len()).collect();
        order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]));
        let sorted: Vec<f64> = order.iter().map(|&at| wanted[at]).collect();
        let spread = push_apart(
            &sorted,
            widest + 8.0,
            (LEFT + 0.5 * widest, WIDTH - 24.0 - 0.5 * widest),
        );
        for (&at, right) in order.iter().zip(spread) {
            let (speed, amplitude, text) = &shown.marks[at];
            let spot = panel.at(*speed, *amplitude);
            canvas.line((right, TOP - 4.0), (spot.0, spot.1 - 4.0), FAINT, 0.7);
            canvas.ring(spot, 3.4, BLACK, 1.2);
            canvas.text(text, (right, TOP - 11.0), SMALL, BLACK, Anchor::Middle);
        }
    })
}

/// A curve: stable motions as a line, unstable ones in dashes.
fn line_of(canvas: &mut Canvas, panel: &Panel, points: &[(f64, f64, bool)], width: f64) {
    let mut last: Option<(f64, f64, bool)> = None;
    for run in points.chunk_by(|a, b| a.2 == b.2) {
        // A run begins where the one before it ended, so that the curve has no gap.
        let all = last.iter().chain(run);
        let spots: Vec<Spot> = all.map(|p| panel.at(p.0, p.1)).collect();
        last = run.last().copied();
        match run[0].2 {
            true => canvas.path(&spots, BLUE, width, Stroke::Solid),
            false => canvas.path(&spots, ORANGE, width - 0.2, Stroke::Dashed),
        }
    }
}
