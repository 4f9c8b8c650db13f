//! Exact propagation of piecewise linear models from switch to switch.

use super::{IntegrationMethod, MethodFamily, StepControl, exact};
use crate::motion::dynamic_model::DynamicModel;

/// A sum of exponentials between switches, and switches as roots of it.
pub const METHOD: IntegrationMethod = IntegrationMethod {
    name: "switched",
    title: "play, stiffness in steps and dry friction as linear machines between switches",
    step_control: StepControl::Exact,
    order: None,
    family: MethodFamily::Propagation,
    bound: None,
    locates_events: true,
    unsupported_reason,
    run: exact::METHOD.run,
};

fn unsupported_reason(model: &DynamicModel) -> Option<String> {
    let message = "it takes machines that are linear between switches: play, rectangular stiffness at imposed speed, Coulomb friction";
    (!model.is_piecewise_linear()).then(|| message.to_string())
}
