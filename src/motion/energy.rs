//! Mechanical energy, input power and dissipated power of a model at one instant.

use super::dynamic_model::{DynamicModel, ElementState, ForceLaw, Regime};
use crate::numeric::Matrix;

/// Powers at one instant, W.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PowerBalance {
    /// By loads, motors, imposed motions and stiffness that varies of itself.
    pub input: f64,
    /// In dampers, friction, flanks that let go.
    pub dissipated: f64,
}

impl DynamicModel {
    /// Kinetic and potential energy, J.
    pub fn mechanical_energy(&self, regime: &Regime, t: f64, y: &[f64]) -> f64 {
        let n = self.coordinate_count();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let kinetic: f64 = 0.5
            * v.iter()
                .zip(self.momentum(v))
                .map(|(v, p)| v * p)
                .sum::<f64>();
        let mut inner = 2 * n;
        let mut potential = 0.0;
        for (at, b) in self.elements.iter().enumerate() {
            let (delta, _) = b.deflection(t, q, v, self.error_pieces(Some(regime), at, t));
            potential += match (&b.law, regime.states[at]) {
                (ForceLaw::Linear { stiffness, .. }, _) => 0.5 * stiffness * delta * delta,
                (ForceLaw::Contact(contact), ElementState::Contact(state, piece)) => {
                    let g = contact.penetration(state, delta);
                    contact.stiffness * b.contact_energy((t, q), g, piece)[0]
                }
                (ForceLaw::Nonlinear { characteristic, .. }, _) => {
                    characteristic.potential_energy(delta)
                }
                (ForceLaw::Maxwell { stiffness, .. }, _) => 0.5 * y[inner] * y[inner] / stiffness,
                _ => 0.0,
            };
            inner += b.internal_count();
        }
        let general = self
            .global_matrices
            .as_ref()
            .map_or(0.0, |(k, _)| 0.5 * bilinear_form(k, q, q));
        kinetic + potential + general
    }

    /// Power lost by a branch of dry friction at an instant, W.
    pub fn friction_power(&self, regime: &Regime, t: f64, y: &[f64], branch: usize) -> f64 {
        let n = self.coordinate_count();
        let b = &self.elements[branch];
        let (_, rate) = b.deflection(
            t,
            &y[..n],
            &y[n..2 * n],
            self.error_pieces(Some(regime), branch, t),
        );
        let aside = self.transverse_friction(branch, Some(regime), t, y);
        let beside = aside.map_or(0.0, |(force, along)| force * along.dot(&y[n..2 * n]));
        self.friction_force(regime, t, y, branch) * rate + beside
    }

    /// Input and dissipated power at an instant.
    pub fn power_balance(&self, regime: &Regime, t: f64, y: &[f64]) -> PowerBalance {
        let n = self.coordinate_count();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut powers = PowerBalance::default();
        for (at, drive) in self.forces.iter().enumerate() {
            powers.input +=
                drive.signal.value(t, regime.pieces[at] as usize) * drive.direction.dot(v);
        }
        let mut inner = 2 * n;
        for (at, b) in self.elements.iter().enumerate() {
            let z = if b.internal_count() > 0 {
                y[inner]
            } else {
                0.0
            };
            inner += b.internal_count();
            let pieces = self.error_pieces(Some(regime), at, t);
            let (delta, rate) = b.deflection(t, q, v, pieces);
            let force = match b.law {
                ForceLaw::Friction(_) | ForceLaw::Clutch { .. } | ForceLaw::LoadFriction(_) => {
                    self.friction_force(regime, t, y, at)
                }
                _ => self.element_force(at, Some(regime), t, y, z).0,
            };
            // Where the force does not act along w, the difference is put in; so is what an imposed e pushes.
            let acted = b.force_direction().dot(v);
            powers.input += force * (b.direction.dot(v) - acted);
            powers.input -= b
                .imposed_displacement
                .as_ref()
                .map_or(0.0, |e| force * e.slope(t, pieces.imposed as usize));
            for (wave, psi, piece) in b.waves_at(t, q, pieces) {
                let slope = wave.waveform.slope_in(psi, piece);
                powers.input -= force * slope * wave.phase.imposed_rate(t);
            }
            match &b.law {
                ForceLaw::Linear { stiffness, .. } => {
                    powers.dissipated += (force - stiffness * delta) * rate
                }
                ForceLaw::Contact(contact) => {
                    let ElementState::Contact(state, of_wave) = regime.states[at] else {
                        continue;
                    };
                    let g = contact.penetration(state, delta);
                    let spring = b.contact_spring((t, q), g, of_wave);
                    powers.dissipated += (force - spring.secant * contact.stiffness * g) * rate;
                    if let Some(wave) = &b.stiffness_wave {
                        let [_, phase_slope] = b.contact_energy((t, q), g, of_wave);
                        let rate = phase_slope * wave.phase.imposed_rate(t);
                        powers.input += contact.stiffness * rate;
                    }
                }
                ForceLaw::Nonlinear { damping, .. } => powers.dissipated += damping * rate * rate,
                ForceLaw::Friction(_) | ForceLaw::Clutch { .. } | ForceLaw::LoadFriction(_) => {
                    powers.dissipated += self.friction_power(regime, t, y, at);
                }
                ForceLaw::TorqueSpeed(_)
                | ForceLaw::LaggedTorque { .. }
                | ForceLaw::AngleLocked { .. } => {
                    powers.input -= force * rate;
                }
                ForceLaw::Maxwell { damping, .. } => powers.dissipated += z * z / damping,
            }
        }
        powers.dissipated += self.mass_damping
            * v.iter()
                .zip(self.momentum(v))
                .map(|(v, p)| v * p)
                .sum::<f64>();
        if let Some((k, c)) = &self.global_matrices {
            powers.dissipated +=
                bilinear_form(c, v, v) + 0.5 * (bilinear_form(k, v, q) - bilinear_form(k, q, v));
        }
        powers
    }
}

/// `xᵀ A y`.
fn bilinear_form(a: &Matrix, x: &[f64], y: &[f64]) -> f64 {
    (0..x.len())
        .map(|i| x[i] * (0..y.len()).map(|j| a[(i, j)] * y[j]).sum::<f64>())
        .sum()
}
