//! Load sharing of contact lines: `C F = a Δ − g` where `F > 0`, `a·F = T`, half widths `b_i = √(4 F_i/(π E* l_i κ_i))` by Newton's method.
//!
//! The contact lines of any gear type are input. At fixed widths and a fixed active set Δ is affine in the torque. The width enters the
//! compliance by its logarithm, so the diagonal term of a cell under force F' has the tangent `C_ii − D`, `D = 1/(π E* l_i)`; that of an
//! ellipse, with approach ∝ F^⅔, is two thirds of its secant. Each sweep solves the contact problem of compliance `C − D` and gaps
//! `g + D F'`; the last sweep gives the tangent stiffness. The tangent neglects that the largest width of a line sets the kernel of all
//! its cells: this costs one or two sweeps and less than 2 % of the tangent stiffness.

use std::f64::consts::PI;

use super::contact_line::{ContactCell, ContactLine};
use super::hertz::plane_strain_sum;
use super::material::Material;
use super::strip_kernel::StripKernel;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;
use crate::numeric::complementarity::{ContactProblem, ContactSolution};
use crate::numeric::profile_matrix::ProfileMatrix;

/// Maximum number of sweeps; convergence takes 3 to 7.
const SWEEPS: usize = 40;
/// Sweeps before damping by one half, which makes an alternating active set converge.
const UNDAMPED_SWEEPS: usize = 12;
/// Relative change of the approach between two sweeps at convergence.
const TOLERANCE: f64 = 1e-8;
/// Tolerance after the last sweep: forces of cells next to an edge may still drift, which changes the approach by less.
const FINAL_TOLERANCE: f64 = 1e-3;
/// Minimum half width of a cell relative to the largest of its line.
const MIN_WIDTH: f64 = 1e-4;

/// Contact lines of all tooth pairs at one position, with their influence coefficients.
#[derive(Debug, Clone)]
pub struct LoadedLines {
    /// Contact lines of the tooth pairs in contact.
    pub lines: Vec<ContactLine>,
    kernels: Vec<StripKernel>,
    /// Tooth compliance by line, m/N: lower triangle, row by row.
    tooth_compliance: Vec<Vec<f64>>,
    /// 1/(π E*), 1/Pa.
    compliance: f64,
}

/// Treatment of the half widths in the linear problem of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slope {
    /// Widths vary with the forces.
    Tangent,
    /// Widths are fixed.
    Secant,
}

/// Load distribution on the contact lines at one torque.
#[derive(Debug, Clone, PartialEq)]
pub struct LineLoads {
    /// Rotation of the driven gear from first contact, rad: the approach Δ.
    pub turn: f64,
    /// Tangent stiffness dT/dΔ about the driven axis, N·m/rad.
    pub tangent: f64,
    /// Normal forces on the cells by line, N.
    pub forces: Vec<Vec<f64>>,
    /// Half widths of the contact at the cells by line, m.
    pub widths: Vec<Vec<f64>>,
    /// Active set: whether each cell carries load, all lines in sequence.
    pub active: Vec<bool>,
    /// Number of sweeps.
    pub sweeps: usize,
}

impl LoadedLines {
    /// Influence coefficients of contact lines between members of the given materials.
    pub fn new(lines: Vec<ContactLine>, materials: [Material; 2]) -> LoadedLines {
        let teeth = lines.iter().map(|line| line.tooth_compliance(&materials));
        let kernels = lines.iter().map(|line| StripKernel::new(&line.cells));
        LoadedLines {
            tooth_compliance: teeth.collect(),
            kernels: kernels.collect(),
            compliance: plane_strain_sum(&materials) / PI,
            lines,
        }
    }

