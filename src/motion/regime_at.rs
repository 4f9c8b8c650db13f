//! Regime at a given state: contact states, stick or slip, active pieces.

use std::borrow::Cow;

use super::dynamic_model::{DynamicModel, ElementState, ForceLaw, Regime};
use super::friction::FrictionState;

/// A rate this small next to the rates it is a difference of is rounding.
const ROUNDING_TOLERANCE: f64 = 64.0 * f64::EPSILON;

impl DynamicModel {
    /// The lines that carry every drive and every imposed e at `t`.
    pub fn active_pieces(&self, t: f64) -> Vec<u32> {
        let drives = self.forces.iter().map(|d| d.signal.piece(t) as u32);
        let imposed = self.elements.iter().map(|b| b.pieces_at(t).imposed);
        drives.chain(imposed).collect()
    }

    /// Regime at a sample: from the method where it has one, else from its equations, every dry friction spread over its creep speed. A
    /// state alone does not tell what sticks: of pairs that move together it leaves a rate of some rounding or tolerance.
    pub fn output_regime<'a>(
        &self,
        known: Option<&'a Regime>,
        t: f64,
        y: &[f64],
    ) -> Cow<'a, Regime> {
        if let Some(known) = known {
            return Cow::Borrowed(known);
        }
        let mut regime = self.contact_regime(t, y);
        for (stand, b) in regime.states.iter_mut().zip(&self.elements) {
            if b.law.is_dry_friction() {
                *stand = ElementState::Smooth;
            }
        }
        Cow::Owned(regime)
    }

    /// The regime that begins at a state.
    pub fn regime(&self, t: f64, y: &[f64]) -> Regime {
        let mut regime = self.contact_regime(t, y);
        self.release_overloaded(&mut regime, t, y);
        regime
    }

    /// Regime of every piece and every contact at a state; friction pairs stick or slide by their rates alone.
    pub fn contact_regime(&self, t: f64, y: &[f64]) -> Regime {
        let (q, v) = (
            &y[..self.coordinate_count()],
            &y[self.coordinate_count()..2 * self.coordinate_count()],
        );
        let mut pieces = self.active_pieces(t);
        let states = self.elements.iter().map(|b| {
            let piece = b.pieces_at(t);
            match &b.law {
                ForceLaw::Contact(contact) => {
                    let of_wave = b
                        .stiffness_wave
                        .as_ref()
                        .map_or(0, |w| w.waveform.piece(w.phase.phase_at(t, q)) as u32);
                    let deflection = b.deflection(t, q, v, piece);
                    ElementState::Contact(
                        b.contact_state(contact, (t, q), deflection, of_wave),
                        of_wave,
                    )
                }
                law if law.is_dry_friction() => {
                    let (_, rate) = b.deflection(t, q, v, piece);
                    let swept = b.direction.entries().map(|(i, a)| (a * v[i]).abs());
                    let imposed = b
                        .imposed_displacement
                        .as_ref()
                        .map_or(0.0, |e| e.slope(t, piece.imposed as usize));
                    let rounding = ROUNDING_TOLERANCE * (swept.sum::<f64>() + imposed.abs());
                    ElementState::Friction(match rate {
                        r if r > rounding => FrictionState::Forward,
                        r if r < -rounding => FrictionState::Backward,
                        _ => FrictionState::Stick,
                    })
                }
                _ => ElementState::Smooth,
            }
        });
        let states = states.collect();
        if self.has_paths() {
            pieces.extend((0..self.elements.len()).map(|at| self.path_piece(at, t, q)));
        }
        Regime {
            pieces,
            states,
            wave_pieces: Vec::new(),
        }
    }

    /// Releases pairs at rest that would have to hold more than their breakaway force, the most overloaded first.
    pub fn release_overloaded(&self, regime: &mut Regime, t: f64, y: &[f64]) {
        let n = self.coordinate_count();
        loop {
            let sticking = regime.sticking_pairs();
            if sticking.is_empty() {
                return;
            }
            let held = self.stick_forces(
                regime,
                t,
                &self.applied_forces(Some(regime), t, y),
                &y[n..2 * n],
            );
            let over = |(&at, &held): (&usize, &f64)| {
                let breakaway = self.friction_at(at, Some(regime), t, y)?.breakaway;
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
                FrictionState::Forward
            } else {
                FrictionState::Backward
            };
            regime.states[at] = ElementState::Friction(slip);
        }
    }

    /// The line a regime has for the imposed e of a branch.
    pub fn imposed_piece(&self, regime: &Regime, branch: usize) -> u32 {
        regime.pieces[self.forces.len() + branch]
    }
}
