//! Load sharing of contact lines: `C F = a Δ − g` where `F > 0`, `a·F = T`, half widths `b_i = √(4 F_i/(π E* l_i κ_i))` by Newton's method.
//!
//! Any kind of pair gives its contact lines; everything behind them is the same. At fixed widths and a fixed set of carrying cells Δ is
//! affine in the torque. A width enters by its logarithm, so the own term of a cell that carries F' has the tangent `C_ii − D`,
//! `D = 1/(π E* l_i)`, of an ellipse, whose approach grows with F^⅔, two thirds of its secant: each sweep solves the problem of the
//! compliance `C − D` and the gaps `g + D F'`, and the last one gives the tangent stiffness. That the largest width of a line sets the
//! kernel of all its cells is left out of the tangent: it costs a sweep or two and less than 2 % of the tangent.

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

/// Sweeps of the widths before the search is given up: 3 to 7 settle them.
const SWEEPS: usize = 40;
/// Sweeps before each goes halfway only: a cell that enters and leaves in turn settles so.
const UNDAMPED: usize = 12;
/// Change of the approach between two sweeps, relative, at which the widths are settled.
const SETTLED: f64 = 1e-8;
/// The same after the last sweep: next to an edge a cell may go on drifting between its neighbours, which moves the approach by less.
const LOOSE: f64 = 1e-3;
/// Least half width of a cell in widths of its line: a cell with hardly any force.
const NARROWEST: f64 = 1e-4;

/// Contact lines of all pairs of teeth at one position.
#[derive(Debug, Clone)]
pub struct LoadedLines {
    /// The lines.
    pub lines: Vec<ContactLine>,
    kernels: Vec<StripKernel>,
    /// Compliance of the teeth, line by line, lower triangles row by row.
    teeth: Vec<Vec<f64>>,
    /// 1/(π E*), 1/Pa.
    compliance: f64,
}

/// Dependence of the widths on the forces within the linear problem of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slope {
    /// They grow with the forces.
    Tangent,
    /// They stay.
    Secant,
}

/// Load on contact lines.
#[derive(Debug, Clone, PartialEq)]
pub struct LineLoads {
    /// Turn of the driven gear from the first touch, rad.
    pub turn: f64,
    /// Tangent stiffness dT/dΔ, N·m/rad.
    pub tangent: f64,
    /// Forces on the cells, line by line, N.
    pub forces: Vec<Vec<f64>>,
    /// Half widths of the cells, line by line, m.
    pub widths: Vec<Vec<f64>>,
    /// The cells that carry, in one row.
    pub active: Vec<bool>,
    /// Sweeps of the widths.
    pub sweeps: usize,
}

impl LoadedLines {
    /// The lines between members of these materials.
    pub fn new(lines: Vec<ContactLine>, materials: [Material; 2]) -> LoadedLines {
        let teeth = lines.iter().map(|line| line.tooth_compliance(&materials));
        let kernels = lines.iter().map(|line| StripKernel::new(&line.cells));
        LoadedLines {
            teeth: teeth.collect(),
            kernels: kernels.collect(),
            compliance: plane_strain_sum(&materials) / PI,
            lines,
        }
    }

    /// The load at a torque about the driven axis, N·m; `start` is that at a similar torque.
    ///
    /// # Errors
    /// As `ContactProblem::solve`; `OutOfRange` where the contact is wider than its cells or teeth; `NoConvergence` where the widths do not settle.
    pub fn solve(&self, torque: f64, start: Option<&LineLoads>) -> Result<LineLoads, Error> {
        let mut forces = match start {
            Some(start) => start.forces.clone(),
            None => self.equal_forces(torque),
        };
        let mut active: Option<Vec<bool>> = start.map(|s| s.active.clone());
        let mut before = f64::NAN;
        for sweep in 1..=SWEEPS {
            let solve = |by: Slope, forces: &[Vec<f64>], active: Option<&[bool]>| {
                let problem = self.problem(forces, by)?;
                let solution = problem.solve(torque, active);
                solution.map_err(|e| too_wide(e, torque))
            };
            // Short cells that carry little may leave the tangent indefinite on the way: the secant is not.
            let tangent = solve(Slope::Tangent, &forces, active.as_deref());
            let is_tangent = tangent.is_ok();
            let mut solution = tangent.or_else(|error| match error.code {
                Code::OutOfRange => solve(Slope::Secant, &forces, active.as_deref()),
                _ => Err(error),
            })?;
            let next = self.by_line(&solution.forces);
            let change = (solution.approach / before - 1.0).abs();
            if change <= SETTLED || (sweep == SWEEPS && change <= LOOSE) {
                if !is_tangent {
                    let last = solve(Slope::Tangent, &next, Some(&solution.active))?;
                    solution.stiffness = last.stiffness;
                }
                return Ok(self.loads(solution, next, sweep));
            }
            before = solution.approach;
            forces = match sweep > UNDAMPED {
                true => halfway(&forces, &next),
                false => next,
            };
            active = Some(solution.active);
        }
        let message = format!(
            "the widths of the contact at {} N·m of the driven gear did not settle in {SWEEPS} sweeps",
            format_number(torque)
        );
        Err(Error::new(Code::NoConvergence, message)
            .with_hint("cells shorter than the contact is wide do this: give a smaller torque or fewer stations"))
    }

