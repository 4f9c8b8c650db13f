//! Errors of an indexed workpiece, separated into flank form and pitch.
//!
//! From one tooth to the next the shafts on the work's side of the differential turn on by `i / z` turns, i of theirs a turn of the
//! work; all others come back to where they were. A line of order o on those shafts moves on by o/z cycles: a whole number repeats and
//! is form, any other part p is pitch, with the cumulative amplitude A and `2 A |sin πp|` from tooth to tooth.

use super::chain::TransmissionChain;
use super::order_lines::OrderLine;
use crate::machine::components::Machine;
use crate::numeric::fraction::Fraction;

/// Effect of a line on the workpiece.
#[derive(Debug, Clone, PartialEq)]
pub enum IndexingEffect {
    /// The same on every tooth: it shapes the flank.
    Form,
    /// Another on every tooth.
    Pitch {
        /// Cycles it moves on from tooth to tooth, less whole ones.
        advance: Fraction,
        /// Amplitude from tooth to tooth over that of the line: `2 |sin πp|`.
        adjacent: f64,
    },
}

/// Indexing effect of every line; `indexed` marks the degrees of freedom that move on with the work, `teeth` are those of the work.
pub fn indexing_effects(
    machine: &Machine,
    chain: &TransmissionChain,
    lines: &[OrderLine],
    indexed: &[bool],
    teeth: u32,
) -> Vec<IndexingEffect> {
    let z = Fraction::new(i64::from(teeth), 1);
    let mark = |line: &OrderLine| {
        let turning = match line.declared(machine) {
            Some(error) => Some(error.rotation_dof),
            None => {
                let branch = line.displacements.first().map(|d| d.0);
                let gear = machine
                    .gears
                    .iter()
                    .find(|g| branch.is_some_and(|b| g.branches.contains(&b)));
                gear.map(|g| g.rotation_dof)
            }
        };
        let moves = turning.is_some_and(|dof| indexed[dof] && chain.ratio(dof).is_some());
        let advance = (&line.order / &z).fract();
        match moves && !advance.is_zero() {
            false => IndexingEffect::Form,
            true => IndexingEffect::Pitch {
                adjacent: 2.0 * (std::f64::consts::PI * advance.to_f64()).sin().abs(),
                advance,
            },
        }
    };
    lines.iter().map(mark).collect()
}
