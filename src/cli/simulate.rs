//! `geardyn simulate`: motion in time.

use std::path::PathBuf;

use serde_json::Value;

use super::args::{RunningArgs, SimulateArgs};
use super::files::{self, Files};
use super::{epilogue, interrupt, motion_flags, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::stop::Stop;
use crate::plan::simulate::Moved;
use crate::report;
use crate::scene::study::{self, BLOCKS, RunningStudy, SimulateStudy, StudyKind, TrackStudy};
use crate::scene::{self, Scene};

/// Integrates and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the motion.
pub fn run(args: &SimulateArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Simulate(motion) => Some((motion.clone(), &study.place)),
        _ => None,
    });
    let (listed, place) = listed.unzip();
    let study = motion_flags::study(&args.motion, listed.unwrap_or_default())?;
    let study = SimulateStudy {
        energy: study.energy || args.energy,
        allow: motion_flags::time(&args.allow, "--allow")?.or(study.allow),
        no_sensitivity: study.no_sensitivity || args.no_sensitivity,
        running: running(&args.running, study.running)?,
        ..study
    };
    if !study.running.history && (args.csv.is_some() || args.svg.is_some()) {
        let error = Error::new(
            Code::Conflict,
            "the study keeps no history, and --csv and --svg are of it",
        );
        return Err(error
            .hint("leave history = \"none\" out of the study, or the flags")
            .into());
    }
    let outputs: Vec<PathBuf> = args.csv.iter().chain(&args.svg).cloned().collect();
    let inputs: Vec<PathBuf> = scene.files();
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
    }
    let mut files = Files::new(&outputs, &inputs)?;
    let moved = moved(&scene, &study, &interrupt::stop(), args.quiet)
        .map_err(|e| motion_flags::placed(e, &args.motion, place))?;
    let whole = !moved.motion.interrupted;
    if let Some(path) = args.csv.as_ref().filter(|_| whole) {
        let text = report::motion::csv(&moved.scene, &moved.motion);
        files.write(path, text.as_bytes())?;
    }
    if let Some(path) = args.svg.as_ref().filter(|_| whole) {
        let picture = report::motion::draw(&scene.model.title, &moved.scene, &moved.motion);
        files.write(path, picture.as_bytes())?;
    }
    let written = files.finish()?;
    match args.json {
        true => output::document(&json(&moved, &scene))?,
        false => output::print(&text(&moved))?,
    }
    if !args.quiet {
        output::tell(&epilogue(&moved));
        output::tell(&epilogue::written(&written));
        output::tell(&epilogue::not_written(&outputs, whole));
    }
    Ok(exit(&moved))
}

/// Integrates; at a terminal it says how far the motion is.
///
/// # Errors
/// Whatever is wrong with the machine or the motion.
pub fn moved(
    scene: &Scene,
    study: &SimulateStudy,
    stop: &Stop,
    quiet: bool,
) -> Result<Moved, Error> {
    let bar = progress::share("integrating", quiet);
    let moved = Moved::new(scene, study, stop, &|share| bar(Some(share)));
    bar(None);
    moved
}

/// What is found while the motion runs: that of the study with what the flags say put in its place.
fn running(args: &RunningArgs, listed: RunningStudy) -> Result<RunningStudy, Error> {
    if args.spectrum.is_some_and(|n| !BLOCKS.contains(&n)) {
        let message = format!(
            "--spectrum takes a block of {} to {} samples",
            BLOCKS.start(),
            BLOCKS.end()
        );
        return Err(Error::new(Code::OutOfRange, message).hint("4096 is usual"));
    }
    if args.turns == Some(0) {
        return Err(
            Error::new(Code::OutOfRange, "--turns takes a count of at least 1")
                .hint("with 8 turns orders a quarter apart are told from each other; more tell nearer ones apart"),
        );
    }
    let track = args
        .track
        .as_deref()
        .map(|t| TrackStudy::parse(t, "--track"));
    let te = args.te.as_deref().map(|t| study::shafts(t, "--te"));
    Ok(RunningStudy {
        history: listed.history && !args.no_history,
        spectrum: args.spectrum.or(listed.spectrum),
        track: track.transpose()?.or(listed.track),
        turns: args.turns.unwrap_or(listed.turns),
        te: te.transpose()?.or(listed.te),
        teeth: args.teeth.clone().or(listed.teeth),
    })
}

/// The tables.
pub fn text(moved: &Moved) -> String {
    let sensitivity = moved.sensitivity.as_ref();
    let mut text = report::motion_table::readings(&moved.scene, &moved.motion, sensitivity);
    if let Some(sensitivity) = sensitivity {
        text += &report::sensitivity_table::text(&moved.scene, sensitivity);
    }
    text += &report::on_the_fly_table::text(&moved.scene, &moved.found);
    if let Some(at) = moved.step_at.filter(|_| !moved.motion.time.is_empty()) {
        text += &report::motion_table::steps(&moved.scene, &moved.motion, at);
    }
    text
}

/// The document.
pub fn json(moved: &Moved, scene: &Scene) -> Value {
    let mut document = report::motion::json(
        &scene.sources,
        &moved.scene,
        &moved.choice,
        &moved.motion,
        moved.step_at,
        &moved.warnings,
    );
    document["title"] = scene.model.title.as_str().into();
    report::sensitivity::extend(&mut document, &moved.scene, moved.sensitivity.as_ref());
    report::on_the_fly::extend(&mut document, &moved.scene, &moved.found);
    document
}

/// What was done and left out, what it cost, doubts.
pub fn epilogue(moved: &Moved) -> String {
    let mut text = String::from("\n");
    text += &epilogue::steps(&moved.plan);
    text += &report::motion_table::effort(&moved.motion);
    if let Some(sensitivity) = &moved.sensitivity {
        text += &report::sensitivity_table::effort(sensitivity);
    }
    if let Some(balance) = &moved.motion.balance {
        text += &report::motion_table::balance(balance);
    }
    text += &epilogue::warnings(&moved.warnings);
    if moved.motion.interrupted {
        let end = crate::base::units::seconds(moved.motion.reached);
        text += &format!("interrupted at t = {end}: what is shown ends there\n");
    }
    text
}

/// How the command ends.
pub fn exit(moved: &Moved) -> u8 {
    match moved.motion.interrupted {
        true => interrupt::INTERRUPTED,
        false => 0,
    }
}
