//! Limits that bevel flanks meet: undercut, end of contact of the cutter, pointed teeth.

use super::bevel_member::{FlankResult, MemberResult};
use crate::base::error::Diagnostic;
use crate::gear::bevel::flank::ToothPoint;
use crate::gear::bevel::tooth::{SIDES, TopLand};
use crate::gear::kernel::limits::Limit;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::{BevelFile, BevelMember};

/// A limit that a flank meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BevelLimit {
    /// `undercut`, `second`, `unreached` or `pointed`.
    pub kind: &'static str,
    /// 0 for the pinion, 1 for the gear.
    pub member: usize,
    /// Index of the flank in [`SIDES`]; none for the tooth.
    pub side: Option<usize>,
    /// Shares of face and height of the place nearest the tip (of pointed teeth nearest the root).
    pub at: [f64; 2],
    /// Depth of the teeth beyond the limit there, m.
    pub depth: f64,
}

/// Limits of both flanks and of the tooth of a member.
pub(super) fn limits(of: &BevelMember, result: &MemberResult, member: usize) -> Vec<BevelLimit> {
    let flanks = result.flanks.iter().enumerate();
    let mut all: Vec<BevelLimit> = flanks
        .filter_map(|(side, flank)| Some((side, flank.as_ref()?)))
        .flat_map(|(side, flank)| flank_limits(of, flank, member, side))
        .collect();
    all.extend(result.top_land.and_then(|land| pointed(of, land, member)));
    all
}

/// Limits of both kinds on a flank.
fn flank_limits(on: &BevelMember, of: &FlankResult, member: usize, side: usize) -> Vec<BevelLimit> {
    let Some(domain) = of.grid.domain() else {
        return Vec::new();
    };
    if of.flank.envelope.motion.is_fixed() {
        return Vec::new();
    }
    let section = &of.flank.section;
    let highest = |limit: Limit| {
        let curves = of.flank.limits(limit, domain);
        let cut = curves.iter().flatten().filter(|p| {
            let root_angle = on.blank.root_angle;
            on.straight
                .is_none_or(|s| s.is_cut_above_root(p, root_angle))
        });
        let places = cut.filter_map(|p| {
            let r = p.point.coordinates;
            section.shares([r.z, f64::hypot(r.x, r.y)])
        });
        places.max_by(|a, b| a[1].total_cmp(&b[1]))
    };
    // Curves are traced only where the nodes show that one crosses the flank.
    let nodes: Vec<&ToothPoint> = of.grid.nodes.iter().flatten().collect();
    let is_whole = nodes.len() == of.grid.nodes.len();
    let on_flank = nodes.iter().filter(|n| !n.in_fillet);
    let signs = on_flank.map(|n| n.point.second_order.second_limit < 0.0);
    let first_sign = signs.clone().next();
    let is_crossed = [
        !is_whole,
        !is_whole || signs.clone().any(|s| Some(s) != first_sign),
    ];
    let kinds = [("undercut", Limit::Undercut), ("second", Limit::Second)];
    let mut found: Vec<BevelLimit> = (kinds.into_iter().zip(is_crossed))
        .filter(|(_, crossed)| *crossed)
        .filter_map(|((kind, limit), _)| {
            let at = highest(limit)?;
            let [root, here] = [section.at(at[0], 0.0), section.at(at[0], at[1])];
            Some(BevelLimit {
                kind,
                member,
                side: Some(side),
                at,
                depth: f64::hypot(here[0] - root[0], here[1] - root[1]),
            })
        })
        .collect();
    if found.is_empty()
        && let Some(at) = of.grid.highest_missing()
    {
        let [root, here] = [section.at(at[0], 0.0), section.at(at[0], at[1])];
        found.push(BevelLimit {
            kind: "unreached",
            member,
            side: Some(side),
            at,
            depth: f64::hypot(here[0] - root[0], here[1] - root[1]),
        });
    }
    found
}

/// Teeth whose flanks cross below the tip.
fn pointed(of: &BevelMember, land: TopLand, member: usize) -> Option<BevelLimit> {
    let height = land.pointed_at?;
    let [tip, here] = [
        of.section.at(land.face, 1.0),
        of.section.at(land.face, height),
    ];
    Some(BevelLimit {
        kind: "pointed",
        member,
        side: None,
        at: [land.face, height],
        depth: f64::hypot(here[0] - tip[0], here[1] - tip[1]),
    })
}

/// A limit as a warning.
pub(super) fn warning(file: &BevelFile, limit: &BevelLimit) -> Diagnostic {
    let name = MEMBERS[limit.member];
    let flank = limit.side.map_or(String::new(), |side| {
        format!("{} flank of the ", SIDES[side])
    });
    let at = format!("{:.0} % of the face from the toe", 100.0 * limit.at[0]);
    let depth = 1e3 * limit.depth;
    let (message, hint) = match limit.kind {
        "undercut" => (
            format!("the {flank}{name} is undercut up to {depth:.3} mm above the root at {at}"),
            "take a smaller dedendum, a larger blade angle or another ratio of roll",
        ),
        "unreached" => (
            format!(
                "the cutter does not reach the {flank}{name} {depth:.3} mm above the root at {at}"
            ),
            "check the settings: rough ones suit pitch angles above 9°",
        ),
        "second" => (
            format!(
                "the cutter ends to touch the {flank}{name} {depth:.3} mm above the root at {at}"
            ),
            "contact lines have an envelope on the cutter there: take another cradle angle or ratio of roll",
        ),
        _ => (
            format!("the teeth of the {name} are pointed {depth:.3} mm below the tip at {at}"),
            match file.members[limit.member].thickness {
                Some(_) => "take a smaller face angle or a larger mean_normal_thickness",
                None => "take a smaller face angle or a smaller point width of the cutter",
            },
        ),
    };
    Diagnostic {
        code: match limit.kind {
            "second" | "unreached" => "contact-ends",
            kind => kind,
        },
        message,
        hint: Some(hint.into()),
    }
}
