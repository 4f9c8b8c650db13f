//! `geardyn te`: transmission error of a chain.

use std::path::PathBuf;

use super::args::TeArgs;
use super::files::{self, Files};
use super::{epilogue, output, progress, te_log};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::kind::Kind;
use crate::base::units;
use crate::plan::prepared::Prepared;
use crate::plan::transmission::run::{self, Answer};
use crate::report;
use crate::scene::study::{IndexStudy, SpeedRange, StudyKind, TransmissionStudy};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the chain.
pub fn run(args: &TeArgs) -> Result<u8, Errors> {
    if te_log::is_log(&args.file, &args.record) {
        return te_log::run(args);
    }
    te_log::refuse_of_model(args)?;
    let scene = scene::read(&args.file)?;
    let study = asked(args, &scene)?;
    let outputs = outputs(args)?;
    let inputs: Vec<PathBuf> = scene.files();
    let mut files = Files::new(&outputs, &inputs)?;
    let mut traced = Traced::new(&scene, &study, args.quiet)?;
    traced.all = args.all;
    let (machine, answer) = (&traced.prepared.machine, &traced.answer);
    if let Some(path) = &args.csv {
        files.write(path, report::transmission::csv(machine, answer).as_bytes())?;
    }
    if let Some(path) = &args.written {
        files.write_with(path, |to| report::transmission::record(machine, answer, to))?;
    }
    if let Some(path) = &args.svg {
        let title = &scene.model.title;
        let pictures = report::transmission_pictures::all(title, machine, answer);
        for (word, picture) in pictures {
            files.write(&files::beside(path, word), picture.as_bytes())?;
        }
    }
    let written = files.finish()?;
    match args.json {
        true => output::document(&traced.json(&scene))?,
        false => output::print(&traced.text())?,
    }
    if !args.quiet && !args.json {
        output::tell(&traced.epilogue());
        output::tell(&epilogue::written(&written));
    }
    Ok(0)
}

/// Every file that is to be written.
fn outputs(args: &TeArgs) -> Result<Vec<PathBuf>, Error> {
    let mut all: Vec<PathBuf> = args.csv.iter().chain(&args.written).cloned().collect();
    if let Some(path) = &args.csv {
        files::ends(path, &["csv"])?;
    }
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
        let words: &[&str] = match args.speeds {
            Some(_) => &["", "budget", "speeds"],
            None => &["", "budget"],
        };
        all.extend(words.iter().map(|word| files::beside(path, word)));
    }
    Ok(all)
}

/// The transmission error of a chain with all that is said of it.
pub struct Traced {
    prepared: Prepared,
    answer: Answer,
    /// Every line is shown.
    all: bool,
}

impl Traced {
    /// Prepares and solves.
    ///
    /// # Errors
    /// Whatever is wrong with the machine, the study or the chain.
    pub fn new(scene: &Scene, study: &TransmissionStudy, quiet: bool) -> Result<Traced, Error> {
        let prepared = Prepared::new(&scene.model)?;
        let answer = progress::busy("following the errors", quiet, || run::run(&prepared, study))?;
        Ok(Traced {
            prepared,
            answer,
            all: false,
        })
    }

    /// The order table, what coincides, the sums.
    pub fn text(&self) -> String {
        report::transmission_table::table(&self.prepared.machine, &self.answer, self.all)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::transmission::json(&scene.sources, &self.prepared.machine, &self.answer)
    }

    /// What was left out, doubts.
    pub fn epilogue(&self) -> String {
        let mut text = String::from("\n");
        text += &epilogue::left_out(&self.answer.plan);
        text += &epilogue::warnings(&self.answer.warnings);
        text
    }
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn asked(args: &TeArgs, scene: &Scene) -> Result<TransmissionStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Transmission(study) => Some(study.clone()),
        _ => None,
    });
    let mut listed = listed.unwrap_or_default();
    if args.output.is_some() && args.output != listed.output {
        // What another output turns with, and what indexes it, is not the study's.
        (listed.against, listed.index) = (None, None);
    }
    let quantity = |text: &Option<String>, kind: Kind, unit: &str, flag: &str| {
        text.as_deref()
            .map(|text| units::parse_or_bare(text, kind, unit, flag))
            .transpose()
    };
    let radius = quantity(&args.radius, Kind::Length, "mm", "--radius")?;
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
        speed: quantity(&args.speed, Kind::Speed, "rpm", "--speed")?.or(listed.speed),
        speeds: (args.speeds.as_deref())
            .map(|text| SpeedRange::parse(text, "--speeds"))
            .transpose()?
            .or(listed.speeds),
        window: args.window.or(listed.window),
        teeth: args.output_teeth.or(listed.teeth),
        index: (args.index.as_deref())
            .map(|text| IndexStudy::parse(text, "--index"))
            .transpose()?
            .or(listed.index),
        record: args.written.is_some(),
    })
}
