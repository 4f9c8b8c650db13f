//! `geardyn stability`: where methods and machine break.

use std::path::PathBuf;

use super::args::StabilityArgs;
use super::{motion_flags, output};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::machine::kinematics::mean_speeds;
use crate::motion::floquet;
use crate::plan::motion::scene::MotionScene;
use crate::plan::prepared::Prepared;
use crate::report;
use crate::report::stability::{Parametric, Stability};
use crate::scene::study::{SpeedRange, StabilityStudy, StudyKind};
use crate::scene::{self, Scene};
use crate::study::stability::{self, Verdict};

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
    let study = StabilityStudy {
        motion: motion_flags::study(&args.motion, listed.motion)?,
        methods: if args.methods.is_empty() {
            listed.methods
        } else {
            args.methods.clone()
        },
        speeds: speeds.or(listed.speeds),
    };
    let inputs: Vec<PathBuf> = scene
        .sources
        .iter()
        .map(|source| PathBuf::from(&source.path))
        .collect();
    let outputs: Vec<PathBuf> = args.svg.iter().cloned().collect();
    output::check(&outputs, &inputs)?;
    if let Some(path) = &args.svg {
        output::ends(path, &["svg"])?;
    }
    let found = study_of(&scene, &study)?;
    if let Some(path) = &args.svg {
        let shortest = found
            .facts
            .limits
            .iter()
            .map(|l| l.1)
            .fold(f64::INFINITY, f64::min);
        let step = study.motion.step.unwrap_or(shortest);
        output::write(
            path,
            report::stability::regions(&scene.model.title, &found.facts, step).as_bytes(),
        )?;
    }
    match args.json {
        true => output::print(&format!(
            "{:#}\n",
            report::stability::json(&scene.sources, &found)
        ))?,
        false => output::print(&report::stability_table::table(&found))?,
    }
    Ok(exit(&found))
}

/// The exit code of what was found: 1 where a case failed.
pub fn exit(found: &Stability) -> u8 {
    u8::from(found.cases.iter().any(|c| c.verdict == Verdict::Fail))
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
pub fn study_of(scene: &Scene, study: &StabilityStudy) -> Result<Stability, Error> {
    let prepared = Prepared::new(&scene.model)?;
    let facts = stability::facts(&prepared)?;
    let ready = MotionScene::new(&prepared, &scene.start, &study.motion)?;
    let floquet = parametric(&prepared, &ready, study)?;
    let cases = stability::extremes(&ready, &study.motion, &study.methods, &mut |_| {})?;
    Ok(Stability {
        facts,
        floquet,
        cases,
    })
}

/// Floquet's multipliers where a stiffness varies at imposed speed, or why there are none.
fn parametric(
    prepared: &Prepared,
    ready: &MotionScene,
    study: &StabilityStudy,
) -> Result<Result<Parametric, String>, Error> {
    let train = &ready.moving.train;
    let imposed = train
        .branches
        .iter()
        .filter_map(|b| b.variation.as_ref())
        .any(|w| w.phase.angle().is_none());
    if !imposed {
        return Ok(Err("no stiffness varies at an imposed speed".to_string()));
    }
    let monodromy = match floquet::monodromy(train, None) {
        Ok(monodromy) => monodromy,
        Err(error) => return Ok(Err(error.message)),
    };
    let multipliers = monodromy.multipliers()?;
    let speeds = mean_speeds(&prepared.machine, &prepared.kinematics, study.motion.speed)?;
    let reference = prepared.machine.speeds.first().map_or(0.0, |s| speeds[s.0]);
    let chart = match study.speeds {
        None => None,
        Some(_) if reference == 0.0 => {
            let message = "a chart over speed needs the speed of the scene to start from";
            return Err(Error::new(Code::NoSpeed, message)
                .hint("state the speed of a node in [speed] of the model"));
        }
        Some(range) => {
            let span = [range.from / reference, range.to / reference];
            Some((
                span,
                floquet::chart::tongues(train, span, range.count as usize)?,
            ))
        }
    };
    Ok(Ok(Parametric {
        largest: multipliers.largest,
        period: monodromy.period,
        chart,
        speed: reference,
    }))
}
