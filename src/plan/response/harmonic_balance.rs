//! Harmonic-balance study: periodic motion over speed with clearance, friction, time-varying stiffness.

use std::time::Instant;

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::{pluralise, quoted_list};
use crate::base::time_budget::CancelToken;
use crate::machine::kinematics::mean_speeds;
use crate::motion::algebraic;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::floquet::stability_chart::{InstabilityTongue, instability_tongues};
use crate::motion::methods::periodic::applicability::unsupported_reason;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;
use crate::response::harmonic_balance::bifurcation::{Bifurcation, BifurcationKind};
use crate::response::harmonic_balance::curve::{
    ContinuationOptions, DEFAULT_TOLERANCE, SolutionCurve, continue_curve,
};
use crate::response::harmonic_balance::family::{SPEED_TOLERANCE, SpeedFamily};
use crate::response::harmonic_balance::linear_part::LinearPart;
use crate::response::harmonic_balance::point::{PeriodicSolution, PointOptions, Refinement};
use crate::scene::initial_conditions::InitialConditions;
use crate::scene::laws::{InitialState, MeshPhase};
use crate::scene::study::{HarmonicBalanceStudy, MAX_ORDERS, SimulateStudy, SpeedRange};

/// Periodic motions over speed.
pub struct HarmonicBalanceResult {
    /// The curve with its folds and bifurcations.
    pub curve: SolutionCurve,
    /// Jump amplitude of every fold or bifurcation: the amplitude of the first output on the stable motion at the same speed that is
    /// furthest from it, where there is one.
    pub jumps: Vec<Option<f64>>,
    /// Names and units of the outputs.
    pub outputs: Vec<(String, &'static str)>,
    /// Whose speed is counted.
    pub node: String,
    /// Ratio of the speed to the fundamental frequency.
    pub ratio: f64,
    /// Requested range.
    pub range: SpeedRange,
    /// Branches that are not linear, whose deflections were solved for.
    pub branches: Vec<String>,
    /// Speeds at which a stiffness that varies feeds a motion while all contacts stay closed; or why they are not known.
    pub instability_tongues: Result<Vec<InstabilityTongue>, String>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// s.
    pub seconds: f64,
}

/// The most points of a curve, in those of the range: around folds it is longer than the range.
const MAX_POINTS_FACTOR: usize = 20;

/// Points of the search for parametric resonances for each point of the range.
const SEARCH_POINTS_FACTOR: usize = 4;

/// A study before it runs.
struct HarmonicBalanceSetup {
    scene: SimulationSetup,
    family: SpeedFamily,
    node: usize,
    ratio: f64,
    range: SpeedRange,
    span: [f64; 2],
    branches: Vec<String>,
    /// Motions can be refined by events; or why not.
    events: Result<(), String>,
}

impl HarmonicBalanceSetup {
    fn new(
        prepared_machine: &PreparedMachine,
        study: &HarmonicBalanceStudy,
    ) -> Result<HarmonicBalanceSetup, Error> {
        let Some(range) = study.speeds else {
            let error = Error::new(Code::Usage, "no speeds are stated");
            return Err(error.with_hint("state `speeds`, such as 500:3000:100"));
        };
        let machine = &prepared_machine.machine;
        let Some(&(node, _)) = machine.speeds.first() else {
            return Err(Error::new(
                Code::UndeterminedSpeed,
                "motions over speed need a speed that all others follow from",
            )
            .with_hint("state the speed of a node in [speed] of the model"));
        };
        let speeds = mean_speeds(machine, &prepared_machine.kinematics, None)?;
        let speed = speeds[node];
        let span = [range.from / speed, range.to / speed];
        if span.iter().any(|x| x.is_nan() || *x <= 0.0) {
            let message = "the range of speeds holds standstill, where nothing repeats, or turns against [speed]";
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("begin above zero, in the sense of [speed]"));
        }
        let scene = simulation_setup(prepared_machine, study)?;
        let train = &scene.model.model;
        if let Some(why) = algebraic::why_inertia_needed(train) {
            return Err(Error::new(Code::Conflict, why)
                .with_hint("give the node its inertia, however small"));
        }
        let of = |name: &String| machine.dof(name).map_or(0.0, |f| speeds[f]);
        let coordinates: Vec<f64> = train.coordinates.iter().map(of).collect();
        let coordinates = relative_speeds(&scene, coordinates)?;
        let family = SpeedFamily::new(train, &coordinates)?;
        let active = LinearPart::new(&family).active;
        let events = if study.skip_event_refinement {
            Err("not requested".to_string())
        } else if !family.is_periodic() {
            Err(
                "a part turns freely against a brake, a damper or a motor: no state comes back"
                    .to_string(),
            )
        } else {
            unsupported_reason(train).map_or(Ok(()), Err)
        };
        Ok(HarmonicBalanceSetup {
            branches: active
                .iter()
                .map(|a| train.elements[a.branch].name.clone())
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

    fn plan(&self, study: &HarmonicBalanceStudy) -> Vec<(&'static str, StageDecision)> {
        let runs = |text: &str| StageDecision::Runs(text.to_string());
        let out = |text: &str| StageDecision::LeftOut(text.to_string());
        let n = self.family.relative.model.coordinate_count();
        let unknowns = match self.branches.is_empty() {
            true => "none: nothing is nonlinear here".to_string(),
            false => format!(
                "the deflections of {}; {} eliminated order by order",
                quoted_list(self.branches.iter().map(String::as_str)),
                pluralise(n, "linear coordinate")
            ),
        };
        let orders = study
            .orders
            .map_or("as many as the residual needs".to_string(), |n| {
                format!("{n}, as requested")
            });
        vec![
            ("unknowns", StageDecision::Runs(unknowns)),
            ("orders", StageDecision::Runs(orders)),
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
                match has_varying_stiffness(&self.family.relative.model) {
                    true => runs("with all contacts closed, over the same speeds"),
                    false => out("no stiffness varies"),
                },
            ),
        ]
    }
}

/// Mean speeds of the independent coordinates, less what prescribed motions carry them along with.
fn relative_speeds(scene: &SimulationSetup, speeds: Vec<f64>) -> Result<Vec<f64>, Error> {
    let Some(prescribed) = &scene.model.prescribed else {
        return Ok(speeds);
    };
    let mut carried = vec![0.0; speeds.len()];
    for motion in &prescribed.motions {
        let slope = motion.signal.knots.last().map_or(0.0, |k| k.slope);
        if motion.signal.knots.iter().any(|k| k.slope != slope) {
            let message = format!(
                "{} changes its speed, and a steady motion has one",
                motion.name
            );
            return Err(Error::new(Code::Conflict, message).with_hint("give the motor one speed"));
        }
        for (k, &whole) in prescribed.retained.iter().enumerate() {
            carried[k] += motion.influence[whole] * slope;
        }
    }
    let relative = |(speed, carried): (f64, f64)| match (speed - carried).abs() {
        rest if rest <= SPEED_TOLERANCE * speed.abs() => 0.0,
        _ => speed - carried,
    };
    Ok(speeds.into_iter().zip(carried).map(relative).collect())
}

/// The plan of a study, row by row.
///
/// # Errors
/// As for [`run`].
pub fn plan(
    machine: &PreparedMachine,
    study: &HarmonicBalanceStudy,
) -> Result<Vec<(&'static str, StageDecision)>, Error> {
    Ok(HarmonicBalanceSetup::new(machine, study)?.plan(study))
}

/// Runs a study; `progress` hears how far it is, 0 to 1.
///
/// # Errors
/// What is missing in the study or the machine; a range that is none; those of the curve.
pub fn run(
    machine: &PreparedMachine,
    study: &HarmonicBalanceStudy,
    progress: &mut dyn FnMut(f64),
) -> Result<HarmonicBalanceResult, Error> {
    let begin = Instant::now();
    let tolerance = study.tolerance.unwrap_or(DEFAULT_TOLERANCE);
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("a tolerance of {tolerance} cannot be"),
        )
        .with_hint("it lies above 0 and below 1"));
    }
    if study.orders.is_some_and(|n| !(1..=MAX_ORDERS).contains(&n)) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("the orders of a balance count from 1 to {MAX_ORDERS}"),
        ));
    }
    let ready = HarmonicBalanceSetup::new(machine, study)?;
    let (family, span, range) = (&ready.family, ready.span, ready.range);
    let course = ContinuationOptions {
        from: span[0] * family.base,
        to: span[1] * family.base,
        step: (span[1] - span[0]).abs() * family.base / f64::from(range.count),
        tolerance,
        orders: study.orders.map(|n| n as usize),
        max_points: MAX_POINTS_FACTOR * range.count as usize,
    };
    let options = PointOptions {
        outputs: &ready.scene.outputs,
        events: ready.events.is_ok(),
    };
    let curve = continue_curve(family, options, course, progress)?;
    let jumps = curve
        .bifurcations
        .iter()
        .map(|s| other_branch_amplitude(&curve, s.after, s.point.omega, &s.point))
        .collect();
    let mut result = HarmonicBalanceResult {
        jumps,
        outputs: ready
            .scene
            .outputs
            .list
            .iter()
            .map(|o| (o.name.clone(), o.unit))
            .collect(),
        node: machine.machine.dof_name(ready.node),
        ratio: ready.ratio,
        range,
        instability_tongues: parametric_resonances(
            &family.relative.model,
            span,
            SEARCH_POINTS_FACTOR * range.count as usize,
        ),
        plan: machine.after_meshes(ready.plan(study)),
        diagnostics: machine.warnings(),
        seconds: begin.elapsed().as_secs_f64(),
        branches: ready.branches,
        curve,
    };
    result.warn(machine.machine.gyroscopic.is_empty(), tolerance);
    Ok(result)
}

