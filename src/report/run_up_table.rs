//! Run-ups as tables for a terminal: critical speeds with the element in danger.

use std::f64::consts::TAU;

use super::harmonic_balance::{rpm, scaled};
use super::number::{brief, significant, with_minus_signs};
use super::table::{finish, plain, right_but_last};
use crate::base::words::counted;
use crate::machine::parts::Machine;
use crate::plan::response::run_up::Answer;

/// Critical speeds shown, those with the largest answers.
const ROWS: usize = 24;

/// The tables.
pub fn table(machine: &Machine, answer: &Answer) -> String {
    let (name, unit) = answer
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), *u));
    let mut text = driver(answer);
    text += &match answer.assumed {
        Some(size) => format!(
            "no error is declared: every order has an assumed amplitude of {} µm, and answers go with it\n",
            brief(1e6 * size)
        ),
        None => "orders have the amplitudes of the errors declared; where none is, only the critical speed is told\n".to_string(),
    };
    for ((name, unit), &(speed, total)) in answer.outputs.iter().zip(&answer.most) {
        let (factor, unit) = scaled(total, unit);
        text += &format!(
            "{name}: all orders together at most {} {unit}, at {} rpm\n",
            brief(factor * total),
            brief(rpm(speed))
        );
    }
    if answer.critical.is_empty() {
        return text + "no order meets a natural frequency that answers in this range\n";
    }
    let largest = answer
        .critical
        .iter()
        .filter_map(|c| c.amplitude)
        .fold(0.0, f64::max);
    let (factor, unit) = scaled(largest, unit);
    text += &format!(
        "\n{} of {}\n",
        counted(answer.critical.len(), "critical speed"),
        answer.node
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
    for c in answer.critical.iter().take(ROWS) {
        let e = &answer.excitations[c.excitation];
        table.add_row(vec![
            significant(rpm(c.speed)),
            significant(c.omega / TAU),
            e.fraction.clone(),
            match c.amplitude {
                Some(size) => brief(factor * size),
                None if !answer.has_size(c.excitation) => "not declared".to_string(),
                None => "infinite".to_string(),
            },
            e.source.clone(),
            c.danger.map_or("–".to_string(), |(element, share)| {
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
    if answer.critical.len() > ROWS {
        text += &format!(
            "… and {} with smaller answers; --json holds all\n",
            answer.critical.len() - ROWS
        );
    }
    with_minus_signs(&text)
}

/// Whether the driver's angle is prescribed or answers.
fn driver(answer: &Answer) -> String {
    match &answer.held[..] {
        [] => format!(
            "run-up of {}: nothing is held, the driver is free and answers the orders too (--hold {} prescribes its angle)\n",
            answer.node, answer.node
        ),
        held => format!(
            "run-up of {}: {} held, answering nothing\n",
            answer.node,
            match held {
                [one] => format!("{one} is"),
                many => format!("{} are", many.join(", ")),
            }
        ),
    }
}
