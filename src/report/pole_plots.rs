//! Poles as plots: in the complex plane with zeros, and over the order of the model.

use super::axes::{linear_range, log_range};
use super::figure::{Axis, Curve, GREY_INK, Guide, Ink, Mark, Plot, PlotColumn};
use super::svg::{LineStyle, ticks};
use crate::base::text::pluralise;
use crate::numeric::Complex;

/// Poles (crosses) and zeros (rings), upper half plane, rad/s.
pub fn pole_zero(title: &str, poles: &[Complex], zeros: &[Complex]) -> PlotColumn {
    let upper: Vec<Complex> = zeros.iter().copied().filter(|z| z.im >= 0.0).collect();
    // Zeros far off would leave the poles in a corner.
    let reach = poles.iter().fold(0.0f64, |m, p| m.max(p.norm()));
    let is_near = |z: &&Complex| z.norm() <= 1.5 * reach;
    let near: Vec<Complex> = upper.iter().filter(is_near).copied().collect();
    let points = |name: &str, ink, mark, all: &[Complex]| {
        let (x, y) = all.iter().map(|z| (z.re, z.im)).unzip();
        Curve::new(name, ink, mark, x, y)
    };
    let range = |of: fn(&Complex) -> f64| {
        let all = poles.iter().chain(&near).map(of);
        linear_range(all.chain([0.0])).filter(|_| !poles.is_empty() || !near.is_empty())
    };
    let axis = |label: &str, of| Axis {
        range: range(of),
        ..Axis::linear(label)
    };
    let far = upper.len() - near.len();
    let plot = Plot {
        guides: vec![Guide {
            dotted: false,
            ..Guide::vertical(0.0)
        }],
        curves: vec![
            points(
                if near.is_empty() { "" } else { "zeros" },
                Ink::Series(1),
                Mark::Rings(4.0),
                &near,
            ),
            points("poles", Ink::Series(0), Mark::Crosses(4.5), poles),
        ],
        empty: "no poles",
        ..Plot::new(
            axis("real part, rad/s", |z| z.re),
            axis("imaginary part, rad/s", |z| z.im),
        )
    };
    PlotColumn {
        note: match far {
            0 => String::new(),
            far => format!("{} beyond the range shown", pluralise(far, "zero")),
        },
        ..PlotColumn::one(title, plot)
    }
}

/// Stability of a pole of one order relative to those of the order before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlottedStability {
    /// Frequency, damping and shape agree.
    Stable,
    /// The frequency agrees.
    Frequency,
    /// Nothing agrees.
    New,
}

/// A stabilisation diagram as plain data.
#[derive(Debug, Clone, Default)]
pub struct StabilisationPlot {
    /// Above it.
    pub title: String,
    /// Poles: order, frequency Hz, how steady.
    pub poles: Vec<(usize, f64, PlottedStability)>,
    /// Frequencies selected, Hz.
    pub selected_hz: Vec<f64>,
    /// Lines behind, Hz, and the level drawn over them.
    pub level: (Vec<f64>, Vec<f64>),
    /// The band, Hz.
    pub band_hz: (f64, f64),
}

/// The figure of a stabilisation diagram.
pub fn stabilisation(shown: &StabilisationPlot) -> PlotColumn {
    let highest = shown.poles.iter().map(|p| p.0).max().unwrap_or(1) as f64;
    let orders = ticks((0.0, highest), 8).into_iter();
    let y = Axis {
        ticks: orders.filter(|t| t.fract() == 0.0).collect(),
        ..Axis::linear("order").over(0.0, highest + 1.0)
    };
    // The level has no axis of its own: it fills the height in decades.
    let level = log_range(shown.level.1.iter().copied()).map(|(low, high)| {
        let height = |v: &f64| (highest + 1.0) * ((v.log10() - low) / (high - low)).clamp(0.0, 1.0);
        let y = shown.level.1.iter().map(height).collect();
        let mark = Mark::Line(1.6, LineStyle::Solid);
        Curve::new(
            "level of the responses",
            Ink::Faint,
            mark,
            shown.level.0.clone(),
            y,
        )
    });
    let poles = [
        ("new", PlottedStability::New, GREY_INK, Mark::Discs(0.9)),
        (
            "frequency stable",
            PlottedStability::Frequency,
            Ink::Series(1),
            Mark::Rings(2.4),
        ),
        (
            "stable",
            PlottedStability::Stable,
            Ink::Series(0),
            Mark::Discs(2.4),
        ),
    ];
    let poles = poles.into_iter().map(|(name, stability, ink, mark)| {
        let those = shown.poles.iter().filter(|p| p.2 == stability);
        let (x, y) = those.map(|p| (p.1, p.0 as f64)).unzip();
        Curve::new(name, ink, mark, x, y)
    });
    let plot = Plot {
        guides: shown
            .selected_hz
            .iter()
            .map(|f| Guide::vertical(*f))
            .collect(),
        curves: level.into_iter().chain(poles).collect(),
        ..Plot::new(
            Axis::linear("frequency, Hz").over(shown.band_hz.0, shown.band_hz.1),
            y,
        )
    };
    PlotColumn {
        note: "dotted: selected".to_string(),
        ..PlotColumn::one(&shown.title, plot)
    }
}
