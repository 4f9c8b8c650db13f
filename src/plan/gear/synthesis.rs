//! Synthesis of a pinion: settings whose flank has a wanted ease-off from the pinion conjugate to the gear.

use super::bevel_contact;
use super::correction::{
    ContactChange, CorrectionResult, depth_warning, depths, dials, large_change,
    no_effective_setting, not_converged, plan, unknowns,
};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::bevel::tooth::SIDES;
use crate::gear::contact::pair::FlankPair;
use crate::gear::cut::correction::CorrectionProblem;
use crate::gear::cut::measured_flank::MeasuredFlank;
use crate::gear::cut::next_cut::NextCut;
use crate::gear::cut::root_point::RootPoint;
use crate::gear::cut::setting::FlankSetup;
use crate::gear::cut::shapes::residual_shapes;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;
use crate::scene::correction_study::{CorrectionStudy, Member};
use crate::scene::ease_off_target::EaseOffTargetFile;

/// Finds the settings of the pinion.
///
/// # Errors
/// A flank that the file does not describe, a gear whose conjugate flank does not reach the pinion, settings that the process does not have.
pub fn run(
    file: &BevelFile,
    study: &CorrectionStudy,
    wanted: &EaseOffTargetFile,
) -> Result<CorrectionResult, Error> {
    if study.member == Member::Gear {
        let message = "the target ease-off is that of the pinion; the gear is not changed";
        return Err(Error::new(Code::Conflict, message)
            .with_span(&wanted.span)
            .with_hint("omit --member"));
    }
    let of = &file.members[0];
    let side = study
        .flank
        .map_or(file.contact.side.flanks()[0], |flank| flank.index());
    let settings = study.settings_for(file, 0, &[side])?;
    let missing = |member: usize, side: usize| {
        let message = format!(
            "the {} flank of the {} is not described",
            SIDES[side], MEMBERS[member]
        );
        Error::new(Code::MissingKey, message)
            .with_span(&file.members[member].span)
            .with_hint("an ease-off needs the flanks of both gears that touch; --flank names that of the pinion")
    };
    let cut = of.flanks[side].as_ref().ok_or_else(|| missing(0, side))?;
    let pinion = file.flank(0, side).ok_or_else(|| missing(0, side))?;
    let gear = file
        .flank(1, 1 - side)
        .ok_or_else(|| missing(1, 1 - side))?;
    let teeth = file.members.each_ref().map(|m| m.teeth);
    let pair = FlankPair::new(
        [pinion.clone(), gear.clone()],
        teeth,
        file.hand,
        &file.assembly(),
    );
    let setup = FlankSetup {
        cutter: cut.cutter,
        machine: cut.settings,
    };
    let mut flank = wanted.target.on(&pair, setup, file.hand).ok_or_else(|| {
        let message = "the flank conjugate to the gear does not reach that of the pinion";
        Error::new(Code::OutOfRange, message)
            .with_span(&of.span)
            .with_hint(
                "start from settings whose flanks touch: `geardyn gear` computes the contact",
            )
    })?;
    let roots = RootPoint::of(&pinion);
    flank.roots = roots.map_or(Vec::new(), |roots| roots.to_vec());
    let flanks = vec![flank];
    let problem = CorrectionProblem {
        unknowns: unknowns(&settings, &flanks, false),
        flanks,
        least: study.least,
    };
    let at_target = |error: Error| error.with_span(&wanted.span);
    let fit = problem.solve().map_err(at_target)?;
    let dials = vec![dials(&settings, cut)];
    let next = problem.rounded_settings(&fit, &fit.setups, &dials, &study.steps, &[roots]);
    let next = next.map_err(at_target)?[0];
    if next.flank(file.hand, of.section).middle().is_none() {
        let message = "the settings nearest to the target ease-off do not cut the middle of the flank: the contact is beyond the blade";
        return Err(at_target(Error::new(Code::OutOfRange, message).with_hint(
            "request an ease-off nearer to that of the present settings",
        )));
    }
    let before = deviations(&problem, setup).map_err(at_target)?;
    let after = deviations(&problem, next).map_err(at_target)?;
    let mut diagnostics = Vec::new();
    let touching = |setup: FlankSetup, notes: &mut Vec<_>| {
        let flank = setup.flank(file.hand, of.section);
        bevel_contact::contact(file, [flank, gear.clone()], notes)
    };
    let contact = ContactChange {
        now: touching(setup, &mut Vec::new()),
        next: touching(next, &mut diagnostics),
    };
    let hint = "request an ease-off nearer to that of the present settings, or free fewer settings";
    diagnostics.extend(not_converged(&fit, hint));
    let depths = vec![depths(roots.as_ref(), &next, file.hand)];
    diagnostics.extend(depth_warning(&depths, &of.section, &[side]));
    diagnostics.extend(no_effective_setting(&fit, study.least));
    let far = (
        "this is another set-up of the machine, not a correction",
        "free fewer settings by --settings, or request an ease-off nearer to that of the present settings",
    );
    diagnostics.extend(large_change(&problem, &fit, far));
    if roots.is_none() {
        diagnostics.push(Diagnostic {
            code: "slot-depth",
            message: "the depth of the slot is not constrained: the tip plane does not pass over the root line of the blank".into(),
            hint: Some("compare the root of the next cut with the blank".into()),
        });
    }
    Ok(CorrectionResult {
        shapes: residual_shapes(&problem.flanks, &fit.nominal, fit.kept),
        plan: plan(study, &settings, &problem, &fit),
        sources: vec![file.source.clone(), wanted.source.clone()],
        member: 0,
        sides: vec![side],
        before: vec![before],
        next: NextCut {
            setups: vec![next],
            deviations: vec![after],
        },
        dials,
        depths,
        cuts_other_flank: false,
        is_one_setting: false,
        contact: Some(contact),
        problem,
        fit,
        diagnostics,
    })
}

/// Deviations of a pinion from the wanted one, m, the turn taken off.
fn deviations(problem: &CorrectionProblem, setup: FlankSetup) -> Result<Vec<Option<f64>>, Error> {
    let flank = MeasuredFlank {
        setup,
        roots: Vec::new(),
        ..problem.flanks[0].clone()
    };
    let fixed = CorrectionProblem {
        flanks: vec![flank],
        unknowns: Vec::new(),
        least: problem.least,
    };
    let rests = fixed.solve()?.residuals.swap_remove(0);
    Ok(rests.into_iter().map(|rest| rest.map(|r| -r)).collect())
}
