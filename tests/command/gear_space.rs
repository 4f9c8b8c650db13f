//! `geardyn gear` of worm pairs, crossed helical pairs and helicoids with their tools.

use crate::support::command::{document, geardyn, put, refusal, said, with_other_digits};
use crate::support::verification::within;
use crate::support::{number, numbers};
use serde_json::Value;

const WORM: &str = "models/gears/worm_zi_2_40.toml";
const CROSSED: &str = "models/gears/crossed_15_24.toml";
const PLANE_WORM: &str = "models/gears/worm_plane_1_40.toml";
const HOB: &str = "models/gears/hob_za_30.toml";
const HELICOID: &str = "models/gears/worm_zk_grinding.toml";

/// A shipped file with a text in place of another.
fn changed(file: &str, from: &str, to: &str) -> (tempfile::TempDir, String) {
    let text = std::fs::read_to_string(file).unwrap();
    assert!(text.contains(from), "{from}");
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "gears.toml", &text.replacen(from, to, 1));
    let path = path.to_str().unwrap().to_string();
    (folder, path)
}

/// Profile of the wheel of a ZK worm: the cone that ground it. The involute helicoid at the ends of the flank is off by 8.4 and 12.7 µm.
/// Source: data/reference/gear/c44_zk_wheel_wear.json.
#[test]
fn ref_tool_of_a_ground_worm() {
    let found = document(&["gear", HELICOID, "--json"]);
    let tool = &found["tool_profile"];
    let angles = numbers(&tool["tool_profile_angle_deg"]);
    let worst = angles.iter().map(|a| (a - 20.0).abs()).fold(0.0, f64::max);
    within("profile angle of the cone, deg", worst, 1e-9);
    let sections = &found["flank_sections"];
    let off = numbers(&sections["off_the_involute_helicoid_um"]);
    let radii = numbers(&sections["radius_mm"]);
    assert_eq!((radii[0], radii[40]), (15.2, 24.0));
    within("at the root, µm", (off[0] + 8.353391278120577).abs(), 1e-6);
    within("at the tip, µm", (off[40] + 12.716566647714838).abs(), 1e-6);
}

/// Centre distance without backlash, and backlash, of a handbook's pair with profile shift.
/// Source: data/reference/gear/c60_crossed_shifted_handbook.json.
#[test]
fn ref_crossed_pair_of_the_file() {
    let (_kept, path) = changed(CROSSED, "centre_distance = \"67.4 mm\"", "");
    let found = document(&["gear", &path, "--json"]);
    let tight = number(&found["geometry"]["centre_distance_mm"]);
    within(
        "centre distance, mm",
        (tight - 67.31321926236106).abs(),
        1e-9,
    );
    let (_kept, path) = changed(CROSSED, "67.4 mm", "67.3 mm");
    let found = document(&["gear", &path, "--json"]);
    let backlash = number(&found["geometry"]["normal_backlash_mm"]);
    within(
        "normal backlash, mm",
        (backlash + 0.009042508014779571).abs(),
        1e-9,
    );
    assert_eq!(found["warnings"][0]["code"], "no-backlash");
    let hint = found["warnings"][0]["hint"].as_str().unwrap();
    assert!(hint.contains("by 0.0133 mm or more"), "{hint}");
    // An error of assembly counts: 0.1 mm less than 67.4 mm are as 67.3 mm.
    let displaced = "67.4 mm\" }\nassembly = { offset = \"-0.1 mm\" }";
    let (_kept, path) = changed(CROSSED, "67.4 mm\" }", displaced);
    let found = document(&["gear", &path, "--json"]);
    assert_eq!(found["warnings"][0]["hint"], hint);
}

