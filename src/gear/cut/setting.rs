//! Settings of a face-mill generator as the numbers that a correction varies.
//!
//! Tilt i and swivel j are varied as `i cos j` and `i sin j`: at i = 0 the swivel moves nothing.

use crate::gear::bevel::cutter::Cutter;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::settings::{MachineSettings, Roll};
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::hand::Hand;

/// A number of the cutter or of the machine that moves the flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// Point radius of the cutter, m.
    PointRadius,
    /// Blade angle of the cutter, rad.
    BladeAngle,
    /// Curvature of the blade's profile, 1/m.
    ProfileCurvature,
    /// Radial distance, m.
    RadialDistance,
    /// Cradle angle, rad.
    CradleAngle,
    /// Blank offset, m.
    BlankOffset,
    /// Sliding base, m.
    SlidingBase,
    /// Sliding base for a radian of the cradle, m.
    HelicalMotion,
    /// Machine centre to back, m.
    CentreToBack,
    /// Machine root angle, rad.
    MachineRootAngle,
    /// `i cos j` of tilt i and swivel j, rad.
    TiltCosine,
    /// `i sin j` of tilt i and swivel j, rad.
    TiltSine,
    /// Ratio of roll, work over cradle.
    Ratio,
    /// Coefficient of the modified roll as on setting sheets: 2C, 6D, 24E, 120F by index.
    ModifiedRoll(usize),
}

/// Kind of a setting's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SettingKind {
    /// Length, m.
    Length,
    /// Angle, rad.
    Angle,
    /// Number without a unit.
    Ratio,
}

/// Factors of the modified roll's coefficients on setting sheets: 2C, 6D, 24E, 120F.
pub const SHEET_FACTORS: [f64; 4] = [2.0, 6.0, 24.0, 120.0];

impl Setting {
    /// Every setting.
    pub const ALL: [Setting; 17] = [
        Setting::PointRadius,
        Setting::BladeAngle,
        Setting::ProfileCurvature,
        Setting::RadialDistance,
        Setting::CradleAngle,
        Setting::BlankOffset,
        Setting::SlidingBase,
        Setting::HelicalMotion,
        Setting::CentreToBack,
        Setting::MachineRootAngle,
        Setting::TiltCosine,
        Setting::TiltSine,
        Setting::Ratio,
        Setting::ModifiedRoll(0),
        Setting::ModifiedRoll(1),
        Setting::ModifiedRoll(2),
        Setting::ModifiedRoll(3),
    ];

    /// Whether the number belongs to the cutter and not to the machine.
    pub fn is_of_cutter(self) -> bool {
        matches!(
            self,
            Setting::PointRadius | Setting::BladeAngle | Setting::ProfileCurvature
        )
    }

    /// Whether the number exists only for work that rolls with the cradle.
    pub fn needs_roll(self) -> bool {
        matches!(
            self,
            Setting::Ratio | Setting::ModifiedRoll(_) | Setting::HelicalMotion
        )
    }

    /// Kind of the number that its dial shows: a profile has its radius there.
    pub fn kind(self) -> SettingKind {
        match self {
            Setting::PointRadius
            | Setting::ProfileCurvature
            | Setting::RadialDistance
            | Setting::BlankOffset
            | Setting::SlidingBase
            | Setting::HelicalMotion
            | Setting::CentreToBack => SettingKind::Length,
            Setting::BladeAngle
            | Setting::CradleAngle
            | Setting::MachineRootAngle
            | Setting::TiltCosine
            | Setting::TiltSine => SettingKind::Angle,
            Setting::Ratio | Setting::ModifiedRoll(_) => SettingKind::Ratio,
        }
    }
}

/// Cutter and machine as they are set for one flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankSetup {
    /// Cutter.
    pub cutter: Cutter,
    /// Machine.
    pub machine: MachineSettings,
}

impl FlankSetup {
    /// The flank that this cuts.
    pub fn flank(&self, hand: Hand, section: ToothSection) -> BevelFlank {
        BevelFlank::new(&self.cutter, &self.machine, hand, section)
    }

    /// Value of a setting, m, rad or a bare number; 0 where a formate machine has none.
    pub fn value(&self, setting: Setting) -> f64 {
        let m = &self.machine;
        let of_roll = |value: &dyn Fn(&Roll) -> f64| m.roll.as_ref().map_or(0.0, value);
        match setting {
            Setting::PointRadius => self.cutter.point_radius,
            Setting::BladeAngle => self.cutter.blade_angle,
            Setting::ProfileCurvature => self.cutter.profile_curvature,
            Setting::RadialDistance => m.radial_distance,
            Setting::CradleAngle => m.cradle_angle,
            Setting::BlankOffset => m.blank_offset,
            Setting::SlidingBase => m.sliding_base,
            Setting::HelicalMotion => m.helical_motion,
            Setting::CentreToBack => m.centre_to_back,
            Setting::MachineRootAngle => m.machine_root_angle,
            Setting::TiltCosine => m.tilt * m.swivel.cos(),
            Setting::TiltSine => m.tilt * m.swivel.sin(),
            Setting::Ratio => of_roll(&|roll| roll.work_over_cradle),
            Setting::ModifiedRoll(k) => of_roll(&|roll| SHEET_FACTORS[k] * roll.modification[k]),
        }
    }

    /// The same with a setting at a value; unchanged where a formate machine has no such setting.
    pub fn with(mut self, setting: Setting, value: f64) -> FlankSetup {
        let m = &mut self.machine;
        match setting {
            Setting::PointRadius => self.cutter.point_radius = value,
            Setting::BladeAngle => self.cutter.blade_angle = value,
            Setting::ProfileCurvature => self.cutter.profile_curvature = value,
            Setting::RadialDistance => m.radial_distance = value,
            Setting::CradleAngle => m.cradle_angle = value,
            Setting::BlankOffset => m.blank_offset = value,
            Setting::SlidingBase => m.sliding_base = value,
            Setting::HelicalMotion => m.helical_motion = value,
            Setting::CentreToBack => m.centre_to_back = value,
            Setting::MachineRootAngle => m.machine_root_angle = value,
            Setting::TiltCosine => m.set_tilt([value, m.tilt * m.swivel.sin()]),
            Setting::TiltSine => m.set_tilt([m.tilt * m.swivel.cos(), value]),
            Setting::Ratio => {
                if let Some(roll) = &mut m.roll {
                    roll.work_over_cradle = value;
                }
            }
            Setting::ModifiedRoll(k) => {
                if let Some(roll) = &mut m.roll {
                    roll.modification[k] = value / SHEET_FACTORS[k];
                }
            }
        }
        self
    }

    /// The same with a setting changed by an amount.
    pub fn changed(self, setting: Setting, by: f64) -> FlankSetup {
        self.with(setting, self.value(setting) + by)
    }
}

impl MachineSettings {
    /// Sets tilt and swivel from `[i cos j, i sin j]`. The swivel of an untilted cutter stays, and so does the sign of a tilt.
    fn set_tilt(&mut self, [cosine, sine]: [f64; 2]) {
        let tilt = f64::hypot(cosine, sine);
        if tilt > 0.0 {
            let sign = if self.tilt < 0.0 { -1.0 } else { 1.0 };
            self.tilt = sign * tilt;
            self.swivel = (sign * sine).atan2(sign * cosine);
        } else {
            self.tilt = 0.0;
        }
    }
}
