//! The contact of two flanks at an angle of the pinion: `f₁ = f₂ = 0`, `r₁ = r₂`, `n₁ ∥ n₂`, and its instantaneous ellipse.

use std::f64::consts::PI;

use super::pair::FlankPair;
use crate::gear::kernel::meeting::Meeting;
use crate::gear::kernel::newton::{newton, solve};
use crate::gear::kernel::root::roots;
use crate::gear::kernel::second_order::{Curvature, SecondOrder};
use crate::gear::kernel::vector::Vector;

/// Unknowns of a contact: u, θ, x of both flanks and the gear's angle.
pub type ContactUnknowns = [f64; 7];

/// A contact of two flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// Angle φ₁ of the pinion, rad.
    pub pinion_angle: f64,
    /// u, θ, x of pinion and gear, and the gear's angle φ₂.
    pub unknowns: ContactUnknowns,
    /// Derivatives of the unknowns over φ₁.
    pub rates: ContactUnknowns,
    /// Point in the fixed frame, m.
    pub point: Vector,
    /// Normal of the pinion, out of its metal.
    pub normal: Vector,
}

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

/// A member at a contact: its meeting, with r, n, ∂r and ∂n over u, θ, x in the fixed frame.
struct Member {
    meeting: Meeting,
    r: Vector,
    n: Vector,
    dr: [Vector; 3],
    dn: [Vector; 3],
}

impl ContactPoint {
    /// The gear's angle φ₂, rad.
    pub fn gear_angle(&self) -> f64 {
        self.unknowns[6]
    }

    /// dφ₂/dφ₁.
    pub fn ratio(&self) -> f64 {
        self.rates[6]
    }
}

impl FlankPair {
    /// The contact at φ₁ by Newton's method from `start`; none where it finds none, as on a line contact.
    pub fn contact(&self, pinion_angle: f64, start: ContactUnknowns) -> Option<ContactPoint> {
        let pinion_turn = self.turn(0);
        let first = self.member(0, pinion_angle, &start)?;
        let tangents = [first.dr[0].unit()?, first.n.cross(first.dr[0]).unit()?];
        let unknowns = newton(start, self.scales(), |y| {
            let members = self.members(pinion_angle, &y)?;
            Some((
                residual(&members, tangents),
                self.jacobian(&members, tangents),
            ))
        })?;
        let members = self.members(pinion_angle, &unknowns)?;
        let [Member { r, n, .. }, Member { n: other, .. }] = &members;
        let of_point = (-pinion_turn.at(*r)).array();
        let of_normal = pinion_turn.w.cross(*n).cross(*other);
        let right = [
            0.0,
            0.0,
            of_point[0],
            of_point[1],
            of_point[2],
            -tangents[0].dot(of_normal),
            -tangents[1].dot(of_normal),
        ];
        let scales = self.scales();
        let scaled = self
            .jacobian(&members, tangents)
            .map(|row| std::array::from_fn(|j| row[j] * scales[j]));
        let rates = solve(scaled, right)?;
        Some(ContactPoint {
            pinion_angle,
            unknowns,
            rates: std::array::from_fn(|j| rates[j] * scales[j]),
            point: *r,
            normal: *n,
        })
    }

    /// A contact without hints: the pinion's middle is turned until `n·v₁₂ = 0`, the gear's flank is found at that place. Of several
    /// angles the one whose normals agree best is the contact.
    pub fn first_contact(&self) -> Option<ContactPoint> {
        let middle = self.flanks[0].middle()?;
        let at_middle = self.flanks[0].envelope.meeting(middle)?;
        let relative = self.turn(0).plus(-self.ratio(), &self.turn(1));
        let condition = |angle: f64| {
            let pose = self.pose(0, angle);
            let (r, n) = (pose.apply(at_middle.jet.r), pose.rotate(at_middle.jet.n));
            let turn = self.turn(0);
            let (dr, dn) = (turn.at(r), turn.w.cross(n));
            let f = n.dot(relative.at(r));
            Some([f, dn.dot(relative.at(r)) + n.dot(relative.w.cross(dr))])
        };
        let mut best: Option<(f64, f64, ContactUnknowns)> = None;
        for angle in roots([-PI, PI], condition) {
            let pose = self.pose(0, angle);
            let (r, n) = (pose.apply(at_middle.jet.r), pose.rotate(at_middle.jet.n));
            let in_gear = self.pose(1, 0.0).inverse().apply(r);
            let place = [in_gear.z, f64::hypot(in_gear.x, in_gear.y)];
            let Some(at) = self.flanks[1].find(place) else {
                continue;
            };
            let Some(gear) = self.flanks[1].envelope.meeting(at) else {
                continue;
            };
            let own = gear.jet.r;
            let turn = in_gear.y.atan2(in_gear.x) - own.y.atan2(own.x);
            let gear_angle = turn - 2.0 * PI * (turn / (2.0 * PI)).round();
            let apart = (n + self.pose(1, gear_angle).rotate(gear.jet.n)).norm();
            if best.is_none_or(|(least, ..)| apart < least) {
                let [u, theta, x] = middle;
                let unknowns = [u, theta, x, at[0], at[1], at[2], gear_angle];
                best = Some((apart, angle, unknowns));
            }
        }
        let (_, angle, start) = best?;
        self.contact(angle, start)
    }

