//! Where methods and machine break: the linear facts, and the scene rerun at its extremes.

use std::ops::ControlFlow;

use super::watch::Watch;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::motion::energy::Meter;
use crate::motion::methods::dop853_table::STAGES;
use crate::motion::methods::{Ladder, METHODS, Method};
use crate::motion::problem::{Ask, Wanted};
use crate::motion::train::{Law, Mass, Train};
use crate::motion::wave::Phase;
use crate::numeric::Complex;
use crate::plan::motion::choice::{choose, named};
use crate::plan::motion::scene::MotionScene;
use crate::plan::prepared::Prepared;
use crate::plan::run;
use crate::plan::stages::Plan;
use crate::scene::study::{ModesStudy, SimulateStudy};

/// The linear facts of a machine with its contacts as the operating point has them.
pub struct Facts {
    /// Every eigenvalue with a frequency or a decay, rad/s; of a conjugate pair the upper one.
    pub eigenvalues: Vec<Complex>,
    /// Largest over smallest |λ|.
    pub stiffness_ratio: f64,
    /// The largest real part, 1/s.
    pub abscissa: f64,
    /// The largest |λ|, rad/s.
    pub fastest: f64,
    /// The smallest, rad/s.
    pub slowest: f64,
    /// Explicit methods and the longest step with which no mode grows that should not, s.
    pub limits: Vec<(&'static str, f64)>,
}

/// Explicit methods whose steps have a limit.
pub const EXPLICIT: [&str; 3] = ["rk4", "dopri5", "dop853"];

/// The stability polynomial `R(z) = Σ c_k z^k` of an explicit method.
///
/// Sources: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, II.4 (Runge–Kutta of order 4)
/// and II.5, Table 5.2 (Dormand–Prince 5(4), seven stages, of which the seventh is the first of the next step); order 8 from
/// its table of stages.
pub fn polynomial(method: &str) -> Option<Vec<f64>> {
    match method {
        "rk4" => Some(vec![1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0]),
        "dopri5" => Some(vec![
            1.0,
            1.0,
            1.0 / 2.0,
            1.0 / 6.0,
            1.0 / 24.0,
            1.0 / 120.0,
            1.0 / 600.0,
        ]),
        "dop853" => Some(of_stages()),
        _ => None,
    }
}

/// `k_i = 1 + z Σ a_ij k_j` as polynomials; row 12 is the end of the step.
fn of_stages() -> Vec<f64> {
    const END: usize = 12;
    let mut stages: Vec<Vec<f64>> = Vec::new();
    for row in &STAGES[..=END] {
        let mut stage = vec![0.0; END + 1];
        stage[0] = 1.0;
        for &(j, a) in *row {
            for k in 0..END {
                stage[k + 1] += a * stages[j][k];
            }
        }
        stages.push(stage);
    }
    stages.swap_remove(END)
}

/// |R(z)| of a stability polynomial at z = hλ.
pub fn amplification(coefficients: &[f64], z: Complex) -> f64 {
    let value = coefficients
        .iter()
        .rev()
        .fold(Complex::ZERO, |sum, &c| sum * z + Complex::new(c, 0.0));
    value.norm()
}

/// Finds the linear facts.
///
/// # Errors
/// Those of complex modes.
pub fn facts(prepared: &Prepared) -> Result<Facts, Error> {
    let study = ModesStudy {
        damped: true,
        ..ModesStudy::default()
    };
    let answer = run::run(prepared, &study, &Plan::modes(prepared, &study))?;
    let eigenvalues: Vec<Complex> = answer
        .modes
        .iter()
        .filter(|m| !m.rigid)
        .map(|m| m.eigenvalue)
        .collect();
    let sizes: Vec<f64> = eigenvalues
        .iter()
        .map(|z| z.norm())
        .filter(|x| *x > 0.0)
        .collect();
    let fastest = sizes.iter().copied().fold(0.0, f64::max);
    let slowest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    let abscissa = eigenvalues
        .iter()
        .map(|z| z.re)
        .fold(f64::NEG_INFINITY, f64::max);
    let of = |name: &'static str| Some((name, limit(&polynomial(name)?, &eigenvalues, fastest)));
    let limits = EXPLICIT.into_iter().filter_map(of).collect();
    Ok(Facts {
        stiffness_ratio: fastest / slowest,
        abscissa,
        fastest,
        slowest,
        limits,
        eigenvalues,
    })
}

/// Growth of a step that counts as none: undamped modes of a method that neither gains nor loses end within it.
const NEUTRAL: f64 = 1e-6;

/// The longest step with which no mode that does not grow by itself is amplified; ∞ where nothing is fast.
fn limit(coefficients: &[f64], eigenvalues: &[Complex], fastest: f64) -> f64 {
    if fastest == 0.0 {
        return f64::INFINITY;
    }
    let stays = |h: f64| {
        eigenvalues
            .iter()
            .filter(|z| z.re <= 0.0)
            .all(|z| amplification(coefficients, *z * h) <= 1.0 + NEUTRAL)
    };
    // Regions are simply connected near the origin: the first crossing counts.
    let mut low = 0.0;
    let mut high = 1e-3 / fastest;
    while stays(high) && high * fastest < 100.0 {
        low = high;
        high *= 1.02;
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if stays(middle) {
            low = middle
        } else {
            high = middle
        }
    }
    low
}

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
    /// The method said that it cannot, or at what cost.
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

/// Evaluations after which an extreme case is refused.
const BUDGET: u64 = 3_000_000;

/// Seconds after which an extreme case is given up.
const PATIENCE: f64 = 4.0;

/// What may be missing of the energy: the share a user would see in a plot.
const ADDS_UP: f64 = 1e-3;

/// Instants at which powers are read.
const SAMPLES: usize = 20_000;

/// Methods taken where none is named: what a plan would choose, and one of every kind.
const USUAL: &[&str] = &[
    "radau5",
    "generalized-alpha-controlled",
    "dop853-events",
    "dopri5",
];

/// What a case does to a scene.
type Change = fn(&mut Extreme);

/// A scene that cases change.
struct Extreme {
    train: Train,
    start: Vec<f64>,
    until: f64,
    tolerance: f64,
}

/// Every case, the unchanged scene first.
const CASES: &[(&str, Change)] = &[
    ("as it is", |_| {}),
    ("stiffness × 1e6", |x| stiffness(&mut x.train, 1e6)),
    ("stiffness × 1e-6", |x| stiffness(&mut x.train, 1e-6)),
    ("inertia × 1e6", |x| inertia(&mut x.train, 1e6)),
    ("inertia × 1e-6", |x| inertia(&mut x.train, 1e-6)),
    ("damping 0", |x| damping(&mut x.train, |_, _| 0.0)),
    ("damping overcritical", |x| {
        damping(&mut x.train, |k, m| 4.0 * (k * m).sqrt())
    }),
    ("backlash 0", |x| backlash(&mut x.train, 0.0)),
    ("backlash × 1e4", |x| backlash(&mut x.train, 1e4)),
    ("speed 0", |x| speed(x, 0.0)),
    ("speed × 100", |x| speed(x, 100.0)),
    ("tolerance 1e-2", |x| x.tolerance = 1e-2),
    ("tolerance 1e-13", |x| x.tolerance = 1e-13),
    ("duration × 1000", |x| x.until *= 1000.0),
];

/// Names of the cases, in their order.
pub fn cases() -> impl Iterator<Item = &'static str> {
    CASES.iter().map(|c| c.0)
}

