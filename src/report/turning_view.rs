//! The view of a worm pair or a crossed pair in space: one pitch of each member, their places, and the curves of contact of the moment.

use serde_json::{Value, json};

use super::view::{View, ViewKind};
use crate::gear::helicoid::turning_pair::TurningPair;

/// Digits of a coordinate, relative to a metre: a nanometre.
const DIGITS: f64 = 1e9;

/// The view of a pair whose members have names.
pub fn turning_view(pair: &TurningPair, names: [&str; 2]) -> View {
    let rounded = |all: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        all.map(|v| (v * DIGITS).round() / DIGITS).collect()
    };
    let member = |k: usize| -> Value {
        let of = &pair.members[k];
        json!({
            "name": names[k],
            "teeth": of.teeth,
            "surface": {
                "points": rounded(&mut of.sector.points.as_flattened().iter().copied()),
                "rings": of.sector.rings,
                "closed": true,
                "turn_rad": 0.0,
            },
            "rotation": of.axes.map(|axis| axis.array()).as_flattened(),
        })
    };
    let (mut first, mut ends, mut points) = (Vec::new(), Vec::new(), Vec::new());
    for position in &pair.positions {
        first.push(ends.len());
        for curve in &position.curves {
            points.extend(curve.iter().flat_map(|p| p.array()));
            ends.push(points.len() / 3);
        }
    }
    // Both members along the line of centres.
    let radius = |k: usize| {
        let points = pair.members[k].sector.points.iter();
        points.map(|[x, y, _]| x.hypot(*y)).fold(0.0, f64::max)
    };
    let ends_x = [0, 1].map(|k| {
        let (centre, radius) = (pair.members[k].centre.x, radius(k));
        [centre - radius, centre + radius]
    });
    let [low, high] = [
        ends_x[0][0].min(ends_x[1][0]),
        ends_x[0][1].max(ends_x[1][1]),
    ];
    let angles = |k: usize| -> Vec<f64> { pair.positions.iter().map(|p| p.angles[k]).collect() };
    View {
        kind: ViewKind::Pair,
        title: "Gears in space".into(),
        replaces: &[],
        data: json!({
            "members": [member(0), member(1)],
            "centres_m": pair.members.each_ref().map(|m| m.centre.array()),
            "middle_m": [0.5 * (low + high), 0.0, 0.0],
            "size_m": high - low,
            "curves": {
                "contact": if pair.is_line_contact { "line" } else { "point" },
                "facing": pair.facing.map(|v| v.array()),
                "angles_rad": [angles(0), angles(1)],
                "first": first,
                "ends": ends,
                "points_m": rounded(&mut points.into_iter()),
            },
        }),
    }
}
