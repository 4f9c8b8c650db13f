//! Summary of a file as it was understood, for `check`.

use std::sync::Arc;

use serde_json::Value;

use super::presentation::{Presentation, Provenance};
use crate::base::error::{Diagnostic, Error};
use crate::base::source_span::SourceFile;
use crate::recording::raw::Repair;

/// A file as it was understood.
#[derive(Default)]
pub struct FileSummary {
    /// The texts of a model; empty for a log.
    pub sources: Vec<Arc<SourceFile>>,
    /// The summary for a terminal.
    pub text: String,
    /// The summary in the document.
    pub body: Value,
    /// Repairs of the data of a log.
    pub repairs: Option<Vec<Repair>>,
    /// Warnings about it.
    pub warnings: Vec<Diagnostic>,
}

impl Presentation for FileSummary {
    fn provenance(&self) -> Provenance<'_> {
        Provenance {
            sources: &self.sources,
            repairs: self.repairs.as_deref(),
            warnings: &self.warnings,
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        Ok(self.body.clone())
    }

    fn text(&self) -> String {
        self.text.clone()
    }
}
