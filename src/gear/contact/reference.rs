//! Reference contact, where the ratio equals that of the tooth numbers: local parameters, contact forces, V–H shift of the pattern.

use super::contact_point::ContactPoint;
use super::pair::{Assembly, FlankPair};
use crate::gear::hand::Hand;
use crate::gear::kernel::newton::newton;
use crate::gear::kernel::second_order::SecondOrder;
use crate::gear::kernel::vector::Vector;

/// Largest number of secant steps to the reference angle.
const STEPS: usize = 30;
/// Tolerance of the ratio relative to that of the tooth numbers.
const SAME_RATIO: f64 = 1e-11;
/// Finite-difference step of the pinion angle, rad: second-order error of exact rates.
const STEP: f64 = 1e-4;
/// Finite-difference step of offset and axial position, as a share of the face width: second-order error of exact positions.
const SHIFT: f64 = 1e-4;
/// Number of continuation steps of a pattern shift, for close starts of Newton's method.
const SHIFT_STEPS: usize = 3;

/// Second-order parameters at the reference contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalParameters {
    /// Change of the ratio m′ = d²φ₂/dφ₁², 1/rad.
    pub ratio_change: f64,
    /// Direction η of the path of contact on the gear flank, rad, from the root-cone direction towards the heel, positive towards the tip.
    pub path_direction: f64,
}

/// Directions and levers of the contact force at a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForces {
    /// Lever arms of the force about both axes, m.
    pub levers: [f64; 2],
    /// Unit force on pinion and gear: tangential (about the axis by the right hand), radial outwards, axial from apex to heel.
    pub directions: [[f64; 3]; 2],
    /// Sense of rotation of the driving pinion: 1 about its axis from apex to heel.
    pub pinion_turn: f64,
}

impl ContactForces {
    /// Unit contact force between two flanks, along the pinion normal on the gear.
    pub fn of(pair: &FlankPair, contact: &ContactPoint) -> ContactForces {
        let force_on = |member: usize, force: Vector| {
            let offset = contact.point - pair.centre(member);
            let axis = pair.turn(member).w;
            let around = axis.cross(offset);
            let radius = around.norm();
            let tangent = around * (1.0 / radius);
            let direction = [
                force.dot(tangent),
                force.dot(tangent.cross(axis)),
                force.dot(axis),
            ];
            (radius * direction[0], direction)
        };
        let ((first, a), (second, b)) = (force_on(0, -contact.normal), force_on(1, contact.normal));
        ContactForces {
            levers: [first.abs(), second.abs()],
            directions: [a, b],
            pinion_turn: -first.signum(),
        }
    }

    /// Normal pressure angle and spiral angle of a force on a member with the pitch angle δ, rad: from its components across the pitch
    /// cone, around and along it.
    pub fn angles(&self, member: usize, pitch_angle: f64) -> [f64; 2] {
        let [around, radial, axial] = self.directions[member];
        let (sin, cos) = pitch_angle.sin_cos();
        let across = radial * cos - axial * sin;
        let along = radial * sin + axial * cos;
        [across.abs().asin(), along.abs().atan2(around.abs())]
    }
}

/// V–H check: pattern shift by offset and pinion position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatternShift {
    /// Position of the shifted contact along the gear face, as a share.
    pub face: f64,
    /// Change V of the offset E, m.
    pub offset: f64,
    /// Change H of the axial pinion position P, m.
    pub pinion_axial: f64,
}

impl FlankPair {
    /// Contact with the ratio of the tooth numbers near another, by the secant method; `None` off the path of flank contact.
    pub fn reference_near(&self, near: &ContactPoint) -> Option<ContactPoint> {
        let error = |c: &ContactPoint| c.ratio() - self.ratio();
        let step = 0.01 * self.pitch();
        let mut before = *near;
        let mut last = self.contact(near.pinion_angle + step, near.unknowns)?;
        for _ in 0..STEPS {
            if error(&last).abs() <= SAME_RATIO {
                return Some(last);
            }
            let slope = (error(&last) - error(&before)) / (last.pinion_angle - before.pinion_angle);
            let limit = 0.2 * self.pitch();
            let change = (-error(&last) / slope).clamp(-limit, limit);
            if !change.is_finite() {
                return None;
            }
            let start = std::array::from_fn(|j| last.unknowns[j] + change * last.rates[j]);
            before = last;
            last = self.contact(last.pinion_angle + change, start)?;
        }
        None
    }

    /// Position of a contact on a member, as shares of face and height.
    pub fn shares(&self, member: usize, contact: &ContactPoint) -> Option<[f64; 2]> {
        let offset = contact.point - self.centre(member);
        let axis = self.turn(member).w;
        let position = [offset.dot(axis), axis.cross(offset).norm()];
        self.flanks[member].section.shares(position)
    }

