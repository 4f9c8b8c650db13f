//! Blanks of bevel files: shaft angles from 20° to 160°, refusals by their cause, designs without slot or top land, cones that do not touch.

use serde_json::Value;

use crate::support::command::{document, put, refusal};
use crate::support::number;
use crate::support::verification::within;

/// A pair by ISO 23509 without flanks.
fn design(pair: &str, teeth: [u32; 2], blank: &str) -> (tempfile::TempDir, String) {
    let text = format!(
        "pair = {{ kind = \"bevel\", {pair} }}\npinion = {{ teeth = {}, hand = \"left\" }}\n\
         gear = {{ teeth = {}, blank = {{ standard = \"ISO 23509\", {blank} }} }}\n",
        teeth[0], teeth[1]
    );
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "pair.toml", &text);
    let path = path.to_str().unwrap().to_string();
    (folder, path)
}

const SPIRAL: &str = "method = 0, spiral_angle = \"35 deg\", outer_pitch_diameter = \"205 mm\", face_width = \"32 mm\", cutter_radius = \"95.25 mm\", addendum_angle = \"1.0 deg\", dedendum_angle = \"3.5 deg\", addendum_factor = 0.3, backlash = \"0.15 mm\"";
const HYPOID: &str = "method = 1, pinion_spiral_angle = \"45 deg\", outer_pitch_diameter = \"180 mm\", face_width = \"27 mm\", cutter_radius = \"76.2 mm\", addendum_angle = \"1 deg\", dedendum_angle = \"3.5 deg\", addendum_factor = 0.3";

/// Codes and messages of the warnings of a command.
fn warnings(command: &str, path: &str) -> Vec<(String, String)> {
    let found = document(&[command, path, "--json"]);
    let all = found["warnings"].as_array().unwrap().iter();
    let text = |w: &Value, key: &str| w[key].as_str().unwrap().to_string();
    all.map(|w| (text(w, "code"), text(w, "message"))).collect()
}

/// Method 0 at shaft angles from 20° to 160°, with and without depth angles: `tan δ₁ = sin Σ/(cos Σ + u)`, the face cones the clearance apart from
/// the root cones of the mate; the blanks as stated cones are the same pair. Neither has flanks, and settings without a flank are refused.
#[test]
fn exact_blanks_at_all_shaft_angles() {
    for degrees in [20.0, 90.0, 150.0, 153.0, 160.0f64] {
        for blank in [
            SPIRAL.to_string(),
            SPIRAL
                .replace("1.0 deg", "0 deg")
                .replace("3.5 deg", "0 deg"),
        ] {
            let pair = format!("shaft_angle = \"{degrees} deg\"");
            let (_kept, path) = design(&pair, [15, 41], &blank);
            let found = document(&["gear", &path, "--json"]);
            let value = |key: &str, k: usize| number(&found["geometry"][key][k]);
            let sigma = degrees.to_radians();
            let first = sigma.sin().atan2(sigma.cos() + 41.0 / 15.0).to_degrees();
            for (k, exact) in [first, degrees - first].into_iter().enumerate() {
                let angle = value("pitch_angle_deg", k);
                within("pitch angle, deg", (angle - exact).abs(), 1e-9);
            }
            let cones = |k: usize| {
                let of = |key: &str, unit: &str| {
                    format!("{} {unit}", value(&format!("{key}_{unit}"), k))
                };
                format!(
                    "blank = {{ pitch_angle = \"{}\", face_angle = \"{}\", root_angle = \"{}\", mean_cone_distance = \"{}\", face_width = \"{}\", face_apex = \"{}\", root_apex = \"{}\" }}",
                    of("pitch_angle", "deg"),
                    of("face_angle", "deg"),
                    of("root_angle", "deg"),
                    of("mean_cone_distance", "mm"),
                    of("face_width", "mm"),
                    of("face_apex_beyond_crossing_point", "mm"),
                    of("root_apex_beyond_crossing_point", "mm"),
                )
            };
            let text = format!(
                "pair = {{ kind = \"bevel\", {pair} }}\n[pinion]\nteeth = 15\nhand = \"left\"\n{}\n[gear]\nteeth = 41\n{}\n",
                cones(0),
                cones(1)
            );
            let folder = tempfile::tempdir().unwrap();
            let stated = put(folder.path(), "cones.toml", &text);
            let again = document(&["gear", stated.to_str().unwrap(), "--json"]);
            for key in ["outer_tip_diameter_mm", "crown_to_crossing_point_mm"] {
                for k in 0..2 {
                    let apart = number(&again["geometry"][key][k]) - value(key, k);
                    within("stated cones, mm", apart.abs(), 1e-6);
                }
            }
            let uncut = text.replace("[gear]", "radial_distance = \"70 mm\"\n[gear]");
            let uncut = put(folder.path(), "uncut.toml", &uncut);
            let (_, message) = refusal(&["gear", uncut.to_str().unwrap()]);
            assert!(message.contains("`concave`"), "{message}");
        }
    }
}

