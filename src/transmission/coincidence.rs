//! Lines of one and the same order: one record holds only their sum, and this says which second record takes it apart.
//!
//! Orders are compared as fractions. A pair put together k teeth further on turns everything behind it by k/z of a turn, and the
//! phase of an error there by the same share of its own period.

use std::collections::VecDeque;

use super::chain::Chain;
use super::lines::{Line, pace};
use crate::machine::parts::{FormError, Machine};
use crate::numeric::fraction::Fraction;
use crate::scene::model::Cause;

/// Lines that one record cannot tell apart.
#[derive(Debug, Clone)]
pub struct Coincidence {
    /// Numbers of the lines.
    pub lines: Vec<usize>,
    /// For each after the first: what tells it from the first.
    pub tests: Vec<Test>,
}

/// A second record that tells two sources of one order apart.
#[derive(Debug, Clone, PartialEq)]
pub enum Test {
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
const WORTH: f64 = 0.02;

/// Every order that several of the lines share whose amplitudes count.
pub fn coincidences(
    machine: &Machine,
    chain: &Chain,
    lines: &[Line],
    counts: &[bool],
) -> Vec<Coincidence> {
    let mut all = Vec::new();
    let counted: Vec<usize> = (0..lines.len()).filter(|&k| counts[k]).collect();
    for group in counted.chunk_by(|&a, &b| lines[a].order == lines[b].order) {
        if let [first, others @ ..] = group
            && !others.is_empty()
        {
            let tests = others
                .iter()
                .map(|&other| test(machine, chain, &lines[*first], &lines[other]));
            all.push(Coincidence {
                lines: group.to_vec(),
                tests: tests.collect(),
            });
        }
    }
    all
}

fn test(machine: &Machine, chain: &Chain, one: &Line, other: &Line) -> Test {
    let (Some(first), Some(second)) = (one.declared(machine), other.declared(machine)) else {
        return Test::Torque;
    };
    let errors = [first, second];
    if let Some(found) = remeshed(machine, chain, [one, other], errors) {
        return found;
    }
    let on_shaft = |cause: Cause| matches!(cause, Cause::Seat | Cause::RunOut);
    if errors[0].turning == errors[1].turning
        && on_shaft(errors[0].cause) != on_shaft(errors[1].cause)
    {
        return Test::Reseat;
    }
    let turned = |line: &Line, error: &FormError| {
        let act = error.acts.first();
        act.map_or(0.0, |act| {
            let [drive, coast] = act.flanks;
            let turns =
                f64::from(line.harmonic) * (coast.turn - drive.turn) / std::f64::consts::TAU;
            turns
                + if drive.gain * coast.gain < 0.0 {
                    0.5
                } else {
                    0.0
                }
        })
    };
    let shift = apart(turned(one, first) - turned(other, second));
    match shift > WORTH {
        true => Test::Reversal(shift),
        false => Test::SpeedOrTester,
    }
}

/// The distance of a phase from the next whole turn, at most one half.
fn apart(turns: f64) -> f64 {
    let part = turns.rem_euclid(1.0);
    part.min(1.0 - part)
}

/// The pair between two sources that parts them best, with the fewest teeth that do.
fn remeshed(
    machine: &Machine,
    chain: &Chain,
    lines: [&Line; 2],
    errors: [&FormError; 2],
) -> Option<Test> {
    /// No more teeth are tried.
    const MOST: u32 = 200;
    let mut best: Option<(Test, f64)> = None;
    for gear in machine.gears.iter().filter(|gear| gear.carrier.is_none()) {
        let (Some(teeth), Some(member)) = (gear.teeth, chain.turns(gear.turning)) else {
            continue;
        };
        if member.is_zero() {
            continue;
        }
        let with_gear = side(machine, gear.element, gear.turning);
        let sides = [0, 1].map(|at| with_gear[errors[at].turning]);
        // One of the two must hang on this side of the pair, the other on the far side.
        if sides[0] == sides[1] {
            continue;
        }
        let (line, error) = if sides[0] {
            (lines[0], errors[0])
        } else {
            (lines[1], errors[1])
        };
        let Some(pace) = pace(chain, error) else {
            continue;
        };
        let each = &(&pace.times(line.harmonic) / member) / &Fraction::new(i64::from(teeth), 1);
        for k in 1..=MOST.min(teeth - 1) {
            let shift = apart(each.times(k).fract().value());
            let better = best.as_ref().is_none_or(|(_, s)| shift > s + WORTH);
            if shift > WORTH && better {
                let test = Test::Remesh {
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

/// Of every freedom: it hangs on `from` with the element taken out.
pub fn side(machine: &Machine, without: usize, from: usize) -> Vec<bool> {
    let mut reached = vec![false; machine.freedoms.len()];
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
