//! Straight bevel gears: blank of a textbook pair, octoids and spherical involutes as envelopes of a plane.

use std::f64::consts::{FRAC_PI_2, TAU};

use geardyn::internals::gear::bevel::blank::{Blank, EndCone};
use geardyn::internals::gear::bevel::cutter::Blade;
use geardyn::internals::gear::bevel::flank::BevelFlank;
use geardyn::internals::gear::bevel::straight::{StraightFlanks, StraightProfile};
use geardyn::internals::gear::bevel::structure_elements::StructureElements;
use geardyn::internals::gear::hand::Hand;
use geardyn::internals::gear::kernel::vector::Vector;

use crate::verification::{printed, within};

const TEETH: [f64; 2] = [20.0, 40.0];
const MODULE: f64 = 3.0;
const FACE_WIDTH: f64 = 20.0;
const ALPHA: f64 = 20.0;

/// Blanks with the addendum rule of the Gleason system for straight bevels, `h_ae2 = m (0.54 + 0.46/u²)` at 90°, whole depth 2.188 m; the
/// face cone is parallel to the mate's root cone. Lengths in mm.
fn blanks() -> [Blank; 2] {
    let u = TEETH[1] / TEETH[0];
    let outer = 0.5 * MODULE * f64::hypot(TEETH[0], TEETH[1]);
    let gear_addendum = MODULE * (0.54 + 0.46 / (u * u));
    let addenda = [2.0 * MODULE - gear_addendum, gear_addendum];
    let dedenda = addenda.map(|a| 2.188 * MODULE - a);
    let angles = dedenda.map(|d| (d / outer).atan());
    [0, 1].map(|k| {
        let pitch_angle = (TEETH[k] / TEETH[1 - k]).atan();
        let (sin, cos) = pitch_angle.sin_cos();
        let face_angle = pitch_angle + angles[1 - k];
        let corner = [
            outer * cos - addenda[k] * sin,
            outer * sin + addenda[k] * cos,
        ];
        Blank {
            pitch_angle,
            face_angle,
            root_angle: pitch_angle - angles[k],
            mean_cone_distance: outer - 0.5 * FACE_WIDTH,
            face_width: FACE_WIDTH,
            outer_share: 0.5,
            pitch_apex: 0.0,
            face_apex: corner[1] / face_angle.tan() - corner[0],
            root_apex: 0.0,
            ends: EndCone::Pitch,
        }
    })
}

fn flank(profile: StraightProfile, k: usize, side: Blade) -> (StraightFlanks, BevelFlank) {
    let blank = blanks()[k];
    let flanks = StraightFlanks {
        profile,
        pressure_angle: ALPHA.to_radians(),
        skew_angle: 0.0,
        pitch_angle: blank.pitch_angle,
        mean_cone_distance: blank.mean_cone_distance,
        pitch_apex: 0.0,
    };
    let hand = [Hand::Right, Hand::Left][k];
    (flanks, flanks.flank(side, hand, blank.section().unwrap()))
}

/// Points and normals over the tooth; a spherical involute has none below its base cone.
fn nodes(flank: &BevelFlank) -> Vec<(Vector, Vector)> {
    let near = flank.middle().unwrap();
    let places = [0.05, 0.5, 0.95].into_iter();
    let places = places.flat_map(|face| [0.2, 0.5, 0.8, 0.98].map(|height| [face, height]));
    places
        .filter_map(|place| {
            let p = flank.point(place, near)?;
            Some((p.point.coordinates, p.normal.components))
        })
        .collect()
}

/// Blank of straight bevels of 20 and 40 teeth, module 3 mm, 90°.
/// Source: KHK, Gear technical reference, straight bevel gears of the Gleason system, table of calculations for z 20/40, m 3.
#[test]
fn ref_straight_bevel_blank() {
    let both = blanks();
    let expected = [
        (67.08204, 4.035, 2.529, 2.15903, 67.2180),
        (67.08204, 1.965, 4.599, 3.92194, 121.7575),
    ];
    for (k, (distance, addendum, dedendum, dedendum_angle, tip)) in expected.into_iter().enumerate()
    {
        let blank = &both[k];
        let name = ["pinion", "gear"][k];
        let section = blank.section().unwrap();
        let [_, outer] = blank.cone_distances();
        let pitch = blank.on_pitch_cone(outer);
        let off = |place: [f64; 2]| f64::hypot(place[0] - pitch[0], place[1] - pitch[1]);
        printed(&format!("{name}, R_e"), "mm", distance, outer, 1e-5);
        printed(
            &format!("{name}, h_ae"),
            "mm",
            addendum,
            off(section.at(1.0, 1.0)),
            1e-3,
        );
        printed(
            &format!("{name}, h_fe"),
            "mm",
            dedendum,
            off(section.at(1.0, 0.0)),
            1e-3,
        );
        let angle = (blank.pitch_angle - blank.root_angle).to_degrees();
        printed(&format!("{name}, θ_f"), "deg", dedendum_angle, angle, 1e-5);
        printed(
            &format!("{name}, d_ae"),
            "mm",
            tip,
            2.0 * section.at(1.0, 1.0)[1],
            1e-4,
        );
    }
}

