//! Run-ups as JSON, CSV and a map.

use std::f64::consts::TAU;
use std::sync::Arc;

use serde_json::{Value, json};

use super::harmonic_balance::rpm;
use super::json::{header, stages, warnings};
use super::map_picture::{Map, maps};
use crate::base::place::Source;
use crate::machine::parts::Machine;
use crate::plan::response::run_up::Answer;
use crate::plan::stages::Verdict;
use crate::response::excitation::Excitation;

/// The document.
pub fn json(sources: &[Arc<Source>], machine: &Machine, answer: &Answer) -> Value {
    let trace: Vec<&str> = answer
        .plan
        .iter()
        .filter(|r| matches!(r.1, Verdict::Runs(_)))
        .map(|r| r.0)
        .collect();
    let output = |(at, (name, unit)): (usize, &(String, &str))| {
        json!({
            "name": name,
            "unit": unit,
            "most": { "speed_rpm": rpm(answer.most[at].0), "value": answer.most[at].1 },
            "total": (0..answer.speeds.len()).map(|s| answer.total(at, s)).collect::<Vec<_>>(),
            "by_excitation": answer.amplitudes[at],
        })
    };
    json!({
        "geardyn": header(sources, &trace),
        "node": answer.node,
        "assumed_amplitude_m": answer.assumed,
        "held": answer.held,
        "speed_rpm": answer.speeds.iter().map(|&s| rpm(s)).collect::<Vec<_>>(),
        "excitations": answer.excitations.iter().map(|e| json!({
            "order": e.fraction, "value": e.order, "source": e.source,
            "amplitude": (e.declared || answer.assumed.is_some()).then_some(e.amplitude), "declared": e.declared,
            "branches": e.branches.iter().map(|b| machine.branch_name(b.0)).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "outputs": answer.outputs.iter().enumerate().map(output).collect::<Vec<_>>(),
        "critical": answer.critical.iter().map(|c| json!({
            "speed_rpm": rpm(c.speed), "frequency_hz": c.omega / TAU, "excitation": c.excitation,
            "order": answer.excitations[c.excitation].fraction, "source": answer.excitations[c.excitation].source,
            "amplitude": c.amplitude, "danger": c.danger.map(|d| machine.elements[d.0].name.clone()), "share": c.danger.map(|d| d.1),
        })).collect::<Vec<_>>(),
        "reason": answer.choice.reason,
        "effort": { "run_time_s": answer.seconds },
        "stages": stages(answer.plan.iter().map(|(name, verdict)| (*name, verdict))),
        "warnings": warnings(&answer.warnings),
    })
}

/// One row a speed: of every output all excitations together, then each.
pub fn csv(answer: &Answer) -> String {
    let mut head = vec!["speed [rpm]".to_string()];
    for (name, unit) in &answer.outputs {
        head.push(super::csv::quoted(&format!("{name} together [{unit}]")));
        for (_, e) in sized(answer) {
            head.push(super::csv::quoted(&format!(
                "{name} by {} ({}) [{unit}]",
                e.source, e.fraction
            )));
        }
    }
    let mut text = head.join(",") + "\n";
    for (at, &speed) in answer.speeds.iter().enumerate() {
        text += &format!("{}", rpm(speed));
        for output in 0..answer.outputs.len() {
            text += &format!(",{}", answer.total(output, at));
            for amplitudes in answer.amplitudes[output].iter().flatten() {
                text += &format!(",{}", amplitudes[at]);
            }
        }
        text.push('\n');
    }
    text
}

/// Excitations that have a size, with their numbers.
fn sized(answer: &Answer) -> impl Iterator<Item = (usize, &Excitation)> {
    let all = answer.excitations.iter().enumerate();
    all.filter(|(number, _)| answer.has_size(*number))
}

/// Rows of a map by frequency.
const LINES: usize = 140;

/// The answers of the first output over speed and frequency.
pub fn picture(title: &str, answer: &Answer) -> String {
    let (name, unit) = answer
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), u));
    // Beyond the highest critical frequency nothing answers; without one all is shown.
    let top = answer
        .excitations
        .iter()
        .map(|e| e.order)
        .fold(0.0, f64::max)
        * answer.speeds.iter().fold(0.0f64, |m, s| m.max(s.abs()))
        / TAU;
    let highest = answer
        .critical
        .iter()
        .map(|c| 1.3 * c.omega / TAU)
        .fold(0.0, f64::max);
    let top = if highest > 0.0 { top.min(highest) } else { top };
    let step = top / LINES as f64;
    let row = |at: usize| {
        let mut row = vec![0.0; LINES];
        // An order passes all frequencies between the speeds half way to the neighbours.
        let [before, after] = [at.saturating_sub(1), (at + 1).min(answer.speeds.len() - 1)];
        let ends =
            [before, after].map(|other| 0.5 * (answer.speeds[at] + answer.speeds[other]).abs());
        for (number, e) in sized(answer) {
            let line = |speed: f64| (e.order * speed / TAU / step) as usize;
            let (low, high) = (line(ends[0].min(ends[1])), line(ends[0].max(ends[1])));
            if let Some(Some(column)) = answer.amplitudes.first().map(|t| &t[number]) {
                let cells = row.iter_mut().take(high.saturating_add(1)).skip(low);
                cells.for_each(|cell| *cell += column[at].powi(2));
            }
        }
        row
    };
    maps(&[Map {
        title: format!("{title}: {name} over the speed of {}", answer.node),
        level: format!("amplitude, dB re 1 {unit}"),
        across: format!("speed of {}, rpm", answer.node),
        times: answer.speeds.iter().map(|&s| rpm(s)).collect(),
        places: (0..LINES).map(|k| (k as f64 + 0.5) * step).collect(),
        rows: (0..answer.speeds.len()).map(row).collect(),
    }])
}
