//! Hobs: a helicoid that rolls with a gear and is fed along it leaves a helicoid; the surface is the envelope under two motions.
//!
//! Hob axis z, gear axis through (a, 0, 0) along (0, sin Σ, cos Σ), `i = ω₂/ω₁`. Rolling is a condition of the direction of the normal alone,
//! `p₁ n·k₁ = i p₂ n·k₂`, so `ψ = atan2(g′, p₁/ρ) + arccos(−c/√(g′² + p₁²/ρ²))` with `c = (p₁/(i p₂) − cos Σ)/sin Σ`; the feed, a screw of
//! the gear's own lead, then gives z linearly: points of the gear are explicit for any profile of the hob. A third motion, the hob shifted
//! along its axis, gives no new equation.

use std::f64::consts::FRAC_PI_2;

use super::axial_profile::Helicoid;
use super::profile_point::ProfilePoint;
use crate::gear::cylindrical::involute::inv;
use crate::gear::kernel::crossed_axes::CrossedAxes;
use crate::gear::kernel::jet::Jet;
use crate::gear::kernel::second_order::Curvature;
use crate::gear::kernel::vector::Vector;

/// A hob that cuts a helical gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hobbing {
    /// Flank of a thread space of the hob with its metal at larger z; the flank of the thread that cuts is its half turn about x.
    pub space_flank: Helicoid,
    /// Axial place of the thread's flank on the cylinder on which its place is known, and that of the space's flank.
    pub heights: [f64; 2],
    /// Axes, with the ratio −z₀/z₂.
    pub axes: CrossedAxes,
    /// Lead of the gear a radian p₂, positive for a right hand.
    pub gear_lead: f64,
}

/// A point of the gear with the point of the hob that makes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HobbedPoint {
    /// Distance ρ from the axis of the hob.
    pub hob_radius: f64,
    /// Azimuth ψ in space about the axis of the hob, rad.
    pub azimuth: f64,
    /// Axial place on the hob.
    pub axial: f64,
    /// Turn φ of the hob, rad.
    pub hob_turn: f64,
    /// Distance from the axis of the gear.
    pub gear_radius: f64,
    /// Azimuth in the transverse section of the gear, counted from the side of the hob, rad.
    pub gear_azimuth: f64,
}

impl HobbedPoint {
    /// Distance from an involute along the line of action, with a constant; none within the base circle.
    pub fn off_involute(&self, base_radius: f64) -> Option<f64> {
        let alpha = (base_radius / self.gear_radius).acos();
        let off = base_radius * (self.gear_azimuth - inv(alpha));
        off.is_finite().then_some(off)
    }
}

/// Second derivatives of the gap between hob and gear over feed s and roll φ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedMarks {
    /// Over the feed, A_ss.
    pub feed: f64,
    /// Mixed, A_sφ.
    pub mixed: f64,
    /// Over the roll, A_φφ.
    pub roll: f64,
}

impl Hobbing {
    /// The thread's flank, which falls outwards.
    fn thread(&self, radius: f64) -> Option<ProfilePoint> {
        let space = self.space_flank.at(radius)?;
        let [thread, of_space] = self.heights;
        Some(ProfilePoint {
            height: thread + of_space - space.height,
            slope: -space.slope,
            curvature: -space.curvature,
        })
    }

    /// Axial place of the thread's flank at a radius of the hob.
    pub fn thread_height(&self, radius: f64) -> Option<f64> {
        Some(self.thread(radius)?.height)
    }

