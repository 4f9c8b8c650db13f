//! Transverse outline of a tooth: involute `ψ(r) = s_t/d ± (inv α_t − inv α_yt)` and the fillet that the tool's tip leaves.
//!
//! ψ is the angle of the right flank from the middle of the tooth. The outline is generated with x_E of the mean thickness.

use std::f64::consts::{FRAC_PI_2, PI};

use super::fillet::Fillet;
use super::involute::inv;
use super::member::Member;
use crate::base::bound::Bound;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::kernel::root::sign_change;

/// Places at which the fillet is compared with the involute to bracket their crossing.
const CROSSING_SCAN: usize = 64;

/// Outline of one tooth in the transverse section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothOutline {
    /// Number of teeth.
    pub teeth: u32,
    /// Teeth point inward.
    pub internal: bool,
    /// Base radius, m.
    pub base_radius: f64,
    /// Root radius, m.
    pub root_radius: f64,
    /// Radius where fillet and involute meet, m.
    pub form_radius: f64,
    /// Radius where the outline ends, m: of the tip cylinder, or where the tooth is pointed before it.
    pub tip_radius: f64,
    /// Profile shift coefficient the outline is generated with.
    pub generating_shift: f64,
    /// The fillet cuts off part of the involute.
    pub undercut: bool,
    /// ψ extrapolated to the base circle, rad.
    base_half_angle: f64,
    fillet: Fillet,
    /// θ of the fillet at the form radius.
    fillet_end: f64,
}

impl ToothOutline {
    /// The outline of a checked member.
    ///
    /// # Errors
    /// `OutOfRange`: no involute is left between fillet and tip, or no tool can cut the gear.
    pub fn new(member: &Member) -> Result<ToothOutline, Error> {
        let gear = &member.gear;
        let shift = member.generating_shift(member.mean_thickness_deviation());
        let sense = member.sense();
        let half = member.mean_thickness() / (f64::from(gear.teeth) * gear.module);
        let base_half_angle = half + sense * inv(gear.transverse_pressure_angle());
        let mut outline = ToothOutline {
            teeth: gear.teeth,
            internal: gear.internal,
            base_radius: 0.5 * gear.base_diameter(),
            root_radius: 0.5 * member.root_diameter(shift),
            form_radius: 0.0,
            tip_radius: 0.5 * member.tip_diameter(),
            generating_shift: shift,
            undercut: false,
            base_half_angle,
            fillet: Fillet::new(member, shift)?,
            fillet_end: 0.0,
        };
        outline.check_tip()?;
        outline.end_at_point();
        outline.join_fillet(member)?;
        Ok(outline)
    }

    fn check_tip(&self) -> Result<(), Error> {
        let (tip, base, root) = (self.tip_radius, self.base_radius, self.root_radius);
        if !(root > 0.0) {
            let message = format!(
                "root radius is {:.4} mm: the tool reaches the axis",
                1e3 * root
            );
            return Err(Error::new(Code::OutOfRange, message)
                .about("teeth")
                .with_hint("give more teeth, a larger profile shift or a smaller dedendum"));
        }
        if tip <= base {
            let message = format!(
                "tip diameter {:.4} mm lies inside the base circle of {:.4} mm, where no involute exists",
                2e3 * tip,
                2e3 * base
            );
            let least = Bound::AtLeast(2e3 * base).text(4);
            let hint = format!("give tip_diameter = \"{least} mm\" or more");
            let error = Error::new(Code::OutOfRange, message).about("tip_diameter");
            return Err(error.with_hint(hint));
        }
        if (tip - root) * self.outward() <= 0.0 {
            let message = format!(
                "tip diameter {:.4} mm does not exceed the root diameter of {:.4} mm",
                2e3 * tip,
                2e3 * root
            );
            let (more, bound) = match self.internal {
                true => ("less", Bound::AtMost(2e3 * root)),
                false => ("more", Bound::AtLeast(2e3 * root)),
            };
            let hint = format!("give tip_diameter = \"{} mm\" or {more}", bound.text(4));
            let error = Error::new(Code::OutOfRange, message).about("tip_diameter");
            return Err(error.with_hint(hint));
        }
        Ok(())
    }

