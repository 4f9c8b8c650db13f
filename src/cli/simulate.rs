//! `geardyn simulate`: motion in time.

use std::path::PathBuf;

use serde_json::Value;

use super::args::{RunningArgs, SimulateArgs};
use super::{epilogue, interrupt, motion_flags, output};
use crate::base::code::Code;
use crate::base::error::{Error, Errors, Warning};
use crate::base::stop::Stop;
use crate::plan::motion::choice::{self, Choice};
use crate::plan::motion::run::{self, Motion};
use crate::plan::motion::scene::MotionScene;
use crate::plan::on_the_fly::{Found, OnTheFly};
use crate::plan::prepared::Prepared;
use crate::plan::stages::Verdict;
use crate::report;
use crate::scene::laws::History;
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
    output::check(&outputs, &inputs)?;
    if let Some(path) = &args.svg {
        output::ends(path, &["svg"])?;
    }
    let moved = Moved::new(&scene, &study, &interrupt::stop())
        .map_err(|e| motion_flags::placed(e, &args.motion, place))?;
    let mut written = Vec::new();
    if let Some(path) = &args.csv {
        output::write(
            path,
            report::motion::csv(&moved.scene, &moved.motion).as_bytes(),
        )?;
        written.push(path.display().to_string());
    }
    if let Some(path) = &args.svg {
        output::write(
            path,
            report::motion::draw(&scene.model.title, &moved.scene, &moved.motion).as_bytes(),
        )?;
        written.push(path.display().to_string());
    }
    match args.json {
        true => output::print(&format!("{:#}\n", moved.json(&scene)))?,
        false => output::print(&moved.text())?,
    }
    if !args.quiet {
        output::tell(&moved.epilogue());
        output::tell(&epilogue::written(&written));
    }
    Ok(moved.exit())
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
                .hint("8 parts orders a quarter apart"),
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

/// A motion with all that is said of it.
pub struct Moved {
    scene: MotionScene,
    choice: Choice,
    motion: Motion,
    found: Found,
    plan: Vec<(&'static str, Verdict)>,
    step_at: Option<f64>,
    warnings: Vec<Warning>,
}

impl Moved {
    /// Prepares, chooses, integrates.
    ///
    /// # Errors
    /// Whatever is wrong with the machine or the motion.
    pub fn new(scene: &Scene, study: &SimulateStudy, stop: &Stop) -> Result<Moved, Error> {
        let prepared = Prepared::new(&scene.model)?;
        let ready = MotionScene::new(&prepared, &scene.start, study)?;
        let mut choice = choice::choose(&ready.moving.train, study)?;
        let mut handed_over = None;
        let run = |choice: &Choice| {
            let mut seen = OnTheFly::new(&prepared, &ready, &study.running)?;
            let mut watch = |at: (f64, &[f64]), values: &[f64]| seen.watch(&ready, at, values);
            let kept = (study.running.history, &mut watch as &mut run::Watch);
            let motion = run::watched(&ready, choice, study.energy, stop, kept)?;
            let found = seen.finish(motion.interrupted)?;
            Ok::<_, Error>((motion, found))
        };
        let (motion, found) = match run(&choice) {
            Ok(done) => done,
            Err(error) => {
                let next = choice::successor(&ready.moving.train, study, &choice, &error);
                let Some(next) = next else { return Err(error) };
                let message = format!(
                    "{}: {}; {} took the motion from its start",
                    choice.method.name, error.message, next.method.name
                );
                handed_over = Some(Warning {
                    code: "handed-over",
                    message,
                    hint: error.hint,
                });
                choice = next;
                run(&choice)?
            }
        };
        let plan = choice::plan(&ready, &choice, study);
        let step_at = only_step(scene).filter(|t| *t < ready.until);
        // What is said of the operating point belongs to linear studies.
        let warnings = prepared
            .warnings()
            .into_iter()
            .filter(|w| !["no-load", "contact-open", "loads-accelerate"].contains(&w.code))
            .chain(handed_over)
            .chain(found.warnings.clone());
        Ok(Moved {
            scene: ready,
            choice,
            motion,
            found,
            plan,
            step_at,
            warnings: warnings.collect(),
        })
    }

    /// The tables.
    pub fn text(&self) -> String {
        let mut text = report::motion_table::readings(&self.scene, &self.motion);
        text += &report::on_the_fly_table::text(&self.scene, &self.found);
        if let Some(at) = self.step_at.filter(|_| !self.motion.time.is_empty()) {
            text += &report::motion_table::steps(&self.scene, &self.motion, at);
        }
        text
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> Value {
        let mut document = report::motion::json(
            &scene.sources,
            &self.scene,
            &self.choice,
            &self.motion,
            self.step_at,
            &self.warnings,
        );
        report::on_the_fly::extend(&mut document, &self.scene, &self.found);
        document
    }

    /// What was done and left out, what it cost, doubts.
    pub fn epilogue(&self) -> String {
        let mut text = String::from("\n");
        text += &epilogue::steps(&self.plan);
        text += &report::motion_table::effort(&self.motion);
        if let Some(balance) = &self.motion.balance {
            text += &report::motion_table::balance(balance);
        }
        text += &epilogue::warnings(&self.warnings);
        if self.motion.interrupted {
            let end = self.motion.reached;
            text += &format!("interrupted at {end} s: what is shown ends there\n");
        }
        text
    }

    /// How the command ends.
    pub fn exit(&self) -> u8 {
        match self.motion.interrupted {
            true => interrupt::INTERRUPTED,
            false => 0,
        }
    }
}

/// The instant of the one step among the loads: the answer to it can be read off.
fn only_step(scene: &Scene) -> Option<f64> {
    let steps = scene
        .model
        .loads
        .iter()
        .filter_map(|load| match load.history {
            History::Step { time, .. } => Some(time),
            _ => None,
        });
    let mut instants: Vec<f64> = steps.collect();
    instants.dedup();
    match instants[..] {
        [at] if at >= 0.0 => Some(at),
        _ => None,
    }
}
