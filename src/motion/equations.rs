//! Equations of motion `M q̈ = f − C₀ q̇ − K₀ q − Σ u F`, in general and in one regime.

use std::f64::consts::TAU;

use super::dynamic_model::{DynamicModel, ForceLaw, MassMatrix, Regime};
use super::problem::OdeProblem;
use super::wave::WavePhase;
use crate::numeric::{Matrix, symmetric};

/// Smallest acceleration that is not set to zero, rad/s² or m/s²: ahead of a wave that runs along a chain the values are arbitrarily small,
/// and processors take a hundred times as long over subnormal numbers.
const MIN_ACCELERATION: f64 = 1e-280;

impl DynamicModel {
    /// ẏ in a regime; without one the state determines every contact state, and dry friction is spread over its creep speed.
    /// Rows of what has no equation of motion hold what must be zero ([`DynamicModel::differential_states`]).
    pub fn derivative_in(&self, regime: Option<&Regime>, t: f64, y: &[f64], dy: &mut [f64]) {
        let n = self.coordinate_count();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut g = self.applied_forces(regime, t, y);
        let mut inner = 2 * n;
        for (at, b) in self.elements.iter().enumerate() {
            match &b.law {
                ForceLaw::LaggedTorque { curve, lag } => {
                    let (_, rate) = b.deflection(t, q, v, self.error_pieces(regime, at, t));
                    dy[inner] = (curve.torque(rate) - y[inner]) / lag;
                    inner += 1;
                }
                ForceLaw::Maxwell { stiffness, damping } => {
                    let (_, rate) = b.deflection(t, q, v, self.error_pieces(regime, at, t));
                    dy[inner] = stiffness * (rate - y[inner] / damping);
                    inner += 1;
                }
                _ => {}
            }
        }
        if let Some(regime) = regime {
            let sticking = regime.sticking_pairs();
            let held = self.stick_forces(regime, t, &g, v);
            for (&at, &held) in sticking.iter().zip(&held) {
                self.elements[at]
                    .direction
                    .entries()
                    .for_each(|(i, a)| g[i] -= a * held);
            }
        }
        let forces = self.has_massless().then(|| g.clone());
        self.apply_inverse_mass(&mut g);
        for i in 0..n {
            dy[i] = v[i];
            dy[n + i] = g[i] - self.mass_damping * v[i];
        }
        if let Some(forces) = forces {
            self.algebraic_rows(regime, (t, y), &forces, dy);
        }
    }

    /// M⁻¹ g, in place; what has no inertia is not accelerated.
    pub fn apply_inverse_mass(&self, g: &mut [f64]) {
        match &self.mass {
            MassMatrix::Diagonal(mass) => g.iter_mut().zip(mass).for_each(|(x, m)| {
                let own = *x / m;
                *x = if *m == 0.0 || own.abs() < MIN_ACCELERATION {
                    0.0
                } else {
                    own
                };
            }),
            MassMatrix::Full { inverse, .. } => {
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
            MassMatrix::Diagonal(mass) => v.iter().zip(mass).map(|(x, m)| x * m).collect(),
            MassMatrix::Full { matrix, .. } => (0..v.len())
                .map(|i| (0..v.len()).map(|j| matrix[(i, j)] * v[j]).sum())
                .collect(),
        }
    }

    /// The forces with which the sticking pairs of a regime keep to their imposed motion against `g`.
    pub fn stick_forces(&self, regime: &Regime, t: f64, g: &[f64], v: &[f64]) -> Vec<f64> {
        let acceleration = |branch: usize| {
            let piece = self.imposed_piece(regime, branch) as usize;
            let e = self.elements[branch].imposed_displacement.as_ref();
            e.map_or(0.0, |e| e.curvature(t, piece))
        };
        self.constraint_forces(&regime.sticking_pairs(), g, v, acceleration)
    }

    /// The forces with which sticking pairs hold the rate of change `a` against `g`: `W M⁻¹ Wᵀ λ = W M⁻¹ (g − α M v) − a`.
    pub fn constraint_forces(
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
        self.apply_inverse_mass(&mut free);
        free.iter_mut()
            .zip(v)
            .for_each(|(a, v)| *a -= self.mass_damping * v);
        let n = self.coordinate_count();
        let columns: Vec<Vec<f64>> = sticking
            .iter()
            .map(|&at| {
                let mut w = vec![0.0; n];
                self.elements[at]
                    .direction
                    .entries()
                    .for_each(|(i, a)| w[i] += a);
                self.apply_inverse_mass(&mut w);
                w
            })
            .collect();
        let m = sticking.len();
        let row = |i: usize| &self.elements[sticking[i]].direction;
        let system = Matrix::from_fn(m, m, |i, j| row(i).dot(&columns[j]));
        let right: Vec<f64> = (0..m).map(|i| row(i).dot(&free) - a(sticking[i])).collect();
        // Pairs that hold the same motion share the force: the least one is taken.
        symmetric::solve_semidefinite(&system, &right).unwrap_or_else(|_| vec![f64::NAN; m])
    }
}

impl OdeProblem for DynamicModel {
    fn len(&self) -> usize {
        2 * self.coordinate_count() + self.internal_count()
    }

    fn derivative(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.derivative_in(None, t, y, dy);
    }

    fn next_discontinuity(&self, t: f64) -> f64 {
        let drives = self.forces.iter().map(|d| d.signal.next_knot(t));
        let imposed = self
            .elements
            .iter()
            .filter_map(|b| b.imposed_displacement.as_ref())
            .map(|e| e.next_knot(t));
        let waves = self
            .elements
            .iter()
            .filter_map(|b| b.stiffness_wave.as_ref())
            .map(|w| match w.phase {
                WavePhase::Imposed { omega, start } if omega != 0.0 => {
                    let next = w.waveform.next_piece(w.phase.phase_at(t, &[]));
                    let mut at = (next * TAU - start) / omega;
                    // The phase of an instant and the instant of a phase differ by rounding.
                    if at <= t {
                        at = (w.waveform.next_piece(next) * TAU - start) / omega;
                    }
                    at
                }
                _ => f64::INFINITY,
            });
        let followed = self.elements.iter().flat_map(|b| {
            let waves = b.stiffness_wave.iter().chain(&b.angle_waves);
            let phases = waves.map(|w| &w.phase).chain(b.law.phase());
            phases.filter_map(|phase| match phase {
                WavePhase::FollowsAngle { known, .. } => known.as_ref().map(|x| x.next_knot(t)),
                WavePhase::Imposed { .. } => None,
            })
        });
        let grips = self.elements.iter().filter_map(|b| match &b.law {
            ForceLaw::Clutch { grip, .. } => Some(grip.next_knot(t)),
            _ => None,
        });
        let paths = self.elements.iter().filter_map(|b| match &b.law {
            ForceLaw::LoadFriction(pressed) => pressed.path.as_ref().map(|path| path.next_edge(t)),
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
pub struct RegimeProblem<'a> {
    /// The machine.
    pub model: &'a DynamicModel,
    /// Regime of contacts, friction pairs and waves.
    pub regime: &'a Regime,
}

impl OdeProblem for RegimeProblem<'_> {
    fn len(&self) -> usize {
        self.model.len()
    }

    fn derivative(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.model.derivative_in(Some(self.regime), t, y, dy);
    }
}
