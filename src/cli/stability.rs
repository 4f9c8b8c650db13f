//! `geardyn stability`: step limits, parametric stability, stress cases.

use super::args::StabilityArgs;
use super::present::Outputs;
use super::{interrupt, output};
use crate::base::error::{Error, Errors};
use crate::plan::motion::method_choice;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::prepared_machine::PreparedMachine;
use crate::report::stability::StabilityReport;
use crate::report::stability_table::StabilityResult;
use crate::scene::study::{SimulateStudy, StabilityStudy};
use crate::scene::{self, Scene};
use crate::study::monitor::{Monitor, interrupted_error};
use crate::study::parametric;
use crate::study::stability::stress_test::{self, CaseMethods};
use crate::study::stability::{amplification, linear, perturbations};

/// Studies and prints; ends with 1 where a case failed.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the machine.
pub fn run(args: &StabilityArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study: StabilityStudy = scene.study(&args.study.flags)?;
    let figures: &[&str] = match study.over {
        Some(_) => &["", "chart"],
        None => &[""],
    };
    let outputs = Outputs::check(&args.out, figures, &[], &scene.files())?;
    let machine = PreparedMachine::new(&scene.model)?;
    let quiet = args.out.quiet || args.out.json;
    outputs.present(&report(&scene, &machine, &study, quiet)?)
}

/// Facts, parametric stability, extremes.
///
/// # Errors
/// Whatever is wrong with the machine or the methods.
pub fn report<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &StabilityStudy,
    quiet: bool,
) -> Result<StabilityReport<'a>, Error> {
    let cancel = &interrupt::cancel_on_ctrl_c();
    method_choice::find_methods(&study.methods)?;
    let mut monitor = Monitor {
        cancel,
        on_progress: &mut |what| output::show_status(what, quiet),
    };
    let facts = match monitor.proceed("modes with their damping") {
        true => linear::linear_stability(machine, study.motion.speed)?,
        false => return Err(interrupted_error()),
    };
    // Multipliers are of the machine, however long it moves; a period of the slowest motion stands in for a duration left out.
    let nominal = SimulateStudy {
        end_time: study.motion.end_time.or(Some(facts.slowest_period())),
        ..study.motion.clone()
    };
    let ready = SimulationSetup::with_single_spring_meshes(machine, &scene.start, &nominal);
    let asks_motion = study.motion.end_time.is_some() || study.speeds.is_some();
    let budget = ready
        .as_ref()
        .map_or(perturbations::MAX_WORK, perturbations::work_limit);
    let (floquet, cases, left_out, methods_left_out) = match ready {
        // What keeps a model from moving is nothing to its linear facts.
        Err(error) if !asks_motion => {
            let why = error.message;
            let nothing = vec![(perturbations::ALL_CASES, perturbations::REASON_NO_DURATION)];
            (Err(why), Vec::new(), nothing, Vec::new())
        }
        ready => {
            let ready = ready?;
            let floquet = parametric::parametric_stability(machine, &ready, study, &mut monitor)?;
            let (cases, left_out, unable) = match study.motion.end_time {
                Some(_) => {
                    let methods = CaseMethods::new(&ready, &study.motion, &study.methods)?;
                    let cases =
                        stress_test::stress_test(&ready, &study.motion, &methods, &mut monitor);
                    (
                        cases,
                        perturbations::skipped_cases(&ready).collect(),
                        methods.unsupported,
                    )
                }
                None => {
                    let nothing =
                        vec![(perturbations::ALL_CASES, perturbations::REASON_NO_DURATION)];
                    (Vec::new(), nothing, Vec::new())
                }
            };
            (floquet, cases, left_out, unable)
        }
    };
    let step = study.motion.step.unwrap_or(facts.default_step());
    let amplified = amplification::amplification_factors(&facts.eigenvalues, step)?;
    Ok(StabilityReport {
        scene,
        step: study.motion.step,
        result: StabilityResult {
            amplification: (step, amplified),
            linear: facts,
            floquet,
            cases,
            budget,
            left_out,
            methods_left_out,
            interrupted: cancel.is_cancelled(),
        },
    })
}
