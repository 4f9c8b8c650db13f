//! `geardyn accuracy`: error against run time.

use std::path::PathBuf;

use super::args::AccuracyArgs;
use super::{motion_flags, output};
use crate::base::error::{Error, Errors};
use crate::plan::motion::scene::MotionScene;
use crate::plan::prepared::Prepared;
use crate::report;
use crate::scene::study::{AccuracyStudy, StudyKind};
use crate::scene::{self, Scene};
use crate::study::accuracy::{self, Accuracy};

/// The error wanted where nobody says.
const WANTED: f64 = 1e-6;

/// Runs every method and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the motion.
pub fn run(args: &AccuracyArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let listed = listed(&scene);
    let study = AccuracyStudy {
        motion: motion_flags::study(&args.motion, listed.motion)?,
        methods: if args.methods.is_empty() {
            listed.methods
        } else {
            args.methods.clone()
        },
        wanted: args.error.or(listed.wanted),
    };
    let outputs: Vec<PathBuf> = args.csv.iter().chain(&args.svg).cloned().collect();
    let inputs: Vec<PathBuf> = scene
        .sources
        .iter()
        .map(|source| PathBuf::from(&source.path))
        .collect();
    output::check(&outputs, &inputs)?;
    if let Some(path) = &args.svg {
        output::ends(path, &["svg"])?;
    }
    let measured = Measured::new(&scene, &study, args.quiet)?;
    if let Some(path) = &args.csv {
        output::write(path, report::accuracy::csv(&measured.accuracy).as_bytes())?;
    }
    if let Some(path) = &args.svg {
        output::write(
            path,
            report::accuracy::draw(&scene.model.title, &measured.accuracy).as_bytes(),
        )?;
    }
    match args.json {
        true => output::print(&format!("{:#}\n", measured.json(&scene)))?,
        false => output::print(&measured.text())?,
    }
    Ok(0)
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
    accuracy: Accuracy,
    outputs: Vec<String>,
    wanted: f64,
}

impl Measured {
    /// Prepares and runs every method.
    ///
    /// # Errors
    /// Whatever is wrong with the machine or the methods.
    pub fn new(scene: &Scene, study: &AccuracyStudy, quiet: bool) -> Result<Measured, Error> {
        let prepared = Prepared::new(&scene.model)?;
        let ready = MotionScene::new(&prepared, &scene.start, &study.motion)?;
        let accuracy = accuracy::study(&ready, &study.methods, &mut |what| progress(what, quiet))?;
        let outputs = ready.outputs.list.iter().map(|o| o.name.clone()).collect();
        Ok(Measured {
            accuracy,
            outputs,
            wanted: study.wanted.unwrap_or(WANTED),
        })
    }

    /// The table.
    pub fn text(&self) -> String {
        report::accuracy_table::table(&self.outputs, &self.accuracy, self.wanted)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::accuracy::json(&scene.sources, &self.outputs, &self.accuracy, self.wanted)
    }
}

/// Says on a terminal what is running.
fn progress(what: &str, quiet: bool) {
    use std::io::IsTerminal;
    if !quiet && std::io::stderr().is_terminal() {
        output::tell(&format!("\r\x1b[K{what} …\r"));
    }
}
