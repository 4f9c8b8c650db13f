//! Dynamic model with the maps between its coordinates and the degrees of freedom of the machine.

use super::combination::LinearCombination;
use super::condensation;
use super::dynamic_model::{DynamicModel, ForceLaw};
use super::prescribed::{self, PrescribedReduction};
use super::signal::Signal;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;

/// Dynamic model of a machine with the combinations that give the degrees of freedom from its coordinates.
pub struct AssembledModel {
    /// Equations of motion.
    pub model: DynamicModel,
    /// Combination of coordinates for every degree of freedom of the machine; `None` for a massless node with an internal state.
    pub dofs: Vec<Option<LinearCombination>>,
    /// Elements of the model for every branch of the machine: one, one per flank or per tooth pair; none if the branch is rigid or was
    /// condensed.
    pub branches: Vec<Vec<usize>>,
    /// Springs and dampers of the condensed branches and of those between prescribed motions.
    pub springs: Vec<Option<SpringDamper>>,
    /// Loads over time from the file, N·m or N, each with its degree of freedom; loads over an angle are elements.
    pub loads: Vec<(usize, Signal)>,
    /// Coordinate of the linear model for every coordinate of the dynamic model, ascending.
    pub retained: Vec<usize>,
    /// Rigid-body motions over the coordinates of the dynamic model.
    pub rigid: Vec<Vec<f64>>,
    /// Prescribed motions, eliminated from the equations.
    pub prescribed: Option<PrescribedReduction>,
}

/// Spring and damper in parallel, `F = k δ + c δ̇`.
#[derive(Debug, Clone)]
pub struct SpringDamper {
    /// Deflection δ, rad or m.
    pub deflection: LinearCombination,
    /// Stiffness k, N·m/rad or N/m.
    pub stiffness: f64,
    /// Damping c, N·m·s/rad or N·s/m.
    pub damping: f64,
}

/// Model over the retained coordinates.
struct ReducedCoordinates {
    model: DynamicModel,
    /// Indices of the retained coordinates in the full model.
    retained: Vec<usize>,
    /// New index of each element; `None` if it was condensed.
    branches: Vec<Option<usize>>,
    /// Each coordinate as a combination of the retained ones.
    recovery: Vec<Option<LinearCombination>>,
}

impl AssembledModel {
    /// Index in the dynamic model of a coordinate of the linear model; `None` if it was eliminated.
    pub fn coordinate_index(&self, coordinate: usize) -> Option<usize> {
        self.retained.binary_search(&coordinate).ok()
    }

    /// Contribution of the prescribed motions to every coordinate at time `t`, s: position and speed.
    pub fn prescribed_motion(&self, t: f64) -> Vec<(f64, f64)> {
        let n = self.model.coordinate_count();
        let Some(prescribed) = &self.prescribed else {
            return vec![(0.0, 0.0); n];
        };
        let state = prescribed.state(t, &vec![0.0; 2 * n]);
        let n_full = prescribed.full_model.coordinate_count();
        let pair = |&i: &usize| (state[i], state[n_full + i]);
        prescribed.retained.iter().map(pair).collect()
    }

    /// Model without the massless coordinates; `source_of` returns the place of a coordinate in the source file.
    ///
    /// # Errors
    /// Those of [`condensation::condense`].
    pub fn without_massless(
        self,
        massless: &[usize],
        source_of: &dyn Fn(usize) -> SourceSpan,
    ) -> Result<AssembledModel, Error> {
        if massless.is_empty() {
            return Ok(self);
        }
        let condensed = condensation::condense(self.model.clone(), massless, source_of)?;
        let motions = self.rigid.iter();
        let rigid = motions.map(|r| condensed.retained.iter().map(|&i| r[i]).collect());
        let rigid = rigid.collect();
        let reduced = ReducedCoordinates {
            model: condensed.model,
            retained: condensed.retained,
            branches: condensed.branches,
            recovery: condensed.recovery,
        };
        Ok(self.in_reduced(reduced, rigid, None))
    }

    /// Model without the coordinates of prescribed motion; each is a name, a coordinate of the linear model and the motion x(t).
    ///
    /// # Errors
    /// Those of [`prescribed::eliminate`].
    pub fn without_prescribed(
        self,
        motions: Vec<(String, usize, Signal)>,
    ) -> Result<AssembledModel, Error> {
        if motions.is_empty() {
            return Ok(self);
        }
        let motions = motions.into_iter().map(|(name, at, motion)| {
            let at = self.coordinate_index(at).unwrap_or_default();
            (name, at, motion)
        });
        let motions = motions.collect();
        let reduction = prescribed::eliminate(self.model.clone(), &self.rigid, motions)?;
        let reduced = ReducedCoordinates {
            model: reduction.model,
            retained: reduction.prescribed.retained.clone(),
            branches: reduction.prescribed.branches.clone(),
            recovery: reduction.prescribed.recovery(),
        };
        Ok(self.in_reduced(reduced, reduction.rigid, Some(reduction.prescribed)))
    }

    fn in_reduced(
        self,
        reduced: ReducedCoordinates,
        rigid: Vec<Vec<f64>>,
        prescribed: Option<PrescribedReduction>,
    ) -> AssembledModel {
        let express = |c: &Option<LinearCombination>| c.as_ref()?.substitute(&reduced.recovery);
        let spring = |(elements, spring): (&Vec<usize>, &Option<SpringDamper>)| {
            let (deflection, stiffness, damping) = match (spring, &elements[..]) {
                (Some(s), _) => (s.deflection.clone(), s.stiffness, s.damping),
                (None, &[element]) if reduced.branches[element].is_none() => {
                    let b = &self.model.elements[element];
                    let ForceLaw::Linear { stiffness, damping } = b.law else {
                        return None;
                    };
                    let deflection = LinearCombination {
                        terms: b.direction.entries().collect(),
                        imposed: b.imposed_displacement.as_ref().map(|e| e.scaled(-1.0)),
                    };
                    (deflection, stiffness, damping)
                }
                _ => return None,
            };
            Some(SpringDamper {
                deflection: deflection.substitute(&reduced.recovery)?,
                stiffness,
                damping,
            })
        };
        let springs = self.branches.iter().zip(&self.springs).map(spring);
        let branches = self.branches.iter().map(|elements| {
            let retained = elements.iter().filter_map(|&b| reduced.branches[b]);
            retained.collect()
        });
        AssembledModel {
            dofs: self.dofs.iter().map(express).collect(),
            branches: branches.collect(),
            springs: springs.collect(),
            loads: self.loads,
            retained: reduced.retained.iter().map(|&i| self.retained[i]).collect(),
            model: reduced.model,
            rigid,
            prescribed,
        }
    }
}
