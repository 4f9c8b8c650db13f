//! Run-ups as terminal tables: critical speeds with the element of highest strain energy.

use std::f64::consts::TAU;

use super::harmonic_balance::{choose_unit, rpm};
use super::modes_table::{finish, plain, right_but_last};
use super::number_format::{four_digits, significant, with_minus_signs};
use crate::base::text::pluralise;
use crate::machine::components::Machine;
use crate::plan::response::run_up::RunUpResult;

/// Maximum number of critical speeds shown: those with the largest responses.
const MAX_ROWS: usize = 24;

/// The tables.
pub fn table(machine: &Machine, result: &RunUpResult) -> String {
    let (name, unit) = result
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), *u));
    let mut text = driver(result);
    text += &match result.assumed {
        Some(size) => format!(
            "no error is declared: every order has an assumed amplitude of {} µm, and answers go with it\n",
            four_digits(1e6 * size)
        ),
        None => "orders have the amplitudes of the errors declared; where none is, only the critical speed is told\n".to_string(),
    };
    for ((name, unit), &(speed, total)) in result.outputs.iter().zip(&result.max_amplitudes) {
        let (factor, unit) = choose_unit(total, unit);
        text += &format!(
            "{name}: all orders together at most {} {unit}, at {} rpm\n",
            four_digits(factor * total),
            four_digits(rpm(speed))
        );
    }
    if result.critical.is_empty() {
        return text + "no order meets a natural frequency that answers in this range\n";
    }
    let largest = result
        .critical
        .iter()
        .filter_map(|c| c.amplitude)
        .fold(0.0, f64::max);
    let (factor, unit) = choose_unit(largest, unit);
    text += &format!(
        "\n{} of {}\n",
        pluralise(result.critical.len(), "critical speed"),
        result.node
    );
    let mut table = plain();
    table.add_row(vec![
        "speed",
        "frequency",
        "order",
        name,
        "source",
        "in danger",
    ]);
    table.add_row(vec!["rpm", "Hz", "", &unit, "", ""]);
    for c in result.critical.iter().take(MAX_ROWS) {
        let e = &result.excitations[c.excitation];
        table.add_row(vec![
            significant(rpm(c.speed)),
            significant(c.omega / TAU),
            e.fraction.clone(),
            match c.amplitude {
                Some(size) => four_digits(factor * size),
                None if !result.is_declared(c.excitation) => "not declared".to_string(),
                None => "infinite".to_string(),
            },
            e.source.clone(),
            c.highest_strain_energy
                .map_or("–".to_string(), |(element, share)| {
                    format!(
                        "{} ({:.0} %)",
                        machine.elements[element].name,
                        100.0 * share
                    )
                }),
        ]);
    }
    right_but_last(&mut table);
    text += &finish(&table);
    if result.critical.len() > MAX_ROWS {
        text += &format!(
            "… and {} with smaller answers; --json holds all\n",
            result.critical.len() - MAX_ROWS
        );
    }
    with_minus_signs(&text)
}

/// Driver's angle: prescribed or free.
fn driver(result: &RunUpResult) -> String {
    match &result.fixed_dofs[..] {
        [] => format!(
            "run-up of {}: nothing is held, the driver is free and answers the orders too (--hold {} prescribes its angle)\n",
            result.node, result.node
        ),
        held => format!(
            "run-up of {}: {} held, answering nothing\n",
            result.node,
            match held {
                [one] => format!("{one} is"),
                many => format!("{} are", many.join(", ")),
            }
        ),
    }
}