    /// Load distribution at a torque about the driven axis, N·m; `start` is the solution at a similar torque.
    ///
    /// # Errors
    /// As `ContactProblem::solve`; `OutOfRange` where the contact is wider than its cells or teeth; `NoConvergence` after 40 sweeps.
    pub fn solve(&self, torque: f64, start: Option<&LineLoads>) -> Result<LineLoads, Error> {
        let mut forces = match start {
            Some(start) => start.forces.clone(),
            None => self.equal_forces(torque),
        };
        let mut active: Option<Vec<bool>> = start.map(|s| s.active.clone());
        let mut previous = f64::NAN;
        for sweep in 1..=SWEEPS {
            let solve = |slope: Slope, forces: &[Vec<f64>], active: Option<&[bool]>| {
                let problem = self.problem(forces, slope)?;
                let solution = problem.solve(torque, active);
                solution.map_err(|e| too_wide(e, torque))
            };
            // Short cells under small load can make the tangent compliance indefinite; the secant stays definite.
            let tangent = solve(Slope::Tangent, &forces, active.as_deref());
            let is_tangent = tangent.is_ok();
            let mut solution = tangent.or_else(|error| match error.code {
                Code::OutOfRange => solve(Slope::Secant, &forces, active.as_deref()),
                _ => Err(error),
            })?;
            let next = self.by_line(&solution.forces);
            let change = (solution.approach / previous - 1.0).abs();
            if change <= TOLERANCE || (sweep == SWEEPS && change <= FINAL_TOLERANCE) {
                if !is_tangent {
                    let last = solve(Slope::Tangent, &next, Some(&solution.active))?;
                    solution.stiffness = last.stiffness;
                }
                return Ok(self.loads(solution, next, sweep));
            }
            previous = solution.approach;
            forces = match sweep > UNDAMPED_SWEEPS {
                true => mean_forces(&forces, &next),
                false => next,
            };
            active = Some(solution.active);
        }
        let message = format!(
            "the contact widths at {} N·m of the driven gear did not converge in {SWEEPS} sweeps",
            format_number(torque)
        );
        Err(Error::new(Code::NoConvergence, message)
            .with_hint("the usual cause is cells shorter than the contact width: give a smaller torque or fewer stations"))
    }

    /// Cells of all lines in sequence.
    pub fn cells(&self) -> impl Iterator<Item = &ContactCell> {
        self.lines.iter().flat_map(|line| &line.cells)
    }

    /// Maximum Hertzian pressure of a cell, Pa, at a force, N, and a half width, m: `2 F/(π b l)` for a line, `3 F/(2 π a b)` for an
    /// ellipse.
    pub fn pressure(cell: &ContactCell, force: f64, width: f64) -> f64 {
        match &cell.ellipse {
            Some(ellipse) => 1.5 * force / (PI * ellipse.aspect() * width * width),
            None => 2.0 * force / (PI * width * cell.length),
        }
    }

    fn loads(&self, solution: ContactSolution, forces: Vec<Vec<f64>>, sweeps: usize) -> LineLoads {
        LineLoads {
            turn: solution.approach,
            tangent: solution.stiffness,
            widths: self.widths(&forces),
            forces,
            active: solution.active,
            sweeps,
        }
    }

    /// Contact problem linearised at given forces, N by line, with variable widths.
    ///
    /// # Errors
    /// As `ContactProblem::new`.
    pub(super) fn tangent_problem(&self, forces: &[Vec<f64>]) -> Result<ContactProblem, Error> {
        self.problem(forces, Slope::Tangent)
    }

    /// Linear contact problem of the lines at given forces.
    fn problem(&self, forces: &[Vec<f64>], slope: Slope) -> Result<ContactProblem, Error> {
        let widths = self.widths(forces);
        let mut gaps: Vec<f64> = self.cells().map(|c| c.gap).collect();
        let mut first = 0;
        let blocks = (0..self.lines.len()).map(|k| {
            let (block, shifts) = self.line_compliance(k, (&widths[k], &forces[k]), slope);
            let line_gaps = gaps[first..].iter_mut().zip(&shifts);
            line_gaps.for_each(|(gap, shift)| *gap += shift);
            first += shifts.len();
            block
        });
        let compliance = ProfileMatrix::from_blocks(blocks);
        ContactProblem::new(compliance, self.cells().map(|c| c.arm).collect(), gaps)
    }

