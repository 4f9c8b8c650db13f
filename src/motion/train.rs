//! A machine in motion: `M q̈ + C₀ q̇ + K₀ q + Σ u_b F_b(δ_b, δ̇_b, t) = Σ d f(t)`, `δ_b = w_bᵀ q − e_b`.
//!
//! The state is `y = [q, q̇, z]`, z the inner states of branches that have one.

use super::contact::Contact;
use super::curve::Curve;
use super::friction::{Friction, Slip};
pub use super::regime::{BranchStand, Regime};
use super::rubbing::Pressed;
use super::signal::Signal;
use super::wave::{Phase, Shape, Wave};
use crate::base::error::Error;
use crate::machine::characteristic::Characteristic;
use crate::machine::direction::Direction;
use crate::numeric::{Matrix, definite};

/// A machine in motion.
#[derive(Debug, Clone)]
pub struct Train {
    /// Names of the coordinates, `node.axis`.
    pub coordinates: Vec<String>,
    /// M.
    pub mass: Mass,
    /// What resists.
    pub branches: Vec<Branch>,
    /// What pushes.
    pub drives: Vec<Drive>,
    /// Rayleigh's α: `C₀ ∋ α M`, 1/s.
    pub drag: f64,
    /// K₀ and C₀ that belong to no branch: gyroscopic and centrifugal terms, modal damping.
    pub general: Option<(Matrix, Matrix)>,
}

/// The inertia.
#[derive(Debug, Clone)]
pub enum Mass {
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

impl Mass {
    /// Coupled; what has no inertia has no part in the inverse.
    ///
    /// # Errors
    /// A matrix that is not positive over what has inertia.
    pub fn full(matrix: Matrix) -> Result<Mass, Error> {
        let n = matrix.nrows();
        let heavy: Vec<usize> = (0..n).filter(|&j| matrix[(j, j)] != 0.0).collect();
        let m = heavy.len();
        let block = Matrix::from_fn(m, m, |i, j| matrix[(heavy[i], heavy[j])]);
        definite::cholesky(&block)?;
        let inner = definite::solve(&block, &Matrix::identity(m, m))?;
        let mut inverse = Matrix::zeros(n, n);
        for (a, &i) in heavy.iter().enumerate() {
            for (b, &j) in heavy.iter().enumerate() {
                inverse[(i, j)] = inner[(a, b)];
            }
        }
        Ok(Mass::Full { matrix, inverse })
    }

    /// An element of M.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        match self {
            Mass::Diagonal(mass) if i == j => mass[i],
            Mass::Diagonal(_) => 0.0,
            Mass::Full { matrix, .. } => matrix[(i, j)],
        }
    }

    /// M.
    pub fn matrix(&self) -> Matrix {
        match self {
            Mass::Diagonal(mass) => Matrix::from_fn(mass.len(), mass.len(), |i, j| self.at(i, j)),
            Mass::Full { matrix, .. } => matrix.clone(),
        }
    }
}

/// A torque or force along a direction.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Its name.
    pub name: String,
    /// d.
    pub direction: Direction,
    /// f(t).
    pub signal: Signal,
}

/// A scalar law between coordinates.
#[derive(Debug, Clone)]
pub struct Branch {
    /// Its name.
    pub name: String,
    /// w.
    pub direction: Direction,
    /// u, where the force does not act along w.
    pub force: Option<Direction>,
    /// F.
    pub law: Law,
    /// The wave of its stiffness, a factor of mean about one.
    pub variation: Option<Wave>,
    /// e imposed in time.
    pub imposed: Option<Signal>,
    /// e that follows angles: the sum of these.
    pub followed: Vec<Wave>,
}

