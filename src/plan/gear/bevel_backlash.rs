//! Backlash of a bevel pair: of the design at the mean points, and the least one as assembled.

use super::bevel_contact::BevelContact;
use super::bevel_member::{MemberResult, flanks_of_sides};
use crate::base::error::Diagnostic;
use crate::gear::contact::backlash::{FlankPath, least_backlash};
use crate::gear::contact::contact_path::PITCHES;
use crate::gear::contact::pair::FlankPair;
use crate::scene::bevel_file::BevelFile;

/// Least backlash over a pitch; below zero where the teeth jam.
#[derive(Debug, Clone, Copy)]
pub struct LeastBacklash {
    /// Turn of the gear, rad.
    pub angle: f64,
    /// Along the normal, m: the angle times the lever of the contact force at the reference contact of the requested flanks.
    pub normal: f64,
}

/// The least backlash as assembled, errors of assembly included; none where a tooth is not known, and with a warning where the other flanks
/// do not touch.
pub(super) fn least(
    file: &BevelFile,
    members: &[MemberResult; 2],
    contact: &BevelContact,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<LeastBacklash> {
    let [Some(pinion), Some(gear)] = members.each_ref().map(|m| m.tooth.as_ref()) else {
        return None;
    };
    let sides = file.contact.side.flanks();
    let others = sides.map(|side| 1 - side);
    let teeth = file.members.each_ref().map(|m| m.teeth);
    let found = flanks_of_sides(members, others).and_then(|flanks| {
        let pair = FlankPair::new(flanks, teeth, file.hand, &file.assembly());
        let path = pair.path_near_teeth(PITCHES, file.contact.positions)?;
        let is_removed = pair.removed_at(&path.reference).is_some();
        (!is_removed).then_some((pair, path))
    });
    let Some((pair, path)) = found else {
        diagnostics.push(Diagnostic {
            code: "no-contact",
            message: format!(
                "the minimum backlash is unknown: the {} flanks do not touch near the middle of their teeth",
                file.contact.side.other().name()
            ),
            hint: Some("try the other side with --side, and check [assembly]".into()),
        });
        return None;
    };
    let requested = FlankPath {
        pair: &contact.pair,
        path: &contact.path,
        sides,
    };
    let opposite = FlankPath {
        pair: &pair,
        path: &path,
        sides: others,
    };
    let angle = least_backlash([pinion, gear], [requested, opposite])?;
    Some(LeastBacklash {
        angle,
        normal: angle * contact.forces.levers[1],
    })
}

/// Backlash normal to the flanks as designed, the pinion's tooth in the gear's space at the mean points, m; none without both teeth.
///
/// Arcs are taken at the means of spiral and pressure angle of both flanks of a member.
pub(super) fn of_design(members: &[MemberResult; 2]) -> Option<f64> {
    let of = |k: usize, arc: usize| {
        let [concave, convex] = members[k].flanks.each_ref().map(|f| f.as_ref()?.elements);
        let (concave, convex) = (concave?, convex?);
        let spiral = 0.5 * (concave.spiral_angle + convex.spiral_angle);
        let pressure = 0.5 * (concave.pressure_angle.abs() + convex.pressure_angle.abs());
        let arc = members[k].tooth.as_ref()?.mean_arcs()[arc];
        Some((arc * spiral.cos(), pressure.cos()))
    };
    let ((tooth, _), (space, cosine)) = (of(0, 0)?, of(1, 1)?);
    Some((space - tooth) * cosine)
}

/// Teeth that jam as assembled, or where the contact is not known by their design.
pub(super) fn warning(design: Option<f64>, least: Option<&LeastBacklash>) -> Option<Diagnostic> {
    let (backlash, place, hint) = match least {
        Some(least) => (
            least.normal,
            "as assembled",
            "reduce mean_normal_thickness, or increase pinion_axial or gear_axial in [assembly]",
        ),
        None => (
            design?,
            "at the mean points",
            "reduce mean_normal_thickness",
        ),
    };
    (backlash < 0.0).then(|| Diagnostic {
        code: "no-backlash",
        message: format!(
            "the teeth jam: the normal backlash {place} is {:.4} mm (limit 0)",
            1e3 * backlash
        ),
        hint: Some(hint.into()),
    })
}
