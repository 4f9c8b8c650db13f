//! Motion in time: outputs with names and units at common instants.

use crate::base::error::Diagnostic;
use crate::motion::energy_balance::EnergyBalance;
use crate::plan::simulate::SimulationResult;

/// The motion of a machine.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// The outputs, in the order requested.
    pub outputs: Vec<MotionOutput>,
    /// The integration method that was used.
    pub method: &'static str,
    /// Energy balance of the run, if the study requests one.
    pub energy: Option<EnergyBalance>,
    /// Warnings about the machine and the integration.
    pub diagnostics: Vec<Diagnostic>,
}

/// One output over time.
#[derive(Debug, Clone)]
pub struct MotionOutput {
    /// Name, as requested.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// One value for each instant of [`Motion::time_s`].
    pub values: Vec<f64>,
}

impl Motion {
    pub(super) fn new(result: SimulationResult) -> Motion {
        let outputs = result.setup.outputs.list.into_iter();
        let outputs = outputs
            .zip(result.history.values)
            .map(|(output, values)| MotionOutput {
                name: output.name,
                unit: output.unit,
                values,
            });
        Motion {
            outputs: outputs.collect(),
            time_s: result.history.time,
            method: result.choice.method.name,
            energy: result.history.balance,
            diagnostics: result.diagnostics,
        }
    }

    /// The output called `name`.
    pub fn output(&self, name: &str) -> Option<&MotionOutput> {
        self.outputs.iter().find(|output| output.name == name)
    }
}
