//! Stability regions in the hλ plane and amplification factor per step of every method.

use super::axes::{clip_to_panel, draw_frame, draw_log_grid};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LABEL_SIZE, LIGHT_GREY, LineStyle, ORANGE, Panel,
    Point2, WIDTH, lighten, render_svg, text_width, ticks,
};
use crate::base::quantity::format_time;
use crate::study::stability::amplification::{AmplificationChart, stability_boundary};
use crate::study::stability::linear::LinearStability;

const MARGIN_LEFT: f64 = 70.0;
const MARGIN_RIGHT: f64 = 24.0;
const MARGIN_TOP: f64 = 56.0;

/// The plane of hλ, with one scale on both axes.
const RE: (f64, f64) = (-8.0, 13.0);
const IM: (f64, f64) = (-0.5, 9.5);

/// Height of the panel of factors, and room between both.
const FACTORS: f64 = 280.0;
const SPACING: f64 = 92.0;

/// Line style of a method: dashes for those of a fixed formula for position and speed.
fn line_style(method: &str) -> (Colour, LineStyle) {
    match method {
        "rk4" => (GREY, LineStyle::Solid),
        "dopri5" => (ORANGE, LineStyle::Solid),
        "dop853" => (BLUE, LineStyle::Solid),
        "newmark" => (GREY, LineStyle::Dashed),
        "hht" => (ORANGE, LineStyle::Dashed),
        "generalized-alpha" => (BLUE, LineStyle::Dashed),
        _ => (BLACK, LineStyle::Solid),
    }
}

/// Regions of stability with the eigenvalues times the step, and the factor of every method on each of them over |hλ|.
pub fn draw_stability_regions(
    title: &str,
    facts: &LinearStability,
    spectrum: &AmplificationChart,
) -> String {
    let across = (MARGIN_LEFT, WIDTH - MARGIN_RIGHT);
    let high = (across.1 - across.0) * (IM.1 - IM.0) / (RE.1 - RE.0);
    let middle = MARGIN_TOP + high + SPACING;
    render_svg(WIDTH, middle + FACTORS + 44.0, |canvas| {
        canvas.title(title, MARGIN_LEFT);
        let plane = Panel::new(across, (MARGIN_TOP, MARGIN_TOP + high), RE, IM);
        draw_complex_plane(canvas, &plane, facts, spectrum);
        let factors = Panel::new(
            across,
            (middle, middle + FACTORS),
            spectrum.decade_range(),
            range_of_factors(spectrum),
        );
        draw_amplification(canvas, &factors, spectrum);
    })
}

/// Powers of ten of the factors shown, a decade to each side of one at least; values beyond six lie on the edge.
fn range_of_factors(spectrum: &AmplificationChart) -> (f64, f64) {
    const MAX_COUNT: f64 = 6.0;
    let points = spectrum
        .methods
        .iter()
        .flat_map(|m| m.undamped.iter().chain(&m.eigenvalues));
    points.fold((-1.0, 1.0), |(low, high): (f64, f64), (_, y)| {
        let y = y.log10().clamp(-MAX_COUNT, MAX_COUNT);
        (low.min(y), high.max(y))
    })
}

