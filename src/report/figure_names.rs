//! Names of curves and points of a plot of an SVG file.

use super::axes::clip_to_panel;
use super::figure::{Curve, Ink, Mark, NamePlacement, Plot};
use super::figure_marks::colour;
use super::label_placement::{Frame, place_labels};
use super::svg::{
    Anchor, BLACK, Canvas, LABEL_SIZE, LIGHT_GREY, Panel, Point2, spread_labels, text_width,
};

/// Size of the names of points.
pub(super) const SMALL: f64 = 9.0;

/// Above a plot with names of points, where they are not upright.
pub(super) const LABEL_ROW: f64 = 24.0;

/// The end of a curve with its name.
pub(super) struct EndName<'a> {
    pub(super) name: &'a str,
    ink: Ink,
    x: f64,
    y: f64,
    pub(super) leaves_at_top: bool,
}

/// Ends of the curves of a plot that names them there.
pub(super) fn end_names(plot: &Plot) -> Vec<EndName<'_>> {
    if plot.names == NamePlacement::Key {
        return Vec::new();
    }
    let top = plot.y.range.map(|range| range.1);
    let end = |curve: &'_ Curve| {
        let points = curve.x.iter().zip(&curve.y);
        let last = points.rev().find(|p| p.0.is_finite() && p.1.is_finite());
        last.map(|(&x, &y)| (x, y))
    };
    let named = plot.curves.iter().filter(|c| !c.name.is_empty());
    named
        .filter_map(|curve| {
            let (x, y) = end(curve)?;
            Some(EndName {
                name: &curve.name,
                ink: curve.ink,
                x,
                y,
                leaves_at_top: top.is_some_and(|top| y >= top * (1.0 - 1e-9)),
            })
        })
        .collect()
}

/// Names curves at their ends, right of the panel or above it, none over another, each led to its curve.
pub(super) fn name_ends(canvas: &mut Canvas, panel: &Panel, plot: &Plot) {
    let all = end_names(plot);
    let spot = |end: &EndName| {
        let y = plot.y.position(end.y).clamp(panel.y.0, panel.y.1);
        panel.to_canvas(plot.x.position(end.x), y)
    };
    let (above, right): (Vec<&EndName>, Vec<&EndName>) = all.iter().partition(|e| e.leaves_at_top);
    let wanted: Vec<f64> = right.iter().map(|end| spot(end).1).collect();
    for (end, height) in right
        .iter()
        .zip(spread_labels(&wanted, LABEL_SIZE + 2.5, panel.down))
    {
        let (side, ink) = (panel.across.1 + 14.0, colour(end.ink));
        canvas.line(spot(end), (side - 3.0, height), LIGHT_GREY, 0.7);
        canvas.text(end.name, (side, height), LABEL_SIZE, ink, Anchor::Start);
    }
    let wanted: Vec<f64> = above.iter().map(|end| spot(end).0).collect();
    for (end, x) in above
        .iter()
        .zip(spread_labels(&wanted, LABEL_SIZE + 2.0, panel.across))
    {
        let (foot, ink) = ((x, panel.down.0 - 10.0), colour(end.ink));
        canvas.line(spot(end), foot, ink, 0.5);
        canvas.vertical_text(end.name, (x, foot.1 - 2.0), LABEL_SIZE, ink, Anchor::Start);
    }
}

/// Names points upright above a panel: positions on both axes, text. On a map the points below its upper edge are named at the right end.
pub(super) fn name_upright(
    canvas: &mut Canvas,
    panel: &Panel,
    labels: &[(f64, f64, String)],
    is_map: bool,
) {
    let top = panel.down.0;
    let leaves = |l: &&(f64, f64, String)| !is_map || panel.canvas_y(l.1) <= top + 2.0;
    let (labels, inside): (Vec<_>, Vec<_>) = labels.iter().partition(leaves);
    let heights: Vec<f64> = inside.iter().map(|l| panel.canvas_y(l.1) - 7.0).collect();
    let room = (top + 8.0, panel.down.1 - 8.0);
    for (label, height) in inside
        .iter()
        .zip(spread_labels(&heights, SMALL + 3.0, room))
    {
        let right = panel.across.1 - 5.0;
        let left = right - text_width(&label.2, SMALL);
        name_on_map(canvas, &label.2, (left, height));
    }
    let wanted: Vec<f64> = labels.iter().map(|l| panel.canvas_x(l.0)).collect();
    for ((x, y, text), right) in labels
        .iter()
        .zip(spread_labels(&wanted, 13.0, panel.across))
    {
        let head = panel.to_canvas(*x, *y);
        canvas.line((right, top - 4.0), (head.0, head.1 - 3.0), LIGHT_GREY, 0.7);
        canvas.vertical_text(text, (right, top - 7.0), SMALL, BLACK, Anchor::Start);
    }
}

/// A name on dark ground, so that it can be read on any level of a map, from its left end.
pub(super) fn name_on_map(canvas: &mut Canvas, text: &str, (left, height): Point2) {
    if text.is_empty() {
        return;
    }
    let half = 0.5 * SMALL + 1.0;
    let right = left + text_width(text, SMALL);
    canvas.fill_rect(
        (left - 1.0, height - half),
        (right + 1.0, height + half),
        BLACK,
    );
    let middle = (0.5 * (left + right), height);
    canvas.text(text, middle, SMALL, LIGHT_GREY, Anchor::Middle);
}

/// Names points next to them, the more important first: positions on both axes, text. As many are named as have room.
pub(super) fn name_peaks(
    canvas: &mut Canvas,
    panel: &Panel,
    plot: &Plot,
    labels: &[(f64, f64, String)],
) {
    const ROOM: f64 = 4.0;
    let points: Vec<Point2> = labels.iter().map(|l| panel.to_canvas(l.0, l.1)).collect();
    let widths: Vec<f64> = labels
        .iter()
        .map(|l| text_width(&l.2, SMALL) + ROOM)
        .collect();
    let room = Frame {
        across: panel.across,
        down: (panel.down.0 - LABEL_ROW + 2.0, panel.down.1),
    };
    let placed = place_labels(&points, &widths, SMALL + ROOM, &room, &traced(panel, plot));
    for ((spot, middle), (.., text)) in points.iter().zip(placed).zip(labels) {
        canvas.stroke_circle(*spot, 2.6, BLACK, 1.0);
        if let Some(middle) = middle {
            canvas.text(text, middle, SMALL, BLACK, Anchor::Middle);
        }
    }
}

/// Spots along the lines of a plot, so near to each other that no name lies between two.
fn traced(panel: &Panel, plot: &Plot) -> Vec<Point2> {
    const APART: f64 = 4.0;
    let position = |(x, y): (&f64, &f64)| (plot.x.position(*x), plot.y.position(*y));
    let lines = plot
        .curves
        .iter()
        .filter(|c| matches!(c.mark, Mark::Line(..)));
    let runs = lines.flat_map(|c| clip_to_panel(panel, c.x.iter().zip(&c.y).map(position)));
    let mut spots = Vec::new();
    for run in runs {
        for pair in run.windows(2) {
            let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
            let count = ((x1 - x0).hypot(y1 - y0) / APART).ceil().clamp(1.0, 1000.0);
            let share = |k: f64| (x0 + (x1 - x0) * k / count, y0 + (y1 - y0) * k / count);
            spots.extend((0..count as usize).map(|k| share(k as f64)));
        }
    }
    spots
}
