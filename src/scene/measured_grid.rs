//! Reads the grid of a measured bevel flank: nodes by `z`, `radius` or `x`, `y`, `z`, and `deviation`, or measured points with nominal normals.

use std::path::Path;
use std::sync::Arc;

use super::csv_table::{CsvTable, column_heads};
use super::limit_table::{cells, lines};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::load;
use crate::base::quantity::truncate;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::gear::bevel::tooth::SIDES;

/// Nodes of a coordinate-measuring machine.
#[derive(Debug, Clone)]
pub struct MeasuredGrid {
    /// Nodes in the order of the file.
    pub nodes: Vec<GridNode>,
    /// The file.
    pub source: Arc<SourceFile>,
}

/// A node with what was measured there.
#[derive(Debug, Clone)]
pub struct GridNode {
    /// Index of its flank in [`SIDES`], where the file names it.
    pub side: Option<usize>,
    /// `[z, radius]` of the nominal point, m: z along the axis from apex to heel.
    pub place: [f64; 2],
    /// Axial and radial component of the nominal normal, where the file gives it.
    pub normal: Option<[f64; 2]>,
    /// Measured deviation, m.
    pub deviation: f64,
    /// The deviation is counted along the normal of the file, whichever way it points; else it is positive where metal is left.
    pub is_along_normal: bool,
    /// Place of its row.
    pub span: SourceSpan,
}

const LENGTH: Option<QuantityKind> = Some(QuantityKind::Length);
/// Heads of a grid by deviations.
const EXAMPLE: &str = "flank,z [mm],radius [mm],deviation [µm]";

/// Reads a grid.
///
/// # Errors
/// Everything wrong in it.
pub fn read(path: &Path) -> Result<MeasuredGrid, Errors> {
    let source = load::load(path)?;
    let heads = column_heads(&source);
    let has = |name: &str| heads.iter().any(|(head, _)| *head == name);
    let by_radius = has("radius");
    let by_points = !has("deviation") && has("x_measured");
    let has_normals = by_points || has("n_x");
    let mut names = match by_radius {
        true if by_points => {
            let message = "measured points need nominal points `x`, `y`, `z`, not `radius`";
            return Err(at_head(&source, Code::Conflict, message).into());
        }
        true => vec![("z", LENGTH), ("radius", LENGTH)],
        false => vec![("x", LENGTH), ("y", LENGTH), ("z", LENGTH)],
    };
    let first_measured = names.len();
    match by_points {
        true => names.extend(["x_measured", "y_measured", "z_measured"].map(|name| (name, LENGTH))),
        false => names.push(("deviation", LENGTH)),
    }
    let first_normal = names.len();
    if has_normals && !by_radius {
        names.extend(["n_x", "n_y", "n_z"].map(|name| (name, None)));
    }
    let table = CsvTable::parse(source.clone(), &names)?;
    let sides = sides(&source)?;
    let row = |k: usize| {
        let value = |column: usize| table.columns[column][k];
        let triple = |first: usize| [0, 1, 2].map(|i| value(first + i));
        let place = match by_radius {
            true => [value(0), value(1)],
            false => [value(2), f64::hypot(value(0), value(1))],
        };
        let normal = (names.len() > first_normal).then(|| unit(triple(first_normal)));
        let deviation = match (by_points, normal) {
            (true, Some(n)) => {
                let (nominal, measured) = (triple(0), triple(first_measured));
                (0..3).map(|i| n[i] * (measured[i] - nominal[i])).sum()
            }
            _ => value(first_measured),
        };
        GridNode {
            side: sides.as_ref().map(|sides| sides[k]),
            normal: normal.map(|n| [n[2], (n[0] * value(0) + n[1] * value(1)) / place[1]]),
            place,
            deviation,
            is_along_normal: by_points,
            span: table.row_span(k),
        }
    };
    if table.is_empty() {
        let message = "the grid has no rows";
        return Err(at_head(&source, Code::MissingKey, message).into());
    }
    Ok(MeasuredGrid {
        nodes: (0..table.len()).map(row).collect(),
        source,
    })
}

/// Index of the flank of each row; none without a column `flank`.
fn sides(source: &Arc<SourceFile>) -> Result<Option<Vec<usize>>, Error> {
    let heads = column_heads(source);
    let Some(column) = heads.iter().position(|(head, _)| *head == "flank") else {
        return Ok(None);
    };
    let side = |(start, text): (usize, &str)| {
        let cell = cells(text).get(column).copied().unwrap_or("");
        SIDES.iter().position(|side| *side == cell).ok_or_else(|| {
            let message = format!("`flank` cannot be \"{}\"", truncate(cell));
            Error::new(Code::OutOfRange, message)
                .with_span(&SourceSpan::new(source.clone(), start..start + text.len()))
                .with_hint("write concave or convex")
        })
    };
    lines(source)
        .skip(1)
        .map(side)
        .collect::<Result<_, _>>()
        .map(Some)
}

fn unit(n: [f64; 3]) -> [f64; 3] {
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    n.map(|x| x / length)
}

fn at_head(source: &Arc<SourceFile>, code: Code, message: &str) -> Error {
    Error::new(code, message)
        .with_span(&SourceSpan::whole_file(&source.path))
        .with_hint(format!(
            "its first line names columns with units, such as {EXAMPLE}"
        ))
}
