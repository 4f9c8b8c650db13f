//! Grinding wheels of a given profile ζ(R) and the helicoids they grind: contact where `n·v = 0` with the screw velocity v.
//!
//! The wheel rotates about the line through (A, 0, 0) along (0, −sin S, cos S). Contact angle β on the wheel circle R, 0 towards the worm:
//! `t (A cos S + p sin S) sin β + (R − t ζ) sin S cos β = A sin S − p cos S`, with `t = −dζ/dR`.

use super::profile_point::{NEWTON_STEPS, ProfilePoint};
use crate::gear::kernel::vector::Vector;

/// Position of a disk-tool axis relative to the axis of the helicoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolAxis {
    /// Centre distance A of the axes, m.
    pub distance: f64,
    /// Angle S between the axes, rad.
    pub angle: f64,
}

/// Grinding wheel with a straight or circular profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrindingWheel {
    /// Position of the wheel axis.
    pub axis: ToolAxis,
    tilted: TiltedAxis,
    /// Reference radius R₀ of the profile, m.
    radius: f64,
    /// Height ζ at R₀, m.
    height: f64,
    /// Sine, cosine and tangent of the profile angle at R₀.
    profile: [f64; 3],
    /// Radius of a convex profile, m; `None` for a straight profile.
    profile_radius: Option<f64>,
}

/// Profile point of a wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelPoint {
    /// Radius R, m.
    pub radius: f64,
    /// Height ζ, m.
    pub height: f64,
    /// Slope `t = −dζ/dR`.
    pub slope: f64,
    /// Derivative dt/dR, 1/m.
    pub curvature: f64,
}

/// Point of the helicoid in contact with the wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundPoint {
    /// Distance ρ from the axis of the helicoid, m.
    pub radius: f64,
    /// Derivative dρ/dR.
    pub radius_slope: f64,
    /// Sine and cosine of the angle β on the wheel.
    pub turn: [f64; 2],
    /// Axial profile at this point.
    pub profile: ProfilePoint,
}

/// Tool axis with sine and cosine of its angle, computed once per tool.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TiltedAxis {
    distance: f64,
    sine: f64,
    cosine: f64,
}

impl TiltedAxis {
    /// Point of a wheel circle: `(A, 0, 0) + R (−cos β, sin β cos S, sin β sin S) + ζ (0, −sin S, cos S)`.
    fn point(&self, radius: f64, height: f64, turn: [f64; 2]) -> Vector {
        self.wheel_vector(radius, height, turn) + Vector::X * self.distance
    }

    /// Vector with the radial and axial components at the angle β on the wheel.
    fn wheel_vector(&self, radial: f64, axial: f64, [sine, cosine]: [f64; 2]) -> Vector {
        let (s, c) = (self.sine, self.cosine);
        Vector::new(
            -radial * cosine,
            radial * sine * c - axial * s,
            radial * sine * s + axial * c,
        )
    }

    /// Sine and cosine of the contact angle β of a wheel circle: of both roots of `P sin β + Q cos β = C` that nearer β = 0.
    fn contact_turn(&self, [p, q, c]: [f64; 3]) -> Option<[f64; 2]> {
        let square = p * p + q * q;
        let root = (square - c * c).sqrt();
        let turn = |root: f64| [(p * c + q * root) / square, (q * c - p * root) / square];
        let [a, b] = [turn(root), turn(-root)];
        let contact = if a[1] > b[1] { a } else { b };
        contact[0].is_finite().then_some(contact)
    }

    /// Coefficients of the equation of meshing `P sin β + Q cos β = C`.
    fn meshing(
        &self,
        lead: f64,
        [radius, height]: [f64; 2],
        [radial, axial]: [f64; 2],
    ) -> [f64; 3] {
        let (s, c) = (self.sine, self.cosine);
        [
            radial * (self.distance * c + lead * s),
            (axial * radius - radial * height) * s,
            axial * (self.distance * s - lead * c),
        ]
    }
}

impl ToolAxis {
    fn tilted(&self) -> TiltedAxis {
        let (sine, cosine) = self.angle.sin_cos();
        TiltedAxis {
            distance: self.distance,
            sine,
            cosine,
        }
    }

    /// Contact angle β of a wheel circle with the normal components `radial` and `axial`, rad; `None` without contact. Of two roots, that
    /// nearer β = 0 cuts.
    pub fn contact_angle(
        &self,
        lead: f64,
        circle: [f64; 2],
        [radial, axial]: [f64; 2],
    ) -> Option<f64> {
        let tilted = self.tilted();
        let [sine, cosine] = tilted.contact_turn(tilted.meshing(lead, circle, [radial, axial]))?;
        Some(sine.atan2(cosine))
    }

    /// Angle S at which the wheel edge at a radius and height generates a line instead of a transition surface, rad.
    ///
    /// All normals of the edge are in contact at the same β: `tan β = ζ sin S/(A cos S + p sin S)`, `R sin S cos β = A sin S − p cos S`.
    pub fn angle_without_transition(&self, lead: f64, [radius, height]: [f64; 2]) -> Option<f64> {
        let excess = |angle: f64| {
            let (s, c) = angle.sin_cos();
            let beta = (height * s).atan2(self.distance * c + lead * s);
            radius * s * beta.cos() - self.distance * s + lead * c
        };
        let start = lead.atan2(self.distance - radius);
        let span = 0.2 * start;
        crate::gear::kernel::root::sign_change([start - span, start + span], |a| Some(excess(a)))
    }

