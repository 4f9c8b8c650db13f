//! Keys of the settings of a face-mill generator: a key of a flank lies over the same key of its gear.

use std::f64::consts::{FRAC_PI_2, PI};

use super::cutter_table::{CutterTable, cutter};
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::base::tables::read_table;
use crate::gear::bevel::blank::Blank;
use crate::gear::bevel::cutter::Cutter;
use crate::gear::bevel::rough_settings::rough_settings;
use crate::gear::bevel::settings::{MachineSettings, Roll};
use crate::gear::bevel::straight::StraightProfile;

/// Process that makes a flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Process {
    /// The work rolls with the cradle.
    Generated,
    /// Cutter and position only.
    Formate,
    /// Straight or skew teeth, with a profile that pitch cone and pressure angle determine.
    Straight(StraightProfile),
}

/// The eccentric of a cradle that names the radial distance: `S_r = 2 K sin(β_e/2)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eccentric {
    /// Machine constant K, m.
    pub machine_constant: f64,
    /// Eccentric angle β_e, rad.
    pub angle: f64,
}

/// A flank as it is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankCut {
    /// Cutter with the blade of the flank.
    pub cutter: Cutter,
    /// Settings of the machine.
    pub settings: MachineSettings,
    /// The eccentric, where the file names it.
    pub eccentric: Option<Eccentric>,
}

/// A flank as its keys describe it, before its blank is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FlankTable {
    /// By settings.
    Settings(FlankCut),
    /// By the cutter and the spiral angle, rad; the settings follow from the blank, without a roll for formate work.
    SpiralAngle {
        /// The cutter.
        cutter: Cutter,
        /// The spiral angle, rad.
        spiral_angle: f64,
        /// Whether the work rolls.
        generated: bool,
    },
}

impl FlankTable {
    /// The flank on its blank.
    pub fn on(&self, blank: &Blank) -> FlankCut {
        match *self {
            FlankTable::Settings(cut) => cut,
            FlankTable::SpiralAngle {
                cutter,
                spiral_angle,
                generated,
            } => {
                let mut settings = rough_settings(blank, &cutter, spiral_angle);
                settings.roll = settings.roll.filter(|_| generated);
                FlankCut {
                    cutter,
                    settings,
                    eccentric: None,
                }
            }
        }
    }
}

/// Keys of settings as written; none where left out.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SettingsTable {
    cutter: CutterTable,
    radial_distance: Option<f64>,
    eccentric_angle: Option<f64>,
    machine_constant: Option<f64>,
    cradle_angle: Option<f64>,
    blank_offset: Option<f64>,
    sliding_base: Option<f64>,
    helical_motion: Option<f64>,
    centre_to_back: Option<f64>,
    machine_root_angle: Option<f64>,
    tilt: Option<f64>,
    swivel: Option<f64>,
    cradle_over_work: Option<f64>,
    work_over_cradle: Option<f64>,
    modified_roll: [Option<f64>; 4],
    spiral_angle: Option<f64>,
}

const ROOT_ANGLE: ValueRange = ValueRange::Open(-FRAC_PI_2, 3.0, "above −90° and below 171°");
const ECCENTRIC_ANGLE: ValueRange = ValueRange::Open(0.0, PI, "above 0° and below 180°");
const SPIRAL_ANGLE: ValueRange = ValueRange::HalfOpen(0.0, 1.2, "at least 0° and below 69°");
const TILT: ValueRange = ValueRange::Open(-1.0, 1.0, "within ±57°");
const ANGLE: ValueRange = ValueRange::Open(-100.0, 100.0, "within ±100 rad");
/// Modified roll, in the keys of setting sheets.
const MODIFIED_ROLL: [&str; 4] = [
    "modified_roll_2C",
    "modified_roll_6D",
    "modified_roll_24E",
    "modified_roll_120F",
];

