//! Options of frequency responses, run-ups and harmonic balance.

use super::{SpeedRange, parsed, texts};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;

/// Steady-state responses to steady excitation, with the options of the command.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ResponseStudy {
    /// Excitations: `node.axis`, `branch.displacement`, `ground.x`, `node.axis.motion`.
    pub inputs: Vec<String>,
    /// Measured outputs: `node.axis`, `.speed`, `.acceleration`, sums, `branch.force`, `branch.deflection`.
    pub outputs: Vec<String>,
    /// Degrees of freedom held still.
    pub fixed_dofs: Vec<String>,
    /// Motions are shown as displacement, speed or acceleration; as named where absent.
    pub motion_quantity: Option<ResponseQuantity>,
    /// From and to, rad/s.
    pub band: Option<(f64, f64)>,
    /// Lines in the band, both ends included.
    pub lines: Option<u32>,
    /// Speed of the first node of `[speed]`, rad/s.
    pub speed: Option<f64>,
    /// Method of the response; chosen where absent.
    pub way: Option<ResponseMethodTag>,
}

/// Displayed quantity of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseQuantity {
    /// Displacement.
    Receptance,
    /// Speed.
    Mobility,
    /// Acceleration.
    Accelerance,
}

/// Method of the response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseMethodTag {
    /// Solved line by line.
    Direct,
    /// A sum over modes.
    Modal,
}

/// The most lines of a response.
pub const MAX_LINES: u32 = 10_000_000;

/// Reads its keys.
pub(super) fn response(f: &mut TableReader) -> ResponseStudy {
    let shown = [
        ("receptance", ResponseQuantity::Receptance),
        ("mobility", ResponseQuantity::Mobility),
        ("accelerance", ResponseQuantity::Accelerance),
    ];
    let ways = [
        ("direct", ResponseMethodTag::Direct),
        ("modal", ResponseMethodTag::Modal),
    ];
    ResponseStudy {
        inputs: texts(f, "inputs"),
        outputs: texts(f, "outputs"),
        fixed_dofs: texts(f, "hold"),
        motion_quantity: f.choice("shown", &shown),
        band: parsed(f, "band", parse_band),
        lines: f.optional_count("lines", 2, MAX_LINES),
        speed: f.optional_quantity("speed", QuantityKind::Speed, ValueRange::Any),
        way: f.choice("method", &ways),
    }
}

/// Reads `A:B`, two frequencies (Hz where bare), into rad/s.
///
/// # Errors
/// What is no rising range of frequencies.
pub fn parse_band(text: &str, subject: &str) -> Result<(f64, f64), Error> {
    let form = || {
        let message = format!("\"{}\" is not a band", quantity::truncate(text));
        let hint = format!("{subject} takes first:last, such as 10:500 or \"0 Hz:3 kHz\"");
        Error::new(Code::OutOfRange, message).with_hint(hint)
    };
    let (from, to) = text.split_once(':').ok_or_else(form)?;
    let frequency =
        |text: &str| quantity::parse_or_bare(text, QuantityKind::Frequency, "Hz", subject);
    let (from, to) = (frequency(from)?, frequency(to)?);
    match from >= 0.0 && from < to && to.is_finite() {
        true => Ok((from, to)),
        false => Err(form()),
    }
}

/// Responses to all orders of a running machine over speed, with the options of the command.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunUpStudy {
    /// Speeds of the first node of `[speed]`.
    pub speeds: Option<SpeedRange>,
    /// Measured outputs, as of a frequency response; forces in all meshes by default.
    pub outputs: Vec<String>,
    /// Degrees of freedom held still.
    pub fixed_dofs: Vec<String>,
}

/// Periodic motions over speed, as the command has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HarmonicBalanceStudy {
    /// Speeds of the first node of `[speed]`; the number of points bounds the steps.
    pub speeds: Option<SpeedRange>,
    /// Signals as of a motion; deflections of what has play or varies by default.
    pub outputs: Vec<String>,
    /// Tolerance for higher orders, relative to the deflections.
    pub tolerance: Option<f64>,
    /// So many orders; as many as the tolerance asks where absent.
    pub orders: Option<u32>,
    /// By orders alone, without refining motions by events.
    pub skip_event_refinement: bool,
}

/// The most orders of a balance.
pub const MAX_ORDERS: u32 = 500;
