//! A motion from its scene to all that is said of it: prepared, a method chosen, integrated, and handed to the next method where this one
//! gives it up.

use std::f64::consts::TAU;

use super::motion::choice::{self, Choice};
use super::motion::cost;
use super::motion::fineness::Coarse;
use super::motion::run::{self, FEWEST, Motion, Watch};
use super::motion::scene::MotionScene;
use super::motion::sensitivity::{Seen, Sensitivity};
use super::motion::stages;
use super::on_the_fly::{Found, OnTheFly};
use super::prepared::Prepared;
use super::stages::Verdict;
use crate::base::error::{Error, Warning};
use crate::base::stop::Stop;
use crate::base::units::{figure, seconds};
use crate::motion::methods::periodic::grid::frequencies;
use crate::motion::problem::Wanted;
use crate::motion::progress::rounded;
use crate::motion::train::Train;
use crate::motion::trouble::fastest_closed;
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
    /// How the motion amplifies a change of its start, where measured.
    pub sensitivity: Option<Sensitivity>,
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
    /// Prepares, chooses, integrates; `hear` hears at every sample what share of the time is done.
    ///
    /// # Errors
    /// Whatever is wrong with the machine or the motion.
    pub fn new(
        scene: &Scene,
        study: &SimulateStudy,
        stop: &Stop,
        hear: &dyn Fn(f64),
    ) -> Result<Moved, Error> {
        let prepared = Prepared::new(&scene.model)?;
        let ready = MotionScene::new(&prepared, &scene.start, study)?;
        let compares = !study.no_sensitivity && !ready.moving.train.superposes();
        let share = if compares { 0.5 } else { 1.0 };
        let carry_out = |choice: &Choice| {
            let mut seen = OnTheFly::new(&prepared, &ready, &study.running)?;
            let mut first = compares.then(|| Seen::new(&ready));
            let mut watch = |at: (f64, &[f64]), values: &[f64]| {
                hear(share * at.0 / ready.until);
                first
                    .iter_mut()
                    .for_each(|first| first.see(&ready, at, values));
                seen.watch(&ready, at, values)
            };
            let kept = (study.running.history, &mut watch as &mut Watch);
            let motion = run::watched(&ready, choice, study.energy, stop, kept)?;
            let found = seen.finish(motion.interrupted)?;
            Ok::<_, Error>((motion, found, first))
        };
        let first = choice::choose(&ready.moving.train, study)?;
        cost::refuse(&ready, &first, study)?;
        let (choice, motion, (found, seen), handed_over) = match carry_out(&first) {
            Ok((motion, found, seen)) => (first, motion, (found, seen), None),
            Err(error) => {
                let next = choice::successor(&ready.moving.train, study, &first, &error);
                let Some(next) = next else { return Err(error) };
                let said = handed_over(&first, &next, error);
                let (motion, found, seen) = carry_out(&next)?;
                (next, motion, (found, seen), Some(said))
            }
        };
        let seen = seen.filter(|_| !motion.interrupted);
        let compared = seen.map(|seen| {
            let hear = |done: f64| hear(share + (1.0 - share) * done);
            let first = (&seen, motion.seconds);
            Sensitivity::measure(&ready, &choice, first, stop, &hear)
        });
        let (sensitivity, not_compared) = match compared {
            Some(Ok(sensitivity)) => (Some(sensitivity), None),
            Some(Err(error)) => (None, Some(not_compared(&error))),
            None => (None, None),
        };
        let warnings = (prepared.warnings().into_iter())
            .filter(|w| !OF_LINEAR_STUDIES.contains(&w.code))
            .chain(handed_over)
            .chain(choice.passed_over.map(|exact| not_exact(&choice, exact)))
            .chain(long_step(&ready.moving.train, &choice))
            .chain(coarse_samples(&ready).or_else(|| coarse_output(&ready, &motion)))
            .chain(sensitivity.as_ref().and_then(unpredictable))
            .chain(not_compared)
            .chain(found.warnings.clone())
            .collect();
        Ok(Moved {
            plan: stages::plan(&ready, &choice, study),
            step_at: only_step(scene).filter(|t| *t < ready.until),
            scene: ready,
            choice,
            motion,
            sensitivity,
            found,
            warnings,
        })
    }
}

/// A history that cannot be predicted to its end.
fn unpredictable(sensitivity: &Sensitivity) -> Option<Warning> {
    let until = sensitivity.until()?;
    Some(Warning {
        code: "not-predictable",
        message: format!(
            "not predictable beyond t = {}: a second run from a slightly changed start diverges there; the history after it is one of many possible",
            seconds(until)
        ),
        hint: Some(
            "use the rms and the percentiles over the second half; a longer motion narrows their intervals"
                .to_string(),
        ),
    })
}

