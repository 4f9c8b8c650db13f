//! Polygons of teeth and of whole gears, and both gears of a pair where one pair of teeth touches at the pitch point.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use super::outline::ToothOutline;
use super::pair::Pair;

/// Steps of each part of a polygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutlineSteps {
    /// Steps of a fillet.
    pub fillet: usize,
    /// Steps of an involute.
    pub involute: usize,
    /// Steps of the land at a tip or root.
    pub land: usize,
}

impl Default for OutlineSteps {
    /// Chords within 1e-4 modules of the curves of gears of 5 teeth or more, of undercut teeth within 3e-4.
    fn default() -> OutlineSteps {
        OutlineSteps {
            fillet: 128,
            involute: 96,
            land: 32,
        }
    }
}

impl ToothOutline {
    /// Polygon `[x, y]`, m, anticlockwise, of the teeth with these numbers and the spaces behind them; tooth 0 has its middle at the angle
    /// `middle`, rad. Over all teeth it closes: the last point is followed by the first.
    pub fn polygon(&self, middle: f64, teeth: Range<i32>, steps: OutlineSteps) -> Vec<[f64; 2]> {
        let share = |i: usize, of: usize| i as f64 / of.max(1) as f64;
        let lower = (0..steps.fillet).map(|i| self.fillet_point(share(i, steps.fillet)));
        let upper = (0..=steps.involute).map(|i| self.involute_point(share(i, steps.involute)));
        let flank: Vec<[f64; 2]> = lower.chain(upper).collect();
        let (Some([root, root_half]), Some([tip, tip_half])) = (flank.first(), flank.last()) else {
            return Vec::new();
        };
        let pitch = TAU / f64::from(self.teeth);
        let land = |from: f64, to: f64, radius: f64| {
            let at = move |i: usize| [radius, from + (to - from) * share(i, steps.land)];
            (1..steps.land).map(at)
        };
        let mut tooth: Vec<[f64; 2]> = flank.iter().map(|[r, psi]| [*r, -psi]).collect();
        tooth.extend(land(-tip_half, *tip_half, *tip));
        tooth.extend(flank.iter().rev());
        tooth.extend(land(*root_half, pitch - root_half, *root));
        let turned = |number: i32| {
            let turn = middle + pitch * f64::from(number);
            tooth.iter().map(move |[radius, angle]| {
                let (sin, cos) = (turn + angle).sin_cos();
                [radius * cos, radius * sin]
            })
        };
        teeth.flat_map(turned).collect()
    }
}

impl Pair {
    /// Polygons of the teeth of pinion and gear with these numbers, `[x, y]`, m, where teeth 0 touch at the pitch point: the pinion's axis
    /// at the origin, the gear's on the x axis, at a, of an internal gear at −a.
    pub fn polygons_in_mesh(
        &self,
        teeth: [Range<i32>; 2],
        steps: OutlineSteps,
    ) -> [Vec<[f64; 2]>; 2] {
        let [first, second] = &self.outlines;
        let [r1, r2] = self.working_diameters().map(|d| 0.5 * d);
        // The involutes touch there, extended where the teeth end before the pitch circle.
        let (half_1, half_2) = (
            first.involute_half_angle(r1),
            second.involute_half_angle(r2),
        );
        let (axis, facing) = match self.members[1].gear.internal {
            true => (-self.centre_distance, -half_2),
            false => (self.centre_distance, PI + half_2),
        };
        let [of_pinion, of_gear] = teeth;
        let mut gear = second.polygon(facing, of_gear, steps);
        gear.iter_mut().for_each(|point| point[0] += axis);
        [first.polygon(half_1, of_pinion, steps), gear]
    }
}
