//! Load path from zero: torques at which cells of the contact lines enter or leave the active set.
//!
//! From a converged load the tangent problem gives the next torque at which a force or a gap vanishes; the load problem is solved there and
//! linearised again. Between two such torques Δ is affine in the torque at fixed widths, with the reciprocal tangent stiffness as slope.

use super::loaded_lines::{LineLoads, LoadedLines, too_wide};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_ascending;

/// First torque of the path relative to the last: single cells are loaded there.
const START: f64 = 1e-3;
/// Maximum ratio of successive torques: the logarithm of the widths stays close to its tangent.
const MAX_STEP: f64 = 1.3;
/// Minimum ratio of successive torques: an active set that changes back within it is skipped.
const MIN_STEP: f64 = 1.0 + 1e-7;
/// Maximum number of steps; 40 to 100 cells change, and steps of `MAX_STEP` take 27.
const MOST_STEPS: usize = 5000;

/// Change of the active set: a cell becomes loaded or unloaded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveSetChange {
    /// Torque about the driven axis, N·m.
    pub torque: f64,
    /// Index of the contact line.
    pub line: usize,
    /// Index of the cell in the line.
    pub cell: usize,
    /// True if the cell becomes loaded, false if it becomes unloaded.
    pub begins: bool,
}

impl LoadedLines {
    /// Changes of the active set from a thousandth of a torque about the driven axis, N·m, up to it, in ascending order.
    ///
    /// # Errors
    /// As `LoadedLines::solve`; `NoConvergence` after 5000 torques.
    pub fn changes(&self, to: f64) -> Result<Vec<ActiveSetChange>, Error> {
        let mut torque = START * to;
        let mut loads = self.solve(torque, None)?;
        let mut changes = Vec::new();
        for _ in 0..MOST_STEPS {
            if torque >= to {
                return Ok(changes);
            }
            let tangent = self.tangent_problem(&loads.forces)?;
            let transition = tangent.next_transition(&loads.active, torque);
            let transition = transition.map_err(|e| too_wide(e, torque))?;
            let max_torque = (MAX_STEP * torque).min(to);
            let next_torque = transition.map_or(max_torque, |t| {
                (t * MIN_STEP).clamp((MIN_STEP * torque).min(to), max_torque)
            });
            let next_loads = self.solve(next_torque, Some(&loads))?;
            changes.extend(self.changes_between(&loads, &next_loads, [torque, next_torque])?);
            (torque, loads) = (next_torque, next_loads);
        }
        let message =
            format!("the load did not reach {to} N·m at the driven gear in {MOST_STEPS} steps");
        Err(Error::new(Code::NoConvergence, message).with_hint("give fewer stations"))
    }

    /// Cells loaded at only one of two torques, with the torque at which their force or gap vanishes on the tangent of the second.
    fn changes_between(
        &self,
        before: &LineLoads,
        after: &LineLoads,
        [from, to]: [f64; 2],
    ) -> Result<Vec<ActiveSetChange>, Error> {
        if before.active == after.active {
            return Ok(Vec::new());
        }
        let tangent = self.tangent_problem(&after.forces)?;
        let margins = tangent.margins(&after.active, to);
        let margins = margins.map_err(|e| too_wide(e, to))?;
        let lines = self.lines.iter().enumerate();
        let indices = lines.flat_map(|(k, line)| (0..line.cells.len()).map(move |i| (k, i)));
        let cells = indices.zip(&margins).enumerate();
        let changed = cells.filter(|(n, _)| before.active[*n] != after.active[*n]);
        let mut changes: Vec<ActiveSetChange> = changed
            .map(|(n, ((line, cell), [value, rate]))| ActiveSetChange {
                torque: (to - value / rate).max(from).min(to),
                line,
                cell,
                begins: after.active[n],
            })
            .collect();
        sort_ascending(&mut changes, |a| a.torque);
        Ok(changes)
    }
}