/// Reads the keys of settings of a table.
pub fn settings(f: &mut TableReader) -> SettingsTable {
    let cutter = read_table(f, "cutter", cutter).unwrap_or_default();
    let length =
        |f: &mut TableReader, key| f.optional_quantity(key, QuantityKind::Length, ValueRange::Any);
    let angle =
        |f: &mut TableReader, key, range| f.optional_quantity(key, QuantityKind::Angle, range);
    f.exclusive("radial_distance", "eccentric_angle");
    f.exclusive("cradle_over_work", "work_over_cradle");
    let table = SettingsTable {
        cutter,
        radial_distance: f.optional_quantity(
            "radial_distance",
            QuantityKind::Length,
            ValueRange::NotNegative,
        ),
        eccentric_angle: angle(f, "eccentric_angle", ECCENTRIC_ANGLE),
        machine_constant: f.optional_quantity(
            "machine_constant",
            QuantityKind::Length,
            ValueRange::Positive,
        ),
        cradle_angle: angle(f, "cradle_angle", ANGLE),
        blank_offset: length(f, "blank_offset"),
        sliding_base: length(f, "sliding_base"),
        helical_motion: length(f, "helical_motion"),
        centre_to_back: length(f, "centre_to_back"),
        machine_root_angle: angle(f, "machine_root_angle", ROOT_ANGLE),
        tilt: angle(f, "tilt", TILT),
        swivel: angle(f, "swivel", ANGLE),
        cradle_over_work: f.optional_number("cradle_over_work", ValueRange::Positive),
        work_over_cradle: f.optional_number("work_over_cradle", ValueRange::Positive),
        modified_roll: MODIFIED_ROLL.map(|key| f.optional_number(key, ValueRange::Any)),
        spiral_angle: angle(f, "spiral_angle", SPIRAL_ANGLE),
    };
    for key in ["cradle_over_work", "work_over_cradle"] {
        let extreme = |ratio: &f64| !(1e-4..1e4).contains(ratio);
        let ratio = [table.cradle_over_work, table.work_over_cradle];
        if f.has(key) && ratio.iter().flatten().any(extreme) {
            let message = format!("`{key}` must be between 1e-4 and 1e4");
            f.report_key(Code::OutOfRange, key, message, "check the ratio of roll");
        }
    }
    table
}

impl SettingsTable {
    /// These keys over those of the gear. A key takes the place of another name of the same setting.
    pub fn over(self, gear: SettingsTable) -> SettingsTable {
        let has_radial = self.radial_distance.or(self.eccentric_angle).is_some();
        let has_ratio = self.cradle_over_work.or(self.work_over_cradle).is_some();
        let unless = |taken: bool, value: Option<f64>| value.filter(|_| !taken);
        SettingsTable {
            cutter: self.cutter.over(gear.cutter),
            radial_distance: (self.radial_distance).or(unless(has_radial, gear.radial_distance)),
            eccentric_angle: (self.eccentric_angle).or(unless(has_radial, gear.eccentric_angle)),
            machine_constant: self.machine_constant.or(gear.machine_constant),
            cradle_angle: self.cradle_angle.or(gear.cradle_angle),
            blank_offset: self.blank_offset.or(gear.blank_offset),
            sliding_base: self.sliding_base.or(gear.sliding_base),
            helical_motion: self.helical_motion.or(gear.helical_motion),
            centre_to_back: self.centre_to_back.or(gear.centre_to_back),
            machine_root_angle: self.machine_root_angle.or(gear.machine_root_angle),
            tilt: self.tilt.or(gear.tilt),
            swivel: self.swivel.or(gear.swivel),
            cradle_over_work: (self.cradle_over_work).or(unless(has_ratio, gear.cradle_over_work)),
            work_over_cradle: (self.work_over_cradle).or(unless(has_ratio, gear.work_over_cradle)),
            modified_roll: [0, 1, 2, 3].map(|k| self.modified_roll[k].or(gear.modified_roll[k])),
            spiral_angle: self.spiral_angle.or(gear.spiral_angle),
        }
    }

    /// A flank takes the machine root angle from the blank.
    pub fn machine_root_angle_is_default(&self, flanks: &[Option<SettingsTable>]) -> bool {
        let own = |flank: &SettingsTable| flank.machine_root_angle.is_some();
        self.machine_root_angle.is_none() && !flanks.iter().flatten().all(own)
    }

