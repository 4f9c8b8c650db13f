//! Dynamic model `M q̈ + C₀ q̇ + K₀ q + Σ u_b F_b(δ_b, δ̇_b, t) = Σ d f(t)`.
//!
//! The state is `y = [q, q̇, z]`, z the inner states of branches that have one.

use super::contact::ContactLaw;
use super::curve::TorqueSpeedCurve;
use super::friction::{FrictionLaw, FrictionState};
use super::load_friction::LoadFriction;
pub use super::regime::{ElementState, Regime};
use super::signal::Signal;
use super::wave::{PeriodicFunction, WavePhase, Waveform};
use crate::base::error::Error;
use crate::machine::characteristic::Characteristic;
use crate::machine::direction::Direction;
use crate::numeric::{Matrix, symmetric};

/// A machine in motion.
#[derive(Debug, Clone)]
pub struct DynamicModel {
    /// Names of the coordinates, `node.axis`.
    pub coordinates: Vec<String>,
    /// M.
    pub mass: MassMatrix,
    /// Force elements (springs, dampers, contacts, friction).
    pub elements: Vec<ForceElement>,
    /// Applied forces.
    pub forces: Vec<AppliedForce>,
    /// Rayleigh's α: `C₀ ∋ α M`, 1/s.
    pub mass_damping: f64,
    /// K₀ and C₀ that belong to no branch: gyroscopic and centrifugal terms, modal damping.
    pub unattached: Option<(Matrix, Matrix)>,
}

/// Mass matrix of a machine, diagonal or with its inverse.
#[derive(Debug, Clone)]
pub enum MassMatrix {
    /// Each coordinate has its own.
    Diagonal(Vec<f64>),
    /// Coupled, with its inverse.
    Full {
        /// M.
        matrix: Matrix,
        /// M⁻¹.
        inverse: Matrix,
    },
}

impl MassMatrix {
    /// Coupled; what has no inertia has no part in the inverse.
    ///
    /// # Errors
    /// A matrix that is not positive over what has inertia.
    pub fn full(matrix: Matrix) -> Result<MassMatrix, Error> {
        let n = matrix.nrows();
        let heavy: Vec<usize> = (0..n).filter(|&j| matrix[(j, j)] != 0.0).collect();
        let m = heavy.len();
        let block = Matrix::from_fn(m, m, |i, j| matrix[(heavy[i], heavy[j])]);
        symmetric::cholesky(&block)?;
        let inner = symmetric::lu_solve(&block, &Matrix::identity(m, m))?;
        let mut inverse = Matrix::zeros(n, n);
        for (a, &i) in heavy.iter().enumerate() {
            for (b, &j) in heavy.iter().enumerate() {
                inverse[(i, j)] = inner[(a, b)];
            }
        }
        Ok(MassMatrix::Full { matrix, inverse })
    }

    /// An element of M.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        match self {
            MassMatrix::Diagonal(mass) if i == j => mass[i],
            MassMatrix::Diagonal(_) => 0.0,
            MassMatrix::Full { matrix, .. } => matrix[(i, j)],
        }
    }

    /// M.
    pub fn matrix(&self) -> Matrix {
        match self {
            MassMatrix::Diagonal(mass) => {
                Matrix::from_fn(mass.len(), mass.len(), |i, j| self.entry(i, j))
            }
            MassMatrix::Full { matrix, .. } => matrix.clone(),
        }
    }
}

/// A torque or force along a direction.
#[derive(Debug, Clone)]
pub struct AppliedForce {
    /// Name of the force.
    pub name: String,
    /// d.
    pub direction: Direction,
    /// f(t).
    pub signal: Signal,
}

/// A scalar law between coordinates.
#[derive(Debug, Clone)]
pub struct ForceElement {
    /// Name of the element.
    pub name: String,
    /// w.
    pub direction: Direction,
    /// u, where the force does not act along w.
    pub force_direction: Option<Direction>,
    /// F.
    pub law: ForceLaw,
    /// The wave of its stiffness, a factor of mean about one.
    pub stiffness_wave: Option<PeriodicFunction>,
    /// e imposed in time.
    pub imposed_displacement: Option<Signal>,
    /// e that follows angles: the sum of these.
    pub angle_waves: Vec<PeriodicFunction>,
}

