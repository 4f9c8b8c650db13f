//! Studies of modes, state-space forms and reduced machines.

use std::f64::consts::TAU;

use super::{ReadStudy, SpeedRange};
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::{TableReader, Word};
use crate::scene::shared_keys::MAX_COUNT;

/// Options of the modes of a machine, as the command has them.
#[derive(Debug, Clone, Default)]
pub struct ModesStudy {
    /// Damping counts.
    pub damped: bool,
    /// Speed of the first node of `[speed]`, rad/s.
    pub speed: Option<f64>,
    /// Speeds of a Campbell diagram.
    pub campbell: Option<SpeedRange>,
    /// Only so many modes, from the lowest.
    pub lowest: Option<u32>,
    /// The modes nearest to this frequency, rad/s.
    pub near: Option<f64>,
    /// The state-space form.
    pub state_space: Option<StateSpaceStudy>,
    /// A reduced machine.
    pub reduce: Option<ReductionStudy>,
}

impl ReadStudy for ModesStudy {
    const KIND: &'static str = "modes";

    fn read(f: &mut TableReader) -> ModesStudy {
        f.exclusive("speed", "campbell");
        f.exclusive("near", "campbell");
        ModesStudy {
            damped: f.flag("damped"),
            speed: f.optional_quantity("speed", QuantityKind::Speed, ValueRange::Any),
            campbell: f.parsed("campbell", SpeedRange::parse),
            lowest: f.optional_count("lowest", 1, MAX_COUNT),
            near: f.optional_quantity("near", QuantityKind::Frequency, ValueRange::NotNegative),
            state_space: StateSpaceStudy::read(f),
            reduce: ReductionStudy::read(f),
        }
    }
}

/// Which state-space form is wanted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StateSpaceStudy {
    /// `node.axis` each; all degrees of freedom where none is named.
    pub inputs: Vec<String>,
    /// `node.axis`, `node.axis.speed`, `node.axis.acceleration` or `branch.force` each; all degrees of freedom where none is
    /// named.
    pub outputs: Vec<String>,
    /// Between samples, s; absent: continuous.
    pub sample_time: Option<f64>,
    /// Hold of the inputs between samples.
    pub method: InputHold,
}

impl StateSpaceStudy {
    /// Reads its keys.
    fn read(f: &mut TableReader) -> Option<StateSpaceStudy> {
        let requested = f.flag("state_space");
        let study = StateSpaceStudy {
            inputs: f.texts("input"),
            outputs: f.texts("output"),
            sample_time: f.optional_quantity(
                "sample_time",
                QuantityKind::Time,
                ValueRange::Positive,
            ),
            method: f.word("hold").unwrap_or_default(),
        };
        for key in ["input", "output", "sample_time"] {
            f.requires(key, "state_space");
        }
        f.requires("hold", "sample_time");
        requested.then_some(study)
    }
}

/// Assumed inputs between samples: the discretisation method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InputHold {
    /// It stays: exact for steps at samples.
    #[default]
    Zero,
    /// It goes straight to the next sample: exact for ramps. States are shifted by what the coming sample adds, outputs not.
    First,
    /// Tustin's rule: the trapezoidal rule in time. Stable forms stay stable; frequencies are warped, states are not the continuous ones.
    Bilinear,
}

impl InputHold {
    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            InputHold::Zero => "zero-order",
            InputHold::First => "first-order",
            InputHold::Bilinear => "bilinear",
        }
    }
}

impl Word for InputHold {
    const WORDS: &'static [(&'static str, InputHold, &'static str)] = &[
        ("zero", InputHold::Zero, "Inputs are held constant"),
        (
            "first",
            InputHold::First,
            "Inputs change linearly to the next sample",
        ),
        ("bilinear", InputHold::Bilinear, "Tustin's rule"),
    ];
}

/// Which reduced machine is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct ReductionStudy {
    /// Reduction method.
    pub method: ReductionKind,
    /// Degrees of freedom kept, loaded and measured, `node.axis` each.
    pub keep: Vec<String>,
    /// The response matters up to here, Hz.
    pub max_frequency_hz: f64,
    /// Modes kept; absent: those below twice the band.
    pub modes: Option<u32>,
}

impl ReductionStudy {
    /// Reads its keys.
    fn read(f: &mut TableReader) -> Option<ReductionStudy> {
        let hertz = |f: &mut TableReader, key: &str| {
            let omega = f.optional_quantity(key, QuantityKind::Frequency, ValueRange::Positive);
            omega.map(|omega| omega / TAU)
        };
        let method = f.word("reduce");
        let (below, at) = (hertz(f, "below"), hertz(f, "condense_at"));
        let (keep, modes) = (
            f.texts("keep"),
            f.optional_count("keep_modes", 0, MAX_COUNT),
        );
        for key in ["keep", "below", "condense_at", "keep_modes"] {
            f.requires(key, "reduce");
        }
        for key in ["keep", "below"] {
            f.requires("reduce", key);
        }
        let method = match (method?, at) {
            (ReductionKind::Dynamic(_), Some(hz)) => ReductionKind::Dynamic(hz),
            (ReductionKind::Dynamic(_), None) => {
                f.report_missing("condense_at", ", where `reduce = \"dynamic\"` condenses");
                return None;
            }
            (other, None) => other,
            (_, Some(_)) => {
                let message = "`condense_at` applies to `reduce = \"dynamic\"` only";
                f.report_key(Code::Conflict, "condense_at", message, "leave it out");
                return None;
            }
        };
        Some(ReductionStudy {
            method,
            keep,
            max_frequency_hz: below?,
            modes,
        })
    }
}

/// Method of model reduction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReductionKind {
    /// Static condensation.
    Guyan,
    /// Condensation at a frequency, Hz.
    Dynamic(f64),
    /// Static condensation and fixed-interface modes.
    CraigBampton,
    /// Modes with a static residual.
    Modal,
}

impl Word for ReductionKind {
    const WORDS: &'static [(&'static str, ReductionKind, &'static str)] = &[
        ("guyan", ReductionKind::Guyan, "Static condensation"),
        (
            "dynamic",
            ReductionKind::Dynamic(f64::NAN),
            "Condensation at --condense-at",
        ),
        (
            "craig-bampton",
            ReductionKind::CraigBampton,
            "Static condensation and fixed-interface modes",
        ),
        (
            "modal",
            ReductionKind::Modal,
            "Modes with a static residual",
        ),
    ];
}
