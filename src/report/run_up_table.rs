//! Run-ups as tables for a terminal: critical speeds with the element in danger.

use std::f64::consts::TAU;

use super::harmonic_balance::{rpm, scaled};
use super::number::{brief, significant};
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
    let mut text = String::new();
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
            c.amplitude
                .map_or("infinite".to_string(), |a| brief(factor * a)),
            format!("{}{}", e.source, if e.declared { "" } else { " *" }),
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
    if answer
        .critical
        .iter()
        .any(|c| !answer.excitations[c.excitation].declared)
    {
        text += "* no amplitude declared: 1 µm is taken\n";
    }
    text
}
