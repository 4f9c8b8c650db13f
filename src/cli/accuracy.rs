//! `geardyn accuracy`: work–precision of integrators, modal and response methods.

use super::args::{AccuracyArgs, AccuracyTargetArg};
use super::present::Outputs;
use super::{interrupt, output, simulate_study};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::prepared_machine::PreparedMachine;
use crate::report::method_comparison::ComparisonReport;
use crate::report::presentation::Presentation;
use crate::report::work_precision::WorkPrecisionReport;
use crate::scene::study::{AccuracyStudy, AccuracyTarget, ResponseStudy, StudyKind, parse_band};
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
    let study = study(args, study_from_scene(&scene))?;
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
            let ready = SimulationSetup::new(&machine, &scene.start, &study.motion)?;
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

/// The study a scene lists with what the flags say put in its place.
fn study(args: &AccuracyArgs, listed: AccuracyStudy) -> Result<AccuracyStudy, Error> {
    let study = AccuracyStudy {
        target: match args.of {
            Some(AccuracyTargetArg::Motion) => AccuracyTarget::Motion,
            Some(AccuracyTargetArg::Modes) => AccuracyTarget::Modes,
            Some(AccuracyTargetArg::Response) => AccuracyTarget::Response,
            None => listed.target,
        },
        lowest: args.lowest.or(listed.lowest),
        response: response(args, listed.response)?,
        motion: simulate_study::from_args(&args.motion, listed.motion)?,
        methods: if args.methods.is_empty() {
            listed.methods
        } else {
            args.methods.clone()
        },
        target_error: args.error.or(listed.target_error),
    };
    if study
        .target_error
        .is_some_and(|x| !(x > 0.0 && x.is_finite()))
    {
        return Err(
            Error::new(Code::OutOfRange, "--error takes a number above zero")
                .with_hint("it is relative: 1e-6 is usual"),
        );
    }
    match find_unused_flag(args, study.target) {
        Some((flag, wants)) => {
            let error = Error::new(Code::Usage, format!("{flag} does nothing here"));
            Err(error.with_hint(format!("it belongs to {wants}")))
        }
        None => Ok(study),
    }
}

/// What is asked of responses.
fn response(args: &AccuracyArgs, listed: ResponseStudy) -> Result<ResponseStudy, Error> {
    let or = |given: &[String], listed: Vec<String>| match given.is_empty() {
        true => listed,
        false => given.to_vec(),
    };
    let band = args.band.as_deref().map(|text| parse_band(text, "--band"));
    Ok(ResponseStudy {
        inputs: or(&args.input, listed.inputs),
        outputs: or(&args.motion.output, listed.outputs),
        band: band.transpose()?.or(listed.band),
        lines: args.lines.or(listed.lines),
        ..listed
    })
}

/// A flag that was given and belongs to another subject, with the subject.
fn find_unused_flag(
    args: &AccuracyArgs,
    of: AccuracyTarget,
) -> Option<(&'static str, &'static str)> {
    const MOTION: &str = "--of motion";
    const RESPONSE: &str = "--of response";
    let how = &args.motion.integration;
    let (moves, answers) = (of == AccuracyTarget::Motion, of == AccuracyTarget::Response);
    let given = [
        (
            args.lowest.is_some() && of != AccuracyTarget::Modes,
            "--lowest",
            "--of modes",
        ),
        (!args.input.is_empty() && !answers, "--input", RESPONSE),
        (args.band.is_some() && !answers, "--band", RESPONSE),
        (args.lines.is_some() && !answers, "--lines", RESPONSE),
        (
            !args.motion.output.is_empty() && of == AccuracyTarget::Modes,
            "--output",
            RESPONSE,
        ),
        (!args.methods.is_empty() && !moves, "--methods", MOTION),
        (how.until.is_some() && !moves, "--until", MOTION),
        (how.method.is_some() && !moves, "--method", MOTION),
        (how.tolerance.is_some() && !moves, "--tolerance", MOTION),
        (how.step.is_some() && !moves, "--step", MOTION),
        (how.samples.is_some() && !moves, "--samples", MOTION),
    ];
    let idle = given.into_iter().find(|g| g.0);
    idle.map(|(_, flag, wants)| (flag, wants))
}

/// The study of accuracy a scene lists; else the motion it lists.
fn study_from_scene(scene: &Scene) -> AccuracyStudy {
    let own = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Accuracy(study) => Some(study.clone()),
        _ => None,
    });
    let motion = || {
        scene.studies.iter().find_map(|study| match &study.kind {
            StudyKind::Simulate(motion) => Some(AccuracyStudy {
                motion: motion.clone(),
                ..AccuracyStudy::default()
            }),
            _ => None,
        })
    };
    own.or_else(motion).unwrap_or_default()
}
