//! Wanted ease-off: the pinion's flank that has a wanted gap from the pinion conjugate to the gear.
//!
//! Nodes lie on the conjugate flank, so that a wanted gap is a wanted deviation of the pinion: synthesis is a correction.

use std::f64::consts::PI;

use super::measured_flank::{FlankNode, MeasuredFlank};
use super::setting::FlankSetup;
use crate::gear::bevel::flank::FlankEnvelope;
use crate::gear::bevel::frames::WorkFrame;
use crate::gear::contact::pair::FlankPair;
use crate::gear::hand::Hand;
use crate::gear::kernel::envelope::{Envelope, FlankPoint};
use crate::gear::kernel::pose::{Direction, Pose};
use crate::gear::kernel::vector::Vector;

/// A wanted ease-off, `F` and `H` from −1 to 1 over face and height of the pinion, counted from the place of the pattern.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EaseOffTarget {
    /// Shares of face and height of the pinion's flank at which the gap is zero: the middle of the pattern.
    pub place: [f64; 2],
    /// Gap of F², m.
    pub lengthwise_crowning: f64,
    /// Gap of H², m.
    pub profile_crowning: f64,
    /// Gap of F H, m: bias.
    pub twist: f64,
    /// Transmission error of the gear half a pitch from the place of the pattern, below zero where the gear lags, rad: its parabola is a gap
    /// that is constant along each line of contact of the conjugate flank.
    pub te_parabola: f64,
}

/// Nodes along the height and along the face.
pub const TARGET_GRID: [usize; 2] = [5, 9];
/// First and last share of the height, above the fillet, and of the face.
const SHARES: [[f64; 2]; 2] = [[0.12, 0.98], [0.02, 0.98]];

impl EaseOffTarget {
    /// The pinion of a pair with the deviations that bring it from its conjugate flank to the wanted gap, the depth of its slot free; none
    /// where the conjugate flank of the gear does not reach the pinion's.
    pub fn on(&self, pair: &FlankPair, setup: FlankSetup, hand: Hand) -> Option<MeasuredFlank> {
        let pinion = &pair.flanks[0];
        let middle = pinion.middle()?;
        let (conjugate, near) = conjugate(pair, middle)?;
        let side = pinion
            .envelope
            .point(middle)?
            .second_order
            .undercut
            .signum();
        let at_place =
            conjugate.on_circle(pinion.section.at(self.place[0], self.place[1]), near)?;
        let (mut nodes, mut deviations) = (Vec::new(), Vec::new());
        let [rows, columns] = TARGET_GRID;
        for column in 0..columns {
            for row in 0..rows {
                let share = |[from, to]: [f64; 2], i: usize, n: usize| {
                    from + (to - from) * i as f64 / (n - 1) as f64
                };
                let shares = [
                    share(SHARES[1], column, columns),
                    share(SHARES[0], row, rows),
                ];
                let place = pinion.section.at(shares[0], shares[1]);
                let Some(at) = conjugate.on_circle(place, near) else {
                    continue;
                };
                let FlankPoint { point, normal, .. } = conjugate.point(at)?;
                let gap = self.gap(
                    pair,
                    shares,
                    at[2] - at_place[2],
                    &point.coordinates,
                    normal.components,
                );
                nodes.push(FlankNode {
                    point,
                    // Out of the gear's metal is into the pinion's.
                    normal: Direction::new(-normal.components),
                    at: pinion.envelope.on_circle(place, middle).unwrap_or(middle),
                    shares,
                    side,
                });
                deviations.push(-gap);
            }
        }
        Some(MeasuredFlank {
            setup,
            hand,
            section: pinion.section,
            nodes,
            deviations,
            roots: Vec::new(),
        })
    }

    /// Wanted gap at shares of face and height, where the conjugate flank touches at an angle of the pinion from the place of the pattern.
    fn gap(&self, pair: &FlankPair, shares: [f64; 2], angle: f64, r: &Vector, n: Vector) -> f64 {
        let [f, h] = [0, 1].map(|k| 2.0 * (shares[k] - self.place[k]));
        let surface =
            self.lengthwise_crowning * f * f + self.twist * f * h + self.profile_crowning * h * h;
        let share = angle / (0.5 * pair.pitch());
        let lag = -self.te_parabola * share * share / pair.ratio().abs();
        surface + lag * n.dot(Vector::Z.cross(*r)).abs()
    }
}

/// Half the range of the pinion's angle in which the gear's middle is sought in mesh, rad.
const SEARCH: f64 = PI;
/// Cosine between the normals of the pinion and of the flank conjugate to its gear at least.
const LEAST_COSINE: f64 = 0.7;

type Conjugate<'a> = Envelope<&'a FlankEnvelope, WorkFrame>;

/// The flank conjugate to the gear, turned onto the pinion's at the middle of its section, with its parameters there.
fn conjugate(pair: &FlankPair, middle: [f64; 3]) -> Option<(Conjugate<'_>, [f64; 3])> {
    let pinion = &pair.flanks[0];
    let place = pinion.section.at(0.5, 0.5);
    let own = pinion.envelope.point(middle)?;
    let [first, theta] = pair.flanks[1].envelope.own(pair.flanks[1].middle()?);
    let free = pair.conjugate_from(0.0, [-SEARCH, SEARCH]);
    let starts = free.motion_parameters([first, theta]).into_iter();
    let azimuth = |r: Vector| r.y.atan2(r.x);
    starts
        .filter_map(|angle| {
            let at = free.on_circle(place, [first, theta, angle])?;
            let point = free.point(at)?;
            let turn = azimuth(own.point.coordinates) - azimuth(point.point.coordinates);
            let pose = Pose::<WorkFrame, WorkFrame>::turned(Vector::Z, turn);
            let turned = pose * point.normal;
            let cosine = -turned.components.dot(own.normal.components);
            let envelope = Envelope {
                motion: free.motion.clone().then(pose),
                ..free.clone()
            };
            (cosine > LEAST_COSINE).then_some((cosine, (envelope, at)))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, found)| found)
}
