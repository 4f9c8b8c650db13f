//! `geardyn te`: transmission error of a chain.

use std::path::PathBuf;

use super::args::TeArgs;
use super::files::{self, OutputFiles};
use super::{footer, output, progress, te_log};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::transmission::run::{self, TransmissionResult};
use crate::report;
use crate::scene::study::{IndexingStudy, SpeedRange, StudyKind, TransmissionStudy};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the chain.
pub fn run(args: &TeArgs) -> Result<u8, Errors> {
    if te_log::is_log(&args.file, &args.record) {
        return te_log::run(args);
    }
    te_log::reject_log_flags(args)?;
    let scene = scene::read(&args.file)?;
    let study = study_from_args(args, &scene)?;
    let outputs = outputs(args)?;
    let inputs: Vec<PathBuf> = scene.files();
    let mut files = OutputFiles::new(&outputs, &inputs)?;
    let mut result = TransmissionReport::new(&scene, &study, args.out.quiet)?;
    result.all = args.all;
    let (machine, answer) = (&result.machine.machine, &result.result);
    if let Some(path) = &args.out.csv {
        files.write(path, report::transmission::csv(machine, answer).as_bytes())?;
    }
    if let Some(path) = &args.written {
        files.write_with(path, |to| {
            report::transmission::write_record(machine, answer, to)
        })?;
    }
    if let Some(path) = &args.out.svg {
        let title = &scene.model.title;
        let plots = report::transmission_plots::draw_all(title, machine, answer);
        for (word, plot) in plots {
            files.write(&files::sibling_path(path, word), plot.as_bytes())?;
        }
    }
    let written = files.finish()?;
    match args.out.json {
        true => output::document(&result.json(&scene))?,
        false => output::print(&result.text())?,
    }
    if !args.out.quiet && !args.out.json {
        output::print_note(&result.epilogue());
        output::print_note(&footer::written_files(&written));
    }
    Ok(0)
}

/// Every file that is to be written.
fn outputs(args: &TeArgs) -> Result<Vec<PathBuf>, Error> {
    let mut all: Vec<PathBuf> = args.out.csv.iter().chain(&args.written).cloned().collect();
    if let Some(path) = &args.out.csv {
        files::ends(path, &["csv"])?;
    }
    if let Some(path) = &args.out.svg {
        files::ends(path, &["svg"])?;
        let words: &[&str] = match args.speeds {
            Some(_) => &["", "budget", "speeds"],
            None => &["", "budget"],
        };
        all.extend(words.iter().map(|word| files::sibling_path(path, word)));
    }
    Ok(all)
}

/// The transmission error of a chain with all that is said of it.
pub struct TransmissionReport {
    machine: PreparedMachine,
    result: TransmissionResult,
    /// Every line is shown.
    all: bool,
}

impl TransmissionReport {
    /// Prepares and solves.
    ///
    /// # Errors
    /// Whatever is wrong with the machine, the study or the chain.
    pub fn new(
        scene: &Scene,
        study: &TransmissionStudy,
        quiet: bool,
    ) -> Result<TransmissionReport, Error> {
        let machine = PreparedMachine::new(&scene.model)?;
        let result =
            progress::with_spinner("following the errors", quiet, || run::run(&machine, study))?;
        Ok(TransmissionReport {
            machine,
            result,
            all: false,
        })
    }

    /// The order table, what coincides, the sums.
    pub fn text(&self) -> String {
        report::transmission_table::table(&self.machine.machine, &self.result, self.all)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::transmission::json(&scene.sources, &self.machine.machine, &self.result)
    }

    /// What was left out, warnings.
    pub fn epilogue(&self) -> String {
        let mut text = String::from("\n");
        text += &footer::omitted_steps(&self.result.plan);
        text += &footer::warnings(&self.result.diagnostics);
        text
    }
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn study_from_args(args: &TeArgs, scene: &Scene) -> Result<TransmissionStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Transmission(study) => Some(study.clone()),
        _ => None,
    });
    let mut listed = listed.unwrap_or_default();
    if args.output.is_some() && args.output != listed.output {
        // What another output turns with, and what indexes it, is not the study's.
        (listed.against, listed.index) = (None, None);
    }
    let quantity = |text: &Option<String>, kind: QuantityKind, unit: &str, flag: &str| {
        text.as_deref()
            .map(|text| quantity::parse_or_bare(text, kind, unit, flag))
            .transpose()
    };
    let radius = quantity(&args.radius, QuantityKind::Length, "mm", "--radius")?;
    if radius.is_some_and(|r| r <= 0.0) {
        return Err(Error::new(
            Code::OutOfRange,
            "--radius takes a length above zero",
        ));
    }
    Ok(TransmissionStudy {
        output: args.output.clone().or(listed.output),
        driver: args.driver.clone().or(listed.driver),
        against: args.against.clone().or(listed.against),
        radius: radius.or(listed.radius),
        speed: quantity(&args.speed, QuantityKind::Speed, "rpm", "--speed")?.or(listed.speed),
        speeds: (args.speeds.as_deref())
            .map(|text| SpeedRange::parse(text, "--speeds"))
            .transpose()?
            .or(listed.speeds),
        window_revs: args.window.or(listed.window_revs),
        teeth: args.output_teeth.or(listed.teeth),
        index: (args.index.as_deref())
            .map(|text| IndexingStudy::parse(text, "--index"))
            .transpose()?
            .or(listed.index),
        record: args.written.is_some(),
    })
}
