//! Frequency responses as JSON, CSV and plots.

use std::sync::Arc;

use serde_json::{Value, json};

use super::bode::{BodeCurve, BodePlot, draw_bode, draw_nyquist};
use super::json::{complex, header, stages, warnings};
use crate::base::source_span::SourceFile;
use crate::base::text::pluralise;
use crate::machine::components::Machine;
use crate::plan::response::run::{ResponseCurve, ResponseResult};
use crate::plan::stages::StageDecision;
use crate::response::frf::{ResponseMethod, SolverKind};

/// Description of the method, as text.
pub fn method_text(result: &ResponseResult) -> String {
    let n = result.stats.coordinates;
    let mut text = match result.solver {
        SolverKind::Dense => format!("dynamic stiffness of {n} coordinates, line by line"),
        SolverKind::Sparse => format!("sparse dynamic stiffness of {n} coordinates, line by line"),
        SolverKind::RealModes => "sum over all real modes".to_string(),
        SolverKind::ComplexModes => "sum over all complex modes".to_string(),
    };
    let summed = matches!(
        result.solver,
        SolverKind::RealModes | SolverKind::ComplexModes
    );
    if summed || result.choice.method == ResponseMethod::Direct {
        text += &format!(": {}", result.choice.reason);
    } else if result.stats.rejected_error.is_none() {
        text += ": its modes do not come apart (damping at what has no inertia, loss factors that differ), so there is no sum over them";
    }
    if let Some(error) = result.stats.error {
        text += &format!(
            "; at {} lines solved directly it is off by {error:.1e} at most",
            result.stats.checked
        );
    }
    if let Some(off) = result.stats.rejected_error {
        text += &format!("; the sum over modes was off by {off:.1e} and given up");
    }
    text
}

/// The document of a frequency response. Of a single input and output `values` and `peaks` stand at the top as well.
pub fn json(sources: &[Arc<SourceFile>], machine: &Machine, result: &ResponseResult) -> Value {
    let trace: Vec<&str> = result
        .plan
        .iter()
        .filter(|row| matches!(row.1, StageDecision::Runs(_)))
        .map(|row| row.0)
        .collect();
    let mut document = json!({
        "geardyn": header(sources, &trace),
        "frequency_hz": result.frequency_hz,
        "responses": result.pairs.iter().map(|pair| response(machine, pair)).collect::<Vec<_>>(),
        "method": match result.solver {
            SolverKind::Dense | SolverKind::Sparse => "direct",
            SolverKind::RealModes => "real modes",
            SolverKind::ComplexModes => "complex modes",
        },
        "reason": result.choice.reason,
        "error": result.stats.error,
        "lines_checked": result.stats.checked,
        "effort": { "run_time_s": result.stats.seconds, "coordinates": result.stats.coordinates },
        "stages": stages(result.plan.iter().map(|(name, decision)| (*name, decision))),
        "warnings": warnings(&result.diagnostics),
    });
    if let [only] = &result.pairs[..] {
        document["value"] = values(only);
        document["peaks"] = peaks(machine, only);
    }
    document
}

fn response(machine: &Machine, pair: &ResponseCurve) -> Value {
    json!({
        "input": pair.input,
        "output": pair.output,
        "unit": pair.unit,
        "at_rest": pair.static_response,
        "value": values(pair),
        "peaks": peaks(machine, pair),
    })
}

fn values(pair: &ResponseCurve) -> Value {
    pair.values.iter().map(|&z| complex(z)).collect()
}

fn peaks(machine: &Machine, pair: &ResponseCurve) -> Value {
    let peak = |p: &crate::plan::response::run::ResonancePeak| {
        json!({
            "frequency_hz": p.peak.omega / std::f64::consts::TAU,
            "magnitude": p.peak.height,
            "amplification": pair.static_response.map(|rest| p.peak.height / rest),
            "damping_ratio": p.peak.damping(),
            "mostly": p.dominant_element.map(|(element, _)| machine.elements[element].name.clone()),
            "share": p.dominant_element.map(|(_, share)| share),
        })
    };
    pair.peaks.iter().map(peak).collect()
}

/// One row a line, real and imaginary part of every response.
pub fn csv(result: &ResponseResult) -> String {
    let mut head = vec!["frequency [Hz]".to_string()];
    for pair in &result.pairs {
        for part in ["re", "im"] {
            head.push(super::modes_csv::csv_field(&format!(
                "{} by {} {part} [{}]",
                pair.output, pair.input, pair.unit
            )));
        }
    }
    let mut text = head.join(",") + "\n";
    for (k, f) in result.frequency_hz.iter().enumerate() {
        text += &format!("{f}");
        for pair in &result.pairs {
            text += &format!(",{},{}", pair.values[k].re, pair.values[k].im);
        }
        text.push('\n');
    }
    text
}

/// Responses omitted from the plots, as text; empty where they show every response.
pub fn omitted_text(result: &ResponseResult) -> String {
    let (all, shown) = (result.pairs.len(), plotted_pairs(result).count());
    match plotted_pairs(result).next() {
        Some(first) if shown < all => format!(
            "drawn: the {} in {}, of {all}; those in other units are drawn when asked for by themselves\n",
            pluralise(shown, "response"),
            first.unit
        ),
        _ => String::new(),
    }
}

/// The responses in the unit of the first.
fn plotted_pairs(result: &ResponseResult) -> impl Iterator<Item = &ResponseCurve> {
    let unit = result.pairs.first().map(|pair| &pair.unit);
    (result.pairs.iter()).filter(move |pair| Some(&pair.unit) == unit)
}

/// Magnitude and phase over frequency, and the complex plane; of the responses in the unit of the first.
pub fn draw_plots(title: &str, result: &ResponseResult) -> (String, String) {
    let curve = |pair: &ResponseCurve| BodeCurve {
        traced: Vec::new(),
        label: format!("{} by {}", pair.output, pair.input),
        unit: pair.unit.clone(),
        measured: pair.plotted.clone(),
        computed: true,
        ..BodeCurve::default()
    };
    let mut modes: Vec<f64> = plotted_pairs(result)
        .flat_map(|p| &p.peaks)
        .map(|p| p.peak.omega / std::f64::consts::TAU)
        .collect();
    modes.sort_by(f64::total_cmp);
    // Peaks of several responses at one mode are one line.
    modes.dedup_by(|a, b| (*a - *b).abs() < 2e-3 * *a);
    let shown = BodePlot {
        title: title.to_string(),
        across: "",
        frequency_hz: result.drawn_hz.clone(),
        curves: plotted_pairs(result).map(curve).collect(),
        modes_hz: modes,
    };
    (draw_bode(&shown), draw_nyquist(&shown))
}
