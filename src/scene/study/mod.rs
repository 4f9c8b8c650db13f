//! Reads `[[study]]`: the analyses a scene lists.

pub use accuracy_stability::{
    AccuracyStudy, AccuracyTarget, ParameterSweep, StabilityStudy, SweepParameter,
};
pub use modes::{InputHold, ModesStudy, ReductionKind, ReductionStudy, StateSpaceStudy};
pub use motion::{DEFAULT_AVERAGING_REVS, OnlineStudy, OrderTrackingStudy, SimulateStudy};
pub use response::{
    HarmonicBalanceStudy, MAX_ORDERS, ResponseMethodTag, ResponseQuantity, ResponseStudy,
    RunUpStudy,
};
pub use speeds::SpeedRange;
pub use transmission::{IndexingStudy, TransmissionStudy};

use super::Scene;
use crate::base::error::Errors;
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::TableReader;
use crate::base::toml::{Table, Value};

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
    /// The study as written.
    table: Table,
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

/// Options of a study, read from the same keys in a scene and on the command line.
pub trait ReadStudy: Sized {
    /// `kind` of the study in a scene.
    const KIND: &'static str;

    /// Reads its keys.
    fn read(f: &mut TableReader) -> Self;

    /// The listed study that flags lie over.
    fn listed<'s>(scene: &'s Scene, _flags: &Flags) -> Option<&'s Study> {
        scene.listed(Self::KIND)
    }
}

impl Study {
    /// The text of a key as written.
    fn text(&self, key: &str) -> Option<&str> {
        match &self.table.get(key)?.item.value {
            Value::String(text) => Some(text),
            _ => None,
        }
    }
}

impl Scene {
    /// The first listed study of a kind.
    fn listed(&self, kind: &str) -> Option<&Study> {
        self.studies.iter().find(|s| s.text("kind") == Some(kind))
    }

    /// The study that a command carries out: the first of its kind that the scene lists, with the flags laid over it.
    ///
    /// # Errors
    /// Everything wrong in the flags, and between them and the listed study.
    pub fn study<S: ReadStudy>(&self, flags: &Flags) -> Result<S, Errors> {
        self.study_over(S::listed(self, flags), flags)
    }

    /// The study `listed`, or an empty one, with the flags laid over it.
    ///
    /// # Errors
    /// Everything wrong in the flags, and between them and the listed study.
    pub fn study_over<S: ReadStudy>(
        &self,
        listed: Option<&Study>,
        flags: &Flags,
    ) -> Result<S, Errors> {
        let title = format!("a study of kind \"{}\"", S::KIND);
        let base = listed.map(|study| (&study.table, &study.span));
        flags.read(&title, base, &self.bare_si, S::read)
    }
}

/// A share of a whole.
const SHARE: ValueRange = ValueRange::Open(0.0, 1.0, "above 0 and below 1");

/// Reads the keys of one kind.
type Reader = fn(&mut TableReader) -> StudyKind;

/// A study; absent where its kind is missing or unknown, which is then noted.
pub fn read(f: &mut TableReader) -> Option<Study> {
    let readers: [(&str, Reader); 8] = [
        (ModesStudy::KIND, |f| StudyKind::Modes(ReadStudy::read(f))),
        (SimulateStudy::KIND, |f| {
            StudyKind::Simulate(ReadStudy::read(f))
        }),
        (AccuracyStudy::KIND, |f| {
            StudyKind::Accuracy(ReadStudy::read(f))
        }),
        (StabilityStudy::KIND, |f| {
            StudyKind::Stability(ReadStudy::read(f))
        }),
        (ResponseStudy::KIND, |f| {
            StudyKind::Response(ReadStudy::read(f))
        }),
        (HarmonicBalanceStudy::KIND, |f| {
            StudyKind::HarmonicBalance(ReadStudy::read(f))
        }),
        (RunUpStudy::KIND, |f| StudyKind::RunUp(ReadStudy::read(f))),
        (TransmissionStudy::KIND, |f| {
            StudyKind::Transmission(ReadStudy::read(f))
        }),
    ];
    let reader = f.choice("kind", &readers);
    f.require("kind");
    Some(Study {
        kind: reader?(f),
        span: f.span.clone(),
        table: f.table.clone(),
    })
}
