//! `geardyn accuracy`: error against run time.

use std::path::PathBuf;

use super::args::{AccuracyArgs, SubjectWord};
use super::files::{self, Files};
use super::{epilogue, interrupt, motion_flags, output};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::stop::Stop;
use crate::plan::motion::scene::MotionScene;
use crate::plan::prepared::Prepared;
use crate::report;
use crate::scene::study::{AccuracyStudy, ResponseStudy, StudyKind, Subject, band};
use crate::scene::{self, Scene};
use crate::study::accuracy::{self, Accuracy};
use crate::study::watch::Watch;
use crate::study::ways::Ways;
use crate::study::{frequencies, responses};

/// The error wanted where nobody says.
const WANTED: f64 = 1e-6;

/// Runs every method and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the motion.
pub fn run(args: &AccuracyArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = study(args, listed(&scene))?;
    let outputs: Vec<PathBuf> = args.csv.iter().chain(&args.svg).cloned().collect();
    let inputs: Vec<PathBuf> = scene.files();
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
    }
    let mut files = Files::new(&outputs, &inputs)?;
    let measured = Measured::new(&scene, &study, args.quiet, &interrupt::stop())?;
    let whole = measured.exit() != interrupt::INTERRUPTED;
    if let Some(path) = args.csv.as_ref().filter(|_| whole) {
        files.write(path, measured.csv().as_bytes())?;
    }
    if let Some(path) = args.svg.as_ref().filter(|_| whole) {
        files.write(path, measured.draw(&scene.model.title).as_bytes())?;
    }
    files.finish()?;
    match args.json {
        true => output::document(&measured.json(&scene))?,
        false => output::print(&measured.text())?,
    }
    if !args.quiet {
        output::tell(measured.epilogue());
        output::tell(&epilogue::not_written(&outputs, whole));
    }
    Ok(measured.exit())
}

/// The study a scene lists with what the flags say put in its place.
fn study(args: &AccuracyArgs, listed: AccuracyStudy) -> Result<AccuracyStudy, Error> {
    let study = AccuracyStudy {
        of: match args.of {
            Some(SubjectWord::Motion) => Subject::Motion,
            Some(SubjectWord::Modes) => Subject::Modes,
            Some(SubjectWord::Response) => Subject::Response,
            None => listed.of,
        },
        lowest: args.lowest.or(listed.lowest),
        response: response(args, listed.response)?,
        motion: motion_flags::study(&args.motion, listed.motion)?,
        methods: if args.methods.is_empty() {
            listed.methods
        } else {
            args.methods.clone()
        },
        wanted: args.error.or(listed.wanted),
    };
    if study.wanted.is_some_and(|x| !(x > 0.0 && x.is_finite())) {
        return Err(
            Error::new(Code::OutOfRange, "--error takes a number above zero")
                .hint("it is relative: 1e-6 is usual"),
        );
    }
    match idle_flag(args, study.of) {
        Some((flag, wants)) => {
            let error = Error::new(Code::Usage, format!("{flag} does nothing here"));
            Err(error.hint(format!("it belongs to {wants}")))
        }
        None => Ok(study),
    }
}

/// What is asked of responses.
fn response(args: &AccuracyArgs, listed: ResponseStudy) -> Result<ResponseStudy, Error> {
    let or = |given: &[String], listed: Vec<String>| match given.is_empty() {
        true => listed,
        false => given.to_vec(),
    };
    let band = args.band.as_deref().map(|text| band(text, "--band"));
    Ok(ResponseStudy {
        inputs: or(&args.input, listed.inputs),
        outputs: or(&args.motion.output, listed.outputs),
        band: band.transpose()?.or(listed.band),
        lines: args.lines.or(listed.lines),
        ..listed
    })
}

