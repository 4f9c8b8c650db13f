//! Reports as one HTML page that opens without a network: tables, interactive figures, warnings, steps.

mod column;
mod compact;
mod figure_json;

use std::collections::BTreeSet;

use serde_json::{Value, json};

use self::column::Columns;
use super::figure::{Figure, FigureContent};
use super::number_format::with_minus_signs;
use super::presentation::Presentation;
use super::view::{View, ViewKind};
use crate::base::error::Diagnostic;

const TEMPLATE: &str = include_str!("template.html");
const STYLE: &str = include_str!("page.css");
/// Scripts that share one scope, in dependency order.
const SCRIPTS: [&str; 5] = [
    include_str!("base.js"),
    include_str!("columns.js"),
    include_str!("marks.js"),
    include_str!("plot.js"),
    include_str!("page.js"),
];
const SPECTRUM_SCRIPT: &str = include_str!("line_spectrum.js");
const PLAYER_SCRIPT: &str = include_str!("kinds/player.js");
const MODE_VIEW_SCRIPT: &str = include_str!("kinds/mode_view.js");
const SPACE_SCRIPT: &str = include_str!("kinds/space.js");
const PLOT_STYLE: &str = include_str!("vendor/uPlot.min.css");
const PLOT_SCRIPT: &str = include_str!("vendor/uPlot.iife.min.js");
const PLOT_LICENCE: &str = include_str!("vendor/LICENSE");

/// Section of a page: one result with its warnings, figures and table.
#[derive(Debug, Clone)]
pub struct Section {
    heading: String,
    title: String,
    text: String,
    notes: String,
    warnings: Vec<Diagnostic>,
    views: Vec<View>,
    figures: Vec<Figure>,
    csv: String,
}

/// Abscissa label of the plots for which the script offers a spectrum.
const TIME: &str = "time, s";

/// Maximum size of a CSV table in a page, bytes; larger tables are omitted.
const MAX_TABLE: usize = 1 << 19;

impl Section {
    /// Section for a result with its figures, under a heading.
    pub fn new(heading: &str, result: &dyn Presentation, figures: Vec<Figure>) -> Section {
        let provenance = result.provenance();
        let repairs = provenance.repairs.unwrap_or_default().iter();
        let repairs: String = repairs
            .map(|r| format!("{}: {}\n", r.kind, r.message))
            .collect();
        let interruption = result.interruption().unwrap_or_default();
        let csv = result.table().csv();
        let views = result.views();
        let is_replaced = |f: &Figure| views.iter().any(|v| v.replaces.contains(&f.suffix));
        let figures = figures.into_iter().filter(|f| !is_replaced(f)).collect();
        Section {
            heading: heading.to_string(),
            title: provenance.title.to_string(),
            text: result.text(),
            notes: repairs + &result.notes() + &interruption,
            warnings: provenance.warnings.to_vec(),
            views,
            figures,
            csv: if csv.len() <= MAX_TABLE {
                csv
            } else {
                String::new()
            },
        }
    }

    /// Title of the scene, else of the first figure with a title, else the first line of the text.
    pub fn title(&self) -> &str {
        let figures = self.figures.iter().map(|figure| match &figure.content {
            FigureContent::Plots(plots) => plots.title.as_str(),
            FigureContent::Drawing(_) => "",
        });
        let mut titles = std::iter::once(self.title.as_str()).chain(figures);
        let first_line = self.text.lines().next().unwrap_or(&self.heading);
        titles.find(|t| !t.is_empty()).unwrap_or(first_line)
    }

    /// Whether a plot is over time, so that a spectrum is offered.
    fn is_over_time(&self) -> bool {
        let over_time = |figure: &Figure| match &figure.content {
            FigureContent::Plots(plots) => plots.plots.iter().any(|p| p.x.label == TIME),
            FigureContent::Drawing(_) => false,
        };
        self.figures.iter().any(over_time)
    }

