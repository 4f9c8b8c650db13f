//! `geardyn response`: steady answers to steady excitation.

use std::path::PathBuf;

use super::args::{FrfFormArg, ResponseArgs, ResponseMethodArg};
use super::files::{self, OutputFiles};
use super::{footer, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::run::{self, ResponseResult};
use crate::report;
use crate::scene::study::{self, ResponseMethodTag, ResponseQuantity, ResponseStudy, StudyKind};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = study_from_args(args, &scene)?;
    let mut files = output_files(args, &scene)?;
    let found = ResponseReport::new(&scene, &study, args.out.svg.is_some(), args.out.quiet)?;
    if let Some(path) = &args.out.csv {
        files.write(path, report::response::csv(&found.result).as_bytes())?;
    }
    if let Some(path) = &args.out.svg {
        let (bode, nyquist) = report::response::draw_plots(&scene.model.title, &found.result);
        files.write(path, bode.as_bytes())?;
        files.write(&files::sibling_path(path, "nyquist"), nyquist.as_bytes())?;
    }
    let written = files.finish()?;
    match args.out.json {
        true => output::document(&found.json(&scene))?,
        false => output::print(&found.text())?,
    }
    if !args.out.quiet && !args.out.json {
        output::print_note(&found.epilogue());
        output::print_note(&footer::written_files(&written));
        if args.out.svg.is_some() {
            output::print_note(&report::response::omitted_text(&found.result));
        }
    }
    Ok(0)
}

/// A linear response with all that is said of it.
pub struct ResponseReport {
    machine: PreparedMachine,
    result: ResponseResult,
}

impl ResponseReport {
    /// Prepares and solves; `drawn`: plots are wanted.
    ///
    /// # Errors
    /// Whatever is wrong with the machine, the study or the solution.
    pub fn new(
        scene: &Scene,
        study: &ResponseStudy,
        drawn: bool,
        quiet: bool,
    ) -> Result<ResponseReport, Error> {
        let machine = PreparedMachine::new(&scene.model)?;
        let result = progress::with_spinner("answering by frequency", quiet, || {
            run::run(&machine, study, drawn)
        })?;
        Ok(ResponseReport { machine, result })
    }

    /// The table of peaks.
    pub fn text(&self) -> String {
        report::response_table::peaks(&self.machine.machine, &self.result)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::response::json(&scene.sources, &self.machine.machine, &self.result)
    }

    /// What was done and left out, warnings.
    pub fn epilogue(&self) -> String {
        let mut text = format!("\n{}\n", report::response::method_text(&self.result));
        text += &footer::omitted_steps(&self.result.plan);
        text += &footer::warnings(&self.result.diagnostics);
        text
    }
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn study_from_args(args: &ResponseArgs, scene: &Scene) -> Result<ResponseStudy, Error> {
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
        .is_some_and(|n| !(2..=study::MAX_LINES).contains(&n))
    {
        let message = format!("--lines takes a count from 2 to {}", study::MAX_LINES);
        return Err(Error::new(Code::OutOfRange, message));
    }
    let speed = args
        .speed
        .as_deref()
        .map(|text| quantity::parse_or_bare(text, QuantityKind::Speed, "rpm", "--speed"))
        .transpose()?;
    let shown = args.kind.map(|word| match word {
        FrfFormArg::Receptance => ResponseQuantity::Receptance,
        FrfFormArg::Mobility => ResponseQuantity::Mobility,
        FrfFormArg::Accelerance => ResponseQuantity::Accelerance,
    });
    let way = args.method.map(|word| match word {
        ResponseMethodArg::Direct => ResponseMethodTag::Direct,
        ResponseMethodArg::Modal => ResponseMethodTag::Modal,
    });
    Ok(ResponseStudy {
        inputs: or(&args.input, listed.inputs),
        outputs: or(&args.output, listed.outputs),
        fixed_dofs: or(&args.hold, listed.fixed_dofs),
        motion_quantity: shown.or(listed.motion_quantity),
        band: args
            .band
            .as_deref()
            .map(|text| study::parse_band(text, "--band"))
            .transpose()?
            .or(listed.band),
        lines: args.lines.or(listed.lines),
        speed: speed.or(listed.speed),
        way: way.or(listed.way),
    })
}

/// The files to write, checked before any work is done.
fn output_files(args: &ResponseArgs, scene: &Scene) -> Result<OutputFiles, Error> {
    let mut outputs: Vec<PathBuf> = args.out.csv.iter().cloned().collect();
    if let Some(path) = &args.out.svg {
        files::ends(path, &["svg"])?;
        outputs.extend([path.clone(), files::sibling_path(path, "nyquist")]);
    }
    let inputs: Vec<PathBuf> = scene.files();
    OutputFiles::new(&outputs, &inputs)
}
