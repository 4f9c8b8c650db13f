//! Exact propagation of linear models, for any step size.

use super::{IntegrationMethod, MethodFamily, StepControl};
use crate::base::error::Error;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::problem::{IntegrationOptions, IntegrationStats, OdeProblem, SampleSink};
use crate::motion::progress::check_options;
use crate::motion::segment::regime_cache::MAX_BYTES;
use crate::motion::segment::run;

/// A sum of exponentials.
pub const METHOD: IntegrationMethod = IntegrationMethod {
    name: "exact",
    title: "linear machines as a sum of exponentials",
    step_control: StepControl::Exact,
    order: None,
    family: MethodFamily::Propagation,
    bound: None,
    locates_events: true,
    unsupported_reason,
    run,
};

/// Checks the options and integrates.
fn run(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    run::run(model, options, MAX_BYTES, sink)
}

fn unsupported_reason(model: &DynamicModel) -> Option<String> {
    let message = "it takes linear machines only: constant stiffness and damping, known forces";
    (!model.is_linear()).then(|| message.to_string())
}
