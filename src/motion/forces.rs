//! Forces of the force elements and their derivatives ∂F/∂δ, ∂F/∂δ̇.

use std::f64::consts::TAU;

use super::contact::{ContactLaw, ContactState};
use super::dynamic_model::{
    DynamicModel, ElementState, ErrorPieces, ForceLaw, Regime, dry_friction_force,
};

impl DynamicModel {
    /// All forces on the coordinates but inertia, drag and what sticking pairs hold.
    pub fn applied_forces(&self, regime: Option<&Regime>, t: f64, y: &[f64]) -> Vec<f64> {
        let n = self.coordinate_count();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut g = vec![0.0; n];
        for (at, drive) in self.forces.iter().enumerate() {
            let piece = regime.map_or_else(|| drive.signal.piece(t), |r| r.pieces[at] as usize);
            let f = drive.signal.value(t, piece);
            drive.direction.entries().for_each(|(i, a)| g[i] += a * f);
        }
        let mut inner = 2 * n;
        for (at, b) in self.elements.iter().enumerate() {
            let z = if b.internal_count() > 0 {
                y[inner]
            } else {
                0.0
            };
            inner += b.internal_count();
            let (force, _, _) = self.element_force(at, regime, t, y, z);
            b.force_direction()
                .entries()
                .for_each(|(i, a)| g[i] -= a * force);
            if let Some((force, direction)) = self.transverse_friction(at, regime, t, y) {
                direction.entries().for_each(|(i, a)| g[i] -= a * force);
            }
            self.add_angle_terms(at, regime, t, y, force, &mut g);
        }
        if let Some((k, c)) = &self.global_matrices {
            for i in 0..n {
                g[i] -= (0..n)
                    .map(|j| k[(i, j)] * q[j] + c[(i, j)] * v[j])
                    .sum::<f64>();
            }
        }
        g
    }

    /// The force F of a branch in a regime and ∂F/∂δ, ∂F/∂δ̇; friction that sticks gives zero, its force being a reaction.
    pub fn element_force(
        &self,
        branch: usize,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
        z: f64,
    ) -> (f64, f64, f64) {
        let b = &self.elements[branch];
        let (q, v) = (
            &y[..self.coordinate_count()],
            &y[self.coordinate_count()..2 * self.coordinate_count()],
        );
        let (delta, rate) = b.deflection(t, q, v, self.error_pieces(regime, branch, t));
        match &b.law {
            ForceLaw::Contact(contact) => {
                let (state, of_wave) = self.contact_state(branch, contact, regime, t, y);
                let g = contact.penetration(state, delta);
                let spring = b.contact_spring((t, q), g, of_wave);
                let force = contact.force(state, spring.secant);
                let slope = contact.force(state, spring.tangent).deflection;
                (force.value_at(delta, rate), slope, force.rate)
            }
            ForceLaw::Friction(friction) => {
                dry_friction_force(friction, regime.map(|r| r.states[branch]), rate)
            }
            ForceLaw::Clutch { .. } | ForceLaw::LoadFriction(_) => {
                let dry = self.friction_at(branch, regime, t, y);
                dry.map_or((0.0, 0.0, 0.0), |dry| {
                    dry_friction_force(&dry, regime.map(|r| r.states[branch]), rate)
                })
            }
            ForceLaw::AngleLocked { mean, terms } => {
                let sum = |(value, slope): (f64, f64), &(n, a, phase): &(f64, f64, f64)| {
                    let (sin, cos) = (n * delta + phase).sin_cos();
                    (value + a * cos, slope - a * n * sin)
                };
                let (value, slope) = terms.iter().fold((*mean, 0.0), sum);
                (-value, -slope, 0.0)
            }
            ForceLaw::LaggedTorque { .. } => (-z, 0.0, 0.0),
            ForceLaw::Maxwell { .. } => (z, 0.0, 0.0),
            law => law.force_and_slopes(delta, rate),
        }
    }

    /// The force of a friction pair, its reaction where it sticks.
    pub fn friction_force(&self, regime: &Regime, t: f64, y: &[f64], branch: usize) -> f64 {
        let sticking = regime.sticking_pairs();
        match sticking.iter().position(|&at| at == branch) {
            None => self.element_force(branch, Some(regime), t, y, 0.0).0,
            Some(at) => {
                let n = self.coordinate_count();
                self.stick_forces(
                    regime,
                    t,
                    &self.applied_forces(Some(regime), t, y),
                    &y[n..2 * n],
                )[at]
            }
        }
    }

    /// Pieces of the displacements imposed on a branch: from the regime, else from the instant and the state.
    pub fn error_pieces<'r>(
        &self,
        regime: Option<&'r Regime>,
        branch: usize,
        t: f64,
    ) -> ErrorPieces<'r> {
        match regime {
            Some(regime) => ErrorPieces {
                imposed: self.imposed_piece(regime, branch),
                waves: regime
                    .wave_pieces
                    .get(branch)
                    .map_or(&[][..], Vec::as_slice),
            },
            None => self.elements[branch].pieces_at(t),
        }
    }

    /// Contact state and the piece of its wave: from the regime, else from the state.
    fn contact_state(
        &self,
        branch: usize,
        contact: &ContactLaw,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> (ContactState, u32) {
        if let Some(ElementState::Contact(state, piece)) = regime.map(|r| r.states[branch]) {
            return (state, piece);
        }
        let b = &self.elements[branch];
        let (q, v) = (
            &y[..self.coordinate_count()],
            &y[self.coordinate_count()..2 * self.coordinate_count()],
        );
        let piece = b
            .stiffness_wave
            .as_ref()
            .map_or(0, |w| w.waveform.piece(w.phase.phase_at(t, q)) as u32);
        let deflection = b.deflection(t, q, v, self.error_pieces(regime, branch, t));
        (b.contact_state(contact, (t, q), deflection, piece), piece)
    }

    /// Adds the terms of a wave that follows an angle: e(φ) turns the direction of its force, k(φ) adds ½ k′ g², a load table ∂V/∂φ, along
    /// the angle.
    fn add_angle_terms(
        &self,
        branch: usize,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
        force: f64,
        g: &mut [f64],
    ) {
        let b = &self.elements[branch];
        let (q, v) = (
            &y[..self.coordinate_count()],
            &y[self.coordinate_count()..2 * self.coordinate_count()],
        );
        for (wave, psi, piece) in b.waves_at(t, q, self.error_pieces(regime, branch, t)) {
            let Some(angle) = wave.phase.angle() else {
                continue;
            };
            let slope = wave.waveform.slope_in(psi, piece) / TAU;
            angle.entries().for_each(|(i, a)| g[i] += a * slope * force);
        }
        if let (Some(angle), ForceLaw::Contact(contact)) = (
            b.stiffness_wave.as_ref().and_then(|w| w.phase.angle()),
            &b.law,
        ) {
            let (state, piece) = self.contact_state(branch, contact, regime, t, y);
            let (delta, _) = b.deflection(t, q, v, self.error_pieces(regime, branch, t));
            let beyond = contact.penetration(state, delta);
            let [_, phase_slope] = b.contact_energy((t, q), beyond, piece);
            let push = contact.stiffness * phase_slope / TAU;
            angle.entries().for_each(|(i, a)| g[i] -= a * push);
        }
    }
}
