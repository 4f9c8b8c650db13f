//! Error against run time as JSON, CSV and a picture.

use std::sync::Arc;

use serde_json::{Value, json};

use super::csv::quoted;
use super::json::header;
use super::motion::effort;
use super::work_precision::{self, Point};
use crate::base::place::Source;
use crate::motion::problem::Wanted;
use crate::study::accuracy::{Accuracy, Run};

/// The document.
pub fn json(
    sources: &[Arc<Source>],
    outputs: &[String],
    accuracy: &Accuracy,
    wanted: f64,
) -> Value {
    let reference = &accuracy.reference;
    let run = |run: &Run| {
        let mut row = effort(&run.effort, run.seconds);
        let (tolerance, step) = match run.wanted {
            Some(Wanted::Tolerance(x)) => (Some(x), None),
            Some(Wanted::Step(h)) => (None, Some(h)),
            None => (None, None),
        };
        if let Some(row) = row.as_object_mut() {
            row.insert("method".into(), json!(run.method));
            row.insert("tolerance".into(), json!(tolerance));
            row.insert("step_s".into(), json!(step));
            row.insert("error".into(), json!(run.error));
            row.insert(
                "status".into(),
                json!(run.failed.as_deref().unwrap_or("ok")),
            );
        }
        row
    };
    let best = accuracy.cheapest(wanted);
    let finite = |x: f64| x.is_finite().then_some(x);
    json!({
        "geardyn": header(sources, &["equations", "start", "reference", "ladder"]),
        "interrupted": accuracy.interrupted,
        "norm": "largest difference over all samples, by the largest size of the reference, worst output",
        "outputs": outputs,
        "reference": {
            "method": reference.method, "beside": reference.beside, "error": finite(reference.agreement),
            "amplification": finite(reference.amplification),
        },
        "runs": accuracy.runs.iter().map(run).collect::<Vec<_>>(),
        "recommendation": { "error": wanted, "method": best.map(|r| r.method), "run_time_s": best.map(|r| r.seconds) },
        "warnings": [],
    })
}

/// One row a run.
pub fn csv(accuracy: &Accuracy) -> String {
    let mut text = String::from(
        "method,tolerance,step_s,error,run_time_s,steps,rejected,rhs_evaluations,events,status\n",
    );
    for run in &accuracy.runs {
        let (tolerance, step) = match run.wanted {
            Some(Wanted::Tolerance(x)) => (format!("{x:e}"), String::new()),
            Some(Wanted::Step(h)) => (String::new(), format!("{h:e}")),
            None => Default::default(),
        };
        let error = run.error.map_or(String::new(), |e| format!("{e:e}"));
        let e = &run.effort;
        let status = quoted(run.failed.as_deref().unwrap_or("ok"));
        text += &format!(
            "{},{tolerance},{step},{error},{},{},{},{},{},{status}\n",
            run.method, run.seconds, e.steps, e.rejected, e.evaluations, e.events
        );
    }
    text
}

/// Error over run time, a line for each method.
pub fn draw(title: &str, accuracy: &Accuracy) -> String {
    let point = |run: &Run| {
        Some(Point {
            method: run.method,
            seconds: run.seconds,
            error: run.error?,
        })
    };
    let points: Vec<Point> = accuracy.runs.iter().filter_map(point).collect();
    let floor = (accuracy.reference.agreement, "agreement of references");
    work_precision::draw(title, &points, floor)
}
