//! What ways to one answer cost, as JSON, CSV and a picture.

use std::sync::Arc;

use serde_json::{Value, json};

use super::csv::quoted;
use super::json::header;
use super::ways_words::advice;
use super::work_precision::{self, Point};
use crate::base::place::Source;
use crate::study::ways::{Size, Way, Ways};

/// The document.
pub fn json(sources: &[Arc<Source>], found: &Ways, wanted: f64) -> Value {
    let run = |way: &Way| {
        let [coordinates, modes, lengths] = sizes(way);
        json!({
            "method": way.method, "coordinates": coordinates, "modes": modes, "lengths": lengths, "error": way.error,
            "run_time_s": way.seconds, "status": way.failed.as_deref().unwrap_or("ok"),
        })
    };
    let best = found.cheapest(wanted).or(found.nearest());
    let reached = found.cheapest(wanted).is_some();
    let [coordinates, modes, lengths] = best.map_or([None; 3], sizes);
    json!({
        "geardyn": header(sources, &["freedoms", "reference", "ladder"]),
        "interrupted": found.interrupted,
        "compared": found.compared,
        "norm": found.norm,
        "freedoms": found.freedoms,
        "reference": { "method": found.reference, "error": found.reference_error },
        "runs": found.list.iter().map(run).collect::<Vec<_>>(),
        "recommendation": {
            "error": wanted, "reached": reached, "method": best.map(|w| w.method), "coordinates": coordinates, "modes": modes,
            "lengths": lengths, "run_time_s": best.map(|w| w.seconds), "error_reached": best.and_then(|w| w.error),
            "text": advice(found, wanted),
        },
        "warnings": [],
    })
}

/// One row a way.
pub fn csv(found: &Ways) -> String {
    let mut text = String::from("method,coordinates,modes,lengths,error,run_time_s,status\n");
    for way in &found.list {
        let sizes = sizes(way).map(|n| n.map_or(String::new(), |n| n.to_string()));
        text += &format!(
            "{},{},{},{},{}\n",
            quoted(way.method),
            sizes.join(","),
            way.error.map_or(String::new(), |e| format!("{e:e}")),
            way.seconds,
            quoted(way.failed.as_deref().unwrap_or("ok")),
        );
    }
    text
}

/// Error over run time, a line for each way.
pub fn draw(title: &str, found: &Ways) -> String {
    let point = |way: &Way| {
        Some(Point {
            method: way.method,
            seconds: way.seconds,
            error: way.error?,
        })
    };
    let points: Vec<Point> = found.list.iter().filter_map(point).collect();
    work_precision::draw(
        title,
        &points,
        (found.reference_error, "error of the reference"),
    )
}

/// Coordinates, modes, lengths: the one that was chosen.
fn sizes(way: &Way) -> [Option<usize>; 3] {
    match way.size {
        Some(Size::Coordinates(n)) => [Some(n), None, None],
        Some(Size::Modes(n)) => [None, Some(n), None],
        Some(Size::Lengths(n)) => [None, None, Some(n)],
        None => [None; 3],
    }
}
