//! Settings of the next cut: those of the last cut minus the changes fitted to its deviations, rounded to the dial steps.

use super::correction::{CorrectionFit, CorrectionProblem, ROOT_WEIGHT, Unknown};
use super::dial::{Dial, DialSteps};
use super::measured_flank::MeasuredFlank;
use super::root_point::RootPoint;
use super::setting::FlankSetup;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::integer_least_squares::integer_least_squares;

/// Settings of the next cut and its expected deviations.
#[derive(Debug, Clone)]
pub struct NextCut {
    /// Settings of each flank, rounded to the dial steps.
    pub setups: Vec<FlankSetup>,
    /// Expected deviations by flank and node, m: residuals of the fit plus the effect of the dial steps.
    pub deviations: Vec<Vec<Option<f64>>>,
}

impl CorrectionProblem {
    /// Next cut after a fit, with the dials of each flank: the machine cut as if its settings differed by the fitted changes, which are
    /// therefore subtracted.
    ///
    /// # Errors
    /// Settings that cut no flank; errors of [`CorrectionProblem::rounded_settings`].
    pub fn next_cut(
        &self,
        fit: &CorrectionFit,
        dials: &[Vec<Dial>],
        steps: &DialSteps,
        roots: &[Option<[RootPoint; 3]>],
    ) -> Result<NextCut, Error> {
        let shifted = |setup: &FlankSetup, flank: usize, sign: f64| {
            let mut setup = *setup;
            for (unknown, change) in self.unknowns.iter().zip(&fit.changes) {
                if unknown.flanks.contains(&flank) {
                    setup = setup.changed(unknown.setting, sign * change);
                }
            }
            setup
        };
        let flanks = self.flanks.iter().enumerate();
        let exact: Vec<FlankSetup> = flanks
            .map(|(f, flank)| shifted(&flank.setup, f, -1.0))
            .collect();
        let setups = self.rounded_settings(fit, &exact, dials, steps, roots)?;
        // The machine errors are the same for the next cut.
        let as_cut = |(f, flank): (usize, &MeasuredFlank)| MeasuredFlank {
            setup: shifted(&setups[f], f, 1.0),
            deviations: vec![0.0; flank.nodes.len()],
            ..flank.clone()
        };
        let expected = CorrectionProblem {
            flanks: self.flanks.iter().enumerate().map(as_cut).collect(),
            unknowns: Vec::new(),
            least: self.least,
        };
        let after_cut = expected.solve()?;
        let sum = |(residuals, after_cut): (&Vec<Option<f64>>, &Vec<Option<f64>>)| {
            let nodes = residuals.iter().zip(after_cut);
            nodes
                .map(|(residual, after_cut)| Some((*residual)? - (*after_cut)?))
                .collect()
        };
        Ok(NextCut {
            deviations: fit
                .residuals
                .iter()
                .zip(&after_cut.residuals)
                .map(sum)
                .collect(),
            setups,
        })
    }

    /// Rounds settings to the dial steps such that flanks and roots deviate least from those of the exact settings; the roundings of the
    /// dials compensate each other.
    ///
    /// # Errors
    /// A radial distance without an eccentric angle.
    pub fn rounded_settings(
        &self,
        fit: &CorrectionFit,
        exact: &[FlankSetup],
        dials: &[Vec<Dial>],
        steps: &DialSteps,
        roots: &[Option<[RootPoint; 3]>],
    ) -> Result<Vec<FlankSetup>, Error> {
        let all_dials = self.dials_of_flanks(dials);
        // A deviation of one step has the weight of the smallest displacement of one node.
        let step_weight = self.least;
        let (mut columns, mut offsets) = (Vec::new(), Vec::new());
        for (i, (dial, flanks)) in all_dials.iter().enumerate() {
            let (last, setup) = (&self.flanks[flanks[0]].setup, &exact[flanks[0]]);
            let (step, value) = (dial.step(steps), dial.value(setup));
            if !value.is_finite() {
                let message = "the computed radial distance exceeds twice the machine constant: no eccentric angle gives it";
                return Err(Error::new(Code::OutOfRange, message).with_hint(
                    "check member, flank and sign of the deviations, or free fewer settings",
                ));
            }
            let next = dial.set(*setup, value + step);
            let changes: Vec<f64> = (self.unknowns.iter())
                .map(|unknown| match unknown.flanks == *flanks {
                    true => {
                        let value = |setup: &FlankSetup| setup.value(unknown.setting);
                        (value(&next) - value(setup)) / unknown.reach
                    }
                    false => 0.0,
                })
                .collect();
            let mut column = fit.fitted.displacements(&changes);
            for (f, roots) in roots.iter().enumerate() {
                let hand = self.flanks[f].hand;
                let depth = |root: &RootPoint, setup: &FlankSetup| {
                    ROOT_WEIGHT * root.depth_change(setup, hand).unwrap_or(0.0)
                };
                let depth_change = |root: &RootPoint| match flanks.contains(&f) {
                    true => depth(root, &next) - depth(root, setup),
                    false => 0.0,
                };
                // Roots of the fit have rows in `column` already.
                if self.flanks[f].roots.is_empty() {
                    column.extend(roots.iter().flatten().map(depth_change));
                }
            }
            column.extend((0..all_dials.len()).map(|j| if i == j { step_weight } else { 0.0 }));
            columns.push(column);
            offsets.push((value - dial.value(last)) / step);
        }
        let rows = columns.first().map_or(0, Vec::len);
        let mut target = vec![0.0; rows];
        for (column, offset) in columns.iter().zip(&offsets) {
            (target.iter_mut().zip(column)).for_each(|(t, c)| *t += offset * c);
        }
        let counts = integer_least_squares(&columns, &target);
        let mut setups = exact.to_vec();
        for ((dial, flanks), count) in all_dials.iter().zip(counts) {
            let value = dial.value(&self.flanks[flanks[0]].setup) + count * dial.step(steps);
            for f in flanks {
                setups[*f] = dial.set(setups[*f], value);
            }
        }
        Ok(setups)
    }

    /// Dials with the flanks they change, without duplicates.
    fn dials_of_flanks(&self, dials: &[Vec<Dial>]) -> Vec<(Dial, Vec<usize>)> {
        let mut all_dials: Vec<(Dial, Vec<usize>)> = Vec::new();
        for (f, dials) in dials.iter().enumerate() {
            for dial in dials {
                let shows =
                    |unknown: &&Unknown| unknown.flanks.contains(&f) && dial.shows(unknown.setting);
                let Some(unknown) = self.unknowns.iter().find(shows) else {
                    continue;
                };
                let entry = (*dial, unknown.flanks.clone());
                if !all_dials.contains(&entry) {
                    all_dials.push(entry);
                }
            }
        }
        all_dials
    }
}
