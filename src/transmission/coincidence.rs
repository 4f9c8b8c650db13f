//! Coinciding orders of different sources, and the second test that separates them.
//!
//! Orders are compared as fractions. A pair put together k teeth further on turns everything behind it by k/z of a turn, and the
//! phase of an error there by the same share of its own period.

use std::collections::VecDeque;

use super::chain::TransmissionChain;
use super::order_lines::{OrderLine, periods_per_turn};
use crate::machine::components::{GeometricError, Machine};
use crate::numeric::fraction::Fraction;
use crate::scene::model::ErrorCause;

/// Lines that one record cannot distinguish.
#[derive(Debug, Clone)]
pub struct OrderCoincidence {
    /// Numbers of the lines.
    pub lines: Vec<usize>,
    /// For each after the first: what tells it from the first.
    pub tests: Vec<SeparationTest>,
}

/// A second record that tells two sources of one order apart.
#[derive(Debug, Clone, PartialEq)]
pub enum SeparationTest {
    /// One pair put together some teeth further on.
    Remesh {
        /// Number of the pair's element.
        pair: usize,
        /// So many teeth.
        teeth: u32,
        /// By which the two phases part, turns.
        shift: f64,
    },
    /// The gear turned on its seat.
    Reseat,
    /// The other flanks carrying: the two phases part by so many turns.
    Reversal(f64),
    /// Another torque: what comes from stiffness goes with it.
    Torque,
    /// Another speed, if the machine passes them on differently; or the element alone on a tester.
    SpeedOrTester,
}

/// Apart in phase by less is not worth a test, turns.
const MIN_PHASE_SHIFT: f64 = 0.02;

/// Every order that several of the lines share whose amplitudes count.
pub fn coincidences(
    machine: &Machine,
    chain: &TransmissionChain,
    lines: &[OrderLine],
    counts: &[bool],
) -> Vec<OrderCoincidence> {
    let mut all = Vec::new();
    let counted: Vec<usize> = (0..lines.len()).filter(|&k| counts[k]).collect();
    for group in counted.chunk_by(|&a, &b| lines[a].order == lines[b].order) {
        if let [first, others @ ..] = group
            && !others.is_empty()
        {
            let tests = others
                .iter()
                .map(|&other| separation_test(machine, chain, &lines[*first], &lines[other]));
            all.push(OrderCoincidence {
                lines: group.to_vec(),
                tests: tests.collect(),
            });
        }
    }
    all
}

fn separation_test(
    machine: &Machine,
    chain: &TransmissionChain,
    one: &OrderLine,
    other: &OrderLine,
) -> SeparationTest {
    let (Some(first), Some(second)) = (one.declared(machine), other.declared(machine)) else {
        return SeparationTest::Torque;
    };
    let errors = [first, second];
    if let Some(found) = best_remesh(machine, chain, [one, other], errors) {
        return found;
    }
    let on_shaft =
        |cause: ErrorCause| matches!(cause, ErrorCause::SeatEccentricity | ErrorCause::RunOut);
    if errors[0].rotation_dof == errors[1].rotation_dof
        && on_shaft(errors[0].cause) != on_shaft(errors[1].cause)
    {
        return SeparationTest::Reseat;
    }
    let turned = |line: &OrderLine, error: &GeometricError| {
        let act = error.acts.first();
        act.map_or(0.0, |act| {
            let [drive, coast] = act.flanks;
            let turns =
                f64::from(line.harmonic) * (coast.phase - drive.phase) / std::f64::consts::TAU;
            turns
                + if drive.gain * coast.gain < 0.0 {
                    0.5
                } else {
                    0.0
                }
        })
    };
    let shift = phase_distance(turned(one, first) - turned(other, second));
    match shift > MIN_PHASE_SHIFT {
        true => SeparationTest::Reversal(shift),
        false => SeparationTest::SpeedOrTester,
    }
}

/// The distance of a phase from the next whole turn, at most one half.
fn phase_distance(turns: f64) -> f64 {
    let part = turns.rem_euclid(1.0);
    part.min(1.0 - part)
}

/// The pair between two sources that parts them best, with the fewest teeth that do.
fn best_remesh(
    machine: &Machine,
    chain: &TransmissionChain,
    lines: [&OrderLine; 2],
    errors: [&GeometricError; 2],
) -> Option<SeparationTest> {
    /// No more teeth are tried.
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
        let sides = [0, 1].map(|at| with_gear[errors[at].rotation_dof]);
        // One of the two must hang on this side of the pair, the other on the far side.
        if sides[0] == sides[1] {
            continue;
        }
        let (line, error) = if sides[0] {
            (lines[0], errors[0])
        } else {
            (lines[1], errors[1])
        };
        let Some(pace) = periods_per_turn(chain, error) else {
            continue;
        };
        let each = &(&pace.times(line.harmonic) / member) / &Fraction::new(i64::from(teeth), 1);
        for k in 1..=MAX_TEETH.min(teeth - 1) {
            let shift = phase_distance(each.times(k).fract().to_f64());
            let better = best
                .as_ref()
                .is_none_or(|(_, s)| shift > s + MIN_PHASE_SHIFT);
            if shift > MIN_PHASE_SHIFT && better {
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

/// True for every degree of freedom still connected to `from` with the element removed.
pub fn connected_side(machine: &Machine, without: usize, from: usize) -> Vec<bool> {
    let mut reached = vec![false; machine.dofs.len()];
    reached[from] = true;
    let mut queue = VecDeque::from([from]);
    while let Some(here) = queue.pop_front() {
        for branch in machine.branches.iter().filter(|b| b.element != without) {
            let terms = &branch.direction.terms;
            if terms.iter().any(|t| t.0 == here) {
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
