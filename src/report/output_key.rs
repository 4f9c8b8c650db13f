//! Keys of the outputs of a motion in its document, and of what a run of it costs.

use serde_json::{Value, json};

use crate::motion::outputs::MotionOutput;
use crate::motion::problem::IntegrationStats;

/// Key of an output: its name and its unit in letters.
pub fn key(output: &MotionOutput) -> String {
    let unit = match output.unit {
        "rad/s" => "rad_s",
        "m/s" => "m_s",
        "rad/s²" => "rad_s2",
        "m/s²" => "m_s2",
        "N·m" => "nm",
        "N" => "n",
        other => other,
    };
    format!("{}_{unit}", output.name)
}

/// Cost of a run.
pub fn effort(stats: &IntegrationStats, seconds: f64) -> Value {
    json!({
        "run_time_s": seconds, "steps": stats.steps, "rejected": stats.rejected, "rhs_evaluations": stats.evaluations,
        "jacobians": stats.jacobians, "factorisations": stats.factorisations, "events": stats.events, "grazed": stats.grazings,
        "linear_machines": stats.regimes,
    })
}
