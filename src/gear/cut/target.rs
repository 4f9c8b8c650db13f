//! Ease-off target: pinion flank with a required gap to the flank conjugate to the gear.
//!
//! The nodes are on the conjugate flank, so that the gap is a deviation of the pinion and synthesis is a correction.

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

/// Ease-off target over the pinion: `F` and `H` are twice the shares of face and height from the centre of the contact pattern.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EaseOffTarget {
    /// Shares (0 to 1) of face and height of the pinion flank with zero gap: centre of the contact pattern.
    pub place: [f64; 2],
    /// Coefficient of F² in the gap, m.
    pub lengthwise_crowning: f64,
    /// Coefficient of H² in the gap, m.
    pub profile_crowning: f64,
    /// Coefficient of F H in the gap (bias), m.
    pub twist: f64,
    /// Transmission error of the gear half a pitch from the centre of the pattern, negative if the gear lags, rad. The gap of this parabola
    /// is constant along each contact line of the conjugate flank.
    pub te_parabola: f64,
}

/// Number of nodes along the height and along the face.
pub const TARGET_GRID: [usize; 2] = [5, 9];
/// First and last share of the height (above the fillet) and of the face.
const SHARES: [[f64; 2]; 2] = [[0.12, 0.98], [0.02, 0.98]];

impl EaseOffTarget {
    /// Pinion flank of a pair with the negative gap as deviations from the conjugate flank, with free slot depth; `None` if the
    /// flank conjugate to the gear does not reach the pinion.
    pub fn on(&self, pair: &FlankPair, setup: FlankSetup, hand: Hand) -> Option<MeasuredFlank> {
        let pinion = &pair.flanks[0];
        let middle = pinion.middle()?;
        let (conjugate, start) = conjugate(pair, middle)?;
        let side = pinion
            .envelope
            .point(middle)?
            .second_order
            .undercut
            .signum();
        let centre =
            conjugate.intersect_circle(pinion.section.at(self.place[0], self.place[1]), start)?;
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
                let z_rho = pinion.section.at(shares[0], shares[1]);
                let Some(parameters) = conjugate.intersect_circle(z_rho, start) else {
                    continue;
                };
                let FlankPoint { point, normal, .. } = conjugate.point(parameters)?;
                let gap = self.gap(
                    pair,
                    shares,
                    parameters[2] - centre[2],
                    &point.coordinates,
                    normal.components,
                );
                nodes.push(FlankNode {
                    point,
                    // The outward normal of the gear points into the pinion.
                    normal: Direction::new(-normal.components),
                    at: pinion
                        .envelope
                        .intersect_circle(z_rho, middle)
                        .unwrap_or(middle),
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

    /// Gap at shares of face and height, m; `angle` is the pinion angle of contact relative to that of the pattern centre, rad.
    fn gap(&self, pair: &FlankPair, shares: [f64; 2], angle: f64, r: &Vector, n: Vector) -> f64 {
        let [f, h] = [0, 1].map(|k| 2.0 * (shares[k] - self.place[k]));
        let surface =
            self.lengthwise_crowning * f * f + self.twist * f * h + self.profile_crowning * h * h;
        let half_pitches = angle / (0.5 * pair.pitch());
        let lag = -self.te_parabola * half_pitches * half_pitches / pair.ratio().abs();
        surface + lag * n.dot(Vector::Z.cross(*r)).abs()
    }
}

/// Half the range of pinion angles searched for contact at the middle of the gear flank, rad.
const SEARCH: f64 = PI;
/// Minimum cosine between the normals of the pinion flank and the conjugate flank.
const MIN_COSINE: f64 = 0.7;

type Conjugate<'a> = Envelope<&'a FlankEnvelope, WorkFrame>;

/// Flank conjugate to the gear, rotated onto the pinion flank at the middle of the section, with its parameters at that point.
fn conjugate(pair: &FlankPair, middle: [f64; 3]) -> Option<(Conjugate<'_>, [f64; 3])> {
    let pinion = &pair.flanks[0];
    let z_rho = pinion.section.at(0.5, 0.5);
    let pinion_point = pinion.envelope.point(middle)?;
    let [first, theta] = pair.flanks[1].envelope.parameters(pair.flanks[1].middle()?);
    let conjugate = pair.conjugate_from(0.0, [-SEARCH, SEARCH]);
    let starts = conjugate.motion_parameters([first, theta]).into_iter();
    let azimuth = |r: Vector| r.y.atan2(r.x);
    starts
        .filter_map(|angle| {
            let parameters = conjugate.intersect_circle(z_rho, [first, theta, angle])?;
            let point = conjugate.point(parameters)?;
            let turn = azimuth(pinion_point.point.coordinates) - azimuth(point.point.coordinates);
            let pose = Pose::<WorkFrame, WorkFrame>::turned(Vector::Z, turn);
            let turned = pose * point.normal;
            let cosine = -turned.components.dot(pinion_point.normal.components);
            let envelope = Envelope {
                motion: conjugate.motion.clone().then(pose),
                ..conjugate.clone()
            };
            (cosine > MIN_COSINE).then_some((cosine, (envelope, parameters)))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, flank)| flank)
}
