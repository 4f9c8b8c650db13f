//! `[[slide]]` and `[[screw]]`.

use super::common;
use super::model::{Screw, Slide};
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// A body that a screw moves along.
pub fn slide(f: &mut Fields) -> Slide {
    Slide {
        name: common::name(f),
        mass: f.quantity("mass", Kind::Mass, Range::NotNegative),
    }
}

/// A screw and its nut.
pub fn screw(f: &mut Fields) -> Screw {
    const LEAD: Range = Range::Between(1e-6, 10.0, "above 1 µm and below 10 m");
    let name = common::name(f);
    let between = common::bodies(f);
    let lead = f.quantity("lead", Kind::Length, LEAD);
    Screw {
        name,
        between,
        // Where the lead is wrong that has been noted.
        lead: (1e9 * lead).round().max(1.0) as u64,
        hand: common::hand(f),
        contact: common::along(f, ""),
    }
}
