//! Time-domain laws: contact damping, waveforms, friction, torque–speed curves, load histories.

use std::sync::Arc;

use crate::base::source_span::SourceFile;

/// Damping law of an opening and closing contact; g is the deflection beyond the backlash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactDamping {
    /// `F = k g + c δ̇`, the damper acting in the gap as well (Kahraman and Singh 1990).
    ActsInGap,
    /// `F = k g + c δ̇` in contact: F is discontinuous at impact and may be tensile before separation.
    Adhesive,
    /// `F = max(0, k g + c δ̇)` in contact: F is discontinuous at impact, never tensile (Modelica's ElastoBacklash2).
    NoPull,
    /// `F = max(0, k g + min(c δ̇, k g))`: continuous, never tensile (Modelica's ElastoBacklash).
    Continuous,
}

impl ContactDamping {
    /// All damping laws with their keywords.
    pub const WORDS: &'static [(&'static str, ContactDamping)] = &[
        ("throughout", ContactDamping::ActsInGap),
        ("adhesive", ContactDamping::Adhesive),
        ("no-pull", ContactDamping::NoPull),
        ("continuous", ContactDamping::Continuous),
    ];
}

/// Nonlinear force–deflection characteristic of an elastic element, an odd function.
#[derive(Debug, Clone, PartialEq)]
pub enum Characteristic {
    /// `F = sign(δ) K |δ|ⁿ`, n ≥ 1: 3/2 for Hertzian point contact (Hertz 1881).
    Power {
        /// K, N/mⁿ or N·m/radⁿ.
        factor: f64,
        /// Exponent n.
        exponent: f64,
        /// Rated deflection, m or rad.
        rated: f64,
    },
    /// Smooth curve through points in ascending order of deflection from zero: m or rad, N or N·m.
    Table(Vec<(f64, f64)>),
}

/// One period of a waveform over the phase ψ, 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub enum Waveform {
    /// Rectangular wave: `high` during the share `duty` of the period, then `low`.
    Rectangular {
        /// First value.
        high: f64,
        /// Second value.
        low: f64,
        /// Duty cycle, in (0, 1).
        duty: f64,
    },
    /// `mean + Σ a cos(2π n ψ + φ)`.
    Fourier {
        /// Mean value (n = 0).
        mean: f64,
        /// Harmonics: n, a, φ in rad.
        terms: Vec<(u32, f64, f64)>,
    },
    /// Periodic linear interpolation of equally spaced values, the first at ψ = 0.
    Table(Vec<f64>),
}

impl Waveform {
    /// Lower bound of the values.
    pub fn lower_bound(&self) -> f64 {
        match self {
            Waveform::Rectangular { high, low, .. } => high.min(*low),
            Waveform::Fourier { mean, terms } => {
                mean - terms.iter().map(|t| t.1.abs()).sum::<f64>()
            }
            Waveform::Table(values) => values.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }
}

/// Stribeck friction: `F = sign(δ̇) [F_c + (F_s − F_c) exp(−(δ̇/v_s)²)]` in slip, |F| ≤ F_s in stick. With v_s = 0 the force drops to
/// F_c at the onset of slip.
///
/// Source: Armstrong-Hélouvry, Dupont and Canudas de Wit 1994, the static model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionLaw {
    /// Sliding (Coulomb) friction F_c, N or N·m.
    pub sliding: f64,
    /// Breakaway friction F_s ≥ F_c, N or N·m.
    pub breakaway: f64,
    /// Stribeck velocity v_s, m/s or rad/s; 0: no decay over speed; unused where F_s = F_c.
    pub stribeck_velocity: f64,
    /// Regularisation width of the sign change, for methods without events, m/s or rad/s.
    pub regularisation_velocity: f64,
}

/// Dry friction of the tooth flanks of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothFriction {
    /// Friction law for a capacity of 1 N·m.
    pub law: FrictionLaw,
    /// Coefficient of friction μ.
    pub coefficient: f64,
    /// Tip radii, m; absent: addendum of one module.
    pub tips: Option<[f64; 2]>,
    /// Mesh phase at zero gear angles, rad, for friction that varies along the path of contact; absent: mean friction over
    /// the mesh cycle.
    pub path: Option<f64>,
}

