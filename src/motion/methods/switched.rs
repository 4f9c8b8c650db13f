//! Machines that are linear between switches, propagated exactly from one switch to the next.

use super::{Kin, Ladder, Method, exact};
use crate::motion::train::Train;

/// A sum of exponentials between switches, and switches as roots of it.
pub const METHOD: Method = Method {
    name: "switched",
    title: "play, stiffness in steps and dry friction as linear machines between switches",
    ladder: Ladder::Exact,
    order: None,
    kin: Kin::Propagation,
    bound: None,
    locates_events: true,
    refuses,
    run: exact::METHOD.run,
};

fn refuses(train: &Train) -> Option<String> {
    let message = "it takes machines that are linear between switches: play, rectangular stiffness at imposed speed, Coulomb friction";
    (!train.is_piecewise_linear()).then(|| message.to_string())
}