/// Method 1 at flat and steep shaft angles gives cones; a limit radius that none has is refused with the least one.
#[test]
fn refuses_blanks_by_their_cause() {
    for (pair, radius) in [
        ("shaft_angle = \"20 deg\", offset = \"4 mm\"", "228.6 mm"),
        ("shaft_angle = \"150 deg\", offset = \"-15 mm\"", "76.2 mm"),
        ("shaft_angle = \"160 deg\", offset = \"-15 mm\"", "76.2 mm"),
    ] {
        let blank = HYPOID.replace("76.2 mm", radius);
        let (_kept, path) = design(pair, [13, 42], &blank);
        document(&["gear", &path, "--json"]);
    }
    let steep = "shaft_angle = \"160 deg\", offset = \"-15 mm\"";
    for (pair, blank, words) in [
        (
            steep,
            HYPOID.replace("76.2 mm", "50 mm"),
            "the least is 52.",
        ),
        (
            "offset = \"150 mm\"",
            HYPOID.to_string(),
            "no pitch cones touch",
        ),
        (
            "offset = \"0 mm\"",
            SPIRAL.replace("32 mm", "300 mm"),
            "reaches its pitch apex: the inner cone distance is",
        ),
        (
            "offset = \"0 mm\"",
            SPIRAL.replace("3.5 deg", "27 deg"),
            "no depth at the toe",
        ),
        (
            "offset = \"0 mm\"",
            SPIRAL.replace("95.25 mm", "5 mm"),
            "does not reach an end of the face",
        ),
        (
            "offset = \"0 mm\"",
            format!("{SPIRAL}, thickness_factor = 4"),
            "the teeth of the gear have no thickness at the mean point: it is -",
        ),
    ] {
        let (_kept, path) = design(pair, [13, 42], &blank);
        let (_, message) = refusal(&["gear", &path]);
        assert!(message.contains(words), "{words}: {message}");
    }
}

/// A pinion of two teeth has no slot and no top lands at the heel, one of five no top land there; `check` says so as well.
#[test]
fn keeps_warnings_of_designs_without_slot_or_top_land() {
    for command in ["gear", "check"] {
        let (_kept, path) = design("offset = \"0 mm\"", [2, 200], SPIRAL);
        let found = warnings(command, &path);
        let codes: Vec<&str> = found.iter().map(|(code, _)| code.as_str()).collect();
        assert_eq!(codes, ["no-slot", "pointed", "pointed"], "{found:?}");
        assert!(found[0].1.contains("at the heel (-0.108 mm)"), "{found:?}");
        let (_kept, path) = design("offset = \"0 mm\"", [5, 60], SPIRAL);
        let found = warnings(command, &path);
        assert_eq!(found.len(), 1);
        assert!(
            found[0].1.contains("pinion are pointed at the heel"),
            "{found:?}"
        );
        let (_kept, path) = design("offset = \"0 mm\"", [15, 41], SPIRAL);
        assert_eq!(warnings(command, &path), []);
    }
}

/// The shipped pair at another shaft angle and with an offset: its pitch cones overlap by R sin 30° or lie apart, and no theory of a pitch point is
/// given.
#[test]
fn law_cones_that_do_not_touch() {
    let text = std::fs::read_to_string("models/gears/bevel_12_36.toml").unwrap();
    for (pair, words) in [
        ("shaft_angle = \"60 deg\"", "overlap by 40.5"),
        ("offset = \"40 mm\"", "mm apart"),
    ] {
        let from = "shaft_angle = \"90 deg\"";
        assert!(text.contains(from));
        let folder = tempfile::tempdir().unwrap();
        let path = put(folder.path(), "pair.toml", &text.replacen(from, pair, 1));
        let path = path.to_str().unwrap();
        let found = warnings("gear", path);
        let apart = found
            .iter()
            .find(|(code, _)| code == "cones-apart")
            .unwrap();
        assert!(apart.1.contains(words), "{apart:?}");
        let geometry = &document(&["gear", path, "--json"])["geometry"];
        let names: Vec<&String> = geometry.as_object().unwrap().keys().collect();
        assert!(
            !names.iter().any(|name| name.contains("at_the_pitch_point")),
            "{names:?}"
        );
    }
    let whole = document(&["gear", "models/gears/bevel_12_36.toml", "--json"]);
    let names = whole["geometry"].as_object().unwrap().keys();
    assert!(
        names
            .into_iter()
            .any(|name| name.contains("at_the_pitch_point"))
    );
}
