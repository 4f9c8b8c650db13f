//! Dry friction whose capacity goes by forces of the machine itself: `C = C₀ + μ l |N|`; of teeth l moves along the path of contact.
//!
//! Teeth at s from the pitch point push the gears against each other by `μ |N| Σ|s|` along `θ₁ − θ₂` and by `μ |N| Σ sign s` along
//! what sliding at the pitch point would be, both against the sense of `θ̇₁ − θ̇₂`.

use std::f64::consts::TAU;

use super::friction::Friction;
use super::train::{Law, Regime, Train, rubbed};
use super::wave::Phase;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::path::{Piece, Reach};
use crate::machine::direction::Direction;

/// Friction pressed by forces of branches.
#[derive(Debug, Clone)]
pub struct Pressed {
    /// For a capacity of one.
    pub friction: Friction,
    /// C₀, N or N·m.
    pub constant: f64,
    /// μ l; of teeth μ alone.
    pub coefficient: f64,
    /// Components of N: forces of branches, so much of each.
    pub by: Vec<Vec<(usize, f64)>>,
    /// Where teeth touch.
    pub path: Option<Path>,
}

/// Where teeth touch.
#[derive(Debug, Clone)]
pub struct Path {
    /// What sliding at the pitch point would be, on drive flanks and on coast flanks.
    pub aside: [Direction; 2],
    /// Levers over the mesh cycle.
    pub pieces: Vec<Piece>,
    /// What carries the cycle on; absent: levers are the same always.
    pub phase: Option<Phase>,
}

impl Path {
    /// Which piece of the cycle holds ψ.
    pub fn piece(&self, psi: f64) -> usize {
        let psi = psi.rem_euclid(1.0);
        self.pieces.partition_point(|p| p.from <= psi).max(1) - 1
    }

    /// Where a piece begins or ends in the cycle.
    pub fn edge(&self, at: usize) -> f64 {
        self.pieces.get(at).map_or(1.0, |p| p.from)
    }

    /// The levers at ψ with the piece `piece` carried on beyond its ends: of the load from the pitch point, m, and its balance.
    fn levers(&self, psi: f64, piece: usize, coasts: bool) -> (f64, f64) {
        let Piece { from, flanks } = &self.pieces[piece];
        let Reach {
            distance,
            slope,
            balance,
        } = flanks[usize::from(coasts)];
        let into = match self.phase {
            Some(_) => psi - from - (psi - 0.5 * (from + self.edge(piece + 1))).round(),
            None => 0.0,
        };
        (distance + slope * into, balance)
    }

    /// The next instant at which a piece ends, where time carries the cycle on, s.
    pub fn next_edge(&self, t: f64) -> f64 {
        let Some(Phase::Imposed { omega, start }) = self.phase else {
            return f64::INFINITY;
        };
        if omega == 0.0 {
            return f64::INFINITY;
        }
        let psi = (omega * t + start) / TAU;
        let whole = psi.floor();
        let edges = (-1..=2).flat_map(|turn| {
            let turn = whole + f64::from(turn);
            self.pieces.iter().map(move |p| turn + p.from)
        });
        // The instant of an edge and the edge at an instant differ by rounding.
        let near = 16.0 * f64::EPSILON * t.abs();
        edges
            .map(|edge| (edge * TAU - start) / omega)
            .filter(|&at| at > t + near)
            .fold(f64::INFINITY, f64::min)
    }
}

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

impl Pressed {
    /// In fewer coordinates and branches: what becomes of directions, of phases and of the numbers of branches.
    ///
    /// # Errors
    /// The number of a branch that presses it and is no more.
    pub fn moved(
        &self,
        direction: impl Fn(&Direction) -> Direction,
        phase: impl Fn(&Phase) -> Phase,
        numbers: &[Option<usize>],
    ) -> Result<Pressed, usize> {
        let renumbered = |&(at, share): &(usize, f64)| Ok((numbers[at].ok_or(at)?, share));
        let component = |forces: &Vec<(usize, f64)>| forces.iter().map(renumbered).collect();
        let path = self.path.as_ref().map(|path| Path {
            aside: [direction(&path.aside[0]), direction(&path.aside[1])],
            pieces: path.pieces.clone(),
            phase: path.phase.as_ref().map(phase),
        });
        Ok(Pressed {
            by: self
                .by
                .iter()
                .map(component)
                .collect::<Result<_, usize>>()?,
            path,
            ..self.clone()
        })
    }

    /// Everything it acts along beside its branch.
    pub fn along(&self) -> impl Iterator<Item = &Direction> {
        self.path.iter().flat_map(|path| {
            let angle = path.phase.as_ref().and_then(Phase::angle);
            path.aside.iter().chain(angle)
        })
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
