//! `geardyn response`: steady-state response over frequency or speed.

use super::args::ResponseArgs;
use super::present::{self, Outputs};
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::run::{ResponseResult, run as solve};
use crate::report::presentation::StudyReport;
use crate::scene::study::ResponseStudy;
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study: ResponseStudy = scene.study(&args.study.flags)?;
    let outputs = Outputs::check(&args.out, &["", "nyquist"], &[], &scene.files())?;
    let drawn = args.out.svg.is_some();
    let machine = PreparedMachine::new(&scene.model)?;
    let report = report(&scene, &machine, &study, drawn, args.out.quiet)?;
    outputs.present(&report)
}

/// Frequency responses; `drawn`: figures are wanted.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn report<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &ResponseStudy,
    drawn: bool,
    quiet: bool,
) -> Result<StudyReport<'a, ResponseResult>, Error> {
    present::solve(
        (scene, machine),
        "answering by frequency",
        quiet,
        |machine| solve(machine, study, drawn),
    )
}
