//! Plans with the steps that run and those left out: as text, as lines below a result, in the document.

use serde_json::{Value, json};

use super::table::Table;
use crate::plan::stages::StageDecision;

/// The steps of a plan.
pub fn steps<'a>(
    plan: &'a [(&'static str, StageDecision)],
) -> impl Iterator<Item = (&'a str, &'a StageDecision)> + Clone {
    plan.iter().map(|(name, decision)| (*name, decision))
}

/// The plan: what runs, what is left out and why.
pub fn text<'a>(steps: impl Iterator<Item = (&'a str, &'a StageDecision)>) -> String {
    let (mut runs, mut left_out) = (Table::texts("|"), Table::texts("|"));
    for (name, decision) in steps {
        match decision {
            StageDecision::Runs(what) => runs.row([name, what]),
            StageDecision::LeftOut(why) => left_out.row([name, why]),
        }
    }
    format!("{}\nleft out\n{}", runs.text(), left_out.text())
}

/// The steps of a plan, a line each.
pub fn step_lines<'a>(steps: impl Iterator<Item = (&'a str, &'a StageDecision)>) -> String {
    let line = |(name, decision): (&str, &StageDecision)| match decision {
        StageDecision::Runs(what) => format!("{name}: {what}\n"),
        StageDecision::LeftOut(why) => format!("left out {name}: {why}\n"),
    };
    steps.map(line).collect()
}

/// The steps that a plan leaves out, a line each.
pub fn omitted_steps(plan: &[(&'static str, StageDecision)]) -> String {
    step_lines(steps(plan).filter(|s| matches!(s.1, StageDecision::LeftOut(_))))
}

/// Stages with what they do or why they are left out.
pub fn stages<'a>(steps: impl Iterator<Item = (&'a str, &'a StageDecision)>) -> Value {
    let stage = |(name, decision): (&str, &StageDecision)| match decision {
        StageDecision::Runs(what) => json!({ "stage": name, "runs": true, "what": what }),
        StageDecision::LeftOut(why) => json!({ "stage": name, "runs": false, "why": why }),
    };
    steps.map(stage).collect()
}
