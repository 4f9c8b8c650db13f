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

/// Numbers that a history may hold.
const MAX_HISTORY_VALUES: f64 = MAX_BYTES / 8.0;

/// Cost model of the steps of a scene.
pub struct CostModel<'s> {
    until: f64,
    coordinates: usize,
    /// Seconds of one evaluation of f.
    evaluation: f64,
    fastest: Option<FastestMode<'s>>,
}

/// A run costs at least this.
pub struct CostBound<'s> {
    /// Steps at least; 0 where nothing bounds them.
    pub steps: f64,
    /// Seconds.
    pub seconds: f64,
    /// Fastest mode, which bounds the steps; absent where the study gives them.
    pub bound: Option<FastestMode<'s>>,
    /// Cost of the matrices, where these cost more than the steps.
    pub matrices: Option<DenseCost>,
}

impl<'s> CostModel<'s> {
    /// Times an evaluation of f, in a millisecond.
    pub fn new(scene: &'s SimulationSetup) -> CostModel<'s> {
        let model = &scene.model.model;
        let mut slope = vec![0.0; model.len()];
        let begin = Instant::now();
        let mut least = f64::INFINITY;
        while begin.elapsed().as_secs_f64() < 1e-3 {
            const TIMED_EVALUATIONS: u32 = 16;
            let some = Instant::now();
            (0..TIMED_EVALUATIONS)
                .for_each(|_| model.derivative(0.0, &scene.initial_state, &mut slope));
            least = least.min(some.elapsed().as_secs_f64() / f64::from(TIMED_EVALUATIONS));
        }
        CostModel {
            until: scene.end_time,
            coordinates: model.coordinate_count(),
            evaluation: least,
            fastest: fastest_mode(model),
        }
    }

    /// Lower bound of the cost of a run by a method; absent where there is no estimate beforehand.
    pub fn lower_bound(&self, method: &IntegrationMethod, size: StepSize) -> Option<CostBound<'s>> {
        let stages = method.bound.map_or(1.0, |b| f64::from(b.stages));
        let (steps, by) = match (size, method.bound, self.fastest) {
            (StepSize::Fixed(h), ..) => (self.until / h, None),
            (StepSize::Adaptive(_), Some(bound), Some(fastest)) => {
                (self.until * fastest.rate / bound.radius, Some(fastest))
            }
            _ => (0.0, None),
        };
        let seconds = steps * stages * self.evaluation;
        let matrices = DenseCost::for_method(method, self.coordinates);
        let matrices = matrices.filter(|m| m.seconds > seconds || m.bytes > MAX_BYTES);
        (steps > 0.0 || matrices.is_some()).then(|| CostBound {
            steps,
            seconds: matrices.map_or(seconds, |m| m.seconds.max(seconds)),
            bound: by,
            matrices,
        })
    }
}

impl CostBound<'_> {
    /// More than so many seconds, or than the room there is.
    pub fn is_beyond(&self, seconds: f64) -> bool {
        self.seconds > seconds || self.matrices.is_some_and(|m| m.bytes > MAX_BYTES)
    }

    /// In words.
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
            Some(by) => format!("{text}, for steps bound by stability: {}", by.describe()),
            None => text,
        }
    }
}

/// Refuses histories of all outputs, so many at a time, that would take more room than is allowed.
///
/// # Errors
/// `BudgetExceeded`, with what they would take.
pub fn check_memory(setup: &SimulationSetup, histories: usize) -> Result<(), Error> {
    let columns = histories * (setup.outputs.list.len() + 1);
    let numbers = columns as f64 * (setup.samples as f64 + 1.0);
    if numbers <= MAX_HISTORY_VALUES {
        return Ok(());
    }
    let message = format!(
        "{} at {} instants would take {:.0} GB, and {:.0} are allowed",
        pluralise(columns, "column"),
        setup.samples + 1,
        8e-9 * numbers,
        8e-9 * MAX_HISTORY_VALUES
    );
    Err(Error::new(Code::BudgetExceeded, message).with_hint("request fewer --samples"))
}

/// Refuses a motion that would take longer than is allowed, or whose history would take more room.
///
/// # Errors
/// `BudgetExceeded`, with the estimate and what to try.
pub fn check_budget(
    setup: &SimulationSetup,
    choice: &MethodChoice,
    study: &SimulateStudy,
) -> Result<(), Error> {
    if study.running.history {
        check_memory(setup, 1)
            .map_err(|e| e.with_hint("request fewer --samples, or keep none with --no-history"))?;
    }
    let least = CostModel::new(setup).lower_bound(choice.method, choice.step_size);
    let Some(least) = least.filter(|least| least.is_beyond(setup.time_budget_s)) else {
        return Ok(());
    };
    let room = match least.matrices {
        Some(_) => format!(" and {:.0} GB", 1e-9 * MAX_BYTES),
        None => String::new(),
    };
    let message = format!(
        "{} would exceed the budget: {}, and {}{room} are allowed",
        choice.method.name,
        least.text(),
        format_duration(setup.time_budget_s)
    );
    if least.matrices.is_some() {
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(matrix_hint(setup)));
    }
    let free = SimulateStudy {
        method: None,
        step: None,
        ..study.clone()
    };
    let other = choose_method(&setup.model.model, &free).ok();
    let other = other.filter(|other| other.method.name != choice.method.name);
    let other = other.map_or(String::new(), |other| {
        format!(
            ", or leave method and step out: the plan takes {}",
            other.method.name
        )
    });
    let step = match choice.step_size {
        StepSize::Fixed(_) => ", take a longer step",
        StepSize::Adaptive(_) => "",
    };
    Err(Error::new(Code::BudgetExceeded, message).with_hint(format!(
        "request a shorter time ({} reach t = {} at most), allow more with --allow {}{step}{other}",
        format_duration(setup.time_budget_s),
        format_time(setup.end_time * setup.time_budget_s / least.seconds),
        suggested_time_limit(least.seconds)
    )))
}

/// Hint for matrices that are too large.
fn matrix_hint(setup: &SimulationSetup) -> String {
    let train = &setup.model.model;
    let explicit = METHODS.iter().filter(|m| m.bound.is_some());
    let able: Vec<&str> = explicit
        .filter(|m| (m.unsupported_reason)(train).is_none())
        .map(|m| m.name)
        .collect();
    match able.is_empty() {
        true => "model the machine with fewer coordinates".to_string(),
        false => format!(
            "{} go without matrices: name one by --method; or model the machine with fewer coordinates",
            able.join(", ")
        ),
    }
}
