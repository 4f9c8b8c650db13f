//! The unloaded contact of a pair whose flanks carry the errors of the generator's chain: exact on the changed envelopes.

use super::bevel_contact::{self, BevelContact};
use super::cut_causes::{chain_errors, cradle_order};
use super::cut_flank::CutFlankResult;
use super::cut_mesh::{CutMesh, meshes};
use crate::base::error::{Diagnostic, Error};
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::cut::blade_passes::angle_lever;
use crate::plan::decision::StageDecision;
use crate::scene::cut_file::CutFile;
use crate::scene::cut_study::CutTarget;
use crate::scene::machine_settings::Process;

/// Share of D that the curvature of an error may take: with all of it the changed flank has an edge.
const SMOOTH: f64 = 0.5;

/// The contact of a pair as it is cut.
#[derive(Debug, Clone)]
pub struct CutContact {
    /// Contact of the ideal flanks.
    pub ideal: ContactSummary,
    /// With the errors of the chain; or why it is left out.
    pub changed: Result<ContactSummary, String>,
    /// The mesh of the ideal flanks and of those of each cause, scallops by their mean.
    pub meshes: Vec<CutMesh>,
    /// Bound of what the crests of the scallops add to the transmission error, rad: the highest scallop of each member over the lever of
    /// the force on the gear.
    pub scallop_bound: f64,
}

/// A contact in short.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSummary {
    /// Peak-to-peak of the transmission error over a pitch, rad.
    pub peak_to_peak: Option<f64>,
    /// Shares of the gear's face and height at the reference contact.
    pub reference: Option<[f64; 2]>,
    /// Contact ratio on the flanks.
    pub contact_ratio: f64,
}

impl ContactSummary {
    fn of(contact: &BevelContact) -> ContactSummary {
        ContactSummary {
            peak_to_peak: contact.peak_to_peak,
            reference: contact.reference_shares[1],
            contact_ratio: contact.contact_ratio,
        }
    }
}

impl CutContact {
    /// The stage of the plan.
    pub fn decision(&self) -> StageDecision {
        match &self.changed {
            Ok(_) => StageDecision::Runs(
                "unloaded, exact on the envelopes that the errors of the chain change".into(),
            ),
            Err(why) => StageDecision::Runs(format!(
                "unloaded, of the ideal flanks; not with errors: {why}"
            )),
        }
    }
}

/// The contact of the flanks that touch; none where one is not described or they do not touch.
///
/// # Errors
/// As [`meshes`].
pub fn contact(
    file: &CutFile,
    flanks: &[CutFlankResult],
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Option<CutContact>, Error> {
    let bevel = &file.bevel;
    let sides = bevel.contact.side.flanks();
    let [Some(pinion), Some(gear)] = [0, 1].map(|k| bevel.flank(k, sides[k])) else {
        return Ok(None);
    };
    let touching = flanks.iter().filter(|f| f.side == sides[f.member]);
    let found = bevel_contact::contact(bevel, [pinion.clone(), gear.clone()], diagnostics);
    let Some(ideal) = found else {
        return Ok(None);
    };
    let scallops = touching.clone().filter_map(|f| f.scallops.statistics);
    let scallop_bound = scallops.map(|s| s.highest).sum::<f64>() / ideal.forces.levers[1];
    let is_chain = |t: CutTarget| t != CutTarget::Cutter;
    let changed = if !file.study.errors.iter().any(|e| is_chain(e.target)) {
        Err("no error of cradle or work is given".into())
    } else if !touching.clone().all(|f| is_smooth(file, f)) {
        Err("an error is so wavy that the changed flank has edges".into())
    } else {
        let mut ends = [pinion, gear];
        for f in touching {
            change(file, f, &mut ends[f.member]);
        }
        let mut own = Vec::new();
        let found = bevel_contact::contact(bevel, ends, &mut own);
        found
            .map(|c| ContactSummary::of(&c))
            .ok_or_else(|| "the changed flanks do not touch near the middle of their teeth".into())
    };
    Ok(Some(CutContact {
        ideal: ContactSummary::of(&ideal),
        changed,
        meshes: meshes(bevel, &ideal, flanks, diagnostics)?,
        scallop_bound,
    }))
}

/// Puts the errors of the chain into the motion that makes a flank.
fn change(file: &CutFile, of: &CutFlankResult, flank: &mut BevelFlank) {
    let Some(cut) = &file.bevel.members[of.member].flanks[of.side] else {
        return;
    };
    let errors = chain_errors(file, &cut.settings, of.feed);
    let hand = file.bevel.hand_of(of.member);
    let motion = cut.settings.motion_with_errors(hand, errors.laws());
    *flank = flank.in_motion(motion);
}

/// Whether the second derivative of the errors stays below D: a wave ε of the work adds `n·(k×r) ε″` to D, one of the cradle as much times
/// the ratio of roll, because the normal velocities of both cancel on the flank.
fn is_smooth(file: &CutFile, of: &CutFlankResult) -> bool {
    let member = &file.bevel.members[of.member];
    let roll = member.flanks[of.side]
        .as_ref()
        .and_then(|cut| cut.settings.roll);
    let Some(roll) = roll.filter(|_| member.process == Process::Generated) else {
        return true;
    };
    let ratio = roll.work_over_cradle;
    let wave: f64 = (file.study.errors.iter())
        .map(|e| {
            let order = cradle_order(e, ratio, of.feed);
            let of_work = e.amplitude * order * order;
            match e.target {
                CutTarget::Work => of_work,
                CutTarget::Cradle => of_work * ratio.abs(),
                CutTarget::Cutter => 0.0,
            }
        })
        .sum();
    let nodes = of.grid.nodes.iter().flatten().filter(|n| !n.in_fillet);
    nodes
        .into_iter()
        .all(|n| wave * angle_lever(&n.point).abs() <= SMOOTH * n.point.second_order.undercut.abs())
}
