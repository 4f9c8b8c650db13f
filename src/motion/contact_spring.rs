//! Spring of a contact at one phase: `F = k w(ψ) g` of a stiffness wave, `F(g, ψ)` of a load table, g the penetration.

use super::contact::{ContactLaw, ContactState};
use super::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::gear::load::load_table::LoadCurve;

/// The spring of a contact at a penetration, over its stiffness k.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSpring {
    /// `F/(k g)`.
    pub secant: f64,
    /// `∂F/∂g / k`.
    pub tangent: f64,
}

impl ForceElement {
    /// The value of its stiffness wave on a piece of it, and d/dψ.
    pub fn factor(&self, t: f64, q: &[f64], piece: u32) -> (f64, f64) {
        match &self.stiffness_wave {
            None => (1.0, 0.0),
            Some(wave) => {
                let psi = wave.phase.phase_at(t, q);
                (
                    wave.waveform.value_in(psi, piece as usize),
                    wave.waveform.slope_in(psi, piece as usize),
                )
            }
        }
    }

    /// The spring at a penetration on a piece of its wave.
    pub fn contact_spring(&self, at: (f64, &[f64]), g: f64, piece: u32) -> ContactSpring {
        let Some((curve, _)) = self.load_curve(at, piece) else {
            let (factor, _) = self.factor(at.0, at.1, piece);
            return ContactSpring {
                secant: factor,
                tangent: factor,
            };
        };
        let point = curve.at_deflection(g);
        ContactSpring {
            secant: if g == 0.0 {
                point.tangent
            } else {
                point.load / g
            },
            tangent: point.tangent,
        }
    }

    /// Potential energy over k at a penetration on a piece of its wave, m² or rad², and its derivative by the phase in periods.
    pub fn contact_energy(&self, at: (f64, &[f64]), g: f64, piece: u32) -> [f64; 2] {
        let Some((curve, positions)) = self.load_curve(at, piece) else {
            let (factor, slope) = self.factor(at.0, at.1, piece);
            return [factor, slope].map(|x| 0.5 * x * g * g);
        };
        let [energy, slope] = curve.energy(g);
        [energy, positions as f64 * slope]
    }

    /// Load over deflection at an instant on a piece of the wave, and the positions in a period; none of a wave without a load table.
    fn load_curve(&self, (t, q): (f64, &[f64]), piece: u32) -> Option<(LoadCurve<'_>, usize)> {
        let wave = self.stiffness_wave.as_ref()?;
        let positions = wave.load_table.as_ref()?.position_count();
        let curve = wave.load_curve(wave.phase.phase_at(t, q), piece as usize)?;
        Some((curve, positions))
    }

    /// Contact state at a deflection and its rate on a piece of the stiffness wave.
    pub fn contact_state(
        &self,
        contact: &ContactLaw,
        at: (f64, &[f64]),
        (delta, rate): (f64, f64),
        piece: u32,
    ) -> ContactState {
        let spring = self.contact_spring(at, delta.abs() - contact.half_play, piece);
        contact.state(delta, rate, spring.secant)
    }

    /// The stiffness follows the load.
    pub fn follows_load(&self) -> bool {
        let wave = self.stiffness_wave.as_ref();
        wave.is_some_and(|wave| wave.load_table.is_some())
    }
}

impl DynamicModel {
    /// The elements that follow their load, each with its load over the largest of its table.
    pub fn loads_over_tables(&self, t: f64, y: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        let (q, v) = y.split_at(self.coordinate_count());
        let over = move |(at, b): (usize, &ForceElement)| {
            let ForceLaw::Contact(contact) = &b.law else {
                return None;
            };
            let wave = b.stiffness_wave.as_ref()?;
            let largest = wave.load_table.as_ref()?.loads().last()?;
            let piece = wave.waveform.piece(wave.phase.phase_at(t, q)) as u32;
            let deflection = b.deflection(t, q, v, b.pieces_at(t));
            let state = b.contact_state(contact, (t, q), deflection, piece);
            let g = contact.penetration(state, deflection.0);
            let load = b.contact_spring((t, q), g, piece).secant * g;
            Some((at, load.abs() / largest))
        };
        self.elements.iter().enumerate().filter_map(over)
    }
}
