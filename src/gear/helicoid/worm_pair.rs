//! Cylindrical worms with wheels at 90°: `z N_x = ρ cos ψ − r₁′`, since the contact normal passes through the line x = r₁′, z = 0.
//!
//! The wheel's axis passes through (a, 0, 0) along (0, −1, 0) and turns by `i φ`, i = z₁/z₂; `ψ = χ + φ` is the azimuth in space,
//! `r₁′ = a − p/i` the working pitch radius of the worm. The whole field of contact over (ρ, ψ) is explicit.

use std::f64::consts::FRAC_PI_2;

use super::axial_profile::Helicoid;
use crate::gear::kernel::root::{roots, sign_change};
use crate::gear::kernel::vector::Vector;

/// A flank of a worm with the wheel that it generates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WormPair {
    /// Flank of the worm.
    pub worm: Helicoid,
    /// Ratio i = z₁/z₂.
    pub ratio: f64,
    /// Centre distance a.
    pub centre_distance: f64,
}

/// Contact of a worm with its wheel; speeds are lengths a radian of the worm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WormContact {
    /// Distance ρ from the worm's axis.
    pub radius: f64,
    /// Azimuth ψ in space, rad.
    pub azimuth: f64,
    /// Turn φ of the worm, rad.
    pub worm_turn: f64,
    /// Turn i φ of the wheel, rad.
    pub wheel_turn: f64,
    /// The point in space from the middle of the wheel, whose axis is y: (ρ cos ψ − a, ρ sin ψ, z).
    pub from_wheel: Vector,
    /// Φ, the rate of the equation of meshing at a point of the worm; zero on the limit of the second kind.
    pub second_limit: f64,
    /// D; zero where the wheel is undercut.
    pub undercut: f64,
    /// Gradient |p| of the equation of meshing over the flank of the worm; p points across the line of contact.
    pub gradient: f64,
    /// Sliding velocity.
    pub sliding: f64,
}

impl WormContact {
    /// Curvature of the wheel less that of the worm across the line of contact, `p²/D`.
    pub fn relative_curvature(&self) -> f64 {
        self.gradient * self.gradient / self.undercut
    }

    /// Sliding velocity across the line of contact, `(D + Φ)/|p|`.
    pub fn sliding_across(&self) -> f64 {
        (self.undercut + self.second_limit) / self.gradient
    }

    /// Velocity of the line of contact over the worm and over the wheel, across itself.
    pub fn line_speeds(&self) -> [f64; 2] {
        [-self.second_limit, self.undercut].map(|rate| rate / self.gradient)
    }

    /// Angle of the line of contact to the sliding velocity, rad.
    pub fn lubrication_angle(&self) -> f64 {
        (self.sliding_across().abs() / self.sliding).min(1.0).asin()
    }

    /// The point in the wheel: x from its axis away from the worm, y along its axis, z.
    pub fn in_wheel(&self) -> Vector {
        let (s, c) = self.wheel_turn.sin_cos();
        let r = self.from_wheel;
        Vector::new(r.x * c + r.z * s, r.y, r.z * c - r.x * s)
    }

    /// Distance from the wheel's axis.
    pub fn wheel_radius(&self) -> f64 {
        f64::hypot(self.from_wheel.x, self.from_wheel.z)
    }
}

impl WormPair {
    /// Working pitch radius of the worm `r₁′ = a − p/i`.
    pub fn worm_pitch_radius(&self) -> f64 {
        self.centre_distance - self.wheel_pitch_radius()
    }

    /// Pitch radius of the wheel `p/i`.
    pub fn wheel_pitch_radius(&self) -> f64 {
        self.worm.lead / self.ratio
    }

