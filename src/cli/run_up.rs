//! `geardyn response --run-up`: response to all orders over speed.

use super::args::ResponseArgs;
use super::present::{self, Outputs};
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::run_up::{RunUpResult, run as solve};
use crate::report::presentation::StudyReport;
use crate::scene::study::RunUpStudy;
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study: RunUpStudy = scene.study(&args.study.flags)?;
    let outputs = Outputs::check(&args.out, &[""], &[], &scene.files())?;
    let machine = PreparedMachine::new(&scene.model)?;
    let quiet = args.out.quiet || args.out.json;
    let report = report(&scene, &machine, &study, quiet)?;
    outputs.present(&report)
}

/// The response over speed.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn report<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &RunUpStudy,
    quiet: bool,
) -> Result<StudyReport<'a, RunUpResult>, Error> {
    present::solve(
        (scene, machine),
        "answering every order",
        quiet,
        |machine| solve(machine, study),
    )
}
