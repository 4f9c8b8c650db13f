//! Settings for the next cut: those of the last one less the changes that explain its deviations, on the steps of the dials.

use super::correction::{CorrectionFit, CorrectionProblem, ROOT_WEIGHT, Unknown};
use super::dial::{Dial, DialSteps};
use super::measured_flank::MeasuredFlank;
use super::root_point::RootPoint;
use super::setting::FlankSetup;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::integer_least_squares::integer_least_squares;

/// Settings of the next cut and what it is expected to leave.
#[derive(Debug, Clone)]
pub struct NextCut {
    /// Settings of each flank, as the dials show them.
    pub setups: Vec<FlankSetup>,
    /// Expected deviations by flank and node, m: what no settings take away and what the steps of the dials leave.
    pub deviations: Vec<Vec<Option<f64>>>,
}

impl CorrectionProblem {
    /// The next cut after a fit, with the dials that are set for each flank: the machine that cut as if its settings differed by the
    /// changes found is set back by them.
    ///
    /// # Errors
    /// Settings at which no flank is cut; as `on_steps`.
    pub fn next_cut(
        &self,
        fit: &CorrectionFit,
        dials: &[Vec<Dial>],
        steps: &DialSteps,
        roots: &[Option<[RootPoint; 3]>],
    ) -> Result<NextCut, Error> {
        let changed = |setup: &FlankSetup, flank: usize, sign: f64| {
            let mut setup = *setup;
            for (unknown, change) in self.unknowns.iter().zip(&fit.changes) {
                if unknown.flanks.contains(&flank) {
                    setup = setup.changed(unknown.setting, sign * change);
                }
            }
            setup
        };
        let flanks = self.flanks.iter().enumerate();
        let wanted: Vec<FlankSetup> = flanks
            .map(|(f, flank)| changed(&flank.setup, f, -1.0))
            .collect();
        let setups = self.on_steps(fit, &wanted, dials, steps, roots)?;
        // The machine cuts the next flank with the same errors.
        let as_cut = |(f, flank): (usize, &MeasuredFlank)| MeasuredFlank {
            setup: changed(&setups[f], f, 1.0),
            deviations: vec![0.0; flank.nodes.len()],
            ..flank.clone()
        };
        let expected = CorrectionProblem {
            flanks: self.flanks.iter().enumerate().map(as_cut).collect(),
            unknowns: Vec::new(),
            least: self.least,
        };
        let left = expected.solve()?;
        let sum = |(rests, left): (&Vec<Option<f64>>, &Vec<Option<f64>>)| {
            let nodes = rests.iter().zip(left);
            nodes
                .map(|(rest, left)| Some((*rest)? - (*left)?))
                .collect()
        };
        Ok(NextCut {
            deviations: fit.rests.iter().zip(&left.rests).map(sum).collect(),
            setups,
        })
    }

    /// Wanted settings on the steps of the dials: of all steps those whose flanks and roots are nearest to the wanted ones, so that dials
    /// make up for each other's rounding.
    ///
    /// # Errors
    /// A radial distance that no eccentric angle gives.
    pub fn on_steps(
        &self,
        fit: &CorrectionFit,
        wanted: &[FlankSetup],
        dials: &[Vec<Dial>],
        steps: &DialSteps,
        roots: &[Option<[RootPoint; 3]>],
    ) -> Result<Vec<FlankSetup>, Error> {
        let all = self.dials_of_flanks(dials);
        // A step away from the wanted settings counts like a least displacement of one node.
        let stay = self.least;
        let (mut columns, mut offsets) = (Vec::new(), Vec::new());
        for (i, (dial, flanks)) in all.iter().enumerate() {
            let (from, setup) = (&self.flanks[flanks[0]].setup, &wanted[flanks[0]]);
            let (step, value) = (dial.step(steps), dial.value(setup));
            if !value.is_finite() {
                let message = "the radial distance of the settings found exceeds twice the machine constant: no eccentric angle gives it";
                return Err(Error::new(Code::OutOfRange, message).with_hint(
                    "check member, flank and sign of the deviations, or free fewer settings",
                ));
            }
            let next = dial.set(*setup, value + step);
            let changes: Vec<f64> = (self.unknowns.iter())
                .map(|unknown| match unknown.flanks == *flanks {
                    true => {
                        let of = |setup: &FlankSetup| setup.value(unknown.setting);
                        (of(&next) - of(setup)) / unknown.reach
                    }
                    false => 0.0,
                })
                .collect();
            let mut column = fit.fitted.displacements(&changes);
            for (f, roots) in roots.iter().enumerate() {
                let hand = self.flanks[f].hand;
                let deeper = |root: &RootPoint, setup: &FlankSetup| {
                    ROOT_WEIGHT * root.deeper_by(setup, hand).unwrap_or(0.0)
                };
                let moved = |root: &RootPoint| match flanks.contains(&f) {
                    true => deeper(root, &next) - deeper(root, setup),
                    false => 0.0,
                };
                // Those that the fit holds have rows of it.
                if self.flanks[f].roots.is_empty() {
                    column.extend(roots.iter().flatten().map(moved));
                }
            }
            column.extend((0..all.len()).map(|j| if i == j { stay } else { 0.0 }));
            columns.push(column);
            offsets.push((value - dial.value(from)) / step);
        }
        let rows = columns.first().map_or(0, Vec::len);
        let mut target = vec![0.0; rows];
        for (column, offset) in columns.iter().zip(&offsets) {
            (target.iter_mut().zip(column)).for_each(|(t, c)| *t += offset * c);
        }
        let counts = integer_least_squares(&columns, &target);
        let mut setups = wanted.to_vec();
        for ((dial, flanks), count) in all.iter().zip(counts) {
            let value = dial.value(&self.flanks[flanks[0]].setup) + count * dial.step(steps);
            for f in flanks {
                setups[*f] = dial.set(setups[*f], value);
            }
        }
        Ok(setups)
    }

    /// Every dial with the flanks that it moves, each once.
    fn dials_of_flanks(&self, dials: &[Vec<Dial>]) -> Vec<(Dial, Vec<usize>)> {
        let mut all: Vec<(Dial, Vec<usize>)> = Vec::new();
        for (f, dials) in dials.iter().enumerate() {
            for dial in dials {
                let shows =
                    |unknown: &&Unknown| unknown.flanks.contains(&f) && dial.shows(unknown.setting);
                let Some(unknown) = self.unknowns.iter().find(shows) else {
                    continue;
                };
                let one = (*dial, unknown.flanks.clone());
                if !all.contains(&one) {
                    all.push(one);
                }
            }
        }
        all
    }
}
