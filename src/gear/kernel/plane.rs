//! Plane meshing as an instance of the kernel: a plane curve swept along z, carried by a motion of the plane.
//!
//! A profile becomes a `PlaneCurve` (or an `Arc`(super::tool::Arc) with z = 0), a motion comes from
//! `rack_rolling` or `gear_rolling`, `plane_envelope` joins them:
//!
//! ```text
//! let envelope = plane_envelope(curve, rack_rolling::<Gear, Rack>(pitch_radius, offset), [from, to]);
//! let point = envelope.flank([x, 0.0])?.profile();                 // conjugate profile where the motion is at x
//! let contacts = envelope.motion_parameters([u, 0.0]);             // motion where the profile's point u touches
//! let point = envelope.point([u, 0.0, contacts[0]])?.profile();    // one of these contacts
//! let limits = limit_points(&envelope, Limit::Undercut, [[from, 0.0], [to, 0.0]], 100);
//! ```
//!
//! - The profile's normal lies to the right of its direction and must point out of the metal of the work: let the curve run with the
//!   metal of the work on its left.
//! - The straight flank of a rack gives the involute, the arc of its tip the fillet (trochoid), a gear's profile its conjugate. A sharp
//!   corner has no normal: its path is `motion.pose(x) * point`.
//! - An `Envelope` is a surface with the parameters `[x, 0]`: it is the `surface` of the next envelope, as a generated shaper that cuts
//!   a gear. Under the inverse motion, `second_contacts([x, 0.0], x)` gives its second line of action.
//! - The contact in the frame of gear 1 is `envelope.surface.jet([u, 0.0])`, in a fixed frame that of gear 1 turned by φ₁.

use super::envelope::{Envelope, FlankPoint};
use super::law::Law;
use super::motion::Motion;
use super::pose::Pose;
use super::tool::{Curve, Tool};
use super::twist::Twist;
use super::vector::Vector;

/// A curve of the plane given by a function.
#[derive(Debug, Clone, Copy)]
pub struct PlaneCurve<F> {
    /// u → `[[x, y], [x′, y′], [x″, y″]]`.
    pub function: F,
    /// First and last u.
    pub range: [f64; 2],
}

impl<F: Fn(f64) -> [[f64; 2]; 3]> Curve for PlaneCurve<F> {
    fn at(&self, u: f64) -> [Vector; 3] {
        (self.function)(u).map(|[x, y]| Vector::new(x, y, 0.0))
    }

    fn range(&self) -> [f64; 2] {
        self.range
    }
}

/// The envelope of a plane curve.
pub type PlaneEnvelope<C, To, From> = Envelope<Tool<C, From>, To>;

/// A point of a plane profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// Parameter of the generating curve.
    pub u: f64,
    /// Parameter of the motion.
    pub x: f64,
    /// Point.
    pub point: [f64; 2],
    /// Unit normal, out of the metal of the work.
    pub normal: [f64; 2],
    /// Curvature κ with `dn = −κ dr`: negative where the metal bulges; infinite at an undercut limit.
    pub curvature: f64,
    /// D: changes its sign at undercut.
    pub undercut: f64,
    /// Φ: changes its sign at a limit of the second kind.
    pub second_limit: f64,
}

/// The envelope of a plane curve under a motion over the range of its parameter.
pub fn plane_envelope<C: Curve, To, From>(
    curve: C,
    motion: Motion<To, From>,
    range: [f64; 2],
) -> PlaneEnvelope<C, To, From> {
    Envelope {
        surface: Tool::new(curve, Twist::slide(Vector::Z)),
        motion,
        range,
    }
}

/// A rack that rolls on the pitch circle of a gear, over the gear's turn φ (counter-clockwise).
///
/// The gear's centre is its origin. At φ = 0 the axes of both are parallel and the rack's origin is at `(0, pitch_radius + offset)`; the
/// rack moves by `−pitch_radius φ` along x. Its line `y = −offset` is the pitch line, so a profile shift is an offset.
pub fn rack_rolling<Gear, Rack>(pitch_radius: f64, offset: f64) -> Motion<Gear, Rack> {
    Motion::fixed(Pose::shifted(Vector::new(0.0, pitch_radius + offset, 0.0)))
        .joint(Twist::slide(Vector::X), Law::linear(-pitch_radius))
        .joint(Twist::turn(Vector::Z, Vector::ZERO), Law::linear(-1.0))
}

/// Gear 1 seen from gear 2 over the turn φ₁ of gear 1, whose centre is at the origin and that of gear 2 at `(centre_distance, 0)`.
///
/// `turn_2` is the angle of gear 2 over φ₁, both counter-clockwise: `−φ₁ z₁/z₂` for an external pair. The other gear's view is the inverse.
pub fn gear_rolling<Gear2, Gear1>(centre_distance: f64, turn_2: Law) -> Motion<Gear2, Gear1> {
    let axis = Twist::turn(Vector::Z, Vector::ZERO);
    let backwards = axis.times(-1.0);
    Motion::<Gear1, Gear1>::identity()
        .joint(axis, Law::linear(1.0))
        .then(Pose::shifted(Vector::new(-centre_distance, 0.0, 0.0)))
        .joint(backwards, turn_2)
}

impl<Frame> FlankPoint<Frame> {
    /// The point as one of a plane profile.
    pub fn profile(&self) -> ProfilePoint {
        let [u, _, x] = self.at;
        let (r, n) = (self.point.coordinates, self.normal.components);
        let second = &self.second_order;
        ProfilePoint {
            u,
            x,
            point: [r.x, r.y],
            normal: [n.x, n.y],
            curvature: second.tool.components[0] + second.p[0] * second.p[0] / second.undercut,
            undercut: second.undercut,
            second_limit: second.second_limit,
        }
    }
}
