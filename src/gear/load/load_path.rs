//! Load raised from zero as one path: torques at which cells of the contact lines begin or cease to carry.
//!
//! From a settled load the tangent problem gives the next torque at which a force or a gap vanishes; the load is settled there and the
//! tangent taken anew. Between two such torques Δ is affine in the torque at fixed widths, its slope the reciprocal tangent stiffness.

use super::loaded_lines::{LineLoads, LoadedLines, too_wide};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_rising;

/// Torque from which the load is raised, in the last: single cells carry there.
const START: f64 = 1e-3;
/// Largest ratio of two torques of the path: the logarithm of the widths is close to its tangent.
const STEP: f64 = 1.3;
/// Least ratio of two torques of the path: a set that changes back within it is passed over.
const LEAST_STEP: f64 = 1.0 + 1e-7;
/// Torques of a path before it is given up: 40 to 100 cells change, and steps of `STEP` are 27.
const MOST_STEPS: usize = 5000;

/// A change of the set of cells that carry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarryingChange {
    /// Torque about the driven axis, N·m.
    pub torque: f64,
    /// Contact line.
    pub line: usize,
    /// Cell of that line.
    pub cell: usize,
    /// It begins to carry; else it ceases.
    pub begins: bool,
}

impl LoadedLines {
    /// The changes up to a torque about the driven axis, N·m, rising, from a thousandth of it on.
    ///
    /// # Errors
    /// As `LoadedLines::solve`; `NoConvergence` after 5000 torques.
    pub fn changes(&self, to: f64) -> Result<Vec<CarryingChange>, Error> {
        let mut torque = START * to;
        let mut here = self.solve(torque, None)?;
        let mut changes = Vec::new();
        for _ in 0..MOST_STEPS {
            if torque >= to {
                return Ok(changes);
            }
            let tangent = self.tangent_problem(&here.forces)?;
            let ahead = tangent.next_transition(&here.active, torque);
            let ahead = ahead.map_err(|e| too_wide(e, torque))?;
            let most = (STEP * torque).min(to);
            let next = ahead.map_or(most, |t| {
                (t * LEAST_STEP).clamp((LEAST_STEP * torque).min(to), most)
            });
            let after = self.solve(next, Some(&here))?;
            changes.extend(self.between(&here, &after, [torque, next])?);
            (torque, here) = (next, after);
        }
        let message =
            format!("the load was not raised to {to} N·m of the driven gear in {MOST_STEPS} steps");
        Err(Error::new(Code::NoConvergence, message).with_hint("give fewer stations"))
    }

    /// Cells that carry at one of two loads: where their force or gap vanishes on the tangent of the second.
    fn between(
        &self,
        before: &LineLoads,
        after: &LineLoads,
        [from, to]: [f64; 2],
    ) -> Result<Vec<CarryingChange>, Error> {
        if before.active == after.active {
            return Ok(Vec::new());
        }
        let tangent = self.tangent_problem(&after.forces)?;
        let margins = tangent.margins(&after.active, to);
        let margins = margins.map_err(|e| too_wide(e, to))?;
        let lines = self.lines.iter().enumerate();
        let places = lines.flat_map(|(k, line)| (0..line.cells.len()).map(move |i| (k, i)));
        let numbered = places.zip(&margins).enumerate();
        let changed = numbered.filter(|(n, _)| before.active[*n] != after.active[*n]);
        let mut changes: Vec<CarryingChange> = changed
            .map(|(n, ((line, cell), [value, rate]))| CarryingChange {
                torque: (to - value / rate).max(from).min(to),
                line,
                cell,
                begins: after.active[n],
            })
            .collect();
        sort_rising(&mut changes, |a| a.torque);
        Ok(changes)
    }
}
