//! Work–precision results of a motion: document, tables, recommendation.

use std::iter::once;

use serde_json::{Value, json};

use super::figure::Figure;
use super::output_key::effort;
use super::presentation::{INTERRUPTED_TEXT, Presentation, Provenance};
use super::sensitivity;
use super::table::{Table, decimal, or_blank, power};
use super::work_precision_plot::{self, WorkPrecisionPoint};
use super::work_precision_text::{
    NORM_TEXT, format_error, format_time_short, method_label, recommendation_text, setting_text,
    tolerance_and_step,
};
use crate::base::error::Error;
use crate::scene::Scene;
use crate::study::reference::{CrossCheck, ReferenceSolution};
use crate::study::work_precision::{
    Recommendation, RunOutcome, WorkPrecisionResult, WorkPrecisionRun,
};

/// A motion by several methods against a reference: error over run time.
pub struct WorkPrecisionReport<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The outputs compared.
    pub outputs: Vec<String>,
    /// The error for which a method is recommended.
    pub target_error: f64,
    /// The runs.
    pub result: WorkPrecisionResult,
}

impl Presentation for WorkPrecisionReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance {
            title: &self.scene.model.title,
            sources: &self.scene.sources,
            trace: vec!["equations", "start", "reference", "runs"],
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let (outputs, accuracy, wanted) = (&self.outputs, &self.result, self.target_error);
        let reference = &accuracy.reference;
        let near = reference.cross_checks.first();
        let witness = |w: &CrossCheck| {
            let (tolerance, step) = tolerance_and_step(w.step_size);
            json!({ "method": w.method, "tolerance": tolerance, "step_s": step, "related": w.related, "distance": w.distance })
        };
        let (tolerance, step) = tolerance_and_step(reference.step_size);
        let silent = |(method, why): &(&str, String)| json!({ "method": method, "reason": why });
        Ok(json!({
            "interrupted": accuracy.interrupted,
            "norm": NORM_TEXT,
            "outputs": outputs,
            "reference": {
                "method": reference.method, "tolerance": tolerance, "step_s": step, "witness": near.map(|w| w.method),
                "error": near.map(|w| w.distance), "amplification": reference.amplification.map(|a| a.factor),
                "is_lower_bound": reference.amplification.is_some_and(|a| a.is_lower_bound),
                "witnesses": reference.cross_checks.iter().map(witness).collect::<Vec<_>>(),
                "silent": reference.unavailable.iter().map(silent).collect::<Vec<_>>(),
            },
            "runs": accuracy.runs.iter().map(row).collect::<Vec<_>>(),
            "recommendation": recommendation(accuracy, wanted),
        }))
    }

    fn text(&self) -> String {
        let (outputs, accuracy, wanted) = (&self.outputs, &self.result, self.target_error);
        let mut text = format!(
            "error in {} ({NORM_TEXT}) against run time\n{}\n",
            outputs.join(", "),
            reference(&accuracy.reference)
        );
        let mut table = Table::named("method|at|error|time|steps|rejected|evaluations|events");
        let known = accuracy.reference.agreement();
        for run in &accuracy.runs {
            let RunOutcome::Completed {
                error,
                seconds,
                stats: e,
            } = &run.outcome
            else {
                continue;
            };
            let count = |n: u64| match n {
                0 => "–".to_string(),
                n => n.to_string(),
            };
            let sign = match known.is_some_and(|known| *error <= known) {
                true => "≤ ",
                false => "",
            };
            table.row([
                run.method.to_string(),
                setting_text(run.step_size),
                format!("{sign}{}", format_error(*error)),
                format_time_short(*seconds),
                count(e.steps),
                count(e.rejected),
                count(e.evaluations),
                count(e.events),
            ]);
        }
        text += &table.text();
        text += &failed_runs_text(&accuracy.runs);
        text += &format!("\n{}\n", recommendation_text(accuracy, wanted));
        text
    }

    fn table(&self) -> Table<'_> {
        let accuracy = &self.result;
        let mut table = Table::new(
            "method|tolerance|step_s|error|run_time_s|steps|rejected|rhs_evaluations|events|status",
        );
        for run in &accuracy.runs {
            let (tolerance, step) = tolerance_and_step(run.step_size);
            let cost = match &run.outcome {
                RunOutcome::Completed {
                    seconds, stats: e, ..
                } => {
                    let counts = [e.steps, e.rejected, e.evaluations, e.events];
                    once(decimal(*seconds))
                        .chain(counts.map(|n| n.to_string()))
                        .collect()
                }
                _ => vec![String::new(); 5],
            };
            let set = [tolerance, step, run.error()].map(|x| or_blank(x, power));
            let status = run.reason().unwrap_or("ok").to_string();
            let cells = once(run.method.to_string()).chain(set).chain(cost);
            table.row(cells.chain(once(status)));
        }
        table
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let point = |run: &WorkPrecisionRun| {
            Some(WorkPrecisionPoint {
                method: run.method,
                seconds: run.seconds()?,
                error: run.error()?,
            })
        };
        let points: Vec<_> = self.result.runs.iter().filter_map(point).collect();
        let floor = self.result.reference.agreement().unwrap_or(0.0);
        let (title, floor) = (&self.scene.model.title, (floor, "agreement of references"));
        Ok(vec![Figure::first(work_precision_plot::figure(
            title, &points, floor,
        ))])
    }

    fn interruption(&self) -> Option<String> {
        self.result
            .interrupted
            .then(|| INTERRUPTED_TEXT.to_string())
    }
}

