//! Work–precision results as JSON, CSV and plot.

use std::sync::Arc;

use serde_json::{Value, json};

use super::json::header;
use super::modes_csv::csv_field;
use super::simulation::effort;
use super::work_precision_plot::{self, WorkPrecisionPoint};
use super::work_precision_text::{NORM_TEXT, recommendation_text, tolerance_and_step};
use crate::base::source_span::SourceFile;
use crate::study::reference::CrossCheck;
use crate::study::work_precision::{
    Recommendation, RunOutcome, WorkPrecisionResult, WorkPrecisionRun,
};

/// The document.
pub fn json(
    sources: &[Arc<SourceFile>],
    outputs: &[String],
    accuracy: &WorkPrecisionResult,
    wanted: f64,
) -> Value {
    let reference = &accuracy.reference;
    let near = reference.cross_checks.first();
    let witness = |w: &CrossCheck| {
        let (tolerance, step) = tolerance_and_step(w.step_size);
        json!({ "method": w.method, "tolerance": tolerance, "step_s": step, "related": w.related, "distance": w.distance })
    };
    let (tolerance, step) = tolerance_and_step(reference.step_size);
    let silent = |(method, why): &(&str, String)| json!({ "method": method, "reason": why });
    json!({
        "geardyn": header(sources, &["equations", "start", "reference", "ladder"]),
        "interrupted": accuracy.interrupted,
        "norm": NORM_TEXT,
        "outputs": outputs,
        "reference": {
            "method": reference.method, "tolerance": tolerance, "step_s": step, "beside": near.map(|w| w.method),
            "error": near.map(|w| w.distance), "amplification": reference.sensitivity,
            "witnesses": reference.cross_checks.iter().map(witness).collect::<Vec<_>>(),
            "silent": reference.unavailable.iter().map(silent).collect::<Vec<_>>(),
        },
        "runs": accuracy.runs.iter().map(row).collect::<Vec<_>>(),
        "recommendation": recommendation(accuracy, wanted),
        "warnings": [],
    })
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

/// One row a rung.
pub fn csv(accuracy: &WorkPrecisionResult) -> String {
    let mut text = String::from(
        "method,tolerance,step_s,error,run_time_s,steps,rejected,rhs_evaluations,events,status\n",
    );
    let power = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:e}"));
    for run in &accuracy.runs {
        let (tolerance, step) = tolerance_and_step(run.step_size);
        let cost = match &run.outcome {
            RunOutcome::Completed {
                seconds, stats: e, ..
            } => format!(
                "{seconds},{},{},{},{}",
                e.steps, e.rejected, e.evaluations, e.events
            ),
            _ => ",,,,".to_string(),
        };
        text += &format!(
            "{},{},{},{},{cost},{}\n",
            run.method,
            power(tolerance),
            power(step),
            power(run.error()),
            csv_field(run.reason().unwrap_or("ok"))
        );
    }
    text
}

/// Error over run time, a line for each method.
pub fn draw(title: &str, accuracy: &WorkPrecisionResult) -> String {
    let point = |run: &WorkPrecisionRun| {
        Some(WorkPrecisionPoint {
            method: run.method,
            seconds: run.seconds()?,
            error: run.error()?,
        })
    };
    let points: Vec<WorkPrecisionPoint> = accuracy.runs.iter().filter_map(point).collect();
    let floor = accuracy.reference.agreement().unwrap_or(0.0);
    work_precision_plot::draw(title, &points, (floor, "agreement of references"))
}
