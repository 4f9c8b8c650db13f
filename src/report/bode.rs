//! Frequency responses as pictures: magnitude, phase and coherence over frequency; measured against fitted; in the complex plane.

use super::axes::{decades, frame, rule_decades, runs, span};
use super::style::{
    Anchor, BLACK, BLUE, Canvas, GREY, Ink, ORANGE, Panel, SMALL, Stroke, TITLE, WIDTH, paler,
    picture, shortened, ticks, width_of,
};
use crate::numeric::Complex;

/// One response.
#[derive(Debug, Clone, Default)]
pub struct Curve {
    /// What it is called.
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

/// What a Bode picture shows.
#[derive(Debug, Clone, Default)]
pub struct Bode {
    /// Above it.
    pub title: String,
    /// What it is over; frequency in Hz where empty.
    pub across: &'static str,
    /// Lines, in the unit of what it is over.
    pub frequency_hz: Vec<f64>,
    /// Responses; the first few are drawn.
    pub curves: Vec<Curve>,
    /// Identified natural frequencies, Hz.
    pub modes_hz: Vec<f64>,
}

/// Responses drawn at once: more cannot be told apart.
const MOST: usize = 4;

const INKS: [Ink; MOST] = [BLUE, ORANGE, BLACK, GREY];

const LEFT: f64 = 70.0;
const TALL: f64 = 230.0;
const LOW: f64 = 110.0;
const FLAT: f64 = 70.0;
const GAP: f64 = 16.0;

/// Magnitude, phase and, where it was measured, coherence.
pub fn bode(shown: &Bode) -> String {
    let curves = &shown.curves[..shown.curves.len().min(MOST)];
    let coherent = curves.iter().any(|c| c.coherence.is_some());
    let axis = match shown.across {
        "" => "frequency, Hz",
        across => across,
    };
    let top = 52.0;
    let heights = [TALL, LOW, if coherent { FLAT } else { 0.0 }];
    let mut at = top;
    let mut panels = Vec::new();
    for height in heights.into_iter().filter(|h| *h > 0.0) {
        panels.push((at, at + height));
        at += height + GAP;
    }
    picture(WIDTH, at + 36.0, |canvas| {
        heading(canvas, &shown.title, curves, shown.curves.len());
        let sizes = || {
            curves
                .iter()
                .flat_map(|c| c.measured.iter().map(|z| z.norm()))
        };
        let (Some(&first), Some(&last), Some(y)) = (
            shown.frequency_hz.first(),
            shown.frequency_hz.last(),
            decades(sizes()),
        ) else {
            canvas.text(
                "no response",
                (WIDTH / 2.0, at / 2.0),
                TITLE,
                GREY,
                Anchor::Middle,
            );
            return;
        };
        let across = (LEFT, WIDTH - 24.0);
        let panel = |down, y| Panel {
            across,
            down,
            x: (first, last),
            y,
        };
        let magnitude = panel(panels[0], y);
        rule_decades(&magnitude, canvas);
        let units: Vec<&str> = curves
            .iter()
            .map(|c| c.unit.as_str())
            .filter(|u| !u.is_empty())
            .collect();
        let unit = match units.first() {
            Some(unit) if units.iter().all(|u| u == unit) => format!("magnitude, {unit}"),
            _ => "magnitude".to_string(),
        };
        frame(&magnitude, canvas, &unit, None);
        let phase = panel(panels[1], (-190.0, 190.0));
        phase.rule_y(canvas, &[-180.0, -90.0, 0.0, 90.0, 180.0]);
        frame(&phase, canvas, "phase, deg", (!coherent).then_some(axis));
        let coherence = coherent.then(|| panel(panels[2], (0.0, 1.05)));
        if let Some(coherence) = &coherence {
            coherence.rule_y(canvas, &[0.0, 0.5, 1.0]);
            frame(coherence, canvas, "coherence", Some(axis));
        }
        for &f in shown.modes_hz.iter().filter(|f| (first..=last).contains(f)) {
            for panel in [&magnitude, &phase] {
                let right = panel.right_of(f);
                canvas.path(
                    &[(right, panel.down.0), (right, panel.down.1)],
                    GREY,
                    0.6,
                    Stroke::Dotted,
                );
            }
        }
        for (curve, ink) in curves.iter().zip(INKS) {
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
                paler(ink)
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
    ink: Ink,
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
    for run in runs(panel, points.into_iter()) {
        canvas.path(&run, ink, width, Stroke::Solid);
    }
}

fn heading(canvas: &mut Canvas, title: &str, curves: &[Curve], all: usize) {
    canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
    let mut right = LEFT;
    let fitted = curves.iter().any(|c| c.fitted.is_some());
    for (curve, ink) in curves.iter().zip(INKS) {
        canvas.line((right, 36.0), (right + 18.0, 36.0), ink, 2.0);
        let label = shortened(&curve.label, 28);
        canvas.text(&label, (right + 23.0, 36.0), SMALL, BLACK, Anchor::Start);
        right += 23.0 + width_of(&label, SMALL) + 16.0;
    }
    let mut remark = String::new();
    if fitted {
        remark += "broad and pale: measured, narrow: fitted";
    }
    if all > curves.len() {
        remark += &format!(
            "{}{} of {all} responses",
            if fitted { "; " } else { "" },
            curves.len()
        );
    }
    canvas.text(&remark, (WIDTH - 24.0, 16.0), SMALL, GREY, Anchor::End);
}

/// The responses in the complex plane, equal scales; points measured, lines fitted.
pub fn nyquist(shown: &Bode) -> String {
    const SIDE: f64 = 560.0;
    let curves = &shown.curves[..shown.curves.len().min(MOST)];
    let top = 52.0;
    picture(WIDTH, top + SIDE + 52.0, |canvas| {
        heading(canvas, &shown.title, curves, shown.curves.len());
        let all = || {
            curves
                .iter()
                .flat_map(|c| c.measured.iter().chain(&c.traced))
        };
        let (Some(re), Some(im)) = (span(all().map(|z| z.re)), span(all().map(|z| z.im))) else {
            canvas.text(
                "no response",
                (WIDTH / 2.0, top + SIDE / 2.0),
                TITLE,
                GREY,
                Anchor::Middle,
            );
            return;
        };
        // Equal scales: the larger range decides, the picture being wider than high.
        let across = (LEFT, WIDTH - 24.0);
        let scale = ((re.1 - re.0) / (across.1 - across.0)).max((im.1 - im.0) / SIDE);
        let about = |range: (f64, f64), length: f64| {
            let middle = 0.5 * (range.0 + range.1);
            (middle - 0.5 * scale * length, middle + 0.5 * scale * length)
        };
        let panel = Panel {
            across,
            down: (top, top + SIDE),
            x: about(re, across.1 - across.0),
            y: about(im, SIDE),
        };
        grid(canvas, &panel);
        for (curve, ink) in curves.iter().zip(INKS) {
            let known = curve.traced.iter().filter(|z| z.is_finite());
            let points: Vec<_> = known.map(|z| panel.at(z.re, z.im)).collect();
            canvas.path(&points, ink, 1.0, Stroke::Solid);
            if curve.computed {
                let known = curve.measured.iter().filter(|z| z.is_finite());
                let points: Vec<_> = known.map(|z| panel.at(z.re, z.im)).collect();
                canvas.path(&points, ink, 1.2, Stroke::Solid);
                continue;
            }
            // Points closer together than their own size are one.
            let (mut last, radius) = ((f64::NAN, f64::NAN), 1.1);
            for z in curve
                .measured
                .iter()
                .filter(|z| z.re.is_finite() && z.im.is_finite())
            {
                let spot = panel.at(z.re, z.im);
                if !((spot.0 - last.0).hypot(spot.1 - last.1) < 0.5 * radius) {
                    canvas.disc(spot, radius, ink);
                    last = spot;
                }
            }
        }
    })
}

/// The grid of the complex plane.
fn grid(canvas: &mut Canvas, panel: &Panel) {
    panel.rule_x(canvas, &ticks(panel.x, 8));
    panel.rule_y(canvas, &ticks(panel.y, 6));
    canvas.frame(
        (panel.across.0, panel.down.0),
        (panel.across.1, panel.down.1),
        GREY,
        0.6,
    );
    canvas.text(
        "real part",
        (0.5 * (panel.across.0 + panel.across.1), panel.down.1 + 28.0),
        SMALL,
        BLACK,
        Anchor::Middle,
    );
    canvas.upright(
        "imaginary part",
        (14.0, 0.5 * (panel.down.0 + panel.down.1)),
        SMALL,
        BLACK,
        Anchor::Middle,
    );
}
