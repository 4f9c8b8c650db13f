//! Document, text and figures of worm pairs, crossed pairs and helicoids.

use serde_json::{Map, Value, json};

use super::figure::{Axis, Figure, PlotColumn, PointLabel};
use super::gear::{geometry_json, member_table, title_lines};
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance};
use super::table::{Table, decimal, or_dash};
use super::turning_view::turning_view;
use super::view::View;
use crate::base::error::Error;
use crate::plan::gear::sheet::{GearSheet, SheetColumn, SheetPlot, SheetTable};

/// Rows of a table that the text shows; documents and CSV files hold all.
const SHOWN_ROWS: usize = 12;

impl Presentation for GearSheet {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_plan(
            std::slice::from_ref(&self.source),
            &self.plan,
            &self.diagnostics,
        )
    }

    fn body(&self) -> Result<Value, Error> {
        let mut body = Map::new();
        body.insert("title".into(), json!(self.title));
        body.insert("kind".into(), json!(self.kind));
        let geometry = Value::Object(geometry_json(&self.quantities));
        body.insert("geometry".into(), geometry);
        for table in &self.tables {
            body.insert(key(table.name, ""), table_json(table));
        }
        Ok(Value::Object(body))
    }

    fn text(&self) -> String {
        let mut text = title_lines(&self.title);
        text += &member_table(self.members, &self.quantities).text();
        for table in &self.tables {
            let (shown, step) = shown(table);
            text += &format!("\n{}", shown.text());
            if step > 1 {
                text += &format!("one row in {step} of `{}`; --json has all\n", table.name);
            }
        }
        text
    }

    /// The main table.
    fn table(&self) -> Table<'_> {
        let columns = self.tables.iter().take(1).flat_map(|table| &table.columns);
        columns.fold(Table::default(), |table, column| {
            table.numbers(
                &key(column.name, ""),
                column.unit,
                column.values.clone(),
                decimal,
            )
        })
    }

    fn notes(&self) -> String {
        step_lines(steps(&self.plan))
    }

    fn views(&self) -> Vec<View> {
        let pair = self.in_space.iter();
        pair.map(|pair| turning_view(pair, self.members)).collect()
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let figures = self.plots.iter();
        Ok(figures
            .map(|plot| Figure::new(plot.suffix, drawn(&self.title, plot)))
            .collect())
    }
}

/// A name as a key: words by underscores, with the unit.
fn key(name: &str, unit: &str) -> String {
    let words = name.replace(' ', "_");
    match unit {
        "" => words,
        _ => format!(
            "{words}_{}",
            unit.replace('/', "_per_")
                .replace("1_per", "per")
                .replace('µ', "u")
        ),
    }
}

fn table_json(table: &SheetTable) -> Value {
    let column = |c: &SheetColumn| (key(c.name, c.unit), json!(c.values));
    Value::Object(table.columns.iter().map(column).collect())
}

/// Every n-th row of a table, with its name above the first column, and n.
fn shown(table: &SheetTable) -> (Table<'static>, usize) {
    let heads = table.columns.iter().map(|c| match c.unit {
        "" => c.name.to_string(),
        unit => format!("{} [{unit}]", c.name),
    });
    let heads: Vec<String> = heads.collect();
    let mut shown = Table::numeric(&format!("{}: {}", table.name, heads.join("|")));
    let count = table.columns.first().map_or(0, |c| c.values.len());
    let step = count.div_ceil(SHOWN_ROWS).max(1);
    for row in (0..count).step_by(step) {
        shown.row(table.columns.iter().map(|c| {
            let value = Some(c.values[row]).filter(|x| x.is_finite());
            or_dash(value, |x| format!("{x:.4}"))
        }));
    }
    (shown, step)
}

pub(super) fn drawn(title: &str, plot: &SheetPlot) -> PlotColumn {
    let [x, y] = plot.axes.map(Axis::linear);
    let mut figure = PlotColumn::of_lines(title, (x, y), plot.curves.iter().cloned());
    for drawn in &mut figure.plots {
        drawn.equal_scales = plot.equal_scales;
        let labels = plot.labels.iter().cloned();
        drawn.labels = labels
            .map(|([x, y], text)| PointLabel { x, y, text })
            .collect();
    }
    figure
}
