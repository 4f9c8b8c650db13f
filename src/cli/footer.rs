//! Footer of a result: repairs, notes, warnings, files written.

use std::path::Path;

use crate::base::error::Diagnostic;
use crate::recording::raw::Repair;
use crate::report::presentation::Presentation;

use super::render;

/// Repairs of the data, a line each.
pub fn repairs(repairs: &[Repair]) -> String {
    let line = |r: &Repair| format!("{}: {}\n", r.kind, render::sanitise(&r.message));
    repairs.iter().map(line).collect()
}

/// Repairs, notes and warnings of a result, and why it ends early; after a blank line, unless there are none.
pub fn notes(result: &dyn Presentation) -> String {
    let about = result.provenance();
    let mut text = repairs(about.repairs.unwrap_or_default());
    text += &result.notes();
    if !result.warnings_first() {
        text += &warnings(about.warnings);
    }
    text += &result.interruption().unwrap_or_default();
    match text.is_empty() {
        true => text,
        false => format!("\n{text}"),
    }
}

/// Warnings, as diagnostics.
pub fn warnings(diagnostics: &[Diagnostic]) -> String {
    let coloured = render::use_colour();
    let text = |w| render::render_diagnostic(w, coloured);
    diagnostics.iter().map(text).collect()
}

/// Names the outputs that an interrupt has left as they were; nothing where the result is `whole`.
pub fn not_written(outputs: &[impl AsRef<Path>], whole: bool) -> String {
    match whole || outputs.is_empty() {
        true => String::new(),
        false => format!("not written: {}\n", names(outputs)),
    }
}

/// Names what was written; nothing where nothing was.
pub fn written_files(files: &[impl AsRef<Path>]) -> String {
    match files.is_empty() {
        true => String::new(),
        false => format!("wrote {}\n", names(files)),
    }
}

fn names(files: &[impl AsRef<Path>]) -> String {
    let name = |f: &_| render::sanitise(&AsRef::<Path>::as_ref(f).display().to_string());
    files.iter().map(name).collect::<Vec<_>>().join(" ")
}
