//! Figures drawn as SVG: key, grids, curves, maps and labels of every plot.

use super::axes::{clip_to_panel, linear_range, log_range, log_ticks};
use super::figure::{
    Axis, Curve, EventMarks, Figure, FigureContent, Ink, Mark, NamePlacement, Plot, PlotColumn,
    PointLabel,
};
use super::heatmap::{draw_map, map_ranges};
use super::label_placement::{Frame, place_labels};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LABEL_SIZE, LIGHT_GREY, LineStyle, ORANGE, Panel,
    Point2, WIDTH, colour_from_rgb, lighten, render_svg, spread_labels, text_width, ticks, widest,
};
use crate::numeric::statistics::extremes;

const MARGIN_LEFT: f64 = 70.0;
/// Right of the plots; with names at the ends of curves more.
const MARGIN_RIGHT: f64 = 24.0;
/// Right of a map, with its scale of colours.
const MAP_MARGIN: f64 = 96.0;
/// Height of the title.
const TITLE: f64 = 26.0;
/// Height of a row of the key.
const KEY_ROW: f64 = 16.0;
/// Below a plot with the numbers of its abscissa, and below one without.
const BELOW: f64 = 46.0;
/// See [`BELOW`].
const BETWEEN: f64 = 16.0;
/// Size of the names of points.
const SMALL: f64 = 9.0;
/// Height of a row of events.
const EVENT_ROW: f64 = 7.0;
/// Above a plot with names of points, where they are not upright.
const LABEL_ROW: f64 = 24.0;

/// Colour of an ink on white paper.
fn colour(ink: Ink) -> Colour {
    let series = |k: usize| match k % 6 {
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

impl Figure {
    /// The figure as an SVG document.
    pub fn svg(&self) -> String {
        match &self.content {
            FigureContent::Plots(plots) => draw(plots),
            FigureContent::Drawing(svg) => svg.clone(),
        }
    }
}

/// Draws a figure of plots.
fn draw(figure: &PlotColumn) -> String {
    let key = key_rows(figure);
    let title = MARGIN_LEFT + text_width(&figure.title, super::svg::TITLE_SIZE);
    let fits_title = WIDTH - MARGIN_RIGHT - text_width(&figure.note, LABEL_SIZE) > title + 10.0;
    // A note below the title has a row of its own or shares the first of the key.
    let first_row: f64 = key.first().into_iter().flatten().map(entry_width).sum();
    let fits_key =
        first_row + text_width(&figure.note, LABEL_SIZE) < WIDTH - MARGIN_LEFT - MARGIN_RIGHT;
    let key_from = usize::from(!fits_title && !fits_key);
    let rows = (key.len() + key_from).max(usize::from(!fits_title));
    let mut at = TITLE + KEY_ROW * rows as f64 + 6.0;
    // Plots of one abscissa stand exactly below each other.
    let map_margin = figure.linked && figure.plots.iter().any(|p| p.map.is_some());
    let layout: Vec<Layout> = (figure.plots.iter().enumerate())
        .map(|(k, plot)| {
            let numbered = !figure.linked || k + 1 == figure.plots.len();
            let layout = Layout::new(plot, at, numbered, map_margin);
            at = layout.down.1 + if numbered { BELOW } else { BETWEEN };
            layout
        })
        .collect();
    render_svg(WIDTH, at + 4.0, |canvas| {
        canvas.title(&figure.title, MARGIN_LEFT);
        let note_height = if fits_title { 16.0 } else { TITLE + 10.0 };
        canvas.note(
            &figure.note,
            (WIDTH - MARGIN_RIGHT, note_height),
            Anchor::End,
        );
        for (row, entries) in key.iter().enumerate() {
            let height = TITLE + KEY_ROW * (row + key_from) as f64 + 10.0;
            let mut right = MARGIN_LEFT;
            for entry in entries {
                right = key_entry(canvas, (right, height), entry) + 16.0;
            }
        }
        for (plot, layout) in figure.plots.iter().zip(&layout) {
            draw_plot(canvas, plot, &figure.events, layout);
        }
    })
}

/// Edges of a plot.
struct Layout {
    across: (f64, f64),
    down: (f64, f64),
    numbered: bool,
}

impl Layout {
    fn new(plot: &Plot, top: f64, numbered: bool, map_margin: bool) -> Layout {
        let ends = end_names(plot);
        let above = match (plot.labels.is_empty(), plot.upright_labels) {
            (true, _) => 0.0,
            (false, false) => LABEL_ROW,
            (false, true) => 12.0 + widest(plot.labels.iter().map(|l| &l.text), SMALL, 20.0),
        };
        let leaving = ends.iter().filter(|e| e.leaves_at_top);
        let upright = widest(leaving.map(|e| e.name), LABEL_SIZE, 0.0);
        let heading = if plot.heading.is_empty() { 0.0 } else { 16.0 };
        let right = match (map_margin || plot.map.is_some(), ends.is_empty()) {
            (true, _) => MAP_MARGIN,
            (false, true) => MARGIN_RIGHT,
            (false, false) => 34.0 + widest(ends.iter().map(|e| e.name), LABEL_SIZE, 20.0),
        };
        let upright = if upright > 0.0 { upright + 14.0 } else { 0.0 };
        let top = top + above.max(upright) + heading;
        Layout {
            across: (MARGIN_LEFT, WIDTH - right),
            down: (top, top + plot.height),
            numbered,
        }
    }

    fn middle(&self) -> Point2 {
        let mean = |(a, b): (f64, f64)| 0.5 * (a + b);
        (mean(self.across), mean(self.down))
    }
}

/// An entry of the key: a name with its sign, that of a curve or a tick for an event.
struct KeyEntry<'a> {
    name: &'a str,
    ink: Ink,
    mark: Option<Mark>,
}

/// Named curves and events in rows of the key, each name once.
fn key_rows(figure: &PlotColumn) -> Vec<Vec<KeyEntry<'_>>> {
    let mut rows: Vec<Vec<KeyEntry>> = Vec::new();
    let mut room = 0.0;
    let plots = figure
        .plots
        .iter()
        .filter(|p| p.names == NamePlacement::Key);
    let curves = plots.flat_map(|p| &p.curves).map(|c| KeyEntry {
        name: &c.name,
        ink: c.ink,
        mark: Some(c.mark),
    });
    let events = figure.events.iter().map(|e| KeyEntry {
        name: &e.name,
        ink: Ink::Series(e.ink),
        mark: None,
    });
    for entry in curves.chain(events) {
        let known = rows.iter().flatten().any(|c| c.name == entry.name);
        if entry.name.is_empty() || known {
            continue;
        }
        let width = entry_width(&entry);
        match rows.last_mut() {
            Some(row) if width <= room => row.push(entry),
            _ => {
                rows.push(vec![entry]);
                room = WIDTH - MARGIN_LEFT - MARGIN_RIGHT;
            }
        }
        room -= width;
    }
    rows
}

