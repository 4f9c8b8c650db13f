//! Run-ups as JSON, CSV and a map.

use std::f64::consts::TAU;
use std::sync::Arc;

use serde_json::{Value, json};

use super::harmonic_balance::rpm;
use super::heatmap::{Heatmap, draw_heatmaps};
use super::json::{header, stages, warnings};
use crate::base::source_span::SourceFile;
use crate::machine::components::Machine;
use crate::plan::response::run_up::RunUpResult;
use crate::plan::stages::StageDecision;
use crate::response::excitation::OrderExcitation;

/// The document.
pub fn json(sources: &[Arc<SourceFile>], machine: &Machine, result: &RunUpResult) -> Value {
    let trace: Vec<&str> = result
        .plan
        .iter()
        .filter(|r| matches!(r.1, StageDecision::Runs(_)))
        .map(|r| r.0)
        .collect();
    let output = |(at, (name, unit)): (usize, &(String, &str))| {
        json!({
            "name": name,
            "unit": unit,
            "most": { "speed_rpm": rpm(result.max_amplitudes[at].0), "value": result.max_amplitudes[at].1 },
            "total": (0..result.speeds.len()).map(|s| result.rss_amplitude(at, s)).collect::<Vec<_>>(),
            "by_excitation": result.amplitudes[at],
        })
    };
    json!({
        "geardyn": header(sources, &trace),
        "node": result.node,
        "assumed_amplitude_m": result.assumed,
        "held": result.fixed_dofs,
        "speed_rpm": result.speeds.iter().map(|&s| rpm(s)).collect::<Vec<_>>(),
        "excitations": result.excitations.iter().map(|e| json!({
            "order": e.fraction, "value": e.order, "source": e.source,
            "amplitude": (e.declared || result.assumed.is_some()).then_some(e.amplitude), "declared": e.declared,
            "branches": e.branches.iter().map(|b| machine.branch_name(b.0)).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "outputs": result.outputs.iter().enumerate().map(output).collect::<Vec<_>>(),
        "critical": result.critical.iter().map(|c| json!({
            "speed_rpm": rpm(c.speed), "frequency_hz": c.omega / TAU, "excitation": c.excitation,
            "order": result.excitations[c.excitation].fraction, "source": result.excitations[c.excitation].source,
            "amplitude": c.amplitude, "danger": c.highest_strain_energy.map(|d| machine.elements[d.0].name.clone()), "share": c.highest_strain_energy.map(|d| d.1),
        })).collect::<Vec<_>>(),
        "reason": result.choice.reason,
        "effort": { "run_time_s": result.seconds },
        "stages": stages(result.plan.iter().map(|(name, decision)| (*name, decision))),
        "warnings": warnings(&result.diagnostics),
    })
}

/// One row a speed: of every output all excitations together, then each.
pub fn csv(result: &RunUpResult) -> String {
    let mut head = vec!["speed [rpm]".to_string()];
    for (name, unit) in &result.outputs {
        head.push(super::modes_csv::csv_field(&format!(
            "{name} together [{unit}]"
        )));
        for (_, e) in sized_excitations(result) {
            head.push(super::modes_csv::csv_field(&format!(
                "{name} by {} ({}) [{unit}]",
                e.source, e.fraction
            )));
        }
    }
    let mut text = head.join(",") + "\n";
    for (at, &speed) in result.speeds.iter().enumerate() {
        text += &format!("{}", rpm(speed));
        for output in 0..result.outputs.len() {
            text += &format!(",{}", result.rss_amplitude(output, at));
            for amplitudes in result.amplitudes[output].iter().flatten() {
                text += &format!(",{}", amplitudes[at]);
            }
        }
        text.push('\n');
    }
    text
}

/// Excitations that have a size, with their numbers.
fn sized_excitations(result: &RunUpResult) -> impl Iterator<Item = (usize, &OrderExcitation)> {
    let all = result.excitations.iter().enumerate();
    all.filter(|(number, _)| result.is_declared(*number))
}

/// Rows of a map by frequency.
const LINES: usize = 140;

/// Response of the first output over speed and frequency.
pub fn draw(title: &str, result: &RunUpResult) -> String {
    let (name, unit) = result
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), u));
    // Beyond the highest critical frequency nothing answers; without one all is shown.
    let top = result
        .excitations
        .iter()
        .map(|e| e.order)
        .fold(0.0, f64::max)
        * result.speeds.iter().fold(0.0f64, |m, s| m.max(s.abs()))
        / TAU;
    let highest = result
        .critical
        .iter()
        .map(|c| 1.3 * c.omega / TAU)
        .fold(0.0, f64::max);
    let top = if highest > 0.0 { top.min(highest) } else { top };
    let step = top / LINES as f64;
    let row = |at: usize| {
        let mut row = vec![0.0; LINES];
        // An order passes all frequencies between the speeds half way to the neighbours.
        let [before, after] = [at.saturating_sub(1), (at + 1).min(result.speeds.len() - 1)];
        let ends =
            [before, after].map(|other| 0.5 * (result.speeds[at] + result.speeds[other]).abs());
        for (number, e) in sized_excitations(result) {
            let line = |speed: f64| (e.order * speed / TAU / step) as usize;
            let (low, high) = (line(ends[0].min(ends[1])), line(ends[0].max(ends[1])));
            if let Some(Some(column)) = result.amplitudes.first().map(|t| &t[number]) {
                let cells = row.iter_mut().take(high.saturating_add(1)).skip(low);
                cells.for_each(|cell| *cell += column[at].powi(2));
            }
        }
        row
    };
    draw_heatmaps(&[Heatmap {
        title: format!("{title}: {name} over the speed of {}", result.node),
        level: format!("amplitude, dB re 1 {unit}"),
        across: format!("speed of {}, rpm", result.node),
        times: result.speeds.iter().map(|&s| rpm(s)).collect(),
        places: (0..LINES).map(|k| (k as f64 + 0.5) * step).collect(),
        rows: (0..result.speeds.len()).map(row).collect(),
    }])
}
