//! Error against run time: every method that can take a scene, over a ladder of tolerances or steps, against one reference.
//!
//! The error of an output is its largest difference from the reference over all samples, divided by the largest size of the
//! reference; that of a run is the worst of its outputs. Nothing below the distance of the reference from its closest unrelated
//! witness can be told, so no error is stated smaller. Times are the least of several repeats.

use super::reference::Reference;
use super::timing::least;
use super::trial::{TIGHTEST, distance, growth, integrate, ladder};
use super::watch::Watch;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::base::units;
use crate::motion::methods::{METHODS, Method};
use crate::motion::problem::{Effort, Wanted};
use crate::plan::motion::choice::each_named;
use crate::plan::motion::cost::{Cost, room};
use crate::plan::motion::scene::MotionScene;

/// Error against run time of one scene.
pub struct Accuracy {
    /// What the errors are against.
    pub reference: Reference,
    /// Every rung of every method, run or not.
    pub runs: Vec<Run>,
    /// It ended before all were done.
    pub interrupted: bool,
}

/// One rung of a method.
pub struct Run {
    /// The method.
    pub method: &'static str,
    /// How exact or how fine it was asked; absent for exact methods, and for those that take no rung at all.
    pub wanted: Option<Wanted>,
    /// How it ended.
    pub outcome: Outcome,
}

/// How a rung ended.
pub enum Outcome {
    /// It came to its end.
    Ended {
        /// Its error, not below what the reference is known to.
        error: f64,
        /// The least time of its repeats, s.
        seconds: f64,
        /// What it cost.
        effort: Effort,
    },
    /// It did not, for this reason.
    Failed(Error),
    /// It was not begun, for this reason.
    NotRun(String),
}

/// What is to be taken for an error.
pub enum Advice<'a> {
    /// The cheapest run that reaches it, and the cheapest of another method.
    Cheapest(&'a Run, Option<&'a Run>),
    /// None reaches it; this one comes nearest.
    Nearest(&'a Run),
    /// No run came to its end.
    Nothing,
}

/// Seconds a rung may take, and all runs of one method for the reference.
pub const PATIENCE: f64 = 10.0;

/// Histories held at a time: those of the methods that may be the reference, and of the rung compared with it.
const KEPT: usize = 16;

/// Runs every method. A rung that would take longer than `patience`, s, is not begun or given up. Ended early, it gives the runs
/// that were finished.
///
/// # Errors
/// An unknown method; no method that could serve as the reference; `Interrupted` before there is one.
pub fn study(
    scene: &MotionScene,
    methods: &[String],
    patience: f64,
    watch: &mut Watch,
) -> Result<Accuracy, Error> {
    refuse(scene, methods)?;
    let chosen: Vec<&'static Method> = match methods.is_empty() {
        true => METHODS.iter().collect(),
        false => each_named(methods)?,
    };
    let cost = Cost::new(scene);
    let reference = Reference::find(scene, (&cost, patience), watch)?;
    let judge = Judge {
        reference: &reference,
        cost,
        patience,
    };
    let mut runs = Vec::new();
    for method in chosen {
        match (method.refuses)(&scene.moving.train) {
            Some(why) => runs.push(Run {
                method: method.name,
                wanted: None,
                outcome: Outcome::NotRun(why),
            }),
            None => climb(scene, method, &judge, watch, &mut runs),
        }
        if watch.stop.is_raised() {
            break;
        }
    }
    Ok(Accuracy {
        reference,
        runs,
        interrupted: watch.stop.is_raised(),
    })
}

/// Refuses what can be known before any run.
///
/// # Errors
/// An unknown method; histories that would take more room than is allowed.
pub fn refuse(scene: &MotionScene, methods: &[String]) -> Result<(), Error> {
    each_named(methods)?;
    room(scene, KEPT)
}

/// What rungs are judged by.
struct Judge<'a> {
    reference: &'a Reference,
    cost: Cost<'a>,
    /// Seconds a rung may take.
    patience: f64,
}