/// Width of a sign and its name with the space behind them.
fn entry_width(entry: &KeyEntry) -> f64 {
    39.0 + text_width(entry.name, LABEL_SIZE)
}

/// A sign and its name; returns the right end.
fn key_entry(canvas: &mut Canvas, (left, height): Point2, entry: &KeyEntry) -> f64 {
    let ink = colour(entry.ink);
    let middle = (left + 9.0, height);
    let Some(mark) = entry.mark else {
        let half = 0.5 * EVENT_ROW;
        canvas.line(
            (middle.0, height - half),
            (middle.0, height + half),
            ink,
            1.4,
        );
        return name_entry(canvas, (left, height), entry.name);
    };
    match mark {
        Mark::Line(width, style) => {
            let ends = [(left, height), (left + 18.0, height)];
            canvas.polyline(&ends, ink, width.max(1.8), style);
        }
        Mark::Discs(radius) => canvas.fill_circle(middle, radius.max(2.4), ink),
        Mark::Stems => canvas.fill_circle(middle, 2.2, ink),
        Mark::Rings(radius) => canvas.stroke_circle(middle, radius, ink, 1.2),
        Mark::Crosses(radius) => cross(canvas, middle, radius, ink),
    }
    name_entry(canvas, (left, height), entry.name)
}

fn name_entry(canvas: &mut Canvas, (left, height): Point2, name: &str) -> f64 {
    canvas.label(name, (left + 23.0, height), Anchor::Start);
    left + 23.0 + text_width(name, LABEL_SIZE)
}

fn cross(canvas: &mut Canvas, (x, y): Point2, r: f64, ink: Colour) {
    canvas.line((x - r, y - r), (x + r, y + r), ink, 1.4);
    canvas.line((x - r, y + r), (x + r, y - r), ink, 1.4);
}

