//! Dynamic model `M q̈ + C₀ q̇ + K₀ q + Σ u_b F_b(δ_b, δ̇_b, t) = Σ d f(t)`.
//!
//! The state is `y = [q, q̇, z]`, with z the internal states of the elements.

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

/// Equations of motion of a machine: mass matrix, force elements and applied forces.
#[derive(Debug, Clone)]
pub struct DynamicModel {
    /// Names of the coordinates, `node.axis`.
    pub coordinates: Vec<String>,
    /// Mass matrix M, kg or kg·m².
    pub mass: MassMatrix,
    /// Force elements (springs, dampers, contacts, friction).
    pub elements: Vec<ForceElement>,
    /// Applied forces.
    pub forces: Vec<AppliedForce>,
    /// Rayleigh's mass-proportional coefficient α of C₀, 1/s.
    pub mass_damping: f64,
    /// Global matrices K₀ and C₀: gyroscopic and centrifugal terms and modal damping.
    pub global_matrices: Option<(Matrix, Matrix)>,
}

/// Mass matrix of a machine, diagonal or full with its inverse.
#[derive(Debug, Clone)]
pub enum MassMatrix {
    /// Diagonal of M.
    Diagonal(Vec<f64>),
    /// Full matrix with its inverse.
    Full {
        /// Matrix M.
        matrix: Matrix,
        /// Inverse M⁻¹, zero in the rows and columns of massless coordinates.
        inverse: Matrix,
    },
}

impl MassMatrix {
    /// Full mass matrix; its inverse is zero in the rows and columns of massless coordinates.
    ///
    /// # Errors
    /// A matrix that is not positive definite over the coordinates with inertia.
    pub fn full(matrix: Matrix) -> Result<MassMatrix, Error> {
        let n = matrix.nrows();
        let massive: Vec<usize> = (0..n).filter(|&j| matrix[(j, j)] != 0.0).collect();
        let m = massive.len();
        let block = Matrix::from_fn(m, m, |i, j| matrix[(massive[i], massive[j])]);
        symmetric::cholesky(&block)?;
        let inner = symmetric::lu_solve(&block, &Matrix::identity(m, m))?;
        let mut inverse = Matrix::zeros(n, n);
        for (a, &i) in massive.iter().enumerate() {
            for (b, &j) in massive.iter().enumerate() {
                inverse[(i, j)] = inner[(a, b)];
            }
        }
        Ok(MassMatrix::Full { matrix, inverse })
    }

    /// Element (i, j) of M.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        match self {
            MassMatrix::Diagonal(mass) if i == j => mass[i],
            MassMatrix::Diagonal(_) => 0.0,
            MassMatrix::Full { matrix, .. } => matrix[(i, j)],
        }
    }

    /// Dense copy of M.
    pub fn matrix(&self) -> Matrix {
        match self {
            MassMatrix::Diagonal(mass) => {
                Matrix::from_fn(mass.len(), mass.len(), |i, j| self.entry(i, j))
            }
            MassMatrix::Full { matrix, .. } => matrix.clone(),
        }
    }
}

/// Applied force or torque `d f(t)`, N or N·m.
#[derive(Debug, Clone)]
pub struct AppliedForce {
    /// Name of the force.
    pub name: String,
    /// Direction d.
    pub direction: Direction,
    /// Force f(t), N or N·m.
    pub signal: Signal,
}

/// Scalar force element `u F(δ, δ̇, t)` with the deflection `δ = w·q − e`.
#[derive(Debug, Clone)]
pub struct ForceElement {
    /// Name of the element.
    pub name: String,
    /// Direction w of the deflection.
    pub direction: Direction,
    /// Direction u of the force; absent if equal to w.
    pub force_direction: Option<Direction>,
    /// Force law F.
    pub law: ForceLaw,
    /// Periodic factor of the stiffness, of mean about one.
    pub stiffness_wave: Option<PeriodicFunction>,
    /// Displacement excitation e(t), m or rad.
    pub imposed_displacement: Option<Signal>,
    /// Displacement excitations that depend on angles, m or rad; they are summed.
    pub angle_waves: Vec<PeriodicFunction>,
}

