//! Gear charts over the teeth: pitch, single-flank records, profile and helix traces.

use super::axes::{draw_curve, draw_frame, linear_range};
use super::number_format::four_digits;
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, GREY, LABEL_SIZE, LIGHT_GREY, LineStyle, ORANGE, Panel, WIDTH,
    lighten, render_svg, text_width, ticks, truncate_label,
};
use crate::gear::measurement::pitch::PitchDeviations;
use crate::gear::measurement::trace::MeanLine;
use crate::plan::measure::charts::ChartPlot;
use crate::plan::measure::grading::GradedFlanks;

/// Left and right edge of every panel, points.
const ACROSS: (f64, f64) = (66.0, WIDTH - 16.0);
/// Margins above a panel for its title and below for its axis, points.
const TITLE_ROW: f64 = 30.0;
const AXIS_ROW: f64 = 40.0;
/// Height of the key of traces, points.
const KEY_ROW: f64 = 18.0;

/// Draws the charts one below the other as SVG; `None` without a chart over the teeth.
pub fn draw_charts(title: &str, plots: &[ChartPlot]) -> Option<String> {
    let sections: Vec<(&ChartPlot, f64)> =
        plots.iter().filter_map(|d| Some((d, height(d)?))).collect();
    let total: f64 = sections.iter().map(|s| s.1 + TITLE_ROW + AXIS_ROW).sum();
    (!sections.is_empty()).then(|| {
        render_svg(WIDTH, total + 34.0, |canvas| {
            canvas.title(title, ACROSS.0);
            let mut top = 26.0;
            for (section, height) in sections {
                let down = (top + TITLE_ROW, top + TITLE_ROW + height);
                draw(canvas, section, down);
                top += height + TITLE_ROW + AXIS_ROW;
            }
        })
    })
}

fn height(chart: &ChartPlot) -> Option<f64> {
    match chart {
        ChartPlot::Pitch { .. } => Some(150.0),
        ChartPlot::Traces { .. } => Some(250.0 + KEY_ROW),
        ChartPlot::Record { .. } => Some(150.0),
        ChartPlot::Runout { .. } => Some(110.0),
    }
}

fn draw(canvas: &mut Canvas, chart: &ChartPlot, down: (f64, f64)) {
    match chart {
        ChartPlot::Pitch { side, pitches } => pitch(canvas, *side, pitches, down),
        ChartPlot::Runout {
            method_text: method,
            runout,
        } => {
            let title = format!("run-out {method}, F_r {:.2} µm", 1e6 * runout.range.value);
            let bars: Vec<f64> = runout.readings.iter().map(|r| 1e6 * r).collect();
            let panel = panel(canvas, &title, "tooth", &bars, down);
            blocks(canvas, &panel, &bars);
        }
        ChartPlot::Traces {
            side,
            is_profile,
            along,
            range,
            design,
            traces,
            ..
        } => {
            let subject = if *is_profile { "profile" } else { "helix" };
            let title = format!("{subject}, {}", flanks(*side));
            let down = (down.0 + KEY_ROW, down.1);
            draw_traces(canvas, &title, (along, *range, design), traces, down);
        }
        ChartPlot::Record {
            side,
            is_double,
            predicted,
            turns,
            values,
            long,
        } => {
            let subject = match (is_double, predicted) {
                (true, _) => "double-flank record".to_string(),
                (_, true) => format!(
                    "single-flank record expected from pitch and profile, {}",
                    flanks(*side)
                ),
                (_, false) => format!("single-flank record, {}", flanks(*side)),
            };
            record(canvas, &subject, *turns, (values, long), down);
        }
    }
}

fn flanks(side: GradedFlanks) -> String {
    match side {
        GradedFlanks::Both => "both flanks".to_string(),
        side => format!("{} flanks", side.name()),
    }
}

/// Panel over tooth numbers; the ordinate includes all values and zero.
fn panel(canvas: &mut Canvas, title: &str, axis: &str, values: &[f64], down: (f64, f64)) -> Panel {
    let n = values.len() as f64;
    grid_panel(canvas, title, axis, (0.5, n + 0.5), values, down)
}

fn grid_panel(
    canvas: &mut Canvas,
    title: &str,
    axis: &str,
    x: (f64, f64),
    values: &[f64],
    down: (f64, f64),
) -> Panel {
    let y = linear_range(values.iter().copied().chain([0.0])).unwrap_or((-1.0, 1.0));
    let panel = Panel::new(ACROSS, down, x, y);
    panel.draw_y_grid(canvas, &ticks(panel.y, 5));
    draw_frame(&panel, canvas, "", Some(axis));
    let middle = 0.5 * (down.0 + down.1);
    canvas.upright("µm", (18.0, middle));
    canvas.label(title, (ACROSS.0, down.0 - 12.0), Anchor::Start);
    panel
}

