//! Curves and events of a plot of an SVG file.

use super::axes::clip_to_panel;
use super::figure::{COLOURS, Curve, EventMarks, Ink, Mark, Plot};
use super::svg::{
    BLACK, BLUE, Canvas, Colour, GREY, LIGHT_GREY, ORANGE, Panel, Point2, colour_from_rgb, lighten,
};

/// Height of a row of events.
pub(super) const EVENT_ROW: f64 = 7.0;

/// Colour of an ink on white paper.
pub(super) fn colour(ink: Ink) -> Colour {
    let series = |k: usize| match k % COLOURS {
        0 => BLUE,
        1 => ORANGE,
        2 => BLACK,
        3 => GREY,
        4 => colour_from_rgb(0x00, 0x80, 0x50),
        _ => colour_from_rgb(0x90, 0x30, 0x90),
    };
    match ink {
        Ink::Series(k) => series(k),
        Ink::Pale(k) => lighten(series(k)),
        Ink::Faint => LIGHT_GREY,
    }
}

pub(super) fn draw_curve(canvas: &mut Canvas, panel: &Panel, plot: &Plot, curve: &Curve) {
    let ink = colour(curve.ink);
    let position = |(x, y): (&f64, &f64)| (plot.x.position(*x), plot.y.position(*y));
    let points = || curve.x.iter().zip(&curve.y).map(position);
    let inside = |(x, y): (f64, f64)| {
        (panel.x.0..=panel.x.1).contains(&x) && (panel.y.0..=panel.y.1).contains(&y)
    };
    for ((x, _), interval) in points().zip(&curve.interval) {
        let ends = [interval.0, interval.1].map(|v| plot.y.position(v).clamp(panel.y.0, panel.y.1));
        let [low, high] = ends.map(|v| panel.to_canvas(x, v));
        canvas.line(low, high, lighten(ink), 1.4);
    }
    match curve.shown_mark() {
        Mark::Line(width, style) => {
            for run in clip_to_panel(panel, points()) {
                canvas.polyline(&run, ink, width, style);
            }
        }
        Mark::Stems => {
            for (x, y) in points().filter(|p| inside(*p)) {
                let head = panel.to_canvas(x, y);
                canvas.line((head.0, panel.down.1), head, ink, 1.4);
                canvas.fill_circle(head, 2.2, ink);
            }
        }
        Mark::Discs(radius) | Mark::Rings(radius) | Mark::Crosses(radius) => {
            // Points closer together than half their radius are one.
            let mut last = (f64::NAN, f64::NAN);
            for (k, (x, y)) in points().enumerate().filter(|(_, p)| inside(*p)) {
                let spot = panel.to_canvas(x, y);
                let radius = curve.radii.get(k).copied().unwrap_or(radius);
                if (spot.0 - last.0).hypot(spot.1 - last.1) < 0.5 * radius {
                    continue;
                }
                last = spot;
                match curve.mark {
                    Mark::Rings(_) => canvas.stroke_circle(spot, radius, ink, 1.2),
                    Mark::Crosses(_) => cross(canvas, spot, radius, ink),
                    _ => canvas.fill_circle(spot, radius, ink),
                }
            }
        }
    }
}

pub(super) fn cross(canvas: &mut Canvas, (x, y): Point2, r: f64, ink: Colour) {
    canvas.line((x - r, y - r), (x + r, y + r), ink, 1.4);
    canvas.line((x - r, y + r), (x + r, y - r), ink, 1.4);
}

/// Ticks at the foot of a plot, one row a kind, the first lowest. Ticks closer together than their width are one.
pub(super) fn draw_events(canvas: &mut Canvas, panel: &Panel, plot: &Plot, events: &[EventMarks]) {
    const TICK: f64 = 0.8;
    for (row, marks) in events.iter().enumerate() {
        let foot = panel.down.1 - EVENT_ROW * row as f64;
        let ink = colour(Ink::Series(marks.ink));
        let mut last = f64::NEG_INFINITY;
        for x in marks.x.iter().map(|x| panel.canvas_x(plot.x.position(*x))) {
            if (panel.across.0..=panel.across.1).contains(&x) && x - last >= TICK {
                canvas.line((x, foot), (x, foot - EVENT_ROW + 1.0), ink, TICK);
                last = x;
            }
        }
    }
}