    fn json(&self, columns: &mut Columns) -> Value {
        let warning =
            |w: &Diagnostic| json!({ "code": w.code, "message": w.message, "hint": w.hint });
        let mut view = |v: &View| json!({ "kind": v.kind.name(), "title": v.title, "data": columns.pack(&v.data) });
        let views: Vec<Value> = self.views.iter().map(&mut view).collect();
        let csv = columns.text(&self.csv);
        let figure = |figure: &Figure| match &figure.content {
            FigureContent::Plots(plots) => figure_json::plots(plots, figure.suffix, columns),
            FigureContent::Drawing(svg) => json!({ "svg": columns.text(svg) }),
        };
        json!({
            "heading": self.heading,
            "text": with_minus_signs(&self.text),
            "notes": self.notes,
            "warnings": self.warnings.iter().map(warning).collect::<Vec<_>>(),
            "views": views,
            "figures": self.figures.iter().map(figure).collect::<Vec<_>>(),
            "csv": csv,
        })
    }
}

/// HTML page of results, with the title of the machine or log and the command that reproduces it.
pub fn page(title: &str, command: &str, sections: &[Section]) -> String {
    let mut columns = Columns::default();
    let kinds: BTreeSet<ViewKind> = (sections.iter().flat_map(|s| &s.views))
        .map(|v| v.kind)
        .collect();
    let over_time = sections.iter().any(Section::is_over_time);
    let sections: Vec<Value> = sections.iter().map(|s| s.json(&mut columns)).collect();
    let version = env!("CARGO_PKG_VERSION");
    let data =
        json!({ "title": title, "command": command, "version": version, "sections": sections });
    // No text in the data can close the script element.
    let data = data.to_string().replace('<', "\\u003c");
    let parts = [
        ("{{title}}", escape(title)),
        (
            "{{style}}",
            format!("{PLOT_STYLE}\n{}", compact::style(STYLE)),
        ),
        ("{{licence}}", PLOT_LICENCE.to_string()),
        ("{{data}}", data),
        ("{{columns}}", columns.elements()),
        ("{{plot_script}}", PLOT_SCRIPT.to_string()),
        ("{{script}}", compact::script(&in_one_scope(&SCRIPTS))),
        ("{{kinds}}", kind_scripts(&kinds, over_time)),
    ];
    fill(TEMPLATE, &parts)
}

/// Wraps scripts in one function scope.
fn in_one_scope(scripts: &[&str]) -> String {
    format!("\"use strict\";\n(() => {{\n{}}})();\n", scripts.concat())
}

/// Script for the views of one kind.
fn kind_script(kind: ViewKind) -> &'static str {
    match kind {
        ViewKind::Modes => include_str!("kinds/modes.js"),
        ViewKind::Points => include_str!("kinds/points.js"),
        ViewKind::Teeth => include_str!("kinds/teeth.js"),
        ViewKind::Pair => include_str!("kinds/pair.js"),
        ViewKind::Surface => include_str!("kinds/surface.js"),
    }
}

/// Script elements for the spectrum and for the kinds of views of a page.
fn kind_scripts(kinds: &BTreeSet<ViewKind>, over_time: bool) -> String {
    // Scripts shared by several kinds come before those of the kinds.
    let any = |of: &[ViewKind], script| of.iter().any(|k| kinds.contains(k)).then_some(script);
    let shared = [
        over_time.then_some(SPECTRUM_SCRIPT),
        (!kinds.is_empty()).then_some(PLAYER_SCRIPT),
        any(&[ViewKind::Modes, ViewKind::Points], MODE_VIEW_SCRIPT),
        any(&[ViewKind::Pair, ViewKind::Surface], SPACE_SCRIPT),
    ];
    let list = (shared.into_iter().flatten()).chain(kinds.iter().map(|k| kind_script(*k)));
    list.map(|script| format!("<script>\n{}</script>\n", compact::script(script)))
        .collect()
}

/// Replaces the placeholders of a template in one pass; inserted text is not searched for placeholders.
fn fill(template: &str, parts: &[(&str, String)]) -> String {
    let mut page = String::new();
    let mut rest = template;
    while let Some(start) = rest.find("{{") {
        page += &rest[..start];
        rest = &rest[start..];
        match parts.iter().find(|(mark, _)| rest.starts_with(mark)) {
            Some((mark, text)) => {
                page += text;
                rest = &rest[mark.len()..];
            }
            None => {
                page += &rest[..2];
                rest = &rest[2..];
            }
        }
    }
    page + rest
}

/// Escapes a text for HTML.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            c => escaped.push(c),
        }
    }
    escaped
}
