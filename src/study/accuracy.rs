//! Error against run time: every method that can take a scene, over a ladder of tolerances or steps, against one reference.
//!
//! The error of an output is its largest difference from the reference over all samples, divided by the largest size of the
//! reference; that of a run is the worst of its outputs. Nothing below the distance of two references can be told, so no error
//! is stated smaller. Times are the least of several repeats.

use std::ops::ControlFlow;

use super::timing::least;
use super::watch::{Watch, interrupted};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::motion::methods::{Ladder, METHODS, Method};
use crate::motion::problem::{Ask, Effort, Wanted};
use crate::plan::motion::choice::named;
use crate::plan::motion::scene::MotionScene;

/// Error against run time of one scene.
pub struct Accuracy {
    /// What the errors are against.
    pub reference: Reference,
    /// Every run, method by method.
    pub runs: Vec<Run>,
    /// It ended before all were done.
    pub interrupted: bool,
}

/// What the errors are against.
pub struct Reference {
    /// Its method, and how exact it was asked.
    pub method: &'static str,
    /// The method it was compared with.
    pub beside: Option<&'static str>,
    /// How far both are apart: an estimate of its own error.
    pub agreement: f64,
    /// By how much a change of the start grows until it is seen in an output: errors of rounding grow alike.
    pub amplification: f64,
    values: Vec<Vec<f64>>,
}

/// One run of a method.
pub struct Run {
    /// The method.
    pub method: &'static str,
    /// How exact or how fine it was asked; absent for exact methods.
    pub wanted: Option<Wanted>,
    /// Its error, where it came to an end.
    pub error: Option<f64>,
    /// The least time of its repeats, s.
    pub seconds: f64,
    /// What it cost.
    pub effort: Effort,
    /// Why it came to none.
    pub failed: Option<String>,
}

/// Tolerances of the ladder.
const TOLERANCES: [f64; 6] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13];

/// The tightest tolerance references are asked with.
const TIGHTEST: f64 = 1e-13;

/// Divisions of the time by fixed-step methods.
const STEPS: [f64; 4] = [1e3, 1e4, 1e5, 1e6];

/// Evaluations after which a rung is given up.
const BUDGET: u64 = 20_000_000;

/// Seconds after which a rung is given up.
const PATIENCE: f64 = 10.0;

/// After a rung of so many seconds the ladder of a method ends: the next would cost several times as much.
const ENOUGH: f64 = 2.0;

/// Relative change of the start that shows how errors grow.
const NUDGE: f64 = 1e-9;

/// Runs every method. Ended early, it gives the runs that were finished.
///
/// # Errors
/// An unknown method; no method that could serve as the reference; `Interrupted` before there is one.
pub fn study(
    scene: &MotionScene,
    methods: &[String],
    watch: &mut Watch,
) -> Result<Accuracy, Error> {
    let chosen: Vec<&Method> = match methods.is_empty() {
        true => METHODS.iter().collect(),
        false => methods
            .iter()
            .map(|name| named(name))
            .collect::<Result<_, Error>>()?,
    };
    let reference = reference(scene, watch)?;
    let mut runs = Vec::new();
    'all: for method in chosen {
        if let Some(why) = (method.refuses)(&scene.moving.train) {
            runs.push(Run {
                method: method.name,
                wanted: None,
                error: None,
                seconds: 0.0,
                effort: Effort::default(),
                failed: Some(why),
            });
            continue;
        }
        for rung in ladder(scene, method) {
            let on = watch.goes_on(method.name);
            let run = rung_of(scene, method, rung, &reference, watch.stop);
            if !on || watch.stop.is_raised() {
                break 'all;
            }
            let hopeless = run.seconds > ENOUGH;
            runs.push(run);
            // Finer rungs cost more.
            if hopeless {
                break;
            }
        }
    }
    Ok(Accuracy {
        reference,
        runs,
        interrupted: watch.stop.is_raised(),
    })
}

impl Reference {
    /// Errors below this cannot be told.
    fn floor(&self) -> f64 {
        match self.agreement.is_finite() {
            true => self.agreement,
            false => 0.0,
        }
    }
}

impl Accuracy {
    /// The cheapest run that reaches an error.
    pub fn cheapest(&self, error: f64) -> Option<&Run> {
        let reached = self
            .runs
            .iter()
            .filter(|r| r.error.is_some_and(|e| e <= error));
        reached.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }

    /// The cheapest run of another method that reaches an error.
    pub fn runner_up(&self, error: f64) -> Option<&Run> {
        let first = self.cheapest(error)?.method;
        let reached = self
            .runs
            .iter()
            .filter(|r| r.method != first && r.error.is_some_and(|e| e <= error));
        reached.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }
}

fn ladder(scene: &MotionScene, method: &Method) -> Vec<Option<Wanted>> {
    match method.ladder {
        Ladder::Exact => vec![None],
        Ladder::Tolerance => TOLERANCES.map(|t| Some(Wanted::Tolerance(t))).to_vec(),
        Ladder::Step => STEPS.map(|n| Some(Wanted::Step(scene.until / n))).to_vec(),
    }
}

