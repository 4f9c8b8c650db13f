//! Settings for the next cut: those of the last one less the changes that explain its deviations, on the steps of the dials.

use super::correction::{CorrectionFit, CorrectionProblem};
use super::dial::{Dial, DialSteps};
use super::measured_flank::MeasuredFlank;
use super::setting::FlankSetup;
use crate::base::error::Error;

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
    /// Settings at which no flank is cut.
    pub fn next_cut(
        &self,
        fit: &CorrectionFit,
        dials: &[Vec<Dial>],
        steps: &DialSteps,
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
        let setups: Vec<FlankSetup> = (self.flanks.iter().enumerate())
            .map(|(f, flank)| {
                let next = changed(&flank.setup, f, -1.0);
                dials[f]
                    .iter()
                    .fold(next, |setup, dial| dial.rounded(setup, &flank.setup, steps))
            })
            .collect();
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
}
