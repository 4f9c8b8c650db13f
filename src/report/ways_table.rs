//! What ways to one answer cost, as a table for a terminal.

use super::accuracy_words::{off, time};
use super::table::{finish, plain, right_but_first};
use super::ways_words::{advice, at};
use crate::base::words::counted;
use crate::study::ways::{Way, Ways};

/// The table, the reference, the recommendation.
pub fn table(found: &Ways, wanted: f64) -> String {
    let mut text = format!(
        "error in {} ({}) against run time; {}\nreference: {}, good to {}\n\n",
        found.compared,
        found.norm,
        counted(found.freedoms, "freedom"),
        found.reference,
        off(found.reference_error),
    );
    let mut table = plain();
    table.set_header(["way", "at", "error", "time"]);
    for way in &found.list {
        let Some(error) = way.error else { continue };
        let row = [
            way.method.to_string(),
            at(way),
            off(error),
            time(way.seconds),
        ];
        table.add_row(row);
    }
    right_but_first(&mut table);
    text += &finish(&table);
    let failed: Vec<(&Way, &String)> = found
        .list
        .iter()
        .filter_map(|w| Some((w, w.failed.as_ref()?)))
        .collect();
    if !failed.is_empty() {
        let mut table = plain();
        for (way, why) in failed {
            table.add_row([way.method.to_string(), at(way), why.clone()]);
        }
        text += &format!("\nleft out or failed\n{}", finish(&table));
    }
    text += &format!("\n{}\n", advice(found, wanted));
    text
}
