//! Transmission error of a chain: components by order, each with its source, and their sums.

use crate::base::error::Diagnostic;
use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::plan::transmission::result::{OrderLineResult, TransmissionResult};

/// The transmission error of a chain at its output.
#[derive(Debug, Clone)]
pub struct TransmissionError {
    /// Components by rising order.
    pub components: Vec<OrderComponent>,
    /// Sum of all amplitudes with their tolerances, rad zero to peak.
    pub worst_case: f64,
    /// Root of the sum of squared amplitudes, rad zero to peak.
    pub rss: f64,
    /// Warnings about the chain.
    pub diagnostics: Vec<Diagnostic>,
}

/// One sinusoidal component of a transmission error.
#[derive(Debug, Clone)]
pub struct OrderComponent {
    /// Order per revolution of the reference shaft.
    pub order: f64,
    /// The order as an exact fraction.
    pub order_fraction: String,
    /// The element that has the error.
    pub source: String,
    /// Quasi-static amplitude and phase at the output, rad.
    pub value: Complex,
    /// The same at the speed of the study, where it names one.
    pub value_at_speed: Option<Complex>,
    /// Share of the sum of squared amplitudes.
    pub share: f64,
}

impl TransmissionError {
    pub(super) fn new(machine: &Machine, result: TransmissionResult) -> TransmissionError {
        let component = |row: &OrderLineResult| OrderComponent {
            order: row.line.order.to_f64(),
            order_fraction: row.line.order.to_string(),
            source: row.source(machine),
            value: result.quasi_static(row),
            value_at_speed: row.dynamic,
            share: row.share,
        };
        TransmissionError {
            components: result.lines.iter().map(component).collect(),
            worst_case: result.budget.worst_case,
            rss: result.budget.rss,
            diagnostics: result.diagnostics,
        }
    }
}