    /// The cells, line by line.
    pub fn cells(&self) -> impl Iterator<Item = &ContactCell> {
        self.lines.iter().flat_map(|line| &line.cells)
    }

    /// Greatest pressure of a cell under a force at a half width, Pa: `2 F/(π b l)` of a semi-elliptic pressure, `3 F/(2 π a b)` of an
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

    /// The problem that is tangent to that of the lines at these forces.
    ///
    /// # Errors
    /// As `ContactProblem::new`.
    pub(super) fn tangent_problem(&self, forces: &[Vec<f64>]) -> Result<ContactProblem, Error> {
        self.problem(forces, Slope::Tangent)
    }

    /// The linear problem of the lines at these forces.
    fn problem(&self, forces: &[Vec<f64>], slope: Slope) -> Result<ContactProblem, Error> {
        let widths = self.widths(forces);
        let mut gaps: Vec<f64> = self.cells().map(|c| c.gap).collect();
        let mut first = 0;
        let blocks = (0..self.lines.len()).map(|k| {
            let (block, shifts) = self.line_compliance(k, (&widths[k], &forces[k]), slope);
            let own = gaps[first..].iter_mut().zip(&shifts);
            own.for_each(|(gap, shift)| *gap += shift);
            first += shifts.len();
            block
        });
        let compliance = ProfileMatrix::from_blocks(blocks);
        ContactProblem::new(compliance, self.cells().map(|c| c.arm).collect(), gaps)
    }

    /// Compliance of a line, lower triangle row by row, and what it adds to the gaps: pairs of teeth do not press on each other.
    fn line_compliance(
        &self,
        k: usize,
        (widths, forces): (&[f64], &[f64]),
        slope: Slope,
    ) -> (Vec<f64>, Vec<f64>) {
        let cells = &self.lines[k].cells;
        let widest = widths.iter().copied().fold(0.0, f64::max);
        // Mean of ln|distance| over the semi-elliptic pressure.
        let y = 0.5 * widest * (-0.5f64).exp();
        let kernel = self.kernels[k].at(y).zip(&self.teeth[k]);
        let mut block: Vec<f64> = kernel
            .map(|(contact, teeth)| self.compliance * contact + teeth)
            .collect();
        let mut shifts = Vec::with_capacity(cells.len());
        for (i, cell) in cells.iter().enumerate() {
            let diagonal = i * (i + 3) / 2;
            let share = self.compliance / cell.length;
            let (own, lost) = match &cell.ellipse {
                Some(unit) => {
                    let secant = unit.approach * unit.semi_axes[1] / widths[i];
                    // In place of the strip.
                    (
                        secant + self.teeth[k][diagonal] - block[diagonal],
                        secant / 3.0,
                    )
                }
                None => (2.0 * share * (widest / widths[i]).ln(), share),
            };
            let is_tangent = slope == Slope::Tangent && forces[i] > 0.0;
            let lost = if is_tangent { lost } else { 0.0 };
            block[diagonal] += own - lost;
            shifts.push(lost * forces[i]);
        }
        (block, shifts)
    }

    /// Half widths under forces: a cell without one is as narrow as the narrowest of its line, a line without one as wide as the widest.
    fn widths(&self, forces: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let width = |(cell, force): (&ContactCell, &f64)| match &cell.ellipse {
            Some(unit) => unit.semi_axes[1] * force.max(0.0).cbrt(),
            None => {
                let line_load = force.max(0.0) / cell.length;
                (4.0 * line_load * self.compliance / cell.curvature).sqrt()
            }
        };
        let lines = self.lines.iter().zip(forces);
        let mut all: Vec<Vec<f64>> = lines
            .map(|(line, forces)| line.cells.iter().zip(forces).map(width).collect())
            .collect();
        let largest = |widths: &[f64]| widths.iter().copied().fold(0.0, f64::max);
        let widest = all.iter().map(|line| largest(line)).fold(0.0, f64::max);
        for line in &mut all {
            let own = largest(line);
            let least = if own > 0.0 { NARROWEST * own } else { widest };
            line.iter_mut().for_each(|b| *b = b.max(least));
        }
        all
    }

    /// Forces as if all cells carried alike.
    fn equal_forces(&self, torque: f64) -> Vec<Vec<f64>> {
        let arms: f64 = self.cells().map(|c| c.arm).sum();
        let lines = self.lines.iter();
        lines
            .map(|line| vec![torque / arms; line.cells.len()])
            .collect()
    }

    fn by_line(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let mut rest = values;
        let lines = self.lines.iter().map(|line| {
            let (own, next) = rest.split_at(line.cells.len());
            rest = next;
            own.to_vec()
        });
        lines.collect()
    }
}

/// Means of two sets of forces.
fn halfway(one: &[Vec<f64>], other: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mean = |(a, b): (&f64, &f64)| 0.5 * (a + b);
    let lines = one.iter().zip(other);
    lines
        .map(|(a, b)| a.iter().zip(b).map(mean).collect())
        .collect()
}

/// A compliance that is not positive definite comes of a contact wider than its cells or as deep as its teeth.
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
