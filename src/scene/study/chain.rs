//! Studies of a chain's transmission error.

use super::{SpeedRange, parsed, speeds};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;
use crate::base::units;
use crate::scene::common::MOST;

/// Transmission error of a chain, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TransmissionStudy {
    /// The node whose error is wanted.
    pub output: Option<String>,
    /// The node whose angle is prescribed; that of the first stated speed where absent.
    pub driver: Option<String>,
    /// The node the output should turn with.
    pub against: Option<String>,
    /// Where on the output the error is also told as an arc, m.
    pub radius: Option<f64>,
    /// Speed of the first node of `[speed]` for the error at speed, rad/s.
    pub speed: Option<f64>,
    /// Speeds of a map of all lines.
    pub speeds: Option<SpeedRange>,
    /// Turns of the output over which ranges are told and a record is made.
    pub window: Option<u32>,
    /// Teeth of the output by which a record is told tooth by tooth.
    pub teeth: Option<u32>,
    /// A machine that indexes tooth by tooth.
    pub index: Option<IndexStudy>,
    /// The error over the angle is wanted.
    pub record: bool,
}

/// Reads its keys.
pub(super) fn transmission(f: &mut Fields) -> TransmissionStudy {
    let text = |f: &mut Fields, key: &str| f.optional_text(key).map(str::to_string);
    TransmissionStudy {
        output: text(f, "output"),
        driver: text(f, "driver"),
        against: text(f, "against"),
        radius: f.optional_quantity("radius", Kind::Length, Range::Positive),
        speed: f.optional_quantity("speed", Kind::Speed, Range::Any),
        speeds: speeds(f, "speeds"),
        window: f.optional_count("window", 1, MOST),
        teeth: f.optional_count("teeth", 1, MOST),
        index: parsed(f, "index", IndexStudy::parse),
        record: false,
    }
}

/// A machine that indexes tooth by tooth.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexStudy {
    /// The pair or shaft whose output side moves on from tooth to tooth.
    pub behind: String,
    /// Teeth of the work.
    pub teeth: u32,
}

impl IndexStudy {
    /// Reads `ELEMENT:TEETH`.
    ///
    /// # Errors
    /// What is not of that form.
    pub fn parse(text: &str, subject: &str) -> Result<IndexStudy, Error> {
        let parts = text.rsplit_once(':');
        let read = parts.and_then(|(behind, teeth)| {
            Some((behind, teeth.trim().parse().ok().filter(|z| *z >= 2)?))
        });
        let Some((behind, teeth)) = read else {
            let message = format!("\"{}\" is no indexing", units::shortened(text));
            let hint = format!(
                "{subject} takes the element behind which the work moves on, and the teeth of the work, such as differential:37"
            );
            return Err(Error::new(Code::OutOfRange, message).hint(hint));
        };
        Ok(IndexStudy {
            behind: behind.trim().to_string(),
            teeth,
        })
    }
}
