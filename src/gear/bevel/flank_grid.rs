//! Nodes of a bevel flank over its blank, in the order of coordinate-measuring machines: rows from root to tip, columns from toe to heel.

use super::flank::{BevelFlank, ToothPoint};
use crate::numeric::statistics::extremes;

/// Minimum extension of a parameter range at each end, rad.
const MIN_MARGIN: f64 = 0.05;

/// Nodes of a flank, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankGrid {
    /// Rows along the height.
    pub rows: usize,
    /// Columns along the face.
    pub columns: usize,
    /// Nodes, row by row; `None` where no flank is cut or where the flank is undercut.
    pub nodes: Vec<Option<ToothPoint>>,
}

impl FlankGrid {
    /// Nodes of a flank at equal shares of height and face, ends included; `None` if no point of the flank is found.
    ///
    /// Newton's method starts from the cubic extrapolation of four nodes, then from the middle, then in small steps from the last node,
    /// because the parameters of a slim pinion change by radians between nodes.
    pub fn of(flank: &BevelFlank, rows: usize, columns: usize) -> Option<FlankGrid> {
        let middle = (flank.middle()?, flank.section.at(0.5, 0.5));
        let share = |i: usize, n: usize| match n {
            0 | 1 => 0.5,
            _ => i as f64 / (n - 1) as f64,
        };
        let mut nodes = Vec::with_capacity(rows * columns);
        let mut row_start = middle;
        for row in 0..rows {
            let mut last = row_start;
            for column in 0..columns {
                let position = flank.section.at(share(column, columns), share(row, rows));
                let preceding = |offset: usize| -> Option<[f64; 3]> {
                    let node: ToothPoint =
                        (column >= offset).then(|| nodes[nodes.len() - offset])??;
                    (!node.in_fillet).then_some(node.point.at)
                };
                let start = match [4, 3, 2, 1].map(preceding) {
                    [Some(a), Some(b), Some(c), Some(d)] => {
                        [0, 1, 2].map(|k| 4.0 * (b[k] + d[k]) - 6.0 * c[k] - a[k])
                    }
                    [_, _, Some(c), Some(d)] => [0, 1, 2].map(|k| 2.0 * d[k] - c[k]),
                    _ => last.0,
                };
                let node = (flank.tooth_point(position, start))
                    .or_else(|| flank.tooth_point(position, middle.0))
                    .or_else(|| flank.tooth_point(position, flank.follow(last, position)?));
                let node = node.filter(|n| n.in_fillet || !n.is_cut_away());
                if let Some(node) = node.as_ref().filter(|n| !n.in_fillet) {
                    last = (node.point.at, position);
                    if column == 0 {
                        row_start = last;
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

    /// Ranges of cradle and cutter angle `[x, θ]` of the nodes on the flank, rad; `None` without such nodes.
    pub fn ranges(&self) -> Option<[[f64; 2]; 2]> {
        let on_flank = || self.nodes.iter().flatten().filter(|n| !n.in_fillet);
        let range = |k: usize| extremes(on_flank().map(|n| n.point.at[k])).into();
        on_flank().next()?;
        Some([range(2), range(1)])
    }

    /// [`FlankGrid::ranges`] extended by their widths at both ends, the domain of the limit curves that cross the section.
    pub fn domain(&self) -> Option<[[f64; 2]; 2]> {
        let widened = |[low, high]: [f64; 2]| {
            let margin = (high - low).max(MIN_MARGIN);
            [low - margin, high + margin]
        };
        Some(self.ranges()?.map(widened))
    }

    /// Shares of face and height of the missing node nearest the tip; `None` if all nodes above the root exist. The blade tip touches the
    /// root cone along one line, so that other nodes at the root may lie slightly below the swept surface.
    pub fn highest_missing(&self) -> Option<[f64; 2]> {
        let k = self.nodes.iter().rposition(Option::is_none)?;
        let (row, column) = (k / self.columns, k % self.columns);
        let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        (row > 0).then(|| [share(column, self.columns), share(row, self.rows)])
    }

    /// Parameters `[s, θ, φ_c]` of the lowest and the highest node on the flank in the column nearest a share of the face; `None` if the
    /// column has no node.
    pub fn ends_of_column(&self, face: f64) -> Option<[[f64; 3]; 2]> {
        let column = (face * (self.columns - 1) as f64).round() as usize;
        let nodes = || (0..self.rows).filter_map(|row| self.node(row, column));
        let mut on_flank = nodes().filter(|n| !n.in_fillet).map(|n| n.point.at);
        let lowest = on_flank.next()?;
        Some([lowest, on_flank.next_back().unwrap_or(lowest)])
    }

    /// Node of a row and a column.
    pub fn node(&self, row: usize, column: usize) -> Option<&ToothPoint> {
        self.nodes.get(row * self.columns + column)?.as_ref()
    }
}
