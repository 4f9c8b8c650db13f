//! Correction of the machine settings of a measured bevel gear: nodes, fit, settings of the next cut, residual shapes.

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
use crate::gear::cut::shapes::{ResidualShape, residual_shapes};
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
    /// Flanks with their deviations, and the settings that may change.
    pub problem: CorrectionProblem,
    /// Settings whose flanks reproduce the measured deviations.
    pub fit: CorrectionFit,
    /// Measured deviations without the best-fit rotation of the workpiece, by flank and node, m.
    pub before: Vec<Vec<Option<f64>>>,
    /// Settings and expected deviations of the next cut.
    pub next: NextCut,
    /// Machine dials of each flank.
    pub dials: Vec<Vec<Dial>>,
    /// True if both flanks are measured and cut at one machine setting.
    pub is_one_setting: bool,
    /// True if the machine setting of the only measured flank also cuts the other flank.
    pub cuts_other_flank: bool,
    /// Depth that the next cut adds to the slot at toe, middle and heel, m, by flank; `None` if the blade tip plane misses a point.
    pub depths: Vec<Option<[f64; 3]>>,
    /// Deviation shapes that no setting removes.
    pub shapes: Vec<ResidualShape>,
    /// Contact of the pair before and after the correction, if an ease-off is requested.
    pub contact: Option<ContactChange>,
    /// Sources of the gear file and of the grid.
    pub sources: Vec<Arc<SourceFile>>,
    /// Stages with their decisions.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Contact of a pair at two settings of its pinion; `None` if the flanks do not touch.
#[derive(Debug, Clone)]
pub struct ContactChange {
    /// Contact at the settings of the file.
    pub now: Option<BevelContact>,
    /// Contact at the settings of the next cut.
    pub next: Option<BevelContact>,
}

/// Reach of a setting, the unit that makes changes comparable: 10′, 0.1 mm, 1 % of the ratio of roll, and a profile curvature of 1/m, which
/// is 4.5 µm at 3 mm from the profile height.
fn reach(setting: Setting, setup: &FlankSetup) -> f64 {
    use crate::gear::cut::setting::SettingKind::{Angle, Length, Ratio};
    /// Reaches of the coefficients 2C, 6D, 24E, 120F; all rotate the workpiece equally at the ends of the roll.
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
    /// Settings of the flanks of a member that may change.
    ///
    /// # Errors
    /// A setting that the process or a straight blade does not have.
    pub(super) fn settings_for(
        &self,
        file: &BevelFile,
        member: usize,
        sides: &[usize],
    ) -> Result<Vec<Setting>, Error> {
        let gear = &file.members[member];
        let conflict = |message: String, hint: &str| {
            Error::new(Code::Conflict, message)
                .with_span(&gear.span)
                .with_hint(hint)
        };
        let settings = self.settings_of(gear.process).map_err(|name| {
            let message = format!("the {} is formate and has no `{name}`", MEMBERS[member]);
            conflict(message, "omit it in `settings`")
        })?;
        let is_straight = |side: &&usize| {
            gear.flanks[**side].is_some_and(|cut| cut.cutter.profile_curvature == 0.0)
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
                "give the blade a large `profile_radius` and its `profile_height`, or omit it in `settings`",
            )),
        }
    }
}

