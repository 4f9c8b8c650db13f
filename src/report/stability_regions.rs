//! Stability regions in the hλ plane and amplification factor per step of every method.

use super::figure::{Axis, BLACK_INK, Band, Curve, GREY_INK, Guide, Ink, Mark, Plot, PlotColumn};
use super::svg::LineStyle;
use crate::base::quantity::format_time;
use crate::numeric::Complex;
use crate::study::stability::amplification::{
    AmplificationChart, AmplificationCurve, stability_boundary,
};
use crate::study::stability::linear::LinearStability;

/// The plane of hλ, with one scale on both axes.
const RE: (f64, f64) = (-8.0, 13.0);
const IM: (f64, f64) = (-0.5, 9.5);

/// Largest factor shown, and the reciprocal of the least; values beyond lie on the edge.
const LARGEST: f64 = 1e6;

/// Side of the boundaries on which methods are stable.
const INSIDE: &str = "explicit methods are stable inside their curves, implicit ones outside";

/// Line of a method: dashed for those of a fixed formula for position and speed.
fn line_style(method: &str) -> (Ink, LineStyle) {
    match method {
        "rk4" => (GREY_INK, LineStyle::Solid),
        "dopri5" => (Ink::Series(1), LineStyle::Solid),
        "dop853" => (Ink::Series(0), LineStyle::Solid),
        "newmark" => (GREY_INK, LineStyle::Dashed),
        "hht" => (Ink::Series(1), LineStyle::Dashed),
        "generalized-alpha" => (Ink::Series(0), LineStyle::Dashed),
        _ => (BLACK_INK, LineStyle::Solid),
    }
}

/// Regions of stability with the eigenvalues times the step, and the factor of every method on each of them over |hλ|.
pub fn stability_regions(
    title: &str,
    facts: &LinearStability,
    spectrum: &AmplificationChart,
) -> PlotColumn {
    PlotColumn {
        title: title.to_string(),
        plots: vec![regions(facts, spectrum), amplification(spectrum)],
        ..PlotColumn::default()
    }
}

fn regions(facts: &LinearStability, spectrum: &AmplificationChart) -> Plot {
    let boundary = |method: &AmplificationCurve| {
        let curve = stability_boundary(method.method);
        let (ink, stroke) = line_style(method.method);
        let upper = curve.iter().filter(|z| z.im >= -0.02);
        let (x, y) = upper.map(|z| (z.re, z.im)).unzip();
        (!curve.is_empty()).then(|| Curve::new(method.method, ink, Mark::Line(1.6, stroke), x, y))
    };
    let places = facts.eigenvalues.iter().map(|z| *z * spectrum.step);
    let is_shown = |z: &Complex| (RE.0..=RE.1).contains(&z.re) && z.im.abs() <= IM.1;
    let (shown, beyond): (Vec<Complex>, Vec<Complex>) = places.partition(is_shown);
    let further = match beyond.len() {
        0 => String::new(),
        n => format!(", {n} beyond the edge"),
    };
    let name = format!("eigenvalues times {}{further}", format_time(spectrum.step));
    let (x, y) = shown.iter().map(|z| (z.re, z.im.abs())).unzip();
    let eigenvalues = Curve::new(name, BLACK_INK, Mark::Rings(3.0), x, y);
    let always: Vec<&str> = spectrum.unconditionally_stable().collect();
    let across = Axis::linear("Re hλ").over(RE.0, RE.1);
    Plot {
        equal_scales: true,
        heading: match always.is_empty() {
            true => INSIDE.to_string(),
            false => format!(
                "{INSIDE}; shaded: left half-plane, stable at any step for {}",
                always.join(", ")
            ),
        },
        bands: vec![Band {
            from: RE.0,
            to: 0.0,
            name: String::new(),
        }],
        curves: spectrum
            .methods
            .iter()
            .filter_map(boundary)
            .chain([eigenvalues])
            .collect(),
        ..Plot::new(across, Axis::linear("Im hλ").over(IM.0, IM.1))
    }
}

fn amplification(spectrum: &AmplificationChart) -> Plot {
    let clamp = |y: f64| y.clamp(1.0 / LARGEST, LARGEST);
    let points = |m: &&AmplificationCurve| [m.undamped.clone(), m.eigenvalues.clone()].concat();
    let all: Vec<(f64, f64)> = spectrum.methods.iter().flat_map(|m| points(&m)).collect();
    // A decade to each side of one at least.
    let ends = all.iter().fold((0.1f64, 10.0f64), |(low, high), (_, y)| {
        (low.min(clamp(*y)), high.max(clamp(*y)))
    });
    let curves = spectrum.methods.iter().flat_map(|method| {
        let (ink, stroke) = line_style(method.method);
        let of = |points: &[(f64, f64)]| -> (Vec<f64>, Vec<f64>) {
            points.iter().map(|(x, y)| (*x, clamp(*y))).unzip()
        };
        let (x, y) = of(&method.undamped);
        let line = Curve::new(method.method, ink, Mark::Line(1.4, stroke), x, y);
        let (x, y) = of(&method.eigenvalues);
        [line, Curve::new("", ink, Mark::Rings(2.4), x, y)]
    });
    let decades = spectrum.decade_range();
    let across = Axis::log("|hλ|").over(10f64.powf(decades.0), 10f64.powf(decades.1));
    Plot {
        height: 280.0,
        heading: "factor of one step: lines without damping, rings at the eigenvalues; above 1 the mode grows".to_string(),
        guides: vec![Guide {
            dotted: false,
            ..Guide::horizontal(1.0)
        }],
        curves: curves.collect(),
        ..Plot::new(across, Axis::log("amplification factor").over(ends.0, ends.1))
    }
}
