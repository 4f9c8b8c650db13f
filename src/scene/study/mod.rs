//! `[[study]]`: what a scene asks of its model.

pub use chain::{IndexStudy, TransmissionStudy};
pub use judged::{AccuracyStudy, Over, Parameter, StabilityStudy, Subject};
pub use modes::{Hold, ModesStudy, ReduceMethod, ReduceStudy, StateSpaceStudy};
pub use motion::{
    BLOCKS, MOST_SAMPLES, RunningStudy, SimulateStudy, TrackStudy, USUAL_TURNS, shafts,
};
pub use response::{
    HarmonicBalanceStudy, MOST_LINES, MOST_ORDERS, ResponseKind, ResponseStudy, ResponseWay,
    RunUpStudy, band,
};
pub use speeds::SpeedRange;

use crate::base::error::Error;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;
use crate::base::place::Place;
use crate::base::toml::Value;

/// Ranges of speeds.
mod speeds;

/// Modes, state space, reduction.
mod modes;

/// Motion in time.
mod motion;

/// Steady answers.
mod response;

/// Transmission error.
mod chain;

/// Methods judged.
mod judged;

/// One question of a scene.
#[derive(Debug, Clone)]
pub struct Study {
    /// What is asked.
    pub kind: StudyKind,
    /// Where it is asked.
    pub place: Place,
}

/// What a study asks.
#[derive(Debug, Clone)]
pub enum StudyKind {
    /// Natural frequencies, damping and shapes.
    Modes(ModesStudy),
    /// Motion in time.
    Simulate(SimulateStudy),
    /// Error against run time.
    Accuracy(AccuracyStudy),
    /// Where methods and machine break.
    Stability(StabilityStudy),
    /// Steady answers to steady excitation.
    Response(ResponseStudy),
    /// Periodic motions over speed, play and all.
    HarmonicBalance(HarmonicBalanceStudy),
    /// Answers to all orders of a running machine over speed.
    RunUp(RunUpStudy),
    /// Transmission error of a chain.
    Transmission(TransmissionStudy),
}

/// Which kind of study.
#[derive(Clone, Copy)]
enum Word {
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
pub fn read(f: &mut Fields) -> Option<Study> {
    let words = [
        ("modes", Word::Modes),
        ("simulate", Word::Simulate),
        ("accuracy", Word::Accuracy),
        ("stability", Word::Stability),
        ("response", Word::Response),
        ("harmonic_balance", Word::HarmonicBalance),
        ("run_up", Word::RunUp),
        ("te", Word::Transmission),
    ];
    let known = f.choice("kind", &words);
    f.need("kind");
    let kind = match known? {
        Word::Modes => StudyKind::Modes(modes::modes(f)),
        Word::Simulate => StudyKind::Simulate(SimulateStudy {
            allow: f.optional_quantity("allow", Kind::Time, Range::Positive),
            running: motion::running(f),
            ..motion::simulate(f)
        }),
        Word::Accuracy => StudyKind::Accuracy(judged::accuracy(f)),
        Word::Stability => StudyKind::Stability(StabilityStudy {
            motion: motion::simulate(f),
            methods: texts(f, "methods"),
            speeds: speeds(f, "speeds"),
            over: parsed(f, "over", Over::parse),
        }),
        Word::Response => StudyKind::Response(response::response(f)),
        Word::RunUp => StudyKind::RunUp(RunUpStudy {
            speeds: speeds(f, "speeds"),
            outputs: texts(f, "outputs"),
            held: texts(f, "hold"),
        }),
        Word::HarmonicBalance => StudyKind::HarmonicBalance(HarmonicBalanceStudy {
            speeds: speeds(f, "speeds"),
            outputs: texts(f, "outputs"),
            tolerance: f
                .optional_number("tolerance", Range::Between(0.0, 1.0, "above 0 and below 1")),
            orders: f.optional_count("orders", 1, MOST_ORDERS),
            orders_alone: f.flag("orders_alone"),
        }),
        Word::Transmission => StudyKind::Transmission(chain::transmission(f)),
    };
    Some(Study {
        kind,
        place: f.place.clone(),
    })
}

/// A list of texts.
pub(super) fn texts(f: &mut Fields, key: &str) -> Vec<String> {
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
            Value::Text(text) => all.push(text.clone()),
            _ => {
                f.wrong_type::<()>(key, item, TAKES);
            }
        }
    }
    all
}

fn speeds(f: &mut Fields, key: &str) -> Option<SpeedRange> {
    parsed(f, key, SpeedRange::parse)
}

/// A text that has a form of its own.
fn parsed<T>(f: &mut Fields, key: &str, parse: fn(&str, &str) -> Result<T, Error>) -> Option<T> {
    let text = f.optional_text(key)?;
    match parse(text, &format!("`{key}`")) {
        Ok(value) => Some(value),
        Err(error) => {
            let place = f.place_of(key).clone();
            let label = format!("in {}", f.title);
            f.notes.push(error.at(&place).label(label));
            None
        }
    }
}
