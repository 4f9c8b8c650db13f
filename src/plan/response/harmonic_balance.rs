//! Harmonic-balance study: periodic motions over a speed range with clearance, friction and time-varying stiffness.

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

/// Solution curve of a harmonic-balance study with its bifurcations and instability tongues.
pub struct HarmonicBalanceResult {
    /// Solution curve with its folds and bifurcations.
    pub curve: SolutionCurve,
    /// Jump amplitude of each fold or bifurcation: amplitude of the first output on the stable branch at the same speed
    /// that differs most from it; `None` without such a branch.
    pub jumps: Vec<Option<f64>>,
    /// Names and units of the outputs.
    pub outputs: Vec<(String, &'static str)>,
    /// Node whose speed defines the range.
    pub node: String,
    /// Ratio of the node speed to the fundamental frequency, both in rad/s.
    pub ratio: f64,
    /// Requested speed range.
    pub range: SpeedRange,
    /// Nonlinear branches, whose deflections are the unknowns.
    pub branches: Vec<String>,
    /// Instability tongues of parametric resonance with all contacts closed, or the reason why they were not computed.
    pub instability_tongues: Result<Vec<InstabilityTongue>, String>,
    /// Stages with their decisions.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Wall-clock time, s.
    pub seconds: f64,
}

/// Maximum number of curve points per point of the range; folds make the curve longer than the range.
const MAX_POINTS_FACTOR: usize = 20;

/// Search points for instability tongues per point of the range.
const SEARCH_POINTS_FACTOR: usize = 4;

/// Prepared study; `span` is the range as factors on the speed of `[speed]`.
struct HarmonicBalanceSetup {
    simulation: SimulationSetup,
    family: SpeedFamily,
    node: usize,
    ratio: f64,
    range: SpeedRange,
    span: [f64; 2],
    branches: Vec<String>,
    /// Whether solutions are refined by shooting with located events, or the reason why not.
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
                "motions over speed need a reference speed",
            )
            .with_hint("state the speed of a node in [speed] of the model"));
        };
        let speeds = mean_speeds(machine, &prepared_machine.kinematics, None)?;
        let speed = speeds[node];
        let span = [range.from / speed, range.to / speed];
        if span.iter().any(|x| x.is_nan() || *x <= 0.0) {
            let message = "the speeds include standstill or have the opposite sense to [speed]";
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("start above zero, in the sense of [speed]"));
        }
        let simulation = simulation_setup(prepared_machine, study)?;
        let model = &simulation.model.model;
        if let Some(reason) = algebraic::inertia_requirement(model) {
            return Err(Error::new(Code::Conflict, reason)
                .with_hint("give the node an inertia, even a small one"));
        }
        let mean_speed = |name: &String| machine.dof(name).map_or(0.0, |f| speeds[f]);
        let coordinates: Vec<f64> = model.coordinates.iter().map(mean_speed).collect();
        let coordinates = relative_speeds(&simulation, coordinates)?;
        let family = SpeedFamily::new(model, &coordinates)?;
        let active = LinearPart::new(&family).active;
        let events = if study.skip_event_refinement {
            Err("not requested".to_string())
        } else if !family.is_periodic() {
            Err(
                "a part turns freely against a brake, a damper or a motor: no state is periodic"
                    .to_string(),
            )
        } else {
            unsupported_reason(model).map_or(Ok(()), Err)
        };
        Ok(HarmonicBalanceSetup {
            branches: active
                .iter()
                .map(|a| model.elements[a.branch].name.clone())
                .collect(),
            node,
            ratio: speed / family.base,
            range,
            span,
            events,
            family,
            simulation,
        })
    }

    fn plan(&self, study: &HarmonicBalanceStudy) -> Vec<(&'static str, StageDecision)> {
        let runs = |text: &str| StageDecision::Runs(text.to_string());
        let left_out = |text: &str| StageDecision::LeftOut(text.to_string());
        let n = self.family.relative.model.coordinate_count();
        let unknowns = match self.branches.is_empty() {
            true => "none: the machine is linear".to_string(),
            false => format!(
                "the deflections of {}; {} eliminated order by order",
                quoted_list(self.branches.iter().map(String::as_str)),
                pluralise(n, "linear coordinate")
            ),
        };
        let orders = study
            .orders
            .map_or("adapted to the residual".to_string(), |n| {
                format!("{n}, as requested")
            });
        vec![
            ("unknowns", StageDecision::Runs(unknowns)),
            ("orders", StageDecision::Runs(orders)),
            (
                "events",
                match &self.events {
                    Ok(()) => runs("motions are refined by shooting with all switches located"),
                    Err(reason) => left_out(reason),
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
                    false => left_out("no stiffness varies"),
                },
            ),
        ]
    }
}

