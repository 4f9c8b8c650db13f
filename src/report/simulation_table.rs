//! Motion in time as tables for a terminal.

use super::number_format::{four_digits, percent, significant_text};
use super::table::Table;
use crate::base::text::pluralise;
use crate::motion::energy_balance::EnergyBalance;
use crate::motion::step_response::StepResponse;
use crate::plan::motion::run::MotionResult;
use crate::plan::motion::sensitivity::{OutputPredictability, Sensitivity};
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Extremes and means of every output, with the digits that hold.
pub fn statistics_table(
    setup: &SimulationSetup,
    history: &MotionResult,
    sensitivity: Option<&Sensitivity>,
) -> String {
    let mut table =
        Table::named("output|unit|end|least|at s|greatest|at s|mean|standard deviation");
    for (at, (output, reading)) in setup
        .outputs
        .list
        .iter()
        .zip(&history.statistics)
        .enumerate()
    {
        let Some(r) = reading else {
            continue;
        };
        let numbers = [
            r.end,
            r.min.0,
            r.min.1,
            r.max.0,
            r.max.1,
            r.mean,
            r.standard_deviation,
        ];
        let errors = sensitivity.map_or([Some(0.0); 7], |s| errors(&s.outputs[at]));
        // What differs from zero by less than a digit shown of the largest value is zero.
        let slight = SLIGHT * r.max.0.abs().max(r.min.0.abs());
        let cells = numbers.iter().zip(errors).map(|(x, error)| {
            let text = error.and_then(|error| significant_text(*x, error));
            text.unwrap_or_else(|| match error {
                Some(error) if error <= slight => "0".to_string(),
                _ => "–".to_string(),
            })
        });
        let name = [output.name.clone(), output.unit.to_string()];
        table.row(name.into_iter().chain(cells));
    }
    table.text()
}

/// Half a unit of the fourth digit of what is largest.
const SLIGHT: f64 = 5e-5;

/// Error of each number of a row.
fn errors(d: &OutputPredictability) -> [Option<f64>; 7] {
    [
        d.end,
        d.min,
        d.min_at,
        d.max,
        d.max_at,
        Some(d.mean),
        Some(d.standard_deviation),
    ]
}

/// Step responses of the outputs.
pub fn step_responses(setup: &SimulationSetup, responses: &[Option<StepResponse>]) -> String {
    let mut table = Table::named(
        "step response|before|after|overshoot %|after s|rise s|settled s|oscillations",
    );
    let mut restless = Vec::new();
    for (output, response) in setup.outputs.list.iter().zip(responses) {
        match response {
            None => restless.push(output.name.as_str()),
            Some(a) => {
                let numbers = [
                    four_digits(a.initial_value),
                    four_digits(a.final_value),
                    percent(a.overshoot.0),
                    four_digits(a.overshoot.1),
                    four_digits(a.rise_s),
                    four_digits(a.settling_s),
                    four_digits(a.oscillations),
                ];
                table.row([output.name.clone()].into_iter().chain(numbers));
            }
        }
    }
    let mut text = match table.row_count() {
        0 => String::new(),
        _ => format!("\n{}", table.text()),
    };
    if !restless.is_empty() {
        text += &format!(
            "\nnot settled within 2 % by the end, so no step response is evaluated: {}\n",
            restless.join(", ")
        );
    }
    text
}

/// Cost of the run.
pub fn cost(history: &MotionResult) -> String {
    let e = &history.stats;
    let counts = [
        (e.steps, "step"),
        (e.evaluations, "evaluation"),
        (e.jacobians, "Jacobian"),
        (e.factorisations, "factorisation"),
        (e.regimes, "linear machine"),
        (e.events, "event"),
    ];
    let things = counts.map(|(n, thing)| (n, pluralise(n as usize, thing)));
    let done = [(e.rejected, "rejected"), (e.grazings, "grazed")];
    let done = done.map(|(n, what)| (n, format!("{n} {what}")));
    let told: Vec<String> = things
        .into_iter()
        .chain(done)
        .filter(|c| c.0 > 0)
        .map(|c| c.1)
        .collect();
    let told = if told.is_empty() {
        String::new()
    } else {
        format!("{}, ", told.join(", "))
    };
    format!("effort: {told}{} s\n", four_digits(history.seconds))
}

/// The energy balance, J.
pub fn energy_balance(balance: &EnergyBalance) -> String {
    if let Some(share) = balance.stopped_at {
        return format!(
            "energy balance: not computed, {} evaluations of the rapidly varying powers covered {} % of the time\n",
            balance.evaluations,
            four_digits(100.0 * share),
        );
    }
    format!(
        "energy: stored {} J, input {} J, dissipated {} J, stored at the end {} J; balance error {} ± {}\n",
        four_digits(balance.before),
        four_digits(balance.work_in),
        four_digits(balance.dissipated),
        four_digits(balance.after),
        four_digits(balance.relative_error().abs()),
        four_digits(balance.error_bound().unwrap_or(f64::INFINITY)),
    )
}
