//! `geardyn response --harmonic-balance`: periodic motions over speed.

use super::args::ResponseArgs;
use super::present::{self, Outputs};
use super::progress;
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::harmonic_balance::{HarmonicBalanceResult, run as solve};
use crate::report::presentation::StudyReport;
use crate::scene::study::HarmonicBalanceStudy;
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study: HarmonicBalanceStudy = scene.study(&args.study.flags)?;
    let outputs = Outputs::check(&args.out, &[""], &[], &scene.files())?;
    let machine = PreparedMachine::new(&scene.model)?;
    let quiet = args.out.quiet || args.out.json;
    let report = report(&scene, &machine, &study, quiet)?;
    outputs.present(&report)
}

/// Periodic motions over speed.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn report<'a>(
    scene: &'a Scene,
    machine: &'a PreparedMachine,
    study: &HarmonicBalanceStudy,
    quiet: bool,
) -> Result<StudyReport<'a, HarmonicBalanceResult>, Error> {
    let bar = progress::progress_bar("following the curve", quiet);
    let report = present::solve((scene, machine), "", true, |machine| {
        solve(machine, study, &mut |share| bar(Some(share)))
    });
    bar(None);
    report
}
