//! A machine in motion with the way back to the freedoms and branches it was made from.

use super::combination::Combination;
use super::massless;
use super::prescribed::{self, Prescribed};
use super::signal::Signal;
use super::train::{Law, Train};
use crate::base::error::Error;
use crate::base::place::Place;

/// A machine in motion, and how its freedoms follow from its coordinates.
pub struct Moving {
    /// The equations.
    pub train: Train,
    /// Of every freedom of the machine; none where a massless node remembers.
    pub freedoms: Vec<Option<Combination>>,
    /// The branches of the machine's each branch, in the train: one, or one a flank; none where it is rigid or became part of
    /// others.
    pub branches: Vec<Vec<usize>>,
    /// Branches of the machine that became part of others or join known motions alone.
    pub springs: Vec<Option<Spring>>,
    /// Loads over time as the file has them, each with its freedom, N·m or N; those that follow an angle are branches.
    pub loads: Vec<(usize, Signal)>,
    /// The coordinates of the linear machine that the train's are.
    pub kept: Vec<usize>,
    /// Motions that strain nothing, over the train's coordinates.
    pub rigid: Vec<Vec<f64>>,
    /// What moves as prescribed, taken out of the equations.
    pub prescribed: Option<Prescribed>,
}

/// A spring and a damper side by side.
#[derive(Debug, Clone)]
pub struct Spring {
    /// δ.
    pub deflection: Combination,
    /// k.
    pub stiffness: f64,
    /// c.
    pub damping: f64,
}

/// A machine in fewer coordinates.
struct Fewer {
    train: Train,
    /// The coordinates that stay.
    kept: Vec<usize>,
    /// Each branch's number among those that stay.
    branches: Vec<Option<usize>>,
    /// Each coordinate in those that stay.
    places: Vec<Option<Combination>>,
}

impl Moving {
    /// The coordinate of the train that a coordinate of the linear machine is; none where it was taken out.
    pub fn place(&self, coordinate: usize) -> Option<usize> {
        self.kept.binary_search(&coordinate).ok()
    }

    /// What prescribed motions add to every coordinate of the train at `t`: place, speed.
    pub fn carried(&self, t: f64) -> Vec<(f64, f64)> {
        let n = self.train.n();
        let Some(known) = &self.prescribed else {
            return vec![(0.0, 0.0); n];
        };
        let all = known.state(t, &vec![0.0; 2 * n]);
        let whole = known.whole.n();
        let pair = |&i: &usize| (all[i], all[whole + i]);
        known.kept.iter().map(pair).collect()
    }

    /// Without the coordinates that have no inertia; `where_is` tells where one is written.
    ///
    /// # Errors
    /// Those of [`massless::condense`].
    pub fn without_massless(
        self,
        light: &[usize],
        where_is: &dyn Fn(usize) -> Place,
    ) -> Result<Moving, Error> {
        if light.is_empty() {
            return Ok(self);
        }
        let found = massless::condense(self.train.clone(), light, where_is)?;
        let motions = self.rigid.iter();
        let rigid = motions.map(|r| found.kept.iter().map(|&i| r[i]).collect());
        let rigid = rigid.collect();
        let fewer = Fewer {
            train: found.train,
            kept: found.kept,
            branches: found.branches,
            places: found.places,
        };
        Ok(self.in_fewer(fewer, rigid, None))
    }

    /// Without coordinates whose motion is known: the name of what prescribes each, its coordinate of the linear machine, x.
    ///
    /// # Errors
    /// Those of [`prescribed::take_out`].
    pub fn without_prescribed(self, known: Vec<(String, usize, Signal)>) -> Result<Moving, Error> {
        if known.is_empty() {
            return Ok(self);
        }
        let known = known.into_iter().map(|(name, at, course)| {
            let at = self.place(at).unwrap_or_default();
            (name, at, course)
        });
        let known = known.collect();
        let rest = prescribed::take_out(self.train.clone(), &self.rigid, known)?;
        let fewer = Fewer {
            train: rest.train,
            kept: rest.prescribed.kept.clone(),
            branches: rest.prescribed.branches.clone(),
            places: rest.prescribed.places(),
        };
        Ok(self.in_fewer(fewer, rest.rigid, Some(rest.prescribed)))
    }

    fn in_fewer(
        self,
        fewer: Fewer,
        rigid: Vec<Vec<f64>>,
        prescribed: Option<Prescribed>,
    ) -> Moving {
        let over = |whole: &Option<Combination>| whole.as_ref()?.over(&fewer.places);
        let spring = |(of, spring): (&Vec<usize>, &Option<Spring>)| {
            let (deflection, stiffness, damping) = match (spring, &of[..]) {
                (Some(known), _) => (known.deflection.clone(), known.stiffness, known.damping),
                (None, &[at]) if fewer.branches[at].is_none() => {
                    let b = &self.train.branches[at];
                    let Law::Linear { stiffness, damping } = b.law else {
                        return None;
                    };
                    let own = Combination {
                        terms: b.direction.scaled().collect(),
                        imposed: b.imposed.as_ref().map(|e| e.times(-1.0)),
                    };
                    (own, stiffness, damping)
                }
                _ => return None,
            };
            Some(Spring {
                deflection: deflection.over(&fewer.places)?,
                stiffness,
                damping,
            })
        };
        let springs = self.branches.iter().zip(&self.springs).map(spring);
        let branches = self.branches.iter().map(|of| {
            let stay = of.iter().filter_map(|&b| fewer.branches[b]);
            stay.collect()
        });
        Moving {
            freedoms: self.freedoms.iter().map(over).collect(),
            branches: branches.collect(),
            springs: springs.collect(),
            loads: self.loads,
            kept: fewer.kept.iter().map(|&i| self.kept[i]).collect(),
            train: fewer.train,
            rigid,
            prescribed,
        }
    }
}