/// Azimuth of a spherical involute over the cone angle, `φ/sin δ_b − acos(tan δ_b/tan δ)` with `cos φ = cos δ/cos δ_b`; straight lines run
/// to the apex.
#[test]
fn exact_spherical_involute() {
    let mut worst = [0f64; 2];
    for k in 0..2 {
        for side in [Blade::Inside, Blade::Outside] {
            let (data, flank) = flank(StraightProfile::SphericalInvolute, k, side);
            let base = data.base_angle();
            let mut azimuths = Vec::new();
            for (r, n) in nodes(&flank) {
                let delta = f64::hypot(r.x, r.y).atan2(r.z);
                let roll = (delta.cos() / base.cos()).acos();
                let azimuth = roll / base.sin() - (base.tan() / delta.tan()).acos();
                let found = r.y.atan2(r.x);
                azimuths.push((azimuth, found));
                worst[0] = worst[0].max(n.dot(r).abs() / r.norm());
            }
            // Both branches of the involute: the sign of the side.
            let spread = |sign: f64| {
                let starts = azimuths.iter().map(|(a, f)| f - sign * a);
                let (low, high) =
                    starts.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
                high - low
            };
            worst[1] = worst[1].max(spread(1.0).min(spread(-1.0)));
        }
    }
    within("normal along the generator", worst[0], 1e-14);
    within("azimuth, rad", worst[1], 1e-13);
}

/// Octoids and spherical involutes of pinion and gear are conjugate: at the angle of the pinion at which a point's normal is perpendicular
/// to the sliding velocity, the gear's flank there has turned by the ratio of the tooth numbers. The pressure angle on the pitch cone is α.
#[test]
fn exact_straight_pairs_are_conjugate() {
    let mut worst = [0f64; 2];
    for profile in [StraightProfile::Octoid, StraightProfile::SphericalInvolute] {
        let (_, pinion) = flank(profile, 0, Blade::Outside);
        let (_, gear) = flank(profile, 1, Blade::Inside);
        let near = gear.middle().unwrap();
        let ratio = TEETH[0] / TEETH[1];
        let mut starts: Vec<f64> = Vec::new();
        for (r, n) in nodes(&pinion) {
            // The gear's axis along x: v₁₂ = (k₁ + i k₂)×r, so n·v₁₂ = (k₁ + i k₂)·(r×n).
            let m = r.cross(n);
            // (m turned by φ) · (i, 0, 1) = 0.
            let (amplitude, phase) = (f64::hypot(m.x, m.y) * ratio, m.y.atan2(m.x));
            let reach = (-m.z / amplitude).clamp(-1.0, 1.0).acos();
            // Of both roots the one in mesh lies near the plane of the axes, on the gear's side.
            let towards = |turn: f64| {
                let (s, c) = turn.sin_cos();
                Vector::new(r.x * c - r.y * s, r.x * s + r.y * c, r.z)
            };
            let turns = [reach - phase, -reach - phase];
            let turn = if towards(turns[0]).x > towards(turns[1]).x {
                turns[0]
            } else {
                turns[1]
            };
            let turn = turn - TAU * (turn / TAU).round();
            let at = towards(turn);
            // The gear's frame: z along x, x along the pinion's axis.
            let in_gear = [at.x, f64::hypot(at.y, at.z)];
            let Some(p) = gear.tooth_point(in_gear, near) else {
                continue;
            };
            let q = p.point.point.coordinates;
            let gear_turn = (-at.y).atan2(at.z) - q.y.atan2(q.x);
            let start = gear_turn + ratio * turn;
            starts.push(
                starts
                    .first()
                    .map_or(start, |first| start - TAU * ((start - first) / TAU).round()),
            );
        }
        assert!(starts.len() > 4, "{}", starts.len());
        let low = starts.iter().fold(f64::MAX, |l, x| l.min(*x));
        let high = starts.iter().fold(f64::MIN, |h, x| h.max(*x));
        worst[0] = worst[0].max(high - low);
        let blank = blanks()[0];
        let mean = pinion
            .tooth_point(blank.mean_point(), pinion.middle().unwrap())
            .unwrap();
        let elements = StructureElements::of(&mean.point, 0.0).unwrap();
        worst[1] = worst[1].max((elements.pressure_angle.to_degrees() - ALPHA).abs());
        worst[1] = worst[1].max(elements.spiral_angle.abs());
    }
    within("transmission error, rad", worst[0], 1e-12);
    within("pressure and spiral angle, deg", worst[1], 1e-10);
}

/// A skew tooth has its angle at the mean point, to either side by its hand.
#[test]
fn law_skew_teeth() {
    let blank = blanks()[0];
    for (hand, sign) in [(Hand::Right, 1.0), (Hand::Left, -1.0)] {
        let data = StraightFlanks {
            skew_angle: 0.3,
            ..flank(StraightProfile::Octoid, 0, Blade::Inside).0
        };
        for side in [Blade::Inside, Blade::Outside] {
            let flank = data.flank(side, hand, blank.section().unwrap());
            let mean = flank.tooth_point(blank.mean_point(), flank.middle().unwrap());
            let elements = StructureElements::of(&mean.unwrap().point, 0.0).unwrap();
            assert!(
                (elements.spiral_angle - sign * 0.3).abs() < 1e-12,
                "{elements:?}"
            );
            assert!((elements.pressure_angle - ALPHA.to_radians()).abs() < 1e-12);
        }
    }
    let sum = blanks()[0].pitch_angle + blanks()[1].pitch_angle;
    assert!((sum - FRAC_PI_2).abs() < 1e-15);
}