/// Force law of a force element.
#[derive(Debug, Clone)]
pub enum ForceLaw {
    /// `F = k δ + c δ̇`.
    Linear {
        /// Stiffness k, N/m or N·m/rad.
        stiffness: f64,
        /// Damping c, N·s/m or N·m·s/rad.
        damping: f64,
    },
    /// Contact with clearance, or a periodic stiffness.
    Contact(ContactLaw),
    /// Dry friction.
    Friction(FrictionLaw),
    /// Dry friction of a clutch with a capacity that varies in time.
    Clutch {
        /// Friction law at full capacity.
        friction: FrictionLaw,
        /// Fraction of the capacity over time, 0 to 1.
        capacity: Signal,
    },
    /// Load-dependent dry friction of bearings and teeth.
    LoadFriction(Box<LoadFriction>),
    /// `F = −(mean + Σ a cos(n δ + φ))`: load with orders n locked to the angle δ.
    AngleLocked {
        /// Mean torque, N·m.
        mean: f64,
        /// Orders n (per revolution), amplitudes a, N·m, and phases φ, rad.
        terms: Vec<(f64, f64, f64)>,
    },
    /// `F = −T(δ̇)`: motor or brake.
    TorqueSpeed(TorqueSpeedCurve),
    /// `F = −z`, `ż = (T(δ̇) − z)/lag`: motor with a first-order lag of the torque.
    LaggedTorque {
        /// Torque–speed curve T.
        curve: TorqueSpeedCurve,
        /// Time constant, s.
        lag: f64,
    },
    /// `F = z`, `ż = k (δ̇ − z/c)`: spring and damper in series.
    Maxwell {
        /// Stiffness k, N/m or N·m/rad.
        stiffness: f64,
        /// Damping c, N·s/m or N·m·s/rad.
        damping: f64,
    },
    /// `F = T(δ) + c δ̇`, T smooth and odd: progressive coupling or Hertzian contact.
    Nonlinear {
        /// Force–deflection curve T.
        characteristic: Characteristic,
        /// Damping c, N·s/m or N·m·s/rad.
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

    /// Phase along the path of contact; `None` for laws without one.
    pub fn phase(&self) -> Option<&WavePhase> {
        match self {
            ForceLaw::LoadFriction(friction) => friction.path.as_ref()?.phase.as_ref(),
            _ => None,
        }
    }

    /// True for dry friction.
    pub fn is_dry_friction(&self) -> bool {
        matches!(
            self,
            ForceLaw::Friction(_) | ForceLaw::Clutch { .. } | ForceLaw::LoadFriction(_)
        )
    }
}

/// Dry friction force with its derivatives with respect to δ and δ̇, in a friction state; regularised without a state.
pub fn dry_friction_force(
    friction: &FrictionLaw,
    state: Option<ElementState>,
    rate: f64,
) -> (f64, f64, f64) {
    match state {
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

/// Active pieces of the displacement excitations of a force element.
#[derive(Debug, Clone, Copy)]
pub struct ErrorPieces<'r> {
    /// Piece of the displacement excitation over time.
    pub imposed: u32,
    /// Piece of each wave over an angle; missing ones follow from the state.
    pub waves: &'r [u32],
}

impl ForceElement {
    /// Direction u of the force.
    pub fn force_direction(&self) -> &Direction {
        self.force_direction.as_ref().unwrap_or(&self.direction)
    }

    /// Largest stiffness factor over the wave, or over all loads of a load table; 1 without a wave.
    pub fn max_factor(&self) -> f64 {
        let wave = self.stiffness_wave.as_ref();
        wave.map_or(1.0, |w| match &w.load_table {
            Some(table) => table.max_tangent_stiffness(),
            None => w.waveform.max().abs().max(w.waveform.lower_bound().abs()),
        })
    }

    /// Mean stiffness factor over the wave; 1 without a wave.
    pub fn mean_factor(&self) -> f64 {
        self.stiffness_wave
            .as_ref()
            .map_or(1.0, |w| w.waveform.mean())
    }

    /// Number of internal states of the law.
    pub fn internal_count(&self) -> usize {
        usize::from(matches!(
            self.law,
            ForceLaw::LaggedTorque { .. } | ForceLaw::Maxwell { .. }
        ))
    }

    /// True if the deflection, the force or a phase of the element involves coordinate z.
    pub fn touches(&self, z: usize) -> bool {
        let involves = |d: &Direction| d.terms.iter().any(|t| t.0 == z);
        let waves = self.stiffness_wave.iter().chain(&self.angle_waves);
        let by_friction = match &self.law {
            ForceLaw::LoadFriction(law) => law.directions().any(involves),
            _ => false,
        };
        by_friction
            || involves(&self.direction)
            || involves(self.force_direction())
            || waves.filter_map(|w| w.phase.angle()).any(involves)
    }

    /// Pieces at t, s; those of waves over an angle follow from the state.
    pub fn pieces_at(&self, t: f64) -> ErrorPieces<'static> {
        let imposed = self.imposed_displacement.as_ref();
        ErrorPieces {
            imposed: imposed.map_or(0, |e| e.piece(t) as u32),
            waves: &[],
        }
    }

    /// Waves over an angle, each with its phase at q, revolutions, and its active piece.
    pub fn waves_at<'b>(
        &'b self,
        t: f64,
        q: &[f64],
        pieces: ErrorPieces<'b>,
    ) -> impl Iterator<Item = (&'b PeriodicFunction, f64, usize)> {
        self.angle_waves.iter().enumerate().map(move |(k, wave)| {
            let psi = wave.phase.phase_at(t, q);
            let fixed = pieces.waves.get(k).map(|piece| *piece as usize);
            (wave, psi, fixed.unwrap_or_else(|| wave.waveform.piece(psi)))
        })
    }

