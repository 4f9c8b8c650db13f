//! Periodic motions over speed of a machine with play, friction and stiffness that varies: what they need, and finding them.

use std::time::Instant;

use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::stop::Stop;
use crate::base::words::{counted, listed};
use crate::machine::kinematics::mean_speeds;
use crate::motion::floquet::chart::{Tongue, tongues};
use crate::motion::light;
use crate::motion::methods::periodic::foreign::foreign;
use crate::motion::train::Train;
use crate::plan::motion::scene::MotionScene;
use crate::plan::prepared::Prepared;
use crate::plan::stages::Verdict;
use crate::response::harmonic::curve::{Course, Curve, TOLERANCE, follow};
use crate::response::harmonic::family::Family;
use crate::response::harmonic::lines::Lines;
use crate::response::harmonic::point::{Asked, Found, Point};
use crate::response::harmonic::special::{Kind, Special};
use crate::scene::laws::{PhaseOf, StartAt};
use crate::scene::start::Start;
use crate::scene::study::{HarmonicBalanceStudy, MOST_ORDERS, SimulateStudy, SpeedRange};

/// Periodic motions over speed.
pub struct Answer {
    /// The curve with its folds and bifurcations.
    pub curve: Curve,
    /// Of every fold or bifurcation: the amplitude of the first output on the stable motion at the same speed that is furthest
    /// from it, where there is one.
    pub jumps: Vec<Option<f64>>,
    /// Names and units of the outputs.
    pub outputs: Vec<(String, &'static str)>,
    /// Whose speed is counted.
    pub node: String,
    /// Its speed over the frequency with which everything repeats.
    pub ratio: f64,
    /// The range asked for.
    pub range: SpeedRange,
    /// Branches that are not linear, whose deflections were solved for.
    pub branches: Vec<String>,
    /// Speeds at which a stiffness that varies feeds a motion while all contacts stay closed; or why they are not known.
    pub tongues: Result<Vec<Tongue>, String>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, Verdict)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
    /// s.
    pub seconds: f64,
}

/// The most points of a curve, in those of the range: around folds it is longer than the range.
const LONGER: usize = 20;

/// Points of the search for parametric resonances for each point of the range.
const FINER: usize = 4;

/// A study before it runs.
struct Ready {
    scene: MotionScene,
    family: Family,
    node: usize,
    ratio: f64,
    range: SpeedRange,
    span: [f64; 2],
    branches: Vec<String>,
    /// Motions can be refined by events; or why not.
    events: Result<(), String>,
}

impl Ready {
    fn new(prepared: &Prepared, study: &HarmonicBalanceStudy) -> Result<Ready, Error> {
        let Some(range) = study.speeds else {
            let error = Error::new(Code::Usage, "nothing says which speeds are wanted");
            return Err(error.hint("add --harmonic-balance 500:3000:100, or `speeds` to the study"));
        };
        let machine = &prepared.machine;
        let Some(&(node, _)) = machine.speeds.first() else {
            return Err(Error::new(
                Code::NoSpeed,
                "motions over speed need a speed that all others follow from",
            )
            .hint("state the speed of a node in [speed] of the model"));
        };
        let speeds = mean_speeds(machine, &prepared.kinematics, None)?;
        let speed = speeds[node];
        let span = [range.from / speed, range.to / speed];
        if span.iter().any(|x| x.is_nan() || *x <= 0.0) {
            let message = "the range of speeds holds standstill, where nothing repeats, or turns against [speed]";
            return Err(Error::new(Code::OutOfRange, message)
                .hint("begin above zero, in the sense of [speed]"));
        }
        let scene = scene(prepared, study)?;
        let train = &scene.moving.train;
        if let Some(why) = light::refused(train) {
            return Err(
                Error::new(Code::Conflict, why).hint("give the node its inertia, however small")
            );
        }
        let of = |name: &String| machine.freedom(name).map_or(0.0, |f| speeds[f]);
        let coordinates: Vec<f64> = train.coordinates.iter().map(of).collect();
        let coordinates = beside_prescribed(&scene, coordinates)?;
        let family = Family::new(train, &coordinates)?;
        let active = Lines::new(&family).active;
        let events = if study.orders_alone {
            Err("not asked for".to_string())
        } else if !family.comes_back() {
            Err(
                "a part turns freely against a brake, a damper or a motor: no state comes back"
                    .to_string(),
            )
        } else {
            foreign(train).map_or(Ok(()), Err)
        };
        Ok(Ready {
            branches: active
                .iter()
                .map(|a| train.branches[a.branch].name.clone())
                .collect(),
            node,
            ratio: speed / family.base,
            range,
            span,
            events,
            family,
            scene,
        })
    }

