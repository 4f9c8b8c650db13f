//! Presentation of results: document, text, table, figures, notes and warnings of every analysis by one trait.

use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::figure::Figure;
use super::json::{hash, warnings};
use super::plan::{omitted_steps, stages, steps};
use super::recording::repairs;
use super::table::Table;
use super::view::View;
use crate::base::error::{Diagnostic, Error};
use crate::base::source_span::SourceFile;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;
use crate::recording::raw::Repair;
use crate::scene::Scene;

/// A result as it is shown, by every command and by each study of a scene.
pub trait Presentation {
    /// Sources and steps of the result.
    fn provenance(&self) -> Provenance<'_>;

    /// The keys of the result in its JSON document; [`document`] adds those of its provenance.
    ///
    /// # Errors
    /// A result without a form that JSON can hold.
    fn body(&self) -> Result<Value, Error>;

    /// The result for a terminal.
    fn text(&self) -> String;

    /// The table that is written as CSV.
    fn table(&self) -> Table<'_> {
        Table::default()
    }

    /// The figures.
    ///
    /// # Errors
    /// A curve that cannot be computed.
    fn figures(&self) -> Result<Vec<Figure>, Error> {
        Ok(Vec::new())
    }

    /// The views that only a page shows.
    fn views(&self) -> Vec<View> {
        Vec::new()
    }

    /// Remainder that the figures do not show; empty by default.
    fn figure_notes(&self) -> String {
        String::new()
    }

    /// Whether warnings precede the result, because they decide whether the rest is of use; by default they follow it.
    fn warnings_first(&self) -> bool {
        false
    }

    /// Steps carried out and left out, in lines: by default those left out.
    fn notes(&self) -> String {
        omitted_steps(self.provenance().stages)
    }

    /// The line that says why the result ends early; absent where it is whole.
    fn interruption(&self) -> Option<String> {
        None
    }

    /// The exit code of a whole result: 1 where it is a bad verdict.
    fn exit_code(&self) -> u8 {
        0
    }
}

/// The result of a study of a scene.
pub struct StudyReport<'a, R> {
    /// The scene.
    pub scene: &'a Scene,
    /// The machine of the scene.
    pub machine: &'a PreparedMachine,
    /// The result.
    pub result: R,
}

/// The result of an analysis of a log.
pub struct LogReport<R> {
    /// Name of the log, above figures.
    pub title: String,
    /// Repairs of the data.
    pub repairs: Vec<Repair>,
    /// The result, its warnings with those about the data.
    pub result: R,
}

/// The line of a result that an interrupt has ended.
pub const ENDED_EARLY: &str = "interrupted: what is shown was finished before\n";

/// Sources and steps of a result.
#[derive(Default)]
pub struct Provenance<'a> {
    /// Title of the scene; empty where there is none or the text of the result begins with it.
    pub title: &'a str,
    /// The texts of the model; empty for a log.
    pub sources: &'a [Arc<SourceFile>],
    /// The steps that ran.
    pub trace: Vec<&'a str>,
    /// Cost of the steps; null where it is not reported.
    pub effort: Value,
    /// The plan, where the document holds it.
    pub stages: &'a [(&'static str, StageDecision)],
    /// Repairs of the data of a log.
    pub repairs: Option<&'a [Repair]>,
    /// Data-quality warnings and others.
    pub warnings: &'a [Diagnostic],
}

impl<'a> Provenance<'a> {
    /// The provenance of a result that a plan has for a model.
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

    /// The provenance of a result from a log, from the steps with their times, s.
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

/// The JSON document of a result: header, result, effort, stages, repairs, warnings.
///
/// # Errors
/// As for [`Presentation::body`].
pub fn document(result: &dyn Presentation) -> Result<Value, Error> {
    let about = result.provenance();
    let mut document = Map::new();
    document.insert("geardyn".into(), about.header());
    if !about.title.is_empty() {
        document.insert("title".into(), about.title.into());
    }
    if let Value::Object(body) = result.body()? {
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
