//! A machine in motion: `M q̈ + C₀ q̇ + K₀ q + Σ u_b F_b(δ_b, δ̇_b, t) = Σ d f(t)`, `δ_b = w_bᵀ q − e_b`.
//!
//! The state is `y = [q, q̇, z]`, z the inner states of branches that have one.

use std::borrow::Cow;
use std::f64::consts::TAU;

use super::contact::{Contact, Stand};
use super::curve::Curve;
use super::friction::{Friction, Slip};
use super::problem::Problem;
pub use super::regime::{BranchStand, Regime};
use super::rubbing::Pressed;
use super::signal::Signal;
use super::wave::{Phase, Shape, Wave};
use crate::base::error::Error;
use crate::machine::characteristic::Characteristic;
use crate::machine::direction::Direction;
use crate::numeric::{Matrix, definite};

/// A rate this small beside the rates it is a difference of is rounding.
const ROUNDED: f64 = 64.0 * f64::EPSILON;

/// An acceleration below this, rad/s² or m/s², is none: ahead of a wave that runs along a chain stand numbers of any smallness, and
/// processors take a hundred times as long over those without all their digits.
const NOTHING: f64 = 1e-280;

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
        self.knows_lines_only()
            && !self.has_light()
            && self.branches.iter().all(|b| {
                let linear = match &b.law {
                    Law::Linear { .. } | Law::Maxwell { .. } => true,
                    Law::Contact(contact) => !contact.opens() && b.variation.is_none(),
                    Law::Curve(curve) | Law::Lagged { curve, .. } => {
                        matches!(curve, Curve::Straight { .. })
                    }
                    Law::Friction(_)
                    | Law::Clutch { .. }
                    | Law::Pressed(_)
                    | Law::Orders { .. }
                    | Law::Nonlinear { .. } => false,
                };
                linear && b.followed.is_empty()
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
        let all = self.known().flat_map(|signal| &signal.harmonics);
        all.map(|h| h.omega.abs()).filter(|&omega| omega != 0.0)
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

    /// The lines that carry every drive and every imposed e at `t`.
    pub fn pieces(&self, t: f64) -> Vec<u32> {
        let drives = self.drives.iter().map(|d| d.signal.piece(t) as u32);
        let imposed = self
            .branches
            .iter()
            .map(|b| b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32));
        drives.chain(imposed).collect()
    }

    /// How everything stands at a sample: as the method has it, else as its equations do, every dry friction spread over its creep
    /// speed. A state alone does not tell what sticks: of pairs that move together it leaves a rate of some rounding or tolerance.
    pub fn stands<'a>(&self, known: Option<&'a Regime>, t: f64, y: &[f64]) -> Cow<'a, Regime> {
        if let Some(known) = known {
            return Cow::Borrowed(known);
        }
        let mut regime = self.placed(t, y);
        for (stand, b) in regime.stands.iter_mut().zip(&self.branches) {
            if b.law.is_dry() {
                *stand = BranchStand::Smooth;
            }
        }
        Cow::Owned(regime)
    }

    /// The regime that begins at a state.
    pub fn regime(&self, t: f64, y: &[f64]) -> Regime {
        let mut regime = self.placed(t, y);
        self.let_slip(&mut regime, t, y);
        regime
    }

    /// Where every piece and every contact is at a state; friction pairs stick or slide by their rates alone.
    pub fn placed(&self, t: f64, y: &[f64]) -> Regime {
        let (q, v) = (&y[..self.n()], &y[self.n()..2 * self.n()]);
        let mut pieces = self.pieces(t);
        let stands = self.branches.iter().enumerate().map(|(at, b)| {
            let piece = pieces[self.drives.len() + at];
            match &b.law {
                Law::Contact(contact) => {
                    let of_wave = b
                        .variation
                        .as_ref()
                        .map_or(0, |w| w.shape.piece(w.phase.at(t, q)) as u32);
                    let (delta, rate) = b.deflection(t, q, v, piece);
                    BranchStand::Contact(
                        contact.stand(delta, rate, b.factor(t, q, of_wave).0),
                        of_wave,
                    )
                }
                law if law.is_dry() => {
                    let (_, rate) = b.deflection(t, q, v, piece);
                    let swept = b.direction.scaled().map(|(i, a)| (a * v[i]).abs());
                    let imposed = b
                        .imposed
                        .as_ref()
                        .map_or(0.0, |e| e.slope(t, piece as usize));
                    let rounding = ROUNDED * (swept.sum::<f64>() + imposed.abs());
                    BranchStand::Friction(match rate {
                        r if r > rounding => Slip::Forward,
                        r if r < -rounding => Slip::Backward,
                        _ => Slip::Stick,
                    })
                }
                _ => BranchStand::Smooth,
            }
        });
        let stands = stands.collect();
        if self.has_paths() {
            pieces.extend((0..self.branches.len()).map(|at| self.path_piece(at, t, q)));
        }
        Regime { pieces, stands }
    }

    /// Of pairs at rest those that would have to hold more than their breakaway force start to slide, the most overloaded first.
    pub fn let_slip(&self, regime: &mut Regime, t: f64, y: &[f64]) {
        let n = self.n();
        loop {
            let sticking = regime.sticking();
            if sticking.is_empty() {
                return;
            }
            let held = self.holding(regime, t, &self.pushed(Some(regime), t, y), &y[n..2 * n]);
            let over = |(&at, &held): (&usize, &f64)| {
                let breakaway = self.dry(at, Some(regime), t, y)?.breakaway;
                (held.abs() > breakaway).then(|| (at, held, held.abs() / breakaway))
            };
            let worst = sticking
                .iter()
                .zip(&held)
                .filter_map(over)
                .max_by(|a, b| a.2.total_cmp(&b.2));
            let Some((at, held, _)) = worst else {
                return;
            };
            let slip = if held > 0.0 {
                Slip::Forward
            } else {
                Slip::Backward
            };
            regime.stands[at] = BranchStand::Friction(slip);
        }
    }

    /// The line a regime has for the imposed e of a branch.
    pub fn imposed_piece(&self, regime: &Regime, branch: usize) -> u32 {
        regime.pieces[self.drives.len() + branch]
    }

    /// The force F of a branch in a regime and ∂F/∂δ, ∂F/∂δ̇; friction that sticks gives zero, its force being a reaction.
    pub fn force(
        &self,
        branch: usize,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
        z: f64,
    ) -> (f64, f64, f64) {
        let b = &self.branches[branch];
        let (q, v) = (&y[..self.n()], &y[self.n()..2 * self.n()]);
        let (delta, rate) = b.deflection(t, q, v, self.line(regime, branch, t));
        match &b.law {
            Law::Linear { stiffness, damping } => {
                (stiffness * delta + damping * rate, *stiffness, *damping)
            }
            Law::Contact(contact) => {
                let (stand, of_wave) = self.contact(branch, contact, regime, t, y);
                let force = contact.force(stand, b.factor(t, q, of_wave).0);
                (force.at(delta, rate), force.deflection, force.rate)
            }
            Law::Friction(friction) => rubbed(friction, regime.map(|r| r.stands[branch]), rate),
            Law::Clutch { .. } | Law::Pressed(_) => {
                let dry = self.dry(branch, regime, t, y);
                dry.map_or((0.0, 0.0, 0.0), |dry| {
                    rubbed(&dry, regime.map(|r| r.stands[branch]), rate)
                })
            }
            Law::Orders { mean, terms } => {
                let sum = |(value, slope): (f64, f64), &(n, a, phase): &(f64, f64, f64)| {
                    let (sin, cos) = (n * delta + phase).sin_cos();
                    (value + a * cos, slope - a * n * sin)
                };
                let (value, slope) = terms.iter().fold((*mean, 0.0), sum);
                (-value, -slope, 0.0)
            }
            Law::Curve(curve) => (-curve.torque(rate), 0.0, -curve.slope(rate)),
            Law::Lagged { .. } => (-z, 0.0, 0.0),
            Law::Maxwell { .. } => (z, 0.0, 0.0),
            Law::Nonlinear {
                characteristic,
                damping,
            } => (
                characteristic.force(delta) + damping * rate,
                characteristic.tangent(delta),
                *damping,
            ),
        }
    }

    /// M⁻¹ g, in place; what has no inertia is not accelerated.
    pub fn accelerate(&self, g: &mut [f64]) {
        match &self.mass {
            Mass::Diagonal(mass) => g.iter_mut().zip(mass).for_each(|(x, m)| {
                let own = *x / m;
                *x = if *m == 0.0 || own.abs() < NOTHING {
                    0.0
                } else {
                    own
                };
            }),
            Mass::Full { inverse, .. } => {
                let force = g.to_vec();
                for (i, x) in g.iter_mut().enumerate() {
                    *x = force
                        .iter()
                        .enumerate()
                        .map(|(j, f)| inverse[(i, j)] * f)
                        .sum();
                }
            }
        }
    }

    /// M v.
    pub fn momentum(&self, v: &[f64]) -> Vec<f64> {
        match &self.mass {
            Mass::Diagonal(mass) => v.iter().zip(mass).map(|(x, m)| x * m).collect(),
            Mass::Full { matrix, .. } => (0..v.len())
                .map(|i| (0..v.len()).map(|j| matrix[(i, j)] * v[j]).sum())
                .collect(),
        }
    }

    /// ẏ in a regime; without one every contact stands where the state puts it, and dry friction is spread over its creep speed.
    /// Rows of what has no equation of motion hold what must be zero ([`Train::moving_states`]).
    pub fn slope_in(&self, regime: Option<&Regime>, t: f64, y: &[f64], dy: &mut [f64]) {
        let n = self.n();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut g = self.pushed(regime, t, y);
        let mut inner = 2 * n;
        for (at, b) in self.branches.iter().enumerate() {
            match &b.law {
                Law::Lagged { curve, lag } => {
                    let (_, rate) = b.deflection(t, q, v, self.line(regime, at, t));
                    dy[inner] = (curve.torque(rate) - y[inner]) / lag;
                    inner += 1;
                }
                Law::Maxwell { stiffness, damping } => {
                    let (_, rate) = b.deflection(t, q, v, self.line(regime, at, t));
                    dy[inner] = stiffness * (rate - y[inner] / damping);
                    inner += 1;
                }
                _ => {}
            }
        }
        if let Some(regime) = regime {
            let sticking = regime.sticking();
            let held = self.holding(regime, t, &g, v);
            for (&at, &held) in sticking.iter().zip(&held) {
                self.branches[at]
                    .direction
                    .scaled()
                    .for_each(|(i, a)| g[i] -= a * held);
            }
        }
        let forces = self.has_light().then(|| g.clone());
        self.accelerate(&mut g);
        for i in 0..n {
            dy[i] = v[i];
            dy[n + i] = g[i] - self.drag * v[i];
        }
        if let Some(forces) = forces {
            self.light_rows(regime, (t, y), &forces, dy);
        }
    }

    /// All forces on the coordinates but inertia, drag and what sticking pairs hold.
    pub fn pushed(&self, regime: Option<&Regime>, t: f64, y: &[f64]) -> Vec<f64> {
        let n = self.n();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut g = vec![0.0; n];
        for (at, drive) in self.drives.iter().enumerate() {
            let piece = regime.map_or_else(|| drive.signal.piece(t), |r| r.pieces[at] as usize);
            let f = drive.signal.value(t, piece);
            drive.direction.scaled().for_each(|(i, a)| g[i] += a * f);
        }
        let mut inner = 2 * n;
        for (at, b) in self.branches.iter().enumerate() {
            let z = if b.inner() > 0 { y[inner] } else { 0.0 };
            inner += b.inner();
            let (force, _, _) = self.force(at, regime, t, y, z);
            b.acts().scaled().for_each(|(i, a)| g[i] -= a * force);
            if let Some((force, direction)) = self.aside(at, regime, t, y) {
                direction.scaled().for_each(|(i, a)| g[i] -= a * force);
            }
            self.follow(at, regime, t, y, force, &mut g);
        }
        if let Some((k, c)) = &self.general {
            for i in 0..n {
                g[i] -= (0..n)
                    .map(|j| k[(i, j)] * q[j] + c[(i, j)] * v[j])
                    .sum::<f64>();
            }
        }
        g
    }

    /// The force of a friction pair, its reaction where it sticks.
    pub fn held(&self, regime: &Regime, t: f64, y: &[f64], branch: usize) -> f64 {
        let sticking = regime.sticking();
        match sticking.iter().position(|&at| at == branch) {
            None => self.force(branch, Some(regime), t, y, 0.0).0,
            Some(at) => {
                let n = self.n();
                self.holding(regime, t, &self.pushed(Some(regime), t, y), &y[n..2 * n])[at]
            }
        }
    }

    /// Which line carries the imposed e of a branch.
    fn line(&self, regime: Option<&Regime>, branch: usize, t: f64) -> u32 {
        match regime {
            Some(regime) => self.imposed_piece(regime, branch),
            None => self.branches[branch]
                .imposed
                .as_ref()
                .map_or(0, |e| e.piece(t) as u32),
        }
    }

    /// How a contact stands and which piece carries its wave: as the regime has it, else as the state puts it.
    fn contact(
        &self,
        branch: usize,
        contact: &Contact,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> (Stand, u32) {
        if let Some(BranchStand::Contact(stand, piece)) = regime.map(|r| r.stands[branch]) {
            return (stand, piece);
        }
        let b = &self.branches[branch];
        let (q, v) = (&y[..self.n()], &y[self.n()..2 * self.n()]);
        let piece = b
            .variation
            .as_ref()
            .map_or(0, |w| w.shape.piece(w.phase.at(t, q)) as u32);
        let (delta, rate) = b.deflection(t, q, v, self.line(regime, branch, t));
        (contact.stand(delta, rate, b.factor(t, q, piece).0), piece)
    }

    /// What a wave that follows an angle adds: e(φ) turns the direction of its force, k(φ) adds ½ k′ g² along the angle.
    fn follow(
        &self,
        branch: usize,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
        force: f64,
        g: &mut [f64],
    ) {
        let b = &self.branches[branch];
        let (q, v) = (&y[..self.n()], &y[self.n()..2 * self.n()]);
        for Wave { shape, phase } in &b.followed {
            let Some(angle) = phase.angle() else { continue };
            let psi = phase.at(t, q);
            let slope = shape.slope_in(psi, shape.piece(psi)) / TAU;
            angle.scaled().for_each(|(i, a)| g[i] += a * slope * force);
        }
        if let (Some(angle), Law::Contact(contact)) =
            (b.variation.as_ref().and_then(|w| w.phase.angle()), &b.law)
        {
            let (stand, piece) = self.contact(branch, contact, regime, t, y);
            let (delta, _) = b.deflection(t, q, v, self.line(regime, branch, t));
            let beyond = contact.beyond(stand, delta);
            let push = 0.5 * contact.stiffness * b.factor(t, q, piece).1 / TAU * beyond * beyond;
            angle.scaled().for_each(|(i, a)| g[i] -= a * push);
        }
    }

    /// The forces with which the sticking pairs of a regime keep to their imposed motion against `g`.
    pub fn holding(&self, regime: &Regime, t: f64, g: &[f64], v: &[f64]) -> Vec<f64> {
        let acceleration = |branch: usize| {
            let piece = self.imposed_piece(regime, branch) as usize;
            let e = self.branches[branch].imposed.as_ref();
            e.map_or(0.0, |e| e.curvature(t, piece))
        };
        self.reactions(&regime.sticking(), g, v, acceleration)
    }

    /// The forces with which sticking pairs hold the rate of change `a` against `g`: `W M⁻¹ Wᵀ λ = W M⁻¹ (g − α M v) − a`.
    pub fn reactions(
        &self,
        sticking: &[usize],
        g: &[f64],
        v: &[f64],
        a: impl Fn(usize) -> f64,
    ) -> Vec<f64> {
        if sticking.is_empty() {
            return Vec::new();
        }
        let mut free = g.to_vec();
        self.accelerate(&mut free);
        free.iter_mut()
            .zip(v)
            .for_each(|(a, v)| *a -= self.drag * v);
        let n = self.n();
        let columns: Vec<Vec<f64>> = sticking
            .iter()
            .map(|&at| {
                let mut w = vec![0.0; n];
                self.branches[at]
                    .direction
                    .scaled()
                    .for_each(|(i, a)| w[i] += a);
                self.accelerate(&mut w);
                w
            })
            .collect();
        let m = sticking.len();
        let row = |i: usize| &self.branches[sticking[i]].direction;
        let system = Matrix::from_fn(m, m, |i, j| row(i).dot(&columns[j]));
        let right: Vec<f64> = (0..m).map(|i| row(i).dot(&free) - a(sticking[i])).collect();
        // Pairs that hold the same motion share the force: the least one is taken.
        definite::solve_semidefinite(&system, &right).unwrap_or_else(|_| vec![f64::NAN; m])
    }
}