fn has_varying_stiffness(model: &DynamicModel) -> bool {
    model.elements.iter().any(|b| b.stiffness_wave.is_some())
}

/// The machine in motion with its waves at imposed speed, and the outputs.
fn simulation_setup(
    prepared_machine: &PreparedMachine,
    study: &HarmonicBalanceStudy,
) -> Result<SimulationSetup, Error> {
    let machine = &prepared_machine.machine;
    let varies = |b: usize| {
        machine.branches[b].backlash > 0.0
            || machine.branches[b].stiffness_variation.is_some()
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
        end_time: Some(1.0),
        outputs,
        ..SimulateStudy::default()
    };
    let start = InitialConditions {
        phase: MeshPhase::Speed,
        at: InitialState::Rest,
        ..InitialConditions::default()
    };
    SimulationSetup::of_whole_meshes(prepared_machine, &start, &motion)
}

/// Parametric resonances with all contacts closed, by factors on the speed.
fn parametric_resonances(
    model: &DynamicModel,
    span: [f64; 2],
    points: usize,
) -> Result<Vec<InstabilityTongue>, String> {
    if !has_varying_stiffness(model) {
        return Err("no stiffness varies".to_string());
    }
    instability_tongues(model, span, points, &CancelToken::default()).map_err(|error| error.message)
}

