//! What an answer shows, whatever it is the answer to: document, text, table, figures, notes, warnings.

use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::json::{hash, warnings};
use super::plan::{omitted_steps, stages, steps};
use super::recording::repairs;
use super::table::Table;
use crate::base::error::{Diagnostic, Error};
use crate::base::source_span::SourceFile;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;
use crate::recording::raw::Repair;
use crate::scene::Scene;

/// An answer as it is shown: by every command, and by each study of a scene.
pub trait Presentation {
    /// What the answer was made from, and by which steps.
    fn provenance(&self) -> Provenance<'_>;

    /// The keys of the answer in its JSON document; [`document`] adds those of its provenance.
    ///
    /// # Errors
    /// A result without a form that JSON can hold.
    fn body(&self) -> Result<Value, Error>;

    /// The answer for a terminal.
    fn text(&self) -> String;

    /// The table that is written as CSV.
    fn table(&self) -> Table<'_> {
        Table::default()
    }

    /// The figures, drawn.
    ///
    /// # Errors
    /// A curve that cannot be computed.
    fn figures(&self) -> Result<Vec<Figure>, Error> {
        Ok(Vec::new())
    }

    /// What the figures do not show; empty where they show all.
    fn figure_notes(&self) -> String {
        String::new()
    }

    /// What was done and left out, in lines: by default the steps left out.
    fn notes(&self) -> String {
        omitted_steps(self.provenance().stages)
    }

    /// Why the answer ends early, in a line; absent where it is whole.
    fn interruption(&self) -> Option<String> {
        None
    }

    /// The exit code of a whole answer: 1 where it is a bad verdict.
    fn exit_code(&self) -> u8 {
        0
    }
}

/// The answer to a study of a scene.
pub struct StudyAnswer<'a, R> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its machine.
    pub machine: PreparedMachine,
    /// The result.
    pub result: R,
}

/// The answer to an analysis of a log.
pub struct LogAnswer<R> {
    /// Name of the log, above figures.
    pub title: String,
    /// What was done to the data.
    pub repairs: Vec<Repair>,
    /// The result, its warnings with those about the data.
    pub result: R,
}

/// The line of an answer that an interrupt has ended.
pub const ENDED_EARLY: &str = "interrupted: what is shown was finished before\n";

/// What an answer was made from, and by which steps.
#[derive(Default)]
pub struct Provenance<'a> {
    /// The texts of the model; empty for a log.
    pub sources: &'a [Arc<SourceFile>],
    /// The steps that ran.
    pub trace: Vec<&'a str>,
    /// What the steps cost; null where it is not told.
    pub effort: Value,
    /// The plan, where the document holds it.
    pub stages: &'a [(&'static str, StageDecision)],
    /// What was done to the data of a log.
    pub repairs: Option<&'a [Repair]>,
    /// Data-quality warnings and others.
    pub warnings: &'a [Diagnostic],
}

impl<'a> Provenance<'a> {
    /// That of an answer to a model by a plan.
    pub fn of_plan(
        sources: &'a [Arc<SourceFile>],
        stages: &'a [(&'static str, StageDecision)],
        warnings: &'a [Diagnostic],
    ) -> Provenance<'a> {
        let ran = stages
            .iter()
            .filter(|s| matches!(s.1, StageDecision::Runs(_)));
        Provenance {
            sources,
            trace: ran.map(|s| s.0).collect(),
            stages,
            warnings,
            ..Provenance::default()
        }
    }

    /// That of an answer to a log, from the steps with their times, s.
    pub fn of_log(
        trace: &'a [(&'static str, f64)],
        repairs: &'a [Repair],
        warnings: &'a [Diagnostic],
    ) -> Provenance<'a> {
        Provenance {
            trace: trace.iter().map(|t| t.0).collect(),
            effort: step_times(trace.iter().copied()),
            repairs: Some(repairs),
            warnings,
            ..Provenance::default()
        }
    }

    /// The `geardyn` block of the document.
    pub fn header(&self) -> Value {
        let hash = (!self.sources.is_empty()).then(|| hash(self.sources));
        json!({ "version": env!("CARGO_PKG_VERSION"), "model_hash": hash, "trace": self.trace })
    }
}

/// The cost of steps: `[{stage, time_s}]`.
pub fn step_times<'a>(steps: impl Iterator<Item = (&'a str, f64)>) -> Value {
    steps
        .map(|(stage, seconds)| json!({ "stage": stage, "time_s": seconds }))
        .collect()
}

/// One of the figures of an answer.
pub struct Figure {
    /// What its file's name ends in, behind a hyphen; empty for the first.
    pub suffix: &'static str,
    /// The drawing.
    pub svg: String,
}

impl Figure {
    /// The first figure.
    pub fn first(svg: String) -> Figure {
        Figure::new("", svg)
    }

    /// A further figure.
    pub fn new(suffix: &'static str, svg: String) -> Figure {
        Figure { suffix, svg }
    }
}

/// The JSON document of an answer: header, answer, effort, stages, repairs, warnings.
///
/// # Errors
/// As for [`Presentation::body`].
pub fn document(answer: &dyn Presentation) -> Result<Value, Error> {
    let about = answer.provenance();
    let mut document = Map::new();
    document.insert("geardyn".into(), about.header());
    if let Value::Object(body) = answer.body()? {
        document.extend(body);
    }
    if !about.effort.is_null() {
        document.insert("effort".into(), about.effort);
    }
    if !about.stages.is_empty() {
        document.insert("stages".into(), stages(steps(about.stages)));
    }
    if let Some(done) = about.repairs {
        document.insert("repairs".into(), repairs(done));
    }
    document.insert("warnings".into(), warnings(about.warnings));
    Ok(Value::Object(document))
}
