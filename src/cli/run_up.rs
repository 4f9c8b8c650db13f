//! `geardyn response --run-up`: response to all orders over speed.

use std::path::PathBuf;

use super::args::ResponseArgs;
use super::files::{self, OutputFiles};
use super::{footer, output, progress};
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::run_up::{RunUpResult, run as solve};
use crate::report;
use crate::scene::study::{RunUpStudy, SpeedRange, StudyKind};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = study_from_args(args, &scene)?;
    let mut outputs: Vec<PathBuf> = args.out.csv.iter().cloned().collect();
    if let Some(path) = &args.out.svg {
        files::ends(path, &["svg"])?;
        outputs.push(path.clone());
    }
    let inputs: Vec<PathBuf> = scene.files();
    let mut files = OutputFiles::new(&outputs, &inputs)?;
    let found = progress::with_spinner(
        "answering every order",
        args.out.quiet || args.out.json,
        || RunUpReport::new(&scene, &study),
    )?;
    if let Some(path) = &args.out.csv {
        files.write(path, report::run_up::csv(&found.result).as_bytes())?;
    }
    if let Some(path) = &args.out.svg {
        let plot = report::run_up::draw(&scene.model.title, &found.result);
        files.write(path, plot.as_bytes())?;
    }
    let written = files.finish()?;
    match args.out.json {
        true => output::document(&found.json(&scene))?,
        false => output::print(&found.text())?,
    }
    if !args.out.quiet && !args.out.json {
        output::print_note(&found.epilogue());
        output::print_note(&footer::written_files(&written));
    }
    Ok(0)
}

/// A run-up with all that is said of it.
pub struct RunUpReport {
    machine: PreparedMachine,
    result: RunUpResult,
}

impl RunUpReport {
    /// Prepares and solves.
    ///
    /// # Errors
    /// Whatever is wrong with the machine, the study or the solution.
    pub fn new(scene: &Scene, study: &RunUpStudy) -> Result<RunUpReport, Error> {
        let machine = PreparedMachine::new(&scene.model)?;
        let result = solve(&machine, study)?;
        Ok(RunUpReport { machine, result })
    }

    /// Critical speeds.
    pub fn text(&self) -> String {
        report::run_up_table::table(&self.machine.machine, &self.result)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::run_up::json(&scene.sources, &self.machine.machine, &self.result)
    }

    /// What was done and left out, warnings.
    pub fn epilogue(&self) -> String {
        let mut text = String::from("\n");
        text += &footer::plan_steps(&self.result.plan);
        text += &footer::warnings(&self.result.diagnostics);
        text
    }
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn study_from_args(args: &ResponseArgs, scene: &Scene) -> Result<RunUpStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::RunUp(study) => Some(study.clone()),
        _ => None,
    });
    let listed = listed.unwrap_or_default();
    let speeds = args
        .run_up
        .as_deref()
        .map(|text| SpeedRange::parse(text, "--run-up"))
        .transpose()?;
    let or = |given: &Vec<String>, listed: Vec<String>| {
        if given.is_empty() {
            listed
        } else {
            given.clone()
        }
    };
    Ok(RunUpStudy {
        speeds: speeds.or(listed.speeds),
        outputs: or(&args.output, listed.outputs),
        fixed_dofs: or(&args.hold, listed.fixed_dofs),
    })
}
