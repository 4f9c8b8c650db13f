//! Two cylindrical gears in mesh: centre distance, working pressure angle, tip diameters, clearances (ISO 21771-1:2024).
//!
//! Without backlash `inv α_wt = inv α_t + 2 (x₁ ± x₂) tan α_n/(z₂ ± z₁)`, − with an internal second gear; at a centre distance
//! `cos α_wt = (r_b2 ± r_b1)/a`.

use super::involute::{angle_from_inv, inv};
use super::member::{MEMBERS, Member};
use super::outline::ToothOutline;
use crate::base::bound::Bound;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;

/// Helix angles, modules and pressure angles nearer than this, relative, are equal: rounding of a conversion of units.
const SAME: f64 = 1e-9;

/// Two gears on parallel axes at a centre distance; the second may be internal.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// The gears, with their tip diameters.
    pub members: [Member; 2],
    /// Outlines of their teeth.
    pub outlines: [ToothOutline; 2],
    /// Centre distance a, m.
    pub centre_distance: f64,
    /// Working transverse pressure angle α_wt, rad.
    pub working_pressure_angle: f64,
}

impl Pair {
    /// The pair at a centre distance, by default without backlash at the nominal tooth thickness.
    ///
    /// # Errors
    /// `OutOfRange`, `Conflict`: gears that cannot mesh, or a centre distance at which they do not reach each other.
    pub fn new(members: [Member; 2], centre_distance: Option<f64>) -> Result<Pair, Error> {
        for (member, name) in members.iter().zip(MEMBERS) {
            member.check().map_err(|error| error.with_part(name))?;
        }
        check_mates(&members)?;
        let involute = working_involute(&members);
        let without_backlash = angle_from_inv(involute);
        let base = base_distance(&members);
        let centre_distance = match centre_distance {
            Some(distance) if distance > base && distance.is_finite() => distance,
            Some(distance) => {
                let message = format!(
                    "centre distance {:.6} mm: the base circles touch at {:.6} mm",
                    1e3 * distance,
                    1e3 * base
                );
                let hint = match without_backlash > 0.0 {
                    true => format!(
                        "without backlash it is {:.4} mm",
                        1e3 * base / without_backlash.cos()
                    ),
                    false => "give a larger centre_distance and profile shifts that fit it".into(),
                };
                let error = Error::new(Code::OutOfRange, message).with_key("centre_distance");
                return Err(error.with_hint(hint));
            }
            None if without_backlash > 0.0 => base / without_backlash.cos(),
            None => {
                let message = "no centre distance is free of backlash: the teeth are too thin for their spaces";
                let limit = shift_sum_at(&members, 0.0);
                let (side, bound) = match members[1].gear.internal {
                    true => ("most", Bound::AtMost(limit)),
                    false => ("least", Bound::AtLeast(limit)),
                };
                let hint = format!(
                    "give centre_distance, or profile shifts with a sum of at {side} {}",
                    bound.text(4)
                );
                let error = Error::new(Code::OutOfRange, message).with_key("gear.profile_shift");
                return Err(error.with_hint(hint));
            }
        };
        let mut members = members;
        let k = clearance_keeping_alteration(&members, centre_distance).min(0.0);
        for member in &mut members {
            let tip = member
                .tip_diameter
                .unwrap_or(member.altered_tip_diameter(k));
            member.tip_diameter = Some(tip);
        }
        let outline =
            |i: usize| ToothOutline::new(&members[i]).map_err(|error| error.with_part(MEMBERS[i]));
        Ok(Pair {
            outlines: [outline(0)?, outline(1)?],
            members,
            centre_distance,
            working_pressure_angle: (base / centre_distance).acos(),
        })
    }

    /// +1 of an external pair, −1 of an internal one.
    pub(super) fn sense(&self) -> f64 {
        self.members[1].sense()
    }

    /// Gear ratio u = z₂/z₁.
    pub fn ratio(&self) -> f64 {
        f64::from(self.members[1].gear.teeth) / f64::from(self.members[0].gear.teeth)
    }

    /// Reference centre distance a_d, m.
    pub fn reference_centre_distance(&self) -> f64 {
        let [d1, d2] = self.members.map(|m| m.gear.reference_diameter());
        0.5 * (d2 + self.sense() * d1)
    }

    /// Working pitch diameters d_w, m.
    pub fn working_diameters(&self) -> [f64; 2] {
        self.members
            .map(|m| m.gear.base_diameter() / self.working_pressure_angle.cos())
    }

