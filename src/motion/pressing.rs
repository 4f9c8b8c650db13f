//! What presses the friction pairs of a machine at a state, and what teeth that rub do beside turning their gears.

use super::friction::Friction;
use super::rubbing::{Path, Pressed};
use super::train::{Law, Regime, Train, rubbed};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;

/// What presses a pair and where.
struct Press {
    /// `μ |N|`.
    friction: f64,
    /// Along the direction of the pair, and aside.
    levers: (f64, f64),
    coasts: bool,
}

impl Train {
    /// The dry friction of a branch at its present capacity, where it is that.
    pub fn dry(
        &self,
        branch: usize,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> Option<Friction> {
        match &self.branches[branch].law {
            Law::Friction(friction) => Some(*friction),
            Law::Clutch { friction, grip } => Some(friction.gripped(grip.value(t, grip.piece(t)))),
            Law::Pressed(pressed) => {
                let press = self.press(branch, pressed, regime, t, y);
                let capacity = pressed.constant + press.friction * press.levers.0;
                Some(pressed.friction.gripped(capacity))
            }
            _ => None,
        }
    }

    /// Which piece of the path of contact holds a branch, where it has one.
    pub fn path_piece(&self, branch: usize, t: f64, q: &[f64]) -> u32 {
        match &self.branches[branch].law {
            Law::Pressed(pressed) => pressed.path.as_ref().map_or(0, |path| {
                let phase = path.phase.as_ref();
                phase.map_or(0, |phase| path.piece(phase.at(t, q)) as u32)
            }),
            _ => 0,
        }
    }

    /// Some branch's friction goes by a path of contact.
    pub fn has_paths(&self) -> bool {
        let moves = |path: &Path| path.phase.is_some();
        self.branches
            .iter()
            .any(|b| matches!(&b.law, Law::Pressed(p) if p.path.as_ref().is_some_and(moves)))
    }

    /// What friction of teeth does beside turning the gears against each other: its force and direction.
    pub fn aside(
        &self,
        branch: usize,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> Option<(f64, &Direction)> {
        let b = &self.branches[branch];
        let Law::Pressed(pressed) = &b.law else {
            return None;
        };
        let path = pressed.path.as_ref()?;
        let n = self.n();
        let press = self.press(branch, pressed, regime, t, y);
        let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
        let (_, rate) = b.deflection(t, &y[..n], &y[n..2 * n], piece);
        let stand = regime.map(|r| r.stands[branch]);
        let (sense, ..) = rubbed(&pressed.friction, stand, rate);
        let direction = &path.aside[usize::from(press.coasts)];
        Some((sense * press.friction * press.levers.1, direction))
    }

    fn press(
        &self,
        branch: usize,
        pressed: &Pressed,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> Press {
        let component = |forces: &Vec<(usize, f64)>| -> f64 {
            let force = |&(at, share): &(usize, f64)| share * self.force(at, regime, t, y, 0.0).0;
            forces.iter().map(force).sum()
        };
        let components = pressed.by.iter().map(component);
        let (mut size, mut coasts) = (0.0f64, false);
        for x in components {
            size = size.hypot(x);
            coasts = x < 0.0;
        }
        let levers = match &pressed.path {
            None => (1.0, 0.0),
            Some(path) => {
                let q = &y[..self.n()];
                let psi = path.phase.as_ref().map_or(0.0, |phase| phase.at(t, q));
                let piece = match regime {
                    Some(regime) => self.frozen_path(regime, branch),
                    None => self.path_piece(branch, t, q),
                };
                path.levers(psi, piece as usize, coasts)
            }
        };
        Press {
            friction: pressed.coefficient * size,
            levers,
            coasts,
        }
    }

    /// The piece of the path of contact that a regime has for a branch.
    fn frozen_path(&self, regime: &Regime, branch: usize) -> u32 {
        let at = self.path_at(branch);
        regime.pieces.get(at).copied().unwrap_or(0)
    }

    /// Where among the pieces of a regime the path of a branch is.
    pub fn path_at(&self, branch: usize) -> usize {
        self.drives.len() + self.branches.len() + branch
    }
}

/// The refusal of friction pressed by a branch that is no unknown.
pub fn unpressed(train: &Train, branch: &str, by: usize) -> Error {
    let message = format!(
        "the friction of {branch} goes by the force of {}, which is no unknown of the motion",
        train.branches[by].name
    );
    Error::new(Code::Conflict, message)
        .hint("give the nodes it joins their inertia, and let no motor prescribe both ends of it")
}
