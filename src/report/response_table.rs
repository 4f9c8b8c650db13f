//! Frequency responses as tables for a terminal: the peaks.

use super::modes_table::{finish, plain, right_but_last};
use super::number_format::{four_digits, percent, significant};
use crate::machine::components::Machine;
use crate::plan::response::run::{ResponseCurve, ResponseResult};

/// Peaks shown of a response, the highest.
const MAX_ROWS: usize = 20;

/// The peaks of every response.
pub fn peaks(machine: &Machine, result: &ResponseResult) -> String {
    let mut text = String::new();
    for (at, pair) in result.pairs.iter().enumerate() {
        let gap = if at > 0 { "\n" } else { "" };
        text += &format!("{gap}{} by {}\n", pair.output, pair.input);
        if let Some(rest) = pair.static_response {
            text += &format!("at rest {} {}\n", four_digits(rest), pair.unit);
        }
        text += &match pair.peaks.is_empty() {
            true => "  no peak in the band\n".to_string(),
            false => table(machine, pair),
        };
    }
    text
}

fn table(machine: &Machine, pair: &ResponseCurve) -> String {
    let mut shown: Vec<_> = pair.peaks.iter().collect();
    shown.sort_by(|a, b| b.peak.height.total_cmp(&a.peak.height));
    shown.truncate(MAX_ROWS);
    shown.sort_by(|a, b| a.peak.omega.total_cmp(&b.peak.omega));
    let mut table = plain();
    table.add_row(vec![
        "frequency",
        "magnitude",
        "amplification",
        "damping",
        "mostly in",
    ]);
    table.add_row(vec!["Hz", &pair.unit, "of rest", "%", ""]);
    let dash = || "–".to_string();
    for p in shown {
        let mostly = p.dominant_element.map_or(dash(), |(element, share)| {
            format!(
                "{} ({:.0} %)",
                machine.elements[element].name,
                100.0 * share
            )
        });
        table.add_row(vec![
            significant(p.peak.omega / std::f64::consts::TAU),
            four_digits(p.peak.height),
            pair.static_response
                .map_or(dash(), |rest| four_digits(p.peak.height / rest)),
            p.peak.damping().map_or(dash(), percent),
            mostly,
        ]);
    }
    right_but_last(&mut table);
    let mut text = finish(&table);
    if pair.peaks.len() > MAX_ROWS {
        text += &format!("{} lower ones\n", pair.peaks.len() - MAX_ROWS);
    }
    text
}
