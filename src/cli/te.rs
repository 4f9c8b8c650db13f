//! `geardyn te`: transmission error of a chain.

use super::args::TeArgs;
use super::present::Outputs;
use super::{destination, progress, te_log};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::transmission::run::run as solve;
use crate::report::transmission::TransmissionReport;
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
    let figures: &[&str] = match args.speeds {
        Some(_) => &["", "budget", "speeds"],
        None => &["", "budget"],
    };
    let mut outputs = Outputs::check(&args.out, figures, &[&args.written], &scene.files())?;
    let mut report = report(&scene, &study, args.out.quiet)?;
    report.all = args.all;
    if let Some(path) = &args.written {
        let failed = |e| destination::output_error(path, &e);
        outputs.write(path, |to| report.record().write_csv(to).map_err(failed))?;
    }
    outputs.present(&report)
}

/// The transmission error of a chain.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the chain.
pub fn report<'a>(
    scene: &'a Scene,
    study: &TransmissionStudy,
    quiet: bool,
) -> Result<TransmissionReport<'a>, Error> {
    let machine = PreparedMachine::new(&scene.model)?;
    let result = progress::with_spinner("following the errors", quiet, || solve(&machine, study))?;
    Ok(TransmissionReport {
        scene,
        machine,
        result,
        all: false,
    })
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
