//! One gear of a pair: involute, basic rack, tip diameter and thickness allowance; `x_E = x + E_sn/(2 m_n tan α_n)`.

use super::basic_rack::BasicRack;
use super::involute::InvoluteGear;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;

/// Names of the members of a pair, in files and messages.
pub const MEMBERS: [&str; 2] = ["pinion", "gear"];

/// A gear as its drawing describes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// Involute and its basic dimensions.
    pub gear: InvoluteGear,
    /// Basic rack, whose tip rounding cuts the fillet.
    pub rack: BasicRack,
    /// Face width, m.
    pub face_width: f64,
    /// Tip diameter, m; by default that of the rack, in a pair shortened so that the bottom clearance is kept.
    pub tip_diameter: Option<f64>,
    /// Lower and upper deviation E_sni, E_sns of the normal thickness at the reference cylinder, m; negative thins the tooth.
    pub thickness_deviation: [f64; 2],
    /// Teeth of the shaper that cuts an internal gear, by default half the teeth of the gear. It has no profile shift, and its tip rounding
    /// is that of the rack where its tooth is wide enough.
    pub shaper_teeth: Option<u32>,
}

impl Member {
    /// A gear of the rack's tooth height, without thickness allowance.
    pub fn new(gear: InvoluteGear, rack: BasicRack, face_width: f64) -> Member {
        Member {
            gear,
            rack,
            face_width,
            tip_diameter: None,
            thickness_deviation: [0.0; 2],
            shaper_teeth: None,
        }
    }

    /// +1 for external teeth, −1 for internal ones: the sense of the tooth's outward direction.
    pub(super) fn sense(&self) -> f64 {
        if self.gear.internal { -1.0 } else { 1.0 }
    }

    /// Tip diameter with the tip alteration coefficient `k`: `d_a = d ± 2 m_n (h_aP + x + k)`.
    pub fn altered_tip_diameter(&self, k: f64) -> f64 {
        let height = self.gear.module * (self.rack.addendum + self.gear.profile_shift + k);
        self.gear.reference_diameter() + 2.0 * self.sense() * height
    }

    /// Tip diameter d_a.
    pub fn tip_diameter(&self) -> f64 {
        self.tip_diameter
            .unwrap_or_else(|| self.altered_tip_diameter(0.0))
    }

    /// Tip alteration coefficient k of the tip diameter.
    pub fn tip_alteration(&self) -> f64 {
        let height = 0.5 * self.sense() * (self.tip_diameter() - self.gear.reference_diameter());
        height / self.gear.module - self.rack.addendum - self.gear.profile_shift
    }

    /// Mean deviation of the normal thickness, m.
    pub fn mean_thickness_deviation(&self) -> f64 {
        0.5 * (self.thickness_deviation[0] + self.thickness_deviation[1])
    }

    /// Normal thickness s_n at the reference cylinder with the mean deviation, m.
    pub fn mean_thickness(&self) -> f64 {
        self.gear.nominal_thickness() + self.mean_thickness_deviation()
    }

    /// Generating profile shift coefficient x_E for a deviation of the normal thickness.
    pub fn generating_shift(&self, deviation: f64) -> f64 {
        let tangent = self.gear.pressure_angle.tan();
        self.gear.profile_shift + deviation / (2.0 * self.gear.module * tangent)
    }

    /// Root diameter generated with a profile shift coefficient: `d_f = d ∓ 2 m_n (h_fP − x)`; with x the nominal d_f, with x_E the
    /// generated d_fE.
    pub fn root_diameter(&self, shift: f64) -> f64 {
        let depth = self.gear.module * (self.rack.dedendum - shift);
        self.gear.reference_diameter() - 2.0 * self.sense() * depth
    }

    /// Diameter where the straight flank of the rack ends its involute, without protuberance:
    /// `d_Ff² = (d sin α_t − 2 m_n (h_fP − x − ρ_fP (1 − sin α_n))/sin α_t)² + d_b²`; `None` where the gear is undercut, and of internal gears.
    pub fn root_form_diameter(&self, shift: f64) -> Option<f64> {
        let roll = self.lowest_roll(shift);
        (roll >= 0.0 && !self.gear.internal).then(|| self.gear.diameter_at_roll(roll))
    }

