//! The scene rerun at its extremes, each answer held to its energy.

use std::ops::ControlFlow;

use super::cases::{CASES, Extreme, idle};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::base::units::seconds;
use crate::motion::meter::{Balance, Limit, Meter};
use crate::motion::methods::{Ladder, METHODS, Method};
use crate::motion::problem::{Ask, Wanted};
use crate::motion::progress::rounded;
use crate::plan::motion::choice::{TOLERANCE, choose, each_named};
use crate::plan::motion::scene::MotionScene;
use crate::scene::study::SimulateStudy;
use crate::study::watch::Watch;

/// One rerun of the scene.
pub struct Case {
    /// What was changed.
    pub name: String,
    /// By which method.
    pub method: &'static str,
    /// How it ended.
    pub verdict: Verdict,
    /// What does not add up of the energy, as a share of the largest part of the balance.
    pub figure: Option<f64>,
    /// Why it was refused or failed.
    pub reason: Option<String>,
}

/// How a rerun ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The answer is finite and its energy adds up.
    Pass,
    /// The method said that it cannot, or at what cost; its energy could not be told well enough; or what was asked is too coarse to hold it.
    Refused,
    /// It answered, and the answer cannot be.
    Fail,
}

impl Verdict {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Refused => "refused",
            Verdict::Fail => "fail",
        }
    }
}

/// What may be missing of the energy, the doubt about it counted in: the share a user would see in a plot.
pub const ADDS_UP: f64 = 1e-3;

/// Methods taken where none is named: what a plan would choose, and one of every kind.
const USUAL: &[&str] = &[
    "radau5",
    "generalized-alpha-controlled",
    "dop853-events",
    "dopri5",
];

/// Methods given a step far too large where none is named.
const STEPPED: &[&str] = &["rk4", "generalized-alpha", "newmark"];

/// Steps of methods that go by one, where the study names no step.
const STEPS: f64 = 1e5;

/// The case of a step far too large, and its share of the time.
const TOO_LARGE: (&str, f64) = ("step a tenth of the time", 0.1);

/// The methods a scene is rerun by.
pub struct Methods {
    /// In every case.
    every: Vec<&'static Method>,
    /// Those given too large a step as well.
    stepped: Vec<&'static Method>,
    /// Those that cannot take the machine, and why.
    pub left_out: Vec<(&'static str, String)>,
}

impl Methods {
    /// Those named; where none is, what a plan would choose and one of every kind.
    ///
    /// # Errors
    /// An unknown method.
    pub fn new(
        scene: &MotionScene,
        study: &SimulateStudy,
        names: &[String],
    ) -> Result<Methods, Error> {
        let train = &scene.moving.train;
        let of = |names: &'static [&str]| METHODS.iter().filter(move |m| names.contains(&m.name));
        let (mut every, mut stepped): (Vec<_>, Vec<_>) = if names.is_empty() {
            let free = SimulateStudy {
                method: None,
                step: None,
                ..study.clone()
            };
            let first = choose(train, &free)?.method;
            let others = of(USUAL).filter(|m| m.name != first.name);
            let every = [first].into_iter().chain(others).collect();
            (every, of(STEPPED).collect())
        } else {
            let all = each_named(names)?;
            let stepped = all.iter().copied().filter(|m| m.ladder == Ladder::Step);
            (all.clone(), stepped.collect())
        };
        let mut left_out: Vec<(&str, String)> = Vec::new();
        for method in every.iter().chain(&stepped) {
            if let Some(why) = (method.refuses)(train)
                && left_out.iter().all(|(name, _)| *name != method.name)
            {
                left_out.push((method.name, why));
            }
        }
        let able = |m: &&Method| left_out.iter().all(|(name, _)| *name != m.name);
        every.retain(able);
        stepped.retain(able);
        Ok(Methods {
            every,
            stepped,
            left_out,
        })
    }
}

/// Reruns a scene at its extremes. Ended early, it gives the cases that were finished.
pub fn extremes(
    scene: &MotionScene,
    study: &SimulateStudy,
    methods: &Methods,
    watch: &mut Watch,
) -> Vec<Case> {
    let tolerance = study.tolerance.unwrap_or(TOLERANCE);
    let step = study.step.unwrap_or(scene.until / STEPS);
    let as_it_is = Extreme::of(scene, tolerance, step);
    let mut all = Vec::new();
    for (name, change) in CASES.iter().filter(|c| idle(c.0, scene).is_none()) {
        for &method in &methods.every {
            if !watch.goes_on(&format!("{name}: {}", method.name)) {
                return all;
            }
            let mut extreme = as_it_is.clone();
            change(&mut extreme);
            let case = rerun(name, method, (&extreme, scene.samples), watch.stop);
            all.extend(case);
        }
    }
    // A step far too large is for those that take what they are given.
    let (name, share) = TOO_LARGE;
    for &method in &methods.stepped {
        if !watch.goes_on(&format!("{name}: {}", method.name)) {
            return all;
        }
        let large = Extreme {
            step: share * scene.until,
            ..as_it_is.clone()
        };
        let case = rerun(name, method, (&large, scene.samples), watch.stop);
        all.extend(case);
    }
    all
}

/// One case by one method, with so many samples; nothing where it was ended.
pub fn rerun(
    name: &str,
    method: &'static Method,
    (extreme, samples): (&Extreme, usize),
    stop: &Stop,
) -> Option<Case> {
    let case = |(verdict, figure, reason)| Case {
        name: name.to_string(),
        method: method.name,
        verdict,
        figure,
        reason,
    };
    let refused = |why: String| Some(case((Verdict::Refused, None, Some(why))));
    let (train, known) = match extreme.moving() {
        Ok(moving) => moving,
        Err(error) => return refused(told(error)),
    };
    if let Some(why) = (method.refuses)(&train) {
        return refused(why);
    }
    let limit = Limit {
        readings: extreme.budget,
        foresees: true,
        stop: stop.clone(),
    };
    let (meter, follower) = Meter::new(&train, known.as_ref(), [0.0, extreme.until], limit);
    let ask = Ask {
        from: 0.0,
        to: extreme.until,
        start: extreme.start.clone(),
        samples,
        effort: match method.ladder {
            Ladder::Step => Wanted::Step(extreme.step),
            _ => Wanted::Tolerance(extreme.tolerance),
        },
        budget: extreme.budget,
        stop: stop.clone(),
        follower,
    };
    let mut finite = true;
    let ran = (method.run)(&train, &ask, &mut |_, y, _| {
        finite &= y.iter().all(|x| x.is_finite());
        ControlFlow::Continue(())
    });
    if stop.is_raised() {
        return None;
    }
    match ran {
        Err(error) => refused(told(error)),
        Ok(_) if !finite => {
            let words = "the answer holds what is no number".to_string();
            Some(case((Verdict::Fail, None, Some(words))))
        }
        Ok(effort) => {
            let balance = meter.borrow().balance();
            let asked = match method.ladder {
                Ladder::Exact => Asked::Exact,
                Ladder::Tolerance => Asked::Tolerance(extreme.tolerance, effort.steps),
                Ladder::Step => Asked::Step(extreme.step, method.order.unwrap_or(1)),
            };
            Some(case(judged(&balance, asked)))
        }
    }
}

fn told(error: Error) -> String {
    match error.code {
        Code::Hopeless => error.message,
        code => format!("{} [{}]", error.message, code.word()),
    }
}

/// How exact a run was asked to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Asked {
    /// To rounding.
    Exact,
    /// By a tolerance of each step's error, and the steps it took.
    Tolerance(f64, u64),
    /// By a step, s, whatever comes of it; and the order of the method.
    Step(f64, u32),
}

