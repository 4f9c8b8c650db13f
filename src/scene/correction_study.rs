//! Reads `[correction]` of a bevel file: measured member, settings that may be changed, steps of the dials.

use std::f64::consts::PI;

use super::machine_settings::Process;
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::{TableReader, Word};
use crate::base::text::suggestion;
use crate::gear::cut::dial::DialSteps;
use crate::gear::cut::setting::Setting;

/// Options of a correction of machine settings from a measured flank.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionStudy {
    /// Measured member.
    pub member: Member,
    /// Measured flank, where only one is used.
    pub flank: Option<FlankSide>,
    /// Settings that may be changed; empty where the process decides.
    pub settings: Vec<Setting>,
    /// Steps of the dials.
    pub steps: DialSteps,
    /// Least root mean square by which a direction of settings must move the flank to be used, m.
    pub least: f64,
}

/// A member of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Member {
    /// Pinion.
    #[default]
    Pinion,
    /// Gear.
    Gear,
}

impl Word for Member {
    const WORDS: &'static [(&'static str, Member, &'static str)] = &[
        ("pinion", Member::Pinion, "The pinion"),
        ("gear", Member::Gear, "The gear"),
    ];
}

impl Member {
    /// Index: 0 pinion, 1 gear.
    pub fn index(self) -> usize {
        usize::from(self == Member::Gear)
    }
}

/// A flank of a bevel tooth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlankSide {
    /// Concave.
    Concave,
    /// Convex.
    Convex,
}

impl Word for FlankSide {
    const WORDS: &'static [(&'static str, FlankSide, &'static str)] = &[
        ("concave", FlankSide::Concave, "The concave flank"),
        ("convex", FlankSide::Convex, "The convex flank"),
    ];
}

impl FlankSide {
    /// Index: 0 concave, 1 convex.
    pub fn index(self) -> usize {
        usize::from(self == FlankSide::Convex)
    }
}

/// Names of what may be changed, with their settings.
pub const SETTINGS: &[(&str, &[Setting])] = &[
    ("point_radius", &[Setting::PointRadius]),
    ("blade_angle", &[Setting::BladeAngle]),
    ("profile_radius", &[Setting::ProfileCurvature]),
    ("radial_distance", &[Setting::RadialDistance]),
    ("cradle_angle", &[Setting::CradleAngle]),
    ("blank_offset", &[Setting::BlankOffset]),
    ("sliding_base", &[Setting::SlidingBase]),
    ("helical_motion", &[Setting::HelicalMotion]),
    ("centre_to_back", &[Setting::CentreToBack]),
    ("machine_root_angle", &[Setting::MachineRootAngle]),
    ("tilt", &[Setting::TiltCosine, Setting::TiltSine]),
    ("cradle_over_work", &[Setting::Ratio]),
    ("modified_roll_2C", &[Setting::ModifiedRoll(0)]),
    ("modified_roll_6D", &[Setting::ModifiedRoll(1)]),
    ("modified_roll_24E", &[Setting::ModifiedRoll(2)]),
    ("modified_roll_120F", &[Setting::ModifiedRoll(3)]),
];

/// Settings that may be changed by default: those of every machine, without the cutter.
const DEFAULT_SETTINGS: [Setting; 7] = [
    Setting::RadialDistance,
    Setting::CradleAngle,
    Setting::BlankOffset,
    Setting::SlidingBase,
    Setting::CentreToBack,
    Setting::MachineRootAngle,
    Setting::Ratio,
];

/// Steps of dials by default: scales of mechanical generators read to 1′ and 0.01 mm, change gears meet a ratio to 1e-6.
const STEPS: DialSteps = DialSteps {
    length: 1e-5,
    angle: PI / 10_800.0,
    ratio: 1e-6,
};

/// Least displacement by default, m: below the repeatability of coordinate-measuring machines.
const LEAST: f64 = 5e-8;

/// Keys of `[correction]`, each with a flag.
pub fn correction(f: &mut TableReader) -> CorrectionStudy {
    let step =
        |f: &mut TableReader, key, kind| f.optional_quantity(key, kind, ValueRange::Positive);
    CorrectionStudy {
        member: f.word("member").unwrap_or_default(),
        flank: f.word("flank"),
        settings: settings(f),
        steps: DialSteps {
            length: step(f, "length_step", QuantityKind::Length).unwrap_or(STEPS.length),
            angle: step(f, "angle_step", QuantityKind::Angle).unwrap_or(STEPS.angle),
            ratio: f
                .optional_number("ratio_step", ValueRange::Positive)
                .unwrap_or(STEPS.ratio),
        },
        least: step(f, "least", QuantityKind::Length).unwrap_or(LEAST),
    }
}

fn settings(f: &mut TableReader) -> Vec<Setting> {
    let mut all = Vec::new();
    let names = f.texts("settings");
    if names.is_empty() && f.has("settings") {
        let message = "`settings` is empty";
        let hint = "name the settings to change, or omit `settings`";
        f.report_key(Code::OutOfRange, "settings", message, hint);
    }
    for name in names {
        let known = SETTINGS.iter().find(|(word, _)| *word == name);
        let Some((_, settings)) = known else {
            let words = || SETTINGS.iter().map(|(word, _)| *word);
            let message = format!("`settings` cannot have \"{name}\"");
            let meant = suggestion(&name, words())
                .map_or(String::new(), |word| format!("did you mean \"{word}\"? "));
            let hint = format!("{meant}it takes {}", words().collect::<Vec<_>>().join(", "));
            f.report_key(Code::OutOfRange, "settings", message, &hint);
            continue;
        };
        all.extend(
            settings
                .iter()
                .filter(|s| !all.contains(*s))
                .collect::<Vec<_>>(),
        );
    }
    all
}

impl CorrectionStudy {
    /// Settings that may be changed for work of a process.
    ///
    /// # Errors
    /// Settings that the process does not have, by name.
    pub fn settings_of(&self, process: Process) -> Result<Vec<Setting>, &'static str> {
        let rolls = process == Process::Generated;
        let fits = |setting: &Setting| rolls || !setting.needs_roll();
        if self.settings.is_empty() {
            return Ok(DEFAULT_SETTINGS.into_iter().filter(fits).collect());
        }
        match self.settings.iter().find(|setting| !fits(setting)) {
            Some(setting) => Err(setting_name(*setting)),
            None => Ok(self.settings.clone()),
        }
    }
}

/// The name of a setting in files.
pub fn setting_name(setting: Setting) -> &'static str {
    let found = SETTINGS
        .iter()
        .find(|(_, settings)| settings.contains(&setting));
    found.map_or("", |(name, _)| name)
}
