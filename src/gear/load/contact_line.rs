//! Contact lines of tooth pairs, divided into cells, on half spaces under strips of semi-elliptic pressure:
//! `u_i = Σ_j F_j/(π E* l_j) ∫ ds/√(s² + y²)`, `y = b e^{−1/2}/2`.
//!
//! The offset y is the mean of ln|distance| over the semi-elliptic pressure of half width b, so one formula gives local flattening and
//! lengthwise coupling. With the largest b of a line for all cells the matrix is positive definite; a narrower cell adds
//! `2 ln(b/b_i)/(π E* l_i)` to its diagonal term. With tooth bending the half space ends at the middle of the tooth: the displacement at
//! that depth h, `(1 + ν)/(2πE) [2(1 − ν) asinh(s/h) + s/√(s² + h²)]`, is subtracted (Johnson, Contact Mechanics, 1985, eq. 3.19).

use std::f64::consts::PI;

use super::elliptic_contact::EllipticContact;
use super::material::Material;

/// Cell of a contact line with one normal force.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCell {
    /// Position of the centre along the line, m.
    pub along: f64,
    /// Length, m.
    pub length: f64,
    /// Unloaded gap, m, relative to first contact of all pairs.
    pub gap: f64,
    /// Lever arm of the normal force about the driven axis, m.
    pub arm: f64,
    /// Relative curvature across the line, 1/m.
    pub curvature: f64,
    /// True for a cell on an edge of a tooth.
    pub on_edge: bool,
    /// Elliptic contact under 1 N, if the cell represents the entire ellipse and is the only cell of its line.
    pub ellipse: Option<EllipticContact>,
    /// Bending response of the teeth of both members at the cell; `None` for rigid teeth.
    pub teeth: Option<[ToothLoad; 2]>,
}

/// Bending response of a tooth to a unit force on a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothLoad {
    /// Depth of the middle plane of the tooth below the flank along the normal, m.
    pub depth: f64,
    /// Shape functions of tooth bending at the cell, in the direction of the force.
    pub shape: Vec<f64>,
    /// Coefficients of the shape functions for the unit force, m/N: the product with the shape at a cell is the displacement of the cell.
    pub response: Vec<f64>,
}

/// Contact line of a pair of teeth.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLine {
    /// Number of the tooth pair.
    pub pair: i32,
    /// Cells in order along the line.
    pub cells: Vec<ContactCell>,
}

impl ContactLine {
    /// Compliance independent of the contact widths, m/N, lower triangle row by row: bending of both teeth minus their half spaces below
    /// the middle plane, symmetrised for each pair of cells.
    pub(super) fn tooth_compliance(&self, materials: &[Material; 2]) -> Vec<f64> {
        let mut triangle = Vec::with_capacity(self.cells.len() * (self.cells.len() + 1) / 2);
        for (i, cell) in self.cells.iter().enumerate() {
            for other in &self.cells[..=i] {
                triangle.push(cell_compliance(cell, other, materials));
            }
        }
        triangle
    }
}

/// Displacement of the teeth at one cell for a unit force on another, m/N; zero for rigid teeth.
fn cell_compliance(cell: &ContactCell, other: &ContactCell, materials: &[Material; 2]) -> f64 {
    let (Some(response), Some(excitation)) = (&cell.teeth, &other.teeth) else {
        return 0.0;
    };
    let member = |k: usize| {
        let terms = response[k].shape.iter().zip(&excitation[k].response);
        // The bending term is symmetric in both cells.
        let bending: f64 = terms.map(|(a, b)| a * b).sum();
        let half_space = below_middle((cell, other), response[k].depth, &materials[k])
            + below_middle((other, cell), excitation[k].depth, &materials[k]);
        bending - 0.5 * half_space
    };
    member(0) + member(1)
}

/// Displacement of a half space at a depth, m, below the first cell for a unit force on the second, m/N.
fn below_middle(
    (cell, loaded): (&ContactCell, &ContactCell),
    depth: f64,
    material: &Material,
) -> f64 {
    let nu = material.poisson;
    let distance = (loaded.along - cell.along).abs();
    let [a, b] = [-0.5, 0.5].map(|half| (distance + half * loaded.length) / depth);
    let [root_a, root_b] = [a, b].map(|s| (s * s + 1.0).sqrt());
    let integral =
        2.0 * (1.0 - nu) * asinh_between([a, b], [root_a, root_b]) + b / root_b - a / root_a;
    (1.0 + nu) / (2.0 * PI * material.young * loaded.length) * integral
}

/// Difference `asinh(b) − asinh(a)` for b ≥ |a|, given `√(a² + 1)` and `√(b² + 1)`: one logarithm without cancellation.
pub(super) fn asinh_between([a, b]: [f64; 2], [root_a, root_b]: [f64; 2]) -> f64 {
    match a < 0.0 {
        true => ((b + root_b) * (root_a - a)).ln(),
        false => ((b + root_b) / (a + root_a)).ln(),
    }
}
