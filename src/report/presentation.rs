//! Presentation trait of analysis results: JSON document, text, table, figures, notes and warnings.

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

/// Output forms of a result, for every command and every study of a scene.
pub trait Presentation {
    /// Sources, steps and warnings of the result.
    fn provenance(&self) -> Provenance<'_>;

    /// JSON object of the result; [`document`] adds the keys of its provenance.
    ///
    /// # Errors
    /// A result that JSON cannot represent.
    fn body(&self) -> Result<Value, Error>;

    /// Terminal text.
    fn text(&self) -> String;

    /// Table for CSV output; empty by default.
    fn table(&self) -> Table<'_> {
        Table::default()
    }

    /// Figures; none by default.
    ///
    /// # Errors
    /// A curve that cannot be computed.
    fn figures(&self) -> Result<Vec<Figure>, Error> {
        Ok(Vec::new())
    }

    /// Interactive views of the HTML page; none by default.
    fn views(&self) -> Vec<View> {
        Vec::new()
    }

    /// Notes on data omitted from the figures; empty by default.
    fn figure_notes(&self) -> String {
        String::new()
    }

    /// Whether the warnings precede the result because they may invalidate it; `false` by default.
    fn warnings_first(&self) -> bool {
        false
    }

    /// Notes on the steps, one per line; the omitted steps by default.
    fn notes(&self) -> String {
        omitted_steps(self.provenance().stages)
    }

    /// Reason for an incomplete result, one line; `None` for a complete result.
    fn interruption(&self) -> Option<String> {
        None
    }

    /// Exit code of a complete result: 1 for a failed verdict, 0 by default.
    fn exit_code(&self) -> u8 {
        0
    }
}

/// Report of a study of a scene.
pub struct StudyReport<'a, R> {
    /// Scene.
    pub scene: &'a Scene,
    /// Machine of the scene.
    pub machine: &'a PreparedMachine,
    /// Result of the study.
    pub result: R,
}

/// Report of the analysis of a log.
pub struct LogReport<R> {
    /// Name of the log, title of the figures.
    pub title: String,
    /// Repairs of the recorded data.
    pub repairs: Vec<Repair>,
    /// Result; its warnings include the data-quality warnings.
    pub result: R,
}

/// Text of a result ended by an interrupt.
pub const INTERRUPTED_TEXT: &str = "interrupted: results shown were complete before\n";

/// Sources, steps and warnings of a result.
#[derive(Default)]
pub struct Provenance<'a> {
    /// Title of the scene; empty without a title or if the text of the result contains it.
    pub title: &'a str,
    /// Source files of the model; empty for a log.
    pub sources: &'a [Arc<SourceFile>],
    /// Names of the executed steps.
    pub trace: Vec<&'a str>,
    /// Cost of the steps; null if not reported.
    pub effort: Value,
    /// Stage decisions of the plan; empty if not reported.
    pub stages: &'a [(&'static str, StageDecision)],
    /// Repairs of the recorded data; `None` for a model.
    pub repairs: Option<&'a [Repair]>,
    /// Warnings, including data-quality warnings.
    pub warnings: &'a [Diagnostic],
}

impl<'a> Provenance<'a> {
    /// Provenance of a result computed from a model by a plan.
    pub fn of_plan(
        sources: &'a [Arc<SourceFile>],
        stages: &'a [(&'static str, StageDecision)],
        warnings: &'a [Diagnostic],
    ) -> Provenance<'a> {
        let executed = stages
            .iter()
            .filter(|s| matches!(s.1, StageDecision::Runs(_)));
        Provenance {
            sources,
            trace: executed.map(|s| s.0).collect(),
            stages,
            warnings,
            ..Provenance::default()
        }
    }

    /// Provenance of a result computed from a log; `trace` holds the steps with their times, s.
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

    /// `geardyn` block of the JSON document.
    pub fn header(&self) -> Value {
        let hash = (!self.sources.is_empty()).then(|| hash(self.sources));
        json!({ "version": env!("CARGO_PKG_VERSION"), "model_hash": hash, "trace": self.trace })
    }
}

/// JSON of the step times, s: `[{stage, time_s}]`.
pub fn step_times<'a>(steps: impl Iterator<Item = (&'a str, f64)>) -> Value {
    steps
        .map(|(stage, seconds)| json!({ "stage": stage, "time_s": seconds }))
        .collect()
}

/// Assembles the JSON document of a result: header, result, effort, stages, repairs, warnings.
///
/// # Errors
/// As for [`Presentation::body`].
pub fn document(result: &dyn Presentation) -> Result<Value, Error> {
    let provenance = result.provenance();
    let mut document = Map::new();
    document.insert("geardyn".into(), provenance.header());
    if !provenance.title.is_empty() {
        document.insert("title".into(), provenance.title.into());
    }
    if let Value::Object(body) = result.body()? {
        document.extend(body);
    }
    if !provenance.effort.is_null() {
        document.insert("effort".into(), provenance.effort);
    }
    if !provenance.stages.is_empty() {
        document.insert("stages".into(), stages(steps(provenance.stages)));
    }
    if let Some(list) = provenance.repairs {
        document.insert("repairs".into(), repairs(list));
    }
    document.insert("warnings".into(), warnings(provenance.warnings));
    Ok(Value::Object(document))
}