    /// The contact at a distance from the worm's axis and an azimuth.
    ///
    /// None outside the flank and where the normal runs along the pitch line.
    pub fn contact(&self, radius: f64, azimuth: f64) -> Option<WormContact> {
        let at = self.worm.at(radius)?;
        let (p, i, slope) = (self.worm.lead, self.ratio, at.slope);
        let (sine, cosine) = azimuth.sin_cos();
        // One division gives 1/ρ and 1/p.
        let over = 1.0 / (p * radius);
        let over_radius = p * over;
        let steep = p * over_radius;
        let normal = steep * sine - slope * cosine;
        let z = (radius * cosine - self.worm_pitch_radius()) / normal;
        if !z.is_finite() {
            return None;
        }
        let turn = azimuth - (z - at.height) * radius * over;
        let e = slope * sine + steep * cosine;
        // Derivatives of f = z N_x − ρ cos ψ + r₁′ along φ, χ, ρ, and the sliding velocity along ρ and χ.
        let f_turn = z * e + radius * sine;
        let f_azimuth = f_turn + p * normal;
        let f_radius =
            -z * (at.curvature * cosine + steep * over_radius * sine) + normal * slope - cosine;
        let (v_radius, v_azimuth) = (i * z * cosine, 1.0 - i * z * over_radius * sine);
        // Of the normal N² and of the metric ρ² N².
        let inverse = 1.0 / (1.0 + slope * slope + steep * steep);
        let scale = i * inverse.sqrt();
        let across = f_radius * v_radius + f_azimuth * v_azimuth;
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
            undercut: scale * (across - f_turn),
            gradient: i * inverse * over_radius * square.sqrt(),
            sliding,
        })
    }

    /// The contact of the same point of the worm at another turn: on the covered side of the limit of the second kind the wheel touches it
    /// twice.
    pub fn second_contact(&self, contact: &WormContact) -> Option<WormContact> {
        let at = self.worm.at(contact.radius)?;
        let (sine, cosine) = contact.azimuth.sin_cos();
        let steep = self.worm.lead / contact.radius;
        let (outward, along) = (-at.slope, -steep);
        let point = Vector::new(
            contact.radius * cosine,
            contact.radius * sine,
            contact.from_wheel.z,
        );
        let normal = Vector::new(
            outward * cosine - along * sine,
            outward * sine + along * cosine,
            1.0,
        );
        let turn = 2.0 * half_turn_tangent(point, normal).atan();
        self.contact(contact.radius, contact.azimuth + turn)
    }

    /// Azimuth of the limit of the second kind at a radius, rad; none where it does not reach the radius.
    ///
    /// `(r₁′/ρ) cos ψ + (r₁′ g′/p) sin ψ = 1`; it passes through the pitch point of every flank.
    pub fn second_limit(&self, radius: f64) -> Option<f64> {
        let slope = self.worm.at(radius)?.slope / self.worm.lead;
        let pitch = self.worm_pitch_radius();
        let reach = (1.0 / (pitch * f64::hypot(1.0 / radius, slope))).acos();
        let middle = slope.atan2(1.0 / radius);
        let azimuth = middle - reach.copysign(slope);
        azimuth.is_finite().then_some(azimuth)
    }

    /// Radius of the limit of the first kind at an azimuth, between two radii: within it the wheel is undercut.
    pub fn undercut(&self, azimuth: f64, radii: [f64; 2]) -> Option<f64> {
        sign_change(radii, |radius| {
            Some(self.contact(radius, azimuth)?.undercut)
        })
    }

    /// Azimuths where the line of contact of a turn of the worm meets a radius, rising, rad.
    pub fn line(&self, worm_turn: f64, radius: f64) -> Vec<f64> {
        let Some(at) = self.worm.at(radius) else {
            return Vec::new();
        };
        // Without the division by the normal, a pole of the place is no jump: z N_x = ρ cos ψ − r₁′ with z = g + p (ψ − φ).
        let p = self.worm.lead;
        let (steep, pitch) = (p / radius, self.worm_pitch_radius());
        let meshing = |psi: f64| {
            let (sine, cosine) = psi.sin_cos();
            let z = at.height + p * (psi - worm_turn);
            let normal = steep * sine - at.slope * cosine;
            let value = z * normal - radius * cosine + pitch;
            let e = steep * cosine + at.slope * sine;
            Some([value, p * normal + z * e + radius * sine])
        };
        roots([-FRAC_PI_2, FRAC_PI_2], meshing)
    }
}

/// `tan(Δ/2) = m_x/m_y` with `m = x×n`: after the turn Δ of a worm its point x of normal n touches a wheel at 90° again; 0 on the limit of the
/// second kind.
pub(super) fn half_turn_tangent(point: Vector, normal: Vector) -> f64 {
    let moment = point.cross(normal);
    moment.x / moment.y
}