    /// Ends the outline at the point of a tooth that is pointed before the tip cylinder.
    fn end_at_point(&mut self) {
        if let Some(pointed) = self.pointed_radius()
            && (self.tip_radius - pointed) * self.outward() > 0.0
        {
            self.tip_radius = pointed;
        }
    }

    /// +1 where the radius grows from root to tip.
    fn outward(&self) -> f64 {
        if self.internal { -1.0 } else { 1.0 }
    }

    /// Radius at which the flanks meet, m; `None` where the base circle comes first (internal teeth).
    pub fn pointed_radius(&self) -> Option<f64> {
        let involute = self.outward() * self.base_half_angle;
        (involute >= 0.0)
            .then(|| self.base_radius / super::involute::angle_from_inv(involute).cos())
    }

    /// Finds where the fillet ends on the involute.
    fn join_fillet(&mut self, member: &Member) -> Result<(), Error> {
        let gear = &member.gear;
        let end = self.fillet.end();
        let cut_off = !gear.internal && member.lowest_roll(self.generating_shift) < 0.0;
        if cut_off || member.rack.protuberance > 0.0 && !gear.internal {
            let parallel = FRAC_PI_2 - gear.pressure_angle;
            let Some(crossing) = self.crossing(cut_off, parallel) else {
                let message = format!(
                    "the fillet of the tooth ({} teeth, x_E {:.4}) leaves no involute below the tip diameter of {:.4} mm",
                    self.teeth,
                    self.generating_shift,
                    2e3 * self.tip_radius
                );
                let hint = match cut_off {
                    true => {
                        let raise = member.least_shift_without_undercut() - self.generating_shift;
                        let least = Bound::AtLeast(gear.profile_shift + raise).text(4);
                        format!("give x ≥ {least}, with which the rack does not undercut")
                    }
                    false => "reduce the protuberance".into(),
                };
                let key = if cut_off {
                    "profile_shift"
                } else {
                    "rack.protuberance"
                };
                let error = Error::new(Code::OutOfRange, message).about(key);
                return Err(error.with_hint(hint));
            };
            self.fillet_end = crossing;
            self.undercut = cut_off;
            self.form_radius = self.fillet.point(crossing)[0];
        } else {
            self.fillet_end = end;
            self.form_radius = self.fillet.point(end)[0];
        }
        if (self.tip_radius - self.form_radius) * self.outward() <= 0.0 {
            let message = format!(
                "tip diameter {:.4} mm leaves no involute: the fillet reaches {:.4} mm",
                2e3 * self.tip_radius,
                2e3 * self.form_radius
            );
            let form = 2e3 * self.form_radius;
            let (more, bound) = match self.internal {
                true => ("less", Bound::AtMost(form)),
                false => ("more", Bound::AtLeast(form)),
            };
            let hint = format!("give tip_diameter = \"{} mm\" or {more}", bound.text(4));
            let error = Error::new(Code::OutOfRange, message).about("tip_diameter");
            return Err(error.with_hint(hint));
        }
        Ok(())
    }

    /// θ where the fillet leaves the metal of the involute, from the end of the rounding downward; `None` where the tip comes first.
    ///
    /// At its end the rounding has cut a gear that it undercuts beyond the involute, and at the base circle into the metal; a protuberance
    /// cuts into it where the rounding is parallel to the flank. So these are the ends of the search. Near the limit of undercut both lie
    /// within ε²/(2 r_b), where ε is the length of roll that is missing, and the depth of ε³/(6 r_b³) is lost in rounding: then the lower
    /// end is the crossing.
    fn crossing(&self, undercut: bool, parallel: f64) -> Option<f64> {
        // Beyond the tip the fillet does not count; with a normal along the pitch line it never comes there.
        let beyond = |radius: f64| move |theta: f64| Some(self.fillet.point(theta)[0] - radius);
        let end = self.fillet.end().min(FRAC_PI_2 * (1.0 - 1e-9));
        let reaches_tip = beyond(self.tip_radius)(end) > Some(0.0);
        let end = match reaches_tip {
            true => sign_change([0.0, end], beyond(self.tip_radius))?,
            false => end,
        };
        let excess = |theta: f64| {
            let [radius, from_space] = self.fillet.point(theta);
            let on_base = self.involute_half_angle(radius.max(self.base_radius));
            PI / f64::from(self.teeth) - from_space - on_base
        };
        if reaches_tip && excess(end) < 0.0 {
            return None;
        }
        // Inside the base circle there is no involute to compare with.
        let is_inside = self.fillet.point(0.0)[0] < self.base_radius;
        let start = match (undercut, is_inside) {
            (true, true) => sign_change([0.0, end], beyond(self.base_radius)).unwrap_or(end),
            (true, false) => 0.0,
            (false, _) => parallel.min(end),
        };
        let place = |i: usize| start + (end - start) * i as f64 / CROSSING_SCAN as f64;
        let leaves = |i: &usize| excess(place(*i)) < 0.0 && excess(place(i + 1)) >= 0.0;
        let piece = (0..CROSSING_SCAN).rev().find(leaves);
        let crossing =
            piece.and_then(|i| sign_change([place(i), place(i + 1)], |theta| Some(excess(theta))));
        Some(crossing.unwrap_or(start))
    }

