//! Studies of modes, state-space forms and reduced machines.

use super::{SpeedRange, speeds};
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;
use crate::scene::common::MOST;

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
    pub reduce: Option<ReduceStudy>,
}

/// Reads its keys.
pub(super) fn modes(f: &mut Fields) -> ModesStudy {
    let study = ModesStudy {
        damped: f.flag("damped"),
        speed: f.optional_quantity("speed", Kind::Speed, Range::Any),
        campbell: speeds(f, "campbell"),
        lowest: f.optional_count("lowest", 1, MOST),
        near: f.optional_quantity("near", Kind::Frequency, Range::NotNegative),
        ..ModesStudy::default()
    };
    f.exclusive("speed", "campbell");
    study
}

/// Which state-space form is wanted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StateSpaceStudy {
    /// `node.axis` each; all freedoms where none is named.
    pub inputs: Vec<String>,
    /// `node.axis`, `node.axis.speed`, `node.axis.acceleration` or `branch.force` each; all freedoms where none is named.
    pub outputs: Vec<String>,
    /// Between samples, s; absent: continuous.
    pub sample_time: Option<f64>,
    /// What inputs do between samples.
    pub hold: Hold,
}

/// What an input is taken to do between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// It stays: exact for steps at samples.
    #[default]
    Zero,
    /// It goes straight to the next sample: exact for ramps. States are shifted by what the coming sample adds, outputs not.
    First,
    /// Tustin's rule: the trapezoidal rule in time. Stable forms stay stable; frequencies are warped, states are not the continuous ones.
    Bilinear,
}

impl Hold {
    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            Hold::Zero => "zero-order",
            Hold::First => "first-order",
            Hold::Bilinear => "bilinear",
        }
    }
}

/// Which reduced machine is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct ReduceStudy {
    /// How.
    pub method: ReduceMethod,
    /// Freedoms kept, loaded and measured, `node.axis` each.
    pub keep: Vec<String>,
    /// The response matters up to here, Hz.
    pub below_hz: f64,
    /// Modes kept; absent: those below twice the band.
    pub modes: Option<u32>,
}

/// How a machine is reduced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReduceMethod {
    /// Static condensation.
    Guyan,
    /// Condensation at a frequency, Hz.
    Dynamic(f64),
    /// Static condensation and fixed-interface modes.
    CraigBampton,
    /// Modes with a static residual.
    Modal,
}