fn blocks(canvas: &mut Canvas, panel: &Panel, values: &[f64]) {
    for (i, &value) in values.iter().enumerate() {
        let x = i as f64 + 1.0;
        canvas.fill_rect(
            panel.to_canvas(x - 0.32, 0.0),
            panel.to_canvas(x + 0.32, value),
            lighten(BLUE),
        );
    }
    canvas.line(
        panel.to_canvas(panel.x.0, 0.0),
        panel.to_canvas(panel.x.1, 0.0),
        GREY,
        0.6,
    );
}

/// Draws single pitch deviations as bars and the cumulative deviation as a line with marked extremes.
fn pitch(canvas: &mut Canvas, side: GradedFlanks, pitches: &PitchDeviations, down: (f64, f64)) {
    let single: Vec<f64> = pitches.single.iter().map(|f| 1e6 * f).collect();
    let cumulative: Vec<f64> = pitches.cumulative.iter().map(|f| 1e6 * f).collect();
    let (largest, total) = (pitches.single_pitch(), pitches.cumulative_total());
    let title = format!(
        "pitch, {}: bars f_i (f_p {:.2} µm), line F_i (F_p {:.2} µm)",
        flanks(side),
        1e6 * largest.estimate.value.abs(),
        1e6 * total.estimate.value
    );
    let values = [&single[..], &cumulative].concat();
    let n = single.len() as f64;
    let panel = grid_panel(canvas, &title, "pitch", (0.5, n + 0.5), &values, down);
    blocks(canvas, &panel, &single);
    let x = largest.first as f64 + 1.0;
    let (from, to) = (
        panel.to_canvas(x - 0.32, 0.0),
        panel.to_canvas(x + 0.32, single[largest.first]),
    );
    canvas.fill_rect(from, to, ORANGE);
    let points: Vec<_> = cumulative
        .iter()
        .enumerate()
        .map(|(i, &f)| panel.to_canvas(i as f64 + 1.0, f))
        .collect();
    canvas.polyline(&points, BLACK, 1.2, LineStyle::Solid);
    let extremes = cumulative.iter().enumerate();
    let high = extremes.clone().max_by(|a, b| a.1.total_cmp(b.1));
    let low = extremes.min_by(|a, b| a.1.total_cmp(b.1));
    for (i, _) in high.into_iter().chain(low) {
        canvas.stroke_circle(points[i], 4.0, BLACK, 1.2);
    }
}

fn record(
    canvas: &mut Canvas,
    subject: &str,
    turns: usize,
    (values, low_orders): (&[f64], &[f64]),
    down: (f64, f64),
) {
    let n = values.len() as f64;
    let values: Vec<f64> = values.iter().map(|e| 1e6 * e).collect();
    let title = format!("{subject}; pale: orders below z/2");
    let x = (0.0, turns as f64);
    let y = linear_range(values.iter().copied()).unwrap_or((-1.0, 1.0));
    let panel = grid_panel(canvas, &title, "turn", x, &[y.0, y.1], down);
    let curve = |canvas: &mut Canvas, values: &mut dyn Iterator<Item = f64>, ink, width| {
        let points = values.enumerate();
        let points = points.map(|(i, e)| (turns as f64 * i as f64 / n, e));
        draw_curve(canvas, &panel, points, ink, width);
    };
    curve(canvas, &mut values.iter().copied(), BLACK, 0.7);
    curve(
        canvas,
        &mut low_orders.iter().map(|e| 1e6 * e),
        lighten(BLUE),
        2.4,
    );
}

