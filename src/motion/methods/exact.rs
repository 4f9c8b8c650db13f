//! Linear machines, propagated exactly whatever the step.

use super::{Ladder, Method};
use crate::motion::segment::journey;
use crate::motion::train::Train;

/// A sum of exponentials.
pub const METHOD: Method = Method {
    name: "exact",
    title: "linear machines as a sum of exponentials",
    ladder: Ladder::Exact,
    order: None,
    locates_events: true,
    refuses,
    run: journey::run,
};

fn refuses(train: &Train) -> Option<String> {
    let message = "it takes linear machines only: constant stiffness and damping, known forces";
    (!train.is_linear()).then(|| message.to_string())
}
