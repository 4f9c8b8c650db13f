//! Amplitude over speed: stable and unstable branches, folds, bifurcations, parametric bands.

use super::axes::linear_range;
use super::figure::{Axis, Band, Curve, GREY_INK, Ink, Mark, Plot, PlotColumn, PointLabel};
use super::svg::LineStyle;

/// Contents of an amplitude plot.
#[derive(Debug, Clone, Default)]
pub struct AmplitudePlot {
    /// Above it.
    pub title: String,
    /// Name of the horizontal axis.
    pub across: String,
    /// Name of the vertical axis.
    pub up: String,
    /// Speed, amplitude and whether it is stable, along the curve.
    pub points: Vec<(f64, f64, bool)>,
    /// Curves next to it, of motions of two periods.
    pub others: Vec<Vec<(f64, f64, bool)>>,
    /// Places with a name: speed, amplitude, text.
    pub marks: Vec<(f64, f64, String)>,
    /// Jumps: speed, from, to.
    pub jumps: Vec<(f64, f64, f64)>,
    /// Bands of speed with a name.
    pub bands: Vec<(f64, f64, String)>,
}

/// The figure.
pub fn amplitude_figure(shown: &AmplitudePlot) -> PlotColumn {
    let all = || shown.points.iter().chain(shown.others.iter().flatten());
    let axis = |label: &str, range| Axis {
        range,
        ..Axis::linear(label)
    };
    let x = axis(&shown.across, linear_range(all().map(|p| p.0)));
    let up = linear_range(all().map(|p| p.1).chain([0.0]));
    let y = axis(&shown.up, up.map(|(_, high)| (0.0, high)));
    let jump = |&(speed, from, to): &(f64, f64, f64)| {
        let mark = Mark::Line(0.8, LineStyle::Dotted);
        Curve::new("jump", GREY_INK, mark, vec![speed; 2], vec![from, to])
    };
    let label = |(x, y, text): &(f64, f64, String)| PointLabel {
        x: *x,
        y: *y,
        text: text.clone(),
    };
    let doubled = shown
        .others
        .iter()
        .flat_map(|o| branch(o, 0.8, " of two periods"));
    let plot = Plot {
        bands: (shown.bands.iter())
            .map(|(from, to, name)| Band {
                from: *from,
                to: *to,
                name: name.clone(),
            })
            .collect(),
        curves: (shown.jumps.iter().map(jump))
            .chain(branch(&shown.points, 1.6, ""))
            .chain(doubled)
            .collect(),
        labels: shown.marks.iter().map(label).collect(),
        ..Plot::new(x, y)
    };
    PlotColumn::one(&shown.title, plot)
}

/// Runs of a branch: stable motions as lines, unstable ones dashed.
fn branch(points: &[(f64, f64, bool)], width: f64, kind: &str) -> Vec<Curve> {
    let mut last: Option<&(f64, f64, bool)> = None;
    let runs = points.chunk_by(|a, b| a.2 == b.2).map(|run| {
        // A run begins where the one before it ended, so that the curve has no gap.
        let (x, y) = last.into_iter().chain(run).map(|p| (p.0, p.1)).unzip();
        last = run.last();
        match run[0].2 {
            true => Curve::new(
                format!("stable{kind}"),
                Ink::Series(0),
                Mark::Line(width, LineStyle::Solid),
                x,
                y,
            ),
            false => Curve::new(
                format!("unstable{kind}"),
                Ink::Series(1),
                Mark::Line(width - 0.2, LineStyle::Dashed),
                x,
                y,
            ),
        }
    });
    runs.collect()
}
