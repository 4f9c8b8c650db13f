//! Load sharing of contact lines: `C F = a Δ − g` where `F > 0`, `a·F = T`, half widths `b_i = √(4 F_i/(π E* l_i κ_i))` by a fixed point.
//!
//! Any kind of pair gives its contact lines; everything behind them is the same. At fixed widths and a fixed set of carrying cells Δ is
//! affine in the torque; the widths enter by their logarithm, so a few sweeps settle them. Their change with the force makes the tangent
//! stiffer than the secant: `∂(C F)/∂F` has `1/(π E* l_i)` less on its diagonal.

use std::f64::consts::PI;

use super::contact_line::{ContactCell, ContactLine};
use super::hertz::plane_strain_sum;
use super::material::Material;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::complementarity::{ContactProblem, ContactSolution};
use crate::numeric::profile_matrix::ProfileMatrix;

/// Sweeps of the widths before the search is given up: 6 to 12 settle them.
const SWEEPS: usize = 40;
/// Sweeps before each goes halfway only, in the logarithm: a cell that enters and leaves in turn settles so.
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
    materials: [Material; 2],
    /// Compliance of the teeth, line by line.
    teeth: Vec<Vec<f64>>,
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
        LoadedLines {
            teeth: teeth.collect(),
            materials,
            lines,
        }
    }

    /// The load at a torque about the driven axis, N·m; `start` is that at a similar torque.
    ///
    /// # Errors
    /// As `ContactProblem::solve`; `OutOfRange` where the contact is wider than its cells or teeth; `NoConvergence` where the widths do not settle.
    pub fn solve(&self, torque: f64, start: Option<&LineLoads>) -> Result<LineLoads, Error> {
        let mut widths = match start {
            Some(start) => start.widths.clone(),
            None => self.first_widths(torque),
        };
        let mut active: Option<Vec<bool>> = start.map(|s| s.active.clone());
        let mut before = f64::NAN;
        for sweep in 1..=SWEEPS {
            let compliance = self.compliance(&widths);
            let solution = self
                .problem(compliance.clone())?
                .solve(torque, active.as_deref())
                .map_err(|e| too_wide(e, torque))?;
            let forces = self.by_line(&solution.forces);
            let next = self.widths(&forces);
            widths = match sweep > UNDAMPED {
                true => halfway(&widths, &next),
                false => next,
            };
            let change = (solution.approach / before - 1.0).abs();
            before = solution.approach;
            if change <= SETTLED || (sweep == SWEEPS && change <= LOOSE) {
                return self.loads(&solution, compliance, (forces, widths), sweep);
            }
            active = Some(solution.active);
        }
        let message =
            format!("the widths of the contact at {torque} N·m did not settle in {SWEEPS} sweeps");
        Err(Error::new(Code::NoConvergence, message)
            .with_hint("cells shorter than the contact is wide do this: give a smaller torque or fewer stations"))
    }

    /// The cells, line by line.
    pub fn cells(&self) -> impl Iterator<Item = &ContactCell> {
        self.lines.iter().flat_map(|line| &line.cells)
    }

    /// Greatest pressure of a cell under a force at a half width, Pa: `2 F/(π b l)` of a semi-elliptic pressure.
    pub fn pressure(cell: &ContactCell, force: f64, width: f64) -> f64 {
        2.0 * force / (PI * width * cell.length)
    }

    fn loads(
        &self,
        solution: &ContactSolution,
        mut compliance: Vec<f64>,
        (forces, widths): (Vec<Vec<f64>>, Vec<Vec<f64>>),
        sweeps: usize,
    ) -> Result<LineLoads, Error> {
        let n = solution.forces.len();
        for (i, cell) in self.cells().enumerate() {
            compliance[i * n + i] -= plane_strain_sum(&self.materials) / (PI * cell.length);
        }
        let set: Vec<usize> = (0..n).filter(|i| solution.active[*i]).collect();
        let arms: Vec<f64> = self.cells().map(|c| c.arm).collect();
        let carrying: Vec<f64> = set.iter().map(|i| arms[*i]).collect();
        let mut stretched = carrying.clone();
        let factor = ProfileMatrix::of_rows(&compliance, n).cholesky(&set)?;
        factor.solve(&mut stretched);
        Ok(LineLoads {
            turn: solution.approach,
            tangent: carrying.iter().zip(&stretched).map(|(a, b)| a * b).sum(),
            forces,
            widths,
            active: solution.active.clone(),
            sweeps,
        })
    }

    fn problem(&self, compliance: Vec<f64>) -> Result<ContactProblem, Error> {
        let n = self.cells().count();
        ContactProblem::new(
            ProfileMatrix::of_rows(&compliance, n),
            self.cells().map(|c| c.arm).collect(),
            self.cells().map(|c| c.gap).collect(),
        )
    }

    /// Compliance of all lines, row by row: pairs of teeth do not press on each other.
    fn compliance(&self, widths: &[Vec<f64>]) -> Vec<f64> {
        let n = self.cells().count();
        let mut all = vec![0.0; n * n];
        let mut first = 0;
        for ((line, teeth), widths) in self.lines.iter().zip(&self.teeth).zip(widths) {
            let own = line.contact_compliance(widths, &self.materials);
            let count = line.cells.len();
            let rows = own
                .chunks_exact(count.max(1))
                .zip(teeth.chunks_exact(count.max(1)));
            for (i, (contact, teeth)) in rows.enumerate() {
                let from = (first + i) * n + first;
                let row = all[from..from + count].iter_mut();
                row.zip(contact.iter().zip(teeth))
                    .for_each(|(c, (a, b))| *c = a + b);
            }
            first += count;
        }
        all
    }

    /// Half widths under forces: a cell without one is as narrow as the narrowest of its line, a line without one as wide as the widest.
    fn widths(&self, forces: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let compliance = plane_strain_sum(&self.materials);
        let width = |(cell, force): (&ContactCell, &f64)| {
            let line_load = force.max(0.0) / cell.length;
            (4.0 / PI * line_load * compliance / cell.curvature).sqrt()
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

    /// Widths as if all cells carried alike.
    fn first_widths(&self, torque: f64) -> Vec<Vec<f64>> {
        let arms: f64 = self.cells().map(|c| c.arm).sum();
        let alike = |line: &ContactLine| vec![torque / arms; line.cells.len()];
        self.widths(&self.lines.iter().map(alike).collect::<Vec<_>>())
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

/// Geometric means of two sets of widths.
fn halfway(one: &[Vec<f64>], other: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mean = |(a, b): (&f64, &f64)| (a * b).sqrt();
    let lines = one.iter().zip(other);
    lines
        .map(|(a, b)| a.iter().zip(b).map(mean).collect())
        .collect()
}

/// A compliance that is not positive definite comes of a contact wider than its cells or as deep as its teeth.
fn too_wide(error: Error, torque: f64) -> Error {
    if error.code != Code::IllPosed {
        return error;
    }
    let message = format!(
        "the contact at {torque} N·m of the driven gear is too wide for its cells or its teeth"
    );
    Error::new(Code::OutOfRange, message).with_hint("give a smaller torque or fewer stations")
}