/// Cases that would change nothing in a scene, and why.
pub fn left_out(scene: &MotionScene) -> impl Iterator<Item = (&'static str, &'static str)> {
    let idle = |&(name, _): &(&'static str, Change)| Some((name, idle(name, scene)?));
    CASES.iter().filter_map(idle)
}

/// Why a case changes nothing.
fn idle(name: &str, scene: &MotionScene) -> Option<&'static str> {
    let train = &scene.moving.train;
    let plays = |law: &Law| matches!(law, Law::Contact(c) if c.half > 0.0);
    let imposed = train.branches.iter().any(|b| {
        let waves = b.variation.iter().chain(&b.followed);
        waves.into_iter().any(|w| w.phase.angle().is_none()) || b.imposed.is_some()
    });
    let n = train.n();
    let turns = scene.start[n..2 * n].iter().any(|v| *v != 0.0);
    match name {
        "backlash 0" | "backlash × 1e4" if !train.branches.iter().any(|b| plays(&b.law)) => {
            Some("no contact has play")
        }
        "speed 0" | "speed × 100" if !turns && !imposed => {
            Some("the scene starts at rest and no speed is imposed")
        }
        _ => None,
    }
}

/// Reruns a scene at its extremes. Ended early, it gives the cases that were finished.
///
/// # Errors
/// An unknown method.
pub fn extremes(
    scene: &MotionScene,
    study: &SimulateStudy,
    methods: &[String],
    watch: &mut Watch,
) -> Result<Vec<Case>, Error> {
    let chosen: Vec<&'static Method> = match methods.is_empty() {
        false => methods
            .iter()
            .map(|name| named(name))
            .collect::<Result<_, Error>>()?,
        true => {
            let first = choose(
                &scene.moving.train,
                &SimulateStudy {
                    method: None,
                    step: None,
                    ..study.clone()
                },
            )?
            .method;
            let others = METHODS
                .iter()
                .filter(|m| USUAL.contains(&m.name) && m.name != first.name);
            [first].into_iter().chain(others).collect()
        }
    };
    let mut all = Vec::new();
    for (name, change) in CASES.iter().filter(|c| idle(c.0, scene).is_none()) {
        for &method in &chosen {
            if !watch.goes_on(&format!("{name}: {}", method.name)) {
                return Ok(all);
            }
            let tolerance = study.tolerance.unwrap_or(1e-6);
            let mut extreme = Extreme {
                train: scene.moving.train.clone(),
                start: scene.start.clone(),
                until: scene.until,
                tolerance,
            };
            change(&mut extreme);
            all.extend(rerun(name, method, &extreme, study, watch.stop));
        }
    }
    // A step far too large is for those that take what they are given.
    for &method in chosen.iter().filter(|m| m.ladder == Ladder::Step) {
        let extreme = Extreme {
            train: scene.moving.train.clone(),
            start: scene.start.clone(),
            until: scene.until,
            tolerance: 0.0,
        };
        let large = SimulateStudy {
            step: Some(scene.until / 10.0),
            ..study.clone()
        };
        let name = "step a tenth of the time";
        all.extend(rerun(name, method, &extreme, &large, watch.stop));
    }
    Ok(all)
}

