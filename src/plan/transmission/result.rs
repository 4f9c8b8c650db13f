//! Result of a transmission-error study.

use std::sync::Arc;

use crate::base::error::Diagnostic;
use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::plan::meshes::work::WorkResult;
use crate::plan::stages::StageDecision;
use crate::plan::transmission::error_record::TransmissionErrorRecord;
use crate::transmission::budget::ErrorBudget;
use crate::transmission::chain::TransmissionChain;
use crate::transmission::coincidence::OrderCoincidence;
use crate::transmission::indexing::IndexingEffect;
use crate::transmission::order_lines::{LineOrigin, OrderLine};
use crate::transmission::speed_map::SpeedMap;

/// Transmission error of a chain: order lines, error budget and their evaluation over speed.
pub struct TransmissionResult {
    /// Transmission chain.
    pub chain: TransmissionChain,
    /// Order lines, ascending in order.
    pub lines: Vec<OrderLineResult>,
    /// Coinciding orders, by indices into [`TransmissionResult::lines`].
    pub coincidences: Vec<OrderCoincidence>,
    /// Period of the error, turns of the reference of the orders; `None` without lines.
    pub period: Option<Fraction>,
    /// Branches of a rigid loop that the errors make inconsistent, so that only elastic joints have a solution.
    pub inconsistent_loop: Option<Vec<String>>,
    /// Sums and percentiles.
    pub budget: ErrorBudget,
    /// Names of the elements of the budget.
    pub elements: Vec<String>,
    /// Dynamic budget at speed, if requested.
    pub dynamic_budget: Option<DynamicBudget>,
    /// Negligible elements of the budget, and the reductions of the root sum of squares and of the worst case without them.
    pub negligible: (Vec<usize>, f64, f64),
    /// Second-order error of eccentricities at the output, rad, which the lines neglect.
    pub second_order: f64,
    /// Effect of each line on a workpiece that is indexed tooth by tooth.
    pub indexing_effects: Option<Vec<IndexingEffect>>,
    /// Amplitudes of the lines over speed.
    pub map: Option<SpeedMap>,
    /// Workpieces generated with the order lines: the work of this machine, and the gears that it contains.
    pub workpieces: Vec<Arc<WorkResult>>,
    /// Transmission error over the angle.
    pub record: Option<TransmissionErrorRecord>,
    /// Wind-up of the chain under the mean loads, rad.
    pub wind_up: f64,
    /// Radius at which the error is also given as an arc length, m.
    pub radius: Option<f64>,
    /// Speed of the reference of the orders for the dynamic error, rad/s.
    pub speed: Option<f64>,
    /// Stages with their decisions.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Dynamic error budget at speed.
pub struct DynamicBudget {
    /// Sums and percentiles.
    pub budget: ErrorBudget,
    /// As [`TransmissionResult::negligible`].
    pub negligible: (Vec<usize>, f64, f64),
}

/// Order line with its amplitudes at the output.
pub struct OrderLineResult {
    /// Source and order of the line.
    pub line: OrderLine,
    /// Quasi-static A and ψ at the output with rigid joints, rad; `None` if a rigid loop is inconsistent with this line alone.
    pub kinematic: Option<Complex>,
    /// Quasi-static A and ψ at the output with elastic joints under load, rad.
    pub loaded: Complex,
    /// Dynamic A and ψ at the output at speed, rad.
    pub dynamic: Option<Complex>,
    /// Share of the sum of squared amplitudes, 0 to 1.
    pub share: f64,
}

impl OrderLineResult {
    /// Location of the declared error, or the name of the mesh.
    pub fn source(&self, machine: &Machine) -> String {
        match self.line.origin {
            LineOrigin::Declared(number) => machine.errors[number].location.clone(),
            LineOrigin::Stiffness(branch) => machine.branch_name(branch),
        }
    }

    /// Cause of the declared error, or the mesh stiffness.
    pub fn cause(&self, machine: &Machine) -> &'static str {
        match self.line.origin {
            LineOrigin::Declared(number) => machine.errors[number].cause.name(),
            LineOrigin::Stiffness(_) => "mesh stiffness",
        }
    }

    /// Phase of a value of the line, degrees in (−180, 180]; `None` if it is unknown or the value is zero.
    pub fn phase(&self, machine: &Machine, value: Complex) -> Option<f64> {
        /// Rounding of a phase of −180°, degrees.
        const ROUNDING: f64 = 1e-9;
        let degrees = match value.arg().to_degrees() {
            angle if angle <= -180.0 + ROUNDING => angle + 360.0,
            angle => angle,
        };
        (self.line.phase_known(machine) && value.norm() > 0.0).then_some(degrees)
    }
}

impl TransmissionResult {
    /// Quasi-static A and ψ of a row, rad: with rigid joints if they have a solution, else with elastic joints.
    pub fn quasi_static(&self, row: &OrderLineResult) -> Complex {
        match row.line.origin {
            LineOrigin::Declared(_) if self.has_rigid_solution() => row.line.quasi_static,
            _ => row.loaded,
        }
    }

    /// Largest A of a row over the requested conditions (quasi-static, at speed, over speeds), rad.
    pub fn max_amplitude(&self, row: usize) -> f64 {
        let quasi_static = self.quasi_static(&self.lines[row]).norm();
        let at_speed = self.lines[row].dynamic.map_or(0.0, |z| z.norm());
        let over_speeds = self.map.as_ref().map_or(0.0, |map| map.largest[row].1);
        quasi_static.max(at_speed).max(over_speeds)
    }

    /// Whether the displayed amplitude of any line differs between elastic and rigid joints.
    pub fn load_changes_lines(&self) -> bool {
        /// Half a unit of the fourth digit, and rounding relative to the largest amplitude.
        const DISPLAY_TOLERANCE: (f64, f64) = (5e-4, 1e-9);
        let largest = self
            .lines
            .iter()
            .fold(0.0f64, |m, r| m.max(r.loaded.norm()));
        let differs = |row: &OrderLineResult| {
            let loaded = row.loaded.norm();
            let difference = |rigid: Complex| (rigid.norm() - loaded).abs();
            let limit = DISPLAY_TOLERANCE.0 * loaded + DISPLAY_TOLERANCE.1 * largest;
            row.kinematic.is_none_or(|rigid| difference(rigid) > limit)
        };
        self.lines.iter().any(differs)
    }

    /// Whether rigid joints have a solution for every single error: the chain has no closed loop.
    pub fn has_rigid_solution(&self) -> bool {
        self.chain.loop_conditions.is_empty()
    }
}
