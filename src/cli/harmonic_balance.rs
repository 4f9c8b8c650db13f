//! `geardyn response --harmonic-balance`: periodic motions over speed.

use super::args::ResponseArgs;
use super::present::{self, Outputs};
use super::progress;
use crate::base::error::{Error, Errors};
use crate::plan::response::harmonic_balance::{HarmonicBalanceResult, run as solve};
use crate::report::presentation::StudyReport;
use crate::scene::study::{HarmonicBalanceStudy, SpeedRange, StudyKind};
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

/// Periodic motions over speed.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn report<'a>(
    scene: &'a Scene,
    study: &HarmonicBalanceStudy,
    quiet: bool,
) -> Result<StudyReport<'a, HarmonicBalanceResult>, Error> {
    let bar = progress::progress_bar("following the curve", quiet);
    let report = present::solve(scene, "", true, |machine| {
        solve(machine, study, &mut |share| bar(Some(share)))
    });
    bar(None);
    report
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn study_from_args(args: &ResponseArgs, scene: &Scene) -> Result<HarmonicBalanceStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::HarmonicBalance(study) => Some(study.clone()),
        _ => None,
    });
    let listed = listed.unwrap_or_default();
    let speeds = args
        .harmonic_balance
        .as_deref()
        .map(|text| SpeedRange::parse(text, "--harmonic-balance"))
        .transpose()?;
    Ok(HarmonicBalanceStudy {
        speeds: speeds.or(listed.speeds),
        outputs: if args.output.is_empty() {
            listed.outputs
        } else {
            args.output.clone()
        },
        tolerance: args.tolerance.or(listed.tolerance),
        orders: args.orders.or(listed.orders),
        skip_event_refinement: args.orders_alone || listed.skip_event_refinement,
    })
}
