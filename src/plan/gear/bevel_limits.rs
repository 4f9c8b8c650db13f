//! Limits of bevel flanks: undercut, second envelope, end of the cutter contact, pointed teeth.

use std::f64::consts::FRAC_PI_2;

use super::bevel_member::{FlankResult, MemberResult};
use crate::base::error::Diagnostic;
use crate::gear::bevel::flank::is_cut_away;
use crate::gear::bevel::tooth::{SIDES, TopLand};
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::{BevelFile, BevelMember};

/// Limit reached by a flank or tooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BevelLimit {
    /// Kind of limit: `undercut`, `second`, `unreached`, `cut-away` (the whole flank) or `pointed`.
    pub kind: &'static str,
    /// Index of the member, 0 for the pinion, 1 for the gear.
    pub member: usize,
    /// Index of the flank in [`SIDES`]; absent for the tooth.
    pub side: Option<usize>,
    /// Fractions of face and height of the point nearest the tip (of pointed teeth nearest the root).
    pub at: [f64; 2],
    /// Height of the tooth beyond the limit there, m.
    pub depth: f64,
}

/// Limits of both flanks and of the tooth of a member.
pub(super) fn limits(gear: &BevelMember, result: &MemberResult, member: usize) -> Vec<BevelLimit> {
    let flanks = result.flanks.iter().enumerate();
    let mut limits: Vec<BevelLimit> = flanks
        .filter_map(|(side, flank)| Some((side, flank.as_ref()?)))
        .flat_map(|(side, flank)| flank_limits(flank, member, side))
        .collect();
    limits.extend(result.top_land.and_then(|land| pointed(gear, land, member)));
    limits
}

/// Undercut and second-envelope limits of a flank; without them, the highest missing node, which the cutter removes or does not reach.
fn flank_limits(result: &FlankResult, member: usize, side: usize) -> Vec<BevelLimit> {
    let section = &result.flank.section;
    let limit = |(kind, at): (&'static str, [f64; 2])| {
        let [root, point] = [section.at(at[0], 0.0), section.at(at[0], at[1])];
        BevelLimit {
            kind,
            member,
            side: Some(side),
            at,
            depth: f64::hypot(point[0] - root[0], point[1] - root[1]),
        }
    };
    let kinds = ["undercut", "second"].into_iter().enumerate();
    let mut limits: Vec<BevelLimit> = kinds
        .filter_map(|(k, kind)| Some((kind, result.limits.highest[k]?)))
        .map(limit)
        .collect();
    if limits.is_empty() && !result.flank.envelope.motion.is_fixed() {
        let kind = |at: [f64; 2]| {
            let at_flank = result.flank.find(section.at(at[0], at[1]));
            let point = at_flank.and_then(|at_flank| result.flank.envelope.point(at_flank));
            match point.is_some_and(|point| is_cut_away(&point)) {
                true if result.grid.ranges().is_none() => "cut-away",
                true => "undercut",
                false => "unreached",
            }
        };
        let missing = result.grid.highest_missing();
        limits.extend(missing.map(|at| limit((kind(at), at))));
    }
    limits
}

/// Limit of a tooth whose flanks intersect below the tip.
fn pointed(gear: &BevelMember, land: TopLand, member: usize) -> Option<BevelLimit> {
    let height = land.pointed_at?;
    let [tip, apex] = [
        gear.section.at(land.face, 1.0),
        gear.section.at(land.face, height),
    ];
    Some(BevelLimit {
        kind: "pointed",
        member,
        side: None,
        at: [land.face, height],
        depth: f64::hypot(apex[0] - tip[0], apex[1] - tip[1]),
    })
}

/// Warning about a limit.
pub(super) fn warning(file: &BevelFile, limit: &BevelLimit) -> Diagnostic {
    let name = MEMBERS[limit.member];
    let flank = limit.side.map_or(String::new(), |side| {
        format!("{} flank of the ", SIDES[side])
    });
    let at = format!("{:.0} % of the face from the toe", 100.0 * limit.at[0]);
    let depth = 1e3 * limit.depth;
    let member = &file.members[limit.member];
    let flank_cut = limit.side.and_then(|side| member.flanks[side]);
    let (fillet, remedy) = match (member.straight, flank_cut) {
        (Some(_), _) => (
            ": the fillet of straight teeth is not computed",
            "take a smaller dedendum, or more teeth, for a flank down to the root",
        ),
        (None, Some(flank_cut)) if flank_cut.cutter.edge_radius == 0.0 => (
            ": the fillet that a sharp edge leaves is not computed",
            "give the cutter an edge_radius",
        ),
        _ => (
            ": neither blade nor edge of the cutter touches below",
            "check the settings, or take a larger edge_radius",
        ),
    };
    let (message, hint) = match limit.kind {
        "undercut" => (
            format!("the {flank}{name} is undercut up to {depth:.3} mm above the root at {at}"),
            "take a smaller dedendum, a larger blade angle or another ratio of roll",
        ),
        "cut-away" => (
            format!(
                "the {flank}{name} is completely undercut: the generating cutter removes the whole flank"
            ),
            match member.blank.pitch_angle > FRAC_PI_2 {
                true => {
                    "teeth of a pitch angle above 90° are hollow and the generating cutter cuts like a crown gear: take process = \"formate\""
                }
                false => "check the ratio of roll, the blade and the hand",
            },
        ),
        "unreached" => (
            format!("the {flank}{name} ends {depth:.3} mm above the root at {at}{fillet}"),
            remedy,
        ),
        "second" => (
            format!(
                "the same part of the blade generates two parts of the {flank}{name}, which join up to {depth:.3} mm above the root at {at}"
            ),
            "contact lines have an envelope on the cutter there, beyond which the blade does not cut: take another ratio of roll or blank offset",
        ),
        _ => (
            format!("the teeth of the {name} are pointed {depth:.3} mm below the tip at {at}"),
            match member.thickness {
                Some(_) => "take a smaller face angle or a larger mean_normal_thickness",
                None => "take a smaller face angle or a smaller point width of the cutter",
            },
        ),
    };
    Diagnostic {
        code: match limit.kind {
            "second" => "double-contact",
            "unreached" => "contact-ends",
            "cut-away" => "undercut",
            kind => kind,
        },
        message,
        hint: Some(hint.into()),
    }
}