/// Nothing where it was ended.
fn rerun(
    name: &str,
    method: &'static Method,
    extreme: &Extreme,
    study: &SimulateStudy,
    stop: &Stop,
) -> Option<Case> {
    let case = |verdict, figure, reason| {
        Some(Case {
            name: name.to_string(),
            method: method.name,
            verdict,
            figure,
            reason,
        })
    };
    if let Some(why) = (method.refuses)(&extreme.train) {
        return case(Verdict::Refused, None, Some(why));
    }
    let effort = match method.ladder {
        Ladder::Step => Wanted::Step(study.step.unwrap_or(extreme.until / 1e5)),
        _ => Wanted::Tolerance(extreme.tolerance),
    };
    let ask = Ask {
        from: 0.0,
        to: extreme.until,
        start: extreme.start.clone(),
        samples: SAMPLES,
        effort,
        budget: BUDGET,
        stop: stop.within(PATIENCE),
    };
    let mut meters = [Meter::default(), Meter::default()];
    let (mut count, mut reached, mut finite) = (0usize, 0.0, true);
    let ran = (method.run)(&extreme.train, &ask, &mut |t, y, regime| {
        finite &= y.iter().all(|x| x.is_finite());
        let regime = extreme.train.stands(regime, t, y);
        meters[0].sample(&extreme.train, &regime, (t, y), 0.0);
        if count % 2 == 0 {
            meters[1].sample(&extreme.train, &regime, (t, y), 0.0);
        }
        count += 1;
        reached = t;
        ControlFlow::Continue(())
    });
    if stop.is_raised() {
        return None;
    }
    match ran {
        Err(error) => {
            let words = match error.code {
                Code::Hopeless => error.message,
                _ => format!("{} [{}]", error.message, error.code.word()),
            };
            return case(Verdict::Refused, None, Some(words));
        }
        Ok(_) if !finite => {
            return case(
                Verdict::Fail,
                None,
                Some("the answer holds what is no number".to_string()),
            );
        }
        Ok(_) if reached < extreme.until => {
            let share = reached / extreme.until;
            let words = format!(
                "given up after {PATIENCE} s at t = {reached:.3e} s, {:.2} % of the time",
                100.0 * share
            );
            return case(Verdict::Refused, None, Some(words));
        }
        Ok(_) => {}
    }
    let [fine, coarse] = meters.map(|m| m.balance().gap());
    // The sum over samples has an error of its own, seen from half as many.
    let read = 4.0 * (fine - coarse).abs();
    match fine.abs() <= ADDS_UP + read {
        true => case(Verdict::Pass, Some(fine.abs()), None),
        false => case(
            Verdict::Fail,
            Some(fine.abs()),
            Some("the energy does not add up".to_string()),
        ),
    }
}

