//! Cost of the methods for one result, as a table for a terminal.

use super::method_comparison_text::{recommendation_text, size_text};
use super::modes_table::{finish, plain, right_but_first};
use super::work_precision_text::{format_error, format_time_short};
use crate::base::text::pluralise;
use crate::study::comparison::{ComparedMethod, ComparisonResult};

/// The table, the reference, the recommendation.
pub fn table(found: &ComparisonResult, wanted: f64) -> String {
    let mut text = format!(
        "error in {} ({}) against run time; {}\nreference: {}, good to {}\n\n",
        found.quantity,
        found.norm,
        pluralise(found.dofs, "freedom"),
        found.reference,
        format_error(found.reference_error),
    );
    let mut table = plain();
    table.set_header(["way", "at", "error", "time"]);
    for method in &found.methods {
        let Some(error) = method.error else { continue };
        let row = [
            method.method.to_string(),
            size_text(method),
            format_error(error),
            format_time_short(method.seconds),
        ];
        table.add_row(row);
    }
    right_but_first(&mut table);
    text += &finish(&table);
    let failed: Vec<(&ComparedMethod, &String)> = found
        .methods
        .iter()
        .filter_map(|w| Some((w, w.failure.as_ref()?)))
        .collect();
    if !failed.is_empty() {
        let mut table = plain();
        for (method, why) in failed {
            table.add_row([method.method.to_string(), size_text(method), why.clone()]);
        }
        text += &format!("\nleft out or failed\n{}", finish(&table));
    }
    text += &format!("\n{}\n", recommendation_text(found, wanted));
    text
}
