//! What ways to one answer cost, as a table for a terminal.

use super::accuracy_table::time;
use super::number::brief;
use super::table::{finish, plain, right_but_first};
use crate::base::words::counted;
use crate::study::ways::{Size, Way, Ways};

/// The table, the reference, the recommendation.
pub fn table(found: &Ways, wanted: f64) -> String {
    let mut text = format!(
        "error in {} ({}) against run time; {}\nreference: {}, good to {}\n\n",
        found.compared,
        found.norm,
        counted(found.freedoms, "freedom"),
        found.reference,
        brief(found.reference_error),
    );
    let mut table = plain();
    table.set_header(["way", "at", "error", "time"]);
    for way in &found.list {
        let Some(error) = way.error else { continue };
        let row = [
            way.method.to_string(),
            at(way),
            format!("{error:.1e}"),
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
    text += &match found.cheapest(wanted) {
        Some(way) => format!(
            "\nfor {wanted:e} the cheapest is {} ({})\n",
            named(way),
            time(way.seconds)
        ),
        None => format!("\nno way reaches {wanted:e}\n"),
    };
    text
}

fn named(way: &Way) -> String {
    match way.size {
        Some(_) => format!("{} at {}", way.method, at(way)),
        None => way.method.to_string(),
    }
}

fn at(way: &Way) -> String {
    match way.size {
        Some(Size::Coordinates(n)) => counted(n, "coordinate"),
        Some(Size::Modes(n)) => counted(n, "mode"),
        Some(Size::Lengths(n)) => counted(n, "length"),
        None => "–".to_string(),
    }
}