fn stiffness(train: &mut Train, factor: f64) {
    for b in &mut train.branches {
        match &mut b.law {
            Law::Linear { stiffness, .. } | Law::Maxwell { stiffness, .. } => *stiffness *= factor,
            Law::Nonlinear { characteristic, .. } => characteristic.scale(factor),
            Law::Contact(contact) => contact.stiffness *= factor,
            Law::Friction(_)
            | Law::Clutch { .. }
            | Law::Pressed(_)
            | Law::Orders { .. }
            | Law::Curve(_)
            | Law::Lagged { .. } => {}
        }
    }
}

fn inertia(train: &mut Train, factor: f64) {
    match &mut train.mass {
        Mass::Diagonal(mass) => mass.iter_mut().for_each(|m| *m *= factor),
        Mass::Full { matrix, inverse } => {
            for j in 0..matrix.ncols() {
                for i in 0..matrix.nrows() {
                    matrix[(i, j)] *= factor;
                    inverse[(i, j)] /= factor;
                }
            }
        }
    }
}

/// Sets the damper of every branch from its stiffness and effective mass.
fn damping(train: &mut Train, of: fn(f64, f64) -> f64) {
    let masses: Vec<f64> = train
        .branches
        .iter()
        .map(|b| {
            let mut w = vec![0.0; train.n()];
            b.direction.scaled().for_each(|(i, a)| w[i] += a);
            train.accelerate(&mut w);
            1.0 / b.direction.dot(&w)
        })
        .collect();
    for (b, m) in train.branches.iter_mut().zip(masses) {
        // What joins no inertia has no damping of its own.
        if !m.is_finite() {
            continue;
        }
        match &mut b.law {
            Law::Linear { stiffness, damping } => *damping = of(*stiffness, m),
            Law::Contact(contact) => contact.damping = of(contact.stiffness, m),
            _ => {}
        }
    }
    train.drag = 0.0;
    if let Some((_, c)) = &mut train.general {
        *c = crate::numeric::Matrix::zeros(c.nrows(), c.ncols());
    }
}

fn backlash(train: &mut Train, factor: f64) {
    for b in &mut train.branches {
        if let Law::Contact(contact) = &mut b.law {
            contact.half *= factor;
        }
    }
}

fn speed(extreme: &mut Extreme, factor: f64) {
    let n = extreme.train.n();
    extreme.start[n..2 * n]
        .iter_mut()
        .for_each(|v| *v *= factor);
    for b in &mut extreme.train.branches {
        for wave in b.variation.iter_mut().chain(&mut b.followed) {
            if let Phase::Imposed { omega, .. } = &mut wave.phase {
                *omega *= factor;
            }
        }
        if let Some(e) = &mut b.imposed {
            e.harmonics.iter_mut().for_each(|h| h.omega *= factor);
        }
    }
}
