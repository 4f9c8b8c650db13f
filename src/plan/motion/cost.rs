//! Lower bound of the run time and memory of an integration, before it starts.

use std::time::Instant;

use super::dense_cost::{DenseCost, MAX_BYTES};
use super::method_choice::{MethodChoice, choose_method};
use super::simulation_setup::SimulationSetup;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::{format_duration, format_time, suggested_time_limit};
use crate::base::text::pluralise;
use crate::motion::diagnostics::{FastestMode, fastest_mode};
use crate::motion::methods::{IntegrationMethod, METHODS};
use crate::motion::problem::{OdeProblem, StepSize};
use crate::motion::progress::rounded;
use crate::scene::study::SimulateStudy;

/// Maximum number of values of a history.
const MAX_HISTORY_VALUES: f64 = MAX_BYTES / 8.0;

/// Cost model of the time steps of a simulation.
pub struct CostModel<'s> {
    end_time: f64,
    coordinates: usize,
    /// Time of one evaluation of the right-hand side, s.
    evaluation_s: f64,
    fastest: Option<FastestMode<'s>>,
}

/// Lower bound of the cost of a run.
pub struct CostBound<'s> {
    /// Minimum number of steps; 0 without a bound.
    pub steps: f64,
    /// Minimum run time, s.
    pub seconds: f64,
    /// Fastest mode, which bounds the step size; `None` if the study states the step.
    pub bound: Option<FastestMode<'s>>,
    /// Cost of the matrices, if it exceeds that of the steps or the memory limit.
    pub matrices: Option<DenseCost>,
}

impl<'s> CostModel<'s> {
    /// Measures the time of an evaluation of the right-hand side, within a millisecond.
    pub fn new(scene: &'s SimulationSetup) -> CostModel<'s> {
        let model = &scene.model.model;
        let mut slope = vec![0.0; model.len()];
        let first_start = Instant::now();
        let mut shortest = f64::INFINITY;
        while first_start.elapsed().as_secs_f64() < 1e-3 {
            const TIMED_EVALUATIONS: u32 = 16;
            let start = Instant::now();
            (0..TIMED_EVALUATIONS)
                .for_each(|_| model.derivative(0.0, &scene.initial_state, &mut slope));
            shortest = shortest.min(start.elapsed().as_secs_f64() / f64::from(TIMED_EVALUATIONS));
        }
        CostModel {
            end_time: scene.end_time,
            coordinates: model.coordinate_count(),
            evaluation_s: shortest,
            fastest: fastest_mode(model),
        }
    }

    /// Lower bound of the cost of a run by a method; `None` without an estimate.
    pub fn lower_bound(&self, method: &IntegrationMethod, size: StepSize) -> Option<CostBound<'s>> {
        let stages = method.bound.map_or(1.0, |b| f64::from(b.stages));
        let (steps, mode) = match (size, method.bound, self.fastest) {
            (StepSize::Fixed(h), ..) => (self.end_time / h, None),
            (StepSize::Adaptive(_), Some(bound), Some(fastest)) => {
                (self.end_time * fastest.rate / bound.radius, Some(fastest))
            }
            _ => (0.0, None),
        };
        let seconds = steps * stages * self.evaluation_s;
        let matrices = DenseCost::for_method(method, self.coordinates);
        let matrices = matrices.filter(|m| m.seconds > seconds || m.bytes > MAX_BYTES);
        (steps > 0.0 || matrices.is_some()).then(|| CostBound {
            steps,
            seconds: matrices.map_or(seconds, |m| m.seconds.max(seconds)),
            bound: mode,
            matrices,
        })
    }
}

impl CostBound<'_> {
    /// True if the run exceeds `seconds` or the memory limit.
    pub fn is_beyond(&self, seconds: f64) -> bool {
        self.seconds > seconds || self.matrices.is_some_and(|m| m.bytes > MAX_BYTES)
    }

    /// Description as text.
    pub fn text(&self) -> String {
        if let Some(matrices) = &self.matrices {
            return matrices.text();
        }
        let text = format!(
            "it would take {} steps and {} at least",
            rounded(self.steps),
            format_duration(self.seconds)
        );
        match self.bound {
            Some(mode) => format!("{text}, for steps bound by stability: {}", mode.describe()),
            None => text,
        }
    }
}

/// Rejects histories of all outputs that exceed the memory limit; `histories` of them are held at a time.
///
/// # Errors
/// `BudgetExceeded` with the required memory.
pub fn check_memory(setup: &SimulationSetup, histories: usize) -> Result<(), Error> {
    let columns = histories * (setup.outputs.list.len() + 1);
    let numbers = columns as f64 * (setup.samples as f64 + 1.0);
    if numbers <= MAX_HISTORY_VALUES {
        return Ok(());
    }
    let message = format!(
        "{} at {} instants would take {:.0} GB (limit {:.0} GB)",
        pluralise(columns, "column"),
        setup.samples + 1,
        8e-9 * numbers,
        8e-9 * MAX_HISTORY_VALUES
    );
    Err(Error::new(Code::BudgetExceeded, message).with_hint("request fewer --samples"))
}

/// Rejects a simulation that exceeds the time budget, or whose history exceeds the memory limit.
///
/// # Errors
/// `BudgetExceeded` with the estimate and the remedies.
pub fn check_budget(
    setup: &SimulationSetup,
    choice: &MethodChoice,
    study: &SimulateStudy,
) -> Result<(), Error> {
    if study.running.history {
        check_memory(setup, 1)
            .map_err(|e| e.with_hint("request fewer --samples, or keep none with --no-history"))?;
    }
    let bound = CostModel::new(setup).lower_bound(choice.method, choice.step_size);
    let Some(bound) = bound.filter(|bound| bound.is_beyond(setup.time_budget_s)) else {
        return Ok(());
    };
    let room = match bound.matrices {
        Some(_) => format!(" and {:.0} GB", 1e-9 * MAX_BYTES),
        None => String::new(),
    };
    let message = format!(
        "{} would exceed the budget: {} (limit {}{room})",
        choice.method.name,
        bound.text(),
        format_duration(setup.time_budget_s)
    );
    if bound.matrices.is_some() {
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(matrix_hint(setup)));
    }
    let automatic = SimulateStudy {
        method: None,
        step: None,
        ..study.clone()
    };
    let other = choose_method(&setup.model.model, &automatic).ok();
    let other = other.filter(|other| other.method.name != choice.method.name);
    let other = other.map_or(String::new(), |other| {
        format!(
            ", or omit method and step: the plan takes {}",
            other.method.name
        )
    });
    let step = match choice.step_size {
        StepSize::Fixed(_) => ", take a longer step",
        StepSize::Adaptive(_) => "",
    };
    Err(Error::new(Code::BudgetExceeded, message).with_hint(format!(
        "request a shorter time (in {} at most t = {}), allow more with --allow {}{step}{other}",
        format_duration(setup.time_budget_s),
        format_time(setup.end_time * setup.time_budget_s / bound.seconds),
        suggested_time_limit(bound.seconds)
    )))
}

/// Hint for matrices that are too large.
fn matrix_hint(setup: &SimulationSetup) -> String {
    let model = &setup.model.model;
    let explicit = METHODS.iter().filter(|m| m.bound.is_some());
    let capable: Vec<&str> = explicit
        .filter(|m| (m.unsupported_reason)(model).is_none())
        .map(|m| m.name)
        .collect();
    match capable.is_empty() {
        true => "model the machine with fewer coordinates".to_string(),
        false => format!(
            "select one of {} by --method, which need no matrices; or model the machine with fewer coordinates",
            capable.join(", ")
        ),
    }
}
