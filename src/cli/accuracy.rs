//! `geardyn accuracy`: work–precision of integrators, modal and response methods.

use super::args::AccuracyArgs;
use super::present::Outputs;
use super::{interrupt, output};
use crate::base::error::{Error, Errors};
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::prepared_machine::PreparedMachine;
use crate::report::method_comparison::ComparisonReport;
use crate::report::presentation::Presentation;
use crate::report::work_precision::WorkPrecisionReport;
use crate::scene::study::{AccuracyStudy, AccuracyTarget};
use crate::scene::{self, Scene};
use crate::study::monitor::Monitor;
use crate::study::{frequencies, responses, work_precision};

/// The error wanted by default.
const DEFAULT_TARGET_ERROR: f64 = 1e-6;

/// Runs every method and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the motion.
pub fn run(args: &AccuracyArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study: AccuracyStudy = scene.study(&args.study.flags)?;
    let outputs = Outputs::check(&args.out, &[""], &[], &scene.files())?;
    outputs.present(&*report(&scene, &study, args.out.quiet)?)
}

/// Every method against one reference.
///
/// # Errors
/// Whatever is wrong with the machine or the methods.
pub fn report<'a>(
    scene: &'a Scene,
    study: &AccuracyStudy,
    quiet: bool,
) -> Result<Box<dyn Presentation + 'a>, Error> {
    let mut monitor = Monitor {
        cancel: &interrupt::cancel_on_ctrl_c(),
        on_progress: &mut |what| output::show_status(what, quiet),
    };
    let target_error = study.target_error.unwrap_or(DEFAULT_TARGET_ERROR);
    let count = study
        .lowest
        .map_or(frequencies::DEFAULT_MODES, |n| n as usize);
    let result = match study.target {
        AccuracyTarget::Modes => {
            frequencies::compare_eigensolvers(&scene.model, count, &mut monitor)?
        }
        AccuracyTarget::Response => {
            let machine = PreparedMachine::new(&scene.model)?;
            responses::compare_responses(&machine, &study.response, &mut monitor)?
        }
        AccuracyTarget::Motion => {
            let machine = PreparedMachine::new(&scene.model)?;
            let ready = SimulationSetup::of_whole_meshes(&machine, &scene.start, &study.motion)?;
            let (methods, limit) = (&study.methods, work_precision::TIME_LIMIT);
            return Ok(Box::new(WorkPrecisionReport {
                scene,
                outputs: ready.outputs.list.iter().map(|o| o.name.clone()).collect(),
                target_error,
                result: work_precision::work_precision(&ready, methods, limit, &mut monitor)?,
            }));
        }
    };
    Ok(Box::new(ComparisonReport {
        scene,
        target_error,
        result,
    }))
}
