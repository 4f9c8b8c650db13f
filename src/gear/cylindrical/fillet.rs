//! Fillet as the envelope of the rounded tip of a tool: where the rounding's normal passes the pitch point it touches the gear.
//!
//! Both tools are described in the transverse plane by the angle θ of the rounding's normal from the middle of the tool's tooth: 0 at the
//! root circle. A point of the fillet is its radius and its angle from the middle of the tooth space.

use super::involute::{angle_from_inv, inv};
use super::member::Member;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::kernel::root::sign_change;

/// A tool with a rounded tip in mesh with the gear it cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Fillet {
    /// Rack on the reference circle of an external gear.
    Rack(RackTip),
    /// Shaper inside an internal gear.
    Shaper(ShaperTip),
}

/// Tip of a rack in the normal section, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RackTip {
    /// Reference radius of the gear.
    reference: f64,
    /// Centre of the rounding: from the middle of the tool's tooth, and above the reference circle of the gear.
    centre: [f64; 2],
    /// Radius of the rounding.
    radius: f64,
    /// Cosine of the helix angle.
    helix_cosine: f64,
    /// θ where the rounding meets the straight flank.
    end: f64,
}

/// Tip of a shaper in the transverse section, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ShaperTip {
    /// Pitch radii of shaper and gear.
    pitch: [f64; 2],
    /// Radius on which the rounding's centre moves, and its angle from the middle of the shaper's tooth.
    centre: [f64; 2],
    /// Radius of the rounding.
    radius: f64,
    /// Turns of the gear for one of the shaper.
    ratio: f64,
    /// θ where the rounding meets the involute of the shaper: the line of action.
    end: f64,
}

impl Fillet {
    /// The fillet of a member generated with the profile shift coefficient `shift`.
    ///
    /// # Errors
    /// `OutOfRange`: a shaper that does not fit into the gear or has no tooth of that height.
    pub fn new(member: &Member, shift: f64) -> Result<Fillet, Error> {
        match member.gear.internal {
            false => Ok(Fillet::Rack(RackTip::new(member, shift))),
            true => Ok(Fillet::Shaper(ShaperTip::new(member, shift)?)),
        }
    }

    /// θ where the rounding ends.
    pub fn end(&self) -> f64 {
        match self {
            Fillet::Rack(rack) => rack.end,
            Fillet::Shaper(shaper) => shaper.end,
        }
    }

    /// Radius, m, and angle from the middle of the space, rad, of the point that the rounding's point θ leaves.
    pub fn point(&self, theta: f64) -> [f64; 2] {
        match self {
            Fillet::Rack(rack) => rack.point(theta),
            Fillet::Shaper(shaper) => shaper.point(theta),
        }
    }
}

impl RackTip {
    fn new(member: &Member, shift: f64) -> RackTip {
        let gear = &member.gear;
        let [aside, depth] = member.rack.rounding_centre(gear.pressure_angle);
        RackTip {
            reference: 0.5 * gear.reference_diameter(),
            centre: [gear.module * aside, gear.module * (shift - depth)],
            radius: gear.module * member.rack.tip_radius,
            helix_cosine: gear.helix.cos(),
            end: member.rack.rounding_end(gear.pressure_angle),
        }
    }

    fn point(&self, theta: f64) -> [f64; 2] {
        let (sine, cosine) = theta.sin_cos();
        let height = self.centre[1] - self.radius * cosine;
        let aside = (self.centre[0] + self.radius * sine) / self.helix_cosine;
        // The normal of the transverse section meets the pitch line this far beyond the point.
        let beyond = height * sine / cosine * self.helix_cosine;
        let out = self.reference + height;
        let turn = (aside + beyond) / self.reference;
        [out.hypot(beyond), (-beyond).atan2(out) + turn]
    }
}

