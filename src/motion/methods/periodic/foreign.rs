//! What the tables cannot hold: laws that are not linear between switches, waves that do not follow time.

use crate::motion::curve::Curve;
use crate::motion::light;
use crate::motion::train::{Branch, Law, Train};
use crate::motion::wave::{Shape, Wave};

/// What of a machine is not linear in every stand, or does not repeat in time.
pub fn foreign(train: &Train) -> Option<String> {
    let of_branch = |b: &Branch| {
        let name = &b.name;
        let straight = |curve: &Curve| matches!(curve, Curve::Straight { .. });
        let turns = |wave: &Wave| wave.phase.angle().is_some();
        match &b.law {
            Law::Friction(_) | Law::Clutch { .. } | Law::Pressed(_) => {
                return Some(format!("{name} has dry friction"));
            }
            Law::Nonlinear { .. } => {
                return Some(format!("the characteristic of {name} is not linear"));
            }
            Law::Curve(curve) | Law::Lagged { curve, .. } if !straight(curve) => {
                return Some(format!("the torque of {name} is not straight over speed"));
            }
            _ => {}
        }
        if b.variation.as_ref().is_some_and(turns) {
            return Some(format!(
                "the stiffness of {name} follows an angle, not time"
            ));
        }
        if b.followed.iter().any(turns) {
            return Some(format!("the error of {name} follows an angle, not time"));
        }
        if let Law::Orders { .. } = b.law {
            return Some(format!("{name} follows an angle, not time"));
        }
        b.followed
            .iter()
            .find(|e| matches!(e.shape, Shape::Rectangular { .. }))
            .map(|_| format!("the error of {name} jumps"))
    };
    let bent = || {
        let message = "a known motion or load is a parabola of time";
        (!train.knows_lines_only()).then(|| message.to_string())
    };
    let light = light::refused(train);
    light.or_else(|| train.branches.iter().find_map(of_branch).or_else(bent))
}
