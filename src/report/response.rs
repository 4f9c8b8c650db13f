//! Frequency responses as JSON, CSV and pictures.

use std::sync::Arc;

use serde_json::{Value, json};

use super::bode::{Bode, Curve, bode, nyquist};
use super::json::{complex, header, stages, warnings};
use crate::base::place::Source;
use crate::base::words::counted;
use crate::machine::parts::Machine;
use crate::plan::response::run::{Answer, Pair};
use crate::plan::stages::Verdict;
use crate::response::frequency::{How, Way};

/// How it was found, in words.
pub fn how(answer: &Answer) -> String {
    let n = answer.effort.coordinates;
    let mut text = match answer.how {
        How::Dense => format!("dynamic stiffness of {n} coordinates, line by line"),
        How::Sparse => format!("sparse dynamic stiffness of {n} coordinates, line by line"),
        How::RealModes => "sum over all real modes".to_string(),
        How::ComplexModes => "sum over all complex modes".to_string(),
    };
    let summed = matches!(answer.how, How::RealModes | How::ComplexModes);
    if summed || answer.choice.way == Way::Direct {
        text += &format!(": {}", answer.choice.reason);
    } else if answer.effort.given_up.is_none() {
        text += ": its modes do not come apart (damping at what has no inertia, loss factors that differ), so there is no sum over them";
    }
    if let Some(error) = answer.effort.error {
        text += &format!(
            "; at {} lines solved directly it is off by {error:.1e} at most",
            answer.effort.checked
        );
    }
    if let Some(off) = answer.effort.given_up {
        text += &format!("; the sum over modes was off by {off:.1e} and given up");
    }
    text
}

/// The document of a frequency response. Of a single input and output `value` and `peaks` stand at the top as well.
pub fn json(sources: &[Arc<Source>], machine: &Machine, answer: &Answer) -> Value {
    let trace: Vec<&str> = answer
        .plan
        .iter()
        .filter(|row| matches!(row.1, Verdict::Runs(_)))
        .map(|row| row.0)
        .collect();
    let mut document = json!({
        "geardyn": header(sources, &trace),
        "frequency_hz": answer.frequency_hz,
        "responses": answer.pairs.iter().map(|pair| response(machine, pair)).collect::<Vec<_>>(),
        "method": match answer.how {
            How::Dense | How::Sparse => "direct",
            How::RealModes => "real modes",
            How::ComplexModes => "complex modes",
        },
        "reason": answer.choice.reason,
        "error": answer.effort.error,
        "lines_checked": answer.effort.checked,
        "effort": { "run_time_s": answer.effort.seconds, "coordinates": answer.effort.coordinates },
        "stages": stages(answer.plan.iter().map(|(name, verdict)| (*name, verdict))),
        "warnings": warnings(&answer.warnings),
    });
    if let [only] = &answer.pairs[..] {
        document["value"] = values(only);
        document["peaks"] = peaks(machine, only);
    }
    document
}

fn response(machine: &Machine, pair: &Pair) -> Value {
    json!({
        "input": pair.input,
        "output": pair.output,
        "unit": pair.unit,
        "at_rest": pair.at_rest,
        "value": values(pair),
        "peaks": peaks(machine, pair),
    })
}

fn values(pair: &Pair) -> Value {
    pair.value.iter().map(|&z| complex(z)).collect()
}

fn peaks(machine: &Machine, pair: &Pair) -> Value {
    let peak = |p: &crate::plan::response::run::Strained| {
        json!({
            "frequency_hz": p.peak.omega / std::f64::consts::TAU,
            "magnitude": p.peak.height,
            "amplification": pair.at_rest.map(|rest| p.peak.height / rest),
            "damping_ratio": p.peak.damping(),
            "mostly": p.mostly.map(|(element, _)| machine.elements[element].name.clone()),
            "share": p.mostly.map(|(_, share)| share),
        })
    };
    pair.peaks.iter().map(peak).collect()
}

/// One row a line, real and imaginary part of every response.
pub fn csv(answer: &Answer) -> String {
    let mut head = vec!["frequency [Hz]".to_string()];
    for pair in &answer.pairs {
        for part in ["re", "im"] {
            head.push(super::csv::quoted(&format!(
                "{} by {} {part} [{}]",
                pair.output, pair.input, pair.unit
            )));
        }
    }
    let mut text = head.join(",") + "\n";
    for (k, f) in answer.frequency_hz.iter().enumerate() {
        text += &format!("{f}");
        for pair in &answer.pairs {
            text += &format!(",{},{}", pair.value[k].re, pair.value[k].im);
        }
        text.push('\n');
    }
    text
}

/// What the pictures leave out, in words; empty where they show every response.
pub fn not_drawn(answer: &Answer) -> String {
    let (all, shown) = (answer.pairs.len(), drawn(answer).count());
    match drawn(answer).next() {
        Some(first) if shown < all => format!(
            "drawn: the {} in {}, of {all}; those in other units are drawn when asked for by themselves\n",
            counted(shown, "response"),
            first.unit
        ),
        _ => String::new(),
    }
}

/// The responses in the unit of the first.
fn drawn(answer: &Answer) -> impl Iterator<Item = &Pair> {
    let unit = answer.pairs.first().map(|pair| &pair.unit);
    (answer.pairs.iter()).filter(move |pair| Some(&pair.unit) == unit)
}

/// Magnitude and phase over frequency, and the complex plane; of the responses in the unit of the first.
pub fn pictures(title: &str, answer: &Answer) -> (String, String) {
    let curve = |pair: &Pair| Curve {
        traced: Vec::new(),
        label: format!("{} by {}", pair.output, pair.input),
        unit: pair.unit.clone(),
        measured: pair.drawn.clone(),
        computed: true,
        ..Curve::default()
    };
    let mut modes: Vec<f64> = drawn(answer)
        .flat_map(|p| &p.peaks)
        .map(|p| p.peak.omega / std::f64::consts::TAU)
        .collect();
    modes.sort_by(f64::total_cmp);
    // Peaks of several responses at one mode are one line.
    modes.dedup_by(|a, b| (*a - *b).abs() < 2e-3 * *a);
    let shown = Bode {
        title: title.to_string(),
        across: "",
        frequency_hz: answer.drawn_hz.clone(),
        curves: drawn(answer).map(curve).collect(),
        modes_hz: modes,
    };
    (bode(&shown), nyquist(&shown))
}
