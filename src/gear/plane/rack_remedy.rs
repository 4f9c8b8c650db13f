//! Changes of a rack cut that avoid undercut, each proved by cutting both gears.
//!
//! A rack undercuts where its straight flank reaches below `ρ sin² α`, ρ the least radius of curvature of the centrode.

use std::f64::consts::PI;

use super::centrodes::{Centrodes, Member};
use super::rack_cut::cut_pair;
use super::rack_cutter::RackCutter;
use crate::base::bound::Bound;

/// Most tooth numbers tried.
const MOST_TRIED: usize = 5;

/// Changes of the cut, each by itself enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RackRemedy {
    /// Least tooth numbers of both gears.
    pub teeth: Option<[u32; 2]>,
    /// Greatest dedendum, in modules.
    pub dedendum: Option<f64>,
}

impl RackRemedy {
    /// The changes with which a rack undercuts no space of either gear, up to a number of teeth.
    pub fn of(
        pair: &Centrodes,
        [z1, z2]: [u32; 2],
        cutter: &RackCutter,
        most_teeth: u32,
    ) -> Option<RackRemedy> {
        let is_free = |teeth: [u32; 2], cutter: &RackCutter| {
            let spaces = cut_pair(pair, teeth, cutter);
            spaces.is_ok_and(|both| both.iter().all(|gear| gear.undercut_spaces.is_empty()))
        };
        let module = pair.closed_arc(Member::First).ok()? / (PI * f64::from(z1));
        let sharpest = [Member::First, Member::Second]
            .map(|member| pair.curvature_extremes(member).largest[0]);
        let sine = cutter.pressure_angle.sin();
        let reach = sine * sine / (sharpest[0].max(sharpest[1]) * module);
        let rounding = cutter.tip_radius * (1.0 - sine);
        let least = (f64::from(z1) * (cutter.dedendum - rounding) / reach).ceil();
        let of_gear = |n: u32| u64::from(n) * u64::from(z2);
        let whole = |n: &u32| of_gear(*n).is_multiple_of(u64::from(z1));
        let both = |n: u32| [n, (of_gear(n) / u64::from(z1)) as u32];
        let mut numbers = ((least as u32).max(z1 + 1)..)
            .filter(whole)
            .take(MOST_TRIED)
            .map(both);
        let dedendum = Bound::AtMost(reach + rounding).text(3).parse().ok();
        Some(RackRemedy {
            teeth: numbers.find(|teeth| teeth[0] <= most_teeth && is_free(*teeth, cutter)),
            dedendum: dedendum.filter(|dedendum| {
                let shallow = RackCutter {
                    dedendum: *dedendum,
                    ..*cutter
                };
                *dedendum > cutter.addendum && is_free([z1, z2], &shallow)
            }),
        })
    }
}
