//! `[[slide]]` and `[[screw]]`.

use super::model::{Screw, Slide};
use super::shared_keys;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;

/// A body that a screw moves along.
pub fn slide(f: &mut TableReader) -> Slide {
    Slide {
        name: shared_keys::name(f),
        mass: f.quantity("mass", QuantityKind::Mass, ValueRange::NotNegative),
    }
}

/// A screw and its nut.
pub fn screw(f: &mut TableReader) -> Screw {
    const LEAD: ValueRange = ValueRange::Open(1e-6, 10.0, "above 1 µm and below 10 m");
    let name = shared_keys::name(f);
    let between = shared_keys::read_body_pair(f);
    let lead = f.quantity("lead", QuantityKind::Length, LEAD);
    Screw {
        name,
        between,
        // Where the lead is wrong that has been noted.
        lead: (1e9 * lead).round().max(1.0) as u64,
        hand: shared_keys::hand(f),
        contact: shared_keys::read_contact(f, ""),
    }
}
