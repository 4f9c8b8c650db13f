//! Sentences about a method comparison: recommendation, labels.

use super::work_precision_text::{format_error, format_time_short};
use crate::base::text::pluralise;
use crate::study::comparison::{ComparedMethod, ComparisonResult, ModelSize};

/// Recommended method for the requested error.
pub fn recommendation_text(found: &ComparisonResult, wanted: f64) -> String {
    let of = |method: &ComparedMethod| {
        format!(
            "{} ({})",
            method_label(method),
            format_time_short(method.seconds)
        )
    };
    match (found.cheapest(wanted), found.most_accurate()) {
        (Some(method), _) => format!("for {wanted:e} the cheapest is {}", of(method)),
        (None, Some(method)) => {
            let mut text = format!(
                "no way reaches {wanted:e}; nearest is {} with {}",
                of(method),
                method.error.map_or(String::new(), format_error)
            );
            if found.reference_error > wanted {
                text += &format!(
                    ", and the reference itself is known to {} only",
                    format_error(found.reference_error)
                );
            }
            text
        }
        (None, None) => "no way came to its end, so that none can be recommended".to_string(),
    }
}

fn method_label(method: &ComparedMethod) -> String {
    match method.size {
        Some(_) => format!("{} at {}", method.method, size_text(method)),
        None => method.method.to_string(),
    }
}

/// Model size of a method, as text.
pub fn size_text(method: &ComparedMethod) -> String {
    match method.size {
        Some(ModelSize::Coordinates(n)) => pluralise(n, "coordinate"),
        Some(ModelSize::Modes(n)) => pluralise(n, "mode"),
        Some(ModelSize::ShaftElements(n)) => pluralise(n, "length"),
        None => "–".to_string(),
    }
}
