//! Time-domain laws: contact damping, waveforms, friction, torque–speed curves, load histories.

use std::sync::Arc;

use crate::base::source_span::SourceFile;

/// Damping law of a contact as it opens and closes. With g the deflection beyond the play:
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactDamping {
    /// `F = k g + c δ̇`, the damper acting in the gap as well (Kahraman and Singh 1990).
    ActsInGap,
    /// `F = k g + c δ̇` while touching: it jumps at touch and may pull before release.
    Adhesive,
    /// `F = max(0, k g + c δ̇)` while touching: it jumps at touch and never pulls (Modelica's ElastoBacklash2).
    NoPull,
    /// `F = max(0, k g + min(c δ̇, k g))`: neither jumps nor pulls (Modelica's ElastoBacklash).
    Continuous,
}

impl ContactDamping {
    /// Every convention by its word.
    pub const WORDS: &'static [(&'static str, ContactDamping)] = &[
        ("throughout", ContactDamping::ActsInGap),
        ("adhesive", ContactDamping::Adhesive),
        ("no-pull", ContactDamping::NoPull),
        ("continuous", ContactDamping::Continuous),
    ];
}

/// Force over deflection of an elastic element that is not linear; the same backward.
#[derive(Debug, Clone, PartialEq)]
pub enum Characteristic {
    /// `F = sign(δ) K |δ|ⁿ`, n ≥ 1: 3/2 for Hertz's contact at a point (Hertz 1881).
    Power {
        /// K, N/mⁿ or N·m/radⁿ.
        factor: f64,
        /// n.
        exponent: f64,
        /// The deflection at which it is rated, m or rad.
        rated: f64,
    },
    /// A smooth curve through points by rising deflection, the first at rest: m or rad, N or N·m.
    Table(Vec<(f64, f64)>),
}

/// One period of a wave, over the phase ψ in turns of the period: ψ from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub enum Waveform {
    /// `high` for the first `duty` of the period, `low` for the rest.
    Rectangular {
        /// Value at first.
        high: f64,
        /// Value afterwards.
        low: f64,
        /// Share of the period, in (0, 1).
        duty: f64,
    },
    /// `mean + Σ a cos(2π n ψ + φ)`.
    Fourier {
        /// n = 0.
        mean: f64,
        /// n, a, φ.
        terms: Vec<(u32, f64, f64)>,
    },
    /// Straight lines through equally spaced values, the first at ψ = 0, closed after the last.
    Table(Vec<f64>),
}

impl Waveform {
    /// No value is below this.
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

/// `F = sign(δ̇) [F_c + (F_s − F_c) exp(−(δ̇/v_s)²)]` sliding; anything up to F_s sticking. With v_s = 0 the force falls to F_c as
/// soon as the pair slides.
///
/// Source: Armstrong-Hélouvry, Dupont and Canudas de Wit 1994, the static model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionLaw {
    /// F_c, N or N·m.
    pub sliding: f64,
    /// F_s ≥ F_c, N or N·m.
    pub breakaway: f64,
    /// v_s, m/s or rad/s; 0: no fall over speed; unused where F_s = F_c.
    pub stribeck_velocity: f64,
    /// Width over which methods without events let the force turn from one sign to the other, m/s or rad/s.
    pub regularisation_velocity: f64,
}

/// Friction along the teeth of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothFriction {
    /// For a capacity of one N·m.
    pub law: FrictionLaw,
    /// μ.
    pub coefficient: f64,
    /// Radii of the tip circles, m; of one module of addendum where absent.
    pub tips: Option<[f64; 2]>,
    /// Phase of the pair in the mesh cycle at zero gear angles, rad, where friction goes along the path of contact; absent: its mean over
    /// the cycle.
    pub path: Option<f64>,
}

/// A torque as a function of speed. It is what the machine receives: positive drives forward.
#[derive(Debug, Clone, PartialEq)]
pub enum TorqueSpeedCurve {
    /// `T = T₀ (1 − ω/ω₀)`: a DC motor at constant voltage.
    Linear {
        /// T₀, at standstill, N·m.
        stall: f64,
        /// ω₀, without load, rad/s.
        idle: f64,
    },
    /// Kloss's formula `T = 2 T_k / (s/s_k + s_k/s)`, `s = (ω_s − ω)/ω_s`: an induction motor at constant frequency.
    Induction {
        /// T_k, the pull-out torque, N·m.
        pull_out: f64,
        /// s_k, the slip at which it acts.
        slip: f64,
        /// ω_s, rad/s.
        synchronous: f64,
    },
    /// Straight lines through points, constant beyond them: speed, torque; by rising speed.
    Table(Vec<(f64, f64)>),
}

/// A load over time, as the file has it.
#[derive(Debug, Clone, PartialEq)]
pub enum LoadHistory {
    /// The same at all times.
    Constant(f64),
    /// Nothing before `time`.
    Step {
        /// N·m afterwards.
        torque: f64,
        /// s.
        time: f64,
    },
    /// A straight line between two instants.
    Ramp {
        /// N·m before.
        from: f64,
        /// N·m afterwards.
        to: f64,
        /// Begin and end, s.
        between: [f64; 2],
    },
    /// `mean + amplitude cos(ω t + φ)`.
    Harmonic {
        /// N·m.
        mean: f64,
        /// N·m.
        amplitude: f64,
        /// rad/s.
        omega: f64,
        /// rad.
        phase: f64,
    },
    /// `mean + Σ a cos(n θ + φ)` of the node's own angle θ.
    Orders {
        /// N·m.
        mean: f64,
        /// n per turn, N·m, rad.
        orders: Vec<(f64, f64, f64)>,
    },
    /// Straight lines through points: s, N·m.
    Table(Vec<(f64, f64)>),
    /// A face-mill cutter at its mean speed.
    FaceMill(FaceMill),
    /// A torque times factors of time, each a plain number: constants, steps, ramps, harmonics and tables.
    Product {
        /// N·m.
        torque: f64,
        /// Each a number over time.
        factors: Vec<LoadHistory>,
    },
}