    fn plan(&self, study: &HarmonicBalanceStudy) -> Vec<(&'static str, Verdict)> {
        let runs = |text: &str| Verdict::Runs(text.to_string());
        let out = |text: &str| Verdict::LeftOut(text.to_string());
        let n = self.family.relative.train.n();
        let unknowns = match self.branches.is_empty() {
            true => "none: nothing is nonlinear here".to_string(),
            false => format!(
                "the deflections of {}; {} eliminated order by order",
                listed(self.branches.iter().map(String::as_str)),
                counted(n, "linear coordinate")
            ),
        };
        let orders = study
            .orders
            .map_or("as many as the residual asks".to_string(), |n| {
                format!("{n}, as asked")
            });
        vec![
            ("unknowns", Verdict::Runs(unknowns)),
            ("orders", Verdict::Runs(orders)),
            (
                "events",
                match &self.events {
                    Ok(()) => runs("motions are refined by shooting with every switch located"),
                    Err(why) => out(why),
                },
            ),
            (
                "stability",
                runs(match &self.events {
                    Ok(()) => "multipliers of the return map",
                    Err(_) => "multipliers from exponentials over 512 steps of a period",
                }),
            ),
            (
                "parametric resonances",
                match varies(&self.family.relative.train) {
                    true => runs("with all contacts closed, over the same speeds"),
                    false => out("no stiffness varies"),
                },
            ),
        ]
    }
}

/// Mean speeds of the coordinates that stay, less what prescribed motions carry them along with.
fn beside_prescribed(scene: &MotionScene, mut speeds: Vec<f64>) -> Result<Vec<f64>, Error> {
    let Some(prescribed) = &scene.moving.prescribed else {
        return Ok(speeds);
    };
    for motion in &prescribed.motions {
        let slope = motion.course.knots.last().map_or(0.0, |k| k.slope);
        if motion.course.knots.iter().any(|k| k.slope != slope) {
            let message = format!(
                "{} changes its speed, and a steady motion has one",
                motion.name
            );
            return Err(Error::new(Code::Conflict, message).hint("give the motor one speed"));
        }
        for (speed, &whole) in speeds.iter_mut().zip(&prescribed.kept) {
            *speed -= motion.share[whole] * slope;
        }
    }
    Ok(speeds)
}

/// The plan of a study, row by row.
///
/// # Errors
/// As for [`run`].
pub fn plan(
    prepared: &Prepared,
    study: &HarmonicBalanceStudy,
) -> Result<Vec<(&'static str, Verdict)>, Error> {
    Ok(Ready::new(prepared, study)?.plan(study))
}

/// Runs a study; `progress` hears how far it is, 0 to 1.
///
/// # Errors
/// What is missing in the study or the machine; a range that is none; those of the curve.
pub fn run(
    prepared: &Prepared,
    study: &HarmonicBalanceStudy,
    progress: &mut dyn FnMut(f64),
) -> Result<Answer, Error> {
    let begin = Instant::now();
    let tolerance = study.tolerance.unwrap_or(TOLERANCE);
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("a tolerance of {tolerance} cannot be"),
        )
        .hint("it lies above 0 and below 1"));
    }
    if study
        .orders
        .is_some_and(|n| !(1..=MOST_ORDERS).contains(&n))
    {
        return Err(Error::new(
            Code::OutOfRange,
            format!("the orders of a balance count from 1 to {MOST_ORDERS}"),
        ));
    }
    let ready = Ready::new(prepared, study)?;
    let (family, span, range) = (&ready.family, ready.span, ready.range);
    let course = Course {
        from: span[0] * family.base,
        to: span[1] * family.base,
        step: (span[1] - span[0]).abs() * family.base / f64::from(range.count),
        tolerance,
        orders: study.orders.map(|n| n as usize),
        most: LONGER * range.count as usize,
    };
    let asked = Asked {
        outputs: &ready.scene.outputs,
        events: ready.events.is_ok(),
    };
    let curve = follow(family, asked, course, progress)?;
    let jumps = curve
        .specials
        .iter()
        .map(|s| beyond(&curve, s.after, s.point.omega, &s.point))
        .collect();
    let mut answer = Answer {
        jumps,
        outputs: ready
            .scene
            .outputs
            .list
            .iter()
            .map(|o| (o.name.clone(), o.unit))
            .collect(),
        node: prepared.machine.freedom_name(ready.node),
        ratio: ready.ratio,
        range,
        tongues: resonances(&family.relative.train, span, FINER * range.count as usize),
        plan: ready.plan(study),
        warnings: prepared.warnings(),
        seconds: begin.elapsed().as_secs_f64(),
        branches: ready.branches,
        curve,
    };
    answer.warn(prepared.machine.spins.is_empty(), tolerance);
    Ok(answer)
}

