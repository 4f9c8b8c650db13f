//! Coinciding orders of different error sources, with a second test for their separation.
//!
//! Orders are compared as fractions. Remeshing of a pair by k teeth rotates all members behind the pair by k/z of a revolution, and the
//! phase of their errors by the same share of the error period.

use std::collections::VecDeque;

use super::chain::TransmissionChain;
use super::order_lines::{OrderLine, periods_per_turn};
use crate::machine::components::{GeometricError, Machine};
use crate::numeric::fraction::Fraction;
use crate::scene::model::ErrorCause;

/// Coincident order lines, indistinguishable in one record.
#[derive(Debug, Clone)]
pub struct OrderCoincidence {
    /// Indices of the lines.
    pub lines: Vec<usize>,
    /// Separation test of each further line from the first.
    pub tests: Vec<SeparationTest>,
}

/// Second test that separates two sources of the same order.
#[derive(Debug, Clone, PartialEq)]
pub enum SeparationTest {
    /// Remeshing of one pair by a number of teeth.
    Remesh {
        /// Element index of the pair.
        pair: usize,
        /// Number of teeth.
        teeth: u32,
        /// Relative phase shift of the two errors, cycles.
        shift: f64,
    },
    /// Rotation of the gear on its seat.
    Reseat,
    /// Load reversal to the opposite flanks, with the relative phase shift, cycles.
    Reversal(f64),
    /// Change of torque: the share due to stiffness changes with the torque.
    Torque,
    /// Change of speed, for sources of different transfer functions, or a test of the single element on a tester.
    SpeedOrTester,
}

/// Smallest phase shift of a useful test, cycles.
const MIN_PHASE_SHIFT: f64 = 0.02;

/// Coincidences of lines of equal order; `counts` marks lines of relevant amplitude.
pub fn coincidences(
    machine: &Machine,
    chain: &TransmissionChain,
    lines: &[OrderLine],
    counts: &[bool],
) -> Vec<OrderCoincidence> {
    let mut coincidences = Vec::new();
    let counted: Vec<usize> = (0..lines.len()).filter(|&k| counts[k]).collect();
    for group in counted.chunk_by(|&a, &b| lines[a].order == lines[b].order) {
        if let [first, others @ ..] = group
            && !others.is_empty()
        {
            let tests = others
                .iter()
                .map(|&other| separation_test(machine, chain, &lines[*first], &lines[other]));
            coincidences.push(OrderCoincidence {
                lines: group.to_vec(),
                tests: tests.collect(),
            });
        }
    }
    coincidences
}

fn separation_test(
    machine: &Machine,
    chain: &TransmissionChain,
    line: &OrderLine,
    other: &OrderLine,
) -> SeparationTest {
    let (Some(first), Some(second)) = (line.declared(machine), other.declared(machine)) else {
        return SeparationTest::Torque;
    };
    let errors = [first, second];
    if let Some(remesh) = best_remesh(machine, chain, [line, other], errors) {
        return remesh;
    }
    let on_shaft =
        |cause: ErrorCause| matches!(cause, ErrorCause::SeatEccentricity | ErrorCause::RunOut);
    if errors[0].rotation_dof == errors[1].rotation_dof
        && on_shaft(errors[0].cause) != on_shaft(errors[1].cause)
    {
        return SeparationTest::Reseat;
    }
    let phase_change = |line: &OrderLine, error: &GeometricError| {
        let act = error.acts.first();
        act.map_or(0.0, |act| {
            let [drive, coast] = act.flanks;
            let cycles =
                f64::from(line.harmonic) * (coast.phase - drive.phase) / std::f64::consts::TAU;
            cycles
                + if drive.gain * coast.gain < 0.0 {
                    0.5
                } else {
                    0.0
                }
        })
    };
    let shift = phase_distance(phase_change(line, first) - phase_change(other, second));
    match shift > MIN_PHASE_SHIFT {
        true => SeparationTest::Reversal(shift),
        false => SeparationTest::SpeedOrTester,
    }
}

/// Distance of a phase from the nearest integer number of cycles, at most 1/2.
fn phase_distance(cycles: f64) -> f64 {
    let fraction = cycles.rem_euclid(1.0);
    fraction.min(1.0 - fraction)
}

/// Remeshing of a pair between two sources with the largest relative phase shift and the fewest teeth.
fn best_remesh(
    machine: &Machine,
    chain: &TransmissionChain,
    lines: [&OrderLine; 2],
    errors: [&GeometricError; 2],
) -> Option<SeparationTest> {
    /// Largest number of teeth of a remeshing.
    const MAX_TEETH: u32 = 200;
    let mut best: Option<(SeparationTest, f64)> = None;
    for gear in machine.gears.iter().filter(|gear| gear.carrier.is_none()) {
        let (Some(teeth), Some(member)) = (gear.teeth, chain.ratio(gear.rotation_dof)) else {
            continue;
        };
        if member.is_zero() {
            continue;
        }
        let with_gear = connected_side(machine, gear.element, gear.rotation_dof);
        let sides = [0, 1].map(|i| with_gear[errors[i].rotation_dof]);
        // The two sources must lie on opposite sides of the pair.
        if sides[0] == sides[1] {
            continue;
        }
        let (line, error) = if sides[0] {
            (lines[0], errors[0])
        } else {
            (lines[1], errors[1])
        };
        let Some(rate) = periods_per_turn(chain, error) else {
            continue;
        };
        let step = &(&rate.times(line.harmonic) / member) / &Fraction::new(i64::from(teeth), 1);
        for k in 1..=MAX_TEETH.min(teeth - 1) {
            let shift = phase_distance(step.times(k).fract().to_f64());
            let is_better = best
                .as_ref()
                .is_none_or(|(_, s)| shift > s + MIN_PHASE_SHIFT);
            if shift > MIN_PHASE_SHIFT && is_better {
                let test = SeparationTest::Remesh {
                    pair: gear.element,
                    teeth: k,
                    shift,
                };
                best = Some((test, shift));
            }
        }
    }
    best.map(|(test, _)| test)
}

/// Flags of the degrees of freedom connected to `start` without the element `removed`.
pub fn connected_side(machine: &Machine, removed: usize, start: usize) -> Vec<bool> {
    let mut reached = vec![false; machine.dofs.len()];
    reached[start] = true;
    let mut queue = VecDeque::from([start]);
    while let Some(dof) = queue.pop_front() {
        for branch in machine.branches.iter().filter(|b| b.element != removed) {
            let terms = &branch.direction.terms;
            if terms.iter().any(|t| t.0 == dof) {
                for &(next, _) in terms {
                    if !reached[next] {
                        reached[next] = true;
                        queue.push_back(next);
                    }
                }
            }
        }
    }
    reached
}
