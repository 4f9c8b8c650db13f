//! Figures as the script of a page reads them.

use serde_json::{Value, json};

use super::column::Columns;
use crate::report::figure::{
    Axis, COLOURS, Curve, Ink, LevelMap, Mark, NamePlacement, Plot, PlotColumn,
};
use crate::report::heatmap::{MapCells, MapColumn};
use crate::report::svg::LineStyle;

/// A column of plots with the end of its file's name.
pub fn plots(figure: &PlotColumn, suffix: &str, columns: &mut Columns) -> Value {
    let index = |i: &usize| *i as f64;
    let events: Vec<Value> = (figure.events.iter())
        .map(|e| {
            json!({
                "kind": e.kind, "name": e.name, "ink": e.ink % COLOURS, "x": columns.value(&e.x), "sources": e.sources,
                "source": columns.value(&e.source.iter().map(index).collect::<Vec<f64>>()),
            })
        })
        .collect();
    json!({
        "title": figure.title,
        "name": suffix.replace('-', " "),
        "note": figure.note,
        "linked": figure.linked,
        "events": events,
        "plots": figure.plots.iter().map(|p| plot(p, columns)).collect::<Vec<_>>(),
    })
}

fn plot(plot: &Plot, columns: &mut Columns) -> Value {
    let map = plot.map.as_ref().and_then(|m| map(m, columns));
    let guides = plot
        .guides
        .iter()
        .map(|g| json!({ "vertical": g.vertical, "at": g.at, "dotted": g.dotted, "name": g.name }));
    let bands = plot
        .bands
        .iter()
        .map(|b| json!({ "from": b.from, "to": b.to, "name": b.name }));
    let labels = plot
        .labels
        .iter()
        .map(|l| json!({ "x": l.x, "y": l.y, "text": l.text }));
    let [x, y] = plot.shown_units();
    json!({
        "x": axis(&plot.x, x),
        "y": axis(&plot.y, y),
        "height": plot.height,
        "equal": plot.equal_scales,
        "heading": plot.heading,
        "at_end": plot.names == NamePlacement::AtEnd,
        "map": map,
        "guides": guides.collect::<Vec<_>>(),
        "bands": bands.collect::<Vec<_>>(),
        "labels": labels.collect::<Vec<_>>(),
        "curves": plot.curves.iter().map(|c| curve(c, columns)).collect::<Vec<_>>(),
        "empty": plot.empty,
    })
}

/// Cells of a map on a page, across and down.
const CELLS: (usize, usize) = (800, 400);

fn map(map: &LevelMap, columns: &mut Columns) -> Option<Value> {
    let cells = MapCells::from_map(map, CELLS);
    let scale = cells.scale()?;
    let edges = |of: fn(&MapColumn) -> f64| cells.columns.iter().map(of).collect::<Vec<f64>>();
    let levels = cells
        .columns
        .iter()
        .flat_map(|c| c.levels.iter().map(|l| l.max(scale.0)));
    let levels: Vec<f64> = levels.collect();
    Some(json!({
        "label": map.label,
        "from": columns.value(&edges(|c| c.from)),
        "to": columns.value(&edges(|c| c.to)),
        "low": cells.low,
        "step": cells.step,
        "rows": cells.columns.first().map_or(0, |c| c.levels.len()),
        "scale": scale,
        "levels": columns.value(&levels),
    }))
}

/// An axis; the page shows its values times `factor`.
fn axis(axis: &Axis, (factor, label): (f64, String)) -> Value {
    json!({ "label": label, "factor": factor, "log": axis.logarithmic, "range": axis.range, "unit": axis.prefixed_unit, "ticks": axis.ticks })
}

fn curve(curve: &Curve, columns: &mut Columns) -> Value {
    let (ink, pale) = match curve.ink {
        Ink::Series(k) => (k % COLOURS, false),
        Ink::Pale(k) => (k % COLOURS, true),
        Ink::Faint => (6, false),
    };
    let (mark, size, style) = match curve.shown_mark() {
        Mark::Line(width, style) => ("line", width, style),
        Mark::Discs(radius) => ("discs", radius, LineStyle::Solid),
        Mark::Rings(radius) => ("rings", radius, LineStyle::Solid),
        Mark::Crosses(radius) => ("crosses", radius, LineStyle::Solid),
        Mark::Stems => ("stems", 2.2, LineStyle::Solid),
    };
    let dash = match style {
        LineStyle::Solid => "solid",
        LineStyle::Dashed => "dashed",
        LineStyle::Dotted => "dotted",
    };
    let (low, high): (Vec<f64>, Vec<f64>) = curve.interval.iter().copied().unzip();
    let along = curve.along.as_ref();
    json!({
        "name": curve.name,
        "along": along.map(|(label, values)| json!({ "label": label, "values": columns.value(values) })),
        "ink": ink,
        "pale": pale,
        "mark": mark,
        "size": size,
        "dash": dash,
        "x": columns.value(&curve.x),
        "y": columns.value(&curve.y),
        "low": columns.value(&low),
        "high": columns.value(&high),
        "radii": columns.value(&curve.radii),
    })
}
