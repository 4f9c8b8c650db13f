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

/// Columns or rows with their factors.
pub(super) type FactorTerms = Vec<(LaplaceFactor, usize)>;

/// Columns or rows, each once.
#[derive(Default)]
pub(super) struct VectorSet {
    pub all: Vec<SparseVector>,
    /// Place of each, by its indices and the bits of its values.
    places: HashMap<Vec<(usize, u64)>, usize>,
}

impl VectorSet {
    /// Puts what an input or output consists of, those of one factor summed and those without an entry left out; their factors and
    /// places.
    pub fn insert(
        &mut self,
        terms: impl Iterator<Item = (LaplaceFactor, SparseVector)>,
    ) -> FactorTerms {
        let mut own: Vec<(LaplaceFactor, SparseVector)> = Vec::new();
        for (factor, vector) in terms {
            match own.iter_mut().find(|t| t.0 == factor) {
                Some((_, sum)) => *sum = sum_duplicates(sum.iter().copied().chain(vector)),
                None => own.push((factor, vector)),
            }
        }
        own.retain(|(_, vector)| !vector.is_empty());
        let mut place = |vector: SparseVector| {
            let key = vector.iter().map(|&(i, x)| (i, x.to_bits())).collect();
            *self.places.entry(key).or_insert_with(|| {
                self.all.push(vector);
                self.all.len() - 1
            })
        };
        own.into_iter()
            .map(|(factor, vector)| (factor, place(vector)))
            .collect()
    }
}

/// Forces and imposed displacements of an input.
pub(super) struct InputVector {
    /// Forces over all coordinates, prescribed ones too.
    pub force: Vec<(LaplaceFactor, SparseVector)>,
    /// h per unit of input.
    pub prescribed: Vec<f64>,
    /// e per unit of input: number of a branch in the machine, and its displacement.
    imposed: Vec<(usize, f64)>,
}

/// Rows that give an output from the coordinates.
pub(super) struct OutputVector {
    /// Rows over all coordinates.
    pub rows: Vec<(LaplaceFactor, SparseVector)>,
    /// Own imposed displacement of a branch, which its output subtracts.
    own_displacement: Vec<(usize, LaplaceFactor, f64)>,
    /// Joint output: forces that act along its own motion count with this sign.
    along: Option<usize>,
}

/// From names to columns and rows.
pub(super) struct PortBuilder<'a> {
    pub machine: &'a Machine,
    pub coordinates: &'a ConstrainedCoordinates,
    /// Rayleigh damping coefficient β.
    pub beta: f64,
    pub transform: &'a SparseTransform,
    /// Entries in rows and columns of what is prescribed.
    pub prescribed_entries: &'a [StiffnessEntry],
    /// Coordinates solved for; those of what is prescribed follow.
    pub n: usize,
}

