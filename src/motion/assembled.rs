//! Dynamic model with the maps from its coordinates to the dofs of the machine.

use super::combination::LinearCombination;
use super::condensation;
use super::dynamic_model::{DynamicModel, ForceLaw};
use super::prescribed::{self, PrescribedReduction};
use super::signal::Signal;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;

/// A machine in motion, and how its degrees of freedom follow from its coordinates.
pub struct AssembledModel {
    /// The equations.
    pub model: DynamicModel,
    /// Combination of coordinates for every degree of freedom of the machine; `None` where a massless node has an inner state.
    pub dofs: Vec<Option<LinearCombination>>,
    /// The branches of the machine's each branch, in the train: one, or one a flank; none where it is rigid or became part of
    /// others.
    pub branches: Vec<Vec<usize>>,
    /// Branches of the machine that became part of others or join known motions alone.
    pub springs: Vec<Option<SpringDamper>>,
    /// Loads over time as the file has them, each with its degree of freedom, N·m or N; those that follow an angle are branches.
    pub loads: Vec<(usize, Signal)>,
    /// The coordinates of the linear machine that the train's are.
    pub retained: Vec<usize>,
    /// Motions that strain nothing, over the train's coordinates.
    pub rigid: Vec<Vec<f64>>,
    /// Prescribed motions, taken out of the equations.
    pub prescribed: Option<PrescribedReduction>,
}

/// A spring and a damper side by side.
#[derive(Debug, Clone)]
pub struct SpringDamper {
    /// δ.
    pub deflection: LinearCombination,
    /// k.
    pub stiffness: f64,
    /// c.
    pub damping: f64,
}

/// A machine in fewer coordinates.
struct ReducedCoordinates {
    model: DynamicModel,
    /// The independent coordinates.
    retained: Vec<usize>,
    /// Each branch's number among those that stay.
    branches: Vec<Option<usize>>,
    /// Each coordinate in those that stay.
    places: Vec<Option<LinearCombination>>,
}

impl AssembledModel {
    /// The coordinate of the train that a coordinate of the linear machine is; none where it was taken out.
    pub fn coordinate_index(&self, coordinate: usize) -> Option<usize> {
        self.retained.binary_search(&coordinate).ok()
    }

    /// Contribution of the prescribed motions to every coordinate of the model at `t`: place, speed.
    pub fn prescribed_motion(&self, t: f64) -> Vec<(f64, f64)> {
        let n = self.model.coordinate_count();
        let Some(known) = &self.prescribed else {
            return vec![(0.0, 0.0); n];
        };
        let all = known.state(t, &vec![0.0; 2 * n]);
        let whole = known.whole.coordinate_count();
        let pair = |&i: &usize| (all[i], all[whole + i]);
        known.retained.iter().map(pair).collect()
    }

    /// Without the coordinates that have no inertia; `where_is` tells where one is written.
    ///
    /// # Errors
    /// Those of [`massless::condense`].
    pub fn without_massless(
        self,
        light: &[usize],
        where_is: &dyn Fn(usize) -> SourceSpan,
    ) -> Result<AssembledModel, Error> {
        if light.is_empty() {
            return Ok(self);
        }
        let found = condensation::condense(self.model.clone(), light, where_is)?;
        let motions = self.rigid.iter();
        let rigid = motions.map(|r| found.retained.iter().map(|&i| r[i]).collect());
        let rigid = rigid.collect();
        let fewer = ReducedCoordinates {
            model: found.model,
            retained: found.retained,
            branches: found.branches,
            places: found.recovery,
        };
        Ok(self.in_reduced(fewer, rigid, None))
    }

    /// Without coordinates whose motion is known: the name of what prescribes each, its coordinate of the linear machine, x.
    ///
    /// # Errors
    /// Those of [`prescribed::eliminate`].
    pub fn without_prescribed(
        self,
        known: Vec<(String, usize, Signal)>,
    ) -> Result<AssembledModel, Error> {
        if known.is_empty() {
            return Ok(self);
        }
        let known = known.into_iter().map(|(name, at, course)| {
            let at = self.coordinate_index(at).unwrap_or_default();
            (name, at, course)
        });
        let known = known.collect();
        let rest = prescribed::eliminate(self.model.clone(), &self.rigid, known)?;
        let fewer = ReducedCoordinates {
            model: rest.model,
            retained: rest.prescribed.retained.clone(),
            branches: rest.prescribed.branches.clone(),
            places: rest.prescribed.recovery(),
        };
        Ok(self.in_reduced(fewer, rest.rigid, Some(rest.prescribed)))
    }

    fn in_reduced(
        self,
        fewer: ReducedCoordinates,
        rigid: Vec<Vec<f64>>,
        prescribed: Option<PrescribedReduction>,
    ) -> AssembledModel {
        let over = |whole: &Option<LinearCombination>| whole.as_ref()?.substitute(&fewer.places);
        let spring = |(of, spring): (&Vec<usize>, &Option<SpringDamper>)| {
            let (deflection, stiffness, damping) = match (spring, &of[..]) {
                (Some(known), _) => (known.deflection.clone(), known.stiffness, known.damping),
                (None, &[at]) if fewer.branches[at].is_none() => {
                    let b = &self.model.elements[at];
                    let ForceLaw::Linear { stiffness, damping } = b.law else {
                        return None;
                    };
                    let own = LinearCombination {
                        terms: b.direction.entries().collect(),
                        imposed: b.imposed_displacement.as_ref().map(|e| e.scaled(-1.0)),
                    };
                    (own, stiffness, damping)
                }
                _ => return None,
            };
            Some(SpringDamper {
                deflection: deflection.substitute(&fewer.places)?,
                stiffness,
                damping,
            })
        };
        let springs = self.branches.iter().zip(&self.springs).map(spring);
        let branches = self.branches.iter().map(|of| {
            let stay = of.iter().filter_map(|&b| fewer.branches[b]);
            stay.collect()
        });
        AssembledModel {
            dofs: self.dofs.iter().map(over).collect(),
            branches: branches.collect(),
            springs: springs.collect(),
            loads: self.loads,
            retained: fewer.retained.iter().map(|&i| self.retained[i]).collect(),
            model: fewer.model,
            rigid,
            prescribed,
        }
    }
}
