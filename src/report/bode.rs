//! Frequency responses as plots: magnitude, phase and coherence over frequency; measured against fitted; in the complex plane.

use super::axes::{draw_curve, draw_frame, draw_log_grid, linear_range, log_range};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LineStyle, ORANGE, Panel, WIDTH, lighten,
    render_svg, ticks, truncate_label,
};
use crate::numeric::Complex;

/// One response.
#[derive(Debug, Clone, Default)]
pub struct BodeCurve {
    /// Label of the curve.
    pub label: String,
    /// Unit of its values.
    pub unit: String,
    /// Measured values by line.
    pub measured: Vec<Complex>,
    /// They were computed on lines that follow the curve: drawn as a line.
    pub computed: bool,
    /// Fitted values on as many places between the lines as its path in the plane needs; empty without a fit.
    pub traced: Vec<Complex>,
    /// Fitted values by line.
    pub fitted: Option<Vec<Complex>>,
    /// Coherence by line.
    pub coherence: Option<Vec<f64>>,
}

/// Contents of a Bode plot.
#[derive(Debug, Clone, Default)]
pub struct BodePlot {
    /// Above it.
    pub title: String,
    /// Label of the abscissa; frequency in Hz where empty.
    pub across: &'static str,
    /// Lines, in the unit of what it is over.
    pub frequency_hz: Vec<f64>,
    /// Responses; the first few are drawn.
    pub curves: Vec<BodeCurve>,
    /// Identified natural frequencies, Hz.
    pub modes_hz: Vec<f64>,
}

/// Responses drawn at once: more cannot be distinguished.
const MAX_COUNT: usize = 4;

const COLOURS: [Colour; MAX_COUNT] = [BLUE, ORANGE, BLACK, GREY];

const MARGIN_LEFT: f64 = 70.0;
const MAGNITUDE_HEIGHT: f64 = 230.0;
const PHASE_HEIGHT: f64 = 110.0;
const COHERENCE_HEIGHT: f64 = 70.0;
const SPACING: f64 = 16.0;

/// Magnitude, phase and, where it was measured, coherence.
pub fn draw_bode(shown: &BodePlot) -> String {
    let curves = &shown.curves[..shown.curves.len().min(MAX_COUNT)];
    let coherent = curves.iter().any(|c| c.coherence.is_some());
    let axis = match shown.across {
        "" => "frequency, Hz",
        across => across,
    };
    let top = 52.0;
    let heights = [
        MAGNITUDE_HEIGHT,
        PHASE_HEIGHT,
        if coherent { COHERENCE_HEIGHT } else { 0.0 },
    ];
    let mut at = top;
    let mut panels = Vec::new();
    for height in heights.into_iter().filter(|h| *h > 0.0) {
        panels.push((at, at + height));
        at += height + SPACING;
    }
    render_svg(WIDTH, at + 36.0, |canvas| {
        heading(canvas, &shown.title, curves, shown.curves.len());
        let sizes = || {
            curves
                .iter()
                .flat_map(|c| c.measured.iter().map(|z| z.norm()))
        };
        let (Some(&first), Some(&last), Some(y)) = (
            shown.frequency_hz.first(),
            shown.frequency_hz.last(),
            log_range(sizes()),
        ) else {
            canvas.placeholder("no response", (WIDTH / 2.0, at / 2.0));
            return;
        };
        let across = (MARGIN_LEFT, WIDTH - 24.0);
        let panel = |down, y| Panel::new(across, down, (first, last), y);
        let magnitude = panel(panels[0], y);
        draw_log_grid(&magnitude, canvas);
        let units: Vec<&str> = curves
            .iter()
            .map(|c| c.unit.as_str())
            .filter(|u| !u.is_empty())
            .collect();
        let unit = match units.first() {
            Some(unit) if units.iter().all(|u| u == unit) => format!("magnitude, {unit}"),
            _ => "magnitude".to_string(),
        };
        draw_frame(&magnitude, canvas, &unit, None);
        let phase = panel(panels[1], (-190.0, 190.0));
        phase.draw_y_grid(canvas, &[-180.0, -90.0, 0.0, 90.0, 180.0]);
        draw_frame(&phase, canvas, "phase, deg", (!coherent).then_some(axis));
        let coherence = coherent.then(|| panel(panels[2], (0.0, 1.05)));
        if let Some(coherence) = &coherence {
            coherence.draw_y_grid(canvas, &[0.0, 0.5, 1.0]);
            draw_frame(coherence, canvas, "coherence", Some(axis));
        }
        for &f in shown.modes_hz.iter().filter(|f| (first..=last).contains(f)) {
            for panel in [&magnitude, &phase] {
                let right = panel.canvas_x(f);
                panel.draw_dotted(canvas, right, GREY, 0.6);
            }
        }
        for (curve, ink) in curves.iter().zip(COLOURS) {
            let over = |f: &dyn Fn(&Complex) -> f64, values: &[Complex]| -> Vec<(f64, f64)> {
                shown
                    .frequency_hz
                    .iter()
                    .copied()
                    .zip(values.iter().map(f))
                    .collect()
            };
            let level = |z: &Complex| z.norm().log10();
            let degrees = |z: &Complex| z.arg().to_degrees();
            let width = if curve.fitted.is_some() { 2.2 } else { 1.0 };
            let pale = if curve.fitted.is_some() {
                lighten(ink)
            } else {
                ink
            };
            for (panel, f) in [
                (&magnitude, &level as &dyn Fn(&Complex) -> f64),
                (&phase, &degrees),
            ] {
                let wraps = std::ptr::eq(panel, &phase);
                stroke(canvas, panel, over(f, &curve.measured), pale, width, wraps);
                if let Some(fitted) = &curve.fitted {
                    stroke(canvas, panel, over(f, fitted), ink, 1.0, wraps);
                }
            }
            if let (Some(panel), Some(values)) = (&coherence, &curve.coherence) {
                let points = shown
                    .frequency_hz
                    .iter()
                    .copied()
                    .zip(values.iter().copied());
                stroke(canvas, panel, points.collect(), ink, 0.8, false);
            }
        }
    })
}