/// Force law of a branch.
#[derive(Debug, Clone)]
pub enum ForceLaw {
    /// `F = k δ + c δ̇`.
    Linear {
        /// k.
        stiffness: f64,
        /// c.
        damping: f64,
    },
    /// Play, or a stiffness with a wave.
    Contact(ContactLaw),
    /// Dry friction.
    Friction(FrictionLaw),
    /// Dry friction pressed together over time: a clutch.
    Clutch {
        /// At full capacity.
        friction: FrictionLaw,
        /// The share of it, from 0 to 1.
        grip: Signal,
    },
    /// Dry friction that goes by forces of the machine: of bearings, of teeth.
    LoadFriction(Box<LoadFriction>),
    /// `F = −(mean + Σ a cos(coordinate_count δ + φ))`: a load whose orders are locked to the angle it acts on.
    AngleLocked {
        /// N·m.
        mean: f64,
        /// n per turn, N·m, rad.
        terms: Vec<(f64, f64, f64)>,
    },
    /// `F = −T(δ̇)`: a motor or brake.
    TorqueSpeed(TorqueSpeedCurve),
    /// `F = −z`, `ż = (T(δ̇) − z)/lag`: a motor whose torque follows late.
    LaggedTorque {
        /// T.
        curve: TorqueSpeedCurve,
        /// s.
        lag: f64,
    },
    /// `F = z`, `ż = k (δ̇ − z/c)`: a spring and a damper in series.
    Maxwell {
        /// k.
        stiffness: f64,
        /// c.
        damping: f64,
    },
    /// `F = T(δ) + c δ̇`, T smooth and odd: a progressive coupling, a Hertzian contact.
    Nonlinear {
        /// T.
        characteristic: Characteristic,
        /// c.
        damping: f64,
    },
}

impl ForceLaw {
    /// `(F, ∂F/∂δ, ∂F/∂δ̇)` of a law without memory, contact or dry friction; zero for every other law.
    pub fn force_and_slopes(&self, delta: f64, rate: f64) -> (f64, f64, f64) {
        match self {
            ForceLaw::Linear { stiffness, damping } => {
                (stiffness * delta + damping * rate, *stiffness, *damping)
            }
            ForceLaw::TorqueSpeed(curve) => (-curve.torque(rate), 0.0, -curve.slope(rate)),
            ForceLaw::Nonlinear {
                characteristic,
                damping,
            } => (
                characteristic.force(delta) + damping * rate,
                characteristic.tangent(delta),
                *damping,
            ),
            _ => (0.0, 0.0, 0.0),
        }
    }

    /// Phase of the path of contact, where the law has one.
    pub fn phase(&self) -> Option<&WavePhase> {
        match self {
            ForceLaw::LoadFriction(pressed) => pressed.path.as_ref()?.phase.as_ref(),
            _ => None,
        }
    }

    /// It is dry friction.
    pub fn is_dry(&self) -> bool {
        matches!(
            self,
            ForceLaw::Friction(_) | ForceLaw::Clutch { .. } | ForceLaw::LoadFriction(_)
        )
    }
}

/// Dry friction force in its state, 0, and d/dδ̇; without a state, its step is spread over the creep speed.
pub fn dry_friction_force(
    friction: &FrictionLaw,
    stand: Option<ElementState>,
    rate: f64,
) -> (f64, f64, f64) {
    match stand {
        Some(ElementState::Friction(FrictionState::Stick)) => (0.0, 0.0, 0.0),
        Some(ElementState::Friction(slip)) => (
            friction.sliding_force(slip, rate),
            0.0,
            friction.slope(slip, rate),
        ),
        _ => {
            let (force, slope) = friction.regularised(rate);
            (force, 0.0, slope)
        }
    }
}

