//! Results of gears in space that are quantities and tables: worm pairs, crossed pairs, helicoids with their tools.

use std::sync::{Arc, LazyLock};

use super::geometry::GearQuantity;
use crate::base::error::Diagnostic;
use crate::base::source_span::SourceFile;
use crate::gear::helicoid::turning_pair::TurningPair;
use crate::plan::decision::StageDecision;

/// A value computed when it is first shown; none where there is nothing to show.
pub type OnDemand<T> = LazyLock<Option<T>, Box<dyn FnOnce() -> Option<T> + Send + Sync>>;

/// Result of a gear file.
#[derive(Debug)]
pub struct GearSheet {
    /// Title in the file.
    pub title: String,
    /// Kind in the file.
    pub kind: &'static str,
    /// The gears in words.
    pub what: &'static str,
    /// Teeth of both members, or starts and teeth.
    pub teeth: Option<[u32; 2]>,
    /// Names of both members.
    pub members: [&'static str; 2],
    /// Geometry.
    pub quantities: Vec<GearQuantity>,
    /// Tables, the main one first.
    pub tables: Vec<SheetTable>,
    /// Curves of each figure.
    pub plots: Vec<SheetPlot>,
    /// The pair that turns in space; none of a tool, and where a tooth has no whole flank or is pointed.
    pub in_space: OnDemand<TurningPair>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// The file.
    pub source: Arc<SourceFile>,
}

/// Columns of equal length.
#[derive(Debug, Clone)]
pub struct SheetTable {
    /// Heading, and key in documents.
    pub name: &'static str,
    /// Columns in their order.
    pub columns: Vec<SheetColumn>,
}

/// Values of one quantity.
#[derive(Debug, Clone)]
pub struct SheetColumn {
    /// Name.
    pub name: &'static str,
    /// Unit of the values.
    pub unit: &'static str,
    /// Values.
    pub values: Vec<f64>,
}

/// Curves over common axes.
#[derive(Debug, Clone)]
pub struct SheetPlot {
    /// End of the file's name.
    pub suffix: &'static str,
    /// Quantity and unit of both axes.
    pub axes: [&'static str; 2],
    /// A unit has the same length on both axes.
    pub equal_scales: bool,
    /// Curves: name, abscissae, ordinates; a value that is not finite interrupts a curve.
    pub curves: Vec<(String, Vec<f64>, Vec<f64>)>,
    /// Named places.
    pub labels: Vec<([f64; 2], String)>,
}

/// Collects the columns of a table row by row.
pub(super) fn table<const N: usize>(
    name: &'static str,
    heads: [(&'static str, &'static str); N],
    rows: impl IntoIterator<Item = [f64; N]>,
) -> SheetTable {
    let rows: Vec<[f64; N]> = rows.into_iter().collect();
    let columns = heads.into_iter().enumerate().map(|(k, (name, unit))| {
        let values = rows.iter().map(|row| row[k]).collect();
        SheetColumn { name, unit, values }
    });
    SheetTable {
        name,
        columns: columns.collect(),
    }
}