    /// Deflection δ and its rate δ̇ on the given pieces of the displacement excitations.
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

    /// Number of internal states.
    pub fn internal_count(&self) -> usize {
        self.elements.iter().map(ForceElement::internal_count).sum()
    }

    /// True for constant stiffness and damping with known forces, for which exact propagation suffices.
    pub fn is_linear(&self) -> bool {
        let constant = |b: &ForceElement| b.stiffness_wave.is_none();
        self.has_linear_inputs()
            && !self.has_massless()
            && self.is_linear_in_state()
            && self.elements.iter().all(constant)
    }

    /// True if the equations are linear in the state, with coefficients that may vary in time.
    pub fn is_linear_in_state(&self) -> bool {
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

    /// True if every known function of time is piecewise linear plus harmonics.
    pub fn has_linear_inputs(&self) -> bool {
        self.signals().all(Signal::is_piecewise_linear)
    }

    /// Known functions of time: applied forces and displacement excitations.
    pub fn signals(&self) -> impl Iterator<Item = &Signal> {
        let imposed = self
            .elements
            .iter()
            .filter_map(|b| b.imposed_displacement.as_ref());
        self.forces.iter().map(|d| &d.signal).chain(imposed)
    }

    /// Frequencies of the harmonic loads and displacement excitations, rad/s.
    pub fn harmonics(&self) -> impl Iterator<Item = f64> {
        let frequencies = |signal: &Signal| -> Vec<f64> {
            let bursts = signal.bursts.iter().map(|b| b.omega);
            let harmonics = signal.harmonics.iter().map(|h| h.omega);
            harmonics.chain(bursts).collect()
        };
        let omegas = self.signals().flat_map(frequencies);
        omegas.map(f64::abs).filter(|&omega| omega != 0.0)
    }

    /// True for a model that is linear between switches: clearance, rectangular stiffness waves at imposed speed, Coulomb friction.
    pub fn is_piecewise_linear(&self) -> bool {
        self.has_linear_inputs()
            && !self.has_massless()
            && self.nonlinear_elements().next().is_none()
    }

    /// Force elements that are not linear between switches.
    pub fn nonlinear_elements(&self) -> impl Iterator<Item = &ForceElement> {
        self.elements.iter().filter(|b| {
            let linear = match &b.law {
                ForceLaw::Linear { .. } | ForceLaw::Maxwell { .. } | ForceLaw::Contact(_) => true,
                ForceLaw::Friction(friction) => {
                    let is_harmonic = |e: &Signal| !e.harmonics.is_empty();
                    friction.is_coulomb()
                        && !b.imposed_displacement.as_ref().is_some_and(is_harmonic)
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

    /// True if an element can switch at an instant that depends on the motion.
    pub fn has_events(&self) -> bool {
        self.elements.iter().any(|b| match &b.law {
            ForceLaw::Contact(contact) => {
                contact.can_open()
                    || b.stiffness_wave.as_ref().is_some_and(|w| {
                        w.phase.angle().is_some() && !matches!(w.waveform, Waveform::Fourier { .. })
                    })
            }
            law => law.is_dry_friction(),
        })
    }
}
