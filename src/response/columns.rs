//! What inputs push and outputs read: columns b and rows c of `D(s) x = b(s) u`, `y = c(s) x + d(s) u`.

use std::collections::{BTreeMap, HashMap};

use super::coordinates::{Coordinates, Held};
use super::entries::{Entry, Sparse, Transform, gathered};
use super::factor::Factor;
use super::ports::{Input, Output};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::linear::LinearBranch;
use crate::machine::parts::{Law, Machine};
use crate::scene::model::Axis;

/// Columns or rows with their factors.
pub(super) type Terms = Vec<(Factor, usize)>;

/// Columns or rows, each once.
#[derive(Default)]
pub(super) struct List {
    pub all: Vec<Sparse>,
    /// Place of each, by its indices and the bits of its values.
    places: HashMap<Vec<(usize, u64)>, usize>,
}

impl List {
    /// Puts what an input or output consists of, those of one factor summed and those without an entry left out; their factors and
    /// places.
    pub fn put(&mut self, terms: impl Iterator<Item = (Factor, Sparse)>) -> Terms {
        let mut own: Vec<(Factor, Sparse)> = Vec::new();
        for (factor, vector) in terms {
            match own.iter_mut().find(|t| t.0 == factor) {
                Some((_, sum)) => *sum = gathered(sum.iter().copied().chain(vector)),
                None => own.push((factor, vector)),
            }
        }
        own.retain(|(_, vector)| !vector.is_empty());
        let mut place = |vector: Sparse| {
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

/// What an input does.
pub(super) struct Driven {
    /// Forces over all coordinates, prescribed ones too.
    pub force: Vec<(Factor, Sparse)>,
    /// h per unit of input.
    pub held: Vec<f64>,
    /// e per unit of input: number of a branch in the machine, and its displacement.
    imposed: Vec<(usize, f64)>,
}

/// What an output sees.
pub(super) struct Seen {
    /// Rows over all coordinates.
    pub rows: Vec<(Factor, Sparse)>,
    /// Of a branch: what its own imposed displacement takes off.
    own: Vec<(usize, Factor, f64)>,
    /// Of a joint: forces that act along its own motion count with this sign.
    along: Option<usize>,
}

/// From names to columns and rows.
pub(super) struct Builder<'a> {
    pub machine: &'a Machine,
    pub coordinates: &'a Coordinates,
    /// Of Rayleigh damping.
    pub beta: f64,
    pub transform: &'a Transform,
    /// Entries in rows and columns of what is prescribed.
    pub beside: &'a [Entry],
    /// Coordinates solved for; those of what is prescribed follow.
    pub n: usize,
}

impl Builder<'_> {
    fn held(&self, what: Held) -> usize {
        let held = &self.coordinates.held;
        held.iter().position(|h| *h == what).unwrap_or(held.len())
    }

    fn branch(&self, index: usize) -> Option<&LinearBranch> {
        self.coordinates.linear.branch(index)
    }

    /// `k + s (c + βk) + iηk`.
    fn law(&self, branch: &LinearBranch) -> [(Factor, f64); 3] {
        [
            (Factor::ONE, branch.stiffness),
            (Factor::S, branch.damping + self.beta * branch.stiffness),
            (Factor::LOSSY, branch.loss_factor * branch.stiffness),
        ]
    }

    fn sees(&self, freedom: usize) -> Sparse {
        let row = self.coordinates.linear.transform[freedom].iter();
        self.transform.sees(row.copied())
    }

    /// What an input does.
    ///
    /// # Errors
    /// A displacement imposed where nothing carries it; a base that nothing elastic joins.
    pub fn input(&self, input: Input) -> Result<Driven, Error> {
        let mut driven = Driven {
            force: Vec::new(),
            held: vec![0.0; self.coordinates.held.len()],
            imposed: Vec::new(),
        };
        match input {
            Input::Torque(freedom) => driven.force.push((Factor::ONE, self.sees(freedom))),
            Input::Motion(freedom) => driven.held[self.held(Held::Freedom(freedom))] = 1.0,
            Input::Displacement(branch) if self.machine.branches[branch].law == Law::Rigid => {
                driven.held[self.held(Held::Joint(branch))] = 1.0;
            }
            Input::Displacement(branch) => driven.imposed.push((branch, 1.0)),
            Input::Base(axis) => driven.imposed = self.base(axis)?,
        }
        for &(index, e) in &driven.imposed {
            let Some(branch) = self.branch(index) else {
                let name = self.machine.branch_name(index);
                let message = format!(
                    "a displacement imposed in `{name}` moves nothing: it is open at the operating point, or both its ends move as one"
                );
                return Err(Error::new(Code::Conflict, message)
                    .hint("state the torques in [[load]] that close it"));
            };
            let acts = self.transform.sees(branch.acts().scaled());
            for (factor, value) in self.law(branch) {
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
                .filter(|t| self.machine.freedoms[t.0].axis == axis);
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
            if branch.law == Law::Rigid {
                let message = format!(
                    "`{}` holds a body rigidly to the ground, which is to move along {}",
                    self.machine.branch_name(index),
                    axis.name()
                );
                return Err(Error::new(Code::Conflict, message).hint("give it a stiffness k"));
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
                .hint("a bearing, or a shaft to \"ground\", joins it"));
        }
        Ok(imposed)
    }

    /// `−D_rh h`.
    pub fn prescribed(&self, held: &[f64]) -> Vec<(Factor, Sparse)> {
        let moved = |e: &&Entry| e.row < self.n && e.column >= self.n;
        let mut sums: [BTreeMap<usize, f64>; 4] = Default::default();
        for entry in self.beside.iter().filter(moved) {
            let h = held[entry.column - self.n];
            for (sum, (_, value)) in sums.iter_mut().zip(entry.parts()) {
                if h * value != 0.0 {
                    *sum.entry(entry.row).or_default() -= value * h;
                }
            }
        }
        let factors = [Factor::ONE, Factor::S, Factor::SS, Factor::LOSSY];
        let columns = sums.map(gathered);
        factors.into_iter().zip(columns).collect()
    }

    /// What an output sees.
    pub fn output(&self, output: &Output) -> Seen {
        let mut seen = Seen {
            rows: Vec::new(),
            own: Vec::new(),
            along: None,
        };
        match output {
            Output::Sum(terms, times) => {
                let scaled = terms
                    .iter()
                    .map(|&(freedom, a)| scaled(a, &self.sees(freedom)));
                let row = gathered(scaled.flatten());
                let factor = Factor {
                    power: *times,
                    lossy: false,
                };
                seen.rows.push((factor, row));
            }
            &Output::Force(index) if self.machine.branches[index].law == Law::Rigid => {
                let at = self.n + self.held(Held::Joint(index));
                seen.along = Some(at);
                let own = self.beside.iter().filter(|e| e.row == at);
                let parts = own.flat_map(|e| e.parts().map(|(factor, a)| (factor, e.column, -a)));
                for (factor, column, a) in parts.filter(|part| part.2 != 0.0) {
                    seen.rows.push((factor, vec![(column, a)]));
                }
            }
            &Output::Force(index) => self.add(&mut seen, index, 1.0, true),
            Output::Forces(all) => {
                (all.iter()).for_each(|&(index, share)| self.add(&mut seen, index, share, true))
            }
            &Output::Deflection(index) => self.add(&mut seen, index, 1.0, false),
        }
        seen
    }

    /// Adds the force of a branch, or its deformation, times a factor.
    fn add(&self, seen: &mut Seen, index: usize, share: f64, force: bool) {
        let Some(branch) = self.branch(index) else {
            return; // Open, or between what moves as one.
        };
        let mut along = self.transform.sees(branch.direction.scaled());
        let still = self.still(branch);
        along.retain(|term| term.0 >= still);
        let law = match force {
            true => self.law(branch).to_vec(),
            false => vec![(Factor::ONE, 1.0)],
        };
        for (factor, value) in law {
            let value = share * value;
            seen.rows.push((factor, scaled(value, &along)));
            seen.own.push((index, factor, value));
        }
    }

    /// Coordinates that leave a branch exactly as it is.
    fn still(&self, branch: &LinearBranch) -> usize {
        let still = &self.coordinates.still;
        if branch.stiffness != 0.0 {
            still.rigid.len()
        } else {
            still.n_undamped_rigid
        }
    }

    /// d between an input and an output.
    pub fn through(&self, seen: &Seen, input: &Driven) -> Vec<(Factor, f64)> {
        let mut all: Vec<(Factor, f64)> = Vec::new();
        for (factor, row) in &seen.rows {
            let prescribed = row.iter().filter(|term| term.0 >= self.n);
            let moved = prescribed.map(|&(j, a)| a * input.held[j - self.n]).sum();
            all.push((*factor, moved));
        }
        for &(index, factor, value) in &seen.own {
            let e: f64 = input
                .imposed
                .iter()
                .filter(|i| i.0 == index)
                .map(|i| i.1)
                .sum();
            all.push((factor, -value * e));
        }
        if let Some(at) = seen.along {
            for (factor, force) in &input.force {
                let own = force.iter().filter(|term| term.0 == at);
                all.extend(own.map(|term| (*factor, term.1)));
            }
        }
        all.retain(|term| term.1 != 0.0);
        all
    }
}

fn scaled(value: f64, vector: &Sparse) -> Sparse {
    let all = vector.iter().map(|&(i, x)| (i, value * x));
    all.filter(|term| term.1 != 0.0).collect()
}
