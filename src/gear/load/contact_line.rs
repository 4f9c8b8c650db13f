//! Contact lines of tooth pairs cut into cells, and their elasticity as half spaces under strips of semi-elliptic pressure:
//! `u_i = Σ_j F_j/(π E* l_j) ∫ ds/√(s² + y²)`, `y = b e^{−1/2}/2`.
//!
//! That y is the mean of ln|distance| over the semi-elliptic pressure of half width b, so the flattening and the lengthwise coupling are
//! one formula. With one b a line, its largest, the matrix is positive definite; a narrower cell adds `2 ln(b/b_i)/(π E* l_i)` to its own
//! term. Where the bending of the teeth is added, the half space ends at the middle of the tooth: less the same load's displacement at
//! that depth h, `(1 + ν)/(2πE) [2(1 − ν) asinh(s/h) + s/√(s² + h²)]`, of each body (Johnson, Contact Mechanics, 1985, eq. 3.19).

use std::f64::consts::PI;

use super::elliptic_contact::EllipticContact;
use super::material::Material;

/// A cell of a contact line: a length that carries one force.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCell {
    /// Place of its middle along the line, m.
    pub along: f64,
    /// Length, m.
    pub length: f64,
    /// Gap without load, m, counted from where the highest place of all pairs touches.
    pub gap: f64,
    /// Arm of its normal force about the driven axis, m.
    pub arm: f64,
    /// Relative curvature across the line, 1/m.
    pub curvature: f64,
    /// It lies on an edge of a tooth.
    pub on_edge: bool,
    /// Elliptic contact under 1 N, if the cell represents all of it and is the only cell of its line.
    pub ellipse: Option<EllipticContact>,
    /// Teeth of both members under it; none where they are rigid.
    pub teeth: Option<[ToothLoad; 2]>,
}

/// Response of one tooth to a unit force on a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothLoad {
    /// Depth of the tooth's middle plane below the flank along the normal, m.
    pub depth: f64,
    /// Shape functions of the bending tooth at the cell, along the force.
    pub shape: Vec<f64>,
    /// Coefficients of these functions under the force, m/N: its product with the shape at a cell is the displacement there.
    pub response: Vec<f64>,
}

/// The contact line of a pair of teeth.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLine {
    /// The pair.
    pub pair: i32,
    /// Cells in order.
    pub cells: Vec<ContactCell>,
}

impl ContactLine {
    /// Compliance that does not depend on the widths, lower triangle row by row: bending of both teeth less their half spaces beyond the
    /// middle, each pair of cells by the mean of both views.
    pub(super) fn tooth_compliance(&self, materials: &[Material; 2]) -> Vec<f64> {
        let mut triangle = Vec::with_capacity(self.cells.len() * (self.cells.len() + 1) / 2);
        for (i, here) in self.cells.iter().enumerate() {
            for there in &self.cells[..=i] {
                triangle.push(seen(here, there, materials));
            }
        }
        triangle
    }
}

/// Displacement of the teeth under a cell for a unit force on another, m/N; zero where they are rigid.
fn seen(here: &ContactCell, there: &ContactCell, materials: &[Material; 2]) -> f64 {
    let (Some(own), Some(loaded)) = (&here.teeth, &there.teeth) else {
        return 0.0;
    };
    let member = |k: usize| {
        let terms = own[k].shape.iter().zip(&loaded[k].response);
        // The plate answers both views alike.
        let bending: f64 = terms.map(|(a, b)| a * b).sum();
        let views = below_middle((here, there), own[k].depth, &materials[k])
            + below_middle((there, here), loaded[k].depth, &materials[k]);
        bending - 0.5 * views
    };
    member(0) + member(1)
}

/// Displacement of one half space at a depth below the first cell for a unit force on the second, m/N.
fn below_middle(
    (here, there): (&ContactCell, &ContactCell),
    depth: f64,
    material: &Material,
) -> f64 {
    let nu = material.poisson;
    let apart = (there.along - here.along).abs();
    let [near, far] = [-0.5, 0.5].map(|half| (apart + half * there.length) / depth);
    let [to_near, to_far] = [near, far].map(|s| (s * s + 1.0).sqrt());
    let integral = 2.0 * (1.0 - nu) * asinh_between([near, far], [to_near, to_far]) + far / to_far
        - near / to_near;
    (1.0 + nu) / (2.0 * PI * material.young * there.length) * integral
}

/// `asinh(b) − asinh(a)` of `[a, b]` with b not below |a|, given `√(a² + 1)` and `√(b² + 1)`: one logarithm without cancellation.
pub(super) fn asinh_between([a, b]: [f64; 2], [root_a, root_b]: [f64; 2]) -> f64 {
    match a < 0.0 {
        true => ((b + root_b) * (root_a - a)).ln(),
        false => ((b + root_b) / (a + root_a)).ln(),
    }
}
