//! The reference contact: the place where the ratio is that of the tooth numbers, its local parameters, and how errors of assembly move it.

use super::contact_point::ContactPoint;
use super::pair::{Assembly, FlankPair};
use crate::gear::hand::Hand;
use crate::gear::kernel::newton::newton;
use crate::gear::kernel::second_order::SecondOrder;
use crate::gear::kernel::vector::Vector;

/// Secant steps towards the angle of the reference.
const STEPS: usize = 30;
/// A ratio this near that of the tooth numbers is equal to it.
const SAME_RATIO: f64 = 1e-11;
/// Step of the pinion's angle in differences of exact rates, rad: their error is its square times a third derivative.
const STEP: f64 = 1e-4;
/// Step of offset and axial place in differences, as a share of the face width: positions are exact, so that the error is its square.
const SHIFT: f64 = 1e-4;
/// Parts in which a pattern is moved, so that Newton's method starts near each.
const PARTS: usize = 3;

/// Local parameters of the contact at its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalParameters {
    /// Change of the ratio m′ = d²φ₂/dφ₁², 1/rad.
    pub ratio_change: f64,
    /// Direction η of the path of contact on the gear's flank, rad, from the root cone's direction towards the heel to the tip.
    pub path_direction: f64,
}

/// Directions and levers of the contact force at a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForces {
    /// Levers of the force about both axes, m.
    pub levers: [f64; 2],
    /// Unit force on pinion and gear: tangential (about the axis by the right hand), radial outwards, axial from apex to heel.
    pub directions: [[f64; 3]; 2],
    /// Sense in which the pinion turns as it drives: 1 about its axis from apex to heel.
    pub pinion_turn: f64,
}

impl ContactForces {
    /// The force between two flanks, along the pinion's normal on the gear.
    pub fn of(pair: &FlankPair, contact: &ContactPoint) -> ContactForces {
        let on = |member: usize, force: Vector| {
            let off = contact.point - pair.centre(member);
            let axis = pair.turn(member).w;
            let around = axis.cross(off);
            let radius = around.norm();
            let tangent = around * (1.0 / radius);
            let direction = [
                force.dot(tangent),
                force.dot(tangent.cross(axis)),
                force.dot(axis),
            ];
            (radius * direction[0], direction)
        };
        let ((first, a), (second, b)) = (on(0, -contact.normal), on(1, contact.normal));
        ContactForces {
            levers: [first.abs(), second.abs()],
            directions: [a, b],
            pinion_turn: -first.signum(),
        }
    }

    /// Normal pressure angle and spiral angle, rad, of a force on a member whose pitch angle is δ: its components across the pitch cone,
    /// around and along it.
    pub fn angles(&self, member: usize, pitch_angle: f64) -> [f64; 2] {
        let [around, radial, axial] = self.directions[member];
        let (sin, cos) = pitch_angle.sin_cos();
        let across = radial * cos - axial * sin;
        let along = radial * sin + axial * cos;
        [across.abs().asin(), along.abs().atan2(around.abs())]
    }
}

/// A shift of the pattern by offset and pinion position: the V–H check.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatternShift {
    /// Share of the gear's face at which the contact then lies.
    pub face: f64,
    /// Change V of the offset E, m.
    pub offset: f64,
    /// Change H of the pinion's axial place P, m.
    pub pinion_axial: f64,
}

impl FlankPair {
    /// The contact near another whose ratio is that of the tooth numbers, by the secant method; none where it is not on the flanks' path.
    pub fn reference_near(&self, near: &ContactPoint) -> Option<ContactPoint> {
        let off = |c: &ContactPoint| c.ratio() - self.ratio();
        let step = 0.01 * self.pitch();
        let mut before = *near;
        let mut last = self.contact(near.pinion_angle + step, near.unknowns)?;
        for _ in 0..STEPS {
            if off(&last).abs() <= SAME_RATIO {
                return Some(last);
            }
            let slope = (off(&last) - off(&before)) / (last.pinion_angle - before.pinion_angle);
            let limit = 0.2 * self.pitch();
            let change = (-off(&last) / slope).clamp(-limit, limit);
            if !change.is_finite() {
                return None;
            }
            let start = std::array::from_fn(|j| last.unknowns[j] + change * last.rates[j]);
            before = last;
            last = self.contact(last.pinion_angle + change, start)?;
        }
        None
    }

