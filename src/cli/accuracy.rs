//! `geardyn accuracy`: work–precision of integrators, modal and response methods.

use std::path::PathBuf;

use super::args::{AccuracyArgs, AccuracyTargetArg};
use super::files::{self, OutputFiles};
use super::{footer, interrupt, output, simulate_study};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::time_budget::CancelToken;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::prepared_machine::PreparedMachine;
use crate::report;
use crate::scene::study::{AccuracyStudy, AccuracyTarget, ResponseStudy, StudyKind, parse_band};
use crate::scene::{self, Scene};
use crate::study::comparison::ComparisonResult;
use crate::study::monitor::Monitor;
use crate::study::work_precision::{self, WorkPrecisionResult};
use crate::study::{frequencies, responses};

/// The error wanted by default.
const DEFAULT_TARGET_ERROR: f64 = 1e-6;

/// Runs every method and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the motion.
pub fn run(args: &AccuracyArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = study(args, study_from_scene(&scene))?;
    let outputs: Vec<PathBuf> = args.out.csv.iter().chain(&args.out.svg).cloned().collect();
    let inputs: Vec<PathBuf> = scene.files();
    if let Some(path) = &args.out.svg {
        files::ends(path, &["svg"])?;
    }
    let mut files = OutputFiles::new(&outputs, &inputs)?;
    let measured = AccuracyReport::new(
        &scene,
        &study,
        args.out.quiet,
        &interrupt::cancel_on_ctrl_c(),
    )?;
    let whole = measured.exit_code() != interrupt::EXIT_INTERRUPTED;
    if let Some(path) = args.out.csv.as_ref().filter(|_| whole) {
        files.write(path, measured.csv().as_bytes())?;
    }
    if let Some(path) = args.out.svg.as_ref().filter(|_| whole) {
        files.write(path, measured.draw(&scene.model.title).as_bytes())?;
    }
    files.finish()?;
    match args.out.json {
        true => output::document(&measured.json(&scene))?,
        false => output::print(&measured.text())?,
    }
    if !args.out.quiet {
        output::print_note(measured.epilogue());
        output::print_note(&footer::not_written(&outputs, whole));
    }
    Ok(measured.exit_code())
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

/// A study of accuracy with all that is said of it.
pub struct AccuracyReport {
    target_error: f64,
    result: AccuracyData,
}

enum AccuracyData {
    Motion {
        accuracy: WorkPrecisionResult,
        outputs: Vec<String>,
    },
    Ways(ComparisonResult),
}

impl AccuracyReport {
    /// Prepares and runs every method.
    ///
    /// # Errors
    /// Whatever is wrong with the machine or the methods.
    pub fn new(
        scene: &Scene,
        study: &AccuracyStudy,
        quiet: bool,
        cancel: &CancelToken,
    ) -> Result<AccuracyReport, Error> {
        let mut monitor = Monitor {
            cancel,
            on_progress: &mut |what| output::show_status(what, quiet),
        };
        let result = match study.target {
            AccuracyTarget::Modes => {
                let count = study
                    .lowest
                    .map_or(frequencies::DEFAULT_MODES, |n| n as usize);
                AccuracyData::Ways(frequencies::compare_eigensolvers(
                    &scene.model,
                    count,
                    &mut monitor,
                )?)
            }
            AccuracyTarget::Response => {
                let machine = PreparedMachine::new(&scene.model)?;
                AccuracyData::Ways(responses::compare_responses(
                    &machine,
                    &study.response,
                    &mut monitor,
                )?)
            }
            AccuracyTarget::Motion => {
                let machine = PreparedMachine::new(&scene.model)?;
                let ready = SimulationSetup::new(&machine, &scene.start, &study.motion)?;
                AccuracyData::Motion {
                    accuracy: work_precision::work_precision(
                        &ready,
                        &study.methods,
                        work_precision::TIME_LIMIT,
                        &mut monitor,
                    )?,
                    outputs: ready.outputs.list.iter().map(|o| o.name.clone()).collect(),
                }
            }
        };
        Ok(AccuracyReport {
            target_error: study.target_error.unwrap_or(DEFAULT_TARGET_ERROR),
            result,
        })
    }

    /// The table.
    pub fn text(&self) -> String {
        match &self.result {
            AccuracyData::Motion { accuracy, outputs } => {
                report::work_precision_table::table(outputs, accuracy, self.target_error)
            }
            AccuracyData::Ways(found) => {
                report::method_comparison_table::table(found, self.target_error)
            }
        }
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        match &self.result {
            AccuracyData::Motion { accuracy, outputs } => {
                report::work_precision::json(&scene.sources, outputs, accuracy, self.target_error)
            }
            AccuracyData::Ways(found) => {
                report::method_comparison::json(&scene.sources, found, self.target_error)
            }
        }
    }

    /// What is said where it ended early.
    pub fn epilogue(&self) -> &'static str {
        match self.exit_code() {
            interrupt::EXIT_INTERRUPTED => "interrupted: what is shown was finished before\n",
            _ => "",
        }
    }

    /// How the command ends.
    pub fn exit_code(&self) -> u8 {
        let interrupted = match &self.result {
            AccuracyData::Motion { accuracy, .. } => accuracy.interrupted,
            AccuracyData::Ways(found) => found.interrupted,
        };
        match interrupted {
            true => interrupt::EXIT_INTERRUPTED,
            false => 0,
        }
    }

    fn csv(&self) -> String {
        match &self.result {
            AccuracyData::Motion { accuracy, .. } => report::work_precision::csv(accuracy),
            AccuracyData::Ways(found) => report::method_comparison::csv(found),
        }
    }

    fn draw(&self, title: &str) -> String {
        match &self.result {
            AccuracyData::Motion { accuracy, .. } => report::work_precision::draw(title, accuracy),
            AccuracyData::Ways(found) => report::method_comparison::draw(title, found),
        }
    }
}
