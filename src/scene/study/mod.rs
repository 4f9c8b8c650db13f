//! Reads `[[study]]`: the analyses a scene lists.

pub use accuracy_stability::{
    AccuracyStudy, AccuracyTarget, ParameterSweep, StabilityStudy, SweepParameter,
};
pub use modes::{DiscretisationMethod, ModesStudy, ReductionKind, ReductionStudy, StateSpaceStudy};
pub use motion::{
    BLOCK_SIZES, DEFAULT_AVERAGING_REVS, MAX_SAMPLES, OnlineStudy, OrderTrackingStudy,
    SimulateStudy, parse_shaft_pair,
};
pub use response::{
    HarmonicBalanceStudy, MAX_LINES, MAX_ORDERS, ResponseMethodTag, ResponseQuantity,
    ResponseStudy, RunUpStudy, parse_band,
};
pub use speeds::SpeedRange;
pub use transmission::{IndexingStudy, TransmissionStudy};

use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::TableReader;
use crate::base::toml::Value;

mod speeds;

mod modes;

mod motion;

mod response;

mod transmission;

mod accuracy_stability;

/// One question of a scene.
#[derive(Debug, Clone)]
pub struct Study {
    /// Kind of study.
    pub kind: StudyKind,
    /// Place of the study in the file.
    pub span: SourceSpan,
}

/// Kind of study with its options.
#[derive(Debug, Clone)]
pub enum StudyKind {
    /// Natural frequencies, damping and shapes.
    Modes(ModesStudy),
    /// Motion in time.
    Simulate(SimulateStudy),
    /// Error against run time.
    Accuracy(AccuracyStudy),
    /// Stability limits of methods and machine.
    Stability(StabilityStudy),
    /// Steady-state responses to steady excitation.
    Response(ResponseStudy),
    /// Periodic motions over speed, play and all.
    HarmonicBalance(HarmonicBalanceStudy),
    /// Responses to all orders of a running machine over speed.
    RunUp(RunUpStudy),
    /// Transmission error of a chain.
    Transmission(TransmissionStudy),
}

/// Which kind of study.
#[derive(Clone, Copy)]
enum StudyTag {
    Modes,
    Simulate,
    Accuracy,
    Stability,
    Response,
    HarmonicBalance,
    RunUp,
    Transmission,
}

/// A study; absent where its kind is missing or unknown, which is then noted.
pub fn read(f: &mut TableReader) -> Option<Study> {
    let words = [
        ("modes", StudyTag::Modes),
        ("simulate", StudyTag::Simulate),
        ("accuracy", StudyTag::Accuracy),
        ("stability", StudyTag::Stability),
        ("response", StudyTag::Response),
        ("harmonic_balance", StudyTag::HarmonicBalance),
        ("run_up", StudyTag::RunUp),
        ("te", StudyTag::Transmission),
    ];
    let known = f.choice("kind", &words);
    f.require("kind");
    let kind = match known? {
        StudyTag::Modes => StudyKind::Modes(modes::modes(f)),
        StudyTag::Simulate => StudyKind::Simulate(SimulateStudy {
            time_limit: f.optional_quantity("allow", QuantityKind::Time, ValueRange::Positive),
            running: motion::running(f),
            ..motion::simulate(f)
        }),
        StudyTag::Accuracy => StudyKind::Accuracy(accuracy_stability::accuracy(f)),
        StudyTag::Stability => StudyKind::Stability(StabilityStudy {
            motion: motion::simulate(f),
            methods: texts(f, "methods"),
            speeds: speeds(f, "speeds"),
            over: parsed(f, "over", ParameterSweep::parse),
        }),
        StudyTag::Response => StudyKind::Response(response::response(f)),
        StudyTag::RunUp => StudyKind::RunUp(RunUpStudy {
            speeds: speeds(f, "speeds"),
            outputs: texts(f, "outputs"),
            fixed_dofs: texts(f, "hold"),
        }),
        StudyTag::HarmonicBalance => StudyKind::HarmonicBalance(HarmonicBalanceStudy {
            speeds: speeds(f, "speeds"),
            outputs: texts(f, "outputs"),
            tolerance: f.optional_number(
                "tolerance",
                ValueRange::Open(0.0, 1.0, "above 0 and below 1"),
            ),
            orders: f.optional_count("orders", 1, MAX_ORDERS),
            skip_event_refinement: f.flag("orders_alone"),
        }),
        StudyTag::Transmission => StudyKind::Transmission(transmission::transmission(f)),
    };
    Some(Study {
        kind,
        span: f.span.clone(),
    })
}

/// A list of texts.
pub(super) fn texts(f: &mut TableReader, key: &str) -> Vec<String> {
    const TAKES: &str = "a list of texts";
    let Some(item) = f.item(key, TAKES) else {
        return Vec::new();
    };
    let Value::List(list) = &item.value else {
        return f.wrong_type(key, item, TAKES).unwrap_or_default();
    };
    let mut all = Vec::new();
    for item in list {
        match &item.value {
            Value::String(text) => all.push(text.clone()),
            _ => {
                f.wrong_type::<()>(key, item, TAKES);
            }
        }
    }
    all
}

fn speeds(f: &mut TableReader, key: &str) -> Option<SpeedRange> {
    parsed(f, key, SpeedRange::parse)
}

/// A text that has a form of its own.
fn parsed<T>(
    f: &mut TableReader,
    key: &str,
    parse: fn(&str, &str) -> Result<T, Error>,
) -> Option<T> {
    let text = f.optional_text(key)?;
    match parse(text, &format!("`{key}`")) {
        Ok(value) => Some(value),
        Err(error) => {
            let span = f.span_of(key).clone();
            let label = format!("in {}", f.title);
            f.errors.push(error.with_span(&span).with_label(label));
            None
        }
    }
}
