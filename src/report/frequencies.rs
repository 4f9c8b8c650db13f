//! What the lowest natural frequencies cost, as JSON, CSV and a picture.

use std::f64::consts::TAU;
use std::sync::Arc;

use serde_json::{Value, json};

use super::csv::quoted;
use super::json::header;
use super::work_precision::{self, Point};
use crate::base::place::Source;
use crate::study::frequencies::{Frequencies, Size, Way};

/// The document.
pub fn json(sources: &[Arc<Source>], found: &Frequencies, wanted: f64) -> Value {
    let run = |way: &Way| {
        let (coordinates, lengths) = match way.size {
            Some(Size::Coordinates(n)) => (Some(n), None),
            Some(Size::Lengths(n)) => (None, Some(n)),
            None => (None, None),
        };
        json!({
            "method": way.method, "coordinates": coordinates, "lengths": lengths, "error": way.error,
            "run_time_s": way.seconds, "status": way.failed.as_deref().unwrap_or("ok"),
        })
    };
    let best = found.cheapest(wanted);
    json!({
        "geardyn": header(sources, &["freedoms", "reference", "ladder"]),
        "norm": "largest relative error of the frequencies compared",
        "modes": found.count,
        "highest_hz": found.highest / TAU,
        "freedoms": found.freedoms,
        "reference": { "method": found.reference, "error": found.reference_error },
        "runs": found.ways.iter().map(run).collect::<Vec<_>>(),
        "recommendation": { "error": wanted, "method": best.map(|w| w.method), "run_time_s": best.map(|w| w.seconds) },
        "warnings": [],
    })
}

/// One row a way.
pub fn csv(found: &Frequencies) -> String {
    let mut text = String::from("method,coordinates,lengths,error,run_time_s,status\n");
    for way in &found.ways {
        let (coordinates, lengths) = match way.size {
            Some(Size::Coordinates(n)) => (n.to_string(), String::new()),
            Some(Size::Lengths(n)) => (String::new(), n.to_string()),
            None => Default::default(),
        };
        text += &format!(
            "{},{coordinates},{lengths},{},{},{}\n",
            quoted(way.method),
            way.error.map_or(String::new(), |e| format!("{e:e}")),
            way.seconds,
            quoted(way.failed.as_deref().unwrap_or("ok")),
        );
    }
    text
}

/// Error over run time, a line for each way.
pub fn draw(title: &str, found: &Frequencies) -> String {
    let point = |way: &Way| {
        Some(Point {
            method: way.method,
            seconds: way.seconds,
            error: way.error?,
        })
    };
    let points: Vec<Point> = found.ways.iter().filter_map(point).collect();
    work_precision::draw(
        title,
        &points,
        (found.reference_error, "error of the reference"),
    )
}
