//! Basic rack in the normal section: addendum, dedendum, tip rounding and protuberance of the tool that cuts its counterpart.
//!
//! Depth of the tool's straight flank below the reference line: `h_fP − ρ_fP (1 − sin α)`.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use crate::base::bound::Bound;
use crate::base::code::Code;
use crate::base::error::Error;

/// A basic rack; lengths in normal modules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BasicRack {
    /// Addendum h_aP of the rack.
    pub addendum: f64,
    /// Dedendum h_fP of the rack, which is the addendum of the tool.
    pub dedendum: f64,
    /// Root fillet radius ρ_fP of the rack, which is the tip radius of the tool.
    pub tip_radius: f64,
    /// Protuberance: offset of the tip rounding beyond the straight flank of the tool, normal to the flank. The rounding continues until
    /// it meets the flank.
    pub protuberance: f64,
}

impl BasicRack {
    /// Profile A of ISO 53:1998, recommended for high torque.
    pub const PROFILE_A: BasicRack = BasicRack::standard(1.25, 0.38);
    /// Profile B of ISO 53:1998, for usual service.
    pub const PROFILE_B: BasicRack = BasicRack::standard(1.25, 0.3);
    /// Profile C of ISO 53:1998, for standard hobs.
    pub const PROFILE_C: BasicRack = BasicRack::standard(1.25, 0.25);
    /// Profile D of ISO 53:1998, for ground or shaved teeth with a deep fillet.
    pub const PROFILE_D: BasicRack = BasicRack::standard(1.4, 0.39);

    const fn standard(dedendum: f64, tip_radius: f64) -> BasicRack {
        BasicRack {
            addendum: 1.0,
            dedendum,
            tip_radius,
            protuberance: 0.0,
        }
    }

    /// Bottom clearance c_P with a rack of the same addendum.
    pub fn bottom_clearance(&self) -> f64 {
        self.dedendum - self.addendum
    }

    /// Greatest tip radius at a normal pressure angle: the tip is then one full rounding.
    pub fn full_tip_radius(&self, pressure_angle: f64) -> f64 {
        let (sine, cosine) = pressure_angle.sin_cos();
        let half_width = FRAC_PI_4 - self.dedendum * sine / cosine + self.protuberance / cosine;
        half_width * cosine / (1.0 - sine)
    }

    /// Depth below the reference line at which the rounding touches the straight flank or, with protuberance, a parallel to it.
    pub fn straight_depth(&self, pressure_angle: f64) -> f64 {
        self.dedendum - self.tip_radius * (1.0 - pressure_angle.sin())
    }

    /// Centre of the tip rounding: distance from the middle of the tool's tooth, depth below the reference line.
    pub(super) fn rounding_centre(&self, pressure_angle: f64) -> [f64; 2] {
        let (sine, cosine) = pressure_angle.sin_cos();
        let aside =
            (self.full_tip_radius(pressure_angle) - self.tip_radius) * (1.0 - sine) / cosine;
        [aside, self.dedendum - self.tip_radius]
    }

    /// Angle from straight down at which the rounding ends on the straight flank.
    pub(super) fn rounding_end(&self, pressure_angle: f64) -> f64 {
        let tangent = FRAC_PI_2 - pressure_angle;
        match self.protuberance > 0.0 {
            true => tangent + (1.0 - self.protuberance / self.tip_radius).acos(),
            false => tangent,
        }
    }

    /// # Errors
    /// `OutOfRange`: a length that is not finite or negative, or a tip that does not fit between the flanks of the tool.
    pub fn check(&self, pressure_angle: f64) -> Result<(), Error> {
        let lengths = [
            ("rack.addendum", self.addendum),
            ("rack.dedendum", self.dedendum),
            ("rack.tip_radius", self.tip_radius),
            ("rack.protuberance", self.protuberance),
        ];
        for (key, length) in lengths {
            if !(length >= 0.0 && length.is_finite()) {
                let message = format!("{key} is {length} modules; it must not be negative");
                return Err(Error::new(Code::OutOfRange, message).with_key(key));
            }
        }
        let full = self.full_tip_radius(pressure_angle);
        if !(full >= 0.0) {
            let message = format!(
                "the flanks of the tool intersect before its dedendum of {} modules",
                self.dedendum
            );
            let deepest = Bound::AtMost(FRAC_PI_4 / pressure_angle.tan()).text(4);
            let plain = if self.protuberance > 0.0 {
                ", protuberance = 0.0"
            } else {
                ""
            };
            let hint = format!("give rack = {{ dedendum = {deepest}, tip_radius = 0.0{plain} }}");
            let error = Error::new(Code::OutOfRange, message).with_key("rack.dedendum");
            return Err(error.with_hint(hint));
        }
        // Rounding of the full radius itself must not refuse it.
        if self.tip_radius > full * (1.0 + 1e-12) {
            let message = format!(
                "tip radius of the basic rack is {} modules; a full rounding has {full:.4}",
                self.tip_radius
            );
            let most = Bound::AtMost(full).text(4);
            let hint = format!("give rack = {{ tip_radius = {most} }} or less");
            let error = Error::new(Code::OutOfRange, message).with_key("rack.tip_radius");
            return Err(error.with_hint(hint));
        }
        if self.protuberance > self.tip_radius {
            let message = format!(
                "protuberance of {} modules exceeds the tip radius of {} that forms it",
                self.protuberance, self.tip_radius
            );
            let hint = format!("give at most {}", self.tip_radius);
            let error = Error::new(Code::OutOfRange, message).with_key("rack.protuberance");
            return Err(error.with_hint(hint));
        }
        Ok(())
    }
}