/// A flag that was given and belongs to another subject, with the subject.
fn idle_flag(args: &AccuracyArgs, of: Subject) -> Option<(&'static str, &'static str)> {
    const MOTION: &str = "--of motion";
    const RESPONSE: &str = "--of response";
    let how = &args.motion.integration;
    let (moves, answers) = (of == Subject::Motion, of == Subject::Response);
    let given = [
        (
            args.lowest.is_some() && of != Subject::Modes,
            "--lowest",
            "--of modes",
        ),
        (!args.input.is_empty() && !answers, "--input", RESPONSE),
        (args.band.is_some() && !answers, "--band", RESPONSE),
        (args.lines.is_some() && !answers, "--lines", RESPONSE),
        (
            !args.motion.output.is_empty() && of == Subject::Modes,
            "--output",
            RESPONSE,
        ),
        (!args.methods.is_empty() && !moves, "--methods", MOTION),
        (how.until.is_some() && !moves, "--until", MOTION),
        (how.method.is_some() && !moves, "--method", MOTION),
        (how.tolerance.is_some() && !moves, "--tolerance", MOTION),
        (how.step.is_some() && !moves, "--step", MOTION),
        (how.samples.is_some() && !moves, "--samples", MOTION),
    ];
    let idle = given.into_iter().find(|g| g.0);
    idle.map(|(_, flag, wants)| (flag, wants))
}

/// The study of accuracy a scene lists; else the motion it lists.
fn listed(scene: &Scene) -> AccuracyStudy {
    let own = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Accuracy(study) => Some(study.clone()),
        _ => None,
    });
    let motion = || {
        scene.studies.iter().find_map(|study| match &study.kind {
            StudyKind::Simulate(motion) => Some(AccuracyStudy {
                motion: motion.clone(),
                ..AccuracyStudy::default()
            }),
            _ => None,
        })
    };
    own.or_else(motion).unwrap_or_default()
}

/// A study of accuracy with all that is said of it.
pub struct Measured {
    wanted: f64,
    found: Found,
}

enum Found {
    Motion {
        accuracy: Accuracy,
        outputs: Vec<String>,
    },
    Ways(Ways),
}

impl Measured {
    /// Prepares and runs every method.
    ///
    /// # Errors
    /// Whatever is wrong with the machine or the methods.
    pub fn new(
        scene: &Scene,
        study: &AccuracyStudy,
        quiet: bool,
        stop: &Stop,
    ) -> Result<Measured, Error> {
        let mut watch = Watch {
            stop,
            hear: &mut |what| output::working(what, quiet),
        };
        let found = match study.of {
            Subject::Modes => {
                let count = study.lowest.map_or(frequencies::USUAL, |n| n as usize);
                Found::Ways(frequencies::study(&scene.model, count, &mut watch)?)
            }
            Subject::Response => {
                let prepared = Prepared::new(&scene.model)?;
                Found::Ways(responses::study(&prepared, &study.response, &mut watch)?)
            }
            Subject::Motion => {
                let prepared = Prepared::new(&scene.model)?;
                let ready = MotionScene::new(&prepared, &scene.start, &study.motion)?;
                Found::Motion {
                    accuracy: accuracy::study(
                        &ready,
                        &study.methods,
                        accuracy::PATIENCE,
                        &mut watch,
                    )?,
                    outputs: ready.outputs.list.iter().map(|o| o.name.clone()).collect(),
                }
            }
        };
        Ok(Measured {
            wanted: study.wanted.unwrap_or(WANTED),
            found,
        })
    }

    /// The table.
    pub fn text(&self) -> String {
        match &self.found {
            Found::Motion { accuracy, outputs } => {
                report::accuracy_table::table(outputs, accuracy, self.wanted)
            }
            Found::Ways(found) => report::ways_table::table(found, self.wanted),
        }
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        match &self.found {
            Found::Motion { accuracy, outputs } => {
                report::accuracy::json(&scene.sources, outputs, accuracy, self.wanted)
            }
            Found::Ways(found) => report::ways::json(&scene.sources, found, self.wanted),
        }
    }

    /// What is said where it ended early.
    pub fn epilogue(&self) -> &'static str {
        match self.exit() {
            interrupt::INTERRUPTED => "interrupted: what is shown was finished before\n",
            _ => "",
        }
    }

    /// How the command ends.
    pub fn exit(&self) -> u8 {
        let interrupted = match &self.found {
            Found::Motion { accuracy, .. } => accuracy.interrupted,
            Found::Ways(found) => found.interrupted,
        };
        match interrupted {
            true => interrupt::INTERRUPTED,
            false => 0,
        }
    }

    fn csv(&self) -> String {
        match &self.found {
            Found::Motion { accuracy, .. } => report::accuracy::csv(accuracy),
            Found::Ways(found) => report::ways::csv(found),
        }
    }

    fn draw(&self, title: &str) -> String {
        match &self.found {
            Found::Motion { accuracy, .. } => report::accuracy::draw(title, accuracy),
            Found::Ways(found) => report::ways::draw(title, found),
        }
    }
}