    /// Length of roll of the last involute point of an external gear; negative where the rack undercuts.
    pub(super) fn lowest_roll(&self, shift: f64) -> f64 {
        let gear = &self.gear;
        let sine = gear.transverse_pressure_angle().sin();
        let depth = gear.module * (self.rack.straight_depth(gear.pressure_angle) - shift);
        0.5 * gear.reference_diameter() * sine - depth / sine
    }

    /// Least generating profile shift coefficient without undercut by the rack:
    /// `x_E,min = h_fP − ρ_fP (1 − sin α_n) − z sin² α_t/(2 cos β)`.
    pub fn least_shift_without_undercut(&self) -> f64 {
        let sine = self.gear.transverse_pressure_angle().sin();
        let reach = f64::from(self.gear.teeth) * sine * sine / (2.0 * self.gear.helix.cos());
        self.rack.straight_depth(self.gear.pressure_angle) - reach
    }

    /// # Errors
    /// `OutOfRange`: a value no gear has.
    pub fn check(&self) -> Result<(), Error> {
        let gear = &self.gear;
        let out_of_range =
            |key: &str, message: String| Err(Error::new(Code::OutOfRange, message).with_key(key));
        if gear.teeth < 2 {
            let message = format!("{} teeth (minimum 2)", gear.teeth);
            return out_of_range("teeth", message);
        }
        let in_range = [
            ("module", gear.module, 0.0, 10.0, "m"),
            (
                "pressure_angle",
                gear.pressure_angle.to_degrees(),
                0.0,
                60.0,
                "deg",
            ),
            ("face_width", self.face_width, 0.0, 1e3, "m"),
        ];
        for (key, value, least, most, unit) in in_range {
            if !(value > least && value <= most) {
                let name = key.replace('_', " ");
                let message = format!(
                    "{name} is {value} {unit}; it must be above {least} and at most {most} {unit}"
                );
                let error = Error::new(Code::OutOfRange, message).with_key(key);
                return Err(error.with_hint("check the value and its unit"));
            }
        }
        let helix = gear.helix.to_degrees();
        if !(helix.abs() <= 80.0) {
            let message = format!("helix angle is {helix} deg (limits ±80 deg)");
            return out_of_range("helix_angle", message);
        }
        if !(gear.profile_shift.abs() <= 10.0) {
            let shift = gear.profile_shift;
            let message = format!("profile shift coefficient is {shift} (limits ±10)");
            return out_of_range("profile_shift", message);
        }
        let [lower, upper] = self.thickness_deviation;
        if !(lower <= upper && lower.is_finite() && upper.is_finite()) {
            let message = format!(
                "thickness deviations are {} and {} µm; give the lower one first",
                format_number(1e6 * lower),
                format_number(1e6 * upper)
            );
            return out_of_range("thickness", message);
        }
        let nominal = gear.nominal_thickness();
        if !(nominal + lower > 0.0) {
            let message = format!(
                "no tooth is left: its normal thickness at the reference cylinder is {:.4} mm, and the lower deviation {:.4} mm",
                1e3 * nominal,
                1e3 * lower
            );
            let key = if lower < 0.0 {
                "thickness"
            } else {
                "profile_shift"
            };
            let error = Error::new(Code::OutOfRange, message).with_key(key);
            return Err(error
                .with_hint("give a thickness deviation nearer to 0, or a larger profile shift"));
        }
        if let Some(tip) = self.tip_diameter
            && !(tip > 0.0 && tip.is_finite())
        {
            let tip = format_number(1e3 * tip);
            return out_of_range(
                "tip_diameter",
                format!("tip diameter is {tip} mm; it must be positive"),
            );
        }
        self.rack.check(gear.pressure_angle)
    }
}
