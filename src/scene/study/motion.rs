//! Options of simulations and of the online analysis during integration.

use super::{ReadStudy, SHARE};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::scene::shared_keys::MAX_COUNT;

/// Motion in time, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SimulateStudy {
    /// To this instant, s; from zero.
    pub end_time: Option<f64>,
    /// Signals: `node.axis`, `node.axis.speed`, `node.axis.acceleration`, `branch.force`, `branch.deflection`.
    pub outputs: Vec<String>,
    /// The method by its word; chosen where absent.
    pub method: Option<String>,
    /// Local error per step, relative.
    pub tolerance: Option<f64>,
    /// Fixed step, s.
    pub step: Option<f64>,
    /// Number of equal steps of the outputs over the time.
    pub samples: Option<u32>,
    /// The energy balance.
    pub energy: bool,
    /// Speed of the first node of `[speed]` in place of the model's, rad/s.
    pub speed: Option<f64>,
    /// Time budget, s.
    pub time_limit: Option<f64>,
    /// No second run tells how the motion amplifies a change of its start.
    pub no_sensitivity: bool,
    /// Online analysis during the run.
    pub running: OnlineStudy,
}

/// The most samples of a motion.
const MAX_SAMPLES: u32 = 100_000_000;

impl SimulateStudy {
    /// Reads the keys of the motion alone.
    pub(super) fn read_motion(f: &mut TableReader) -> SimulateStudy {
        f.accept_former("outputs", "output");
        f.exclusive("tolerance", "step");
        SimulateStudy {
            end_time: f.optional_quantity("until", QuantityKind::Time, ValueRange::Positive),
            outputs: f.texts("output"),
            method: f.optional_text("method").map(str::to_string),
            tolerance: f.optional_number("tolerance", SHARE),
            step: f.optional_quantity("step", QuantityKind::Time, ValueRange::Positive),
            samples: f.optional_count("samples", 1, MAX_SAMPLES),
            energy: f.flag("energy"),
            speed: f.optional_quantity("speed", QuantityKind::Speed, ValueRange::Any),
            time_limit: None,
            no_sensitivity: f.optional_flag("sensitivity") == Some(false),
            running: OnlineStudy::default(),
        }
    }
}

impl ReadStudy for SimulateStudy {
    const KIND: &'static str = "simulate";

    fn read(f: &mut TableReader) -> SimulateStudy {
        SimulateStudy {
            time_limit: f.optional_quantity("allow", QuantityKind::Time, ValueRange::Positive),
            running: OnlineStudy::read(f),
            ..SimulateStudy::read_motion(f)
        }
    }
}

/// Online analysis of a motion while it runs, without its history.
#[derive(Debug, Clone, PartialEq)]
pub struct OnlineStudy {
    /// The history of the outputs is kept.
    pub history: bool,
    /// Spectra of the outputs over blocks of so many samples.
    pub spectrum: Option<u32>,
    /// Orders of the outputs.
    pub track: Option<OrderTrackingStudy>,
    /// Over so many turns each point of the orders is a mean.
    pub turns: u32,
    /// Transmission error of the second node against the first.
    pub te: Option<[String; 2]>,
    /// Teeth between both, driver first: `21:63` or `21:63,17:40`.
    pub teeth: Option<String>,
}

/// Turns of a point of the orders by default.
pub const DEFAULT_AVERAGING_REVS: u32 = 8;

/// Samples of a block at least and at most.
const BLOCK_SIZES: std::ops::RangeInclusive<u32> = 16..=(1 << 24);

impl Default for OnlineStudy {
    fn default() -> OnlineStudy {
        OnlineStudy {
            history: true,
            spectrum: None,
            track: None,
            turns: DEFAULT_AVERAGING_REVS,
            te: None,
            teeth: None,
        }
    }
}

impl OnlineStudy {
    /// Reads its keys.
    fn read(f: &mut TableReader) -> OnlineStudy {
        let usual = OnlineStudy::default();
        let history = f.choice("history", &[("kept", true), ("none", false)]);
        let turns = f.optional_count("turns", 1, MAX_COUNT);
        let study = OnlineStudy {
            history: history.unwrap_or(usual.history),
            spectrum: f.optional_count("spectrum", *BLOCK_SIZES.start(), *BLOCK_SIZES.end()),
            track: f.parsed("track", OrderTrackingStudy::parse),
            turns: turns.unwrap_or(usual.turns),
            te: f.parsed("te", parse_shaft_pair),
            teeth: f.optional_text("teeth").map(str::to_string),
        };
        f.requires("turns", "track");
        f.requires("te", "teeth");
        f.requires("teeth", "te");
        study
    }
}

/// Orders followed over the angle of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderTrackingStudy {
    /// The node they turn with.
    pub node: String,
    /// Cycles a turn of it.
    pub orders: Vec<f64>,
}

/// The most orders followed at once.
const MAX_TRACKED: usize = 100;

impl OrderTrackingStudy {
    /// Reads `NODE:ORDER,ORDER…`, orders as numbers or fractions.
    ///
    /// # Errors
    /// What is not of that form.
    pub fn parse(text: &str, subject: &str) -> Result<OrderTrackingStudy, Error> {
        let order = |text: &str| -> Option<f64> {
            let number = |text: &str| text.trim().parse::<f64>().ok();
            let value = match text.split_once('/') {
                Some((a, b)) => number(a)? / number(b)?,
                None => number(text)?,
            };
            (value > 0.0 && value.is_finite()).then_some(value)
        };
        let read = text.rsplit_once(':').and_then(|(node, orders)| {
            let orders = orders.split(',').map(order).collect::<Option<Vec<f64>>>()?;
            (orders.len() <= MAX_TRACKED).then(|| OrderTrackingStudy {
                node: node.trim().to_string(),
                orders,
            })
        });
        read.ok_or_else(|| {
            let message = format!("\"{}\" is not orders of a node", quantity::truncate(text));
            let hint =
                format!("{subject} takes node:order,order…, such as motor:1,21 or motor:37/12");
            Error::new(Code::OutOfRange, message).with_hint(hint)
        })
    }
}

/// Reads `INPUT:OUTPUT`, two nodes.
///
/// # Errors
/// What is not of that form.
fn parse_shaft_pair(text: &str, subject: &str) -> Result<[String; 2], Error> {
    match text.split_once(':') {
        Some((a, b)) if !a.trim().is_empty() && !b.trim().is_empty() => {
            Ok([a, b].map(|node| node.trim().to_string()))
        }
        _ => {
            let message = format!("\"{}\" does not name two nodes", quantity::truncate(text));
            let hint = format!("{subject} takes input:output, such as motor:spindle");
            Err(Error::new(Code::OutOfRange, message).with_hint(hint))
        }
    }
}
