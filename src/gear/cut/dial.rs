//! Dials of a generator: settings as the machine shows them, with the steps to which it can be set.

use super::setting::{FlankSetup, Setting, SettingKind};

/// A dial, or a dimension of the cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dial {
    /// A setting shown as it is.
    Setting(Setting),
    /// Profile radius of a curved blade, m.
    ProfileRadius,
    /// Eccentric angle β_e of the machine constant K, `S_r = 2 K sin(β_e/2)`, rad.
    EccentricAngle {
        /// Machine constant K, m.
        machine_constant: f64,
    },
    /// Tilt i, rad.
    Tilt,
    /// Swivel j, rad.
    Swivel,
    /// Ratio of roll, cradle over work.
    CradleOverWork,
}

/// Steps of the dials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DialSteps {
    /// Step of lengths, m.
    pub length: f64,
    /// Step of angles, rad.
    pub angle: f64,
    /// Step of the ratio of roll and of the coefficients of its modification.
    pub ratio: f64,
}

impl Dial {
    /// The dials that show a setting.
    pub fn of(setting: Setting, machine_constant: Option<f64>) -> Vec<Dial> {
        match (setting, machine_constant) {
            (Setting::RadialDistance, Some(machine_constant)) => {
                vec![Dial::EccentricAngle { machine_constant }]
            }
            (Setting::ProfileCurvature, _) => vec![Dial::ProfileRadius],
            (Setting::TiltCosine | Setting::TiltSine, _) => vec![Dial::Tilt, Dial::Swivel],
            (Setting::Ratio, _) => vec![Dial::CradleOverWork],
            (setting, _) => vec![Dial::Setting(setting)],
        }
    }

    /// Whether it shows a setting, by itself or with other dials.
    pub fn shows(self, setting: Setting) -> bool {
        let constant = match self {
            Dial::EccentricAngle { machine_constant } => Some(machine_constant),
            _ => None,
        };
        Dial::of(setting, constant).contains(&self)
    }

    /// Whether it is a dimension of the cutter.
    pub fn is_of_cutter(self) -> bool {
        match self {
            Dial::Setting(setting) => setting.is_of_cutter(),
            dial => dial == Dial::ProfileRadius,
        }
    }

    /// Kind of its number.
    pub fn kind(self) -> SettingKind {
        match self {
            Dial::Setting(setting) => setting.kind(),
            Dial::ProfileRadius => SettingKind::Length,
            Dial::EccentricAngle { .. } | Dial::Tilt | Dial::Swivel => SettingKind::Angle,
            Dial::CradleOverWork => SettingKind::Ratio,
        }
    }

    /// The value that it shows, m, rad or a bare number.
    pub fn value(self, setup: &FlankSetup) -> f64 {
        match self {
            Dial::Setting(setting) => setup.value(setting),
            Dial::ProfileRadius => 1.0 / setup.value(Setting::ProfileCurvature),
            Dial::EccentricAngle { machine_constant } => {
                2.0 * (setup.machine.radial_distance / (2.0 * machine_constant)).asin()
            }
            Dial::Tilt => setup.machine.tilt,
            Dial::Swivel => setup.machine.swivel,
            Dial::CradleOverWork => 1.0 / setup.value(Setting::Ratio),
        }
    }

    /// The setup with the dial at a value, m, rad or a bare number.
    pub fn set(self, mut setup: FlankSetup, value: f64) -> FlankSetup {
        match self {
            Dial::Setting(setting) => return setup.with(setting, value),
            Dial::ProfileRadius => return setup.with(Setting::ProfileCurvature, 1.0 / value),
            Dial::EccentricAngle { machine_constant } => {
                setup.machine.radial_distance = 2.0 * machine_constant * (0.5 * value).sin();
            }
            Dial::Tilt => setup.machine.tilt = value,
            Dial::Swivel => setup.machine.swivel = value,
            Dial::CradleOverWork => return setup.with(Setting::Ratio, 1.0 / value),
        }
        setup
    }

    /// The step of the dial, m, rad or a bare number.
    pub fn step(self, steps: &DialSteps) -> f64 {
        match self.kind() {
            SettingKind::Length => steps.length,
            SettingKind::Angle => steps.angle,
            SettingKind::Ratio => steps.ratio,
        }
    }
}
