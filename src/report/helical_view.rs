//! View of a helical pair in space: one pitch of each gear as outlines along the face, turned by `2π z/p_z`, and both axis positions.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::view::{View, ViewKind};
use crate::gear::cylindrical::gear_outline::OutlineSteps;
use crate::gear::cylindrical::pair::Pair;
use crate::gear::hand::Hand;
use crate::plan::gear_limits::MEMBERS;

/// Steps along fillet, involute and land of the drawn teeth.
const STEPS: OutlineSteps = OutlineSteps {
    fillet: 4,
    involute: 6,
    land: 3,
};

/// Number of outlines along the face.
const SLICES: usize = 9;

/// Thickness of the rim below the root, normal modules.
const RIM: f64 = 2.5;

/// Minimum bore radius, as a share of the root radius.
const MIN_BORE: f64 = 0.3;

/// Coordinates are rounded to 1/`DIGITS` m, 0.1 µm.
const DIGITS: f64 = 1e7;

/// View of a helical pair whose teeth touch at the pitch point in the middle of the face; `None` for spur gears.
pub fn helical_view(pair: &Pair, hand: Hand) -> Option<View> {
    let internal = pair.members[1].gear.internal;
    let teeth = pair.polygons_in_mesh([0..1, 0..1], STEPS);
    let axes = [
        0.0,
        if internal { -1.0 } else { 1.0 } * pair.centre_distance,
    ];
    let ratio = if internal { 1.0 } else { -1.0 } / pair.ratio();
    let radii = pair.outlines.map(|o| o.tip_radius.max(o.root_radius));
    let lead = pair.members[0].gear.lead()?;
    let twist = TAU / lead * if hand == Hand::Right { 1.0 } else { -1.0 };
    let member = |k: usize| -> Value {
        let outline: Vec<[f64; 2]> = teeth[k].iter().map(|p| [p[0] - axes[k], p[1]]).collect();
        // The twists have the ratio of the rotations in mesh.
        let twist = if k == 0 { twist } else { ratio * twist };
        let rings = rings(pair, k, &outline, twist);
        json!({
            "name": MEMBERS[k],
            "teeth": pair.members[k].gear.teeth,
            "surface": { "points": rings, "rings": SLICES + 2, "closed": true, "turn_rad": 0.0 },
            "rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1],
            "start_rad": 0.0,
        })
    };
    let ends = [0, 1].map(|k| [axes[k] - radii[k], axes[k] + radii[k]]);
    let [low, high] = [ends[0][0].min(ends[1][0]), ends[0][1].max(ends[1][1])];
    Some(View {
        kind: ViewKind::Pair,
        title: "Gears in space".into(),
        replaces: &[],
        data: json!({
            "members": [member(0), member(1)],
            "centres_m": axes.map(|x| [x, 0.0, 0.0]),
            "middle_m": [0.5 * (low + high), 0.0, 0.0],
            "size_m": high - low,
            "ratio": ratio,
        }),
    })
}

/// Points of one pitch: outlines along the face, then the rim at both ends, `[x, y, z]` from the gear axis, m.
fn rings(pair: &Pair, k: usize, outline: &[[f64; 2]], twist: f64) -> Vec<f64> {
    let (member, shape) = (&pair.members[k], &pair.outlines[k]);
    let rim = match member.gear.internal {
        true => shape.root_radius + RIM * member.gear.module,
        false => (shape.root_radius - RIM * member.gear.module).max(MIN_BORE * shape.root_radius),
    };
    let height = |slice: usize| member.face_width * (slice as f64 / (SLICES - 1) as f64 - 0.5);
    let outlines = (0..SLICES).map(|slice| (height(slice), None));
    let ends = [(height(SLICES - 1), Some(rim)), (height(0), Some(rim))];
    let points = outlines.chain(ends).flat_map(|(z, radius)| {
        let (sin, cos) = (twist * z).sin_cos();
        outline.iter().flat_map(move |[x, y]| {
            let scale = radius.map_or(1.0, |r| r / x.hypot(*y));
            [scale * (cos * x - sin * y), scale * (sin * x + cos * y), z]
        })
    });
    points.map(|v| (v * DIGITS).round() / DIGITS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::flags::Flags;
    use crate::base::source_span::SourceFile;
    use crate::gear::kernel::vector::wrapped;
    use crate::scene::gear_file;
    use std::sync::Arc;

    /// Along the face the pinion outline turns by `b tan β/r`; the gear outline turns by the same pitch-circle arc in the opposite sense.
    #[test]
    fn exact_outlines_turn_by_the_lead() {
        let source = SourceFile {
            path: "helical.toml".into(),
            text: include_str!("../../models/gears/helical.toml").into(),
            first_line: 1,
        };
        let file = gear_file::read(&Arc::new(source), &Flags::default()).unwrap();
        let pair = Pair::new(file.members, file.centre_distance).unwrap();
        let view = helical_view(&pair, Hand::Right).unwrap();
        let turn = |k: usize| -> f64 {
            let surface = &view.data["members"][k]["surface"];
            let points = surface["points"].as_array().unwrap();
            let points: Vec<f64> = points.iter().map(|v| v.as_f64().unwrap()).collect();
            let ring_size = points.len() / (SLICES + 2);
            let angle = |ring: usize| points[ring * ring_size + 1].atan2(points[ring * ring_size]);
            wrapped(angle(SLICES - 1) - angle(0))
        };
        let [pinion, gear] = pair.members.map(|m| m.gear);
        let expected =
            pair.members[0].face_width * pinion.helix.tan() * 2.0 / pinion.reference_diameter();
        assert!((turn(0) - expected).abs() < 2e-6, "{} {expected}", turn(0));
        let rolled = -f64::from(pinion.teeth) / f64::from(gear.teeth) * expected;
        assert!((turn(1) - rolled).abs() < 2e-6, "{} {rolled}", turn(1));
        let ratio = view.data["ratio"].as_f64().unwrap();
        assert!((ratio + 24.0 / 95.0).abs() < 1e-15, "{ratio}");
    }
}