/// Draws a curve; one that wraps from −180° to 180° is broken there.
fn stroke(
    canvas: &mut Canvas,
    panel: &Panel,
    mut points: Vec<(f64, f64)>,
    ink: Colour,
    width: f64,
    wraps: bool,
) {
    if wraps {
        let mut broken = Vec::with_capacity(points.len());
        for (k, &point) in points.iter().enumerate() {
            if k > 0 && (point.1 - points[k - 1].1).abs() > 180.0 {
                broken.push((point.0, f64::NAN));
            }
            broken.push(point);
        }
        points = broken;
    }
    draw_curve(canvas, panel, points.into_iter(), ink, width);
}

fn heading(canvas: &mut Canvas, title: &str, curves: &[BodeCurve], all: usize) {
    canvas.title(title, MARGIN_LEFT);
    let mut right = MARGIN_LEFT;
    let fitted = curves.iter().any(|c| c.fitted.is_some());
    for (curve, ink) in curves.iter().zip(COLOURS) {
        let label = truncate_label(&curve.label, 28);
        right = canvas.key_entry((right, 36.0), &label, ink, 2.0) + 16.0;
    }
    let mut diagnostic = String::new();
    if fitted {
        diagnostic += "broad and pale: measured, narrow: fitted";
    }
    if all > curves.len() {
        diagnostic += &format!(
            "{}{} of {all} responses",
            if fitted { "; " } else { "" },
            curves.len()
        );
    }
    canvas.note(&diagnostic, (WIDTH - 24.0, 16.0), Anchor::End);
}

/// The responses in the complex plane, equal scales; points measured, lines fitted.
pub fn draw_nyquist(shown: &BodePlot) -> String {
    const SIDE: f64 = 560.0;
    let curves = &shown.curves[..shown.curves.len().min(MAX_COUNT)];
    let top = 52.0;
    render_svg(WIDTH, top + SIDE + 52.0, |canvas| {
        heading(canvas, &shown.title, curves, shown.curves.len());
        let all = || {
            curves
                .iter()
                .flat_map(|c| c.measured.iter().chain(&c.traced))
        };
        let (Some(re), Some(im)) = (
            linear_range(all().map(|z| z.re)),
            linear_range(all().map(|z| z.im)),
        ) else {
            canvas.placeholder("no response", (WIDTH / 2.0, top + SIDE / 2.0));
            return;
        };
        // Equal scales: the larger range decides, the plot being wider than high.
        let across = (MARGIN_LEFT, WIDTH - 24.0);
        let scale = ((re.1 - re.0) / (across.1 - across.0)).max((im.1 - im.0) / SIDE);
        let about = |range: (f64, f64), length: f64| {
            let middle = 0.5 * (range.0 + range.1);
            (middle - 0.5 * scale * length, middle + 0.5 * scale * length)
        };
        let panel = Panel::new(
            across,
            (top, top + SIDE),
            about(re, across.1 - across.0),
            about(im, SIDE),
        );
        grid(canvas, &panel);
        for (curve, ink) in curves.iter().zip(COLOURS) {
            let known = curve.traced.iter().filter(|z| z.is_finite());
            let points: Vec<_> = known.map(|z| panel.to_canvas(z.re, z.im)).collect();
            canvas.polyline(&points, ink, 1.0, LineStyle::Solid);
            if curve.computed {
                let known = curve.measured.iter().filter(|z| z.is_finite());
                let points: Vec<_> = known.map(|z| panel.to_canvas(z.re, z.im)).collect();
                canvas.polyline(&points, ink, 1.2, LineStyle::Solid);
                continue;
            }
            // Points closer together than their own size are one.
            let (mut last, radius) = ((f64::NAN, f64::NAN), 1.1);
            for z in curve
                .measured
                .iter()
                .filter(|z| z.re.is_finite() && z.im.is_finite())
            {
                let spot = panel.to_canvas(z.re, z.im);
                if !((spot.0 - last.0).hypot(spot.1 - last.1) < 0.5 * radius) {
                    canvas.fill_circle(spot, radius, ink);
                    last = spot;
                }
            }
        }
    })
}

/// The grid of the complex plane.
fn grid(canvas: &mut Canvas, panel: &Panel) {
    panel.draw_x_grid(canvas, &ticks(panel.x, 8));
    panel.draw_y_grid(canvas, &ticks(panel.y, 6));
    panel.draw_outline(canvas);
    panel.draw_x_name(canvas, "real part", 28.0);
    panel.draw_y_name(canvas, "imaginary part");
}
