//! Warnings about the blanks of a bevel pair: pitch cones without contact, slots without width, pointed teeth of a design.

use std::f64::consts::PI;

use super::bevel_member::MemberResult;
use super::hypoid_theory::gap_of_pitch_cones;
use crate::base::error::Diagnostic;
use crate::gear::bevel::slots::Slots;
use crate::gear::bevel::tooth::SIDES;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;

/// Positions along the face in the order of [`Slots`].
const POSITIONS: [&str; 3] = ["toe", "mean point", "heel"];

/// Warnings about the blanks of a file; slots and top lands are checked for members without tooth flanks only.
pub(super) fn warnings(file: &BevelFile) -> Vec<Diagnostic> {
    let mut list: Vec<Diagnostic> = cone_gap(file).into_iter().collect();
    if let Some(design) = file.design.filter(|d| !d.method.is_face_hobbed()) {
        let no_tooth = |k: &usize| file.members[*k].missing_tooth_reason().is_some();
        let slots = Slots::of(&design);
        list.extend((0..2).filter(no_tooth).flat_map(|k| slot_checks(&slots, k)));
    }
    list
}

/// Maximum difference of the spiral angles of flank and design, rad.
const SAME_SPIRAL: f64 = 2.0 * PI / 180.0;

/// Warnings about flanks whose spiral angle differs from that of their blank.
pub(super) fn flank_warnings(file: &BevelFile, members: &[MemberResult; 2]) -> Vec<Diagnostic> {
    let mut list = Vec::new();
    let flanks = (0..2).flat_map(|k| (0..2).map(move |side| (k, side)));
    for (k, side) in flanks {
        let elements = members[k].flanks[side].as_ref().and_then(|f| f.elements);
        let Some((design, elements)) = file.design.zip(elements) else {
            continue;
        };
        let [blank, flank] = [design.spiral_angles[k], elements.spiral_angle].map(f64::abs);
        if (blank - flank).abs() > SAME_SPIRAL {
            list.push(Diagnostic {
                code: "other-spiral",
                message: format!(
                    "the {} flank of the {} has a spiral angle of {:.2}° at its mean point, and its blank is designed for {:.2}°",
                    SIDES[side],
                    MEMBERS[k],
                    flank.to_degrees(),
                    blank.to_degrees()
                ),
                hint: Some("check spiral_angle or settings of the flank, and the spiral angle in `blank`".into()),
            });
        }
    }
    list
}

/// Warning about pitch cones that do not touch.
fn cone_gap(file: &BevelFile) -> Option<Diagnostic> {
    let [pinion, gear] = file.members.each_ref().map(|m| &m.blank);
    let gap = gap_of_pitch_cones(file)?;
    let gap_text = match gap > 0.0 {
        true => format!("are {:.3} mm apart", 1e3 * gap),
        false => format!("overlap by {:.3} mm", -1e3 * gap),
    };
    let sum = pinion.pitch_angle + gear.pitch_angle;
    let message = format!(
        "the pitch cones do not touch: at the mean point of the pinion they {gap_text}, with pitch angles of {:.3}° in sum, a shaft angle of {:.3}° and an offset of {:.3} mm",
        sum.to_degrees(),
        file.nominal.shaft_angle.to_degrees(),
        1e3 * file.nominal.offset
    );
    Some(Diagnostic {
        code: "cones-apart",
        message,
        hint: Some("check shaft_angle and offset of the pair, pitch_angle, pitch_apex and mean_cone_distance of both blanks".into()),
    })
}

/// Warnings about slots, top lands and edge radii of a member that are not positive.
fn slot_checks(slots: &Slots, member: usize) -> Vec<Diagnostic> {
    let name = MEMBERS[member];
    let smallest = |values: &[f64; 3]| {
        let mut positions = POSITIONS.into_iter().zip(values);
        let first = positions.next()?;
        let (position, value) = positions.fold(first, |a, b| if b.1 < a.1 { b } else { a });
        (*value <= 0.0).then(|| (position, 1e3 * value))
    };
    let mut list = Vec::new();
    let mut warn = |code, message: String, hint: &str| {
        let hint = Some(hint.to_string());
        list.push(Diagnostic {
            code,
            message,
            hint,
        });
    };
    let edge_radius = (slots.edge_radii.without_interference).map(|radii| 1e3 * radii[member]);
    if let Some((position, width)) = smallest(&slots.widths[member]) {
        warn(
            "no-slot",
            format!(
                "the slot between the teeth of the {name} has no width at the {position} ({width:.3} mm): no blade can cut it"
            ),
            "take a smaller addendum_angle, dedendum_angle or depth_factor, or fewer teeth of the gear",
        );
    } else if let Some(edge_radius) = edge_radius.filter(|radius| *radius < 0.0) {
        warn(
            "interference",
            format!(
                "the tip of the {} interferes at the toe with the flank that even a sharp blade leaves on the {name}: the largest edge radius without interference is {edge_radius:.3} mm",
                MEMBERS[1 - member]
            ),
            "take a larger clearance_factor or pressure_angle",
        );
    }
    if let Some((position, width)) = smallest(&slots.top_lands[member]) {
        let remedy = match member {
            0 => "take a larger addendum_factor or thickness_factor, or a smaller dedendum_angle",
            _ => {
                "take a smaller addendum_angle, dedendum_angle or thickness_factor, or fewer teeth of the gear"
            }
        };
        warn(
            "pointed",
            format!(
                "the teeth of the {name} are pointed at the {position}: the top land of the design is {width:.3} mm"
            ),
            remedy,
        );
    }
    list
}
