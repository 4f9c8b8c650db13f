//! Regions of stability in the plane of hλ, and below them what a step of every method makes of each mode of a machine.

use super::axes::{frame, rule_decades, runs};
use super::style::{
    Anchor, BLACK, BLUE, Canvas, FAINT, GREY, Ink, ORANGE, Panel, SMALL, Spot, Stroke, TITLE,
    WIDTH, paler, picture, ticks, width_of,
};
use crate::base::units::seconds;
use crate::study::stability::amplification::{Spectrum, boundary};
use crate::study::stability::facts::Facts;

const LEFT: f64 = 70.0;
const RIGHT: f64 = 24.0;
const TOP: f64 = 56.0;

/// The plane of hλ, with one scale on both axes.
const RE: (f64, f64) = (-8.0, 13.0);
const IM: (f64, f64) = (-0.5, 9.5);

/// Height of the panel of factors, and room between both.
const FACTORS: f64 = 280.0;
const BETWEEN: f64 = 92.0;

/// How a method is drawn: those of a fixed formula for position and speed in dashes.
fn look(method: &str) -> (Ink, Stroke) {
    match method {
        "rk4" => (GREY, Stroke::Solid),
        "dopri5" => (ORANGE, Stroke::Solid),
        "dop853" => (BLUE, Stroke::Solid),
        "newmark" => (GREY, Stroke::Dashed),
        "hht" => (ORANGE, Stroke::Dashed),
        "generalized-alpha" => (BLUE, Stroke::Dashed),
        _ => (BLACK, Stroke::Solid),
    }
}

/// Regions of stability with the eigenvalues times the step, and the factor of every method on each of them over |hλ|.
pub fn regions(title: &str, facts: &Facts, spectrum: &Spectrum) -> String {
    let across = (LEFT, WIDTH - RIGHT);
    let high = (across.1 - across.0) * (IM.1 - IM.0) / (RE.1 - RE.0);
    let middle = TOP + high + BETWEEN;
    picture(WIDTH, middle + FACTORS + 44.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let plane = Panel {
            across,
            down: (TOP, TOP + high),
            x: RE,
            y: IM,
        };
        in_the_plane(canvas, &plane, facts, spectrum);
        let factors = Panel {
            across,
            down: (middle, middle + FACTORS),
            x: spectrum.sizes(),
            y: range_of_factors(spectrum),
        };
        over_size(canvas, &factors, spectrum);
    })
}

/// Powers of ten of the factors shown, a decade to each side of one at least; what lies beyond six stands on the edge.
fn range_of_factors(spectrum: &Spectrum) -> (f64, f64) {
    const MOST: f64 = 6.0;
    let points = spectrum
        .methods
        .iter()
        .flat_map(|m| m.line.iter().chain(&m.marks));
    points.fold((-1.0, 1.0), |(low, high): (f64, f64), (_, y)| {
        let y = y.log10().clamp(-MOST, MOST);
        (low.min(y), high.max(y))
    })
}