    /// Transverse base pitch p_bt, m.
    pub fn base_pitch(&self) -> f64 {
        self.members[0].gear.base_pitch()
    }

    /// Bottom clearances c at the root of either gear, m; negative where the mate's tip reaches the root circle.
    pub fn bottom_clearances(&self) -> [f64; 2] {
        let [tip1, tip2] = self.members.map(|m| 0.5 * m.tip_diameter());
        let [root1, root2] = self.outlines.map(|o| o.root_radius);
        let a = self.centre_distance;
        match self.members[1].gear.internal {
            false => [a - root1 - tip2, a - root2 - tip1],
            true => [tip2 - a - root1, root2 - a - tip1],
        }
    }
}

fn check_mates(members: &[Member; 2]) -> Result<(), Error> {
    let [first, second] = members.map(|m| m.gear);
    let conflict = |message: String| Err(Error::new(Code::Conflict, message));
    if first.internal {
        let message = "the first gear is internal; an internal gear is the second";
        let error = Error::new(Code::Conflict, message).with_key("pinion.internal");
        return Err(error.with_hint("exchange the tables `pinion` and `gear`"));
    }
    let shared = [
        ("normal module", "mm", 1e3, first.module, second.module),
        (
            "pressure angle",
            "deg",
            1f64.to_degrees(),
            first.pressure_angle,
            second.pressure_angle,
        ),
        (
            "helix angle",
            "deg",
            1f64.to_degrees(),
            first.helix.abs(),
            second.helix.abs(),
        ),
    ];
    for (name, unit, scale, one, other) in shared {
        let shown = |x: f64| format!("{} {unit}", format_number(scale * x));
        if (one - other).abs() > SAME * one.abs().max(other.abs()) {
            return conflict(format!(
                "the gears differ in {name}: {} and {}",
                shown(one),
                shown(other)
            ));
        }
    }
    if second.internal && second.teeth <= first.teeth {
        let (ring, pinion) = (second.teeth, first.teeth);
        let message = format!("internal gear of {ring} teeth cannot contain a pinion of {pinion}");
        let error = Error::new(Code::Conflict, message).with_key("gear.teeth");
        return Err(error.with_hint(format!(
            "give more than {pinion} teeth, or fewer to the pinion"
        )));
    }
    Ok(())
}

/// z₂ ± z₁.
fn tooth_sum(members: &[Member; 2]) -> f64 {
    let [z1, z2] = members.map(|m| f64::from(m.gear.teeth));
    z2 + members[1].sense() * z1
}

/// inv α_wt without backlash at the nominal thicknesses.
fn working_involute(members: &[Member; 2]) -> f64 {
    let gear = &members[0].gear;
    let shifts = members[1].sense() * (gear.profile_shift + members[1].gear.profile_shift);
    inv(gear.transverse_pressure_angle())
        + 2.0 * shifts * gear.pressure_angle.tan() / tooth_sum(members)
}

/// Distance at which the base circles touch, m.
pub(super) fn base_distance(members: &[Member; 2]) -> f64 {
    let [b1, b2] = members.map(|m| 0.5 * m.gear.base_diameter());
    b2 + members[1].sense() * b1
}

/// Tip alteration coefficient that keeps the bottom clearance of the rack: `k = ±(a − a_d)/m_n − (x₁ + x₂)`, − for internal pairs.
fn clearance_keeping_alteration(members: &[Member; 2], centre_distance: f64) -> f64 {
    let sense = members[1].sense();
    let [d1, d2] = members.map(|m| m.gear.reference_diameter());
    let reference = 0.5 * (d2 + sense * d1);
    let shifts = members[0].gear.profile_shift + members[1].gear.profile_shift;
    sense * (centre_distance - reference) / members[0].gear.module - shifts
}

/// Sum x₁ + x₂ of the profile shifts that leaves no backlash at a centre distance; NaN where the base circles do not touch.
pub fn profile_shift_sum(members: &[Member; 2], centre_distance: f64) -> f64 {
    shift_sum_at(
        members,
        inv((base_distance(members) / centre_distance).acos()),
    )
}

/// The sum of profile shifts without backlash at a working involute.
fn shift_sum_at(members: &[Member; 2], involute: f64) -> f64 {
    let gear = &members[0].gear;
    let beyond = involute - inv(gear.transverse_pressure_angle());
    members[1].sense() * beyond * tooth_sum(members) / (2.0 * gear.pressure_angle.tan())
}
