//! Plane double-enveloping worm pairs: both lines of contact, the curve between both parts of the tooth, the worm's edge of regression.

use geardyn::internals::gear::helicoid::plane_worm::{PlaneWorm, PlaneWormContact};
use serde_json::Value;

use crate::cases::{case, number, number_at, numbers};
use crate::verification::within;

fn pair(case: &Value) -> PlaneWorm {
    let get = |key: &str| number_at(case, &format!("/inputs/{key}"));
    PlaneWorm {
        centre_distance: get("a"),
        ratio: get("z1") / get("z2"),
        base_radius: get("base_circle_radius_rb"),
        plane_angle: get("plane_inclination_beta_deg").to_radians(),
    }
}

fn rows(case: &Value, key: &str) -> Vec<Vec<f64>> {
    case["expected"][key]
        .as_array()
        .unwrap()
        .iter()
        .map(numbers)
        .collect()
}

/// First and second contact, limits and both curvatures of an hourglass worm of one start with a wheel of 40 teeth.
/// Source: extrema of azimuth, neighbouring lines, 143 000 worm points over 1 400 turns, data/reference/gear/c56_plane_double_enveloping.json.
#[test]
fn ref_plane_worm_contact() {
    let case = case("c56_plane_double_enveloping");
    let pair = pair(&case);
    let (mut place, mut angle, mut curvature) = (0f64, 0f64, 0f64);
    for row in rows(&case, "contact") {
        let [turn, eta] = [row[0].to_radians(), row[1]];
        let line = pair.generating_line(turn);
        let first = line.first_contact(eta).unwrap();
        let found = [
            first.in_wheel.x,
            first.point.x,
            first.point.y,
            first.point.z,
        ];
        for (found, want) in found.iter().zip(&row[2..6]) {
            place = place.max((found - want).abs());
        }
        place = place.max((first.second_limit - row[6]).abs());
        place = place.max((first.undercut - row[7]).abs());
        curvature = curvature.max((-first.relative_curvature - row[8]).abs());
        angle = angle.max((first.lubrication_angle().to_degrees() - row[9]).abs());
        let second = line.second_contact_at(eta).unwrap();
        let delta = (second.wheel_turn - turn) / pair.ratio;
        angle = angle.max((delta.to_degrees() - row[10]).abs());
        angle = angle.max((second.wheel_turn.to_degrees() - row[11]).abs());
        let at = second.in_wheel;
        for (found, want) in [at.x, at.y, at.z, second.height].iter().zip(&row[12..16]) {
            place = place.max((found - want).abs());
        }
        curvature = curvature.max((second.relative_curvature - row[16]).abs());
        angle = angle.max((second.lubrication_angle().to_degrees() - row[17]).abs());
        // The second contact is found again from its own turn of the wheel and that at which the plane makes the point.
        let again = pair.generating_line(second.wheel_turn);
        let again = again.second_contact(turn).unwrap();
        place = place.max((again.in_wheel - at).norm());
        curvature = curvature.max((again.relative_curvature - row[16]).abs());
    }
    for row in rows(&case, "limit") {
        let turn = row[0].to_radians();
        let line = pair.generating_line(turn);
        let [xi, eta] = line.limit().unwrap();
        place = place.max((xi - row[4]).abs()).max((eta - row[5]).abs());
        (0..3).for_each(|k| place = place.max((line.coefficients[k] - row[1 + k]).abs()));
        let contact = line.first_contact(eta).unwrap();
        place = place
            .max(contact.second_limit.abs())
            .max((contact.undercut - row[7]).abs());
        curvature = curvature.max((-contact.relative_curvature - row[8]).abs());
        place = place.max((line.undercut().unwrap() - row[9]).abs());
    }
    within("places, mm, Φ and D", place, 1e-9);
    within("angles, deg", angle, 1e-8);
    within("relative curvatures, 1/mm", curvature, 1e-10);
}

/// Near the curve between both parts of the tooth the second curvature goes linearly to zero, and at the curve there is one contact.
/// Source: data/reference/gear/c56_plane_double_enveloping.json.
#[test]
fn ref_plane_worm_near_its_limit() {
    let case = case("c56_plane_double_enveloping");
    let pair = pair(&case);
    let line = pair.generating_line(23f64.to_radians());
    let [_, limit] = line.limit().unwrap();
    let mut worst = 0f64;
    for row in rows(&case, "near_limit") {
        let first = line.first_contact(limit + row[0]).unwrap();
        let second = line.second_contact_at(limit + row[0]).unwrap();
        worst = worst.max((-first.relative_curvature - row[2]).abs());
        worst = worst.max((second.relative_curvature - row[3]).abs());
    }
    within("relative curvatures, 1/mm", worst, 1e-9);
    assert_eq!(line.second_contact_at(limit), None);
}

/// Height of the enveloped part over the plane at places of the wheel, and the curve where it begins.
/// Source: brute force over worm points and turns, data/reference/gear/c56_plane_double_enveloping.json.
#[test]
fn ref_enveloped_part_of_the_tooth() {
    let case = case("c56_plane_double_enveloping");
    let pair = pair(&case);
    let radius = |c: &PlaneWormContact| f64::hypot(c.in_wheel.x, c.in_wheel.z);
    let map = &case["expected"]["wheel_map"];
    let row = numbers(&map["rows"][1]);
    // At wheel radius 102 mm and η = 0: the nearest second contact of a grid.
    let mut nearest = (1.0, f64::NAN);
    for (k, l) in (0..400).flat_map(|k| (0..100).map(move |l| (k, l))) {
        let turn = 0.4 + 0.4 * f64::from(k) / 400.0;
        let eta = 10.0 * f64::from(l) / 100.0;
        let c = pair.generating_line(turn).second_contact_at(eta).unwrap();
        let off = f64::hypot(radius(&c) - row[0], c.in_wheel.y);
        if off < nearest.0 && c.relative_curvature < 0.0 {
            nearest = (off, c.height);
        }
    }
    // The nearest of the sampled points lies a few hundredths of a millimetre away.
    assert!(
        (nearest.1 - row[3]).abs() < 0.2 * nearest.0 + 1e-3,
        "{nearest:?} {}",
        row[3]
    );
    let mut worst = 0f64;
    for boundary in map["boundary"].as_array().unwrap() {
        let [at_radius, eta, turn] = numbers(boundary)[..] else {
            panic!("{boundary}");
        };
        let found = pair.generating_line(turn.to_radians()).limit().unwrap();
        let zeta = pair.base_radius + found[1] * pair.plane_angle.tan();
        worst = worst.max((f64::hypot(found[0], zeta) - at_radius).abs());
        worst = worst.max((found[1] - eta).abs());
    }
    within("curve between both parts, mm", worst, 1e-9);
    assert_eq!(number(&map["rows"][1][6]), 0.0);
}
