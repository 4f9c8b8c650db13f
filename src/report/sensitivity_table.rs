//! Sensitivity of a motion to its start, as text.

use super::modes_table::{finish, plain, right_but_first};
use super::number_format::{four_digits, significant_text, with_deviation};
use crate::base::quantity::format_time;
use crate::plan::motion::sensitivity::Sensitivity;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::motion::statistics::{PERCENTILES, Statistics, UncertainValue};

/// Predictability of the motion, and the statistics valid beyond it; nothing where every digit shown holds.
pub fn text(scene: &SimulationSetup, sensitivity: &Sensitivity) -> String {
    if sensitivity.all_shown() {
        return String::new();
    }
    let what = match (sensitivity.until(), sensitivity.factor) {
        (Some(until), _) => format!("not predictable beyond t = {}", format_time(until)),
        (None, Some(factor)) if factor < SLIGHT => {
            "the errors of the method leave the digits shown: ask for a tighter tolerance or a shorter step".to_string()
        }
        (None, _) => "only digits that hold are shown".to_string(),
    };
    let mut text = format!("\n{}; {what}\n", factor(sensitivity));
    let mut table = plain();
    let shares = PERCENTILES.map(|share| format!("{:.0} % below", 100.0 * share));
    let columns = ["second half", "unit", "mean", "rms about it"].map(str::to_string);
    table.set_header(columns.into_iter().chain(shares));
    for (output, digits) in scene.outputs.list.iter().zip(&sensitivity.outputs) {
        if let Some(statistics) = &digits.second_half {
            let names = [output.name.clone(), output.unit.to_string()];
            table.add_row(names.into_iter().chain(cells(statistics)));
        }
    }
    if table.row_count() > 0 {
        right_but_first(&mut table);
        text += &format!(
            "\n{}± the 95 % interval, from blocks of two runs\n",
            finish(&table)
        );
    }
    text
}

/// A motion that amplifies less does not take the digits.
const SLIGHT: f64 = 10.0;

fn factor(sensitivity: &Sensitivity) -> String {
    let size = match (sensitivity.factor, sensitivity.parted) {
        (Some(factor), true) => format!("more than ×{:.0e}", 0.5 * factor),
        (Some(factor), false) => format!(
            "×{}",
            significant_text(factor, 5e-3 * factor).unwrap_or_default()
        ),
        (None, _) => "not known".to_string(),
    };
    format!("sensitivity to initial conditions {size}")
}

fn cells(s: &Statistics) -> Vec<String> {
    let cell = |known: &UncertainValue| with_deviation(known.value, known.error);
    let percentiles = match &s.percentiles {
        Some(all) => all.iter().map(cell).collect(),
        None => vec!["–".to_string(); PERCENTILES.len()],
    };
    let own = [&s.mean, &s.rms].map(cell);
    own.into_iter().chain(percentiles).collect()
}

/// Cost and result of the further runs, in a line.
pub fn effort(sensitivity: &Sensitivity) -> String {
    const ALL: &str = "all digits shown are significant";
    let found = match (sensitivity.all_shown(), sensitivity.factor) {
        (true, Some(_)) => format!("{ALL}, {}", factor(sensitivity)),
        (false, Some(_)) => factor(sensitivity),
        (_, None) => ALL.to_string(),
    };
    format!(
        "compared with a start changed by {:.0e} of the deflections: {found}, {} s\n",
        sensitivity.change,
        four_digits(sensitivity.seconds)
    )
}