/// Computes the settings of the next cut.
///
/// # Errors
/// A flank that the file does not describe, nodes outside it, normals of another flank, settings that the process does not have.
pub fn run(
    file: &BevelFile,
    study: &CorrectionStudy,
    grid: &MeasuredGrid,
) -> Result<CorrectionResult, Error> {
    let member = study.member.index();
    let gear = &file.members[member];
    let sides = sides(file, study, grid)?;
    let settings = study.settings_for(file, member, &sides)?;
    let cuts: Vec<&FlankCut> = sides
        .iter()
        .filter_map(|side| gear.flanks[*side].as_ref())
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
    let with_grid_span = |error: Error| error.with_span(&grid.nodes[0].span);
    let fit = problem.solve().map_err(with_grid_span)?;
    let uncorrected = CorrectionProblem {
        unknowns: Vec::new(),
        ..problem.clone()
    };
    let before = uncorrected.solve().map_err(with_grid_span)?.residuals;
    let dials: Vec<Vec<Dial>> = cuts.iter().map(|cut| dials(&settings, cut)).collect();
    let root = |side: &usize| RootPoint::of(&file.flank(member, *side)?);
    let roots: Vec<Option<[RootPoint; 3]>> = sides.iter().map(root).collect();
    let next = problem.next_cut(&fit, &dials, &study.steps, &roots);
    let next = next.map_err(with_grid_span)?;
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
    diagnostics.extend(no_effective_setting(&fit, study.least));
    diagnostics.extend(no_improvement(&before, &next).filter(|_| fit.kept > 0));
    let cuts_other_flank = match sides[..] {
        [side] => gear.flanks[1 - side].is_some_and(|other| other.settings == cuts[0].settings),
        _ => false,
    };
    if cuts_other_flank {
        diagnostics.push(Diagnostic {
            code: "other-flank",
            message: format!(
                "the {} flank is cut at the same settings and changes with them: its deviations are not in the grid",
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
    diagnostics.extend(depth_warning(&depths, &gear.section, &sides));
    Ok(CorrectionResult {
        shapes: residual_shapes(&problem.flanks, &fit.nominal, fit.kept),
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
        cuts_other_flank,
        depths,
        contact: None,
        diagnostics,
    })
}

/// Unknowns of the fit: machine settings once for flanks cut at one setting, all other settings for each flank.
pub(super) fn unknowns(
    settings: &[Setting],
    flanks: &[MeasuredFlank],
    is_one_setting: bool,
) -> Vec<Unknown> {
    let mut unknowns = Vec::new();
    for setting in settings {
        let reach = |f: usize| reach(*setting, &flanks[f].setup);
        let groups: Vec<Vec<usize>> = match is_one_setting && !setting.is_of_cutter() {
            true => vec![vec![0, 1]],
            false => (0..flanks.len()).map(|f| vec![f]).collect(),
        };
        unknowns.extend(groups.into_iter().map(|flanks| Unknown {
            setting: *setting,
            reach: reach(flanks[0]),
            flanks,
        }));
    }
    unknowns
}

/// Dials of the machine that display the settings.
pub(super) fn dials(settings: &[Setting], cut: &FlankCut) -> Vec<Dial> {
    let mut shown: Vec<Dial> = Vec::new();
    let constant = cut.eccentric.map(|eccentric| eccentric.machine_constant);
    for dial in settings
        .iter()
        .flat_map(|setting| Dial::of(*setting, constant))
    {
        if !shown.contains(&dial) {
            shown.push(dial);
        }
    }
    shown
}

/// Warning of a fit that did not converge.
pub(super) fn not_converged(fit: &CorrectionFit, hint: &str) -> Option<Diagnostic> {
    (!fit.is_converged).then(|| Diagnostic {
        code: "not-converged",
        message: format!(
            "the settings did not converge in {}",
            pluralise(fit.steps, "step")
        ),
        hint: Some(hint.into()),
    })
}

/// Warning that no combination of settings moves the flank by `least`, m rms.
pub(super) fn no_effective_setting(fit: &CorrectionFit, least: f64) -> Option<Diagnostic> {
    (fit.kept == 0).then(|| Diagnostic {
        code: "nothing-changes",
        message: format!(
            "no combination of the settings moves the flank by more than {} µm rms: nothing is changed",
            format_number(1e6 * least)
        ),
        hint: Some("free other settings by --settings".into()),
    })
}

/// Warning that the next cut has no smaller deviations than the measured one, since the dial steps are too coarse.
fn no_improvement(before: &[Vec<Option<f64>>], next: &NextCut) -> Option<Diagnostic> {
    let rms = |deviations: &[Vec<Option<f64>>]| Deviations::of(&deviations.concat()).rms;
    let [measured, predicted] = [rms(before), rms(&next.deviations)];
    (predicted >= measured).then(|| Diagnostic {
        code: "no-better",
        message: format!(
            "the next cut would have {:.3} µm rms and the measured one has {:.3} µm: keep the settings",
            1e6 * predicted,
            1e6 * measured
        ),
        hint: Some("use finer steps of the dials, or free other settings".into()),
    })
}

/// Depth that settings add to the slot at toe, middle and heel, m; `None` without root points.
pub(super) fn depths(
    roots: Option<&[RootPoint; 3]>,
    setup: &FlankSetup,
    hand: Hand,
) -> Option<[f64; 3]> {
    let [toe, middle, heel] = roots?.each_ref().map(|root| root.depth_change(setup, hand));
    Some([toe?, middle?, heel?])
}

/// Change of slot depth, relative to the tooth depth, above which a warning is issued.
const DEPTH_CHANGE: f64 = 0.01;

/// Warning of slots that become deeper or shallower, with the largest change.
pub(super) fn depth_warning(
    depths: &[Option<[f64; 3]>],
    section: &ToothSection,
    sides: &[usize],
) -> Option<Diagnostic> {
    let places = ["toe", "middle", "heel"];
    let changes = depths.iter().zip(sides).flat_map(|(depths, side)| {
        let with_side = |(depth, place)| (depth, place, SIDES[*side]);
        depths
            .iter()
            .flatten()
            .copied()
            .zip(places)
            .map(with_side)
            .collect::<Vec<_>>()
    });
    let (depth, place, side) = changes
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        .filter(|(depth, ..)| depth.abs() > DEPTH_CHANGE * section.depth())?;
    Some(Diagnostic {
        code: "slot-depth",
        message: format!(
            "the slot becomes {:.3} mm {} at the {place}, by the blade of the {side} flank",
            1e3 * depth.abs(),
            if depth > 0.0 { "deeper" } else { "shallower" }
        ),
        hint: Some("check clearance and root; omit machine_root_angle and sliding_base from --settings, or give the blanks another depth".into()),
    })
}

/// Change in reaches above which it exceeds the errors of a machine.
const LARGE_CHANGE: f64 = 10.0;

/// Warning of the largest change above [`LARGE_CHANGE`], with its meaning and a hint.
pub(super) fn large_change(
    problem: &CorrectionProblem,
    fit: &CorrectionFit,
    (meaning, hint): (&str, &str),
) -> Option<Diagnostic> {
    let changes = problem.unknowns.iter().zip(&fit.changes);
    let worst = changes
        .map(|(unknown, change)| (unknown.setting, (change / unknown.reach).abs()))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, size)| *size > LARGE_CHANGE)?;
    Some(Diagnostic {
        code: "large-change",
        message: format!(
            "`{}` would change by {:.0} times 10′, 0.1 mm, 1 % of the ratio of roll or 1/m of the curvature of a profile: {meaning}",
            setting_name(worst.0),
            worst.1
        ),
        hint: Some(hint.into()),
    })
}

/// Stages of a correction with their decisions.
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
            LeftOut("each flank is rotated separately to its least deviation".into()),
        ),
    ]
}
