//! The instantaneous contact ellipse: semi-axes `√(2δ/|κ|)` of the relative curvatures κ at a coating of the thickness δ.

use super::contact_point::ContactPoint;
use super::pair::FlankPair;
use crate::gear::kernel::second_order::{Curvature, SecondOrder};
use crate::gear::kernel::vector::Vector;
use crate::numeric::sorting::sort_ascending;

/// Instantaneous contact ellipse: where the gap is below the coating's thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEllipse {
    /// Principal relative curvatures, gear less pinion, in the pinion's normal, the smaller in size first, 1/m.
    pub relative_curvatures: [f64; 2],
    /// Semi-axes, the longer first, m.
    pub semi_axes: [f64; 2],
    /// Unit vector along the longer axis, in the fixed frame.
    pub direction: Vector,
}

impl FlankPair {
    /// The ellipse of a contact for a coating of a thickness; none at an undercut limit and where the relative curvature vanishes.
    pub fn ellipse(&self, contact: &ContactPoint, coating: f64) -> Option<ContactEllipse> {
        let angles = [contact.pinion_angle, contact.gear_angle()];
        let mut curvatures = [None, None];
        for (k, meeting) in contact.meshing_states.iter().enumerate() {
            let own = SecondOrder::of(meeting)?.envelope()?;
            let pose = self.pose(k, angles[k]);
            curvatures[k] = Some(Curvature {
                tangents: own.tangents.map(|e| pose.rotate(e)),
                ..own
            });
        }
        let [Some(pinion), Some(gear)] = curvatures else {
            return None;
        };
        // The gear's normal points the other way, which turns the sign of its curvature.
        let gear_normal = self
            .pose(1, contact.gear_angle())
            .rotate(contact.meshing_states[1].jet.n);
        let side = contact.normal.dot(gear_normal).signum();
        let [e1, e2] = pinion.tangents;
        let [w11, w12, w22] = pinion.components;
        let relative = Curvature {
            tangents: pinion.tangents,
            components: [
                side * gear.between(e1, e1) - w11,
                side * gear.between(e1, e2) - w12,
                side * gear.between(e2, e2) - w22,
            ],
        };
        let mut principal = relative.principal();
        sort_ascending(&mut principal, |a| a.0.abs());
        let semi_axes = principal.map(|(k, _)| (2.0 * coating / k.abs()).sqrt());
        semi_axes[0].is_finite().then_some(ContactEllipse {
            relative_curvatures: principal.map(|(k, _)| k),
            semi_axes,
            direction: principal[0].1,
        })
    }
}