    /// Distance ρ and axial height of the helix that a wheel point generates at the angle β.
    pub fn helix(&self, lead: f64, [radius, height]: [f64; 2], beta: f64) -> [f64; 2] {
        let r = self
            .tilted()
            .point(radius, height, [beta.sin(), beta.cos()]);
        [f64::hypot(r.x, r.y), r.z - lead * r.y.atan2(r.x)]
    }
}

impl GrindingWheel {
    /// Creates a wheel from the half-width ζ and the profile angle, `tan = −dζ/dR`, at a radius; `profile_radius` is `None` for a straight
    /// profile.
    pub fn new(
        axis: ToolAxis,
        [radius, height]: [f64; 2],
        profile_angle: f64,
        profile_radius: Option<f64>,
    ) -> GrindingWheel {
        let (sine, cosine) = profile_angle.sin_cos();
        GrindingWheel {
            tilted: axis.tilted(),
            axis,
            radius,
            height,
            profile: [sine, cosine, sine / cosine],
            profile_radius,
        }
    }

    /// Profile at a wheel radius; `None` outside a circular profile.
    pub fn wheel_profile(&self, radius: f64) -> Option<WheelPoint> {
        let [sine, cosine, tangent] = self.profile;
        let Some(arc) = self.profile_radius else {
            return Some(WheelPoint {
                radius,
                height: self.height - tangent * (radius - self.radius),
                slope: tangent,
                curvature: 0.0,
            });
        };
        let along = (radius - self.radius) / arc + sine;
        let across = (1.0 - along * along).sqrt();
        (across > 0.0).then(|| WheelPoint {
            radius,
            height: self.height + arc * (across - cosine),
            slope: along / across,
            curvature: 1.0 / (arc * across.powi(3)),
        })
    }

    /// Point of the helicoid ground by the wheel circle of a radius; `None` without contact.
    pub fn ground(&self, lead: f64, radius: f64) -> Option<GroundPoint> {
        let axis = self.tilted;
        let WheelPoint {
            height: zeta,
            slope: t,
            curvature: dt,
            ..
        } = self.wheel_profile(radius)?;
        let [p, q, constant] = axis.meshing(lead, [radius, zeta], [t, 1.0]);
        let turn = axis.contact_turn([p, q, constant])?;
        let [sine, cosine] = turn;
        let r = axis.point(radius, zeta, turn);
        let n = axis.wheel_vector(t, 1.0, turn);
        // Derivatives along the profile: ζ′ = −t, and β′ from the equation of meshing.
        let dp = dt * (axis.distance * axis.cosine + lead * axis.sine);
        let dq = (1.0 - dt * zeta + t * t) * axis.sine;
        let d_beta = -(dp * sine + dq * cosine) / (p * cosine - q * sine);
        let rotation = |radial: f64| axis.wheel_vector(radial, 0.0, [cosine, -sine]) * d_beta;
        let dr = axis.wheel_vector(1.0, -t, turn) + rotation(radius);
        let dn = axis.wheel_vector(dt, 0.0, turn) + rotation(t);
        let distance = (r.x * r.x + r.y * r.y).sqrt();
        let (inverse, inverse_z) = (1.0 / distance, 1.0 / n.z);
        let d_distance = (r.x * dr.x + r.y * dr.y) * inverse;
        // g′ = −N·e_ρ/N_z.
        let outward = (n.x * r.x + n.y * r.y) * inverse;
        let d_numerator = dn.x * r.x + dn.y * r.y + n.x * dr.x + n.y * dr.y;
        let d_outward = (d_numerator - outward * d_distance) * inverse;
        let slope = -outward * inverse_z;
        let d_slope = -(d_outward + slope * dn.z) * inverse_z;
        Some(GroundPoint {
            radius: distance,
            radius_slope: d_distance,
            turn,
            profile: ProfilePoint {
                height: r.z - lead * r.y.atan2(r.x),
                slope,
                curvature: d_slope / d_distance,
            },
        })
    }

    /// Axial profile at a distance from the helicoid axis; `None` below the smallest distance that the wheel reaches.
    pub fn profile(&self, lead: f64, distance: f64) -> Option<ProfilePoint> {
        let mut radius = self.axis.distance - distance;
        for _ in 0..NEWTON_STEPS {
            let at = self.ground(lead, radius)?;
            if !(at.radius_slope < 0.0) {
                return None;
            }
            let step = (at.radius - distance) / at.radius_slope;
            if step.abs() <= STEP_TOLERANCE * radius {
                return Some(at.profile.moved(distance - at.radius));
            }
            radius -= step;
        }
        None
    }

    /// Wheel radius and smallest ground distance from the helicoid axis, where dρ/dR = 0 between two wheel radii.
    pub fn least_distance(&self, lead: f64, radii: [f64; 2]) -> Option<[f64; 2]> {
        let slope = |radius: f64| Some(self.ground(lead, radius)?.radius_slope);
        let radius = crate::gear::kernel::root::sign_change(radii, slope)?;
        Some([radius, self.ground(lead, radius)?.radius])
    }
}

/// Largest final Newton step relative to the wheel radius; the remaining error is of the order of its square.
const STEP_TOLERANCE: f64 = 1e-9;