impl LoadHistory {
    /// Long-term value of the load, N·m, which decides the flanks in contact.
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

    /// The least and the greatest it ever is; of a product what the extremes of its factors leave room for. Absent where the motion
    /// decides.
    pub fn range(&self) -> Option<[f64; 2]> {
        let of = |values: &[f64]| {
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            [
                least,
                values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        Some(match self {
            LoadHistory::Constant(torque) => of(&[*torque]),
            LoadHistory::Step { torque, .. } => of(&[0.0, *torque]),
            LoadHistory::Ramp { from, to, .. } => of(&[*from, *to]),
            LoadHistory::Harmonic {
                mean, amplitude, ..
            } => of(&[mean - amplitude, mean + amplitude]),
            LoadHistory::Table(points) => of(&points.iter().map(|p| p.1).collect::<Vec<_>>()),
            LoadHistory::Orders { .. } | LoadHistory::FaceMill(_) => return None,
            LoadHistory::Product { torque, factors } => {
                let mut range = [*torque; 2];
                for factor in factors {
                    let [low, high] = factor.range()?;
                    let [a, b] = range;
                    range = of(&[a * low, a * high, b * low, b * high]);
                }
                range
            }
        })
    }
}

/// Cutting forces of a face-mill head that generates one tooth slot.
///
/// One blade cuts `F = k_c1 b h^(1−m)` along its path (Kienzle 1952; k_c1 for a chip of 1 mm × 1 mm), and is pushed across it
/// by shares of F.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMill {
    /// Chips of the blades.
    pub chips: MillChips,
    /// Radius at which they are cut, m.
    pub radius: f64,
    /// k_c1, Pa.
    pub specific_force: f64,
    /// m, in [0, 1).
    pub exponent: f64,
    /// +1 or −1: the sense of its torque on the node.
    pub sense: f64,
    /// Angle of the middle of the slot round the axis of the head, from x to y, rad; needed where the head moves across it.
    pub slot: Option<f64>,
    /// Radial force on a blade away from the axis, as a share of F.
    pub radial: f64,
    /// Axial force along z, as a share of F.
    pub axial: f64,
}

/// Chips of the blade groups of a head.
#[derive(Debug, Clone, PartialEq)]
pub enum MillChips {
    /// By their greatest size.
    Stated(StatedChips),
    /// By the passes of the blades, from the time at which the first place of the first pass is cut, s.
    Passes {
        /// That time, s.
        start: f64,
        /// Places pass by pass: two or more at equal steps of the head.
        passes: Vec<Vec<MillPlace>>,
        /// The file that holds them; absent where it cannot be read.
        source: Option<Arc<SourceFile>>,
    },
}

impl LoadHistory {
    /// The file of chips of a face-mill load.
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

/// Chips of alike groups that enter and leave the slot one after another; they thicken and thin again over the generating roll.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedChips {
    /// Blade groups round the head.
    pub blades: u32,
    /// Angle of the head over which one blade is in the slot, rad.
    pub arc: f64,
    /// Chip width b of one group, m.
    pub width: f64,
    /// Largest chip thickness over the roll, m.
    pub chip: f64,
    /// Excess cut of the first group and deficit of the one opposite, m: run-out of the head.
    pub runout: f64,
    /// The generating roll, begin and end, s.
    pub roll: [f64; 2],
}

/// A place of a blade's pass through the slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MillPlace {
    /// Turn of the head from the first place of the first pass, rad.
    pub head: f64,
    /// Angle of the blade from the middle of the slot in the sense of its turn, rad.
    pub angle: f64,
    /// Length of the edge that cuts, m.
    pub edge: f64,
    /// Mean chip thickness along it, m.
    pub thickness: f64,
}

/// Motor model: drives a node by its speed, or moves it as prescribed.
#[derive(Debug, Clone, PartialEq)]
pub enum MotorModel {
    /// A torque over speed, following at once or late.
    Curve {
        /// The torque.
        curve: TorqueSpeedCurve,
        /// Electrical lag, s; zero: none.
        lag: f64,
    },
    /// The speed itself, rad/s.
    Speed(MotionProfile),
    /// The angle itself, rad.
    Angle(MotionProfile),
}

/// A motion prescribed over time: `x(t) + a cos(ω t + φ)`.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionProfile {
    /// x: straight lines through points: s, rad or rad/s.
    pub points: Vec<(f64, f64)>,
    /// Oscillation about the mean.
    pub oscillation: Option<Sinusoid>,
}

/// `amplitude cos(omega t + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sinusoid {
    /// rad or rad/s.
    pub amplitude: f64,
    /// rad/s.
    pub omega: f64,
    /// rad.
    pub phase: f64,
}

/// Source of the phase angles of the waves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MeshPhase {
    /// From the motion itself.
    #[default]
    Angle,
    /// From the mean speeds: ψ = Ω t.
    Speed,
}

/// Initial state of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InitialState {
    /// Nothing moves, nothing is wound up.
    #[default]
    Rest,
    /// At the mean speeds, wound up under the loads of the first instant.
    Steady,
}