    /// Shares of face and height of a member at which a contact lies.
    pub fn shares(&self, member: usize, contact: &ContactPoint) -> Option<[f64; 2]> {
        let off = contact.point - self.centre(member);
        let axis = self.turn(member).w;
        let place = [off.dot(axis), axis.cross(off).norm()];
        self.flanks[member].section.shares(place)
    }

    /// Local parameters at a contact of flanks.
    pub fn local_parameters(&self, contact: &ContactPoint) -> Option<LocalParameters> {
        let at = |step: f64| {
            let start = std::array::from_fn(|j| contact.unknowns[j] + step * contact.rates[j]);
            self.contact(contact.pinion_angle + step, start)
        };
        let (before, after) = (at(-STEP)?, at(STEP)?);
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
            // A line has no sense: the end that points to the tip.
            path_direction: (up * up.signum()).atan2(along * up.signum()),
        })
    }

    /// D of both flanks at a contact over D at another: below zero beyond an undercut limit.
    pub fn undercut_shares(
        &self,
        contact: &ContactPoint,
        reference: &ContactPoint,
    ) -> Option<[f64; 2]> {
        let of = |c: &ContactPoint| {
            let d = (c.meetings.each_ref()).map(|m| SecondOrder::of(m).map(|s| s.undercut));
            Some([d[0]?, d[1]?])
        };
        let (here, there) = (of(contact)?, of(reference)?);
        Some([here[0] / there[0], here[1] / there[1]])
    }
}

/// Changes V and H with which the flanks touch at a share of the gear's face, half its height and the ratio of the tooth numbers, by Newton's
/// method on `(V, H, φ₁)`; none where it does not converge, or the contact there is off the teeth.
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
    let mut at = |[offset, axial, angle]: [f64; 3], keep: bool| -> Option<[f64; 3]> {
        let moved = moved_by(offset, axial);
        let change = angle - near.pinion_angle;
        let start = std::array::from_fn(|j| near.unknowns[j] + change * near.rates[j]);
        let found = moved.contact(angle, start)?;
        if keep {
            near = found;
        }
        let [along, height] = moved.shares(1, &found)?;
        let on_teeth = moved.is_near_teeth(&found);
        on_teeth.then_some([along, height, found.ratio() / pair.ratio()])
    };
    let steps = [SHIFT * width, SHIFT * width, STEP];
    // The pattern moves in parts, each from the contact of the one before.
    let mut places = [0.0, 0.0, reference.pinion_angle];
    let start = at(places, true)?;
    let end = [face, 0.5, 1.0];
    for part in 1..=PARTS {
        let share = part as f64 / PARTS as f64;
        places = newton(places, [width, width, pair.pitch()], |x| {
            let here = at(x, true)?;
            let mut rows = [[0.0; 3]; 3];
            for k in 0..3 {
                let moved = |sign: f64| {
                    std::array::from_fn(|j| x[j] + if j == k { sign * steps[k] } else { 0.0 })
                };
                let (a, b) = (at(moved(-1.0), false)?, at(moved(1.0), false)?);
                (0..3).for_each(|i| rows[i][k] = (b[i] - a[i]) / (2.0 * steps[k]));
            }
            let target = |i: usize| start[i] + share * (end[i] - start[i]);
            Some((std::array::from_fn(|i| here[i] - target(i)), rows))
        })?;
    }
    at(places, true)?;
    let [offset, pinion_axial, _] = places;
    let is_on_teeth = moved_by(offset, pinion_axial).is_on_teeth(&near);
    is_on_teeth.then_some(PatternShift {
        face,
        offset,
        pinion_axial,
    })
}