/// Draws vertical traces side by side with their mean lines and the design; surplus material is to the right.
fn draw_traces(
    canvas: &mut Canvas,
    title: &str,
    (along, range, design): (&[f64], (f64, f64), &[f64]),
    traces: &[(String, Vec<f64>, MeanLine)],
    down: (f64, f64),
) {
    let values = || traces.iter().flat_map(|t| &t.1).chain(design).copied();
    let Some((low, high)) = linear_range(values().map(|y| 1e6 * y).chain([0.0])) else {
        return;
    };
    let (Some(&bottom), Some(&top)) = (along.first(), along.last()) else {
        return;
    };
    let lane = ((ACROSS.1 - ACROSS.0) / traces.len() as f64).min(190.0);
    let y = (1e3 * bottom, 1e3 * top);
    let lanes = Panel::new(
        (ACROSS.0, ACROSS.0 + lane * traces.len() as f64),
        down,
        (0.0, 1.0),
        y,
    );
    lanes.draw_y_grid(canvas, &ticks(y, 6));
    canvas.upright("mm", (18.0, 0.5 * (down.0 + down.1)));
    for limit in [range.0, range.1] {
        let height = lanes.canvas_y((1e3 * limit).clamp(y.0, y.1));
        let ends = [(lanes.across.0, height), (lanes.across.1, height)];
        canvas.polyline(&ends, ORANGE, 1.0, LineStyle::Dashed);
    }
    for (i, (name, trace, line)) in traces.iter().enumerate() {
        let left = ACROSS.0 + lane * i as f64;
        let panel = Panel::new((left + 6.0, left + lane - 6.0), down, (low, high), y);
        let zero = panel.canvas_x(0.0);
        canvas.line((zero, down.0), (zero, down.1), LIGHT_GREY, 1.0);
        for value in ticks((low, high), 2) {
            let x = panel.canvas_x(value);
            canvas.line((x, down.0), (x, down.0 + 3.0), GREY, 0.6);
            let text = four_digits(value);
            canvas.text(
                &text,
                (x, down.0 + 9.0),
                LABEL_SIZE - 2.0,
                GREY,
                Anchor::Middle,
            );
        }
        let curve = |values: &mut dyn Iterator<Item = (f64, f64)>| -> Vec<_> {
            values
                .map(|(x, y)| panel.to_canvas(1e6 * y, 1e3 * x))
                .collect()
        };
        if design.iter().any(|d| *d != 0.0) {
            let points = curve(&mut along.iter().copied().zip(design.iter().copied()));
            canvas.polyline(&points, GREY, 1.0, LineStyle::Dashed);
        }
        let points = curve(&mut along.iter().copied().zip(trace.iter().copied()));
        canvas.polyline(&points, BLACK, 1.1, LineStyle::Solid);
        // The mean line is relative to the design.
        let evaluated = along
            .iter()
            .zip(design)
            .filter(|(x, _)| **x >= range.0 && **x <= range.1);
        let points = curve(&mut evaluated.map(|(x, d)| (*x, line.height_at(*x) + d)));
        canvas.polyline(&points, BLUE, 1.4, LineStyle::Solid);
        let label = truncate_label(name, (lane / 7.0) as usize);
        let middle = left + 0.5 * lane;
        canvas.label(&label, (middle, down.1 + 11.0), Anchor::Middle);
        let slope = format!("f_H {:.1}", 1e6 * line.slope.value).replace('-', "−");
        canvas.text(
            &slope,
            (middle, down.1 + 25.0),
            LABEL_SIZE,
            BLUE,
            Anchor::Middle,
        );
    }
    let bar = ticks((0.0, 0.5 * (high - low)), 2)
        .last()
        .copied()
        .unwrap_or(1.0);
    let length = bar / (high - low) * (lane - 12.0);
    let (end, height) = (ACROSS.1, down.0 - 12.0 - KEY_ROW);
    canvas.line((end - length, height), (end, height), BLACK, 2.0);
    let text = format!("surplus to the right, {bar} µm");
    canvas.label(&text, (end - length - 8.0, height), Anchor::End);
    canvas.label(title, (ACROSS.0, height), Anchor::Start);
    draw_trace_key(canvas, down.0 - 12.0, design.iter().any(|d| *d != 0.0));
}

/// Draws the key of the lines of the traces.
fn draw_trace_key(canvas: &mut Canvas, height: f64, has_design: bool) {
    let lines = [
        ("trace", BLACK, LineStyle::Solid),
        ("mean line, slope f_H in µm", BLUE, LineStyle::Solid),
        ("ends of the evaluation range", ORANGE, LineStyle::Dashed),
        ("design", GREY, LineStyle::Dashed),
    ];
    let mut left = ACROSS.0;
    for (name, ink, style) in &lines[..if has_design { 4 } else { 3 }] {
        let ends = [(left, height), (left + 18.0, height)];
        canvas.polyline(&ends, *ink, 1.4, *style);
        canvas.label(name, (left + 23.0, height), Anchor::Start);
        left += 39.0 + text_width(name, LABEL_SIZE);
    }
    let note = "numbers in the lanes: µm";
    canvas.note(note, (left, height), Anchor::Start);
}
