//! Applicability of the periodic method: piecewise linear laws, waves imposed in time.

use crate::motion::algebraic;
use crate::motion::curve::TorqueSpeedCurve;
use crate::motion::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::motion::wave::{PeriodicFunction, Waveform};

/// First part of a machine that is not linear in every contact state, or not periodic in time.
pub fn unsupported_reason(model: &DynamicModel) -> Option<String> {
    let of_branch = |b: &ForceElement| {
        let name = &b.name;
        let straight = |curve: &TorqueSpeedCurve| matches!(curve, TorqueSpeedCurve::Linear { .. });
        let turns = |wave: &PeriodicFunction| wave.phase.angle().is_some();
        match &b.law {
            ForceLaw::Friction(_) | ForceLaw::Clutch { .. } | ForceLaw::LoadFriction(_) => {
                return Some(format!("{name} has dry friction"));
            }
            ForceLaw::Nonlinear { .. } => {
                return Some(format!("the characteristic of {name} is not linear"));
            }
            ForceLaw::TorqueSpeed(curve) | ForceLaw::LaggedTorque { curve, .. }
                if !straight(curve) =>
            {
                return Some(format!("the torque of {name} is not linear in speed"));
            }
            _ => {}
        }
        if b.stiffness_wave.as_ref().is_some_and(turns) {
            return Some(format!(
                "the stiffness of {name} depends on an angle, not on time"
            ));
        }
        if b.follows_load() {
            return Some(format!("the stiffness of {name} depends on its load"));
        }
        if b.angle_waves.iter().any(turns) {
            return Some(format!("the error of {name} depends on an angle, not time"));
        }
        if let ForceLaw::AngleLocked { .. } = b.law {
            return Some(format!("{name} depends on an angle, not on time"));
        }
        b.angle_waves
            .iter()
            .find(|e| matches!(e.waveform, Waveform::Rectangular { .. }))
            .map(|_| format!("the error of {name} jumps"))
    };
    let bent = || {
        let message = "a prescribed motion or load is quadratic in time";
        (!model.has_linear_inputs()).then(|| message.to_string())
    };
    let light = algebraic::inertia_requirement(model);
    light.or_else(|| model.elements.iter().find_map(of_branch).or_else(bent))
}