fn row(run: &WorkPrecisionRun) -> Value {
    let mut row = match &run.outcome {
        RunOutcome::Completed {
            seconds, stats: e, ..
        } => effort(e, *seconds),
        _ => json!({ "run_time_s": null }),
    };
    let (tolerance, step) = tolerance_and_step(run.step_size);
    if let Some(row) = row.as_object_mut() {
        row.insert("method".into(), json!(run.method));
        row.insert("tolerance".into(), json!(tolerance));
        row.insert("step_s".into(), json!(step));
        row.insert("error".into(), json!(run.error()));
        row.insert("status".into(), json!(run.reason().unwrap_or("ok")));
    }
    row
}

fn recommendation(accuracy: &WorkPrecisionResult, wanted: f64) -> Value {
    let (run, reached) = match accuracy.recommend(wanted) {
        Recommendation::Cheapest(run, _) => (Some(run), true),
        Recommendation::Nearest(run) => (Some(run), false),
        Recommendation::Unavailable => (None, false),
    };
    let (tolerance, step) = tolerance_and_step(run.and_then(|r| r.step_size));
    json!({
        "error": wanted, "reached": reached, "method": run.map(|r| r.method), "tolerance": tolerance, "step_s": step,
        "run_time_s": run.and_then(WorkPrecisionRun::seconds), "error_reached": run.and_then(WorkPrecisionRun::error),
        "text": recommendation_text(accuracy, wanted),
    })
}

/// Reference of the errors, and its own accuracy.
fn reference(reference: &ReferenceSolution) -> String {
    let own = method_label(reference.method, reference.step_size);
    let other = |w: &CrossCheck| method_label(w.method, w.step_size);
    let mut text = match &reference.cross_checks[..] {
        [] => format!("reference: {own} only, not verified\n"),
        [near, ..] if near.related => format!(
            "reference: {own}, {} from itself at {}; not verified by an unrelated method\n",
            format_error(near.distance),
            setting_text(near.step_size),
        ),
        [near, rest @ ..] => {
            let mut text = format!(
                "reference: {own}; {}, an unrelated method, agrees to {}, below which no error can be measured\n",
                other(near),
                format_error(near.distance)
            );
            for far in rest {
                text += &format!(
                    "           {} agrees to {}\n",
                    other(far),
                    format_error(far.distance)
                );
            }
            text
        }
    };
    for (method, why) in &reference.unavailable {
        text += &format!("           {method}: {why}\n");
    }
    text + &match reference.amplification {
        Some(found) => format!("{}\n", sensitivity::factor_text(Some(found))),
        None => {
            "sensitivity to initial conditions not measured: no deformation, or a run ended early\n"
                .to_string()
        }
    }
}

/// Rungs without an error, those of one method with one reason in a line.
fn failed_runs_text(runs: &[WorkPrecisionRun]) -> String {
    let mut table = Table::texts("||");
    let mut before = None;
    let rows = runs.iter().filter_map(|r| Some((r, r.reason()?)));
    for (place, (run, why)) in rows.clone().enumerate() {
        if before == Some((run.method, why)) {
            continue;
        }
        before = Some((run.method, why));
        let alike = rows.clone().skip(place + 1);
        let more = alike
            .take_while(|(r, other)| (r.method, *other) == (run.method, why))
            .count();
        let rungs = match more {
            0 => setting_text(run.step_size),
            _ => format!("{} and finer", setting_text(run.step_size)),
        };
        table.row([run.method.to_string(), rungs, why.to_string()]);
    }
    match table.row_count() {
        0 => String::new(),
        _ => format!("\nleft out or failed\n{}", table.text()),
    }
}
