//! Linear machines, propagated exactly whatever the step.

use super::{Kin, Ladder, Method};
use crate::base::error::Error;
use crate::motion::problem::{Ask, Effort, Problem, Sink};
use crate::motion::progress::check;
use crate::motion::segment::journey;
use crate::motion::segment::met::ROOM;
use crate::motion::train::Train;

/// A sum of exponentials.
pub const METHOD: Method = Method {
    name: "exact",
    title: "linear machines as a sum of exponentials",
    ladder: Ladder::Exact,
    order: None,
    kin: Kin::Propagation,
    bound: None,
    locates_events: true,
    refuses,
    run,
};

/// Checks what is asked, and flies.
fn run(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    journey::run(train, ask, ROOM, sink)
}

fn refuses(train: &Train) -> Option<String> {
    let message = "it takes linear machines only: constant stiffness and damping, known forces";
    (!train.is_linear()).then(|| message.to_string())
}
