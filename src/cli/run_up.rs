//! `geardyn response --run-up`: response to all orders over speed.

use super::args::ResponseArgs;
use super::present::{self, Outputs};
use crate::base::error::{Error, Errors};
use crate::plan::response::run_up::{RunUpResult, run as solve};
use crate::report::presentation::StudyReport;
use crate::scene::study::{RunUpStudy, SpeedRange, StudyKind};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = study_from_args(args, &scene)?;
    let outputs = Outputs::check(&args.out, &[""], &[], &scene.files())?;
    let report = report(&scene, &study, args.out.quiet || args.out.json)?;
    outputs.present(&report)
}

/// The response over speed.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn report<'a>(
    scene: &'a Scene,
    study: &RunUpStudy,
    quiet: bool,
) -> Result<StudyReport<'a, RunUpResult>, Error> {
    present::solve(scene, "answering every order", quiet, |machine| {
        solve(machine, study)
    })
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn study_from_args(args: &ResponseArgs, scene: &Scene) -> Result<RunUpStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::RunUp(study) => Some(study.clone()),
        _ => None,
    });
    let listed = listed.unwrap_or_default();
    let speeds = args
        .run_up
        .as_deref()
        .map(|text| SpeedRange::parse(text, "--run-up"))
        .transpose()?;
    let or = |given: &Vec<String>, listed: Vec<String>| {
        if given.is_empty() {
            listed
        } else {
            given.clone()
        }
    };
    Ok(RunUpStudy {
        speeds: speeds.or(listed.speeds),
        outputs: or(&args.output, listed.outputs),
        fixed_dofs: or(&args.hold, listed.fixed_dofs),
    })
}
