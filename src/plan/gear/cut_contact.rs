//! Unloaded contact of a pair with the errors of the generating chain, exact on the changed envelopes.

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

/// Maximum change of the undercut function D by the second derivative of the errors, relative to D; at 1 the changed flank has an edge.
const MAX_SHARE: f64 = 0.5;

/// Contact of a pair as cut, compared with the ideal flanks.
#[derive(Debug, Clone)]
pub struct CutContact {
    /// Contact of the ideal flanks.
    pub ideal: ContactSummary,
    /// Contact with the errors of the chain, or the reason why it is not computed.
    pub changed: Result<ContactSummary, String>,
    /// Meshes of the ideal flanks and of the flanks of each cause, with the mean of the scallops.
    pub meshes: Vec<CutMesh>,
    /// Bound of the transmission error due to the scallop crests, rad: sum of the highest scallops of both members over the lever arm of
    /// the force on the gear.
    pub scallop_bound: f64,
}

/// Summary of an unloaded contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSummary {
    /// Peak-to-peak transmission error over a pitch, rad; absent if no pair touches at some angle.
    pub peak_to_peak: Option<f64>,
    /// Reference contact as fractions of face and height of the gear.
    pub reference: Option<[f64; 2]>,
    /// Contact ratio on the flanks.
    pub contact_ratio: f64,
}

impl ContactSummary {
    fn of(contact: &BevelContact) -> ContactSummary {
        ContactSummary {
            peak_to_peak: contact.peak_to_peak,
            reference: contact.reference_position[1],
            contact_ratio: contact.contact_ratio,
        }
    }
}

impl CutContact {
    /// Stage of the plan.
    pub fn decision(&self) -> StageDecision {
        match &self.changed {
            Ok(_) => StageDecision::Runs(
                "unloaded, exact on the envelopes changed by the errors of the chain".into(),
            ),
            Err(reason) => StageDecision::Runs(format!(
                "unloaded, of the ideal flanks; not with errors: {reason}"
            )),
        }
    }
}

/// Contact of the flanks in mesh; `None` if one is not described or they do not touch.
///
/// # Errors
/// Those of [`meshes`].
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
    let in_mesh = flanks.iter().filter(|f| f.side == sides[f.member]);
    let contact = bevel_contact::contact(bevel, [pinion.clone(), gear.clone()], diagnostics);
    let Some(ideal) = contact else {
        return Ok(None);
    };
    let scallops = in_mesh.clone().filter_map(|f| f.scallops.statistics);
    let scallop_bound = scallops.map(|s| s.highest).sum::<f64>() / ideal.forces.levers[1];
    let is_chain = |t: CutTarget| t != CutTarget::Cutter;
    let changed = if !file.study.errors.iter().any(|e| is_chain(e.target)) {
        Err("no error of cradle or work is given".into())
    } else if !in_mesh.clone().all(|f| is_smooth(file, f)) {
        Err("an error is of so high an order that the changed flank has edges".into())
    } else {
        let mut ends = [pinion, gear];
        for f in in_mesh {
            change(file, f, &mut ends[f.member]);
        }
        let mut ignored = Vec::new();
        let contact = bevel_contact::contact(bevel, ends, &mut ignored);
        contact
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

/// Adds the errors of the chain to the generating motion of a flank.
fn change(file: &CutFile, result: &CutFlankResult, flank: &mut BevelFlank) {
    let Some(cut) = &file.bevel.members[result.member].flanks[result.side] else {
        return;
    };
    let errors = chain_errors(file, &cut.settings, result.feed);
    let hand = file.bevel.hand_of(result.member);
    let motion = cut.settings.motion_with_errors(hand, errors.laws());
    *flank = flank.in_motion(motion);
}

/// True if the second derivative of the errors is small against D: an error ε of the work adds `n·(k×r) ε″` to D, an error of the cradle
/// the same times the ratio of roll, because the normal velocities of both cancel on the flank.
fn is_smooth(file: &CutFile, result: &CutFlankResult) -> bool {
    let member = &file.bevel.members[result.member];
    let roll = member.flanks[result.side]
        .as_ref()
        .and_then(|cut| cut.settings.roll);
    let Some(roll) = roll.filter(|_| member.process == Process::Generated) else {
        return true;
    };
    let ratio = roll.work_over_cradle;
    let curvature: f64 = (file.study.errors.iter())
        .map(|e| {
            let order = cradle_order(e, ratio, result.feed);
            let work_term = e.amplitude * order * order;
            match e.target {
                CutTarget::Work => work_term,
                CutTarget::Cradle => work_term * ratio.abs(),
                CutTarget::Cutter => 0.0,
            }
        })
        .sum();
    let nodes = result.grid.nodes.iter().flatten().filter(|n| !n.in_fillet);
    nodes.into_iter().all(|n| {
        curvature * angle_lever(&n.point).abs() <= MAX_SHARE * n.point.second_order.undercut.abs()
    })
}
