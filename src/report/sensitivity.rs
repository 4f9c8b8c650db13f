//! Sensitivity of a motion to initial conditions, as JSON and as text.

use serde_json::{Value, json};

use super::number_format::{four_digits, significant_text, with_deviation};
use super::output_key::key;
use super::table::Table;
use crate::base::quantity::format_time;
use crate::motion::block_statistics::{PERCENTILES, Statistics, UncertainValue};
use crate::motion::sensitivity::Amplification;
use crate::plan::motion::sensitivity::{OutputPredictability, Sensitivity};
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Adds `sensitivity` to the document and sets the `readings` that are not predictable to null.
pub fn extend(document: &mut Value, setup: &SimulationSetup, sensitivity: Option<&Sensitivity>) {
    let Some(sensitivity) = sensitivity else {
        document["sensitivity"] = Value::Null;
        return;
    };
    let mut outputs = serde_json::Map::new();
    for (output, digits) in setup.outputs.list.iter().zip(&sensitivity.outputs) {
        let key = key(output);
        for (name, error) in uncertainties(digits) {
            if error.is_none() && document["readings"][&key].is_object() {
                document["readings"][&key][name] = Value::Null;
            }
        }
        let uncertainty: serde_json::Map<String, Value> = uncertainties(digits)
            .into_iter()
            .map(|(name, error)| (name.to_string(), json!(error)))
            .collect();
        outputs.insert(
            key,
            json!({
                "predictable_until_s": digits.until,
                "uncertainty": uncertainty,
                "second_half": digits.second_half.as_ref().map(statistics),
            }),
        );
    }
    document["sensitivity"] = json!({
        "factor": sensitivity.amplification.map(|a| a.factor),
        "is_lower_bound": sensitivity.amplification.is_some_and(|a| a.is_lower_bound), "change": sensitivity.change(),
        "predictable_until_s": sensitivity.until(), "not_predictable_s": sensitivity.temporary_parting, "all_shown_digits_hold": sensitivity.all_shown(),
        "run_time_s": sensitivity.seconds, "outputs": outputs,
    });
}

/// Uncertainty of each reading, by its key; `None` if the reading is not predictable.
fn uncertainties(d: &OutputPredictability) -> [(&'static str, Option<f64>); 7] {
    [
        ("end", d.end),
        ("least", d.min),
        ("least_at_s", d.min_at),
        ("greatest", d.max),
        ("greatest_at_s", d.max_at),
        ("mean", Some(d.mean)),
        ("rms_about_mean", Some(d.standard_deviation)),
    ]
}

fn statistics(s: &Statistics) -> Value {
    let document = |x: &UncertainValue| json!({ "value": x.value, "uncertainty": x.error });
    let percentiles = s.percentiles.map(|values| {
        let entry = |(share, x): (&f64, &UncertainValue)| {
            json!({ "below": share, "value": x.value, "uncertainty": x.error })
        };
        PERCENTILES.iter().zip(&values).map(entry).collect::<Vec<_>>()
    });
    json!({ "mean": document(&s.mean), "rms_about_mean": document(&s.standard_deviation), "percentiles": percentiles })
}

/// Predictability of the motion, and the statistics valid beyond it; empty if every digit shown is significant.
pub fn text(setup: &SimulationSetup, sensitivity: &Sensitivity) -> String {
    if sensitivity.all_shown() {
        return String::new();
    }
    let factor = sensitivity.amplification.map(|a| a.factor);
    let what = match (sensitivity.until(), factor) {
        (Some(until), _) => format!("not predictable beyond t = {}", format_time(until)),
        (None, Some(factor)) if factor < SLIGHT => {
            "the errors of the method limit the digits shown: request a tighter tolerance or a shorter step".to_string()
        }
        (None, _) => match sensitivity.temporary_parting {
            None => "only significant digits are shown".to_string(),
            Some([from, to]) => format!(
                "not predictable between t = {} and {}, only significant digits are shown",
                format_time(from),
                format_time(to)
            ),
        },
    };
    let mut text = format!("\n{}; {what}\n", factor_text(sensitivity.amplification));
    let below = PERCENTILES.map(|share| format!("|{:.0} % below", 100.0 * share));
    let mut table =
        Table::named("second half|unit|mean|standard deviation").columns(&below.concat()[1..]);
    for (output, digits) in setup.outputs.list.iter().zip(&sensitivity.outputs) {
        if let Some(statistics) = &digits.second_half {
            let names = [output.name.clone(), output.unit.to_string()];
            table.row(names.into_iter().chain(cells(statistics)));
        }
    }
    if table.row_count() > 0 {
        text += &format!(
            "\n{}± the 95 % interval, from blocks of two runs\n",
            table.text()
        );
    }
    text
}

/// Amplification of initial errors below which digits are lost by the errors of the method.
const SLIGHT: f64 = 10.0;

/// Amplification as text.
pub fn factor_text(amplification: Option<Amplification>) -> String {
    let size = match amplification {
        Some(a) if a.is_lower_bound => format!("more than ×{:.0e}", 0.5 * a.factor),
        Some(a) => format!(
            "×{}",
            significant_text(a.factor, 5e-3 * a.factor).unwrap_or_default()
        ),
        None => "not known".to_string(),
    };
    format!("sensitivity to initial conditions {size}")
}

fn cells(s: &Statistics) -> Vec<String> {
    let cell = |x: &UncertainValue| with_deviation(x.value, x.error);
    let percentiles = match &s.percentiles {
        Some(list) => list.iter().map(cell).collect(),
        None => vec!["–".to_string(); PERCENTILES.len()],
    };
    let moments = [&s.mean, &s.standard_deviation].map(cell);
    moments.into_iter().chain(percentiles).collect()
}

/// Cost and result of the comparison run, as one line of text.
pub fn cost(sensitivity: &Sensitivity) -> String {
    const ALL: &str = "all digits shown are significant";
    let found = match (sensitivity.all_shown(), sensitivity.amplification) {
        (true, Some(a)) => format!("{ALL}, {}", factor_text(Some(a))),
        (false, Some(a)) => factor_text(Some(a)),
        (_, None) => ALL.to_string(),
    };
    format!(
        "compared with an initial state perturbed by {:.0e} of the deflections: {found}, {} s\n",
        sensitivity.change(),
        four_digits(sensitivity.seconds)
    )
}