fn draw_complex_plane(
    canvas: &mut Canvas,
    panel: &Panel,
    facts: &LinearStability,
    spectrum: &AmplificationChart,
) {
    canvas.fill_rect(
        panel.to_canvas(RE.0, IM.1),
        panel.to_canvas(0.0, IM.0),
        lighten(lighten(LIGHT_GREY)),
    );
    panel.draw_y_grid(canvas, &ticks(panel.y, 8));
    draw_frame(panel, canvas, "Im hλ", Some("Re hλ"));
    let always = spectrum
        .unconditionally_stable()
        .collect::<Vec<_>>()
        .join(", ");
    let words = ["left half-plane: no step is too long for", always.as_str()];
    for (row, text) in words.into_iter().enumerate() {
        let down = MARGIN_TOP + 14.0 + 15.0 * row as f64;
        canvas.label(text, (MARGIN_LEFT + 8.0, down), Anchor::Start);
    }
    let mut right = MARGIN_LEFT;
    for course in &spectrum.methods {
        let curve = stability_boundary(course.method);
        if curve.is_empty() {
            continue;
        }
        let (ink, stroke) = line_style(course.method);
        let spots: Vec<Point2> = curve
            .iter()
            .filter(|z| z.im >= -0.02)
            .map(|z| panel.to_canvas(z.re, z.im))
            .collect();
        canvas.polyline(&spots, ink, 1.6, stroke);
        let side = match course.conditionally_stable {
            true => "stable inside",
            false => "outside",
        };
        let text = format!("{}, {side}", course.method);
        right = entry(canvas, (right, 36.0), &text, ink, stroke);
    }
    let label = format!("eigenvalues times {}", format_time(spectrum.step));
    canvas.stroke_circle((right + 8.0, 36.0), 3.0, BLACK, 1.2);
    canvas.label(&label, (right + 18.0, 36.0), Anchor::Start);
    let places = facts.eigenvalues.iter().map(|z| *z * spectrum.step);
    let (shown, beyond): (Vec<_>, Vec<_>) =
        places.partition(|z| (RE.0..=RE.1).contains(&z.re) && z.im.abs() <= IM.1);
    for z in shown {
        canvas.stroke_circle(panel.to_canvas(z.re, z.im.abs()), 3.0, BLACK, 1.2);
    }
    if !beyond.is_empty() {
        let text = format!("{} beyond the edge", beyond.len());
        let place = (MARGIN_LEFT + 8.0, MARGIN_TOP + 48.0);
        canvas.label(&text, place, Anchor::Start);
    }
}

fn draw_amplification(canvas: &mut Canvas, panel: &Panel, spectrum: &AmplificationChart) {
    draw_log_grid(panel, canvas);
    panel.draw_outline(canvas);
    panel.draw_y_name(canvas, "factor of a step");
    let (first, last) = (panel.x.0.ceil() as i32, panel.x.1.floor() as i32);
    let every = ((last - first) / 10).max(1) as usize;
    for decade in (first..=last).step_by(every) {
        panel.draw_x_mark(canvas, f64::from(decade), &format!("1e{decade}"));
    }
    panel.draw_x_name(canvas, "|hλ|", 28.0);
    let one = panel.canvas_y(0.0);
    panel.draw_horizontal(canvas, one, GREY, 0.8);
    let above = panel.down.0 - 30.0;
    canvas.label("what a step makes of a mode: lines without damping, rings at the eigenvalues; above 1 it grows", (MARGIN_LEFT, above), Anchor::Start);
    let mut right = MARGIN_LEFT;
    for course in &spectrum.methods {
        let (ink, stroke) = line_style(course.method);
        let line = course.undamped.iter().map(|(x, y)| (x.log10(), y.log10()));
        for run in clip_to_panel(panel, line) {
            canvas.polyline(&run, ink, 1.4, stroke);
        }
        for (x, y) in &course.eigenvalues {
            let height = y.log10().clamp(panel.y.0, panel.y.1);
            canvas.stroke_circle(panel.to_canvas(x.log10(), height), 2.4, ink, 1.0);
        }
        right = entry(canvas, (right, above + 16.0), course.method, ink, stroke);
    }
}

/// A line with its name; where the next entry begins.
fn entry(
    canvas: &mut Canvas,
    (right, down): Point2,
    text: &str,
    ink: Colour,
    stroke: LineStyle,
) -> f64 {
    canvas.polyline(&[(right, down), (right + 18.0, down)], ink, 2.0, stroke);
    canvas.label(text, (right + 23.0, down), Anchor::Start);
    right + 23.0 + text_width(text, LABEL_SIZE) + 18.0
}
