//! `geardyn simulate`: motion in time.

use std::path::PathBuf;

use serde_json::Value;

use super::args::{OnlineArgs, SimulateArgs};
use super::files::{self, OutputFiles};
use super::{footer, interrupt, output, progress, simulate_study};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::time_budget::CancelToken;
use crate::plan::simulate::SimulationResult;
use crate::report;
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
    let outputs: Vec<PathBuf> = args.out.csv.iter().chain(&args.out.svg).cloned().collect();
    let inputs: Vec<PathBuf> = scene.files();
    if let Some(path) = &args.out.svg {
        files::ends(path, &["svg"])?;
    }
    let mut files = OutputFiles::new(&outputs, &inputs)?;
    let result = simulate(
        &scene,
        &study,
        &interrupt::cancel_on_ctrl_c(),
        args.out.quiet,
    )
    .map_err(|e| simulate_study::with_study_span(e, &args.motion, place))?;
    let whole = !result.history.interrupted;
    if let Some(path) = args.out.csv.as_ref().filter(|_| whole) {
        let text = report::simulation::csv(&result.scene, &result.history);
        files.write(path, text.as_bytes())?;
    }
    if let Some(path) = args.out.svg.as_ref().filter(|_| whole) {
        let plot = report::simulation::draw(&scene.model.title, &result.scene, &result.history);
        files.write(path, plot.as_bytes())?;
    }
    let written = files.finish()?;
    match args.out.json {
        true => output::document(&json(&result, &scene))?,
        false => output::print(&text(&result))?,
    }
    if !args.out.quiet {
        output::print_note(&epilogue(&result));
        output::print_note(&footer::written_files(&written));
        output::print_note(&footer::not_written(&outputs, whole));
    }
    Ok(exit_code(&result))
}

/// Integrates; at a terminal it says how far the motion is.
///
/// # Errors
/// Whatever is wrong with the machine or the motion.
pub fn simulate(
    scene: &Scene,
    study: &SimulateStudy,
    cancel: &CancelToken,
    quiet: bool,
) -> Result<SimulationResult, Error> {
    let bar = progress::progress_bar("integrating", quiet);
    let moved = SimulationResult::simulate(scene, study, cancel, &|share| bar(Some(share)));
    bar(None);
    moved
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

/// The tables.
pub fn text(result: &SimulationResult) -> String {
    let sensitivity = result.sensitivity.as_ref();
    let mut text =
        report::simulation_table::output_statistics(&result.scene, &result.history, sensitivity);
    if let Some(sensitivity) = sensitivity {
        text += &report::sensitivity_table::text(&result.scene, sensitivity);
    }
    text += &report::online_table::text(&result.scene, &result.online);
    if let Some(at) = result
        .step_time_s
        .filter(|_| !result.history.time.is_empty())
    {
        text += &report::simulation_table::step_responses(&result.scene, &result.history, at);
    }
    text
}

/// The document.
pub fn json(result: &SimulationResult, scene: &Scene) -> Value {
    let mut document = report::simulation::json(
        &scene.sources,
        &result.scene,
        &result.choice,
        &result.history,
        result.step_time_s,
        &result.diagnostics,
    );
    document["title"] = scene.model.title.as_str().into();
    report::sensitivity::extend(&mut document, &result.scene, result.sensitivity.as_ref());
    report::online::extend(&mut document, &result.scene, &result.online);
    document
}

/// What was done and left out, what it cost, warnings.
pub fn epilogue(result: &SimulationResult) -> String {
    let mut text = String::from("\n");
    text += &footer::plan_steps(&result.plan);
    text += &report::simulation_table::effort(&result.history);
    if let Some(sensitivity) = &result.sensitivity {
        text += &report::sensitivity_table::effort(sensitivity);
    }
    if let Some(balance) = &result.history.balance {
        text += &report::simulation_table::balance(balance);
    }
    text += &footer::warnings(&result.diagnostics);
    if result.history.interrupted {
        let end = crate::base::quantity::format_time(result.history.end_time);
        text += &format!("interrupted at t = {end}: what is shown ends there\n");
    }
    text
}

/// How the command ends.
pub fn exit_code(result: &SimulationResult) -> u8 {
    match result.history.interrupted {
        true => interrupt::EXIT_INTERRUPTED,
        false => 0,
    }
}
