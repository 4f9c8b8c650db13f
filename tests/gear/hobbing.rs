//! Hobs in closed form: gears under roll and feed, the error of an Archimedean hob, feed marks.

use geardyn::internals::gear::helicoid::hob::{Hobbing, axis_angle};
use geardyn::internals::gear::helicoid::worm_thread::{FlankType, WormThread};
use geardyn::internals::gear::kernel::crossed_axes::CrossedAxes;
use geardyn::internals::gear::kernel::root::sign_change;
use serde_json::Value;

use crate::cases::{case, number_at, numbers};
use crate::verification::within;

/// The hob of c47 with a flank type, and its gear.
fn hobbing(case: &Value, flank: FlankType) -> Hobbing {
    let get = |key: &str| number_at(case, &format!("/inputs/{key}"));
    let (module, starts) = (get("normal_module"), get("hob_starts"));
    let diameter = 2.0 * get("hob_pitch_radius");
    let lead_angle = (starts * module / diameter).asin();
    let axial_module = module / lead_angle.cos();
    let thread = WormThread {
        flank,
        starts: starts as u32,
        module: axial_module,
        diameter_quotient: diameter / axial_module,
        pressure_angle: get("alpha_n_deg").to_radians(),
    };
    let helix = get("gear_helix_deg_right_positive").to_radians();
    let radius = 0.5 * get("gear_teeth") * module / helix.cos();
    Hobbing {
        space_flank: thread.helicoid().unwrap(),
        heights: [std::f64::consts::FRAC_PI_4 * axial_module; 2],
        axes: CrossedAxes {
            offset: 0.5 * diameter + radius,
            shaft_angle: axis_angle(lead_angle, helix),
            ratio: -starts / get("gear_teeth"),
        },
        gear_lead: radius / helix.tan(),
    }
}

/// Points of hob and gear of an involute and of an Archimedean hob, and the relief that the Archimedean hob leaves along the line of action.
/// Source: two-variable extremum, data/reference/gear/c47_hobbing_zi_za.json.
#[test]
fn ref_hob_in_closed_form() {
    let case = case("c47_hobbing_zi_za");
    let base_radius = number_at(&case, "/expected/gear_base_radius");
    let (mut place, mut angle, mut relief) = (0f64, 0f64, 0f64);
    for (name, flank) in [("ZI", FlankType::Zi), ("ZA", FlankType::Za)] {
        let hobbing = hobbing(&case, flank);
        let involute = |radius: f64| {
            let alpha = (base_radius / radius).acos();
            alpha.tan() - alpha
        };
        let rows = case["expected"]["points"][name].as_array().unwrap();
        for row in rows {
            let row = numbers(row);
            let p = hobbing.point(row[0]).unwrap();
            place = place
                .max((p.axial - row[2]).abs())
                .max((p.gear_radius - row[4]).abs());
            angle = angle
                .max((p.azimuth.to_degrees() - row[1]).abs())
                .max((p.hob_turn.to_degrees() - row[3]).abs())
                .max((p.gear_azimuth.to_degrees() - row[5]).abs());
            if let Some(expected) = row.get(6) {
                let pitch = hobbing.point(40.0).unwrap();
                let off = |p: &geardyn::internals::gear::helicoid::hob::HobbedPoint| {
                    p.gear_azimuth - involute(p.gear_radius)
                };
                let found = 1e3 * base_radius * (off(&p) - off(&pitch)).abs();
                relief = relief.max((found - expected.abs()).abs());
            }
        }
    }
    within("places, mm", place, 1e-9);
    within("angles, deg", angle, 1e-9);
    within("relief, µm", relief, 1e-5);
}

/// Second derivatives of the gap over feed and roll, and the height of feed marks; the handbook's rule is a third too high.
/// Source: restricted extremum, data/reference/gear/c61_hob_feed_marks.json.
#[test]
fn ref_feed_marks() {
    let hob = case("c47_hobbing_zi_za");
    let marks = case("c61_hob_feed_marks");
    let hobbing = hobbing(&hob, FlankType::Zi);
    let feed = number_at(&marks, "/inputs/feed_mm_per_turn");
    let pitch = hobbing.point(40.0).unwrap();
    let (mut second, mut height) = (0f64, 0f64);
    for row in marks["expected"]["rows"].as_array().unwrap() {
        let row = numbers(row);
        // The case counts the turn of the hob against that of c47.
        let off = |radius: f64| Some(hobbing.point(radius)?.hob_turn - pitch.hob_turn + row[0]);
        let radius = match row[0] {
            0.0 => 40.0,
            _ => sign_change([36.0, 44.0], off).unwrap(),
        };
        let found = hobbing.feed_marks(&hobbing.point(radius).unwrap()).unwrap();
        for (found, expected) in [found.feed, found.mixed, found.roll].iter().zip(&row[1..4]) {
            second = second.max((found.abs() - expected).abs());
        }
        height = height.max((1e3 * found.height(feed) - row[4]).abs());
    }
    within("second derivatives", second, 1e-10);
    within("height, µm", height, 1e-6);
}
