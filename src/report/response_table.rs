//! Frequency responses as tables for a terminal: the peaks.

use super::number::{brief, percent, significant};
use super::table::{finish, plain, right_but_last};
use crate::machine::parts::Machine;
use crate::plan::response::run::{Answer, Pair};

/// Peaks shown of a response, the highest.
const ROWS: usize = 20;

/// The peaks of every response.
pub fn peaks(machine: &Machine, answer: &Answer) -> String {
    let mut text = String::new();
    for (at, pair) in answer.pairs.iter().enumerate() {
        let gap = if at > 0 { "\n" } else { "" };
        text += &format!("{gap}{} by {}\n", pair.output, pair.input);
        if let Some(rest) = pair.at_rest {
            text += &format!("at rest {} {}\n", brief(rest), pair.unit);
        }
        text += &match pair.peaks.is_empty() {
            true => "  no peak in the band\n".to_string(),
            false => table(machine, pair),
        };
    }
    text
}

fn table(machine: &Machine, pair: &Pair) -> String {
    let mut shown: Vec<_> = pair.peaks.iter().collect();
    shown.sort_by(|a, b| b.peak.height.total_cmp(&a.peak.height));
    shown.truncate(ROWS);
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
        let mostly = p.mostly.map_or(dash(), |(element, share)| {
            format!(
                "{} ({:.0} %)",
                machine.elements[element].name,
                100.0 * share
            )
        });
        table.add_row(vec![
            significant(p.peak.omega / std::f64::consts::TAU),
            brief(p.peak.height),
            pair.at_rest
                .map_or(dash(), |rest| brief(p.peak.height / rest)),
            p.peak.damping().map_or(dash(), percent),
            mostly,
        ]);
    }
    right_but_last(&mut table);
    let mut text = finish(&table);
    if pair.peaks.len() > ROWS {
        text += &format!("{} lower ones\n", pair.peaks.len() - ROWS);
    }
    text
}
