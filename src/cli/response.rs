//! `geardyn response`: steady answers to steady excitation.

use std::path::PathBuf;

use super::args::{ResponseArgs, ResponseKindWord, ResponseWayWord};
use super::files::{self, Files};
use super::{epilogue, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::kind::Kind;
use crate::base::units;
use crate::plan::prepared::Prepared;
use crate::plan::response::run::{self, Answer};
use crate::report;
use crate::scene::study::{self, ResponseKind, ResponseStudy, ResponseWay, StudyKind};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = asked(args, &scene)?;
    let mut files = planned(args, &scene)?;
    let found = Linear::new(&scene, &study, args.svg.is_some(), args.quiet)?;
    if let Some(path) = &args.csv {
        files.write(path, report::response::csv(&found.answer).as_bytes())?;
    }
    if let Some(path) = &args.svg {
        let (bode, nyquist) = report::response::pictures(&scene.model.title, &found.answer);
        files.write(path, bode.as_bytes())?;
        files.write(&files::beside(path, "nyquist"), nyquist.as_bytes())?;
    }
    let written = files.finish()?;
    match args.json {
        true => output::document(&found.json(&scene))?,
        false => output::print(&found.text())?,
    }
    if !args.quiet && !args.json {
        output::tell(&found.epilogue());
        output::tell(&epilogue::written(&written));
        if args.svg.is_some() {
            output::tell(&report::response::not_drawn(&found.answer));
        }
    }
    Ok(0)
}

/// A linear response with all that is said of it.
pub struct Linear {
    prepared: Prepared,
    answer: Answer,
}

impl Linear {
    /// Prepares and solves; `drawn`: pictures are wanted.
    ///
    /// # Errors
    /// Whatever is wrong with the machine, the study or the solution.
    pub fn new(
        scene: &Scene,
        study: &ResponseStudy,
        drawn: bool,
        quiet: bool,
    ) -> Result<Linear, Error> {
        let prepared = Prepared::new(&scene.model)?;
        let answer = progress::busy("answering by frequency", quiet, || {
            run::run(&prepared, study, drawn)
        })?;
        Ok(Linear { prepared, answer })
    }

    /// The table of peaks.
    pub fn text(&self) -> String {
        report::response_table::peaks(&self.prepared.machine, &self.answer)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::response::json(&scene.sources, &self.prepared.machine, &self.answer)
    }

    /// What was done and left out, doubts.
    pub fn epilogue(&self) -> String {
        let mut text = format!("\n{}\n", report::response::how(&self.answer));
        text += &epilogue::left_out(&self.answer.plan);
        text += &epilogue::warnings(&self.answer.warnings);
        text
    }
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn asked(args: &ResponseArgs, scene: &Scene) -> Result<ResponseStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Response(response) => Some(response.clone()),
        _ => None,
    });
    let listed = listed.unwrap_or_default();
    let or = |given: &Vec<String>, listed: Vec<String>| {
        if given.is_empty() {
            listed
        } else {
            given.clone()
        }
    };
    if args
        .lines
        .is_some_and(|n| !(2..=study::MOST_LINES).contains(&n))
    {
        let message = format!("--lines takes a count from 2 to {}", study::MOST_LINES);
        return Err(Error::new(Code::OutOfRange, message));
    }
    let speed = args
        .speed
        .as_deref()
        .map(|text| units::parse_or_bare(text, Kind::Speed, "rpm", "--speed"))
        .transpose()?;
    let shown = args.kind.map(|word| match word {
        ResponseKindWord::Receptance => ResponseKind::Receptance,
        ResponseKindWord::Mobility => ResponseKind::Mobility,
        ResponseKindWord::Accelerance => ResponseKind::Accelerance,
    });
    let way = args.method.map(|word| match word {
        ResponseWayWord::Direct => ResponseWay::Direct,
        ResponseWayWord::Modal => ResponseWay::Modal,
    });
    Ok(ResponseStudy {
        inputs: or(&args.input, listed.inputs),
        outputs: or(&args.output, listed.outputs),
        held: or(&args.hold, listed.held),
        shown: shown.or(listed.shown),
        band: args
            .band
            .as_deref()
            .map(|text| study::band(text, "--band"))
            .transpose()?
            .or(listed.band),
        lines: args.lines.or(listed.lines),
        speed: speed.or(listed.speed),
        way: way.or(listed.way),
    })
}

/// The files to write, checked before any work is done.
fn planned(args: &ResponseArgs, scene: &Scene) -> Result<Files, Error> {
    let mut outputs: Vec<PathBuf> = args.csv.iter().cloned().collect();
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
        outputs.extend([path.clone(), files::beside(path, "nyquist")]);
    }
    let inputs: Vec<PathBuf> = scene.files();
    Files::new(&outputs, &inputs)
}