/// Every rung of a method, the coarsest first; those that would take too long are listed and not begun.
fn climb(
    scene: &MotionScene,
    method: &'static Method,
    judge: &Judge,
    watch: &mut Watch,
    runs: &mut Vec<Run>,
) {
    let mut dear = None;
    for rung in ladder(scene, method) {
        let wanted = rung.unwrap_or(Wanted::Tolerance(TIGHTEST));
        let least = judge.cost.least(method, wanted);
        let least = least.filter(|least| least.is_beyond(judge.patience));
        dear = dear.or(least.map(|least| format!("not run: {}", least.told())));
        let outcome = match &dear {
            Some(why) => Outcome::NotRun(String::clone(why)),
            None => {
                let on = watch.goes_on(method.name);
                let outcome = run(scene, method, rung, judge, watch.stop);
                if !on || watch.stop.is_raised() {
                    return;
                }
                dear = outcome.too_dear(method, judge.patience);
                outcome
            }
        };
        runs.push(Run {
            method: method.name,
            wanted: rung,
            outcome,
        });
    }
}

impl Outcome {
    /// Why the next finer rung is not worth beginning.
    fn too_dear(&self, method: &Method, patience: f64) -> Option<String> {
        match self {
            Outcome::Ended { seconds, .. } => {
                let next = growth(method) * seconds;
                (next > patience).then(|| {
                    format!(
                        "not run: the last took {}, the next would take about {}",
                        units::seconds(*seconds),
                        units::seconds(next)
                    )
                })
            }
            Outcome::Failed(error) if error.code == Code::Hopeless => {
                Some("not run: the last was given up".to_string())
            }
            _ => None,
        }
    }
}

impl Run {
    /// Its error, where it came to its end.
    pub fn error(&self) -> Option<f64> {
        match self.outcome {
            Outcome::Ended { error, .. } => Some(error),
            _ => None,
        }
    }

    /// How long it took, s, where it came to its end.
    pub fn seconds(&self) -> Option<f64> {
        match self.outcome {
            Outcome::Ended { seconds, .. } => Some(seconds),
            _ => None,
        }
    }

    /// Why it has no error.
    pub fn reason(&self) -> Option<&str> {
        match &self.outcome {
            Outcome::Ended { .. } => None,
            Outcome::Failed(error) => Some(&error.message),
            Outcome::NotRun(why) => Some(why),
        }
    }
}

impl Accuracy {
    /// What is to be taken for an error.
    pub fn advice(&self, error: f64) -> Advice<'_> {
        let reached = || {
            let all = self.runs.iter();
            all.filter(|r| r.error().is_some_and(|e| e <= error))
        };
        let time = |run: &Run| run.seconds().unwrap_or(f64::INFINITY);
        let cheaper = |a: &&Run, b: &&Run| time(a).total_cmp(&time(b));
        if let Some(best) = reached().min_by(cheaper) {
            let others = reached().filter(|r| r.method != best.method);
            return Advice::Cheapest(best, others.min_by(cheaper));
        }
        let ended = self.runs.iter().filter(|r| r.error().is_some());
        let off = |run: &Run| run.error().unwrap_or(f64::INFINITY);
        let nearest = ended.min_by(|a, b| off(a).total_cmp(&off(b)).then(cheaper(a, b)));
        nearest.map_or(Advice::Nothing, Advice::Nearest)
    }
}

fn run(
    scene: &MotionScene,
    method: &'static Method,
    rung: Option<Wanted>,
    judge: &Judge,
    stop: &Stop,
) -> Outcome {
    let wanted = rung.unwrap_or(Wanted::Tolerance(TIGHTEST));
    let (outcome, seconds) = least(|| {
        let trial = integrate(scene, method, wanted, &scene.start, (stop, judge.patience))?;
        let error = distance(&trial.values, &judge.reference.values);
        let error = error.max(judge.reference.agreement().unwrap_or(0.0));
        match error.is_finite() {
            true => Ok((error, trial.effort)),
            false => Err(Error::new(
                Code::Overflow,
                "the motion grew beyond all numbers",
            )),
        }
    });
    match outcome {
        Ok((error, effort)) => Outcome::Ended {
            error,
            seconds,
            effort,
        },
        Err(error) => Outcome::Failed(error),
    }
}