/// The profile that an Archimedean hob leaves, and its feed marks at the pitch point, as in c47 and c61 of data/reference/gear; an involute
/// hob leaves the involute.
#[test]
fn law_hob_of_the_file() {
    let found = document(&["gear", HOB, "--json"]);
    let profile = &found["hobbed_profile"];
    let [radii, off] = ["hob_radius_mm", "off_the_involute_um"].map(|key| numbers(&profile[key]));
    assert!((radii[0] - 36.0).abs() < 1e-9 && (radii[40] - 44.0).abs() < 1e-9);
    within(
        "at the tip, µm",
        (off[0].abs() - 6.060098913026777).abs(),
        1e-5,
    );
    within(
        "at the root, µm",
        (off[40].abs() - 4.920720249143828).abs(),
        1e-5,
    );
    let (_kept, path) = changed(HOB, "type = \"ZA\"", "type = \"ZI\"");
    let exact = document(&["gear", &path, "--json"]);
    let off = numbers(&exact["hobbed_profile"]["off_the_involute_um"]);
    let worst = off.iter().map(|x| x.abs()).fold(0.0, f64::max);
    within("involute hob, µm", worst, 1e-8);
    let height = number(&exact["geometry"]["height_of_feed_marks_at_the_pitch_point_mm"]);
    within(
        "feed marks, µm",
        (1e3 * height - 3.6611849582811744).abs(),
        1e-6,
    );
}

/// First and second lines of contact of a plane double-enveloping worm; in the middle of each second line the wheel lies above the plane.
#[test]
fn law_plane_worm_has_two_lines() {
    let found = document(&["gear", PLANE_WORM, "--json"]);
    let [first, second] = ["contact", "second_contact"].map(|key| &found[key]);
    let heights = |of: &Value| numbers(&of["height_over_the_plane_mm"]);
    assert!(heights(first).iter().all(|h| *h == 0.0));
    assert!(heights(second).len() > 10 && heights(second).iter().all(|h| *h >= 0.0));
    let y = |of: &Value| numbers(&of["y_wheel_mm"]);
    assert!(y(first).iter().chain(&y(second)).all(|y| y.abs() <= 16.0));
    assert!(number(&found["geometry"]["contact_ratio"]) > 1.0);
    assert!(found["curve_between_both_parts"].is_object());
}

/// Two left-hand gears are the mirror image of two right-hand ones, also with the shaft angle by default.
#[test]
fn law_left_hands_mirror_right_ones() {
    let text = std::fs::read_to_string(CROSSED).unwrap();
    let text = text.replace("shaft_angle = \"50 deg\", ", "");
    let folder = tempfile::tempdir().unwrap();
    let found = |text: &str| {
        let path = put(folder.path(), "pair.toml", text);
        document(&["gear", path.to_str().unwrap(), "--json"])
    };
    let [right, left] = [found(&text), found(&text.replace("right", "left"))];
    for key in ["shaft_angle_deg", "normal_backlash_mm", "contact_ratio"] {
        assert_eq!(right["geometry"][key], left["geometry"][key], "{key}");
    }
    assert_eq!(right["contact"]["z_mm"], left["contact"]["z_mm"]);
    let y = |of: &Value| numbers(&of["contact"]["y_mm"]);
    assert!(y(&right).iter().zip(y(&left)).all(|(a, b)| *a == -b));
}

/// Lines of contact lie on the wheel within face and throat, and their count follows the contact ratio.
#[test]
fn law_contact_lies_on_the_wheel() {
    let found = document(&["gear", WORM, "--json"]);
    let contact = &found["contact"];
    let (y, radius) = (
        numbers(&contact["y_wheel_mm"]),
        numbers(&contact["wheel_radius_mm"]),
    );
    assert!(y.iter().all(|y| y.abs() <= 20.0) && radius.iter().all(|r| *r <= 107.5));
    let turns = numbers(&contact["worm_turn_deg"]);
    let mut turns: Vec<i64> = turns.iter().map(|turn| turn.round() as i64).collect();
    turns.dedup();
    let ratio = number(&found["geometry"]["contact_ratio"]);
    let lines = turns.len() as f64;
    assert!(
        (lines - 4.0 * ratio).abs() <= 1.0,
        "{lines} lines, contact ratio {ratio}"
    );
    let (_kept, left) = changed(WORM, "hand = \"right\"", "hand = \"left\"");
    let mirrored = document(&["gear", &left, "--json"]);
    let of_left = numbers(&mirrored["contact"]["y_wheel_mm"]);
    assert!(y.iter().zip(&of_left).all(|(a, b)| *a == -b));
}