/// Which pieces of the displacements imposed on a branch hold.
#[derive(Debug, Clone, Copy)]
pub struct ErrorPieces<'r> {
    /// Line of the displacement known in time.
    pub imposed: u32,
    /// Piece of each wave over an angle; of those missing the one at the state.
    pub waves: &'r [u32],
}

impl ForceElement {
    /// The direction its force acts in.
    pub fn force_direction(&self) -> &Direction {
        self.force_direction.as_ref().unwrap_or(&self.direction)
    }

    /// The largest factor of its stiffness over its wave, of a load table over all its loads; one without.
    pub fn max_factor(&self) -> f64 {
        let wave = self.stiffness_wave.as_ref();
        wave.map_or(1.0, |w| match &w.load_table {
            Some(table) => table.greatest_tangent(),
            None => w.waveform.max().abs().max(w.waveform.lower_bound().abs()),
        })
    }

    /// The mean factor of its stiffness over its wave; one without.
    pub fn mean_factor(&self) -> f64 {
        self.stiffness_wave
            .as_ref()
            .map_or(1.0, |w| w.waveform.mean())
    }

    /// Inner states of its law.
    pub fn internal_count(&self) -> usize {
        usize::from(matches!(
            self.law,
            ForceLaw::LaggedTorque { .. } | ForceLaw::Maxwell { .. }
        ))
    }

    /// A coordinate moves it, is moved by it, or carries on its phase.
    pub fn touches(&self, z: usize) -> bool {
        let along = |d: &Direction| d.terms.iter().any(|t| t.0 == z);
        let waves = self.stiffness_wave.iter().chain(&self.angle_waves);
        let rubs = match &self.law {
            ForceLaw::LoadFriction(pressed) => pressed.directions().any(along),
            _ => false,
        };
        rubs || along(&self.direction)
            || along(self.force_direction())
            || waves.filter_map(|w| w.phase.angle()).any(along)
    }

    /// Pieces at an instant, those of waves over an angle by the state.
    pub fn pieces_at(&self, t: f64) -> ErrorPieces<'static> {
        let imposed = self.imposed_displacement.as_ref();
        ErrorPieces {
            imposed: imposed.map_or(0, |e| e.piece(t) as u32),
            waves: &[],
        }
    }

    /// The waves over an angle, each with its phase at q and the piece that holds there.
    pub fn waves_at<'b>(
        &'b self,
        t: f64,
        q: &[f64],
        pieces: ErrorPieces<'b>,
    ) -> impl Iterator<Item = (&'b PeriodicFunction, f64, usize)> {
        self.angle_waves.iter().enumerate().map(move |(k, wave)| {
            let psi = wave.phase.phase_at(t, q);
            let frozen = pieces.waves.get(k).map(|piece| *piece as usize);
            (
                wave,
                psi,
                frozen.unwrap_or_else(|| wave.waveform.piece(psi)),
            )
        })
    }

    /// δ and δ̇ on pieces of the imposed displacements.
    pub fn deflection(&self, t: f64, q: &[f64], v: &[f64], pieces: ErrorPieces) -> (f64, f64) {
        let (mut delta, mut rate) = (self.direction.dot(q), self.direction.dot(v));
        if let Some(e) = &self.imposed_displacement {
            delta -= e.value(t, pieces.imposed as usize);
            rate -= e.slope(t, pieces.imposed as usize);
        }
        for (wave, psi, at) in self.waves_at(t, q, pieces) {
            delta -= wave.waveform.value_in(psi, at);
            rate -= wave.waveform.slope_in(psi, at) * wave.phase.rate(t, v);
        }
        (delta, rate)
    }
}

impl DynamicModel {
    /// Number of coordinates.
    pub fn coordinate_count(&self) -> usize {
        self.coordinates.len()
    }

    /// Number of inner states.
    pub fn internal_count(&self) -> usize {
        self.elements.iter().map(ForceElement::internal_count).sum()
    }

    /// Nothing but constant stiffness and damping and known forces: exact propagation suffices.
    pub fn is_linear(&self) -> bool {
        let constant = |b: &ForceElement| b.stiffness_wave.is_none();
        self.has_linear_inputs()
            && !self.has_massless()
            && self.superposes()
            && self.elements.iter().all(constant)
    }

