//! Identified modes and transfer functions as JSON, CSV and curves.

use serde_json::{Value, json};

use super::bode::{Bode, Curve};
use super::json::{complex, log_header, warnings};
use super::recording::repairs;
use crate::base::error::Error;
use crate::identify::mode::IdentifiedMode;
use crate::identify::transfer::function::TransferFunction;
use crate::plan::logs::doubts::{coherence_at, window_damping};
use crate::plan::logs::identification::Identification;
use crate::recording::raw::Repair;
use crate::recording::responses::FrequencyResponse;

/// The JSON document of `identify`.
///
/// # Errors
/// A transfer function without polynomial form.
pub fn json(found: &Identification, done: &[Repair]) -> Result<Value, Error> {
    let trace: Vec<&str> = found.trace.iter().map(|t| t.0).collect();
    let functions = found
        .functions
        .iter()
        .map(TransferFunction::to_json)
        .collect::<Result<Vec<Value>, Error>>()?;
    Ok(json!({
        "geardyn": log_header(&trace),
        "how": found.how,
        "band_hz": [found.band_hz.0, found.band_hz.1],
        "hits": found.hits.iter().map(|h| json!({ "time_s": h.time_s, "peak": h.peak, "used": h.fault.is_none(), "fault": h.fault.map(|f| f.words()) })).collect::<Vec<_>>(),
        "averages": found.responses.averages,
        "window_decay_1_s": found.responses.window_decay,
        "modes": found.modes.iter().enumerate().map(|(k, m)| mode(found, k, m)).collect::<Vec<_>>(),
        "omitted": found.fit.omitted.iter().map(|o| json!({ "pole_rad_s": complex(o.pole), "reason": o.reason })).collect::<Vec<_>>(),
        "spread": found.fit.spread.iter().map(|s| json!({ "frequency_hz": s.frequency_hz, "frequency_spread_hz": s.frequency_spread_hz, "damping_spread": s.damping_spread })).collect::<Vec<_>>(),
        "evidence": found.fit.evidence.iter().map(|s| json!({ "pole_pairs_before": s.poles_before, "pole_pairs": s.poles_after, "chi2_before": s.chi2_before, "chi2": s.chi2_after, "probability": s.probability, "accepted": s.accepted, "reason": s.reason })).collect::<Vec<_>>(),
        "chi2": found.fit.chi2,
        "degrees_of_freedom": found.fit.dof,
        "delay_s": found.fit.delay_s,
        "transfer_functions": functions,
        "effort": found.trace.iter().map(|t| json!({ "stage": t.0, "time_s": t.1 })).collect::<Vec<_>>(),
        "repairs": repairs(done),
        "warnings": warnings(&found.warnings),
    }))
}

fn mode(found: &Identification, k: usize, mode: &IdentifiedMode) -> Value {
    let f = mode.frequency_hz();
    let names = found
        .responses
        .functions
        .iter()
        .map(|f| f.output.name.clone());
    let shape: serde_json::Map<String, Value> =
        names.zip(mode.shape.iter().map(|&z| complex(z))).collect();
    json!({
        "mode": k + 1,
        "frequency_hz": f,
        "frequency_std_hz": mode.frequency_std_hz(),
        "damped_frequency_hz": mode.damped_frequency_hz(),
        "damping_ratio": mode.damping_ratio(),
        "damping_std": mode.damping_std(),
        "window_damping": (found.responses.window_decay > 0.0).then(|| window_damping(found.responses.window_decay, f)),
        "pole_rad_s": complex(mode.pole),
        "coherence": coherence_at(&found.responses, f),
        "shape": shape,
    })
}

/// The modes as CSV.
pub fn csv(found: &Identification) -> String {
    let mut text =
        String::from("mode,frequency_hz,frequency_std_hz,damping_ratio,damping_std,coherence");
    let quoted = |name: &str| name.replace('"', "\"\"");
    for f in &found.responses.functions {
        text += &format!(",\"{0} re\",\"{0} im\"", quoted(&f.output.name));
    }
    text.push('\n');
    let or_empty = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:?}"));
    for (k, m) in found.modes.iter().enumerate() {
        text += &format!(
            "{},{:?},{},{:?},{},{}",
            k + 1,
            m.frequency_hz(),
            or_empty(m.frequency_std_hz()),
            m.damping_ratio(),
            or_empty(m.damping_std()),
            or_empty(coherence_at(&found.responses, m.frequency_hz()))
        );
        for z in &m.shape {
            text += &format!(",{:?},{:?}", z.re, z.im);
        }
        text.push('\n');
    }
    text
}

/// The responses, measured and fitted, inside the band.
pub fn curves(found: &Identification, title: &str) -> Bode {
    let (low, high) = found.band_hz;
    let lines: Vec<usize> = (0..found.responses.frequency_hz.len())
        .filter(|&k| (low..=high).contains(&found.responses.frequency_hz[k]))
        .collect();
    let synthesised: Vec<Vec<_>> = lines
        .iter()
        .map(|&k| found.fit.synthesise(found.responses.frequency_hz[k]))
        .collect();
    let curve = |(i, f): (usize, &FrequencyResponse)| Curve {
        label: label(f),
        unit: unit(f),
        measured: lines.iter().map(|&k| f.value[k]).collect(),
        fitted: Some(synthesised.iter().map(|all| all[i]).collect()),
        coherence: f
            .coherence
            .as_ref()
            .map(|c| lines.iter().map(|&k| c[k]).collect()),
    };
    Bode {
        title: title.to_string(),
        frequency_hz: lines
            .iter()
            .map(|&k| found.responses.frequency_hz[k])
            .collect(),
        curves: found
            .responses
            .functions
            .iter()
            .enumerate()
            .map(curve)
            .collect(),
        modes_hz: found
            .modes
            .iter()
            .map(IdentifiedMode::frequency_hz)
            .collect(),
    }
}

/// What a response is called in pictures.
fn label(f: &FrequencyResponse) -> String {
    match &f.input {
        Some(input) if !input.name.is_empty() => format!("{}/{}", f.output.name, input.name),
        _ => f.output.name.clone(),
    }
}

fn unit(f: &FrequencyResponse) -> String {
    match &f.input {
        Some(input) if !input.unit.is_empty() && !f.output.unit.is_empty() => {
            format!("({})/({})", f.output.unit, input.unit)
        }
        _ => f.output.unit.clone(),
    }
}

/// How far the fit is from each response, relative: the worst.
pub fn worst_error(found: &Identification) -> f64 {
    found.fit.fit_error.iter().copied().fold(0.0, f64::max)
}