    /// The ellipse of a contact for a coating of a thickness; none at an undercut limit and where the relative curvature vanishes.
    pub fn ellipse(&self, contact: &ContactPoint, coating: f64) -> Option<ContactEllipse> {
        let members = self.members(contact.pinion_angle, &contact.unknowns)?;
        let angles = [contact.pinion_angle, contact.gear_angle()];
        let mut curvatures = [None, None];
        for (k, member) in members.iter().enumerate() {
            let own = SecondOrder::of(&member.meeting)?.envelope()?;
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
        let side = members[0].n.dot(members[1].n).signum();
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
        principal.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let semi_axes = principal.map(|(k, _)| (2.0 * coating / k.abs()).sqrt());
        semi_axes[0].is_finite().then_some(ContactEllipse {
            relative_curvatures: principal.map(|(k, _)| k),
            semi_axes,
            direction: principal[0].1,
        })
    }

    fn members(&self, pinion_angle: f64, y: &ContactUnknowns) -> Option<[Member; 2]> {
        Some([self.member(0, pinion_angle, y)?, self.member(1, y[6], y)?])
    }

    fn member(&self, k: usize, angle: f64, y: &ContactUnknowns) -> Option<Member> {
        let at = [y[3 * k], y[3 * k + 1], y[3 * k + 2]];
        let meeting = self.flanks[k].envelope.meeting(at)?;
        let pose = self.pose(k, angle);
        let jet = &meeting.jet;
        let change = meeting.angular.cross(jet.n);
        Some(Member {
            r: pose.apply(jet.r),
            n: pose.rotate(jet.n),
            dr: [jet.dr[0], jet.dr[1], meeting.velocity].map(|d| pose.rotate(d)),
            dn: [jet.dn[0], jet.dn[1], change].map(|d| pose.rotate(d)),
            meeting,
        })
    }

    /// Rows of derivatives of the residual over the unknowns.
    fn jacobian(&self, [a, b]: &[Member; 2], tangents: [Vector; 2]) -> [[f64; 7]; 7] {
        let turn = self.turn(1);
        let [p, q] = [a, b].map(|m| m.meeting.gradient);
        let by_gear = -turn.at(b.r);
        let points = [
            a.dr[0], a.dr[1], a.dr[2], -b.dr[0], -b.dr[1], -b.dr[2], by_gear,
        ];
        let normals = [
            a.dn[0].cross(b.n),
            a.dn[1].cross(b.n),
            a.dn[2].cross(b.n),
            a.n.cross(b.dn[0]),
            a.n.cross(b.dn[1]),
            a.n.cross(b.dn[2]),
            a.n.cross(turn.w.cross(b.n)),
        ];
        [
            [p[0], p[1], p[2], 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, q[0], q[1], q[2], 0.0],
            points.map(|d| d.x),
            points.map(|d| d.y),
            points.map(|d| d.z),
            normals.map(|d| tangents[0].dot(d)),
            normals.map(|d| tangents[1].dot(d)),
        ]
    }

    fn scales(&self) -> ContactUnknowns {
        let [a, b] = [0, 1].map(|k| self.flanks[k].envelope.scales_of_three());
        [a[0], a[1], a[2], b[0], b[1], b[2], 1.0]
    }
}

fn residual([a, b]: &[Member; 2], tangents: [Vector; 2]) -> [f64; 7] {
    let apart = a.r - b.r;
    let across = a.n.cross(b.n);
    [
        a.meeting.f,
        b.meeting.f,
        apart.x,
        apart.y,
        apart.z,
        tangents[0].dot(across),
        tangents[1].dot(across),
    ]
}
