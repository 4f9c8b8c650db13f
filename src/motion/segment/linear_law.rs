//! Linear law of an element in one regime: stiffness, damping, constant, internal state.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::contact::Affine;
use crate::motion::curve::TorqueSpeedCurve;
use crate::motion::dynamic_model::{ElementState, ForceElement, ForceLaw};
use crate::motion::friction::FrictionState;

/// A branch that is linear in its regime.
#[derive(Debug, Clone, Copy)]
pub struct LinearLaw {
    /// `F = constant + k δ + c δ̇` of what is not inner.
    pub force: Affine,
    /// It sticks: what it carries is a reaction.
    pub sticks: bool,
    /// Law of the inner state.
    pub inner: Option<InternalLaw>,
}

impl LinearLaw {
    /// Whether it is the same but for its constants.
    pub fn same_dynamics(&self, other: &LinearLaw) -> bool {
        let force = |law: &LinearLaw| (law.force.deflection, law.force.rate, law.sticks);
        let inner = |law: &LinearLaw| {
            law.inner.map(|own| InternalLaw {
                constant: 0.0,
                ..own
            })
        };
        force(self) == force(other) && inner(self) == inner(other)
    }
}

/// `F = force · z`, `ż = constant + seen · wᵀq̇ − imposed · ė − decay · z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InternalLaw {
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

/// Linear law of a branch in its present state.
///
/// # Errors
/// A law that is not linear between switches.
pub fn linear_law(branch: &ForceElement, state: ElementState) -> Result<LinearLaw, Error> {
    let plain = |constant: f64, deflection: f64, rate: f64| {
        Ok(LinearLaw {
            force: Affine {
                constant,
                deflection,
                rate,
            },
            sticks: false,
            inner: None,
        })
    };
    match (&branch.law, state) {
        (ForceLaw::Linear { stiffness, damping }, _) => plain(0.0, *stiffness, *damping),
        (ForceLaw::Contact(contact), ElementState::Contact(state, piece)) => {
            let force = contact.force(state, branch.factor(0.0, &[], piece).0);
            plain(force.constant, force.deflection, force.rate)
        }
        (ForceLaw::Friction(friction), ElementState::Friction(slip)) if friction.is_coulomb() => {
            Ok(LinearLaw {
                force: Affine {
                    constant: slip.sign() * friction.sliding,
                    ..Affine::default()
                },
                sticks: slip == FrictionState::Stick,
                inner: None,
            })
        }
        (ForceLaw::TorqueSpeed(TorqueSpeedCurve::Linear { stall, idle }), _) => {
            plain(-stall, 0.0, stall / idle)
        }
        (
            ForceLaw::LaggedTorque {
                curve: TorqueSpeedCurve::Linear { stall, idle },
                lag,
            },
            _,
        ) => {
            let seen = -stall / idle / lag;
            Ok(LinearLaw {
                force: Affine::default(),
                sticks: false,
                inner: Some(InternalLaw {
                    force: -1.0,
                    constant: stall / lag,
                    seen,
                    imposed: seen,
                    decay: 1.0 / lag,
                    scale: like(seen),
                }),
            })
        }
        (ForceLaw::Maxwell { stiffness, damping }, _) => Ok(LinearLaw {
            force: Affine::default(),
            sticks: false,
            inner: Some(InternalLaw {
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
            Err(Error::new(Code::OutOfRange, message).with_hint("take a method that steps"))
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
