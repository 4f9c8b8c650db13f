//! The view of cylindrical gears that turn in mesh: one tooth of each, circles and the path of contact.

use serde_json::{Value, json};

use super::view::{View, ViewKind};
use crate::gear::cylindrical::gear_outline::OutlineSteps;
use crate::gear::cylindrical::pair::Pair;
use crate::gear::cylindrical::path_points::PathPoint;
use crate::plan::gear_limits::MEMBERS;

/// Steps of the drawn teeth.
const STEPS: OutlineSteps = OutlineSteps {
    fillet: 10,
    involute: 16,
    land: 5,
};

/// Digits of a coordinate, relative to a metre: a nanometre.
const DIGITS: f64 = 1e9;

/// The view of a pair whose teeth touch at the pitch point.
pub fn teeth_view(pair: &Pair, path: &[(&'static str, PathPoint)]) -> View {
    let teeth = pair.polygons_in_mesh([0..1, 0..1], STEPS);
    let sense = if pair.members[1].gear.internal {
        -1.0
    } else {
        1.0
    };
    let axes = [0.0, sense * pair.centre_distance];
    let pitch = pair.working_diameters().map(|d| 0.5 * d);
    let member = |k: usize| {
        let outline = &pair.outlines[k];
        let rounded = |v: f64| (v * DIGITS).round() / DIGITS;
        let own = |p: &[f64; 2]| [rounded(p[0] - axes[k]), rounded(p[1])];
        json!({
            "name": MEMBERS[k],
            "teeth": pair.members[k].gear.teeth,
            "internal": pair.members[k].gear.internal,
            "axis_m": axes[k],
            "root_m": outline.root_radius,
            "tip_m": outline.tip_radius,
            "pitch_m": pitch[k],
            "base_m": outline.base_radius,
            "tooth_m": teeth[k].iter().map(own).collect::<Vec<_>>(),
        })
    };
    let point = |(name, p): &(&'static str, PathPoint)| json!({ "name": name, "at_m": p.distance });
    View {
        kind: ViewKind::Teeth,
        title: "Teeth in mesh".into(),
        replaces: &[],
        data: json!({
            "members": [member(0), member(1)],
            "module_m": pair.members[0].gear.module,
            "pressure_angle_rad": pair.working_pressure_angle,
            "base_pitch_m": pair.base_pitch(),
            "path": path.iter().map(point).collect::<Vec<Value>>(),
        }),
    }
}