/// How much a method is trusted to be a reference: exact ones first, then those that take switches as they come.
fn trust(method: &Method) -> u32 {
    match (method.ladder, method.locates_events) {
        (Ladder::Exact, _) => 0,
        (Ladder::Tolerance, true) => 1,
        (Ladder::Tolerance, false) => 2,
        (Ladder::Step, _) => 3,
    }
}

fn reference(scene: &MotionScene, watch: &mut Watch) -> Result<Reference, Error> {
    let train = &scene.moving.train;
    let mut able: Vec<&Method> = METHODS
        .iter()
        .filter(|m| (m.refuses)(train).is_none() && trust(m) < 3)
        .collect();
    able.sort_by_key(|m| trust(m));
    let mut found: Vec<(&'static str, Vec<Vec<f64>>)> = Vec::new();
    let mut why = Vec::new();
    for method in able {
        if !watch.goes_on(&format!("reference by {}", method.name)) {
            return Err(interrupted());
        }
        let wanted = Wanted::Tolerance(TIGHTEST);
        match integrate(scene, method, wanted, &scene.start, watch.stop) {
            Ok((values, _)) => found.push((method.name, values)),
            Err(error) if error.code == Code::Interrupted => return Err(error),
            Err(error) => why.push(format!("{}: {}", method.name, error.message)),
        }
        if found.len() == 2 {
            break;
        }
    }
    let mut found = found.into_iter();
    let Some((method, values)) = found.next() else {
        let error = Error::new(
            Code::NoConvergence,
            "no method gives a reference for this scene",
        );
        return Err(error.hint(why.join("; ")));
    };
    let (beside, agreement) = match found.next() {
        Some((name, other)) => (Some(name), distance(&other, &values)),
        None => (None, f64::NAN),
    };
    let first = METHODS.iter().find(|m| m.name == method);
    let nudged: Vec<f64> = scene.start.iter().map(|x| x * (1.0 + NUDGE)).collect();
    let moved = first.and_then(|m| {
        let wanted = Wanted::Tolerance(TIGHTEST);
        integrate(scene, m, wanted, &nudged, watch.stop).ok()
    });
    let amplification = moved.map_or(f64::NAN, |(moved, _)| distance(&moved, &values) / NUDGE);
    Ok(Reference {
        method,
        beside,
        agreement,
        amplification,
        values,
    })
}

/// The outputs of a run; given up when it takes too long.
fn integrate(
    scene: &MotionScene,
    method: &Method,
    wanted: Wanted,
    start: &[f64],
    stop: &Stop,
) -> Result<(Vec<Vec<f64>>, Effort), Error> {
    let train = &scene.moving.train;
    let ask = Ask {
        from: 0.0,
        to: scene.until,
        start: start.to_vec(),
        samples: scene.samples,
        effort: wanted,
        budget: BUDGET,
        stop: stop.within(PATIENCE),
    };
    let mut values = vec![Vec::with_capacity(scene.samples + 1); scene.outputs.list.len()];
    let mut reached = 0.0;
    let effort = (method.run)(train, &ask, &mut |t, y, regime| {
        for (list, value) in values.iter_mut().zip(scene.outputs.at(train, regime, t, y)) {
            list.push(value);
        }
        reached = t;
        ControlFlow::Continue(())
    })?;
    if stop.is_raised() {
        return Err(interrupted());
    }
    if values.first().is_some_and(|v| v.len() <= scene.samples) {
        let message = format!("given up after {PATIENCE} s at t = {reached:.4} s");
        return Err(Error::new(Code::Hopeless, message));
    }
    Ok((values, effort))
}

fn rung_of(
    scene: &MotionScene,
    method: &'static Method,
    rung: Option<Wanted>,
    reference: &Reference,
    stop: &Stop,
) -> Run {
    let wanted = rung.unwrap_or(Wanted::Tolerance(TIGHTEST));
    let (outcome, seconds) = least(|| {
        let (values, effort) = integrate(scene, method, wanted, &scene.start, stop)?;
        let error = distance(&values, &reference.values).max(reference.floor());
        match error.is_finite() {
            true => Ok((error, effort)),
            false => Err(Error::new(
                Code::Overflow,
                "the motion grew beyond all numbers",
            )),
        }
    });
    let (error, effort, failed) = match outcome {
        Ok((error, effort)) => (Some(error), effort, None),
        Err(error) => (None, Effort::default(), Some(error.message)),
    };
    Run {
        method: method.name,
        wanted: rung,
        error,
        seconds,
        effort,
        failed,
    }
}

/// The worst output's largest difference, each by its own largest size.
fn distance(values: &[Vec<f64>], reference: &[Vec<f64>]) -> f64 {
    let of = |(x, r): (&Vec<f64>, &Vec<f64>)| {
        let size = r.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let worst = x.iter().zip(r).fold(0.0f64, |m, (a, b)| {
            let d = (a - b).abs();
            if d.is_nan() { f64::INFINITY } else { m.max(d) }
        });
        if size > 0.0 { worst / size } else { worst }
    };
    values.iter().zip(reference).map(of).fold(0.0, f64::max)
}
