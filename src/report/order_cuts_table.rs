//! Order cuts as tables for a terminal.

use std::f64::consts::TAU;

use super::modes_table::{finish, plain, right_but_last};
use super::number_format::{four_digits, significant};
use crate::plan::logs::order_cuts::{OrderCuts, rpm};

/// The largest amplitude of each order, with its speed.
pub fn table(found: &OrderCuts) -> String {
    let mut text = format!("{}\n\n", found.method_text);
    let mut table = plain();
    table.add_row(vec!["order", "largest", "at", "frequency", "phase", ""]);
    table.add_row(vec!["", "", "rpm", "Hz", "deg", ""]);
    for cut in &found.cuts {
        let Some(at) = cut.largest() else { continue };
        let speed = found.speed[at];
        table.add_row(vec![
            four_digits(cut.order),
            four_digits(cut.value[at].norm()),
            significant(rpm(speed)),
            significant(cut.order * speed / TAU),
            format!("{:.0}", cut.value[at].arg().to_degrees()),
            format!("{} {}", cut.channel, cut.unit),
        ]);
    }
    right_but_last(&mut table);
    text += &finish(&table);
    text
}
