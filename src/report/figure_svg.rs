//! SVG figures: layout, axis ranges, grids and guide lines of their plots.

use super::axes::{linear_range, log_range, log_ticks};
use super::figure::{Axis, Curve, EventMarks, Figure, FigureContent, Plot, PlotColumn, PointLabel};
use super::figure_key::{KEY_ROW, entry_width, key_entry, key_rows};
use super::figure_marks::{EVENT_ROW, draw_curve, draw_events};
use super::figure_names::{
    LABEL_ROW, SMALL, end_names, name_ends, name_on_map, name_peaks, name_upright,
};
use super::heatmap::{draw_map, map_ranges};
use super::svg::{
    Anchor, Canvas, GREY, LABEL_SIZE, LIGHT_GREY, LineStyle, Panel, Point2, TITLE_SIZE, WIDTH,
    lighten, render_svg, text_width, ticks, widest,
};
use crate::numeric::statistics::extremes;

const MARGIN_LEFT: f64 = 70.0;
/// Right margin of a plot without names at the ends of its curves.
const MARGIN_RIGHT: f64 = 24.0;
/// Right margin of a map, with its colour scale.
const MAP_MARGIN: f64 = 96.0;
/// Height of the title.
const TITLE: f64 = 26.0;
/// Margin below a plot with tick labels at its abscissa.
const BELOW: f64 = 46.0;
/// Margin below a plot without tick labels at its abscissa.
const BETWEEN: f64 = 16.0;

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
    let plot_width = WIDTH - MARGIN_LEFT - MARGIN_RIGHT;
    let key = key_rows(figure, plot_width);
    let title = MARGIN_LEFT + text_width(&figure.title, TITLE_SIZE);
    let fits_title = WIDTH - MARGIN_RIGHT - text_width(&figure.note, LABEL_SIZE) > title + 10.0;
    // A note that does not fit next to the title shares the first row of the key or has its own row.
    let first_row: f64 = key.first().into_iter().flatten().map(entry_width).sum();
    let fits_key = first_row + text_width(&figure.note, LABEL_SIZE) < plot_width;
    let first_key_row = usize::from(!fits_title && !fits_key);
    let rows = (key.len() + first_key_row).max(usize::from(!fits_title));
    let mut at = TITLE + KEY_ROW * rows as f64 + 6.0;
    // Plots with a common abscissa have the same left and right edges.
    let map_margin = figure.linked && figure.plots.iter().any(|p| p.map.is_some());
    let layout: Vec<Layout> = (figure.plots.iter().enumerate())
        .map(|(k, plot)| {
            let has_numbers = !figure.linked || k + 1 == figure.plots.len();
            let layout = Layout::new(plot, at, has_numbers, map_margin);
            at = layout.down.1 + if has_numbers { BELOW } else { BETWEEN };
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
            let height = TITLE + KEY_ROW * (row + first_key_row) as f64 + 10.0;
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

/// Edges of a plot, points.
struct Layout {
    across: (f64, f64),
    down: (f64, f64),
    /// Height of the heading, above the names of points.
    heading: f64,
    numbered: bool,
}

impl Layout {
    fn new(plot: &Plot, top: f64, numbered: bool, map_margin: bool) -> Layout {
        let ends = end_names(plot);
        let label_height = match (plot.labels.is_empty(), plot.upright_labels) {
            (true, _) => 0.0,
            (false, false) => LABEL_ROW,
            (false, true) => 12.0 + widest(plot.labels.iter().map(|l| &l.text), SMALL, 20.0),
        };
        let top_ends = ends.iter().filter(|e| e.leaves_at_top);
        let upright = widest(top_ends.map(|e| e.name), LABEL_SIZE, 0.0);
        let heading = if plot.heading.is_empty() { 0.0 } else { 16.0 };
        let right = match (map_margin || plot.map.is_some(), ends.is_empty()) {
            (true, _) => MAP_MARGIN,
            (false, true) => MARGIN_RIGHT,
            (false, false) => 34.0 + widest(ends.iter().map(|e| e.name), LABEL_SIZE, 20.0),
        };
        let upright = if upright > 0.0 { upright + 14.0 } else { 0.0 };
        let heading_at = top + 0.5 * heading;
        let top = top + label_height.max(upright) + heading;
        Layout {
            heading: heading_at,
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

/// Ranges of both axes as axis positions; `None` if no value is finite.
fn ranges(plot: &Plot) -> Option<((f64, f64), (f64, f64))> {
    let map = plot.map.as_ref().map(map_ranges);
    if map == Some(None) {
        return None;
    }
    let map = map.flatten();
    let range_of = |axis: &Axis, values: &dyn Fn(&Curve) -> Vec<f64>, tight: bool| {
        let samples = || plot.curves.iter().flat_map(values);
        match (axis.logarithmic, tight) {
            (true, _) => log_range(samples()),
            (false, true) => {
                let ends = extremes(samples().filter(|x| x.is_finite()));
                match ends.0 < ends.1 {
                    true => Some(ends),
                    false => linear_range(samples()),
                }
            }
            (false, false) => linear_range(samples()),
        }
    };
    let abscissae = |curve: &Curve| curve.x.clone();
    let ordinates = |curve: &Curve| {
        let ends = curve.interval.iter().flat_map(|i| [i.0, i.1]);
        curve.y.iter().copied().chain(ends).collect()
    };
    let axis_range = |axis: &Axis| {
        axis.range
            .map(|(a, b)| (axis.position(a), axis.position(b)))
    };
    let x = axis_range(&plot.x)
        .or_else(|| map.map(|m| m.0))
        .or_else(|| range_of(&plot.x, &abscissae, true))?;
    let y = axis_range(&plot.y)
        .or_else(|| map.map(|m| m.1))
        .or_else(|| range_of(&plot.y, &ordinates, false))?;
    Some((x, y))
}

fn draw_plot(canvas: &mut Canvas, plot: &Plot, events: &[EventMarks], layout: &Layout) {
    let has_points = plot.map.is_some() || plot.curves.iter().any(|c| !c.y.is_empty());
    let Some((x, y)) = ranges(plot).filter(|_| has_points) else {
        canvas.placeholder(plot.empty, layout.middle());
        return;
    };
    let (x, y) = match plot.equal_scales {
        true => equal_scales(x, y, layout),
        false => (x, y),
    };
    // Curves are kept above the event marks.
    let rows = match plot.y.range {
        Some(_) => 0.0,
        None => EVENT_ROW * events.len() as f64,
    };
    let curve_height = layout.down.1 - layout.down.0 - rows;
    let y = (y.0 - (y.1 - y.0) * rows / curve_height, y.1);
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
        let spot = (layout.across.0 + 6.0, layout.heading);
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

/// Both ranges widened about their middles to the same scale, the larger of the two.
fn equal_scales(x: (f64, f64), y: (f64, f64), layout: &Layout) -> ((f64, f64), (f64, f64)) {
    let size = |(low, high): (f64, f64)| high - low;
    let (wide, high) = (size(layout.across), size(layout.down));
    let scale = (size(x) / wide).max(size(y) / high);
    let widen = |range: (f64, f64), length: f64| {
        let middle = 0.5 * (range.0 + range.1);
        (middle - 0.5 * scale * length, middle + 0.5 * scale * length)
    };
    (widen(x, wide), widen(y, high))
}

/// Draws grid, tick labels and names of both axes, with unit prefixes by the size of the values.
fn draw_grid(canvas: &mut Canvas, panel: &Panel, plot: &Plot, numbered: bool) {
    let [(x_factor, x_name), (y_factor, y_name)] = plot.shown_units();
    let shown = |range: (f64, f64), axis: &Axis, factor: f64| match axis.logarithmic {
        true => (range.0 + factor.log10(), range.1 + factor.log10()),
        false => (range.0 * factor, range.1 * factor),
    };
    let panel = &Panel {
        x: shown(panel.x, &plot.x, x_factor),
        y: shown(panel.y, &plot.y, y_factor),
        ..*panel
    };
    // About `count` round numbers, or the ticks that the axis states.
    let values = |axis: &Axis, range: (f64, f64), factor: f64, count: usize| match &axis.ticks[..] {
        [] => ticks(range, count),
        stated => stated.iter().map(|v| v * factor).collect(),
    };
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
            panel.draw_y_grid(canvas, &values(&plot.y, panel.y, y_factor, about as usize));
        }
    }
    match (plot.x.logarithmic, numbered) {
        (true, _) => {
            for (at, text) in log_ticks(panel.x, plot.x.prefixed_unit) {
                let text = if numbered { text.as_str() } else { "" };
                panel.draw_x_mark(canvas, at, text);
            }
        }
        (false, true) => panel.draw_x_grid(canvas, &values(&plot.x, panel.x, x_factor, 8)),
        (false, false) => {
            for value in ticks(panel.x, 8) {
                panel.draw_vertical(canvas, panel.canvas_x(value), LIGHT_GREY, 0.5);
            }
        }
    }
    if numbered {
        panel.draw_x_name(canvas, &x_name, 30.0);
    }
    panel.draw_y_name(canvas, &y_name);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::{Figure, Ink};

    /// Texts of a drawing with their vertical positions, points.
    fn texts(svg: &str) -> Vec<(f64, String)> {
        let elements = svg.split("<text ").skip(1);
        let read = |element: &str| {
            let height = element.split("y=\"").nth(1)?.split('"').next()?;
            let text = element.split('>').nth(1)?.split('<').next()?;
            Some((height.parse::<f64>().ok()? / 8.0, text.trim().to_string()))
        };
        elements.filter_map(read).collect()
    }

    fn plot(label: &str, values: Vec<f64>) -> Plot {
        let abscissae = (0..values.len()).map(|k| k as f64).collect();
        Plot {
            curves: vec![Curve::line("", Ink::Series(0), abscissae, values)],
            ..Plot::new(Axis::linear("time, s"), Axis::linear(label))
        }
    }

    /// Deflections of 40 µm are plotted in µm with round numbers, linear and logarithmic; the time axis stays in s.
    #[test]
    fn exact_axes_in_the_unit_of_their_size() {
        let values = vec![1e-5, 2e-5, 4e-5];
        let linear = plot("deflection, m", values.clone());
        let logarithmic = Plot {
            y: Axis::log("deflection, m"),
            ..plot("", values)
        };
        for (plot, numbers) in [(linear, ["20", "30"]), (logarithmic, ["20", "10"])] {
            let svg = Figure::first(PlotColumn::one("", plot)).svg();
            let found: Vec<String> = texts(&svg).into_iter().map(|t| t.1).collect();
            for text in ["deflection, µm", "time, s", numbers[0], numbers[1], "1.0"] {
                assert!(found.iter().any(|t| t == text), "{text}: {found:?}");
            }
        }
    }

    /// The heading of a plot and the name of a point at its upper edge have separate rows.
    #[test]
    fn exact_heading_is_above_names() {
        let plot = Plot {
            heading: "motor.speed".into(),
            labels: vec![PointLabel {
                x: 0.0,
                y: 3.0,
                text: "greatest".into(),
            }],
            ..plot("rad/s", vec![3.0, 1.0, 2.0])
        };
        let found = texts(&Figure::first(PlotColumn::one("", plot)).svg());
        let height = |text: &str| found.iter().find(|t| t.1 == text).map(|t| t.0).unwrap();
        assert!(
            height("motor.speed") + LABEL_SIZE < height("greatest"),
            "{found:?}"
        );
    }
}