/// No second run tells which digits hold.
fn not_compared(error: &Error) -> Warning {
    Warning {
        code: "not-compared",
        message: format!(
            "the sensitivity to the start was not measured, so the number of significant digits is unknown: {}",
            error.message
        ),
        hint: error.hint.clone(),
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

/// The highest frequency of loads, errors and stiffness waves of imposed speed, rad/s; zero where none acts.
fn fastest_acting(train: &Train) -> f64 {
    let all = train.harmonics().chain(frequencies(train));
    all.fold(0.0, f64::max)
}

/// Samples too far apart to see what the loads, the errors and the stiffness waves of imposed speed do.
fn coarse_samples(scene: &MotionScene) -> Option<Warning> {
    let fastest = fastest_acting(&scene.moving.train);
    let step = scene.until / scene.samples as f64;
    let per_period = TAU / (fastest * step);
    (per_period < FEWEST).then(|| Warning {
        code: "coarse-samples",
        message: format!(
            "{} samples in a period of the fastest that acts, {} Hz: extremes and means of the outputs are those of the samples, and miss what lies between",
            few(per_period),
            figure(fastest / TAU)
        ),
        hint: Some(finer(scene, per_period)),
    })
}

/// Samples too far apart to see how an output swings.
fn coarse_output(scene: &MotionScene, motion: &Motion) -> Option<Warning> {
    let Coarse { output, per_period } = motion.coarse?;
    Some(Warning {
        code: "coarse-samples",
        message: format!(
            "`{}` swings so fast that {} samples lie in a period: extremes and means of the outputs are those of the samples, and miss what lies between",
            scene.outputs.list[output].name,
            few(per_period)
        ),
        hint: Some(finer(scene, per_period)),
    })
}

/// How many samples would do, to two digits; where so many cannot be asked for, how short a time.
fn finer(scene: &MotionScene, per_period: f64) -> String {
    let samples = FINE / per_period * scene.samples as f64;
    let digit = 10f64.powf(samples.log10().floor() - 1.0).max(1.0);
    let samples = (samples / digit).ceil() * digit;
    if samples <= f64::from(u32::MAX) {
        return format!("--samples {} gives {FINE} in each", rounded(samples));
    }
    let until = scene.until * per_period / FINE;
    format!(
        "--until \"{}\" gives {FINE} in each, with as many samples",
        flag(until)
    )
}

/// So many in a period, to two places, or two digits where it is far fewer than one.
fn few(per_period: f64) -> String {
    match per_period {
        n if n < 0.01 => format!("{n:.1e}"),
        n => format!("{n:.2}"),
    }
}

/// A time as a flag takes it.
fn flag(time_s: f64) -> String {
    match time_s {
        t if t < 1e-9 => format!("{t:.1e} s"),
        t => seconds(t),
    }
}

/// A fixed step too long for what can swing in the machine, or acts on it.
fn long_step(train: &Train, choice: &Choice) -> Option<Warning> {
    let Wanted::Step(step) = choice.wanted else {
        return None;
    };
    let free = fastest_closed(train);
    if let (Some(bound), Some(free)) = (choice.method.bound, free)
        && step * free.rate > bound.radius
    {
        let limit = bound.radius / free.rate;
        return Some(Warning {
            code: "long-step",
            message: format!(
                "a step of {} is longer than {}, beyond which every free motion so fast grows from step to step; {}",
                flag(step),
                flag(limit),
                free.told()
            ),
            hint: Some(format!(
                "take --step \"{}\" or less, or leave method and step out",
                flag(0.5 * limit)
            )),
        });
    }
    let acting = fastest_acting(train);
    let (rate, told) = match free {
        Some(free) if free.rate >= acting => (free.rate, free.told()),
        _ => (
            acting,
            format!("the fastest that acts has {} Hz", figure(acting / TAU)),
        ),
    };
    // The period of a swing is then off by 2 to 3 %: (hω)²/12 of Newmark's average acceleration, (hω)⁴/120 of Runge and Kutta's order 4.
    let fewest = match choice.method.order {
        Some(2) => 10.0,
        _ => 5.0,
    };
    let per_period = TAU / (step * rate);
    (per_period < fewest).then(|| Warning {
        code: "long-step",
        message: format!(
            "{} steps in a period of the fastest that can swing: where it does, it is not followed; {told}",
            few(per_period)
        ),
        hint: Some(format!(
            "--step \"{}\" gives {FINE} in each; where half the step changes nothing, it does not swing",
            flag(step * per_period / FINE)
        )),
    })
}

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
