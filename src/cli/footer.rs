//! Footer of a result: repairs, plan steps, warnings, files written.

use std::path::Path;

use crate::base::error::Diagnostic;
use crate::plan::stages::StageDecision;
use crate::recording::raw::Repair;

use super::render;

/// What was done to the data, a line each.
pub fn repairs(repairs: &[Repair]) -> String {
    let line = |r: &Repair| format!("{}: {}\n", r.kind, render::sanitise(&r.message));
    repairs.iter().map(line).collect()
}

/// What a plan does and what it leaves out, a line each.
pub fn plan_steps<'a>(plan: impl IntoIterator<Item = &'a (&'static str, StageDecision)>) -> String {
    let line = |(name, decision): &(&str, StageDecision)| match decision {
        StageDecision::Runs(what) => format!("{name}: {what}\n"),
        StageDecision::LeftOut(why) => format!("left out {name}: {why}\n"),
    };
    plan.into_iter().map(line).collect()
}

/// What a plan leaves out, a line each.
pub fn omitted_steps(plan: &[(&'static str, StageDecision)]) -> String {
    plan_steps(
        plan.iter()
            .filter(|(_, v)| matches!(v, StageDecision::LeftOut(_))),
    )
}

/// Warnings, as diagnostics.
pub fn warnings(diagnostics: &[Diagnostic]) -> String {
    let coloured = render::use_colour();
    let text = |w| render::render_diagnostic(w, coloured);
    diagnostics.iter().map(text).collect()
}

/// Names the outputs that an interrupt has left as they were; nothing where the answer is `whole`.
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
    let name = |f: &_| AsRef::<Path>::as_ref(f).display().to_string();
    files.iter().map(name).collect::<Vec<_>>().join(" ")
}
