//! Nearest remedial values: each value, rounded as printed, removes its warning from the pair without a new warning.
//!
//! If the value causes another warning (a longer addendum against a low contact ratio, a shorter one against interference), it is replaced
//! by the nearest profile shifts or tooth numbers without warnings, with the tips of the rack.

use std::f64::consts::PI;

use super::member::Member;
use super::pair::Pair;
use super::warnings::{NearestValue, Warning, WarningKind};
use crate::base::bound::Bound;
use crate::gear::kernel::root::sign_change;
use crate::numeric::sorting::sort_ascending;

/// Profile shift coefficients examined, in tenths.
const SHIFTS: std::ops::RangeInclusive<i32> = -8..=12;
/// Maximum number of teeth added to the pinion.
const MAX_ADDED_TEETH: u32 = 40;
/// Maximum change of the centre distance, modules.
const MAX_CENTRE_CHANGE: f64 = 3.0;

/// Number of decimals of printed coefficients and of lengths in mm.
pub const DECIMALS: usize = 4;

/// Bound, rounded as printed.
fn rounded(bound: Bound) -> f64 {
    bound.text(DECIMALS).parse().unwrap_or(f64::NAN)
}

/// Length in m, rounded as printed in mm.
fn rounded_length(bound: Bound) -> f64 {
    1e-3 * rounded(bound.scaled(1e3))
}

/// Gear pair of a file, with `None` for default values.
#[derive(Debug, Clone, Copy)]
pub struct Design {
    /// Members of the pair.
    pub members: [Member; 2],
    /// Centre distance, m; `None` for the distance without backlash.
    pub centre_distance: Option<f64>,
}

impl Design {
    /// Gear pair of the design; `None` if it is invalid.
    fn pair(&self) -> Option<Pair> {
        Pair::new(self.members, self.centre_distance).ok()
    }

    /// Returns the design with a remedial value, rounded as printed.
    pub fn with_nearest(&self, nearest: NearestValue) -> Design {
        let mut changed = *self;
        match nearest {
            NearestValue::ProfileShift { member, value } => {
                changed.members[member].gear.profile_shift = rounded(value);
            }
            NearestValue::TipDiameter { member, value } => {
                changed.members[member].tip_diameter = Some(rounded_length(value));
            }
            NearestValue::TipDiameters(tips) => {
                for (member, tip) in changed.members.iter_mut().zip(tips) {
                    member.tip_diameter = Some(rounded_length(tip));
                }
            }
            NearestValue::FaceWidth(width) => {
                for member in &mut changed.members {
                    member.face_width = rounded_length(width);
                }
            }
            NearestValue::CentreDistance(distance) => {
                changed.centre_distance = Some(rounded_length(distance));
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

    /// Warnings of the pair, each with a remedial value if one exists.
    pub fn warnings(&self, pair: &Pair) -> Vec<Warning> {
        let warnings = pair.warnings();
        let mut warning_free = None;
        let remedy = |warning: &Warning| {
            let is_present = |w: &Warning| {
                let is_same = |p: &Warning| p.kind == w.kind && p.member == w.member;
                warnings.iter().any(is_same) && !is_same(warning)
            };
            let is_remedy = |nearest: &NearestValue| {
                let changed = self.with_nearest(*nearest).pair();
                changed.is_some_and(|pair| pair.warnings().iter().all(is_present))
            };
            let direct = warning.nearest.into_iter();
            let contact = match warning.kind {
                WarningKind::ContactRatio => self.longer_contact(pair),
                _ => Vec::new(),
            };
            direct.chain(contact).find(is_remedy)
        };
        let with_value = |warning: &Warning| Warning {
            nearest: remedy(warning)
                .or_else(|| *warning_free.get_or_insert_with(|| self.without_warnings(pair))),
            ..*warning
        };
        warnings.iter().map(with_value).collect()
    }

    /// Face width and centre distance with a contact ratio of 1.
    fn longer_contact(&self, pair: &Pair) -> Vec<NearestValue> {
        let (ratios, gear) = (pair.contact_ratios(), &pair.members[0].gear);
        let slope = gear.helix.sin().abs();
        let missing = 1.0 - ratios.transverse;
        let width = (slope > 0.0)
            .then(|| NearestValue::FaceWidth(Bound::AtLeast(missing * PI * gear.module / slope)));
        let members = pair.members;
        let excess = |distance: f64| {
            let pair = Pair::new(members, Some(distance)).ok()?;
            Some(pair.contact_ratios().total - 1.0)
        };
        let (from, reach) = (pair.centre_distance, MAX_CENTRE_CHANGE * gear.module);
        let centre = match pair.members[1].gear.internal {
            false => sign_change([from - reach, from], |a| Some(excess(a).unwrap_or(1.0)))
                .map(Bound::AtMost),
            true => sign_change([from, from + reach], |a| Some(excess(a).unwrap_or(1.0)))
                .map(Bound::AtLeast),
        };
        width
            .into_iter()
            .chain(centre.map(NearestValue::CentreDistance))
            .collect()
    }

    /// Profile shifts or tooth numbers nearest to the present ones without warnings, or with that of radial assembly only.
    pub fn without_warnings(&self, pair: &Pair) -> Option<NearestValue> {
        let gears = pair.members.map(|member| member.gear);
        let present = gears.map(|gear| gear.profile_shift);
        let teeth = gears.map(|gear| gear.teeth);
        let tenths = |i: i32| f64::from(i) / 10.0;
        let mut shifts: Vec<[f64; 2]> = SHIFTS
            .flat_map(|i| SHIFTS.map(move |j| [tenths(i), tenths(j)]))
            .collect();
        let distance = |s: &[f64; 2]| (s[0] - present[0]).hypot(s[1] - present[1]);
        sort_ascending(&mut shifts, distance);
        let by_shifts = shifts.into_iter().map(|shifts| NearestValue::Teeth {
            teeth,
            shifts,
            axial_assembly: false,
        });
        let by_teeth = (1..=MAX_ADDED_TEETH).map(|added| {
            let second = f64::from(added) * pair.ratio();
            NearestValue::Teeth {
                teeth: [teeth[0] + added, teeth[1] + second.round().max(1.0) as u32],
                shifts: [0.0; 2],
                axial_assembly: false,
            }
        });
        // First change without warnings, else the first that only prevents radial assembly.
        let mut axial = None;
        for nearest in by_shifts.chain(by_teeth) {
            let Some(changed) = self.with_nearest(nearest).pair() else {
                continue;
            };
            match changed.warnings()[..] {
                [] => return Some(nearest),
                [warning] if warning.kind == WarningKind::TrimmingInterference => {
                    axial = axial.or(Some(nearest));
                }
                _ => {}
            }
        }
        axial.map(|nearest| match nearest {
            NearestValue::Teeth { teeth, shifts, .. } => NearestValue::Teeth {
                teeth,
                shifts,
                axial_assembly: true,
            },
            other => other,
        })
    }
}
