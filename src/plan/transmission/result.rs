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

/// The transmission error of a chain.
pub struct TransmissionResult {
    /// The chain.
    pub chain: TransmissionChain,
    /// Every line, by rising order.
    pub lines: Vec<OrderLineResult>,
    /// Orders that coincide, by numbers of rows.
    pub coincidences: Vec<OrderCoincidence>,
    /// After so many turns of what orders are counted by everything repeats; absent where there is no line.
    pub period: Option<Fraction>,
    /// Branches of a rigid loop that is inconsistent with the errors, so that only elastic joints have a solution.
    pub inconsistent_loop: Option<Vec<String>>,
    /// Sums and percentiles.
    pub budget: ErrorBudget,
    /// Names of the elements of the budget.
    pub elements: Vec<String>,
    /// Dynamic budget at speed, on request.
    pub at_speed: Option<DynamicBudget>,
    /// Elements that could be left out, and what that takes off the root of the sum of squares and off the worst case.
    pub negligible: (Vec<usize>, f64, f64),
    /// Second order of offsets, which the lines leave out, at the output, rad.
    pub second_order: f64,
    /// Effect of each line on work that is indexed tooth by tooth.
    pub marks: Option<Vec<IndexingEffect>>,
    /// Lines over speed.
    pub map: Option<SpeedMap>,
    /// Work of generators, cut with the lines: of this machine, and of the gears that it runs.
    pub works: Vec<Arc<WorkResult>>,
    /// The error over the angle.
    pub record: Option<TransmissionErrorRecord>,
    /// By how much the mean loads wind up the chain, rad.
    pub wind_up: f64,
    /// m.
    pub radius: Option<f64>,
    /// Speed of what orders are counted by, for the error at speed, rad/s.
    pub speed: Option<f64>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Sums at speed.
pub struct DynamicBudget {
    /// Sums and percentiles.
    pub budget: ErrorBudget,
    /// As [`TransmissionResult::negligible`].
    pub negligible: (Vec<usize>, f64, f64),
}

/// A line of the table.
pub struct OrderLineResult {
    /// Source and order of the line.
    pub line: OrderLine,
    /// A and ψ at the output with rigid joints, slowly, rad; absent where they would lock: a loop does not fit this line alone.
    pub kinematic: Option<Complex>,
    /// The same under load, where joints give way.
    pub loaded: Complex,
    /// The same at speed.
    pub dynamic: Option<Complex>,
    /// Share of the sum of squared amplitudes.
    pub share: f64,
}

impl OrderLineResult {
    /// The element that the line comes from.
    pub fn source(&self, machine: &Machine) -> String {
        match self.line.origin {
            LineOrigin::Declared(number) => machine.errors[number].location.clone(),
            LineOrigin::Stiffness(branch) => machine.branch_name(branch),
        }
    }

    /// Cause of the line.
    pub fn cause(&self, machine: &Machine) -> &'static str {
        match self.line.origin {
            LineOrigin::Declared(number) => machine.errors[number].cause.name(),
            LineOrigin::Stiffness(_) => "mesh stiffness",
        }
    }

    /// Phase of a value of the line, degrees in (−180, 180], where it is known.
    pub fn phase(&self, machine: &Machine, value: Complex) -> Option<f64> {
        /// Rounding of a half turn backward, as a share of a turn.
        const ROUNDING: f64 = 1e-9;
        let turned = match value.arg().to_degrees() {
            half if half <= -180.0 + ROUNDING => half + 360.0,
            other => other,
        };
        (self.line.phase_known(machine) && value.norm() > 0.0).then_some(turned)
    }
}

impl TransmissionResult {
    /// Quasi-static A and ψ of a row: with rigid joints where these have a solution, in loops as the elastic joints share it out.
    pub fn quasi_static(&self, row: &OrderLineResult) -> Complex {
        match row.line.origin {
            LineOrigin::Declared(_) if self.has_rigid_solution() => row.line.quasi_static,
            _ => row.loaded,
        }
    }

    /// Largest A of a row over the requested conditions: quasi-static, at speed, over speeds, rad.
    pub fn max_amplitude(&self, row: usize) -> f64 {
        let slow = self.quasi_static(&self.lines[row]).norm();
        let at_speed = self.lines[row].dynamic.map_or(0.0, |z| z.norm());
        let over = self.map.as_ref().map_or(0.0, |map| map.largest[row].1);
        slow.max(at_speed).max(over)
    }

    /// Some line is another under load than with rigid joints, beyond what is shown of either.
    pub fn load_changes_lines(&self) -> bool {
        /// Half a unit of the fourth digit, and rounding of the largest.
        const DISPLAY_TOLERANCE: (f64, f64) = (5e-4, 1e-9);
        let largest = self
            .lines
            .iter()
            .fold(0.0f64, |m, r| m.max(r.loaded.norm()));
        let differs = |row: &OrderLineResult| {
            let loaded = row.loaded.norm();
            let off = |rigid: Complex| (rigid.norm() - loaded).abs();
            let shown = DISPLAY_TOLERANCE.0 * loaded + DISPLAY_TOLERANCE.1 * largest;
            row.kinematic.is_none_or(|rigid| off(rigid) > shown)
        };
        self.lines.iter().any(differs)
    }

    /// True if rigid joints have a solution for every single error: no loop shares it out.
    pub fn has_rigid_solution(&self) -> bool {
        self.chain.loop_conditions.is_empty()
    }
}