/// Torque–speed curve of a motor; positive torque drives the machine forward.
#[derive(Debug, Clone, PartialEq)]
pub enum TorqueSpeedCurve {
    /// `T = T₀ (1 − ω/ω₀)`: a DC motor at constant voltage.
    Linear {
        /// Stall torque T₀, N·m.
        stall: f64,
        /// No-load speed ω₀, rad/s.
        idle: f64,
    },
    /// Kloss's formula `T = 2 T_k / (s/s_k + s_k/s)`, `s = (ω_s − ω)/ω_s`: an induction motor at constant frequency.
    Induction {
        /// Pull-out torque T_k, N·m.
        pull_out: f64,
        /// Pull-out slip s_k.
        slip: f64,
        /// Synchronous speed ω_s, rad/s.
        synchronous: f64,
    },
    /// Linear interpolation of (speed, rad/s; torque, N·m) in ascending order of speed, constant outside.
    Table(Vec<(f64, f64)>),
}

/// Load history of the file: torque, N·m, or force, N, over time.
#[derive(Debug, Clone, PartialEq)]
pub enum LoadHistory {
    /// Constant load, N·m.
    Constant(f64),
    /// Step from zero at `time`.
    Step {
        /// Torque after the step or ramp, N·m.
        torque: f64,
        /// s.
        time: f64,
    },
    /// Linear ramp between two instants.
    Ramp {
        /// Torque before the ramp, N·m.
        from: f64,
        /// Torque after the step or ramp, N·m.
        to: f64,
        /// Start and end times, s.
        between: [f64; 2],
    },
    /// `mean + amplitude cos(ω t + φ)`.
    Harmonic {
        /// Mean torque, N·m.
        mean: f64,
        /// Amplitude, N·m.
        amplitude: f64,
        /// Angular frequency ω, rad/s.
        omega: f64,
        /// Phase φ, rad.
        phase: f64,
    },
    /// `mean + Σ a cos(n θ + φ)`, θ the angle of the node.
    Orders {
        /// Mean torque, N·m.
        mean: f64,
        /// Order n per revolution, amplitude a, N·m, phase φ, rad.
        orders: Vec<(f64, f64, f64)>,
    },
    /// Linear interpolation of points: s, N·m.
    Table(Vec<(f64, f64)>),
    /// Cutting forces of a face-mill cutter at its mean speed.
    FaceMill(FaceMill),
    /// Torque times dimensionless factors over time: constants, steps, ramps, harmonics and tables.
    Product {
        /// Torque, N·m.
        torque: f64,
        /// Dimensionless factors over time.
        factors: Vec<LoadHistory>,
    },
}

impl LoadHistory {
    /// Long-term value of the load, N·m, which determines the flanks in contact.
    pub fn long_term_value(&self) -> f64 {
        match self {
            LoadHistory::Constant(torque) | LoadHistory::Step { torque, .. } => *torque,
            LoadHistory::Ramp { to, .. } => *to,
            LoadHistory::Harmonic { mean, .. } | LoadHistory::Orders { mean, .. } => *mean,
            LoadHistory::Table(points) => points.last().map_or(0.0, |p| p.1),
            LoadHistory::FaceMill(_) => 0.0,
            LoadHistory::Product { torque, factors } => factors
                .iter()
                .fold(*torque, |x, factor| x * factor.long_term_value()),
        }
    }

