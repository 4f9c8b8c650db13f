//! Transmission error of a chain: components by order, each with its source, and their sums.

use crate::base::error::Warning;
use crate::machine::parts::Machine;
use crate::numeric::Complex;
use crate::plan::transmission::run::{Answer, Row};
use crate::report::transmission::source;

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
    pub warnings: Vec<Warning>,
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
    pub(super) fn new(machine: &Machine, answer: Answer) -> TransmissionError {
        let component = |row: &Row| OrderComponent {
            order: row.line.order.value(),
            order_fraction: row.line.order.to_string(),
            source: source(machine, row),
            value: answer.slow(row),
            value_at_speed: row.dynamic,
            share: row.share,
        };
        TransmissionError {
            components: answer.rows.iter().map(component).collect(),
            worst_case: answer.budget.worst_case,
            rss: answer.budget.rss,
            warnings: answer.warnings,
        }
    }
}
