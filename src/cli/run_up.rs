//! `geardyn response --run-up`: answers to all orders over speed.

use std::path::PathBuf;

use super::args::ResponseArgs;
use super::files::{self, Files};
use super::{epilogue, output, progress};
use crate::base::error::{Error, Errors};
use crate::plan::prepared::Prepared;
use crate::plan::response::run_up::{Answer, run as solve};
use crate::report;
use crate::scene::study::{RunUpStudy, SpeedRange, StudyKind};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = asked(args, &scene)?;
    let mut outputs: Vec<PathBuf> = args.csv.iter().cloned().collect();
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
        outputs.push(path.clone());
    }
    let inputs: Vec<PathBuf> = scene.files();
    let mut files = Files::new(&outputs, &inputs)?;
    let found = progress::busy("answering every order", args.quiet || args.json, || {
        Raised::new(&scene, &study)
    })?;
    if let Some(path) = &args.csv {
        files.write(path, report::run_up::csv(&found.answer).as_bytes())?;
    }
    if let Some(path) = &args.svg {
        let picture = report::run_up::picture(&scene.model.title, &found.answer);
        files.write(path, picture.as_bytes())?;
    }
    let written = files.finish()?;
    match args.json {
        true => output::document(&found.json(&scene))?,
        false => output::print(&found.text())?,
    }
    if !args.quiet && !args.json {
        output::tell(&found.epilogue());
        output::tell(&epilogue::written(&written));
    }
    Ok(0)
}

/// A run-up with all that is said of it.
pub struct Raised {
    prepared: Prepared,
    answer: Answer,
}

impl Raised {
    /// Prepares and solves.
    ///
    /// # Errors
    /// Whatever is wrong with the machine, the study or the solution.
    pub fn new(scene: &Scene, study: &RunUpStudy) -> Result<Raised, Error> {
        let prepared = Prepared::new(&scene.model)?;
        let answer = solve(&prepared, study)?;
        Ok(Raised { prepared, answer })
    }

    /// Critical speeds.
    pub fn text(&self) -> String {
        report::run_up_table::table(&self.prepared.machine, &self.answer)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::run_up::json(&scene.sources, &self.prepared.machine, &self.answer)
    }

    /// What was done and left out, doubts.
    pub fn epilogue(&self) -> String {
        let mut text = String::from("\n");
        text += &epilogue::steps(&self.answer.plan);
        text += &epilogue::warnings(&self.answer.warnings);
        text
    }
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn asked(args: &ResponseArgs, scene: &Scene) -> Result<RunUpStudy, Error> {
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
        held: or(&args.hold, listed.held),
    })
}
