//! `geardyn simulate`: motion in time.

use super::args::{OnlineArgs, SimulateArgs};
use super::present::Outputs;
use super::{interrupt, progress, simulate_study};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::plan::simulate::SimulationResult;
use crate::report::simulation::SimulationReport;
use crate::scene::study::{
    self, BLOCK_SIZES, OnlineStudy, OrderTrackingStudy, SimulateStudy, StudyKind,
};
use crate::scene::{self, Scene};

/// Integrates and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the motion.
pub fn run(args: &SimulateArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Simulate(motion) => Some((motion.clone(), &study.span)),
        _ => None,
    });
    let (listed, place) = listed.unzip();
    let study = simulate_study::from_args(&args.motion, listed.unwrap_or_default())?;
    let study = SimulateStudy {
        energy: study.energy || args.energy,
        time_limit: simulate_study::parse_time(&args.allow, "--allow")?.or(study.time_limit),
        no_sensitivity: study.no_sensitivity || args.no_sensitivity,
        running: online_from_args(&args.running, study.running)?,
        ..study
    };
    if !study.running.history && (args.out.csv.is_some() || args.out.svg.is_some()) {
        let error = Error::new(
            Code::Conflict,
            "the study keeps no history, and --csv and --svg are of it",
        );
        return Err(error
            .with_hint("leave history = \"none\" out of the study, or the flags")
            .into());
    }
    let outputs = Outputs::check(&args.out, &[""], &[], &scene.files())?;
    let report = report(&scene, &study, args.out.quiet)
        .map_err(|e| simulate_study::with_study_span(e, &args.motion, place))?;
    outputs.present(&report)
}

/// The motion; at a terminal it says how far it is.
///
/// # Errors
/// Whatever is wrong with the machine or the motion.
pub fn report<'a>(
    scene: &'a Scene,
    study: &SimulateStudy,
    quiet: bool,
) -> Result<SimulationReport<'a>, Error> {
    let bar = progress::progress_bar("integrating", quiet);
    let cancel = interrupt::cancel_on_ctrl_c();
    let result = SimulationResult::simulate(scene, study, &cancel, &|share| bar(Some(share)));
    bar(None);
    let result = result?;
    Ok(SimulationReport { scene, result })
}

/// What is found while the motion runs: that of the study with what the flags say put in its place.
fn online_from_args(args: &OnlineArgs, listed: OnlineStudy) -> Result<OnlineStudy, Error> {
    if args.spectrum.is_some_and(|n| !BLOCK_SIZES.contains(&n)) {
        let message = format!(
            "--spectrum takes a block of {} to {} samples",
            BLOCK_SIZES.start(),
            BLOCK_SIZES.end()
        );
        return Err(Error::new(Code::OutOfRange, message).with_hint("4096 is usual"));
    }
    if args.turns == Some(0) {
        return Err(
            Error::new(Code::OutOfRange, "--turns takes a count of at least 1")
                .with_hint("with 8 turns orders a quarter apart are told from each other; more tell nearer ones apart"),
        );
    }
    let track = args
        .track
        .as_deref()
        .map(|t| OrderTrackingStudy::parse(t, "--track"));
    let te = args
        .te
        .as_deref()
        .map(|t| study::parse_shaft_pair(t, "--te"));
    Ok(OnlineStudy {
        history: listed.history && !args.no_history,
        spectrum: args.spectrum.or(listed.spectrum),
        track: track.transpose()?.or(listed.track),
        turns: args.turns.unwrap_or(listed.turns),
        te: te.transpose()?.or(listed.te),
        teeth: args.teeth.clone().or(listed.teeth),
    })
}
