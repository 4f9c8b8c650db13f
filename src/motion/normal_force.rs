//! Normal forces of friction pairs, and transverse friction of gear teeth.

use super::dynamic_model::{DynamicModel, ForceLaw, Regime, dry_friction_force};
use super::friction::FrictionLaw;
use super::load_friction::{FrictionLevers, LoadFriction};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::direction::Direction;

/// Normal force of a friction pair, with its levers.
struct NormalForce {
    /// `μ |N|`.
    friction: f64,
    /// Along the direction of the pair, and aside.
    levers: (f64, f64),
    coasts: bool,
}

impl DynamicModel {
    /// The dry friction of a branch at its present capacity, where it is that.
    pub fn friction_at(
        &self,
        branch: usize,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> Option<FrictionLaw> {
        match &self.elements[branch].law {
            ForceLaw::Friction(friction) => Some(*friction),
            ForceLaw::Clutch { friction, capacity } => {
                Some(friction.scaled(capacity.value(t, capacity.piece(t))))
            }
            ForceLaw::LoadFriction(pressed) => {
                let press = self.press(branch, pressed, regime, t, y);
                let capacity = pressed.constant + press.friction * press.levers.0;
                Some(pressed.friction.scaled(capacity))
            }
            _ => None,
        }
    }

    /// Which piece of the path of contact holds a branch, where it has one.
    pub fn path_piece(&self, branch: usize, t: f64, q: &[f64]) -> u32 {
        match &self.elements[branch].law {
            ForceLaw::LoadFriction(pressed) => pressed.path.as_ref().map_or(0, |path| {
                let phase = path.phase.as_ref();
                phase.map_or(0, |phase| path.piece(phase.phase_at(t, q)) as u32)
            }),
            _ => 0,
        }
    }

    /// Some branch's friction goes by a path of contact.
    pub fn has_paths(&self) -> bool {
        let moves = |path: &FrictionLevers| path.phase.is_some();
        self.elements.iter().any(
            |b| matches!(&b.law, ForceLaw::LoadFriction(p) if p.path.as_ref().is_some_and(moves)),
        )
    }

    /// Friction of teeth transverse to turning the gears against each other: its force and direction.
    pub fn transverse_friction(
        &self,
        branch: usize,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> Option<(f64, &Direction)> {
        let b = &self.elements[branch];
        let ForceLaw::LoadFriction(pressed) = &b.law else {
            return None;
        };
        let path = pressed.path.as_ref()?;
        let n = self.coordinate_count();
        let press = self.press(branch, pressed, regime, t, y);
        let piece = b.pieces_at(t);
        let (_, rate) = b.deflection(t, &y[..n], &y[n..2 * n], piece);
        let stand = regime.map(|r| r.states[branch]);
        let (sense, ..) = dry_friction_force(&pressed.friction, stand, rate);
        let direction = &path.pitch_point_sliding[usize::from(press.coasts)];
        Some((sense * press.friction * press.levers.1, direction))
    }

    fn press(
        &self,
        branch: usize,
        pressed: &LoadFriction,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> NormalForce {
        let component = |forces: &Vec<(usize, f64)>| -> f64 {
            let force =
                |&(at, share): &(usize, f64)| share * self.element_force(at, regime, t, y, 0.0).0;
            forces.iter().map(force).sum()
        };
        let components = pressed.force_components.iter().map(component);
        let (mut size, mut coasts) = (0.0f64, false);
        for x in components {
            size = size.hypot(x);
            coasts = x < 0.0;
        }
        let levers = match &pressed.path {
            None => (1.0, 0.0),
            Some(path) => {
                let q = &y[..self.coordinate_count()];
                let psi = path
                    .phase
                    .as_ref()
                    .map_or(0.0, |phase| phase.phase_at(t, q));
                let piece = match regime {
                    Some(regime) => self.frozen_path(regime, branch),
                    None => self.path_piece(branch, t, q),
                };
                path.levers(psi, piece as usize, coasts)
            }
        };
        NormalForce {
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

    /// Index of a branch's path of contact among the pieces of a regime.
    pub fn path_at(&self, branch: usize) -> usize {
        self.forces.len() + self.elements.len() + branch
    }
}

/// The refusal of friction pressed by a branch that is no unknown.
pub fn missing_normal_force(model: &DynamicModel, branch: &str, by: usize) -> Error {
    let message = format!(
        "the friction of {branch} depends on the force of {}, which is not an unknown of the motion",
        model.elements[by].name
    );
    Error::new(Code::Conflict, message).with_hint(
        "give the nodes it joins their inertia, and let no motor prescribe both ends of it",
    )
}
