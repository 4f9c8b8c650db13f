//! A motion from its scene to all that is said of it: prepared, a method chosen, integrated, and handed to the next method where this one
//! gives it up.

use super::motion::choice::{self, Choice};
use super::motion::cost;
use super::motion::run::{self, Motion, Watch};
use super::motion::scene::MotionScene;
use super::on_the_fly::{Found, OnTheFly};
use super::prepared::Prepared;
use super::stages::Verdict;
use crate::base::error::{Error, Warning};
use crate::base::stop::Stop;
use crate::motion::methods::periodic::grid::frequencies;
use crate::scene::Scene;
use crate::scene::laws::History;
use crate::scene::study::SimulateStudy;

/// A motion with all that is said of it.
pub struct Moved {
    /// What moved.
    pub scene: MotionScene,
    /// By which method, and why.
    pub choice: Choice,
    /// How.
    pub motion: Motion,
    /// What was found on the way.
    pub found: Found,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, Verdict)>,
    /// The instant of the one step among the loads, s: the answer to it can be read off.
    pub step_at: Option<f64>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Doubts about an operating point, which belong to linear studies.
const OF_LINEAR_STUDIES: [&str; 3] = ["no-load", "contact-open", "loads-accelerate"];

impl Moved {
    /// Prepares, chooses, integrates.
    ///
    /// # Errors
    /// Whatever is wrong with the machine or the motion.
    pub fn new(scene: &Scene, study: &SimulateStudy, stop: &Stop) -> Result<Moved, Error> {
        let prepared = Prepared::new(&scene.model)?;
        let ready = MotionScene::new(&prepared, &scene.start, study)?;
        let carry_out = |choice: &Choice| {
            let mut seen = OnTheFly::new(&prepared, &ready, &study.running)?;
            let mut watch = |at: (f64, &[f64]), values: &[f64]| seen.watch(&ready, at, values);
            let kept = (study.running.history, &mut watch as &mut Watch);
            let motion = run::watched(&ready, choice, study.energy, stop, kept)?;
            let found = seen.finish(motion.interrupted)?;
            Ok::<_, Error>((motion, found))
        };
        let first = choice::choose(&ready.moving.train, study)?;
        cost::refuse(&ready, &first, study)?;
        let (choice, motion, found, handed_over) = match carry_out(&first) {
            Ok((motion, found)) => (first, motion, found, None),
            Err(error) => {
                let next = choice::successor(&ready.moving.train, study, &first, &error);
                let Some(next) = next else { return Err(error) };
                let said = handed_over(&first, &next, error);
                let (motion, found) = carry_out(&next)?;
                (next, motion, found, Some(said))
            }
        };
        let warnings = (prepared.warnings().into_iter())
            .filter(|w| !OF_LINEAR_STUDIES.contains(&w.code))
            .chain(handed_over)
            .chain(choice.passed_over.map(|exact| not_exact(&choice, exact)))
            .chain(coarse_samples(&ready))
            .chain(found.warnings.clone())
            .collect();
        Ok(Moved {
            plan: choice::plan(&ready, &choice, study),
            step_at: only_step(scene).filter(|t| *t < ready.until),
            scene: ready,
            choice,
            motion,
            found,
            warnings,
        })
    }
}

/// A step was asked for where a method without one would be exact.
fn not_exact(choice: &Choice, exact: &str) -> Warning {
    Warning {
        code: "step-for-exact",
        message: format!(
            "a step was asked for, so that {} took the motion, which {exact} would give without an error of steps",
            choice.method.name
        ),
        hint: Some("leave the step out; `geardyn accuracy` shows what its error is".to_string()),
    }
}

/// Samples too far apart to see what the loads, the errors and the stiffness waves of imposed speed do.
fn coarse_samples(scene: &MotionScene) -> Option<Warning> {
    let train = &scene.moving.train;
    let fastest = train
        .harmonics()
        .chain(frequencies(train))
        .fold(0.0, f64::max);
    let step = scene.until / scene.samples as f64;
    let per_period = std::f64::consts::TAU / (fastest * step);
    (per_period < FEWEST).then(|| Warning {
        code: "coarse-samples",
        message: format!(
            "{per_period:.2} samples in a period of the fastest that acts, {:.4} Hz: extremes and means of the outputs are those of the samples, and miss what lies between",
            fastest / std::f64::consts::TAU
        ),
        hint: Some(format!(
            "--samples {:.0} gives {} in each",
            (FINE / per_period * scene.samples as f64).ceil(),
            FINE
        )),
    })
}

/// Samples in a period below which extremes may be a fifth short, cos(π/5).
const FEWEST: f64 = 5.0;

/// Samples in a period from which extremes are true to 1 %: cos(π/20).
const FINE: f64 = 20.0;

/// One method gave a motion up, another took it.
fn handed_over(first: &Choice, next: &Choice, error: Error) -> Warning {
    Warning {
        code: "handed-over",
        message: format!(
            "{}: {}; {} took the motion from its start",
            first.method.name, error.message, next.method.name
        ),
        hint: error.hint,
    }
}

/// The instant of the one step among the loads.
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
