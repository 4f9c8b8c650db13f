//! Limits that a pair meets, as warnings: what is wrong, by how much, and the nearest value that avoids it.

use crate::base::error::Diagnostic;
pub use crate::gear::cylindrical::member::MEMBERS;
use crate::gear::cylindrical::pair::Pair;
use crate::gear::cylindrical::remedy::DECIMALS;
use crate::gear::cylindrical::warnings::{NearestValue, Warning, WarningKind};

/// The warning as a diagnostic.
pub fn diagnostic(warning: &Warning) -> Diagnostic {
    let member = warning.member.map_or("pair", |m| MEMBERS[m]);
    let mate = warning.member.map_or("mate", |m| MEMBERS[1 - m]);
    let by_um = 1e6 * warning.by;
    let message = match warning.kind {
        WarningKind::Undercut => format!(
            "the {member} is undercut: its generating profile shift coefficient is {:.4} below the limit",
            warning.by
        ),
        WarningKind::InvoluteInterference => format!(
            "involute interference: the tip of the {mate} reaches {by_um:.1} µm along the path beyond the base circle of the {member}"
        ),
        WarningKind::FilletInterference => format!(
            "the tip of the {mate} reaches the fillet of the {member} by {by_um:.1} µm along the path"
        ),
        WarningKind::TrochoidInterference => {
            "trochoid interference: tip corners of pinion and ring collide outside the path of contact"
                .into()
        }
        WarningKind::TrimmingInterference => {
            "the pinion cannot be assembled radially: tip corners collide; assemble it axially"
                .into()
        }
        WarningKind::ContactRatio => format!(
            "the total contact ratio is {:.4}, below 1: the motion is not transmitted between pairs",
            1.0 - warning.by
        ),
        WarningKind::PointedTip => format!(
            "the teeth of the {member} are pointed {by_um:.1} µm of diameter before the tip cylinder"
        ),
        WarningKind::Clearance => format!(
            "the tip of the {mate} reaches the root circle of the {member} by {by_um:.1} µm"
        ),
    };
    Diagnostic {
        code: code(warning.kind),
        message,
        hint: warning.nearest.map(hint),
    }
}

/// The word of a warning.
pub fn code(kind: WarningKind) -> &'static str {
    match kind {
        WarningKind::Undercut => "undercut",
        WarningKind::InvoluteInterference
        | WarningKind::FilletInterference
        | WarningKind::TrochoidInterference
        | WarningKind::TrimmingInterference => "interference",
        WarningKind::ContactRatio => "contact-ratio",
        WarningKind::PointedTip => "pointed",
        WarningKind::Clearance => "clearance",
    }
}

/// The name of a limit in a list of those that are kept.
pub fn name(kind: WarningKind) -> &'static str {
    match kind {
        WarningKind::Undercut => "undercut",
        WarningKind::InvoluteInterference => "involute interference",
        WarningKind::FilletInterference => "fillet interference",
        WarningKind::TrochoidInterference => "trochoid interference",
        WarningKind::TrimmingInterference => "trimming interference",
        WarningKind::ContactRatio => "contact ratio below 1",
        WarningKind::PointedTip => "pointed tips",
        WarningKind::Clearance => "clearance below 0",
    }
}

/// Names of the limits that a pair keeps.
pub fn kept(pair: &Pair, met: &[Warning]) -> Vec<&'static str> {
    let is_kept = |kind: &WarningKind| met.iter().all(|warning| warning.kind != *kind);
    WarningKind::of(pair).filter(is_kept).map(name).collect()
}

/// The value in words.
pub fn hint(nearest: NearestValue) -> String {
    match nearest {
        NearestValue::ProfileShift { member, value } => {
            format!(
                "{}.profile_shift = {} avoids it",
                MEMBERS[member],
                value.text(DECIMALS)
            )
        }
        NearestValue::TipDiameter { member, value } => format!(
            "{}.tip_diameter = \"{} mm\" avoids it",
            MEMBERS[member],
            value.scaled(1e3).text(DECIMALS)
        ),
        NearestValue::TipDiameters([first, second]) => format!(
            "tip diameters of {} mm (pinion) and {} mm (gear) avoid it",
            first.scaled(1e3).text(DECIMALS),
            second.scaled(1e3).text(DECIMALS)
        ),
        NearestValue::FaceWidth(width) => format!(
            "face_width = \"{} mm\" of both gears avoids it",
            width.scaled(1e3).text(DECIMALS)
        ),
        NearestValue::CentreDistance(distance) => format!(
            "pair.centre_distance = \"{} mm\" avoids it",
            distance.scaled(1e3).text(DECIMALS)
        ),
        NearestValue::Teeth {
            teeth: [z1, z2],
            shifts: [x1, x2],
            axial_assembly,
        } => format!(
            "teeth = {z1} with profile_shift = {x1} (pinion) and teeth = {z2} with profile_shift = {x2} (gear) avoid every warning{}, without tip_diameter and centre_distance",
            match axial_assembly {
                true => " except that of radial assembly",
                false => "",
            }
        ),
    }
}