/// The profile shift that the undercut warning names avoids it, and a step less does not.
#[test]
fn law_undercut_hint_holds() {
    let small = |shift: f64| {
        let (kept, path) = changed(
            WORM,
            "teeth = 40, profile_shift = 0.0",
            &format!("teeth = 20, profile_shift = {shift}"),
        );
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("20 deg", "15 deg")).unwrap();
        let found = document(&["gear", &path, "--json"]);
        drop(kept);
        found["warnings"].as_array().unwrap().first().cloned()
    };
    let warning = small(0.0).unwrap();
    assert_eq!(warning["code"], "undercut");
    let hint = warning["hint"].as_str().unwrap();
    let named = hint.split("profile_shift = ").nth(1).unwrap();
    let shift: f64 = named.split(' ').next().unwrap().parse().unwrap();
    assert!(small(shift).is_none(), "{hint}");
    assert!(small(shift - 0.06).is_some(), "{hint}");
}

/// Wrong files are refused with the key and the remedy.
#[test]
fn refuses_wrong_files_of_gears_in_space() {
    let cases = [
        (
            WORM,
            "\"90 deg\"",
            "\"80 deg\"",
            "other shaft angles than 90",
        ),
        (WORM, "type = \"ZI\"", "type = \"ZK\"", "no `tool_radius`"),
        (
            WORM,
            "type = \"ZI\"",
            "type = \"ZI\", tool_radius = \"90 mm\"",
            "applies to the flank types",
        ),
        (WORM, "type = \"ZI\"", "type = \"ZE\"", "ZE"),
        (
            WORM,
            "teeth = 40",
            "teeth = 40, tip_diameter = \"185 mm\"",
            "does not reach",
        ),
        (WORM, "length = \"80 mm\"", "", "no `length`"),
        (
            CROSSED,
            "shaft_angle = \"50 deg\"",
            "shaft_angle = \"5 deg\"",
            "no common normal",
        ),
        (CROSSED, "hand = \"right\", ", "", "no `hand`"),
        (CROSSED, "67.4 mm", "90 mm", "do not touch"),
        (HELICOID, "kind = \"disk\"", "kind = \"hob\"", "no `teeth`"),
        (PLANE_WORM, "\"125 mm\"", "\"135 mm\"", "do not touch"),
        (PLANE_WORM, "\"40 mm\"", "\"101 mm\"", "base circle"),
        (HOB, "starts = 2", "starts = 18", "lead angle"),
        (HOB, "type = \"ZA\"", "type = \"ZK\"", "ZK"),
        (
            HELICOID,
            "tool_radius = \"100 mm\" }",
            "tool_radius = \"100 mm\", tip_diameter = \"30 mm\" }",
            "does not contain the reference",
        ),
    ];
    for (file, from, to, says) in cases {
        let (_kept, path) = changed(file, from, to);
        let (_, message) = refusal(&["gear", &path]);
        assert!(message.contains(says), "{to}: {message}");
    }
    let (_, message) = refusal(&["gear", WORM, "--torque", "10"]);
    assert!(message.contains("torque"), "{message}");
    let (_, message) = refusal(&["accuracy", WORM]);
    assert!(message.contains("cylindrical"), "{message}");
    let worm = std::fs::canonicalize(WORM).unwrap();
    let (_kept, path) = changed(
        "models/noise_rig.toml",
        "gear = \"gears/stage_28_56.toml\"",
        &format!("gear = \"{}\"", worm.display()),
    );
    let (_, message) = refusal(&["modes", &path]);
    assert!(
        message.contains("of a cylindrical or a bevel pair"),
        "{message}"
    );
}

/// Plan, check, figures and CSV of each kind.
#[test]
fn law_every_command_takes_gears_in_space() {
    let folder = tempfile::tempdir().unwrap();
    for (file, suffix) in [
        (WORM, "-axodes"),
        (PLANE_WORM, "-axodes"),
        (CROSSED, "-axodes"),
        (HOB, "-feed-marks"),
        (HELICOID, "-deviation"),
    ] {
        let place = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
        let (svg, csv) = (place("a.svg"), place("a.csv"));
        let output = geardyn(&["gear", file, "--svg", &svg, "--csv", &csv, "--quiet"]);
        assert_eq!(output.status.code(), Some(0), "{file}");
        let drawn = std::fs::read_to_string(place(&format!("a{suffix}.svg"))).unwrap();
        assert!(
            drawn.contains("<polyline") || drawn.contains("<path"),
            "{file}"
        );
        assert!(std::fs::read_to_string(&csv).unwrap().lines().count() > 15);
        let (code, text, _) = said(&["check", file]);
        assert_eq!(code, Some(0), "{text}");
        let plan = document(&["plan", file, "--json"]);
        assert!(plan.to_string().contains("geometry"), "{plan}");
    }
}