impl Asked {
    /// What may be missing of the energy where every step errs as far as it may: twice the errors, energy being of their square.
    fn allows(self) -> f64 {
        match self {
            Asked::Exact => 0.0,
            Asked::Tolerance(tolerance, steps) => 2.0 * tolerance * steps as f64,
            Asked::Step(..) => f64::INFINITY,
        }
    }

    /// Why so much of the energy is missing, and what would hold it.
    fn too_coarse(self, gap: f64) -> String {
        let less = ADDS_UP / gap;
        match self {
            Asked::Exact => String::new(),
            Asked::Tolerance(tolerance, steps) => format!(
                "too coarse: {gap:.0e} of the energy is missing, which an error of {tolerance:.0e} in each of {steps} steps allows; a tolerance of about {:.0e} would hold it",
                tolerance * less
            ),
            Asked::Step(step, order) => format!(
                "the step is too long: {gap:.0e} of the energy is missing; steps of about {} would hold it",
                seconds(step * less.powf(1.0 / f64::from(order)))
            ),
        }
    }
}

/// What the balance of a run that came to its end says of it: verdict, figure, reason.
pub fn judged(balance: &Balance, asked: Asked) -> (Verdict, Option<f64>, Option<String>) {
    let gap = balance.gap().abs();
    let refused = |figure, why| (Verdict::Refused, figure, Some(why));
    if let Some(share) = balance.given_up {
        let whole = match share > 0.0 {
            true => format!("about {}", rounded(balance.readings as f64 / share)),
            false => "more than can be told".to_string(),
        };
        let words = format!(
            "its energy cannot be told: {} readings of the powers came through {} % of the time; the whole would take {whole}, more than is allowed",
            rounded(balance.readings as f64),
            brief_share(share)
        );
        return refused(None, words);
    }
    let doubt = balance.doubt().unwrap_or(f64::INFINITY);
    if gap + doubt <= ADDS_UP {
        (Verdict::Pass, Some(gap), None)
    } else if gap - doubt > ADDS_UP.max(asked.allows()) {
        let words = "the energy does not add up".to_string();
        (Verdict::Fail, Some(gap), Some(words))
    } else if gap - doubt > ADDS_UP {
        refused(Some(gap), asked.too_coarse(gap))
    } else {
        let words = format!(
            "whether its energy adds up cannot be told: it closes to {gap:.0e}, known to {doubt:.0e}"
        );
        refused(Some(gap), words)
    }
}

/// A share in per cent, never rounded to all of it.
fn brief_share(share: f64) -> String {
    let cent = 100.0 * share;
    match cent {
        0.0 => "0".to_string(),
        c if c >= 1.0 => format!("{:.0}", c.floor()),
        c => format!("{c:.1e}"),
    }
}