fn in_the_plane(canvas: &mut Canvas, panel: &Panel, facts: &Facts, spectrum: &Spectrum) {
    canvas.block(
        panel.at(RE.0, IM.1),
        panel.at(0.0, IM.0),
        paler(paler(FAINT)),
    );
    panel.rule_y(canvas, &ticks(panel.y, 8));
    frame(panel, canvas, "Im hλ", Some("Re hλ"));
    let always = spectrum.always_stable().collect::<Vec<_>>().join(", ");
    let words = ["left half-plane: no step is too long for", always.as_str()];
    for (row, text) in words.into_iter().enumerate() {
        let down = TOP + 14.0 + 15.0 * row as f64;
        canvas.text(text, (LEFT + 8.0, down), SMALL, BLACK, Anchor::Start);
    }
    let mut right = LEFT;
    for course in &spectrum.methods {
        let curve = boundary(course.method);
        if curve.is_empty() {
            continue;
        }
        let (ink, stroke) = look(course.method);
        let spots: Vec<Spot> = curve
            .iter()
            .filter(|z| z.im >= -0.02)
            .map(|z| panel.at(z.re, z.im))
            .collect();
        canvas.path(&spots, ink, 1.6, stroke);
        let side = match course.limited {
            true => "stable inside",
            false => "outside",
        };
        let text = format!("{}, {side}", course.method);
        right = entry(canvas, (right, 36.0), &text, ink, stroke);
    }
    let label = format!("eigenvalues times {}", seconds(spectrum.step));
    canvas.ring((right + 8.0, 36.0), 3.0, BLACK, 1.2);
    canvas.text(&label, (right + 18.0, 36.0), SMALL, BLACK, Anchor::Start);
    let places = facts.eigenvalues.iter().map(|z| *z * spectrum.step);
    let (shown, beyond): (Vec<_>, Vec<_>) =
        places.partition(|z| (RE.0..=RE.1).contains(&z.re) && z.im.abs() <= IM.1);
    for z in shown {
        canvas.ring(panel.at(z.re, z.im.abs()), 3.0, BLACK, 1.2);
    }
    if !beyond.is_empty() {
        let text = format!("{} beyond the edge", beyond.len());
        let place = (LEFT + 8.0, TOP + 48.0);
        canvas.text(&text, place, SMALL, BLACK, Anchor::Start);
    }
}

fn over_size(canvas: &mut Canvas, panel: &Panel, spectrum: &Spectrum) {
    rule_decades(panel, canvas);
    canvas.frame(
        (panel.across.0, panel.down.0),
        (panel.across.1, panel.down.1),
        GREY,
        0.6,
    );
    let beside = (14.0, 0.5 * (panel.down.0 + panel.down.1));
    canvas.upright("factor of a step", beside, SMALL, BLACK, Anchor::Middle);
    let (first, last) = (panel.x.0.ceil() as i32, panel.x.1.floor() as i32);
    let every = ((last - first) / 10).max(1) as usize;
    for decade in (first..=last).step_by(every) {
        let right = panel.right_of(f64::from(decade));
        canvas.line((right, panel.down.0), (right, panel.down.1), FAINT, 0.5);
        let text = format!("1e{decade}");
        let place = (right, panel.down.1 + 11.0);
        canvas.text(&text, place, SMALL, BLACK, Anchor::Middle);
    }
    let under = (0.5 * (panel.across.0 + panel.across.1), panel.down.1 + 28.0);
    canvas.text("|hλ|", under, SMALL, BLACK, Anchor::Middle);
    let one = panel.height_of(0.0);
    canvas.line((panel.across.0, one), (panel.across.1, one), GREY, 0.8);
    let above = panel.down.0 - 30.0;
    canvas.text(
        "what a step makes of a mode: lines without damping, rings at the eigenvalues; above 1 it grows",
        (LEFT, above),
        SMALL,
        BLACK,
        Anchor::Start,
    );
    let mut right = LEFT;
    for course in &spectrum.methods {
        let (ink, stroke) = look(course.method);
        let line = course.line.iter().map(|(x, y)| (x.log10(), y.log10()));
        for run in runs(panel, line) {
            canvas.path(&run, ink, 1.4, stroke);
        }
        for (x, y) in &course.marks {
            let height = y.log10().clamp(panel.y.0, panel.y.1);
            canvas.ring(panel.at(x.log10(), height), 2.4, ink, 1.0);
        }
        right = entry(canvas, (right, above + 16.0), course.method, ink, stroke);
    }
}

/// A line with its name; where the next entry begins.
fn entry(canvas: &mut Canvas, (right, down): Spot, text: &str, ink: Ink, stroke: Stroke) -> f64 {
    canvas.path(&[(right, down), (right + 18.0, down)], ink, 2.0, stroke);
    canvas.text(text, (right + 23.0, down), SMALL, BLACK, Anchor::Start);
    right + 23.0 + width_of(text, SMALL) + 18.0
}
