//! `geardyn te`: transmission error of a chain.

use super::args::TeArgs;
use super::present::Outputs;
use super::{destination, progress, te_log};
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::transmission::run::run as solve;
use crate::report::transmission::TransmissionReport;
use crate::scene::study::TransmissionStudy;
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the chain.
pub fn run(args: &TeArgs) -> Result<u8, Errors> {
    if te_log::is_log(args) {
        return te_log::run(args);
    }
    let scene = scene::read(&args.file)?;
    let study: TransmissionStudy = scene.study(&args.study.flags)?;
    let record = &args.study.file("record");
    let model = &scene.model;
    let cuts = model.work.is_some() || model.gear_pairs.iter().any(|p| p.cut_on.is_some());
    let mut figures = vec!["", "budget"];
    figures.extend(study.speeds.is_some().then_some("speeds"));
    figures.extend(cuts.then_some("flank"));
    let mut outputs = Outputs::check(&args.out, &figures, &[record], &scene.files())?;
    let machine = PreparedMachine::new(&scene.model)?;
    let mut report = report(&scene, &machine, &study, args.out.quiet)?;
    report.all = args.all;
    if let Some(path) = record {
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
    machine: &'a PreparedMachine,
    study: &TransmissionStudy,
    quiet: bool,
) -> Result<TransmissionReport<'a>, Error> {
    let result = progress::with_spinner("transmission error", quiet, || solve(machine, study))?;
    Ok(TransmissionReport {
        scene,
        machine,
        result,
        all: false,
    })
}
