//! Contact lines of tooth pairs cut into cells, and their elasticity as half spaces under strips of semi-elliptic pressure:
//! `u_i = Σ_j F_j/(π E* l_j) ∫ ds/√(s² + y²)`, `y = b e^{−1/2}/2`.
//!
//! That y is the mean of ln|distance| over the semi-elliptic pressure of half width b, so the flattening and the lengthwise coupling are
//! one formula. With one b a line, its largest, the matrix is positive definite; a narrower cell adds `2 ln(b/b_i)/(π E* l_i)` to its own
//! term. Where the bending of the teeth is added, the half space ends at the middle of the tooth: less the same load's displacement at
//! that depth h, `(1 + ν)/(2πE) [2(1 − ν) asinh(s/h) + s/√(s² + h²)]`, of each body (Johnson, Contact Mechanics, 1985, eq. 3.19).

use std::f64::consts::PI;

use super::hertz::plane_strain_sum;
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
    /// Compliance that does not depend on the widths, row by row: bending of both teeth less their half spaces beyond the middle.
    pub(super) fn tooth_compliance(&self, materials: &[Material; 2]) -> Vec<f64> {
        self.symmetric(|i, row| {
            for (j, value) in row.iter_mut().enumerate() {
                let cells = (&self.cells[i], &self.cells[j]);
                let (Some(here), Some(there)) = (&cells.0.teeth, &cells.1.teeth) else {
                    continue;
                };
                for k in 0..2 {
                    let bending: f64 = (here[k].shape.iter().zip(&there[k].response))
                        .map(|(a, b)| a * b)
                        .sum();
                    *value += bending - below_middle(cells, here[k].depth, &materials[k]);
                }
            }
        })
    }

    /// Compliance of the half spaces at half widths of the cells, m/N, row by row.
    pub(super) fn contact_compliance(&self, widths: &[f64], materials: &[Material; 2]) -> Vec<f64> {
        let compliance = plane_strain_sum(materials) / PI;
        let widest = widths.iter().copied().fold(0.0, f64::max);
        let y = 0.5 * widest * (-0.5f64).exp();
        self.symmetric(|i, row| {
            for (value, cell) in row.iter_mut().zip(&self.cells) {
                let [near, far] = self.ends(i, cell);
                *value = compliance / cell.length * ((far / y).asinh() - (near / y).asinh());
            }
            row[i] += compliance / self.cells[i].length * 2.0 * (widest / widths[i]).ln();
        })
    }

    /// Places of the ends of a cell along the line, from the middle of cell i.
    fn ends(&self, i: usize, cell: &ContactCell) -> [f64; 2] {
        let apart = cell.along - self.cells[i].along;
        [apart - 0.5 * cell.length, apart + 0.5 * cell.length]
    }

    /// The mean of a matrix and its transpose: cells of unequal lengths see each other differently by the second order of their length.
    fn symmetric(&self, fill: impl Fn(usize, &mut [f64])) -> Vec<f64> {
        let n = self.cells.len();
        let mut rows = vec![0.0; n * n];
        for (i, row) in rows.chunks_exact_mut(n.max(1)).enumerate() {
            fill(i, row);
        }
        for i in 0..n {
            for j in 0..i {
                let mean = 0.5 * (rows[i * n + j] + rows[j * n + i]);
                (rows[i * n + j], rows[j * n + i]) = (mean, mean);
            }
        }
        rows
    }
}

/// Displacement of one half space at a depth below the first cell for a unit force on the second, m/N.
fn below_middle(
    (here, there): (&ContactCell, &ContactCell),
    depth: f64,
    material: &Material,
) -> f64 {
    let nu = material.poisson;
    let kernel = |s: f64| 2.0 * (1.0 - nu) * (s / depth).asinh() + s / s.hypot(depth);
    let apart = there.along - here.along;
    let integral = kernel(apart + 0.5 * there.length) - kernel(apart - 0.5 * there.length);
    (1.0 + nu) / (2.0 * PI * material.young * there.length) * integral
}
