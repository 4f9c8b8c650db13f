//! The cut flank as triangles over the nodes of the ideal one, each moved along its normal.

use super::blade_passes::CutPoint;
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::bevel::solid::Solid;

/// The open surface of a cut flank, m; cells with a node that is not cut are left out.
pub fn cut_surface(grid: &FlankGrid, cuts: &[Option<CutPoint>]) -> Solid {
    let mut points = Vec::new();
    let mut numbers = Vec::with_capacity(cuts.len());
    for (node, cut) in grid.nodes.iter().zip(cuts) {
        let (Some(node), Some(cut)) = (node, cut) else {
            numbers.push(None);
            continue;
        };
        numbers.push(Some(points.len()));
        let (r, n) = (node.point.point.coordinates, node.point.normal.components);
        points.push((r + n * cut.deviation).array());
    }
    let at =
        |row: usize, column: usize| numbers.get(row * grid.columns + column).copied().flatten();
    let mut triangles = Vec::new();
    for row in 1..grid.rows {
        for column in 1..grid.columns {
            let corners = [
                at(row - 1, column - 1),
                at(row - 1, column),
                at(row, column),
                at(row, column - 1),
            ];
            if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    let mut solid = Solid { points, triangles };
    orient(&mut solid, grid);
    solid
}

/// Turns the triangles so that they face out of the metal, as the normals of the nodes.
fn orient(solid: &mut Solid, grid: &FlankGrid) {
    let node = grid.nodes.iter().flatten().find(|n| !n.in_fillet);
    let (Some(node), Some(triangle)) = (node, solid.triangles.first()) else {
        return;
    };
    let [a, b, c] = triangle.map(|i| solid.points[i]);
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
    let n = node.point.normal.components.array();
    let facing = n[0] * (u[1] * v[2] - u[2] * v[1])
        + n[1] * (u[2] * v[0] - u[0] * v[2])
        + n[2] * (u[0] * v[1] - u[1] * v[0]);
    if facing < 0.0 {
        solid.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}
