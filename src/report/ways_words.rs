//! What is said of what ways to one answer cost.

use super::accuracy_words::{off, time};
use crate::base::words::counted;
use crate::study::ways::{Size, Way, Ways};

/// What is to be taken for the error wanted.
pub fn advice(found: &Ways, wanted: f64) -> String {
    let of = |way: &Way| format!("{} ({})", named(way), time(way.seconds));
    match (found.cheapest(wanted), found.nearest()) {
        (Some(way), _) => format!("for {wanted:e} the cheapest is {}", of(way)),
        (None, Some(way)) => {
            let mut text = format!(
                "no way reaches {wanted:e}; nearest is {} with {}",
                of(way),
                way.error.map_or(String::new(), off)
            );
            if found.reference_error > wanted {
                text += &format!(
                    ", and the reference itself is known to {} only",
                    off(found.reference_error)
                );
            }
            text
        }
        (None, None) => "no way came to its end, so that none can be recommended".to_string(),
    }
}

fn named(way: &Way) -> String {
    match way.size {
        Some(_) => format!("{} at {}", way.method, at(way)),
        None => way.method.to_string(),
    }
}

/// How fine a way is.
pub fn at(way: &Way) -> String {
    match way.size {
        Some(Size::Coordinates(n)) => counted(n, "coordinate"),
        Some(Size::Modes(n)) => counted(n, "mode"),
        Some(Size::Lengths(n)) => counted(n, "length"),
        None => "–".to_string(),
    }
}