    /// Compliance of a line, lower triangle row by row, and its gap increments; tooth pairs are not coupled.
    fn line_compliance(
        &self,
        k: usize,
        (widths, forces): (&[f64], &[f64]),
        slope: Slope,
    ) -> (Vec<f64>, Vec<f64>) {
        let cells = &self.lines[k].cells;
        let widest = widths.iter().copied().fold(0.0, f64::max);
        // Kernel distance equal to the mean of ln|distance| over the semi-elliptic pressure.
        let y = 0.5 * widest * (-0.5f64).exp();
        let kernel = self.kernels[k].at(y).zip(&self.tooth_compliance[k]);
        let mut block: Vec<f64> = kernel
            .map(|(contact, teeth)| self.compliance * contact + teeth)
            .collect();
        let mut shifts = Vec::with_capacity(cells.len());
        for (i, cell) in cells.iter().enumerate() {
            let diagonal = i * (i + 3) / 2;
            let unit_term = self.compliance / cell.length;
            let (diagonal_term, reduction) = match &cell.ellipse {
                Some(unit) => {
                    let secant = unit.approach * unit.semi_axes[1] / widths[i];
                    // Replaces the diagonal term of the strip.
                    (
                        secant + self.tooth_compliance[k][diagonal] - block[diagonal],
                        secant / 3.0,
                    )
                }
                None => (2.0 * unit_term * (widest / widths[i]).ln(), unit_term),
            };
            let is_tangent = slope == Slope::Tangent && forces[i] > 0.0;
            let reduction = if is_tangent { reduction } else { 0.0 };
            block[diagonal] += diagonal_term - reduction;
            shifts.push(reduction * forces[i]);
        }
        (block, shifts)
    }

    /// Half widths under given forces; an unloaded cell takes the minimum of its line, an unloaded line the largest width of all lines.
    fn widths(&self, forces: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let width = |(cell, force): (&ContactCell, &f64)| match &cell.ellipse {
            Some(unit) => unit.semi_axes[1] * force.max(0.0).cbrt(),
            None => {
                let line_load = force.max(0.0) / cell.length;
                (4.0 * line_load * self.compliance / cell.curvature).sqrt()
            }
        };
        let lines = self.lines.iter().zip(forces);
        let mut widths: Vec<Vec<f64>> = lines
            .map(|(line, forces)| line.cells.iter().zip(forces).map(width).collect())
            .collect();
        let largest = |widths: &[f64]| widths.iter().copied().fold(0.0, f64::max);
        let widest = widths.iter().map(|line| largest(line)).fold(0.0, f64::max);
        for line in &mut widths {
            let max = largest(line);
            let least = if max > 0.0 { MIN_WIDTH * max } else { widest };
            line.iter_mut().for_each(|b| *b = b.max(least));
        }
        widths
    }

    /// Equal forces on all cells in equilibrium with the torque.
    fn equal_forces(&self, torque: f64) -> Vec<Vec<f64>> {
        let arms: f64 = self.cells().map(|c| c.arm).sum();
        let lines = self.lines.iter();
        lines
            .map(|line| vec![torque / arms; line.cells.len()])
            .collect()
    }

    fn by_line(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let mut remaining = values;
        let lines = self.lines.iter().map(|line| {
            let (line_values, next) = remaining.split_at(line.cells.len());
            remaining = next;
            line_values.to_vec()
        });
        lines.collect()
    }
}

/// Mean of two force distributions.
fn mean_forces(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mean = |(a, b): (&f64, &f64)| 0.5 * (a + b);
    let lines = a.iter().zip(b);
    lines
        .map(|(a, b)| a.iter().zip(b).map(mean).collect())
        .collect()
}

/// Converts `IllPosed` to `OutOfRange`: the compliance is indefinite where the contact is wider than its cells or as deep as its teeth.
pub(super) fn too_wide(error: Error, torque: f64) -> Error {
    if error.code != Code::IllPosed {
        return error;
    }
    let message = format!(
        "the contact at {} N·m of the driven gear is too wide for its cells or its teeth",
        format_number(torque)
    );
    Error::new(Code::OutOfRange, message).with_hint("give a smaller torque or fewer stations")
}