/// Mean speeds of the independent coordinates relative to the prescribed motions, rad/s or m/s.
fn relative_speeds(simulation: &SimulationSetup, speeds: Vec<f64>) -> Result<Vec<f64>, Error> {
    let Some(prescribed) = &simulation.model.prescribed else {
        return Ok(speeds);
    };
    let mut base_speeds = vec![0.0; speeds.len()];
    for motion in &prescribed.motions {
        let slope = motion.signal.knots.last().map_or(0.0, |k| k.slope);
        if motion.signal.knots.iter().any(|k| k.slope != slope) {
            let message = format!(
                "{} changes its speed; a steady motion needs a constant one",
                motion.name
            );
            return Err(Error::new(Code::Conflict, message).with_hint("give the motor one speed"));
        }
        for (k, &coordinate) in prescribed.retained.iter().enumerate() {
            base_speeds[k] += motion.influence[coordinate] * slope;
        }
    }
    let relative = |(speed, base_speed): (f64, f64)| match (speed - base_speed).abs() {
        difference if difference <= SPEED_TOLERANCE * speed.abs() => 0.0,
        _ => speed - base_speed,
    };
    Ok(speeds.into_iter().zip(base_speeds).map(relative).collect())
}

/// Plans a study: its stages with their decisions.
///
/// # Errors
/// Errors of [`run`] before it solves.
pub fn plan(
    machine: &PreparedMachine,
    study: &HarmonicBalanceStudy,
) -> Result<Vec<(&'static str, StageDecision)>, Error> {
    Ok(HarmonicBalanceSetup::new(machine, study)?.plan(study))
}

/// Runs a study; `progress` receives the completed fraction, 0 to 1.
///
/// # Errors
/// Missing entries of the study or the machine; an invalid speed range; errors of the continuation.
pub fn run(
    machine: &PreparedMachine,
    study: &HarmonicBalanceStudy,
    progress: &mut dyn FnMut(f64),
) -> Result<HarmonicBalanceResult, Error> {
    let start = Instant::now();
    let tolerance = study.tolerance.unwrap_or(DEFAULT_TOLERANCE);
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("a tolerance of {tolerance} is out of range"),
        )
        .with_hint("give one above 0 and below 1"));
    }
    if study.orders.is_some_and(|n| !(1..=MAX_ORDERS).contains(&n)) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("the number of orders must be from 1 to {MAX_ORDERS}"),
        ));
    }
    let setup = HarmonicBalanceSetup::new(machine, study)?;
    let (family, span, range) = (&setup.family, setup.span, setup.range);
    let continuation = ContinuationOptions {
        from: span[0] * family.base,
        to: span[1] * family.base,
        step: (span[1] - span[0]).abs() * family.base / f64::from(range.count),
        tolerance,
        orders: study.orders.map(|n| n as usize),
        max_points: MAX_POINTS_FACTOR * range.count as usize,
    };
    let options = PointOptions {
        outputs: &setup.simulation.outputs,
        events: setup.events.is_ok(),
    };
    let curve = continue_curve(family, options, continuation, progress)?;
    let jumps = curve
        .bifurcations
        .iter()
        .map(|s| other_branch_amplitude(&curve, s.after, s.point.omega, &s.point))
        .collect();
    let mut result = HarmonicBalanceResult {
        jumps,
        outputs: setup
            .simulation
            .outputs
            .list
            .iter()
            .map(|o| (o.name.clone(), o.unit))
            .collect(),
        node: machine.machine.dof_name(setup.node),
        ratio: setup.ratio,
        range,
        instability_tongues: parametric_resonances(
            &family.relative.model,
            span,
            SEARCH_POINTS_FACTOR * range.count as usize,
        ),
        plan: machine.after_meshes(setup.plan(study)),
        diagnostics: machine.warnings(),
        seconds: start.elapsed().as_secs_f64(),
        branches: setup.branches,
        curve,
    };
    result.warn(machine.machine.gyroscopic.is_empty(), tolerance);
    Ok(result)
}

fn has_varying_stiffness(model: &DynamicModel) -> bool {
    model.elements.iter().any(|b| b.stiffness_wave.is_some())
}