    /// Bounds of the load, minimum and maximum, N·m; for a product the interval product of its factors. `None` where the load depends
    /// on the motion.
    pub fn range(&self) -> Option<[f64; 2]> {
        let bounds = |values: &[f64]| {
            let minimum = values.iter().copied().fold(f64::INFINITY, f64::min);
            [
                minimum,
                values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        Some(match self {
            LoadHistory::Constant(torque) => bounds(&[*torque]),
            LoadHistory::Step { torque, .. } => bounds(&[0.0, *torque]),
            LoadHistory::Ramp { from, to, .. } => bounds(&[*from, *to]),
            LoadHistory::Harmonic {
                mean, amplitude, ..
            } => bounds(&[mean - amplitude, mean + amplitude]),
            LoadHistory::Table(points) => bounds(&points.iter().map(|p| p.1).collect::<Vec<_>>()),
            LoadHistory::Orders { .. } | LoadHistory::FaceMill(_) => return None,
            LoadHistory::Product { torque, factors } => {
                let mut range = [*torque; 2];
                for factor in factors {
                    let [low, high] = factor.range()?;
                    let [a, b] = range;
                    range = bounds(&[a * low, a * high, b * low, b * high]);
                }
                range
            }
        })
    }
}

/// Cutting forces of a face-mill head that generates one tooth slot.
///
/// Cutting force of one blade `F = k_c1 b h^(1−m)` along its path (Kienzle 1952; k_c1 for a chip of 1 mm × 1 mm), with radial and
/// axial forces as shares of F.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMill {
    /// Chips of the blades.
    pub chips: MillChips,
    /// Cutting radius, m.
    pub radius: f64,
    /// Specific cutting force k_c1, Pa.
    pub specific_force: f64,
    /// Kienzle exponent m, in [0, 1).
    pub exponent: f64,
    /// Sign of the cutting torque on the node, +1 or −1.
    pub sense: f64,
    /// Angular position of the slot centre about the head axis, from x to y, rad; required for lateral motion of the head.
    pub slot: Option<f64>,
    /// Outward radial force on a blade, as a share of F.
    pub radial: f64,
    /// Axial force along z, as a share of F.
    pub axial: f64,
}

/// Chips of the blade groups of a head.
#[derive(Debug, Clone, PartialEq)]
pub enum MillChips {
    /// Chips given by their largest dimensions.
    Stated(StatedChips),
    /// Chips given by blade passes.
    Passes {
        /// Time of the first position of the first pass, s.
        start: f64,
        /// Blade positions of each pass: two or more at equal angular steps of the head.
        passes: Vec<Vec<BladeSample>>,
        /// Chip file; absent where it cannot be read.
        source: Option<Arc<SourceFile>>,
    },
}

impl LoadHistory {
    /// Chip file of a face-mill load.
    pub fn chips(&self) -> Option<&Arc<SourceFile>> {
        match self {
            LoadHistory::FaceMill(FaceMill {
                chips: MillChips::Passes { source, .. },
                ..
            }) => source.as_ref(),
            _ => None,
        }
    }
}

/// Chips of equal blade groups that cut in succession; chip thickness increases and decreases over the generating roll.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedChips {
    /// Number of blade groups of the head.
    pub blades: u32,
    /// Angle of the head over which one blade is in the slot, rad.
    pub arc: f64,
    /// Chip width b of one group, m.
    pub width: f64,
    /// Largest chip thickness over the roll, m.
    pub chip: f64,
    /// Run-out of the head, m: excess chip thickness of the first group and deficit of the opposite group.
    pub runout: f64,
    /// Start and end of the generating roll, s.
    pub roll: [f64; 2],
}

/// Blade position in a pass through the slot, with its chip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeSample {
    /// Rotation of the head from the first position of the first pass, rad.
    pub head: f64,
    /// Angle of the blade from the slot centre in the sense of rotation, rad.
    pub angle: f64,
    /// Length of the cutting edge in contact, m.
    pub edge: f64,
    /// Mean chip thickness along the edge, m.
    pub thickness: f64,
}

/// Motor model: torque–speed curve or prescribed motion.
#[derive(Debug, Clone, PartialEq)]
pub enum MotorModel {
    /// Torque–speed curve with optional first-order lag.
    Curve {
        /// Torque–speed curve.
        curve: TorqueSpeedCurve,
        /// Electrical lag, s; zero: none.
        lag: f64,
    },
    /// Prescribed speed, rad/s.
    Speed(MotionProfile),
    /// Prescribed angle, rad.
    Angle(MotionProfile),
}

/// Prescribed motion over time: `x(t) + a cos(ω t + φ)`.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionProfile {
    /// Linear interpolation x(t) of points: s, rad or rad/s.
    pub points: Vec<(f64, f64)>,
    /// Oscillation about the mean.
    pub oscillation: Option<Sinusoid>,
}

/// Sinusoid `amplitude cos(omega t + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sinusoid {
    /// Amplitude, rad or rad/s.
    pub amplitude: f64,
    /// Angular frequency ω, rad/s.
    pub omega: f64,
    /// Phase φ, rad.
    pub phase: f64,
}

/// Source of the mesh phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MeshPhase {
    /// Phase from the gear angles.
    #[default]
    Angle,
    /// Phase from the mean speeds: ψ = Ω t.
    Speed,
}

/// Initial state of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InitialState {
    /// At standstill, without deflection.
    #[default]
    Rest,
    /// At the mean speeds, with the static deflection under the initial loads.
    Steady,
}