/// Changed digits give an answer, a refusal or a warning, never a panic or NaN.
#[test]
fn survives_mutated_files_of_gears_in_space() {
    fastrand::seed(29);
    let folder = tempfile::tempdir().unwrap();
    for file in [WORM, PLANE_WORM, CROSSED, HOB, HELICOID] {
        let text = std::fs::read_to_string(file).unwrap();
        for _ in 0..60 {
            let mutated = with_other_digits(&text);
            let path = put(folder.path(), "gears.toml", &mutated);
            let (code, text, notes) = said(&["gear", path.to_str().unwrap()]);
            assert!(
                matches!(code, Some(0 | 2 | 3)),
                "{code:?} {notes}\n{mutated}"
            );
            let bad = ["NaN", " inf", "panicked"]
                .iter()
                .any(|word| text.contains(word) || notes.contains(word));
            assert!(!bad, "{text}{notes}\n{mutated}");
        }
    }
}

/// A worm pair of a machine by its gear file is the one by the same numbers; keys that the file determines, files of other pairs and of
/// plane-enveloping worms are refused.
#[test]
fn law_worm_of_a_machine() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["worm_zi_2_40", "worm_plane_1_40", "bevel_12_36"] {
        let text = std::fs::read_to_string(format!("models/gears/{name}.toml")).unwrap();
        put(folder.path(), &format!("{name}.toml"), &text);
    }
    let model = |keys: &str| {
        format!(
            "inertia = [{{ name = \"worm\", J = \"0.01 kg·m²\" }}, {{ name = \"wheel\", J = \"0.2 kg·m²\" }}]\n\
             [[worm_pair]]\nname = \"mesh\"\nbetween = [\"worm\", \"wheel\"]\nk = \"300 N/µm\"\n{keys}\n"
        )
    };
    let modes = |keys: &str| {
        let path = put(folder.path(), "machine.toml", &model(keys));
        document(&["modes", path.to_str().unwrap(), "--json"])["modes"].clone()
    };
    let lead = 0.2f64.atan().to_degrees();
    let stated = modes(&format!(
        "teeth = [2, 40]\nmodule = \"5 mm\"\nlead_angle = \"{lead} deg\"\npressure_angle = \"20 deg\""
    ));
    let named = modes("gear = \"worm_zi_2_40.toml\"");
    let frequency = |modes: &Value| number(&modes[1]["frequency_hz"]);
    assert!(frequency(&named) > 100.0);
    // Another worm is another model; a shifted wheel meshes on a larger pitch cylinder of the worm, where the lead angle is smaller.
    let path = put(
        folder.path(),
        "machine.toml",
        &model("gear = \"worm_zi_2_40.toml\"\nfriction = 0.05"),
    );
    let path = path.to_str().unwrap();
    let hash = || document(&["modes", path, "--json"])["geardyn"]["model_hash"].clone();
    let before = hash();
    assert!(before.is_string());
    let text = std::fs::read_to_string("models/gears/worm_zi_2_40.toml").unwrap();
    put(
        folder.path(),
        "worm_zi_2_40.toml",
        &text.replace("profile_shift = 0.0", "profile_shift = 1.0"),
    );
    assert_ne!(before, hash());
    let (_, _, notes) = said(&["modes", path]);
    let lead = (2.0f64 / 12.0).atan();
    let rho = (0.05 / (0.2f64.atan().cos() * 20f64.to_radians().cos() / lead.cos())).atan();
    let percent = 100.0 * lead.tan() / (lead + rho).tan();
    assert!(
        notes.contains(&format!("efficiency {percent:.0} %")),
        "{percent}: {notes}"
    );
    put(folder.path(), "worm_zi_2_40.toml", &text);
    within(
        "frequency by the gear file, relative",
        (frequency(&named) / frequency(&stated) - 1.0).abs(),
        1e-14,
    );
    for (keys, message) in [
        (
            "gear = \"worm_zi_2_40.toml\"\nlead_angle = \"11 deg\"",
            "`lead_angle` is determined by the gear file",
        ),
        (
            "gear = \"worm_plane_1_40.toml\"",
            "takes the gear file of a cylindrical worm",
        ),
        (
            "gear = \"bevel_12_36.toml\"",
            "takes the gear file of a cylindrical worm",
        ),
        ("teeth = [2, 40]\nmodule = \"5 mm\"", "`lead_angle`"),
    ] {
        let path = put(folder.path(), "wrong.toml", &model(keys));
        let (_, said) = refusal(&["check", path.to_str().unwrap()]);
        assert!(said.contains(message), "{keys}: {said}");
    }
}

