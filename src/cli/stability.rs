//! `geardyn stability`: where methods and machine break.

use std::path::PathBuf;

use super::args::StabilityArgs;
use super::files::{self, Files};
use super::{epilogue, interrupt, motion_flags, output};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::stop::Stop;
use crate::plan::motion::choice;
use crate::plan::motion::scene::MotionScene;
use crate::plan::prepared::Prepared;
use crate::report;
use crate::report::stability::Stability;
use crate::scene::study::{Over, SimulateStudy, SpeedRange, StabilityStudy, StudyKind};
use crate::scene::{self, Scene};
use crate::study::parametric;
use crate::study::stability::amplification::Spectrum;
use crate::study::stability::extremes::{self, Methods, Verdict};
use crate::study::stability::{amplification, cases, facts};
use crate::study::watch::{Watch, interrupted};

/// Studies and prints; ends with 1 where a case failed.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the machine.
pub fn run(args: &StabilityArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let listed = listed(&scene);
    let speeds = args
        .speeds
        .as_deref()
        .map(|text| SpeedRange::parse(text, "--speeds"))
        .transpose()?;
    let over = args
        .over
        .as_deref()
        .map(|text| Over::parse(text, "--over"))
        .transpose()?;
    let study = StabilityStudy {
        motion: motion_flags::study(&args.motion, listed.motion)?,
        methods: if args.methods.is_empty() {
            listed.methods
        } else {
            args.methods.clone()
        },
        speeds: speeds.or(listed.speeds),
        over: over.or(listed.over),
    };
    if study.over.is_some() && study.speeds.is_none() {
        let error = Error::new(
            Code::Usage,
            "a second axis needs a first: `over` goes with speeds",
        );
        return Err(error.hint("add --speeds FIRST:LAST:POINTS").into());
    }
    let inputs: Vec<PathBuf> = scene.files();
    let mut outputs: Vec<PathBuf> = args.svg.iter().cloned().collect();
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
        outputs.extend(study.over.map(|_| files::beside(path, "chart")));
    }
    let mut files = Files::new(&outputs, &inputs)?;
    let found = study_of(&scene, &study, args.json, &interrupt::stop())?;
    if let Some(path) = args.svg.as_ref().filter(|_| !found.interrupted) {
        let shortest = found
            .facts
            .limits
            .iter()
            .map(|l| l.1)
            .fold(f64::INFINITY, f64::min);
        let usual = if shortest.is_finite() { shortest } else { 1.0 };
        let step = study.motion.step.unwrap_or(usual);
        let spectrum = Spectrum::new(&found.facts.eigenvalues, step)?;
        let picture = report::regions::regions(&scene.model.title, &found.facts, &spectrum);
        files.write(path, picture.as_bytes())?;
        let charted = found.floquet.as_ref().ok();
        if let Some((chart, speed)) = charted.and_then(|p| Some((p.chart.as_ref()?, p.speed)))
            && chart.over.is_some()
        {
            let picture = report::stability::chart(&scene.model.title, chart, speed);
            files.write(&files::beside(path, "chart"), picture.as_bytes())?;
        }
    }
    files.finish()?;
    match args.json {
        true => output::document(&report::stability::json(&scene.sources, &found))?,
        false => output::print(&report::stability_table::table(&found))?,
    }
    output::tell(&epilogue(&found));
    output::tell(&epilogue::not_written(&outputs, !found.interrupted));
    Ok(exit(&found))
}

/// Warnings, and what is said where the study ended early.
pub fn epilogue(found: &Stability) -> String {
    let text = epilogue::warnings(&found.facts.warnings);
    match found.interrupted {
        true => text + "interrupted: what is shown was finished before\n",
        false => text,
    }
}

/// The exit code of what was found: 1 where a case failed.
pub fn exit(found: &Stability) -> u8 {
    match found.interrupted {
        true => interrupt::INTERRUPTED,
        false => u8::from(found.cases.iter().any(|c| c.verdict == Verdict::Fail)),
    }
}

/// The study of stability a scene lists; else the motion it lists.
fn listed(scene: &Scene) -> StabilityStudy {
    let own = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Stability(study) => Some(study.clone()),
        _ => None,
    });
    let motion = || {
        scene.studies.iter().find_map(|study| match &study.kind {
            StudyKind::Simulate(motion) => Some(StabilityStudy {
                motion: motion.clone(),
                ..StabilityStudy::default()
            }),
            _ => None,
        })
    };
    own.or_else(motion).unwrap_or_default()
}

/// Facts, parametric stability, extremes.
///
/// # Errors
/// Whatever is wrong with the machine or the methods.
pub fn study_of(
    scene: &Scene,
    study: &StabilityStudy,
    quiet: bool,
    stop: &Stop,
) -> Result<Stability, Error> {
    choice::each_named(&study.methods)?;
    let mut watch = Watch {
        stop,
        hear: &mut |what| output::working(what, quiet),
    };
    let prepared = Prepared::new(&scene.model)?;
    let facts = match watch.goes_on("modes with their damping") {
        true => facts::facts(&prepared, study.motion.speed)?,
        false => return Err(interrupted()),
    };
    // Multipliers are of the machine, however long it moves; a period of the slowest motion stands in for a duration left out.
    let nominal = SimulateStudy {
        until: study.motion.until.or(Some(facts.slowest_period())),
        ..study.motion.clone()
    };
    let ready = MotionScene::new(&prepared, &scene.start, &nominal);
    let asks_motion = study.motion.until.is_some() || study.speeds.is_some();
    let budget = ready.as_ref().map_or(cases::BUDGET, cases::budget);
    let (floquet, cases, left_out, methods_left_out) = match ready {
        // What keeps a model from moving is nothing to its linear facts.
        Err(error) if !asks_motion => {
            let why = error.message;
            let nothing = vec![(cases::ALL, cases::NO_DURATION)];
            (Err(why), Vec::new(), nothing, Vec::new())
        }
        ready => {
            let ready = ready?;
            let floquet = parametric::study(&prepared, &ready, study, &mut watch)?;
            let (cases, left_out, unable) = match study.motion.until {
                Some(_) => {
                    let methods = Methods::new(&ready, &study.motion, &study.methods)?;
                    let cases = extremes::extremes(&ready, &study.motion, &methods, &mut watch);
                    (cases, cases::left_out(&ready).collect(), methods.left_out)
                }
                None => {
                    let nothing = vec![(cases::ALL, cases::NO_DURATION)];
                    (Vec::new(), nothing, Vec::new())
                }
            };
            (floquet, cases, left_out, unable)
        }
    };
    let step = study.motion.step.unwrap_or(facts.usual_step());
    let amplified = amplification::amplified(&facts.eigenvalues, step)?;
    Ok(Stability {
        amplified: (step, amplified),
        facts,
        floquet,
        cases,
        budget,
        left_out,
        methods_left_out,
        interrupted: stop.is_raised(),
    })
}