/// Amplitude of the first output on another stable segment of the curve at ω: the furthest from that of `here`.
fn other_branch_amplitude(
    curve: &SolutionCurve,
    after: usize,
    omega: f64,
    here: &PeriodicSolution,
) -> Option<f64> {
    const EXCLUDED_POINTS: usize = 2;
    let amplitude = |p: &PeriodicSolution| p.outputs.first().map(|o| o.amplitude());
    let own = amplitude(here)?;
    let others = curve.points.windows(2).enumerate().filter(|(at, pair)| {
        let spans = (pair[0].omega - omega) * (pair[1].omega - omega) <= 0.0;
        at.abs_diff(after) > EXCLUDED_POINTS
            && spans
            && pair.iter().all(|p| p.unstable_count() == 0)
    });
    let between = |(_, pair): (usize, &[PeriodicSolution])| {
        let (a, b) = (amplitude(&pair[0])?, amplitude(&pair[1])?);
        let share = (omega - pair[0].omega) / (pair[1].omega - pair[0].omega);
        Some(a + (b - a) * share)
    };
    others
        .filter_map(between)
        .max_by(|a, b| (a - own).abs().total_cmp(&(b - own).abs()))
}

impl HarmonicBalanceResult {
    /// The speed of the node at ω, rad/s.
    pub fn speed(&self, omega: f64) -> f64 {
        omega * self.ratio
    }

    /// Points found by events, and by orders alone.
    pub fn refinement_counts(&self) -> (usize, usize) {
        let exact = self
            .curve
            .points
            .iter()
            .filter(|p| p.refinement == Refinement::Shooting)
            .count();
        (exact, self.curve.points.len() - exact)
    }

    fn warn(&mut self, plain: bool, tolerance: f64) {
        let doublings = |s: &Bifurcation| s.kind == BifurcationKind::PeriodDoubling;
        let not_followed =
            self.refinement_counts().0 == 0 && self.curve.bifurcations.iter().any(doublings);
        let mut warn = |code, message: String, hint: &str| {
            self.diagnostics.push(Diagnostic {
                code,
                message,
                hint: Some(hint.to_string()),
            });
        };
        if let Some(error) = &self.curve.stopped_by {
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
        if self.curve.order_limited {
            let worst = self
                .curve
                .points
                .iter()
                .map(|p| p.truncation_error)
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
