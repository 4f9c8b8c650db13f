//! Size of what the blades of a head leave on the touching flank of a member, and in its pair to first order over the arm of the normal.
//!
//! Teeth of one gear meet the blades in other phases: each size is the largest over as many phases as the head has blades.

use super::bevel_member::GRID;
use super::cut_flank::flank_node;
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::contact::contact_path::ContactPath;
use crate::gear::contact::pair::FlankPair;
use crate::gear::cut::blade_passes::{BladePasses, CutConditions, scallop_height};
use crate::gear::cut::cutter_head::BladeFeed;
use crate::numeric::statistics::peak_to_peak;
use crate::scene::bevel_file::BevelFile;

/// Sizes of the effect of discrete blades.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeEffect {
    /// Feed of the roll.
    pub feed: BladeFeed,
    /// Greatest height of the scallops by the law, m.
    pub scallop: f64,
    /// Largest difference between places of the flank, scallops by their mean, m.
    pub flank_range: f64,
    /// Largest peak-to-peak transmission error over the leading contacts of a pitch, scallops by their mean, rad.
    pub te_peak_to_peak: f64,
}

impl BladeEffect {
    /// The blades of `[cut]` of a file at `cradle_per_turn` rad of the cradle in a turn of the cutter, in the sense of `[cut]`.
    ///
    /// # Errors
    /// Why there is none, in words: no `[cut]`, or of the other member; no contact or no blade at some position.
    pub fn of(
        file: &BevelFile,
        member: usize,
        (pair, path): (&FlankPair, &ContactPath),
        cradle_per_turn: f64,
    ) -> Result<BladeEffect, &'static str> {
        let study = file.cut.as_ref().ok_or("the gear file has no [cut]")?;
        if study.member.is_some_and(|only| only != member) {
            return Err("[cut] of the gear file is of the other member");
        }
        let feed = BladeFeed {
            cradle_per_turn: cradle_per_turn.copysign(study.cradle_speed.unwrap_or(1.0)),
            ..study.feed(true)
        };
        let conditions = CutConditions {
            offsets: study.offsets.clone(),
            ..CutConditions::regular(feed)
        };
        let side = file.contact.side.flanks()[member];
        let described = "the flank that touches is not described";
        let cut = file.members[member].flanks[side]
            .as_ref()
            .ok_or(described)?;
        let flank = &pair.flanks[member];
        let machine = (&cut.cutter, &cut.settings, file.hand_of(member));
        let depth = flank.section.depth();
        let middle = flank.middle().ok_or(described)?;
        let passes = BladePasses::new(machine, depth, middle[1], &conditions);
        let grid = FlankGrid::of(flank, GRID[0], GRID[1]).ok_or(described)?;
        let nodes = || grid.nodes.iter().filter_map(flank_node);
        let positions = file.contact.positions;
        let contacts = (0..positions).map(|i| {
            let angle = path.reference.pinion_angle + pair.pitch() * i as f64 / positions as f64;
            let contact = pair.leading(path, angle)?.contact;
            let at = &contact.unknowns[3 * member..];
            let arm = pair.turn(1).at(contact.point).dot(contact.normal).abs();
            Some((flank.envelope.point([at[0], at[1], at[2]])?, arm))
        });
        let contacts: Vec<_> =
            (contacts.collect::<Option<_>>()).ok_or("at some position the flanks do not touch")?;
        let largest = |at: &dyn Fn(f64) -> Option<Vec<f64>>| {
            let ranges = (0..feed.blades).map(|k| Some(peak_to_peak(&at(f64::from(k))?)));
            ranges.collect::<Option<Vec<f64>>>()
        };
        let some = |values: Vec<f64>| (!values.is_empty()).then_some(values);
        let on_flank = |phase: f64| {
            let reached = nodes().filter_map(|p| passes.mean_deviation(p, phase));
            some(reached.collect())
        };
        let in_pair = |phase: f64| {
            let ahead = contacts
                .iter()
                .filter_map(|(p, arm)| Some(passes.mean_deviation(p, phase)? / arm));
            some(ahead.collect())
        };
        let greatest = |ranges: Vec<f64>| ranges.into_iter().fold(0.0, f64::max);
        let unreached = "no blade reaches a contact of the pair";
        Ok(BladeEffect {
            feed,
            scallop: nodes()
                .map(|p| scallop_height(&p.second_order, feed.step()))
                .fold(0.0, f64::max),
            flank_range: largest(&on_flank).map(greatest).ok_or(unreached)?,
            te_peak_to_peak: largest(&in_pair).map(greatest).ok_or(unreached)?,
        })
    }
}
