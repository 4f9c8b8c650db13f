//! Cylindrical worm pair at 90°: `z N_x = ρ cos ψ − r₁′`, since the contact normal intersects the line x = r₁′, z = 0.
//!
//! The wheel axis passes through (a, 0, 0) along (0, −1, 0), with rotation `i φ`, i = z₁/z₂; `ψ = χ + φ` is the azimuth in the fixed frame,
//! `r₁′ = a − p/i` the working pitch radius of the worm. The field of contact over (ρ, ψ) is explicit. Lengths have the unit of the input.

use std::f64::consts::FRAC_PI_2;

use super::axial_profile::Helicoid;
use crate::gear::kernel::root::{roots, sign_change};
use crate::gear::kernel::vector::Vector;

/// Worm flank with the wheel that it generates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WormPair {
    /// Helicoid of the worm flank.
    pub worm: Helicoid,
    /// Ratio i = z₁/z₂.
    pub ratio: f64,
    /// Centre distance a.
    pub centre_distance: f64,
}

/// Contact of worm and wheel; velocities are lengths per radian of the worm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WormContact {
    /// Distance ρ from the worm axis.
    pub radius: f64,
    /// Azimuth ψ in the fixed frame, rad.
    pub azimuth: f64,
    /// Rotation φ of the worm, rad.
    pub worm_turn: f64,
    /// Rotation i φ of the wheel, rad.
    pub wheel_turn: f64,
    /// Point in the fixed frame relative to the centre of the wheel, whose axis is y: (ρ cos ψ − a, ρ sin ψ, z).
    pub from_wheel: Vector,
    /// Limit function Φ, the rate of the equation of meshing at a point of the worm; zero at the limit of the second kind.
    pub second_limit: f64,
    /// Undercut function D; zero at an edge of regression of the wheel.
    pub undercut: f64,
    /// Gradient |p| of the equation of meshing over the worm flank; p is perpendicular to the contact line.
    pub gradient: f64,
    /// Magnitude of the sliding velocity.
    pub sliding: f64,
}

impl WormContact {
    /// Relative curvature across the contact line, wheel minus worm, `p²/D`.
    pub fn relative_curvature(&self) -> f64 {
        self.gradient * self.gradient / self.undercut
    }

    /// Component of the sliding velocity across the contact line, `(D + Φ)/|p|`.
    pub fn sliding_across(&self) -> f64 {
        (self.undercut + self.second_limit) / self.gradient
    }

    /// Velocities of the contact line over worm and wheel, perpendicular to the line.
    pub fn line_speeds(&self) -> [f64; 2] {
        [-self.second_limit, self.undercut].map(|rate| rate / self.gradient)
    }

    /// Angle between contact line and sliding velocity, rad, 0 to π/2.
    pub fn lubrication_angle(&self) -> f64 {
        (self.sliding_across().abs() / self.sliding).min(1.0).asin()
    }

    /// Point in the wheel frame: x from its axis away from the worm, y along the axis, z.
    pub fn in_wheel(&self) -> Vector {
        let (s, c) = self.wheel_turn.sin_cos();
        let r = self.from_wheel;
        Vector::new(r.x * c + r.z * s, r.y, r.z * c - r.x * s)
    }

    /// Distance of the point from the wheel axis.
    pub fn wheel_radius(&self) -> f64 {
        f64::hypot(self.from_wheel.x, self.from_wheel.z)
    }
}

impl WormPair {
    /// Working pitch radius of the worm, `r₁′ = a − p/i`.
    pub fn worm_pitch_radius(&self) -> f64 {
        self.centre_distance - self.wheel_pitch_radius()
    }

    /// Pitch radius of the wheel, `p/i`.
    pub fn wheel_pitch_radius(&self) -> f64 {
        self.worm.lead / self.ratio
    }

