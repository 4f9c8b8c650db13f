//! What is said below an answer: what was done to the data, what runs and what is left out, doubts, files written.

use std::path::Path;

use crate::base::error::Warning;
use crate::plan::stages::Verdict;
use crate::recording::raw::Repair;

use super::diagnostic;

/// What was done to the data, a line each.
pub fn repairs(repairs: &[Repair]) -> String {
    let line = |r: &Repair| format!("{}: {}\n", r.kind, diagnostic::harmless(&r.message));
    repairs.iter().map(line).collect()
}

/// What a plan does and what it leaves out, a line each.
pub fn steps<'a>(plan: impl IntoIterator<Item = &'a (&'static str, Verdict)>) -> String {
    let line = |(name, verdict): &(&str, Verdict)| match verdict {
        Verdict::Runs(what) => format!("{name}: {what}\n"),
        Verdict::LeftOut(why) => format!("left out {name}: {why}\n"),
    };
    plan.into_iter().map(line).collect()
}

/// What a plan leaves out, a line each.
pub fn left_out(plan: &[(&'static str, Verdict)]) -> String {
    steps(
        plan.iter()
            .filter(|(_, v)| matches!(v, Verdict::LeftOut(_))),
    )
}

/// Doubts, as diagnostics.
pub fn warnings(warnings: &[Warning]) -> String {
    let coloured = diagnostic::colour();
    let text = |w| diagnostic::warning(w, coloured);
    warnings.iter().map(text).collect()
}

/// Names the outputs that an interrupt has left as they were; nothing where the answer is `whole`.
pub fn not_written(outputs: &[impl AsRef<Path>], whole: bool) -> String {
    match whole || outputs.is_empty() {
        true => String::new(),
        false => format!("not written: {}\n", names(outputs)),
    }
}

/// Names what was written; nothing where nothing was.
pub fn written(files: &[impl AsRef<Path>]) -> String {
    match files.is_empty() {
        true => String::new(),
        false => format!("wrote {}\n", names(files)),
    }
}

fn names(files: &[impl AsRef<Path>]) -> String {
    let name = |f: &_| AsRef::<Path>::as_ref(f).display().to_string();
    files.iter().map(name).collect::<Vec<_>>().join(" ")
}
