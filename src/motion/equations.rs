//! Equations of motion `M q̈ = f − C₀ q̇ − K₀ q − Σ u F`, with or without a fixed regime.

use std::f64::consts::TAU;

use super::dynamic_model::{DynamicModel, ForceLaw, MassMatrix, Regime};
use super::problem::OdeProblem;
use super::wave::WavePhase;
use crate::numeric::{Matrix, symmetric};

/// Smallest acceleration that is not set to zero, rad/s² or m/s². Values ahead of a wave front in a chain are arbitrarily small, and
/// arithmetic on subnormal numbers is about a hundred times slower.
const MIN_ACCELERATION: f64 = 1e-280;

impl DynamicModel {
    /// Derivative ẏ in a regime. Without a regime the contact states follow from y and dry friction is regularised. Algebraic rows
    /// hold the residual that must vanish ([`DynamicModel::differential_states`]).
    pub fn derivative_in(&self, regime: Option<&Regime>, t: f64, y: &[f64], dy: &mut [f64]) {
        let n = self.coordinate_count();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut g = self.applied_forces(regime, t, y);
        let mut internal = 2 * n;
        for (element, b) in self.elements.iter().enumerate() {
            match &b.law {
                ForceLaw::LaggedTorque { curve, lag } => {
                    let (_, rate) = b.deflection(t, q, v, self.error_pieces(regime, element, t));
                    dy[internal] = (curve.torque(rate) - y[internal]) / lag;
                    internal += 1;
                }
                ForceLaw::Maxwell { stiffness, damping } => {
                    let (_, rate) = b.deflection(t, q, v, self.error_pieces(regime, element, t));
                    dy[internal] = stiffness * (rate - y[internal] / damping);
                    internal += 1;
                }
                _ => {}
            }
        }
        if let Some(regime) = regime {
            let sticking = regime.sticking_pairs();
            let reactions = self.stick_forces(regime, t, &g, v);
            for (&element, &reaction) in sticking.iter().zip(&reactions) {
                self.elements[element]
                    .direction
                    .entries()
                    .for_each(|(i, a)| g[i] -= a * reaction);
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

    /// Product M⁻¹ g, in place; zero for massless coordinates.
    pub fn apply_inverse_mass(&self, g: &mut [f64]) {
        match &self.mass {
            MassMatrix::Diagonal(mass) => g.iter_mut().zip(mass).for_each(|(x, m)| {
                let a = *x / m;
                *x = if *m == 0.0 || a.abs() < MIN_ACCELERATION {
                    0.0
                } else {
                    a
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

    /// Momentum M v.
    pub fn momentum(&self, v: &[f64]) -> Vec<f64> {
        match &self.mass {
            MassMatrix::Diagonal(mass) => v.iter().zip(mass).map(|(x, m)| x * m).collect(),
            MassMatrix::Full { matrix, .. } => (0..v.len())
                .map(|i| (0..v.len()).map(|j| matrix[(i, j)] * v[j]).sum())
                .collect(),
        }
    }

    /// Constraint forces of the sticking pairs of a regime under the forces `g`.
    pub fn stick_forces(&self, regime: &Regime, t: f64, g: &[f64], v: &[f64]) -> Vec<f64> {
        let acceleration = |branch: usize| {
            let piece = self.imposed_piece(regime, branch) as usize;
            let e = self.elements[branch].imposed_displacement.as_ref();
            e.map_or(0.0, |e| e.curvature(t, piece))
        };
        self.constraint_forces(&regime.sticking_pairs(), g, v, acceleration)
    }

    /// Constraint forces λ of sticking pairs with the relative acceleration `a` under the forces `g`: `W M⁻¹ Wᵀ λ = W M⁻¹ (g − α M v) − a`.
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
        let mut acc = g.to_vec();
        self.apply_inverse_mass(&mut acc);
        acc.iter_mut()
            .zip(v)
            .for_each(|(a, v)| *a -= self.mass_damping * v);
        let n = self.coordinate_count();
        let columns: Vec<Vec<f64>> = sticking
            .iter()
            .map(|&branch| {
                let mut w = vec![0.0; n];
                self.elements[branch]
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
        let rhs: Vec<f64> = (0..m).map(|i| row(i).dot(&acc) - a(sticking[i])).collect();
        // Redundant constraints: minimum-norm solution.
        symmetric::solve_semidefinite(&system, &rhs).unwrap_or_else(|_| vec![f64::NAN; m])
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
                    let mut time = (next * TAU - start) / omega;
                    // Phase and time are inverse to each other only up to rounding.
                    if time <= t {
                        time = (w.waveform.next_piece(next) * TAU - start) / omega;
                    }
                    time
                }
                _ => f64::INFINITY,
            });
        let angles = self.elements.iter().flat_map(|b| {
            let waves = b.stiffness_wave.iter().chain(&b.angle_waves);
            let phases = waves.map(|w| &w.phase).chain(b.law.phase());
            phases.filter_map(|phase| match phase {
                WavePhase::FollowsAngle { known, .. } => known.as_ref().map(|x| x.next_knot(t)),
                WavePhase::Imposed { .. } => None,
            })
        });
        let clutches = self.elements.iter().filter_map(|b| match &b.law {
            ForceLaw::Clutch { capacity, .. } => Some(capacity.next_knot(t)),
            _ => None,
        });
        let paths = self.elements.iter().filter_map(|b| match &b.law {
            ForceLaw::LoadFriction(law) => law.path.as_ref().map(|path| path.next_edge(t)),
            _ => None,
        });
        drives
            .chain(imposed)
            .chain(paths)
            .chain(waves)
            .chain(angles)
            .chain(clutches)
            .fold(f64::INFINITY, f64::min)
    }
}

/// Dynamic model in a fixed regime.
pub struct RegimeProblem<'a> {
    /// Dynamic model of the machine.
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
