//! Comparison of solution methods (error and run time) as JSON, CSV and plot.

use std::sync::Arc;

use serde_json::{Value, json};

use super::json::header;
use super::method_comparison_text::recommendation_text;
use super::modes_csv::csv_field;
use super::work_precision_plot::{self, WorkPrecisionPoint};
use crate::base::source_span::SourceFile;
use crate::study::comparison::{ComparedMethod, ComparisonResult, ModelSize};

/// The document.
pub fn json(sources: &[Arc<SourceFile>], found: &ComparisonResult, wanted: f64) -> Value {
    let run = |compared_method: &ComparedMethod| {
        let [coordinates, modes, lengths] = sizes(compared_method);
        json!({
            "method": compared_method.method, "coordinates": coordinates, "modes": modes, "lengths": lengths, "error": compared_method.error,
            "run_time_s": compared_method.seconds, "status": compared_method.failure.as_deref().unwrap_or("ok"),
        })
    };
    let best = found.cheapest(wanted).or(found.most_accurate());
    let reached = found.cheapest(wanted).is_some();
    let [coordinates, modes, lengths] = best.map_or([None; 3], sizes);
    json!({
        "geardyn": header(sources, &["freedoms", "reference", "ladder"]),
        "interrupted": found.interrupted,
        "compared": found.quantity,
        "norm": found.norm,
        "freedoms": found.dofs,
        "reference": { "method": found.reference, "error": found.reference_error },
        "runs": found.methods.iter().map(run).collect::<Vec<_>>(),
        "recommendation": {
            "error": wanted, "reached": reached, "method": best.map(|w| w.method), "coordinates": coordinates, "modes": modes,
            "lengths": lengths, "run_time_s": best.map(|w| w.seconds), "error_reached": best.and_then(|w| w.error),
            "text": recommendation_text(found, wanted),
        },
        "warnings": [],
    })
}

/// One row a way.
pub fn csv(found: &ComparisonResult) -> String {
    let mut text = String::from("method,coordinates,modes,lengths,error,run_time_s,status\n");
    for compared_method in &found.methods {
        let sizes = sizes(compared_method).map(|n| n.map_or(String::new(), |n| n.to_string()));
        text += &format!(
            "{},{},{},{},{}\n",
            csv_field(compared_method.method),
            sizes.join(","),
            compared_method
                .error
                .map_or(String::new(), |e| format!("{e:e}")),
            compared_method.seconds,
            csv_field(compared_method.failure.as_deref().unwrap_or("ok")),
        );
    }
    text
}

/// Error over run time, a line for each way.
pub fn draw(title: &str, found: &ComparisonResult) -> String {
    let point = |compared_method: &ComparedMethod| {
        Some(WorkPrecisionPoint {
            method: compared_method.method,
            seconds: compared_method.seconds,
            error: compared_method.error?,
        })
    };
    let points: Vec<WorkPrecisionPoint> = found.methods.iter().filter_map(point).collect();
    work_precision_plot::draw(
        title,
        &points,
        (found.reference_error, "error of the reference"),
    )
}

/// Coordinates, modes, lengths: the one that was chosen.
fn sizes(method: &ComparedMethod) -> [Option<usize>; 3] {
    match method.size {
        Some(ModelSize::Coordinates(n)) => [Some(n), None, None],
        Some(ModelSize::Modes(n)) => [None, Some(n), None],
        Some(ModelSize::ShaftElements(n)) => [None, None, Some(n)],
        None => [None; 3],
    }
}