/// The end of a curve with its name.
struct EndName<'a> {
    name: &'a str,
    ink: Ink,
    x: f64,
    y: f64,
    leaves_at_top: bool,
}

/// Ends of the curves of a plot that names them there.
fn end_names(plot: &Plot) -> Vec<EndName<'_>> {
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

/// Ranges of both axes in their positions; absent where nothing is finite.
fn ranges(plot: &Plot) -> Option<((f64, f64), (f64, f64))> {
    let map = plot.map.as_ref().map(map_ranges);
    if map == Some(None) {
        return None;
    }
    let map = map.flatten();
    let over = |axis: &Axis, values: &dyn Fn(&Curve) -> Vec<f64>, tight: bool| {
        let all = || plot.curves.iter().flat_map(values);
        match (axis.logarithmic, tight) {
            (true, _) => log_range(all()),
            (false, true) => {
                let ends = extremes(all().filter(|x| x.is_finite()));
                match ends.0 < ends.1 {
                    true => Some(ends),
                    false => linear_range(all()),
                }
            }
            (false, false) => linear_range(all()),
        }
    };
    let abscissae = |curve: &Curve| curve.x.clone();
    let ordinates = |curve: &Curve| {
        let ends = curve.interval.iter().flat_map(|i| [i.0, i.1]);
        curve.y.iter().copied().chain(ends).collect()
    };
    let stated = |axis: &Axis| {
        axis.range
            .map(|(a, b)| (axis.position(a), axis.position(b)))
    };
    let x = stated(&plot.x)
        .or_else(|| map.map(|m| m.0))
        .or_else(|| over(&plot.x, &abscissae, true))?;
    let y = stated(&plot.y)
        .or_else(|| map.map(|m| m.1))
        .or_else(|| over(&plot.y, &ordinates, false))?;
    Some((x, y))
}

fn draw_plot(canvas: &mut Canvas, plot: &Plot, events: &[EventMarks], layout: &Layout) {
    let holds_points = plot.map.is_some() || plot.curves.iter().any(|c| !c.y.is_empty());
    let Some((x, y)) = ranges(plot).filter(|_| holds_points) else {
        canvas.placeholder(plot.empty, layout.middle());
        return;
    };
    let (x, y) = match plot.equal_scales {
        true => equal_scales(x, y, layout),
        false => (x, y),
    };
    // The curves end above the ticks of events.
    let rows = match plot.y.range {
        Some(_) => 0.0,
        None => EVENT_ROW * events.len() as f64,
    };
    let above = layout.down.1 - layout.down.0 - rows;
    let y = (y.0 - (y.1 - y.0) * rows / above, y.1);
    let panel = Panel::new(layout.across, layout.down, x, y);
    for band in &plot.bands {
        let ends = [band.from, band.to].map(|v| plot.x.position(v).clamp(x.0, x.1));
        let corners = (panel.to_canvas(ends[0], y.0), panel.to_canvas(ends[1], y.1));
        canvas.fill_rect(corners.0, corners.1, lighten(LIGHT_GREY));
        let foot = (
            panel.canvas_x(0.5 * (ends[0] + ends[1])),
            layout.down.1 - 9.0,
        );
        canvas.note(&band.name, foot, Anchor::Middle);
    }
    draw_grid(canvas, &panel, plot, layout.numbered);
    if let Some(map) = &plot.map {
        draw_map(canvas, &panel, map);
    }
    draw_guides(canvas, &panel, plot);
    for curve in &plot.curves {
        draw_curve(canvas, &panel, plot, curve);
    }
    draw_events(canvas, &panel, plot, events);
    panel.draw_outline(canvas);
    if !plot.heading.is_empty() {
        let spot = (layout.across.0 + 6.0, layout.down.0 - 8.0);
        canvas.label(&plot.heading, spot, Anchor::Start);
    }
    let position = |l: &PointLabel| (plot.x.position(l.x), plot.y.position(l.y), l.text.clone());
    let labels: Vec<_> = plot.labels.iter().map(position).collect();
    match plot.upright_labels {
        true => name_upright(canvas, &panel, &labels, plot.map.is_some()),
        false => name_peaks(canvas, &panel, plot, &labels),
    }
    name_ends(canvas, &panel, plot);
}

