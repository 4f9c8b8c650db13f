//! Studies of modes, state-space forms and reduced machines.

use super::{SpeedRange, speeds};
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
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

/// Reads its keys.
pub(super) fn modes(f: &mut TableReader) -> ModesStudy {
    let study = ModesStudy {
        damped: f.flag("damped"),
        speed: f.optional_quantity("speed", QuantityKind::Speed, ValueRange::Any),
        campbell: speeds(f, "campbell"),
        lowest: f.optional_count("lowest", 1, MAX_COUNT),
        near: f.optional_quantity("near", QuantityKind::Frequency, ValueRange::NotNegative),
        ..ModesStudy::default()
    };
    f.exclusive("speed", "campbell");
    study
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
    pub method: DiscretisationMethod,
}

/// Assumed inputs between samples: the discretisation method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DiscretisationMethod {
    /// It stays: exact for steps at samples.
    #[default]
    Zero,
    /// It goes straight to the next sample: exact for ramps. States are shifted by what the coming sample adds, outputs not.
    First,
    /// Tustin's rule: the trapezoidal rule in time. Stable forms stay stable; frequencies are warped, states are not the continuous ones.
    Bilinear,
}

impl DiscretisationMethod {
    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            DiscretisationMethod::Zero => "zero-order",
            DiscretisationMethod::First => "first-order",
            DiscretisationMethod::Bilinear => "bilinear",
        }
    }
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
