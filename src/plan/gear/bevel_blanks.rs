//! Warnings about the blanks of a bevel pair: pitch cones that do not touch, slots without width, pointed teeth of a design.

use std::f64::consts::PI;

use super::bevel_member::MemberResult;
use super::hypoid_theory::gap_of_pitch_cones;
use crate::base::error::Diagnostic;
use crate::gear::bevel::slots::Slots;
use crate::gear::bevel::tooth::SIDES;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;

/// Places along the face in the order of [`Slots`].
const PLACES: [&str; 3] = ["toe", "mean point", "heel"];

/// Warnings about the blanks of a file; slots and top lands of a member whose flanks make a tooth are those of the tooth.
pub(super) fn warnings(file: &BevelFile) -> Vec<Diagnostic> {
    let mut all: Vec<Diagnostic> = apart(file).into_iter().collect();
    if let Some(design) = file.design.filter(|d| !d.method.is_face_hobbed()) {
        let is_bare = |k: &usize| file.members[*k].lacks_tooth().is_some();
        let slots = Slots::of(&design);
        all.extend((0..2).filter(is_bare).flat_map(|k| of_design(&slots, k)));
    }
    all
}

/// Spiral angles of flank and design that differ by more are those of different gears, rad.
const SAME_SPIRAL: f64 = 2.0 * PI / 180.0;

/// Warnings about teeth that do not belong to their blanks or to each other.
pub(super) fn of_teeth(file: &BevelFile, members: &[MemberResult; 2]) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    let places = (0..2).flat_map(|k| (0..2).map(move |side| (k, side)));
    for (k, side) in places {
        let elements = members[k].flanks[side].as_ref().and_then(|f| f.elements);
        let Some((design, elements)) = file.design.zip(elements) else {
            continue;
        };
        let [of_blank, of_flank] = [design.spiral_angles[k], elements.spiral_angle].map(f64::abs);
        if (of_blank - of_flank).abs() > SAME_SPIRAL {
            all.push(Diagnostic {
                code: "other-spiral",
                message: format!(
                    "the {} flank of the {} has a spiral angle of {:.2}° at its mean point, and its blank is designed for {:.2}°",
                    SIDES[side],
                    MEMBERS[k],
                    of_flank.to_degrees(),
                    of_blank.to_degrees()
                ),
                hint: Some("check spiral_angle or settings of the flank, and the spiral angle in `blank`".into()),
            });
        }
    }
    all
}

/// Pitch cones that do not touch.
fn apart(file: &BevelFile) -> Option<Diagnostic> {
    let [pinion, gear] = file.members.each_ref().map(|m| &m.blank);
    let gap = gap_of_pitch_cones(file)?;
    let how = match gap > 0.0 {
        true => format!("are {:.3} mm apart", 1e3 * gap),
        false => format!("overlap by {:.3} mm", -1e3 * gap),
    };
    let sum = pinion.pitch_angle + gear.pitch_angle;
    let message = format!(
        "the pitch cones do not touch: at the mean point of the pinion they {how}, with pitch angles of {:.3}° in sum, a shaft angle of {:.3}° and an offset of {:.3} mm",
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

/// Slots, top lands and edge radii of a member that have no width.
fn of_design(slots: &Slots, member: usize) -> Vec<Diagnostic> {
    let name = MEMBERS[member];
    let least = |values: &[f64; 3]| {
        let mut places = PLACES.into_iter().zip(values);
        let first = places.next()?;
        let (place, value) = places.fold(first, |a, b| if b.1 < a.1 { b } else { a });
        (*value <= 0.0).then(|| (place, 1e3 * value))
    };
    let mut all = Vec::new();
    let mut warn = |code, message: String, hint: &str| {
        let hint = Some(hint.to_string());
        all.push(Diagnostic {
            code,
            message,
            hint,
        });
    };
    let edge_radius = (slots.edge_radii.without_interference).map(|radii| 1e3 * radii[member]);
    if let Some((place, width)) = least(&slots.widths[member]) {
        warn(
            "no-slot",
            format!(
                "the slot between the teeth of the {name} has no width at the {place}: it is {width:.3} mm, and no blade cuts it"
            ),
            "take a smaller addendum_angle, dedendum_angle or depth_factor, or fewer teeth of the gear",
        );
    } else if let Some(edge_radius) = edge_radius.filter(|radius| *radius < 0.0) {
        warn(
            "interference",
            format!(
                "the tip of the {} reaches beneath the flank that even a sharp blade leaves on the {name} at the toe: the largest edge radius without interference is {edge_radius:.3} mm",
                MEMBERS[1 - member]
            ),
            "take a larger clearance_factor or pressure_angle",
        );
    }
    if let Some((place, width)) = least(&slots.top_lands[member]) {
        let remedy = match member {
            0 => "take a larger addendum_factor or thickness_factor, or a smaller dedendum_angle",
            _ => {
                "take a smaller addendum_angle, dedendum_angle or thickness_factor, or fewer teeth of the gear"
            }
        };
        warn(
            "pointed",
            format!(
                "the teeth of the {name} are pointed at the {place}: the top land of the design is {width:.3} mm"
            ),
            remedy,
        );
    }
    all
}
