//! A bevel pair as discrete blades cut it: its flanks, its contact, stages.

use super::cut_chips::{self, ChipResult};
use super::cut_contact::{CutContact, contact};
use super::cut_flank::{CauseResult, CutFlankResult, flank, flank_node};
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_number;
use crate::base::text::pluralise;
use crate::gear::bevel::tooth::SIDES;
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::cut_file::CutFile;

/// Results of a cut.
#[derive(Debug, Clone)]
pub struct CutResult {
    /// Flanks that are cut.
    pub flanks: Vec<CutFlankResult>,
    /// Contact of the flanks that touch, ideal and with the errors of the chain.
    pub contact: Option<CutContact>,
    /// Chips of the members that are cut from the solid, or why there are none.
    pub chips: Vec<Result<ChipResult, String>>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Cuts the flanks of a file.
///
/// # Errors
/// Cutters that do not reach their blanks; a history that ends before the roll.
pub fn run(file: &CutFile) -> Result<CutResult, Error> {
    let mut flanks = Vec::new();
    let mut diagnostics = Vec::new();
    for member in 0..2 {
        for side in 0..2 {
            let is_cut = file.study.member.is_none_or(|only| only == member);
            if let (true, Some(cut)) = (is_cut, &file.bevel.members[member].flanks[side]) {
                flanks.push(flank(file, [member, side], cut)?);
            }
        }
    }
    for flank in &flanks {
        diagnostics.extend(left_out(flank));
    }
    let contact = contact(file, &flanks, &mut diagnostics)?;
    let is_cut = |member: &usize| file.study.member.is_none_or(|only| only == *member);
    let members = [0, 1].into_iter().filter(is_cut);
    let chips: Vec<_> = members
        .map(|member| cut_chips::chips(file, member))
        .collect();
    Ok(CutResult {
        plan: plan(file, &flanks, contact.as_ref(), &chips),
        chips,
        flanks,
        contact,
        diagnostics,
    })
}

/// The warning that nodes of a flank are not cut.
fn left_out(flank: &CutFlankResult) -> Option<Diagnostic> {
    let missing = |cause: &CauseResult| {
        let nodes = flank.grid.nodes.iter().zip(&cause.cuts);
        nodes
            .filter(|(n, cut)| flank_node(n).is_some() && cut.is_none())
            .count()
    };
    let most = flank.causes.iter().map(missing).max().unwrap_or(0);
    (most > 0).then(|| Diagnostic {
        code: "undercut",
        message: format!(
            "{most} of {} nodes of the {} flank of the {} are left out: more passes than can be compared reach them, or none",
            flank.grid.nodes.len(),
            SIDES[flank.side],
            MEMBERS[flank.member]
        ),
        hint: Some("the undercut function D is near zero there; see the limits of `geardyn gear`".into()),
    })
}

/// The stage of the mesh of each cause.
fn mesh_decision(file: &CutFile, contact: Option<&CutContact>) -> StageDecision {
    let Some(contact) = contact else {
        return StageDecision::LeftOut("flanks that do not touch have no mesh".into());
    };
    let Some(ideal) = contact.meshes.first() else {
        return StageDecision::LeftOut("the flanks do not touch at every angle".into());
    };
    let load = match ideal.loaded {
        Some(loaded) => format!("at {} N·m of the pinion", format_number(loaded.torque)),
        None => "without load: no torque is given in [mesh]".into(),
    };
    StageDecision::Runs(format!(
        "{} × {} positions × {} stations, {load}; deviations to first order over the arms, scallops by their mean",
        pluralise(contact.meshes.len(), "cut"),
        file.bevel.mesh.positions,
        file.bevel.mesh.stations
    ))
}

fn plan(
    file: &CutFile,
    flanks: &[CutFlankResult],
    contact: Option<&CutContact>,
    chips: &[Result<ChipResult, String>],
) -> Vec<(&'static str, StageDecision)> {
    use StageDecision::{LeftOut, Runs};
    let study = &file.study;
    let step = study.feed(true).step().to_degrees();
    let rolls = study.cradle_speed.is_some();
    let nodes = flanks.iter().filter_map(|f| f.nodes_per_scallop);
    let coarse = match nodes.reduce(f64::min) {
        Some(nodes) => format!("; at least {nodes:.1} nodes per scallop"),
        None => String::new(),
    };
    let maps = format!(
        "{} blades on rays along the normals of {} × {} nodes; each node has the least distance over the passes near it{coarse}",
        study.blades, study.grid[0], study.grid[1]
    );
    let given = |is_given: bool, what: String, why: &str| match is_given {
        true => Runs(what),
        false => LeftOut(why.into()),
    };
    let (errors, offsets) = (study.errors.len(), study.offsets.len());
    vec![
        (
            "scallops",
            given(
                rolls,
                format!("law |D| Δx²/8 and highest over all phases, Δx = {step:.4}° of the cradle"),
                "formate flanks have no scallops of the roll",
            ),
        ),
        ("flanks", Runs(maps)),
        (
            "run-out",
            given(offsets > 0, format!("{offsets} blades"), "no run-out is given"),
        ),
        (
            "chain errors",
            given(errors > 0 && rolls, format!("{errors} harmonics"), match rolls {
                true => "no [[cut.error]] is given",
                false => "formate flanks do not roll",
            }),
        ),
        (
            "spindle history",
            given(
                file.history.is_some() && rolls,
                "its straight line, the nominal turn, is subtracted; its middle lies at the middle of the roll".into(),
                match rolls {
                    true => "no spindle_history is given",
                    false => "formate flanks do not roll",
                },
            ),
        ),
        (
            "contact",
            match contact {
                Some(contact) => contact.decision(),
                None => LeftOut("the flanks that touch are not both described, or do not touch".into()),
            },
        ),
        ("mesh", mesh_decision(file, contact)),
        ("chips", cut_chips::decision(chips)),
        (
            "regeneration",
            LeftOut("vibration of the cut is not fed back to the chips of later blades".into()),
        ),
    ]
}