    /// The flank that these settings cut; keys that are missing or have no place in the process are noted in the table being read.
    pub fn cut(
        &self,
        f: &mut TableReader,
        side: &str,
        process: Process,
        root_angle: Option<f64>,
    ) -> Option<FlankTable> {
        let cutter = self.cutter.of_flank(f, side);
        let mut complete = true;
        let mut need = |f: &mut TableReader, value: Option<f64>, key: &str, hint: &str| {
            if value.is_none() {
                complete = false;
                let span = f.span.clone();
                let message = format!("the {side} flank of {} has no `{key}`", f.title);
                f.report(Code::MissingKey, message, &span, hint);
            }
            value.unwrap_or(f64::NAN)
        };
        if let Some(spiral_angle) = self.spiral_angle {
            if self.states_settings() {
                let span = f.span.clone();
                let message = format!(
                    "the {side} flank of {} has `spiral_angle` and settings",
                    f.title
                );
                let hint =
                    "`spiral_angle` gives rough settings: omit the settings, or `spiral_angle`";
                f.report(Code::Conflict, message, &span, hint);
                return None;
            }
            return Some(FlankTable::SpiralAngle {
                cutter: cutter?,
                spiral_angle,
                generated: process == Process::Generated,
            });
        }
        let eccentric = self.eccentric_angle.map(|angle| Eccentric {
            angle,
            machine_constant: need(
                f,
                self.machine_constant,
                "machine_constant",
                "`eccentric_angle` needs the machine constant K of S_r = 2 K sin(β_e/2)",
            ),
        });
        let by_eccentric = eccentric.map(|e| 2.0 * e.machine_constant * (0.5 * e.angle).sin());
        let radial_distance = need(
            f,
            by_eccentric.or(self.radial_distance),
            "radial_distance",
            "or `eccentric_angle` with `machine_constant`; without settings give `spiral_angle` only",
        );
        let cradle_angle = need(
            f,
            self.cradle_angle,
            "cradle_angle",
            "the angular position q of the cutter's centre",
        );
        let machine_root_angle = need(
            f,
            self.machine_root_angle.or(root_angle),
            "machine_root_angle",
            "by default the root angle of the blank",
        );
        let ratio = self
            .work_over_cradle
            .or(self.cradle_over_work.map(|x| 1.0 / x));
        let is_modified = self.modified_roll.iter().any(Option::is_some);
        let roll = match process {
            Process::Generated => Some(Roll::from_sheet(
                need(
                    f,
                    ratio,
                    "cradle_over_work",
                    "or `work_over_cradle`, exactly one of them",
                ),
                self.modified_roll.map(Option::unwrap_or_default),
            )),
            Process::Formate | Process::Straight(_) => {
                if ratio.is_some() || is_modified || self.helical_motion.is_some() {
                    complete = false;
                    let span = f.span.clone();
                    let message =
                        format!("the {side} flank of {} is formate and has no roll", f.title);
                    let hint = "omit the ratio of roll, its modification and `helical_motion`, or use process = \"generated\"";
                    f.report(Code::Conflict, message, &span, hint);
                }
                None
            }
        };
        cutter.filter(|_| complete).map(|cutter| {
            FlankTable::Settings(FlankCut {
                cutter,
                settings: MachineSettings {
                    radial_distance,
                    cradle_angle,
                    blank_offset: self.blank_offset.unwrap_or(0.0),
                    sliding_base: self.sliding_base.unwrap_or(0.0),
                    helical_motion: self.helical_motion.unwrap_or(0.0),
                    centre_to_back: self.centre_to_back.unwrap_or(0.0),
                    machine_root_angle,
                    tilt: self.tilt.unwrap_or(0.0),
                    swivel: self.swivel.unwrap_or(0.0),
                    roll,
                },
                eccentric,
            })
        })
    }

    /// Whether anything but the cutter is stated.
    fn states_settings(&self) -> bool {
        let lone = [
            self.radial_distance,
            self.eccentric_angle,
            self.machine_constant,
            self.cradle_angle,
            self.blank_offset,
            self.sliding_base,
            self.helical_motion,
            self.centre_to_back,
            self.machine_root_angle,
            self.tilt,
            self.swivel,
            self.cradle_over_work,
            self.work_over_cradle,
        ];
        lone.iter().chain(&self.modified_roll).any(Option::is_some)
    }

    /// A flank is described by its spiral angle.
    pub fn has_spiral_angle(&self) -> bool {
        self.spiral_angle.is_some()
    }
}