impl Problem for Train {
    fn len(&self) -> usize {
        2 * self.n() + self.inner()
    }

    fn slope(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.slope_in(None, t, y, dy);
    }

    fn next_break(&self, t: f64) -> f64 {
        let drives = self.drives.iter().map(|d| d.signal.next_knot(t));
        let imposed = self
            .branches
            .iter()
            .filter_map(|b| b.imposed.as_ref())
            .map(|e| e.next_knot(t));
        let waves = self
            .branches
            .iter()
            .filter_map(|b| b.variation.as_ref())
            .map(|w| match w.phase {
                Phase::Imposed { omega, start } if omega != 0.0 => {
                    let next = w.shape.next_piece(w.phase.at(t, &[]));
                    let mut at = (next * TAU - start) / omega;
                    // The phase of an instant and the instant of a phase differ by rounding.
                    if at <= t {
                        at = (w.shape.next_piece(next) * TAU - start) / omega;
                    }
                    at
                }
                _ => f64::INFINITY,
            });
        let followed = self.branches.iter().flat_map(|b| {
            let waves = b.variation.iter().chain(&b.followed);
            let phases = waves.map(|w| &w.phase).chain(b.law.phase());
            phases.filter_map(|phase| match phase {
                Phase::Followed { known, .. } => known.as_ref().map(|x| x.next_knot(t)),
                Phase::Imposed { .. } => None,
            })
        });
        let grips = self.branches.iter().filter_map(|b| match &b.law {
            Law::Clutch { grip, .. } => Some(grip.next_knot(t)),
            _ => None,
        });
        let paths = self.branches.iter().filter_map(|b| match &b.law {
            Law::Pressed(pressed) => pressed.path.as_ref().map(|path| path.next_edge(t)),
            _ => None,
        });
        drives
            .chain(imposed)
            .chain(paths)
            .chain(waves)
            .chain(followed)
            .chain(grips)
            .fold(f64::INFINITY, f64::min)
    }
}

/// A machine held in one regime.
pub struct Frozen<'a> {
    /// The machine.
    pub train: &'a Train,
    /// How everything stands.
    pub regime: &'a Regime,
}

impl Problem for Frozen<'_> {
    fn len(&self) -> usize {
        self.train.len()
    }

    fn slope(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.train.slope_in(Some(self.regime), t, y, dy);
    }
}
