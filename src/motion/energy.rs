//! Energies and powers of a machine at an instant: what is stored, put in, lost.

use super::train::{BranchStand, Law, Regime, Train};
use super::wave::Wave;
use crate::numeric::Matrix;

/// Powers at one instant, W.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Powers {
    /// By loads, motors, imposed motions and stiffness that varies of itself.
    pub put_in: f64,
    /// In dampers, friction, flanks that let go.
    pub lost: f64,
}

impl Train {
    /// Kinetic and potential energy, J.
    pub fn stored(&self, regime: &Regime, t: f64, y: &[f64]) -> f64 {
        let n = self.n();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let kinetic: f64 = 0.5
            * v.iter()
                .zip(self.momentum(v))
                .map(|(v, p)| v * p)
                .sum::<f64>();
        let mut inner = 2 * n;
        let mut potential = 0.0;
        for (at, b) in self.branches.iter().enumerate() {
            let (delta, _) = b.deflection(t, q, v, self.imposed_piece(regime, at));
            potential += match (&b.law, regime.stands[at]) {
                (Law::Linear { stiffness, .. }, _) => 0.5 * stiffness * delta * delta,
                (Law::Contact(contact), BranchStand::Contact(stand, piece)) => {
                    contact.stored(stand, b.factor(t, q, piece).0, delta)
                }
                (Law::Nonlinear { characteristic, .. }, _) => characteristic.stored(delta),
                (Law::Maxwell { stiffness, .. }, _) => 0.5 * y[inner] * y[inner] / stiffness,
                _ => 0.0,
            };
            inner += b.inner();
        }
        let general = self
            .general
            .as_ref()
            .map_or(0.0, |(k, _)| 0.5 * form(k, q, q));
        kinetic + potential + general
    }

    /// What a branch of dry friction loses at an instant, W.
    pub fn rubbed_away(&self, regime: &Regime, t: f64, y: &[f64], branch: usize) -> f64 {
        let n = self.n();
        let b = &self.branches[branch];
        let (_, rate) = b.deflection(t, &y[..n], &y[n..2 * n], self.imposed_piece(regime, branch));
        let aside = self.aside(branch, Some(regime), t, y);
        let beside = aside.map_or(0.0, |(force, along)| force * along.dot(&y[n..2 * n]));
        self.held(regime, t, y, branch) * rate + beside
    }

    /// What is put in and lost at an instant.
    pub fn powers(&self, regime: &Regime, t: f64, y: &[f64]) -> Powers {
        let n = self.n();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut powers = Powers::default();
        for (at, drive) in self.drives.iter().enumerate() {
            powers.put_in +=
                drive.signal.value(t, regime.pieces[at] as usize) * drive.direction.dot(v);
        }
        let mut inner = 2 * n;
        for (at, b) in self.branches.iter().enumerate() {
            let z = if b.inner() > 0 { y[inner] } else { 0.0 };
            inner += b.inner();
            let piece = self.imposed_piece(regime, at);
            let (delta, rate) = b.deflection(t, q, v, piece);
            let force = match b.law {
                Law::Friction(_) | Law::Clutch { .. } | Law::Pressed(_) => {
                    self.held(regime, t, y, at)
                }
                _ => self.force(at, Some(regime), t, y, z).0,
            };
            // Where the force does not act along w, the difference is put in; so is what an imposed e pushes.
            let acted = b.acts().dot(v);
            powers.put_in += force * (b.direction.dot(v) - acted);
            powers.put_in -= b
                .imposed
                .as_ref()
                .map_or(0.0, |e| force * e.slope(t, piece as usize));
            for Wave { shape, phase } in &b.followed {
                let psi = phase.at(t, q);
                let slope = shape.slope_in(psi, shape.piece(psi));
                powers.put_in -= force * slope * phase.imposed_rate(t);
            }
            match &b.law {
                Law::Linear { stiffness, .. } => powers.lost += (force - stiffness * delta) * rate,
                Law::Contact(contact) => {
                    let BranchStand::Contact(stand, of_wave) = regime.stands[at] else {
                        continue;
                    };
                    let (factor, slope) = b.factor(t, q, of_wave);
                    let beyond = contact.beyond(stand, delta);
                    powers.lost += (force - factor * contact.stiffness * beyond) * rate;
                    if let Some(wave) = &b.variation {
                        let rate = slope * wave.phase.imposed_rate(t);
                        powers.put_in += 0.5 * contact.stiffness * rate * beyond * beyond;
                    }
                }
                Law::Nonlinear { damping, .. } => powers.lost += damping * rate * rate,
                Law::Friction(_) | Law::Clutch { .. } | Law::Pressed(_) => {
                    powers.lost += self.rubbed_away(regime, t, y, at);
                }
                Law::Curve(_) | Law::Lagged { .. } | Law::Orders { .. } => {
                    powers.put_in -= force * rate;
                }
                Law::Maxwell { damping, .. } => powers.lost += z * z / damping,
            }
        }
        powers.lost += self.drag
            * v.iter()
                .zip(self.momentum(v))
                .map(|(v, p)| v * p)
                .sum::<f64>();
        if let Some((k, c)) = &self.general {
            powers.lost += form(c, v, v) + 0.5 * (form(k, v, q) - form(k, q, v));
        }
        powers
    }
}

/// `xᵀ A y`.
fn form(a: &Matrix, x: &[f64], y: &[f64]) -> f64 {
    (0..x.len())
        .map(|i| x[i] * (0..y.len()).map(|j| a[(i, j)] * y[j]).sum::<f64>())
        .sum()
}
