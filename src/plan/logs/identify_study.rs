//! Identification study: channels, band, method and options; `None`: chosen from the data.

use super::frf_estimation::FrfStudy;
use super::method::IdentificationMethod;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity::{self, to_hertz};
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::{TableReader, Word};
use crate::identify::rational::DelayModel;
use crate::scene::study::ResponseQuantity;
use crate::spectrum::frf::Estimator;
use crate::spectrum::window::Window;

/// Request for the identification of a log.
#[derive(Debug, Clone, Default)]
pub struct IdentifyStudy {
    /// Channels that drive.
    pub inputs: Vec<String>,
    /// Response channels.
    pub outputs: Vec<String>,
    /// Options for the estimation of responses.
    pub estimate: FrfStudy,
    /// Lines used, Hz.
    pub band_hz: Option<(f64, f64)>,
    /// Pole pairs; as many as are significant where `None`.
    pub order: Option<usize>,
    /// A delay to be estimated.
    pub delay: DelayModel,
    /// Poles may be unstable.
    pub allow_unstable: bool,
    /// Order of differentiation of the motion in every response, where the units are ambiguous.
    pub derivative: Option<u8>,
    /// List weak modes among the others.
    pub all: bool,
    /// The method; by what is named where `None`.
    pub method: Option<IdentificationMethod>,
    /// Speed of what turns, Hz.
    pub speed_hz: Option<f64>,
    /// Output at the driving point, `INPUT=OUTPUT` with several inputs: modal masses by the first, reciprocity between all.
    pub driving_points: Vec<String>,
    /// Memory of a model that follows the process, s; by best prediction where `None`.
    pub memory_s: Option<f64>,
}

/// Modes at most.
const MAX_MODES: u32 = 500;

/// Share of a block.
pub const OVERLAPS: ValueRange = ValueRange::HalfOpen(0.0, 1.0, "at least 0 and below 1");

impl IdentifyStudy {
    /// Reads its keys.
    pub fn read(f: &mut TableReader) -> IdentifyStudy {
        f.exclusive("speed", "input");
        let order = f.optional_count("order", 1, MAX_MODES);
        let motion = f.word("kind");
        IdentifyStudy {
            inputs: f.texts("input"),
            outputs: f.texts("output"),
            estimate: FrfStudy::read(f),
            band_hz: f.parsed("band", parse_band_hz),
            order: order.map(|order| order as usize),
            delay: f.word("delay").unwrap_or_default(),
            allow_unstable: f.flag("allow_unstable"),
            all: f.flag("all"),
            derivative: motion.map(|motion: ResponseQuantity| motion.derivative_order()),
            method: f.word("method"),
            speed_hz: f
                .optional_quantity("speed", QuantityKind::Speed, ValueRange::Positive)
                .map(to_hertz),
            driving_points: f.texts("driving_point"),
            memory_s: f.optional_quantity("memory", QuantityKind::Time, ValueRange::Positive),
        }
    }
}

impl FrfStudy {
    /// Reads its keys.
    fn read(f: &mut TableReader) -> FrfStudy {
        let dwells = f.texts("dwells");
        let dwells: Result<Vec<(f64, f64)>, Error> =
            dwells.iter().map(|text| parse_dwell(text)).collect();
        let study = FrfStudy {
            estimator: f.word("estimator").unwrap_or_default(),
            window: f.parsed("window", |text, _| Window::parse(text)),
            frequency_resolution_hz: read_resolution(f),
            overlap: f.optional_number("overlap", OVERLAPS),
            impact: f.optional_flag("impact"),
            stepped: f.optional_flag("stepped"),
            dwells_s: dwells.unwrap_or_else(|error| {
                let span = f.span_of("dwells").clone();
                f.push(error, &span);
                Vec::new()
            }),
        };
        let dwells = !study.dwells_s.is_empty();
        let mut exclude = |one: &str, other: &str| {
            let message = format!("`{one}` and `{other}` exclude each other");
            f.report_key(Code::Conflict, one, message, "omit one of them");
        };
        if study.stepped == Some(true) && study.impact == Some(true) {
            exclude("stepped", "impact");
        } else if dwells && study.impact == Some(true) {
            exclude("dwells", "impact");
        } else if dwells && study.stepped == Some(false) {
            exclude("dwells", "no-stepped");
        }
        study
    }
}

/// The key `resolution`, Hz.
pub fn read_resolution(f: &mut TableReader) -> Option<f64> {
    let kind = QuantityKind::Frequency;
    let omega = f.optional_quantity("resolution", kind, ValueRange::Positive);
    omega.map(to_hertz)
}

/// `A:B`, frequencies, Hz.
pub fn parse_band_hz(text: &str, subject: &str) -> Result<(f64, f64), Error> {
    let band = ("a band", "10:2000 or \"10 Hz:2 kHz\"");
    let (low, high) = quantity::parse_range(text, QuantityKind::Frequency, band, subject)?;
    Ok((to_hertz(low), to_hertz(high)))
}

/// `FROM:TO`, s.
fn parse_dwell(text: &str) -> Result<(f64, f64), Error> {
    quantity::parse_range(
        text,
        QuantityKind::Time,
        ("a dwell", "0.5:2.5,3:5"),
        "`dwells`",
    )
}

impl Word for Estimator {
    const WORDS: &'static [(&'static str, Estimator, &'static str)] = &[
        ("h1", Estimator::H1, "Noise on the outputs"),
        ("h2", Estimator::H2, "Noise on the input"),
        ("hv", Estimator::Hv, "Noise on both"),
    ];
}

impl Word for DelayModel {
    const WORDS: &'static [(&'static str, DelayModel, &'static str)] = &[
        ("none", DelayModel::None, "None"),
        ("common", DelayModel::Common, "One for all responses"),
        ("each", DelayModel::PerResponse, "One for each response"),
    ];
}
