//! Order cuts as JSON, CSV and a plot.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::bode::{self, BodePlot};
use super::json::{log_header, warnings};
use super::modes_csv::csv_field;
use super::recording::repairs;
use crate::plan::logs::order_cuts::{OrderCut, OrderCuts, rpm};
use crate::recording::raw::Repair;

/// The JSON document.
pub fn json(found: &OrderCuts, done: &[Repair]) -> Value {
    let trace: Vec<&str> = found.trace.iter().map(|t| t.0).collect();
    let cut = |cut: &OrderCut| {
        let largest = cut.largest().map(|at| {
            json!({ "amplitude": cut.value[at].norm(), "phase_rad": cut.value[at].arg(), "speed_rpm": rpm(found.speed[at]),
                "frequency_hz": cut.order * found.speed[at] / TAU })
        });
        json!({
            "channel": cut.channel,
            "unit": cut.unit,
            "order": cut.order,
            "amplitude": cut.value.iter().map(|z| z.norm()).collect::<Vec<_>>(),
            "phase_rad": cut.value.iter().map(|z| z.arg()).collect::<Vec<_>>(),
            "largest": largest,
        })
    };
    json!({
        "geardyn": log_header(&trace),
        "kind": "order-cut",
        "how": found.method_text,
        "turns": found.turns,
        "time_s": found.time_s,
        "speed_rpm": found.speed.iter().map(|&s| rpm(s)).collect::<Vec<_>>(),
        "cuts": found.cuts.iter().map(cut).collect::<Vec<_>>(),
        "effort": found.trace.iter().map(|t| json!({ "stage": t.0, "time_s": t.1 })).collect::<Vec<_>>(),
        "repairs": repairs(done),
        "warnings": warnings(&found.diagnostics),
    })
}

/// One row a block: time, speed, and amplitude and phase of each order of each channel.
pub fn csv(found: &OrderCuts) -> String {
    let mut head = vec!["time_s".to_string(), "speed_rpm".to_string()];
    for cut in &found.cuts {
        let name = format!("{} order {}", cut.channel, cut.order);
        head.push(csv_field(&format!("{name} amplitude [{}]", cut.unit)));
        head.push(csv_field(&format!("{name} phase [deg]")));
    }
    let mut text = head.join(",") + "\n";
    for (at, (time, &speed)) in found.time_s.iter().zip(&found.speed).enumerate() {
        text += &format!("{time:?},{:?}", rpm(speed));
        for cut in &found.cuts {
            let value = cut.value[at];
            text += &format!(",{:?},{:?}", value.norm(), value.arg().to_degrees());
        }
        text.push('\n');
    }
    text
}

/// Amplitude and phase over speed, by rising speed.
pub fn draw(found: &OrderCuts, title: &str) -> String {
    let mut rising: Vec<usize> = (0..found.speed.len()).collect();
    rising.sort_by(|&a, &b| found.speed[a].total_cmp(&found.speed[b]));
    bode::draw_bode(&BodePlot {
        title: format!("{title}: order cuts"),
        across: "speed, rpm",
        frequency_hz: rising.iter().map(|&at| rpm(found.speed[at])).collect(),
        curves: (found.cuts.iter())
            .map(|cut| bode::BodeCurve {
                label: format!("{} order {}", cut.channel, cut.order),
                unit: cut.unit.clone(),
                measured: rising.iter().map(|&at| cut.value[at]).collect(),
                computed: true,
                ..bode::BodeCurve::default()
            })
            .collect(),
        modes_hz: Vec::new(),
    })
}
