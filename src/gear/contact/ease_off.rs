//! Ease-off: the gap between the cut pinion and the pinion conjugate to the gear, along the conjugate's normals.
//!
//! The gear's flank is the tool, the pair's own motion at the ratio of the tooth numbers through a contact is the motion: its envelope is
//! the conjugate flank. Distances lie on its normals, so no grid is subtracted from another.

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

/// Terms of the polynomial that decomposes an ease-off.
const TERMS: usize = 6;

/// A point this far below the end of the blade, m, is on it.
const ON_BLADE: f64 = 1e-9;

/// Gaps over the pinion's flank, row by row from root to tip, each from toe to heel.
#[derive(Debug, Clone, PartialEq)]
pub struct EaseOff {
    /// Rows along the height.
    pub rows: usize,
    /// Columns along the face.
    pub columns: usize,
    /// Gaps, m: positive where the cut pinion has less metal; none where a flank does not exist or Toprem or edge of the cutter make the
    /// tooth.
    pub gaps: Vec<Option<f64>>,
}

/// Least-squares terms of an ease-off over `F` from −1 at the toe to 1 at the heel and `H` from −1 at the root to 1 at the tip, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EaseOffTerms {
    /// Gap at the middle.
    pub constant: f64,
    /// Factor of F: error of the spiral angle.
    pub spiral_angle: f64,
    /// Factor of H: error of the pressure angle.
    pub pressure_angle: f64,
    /// Factor of F²: lengthwise crowning.
    pub lengthwise_crowning: f64,
    /// Factor of F H: twist.
    pub twist: f64,
    /// Factor of H²: profile crowning.
    pub profile_crowning: f64,
    /// Root mean square of what the terms leave.
    pub rest: f64,
}

impl FlankPair {
    /// The pinion's flank conjugate to the gear at the ratio of the tooth numbers through a contact, over φ₁.
    pub fn conjugate(&self, contact: &ContactPoint) -> Envelope<&FlankEnvelope, WorkFrame> {
        let (angle, pitch) = (contact.pinion_angle, self.pitch());
        let turn_of_gear = contact.gear_angle() - self.ratio() * angle;
        self.conjugate_from(turn_of_gear, [angle - pitch, angle + pitch])
    }

    /// The pinion's flank conjugate to the gear at the ratio of the tooth numbers over φ₁ in a range, the gear at an angle at φ₁ = 0.
    pub fn conjugate_from(
        &self,
        turn_of_gear: f64,
        range: [f64; 2],
    ) -> Envelope<&FlankEnvelope, WorkFrame> {
        let ratio = self.ratio();
        let axis = Twist::turn(Vector::Z, Vector::ZERO);
        let between = self.pose(0, 0.0).inverse().after(&self.pose(1, 0.0));
        let motion = Motion::fixed(Pose::<WorkFrame, WorkFrame>::turned(
            Vector::Z,
            turn_of_gear,
        ))
        .joint(axis, Law::linear(ratio))
        .then(Pose::<WorkFrame, WorkFrame>::new(between))
        .joint(axis, Law::linear(-1.0));
        Envelope {
            surface: &self.flanks[1].envelope,
            motion,
            range,
        }
    }

    /// The ease-off of the cut pinion through a contact at `rows` by `columns` nodes of its section.
    pub fn ease_off(&self, contact: &ContactPoint, rows: usize, columns: usize) -> EaseOff {
        let conjugate = self.conjugate(contact);
        let y = &contact.unknowns;
        let [first, theta] = self.flanks[1].envelope.own([y[3], y[4], y[5]]);
        let starts = ([first, theta, contact.pinion_angle], [y[0], y[1], y[2]]);
        let mut gaps = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            for column in 0..columns {
                let share = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
                let place = self.flanks[0]
                    .section
                    .at(share(column, columns), share(row, rows));
                gaps.push(self.gap(&conjugate, place, starts));
            }
        }
        EaseOff {
            rows,
            columns,
            gaps,
        }
    }

    /// The gap at a node `[z, radius]`.
    fn gap(
        &self,
        conjugate: &Envelope<&FlankEnvelope, WorkFrame>,
        place: [f64; 2],
        (of_conjugate, of_pinion): ([f64; 3], [f64; 3]),
    ) -> Option<f64> {
        let at = conjugate.on_circle(place, of_conjugate)?;
        let FlankPoint { point, normal, .. } = conjugate.point(at)?;
        // Out of the gear's metal is into the pinion's: a positive distance is a gap.
        let inward = Direction::new(normal.components);
        let pinion = &self.flanks[0].envelope;
        let near = pinion.on_circle(place, of_pinion)?;
        let (found, distance) = pinion.on_ray(point, inward, near)?;
        // Below the end of the blade Toprem or edge make the tooth.
        let [end, _] = pinion.surface.curve.range;
        (found[0] >= end - ON_BLADE).then_some(distance)
    }
}

impl EaseOff {
    /// Least-squares terms over the nodes that exist; none where they do not determine them.
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
            rest: f64::sqrt(squares / count),
        })
    }

    /// `[1, F, H, F², F H, H²]` with the gap, of every node that exists.
    fn nodes(&self) -> impl Iterator<Item = ([f64; TERMS], f64)> {
        let side = |i: usize, n: usize| 2.0 * i as f64 / (n.max(2) - 1) as f64 - 1.0;
        let places = (0..self.rows).flat_map(move |row| {
            (0..self.columns).map(move |column| (side(column, self.columns), side(row, self.rows)))
        });
        let nodes = places.zip(&self.gaps);
        nodes.filter_map(|((f, h), gap)| Some(([1.0, f, h, f * f, f * h, h * h], (*gap)?)))
    }
}