/// A wheel so small that it reaches a part of the flank only says which.
#[test]
fn law_small_reground_wheel_warns() {
    let (_folder, path) = changed(
        HELICOID,
        "\"disk\", radius = \"100 mm\" }",
        "\"disk\", radius = \"100 mm\", reground_radius = \"2 mm\" }",
    );
    let found = document(&["gear", &path, "--json"]);
    let ground = numbers(&found["regrinding"]["radius_mm"]);
    assert!(ground.len() < numbers(&found["flank_sections"]["radius_mm"]).len());
    let warning = &found["warnings"][0];
    assert_eq!(warning["code"], "undercut");
    let message = warning["message"].as_str().unwrap();
    let last = message.split(" and ").nth(1).unwrap().split(' ').next();
    let last: f64 = last.unwrap().parse().unwrap();
    // The end lies between the last radius of the table and the next.
    let step = ground[1] - ground[0];
    let beyond = last - ground[ground.len() - 1];
    assert!((-5e-4..step).contains(&beyond), "{message}");
}

/// A wheel dressed from 250 to 200 mm: both flanks are the tabled distances from the involute helicoid apart. Threads that no wheel grinds
/// refuse it.
/// Source: data/reference/gear/c44_zk_wheel_wear.json.
#[test]
fn ref_reground_worm() {
    let text = std::fs::read_to_string("data/reference/gear/c44_zk_wheel_wear.json").unwrap();
    let case: Value = serde_json::from_str(&text).unwrap();
    let off = |radius: &str| {
        let rows = &case["expected"]["wheel_radius_R0"][radius]["rows"];
        let rows: Vec<Vec<f64>> = rows.as_array().unwrap().iter().map(numbers).collect();
        [rows[0][2], rows[rows.len() - 1][2]]
    };
    let ([before_root, before_tip], [root, tip]) = (off("250.0"), off("200.0"));
    let (_folder, path) = changed(
        HELICOID,
        "tool_radius = \"100 mm\"",
        "tool_radius = \"250 mm\"",
    );
    let text = std::fs::read_to_string(&path).unwrap();
    let radius = "radius = \"100 mm\" }";
    assert!(text.contains(radius));
    let text = text.replace(
        radius,
        "radius = \"250 mm\", reground_radius = \"200 mm\" }",
    );
    std::fs::write(&path, &text).unwrap();
    let found = &document(&["gear", &path, "--json"])["regrinding"];
    let [flank, involute] =
        ["off_the_flank_um", "off_the_involute_helicoid_um"].map(|k| numbers(&found[k]));
    let last = flank.len() - 1;
    for (name, found, expected) in [
        ("root", flank[0], root - before_root),
        ("tip", flank[last], tip - before_tip),
        ("root from the involute helicoid", involute[0], root),
        ("tip from the involute helicoid", involute[last], tip),
    ] {
        within(&format!("{name}, µm"), (found - expected).abs(), 1e-8);
    }
    std::fs::write(
        &path,
        text.replace("\"ZK\"", "\"ZI\"")
            .replace(", tool_radius = \"250 mm\"", ""),
    )
    .unwrap();
    let (_, message) = refusal(&["gear", &path]);
    assert!(
        message.contains("`tool.reground_radius` applies to ground threads"),
        "{message}"
    );
}