    /// Local parameters at a flank contact.
    pub fn local_parameters(&self, contact: &ContactPoint) -> Option<LocalParameters> {
        let contact_at = |step: f64| {
            let start = std::array::from_fn(|j| contact.unknowns[j] + step * contact.rates[j]);
            self.contact(contact.pinion_angle + step, start)
        };
        let (before, after) = (contact_at(-STEP)?, contact_at(STEP)?);
        let in_gear = |c: &ContactPoint| self.pose(1, c.gear_angle()).inverse().apply(c.point);
        let path = in_gear(&after) - in_gear(&before);
        let r = in_gear(contact);
        let rho = f64::hypot(r.x, r.y);
        let (dz, dr) = (path.z, (r.x * path.x + r.y * path.y) / rho);
        let [[toe, _], [heel, _]] = self.flanks[1].section.corners;
        let (along_z, along_r) = (heel[0] - toe[0], heel[1] - toe[1]);
        let along = dz * along_z + dr * along_r;
        let up = dr * along_z - dz * along_r;
        Some(LocalParameters {
            ratio_change: (after.ratio() - before.ratio()) / (2.0 * STEP),
            // A line has no sense: the direction towards the tip is chosen.
            path_direction: (up * up.signum()).atan2(along * up.signum()),
        })
    }

    /// Ratio of D at a contact to D at a reference, for both flanks: negative beyond an undercut limit.
    pub fn undercut_shares(
        &self,
        contact: &ContactPoint,
        reference: &ContactPoint,
    ) -> Option<[f64; 2]> {
        let undercuts = |c: &ContactPoint| {
            let d = (c.meshing_states.each_ref()).map(|m| SecondOrder::of(m).map(|s| s.undercut));
            Some([d[0]?, d[1]?])
        };
        let (current, base) = (undercuts(contact)?, undercuts(reference)?);
        Some([current[0] / base[0], current[1] / base[1]])
    }
}

/// Changes V and H for a contact at a share of the gear face, half height and the ratio of the tooth numbers, by Newton's
/// method on `(V, H, φ₁)`; `None` without convergence, or for a contact off the teeth.
pub fn shift_pattern(
    pair: &FlankPair,
    (assembly, hand): (&Assembly, Hand),
    reference: &ContactPoint,
    face: f64,
) -> Option<PatternShift> {
    let section = &pair.flanks[1].section;
    let [toe, heel] = [section.at(0.0, 0.5), section.at(1.0, 0.5)];
    let width = f64::hypot(heel[0] - toe[0], heel[1] - toe[1]);
    let moved_by = |offset: f64, pinion_axial: f64| {
        let change = Assembly {
            offset,
            pinion_axial,
            ..Assembly::default()
        };
        let moved = assembly.changed(&change, 1.0);
        FlankPair::new(pair.flanks.clone(), pair.teeth, hand, &moved)
    };
    let mut near = *reference;
    let mut evaluate = |[offset, axial, angle]: [f64; 3], update: bool| -> Option<[f64; 3]> {
        let moved = moved_by(offset, axial);
        let change = angle - near.pinion_angle;
        let start = std::array::from_fn(|j| near.unknowns[j] + change * near.rates[j]);
        let contact = moved.contact(angle, start)?;
        if update {
            near = contact;
        }
        let [along, height] = moved.shares(1, &contact)?;
        let on_teeth = moved.is_near_teeth(&contact);
        on_teeth.then_some([along, height, contact.ratio() / pair.ratio()])
    };
    let steps = [SHIFT * width, SHIFT * width, STEP];
    // Continuation: each step starts from the contact of the preceding step.
    let mut solution = [0.0, 0.0, reference.pinion_angle];
    let start = evaluate(solution, true)?;
    let end = [face, 0.5, 1.0];
    for step in 1..=SHIFT_STEPS {
        let share = step as f64 / SHIFT_STEPS as f64;
        solution = newton(solution, [width, width, pair.pitch()], |x| {
            let values = evaluate(x, true)?;
            let mut rows = [[0.0; 3]; 3];
            for k in 0..3 {
                let moved = |sign: f64| {
                    std::array::from_fn(|j| x[j] + if j == k { sign * steps[k] } else { 0.0 })
                };
                let (a, b) = (evaluate(moved(-1.0), false)?, evaluate(moved(1.0), false)?);
                (0..3).for_each(|i| rows[i][k] = (b[i] - a[i]) / (2.0 * steps[k]));
            }
            let target = |i: usize| start[i] + share * (end[i] - start[i]);
            Some((std::array::from_fn(|i| values[i] - target(i)), rows))
        })?;
    }
    evaluate(solution, true)?;
    let [offset, pinion_axial, _] = solution;
    let is_on_teeth = moved_by(offset, pinion_axial).is_on_teeth(&near);
    is_on_teeth.then_some(PatternShift {
        face,
        offset,
        pinion_axial,
    })
}
