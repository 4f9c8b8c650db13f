//! Speeds at which a Campbell branch crosses an order line: `|λ(Ω)| = order · |Ω|`.

use super::excitation_orders::{ExcitationCause, ExcitationOrder};
use super::mode::Mode;
use super::tracking::{ModeSet, ModeTracker};
use super::whirl::mass_diagonal;
use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::machine::linear::LinearModel;

/// A mode that an order meets.
pub struct ModeAtCrossing {
    /// Reference speed, rad/s.
    pub speed: f64,
    /// The mode there.
    pub mode: Mode,
}

/// Relative distance of |λ| from the order line at which a crossing is found.
const CROSSING_TOLERANCE: f64 = 1e-10;

/// Frequency distance of a mode above an order line, rad/s.
pub fn distance_to_order(mode: &Mode, order: &ExcitationOrder, speed: f64) -> f64 {
    mode.omega() - order.value * speed.abs()
}

/// The crossing between two speeds, of mode `from` at the first and `to` at the second; modes are solved anew on the way.
///
/// Nothing where both ends are on the same side, and so where a branch crosses twice between them.
/// The Illinois variant of false position (Dowell & Jarratt, BIT 11 (1971), 168–174).
///
/// # Errors
/// Those of the solver.
pub fn find_crossing<F: Fn(f64) -> Result<Vec<Mode>, Error>>(
    tracker: &ModeTracker<F>,
    order: &ExcitationOrder,
    (before, from): (&ModeSet, usize),
    (after, to): (&ModeSet, usize),
) -> Result<Option<ModeAtCrossing>, Error> {
    let gap = |snapshot: &ModeSet, mode: usize| {
        distance_to_order(&snapshot.modes[mode].mode, order, snapshot.speed)
    };
    let (mut low, mut high) = (gap(before, from), gap(after, to));
    if (low < 0.0) == (high < 0.0) {
        return Ok(None);
    }
    let (mut here, mut mode) = (before.clone(), from);
    let (mut first, mut last) = (before.speed, after.speed);
    for _ in 0..60 {
        if low.abs() <= CROSSING_TOLERANCE * here.modes[mode].mode.omega() {
            break;
        }
        let speed = first + (last - first) * (low / (low - high));
        if (last - first).abs() <= f64::EPSILON * speed.abs() {
            break;
        }
        let (next, link) = tracker.follow(&here, speed)?;
        let Some(same) = link.to[mode] else {
            return Ok(None);
        };
        let value = gap(&next, same);
        let found = value.abs() <= CROSSING_TOLERANCE * next.modes[same].mode.omega();
        if found || (value < 0.0) == (low < 0.0) {
            (first, low, here, mode) = (speed, value, next, same);
            high /= 2.0;
        } else {
            (last, high) = (speed, value);
            low /= 2.0;
        }
        if found {
            break;
        }
    }
    Ok(Some(ModeAtCrossing {
        speed: here.speed,
        mode: here.modes[mode].mode.clone(),
    }))
}

/// Participation of a mode in an order, 0 to 1: the share of its strain energy in the meshes whose teeth excite the order, or of its
/// kinetic energy in the nodes whose rotation does, whichever is larger.
pub fn participation(
    machine: &Machine,
    model: &LinearModel,
    mode: &Mode,
    order: &ExcitationOrder,
) -> f64 {
    let meshing = |branch: usize| {
        order
            .sources
            .iter()
            .filter(|source| source.cause == ExcitationCause::Mesh)
            .any(|source| {
                source
                    .gear
                    .is_some_and(|gear| machine.gears[gear].branches.contains(&branch))
            })
    };
    let turning = |dof: usize| {
        let node = machine.dofs[dof].node;
        order
            .sources
            .iter()
            .any(|source| source.cause == ExcitationCause::Rotation && source.node == node)
    };
    let p = model.select_independent(&mode.shape);
    let springs = model.branches.iter().filter(|b| b.stiffness > 0.0);
    let strain = share(springs.map(|b| {
        (
            meshing(b.index),
            b.stiffness * b.direction.dot_complex(&p).norm_sqr(),
        )
    }));
    let masses = mass_diagonal(machine);
    let moving = masses
        .iter()
        .zip(&mode.shape)
        .map(|(m, q)| m * q.norm_sqr())
        .enumerate();
    let kinetic = share(moving.map(|(dof, energy)| (turning(dof), energy)));
    strain.max(kinetic)
}

/// Share of the selected parts in the sum of all.
fn share(parts: impl Iterator<Item = (bool, f64)>) -> f64 {
    let (chosen, all) = parts.fold((0.0, 0.0), |(chosen, all), (is_chosen, part)| {
        (if is_chosen { chosen + part } else { chosen }, all + part)
    });
    if all > 0.0 { chosen / all } else { 0.0 }
}
