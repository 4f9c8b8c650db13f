//! Nodes of a bevel flank over its blank, in the order of coordinate-measuring machines: rows from root to tip, columns from toe to heel.

use super::flank::BevelFlank;
use super::frames::WorkFrame;
use crate::gear::kernel::envelope::FlankPoint;

/// Nodes of a flank, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankGrid {
    /// Rows along the height.
    pub rows: usize,
    /// Columns along the face.
    pub columns: usize,
    /// Nodes, row by row; none where the cutter leaves no flank.
    pub nodes: Vec<Option<FlankPoint<WorkFrame>>>,
}

impl FlankGrid {
    /// The nodes of a flank at equal shares of height and face, both with their ends; none where no point of the flank is found.
    ///
    /// Each node starts from the one before it, then from the middle.
    pub fn of(flank: &BevelFlank, rows: usize, columns: usize) -> Option<FlankGrid> {
        let middle = flank.middle()?;
        let share = |i: usize, n: usize| match n {
            0 | 1 => 0.5,
            _ => i as f64 / (n - 1) as f64,
        };
        let mut nodes = Vec::with_capacity(rows * columns);
        let mut row_start = middle;
        for row in 0..rows {
            let mut near = row_start;
            for column in 0..columns {
                let place = [share(column, columns), share(row, rows)];
                let node = flank
                    .point(place, near)
                    .or_else(|| flank.point(place, middle));
                if let Some(node) = &node {
                    near = node.at;
                    if column == 0 {
                        row_start = near;
                    }
                }
                nodes.push(node);
            }
        }
        Some(FlankGrid {
            rows,
            columns,
            nodes,
        })
    }

    /// The node of a row and a column.
    pub fn node(&self, row: usize, column: usize) -> Option<&FlankPoint<WorkFrame>> {
        self.nodes.get(row * self.columns + column)?.as_ref()
    }
}
