//! Input columns b, output rows c and feedthrough d of `D(s) x = b u`, `y = c x + d u`.

use std::collections::{BTreeMap, HashMap};

use super::constrained::{ConstrainedCoordinates, PrescribedDof};
use super::dynamic_stiffness::{SparseTransform, SparseVector, StiffnessEntry, sum_duplicates};
use super::laplace_factor::LaplaceFactor;
use super::ports::{ResponseInput, ResponseOutput};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::linear::LinearBranch;
use crate::scene::model::Axis;

/// Laplace factors with column or row indices.
pub(super) type FactorTerms = Vec<(LaplaceFactor, usize)>;

/// Set of distinct columns or rows.
#[derive(Default)]
pub(super) struct VectorSet {
    pub all: Vec<SparseVector>,
    /// Index of each vector, by its indices and the bits of its values.
    indices: HashMap<Vec<(usize, u64)>, usize>,
}

impl VectorSet {
    /// Inserts the vectors of an input or output, summed by factor, without empty ones; returns their factors and
    /// indices.
    pub fn insert(
        &mut self,
        terms: impl Iterator<Item = (LaplaceFactor, SparseVector)>,
    ) -> FactorTerms {
        let mut sums: Vec<(LaplaceFactor, SparseVector)> = Vec::new();
        for (factor, vector) in terms {
            match sums.iter_mut().find(|t| t.0 == factor) {
                Some((_, sum)) => *sum = sum_duplicates(sum.iter().copied().chain(vector)),
                None => sums.push((factor, vector)),
            }
        }
        sums.retain(|(_, vector)| !vector.is_empty());
        let mut index = |vector: SparseVector| {
            let key = vector.iter().map(|&(i, x)| (i, x.to_bits())).collect();
            *self.indices.entry(key).or_insert_with(|| {
                self.all.push(vector);
                self.all.len() - 1
            })
        };
        sums.into_iter()
            .map(|(factor, vector)| (factor, index(vector)))
            .collect()
    }
}

/// Forces and imposed displacements of an input.
pub(super) struct InputVector {
    /// Forces over all coordinates, prescribed ones too.
    pub force: Vec<(LaplaceFactor, SparseVector)>,
    /// Prescribed displacements h per unit of input.
    pub prescribed: Vec<f64>,
    /// Imposed displacements e per unit of input: branch index, and displacement.
    imposed: Vec<(usize, f64)>,
}

/// Row vectors of an output over the coordinates.
pub(super) struct OutputVector {
    /// Rows over all coordinates.
    pub rows: Vec<(LaplaceFactor, SparseVector)>,
    /// Imposed displacements that the output subtracts: branch index, factor, coefficient.
    imposed_displacement: Vec<(usize, LaplaceFactor, f64)>,
    /// Joint coordinate of a joint-force output: forces along it contribute with positive sign.
    joint: Option<usize>,
}

/// Builder of input columns and output rows.
pub(super) struct PortBuilder<'a> {
    pub machine: &'a Machine,
    pub coordinates: &'a ConstrainedCoordinates,
    /// Rayleigh damping coefficient β.
    pub beta: f64,
    pub transform: &'a SparseTransform,
    /// Stiffness entries in rows and columns of prescribed coordinates.
    pub prescribed_entries: &'a [StiffnessEntry],
    /// Number of unknown coordinates; the prescribed ones follow.
    pub n: usize,
}

