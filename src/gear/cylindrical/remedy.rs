//! Nearest values that can be followed: each as it is printed leaves the pair without its warning and without a new one.
//!
//! Where the value of one warning brings another (longer tips against short contact, shorter ones against interference), profile shifts or
//! tooth numbers of teeth with the rack's tips, nearest to the present ones, that leave no warning take its place.

use std::f64::consts::PI;

use super::member::Member;
use super::pair::Pair;
use super::warnings::{NearestValue, Warning, WarningKind};
use crate::base::bound::Bound;
use crate::gear::kernel::root::sign_change;
use crate::numeric::sorting::sort_rising;

/// Profile shifts tried, in tenths.
const SHIFTS: std::ops::RangeInclusive<i32> = -8..=12;
/// Most teeth added to the pinion.
const MOST_TEETH: u32 = 40;
/// By how many modules the centre distance is moved at most.
const FARTHEST: f64 = 3.0;

/// Decimals of printed values: of a coefficient, of mm.
pub const DECIMALS: usize = 4;

/// A bound as it is printed.
fn printed(bound: Bound) -> f64 {
    bound.text(DECIMALS).parse().unwrap_or(f64::NAN)
}

/// A length as it is printed in mm, m.
fn printed_length(bound: Bound) -> f64 {
    1e-3 * printed(bound.scaled(1e3))
}

/// Gears as a file describes them: without a value where it leaves the default.
#[derive(Debug, Clone, Copy)]
pub struct Design {
    /// The gears.
    pub members: [Member; 2],
    /// Centre distance, m; without backlash by default.
    pub centre_distance: Option<f64>,
}

impl Design {
    /// The pair.
    fn pair(&self) -> Option<Pair> {
        Pair::new(self.members, self.centre_distance).ok()
    }

    /// The design with a value as it is printed.
    pub fn with(&self, nearest: NearestValue) -> Design {
        let mut changed = *self;
        match nearest {
            NearestValue::ProfileShift { member, value } => {
                changed.members[member].gear.profile_shift = printed(value);
            }
            NearestValue::TipDiameter { member, value } => {
                changed.members[member].tip_diameter = Some(printed_length(value));
            }
            NearestValue::TipDiameters(tips) => {
                for (member, tip) in changed.members.iter_mut().zip(tips) {
                    member.tip_diameter = Some(printed_length(tip));
                }
            }
            NearestValue::FaceWidth(width) => {
                for member in &mut changed.members {
                    member.face_width = printed_length(width);
                }
            }
            NearestValue::CentreDistance(distance) => {
                changed.centre_distance = Some(printed_length(distance));
            }
            NearestValue::Teeth { teeth, shifts, .. } => {
                changed.centre_distance = None;
                for (i, member) in changed.members.iter_mut().enumerate() {
                    member.gear.teeth = teeth[i];
                    member.gear.profile_shift = shifts[i];
                    member.tip_diameter = None;
                }
            }
        }
        changed
    }

    /// The warnings of the pair, each with a value that can be followed where there is one.
    pub fn warnings(&self, pair: &Pair) -> Vec<Warning> {
        let met = pair.warnings();
        let mut whole = None;
        let followed = |warning: &Warning| {
            let is_old = |new: &Warning| {
                let same = |old: &Warning| old.kind == new.kind && old.member == new.member;
                met.iter().any(same) && !(new.kind == warning.kind && new.member == warning.member)
            };
            let leaves = |nearest: &NearestValue| {
                let changed = self.with(*nearest).pair();
                changed.is_some_and(|pair| pair.warnings().iter().all(is_old))
            };
            let own = warning.nearest.into_iter();
            let contact = match warning.kind {
                WarningKind::ContactRatio => self.longer_contact(pair),
                _ => Vec::new(),
            };
            own.chain(contact).find(leaves)
        };
        let with_value = |warning: &Warning| Warning {
            nearest: followed(warning)
                .or_else(|| *whole.get_or_insert_with(|| self.without_warnings(pair))),
            ..*warning
        };
        met.iter().map(with_value).collect()
    }

    /// Face width and centre distance at which the contact ratio is 1.
    fn longer_contact(&self, pair: &Pair) -> Vec<NearestValue> {
        let (ratios, gear) = (pair.contact_ratios(), &pair.members[0].gear);
        let slope = gear.helix.sin().abs();
        let missing = 1.0 - ratios.transverse;
        let width = (slope > 0.0)
            .then(|| NearestValue::FaceWidth(Bound::AtLeast(missing * PI * gear.module / slope)));
        let made = pair.members;
        let beyond = |distance: f64| {
            let at = Pair::new(made, Some(distance)).ok()?;
            Some(at.contact_ratios().total - 1.0)
        };
        let (from, reach) = (pair.centre_distance, FARTHEST * gear.module);
        let centre = match pair.members[1].gear.internal {
            false => sign_change([from - reach, from], |a| Some(beyond(a).unwrap_or(1.0)))
                .map(Bound::AtMost),
            true => sign_change([from, from + reach], |a| Some(beyond(a).unwrap_or(1.0)))
                .map(Bound::AtLeast),
        };
        width
            .into_iter()
            .chain(centre.map(NearestValue::CentreDistance))
            .collect()
    }

    /// Profile shifts or tooth numbers nearest to the present ones that leave no warning, or none but that of radial assembly.
    pub fn without_warnings(&self, pair: &Pair) -> Option<NearestValue> {
        let gears = pair.members.map(|member| member.gear);
        let present = gears.map(|gear| gear.profile_shift);
        let teeth = gears.map(|gear| gear.teeth);
        let tenths = |i: i32| f64::from(i) / 10.0;
        let mut shifts: Vec<[f64; 2]> = SHIFTS
            .flat_map(|i| SHIFTS.map(move |j| [tenths(i), tenths(j)]))
            .collect();
        let far = |s: &[f64; 2]| (s[0] - present[0]).hypot(s[1] - present[1]);
        sort_rising(&mut shifts, far);
        let of_shifts = shifts.into_iter().map(|shifts| NearestValue::Teeth {
            teeth,
            shifts,
            axial_assembly: false,
        });
        let more = (1..=MOST_TEETH).map(|more| {
            let second = f64::from(more) * pair.ratio();
            NearestValue::Teeth {
                teeth: [teeth[0] + more, teeth[1] + second.round().max(1.0) as u32],
                shifts: [0.0; 2],
                axial_assembly: false,
            }
        });
        // The first without any warning, else the first of those that leave radial assembly impossible.
        let mut along_axis = None;
        for nearest in of_shifts.chain(more) {
            let Some(changed) = self.with(nearest).pair() else {
                continue;
            };
            match changed.warnings()[..] {
                [] => return Some(nearest),
                [only] if only.kind == WarningKind::TrimmingInterference => {
                    along_axis = along_axis.or(Some(nearest));
                }
                _ => {}
            }
        }
        along_axis.map(|nearest| match nearest {
            NearestValue::Teeth { teeth, shifts, .. } => NearestValue::Teeth {
                teeth,
                shifts,
                axial_assembly: true,
            },
            other => other,
        })
    }
}
