//! `geardyn response`: steady-state response over frequency, orders over speed, periodic motions over speed.

use super::args::ResponseArgs;
use super::present::{self, Outputs};
use super::progress;
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::harmonic_balance::{self, HarmonicBalanceResult};
use crate::plan::response::run::{self, ResponseResult};
use crate::plan::response::run_up::{self, RunUpResult};
use crate::report::presentation::StudyReport;
use crate::scene::study::{HarmonicBalanceStudy, ResponseStudy, RunUpStudy};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let (flags, quiet) = (&args.study.flags, args.out.quiet || args.out.json);
    let outputs = |figures: &[&str]| Outputs::check(&args.out, figures, &[], &scene.files());
    let machine = || PreparedMachine::new(&scene.model);
    if args.study.has("harmonic-balance") {
        let (study, outputs, machine) = (scene.study(flags)?, outputs(&[""])?, machine()?);
        outputs.present(&periodic(&scene, &machine, &study, quiet)?)
    } else if args.study.has("run-up") {
        let (study, outputs, machine) = (scene.study(flags)?, outputs(&[""])?, machine()?);
        outputs.present(&over_speed(&scene, &machine, &study, quiet)?)
    } else {
        let figures = &["", "nyquist"];
        let (study, outputs, machine) = (scene.study(flags)?, outputs(figures)?, machine()?);
        let drawn = outputs.shows_figures();
        outputs.present(&over_frequency(&scene, &machine, &study, drawn, quiet)?)
    }
}

/// Frequency responses; `drawn`: figures are wanted.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn over_frequency<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &ResponseStudy,
    drawn: bool,
    quiet: bool,
) -> Result<StudyReport<'a, ResponseResult>, Error> {
    let solve = |machine: &PreparedMachine| run::run(machine, study, drawn);
    present::solve((scene, machine), "computing responses", quiet, solve)
}

/// Orders over speed.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn over_speed<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &RunUpStudy,
    quiet: bool,
) -> Result<StudyReport<'a, RunUpResult>, Error> {
    let solve = |machine: &PreparedMachine| run_up::run(machine, study);
    present::solve((scene, machine), "computing order responses", quiet, solve)
}

/// Periodic motions over speed.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn periodic<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &HarmonicBalanceStudy,
    quiet: bool,
) -> Result<StudyReport<'a, HarmonicBalanceResult>, Error> {
    let bar = progress::progress_bar("continuing the curve", quiet);
    let report = present::solve((scene, machine), "", true, |machine| {
        harmonic_balance::run(machine, study, &mut |share| bar(Some(share)))
    });
    bar(None);
    report
}
