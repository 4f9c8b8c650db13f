//! Wheels of a stated profile ζ(R) and the helicoids that they grind: the normal of the wheel meets the axis of the screw.
//!
//! The wheel turns about the line through (A, 0, 0) along (0, −sin S, cos S). Contact at the angle β of the wheel circle R, β = 0 towards the worm:
//! `t (A cos S + p sin S) sin β + (R − t ζ) sin S cos β = A sin S − p cos S`, with `t = −dζ/dR`.

use super::profile_point::{NEWTON_STEPS, ProfilePoint};
use crate::gear::kernel::vector::Vector;

/// Place of a disk tool's axis against the axis of the helicoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolAxis {
    /// Distance A of the axes.
    pub distance: f64,
    /// Angle S of the axes, rad.
    pub angle: f64,
}

/// A wheel of a straight or circular profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrindingWheel {
    /// Place of its axis.
    pub axis: ToolAxis,
    tilted: TiltedAxis,
    /// Radius R₀ at which the profile has its height and slope.
    radius: f64,
    /// Height ζ at R₀.
    height: f64,
    /// Sine, cosine and tangent of the profile's angle at R₀.
    profile: [f64; 3],
    /// Radius of a convex profile; none for a straight one.
    profile_radius: Option<f64>,
}

/// A point of a wheel's profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelPoint {
    /// Radius R.
    pub radius: f64,
    /// Height ζ.
    pub height: f64,
    /// Slope `t = −dζ/dR`.
    pub slope: f64,
    /// dt/dR.
    pub curvature: f64,
}

/// A point of the helicoid under the wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundPoint {
    /// Distance ρ from the axis of the helicoid.
    pub radius: f64,
    /// dρ/dR.
    pub radius_slope: f64,
    /// Sine and cosine of the angle β on the wheel.
    pub turn: [f64; 2],
    /// The axial profile there.
    pub profile: ProfilePoint,
}

/// The axis with sine and cosine of its angle, for many points of one tool.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TiltedAxis {
    distance: f64,
    sine: f64,
    cosine: f64,
}

impl TiltedAxis {
    /// `(A, 0, 0)` to the point of a wheel circle: `R (−cos β, sin β cos S, sin β sin S) + ζ (0, −sin S, cos S)`.
    fn point(&self, radius: f64, height: f64, turn: [f64; 2]) -> Vector {
        self.turned(radius, height, turn) + Vector::X * self.distance
    }

    /// A vector of the wheel with a radial and an axial part, at the angle β.
    fn turned(&self, radial: f64, axial: f64, [sine, cosine]: [f64; 2]) -> Vector {
        let (s, c) = (self.sine, self.cosine);
        Vector::new(
            -radial * cosine,
            radial * sine * c - axial * s,
            radial * sine * s + axial * c,
        )
    }

    /// Sine and cosine of the angle β where a wheel circle touches the helicoid: of both roots of `P sin β + Q cos β = C` that nearer β = 0.
    fn contact_turn(&self, [p, q, c]: [f64; 3]) -> Option<[f64; 2]> {
        let square = p * p + q * q;
        let rest = (square - c * c).sqrt();
        let turn = |rest: f64| [(p * c + q * rest) / square, (q * c - p * rest) / square];
        let [a, b] = [turn(rest), turn(-rest)];
        let nearer = if a[1] > b[1] { a } else { b };
        nearer[0].is_finite().then_some(nearer)
    }

    /// Coefficients of `P sin β + Q cos β = C`.
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

    /// Angle β where a wheel circle whose normal has the radial part `radial` and the axial part `axial` touches the helicoid, rad; none
    /// where that circle never touches. Of two roots the one nearer β = 0 cuts.
    pub fn contact_angle(
        &self,
        lead: f64,
        place: [f64; 2],
        [radial, axial]: [f64; 2],
    ) -> Option<f64> {
        let tilted = self.tilted();
        let [sine, cosine] = tilted.contact_turn(tilted.meshing(lead, place, [radial, axial]))?;
        Some(sine.atan2(cosine))
    }

    /// Angle S at which the edge of a wheel at a radius and height leaves a line instead of a transition surface, rad.
    ///
    /// Every normal of the edge touches at one β: `tan β = ζ sin S/(A cos S + p sin S)`, `R sin S cos β = A sin S − p cos S`.
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

    /// Distance ρ and axial height of the helix that a point of the wheel leaves at the angle β.
    pub fn helix(&self, lead: f64, [radius, height]: [f64; 2], beta: f64) -> [f64; 2] {
        let r = self
            .tilted()
            .point(radius, height, [beta.sin(), beta.cos()]);
        [f64::hypot(r.x, r.y), r.z - lead * r.y.atan2(r.x)]
    }
}

impl GrindingWheel {
    /// A wheel with half its width ζ and the angle of its profile, `tan = −dζ/dR`, at a radius; `profile_radius` is that of a convex profile,
    /// none of a straight one.
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

    /// The profile at a radius of the wheel; none beyond a circular profile.
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

    /// The helicoid's point that the wheel circle of a radius grinds; none where it never touches.
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
        let n = axis.turned(t, 1.0, turn);
        // Derivatives along the profile: ζ′ = −t, and β′ from the equation of meshing.
        let dp = dt * (axis.distance * axis.cosine + lead * axis.sine);
        let dq = (1.0 - dt * zeta + t * t) * axis.sine;
        let d_beta = -(dp * sine + dq * cosine) / (p * cosine - q * sine);
        let swept = |radial: f64| axis.turned(radial, 0.0, [cosine, -sine]) * d_beta;
        let dr = axis.turned(1.0, -t, turn) + swept(radius);
        let dn = axis.turned(dt, 0.0, turn) + swept(t);
        let distance = (r.x * r.x + r.y * r.y).sqrt();
        let (inverse, inverse_z) = (1.0 / distance, 1.0 / n.z);
        let d_distance = (r.x * dr.x + r.y * dr.y) * inverse;
        // g′ = −N·e_ρ/N_z.
        let outward = (n.x * r.x + n.y * r.y) * inverse;
        let along = dn.x * r.x + dn.y * r.y + n.x * dr.x + n.y * dr.y;
        let d_outward = (along - outward * d_distance) * inverse;
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

    /// The axial profile at a distance from the helicoid's axis; none below the least distance that the wheel reaches.
    pub fn profile(&self, lead: f64, distance: f64) -> Option<ProfilePoint> {
        let mut radius = self.axis.distance - distance;
        for _ in 0..NEWTON_STEPS {
            let at = self.ground(lead, radius)?;
            if !(at.radius_slope < 0.0) {
                return None;
            }
            let step = (at.radius - distance) / at.radius_slope;
            if step.abs() <= SETTLED * radius {
                return Some(at.profile.moved(distance - at.radius));
            }
            radius -= step;
        }
        None
    }

    /// Radius of the wheel and least distance from the helicoid's axis that it grinds, where dρ/dR = 0 between two wheel radii.
    pub fn least_distance(&self, lead: f64, radii: [f64; 2]) -> Option<[f64; 2]> {
        let slope = |radius: f64| Some(self.ground(lead, radius)?.radius_slope);
        let radius = crate::gear::kernel::root::sign_change(radii, slope)?;
        Some([radius, self.ground(lead, radius)?.radius])
    }
}

/// A Newton step below this share of the wheel radius leaves an error of its square.
const SETTLED: f64 = 1e-9;
