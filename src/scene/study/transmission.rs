//! Options of transmission-error studies.

use super::{ReadStudy, SpeedRange};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::scene::shared_keys::MAX_COUNT;

/// Transmission error of a chain, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TransmissionStudy {
    /// The node whose error is wanted.
    pub output: Option<String>,
    /// The node whose angle is prescribed; that of the first stated speed where absent.
    pub driver: Option<String>,
    /// The node the output should turn with.
    pub against: Option<String>,
    /// Radius on the output at which the error is also given as an arc, m.
    pub radius: Option<f64>,
    /// Speed of the first node of `[speed]` for the error at speed, rad/s.
    pub speed: Option<f64>,
    /// Speeds of a map of all lines.
    pub speeds: Option<SpeedRange>,
    /// Window of ranges and of the record, turns of the output.
    pub window_revs: Option<u32>,
    /// Number of teeth of the output for a record tooth by tooth.
    pub teeth: Option<u32>,
    /// A machine that indexes tooth by tooth.
    pub index: Option<IndexingStudy>,
    /// The error over the angle is wanted.
    pub record: bool,
}

impl ReadStudy for TransmissionStudy {
    const KIND: &'static str = "te";

    fn read(f: &mut TableReader) -> TransmissionStudy {
        f.accept_former("teeth", "output_teeth");
        // What another output turns with, and what indexes it, is not the study's.
        f.replace("output", &["against", "index"]);
        let text = |f: &mut TableReader, key: &str| f.optional_text(key).map(str::to_string);
        TransmissionStudy {
            output: text(f, "output"),
            driver: text(f, "driver"),
            against: text(f, "against"),
            radius: f.optional_quantity("radius", QuantityKind::Length, ValueRange::Positive),
            speed: f.optional_quantity("speed", QuantityKind::Speed, ValueRange::Any),
            speeds: f.parsed("speeds", SpeedRange::parse),
            window_revs: f.optional_count("window", 1, MAX_COUNT),
            teeth: f.optional_count("output_teeth", 1, MAX_COUNT),
            index: f.parsed("index", IndexingStudy::parse),
            record: f.flag("record"),
        }
    }
}

/// A machine that indexes tooth by tooth.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexingStudy {
    /// The pair or shaft whose output side moves on from tooth to tooth.
    pub element: String,
    /// Teeth of the work.
    pub teeth: u32,
}

impl IndexingStudy {
    /// Reads `ELEMENT:TEETH`.
    ///
    /// # Errors
    /// What is not of that form.
    pub fn parse(text: &str, subject: &str) -> Result<IndexingStudy, Error> {
        let parts = text.rsplit_once(':');
        let read = parts.and_then(|(behind, teeth)| {
            Some((behind, teeth.trim().parse().ok().filter(|z| *z >= 2)?))
        });
        let Some((behind, teeth)) = read else {
            let message = format!("\"{}\" is not an indexing", quantity::truncate(text));
            let hint = format!(
                "{subject} takes the element after which the work is indexed, and the teeth of the work, such as differential:37"
            );
            return Err(Error::new(Code::OutOfRange, message).with_hint(hint));
        };
        Ok(IndexingStudy {
            element: behind.trim().to_string(),
            teeth,
        })
    }
}