impl PortBuilder<'_> {
    fn prescribed_index(&self, dof: PrescribedDof) -> usize {
        let model = &self.coordinates.prescribed;
        model.iter().position(|h| *h == dof).unwrap_or(model.len())
    }

    fn branch(&self, index: usize) -> Option<&LinearBranch> {
        self.coordinates.model.branch(index)
    }

    /// Dynamic stiffness of a branch, `k + s (c + βk) + iηk`.
    fn dynamic_stiffness(&self, branch: &LinearBranch) -> [(LaplaceFactor, f64); 3] {
        [
            (LaplaceFactor::ONE, branch.stiffness),
            (
                LaplaceFactor::S,
                branch.damping + self.beta * branch.stiffness,
            ),
            (
                LaplaceFactor::HYSTERETIC,
                branch.loss_factor * branch.stiffness,
            ),
        ]
    }

    fn dof_row(&self, dof: usize) -> SparseVector {
        let row = self.coordinates.model.transform[dof].iter();
        self.transform.project(row.copied())
    }

    /// Column vector of an input.
    ///
    /// # Errors
    /// `Conflict` for a displacement imposed in an open branch, and for a base without elastic branches.
    pub fn input(&self, input: ResponseInput) -> Result<InputVector, Error> {
        let mut column = InputVector {
            force: Vec::new(),
            prescribed: vec![0.0; self.coordinates.prescribed.len()],
            imposed: Vec::new(),
        };
        match input {
            ResponseInput::Torque(dof) => {
                column.force.push((LaplaceFactor::ONE, self.dof_row(dof)))
            }
            ResponseInput::Motion(dof) => {
                column.prescribed[self.prescribed_index(PrescribedDof::Dof(dof))] = 1.0
            }
            ResponseInput::Displacement(branch)
                if self.machine.branches[branch].law == BranchLaw::Rigid =>
            {
                column.prescribed[self.prescribed_index(PrescribedDof::Joint(branch))] = 1.0;
            }
            ResponseInput::Displacement(branch) => column.imposed.push((branch, 1.0)),
            ResponseInput::Base(axis) => column.imposed = self.base(axis)?,
        }
        for &(index, e) in &column.imposed {
            let Some(branch) = self.branch(index) else {
                let name = self.machine.branch_name(index);
                let message = format!(
                    "a displacement imposed in `{name}` has no effect: it is open at the operating point, or both its ends move alike"
                );
                return Err(Error::new(Code::Conflict, message)
                    .with_hint("state the torques in [[load]] that close it"));
            };
            let direction = self.transform.project(branch.force_direction().entries());
            for (factor, value) in self.dynamic_stiffness(branch) {
                column.force.push((factor, scaled(value * e, &direction)));
            }
        }
        Ok(column)
    }

    /// Imposed displacements of the grounded branches per unit of base motion, subtracted from their δ.
    fn base(&self, axis: Axis) -> Result<Vec<(usize, f64)>, Error> {
        let mut imposed = Vec::new();
        for (index, branch) in self.machine.branches.iter().enumerate() {
            let terms = branch
                .direction
                .terms
                .iter()
                .filter(|t| self.machine.dofs[t.0].axis == axis);
            let sum: f64 = branch.direction.scale * terms.clone().map(|t| t.1).sum::<f64>();
            let size: f64 =
                branch.direction.scale.abs() * terms.clone().map(|t| t.1.abs()).sum::<f64>();
            // The terms of two bodies cancel to rounding.
            let is_grounded = sum.abs() > 1e-12 * size;
            let is_angular = axis == Axis::Theta
                && (branch.direction.terms.len() != 1 || branch.direction.scale != 1.0);
            if !is_grounded || is_angular {
                continue;
            }
            if branch.law == BranchLaw::Rigid {
                let message = format!(
                    "`{}` connects a body rigidly to the ground, whose motion along {} is the input",
                    self.machine.branch_name(index),
                    axis.name()
                );
                return Err(Error::new(Code::Conflict, message).with_hint("give it a stiffness k"));
            }
            if self.branch(index).is_some() {
                imposed.push((index, sum));
            }
        }
        if imposed.is_empty() {
            let message = format!(
                "no element of this machine is connected to the ground along {}",
                axis.name()
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("connect it by a bearing or a shaft to \"ground\""));
        }
        Ok(imposed)
    }

    /// Forces of the prescribed displacements, `−D_rh h`.
    pub fn prescribed(&self, displacements: &[f64]) -> Vec<(LaplaceFactor, SparseVector)> {
        let is_coupling = |e: &&StiffnessEntry| e.row < self.n && e.column >= self.n;
        let mut sums: [BTreeMap<usize, f64>; 4] = Default::default();
        for entry in self.prescribed_entries.iter().filter(is_coupling) {
            let h = displacements[entry.column - self.n];
            for (sum, (_, value)) in sums.iter_mut().zip(entry.factors()) {
                if h * value != 0.0 {
                    *sum.entry(entry.row).or_default() -= value * h;
                }
            }
        }
        let factors = [
            LaplaceFactor::ONE,
            LaplaceFactor::S,
            LaplaceFactor::S_SQUARED,
            LaplaceFactor::HYSTERETIC,
        ];
        let columns = sums.map(sum_duplicates);
        factors.into_iter().zip(columns).collect()
    }

    /// Row vector of an output.
    pub fn output(&self, output: &ResponseOutput) -> OutputVector {
        let mut vector = OutputVector {
            rows: Vec::new(),
            imposed_displacement: Vec::new(),
            joint: None,
        };
        match output {
            ResponseOutput::Sum(terms, order) => {
                let scaled = terms.iter().map(|&(dof, a)| scaled(a, &self.dof_row(dof)));
                let row = sum_duplicates(scaled.flatten());
                let factor = LaplaceFactor {
                    power: *order,
                    hysteretic: false,
                };
                vector.rows.push((factor, row));
            }
            &ResponseOutput::Force(index)
                if self.machine.branches[index].law == BranchLaw::Rigid =>
            {
                let joint = self.n + self.prescribed_index(PrescribedDof::Joint(index));
                vector.joint = Some(joint);
                let row = self.prescribed_entries.iter().filter(|e| e.row == joint);
                let terms = row.flat_map(|e| e.factors().map(|(factor, a)| (factor, e.column, -a)));
                for (factor, column, a) in terms.filter(|term| term.2 != 0.0) {
                    vector.rows.push((factor, vec![(column, a)]));
                }
            }
            &ResponseOutput::Force(index) => self.add(&mut vector, index, 1.0, true),
            ResponseOutput::Forces(all) => {
                (all.iter()).for_each(|&(index, share)| self.add(&mut vector, index, share, true))
            }
            &ResponseOutput::Deflection(index) => self.add(&mut vector, index, 1.0, false),
        }
        vector
    }

    /// Adds the force or the deformation of a branch, times a factor.
    fn add(&self, rows: &mut OutputVector, index: usize, share: f64, force: bool) {
        let Some(branch) = self.branch(index) else {
            return; // Open, or without relative motion.
        };
        let mut row = self.transform.project(branch.direction.entries());
        let n_neutral = self.neutral_count(branch);
        row.retain(|term| term.0 >= n_neutral);
        let factors = match force {
            true => self.dynamic_stiffness(branch).to_vec(),
            false => vec![(LaplaceFactor::ONE, 1.0)],
        };
        for (factor, value) in factors {
            let value = share * value;
            rows.rows.push((factor, scaled(value, &row)));
            rows.imposed_displacement.push((index, factor, value));
        }
    }

    /// Number of coordinates without effect on a branch.
    fn neutral_count(&self, branch: &LinearBranch) -> usize {
        let fixed = &self.coordinates.fixed;
        if branch.stiffness != 0.0 {
            fixed.rigid.len()
        } else {
            fixed.n_undamped_rigid
        }
    }

    /// Feedthrough d from an input to an output.
    pub fn feedthrough(
        &self,
        rows: &OutputVector,
        input: &InputVector,
    ) -> Vec<(LaplaceFactor, f64)> {
        let mut terms: Vec<(LaplaceFactor, f64)> = Vec::new();
        for (factor, row) in &rows.rows {
            let prescribed = row.iter().filter(|term| term.0 >= self.n);
            let moved = prescribed
                .map(|&(j, a)| a * input.prescribed[j - self.n])
                .sum();
            terms.push((*factor, moved));
        }
        for &(index, factor, value) in &rows.imposed_displacement {
            let e: f64 = input
                .imposed
                .iter()
                .filter(|i| i.0 == index)
                .map(|i| i.1)
                .sum();
            terms.push((factor, -value * e));
        }
        if let Some(joint) = rows.joint {
            for (factor, force) in &input.force {
                let along = force.iter().filter(|term| term.0 == joint);
                terms.extend(along.map(|term| (*factor, term.1)));
            }
        }
        terms.retain(|term| term.1 != 0.0);
        terms
    }
}

fn scaled(value: f64, vector: &SparseVector) -> SparseVector {
    let products = vector.iter().map(|&(i, x)| (i, value * x));
    products.filter(|term| term.1 != 0.0).collect()
}