/// Both ranges widened about their middles to the larger scale, as the plot is wider than high.
fn equal_scales(x: (f64, f64), y: (f64, f64), layout: &Layout) -> ((f64, f64), (f64, f64)) {
    let size = |(low, high): (f64, f64)| high - low;
    let (wide, high) = (size(layout.across), size(layout.down));
    let scale = (size(x) / wide).max(size(y) / high);
    let about = |range: (f64, f64), length: f64| {
        let middle = 0.5 * (range.0 + range.1);
        (middle - 0.5 * scale * length, middle + 0.5 * scale * length)
    };
    (about(x, wide), about(y, high))
}

fn draw_grid(canvas: &mut Canvas, panel: &Panel, plot: &Plot, numbered: bool) {
    match plot.y.logarithmic {
        true => {
            for (at, text) in log_ticks(panel.y, plot.y.prefixed_unit) {
                let height = panel.canvas_y(at);
                panel.draw_horizontal(canvas, height, LIGHT_GREY, 0.5);
                canvas.label(&text, (panel.across.0 - 5.0, height), Anchor::End);
            }
        }
        false => {
            let about = ((panel.down.1 - panel.down.0) / 40.0).clamp(4.0, 8.0);
            let round = ticks(panel.y, about as usize);
            let all = if plot.y.ticks.is_empty() {
                round
            } else {
                plot.y.ticks.clone()
            };
            panel.draw_y_grid(canvas, &all);
        }
    }
    match (plot.x.logarithmic, numbered) {
        (true, _) => {
            for (at, text) in log_ticks(panel.x, plot.x.prefixed_unit) {
                let text = if numbered { text.as_str() } else { "" };
                panel.draw_x_mark(canvas, at, text);
            }
        }
        (false, true) if plot.x.ticks.is_empty() => panel.draw_x_grid(canvas, &ticks(panel.x, 8)),
        (false, true) => panel.draw_x_grid(canvas, &plot.x.ticks),
        (false, false) => {
            for value in ticks(panel.x, 8) {
                panel.draw_vertical(canvas, panel.canvas_x(value), LIGHT_GREY, 0.5);
            }
        }
    }
    if numbered {
        panel.draw_x_name(canvas, &plot.x.label, 30.0);
    }
    panel.draw_y_name(canvas, &plot.y.label);
}

fn draw_guides(canvas: &mut Canvas, panel: &Panel, plot: &Plot) {
    for guide in &plot.guides {
        let axis = if guide.vertical { &plot.x } else { &plot.y };
        let range = if guide.vertical { panel.x } else { panel.y };
        let at = axis.position(guide.at);
        if !(range.0..=range.1).contains(&at) {
            continue;
        }
        let ends = match guide.vertical {
            true => [panel.y.0, panel.y.1].map(|y| panel.to_canvas(at, y)),
            false => [panel.x.0, panel.x.1].map(|x| panel.to_canvas(x, at)),
        };
        let style = if guide.dotted {
            LineStyle::Dotted
        } else {
            LineStyle::Solid
        };
        let ink = if plot.map.is_some() { LIGHT_GREY } else { GREY };
        canvas.polyline(&ends, ink, 0.8, style);
        if !guide.vertical && plot.map.is_some() {
            name_on_map(canvas, &guide.name, (panel.across.0 + 5.0, ends[0].1 - 7.0));
            continue;
        }
        let corner = (panel.across.1, panel.down.1 + 30.0);
        canvas.note(&guide.name, corner, Anchor::End);
    }
}

/// A name on dark ground, so that it can be read on any level of a map, from its left end.
fn name_on_map(canvas: &mut Canvas, text: &str, (left, height): Point2) {
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

/// Ticks at the foot of a plot, one row a kind, the first lowest. Ticks closer together than their width are one.
fn draw_events(canvas: &mut Canvas, panel: &Panel, plot: &Plot, events: &[EventMarks]) {
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

fn draw_curve(canvas: &mut Canvas, panel: &Panel, plot: &Plot, curve: &Curve) {
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
    match curve.mark {
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

/// Names curves at their ends, right of the panel or above it, none over another, each led to its curve.
fn name_ends(canvas: &mut Canvas, panel: &Panel, plot: &Plot) {
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
fn name_upright(canvas: &mut Canvas, panel: &Panel, labels: &[(f64, f64, String)], is_map: bool) {
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

/// Names points next to them, the more important first: positions on both axes, text. As many are named as have room.
fn name_peaks(canvas: &mut Canvas, panel: &Panel, plot: &Plot, labels: &[(f64, f64, String)]) {
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
