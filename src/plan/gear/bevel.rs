//! A bevel pair by machine settings: flanks on their blanks, limits, tooth, contact, stages.

use super::bevel_backlash::{self, LeastBacklash};
use super::bevel_blanks;
use super::bevel_contact::{BevelContact, contact};
use super::bevel_limits::{self, BevelLimit};
use super::bevel_member::{MemberResult, flanks_of_sides, member};
use super::bevel_mesh::{self, BevelMeshResult, LoadedPair, MeshStudies};
use super::bevel_quantities::quantities;
use super::bevel_stability;
use super::geometry::GearQuantity;
use super::pattern_states::PatternStates;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_number;
use crate::gear::bevel::straight::StraightProfile;
use crate::gear::bevel::tooth::SIDES;
use crate::gear::contact::pair::Assembly;
use crate::gear::hand::Hand;
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;
use crate::scene::machine_settings::Process;

/// Results of a bevel file.
#[derive(Debug, Clone)]
pub struct BevelResult {
    /// Blanks and teeth.
    pub quantities: Vec<GearQuantity>,
    /// Pinion and gear.
    pub members: [MemberResult; 2],
    /// Limits that the flanks meet.
    pub limits: Vec<BevelLimit>,
    /// Contact of the requested flanks.
    pub contact: Option<BevelContact>,
    /// Least backlash as assembled, where both teeth are known.
    pub backlash: Option<LeastBacklash>,
    /// Contacts moved by V and H over the range of the V–H check, where it is requested.
    pub states: Option<PatternStates>,
    /// The pair under load, where the file has a torque.
    pub mesh: Option<BevelMeshResult>,
    /// Studies of the loaded pair.
    pub studies: MeshStudies,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Computes what the file determines.
///
/// # Errors
/// Cutters that do not reach their blanks.
pub fn run(file: &BevelFile) -> Result<BevelResult, Error> {
    let mut limits = Vec::new();
    let mut members = Vec::with_capacity(2);
    for k in 0..2 {
        let member = member(file, k)?;
        limits.extend(bevel_limits::limits(&file.members[k], &member, k));
        members.push(member);
    }
    let members: [MemberResult; 2] = members
        .try_into()
        .map_err(|_| Error::new(Code::MissingKey, "the gears are not described"))?;
    let mut diagnostics = bevel_blanks::warnings(file);
    diagnostics.extend(limits.iter().map(|l| bevel_limits::warning(file, l)));
    diagnostics.extend(bevel_blanks::flank_warnings(file, &members));
    let contact = match file.is_conjugate() {
        true => None,
        false => flanks_of_sides(&members, file.contact.side.flanks())
            .and_then(|flanks| contact(file, flanks, &mut diagnostics)),
    };
    let backlash =
        (contact.as_ref()).and_then(|c| bevel_backlash::least(file, &members, c, &mut diagnostics));
    let design = bevel_backlash::of_design(&members);
    diagnostics.extend(bevel_backlash::warning(design, backlash.as_ref()));
    let torques = &file.mesh.torques;
    let (mesh, studies) = match &contact {
        Some(BevelContact { pair, path, .. }) if !torques.is_empty() => {
            let teeth = members.each_ref().map(|m| m.tooth.as_ref());
            let flanks = (pair, path);
            let loaded = LoadedPair::new(file, teeth, flanks)?;
            let mesh = loaded.mesh(torques, &mut diagnostics)?;
            let studies = loaded.studies(&mesh.mesh)?;
            (Some(mesh), studies)
        }
        _ => (None, MeshStudies::default()),
    };
    Ok(BevelResult {
        states: contact.as_ref().and_then(|c| PatternStates::of(file, c)),
        mesh,
        studies,
        quantities: quantities(file, &members, design),
        plan: plan(file),
        members,
        limits,
        contact,
        backlash,
        diagnostics,
    })
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &BevelFile) -> Vec<(&'static str, StageDecision)> {
    use StageDecision::{LeftOut, Runs};
    let process = |k: usize| match file.members[k].process {
        Process::Generated => "generated",
        Process::Formate => "formate",
        Process::Straight(StraightProfile::Octoid) => "octoids of a plane crown tool",
        Process::Straight(StraightProfile::SphericalInvolute) => "spherical involutes",
    };
    let sides = |k: usize| {
        let described = (0..2).filter(|side| file.members[k].describes(*side));
        let given: Vec<&str> = described.map(|side| SIDES[side]).collect();
        format!("{} {} ({})", MEMBERS[k], given.join(" and "), process(k))
    };
    let blanks = match &file.design {
        Some(design) => format!(
            "blanks by ISO 23509:2016, method {}",
            design.method.number()
        ),
        None => "blanks by their cones".into(),
    };
    let mut plan = vec![("geometry", Runs(blanks))];
    if !file.defaults.is_empty() {
        plan.push(("defaults", Runs(file.defaults.join("; "))));
    }
    let is_bare = file
        .members
        .iter()
        .all(|m| (0..2).all(|side| !m.describes(side)));
    let on_flanks = |what: String| match is_bare {
        true => LeftOut("no settings of a flank are given: the blanks alone".into()),
        false => Runs(what),
    };
    plan.push(("flanks", on_flanks(format!("{}, {}", sides(0), sides(1)))));
    plan.push((
        "limits",
        on_flanks("undercut and end of contact of the cutter on each flank".into()),
    ));
    let missing: Vec<String> = [0, 1]
        .iter()
        .filter_map(|k| {
            Some(format!(
                "{}: {}",
                MEMBERS[*k],
                file.members[*k].missing_tooth_reason()?
            ))
        })
        .collect();
    plan.push((
        "teeth",
        match missing.len() {
            0 => Runs("thickness and top lands of both gears".into()),
            1 => Runs(format!(
                "thickness and top lands; not of the {}",
                missing[0]
            )),
            _ => LeftOut(missing.join("; ")),
        },
    ));
    let study = &file.contact;
    plan.push((
        "contact",
        match file.missing_flank() {
            None if file.is_conjugate() => LeftOut(
                "straight flanks are conjugate: lines of contact, no transmission error".into(),
            ),
            None => Runs(format!(
                "unloaded, {} flanks, {} positions in a pitch over {} pitches each way, coating {} µm",
                study.side.name(),
                study.positions,
                study.pitches,
                format_number(1e6 * study.coating)
            )),
            Some([member, side]) => LeftOut(format!(
                "the {} flank of the {} is not described",
                SIDES[side], MEMBERS[member]
            )),
        },
    ));
    plan.push((
        "V–H check",
        match (study.vh, file.missing_flank()) {
            (true, None) if !file.is_conjugate() => Runs(
                "offset and pinion position that move the pattern to toe, middle and heel".into(),
            ),
            (true, _) => {
                LeftOut("no contact: a flank is not described, or the flanks are conjugate".into())
            }
            (false, _) => LeftOut("not requested: --vh".into()),
        },
    ));
    if file.is_conjugate() && file.errors != Assembly::default() {
        let reason = "errors of assembly: straight flanks are conjugate as designed, their contact when displaced is not computed";
        plan.push(("assembly", LeftOut(reason.into())));
    }
    plan.push(("mesh", bevel_mesh::plan(file)));
    plan.extend(bevel_stability::plan(file).map(|decision| ("stability", decision)));
    plan
}

/// The word of a hand.
pub fn hand_name(hand: Hand) -> &'static str {
    match hand {
        Hand::Right => "right",
        Hand::Left => "left",
    }
}
