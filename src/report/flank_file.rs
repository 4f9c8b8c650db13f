//! Flanks of bevel gears in files: points and normals as CSV, the solids of the gears in mesh as binary STL.

use std::io::{self, Write};

use super::table::{Table, decimal};
use crate::gear::bevel::solid::Solid;
use crate::gear::bevel::tooth::SIDES;
use crate::plan::gear::bevel::BevelResult;
use crate::plan::gear_limits::MEMBERS;

/// Points along the height and along the face of a solid's flank.
const SOLID_GRID: [usize; 2] = [13, 25];

/// File formats of flanks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlankFormat {
    /// Rows of member, side, row, column, point and normal: rows from root to tip, columns from toe to heel.
    Csv,
    /// Triangles in mm.
    Stl,
}

impl FlankFormat {
    /// Suffixes of file names.
    pub const SUFFIXES: [&str; 2] = ["csv", "stl"];

    /// The format of a suffix of [`FlankFormat::SUFFIXES`].
    pub fn of_suffix(suffix: &str) -> FlankFormat {
        match suffix {
            "stl" => FlankFormat::Stl,
            _ => FlankFormat::Csv,
        }
    }
}

/// Nodes of all flanks of a result.
pub fn table(result: &BevelResult) -> Table<'static> {
    let mut table =
        Table::named("member|side|row|column|x [mm]|y [mm]|z [mm]|n_x|n_y|n_z|in fillet");
    for (member, name) in result.members.iter().zip(MEMBERS) {
        for (flank, side) in member.flanks.iter().zip(SIDES) {
            let Some(grid) = flank.as_ref().map(|f| &f.grid) else {
                continue;
            };
            for row in 0..grid.rows {
                for column in 0..grid.columns {
                    let Some(node) = grid.node(row, column) else {
                        continue;
                    };
                    let (r, n) = (node.point.point.coordinates, node.point.normal.components);
                    let place = (r * 1e3).array().map(decimal);
                    let mut cells = vec![name.to_string(), side.to_string()];
                    cells.extend([row + 1, column + 1].map(|i| i.to_string()));
                    cells.extend(place);
                    cells.extend(n.array().map(decimal));
                    cells.push(if node.in_fillet { "yes" } else { "no" }.into());
                    table.row(cells);
                }
            }
        }
    }
    table
}

/// Solids of the gears whose teeth are whole, as they touch at the reference contact; each in its place without a contact.
pub fn solids(result: &BevelResult, sides: [usize; 2]) -> Vec<Solid> {
    let [rows, columns] = SOLID_GRID;
    let placed = |k: usize| {
        let tooth = result.members[k].tooth.as_ref()?;
        let mut solid = tooth.solid(rows, columns)?;
        let contact = result.contact.as_ref();
        let turn = tooth.turn_to_cut(sides[k]);
        let pose = contact.map(|c| {
            let reference = &c.path.reference;
            let angle = [reference.pinion_angle, reference.gear_angle()][k];
            c.pair.pose(k, angle + turn)
        });
        if let Some(pose) = pose {
            solid.place(&pose);
        }
        Some(solid)
    };
    [0, 1].into_iter().filter_map(placed).collect()
}

/// Writes solids as binary STL, lengths in mm.
///
/// # Errors
/// `to` cannot be written.
pub fn write_stl(solids: &[Solid], to: &mut dyn Write) -> io::Result<()> {
    let mut header = [0u8; 80];
    let text = b"geardyn: bevel gears, lengths in mm";
    header[..text.len()].copy_from_slice(text);
    to.write_all(&header)?;
    let count: usize = solids.iter().map(|s| s.triangles.len()).sum();
    let count = u32::try_from(count).map_err(io::Error::other)?;
    to.write_all(&count.to_le_bytes())?;
    for solid in solids {
        for triangle in &solid.triangles {
            let corners = triangle.map(|i| solid.points[i].map(|x| 1e3 * x));
            let [a, b, c] = corners;
            let (u, v) = (
                [0, 1, 2].map(|k| b[k] - a[k]),
                [0, 1, 2].map(|k| c[k] - a[k]),
            );
            let normal = [
                u[1] * v[2] - u[2] * v[1],
                u[2] * v[0] - u[0] * v[2],
                u[0] * v[1] - u[1] * v[0],
            ];
            let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            let unit = normal.map(|x| if length > 0.0 { x / length } else { 0.0 });
            for x in unit.iter().chain(corners.iter().flatten()) {
                to.write_all(&(*x as f32).to_le_bytes())?;
            }
            to.write_all(&[0, 0])?;
        }
    }
    Ok(())
}
