//! `geardyn accuracy`: work–precision of integrators, modal and response methods.

use std::sync::Arc;

use super::args::AccuracyArgs;
use super::present::Outputs;
use super::{gear, interrupt, output};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::prepared_machine::PreparedMachine;
use crate::report::mesh_accuracy::MeshAccuracyReport;
use crate::report::method_comparison::ComparisonReport;
use crate::report::presentation::Presentation;
use crate::report::work_precision::WorkPrecisionReport;
use crate::scene::bevel_file;
use crate::scene::gear_file;
use crate::scene::gear_kind::{self, PairKind};
use crate::scene::study::{AccuracyStudy, AccuracyTarget};
use crate::scene::{self, Scene};
use crate::study::monitor::Monitor;
use crate::study::{contact_grid, frequencies, mesh_grid, responses, work_precision};

/// The error wanted by default.
const DEFAULT_TARGET_ERROR: f64 = 1e-6;

/// Runs every method and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the motion.
pub fn run(args: &AccuracyArgs) -> Result<u8, Errors> {
    if let Some(source) = gear::gear_source(&args.scene)? {
        return of_mesh(args, &source);
    }
    let scene = scene::read(&args.scene)?;
    let study: AccuracyStudy = scene.study(&args.study.flags)?;
    let outputs = Outputs::check(&args.out, &[""], &[], &scene.files())?;
    let machine = PreparedMachine::new(&scene.model)?;
    outputs.present(&*report(&scene, &machine, &study, args.out.quiet)?)
}

/// The error of a mesh wanted by default.
const DEFAULT_MESH_ERROR: f64 = 1e-2;

/// Grids of the mesh of a gear file against a finer one.
fn of_mesh(args: &AccuracyArgs, source: &Arc<SourceFile>) -> Result<u8, Errors> {
    let (flags, quiet) = (&args.study.flags, args.out.quiet);
    let target_error = flags.read("a gear file", None, &[], |f| {
        f.optional_number("error", ValueRange::Positive)
    })?;
    let kind = gear_kind::pair_kind(source)?;
    if !matches!(kind, PairKind::Cylindrical | PairKind::Bevel) {
        let message = "loads are shared between cylindrical gears and bevel gears only";
        return Err(Error::new(Code::Usage, message)
            .with_span(&SourceSpan::whole_file(&source.path))
            .with_hint("`geardyn gear` computes this pair without a load")
            .into());
    }
    let outputs = Outputs::check(&args.out, &[""], &[], std::slice::from_ref(&args.scene))?;
    let mut monitor = Monitor {
        cancel: &interrupt::cancel_on_ctrl_c(),
        on_progress: &mut |what| output::show_status(what, quiet),
    };
    let (title, results) = match kind {
        PairKind::Bevel => {
            let file = bevel_file::read(source, &Flags::default())?;
            let results = contact_grid::compare_bevel_grids(&file, &mut monitor)?;
            (file.title, results)
        }
        _ => {
            let file = gear_file::read(source, &Flags::default())?;
            let results = mesh_grid::compare_grids(&file, &mut monitor)?;
            (file.title, results)
        }
    };
    outputs.present(&MeshAccuracyReport {
        results,
        target_error: target_error.unwrap_or(DEFAULT_MESH_ERROR),
        title: &title,
        source,
    })
}

/// Every method against one reference.
///
/// # Errors
/// Whatever is wrong with the machine or the methods.
pub fn report<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
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
            frequencies::compare_eigensolvers(machine, &scene.model, count, &mut monitor)?
        }
        AccuracyTarget::Response => {
            responses::compare_responses(machine, &study.response, &mut monitor)?
        }
        AccuracyTarget::Motion => {
            let ready =
                SimulationSetup::with_single_spring_meshes(machine, &scene.start, &study.motion)?;
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
