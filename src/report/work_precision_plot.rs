//! Work–precision plot: error over run time, both logarithmic, one curve per method.

use super::figure::{Axis, Curve, Guide, Ink, Mark, NamePlacement, Plot, PlotColumn};
use super::svg::LineStyle;

/// Errors below this are rounding of the reference.
const FLOOR: f64 = 1e-17;

/// One run in the plot.
#[derive(Debug, Clone, Copy)]
pub struct WorkPrecisionPoint {
    /// The method, whose points are joined.
    pub method: &'static str,
    /// Run time, s.
    pub seconds: f64,
    /// Relative error.
    pub error: f64,
}

/// Work–precision plot: error over run time, both logarithmic, a line for each method; below the floor no error is measurable.
pub fn figure(
    title: &str,
    points: &[WorkPrecisionPoint],
    (floor, called): (f64, &str),
) -> PlotColumn {
    let error = |p: &WorkPrecisionPoint| p.error.max(FLOOR);
    let mut methods: Vec<&str> = Vec::new();
    for point in points {
        if !methods.contains(&point.method) {
            methods.push(point.method);
        }
    }
    let curve = |(k, method): (usize, &&str)| {
        let own = || points.iter().filter(|p| p.method == *method);
        let [x, y] = [
            own().map(|p| p.seconds).collect(),
            own().map(error).collect(),
        ];
        let strokes = [LineStyle::Solid, LineStyle::Dashed, LineStyle::Dotted];
        let stroke = strokes[(k / 6) % strokes.len()];
        let line = Curve::new(*method, Ink::Series(k), Mark::Line(1.4, stroke), x, y);
        let points = Curve {
            name: String::new(),
            mark: Mark::Discs(3.0),
            ..line.clone()
        };
        [line, points]
    };
    let known = floor > 0.0 && floor.is_finite();
    let guide = known.then(|| Guide::horizontal(floor));
    let note = known.then(|| format!("dotted: {called}, {floor:.1e}"));
    let (low, high) = points
        .iter()
        .map(error)
        .fold((f64::INFINITY, 0.0f64), |(l, h), e| (l.min(e), h.max(e)));
    const HALF_DECADE: f64 = 3.2;
    const LARGEST: f64 = 1e3;
    let x = Axis {
        prefixed_unit: Some("s"),
        ..Axis::log("run time")
    };
    let y = Axis {
        range: (low <= high).then(|| (low / HALF_DECADE, high.min(LARGEST) * HALF_DECADE)),
        ..Axis::log("error")
    };
    let figure = PlotColumn::one(
        title,
        Plot {
            guides: guide.into_iter().collect(),
            curves: methods.iter().enumerate().flat_map(curve).collect(),
            names: NamePlacement::AtEnd,
            empty: "no run completed",
            ..Plot::new(x, y)
        },
    );
    PlotColumn {
        note: note.unwrap_or_default(),
        ..figure
    }
}