/// Setup of the dynamic model with stiffness waves at the imposed speed, and its outputs.
fn simulation_setup(
    prepared_machine: &PreparedMachine,
    study: &HarmonicBalanceStudy,
) -> Result<SimulationSetup, Error> {
    let machine = &prepared_machine.machine;
    let is_nonlinear_or_varying = |b: usize| {
        machine.branches[b].backlash > 0.0
            || machine.branches[b].stiffness_variation.is_some()
            || machine.branches[b].characteristic.is_some()
    };
    let default_names = (0..machine.branches.len())
        .filter(|&b| is_nonlinear_or_varying(b))
        .map(|b| format!("{}.deflection", machine.branch_name(b)));
    let outputs = match study.outputs.is_empty() {
        true => default_names.collect(),
        false => study.outputs.clone(),
    };
    let motion = SimulateStudy {
        end_time: Some(1.0),
        outputs,
        ..SimulateStudy::default()
    };
    let initial_conditions = InitialConditions {
        phase: MeshPhase::Speed,
        at: InitialState::Rest,
        ..InitialConditions::default()
    };
    SimulationSetup::with_single_spring_meshes(prepared_machine, &initial_conditions, &motion)
}

/// Instability tongues with all contacts closed, over `span` as factors on the speed.
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

/// Amplitude of the first output on the stable branch at ω that differs most from `solution`; points next to `after` are excluded.
fn other_branch_amplitude(
    curve: &SolutionCurve,
    after: usize,
    omega: f64,
    solution: &PeriodicSolution,
) -> Option<f64> {
    const EXCLUDED_POINTS: usize = 2;
    let amplitude = |p: &PeriodicSolution| p.outputs.first().map(|o| o.amplitude());
    let reference = amplitude(solution)?;
    let stable_segments = curve.points.windows(2).enumerate().filter(|(at, pair)| {
        let brackets = (pair[0].omega - omega) * (pair[1].omega - omega) <= 0.0;
        at.abs_diff(after) > EXCLUDED_POINTS
            && brackets
            && pair.iter().all(|p| p.unstable_count() == 0)
    });
    let interpolate = |(_, pair): (usize, &[PeriodicSolution])| {
        let (a, b) = (amplitude(&pair[0])?, amplitude(&pair[1])?);
        let share = (omega - pair[0].omega) / (pair[1].omega - pair[0].omega);
        Some(a + (b - a) * share)
    };
    stable_segments
        .filter_map(interpolate)
        .max_by(|a, b| (a - reference).abs().total_cmp(&(b - reference).abs()))
}

impl HarmonicBalanceResult {
    /// Speed of the node at the fundamental frequency ω, rad/s.
    pub fn speed(&self, omega: f64) -> f64 {
        omega * self.ratio
    }

    /// Numbers of points refined by shooting and by harmonic balance alone.
    pub fn refinement_counts(&self) -> (usize, usize) {
        let shooting = self
            .curve
            .points
            .iter()
            .filter(|p| p.refinement == Refinement::Shooting)
            .count();
        (shooting, self.curve.points.len() - shooting)
    }

    fn warn(&mut self, is_without_gyroscopic: bool, tolerance: f64) {
        let is_doubling = |s: &Bifurcation| s.kind == BifurcationKind::PeriodDoubling;
        let unfollowed_doubling =
            self.refinement_counts().0 == 0 && self.curve.bifurcations.iter().any(is_doubling);
        let mut warn = |code, message: String, hint: &str| {
            self.diagnostics.push(Diagnostic {
                code,
                message,
                hint: Some(hint.to_string()),
            });
        };
        if let Some(error) = &self.curve.stopped_by {
            let last_rpm = self
                .curve
                .points
                .last()
                .map_or(0.0, |p| p.omega * self.ratio)
                * 30.0
                / std::f64::consts::PI;
            warn(
                "curve-lost",
                format!("the curve ends at {last_rpm:.6} rpm: {}", error.message),
                "the motion may not be periodic beyond; simulate in time, or start from the other end",
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
                    "the balance needs more orders than its limit: the omitted ones sum to {worst:.1e} (tolerance {tolerance:.1e})"
                ),
                "motions refined by events are not affected; the others have an error of that size",
            );
        }
        if unfollowed_doubling {
            warn(
                "doubling",
                "motions of two periods begin at a period doubling and are followed only if motions are refined by events".to_string(),
                "simulate in time just beyond the doubling",
            );
        }
        if !is_without_gyroscopic {
            warn(
                "gyroscopic",
                "gyroscopic terms of the speed in [speed] are used at all speeds".to_string(),
                "use a narrower range around that speed",
            );
        }
    }
}
