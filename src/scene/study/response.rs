//! Options of frequency responses, run-ups and harmonic balance.

use super::{ReadStudy, SHARE, SpeedRange};
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::{TableReader, Word};

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

impl ResponseQuantity {
    /// Derivatives with respect to time, from displacement.
    pub fn derivative_order(self) -> u8 {
        self as u8
    }
}

impl Word for ResponseQuantity {
    const WORDS: &'static [(&'static str, ResponseQuantity, &'static str)] = &[
        ("receptance", ResponseQuantity::Receptance, "Displacement"),
        ("mobility", ResponseQuantity::Mobility, "Speed"),
        ("accelerance", ResponseQuantity::Accelerance, "Acceleration"),
    ];
}

/// Method of the response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseMethodTag {
    /// Solved line by line.
    Direct,
    /// A sum over modes.
    Modal,
}

impl Word for ResponseMethodTag {
    const WORDS: &'static [(&'static str, ResponseMethodTag, &'static str)] = &[
        ("direct", ResponseMethodTag::Direct, "Solved line by line"),
        ("modal", ResponseMethodTag::Modal, "A sum over all modes"),
    ];
}

/// The most lines of a response.
const MAX_LINES: u32 = 10_000_000;

impl ReadStudy for ResponseStudy {
    const KIND: &'static str = "response";

    fn read(f: &mut TableReader) -> ResponseStudy {
        f.accept_former("inputs", "input");
        f.accept_former("outputs", "output");
        f.accept_former("shown", "as");
        ResponseStudy {
            inputs: f.texts("input"),
            outputs: f.texts("output"),
            fixed_dofs: f.texts("hold"),
            motion_quantity: f.word("as"),
            band: f.parsed("band", parse_band),
            lines: f.optional_count("lines", 2, MAX_LINES),
            speed: f.optional_quantity("speed", QuantityKind::Speed, ValueRange::Any),
            way: f.word("method"),
        }
    }
}

/// Reads `A:B`, two frequencies (Hz where bare), into rad/s.
fn parse_band(text: &str, subject: &str) -> Result<(f64, f64), Error> {
    let band = ("a band", "10:500 or \"0 Hz:3 kHz\"");
    quantity::parse_range(text, QuantityKind::Frequency, band, subject)
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

impl ReadStudy for RunUpStudy {
    const KIND: &'static str = "run_up";

    fn read(f: &mut TableReader) -> RunUpStudy {
        f.accept_former("outputs", "output");
        RunUpStudy {
            speeds: f.parsed("speeds", SpeedRange::parse),
            outputs: f.texts("output"),
            fixed_dofs: f.texts("hold"),
        }
    }
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

impl ReadStudy for HarmonicBalanceStudy {
    const KIND: &'static str = "harmonic_balance";

    fn read(f: &mut TableReader) -> HarmonicBalanceStudy {
        f.accept_former("outputs", "output");
        HarmonicBalanceStudy {
            speeds: f.parsed("speeds", SpeedRange::parse),
            outputs: f.texts("output"),
            tolerance: f.optional_number("tolerance", SHARE),
            orders: f.optional_count("orders", 1, MAX_ORDERS),
            skip_event_refinement: f.flag("orders_alone"),
        }
    }
}