impl PortBuilder<'_> {
    fn prescribed_index(&self, what: PrescribedDof) -> usize {
        let model = &self.coordinates.prescribed;
        model.iter().position(|h| *h == what).unwrap_or(model.len())
    }

    fn branch(&self, index: usize) -> Option<&LinearBranch> {
        self.coordinates.model.branch(index)
    }

    /// `k + s (c + βk) + iηk`.
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
    /// A displacement imposed where nothing carries it; a base that nothing elastic joins.
    pub fn input(&self, input: ResponseInput) -> Result<InputVector, Error> {
        let mut driven = InputVector {
            force: Vec::new(),
            prescribed: vec![0.0; self.coordinates.prescribed.len()],
            imposed: Vec::new(),
        };
        match input {
            ResponseInput::Torque(dof) => {
                driven.force.push((LaplaceFactor::ONE, self.dof_row(dof)))
            }
            ResponseInput::Motion(dof) => {
                driven.prescribed[self.prescribed_index(PrescribedDof::Dof(dof))] = 1.0
            }
            ResponseInput::Displacement(branch)
                if self.machine.branches[branch].law == BranchLaw::Rigid =>
            {
                driven.prescribed[self.prescribed_index(PrescribedDof::Joint(branch))] = 1.0;
            }
            ResponseInput::Displacement(branch) => driven.imposed.push((branch, 1.0)),
            ResponseInput::Base(axis) => driven.imposed = self.base(axis)?,
        }
        for &(index, e) in &driven.imposed {
            let Some(branch) = self.branch(index) else {
                let name = self.machine.branch_name(index);
                let message = format!(
                    "a displacement imposed in `{name}` moves nothing: it is open at the operating point, or both its ends move as one"
                );
                return Err(Error::new(Code::Conflict, message)
                    .with_hint("state the torques in [[load]] that close it"));
            };
            let acts = self.transform.project(branch.force_direction().entries());
            for (factor, value) in self.dynamic_stiffness(branch) {
                driven.force.push((factor, scaled(value * e, &acts)));
            }
        }
        Ok(driven)
    }

    /// Displacements of the branches that end at the ground, per unit of its motion: what its motion takes from their δ.
    fn base(&self, axis: Axis) -> Result<Vec<(usize, f64)>, Error> {
        let mut imposed = Vec::new();
        for (index, branch) in self.machine.branches.iter().enumerate() {
            let along = branch
                .direction
                .terms
                .iter()
                .filter(|t| self.machine.dofs[t.0].axis == axis);
            let sum: f64 = branch.direction.scale * along.clone().map(|t| t.1).sum::<f64>();
            let size: f64 =
                branch.direction.scale.abs() * along.clone().map(|t| t.1.abs()).sum::<f64>();
            // Of its terms: what a body's motion takes and another's gives back cancels to rounding.
            let grounded = sum.abs() > 1e-12 * size;
            let turning = axis == Axis::Theta
                && (branch.direction.terms.len() != 1 || branch.direction.scale != 1.0);
            if !grounded || turning {
                continue;
            }
            if branch.law == BranchLaw::Rigid {
                let message = format!(
                    "`{}` holds a body rigidly to the ground, which is to move along {}",
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
                "nothing of this machine is joined to the ground along {}",
                axis.name()
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("a bearing, or a shaft to \"ground\", joins it"));
        }
        Ok(imposed)
    }

    /// `−D_rh h`.
    pub fn prescribed(&self, held: &[f64]) -> Vec<(LaplaceFactor, SparseVector)> {
        let moved = |e: &&StiffnessEntry| e.row < self.n && e.column >= self.n;
        let mut sums: [BTreeMap<usize, f64>; 4] = Default::default();
        for entry in self.prescribed_entries.iter().filter(moved) {
            let h = held[entry.column - self.n];
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
        let mut seen = OutputVector {
            rows: Vec::new(),
            own_displacement: Vec::new(),
            along: None,
        };
        match output {
            ResponseOutput::Sum(terms, times) => {
                let scaled = terms.iter().map(|&(dof, a)| scaled(a, &self.dof_row(dof)));
                let row = sum_duplicates(scaled.flatten());
                let factor = LaplaceFactor {
                    power: *times,
                    hysteretic: false,
                };
                seen.rows.push((factor, row));
            }
            &ResponseOutput::Force(index)
                if self.machine.branches[index].law == BranchLaw::Rigid =>
            {
                let at = self.n + self.prescribed_index(PrescribedDof::Joint(index));
                seen.along = Some(at);
                let own = self.prescribed_entries.iter().filter(|e| e.row == at);
                let parts = own.flat_map(|e| e.factors().map(|(factor, a)| (factor, e.column, -a)));
                for (factor, column, a) in parts.filter(|part| part.2 != 0.0) {
                    seen.rows.push((factor, vec![(column, a)]));
                }
            }
            &ResponseOutput::Force(index) => self.add(&mut seen, index, 1.0, true),
            ResponseOutput::Forces(all) => {
                (all.iter()).for_each(|&(index, share)| self.add(&mut seen, index, share, true))
            }
            &ResponseOutput::Deflection(index) => self.add(&mut seen, index, 1.0, false),
        }
        seen
    }

    /// Adds the force of a branch, or its deformation, times a factor.
    fn add(&self, rows: &mut OutputVector, index: usize, share: f64, force: bool) {
        let Some(branch) = self.branch(index) else {
            return; // Open, or between what moves as one.
        };
        let mut along = self.transform.project(branch.direction.entries());
        let still = self.neutral_count(branch);
        along.retain(|term| term.0 >= still);
        let law = match force {
            true => self.dynamic_stiffness(branch).to_vec(),
            false => vec![(LaplaceFactor::ONE, 1.0)],
        };
        for (factor, value) in law {
            let value = share * value;
            rows.rows.push((factor, scaled(value, &along)));
            rows.own_displacement.push((index, factor, value));
        }
    }

    /// Coordinates that leave a branch exactly as it is.
    fn neutral_count(&self, branch: &LinearBranch) -> usize {
        let still = &self.coordinates.fixed;
        if branch.stiffness != 0.0 {
            still.rigid.len()
        } else {
            still.n_undamped_rigid
        }
    }

    /// d between an input and an output.
    pub fn feedthrough(
        &self,
        rows: &OutputVector,
        input: &InputVector,
    ) -> Vec<(LaplaceFactor, f64)> {
        let mut all: Vec<(LaplaceFactor, f64)> = Vec::new();
        for (factor, row) in &rows.rows {
            let prescribed = row.iter().filter(|term| term.0 >= self.n);
            let moved = prescribed
                .map(|&(j, a)| a * input.prescribed[j - self.n])
                .sum();
            all.push((*factor, moved));
        }
        for &(index, factor, value) in &rows.own_displacement {
            let e: f64 = input
                .imposed
                .iter()
                .filter(|i| i.0 == index)
                .map(|i| i.1)
                .sum();
            all.push((factor, -value * e));
        }
        if let Some(at) = rows.along {
            for (factor, force) in &input.force {
                let own = force.iter().filter(|term| term.0 == at);
                all.extend(own.map(|term| (*factor, term.1)));
            }
        }
        all.retain(|term| term.1 != 0.0);
        all
    }
}

fn scaled(value: f64, vector: &SparseVector) -> SparseVector {
    let all = vector.iter().map(|&(i, x)| (i, value * x));
    all.filter(|term| term.1 != 0.0).collect()
}
