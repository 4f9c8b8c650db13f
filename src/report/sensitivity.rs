//! Sensitivity of a motion to its start, in the document.

use serde_json::{Value, json};

use super::simulation::key;
use crate::plan::motion::sensitivity::{OutputPredictability, Sensitivity};
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::motion::statistics::{PERCENTILES, Statistics, UncertainValue};

/// Adds `sensitivity`, and takes out of `readings` what cannot be predicted.
pub fn extend(document: &mut Value, scene: &SimulationSetup, sensitivity: Option<&Sensitivity>) {
    let Some(found) = sensitivity else {
        document["sensitivity"] = Value::Null;
        return;
    };
    let mut outputs = serde_json::Map::new();
    for (output, digits) in scene.outputs.list.iter().zip(&found.outputs) {
        let key = key(output);
        for (name, error) in errors(digits) {
            if error.is_none() && document["readings"][&key].is_object() {
                document["readings"][&key][name] = Value::Null;
            }
        }
        let off: serde_json::Map<String, Value> = errors(digits)
            .into_iter()
            .map(|(name, error)| (name.to_string(), json!(error)))
            .collect();
        outputs.insert(
            key,
            json!({
                "predictable_until_s": digits.until,
                "uncertainty": off,
                "second_half": digits.second_half.as_ref().map(statistics),
            }),
        );
    }
    document["sensitivity"] = json!({
        "factor": found.factor, "is_lower_bound": found.parted, "change": found.change,
        "predictable_until_s": found.until(), "all_shown_digits_hold": found.all_shown(),
        "run_time_s": found.seconds, "outputs": outputs,
    });
}

/// The readings by their keys, each with what it may be off by.
fn errors(d: &OutputPredictability) -> [(&'static str, Option<f64>); 7] {
    [
        ("end", d.end),
        ("least", d.min),
        ("least_at_s", d.min_at),
        ("greatest", d.max),
        ("greatest_at_s", d.max_at),
        ("mean", Some(d.mean)),
        ("rms_about_mean", Some(d.rms)),
    ]
}

fn statistics(s: &Statistics) -> Value {
    let of = |known: &UncertainValue| json!({ "value": known.value, "uncertainty": known.error });
    let percentiles = s.percentiles.map(|all| {
        let one = |(share, known): (&f64, &UncertainValue)| {
            json!({ "below": share, "value": known.value, "uncertainty": known.error })
        };
        PERCENTILES.iter().zip(&all).map(one).collect::<Vec<_>>()
    });
    json!({ "mean": of(&s.mean), "rms_about_mean": of(&s.rms), "percentiles": percentiles })
}
