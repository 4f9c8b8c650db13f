//! Correction of the settings of a measured bevel gear: nodes, fit, settings of the next cut, what no settings take away.

use std::sync::Arc;

use super::bevel_contact::BevelContact;
use super::measured_nodes::{measured_flank, sides};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_number;
use crate::base::source_span::SourceFile;
use crate::base::text::pluralise;
use crate::gear::bevel::tooth::SIDES;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::cut::correction::{CorrectionFit, CorrectionProblem, Unknown};
use crate::gear::cut::dial::Dial;
use crate::gear::cut::measured_flank::{Deviations, MeasuredFlank};
use crate::gear::cut::next_cut::NextCut;
use crate::gear::cut::root_point::RootPoint;
use crate::gear::cut::setting::{FlankSetup, Setting};
use crate::gear::cut::shapes::{ShapeRest, shape_rests};
use crate::gear::hand::Hand;
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;
use crate::scene::correction_study::{CorrectionStudy, setting_name};
use crate::scene::machine_settings::FlankCut;
use crate::scene::measured_grid::MeasuredGrid;

/// Settings for the next cut of a measured gear.
#[derive(Debug, Clone)]
pub struct CorrectionResult {
    /// Index of the member.
    pub member: usize,
    /// Index of each flank: 0 concave, 1 convex.
    pub sides: Vec<usize>,
    /// Flanks with their deviations, and what may be changed.
    pub problem: CorrectionProblem,
    /// Settings whose flanks have the deviations.
    pub fit: CorrectionFit,
    /// Measured deviations less a turn of the work, by flank and node, m.
    pub before: Vec<Vec<Option<f64>>>,
    /// The next cut.
    pub next: NextCut,
    /// Dials of each flank.
    pub dials: Vec<Vec<Dial>>,
    /// Both flanks are measured and cut at one setting of the machine.
    pub is_one_setting: bool,
    /// The machine that cuts the measured flank cuts the other one as well.
    pub moves_other: bool,
    /// Depth that the next cut adds to the slot at toe, middle and heel, m, by flank; none where the tip plane does not pass there.
    pub depths: Vec<Option<[f64; 3]>>,
    /// Shapes that no settings take away.
    pub shapes: Vec<ShapeRest>,
    /// Contact of the pair before and after, where an ease-off is wanted.
    pub contact: Option<ContactChange>,
    /// File and grid.
    pub sources: Vec<Arc<SourceFile>>,
    /// Stages.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Contact of a pair at two settings of its pinion; none where the flanks do not touch.
#[derive(Debug, Clone)]
pub struct ContactChange {
    /// At the settings of the file.
    pub now: Option<BevelContact>,
    /// At those of the next cut.
    pub next: Option<BevelContact>,
}

/// Reach of a setting: the unit in which changes are weighed against each other, 10′, 0.1 mm, a hundredth of the ratio of roll, and 1/m of
/// the curvature of a profile, 4.5 µm at 3 mm from its profile height.
fn reach(setting: Setting, setup: &FlankSetup) -> f64 {
    use crate::gear::cut::setting::SettingKind::{Angle, Length, Ratio};
    /// Reaches of the coefficients 2C, 6D, 24E, 120F: each turns the work alike at the ends of the roll.
    const MODIFIED_ROLL: [f64; 4] = [1e-2, 1e-1, 1.0, 10.0];
    match (setting, setting.kind()) {
        (Setting::ModifiedRoll(k), _) => MODIFIED_ROLL[k],
        (Setting::ProfileCurvature, _) => 1.0,
        (_, Length) => 1e-4,
        (_, Angle) => std::f64::consts::PI / 1080.0,
        (_, Ratio) => 1e-2 * setup.value(Setting::Ratio),
    }
}

impl CorrectionStudy {
    /// Settings that may be changed of the flanks of a member.
    ///
    /// # Errors
    /// Settings that the process or a straight blade does not have, at the member.
    pub(super) fn settings_for(
        &self,
        file: &BevelFile,
        member: usize,
        sides: &[usize],
    ) -> Result<Vec<Setting>, Error> {
        let of = &file.members[member];
        let conflict = |message: String, hint: &str| {
            Error::new(Code::Conflict, message)
                .with_span(&of.span)
                .with_hint(hint)
        };
        let settings = self.settings_of(of.process).map_err(|name| {
            let message = format!("the {} is formate and has no `{name}`", MEMBERS[member]);
            conflict(message, "leave it out of `settings`")
        })?;
        let is_straight = |side: &&usize| {
            of.flanks[**side].is_some_and(|cut| cut.cutter.profile_curvature == 0.0)
        };
        let straight = (sides.iter().find(is_straight))
            .filter(|_| settings.contains(&Setting::ProfileCurvature));
        match straight {
            None => Ok(settings),
            Some(side) => Err(conflict(
                format!(
                    "the {} flank of the {} is cut by a straight blade, which has no `profile_radius`",
                    SIDES[*side], MEMBERS[member]
                ),
                "give the blade a large `profile_radius` and its `profile_height`, or leave it out of `settings`",
            )),
        }
    }
}

/// Finds the settings of the next cut.
///
/// # Errors
/// A flank that the file does not describe, nodes beyond it, normals of another flank, settings that the process does not have.
pub fn run(
    file: &BevelFile,
    study: &CorrectionStudy,
    grid: &MeasuredGrid,
) -> Result<CorrectionResult, Error> {
    let member = study.member.index();
    let of = &file.members[member];
    let sides = sides(file, study, grid)?;
    let settings = study.settings_for(file, member, &sides)?;
    let cuts: Vec<&FlankCut> = sides
        .iter()
        .filter_map(|side| of.flanks[*side].as_ref())
        .collect();
    let mut diagnostics = Vec::new();
    let mut flanks = Vec::with_capacity(sides.len());
    for side in &sides {
        flanks.push(measured_flank(
            file,
            (member, *side),
            grid,
            &mut diagnostics,
        )?);
    }
    let is_one_setting = flanks.len() == 2 && flanks[0].setup.machine == flanks[1].setup.machine;
    let problem = CorrectionProblem {
        unknowns: unknowns(&settings, &flanks, is_one_setting),
        flanks,
        least: study.least,
    };
    let at_grid = |error: Error| error.with_span(&grid.nodes[0].span);
    let fit = problem.solve().map_err(at_grid)?;
    let unchanged = CorrectionProblem {
        unknowns: Vec::new(),
        ..problem.clone()
    };
    let before = unchanged.solve().map_err(at_grid)?.rests;
    let dials: Vec<Vec<Dial>> = cuts.iter().map(|cut| dials(&settings, cut)).collect();
    let root = |side: &usize| RootPoint::of(&file.flank(member, *side)?);
    let roots: Vec<Option<[RootPoint; 3]>> = sides.iter().map(root).collect();
    let next = problem.next_cut(&fit, &dials, &study.steps, &roots);
    let next = next.map_err(at_grid)?;
    let hint = "check member, flank and sign of the deviations, or free fewer settings";
    diagnostics.extend(not_converged(&fit, hint));
    diagnostics.extend(large_change(
        &problem,
        &fit,
        (
            "more than errors of a machine explain",
            "check member, flank and units, or free fewer settings by --settings",
        ),
    ));
    diagnostics.extend(nothing_moves(&fit, study.least));
    diagnostics.extend(no_better(&before, &next).filter(|_| fit.kept > 0));
    let moves_other = match sides[..] {
        [side] => of.flanks[1 - side].is_some_and(|other| other.settings == cuts[0].settings),
        _ => false,
    };
    if moves_other {
        diagnostics.push(Diagnostic {
            code: "other-flank",
            message: format!(
                "the {} flank is cut at the same settings and moves with them: its deviations are not in the grid",
                SIDES[1 - sides[0]]
            ),
            hint: Some("measure both flanks".into()),
        });
    }
    let hand = file.hand_of(member);
    let depth = |(roots, setup): (&Option<[RootPoint; 3]>, &FlankSetup)| {
        depths(roots.as_ref(), setup, hand)
    };
    let depths: Vec<Option<[f64; 3]>> = roots.iter().zip(&next.setups).map(depth).collect();
    diagnostics.extend(depth_warning(&depths, &of.section, &sides));
    Ok(CorrectionResult {
        shapes: shape_rests(&problem.flanks, &fit.nominal, fit.kept),
        plan: plan(study, &settings, &problem, &fit),
        sources: vec![file.source.clone(), grid.source.clone()],
        member,
        sides,
        problem,
        fit,
        before,
        next,
        dials,
        is_one_setting,
        moves_other,
        depths,
        contact: None,
        diagnostics,
    })
}

/// Settings as unknowns: the machine of flanks cut at one setting once, everything else for each flank.
pub(super) fn unknowns(
    settings: &[Setting],
    flanks: &[MeasuredFlank],
    is_one_setting: bool,
) -> Vec<Unknown> {
    let mut all = Vec::new();
    for setting in settings {
        let reach = |f: usize| reach(*setting, &flanks[f].setup);
        let groups: Vec<Vec<usize>> = match is_one_setting && !setting.is_of_cutter() {
            true => vec![vec![0, 1]],
            false => (0..flanks.len()).map(|f| vec![f]).collect(),
        };
        all.extend(groups.into_iter().map(|flanks| Unknown {
            setting: *setting,
            reach: reach(flanks[0]),
            flanks,
        }));
    }
    all
}

/// Dials that show the settings.
pub(super) fn dials(settings: &[Setting], cut: &FlankCut) -> Vec<Dial> {
    let mut all: Vec<Dial> = Vec::new();
    let constant = cut.eccentric.map(|eccentric| eccentric.machine_constant);
    for dial in settings
        .iter()
        .flat_map(|setting| Dial::of(*setting, constant))
    {
        if !all.contains(&dial) {
            all.push(dial);
        }
    }
    all
}

/// A warning of a search that did not end.
pub(super) fn not_converged(fit: &CorrectionFit, hint: &str) -> Option<Diagnostic> {
    (!fit.is_converged).then(|| Diagnostic {
        code: "not-converged",
        message: format!(
            "the settings did not settle in {}",
            pluralise(fit.steps, "step")
        ),
        hint: Some(hint.into()),
    })
}

/// A warning where no direction of settings moves the flank.
pub(super) fn nothing_moves(fit: &CorrectionFit, least: f64) -> Option<Diagnostic> {
    (fit.kept == 0).then(|| Diagnostic {
        code: "nothing-changes",
        message: format!(
            "no combination of the settings moves the flank by more than {} µm rms: nothing is changed",
            format_number(1e6 * least)
        ),
        hint: Some("free other settings by --settings".into()),
    })
}

/// A warning of a next cut that is no better than the measured one: the steps of the dials are too coarse.
fn no_better(before: &[Vec<Option<f64>>], next: &NextCut) -> Option<Diagnostic> {
    let rms = |all: &[Vec<Option<f64>>]| Deviations::of(&all.concat()).rms;
    let [now, then] = [rms(before), rms(&next.deviations)];
    (then >= now).then(|| Diagnostic {
        code: "no-better",
        message: format!(
            "the next cut would have {:.3} µm rms and the measured one has {:.3} µm: leave the settings",
            1e6 * then,
            1e6 * now
        ),
        hint: Some("take finer steps of the dials, or free other settings".into()),
    })
}

/// Depth that settings add to the slot at toe, middle and heel, m.
pub(super) fn depths(
    roots: Option<&[RootPoint; 3]>,
    setup: &FlankSetup,
    hand: Hand,
) -> Option<[f64; 3]> {
    let [toe, middle, heel] = roots?.each_ref().map(|root| root.deeper_by(setup, hand));
    Some([toe?, middle?, heel?])
}

/// Change of the slot's depth that is named, as a share of the depth of the tooth.
const DEPTH_CHANGE: f64 = 0.01;

/// A warning of slots that become deeper or shallower.
pub(super) fn depth_warning(
    depths: &[Option<[f64; 3]>],
    section: &ToothSection,
    sides: &[usize],
) -> Option<Diagnostic> {
    let places = ["toe", "middle", "heel"];
    let all = depths.iter().zip(sides).flat_map(|(depths, side)| {
        let of = |(depth, place)| (depth, place, SIDES[*side]);
        depths
            .iter()
            .flatten()
            .copied()
            .zip(places)
            .map(of)
            .collect::<Vec<_>>()
    });
    let (depth, place, side) = all
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        .filter(|(depth, ..)| depth.abs() > DEPTH_CHANGE * section.depth())?;
    Some(Diagnostic {
        code: "slot-depth",
        message: format!(
            "the slot becomes {:.3} mm {} at the {place}, by the blade of the {side} flank",
            1e3 * depth.abs(),
            if depth > 0.0 { "deeper" } else { "shallower" }
        ),
        hint: Some("check clearance and root; hold machine_root_angle and sliding_base out of --settings, or give the blanks another depth".into()),
    })
}

/// Changes beyond this many reaches are not small errors of a machine.
const FAR: f64 = 10.0;

/// A warning of large changes, with what they are and a hint.
pub(super) fn large_change(
    problem: &CorrectionProblem,
    fit: &CorrectionFit,
    (what, hint): (&str, &str),
) -> Option<Diagnostic> {
    let in_reach = problem.unknowns.iter().zip(&fit.changes);
    let worst = in_reach
        .map(|(unknown, change)| (unknown.setting, (change / unknown.reach).abs()))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, size)| *size > FAR)?;
    Some(Diagnostic {
        code: "large-change",
        message: format!(
            "`{}` would change by {:.0} times 10′, 0.1 mm, 1 % of the ratio of roll or 1/m of the curvature of a profile: {what}",
            setting_name(worst.0),
            worst.1
        ),
        hint: Some(hint.into()),
    })
}

/// The stages of a correction.
pub(super) fn plan(
    study: &CorrectionStudy,
    settings: &[Setting],
    problem: &CorrectionProblem,
    fit: &CorrectionFit,
) -> Vec<(&'static str, StageDecision)> {
    use StageDecision::{LeftOut, Runs};
    let mut names: Vec<&str> = settings.iter().map(|s| setting_name(*s)).collect();
    names.dedup();
    let nodes: usize = problem.flanks.iter().map(|flank| flank.nodes.len()).sum();
    let chosen = if study.settings.is_empty() {
        "by default"
    } else {
        "as requested"
    };
    vec![
        (
            "nodes",
            Runs(format!(
                "{nodes} on {}",
                pluralise(problem.flanks.len(), "flank")
            )),
        ),
        ("settings", Runs(format!("{} ({chosen})", names.join(", ")))),
        (
            "fit",
            Runs(format!(
                "{} of {} above {} µm rms, {}",
                pluralise(fit.kept, "direction"),
                problem.unknowns.len(),
                format_number(1e6 * study.least),
                pluralise(fit.steps, "step")
            )),
        ),
        (
            "tooth thickness",
            LeftOut("each flank is turned by itself to its least deviation".into()),
        ),
    ]
}
