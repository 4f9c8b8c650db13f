//! Studies of motion in time, and what is found of it while it runs.

use super::{parsed, texts};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;
use crate::base::units;
use crate::scene::common::MOST;

/// Motion in time, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SimulateStudy {
    /// To this instant, s; from zero.
    pub until: Option<f64>,
    /// Signals: `node.axis`, `node.axis.speed`, `node.axis.acceleration`, `branch.force`, `branch.deflection`.
    pub outputs: Vec<String>,
    /// The method by its word; chosen where absent.
    pub method: Option<String>,
    /// Local error per step, relative.
    pub tolerance: Option<f64>,
    /// Fixed step, s.
    pub step: Option<f64>,
    /// How many equal steps the outputs divide the time into.
    pub samples: Option<u32>,
    /// The energy balance.
    pub energy: bool,
    /// Speed of the first node of `[speed]` in place of the model's, rad/s.
    pub speed: Option<f64>,
    /// How long the work may take, s.
    pub allow: Option<f64>,
    /// No second run tells how the motion amplifies a change of its start.
    pub no_sensitivity: bool,
    /// What is found while it runs.
    pub running: RunningStudy,
}

/// The most samples of a motion.
pub const MOST_SAMPLES: u32 = 100_000_000;

/// Reads its keys.
pub(super) fn simulate(f: &mut Fields) -> SimulateStudy {
    f.exclusive("tolerance", "step");
    SimulateStudy {
        until: f.optional_quantity("until", Kind::Time, Range::Positive),
        outputs: texts(f, "outputs"),
        method: f.optional_text("method").map(str::to_string),
        tolerance: f.optional_number("tolerance", Range::Between(0.0, 1.0, "above 0 and below 1")),
        step: f.optional_quantity("step", Kind::Time, Range::Positive),
        samples: f.optional_count("samples", 1, MOST_SAMPLES),
        energy: f.flag("energy"),
        speed: f.optional_quantity("speed", Kind::Speed, Range::Any),
        allow: None,
        no_sensitivity: f.optional_flag("sensitivity") == Some(false),
        running: RunningStudy::default(),
    }
}

/// What is found of a motion while it runs, without its history.
#[derive(Debug, Clone, PartialEq)]
pub struct RunningStudy {
    /// The history of the outputs is kept.
    pub history: bool,
    /// Spectra of the outputs over blocks of so many samples.
    pub spectrum: Option<u32>,
    /// Orders of the outputs.
    pub track: Option<TrackStudy>,
    /// Over so many turns each point of the orders is a mean.
    pub turns: u32,
    /// Transmission error of the second node against the first.
    pub te: Option<[String; 2]>,
    /// Teeth between both, driver first: `21:63` or `21:63,17:40`.
    pub teeth: Option<String>,
}

/// Turns of a point of the orders where nothing is said.
pub const USUAL_TURNS: u32 = 8;

/// Samples of a block at least and at most.
pub const BLOCKS: std::ops::RangeInclusive<u32> = 16..=(1 << 24);

impl Default for RunningStudy {
    fn default() -> RunningStudy {
        RunningStudy {
            history: true,
            spectrum: None,
            track: None,
            turns: USUAL_TURNS,
            te: None,
            teeth: None,
        }
    }
}

/// Reads its keys.
pub(super) fn running(f: &mut Fields) -> RunningStudy {
    let usual = RunningStudy::default();
    let track = parsed(f, "track", TrackStudy::parse);
    if f.has("turns") && !f.has("track") {
        f.missing("track", ", the orders that `turns` is of");
    }
    if f.has("te") != f.has("teeth") {
        let (has, lacks) = if f.has("te") {
            ("te", "teeth")
        } else {
            ("teeth", "te")
        };
        f.missing(lacks, &format!(", and `{has}` is given"));
    }
    RunningStudy {
        history: f
            .choice("history", &[("kept", true), ("none", false)])
            .unwrap_or(usual.history),
        spectrum: f.optional_count("spectrum", *BLOCKS.start(), *BLOCKS.end()),
        track,
        turns: f.optional_count("turns", 1, MOST).unwrap_or(usual.turns),
        te: parsed(f, "te", shafts),
        teeth: f.optional_text("teeth").map(str::to_string),
    }
}

/// Orders followed over the angle of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackStudy {
    /// The node they turn with.
    pub node: String,
    /// Cycles a turn of it.
    pub orders: Vec<f64>,
}

/// The most orders followed at once.
const MOST_TRACKED: usize = 100;

impl TrackStudy {
    /// Reads `NODE:ORDER,ORDER…`, orders as numbers or fractions.
    ///
    /// # Errors
    /// What is not of that form.
    pub fn parse(text: &str, subject: &str) -> Result<TrackStudy, Error> {
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
            (orders.len() <= MOST_TRACKED).then(|| TrackStudy {
                node: node.trim().to_string(),
                orders,
            })
        });
        read.ok_or_else(|| {
            let message = format!("\"{}\" names no orders of a node", units::shortened(text));
            let hint =
                format!("{subject} takes node:order,order…, such as motor:1,21 or motor:37/12");
            Error::new(Code::OutOfRange, message).hint(hint)
        })
    }
}

/// Reads `INPUT:OUTPUT`, two nodes.
///
/// # Errors
/// What is not of that form.
pub fn shafts(text: &str, subject: &str) -> Result<[String; 2], Error> {
    match text.split_once(':') {
        Some((a, b)) if !a.trim().is_empty() && !b.trim().is_empty() => {
            Ok([a, b].map(|node| node.trim().to_string()))
        }
        _ => {
            let message = format!("\"{}\" names no two nodes", units::shortened(text));
            let hint = format!("{subject} takes input:output, such as motor:spindle");
            Err(Error::new(Code::OutOfRange, message).hint(hint))
        }
    }
}