fn varies(train: &Train) -> bool {
    train.branches.iter().any(|b| b.variation.is_some())
}

/// The machine in motion with its waves at imposed speed, and the outputs.
fn scene(prepared: &Prepared, study: &HarmonicBalanceStudy) -> Result<MotionScene, Error> {
    let machine = &prepared.machine;
    let varies = |b: usize| {
        machine.branches[b].play > 0.0
            || machine.branches[b].wave.is_some()
            || machine.branches[b].characteristic.is_some()
    };
    let usual = (0..machine.branches.len())
        .filter(|&b| varies(b))
        .map(|b| format!("{}.deflection", machine.branch_name(b)));
    let outputs = match study.outputs.is_empty() {
        true => usual.collect(),
        false => study.outputs.clone(),
    };
    let motion = SimulateStudy {
        until: Some(1.0),
        outputs,
        ..SimulateStudy::default()
    };
    let start = Start {
        phase: PhaseOf::Speed,
        at: StartAt::Rest,
        ..Start::default()
    };
    MotionScene::new(prepared, &start, &motion)
}

/// Parametric resonances with all contacts closed, by factors on the speed.
fn resonances(train: &Train, span: [f64; 2], points: usize) -> Result<Vec<Tongue>, String> {
    if !varies(train) {
        return Err("no stiffness varies".to_string());
    }
    tongues(train, span, points, &Stop::default()).map_err(|error| error.message)
}

/// The amplitude of the first output on another stable stretch of the curve at ω: the furthest from that of `here`.
fn beyond(curve: &Curve, after: usize, omega: f64, here: &Point) -> Option<f64> {
    const NEAR: usize = 2;
    let amplitude = |p: &Point| p.outputs.first().map(|o| o.amplitude());
    let own = amplitude(here)?;
    let others = curve.points.windows(2).enumerate().filter(|(at, pair)| {
        let spans = (pair[0].omega - omega) * (pair[1].omega - omega) <= 0.0;
        at.abs_diff(after) > NEAR && spans && pair.iter().all(|p| p.unstable() == 0)
    });
    let between = |(_, pair): (usize, &[Point])| {
        let (a, b) = (amplitude(&pair[0])?, amplitude(&pair[1])?);
        let share = (omega - pair[0].omega) / (pair[1].omega - pair[0].omega);
        Some(a + (b - a) * share)
    };
    others
        .filter_map(between)
        .max_by(|a, b| (a - own).abs().total_cmp(&(b - own).abs()))
}

impl Answer {
    /// The speed of the node at ω, rad/s.
    pub fn speed(&self, omega: f64) -> f64 {
        omega * self.ratio
    }

    /// Points found by events, and by orders alone.
    pub fn counts(&self) -> (usize, usize) {
        let exact = self
            .curve
            .points
            .iter()
            .filter(|p| p.found == Found::Events)
            .count();
        (exact, self.curve.points.len() - exact)
    }

    fn warn(&mut self, plain: bool, tolerance: f64) {
        let doublings = |s: &Special| s.kind == Kind::PeriodDoubling;
        let not_followed = self.counts().0 == 0 && self.curve.specials.iter().any(doublings);
        let mut warn = |code, message: String, hint: &str| {
            self.warnings.push(Warning {
                code,
                message,
                hint: Some(hint.to_string()),
            });
        };
        if let Some(error) = &self.curve.ended {
            let reached = self
                .curve
                .points
                .last()
                .map_or(0.0, |p| p.omega * self.ratio)
                * 30.0
                / std::f64::consts::PI;
            warn(
                "curve-lost",
                format!("the curve was lost at {reached:.6} rpm: {}", error.message),
                "the motion may stop repeating there; simulate in time, or begin from the other side",
            );
        }
        if self.curve.limited {
            let worst = self
                .curve
                .points
                .iter()
                .map(|p| p.left_out)
                .fold(0.0, f64::max);
            warn(
                "orders-limited",
                format!(
                    "the balance would need more orders than it takes: those left out add up to {worst:.1e}, not {tolerance:.1e}"
                ),
                "motions refined by events do not depend on it; of the others take as many digits as that",
            );
        }
        if not_followed {
            warn(
                "doubling",
                "motions of two periods begin at a period doubling, and are followed only where motions are refined by events".to_string(),
                "simulate in time just beyond the doubling to see one",
            );
        }
        if !plain {
            warn(
                "gyroscopic",
                "gyroscopic terms are those of the speed in [speed] at all speeds".to_string(),
                "take a narrower range around that speed",
            );
        }
    }
}