impl ShaperTip {
    fn new(member: &Member, shift: f64) -> Result<ShaperTip, Error> {
        let all = member.gear.teeth;
        let teeth = member.shaper_teeth.unwrap_or((all / 2).max(1));
        ShaperTip::of_teeth(member, shift, teeth).map_err(|why| {
            let message =
                format!("a shaper of {teeth} teeth cannot cut {all} internal teeth: {why}");
            let mut nearest: Vec<u32> = (1..all).collect();
            nearest.sort_by_key(|z| z.abs_diff(teeth));
            let can_cut = |z: &u32| ShaperTip::of_teeth(member, shift, *z).is_ok();
            let hint = match nearest.into_iter().find(can_cut) {
                Some(z) => format!("shaper_teeth = {z} cuts them"),
                None => "no shaper cuts them: give a profile shift nearer to 0 or another dedendum"
                    .into(),
            };
            let error = Error::new(Code::OutOfRange, message).with_key("shaper_teeth");
            error.with_hint(hint)
        })
    }

    /// The tip of a shaper of so many teeth, or why it cannot cut the gear.
    fn of_teeth(member: &Member, shift: f64, teeth: u32) -> Result<ShaperTip, &'static str> {
        let gear = &member.gear;
        if teeth >= gear.teeth {
            return Err("it does not fit inside");
        }
        let ratio = f64::from(teeth) / f64::from(gear.teeth);
        let base = 0.5 * gear.base_diameter();
        let tangent = gear.pressure_angle.tan();
        let reference_involute = inv(gear.transverse_pressure_angle());
        let difference = f64::from(gear.teeth - teeth);
        let involute = reference_involute - 2.0 * shift * tangent / difference;
        let angle = angle_from_inv(involute);
        if !angle.is_finite() {
            return Err("their flanks have no common working pressure angle");
        }
        let pitch = [ratio * base / angle.cos(), base / angle.cos()];
        let tip = 0.5 * member.root_diameter(shift) - (pitch[1] - pitch[0]);
        let own_base = ratio * base;
        if !(tip > own_base) {
            return Err("its tip circle lies inside its base circle");
        }
        // Length of roll of a rounding's centre and its angle from the middle of the shaper's tooth: on the involute moved inward.
        let roll = |radius: f64| {
            let centre = (tip - radius).max(own_base);
            ((centre - own_base) * (centre + own_base)).sqrt()
        };
        let half = std::f64::consts::FRAC_PI_2 / f64::from(teeth) + reference_involute;
        let aside = |radius: f64| half - radius / own_base - inv((roll(radius) / own_base).atan());
        if !(aside(0.0) >= 0.0) {
            return Err("its flanks intersect below its tip");
        }
        // No larger than a full rounding.
        let wanted = (gear.module * member.rack.tip_radius).min(tip - own_base);
        let radius = sign_change([0.0, wanted], |radius| Some(aside(radius))).unwrap_or(wanted);
        let (centre, aside, roll) = (tip - radius, aside(radius).max(0.0), roll(radius));
        if !(roll >= own_base * angle.tan()) {
            return Err("its tip rounding does not reach beyond the pitch point");
        }
        Ok(ShaperTip {
            pitch,
            centre: [centre, aside],
            radius,
            ratio,
            end: std::f64::consts::FRAC_PI_2 - angle,
        })
    }

    fn point(&self, theta: f64) -> [f64; 2] {
        let (sine, cosine) = theta.sin_cos();
        let [own_pitch, pitch] = self.pitch;
        let [arm, aside] = self.centre;
        // From the pitch point along the normal to the rounding's centre.
        let reach =
            ((arm - own_pitch * sine) * (arm + own_pitch * sine)).sqrt() - own_pitch * cosine;
        let turn = (reach * sine).atan2(own_pitch + reach * cosine) - aside;
        let touch = reach + self.radius;
        let (across, out) = (touch * sine, pitch + touch * cosine);
        [out.hypot(across), across.atan2(out) - self.ratio * turn]
    }
}
