//! How everything that can switch stands at a state.

use std::borrow::Cow;

use super::friction::Slip;
use super::train::{BranchStand, Law, Regime, Train};

/// A rate this small beside the rates it is a difference of is rounding.
const ROUNDED: f64 = 64.0 * f64::EPSILON;

impl Train {
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
}