/// How a branch resists.
#[derive(Debug, Clone)]
pub enum Law {
    /// `F = k δ + c δ̇`.
    Linear {
        /// k.
        stiffness: f64,
        /// c.
        damping: f64,
    },
    /// Play, or a stiffness with a wave.
    Contact(Contact),
    /// Dry friction.
    Friction(Friction),
    /// Dry friction pressed together over time: a clutch.
    Clutch {
        /// At full capacity.
        friction: Friction,
        /// The share of it, from 0 to 1.
        grip: Signal,
    },
    /// Dry friction that goes by forces of the machine: of bearings, of teeth.
    Pressed(Box<Pressed>),
    /// `F = −(mean + Σ a cos(n δ + φ))`: a load whose orders are locked to the angle it acts on.
    Orders {
        /// N·m.
        mean: f64,
        /// n per turn, N·m, rad.
        terms: Vec<(f64, f64, f64)>,
    },
    /// `F = −T(δ̇)`: a motor or brake.
    Curve(Curve),
    /// `F = −z`, `ż = (T(δ̇) − z)/lag`: a motor whose torque follows late.
    Lagged {
        /// T.
        curve: Curve,
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

impl Law {
    /// `(F, ∂F/∂δ, ∂F/∂δ̇)` of a law without memory, contact or dry friction; zero for every other law.
    pub fn force_and_slopes(&self, delta: f64, rate: f64) -> (f64, f64, f64) {
        match self {
            Law::Linear { stiffness, damping } => {
                (stiffness * delta + damping * rate, *stiffness, *damping)
            }
            Law::Curve(curve) => (-curve.torque(rate), 0.0, -curve.slope(rate)),
            Law::Nonlinear {
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

    /// What carries its path of contact on, where it has one.
    pub fn phase(&self) -> Option<&Phase> {
        match self {
            Law::Pressed(pressed) => pressed.path.as_ref()?.phase.as_ref(),
            _ => None,
        }
    }

    /// It is dry friction.
    pub fn is_dry(&self) -> bool {
        matches!(
            self,
            Law::Friction(_) | Law::Clutch { .. } | Law::Pressed(_)
        )
    }
}

/// The force of dry friction as it stands, 0, and d/dδ̇; where nothing says how it stands, its step is spread over the creep speed.
pub fn rubbed(friction: &Friction, stand: Option<BranchStand>, rate: f64) -> (f64, f64, f64) {
    match stand {
        Some(BranchStand::Friction(Slip::Stick)) => (0.0, 0.0, 0.0),
        Some(BranchStand::Friction(slip)) => (
            friction.sliding(slip, rate),
            0.0,
            friction.slope(slip, rate),
        ),
        _ => {
            let (force, slope) = friction.smoothed(rate);
            (force, 0.0, slope)
        }
    }
}

impl Branch {
    /// The direction its force acts in.
    pub fn acts(&self) -> &Direction {
        self.force.as_ref().unwrap_or(&self.direction)
    }

    /// The largest factor of its stiffness over its wave; one without.
    pub fn greatest_factor(&self) -> f64 {
        let wave = self.variation.as_ref();
        wave.map_or(1.0, |w| w.shape.greatest().abs().max(w.shape.least().abs()))
    }

    /// The mean factor of its stiffness over its wave; one without.
    pub fn mean_factor(&self) -> f64 {
        self.variation.as_ref().map_or(1.0, |w| w.shape.mean())
    }

    /// Inner states of its law.
    pub fn inner(&self) -> usize {
        usize::from(matches!(self.law, Law::Lagged { .. } | Law::Maxwell { .. }))
    }

    /// A coordinate moves it, is moved by it, or carries on its phase.
    pub fn touches(&self, z: usize) -> bool {
        let along = |d: &Direction| d.terms.iter().any(|t| t.0 == z);
        let waves = self.variation.iter().chain(&self.followed);
        let rubs = match &self.law {
            Law::Pressed(pressed) => pressed.along().any(along),
            _ => false,
        };
        rubs || along(&self.direction)
            || along(self.acts())
            || waves.filter_map(|w| w.phase.angle()).any(along)
    }

    /// δ and δ̇. An imposed e is on the line `piece`.
    pub fn deflection(&self, t: f64, q: &[f64], v: &[f64], piece: u32) -> (f64, f64) {
        let (mut delta, mut rate) = (self.direction.dot(q), self.direction.dot(v));
        if let Some(e) = &self.imposed {
            delta -= e.value(t, piece as usize);
            rate -= e.slope(t, piece as usize);
        }
        for wave in &self.followed {
            let psi = wave.phase.at(t, q);
            let at = wave.shape.piece(psi);
            delta -= wave.shape.value_in(psi, at);
            rate -= wave.shape.slope_in(psi, at) * wave.phase.rate(t, v);
        }
        (delta, rate)
    }

    /// The value of its stiffness wave on a piece of it, and d/dψ.
    pub fn factor(&self, t: f64, q: &[f64], piece: u32) -> (f64, f64) {
        match &self.variation {
            None => (1.0, 0.0),
            Some(wave) => {
                let psi = wave.phase.at(t, q);
                (
                    wave.shape.value_in(psi, piece as usize),
                    wave.shape.slope_in(psi, piece as usize),
                )
            }
        }
    }
}

impl Train {
    /// How many coordinates there are.
    pub fn n(&self) -> usize {
        self.coordinates.len()
    }

    /// How many inner states there are.
    pub fn inner(&self) -> usize {
        self.branches.iter().map(Branch::inner).sum()
    }

    /// Nothing but constant stiffness and damping and known forces: exact propagation suffices.
    pub fn is_linear(&self) -> bool {
        let constant = |b: &Branch| b.variation.is_none();
        self.knows_lines_only()
            && !self.has_light()
            && self.superposes()
            && self.branches.iter().all(constant)
    }

    /// The equations are linear in the state, whatever varies in time: differences of motions do not depend on the motions.
    pub fn superposes(&self) -> bool {
        self.branches.iter().all(|b| {
            let linear = match &b.law {
                Law::Linear { .. } | Law::Maxwell { .. } => true,
                Law::Contact(contact) => !contact.opens(),
                Law::Curve(curve) | Law::Lagged { curve, .. } => {
                    matches!(curve, Curve::Straight { .. })
                }
                Law::Friction(_)
                | Law::Clutch { .. }
                | Law::Pressed(_)
                | Law::Orders { .. }
                | Law::Nonlinear { .. } => false,
            };
            let known = |wave: &Wave| wave.phase.angle().is_none();
            linear && b.followed.is_empty() && b.variation.as_ref().is_none_or(known)
        })
    }

    /// Known functions of time are lines and harmonics, none of them parabolas.
    pub fn knows_lines_only(&self) -> bool {
        self.known().all(Signal::is_straight)
    }

    /// Known functions of time: what drives and what is imposed.
    fn known(&self) -> impl Iterator<Item = &Signal> {
        let imposed = self.branches.iter().filter_map(|b| b.imposed.as_ref());
        self.drives.iter().map(|d| &d.signal).chain(imposed)
    }

    /// Frequencies of harmonic loads and errors, rad/s.
    pub fn harmonics(&self) -> impl Iterator<Item = f64> {
        let lasting = |signal: &Signal| -> Vec<f64> {
            let bursts = signal.bursts.iter().map(|b| b.omega);
            let harmonics = signal.harmonics.iter().map(|h| h.omega);
            harmonics.chain(bursts).collect()
        };
        let all = self.known().flat_map(lasting);
        all.map(f64::abs).filter(|&omega| omega != 0.0)
    }

    /// Linear between switches: contacts with play, stiffness in steps at imposed speed, Coulomb friction.
    pub fn is_piecewise_linear(&self) -> bool {
        self.knows_lines_only() && !self.has_light() && self.bent().next().is_none()
    }

    /// Branches that are not linear between switches.
    pub fn bent(&self) -> impl Iterator<Item = &Branch> {
        self.branches.iter().filter(|b| {
            let linear = match &b.law {
                Law::Linear { .. } | Law::Maxwell { .. } | Law::Contact(_) => true,
                Law::Friction(friction) => {
                    let swings = |e: &Signal| !e.harmonics.is_empty();
                    friction.is_coulomb() && !b.imposed.as_ref().is_some_and(swings)
                }
                Law::Curve(curve) | Law::Lagged { curve, .. } => {
                    matches!(curve, Curve::Straight { .. })
                }
                Law::Clutch { .. }
                | Law::Pressed(_)
                | Law::Orders { .. }
                | Law::Nonlinear { .. } => false,
            };
            let steps = b
                .variation
                .as_ref()
                .is_none_or(|w| w.shape.is_steps() && w.phase.angle().is_none());
            !(linear && steps && b.followed.is_empty())
        })
    }

    /// Something can switch at an instant that the motion decides.
    pub fn has_events(&self) -> bool {
        self.branches.iter().any(|b| match &b.law {
            Law::Contact(contact) => {
                contact.opens()
                    || b.variation.as_ref().is_some_and(|w| {
                        w.phase.angle().is_some() && !matches!(w.shape, Shape::Fourier { .. })
                    })
            }
            law => law.is_dry(),
        })
    }
}