    /// The equations are linear in the state, whatever varies in time: differences of motions do not depend on the motions.
    pub fn superposes(&self) -> bool {
        self.elements.iter().all(|b| {
            let linear = match &b.law {
                ForceLaw::Linear { .. } | ForceLaw::Maxwell { .. } => true,
                ForceLaw::Contact(contact) => !contact.can_open(),
                ForceLaw::TorqueSpeed(curve) | ForceLaw::LaggedTorque { curve, .. } => {
                    matches!(curve, TorqueSpeedCurve::Linear { .. })
                }
                ForceLaw::Friction(_)
                | ForceLaw::Clutch { .. }
                | ForceLaw::LoadFriction(_)
                | ForceLaw::AngleLocked { .. }
                | ForceLaw::Nonlinear { .. } => false,
            };
            let known =
                |wave: &PeriodicFunction| wave.phase.angle().is_none() && wave.load_table.is_none();
            linear && b.angle_waves.is_empty() && b.stiffness_wave.as_ref().is_none_or(known)
        })
    }

    /// Known functions of time are lines and harmonics, none of them parabolas.
    pub fn has_linear_inputs(&self) -> bool {
        self.signals().all(Signal::is_piecewise_linear)
    }

    /// Known functions of time: what drives and what is imposed.
    pub fn signals(&self) -> impl Iterator<Item = &Signal> {
        let imposed = self
            .elements
            .iter()
            .filter_map(|b| b.imposed_displacement.as_ref());
        self.forces.iter().map(|d| &d.signal).chain(imposed)
    }

    /// Frequencies of harmonic loads and errors, rad/s.
    pub fn harmonics(&self) -> impl Iterator<Item = f64> {
        let lasting = |signal: &Signal| -> Vec<f64> {
            let bursts = signal.bursts.iter().map(|b| b.omega);
            let harmonics = signal.harmonics.iter().map(|h| h.omega);
            harmonics.chain(bursts).collect()
        };
        let all = self.signals().flat_map(lasting);
        all.map(f64::abs).filter(|&omega| omega != 0.0)
    }

    /// Linear between switches: contacts with play, stiffness in steps at imposed speed, Coulomb friction.
    pub fn is_piecewise_linear(&self) -> bool {
        self.has_linear_inputs()
            && !self.has_massless()
            && self.nonlinear_elements().next().is_none()
    }

    /// Branches that are not linear between switches.
    pub fn nonlinear_elements(&self) -> impl Iterator<Item = &ForceElement> {
        self.elements.iter().filter(|b| {
            let linear = match &b.law {
                ForceLaw::Linear { .. } | ForceLaw::Maxwell { .. } | ForceLaw::Contact(_) => true,
                ForceLaw::Friction(friction) => {
                    let swings = |e: &Signal| !e.harmonics.is_empty();
                    friction.is_coulomb() && !b.imposed_displacement.as_ref().is_some_and(swings)
                }
                ForceLaw::TorqueSpeed(curve) | ForceLaw::LaggedTorque { curve, .. } => {
                    matches!(curve, TorqueSpeedCurve::Linear { .. })
                }
                ForceLaw::Clutch { .. }
                | ForceLaw::LoadFriction(_)
                | ForceLaw::AngleLocked { .. }
                | ForceLaw::Nonlinear { .. } => false,
            };
            let steps = b
                .stiffness_wave
                .as_ref()
                .is_none_or(|w| w.waveform.is_piecewise_constant() && w.phase.angle().is_none());
            !(linear && steps && b.angle_waves.is_empty())
        })
    }

    /// Something can switch at an instant that the motion decides.
    pub fn has_events(&self) -> bool {
        self.elements.iter().any(|b| match &b.law {
            ForceLaw::Contact(contact) => {
                contact.can_open()
                    || b.stiffness_wave.as_ref().is_some_and(|w| {
                        w.phase.angle().is_some() && !matches!(w.waveform, Waveform::Fourier { .. })
                    })
            }
            law => law.is_dry(),
        })
    }
}
