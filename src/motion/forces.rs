//! The forces of branches, and what they push.

use std::f64::consts::TAU;

use super::contact::{Contact, Stand};
use super::train::{BranchStand, Law, Regime, Train, rubbed};
use super::wave::Wave;

impl Train {
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
            Law::Lagged { .. } => (-z, 0.0, 0.0),
            Law::Maxwell { .. } => (z, 0.0, 0.0),
            law => law.force_and_slopes(delta, rate),
        }
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
    pub fn line(&self, regime: Option<&Regime>, branch: usize, t: f64) -> u32 {
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
}
