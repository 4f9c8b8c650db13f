//! The stages of a gear file as they are shown by `plan`.

use std::sync::Arc;

use serde_json::{Value, json};

use super::plan::{steps, text};
use super::presentation::{Presentation, Provenance};
use crate::base::error::Error;
use crate::base::source_span::SourceFile;
use crate::plan::stages::StageDecision;

/// Stages of a gear file.
pub struct GearPlan {
    /// The file, and the tables it names.
    pub sources: Vec<Arc<SourceFile>>,
    /// Stages that run, and those left out with the reason.
    pub stages: Vec<(&'static str, StageDecision)>,
}

impl Presentation for GearPlan {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_plan(&self.sources, &self.stages, &[])
    }

    fn body(&self) -> Result<Value, Error> {
        Ok(json!({}))
    }

    fn text(&self) -> String {
        text(steps(&self.stages))
    }
}
