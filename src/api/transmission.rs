//! Transmission error of a chain: components by order, each with its source, and their sums; over speed and over the angle.

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
    /// Amplitudes over speed, if the study requests speeds.
    pub over_speed: Option<AmplitudesOverSpeed>,
    /// Error over the angle of the output, if the study requests a record.
    pub record: Option<ErrorRecord>,
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

/// Dynamic amplitudes of all components over the speed of the first node of `[speed]`.
#[derive(Debug, Clone)]
pub struct AmplitudesOverSpeed {
    /// Speeds, rad/s.
    pub speeds: Vec<f64>,
    /// Amplitudes, rad zero to peak: components × speeds.
    pub amplitudes: Vec<Vec<f64>>,
    /// Speed (rad/s) and amplitude (rad) of the largest value of each component; resonances between the speeds are
    /// included unless one is undamped.
    pub largest: Vec<(f64, f64)>,
}

/// Transmission error over the angle; unknown phases are drawn from a fixed seed.
#[derive(Debug, Clone)]
pub struct ErrorRecord {
    /// Length, revolutions of the output.
    pub revolutions: usize,
    /// Errors at equally spaced output angles, `2π revolutions/len` apart from zero, rad: at the speed of the study, or quasi-static without
    /// one.
    pub values: Vec<f64>,
    /// Total single-flank composite deviation F_i′ over the record, rad.
    pub total_deviation: f64,
    /// Largest F_i′ of one revolution, rad.
    pub deviation_per_revolution: f64,
    /// Tooth-to-tooth deviation f_i′, rad, if the output has teeth.
    pub tooth_to_tooth_deviation: Option<f64>,
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
            over_speed: result.map.map(|map| AmplitudesOverSpeed {
                speeds: map.speeds,
                amplitudes: map.amplitudes,
                largest: map.largest,
            }),
            record: result.record.map(|evaluated| ErrorRecord {
                revolutions: evaluated.record.turns,
                values: evaluated.record.values,
                total_deviation: evaluated.total,
                deviation_per_revolution: evaluated.per_revolution,
                tooth_to_tooth_deviation: evaluated.per_tooth.map(|[tooth, ..]| tooth),
            }),
            diagnostics: result.diagnostics,
        }
    }
}
