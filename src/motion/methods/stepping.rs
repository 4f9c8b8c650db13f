//! Methods with error control, a dense output and located events, and the same methods on plain problems.

use super::dop853::Dop853;
use super::radau::Radau;
use crate::base::error::Error;
use crate::motion::events;
use crate::motion::pencil::Plain;
use crate::motion::problem::{Ask, Effort, Problem, Sink, Wanted};
use crate::motion::progress::check;
use crate::motion::scale::Scale;
use crate::motion::stepper::{self, Control};
use crate::motion::train::Train;

/// A machine by Dormand and Prince's method of order 8.
///
/// # Errors
/// Those of [`events::run`].
pub fn dop853(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    let mut stepper = Dop853::new(control(ask), Scale::of_train(train, ask));
    events::run(train, ask, sink, &mut stepper)
}

/// A machine by Radau IIA of order 5.
///
/// # Errors
/// Those of [`events::run`].
pub fn radau5(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    let mut stepper = Radau::new(control(ask), Scale::of_train(train, ask));
    events::run(train, ask, sink, &mut stepper)
}

/// A plain problem by Dormand and Prince's method of order 8.
///
/// # Errors
/// Those of [`stepper::run`].
pub fn dop853_plain<P: Problem>(problem: &P, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    let mut stepper = Dop853::new(control(ask), Scale::plain(problem.len()));
    stepper::run(problem, ask, sink, &mut stepper)
}

/// A plain problem by Radau IIA of order 5.
///
/// # Errors
/// Those of [`stepper::run`].
pub fn radau5_plain<P: Problem>(problem: &P, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    let mut stepper = Radau::new(control(ask), Scale::plain(problem.len()));
    stepper::run(&Plain(problem), ask, sink, &mut stepper)
}

/// How steps are chosen.
pub(super) fn control(ask: &Ask) -> Control {
    match ask.effort {
        Wanted::Tolerance(tolerance) => Control::Tolerance(tolerance),
        Wanted::Step(h) => Control::Fixed(h),
    }
}
