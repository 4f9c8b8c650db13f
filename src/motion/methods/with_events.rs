//! DOP853 and Radau5 with located events, and the same methods for a plain ODE.

use super::dop853::Dop853;
use super::radau::Radau5;
use crate::base::error::Error;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::error_scale::ErrorScale;
use crate::motion::events;
use crate::motion::pencil::DenseProblem;
use crate::motion::problem::{
    IntegrationOptions, IntegrationStats, OdeProblem, SampleSink, StepSize,
};
use crate::motion::progress::check_options;
use crate::motion::stepper::{self, StepSizeRule};

/// A machine by Dormand and Prince's method of order 8.
///
/// # Errors
/// Those of [`events::run`].
pub fn dop853(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    let mut stepper = Dop853::new(step_size(options), ErrorScale::for_model(model, options));
    events::run(model, options, sink, &mut stepper)
}

/// A machine by Radau IIA of order 5.
///
/// # Errors
/// Those of [`events::run`].
pub fn radau5(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    let mut stepper = Radau5::new(step_size(options), ErrorScale::for_model(model, options));
    events::run(model, options, sink, &mut stepper)
}

/// A plain problem by Dormand and Prince's method of order 8.
///
/// # Errors
/// Those of [`stepper::run`].
pub fn dop853_ode<P: OdeProblem>(
    problem: &P,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    let mut stepper = Dop853::new(step_size(options), ErrorScale::plain(problem.len()));
    stepper::run(problem, options, sink, &mut stepper)
}

/// A plain problem by Radau IIA of order 5.
///
/// # Errors
/// Those of [`stepper::run`].
pub fn radau5_ode<P: OdeProblem>(
    problem: &P,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    let mut stepper = Radau5::new(step_size(options), ErrorScale::plain(problem.len()));
    stepper::run(&DenseProblem(problem), options, sink, &mut stepper)
}

/// Step-size rule of the options.
pub(super) fn step_size(options: &IntegrationOptions) -> StepSizeRule {
    match options.step_size {
        StepSize::Adaptive(tolerance) => StepSizeRule::Tolerance(tolerance),
        StepSize::Fixed(h) => StepSizeRule::Fixed(h),
    }
}