    /// The point of the gear that a radius of the hob makes; none where it makes none.
    pub fn point(&self, radius: f64) -> Option<HobbedPoint> {
        let at = self.thread(radius)?;
        let (p1, p2, i) = (self.space_flank.lead, self.gear_lead, self.axes.ratio);
        let (sin, cos) = self.axes.shaft_angle.sin_cos();
        let c = (p1 / (i * p2) - cos) / sin;
        let steep = p1 / radius;
        let azimuth = at.slope.atan2(steep) + (-c / f64::hypot(at.slope, steep)).acos();
        let (s, t) = azimuth.sin_cos();
        let normal_x = -at.slope * t + steep * s;
        let (x, y) = (radius * t - self.axes.offset, radius * s);
        let axial = (-p1 / i + (sin - c * cos) * x + normal_x * y * cos) / (normal_x * sin);
        let hob_turn = azimuth - (axial - at.height) / p1;
        let along = y * sin + axial * cos;
        let across = y * cos - axial * sin;
        let gear_azimuth = -across.atan2(-x) - i * hob_turn - along / p2;
        gear_azimuth.is_finite().then(|| HobbedPoint {
            hob_radius: radius,
            azimuth,
            axial,
            hob_turn,
            gear_radius: f64::hypot(x, across),
            gear_azimuth,
        })
    }

    /// Second derivatives of the gap at a point, `A_ij = |p_i·v_j − Φ_ij|` over feed and roll.
    pub fn feed_marks(&self, point: &HobbedPoint) -> Option<FeedMarks> {
        let (normal, place, hob) = self.surface(point)?;
        let [_, k2] = self.axes.directions();
        let [_, foot] = self.axes.feet();
        let roll = self.axes.relative();
        let feed_turn = k2 * (1.0 / self.gear_lead);
        let (v_roll, w_roll) = (roll.at(place), roll.w);
        let (v_feed, w_feed) = (k2 + feed_turn.cross(place - foot), feed_turn);
        let gradient = |w: Vector, v: Vector, along: Vector| {
            normal.cross(w).dot(along) - hob.between(v, along)
        };
        let mixed_rate = w_roll.cross(normal).dot(v_feed) + normal.dot(w_feed.cross(v_roll));
        let marks = FeedMarks {
            feed: gradient(w_feed, v_feed, v_feed),
            mixed: gradient(w_feed, v_feed, v_roll) - mixed_rate,
            roll: gradient(w_roll, v_roll, v_roll) - normal.dot(self.axes.rate(place)),
        };
        // One sign for all: the hob touches from outside.
        let sign = 1f64.copysign(marks.roll);
        let all = [marks.feed, marks.mixed, marks.roll].map(|a| sign * a);
        all.iter().all(|a| a.is_finite()).then_some(FeedMarks {
            feed: all[0],
            mixed: all[1],
            roll: all[2],
        })
    }

    /// Normal, place and curvature of the hob's flank in space.
    fn surface(&self, point: &HobbedPoint) -> Option<(Vector, Vector, Curvature)> {
        let at = self.thread(point.hob_radius)?;
        let (rho, p) = (point.hob_radius, self.space_flank.lead);
        let (sin, cos) = point.azimuth.sin_cos();
        let (outward, around) = (Vector::new(cos, sin, 0.0), Vector::new(-sin, cos, 0.0));
        let steep = p / rho;
        let normal = Vector::Z - outward * at.slope - around * steep;
        let length = normal.norm();
        let n = normal.unit()?;
        let change = |by: Vector| (by - n * n.dot(by)) * (1.0 / length);
        let place = outward * rho + Vector::Z * point.axial;
        let jet = Jet {
            r: place,
            n,
            dr: [outward + Vector::Z * at.slope, around * rho + Vector::Z * p],
            dn: [
                change(around * (steep / rho) - outward * at.curvature),
                change(outward * steep - around * at.slope),
            ],
        };
        Some((n, place, Curvature::of(&jet)?))
    }
}

impl FeedMarks {
    /// Height of the marks between two steps of the feed with the roll free, `(A_ss − A_sφ²/A_φφ) f²/8`.
    pub fn height(&self, feed: f64) -> f64 {
        (self.feed - self.mixed * self.mixed / self.roll) * feed * feed / 8.0
    }
}

/// Angle of the axes `Σ = 90° − γ₀ + β₂` of a right-hand hob with the lead angle γ₀, β₂ positive for a right-hand gear, rad.
pub fn axis_angle(hob_lead_angle: f64, gear_helix: f64) -> f64 {
    FRAC_PI_2 - hob_lead_angle + gear_helix
}
