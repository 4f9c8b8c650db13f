//! A given pair of profiles checked by the law of gearing: where its common normal misses the pitch point, and the ratio it then gives.

use super::centrodes::{Centrodes, Member};
use super::conjugate::conjugate;
use super::conjugate_flank::FLANK_POINTS;
use super::law_of_gearing::{GearingCheck, check_gearing};
use super::profile::Shape;
use super::rolling::Rolling;
use crate::base::code::Code;
use crate::base::error::Error;

/// A contact of both profiles with the ratio that the law requires there.
#[derive(Debug, Clone, Copy)]
pub struct GivenContact {
    /// The contact.
    pub check: GearingCheck,
    /// Ratio of the law.
    pub ratio: f64,
}

/// Contacts of both profiles over the angles at which the pinion's would touch its conjugate; angles without a contact are left out.
///
/// # Errors
/// A pinion's profile without a conjugate; `OutOfRange` where the profiles touch nowhere.
pub fn contacts(
    pair: &Centrodes,
    pinion: &Shape,
    gear: &Shape,
) -> Result<Vec<GivenContact>, Error> {
    let generated = conjugate(&Rolling::of_pair(pair), pinion.clone(), FLANK_POINTS)?;
    let angles = (generated.contacts().iter()).filter_map(|c| pair.angle_at_arc(c.arc));
    let contact = |angle: f64| {
        let check = *check_gearing(pair, pinion, gear, &[angle]).ok()?.first()?;
        let turn = pair.displacement(Member::Second, angle)?;
        Some(GivenContact {
            check,
            ratio: turn[1].abs().recip(),
        })
    };
    let found: Vec<GivenContact> = angles.filter_map(contact).collect();
    match found.is_empty() {
        false => Ok(found),
        true => {
            let message = "the given flanks of pinion and gear do not touch";
            Err(Error::new(Code::OutOfRange, message).with_hint(
                "check the frames: at φ₁ = 0 both are parallel, and the pitch point lies on the x axis between the gears",
            ))
        }
    }
}