    /// ψ of the involute at a radius, extended beyond its ends, rad.
    pub(super) fn involute_half_angle(&self, radius: f64) -> f64 {
        let base = self.base_radius;
        let roll = ((radius - base) * (radius + base)).max(0.0).sqrt();
        self.base_half_angle - self.outward() * inv((roll / base).atan())
    }

    /// Angle ψ of the flank from the middle of the tooth at a radius, rad; `None` outside root and tip radius.
    pub fn half_angle(&self, radius: f64) -> Option<f64> {
        let from_root = (radius - self.root_radius) * self.outward();
        let to_tip = (self.tip_radius - radius) * self.outward();
        if !(from_root >= 0.0 && to_tip >= 0.0) {
            return None;
        }
        if (radius - self.form_radius) * self.outward() >= 0.0 {
            return Some(self.involute_half_angle(radius));
        }
        let beyond = |theta: f64| Some(self.fillet.point(theta)[0] - radius);
        let theta = match sign_change([0.0, self.fillet_end], beyond) {
            Some(theta) => theta,
            // A radius at rounding distance from an end of the fillet.
            None if from_root < (self.form_radius - radius).abs() => 0.0,
            None => self.fillet_end,
        };
        Some(self.fillet_point(theta / self.fillet_end)[1])
    }

    /// Transverse thickness along the arc of a radius, m; `None` outside root and tip radius.
    pub fn thickness(&self, radius: f64) -> Option<f64> {
        Some(2.0 * radius * self.half_angle(radius)?)
    }

    /// Radius, m, and ψ, rad, of the fillet at a share of the tool's rounding, 0 at the root circle, 1 at the form radius.
    pub fn fillet_point(&self, share: f64) -> [f64; 2] {
        let [radius, from_space] = self.fillet.point(share * self.fillet_end);
        [radius, PI / f64::from(self.teeth) - from_space]
    }

    /// Radius, m, and ψ, rad, of the involute at a share of its length of roll, 0 at the form radius, 1 at the tip.
    pub fn involute_point(&self, share: f64) -> [f64; 2] {
        let [from, to] = [self.form_radius, self.tip_radius].map(|r| self.roll_length(r));
        let roll = from + share * (to - from);
        let radius = self.base_radius.hypot(roll);
        let involute = inv((roll / self.base_radius).atan());
        [radius, self.base_half_angle - self.outward() * involute]
    }

    /// Length of roll at a radius, m; 0 inside the base circle.
    pub fn roll_length(&self, radius: f64) -> f64 {
        let base = self.base_radius;
        ((radius - base) * (radius + base)).max(0.0).sqrt()
    }

    /// Right flank from the root circle to the tip with the tooth's middle along +y, `[x, y]`, m: `fillet` + `involute` intervals.
    pub fn flank(&self, fillet: usize, involute: usize) -> Vec<[f64; 2]> {
        let share = |i: usize, of: usize| i as f64 / of.max(1) as f64;
        let lower = (0..fillet).map(|i| self.fillet_point(share(i, fillet)));
        let upper = (0..=involute).map(|i| self.involute_point(share(i, involute)));
        lower
            .chain(upper)
            .map(|[radius, psi]| [radius * psi.sin(), radius * psi.cos()])
            .collect()
    }
}
