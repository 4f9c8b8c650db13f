//! Frequency-domain decomposition plot: singular values, SDOF bells, autocovariance decay.

use super::figure::{
    Axis, BLACK_INK, Curve, GREY_INK, Guide, Ink, Mark, Plot, PlotColumn, PointLabel,
};
use super::svg::LineStyle;

/// A decomposition as plain data.
#[derive(Debug, Clone, Default)]
pub struct FddPlot {
    /// Above it.
    pub title: String,
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Singular values over these lines, the largest first.
    pub singular_values: Vec<Vec<f64>>,
    /// Labelled peaks: Hz, value, text.
    pub labels: Vec<(f64, f64, String)>,
    /// Bells by rising frequency.
    pub bells: Vec<PlottedBell>,
    /// Between these shares of the decay its line is laid.
    pub fitted: (f64, f64),
}

/// A bell and its decay.
#[derive(Debug, Clone, Default)]
pub struct PlottedBell {
    /// Annotation next to the decays.
    pub words: String,
    /// Lines, Hz, and density.
    pub lines: Vec<(f64, f64)>,
    /// Cycles and share left.
    pub decay: Vec<(f64, f64)>,
    /// Natural logarithm at no lag, and its slope per cycle.
    pub line: Option<(f64, f64)>,
}

/// One ink after the other, so that neighbours differ.
fn ink(k: usize) -> Ink {
    Ink::Series([1, 0, 4, 5][k % 4])
}

/// The figure: decays only where there are some.
pub fn figure(shown: &FddPlot) -> PlotColumn {
    let has_decays = shown.bells.iter().any(|b| !b.decay.is_empty());
    let mut plots = vec![singular_values(shown)];
    plots.extend(has_decays.then(|| decays(shown)));
    PlotColumn {
        title: shown.title.clone(),
        plots,
        ..PlotColumn::default()
    }
}

fn singular_values(shown: &FddPlot) -> Plot {
    let value = |(k, values): (usize, &Vec<f64>)| {
        let (name, ink, width) = match k {
            0 => ("largest singular value", BLACK_INK, 0.9),
            _ => ("other singular values", GREY_INK, 0.5),
        };
        let mark = Mark::Line(width, LineStyle::Solid);
        Curve::new(name, ink, mark, shown.frequency_hz.clone(), values.clone())
    };
    let bell = |(k, bell): (usize, &PlottedBell)| {
        let (x, y) = bell.lines.iter().copied().unzip();
        Curve::new("", ink(k), Mark::Line(2.2, LineStyle::Solid), x, y)
    };
    let values = shown.singular_values.iter().enumerate().rev().map(value);
    let label = |(x, y, text): &(f64, f64, String)| PointLabel {
        x: *x,
        y: *y,
        text: text.clone(),
    };
    Plot {
        height: 330.0,
        curves: values
            .chain(shown.bells.iter().enumerate().map(bell))
            .collect(),
        labels: shown.labels.iter().map(label).collect(),
        ..Plot::new(Axis::linear("frequency, Hz"), Axis::log("singular values"))
    }
}

fn decays(shown: &FddPlot) -> Plot {
    let curves = shown.bells.iter().enumerate().flat_map(|(k, bell)| {
        let (x, y) = bell.decay.iter().copied().unzip();
        let decay = Curve::new(&bell.words, ink(k), Mark::Discs(1.1), x, y);
        let end = bell.decay.last().map_or(0.0, |p| p.0);
        let line = bell.line.map(|(start, slope)| {
            let at = |cycles: f64| (start + slope * cycles).exp();
            let mark = Mark::Line(0.8, LineStyle::Solid);
            Curve::new("", ink(k), mark, vec![0.0, end], vec![at(0.0), at(end)])
        });
        [Some(decay), line].into_iter().flatten()
    });
    let shares = [shown.fitted.0, shown.fitted.1];
    Plot {
        height: 210.0,
        heading: "a line is fitted to each decay between the dotted levels".to_string(),
        guides: shares.iter().map(|s| Guide::horizontal(*s)).collect(),
        curves: curves.collect(),
        ..Plot::new(
            Axis::linear("cycles"),
            Axis::log("autocovariance of the bell"),
        )
    }
}
