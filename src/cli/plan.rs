//! `geardyn plan`: stages to be run, stages left out, condensation advice.

use std::sync::Arc;

use super::args::PlanArgs;
use super::{gear, output};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::flags::Flags;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceFile;
use crate::modes::modal_basis::{self, UndampedSolver};
use crate::modes::reduction::{CondensationAdvice, find_condensable};
use crate::modes::system_matrices::AnalysisContext;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::motion::{method_choice, stages};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::{harmonic_balance, run_up};
use crate::plan::stages::ModesPlan;
use crate::report::plan_report::{MotionPlan, PlanReport};
use crate::report::presentation::{Presentation, document};
use crate::scene::study::{AccuracyTarget, ModesStudy, SimulateStudy, Study, StudyKind};
use crate::scene::{self, Scene};

/// Prints the plan of a study of modes.
///
/// # Errors
/// Whatever is wrong with the file or the flags.
pub fn run(args: &PlanArgs) -> Result<u8, Errors> {
    if let Some(source) = gear::gear_source(&args.model)? {
        return of_gears(args, &source);
    }
    let scene = scene::read(&args.model)?;
    let study: ModesStudy = scene.study(&args.study.flags)?;
    let machine = PreparedMachine::new(&scene.model)?;
    let modes = ModesPlan::plan_modes(&machine, &study);
    let band = args
        .advise
        .as_deref()
        .map(|text| quantity::parse_or_bare(text, QuantityKind::Frequency, "Hz", "--advise"));
    let band_hz = band.transpose()?.map(|omega| omega / std::f64::consts::TAU);
    let advice = band_hz
        .map(|hz| {
            let asked: SimulateStudy = scene.study_over(None, &args.integration.flags)?;
            let tolerance = asked.tolerance.unwrap_or(DEFAULT_TOLERANCE);
            Ok::<_, Errors>((hz, condensation_advice(&machine, hz, tolerance)?))
        })
        .transpose()?;
    // With --advise the tolerance is that of the advice.
    let flags = match args.advise {
        Some(_) => args.integration.flags.without("tolerance"),
        None => args.integration.flags.clone(),
    };
    let motions: Vec<MotionPlan> = simulation_plans(&scene, &machine, &flags)?
        .into_iter()
        .map(|(kind, stages)| (kind, machine.after_meshes(stages)))
        .collect();
    let report = PlanReport {
        modes_shown: motions.len() < scene.studies.len() || motions.is_empty(),
        scene: &scene,
        warnings: machine.warnings(),
        machine,
        modes,
        motions,
        advice,
    };
    match args.json {
        true => output::document(&document(&report)?)?,
        false => output::print(&report.text())?,
    }
    Ok(0)
}

/// The stages of a gear file, to which no flag of a study applies.
fn of_gears(args: &PlanArgs, source: &Arc<SourceFile>) -> Result<u8, Errors> {
    for flags in [&args.study.flags, &args.integration.flags] {
        flags.read("a gear file", None, &[], |_| ())?;
    }
    if args.advise.is_some() {
        let message = "--advise applies to machines; the file describes gears";
        return Err(Error::new(Code::Usage, message).with_hint("omit it").into());
    }
    let plan = gear::stages(source)?;
    match args.json {
        true => output::document(&document(&plan)?)?,
        false => output::print(&plan.text())?,
    }
    Ok(0)
}

/// Relative change of a frequency that does not matter, by default.
const DEFAULT_TOLERANCE: f64 = 1e-3;

/// The plans of every study of motion that a scene lists; where it lists none and the flags ask for one, of that.
fn simulation_plans(
    scene: &Scene,
    machine: &PreparedMachine,
    flags: &Flags,
) -> Result<Vec<MotionPlan>, Errors> {
    let mut all = Vec::new();
    let in_time = |kind: &'static str, listed: Option<&Study>| {
        let motion: SimulateStudy = scene.study_over(listed, flags)?;
        // `accuracy` and `stability` compare runs of their own.
        let motion = SimulateStudy {
            no_sensitivity: motion.no_sensitivity || kind != "simulate",
            ..motion
        };
        let ready = match kind {
            "simulate" => SimulationSetup::new(machine, &scene.start, &motion)?,
            _ => SimulationSetup::with_single_spring_meshes(machine, &scene.start, &motion)?,
        };
        let choice = method_choice::choose_method(&ready.model.model, &motion)?;
        Ok::<_, Errors>((kind, stages::plan(&ready, &choice, &motion)))
    };
    let moves = |kind: &StudyKind| {
        matches!(
            kind,
            StudyKind::Simulate(_) | StudyKind::Accuracy(_) | StudyKind::Stability(_)
        )
    };
    if !flags.is_empty() && !scene.studies.iter().any(|s| moves(&s.kind)) {
        all.push(in_time("simulate", None)?);
    }
    for study in &scene.studies {
        let (kind, listed) = match &study.kind {
            StudyKind::Modes(_) => continue,
            StudyKind::Response(response) => {
                all.push((
                    "response",
                    crate::plan::response::method_choice::plan(machine, response),
                ));
                continue;
            }
            StudyKind::HarmonicBalance(balance) => {
                all.push((
                    "harmonic_balance",
                    harmonic_balance::plan(machine, balance)?,
                ));
                continue;
            }
            StudyKind::RunUp(study) => {
                all.push(("run_up", run_up::plan(machine, study)?));
                continue;
            }
            StudyKind::Transmission(te) => {
                all.push((
                    "te",
                    crate::plan::transmission::stages::plan(&machine.machine, te),
                ));
                continue;
            }
            StudyKind::Simulate(_) => ("simulate", Some(study)),
            StudyKind::Accuracy(accuracy) => {
                let moves = accuracy.target == AccuracyTarget::Motion;
                ("accuracy", Some(study).filter(|_| moves))
            }
            StudyKind::Stability(_) => ("stability", Some(study)),
        };
        all.push(in_time(kind, listed)?);
    }
    Ok(all)
}

fn condensation_advice(
    prepared_machine: &PreparedMachine,
    hz: f64,
    tolerance: f64,
) -> Result<CondensationAdvice, Error> {
    let PreparedMachine {
        machine,
        model: linear,
        ..
    } = prepared_machine;
    let basis = modal_basis::solve(linear, UndampedSolver::Factored)?;
    let context = AnalysisContext {
        machine,
        model: linear,
        basis: &basis,
        speeds: None,
    };
    find_condensable(&context, hz, tolerance)
}
