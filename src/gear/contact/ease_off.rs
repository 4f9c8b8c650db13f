//! Ease-off: gap between the cut pinion flank and the flank conjugate to the gear, along the normals of the conjugate flank.
//!
//! The conjugate flank is the envelope of the gear flank under the motion of the pair at the ratio of the tooth numbers through a contact.
//! Gaps are exact distances along its normals, not differences of two grids.

use super::contact_point::ContactPoint;
use super::pair::FlankPair;
use crate::gear::bevel::flank::FlankEnvelope;
use crate::gear::bevel::frames::WorkFrame;
use crate::gear::kernel::envelope::{Envelope, FlankPoint};
use crate::gear::kernel::law::Law;
use crate::gear::kernel::motion::Motion;
use crate::gear::kernel::newton::solve;
use crate::gear::kernel::pose::{Direction, Pose};
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;

/// Number of polynomial terms of an ease-off.
const TERMS: usize = 6;

/// Tolerance of the end of the blade, m.
const ON_BLADE: f64 = 1e-9;

/// Gaps over the pinion flank, row by row from root to tip, each row from toe to heel.
#[derive(Debug, Clone, PartialEq)]
pub struct EaseOff {
    /// Rows along the height.
    pub rows: usize,
    /// Columns along the face.
    pub columns: usize,
    /// Gaps, m, positive where the cut pinion has less material; `None` where a flank does not exist or Toprem or cutter edge generate the
    /// surface.
    pub gaps: Vec<Option<f64>>,
}

/// Least-squares coefficients of an ease-off, m, over F from −1 at the toe to 1 at the heel and H from −1 at the root to 1 at the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EaseOffTerms {
    /// Constant term: gap at the middle of the flank.
    pub constant: f64,
    /// Coefficient of F: spiral-angle error.
    pub spiral_angle: f64,
    /// Coefficient of H: pressure-angle error.
    pub pressure_angle: f64,
    /// Coefficient of F²: lengthwise crowning.
    pub lengthwise_crowning: f64,
    /// Coefficient of F H: twist.
    pub twist: f64,
    /// Coefficient of H²: profile crowning.
    pub profile_crowning: f64,
    /// Root mean square of the residuals.
    pub residual: f64,
}

impl FlankPair {
    /// Pinion flank conjugate to the gear at the ratio of the tooth numbers through a contact, over one pitch of φ₁ to either side.
    pub fn conjugate(&self, contact: &ContactPoint) -> Envelope<&FlankEnvelope, WorkFrame> {
        let (angle, pitch) = (contact.pinion_angle, self.pitch());
        let turn_of_gear = contact.gear_angle() - self.ratio() * angle;
        self.conjugate_from(turn_of_gear, [angle - pitch, angle + pitch])
    }

    /// Pinion flank conjugate to the gear at the ratio of the tooth numbers, over a range of φ₁, rad; `turn_of_gear`: φ₂ at φ₁ = 0, rad.
    pub fn conjugate_from(
        &self,
        turn_of_gear: f64,
        range: [f64; 2],
    ) -> Envelope<&FlankEnvelope, WorkFrame> {
        let ratio = self.ratio();
        let axis = Twist::turn(Vector::Z, Vector::ZERO);
        let pinion_from_gear = self.pose(0, 0.0).inverse().after(&self.pose(1, 0.0));
        let motion = Motion::fixed(Pose::<WorkFrame, WorkFrame>::turned(
            Vector::Z,
            turn_of_gear,
        ))
        .joint(axis, Law::linear(ratio))
        .then(Pose::<WorkFrame, WorkFrame>::new(pinion_from_gear))
        .joint(axis, Law::linear(-1.0));
        Envelope {
            surface: &self.flanks[1].envelope,
            motion,
            range,
        }
    }

    /// Ease-off of the cut pinion through a contact, at `rows` by `columns` nodes of its section.
    pub fn ease_off(&self, contact: &ContactPoint, rows: usize, columns: usize) -> EaseOff {
        let conjugate = self.conjugate(contact);
        let y = &contact.unknowns;
        let [first, theta] = self.flanks[1].envelope.parameters([y[3], y[4], y[5]]);
        let starts = ([first, theta, contact.pinion_angle], [y[0], y[1], y[2]]);
        let mut gaps = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            for column in 0..columns {
                let share = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
                let position = self.flanks[0]
                    .section
                    .at(share(column, columns), share(row, rows));
                gaps.push(self.gap(&conjugate, position, starts));
            }
        }
        EaseOff {
            rows,
            columns,
            gaps,
        }
    }

    /// Gap at a node `[z, radius]`, m, from starts of Newton's method for the conjugate flank and the pinion.
    fn gap(
        &self,
        conjugate: &Envelope<&FlankEnvelope, WorkFrame>,
        position: [f64; 2],
        (conjugate_start, pinion_start): ([f64; 3], [f64; 3]),
    ) -> Option<f64> {
        let at = conjugate.intersect_circle(position, conjugate_start)?;
        let FlankPoint { point, normal, .. } = conjugate.point(at)?;
        // The normal points out of the gear into the pinion, so a positive distance is a gap.
        let inward = Direction::new(normal.components);
        let pinion = &self.flanks[0].envelope;
        let start = pinion.intersect_circle(position, pinion_start)?;
        let (parameters, distance) = pinion.intersect_ray(point, inward, start)?;
        // Below the end of the blade, Toprem or edge generate the surface.
        let [end, _] = pinion.surface.curve.range;
        (parameters[0] >= end - ON_BLADE).then_some(distance)
    }
}

impl EaseOff {
    /// Least-squares coefficients over the existing nodes; `None` where the normal equations are singular.
    pub fn terms(&self) -> Option<EaseOffTerms> {
        let mut normal = [[0.0; TERMS]; TERMS];
        let mut right = [0.0; TERMS];
        for (row, gap) in self.nodes() {
            for i in 0..TERMS {
                right[i] += row[i] * gap;
                (0..TERMS).for_each(|j| normal[i][j] += row[i] * row[j]);
            }
        }
        let terms = solve(normal, right)?;
        let (mut squares, mut count) = (0.0, 0.0);
        for (row, gap) in self.nodes() {
            let fitted: f64 = row.iter().zip(terms).map(|(a, b)| a * b).sum();
            squares += (gap - fitted) * (gap - fitted);
            count += 1.0;
        }
        let [
            constant,
            spiral_angle,
            pressure_angle,
            lengthwise_crowning,
            twist,
            profile_crowning,
        ] = terms;
        Some(EaseOffTerms {
            constant,
            spiral_angle,
            pressure_angle,
            lengthwise_crowning,
            twist,
            profile_crowning,
            residual: f64::sqrt(squares / count),
        })
    }

    /// Regressors `[1, F, H, F², F H, H²]` and gap of every existing node.
    fn nodes(&self) -> impl Iterator<Item = ([f64; TERMS], f64)> {
        let side = |i: usize, n: usize| 2.0 * i as f64 / (n.max(2) - 1) as f64 - 1.0;
        let coordinates = (0..self.rows).flat_map(move |row| {
            (0..self.columns).map(move |column| (side(column, self.columns), side(row, self.rows)))
        });
        let nodes = coordinates.zip(&self.gaps);
        nodes.filter_map(|((f, h), gap)| Some(([1.0, f, h, f * f, f * h, h * h], (*gap)?)))
    }
}