    /// Contact at a distance ρ from the worm axis and an azimuth ψ, rad.
    ///
    /// `None` outside the flank and where the normal is parallel to the pitch line.
    pub fn contact(&self, radius: f64, azimuth: f64) -> Option<WormContact> {
        let g = self.worm.at(radius)?;
        let (p, i, slope) = (self.worm.lead, self.ratio, g.slope);
        let (sine, cosine) = azimuth.sin_cos();
        // One division gives 1/ρ and 1/p.
        let inverse_product = 1.0 / (p * radius);
        let inv_radius = p * inverse_product;
        let tan_lead = p * inv_radius;
        let normal = tan_lead * sine - slope * cosine;
        let z = (radius * cosine - self.worm_pitch_radius()) / normal;
        if !z.is_finite() {
            return None;
        }
        let turn = azimuth - (z - g.height) * radius * inverse_product;
        let e = slope * sine + tan_lead * cosine;
        // Derivatives of f = z N_x − ρ cos ψ + r₁′ along φ, χ, ρ, and the sliding velocity along ρ and χ.
        let f_turn = z * e + radius * sine;
        let f_azimuth = f_turn + p * normal;
        let f_radius =
            -z * (g.curvature * cosine + tan_lead * inv_radius * sine) + normal * slope - cosine;
        let (v_radius, v_azimuth) = (i * z * cosine, 1.0 - i * z * inv_radius * sine);
        // 1/N² of the normal; the determinant of the metric is ρ² N².
        let inverse = 1.0 / (1.0 + slope * slope + tan_lead * tan_lead);
        let scale = i * inverse.sqrt();
        let f_sliding = f_radius * v_radius + f_azimuth * v_azimuth;
        // Metric of the helicoid: r_ρ = e_ρ + g′ k, r_χ = ρ e_χ + p k.
        let metric = [1.0 + slope * slope, slope * p, radius * radius + p * p];
        let square = metric[2] * f_radius * f_radius - 2.0 * metric[1] * f_radius * f_azimuth
            + metric[0] * f_azimuth * f_azimuth;
        let sliding = (metric[0] * v_radius * v_radius
            + 2.0 * metric[1] * v_radius * v_azimuth
            + metric[2] * v_azimuth * v_azimuth)
            .sqrt();
        Some(WormContact {
            radius,
            azimuth,
            worm_turn: turn,
            wheel_turn: i * turn,
            from_wheel: Vector::new(radius * cosine - self.centre_distance, radius * sine, z),
            second_limit: scale * f_turn,
            undercut: scale * (f_sliding - f_turn),
            gradient: i * inverse * inv_radius * square.sqrt(),
            sliding,
        })
    }

    /// Second contact of the same worm point, at another rotation: the wheel touches each point on one side of the limit of the second
    /// kind twice.
    pub fn second_contact(&self, contact: &WormContact) -> Option<WormContact> {
        let g = self.worm.at(contact.radius)?;
        let (sine, cosine) = contact.azimuth.sin_cos();
        let tan_lead = self.worm.lead / contact.radius;
        let (radial, tangential) = (-g.slope, -tan_lead);
        let point = Vector::new(
            contact.radius * cosine,
            contact.radius * sine,
            contact.from_wheel.z,
        );
        let normal = Vector::new(
            radial * cosine - tangential * sine,
            radial * sine + tangential * cosine,
            1.0,
        );
        let turn = 2.0 * half_turn_tangent(point, normal).atan();
        self.contact(contact.radius, contact.azimuth + turn)
    }

    /// Azimuth of the limit of the second kind at a radius, rad; `None` where the limit does not reach the radius.
    ///
    /// `(r₁′/ρ) cos ψ + (r₁′ g′/p) sin ψ = 1`; the limit passes through the pitch point of every flank.
    pub fn second_limit(&self, radius: f64) -> Option<f64> {
        let slope = self.worm.at(radius)?.slope / self.worm.lead;
        let pitch = self.worm_pitch_radius();
        let half_range = (1.0 / (pitch * f64::hypot(1.0 / radius, slope))).acos();
        let middle = slope.atan2(1.0 / radius);
        let azimuth = middle - half_range.copysign(slope);
        azimuth.is_finite().then_some(azimuth)
    }

    /// Radius of the limit of the first kind at an azimuth, rad, between two radii: inside this radius the wheel is undercut.
    pub fn undercut(&self, azimuth: f64, radii: [f64; 2]) -> Option<f64> {
        sign_change(radii, |radius| {
            Some(self.contact(radius, azimuth)?.undercut)
        })
    }

    /// Azimuths at which the contact line of a worm rotation (rad) crosses a radius, ascending, rad.
    pub fn line(&self, worm_turn: f64, radius: f64) -> Vec<f64> {
        let Some(g) = self.worm.at(radius) else {
            return Vec::new();
        };
        // Multiplied by N_x, the equation has no pole: z N_x = ρ cos ψ − r₁′ with z = g + p (ψ − φ).
        let p = self.worm.lead;
        let (tan_lead, pitch) = (p / radius, self.worm_pitch_radius());
        let meshing = |psi: f64| {
            let (sine, cosine) = psi.sin_cos();
            let z = g.height + p * (psi - worm_turn);
            let normal = tan_lead * sine - g.slope * cosine;
            let value = z * normal - radius * cosine + pitch;
            let e = tan_lead * cosine + g.slope * sine;
            Some([value, p * normal + z * e + radius * sine])
        };
        roots([-FRAC_PI_2, FRAC_PI_2], meshing)
    }
}

/// Tangent `tan(Δ/2) = m_x/m_y`, `m = x×n`, of the worm rotation Δ to the second contact of a point x with normal n with a wheel at
/// 90°; 0 at the limit of the second kind.
pub(super) fn half_turn_tangent(point: Vector, normal: Vector) -> f64 {
    let moment = point.cross(normal);
    moment.x / moment.y
}
