//! Error of transmission error and stiffness of a mesh against run time: document, tables, figure.

use std::sync::Arc;

use serde_json::{Value, json};

use super::figure::Figure;
use super::method_comparison::{comparison_json, comparison_points, comparison_text, run_table};
use super::presentation::{INTERRUPTED_TEXT, Presentation, Provenance};
use super::table::Table;
use super::work_precision_plot::{self, WorkPrecisionPoint};
use crate::base::error::Error;
use crate::base::source_span::SourceFile;
use crate::numeric::sorting::sort_ascending;
use crate::study::comparison::ComparisonResult;

/// Grids of a mesh compared by e(φ, T) and by k(φ, T), or by the unloaded transmission error.
pub struct MeshAccuracyReport<'a> {
    /// Title of the gear file.
    pub title: &'a str,
    /// The gear file.
    pub source: &'a Arc<SourceFile>,
    /// The error for which a grid is recommended.
    pub target_error: f64,
    /// Comparisons by e(φ, T) and, under a load, by k(φ, T).
    pub results: Vec<ComparisonResult>,
}

impl Presentation for MeshAccuracyReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance {
            sources: std::slice::from_ref(self.source),
            trace: vec!["geometry", "reference", "runs"],
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let mut of_results = self.results.iter();
        let mut next = || {
            of_results
                .next()
                .map(|of| comparison_json(of, self.target_error))
        };
        Ok(json!({ "te": next(), "stiffness": next() }))
    }

    fn text(&self) -> String {
        let texts = self
            .results
            .iter()
            .map(|of| comparison_text(of, self.target_error));
        texts.collect::<Vec<_>>().join("\n")
    }

    fn table(&self) -> Table<'_> {
        run_table(self.results.iter().flat_map(|result| &result.methods))
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let points: Vec<_> = self.results.iter().flat_map(quickest).collect();
        let floors = self.results.iter().map(|of| of.reference_error);
        let floor = (
            floors.fold(f64::INFINITY, f64::min),
            "error of the reference",
        );
        let title = self.title;
        Ok(vec![Figure::first(work_precision_plot::figure(
            title, &points, floor,
        ))])
    }

    fn interruption(&self) -> Option<String> {
        let interrupted = self.results.iter().any(|result| result.interrupted);
        interrupted.then(|| INTERRUPTED_TEXT.to_string())
    }
}

/// The grids that no quicker one is as accurate as, by rising time.
fn quickest(result: &ComparisonResult) -> Vec<WorkPrecisionPoint> {
    let mut points = comparison_points(result);
    sort_ascending(&mut points, |a| a.seconds);
    let mut least = f64::INFINITY;
    points.retain(|point| {
        let is_better = point.error < least;
        least = least.min(point.error);
        is_better
    });
    points
}
