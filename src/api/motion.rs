//! Motion in time: outputs with names and units at common instants.

use crate::base::error::Warning;
use crate::plan::simulate::Moved;

/// The motion of a machine.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// The outputs, in the order requested.
    pub outputs: Vec<MotionOutput>,
    /// The integration method that was used.
    pub method: &'static str,
    /// Warnings about the machine and the integration.
    pub warnings: Vec<Warning>,
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
    pub(super) fn new(moved: Moved) -> Motion {
        let outputs = moved.scene.outputs.list.into_iter();
        let outputs = outputs
            .zip(moved.motion.values)
            .map(|(output, values)| MotionOutput {
                name: output.name,
                unit: output.unit,
                values,
            });
        Motion {
            outputs: outputs.collect(),
            time_s: moved.motion.time,
            method: moved.choice.method.name,
            warnings: moved.warnings,
        }
    }

    /// The output called `name`.
    pub fn output(&self, name: &str) -> Option<&MotionOutput> {
        self.outputs.iter().find(|output| output.name == name)
    }
}
