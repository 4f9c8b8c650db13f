//! Branches in one regime: what each adds to stiffness, damping, constant force and inner states.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::contact::Affine;
use crate::motion::curve::Curve;
use crate::motion::friction::Slip;
use crate::motion::train::{Branch, BranchStand, Law};

/// A branch that is linear in its regime.
#[derive(Debug, Clone, Copy)]
pub struct Held {
    /// `F = constant + k δ + c δ̇` of what is not inner.
    pub force: Affine,
    /// It sticks: what it carries is a reaction.
    pub sticks: bool,
    /// Its inner state.
    pub inner: Option<Inner>,
}

impl Held {
    /// Whether it is the same but for its constants.
    pub fn is_like(&self, other: &Held) -> bool {
        let force = |law: &Held| (law.force.deflection, law.force.rate, law.sticks);
        let inner = |law: &Held| {
            law.inner.map(|own| Inner {
                constant: 0.0,
                ..own
            })
        };
        force(self) == force(other) && inner(self) == inner(other)
    }
}

/// `F = force · z`, `ż = constant + seen · wᵀq̇ − imposed · ė − decay · z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inner {
    /// +1 or −1.
    pub force: f64,
    /// Per second.
    pub constant: f64,
    /// Per rate of the direction.
    pub seen: f64,
    /// Per rate of the imposed motion.
    pub imposed: f64,
    /// 1/s.
    pub decay: f64,
    /// z of one in units of the size of rates.
    pub scale: f64,
}

/// A branch as it stands.
///
/// # Errors
/// A law that is not linear between switches.
pub fn held(branch: &Branch, stand: BranchStand) -> Result<Held, Error> {
    let plain = |constant: f64, deflection: f64, rate: f64| {
        Ok(Held {
            force: Affine {
                constant,
                deflection,
                rate,
            },
            sticks: false,
            inner: None,
        })
    };
    match (&branch.law, stand) {
        (Law::Linear { stiffness, damping }, _) => plain(0.0, *stiffness, *damping),
        (Law::Contact(contact), BranchStand::Contact(stand, piece)) => {
            let force = contact.force(stand, branch.factor(0.0, &[], piece).0);
            plain(force.constant, force.deflection, force.rate)
        }
        (Law::Friction(friction), BranchStand::Friction(slip)) if friction.is_coulomb() => {
            Ok(Held {
                force: Affine {
                    constant: slip.sign() * friction.sliding,
                    ..Affine::default()
                },
                sticks: slip == Slip::Stick,
                inner: None,
            })
        }
        (Law::Curve(Curve::Straight { stall, idle }), _) => plain(-stall, 0.0, stall / idle),
        (
            Law::Lagged {
                curve: Curve::Straight { stall, idle },
                lag,
            },
            _,
        ) => {
            let seen = -stall / idle / lag;
            Ok(Held {
                force: Affine::default(),
                sticks: false,
                inner: Some(Inner {
                    force: -1.0,
                    constant: stall / lag,
                    seen,
                    imposed: seen,
                    decay: 1.0 / lag,
                    scale: like(seen),
                }),
            })
        }
        (Law::Maxwell { stiffness, damping }, _) => Ok(Held {
            force: Affine::default(),
            sticks: false,
            inner: Some(Inner {
                force: 1.0,
                constant: 0.0,
                seen: *stiffness,
                imposed: *stiffness,
                decay: stiffness / damping,
                scale: like(*stiffness),
            }),
        }),
        _ => {
            let message = format!(
                "the law of `{}` is not linear between switches",
                branch.name
            );
            Err(Error::new(Code::OutOfRange, message).hint("take a method that steps"))
        }
    }
}

/// Then z and rates push each other alike.
fn like(seen: f64) -> f64 {
    match seen.abs().sqrt() {
        0.0 => 1.0,
        scale => scale,
    }
}
