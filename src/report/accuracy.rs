//! Error against run time as JSON, CSV and a picture.

use std::sync::Arc;

use serde_json::{Value, json};

use super::accuracy_words::{NORM, advice, asked};
use super::csv::quoted;
use super::json::header;
use super::motion::effort;
use super::work_precision::{self, Point};
use crate::base::place::Source;
use crate::study::accuracy::{Accuracy, Advice, Outcome, Run};
use crate::study::reference::Witness;

/// The document.
pub fn json(
    sources: &[Arc<Source>],
    outputs: &[String],
    accuracy: &Accuracy,
    wanted: f64,
) -> Value {
    let reference = &accuracy.reference;
    let near = reference.witnesses.first();
    let witness = |w: &Witness| {
        let (tolerance, step) = asked(w.wanted);
        json!({ "method": w.method, "tolerance": tolerance, "step_s": step, "related": w.related, "distance": w.distance })
    };
    let (tolerance, step) = asked(reference.wanted);
    let silent = |(method, why): &(&str, String)| json!({ "method": method, "reason": why });
    json!({
        "geardyn": header(sources, &["equations", "start", "reference", "ladder"]),
        "interrupted": accuracy.interrupted,
        "norm": NORM,
        "outputs": outputs,
        "reference": {
            "method": reference.method, "tolerance": tolerance, "step_s": step, "beside": near.map(|w| w.method),
            "error": near.map(|w| w.distance), "amplification": reference.amplification,
            "witnesses": reference.witnesses.iter().map(witness).collect::<Vec<_>>(),
            "silent": reference.silent.iter().map(silent).collect::<Vec<_>>(),
        },
        "runs": accuracy.runs.iter().map(row).collect::<Vec<_>>(),
        "recommendation": recommendation(accuracy, wanted),
        "warnings": [],
    })
}

fn row(run: &Run) -> Value {
    let mut row = match &run.outcome {
        Outcome::Ended {
            seconds, effort: e, ..
        } => effort(e, *seconds),
        _ => json!({ "run_time_s": null }),
    };
    let (tolerance, step) = asked(run.wanted);
    if let Some(row) = row.as_object_mut() {
        row.insert("method".into(), json!(run.method));
        row.insert("tolerance".into(), json!(tolerance));
        row.insert("step_s".into(), json!(step));
        row.insert("error".into(), json!(run.error()));
        row.insert("status".into(), json!(run.reason().unwrap_or("ok")));
    }
    row
}

fn recommendation(accuracy: &Accuracy, wanted: f64) -> Value {
    let (run, reached) = match accuracy.advice(wanted) {
        Advice::Cheapest(run, _) => (Some(run), true),
        Advice::Nearest(run) => (Some(run), false),
        Advice::Nothing => (None, false),
    };
    let (tolerance, step) = asked(run.and_then(|r| r.wanted));
    json!({
        "error": wanted, "reached": reached, "method": run.map(|r| r.method), "tolerance": tolerance, "step_s": step,
        "run_time_s": run.and_then(Run::seconds), "error_reached": run.and_then(Run::error),
        "text": advice(accuracy, wanted),
    })
}

/// One row a rung.
pub fn csv(accuracy: &Accuracy) -> String {
    let mut text = String::from(
        "method,tolerance,step_s,error,run_time_s,steps,rejected,rhs_evaluations,events,status\n",
    );
    let power = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:e}"));
    for run in &accuracy.runs {
        let (tolerance, step) = asked(run.wanted);
        let cost = match &run.outcome {
            Outcome::Ended {
                seconds, effort: e, ..
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
            quoted(run.reason().unwrap_or("ok"))
        );
    }
    text
}

/// Error over run time, a line for each method.
pub fn draw(title: &str, accuracy: &Accuracy) -> String {
    let point = |run: &Run| {
        Some(Point {
            method: run.method,
            seconds: run.seconds()?,
            error: run.error()?,
        })
    };
    let points: Vec<Point> = accuracy.runs.iter().filter_map(point).collect();
    let floor = accuracy.reference.agreement().unwrap_or(0.0);
    work_precision::draw(title, &points, (floor, "agreement of references"))
}
