//! Labels of the curves and points of a plot in an SVG file.

use super::axes::clip_to_panel;
use super::figure::{Curve, Ink, Mark, NamePlacement, Plot};
use super::figure_marks::colour;
use super::label_placement::{Frame, place_labels};
use super::svg::{
    Anchor, BLACK, Canvas, LABEL_SIZE, LIGHT_GREY, Panel, Point2, spread_labels, text_width,
};

/// Font size of point labels, points.
pub(super) const SMALL: f64 = 9.0;

/// Height of the row above a plot with horizontal point labels, points.
pub(super) const LABEL_ROW: f64 = 24.0;

/// Labelled end of a curve, in axis values.
pub(super) struct EndName<'a> {
    pub(super) name: &'a str,
    ink: Ink,
    x: f64,
    y: f64,
    pub(super) leaves_at_top: bool,
}

/// Labelled curve ends of a plot; empty for a plot with a key.
pub(super) fn end_names(plot: &Plot) -> Vec<EndName<'_>> {
    if plot.names == NamePlacement::Key {
        return Vec::new();
    }
    let top = plot.y.range.map(|range| range.1);
    let last_point = |curve: &'_ Curve| {
        let points = curve.x.iter().zip(&curve.y);
        let last = points.rev().find(|p| p.0.is_finite() && p.1.is_finite());
        last.map(|(&x, &y)| (x, y))
    };
    let curves = plot.curves.iter().filter(|c| !c.name.is_empty());
    curves
        .filter_map(|curve| {
            let (x, y) = last_point(curve)?;
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

/// Labels curves at their ends, right of the panel or above it, without overlap, each with a leader line to its curve.
pub(super) fn name_ends(canvas: &mut Canvas, panel: &Panel, plot: &Plot) {
    let ends = end_names(plot);
    let spot = |end: &EndName| {
        let y = plot.y.position(end.y).clamp(panel.y.0, panel.y.1);
        panel.to_canvas(plot.x.position(end.x), y)
    };
    let (upper, right): (Vec<&EndName>, Vec<&EndName>) = ends.iter().partition(|e| e.leaves_at_top);
    let targets: Vec<f64> = right.iter().map(|end| spot(end).1).collect();
    for (end, height) in right
        .iter()
        .zip(spread_labels(&targets, LABEL_SIZE + 2.5, panel.down))
    {
        let (left, ink) = (panel.across.1 + 14.0, colour(end.ink));
        canvas.line(spot(end), (left - 3.0, height), LIGHT_GREY, 0.7);
        canvas.text(end.name, (left, height), LABEL_SIZE, ink, Anchor::Start);
    }
    let targets: Vec<f64> = upper.iter().map(|end| spot(end).0).collect();
    for (end, x) in upper
        .iter()
        .zip(spread_labels(&targets, LABEL_SIZE + 2.0, panel.across))
    {
        let (foot, ink) = ((x, panel.down.0 - 10.0), colour(end.ink));
        canvas.line(spot(end), foot, ink, 0.5);
        canvas.vertical_text(end.name, (x, foot.1 - 2.0), LABEL_SIZE, ink, Anchor::Start);
    }
}

/// Draws vertical point labels (x, y, text) above a panel; on a map, points below the upper edge are labelled at the right edge.
pub(super) fn name_upright(
    canvas: &mut Canvas,
    panel: &Panel,
    labels: &[(f64, f64, String)],
    is_map: bool,
) {
    let top = panel.down.0;
    let is_at_top = |l: &&(f64, f64, String)| !is_map || panel.canvas_y(l.1) <= top + 2.0;
    let (labels, lower): (Vec<_>, Vec<_>) = labels.iter().partition(is_at_top);
    let heights: Vec<f64> = lower.iter().map(|l| panel.canvas_y(l.1) - 7.0).collect();
    let range = (top + 8.0, panel.down.1 - 8.0);
    for (label, height) in lower
        .iter()
        .zip(spread_labels(&heights, SMALL + 3.0, range))
    {
        let right = panel.across.1 - 5.0;
        let left = right - text_width(&label.2, SMALL);
        name_on_map(canvas, &label.2, (left, height));
    }
    let targets: Vec<f64> = labels.iter().map(|l| panel.canvas_x(l.0)).collect();
    for ((x, y, text), left) in labels
        .iter()
        .zip(spread_labels(&targets, 13.0, panel.across))
    {
        let mark = panel.to_canvas(*x, *y);
        canvas.line((left, top - 4.0), (mark.0, mark.1 - 3.0), LIGHT_GREY, 0.7);
        canvas.vertical_text(text, (left, top - 7.0), SMALL, BLACK, Anchor::Start);
    }
}

/// Draws a label from its left end on a dark background, legible on any level of a map.
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

/// Labels points (x, y, text; most important first) next to their markers; labels without room are omitted.
pub(super) fn name_peaks(
    canvas: &mut Canvas,
    panel: &Panel,
    plot: &Plot,
    labels: &[(f64, f64, String)],
) {
    const GAP: f64 = 4.0;
    let points: Vec<Point2> = labels.iter().map(|l| panel.to_canvas(l.0, l.1)).collect();
    let widths: Vec<f64> = labels
        .iter()
        .map(|l| text_width(&l.2, SMALL) + GAP)
        .collect();
    let frame = Frame {
        across: panel.across,
        down: (panel.down.0 - LABEL_ROW + 2.0, panel.down.1),
    };
    let middles = place_labels(&points, &widths, SMALL + GAP, &frame, &samples(panel, plot));
    for ((marker, middle), (.., text)) in points.iter().zip(middles).zip(labels) {
        canvas.stroke_circle(*marker, 2.6, BLACK, 1.0);
        if let Some(middle) = middle {
            canvas.text(text, middle, SMALL, BLACK, Anchor::Middle);
        }
    }
}

/// Points along the drawn lines of a plot, closer together than a label is high.
fn samples(panel: &Panel, plot: &Plot) -> Vec<Point2> {
    const PITCH: f64 = 4.0;
    let position = |(x, y): (&f64, &f64)| (plot.x.position(*x), plot.y.position(*y));
    let lines = plot
        .curves
        .iter()
        .filter(|c| matches!(c.mark, Mark::Line(..)));
    let runs = lines.flat_map(|c| clip_to_panel(panel, c.x.iter().zip(&c.y).map(position)));
    let mut points = Vec::new();
    for run in runs {
        for pair in run.windows(2) {
            let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
            let count = ((x1 - x0).hypot(y1 - y0) / PITCH).ceil().clamp(1.0, 1000.0);
            let at = |k: f64| (x0 + (x1 - x0) * k / count, y0 + (y1 - y0) * k / count);
            points.extend((0..count as usize).map(|k| at(k as f64)));
        }
    }
    points
}
