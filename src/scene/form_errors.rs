//! `[[error]]`: what a gear's flanks do wrong in every turn.

use super::common;
use super::laws::Shape;
use super::model::{FormError, Name};
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// The highest order per turn.
const HIGHEST: u32 = 1_000_000;

/// An error of a gear.
pub fn form_error(f: &mut Fields) -> FormError {
    let on = common::one_node(f, "on");
    let mesh = f.optional_text("mesh").map(|text| Name {
        text: text.to_string(),
        place: f.place_of("mesh").clone(),
    });
    let cause = f
        .optional_text("cause")
        .unwrap_or("eccentricity")
        .to_string();
    f.exclusive("amplitude", "values");
    let shape = match f.has("values") {
        true => {
            let values = f
                .optional_quantities("values", Kind::Length, Range::Any, None)
                .unwrap_or_default();
            if values.len() < 2 && f.has("values") {
                f.refuse_key(
                    Code::OutOfRange,
                    "values",
                    "a table over one turn needs two values at least",
                    "give one value a tooth, cumulative",
                );
            }
            Shape::Table(values)
        }
        false => {
            let amplitude = f.quantity("amplitude", Kind::Length, Range::NotNegative);
            let order = f.optional_count("order", 1, HIGHEST).unwrap_or(1);
            let phase = f
                .optional_quantity("phase", Kind::Angle, Range::Any)
                .unwrap_or(0.0);
            Shape::Fourier {
                mean: 0.0,
                terms: vec![(order, amplitude, phase)],
            }
        }
    };
    FormError {
        on,
        mesh,
        cause,
        shape,
    }
}
