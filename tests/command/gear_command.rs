//! `geardyn gear` as it is called.

use std::path::Path;

use serde_json::Value;

use crate::support::command::{document, geardyn, put, said};
use crate::support::verification::{printed, within};

const FZG: &str = "models/gears/fzg_c.toml";

/// Everything said of a refusal, which ends the command with 2.
fn refused(arguments: &[&str]) -> String {
    let (code, text, notes) = said(arguments);
    assert_eq!(code, Some(2), "{arguments:?}\n{text}{notes}");
    text + &notes
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// Geometry of the FZG test gears of type C through the command.
///
/// Source: DIN ISO 14635-1:2006, test gears type C; contact ratio, sliding and active diameters recomputed to the digits shown.
#[test]
fn ref_fzg_test_gears() {
    let found = document(&["gear", FZG, "--json"]);
    let geometry = &found["geometry"];
    let pair = |key: &str| number(&geometry[key]);
    let each = |key: &str, k: usize| number(&geometry[key][k]);
    printed(
        "working pressure angle",
        "deg",
        22.438791,
        pair("working_pressure_angle_deg"),
        0.6e-6,
    );
    printed(
        "transverse contact ratio",
        "",
        1.43754,
        pair("transverse_contact_ratio"),
        0.6e-5,
    );
    printed(
        "active root diameter of the pinion",
        "mm",
        68.2466,
        each("active_root_diameter_mm", 0),
        0.6e-4,
    );
    printed(
        "active root diameter of the gear",
        "mm",
        103.9971,
        each("active_root_diameter_mm", 1),
        0.6e-4,
    );
    let path = found["path"].as_array().unwrap();
    let sliding = |point: usize, k: usize| number(&path[point]["specific_sliding"][k]);
    printed(
        "specific sliding of the pinion at A",
        "",
        -3.539,
        sliding(0, 0),
        0.6e-3,
    );
    printed(
        "specific sliding of the gear at E",
        "",
        -2.113,
        sliding(4, 1),
        0.6e-3,
    );
    printed(
        "specific sliding of the pinion at E",
        "",
        0.6788,
        sliding(4, 0),
        0.6e-4,
    );
    printed(
        "specific sliding of the gear at A",
        "",
        0.7797,
        sliding(0, 1),
        0.6e-4,
    );
}

/// Two tooth numbers and a module are a gear file: profile A, no shift, no backlash; what was assumed is named.
#[test]
fn exact_pair_of_two_tooth_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let text = "pair = { kind = \"cylindrical\", module = \"2 mm\" }\npinion = { teeth = 20 }\ngear = { teeth = 40 }\n";
    let path = put(folder.path(), "pair.toml", text);
    let path = path.to_str().unwrap();
    let found = document(&["gear", path, "--json"]);
    assert!((number(&found["geometry"]["centre_distance_mm"]) - 60.0).abs() < 1e-12);
    // W_3 = m cos α (2.5 π + z inv α).
    let angle = 20f64.to_radians();
    let exact = 2.0 * angle.cos() * (2.5 * std::f64::consts::PI + 20.0 * (angle.tan() - angle));
    let span = number(&found["drawing"][0][0]["nominal_mm"]);
    assert!((span - exact).abs() < 1e-12, "{span} {exact}");
    assert!(number(&found["backlash"]["nominal"]["circumferential_um"]).abs() < 1e-9);
    let (_, text, notes) = said(&["gear", path]);
    assert!(text.contains("centre distance") && !text.contains("torque"));
    for words in [
        "ISO 53 profile A",
        "pinion.profile_shift: 0",
        "20 mm, ten modules",
        "rates no load capacity",
    ] {
        assert!(notes.contains(words), "{words}: {notes}");
    }
}

/// Under load the shares of all pairs sum to 1, the driven gear lags, and more torque gives more transmission error.
#[test]
fn law_mesh_of_a_loaded_pair() {
    let found = document(&[
        "gear",
        FZG,
        "--torques",
        "50:200:4",
        "--positions",
        "24",
        "--json",
    ]);
    let mesh = &found["mesh"];
    assert_eq!(
        mesh["torques_nm"],
        serde_json::json!([50.0, 100.0, 150.0, 200.0])
    );
    let mut last = 0.0;
    for torque in 0..4 {
        for position in 0..24 {
            let shares = mesh["shares"][torque][position].as_array().unwrap();
            let sum: f64 = shares.iter().map(number).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{sum}");
            assert!(number(&mesh["te_um"][torque][position]) < 0.0);
        }
        let over = number(&mesh["peak_to_peak_um"][torque]);
        assert!(over > last, "{over} {last}");
        last = over;
    }
}

/// Tip relief that fits the load lowers the transmission error at that load, and raises it without load.
#[test]
fn law_relief_trades_load_for_no_load() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(FZG).unwrap();
    let relieved = text
        .replace(
            "tip_diameter = \"82.46 mm\"",
            "tip_diameter = \"82.46 mm\", tip_relief = \"25 µm\", relief_from = \"17.7 mm\"",
        )
        .replace(
            "tip_diameter = \"118.36 mm\"",
            "tip_diameter = \"118.36 mm\", tip_relief = \"25 µm\", relief_from = \"24.5 mm\"",
        );
    assert_ne!(text, relieved);
    let path = put(folder.path(), "relieved.toml", &relieved);
    let over = |file: &str| {
        let found = document(&["gear", file, "--torque", "400", "--json"]);
        (
            number(&found["mesh"]["peak_to_peak_um"][0]),
            number(&found["mesh"]["unloaded_peak_to_peak_um"]),
        )
    };
    let (plain, relieved) = (over(FZG), over(path.to_str().unwrap()));
    assert!(relieved.0 < 0.6 * plain.0, "{plain:?} {relieved:?}");
    assert!(plain.1 < 1e-6 && relieved.1 > 1.0, "{plain:?} {relieved:?}");
}

/// Figures and tables are written where they are named.
#[test]
fn keeps_files_of_a_gear_pair() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (svg, csv) = (at("p.svg"), at("p.csv"));
    let done = geardyn(&[
        "gear",
        FZG,
        "--torques",
        "100:200:2",
        "--positions",
        "12",
        "--svg",
        &svg,
        "--csv",
        &csv,
        "--quiet",
    ]);
    assert!(done.status.success());
    for name in ["", "-sliding", "-mesh", "-stiffness", "-sharing", "-harris"] {
        let name = format!("p{name}.svg");
        let plot = std::fs::read_to_string(Path::new(&at(&name))).unwrap();
        assert!(plot.starts_with("<svg") && plot.contains("FZG test gears, type C"));
    }
    let table = std::fs::read_to_string(csv).unwrap();
    assert!(table.starts_with("pinion_angle [rad],te_unloaded [µm],te at 100 N·m [µm]"));
    assert_eq!(table.lines().count(), 13);
}

/// What cannot mesh is refused with the place and the nearest value that works; limits that are met are warned of.
#[test]
fn refuses_gears_that_cannot_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let count = std::cell::Cell::new(0);
    let file = |pair: &str, pinion: &str, gear: &str| {
        count.set(count.get() + 1);
        let text = format!(
            "pair = {{ kind = \"cylindrical\", module = \"2 mm\"{pair} }}\npinion = {{ teeth = {pinion} }}\ngear = {{ teeth = {gear} }}\n"
        );
        let path = put(folder.path(), &format!("pair_{}.toml", count.get()), &text);
        path.to_str().unwrap().to_string()
    };
    let cases = [
        (
            file(", centre_distance = \"50 mm\"", "20", "40"),
            "base circles touch at 56.38",
        ),
        (file("", "20", "18, internal = true"), "cannot contain"),
        (
            file("", "20, internal = true", "40"),
            "first gear is internal",
        ),
        (file("", "20, tip_relief = \"10 µm\"", "40"), "relief_from"),
        (
            file(", helix_angle = \"95 deg\"", "20", "40"),
            "helix_angle",
        ),
        (file("", "20, modul = 3", "40"), "modul"),
        (file("", "1", "40"), "teeth"),
    ];
    for (path, words) in &cases {
        let text = refused(&["gear", path, "--json"]);
        assert!(text.contains(words), "{words}: {text}");
    }
    let undercut = file("", "8", "40");
    let found = document(&["gear", &undercut, "--json"]);
    assert_eq!(found["limits"][0]["kind"], "undercut");
    assert_eq!(found["warnings"][0]["code"], "undercut");
    let nearest = number(&found["limits"][0]["nearest"]["profile_shift"]);
    let cured = file("", &format!("8, profile_shift = {}", nearest + 1e-6), "40");
    let found = document(&["gear", &cured, "--json"]);
    assert!(
        found["limits"]
            .as_array()
            .unwrap()
            .iter()
            .all(|l| l["kind"] != "undercut"),
        "{found}"
    );
    let text = refused(&["gear", FZG, "--torque", "0"]);
    assert!(text.contains("torque"), "{text}");
    let text = refused(&["modes", FZG]);
    assert!(text.contains("geardyn gear"), "{text}");
    let (code, text, _) = said(&["check", FZG]);
    assert!(
        code == Some(0) && text.contains("cylindrical gears of 16 and 24 teeth"),
        "{text}"
    );
}

/// The stages of a gear file, with the reason for each that does not run; flags of studies do not apply.
#[test]
fn law_plan_names_its_stages() {
    let plan = document(&["plan", FZG, "--json"]);
    let stages = plan["stages"].as_array().unwrap();
    let runs = |name: &str| {
        let stage = stages.iter().find(|stage| stage["stage"] == name).unwrap();
        stage["runs"].as_bool().unwrap()
    };
    for name in ["geometry", "flanks", "limits", "contact"] {
        assert!(runs(name), "{name}");
    }
    assert!(!runs("mesh"));
    let loaded = document(&["plan", "models/gears/helical.toml", "--json"]);
    let last = loaded["stages"].as_array().unwrap().iter();
    assert!(
        last.clone()
            .any(|s| s["stage"] == "mesh" && s["runs"] == true)
    );
    let text = refused(&["plan", FZG, "--damped"]);
    assert!(text.contains("--damped has no effect here"), "{text}");
}

/// Errors of e(φ, T) and k(φ, T) fall as slices are added, down to the error of the reference, which half its grid gives.
#[test]
fn law_error_of_a_mesh_over_its_grid() {
    let folder = tempfile::tempdir().unwrap();
    let helical = std::fs::read_to_string("models/gears/helical.toml").unwrap();
    let path = put(folder.path(), "helical.toml", &helical);
    let found = document(&[
        "accuracy",
        path.to_str().unwrap(),
        "--json",
        "--error",
        "0.05",
    ]);
    for (name, coarse) in [("te", 0.1), ("stiffness", 0.02)] {
        let result = &found[name];
        let floor = number(&result["reference"]["error"]);
        assert!(floor > 0.0 && floor < 0.01, "{name}: {floor}");
        let error = |positions: u32, slices: u32| {
            let runs = result["runs"].as_array().unwrap();
            let is = |run: &&Value| run["positions"] == positions && run["slices"] == slices;
            number(&runs.iter().find(is).unwrap()["error"])
        };
        let errors = [5, 11, 41].map(|slices| error(60, slices));
        assert!(errors[0] > coarse, "{name}: {errors:?}");
        assert!(
            errors[1] < 0.8 * errors[0] && errors[2] < 0.5 * errors[1],
            "{name}: {errors:?}"
        );
        assert!(errors[2] >= floor);
        assert_eq!(result["recommendation"]["reached"], true);
    }
    let text = refused(&["accuracy", FZG]);
    assert!(text.contains("no torque is given"), "{text}");
}

/// Spur teeth are alike along the face: five slices serve, and the errors fall with the positions.
#[test]
fn law_slices_of_spur_gears_are_not_compared() {
    let found = document(&["accuracy", "models/gears/stage_28_56.toml", "--json"]);
    let result = &found["te"];
    let floor = number(&result["reference"]["error"]);
    assert!(floor < 1e-3, "{floor}");
    let runs = result["runs"].as_array().unwrap();
    assert!(runs.iter().all(|run| run["slices"] == 5));
    let errors: Vec<f64> = runs.iter().map(|run| number(&run["error"])).collect();
    assert_eq!(errors.len(), 5);
    assert!(errors.windows(2).all(|e| e[1] < 0.8 * e[0]), "{errors:?}");
}

/// An error of the centre distance moves the working pressure angle and leaves tips as they are: `cos α_wt = a_d cos α_t/a`.
#[test]
fn exact_error_of_the_centre_distance() {
    let folder = tempfile::tempdir().unwrap();
    let text = "pair = { kind = \"cylindrical\", module = \"2 mm\" }\npinion = { teeth = 20 }\ngear = { teeth = 40 }\n";
    let moved = format!("{text}assembly = {{ offset = \"0.1 mm\" }}\n");
    let plain = put(folder.path(), "plain.toml", text);
    let moved = put(folder.path(), "moved.toml", &moved);
    let of = |path: &Path| document(&["gear", path.to_str().unwrap(), "--json"]);
    let (plain, moved) = (of(&plain), of(&moved));
    let angle = number(&moved["geometry"]["working_pressure_angle_deg"]);
    let exact = (60.0 * 20f64.to_radians().cos() / 60.1).acos().to_degrees();
    assert!((angle - exact).abs() < 1e-10, "{angle} {exact}");
    assert_eq!(
        plain["geometry"]["tip_diameter_mm"],
        moved["geometry"]["tip_diameter_mm"]
    );
    // j_bn = 2 a (inv α_wt − inv α) cos α of gears without backlash at a = 60 mm, in µm.
    let inv = |degrees: f64| degrees.to_radians().tan() - degrees.to_radians();
    let exact = 1e3 * 2.0 * 60.0 * (inv(angle) - inv(20.0)) * 20f64.to_radians().cos();
    let play = number(&moved["backlash"]["nominal"]["normal_um"]);
    assert!((play - exact).abs() < 1e-6, "{play} {exact}");
    for (table, words) in [
        ("assembly = { pinion_axial = \"1 mm\" }", "pinion_axial"),
        ("contact = { pitches = 2 }", "point contact"),
    ] {
        let path = put(folder.path(), "refused.toml", &format!("{text}{table}\n"));
        let said = refused(&["gear", path.to_str().unwrap()]);
        assert!(said.contains(words), "{said}");
    }
}

/// Gears of one hand cannot mesh on parallel axes, a ring and its pinion of two hands neither.
#[test]
fn refuses_hands_that_cannot_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let file = |helix: &str, pinion: &str, gear: &str| {
        let text = format!(
            "pair = {{ kind = \"cylindrical\", module = \"3 mm\", helix_angle = \"{helix}\" }}\npinion = {{ teeth = 19{pinion} }}\ngear = {{ teeth = 91{gear} }}\n"
        );
        put(folder.path(), "pair.toml", &text)
    };
    let (left, right) = (", hand = \"left\"", ", hand = \"right\"");
    let ring = |hand: &str| format!("{hand}, internal = true");
    for (pinion, gear) in [
        (left, left.to_string()),
        (right, right.into()),
        (left, ring(right)),
    ] {
        let path = file("20 deg", pinion, &gear);
        let notes = refused(&["gear", path.to_str().unwrap()]);
        assert!(notes.contains("pinion.hand and gear.hand"), "{notes}");
    }
    for (pinion, gear) in [
        (left, right.to_string()),
        ("", right.into()),
        (left, ring(left)),
    ] {
        let path = file("20 deg", pinion, &gear);
        let (code, _, notes) = said(&["gear", path.to_str().unwrap()]);
        assert_eq!(code, Some(0), "{notes}");
    }
}

/// A helix slope at one end of the face is for one hand what its negative is for the other; the same slope is not.
#[test]
fn law_helix_slope_goes_by_the_hand() {
    let folder = tempfile::tempdir().unwrap();
    let ripple = |hand: &str, slope: &str| {
        let text = format!(
            "pair = {{ kind = \"cylindrical\", module = \"3 mm\", helix_angle = \"15 deg\" }}\npinion = {{ teeth = 19, hand = \"{hand}\", face_width = \"30 mm\", helix_slope = \"{slope}\" }}\ngear = {{ teeth = 59, face_width = \"30 mm\" }}\n[mesh]\ntorque = \"190 N·m\"\n"
        );
        let path = put(folder.path(), "pair.toml", &text);
        let csv = folder.path().join("mesh.csv");
        let done = geardyn(&[
            "gear",
            path.to_str().unwrap(),
            "--csv",
            csv.to_str().unwrap(),
            "--quiet",
        ]);
        assert!(done.status.success());
        let table = std::fs::read_to_string(csv).unwrap();
        let error: Vec<f64> = (table.lines().skip(1))
            .map(|line| line.split(',').nth(2).unwrap().parse().unwrap())
            .collect();
        let [low, high] = [f64::min, f64::max].map(|f| error.iter().copied().reduce(f).unwrap());
        high - low
    };
    let (right, left) = (ripple("right", "10 µm"), ripple("left", "10 µm"));
    let mirrored = ripple("left", "-10 µm");
    assert!(
        (right - mirrored).abs() < 1e-3 * right,
        "{right} {mirrored}"
    );
    assert!((right - left).abs() > 0.01 * right, "{right} {left}");
}

/// The least file answers at every usual pressure angle, with each default named and all readings of the drawing.
#[test]
fn survives_the_least_file() {
    let folder = tempfile::tempdir().unwrap();
    for angle in [14.5, 20.0, 22.5, 25.0, 28.0] {
        let text = format!(
            "pair = {{ kind = \"cylindrical\", module = \"2 mm\", pressure_angle = \"{angle} deg\" }}\npinion = {{ teeth = 20 }}\ngear = {{ teeth = 40 }}\n"
        );
        let path = put(folder.path(), "pair.toml", &text);
        let (code, table, notes) = said(&["gear", path.to_str().unwrap()]);
        assert_eq!(code, Some(0), "{angle}: {notes}");
        let all = table + &notes;
        for part in [
            "over balls of",
            "helix_angle: 0",
            "centre_distance: without backlash",
        ] {
            assert!(all.contains(part), "{angle} {part}: {all}");
        }
    }
}

/// A ring's tip at 69.000 mm meets the pinion inside its base circle by 0.03 mm along the path; its tip corners pass free.
/// Source: internal pair 16/24, m 3 mm, x 0/0.5 of a handbook; nearest tip 69.012 mm.
#[test]
fn ref_internal_pair_says_what_is_free() {
    let folder = tempfile::tempdir().unwrap();
    let text = "pair = { kind = \"cylindrical\", module = \"3 mm\" }\npinion = { teeth = 16 }\n\
         gear = { teeth = 24, internal = true, profile_shift = -0.5, tip_diameter = \"69 mm\" }\n";
    let path = put(folder.path(), "ring.toml", text);
    let path = path.to_str().unwrap();
    let found = document(&["gear", path, "--json"]);
    let kept = found["limits_kept"].to_string();
    assert!(
        kept.contains("trochoid interference") && !kept.contains("involute"),
        "{kept}"
    );
    let limits = found["limits"].as_array().unwrap();
    let involute = limits.iter().find(|l| l["kind"] == "interference").unwrap();
    printed(
        "interference",
        "mm",
        0.03,
        1e3 * number(&involute["by_si"]),
        0.005,
    );
    let tip = number(&involute["nearest"]["tip_diameter_mm"]);
    printed("nearest tip", "mm", 69.012, tip, 0.001);
    let (code, text, _) = said(&["gear", path]);
    assert_eq!(code, Some(0));
    assert!(
        text.contains("free of fillet interference, trochoid interference"),
        "{text}"
    );
}

/// A model, readings and a measured gear are one error with the command that takes them; flags of a load need a torque.
#[test]
fn refuses_files_of_other_commands() {
    for (file, command) in [
        ("models/gear_pair.toml", "geardyn check"),
        ("data/unknown_gear.toml", "geardyn gear reverse"),
        ("data/index_gear.toml", "geardyn measure"),
    ] {
        let all = refused(&["gear", file]);
        assert_eq!(all.matches("error").count(), 1, "{all}");
        assert!(all.contains(command), "{all}");
    }
    let all = refused(&["gear", FZG, "--positions", "30"]);
    assert!(
        all.contains("--positions has no effect without a torque"),
        "{all}"
    );
}

/// The relief that the command names leaves, as keys of the file, the peak-to-peak it states, and less than the teeth without it.
#[test]
fn law_least_relief_of_the_command() {
    let found = document(&[
        "gear",
        FZG,
        "--torques",
        "150:250:2",
        "--least-relief",
        "--json",
    ]);
    let least = &found["least_relief"];
    let text = std::fs::read_to_string(FZG).unwrap();
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    for name in ["pinion", "gear"] {
        let keys = format!(
            ", tip_relief = \"{} µm\", relief_from = \"{} mm\" }}",
            number(&least[name]["tip_relief_um"]),
            number(&least[name]["relief_from_mm"])
        );
        let line = lines
            .iter_mut()
            .find(|line| line.starts_with(name))
            .unwrap();
        *line = line.replace(" }", &keys);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "relieved.toml", &lines.join("\n"));
    let relieved = document(&[
        "gear",
        path.to_str().unwrap(),
        "--torques",
        "150:250:2",
        "--json",
    ]);
    let stated = least["peak_to_peak_um"].as_array().unwrap();
    let found = relieved["mesh"]["peak_to_peak_um"].as_array().unwrap();
    for (stated, found) in [(&stated[0], &found[0]), (&stated[4], &found[1])] {
        within(
            "peak to peak",
            (number(found) / number(stated) - 1.0).abs(),
            1e-6,
        );
    }
    let without = number(&least["without_um"][4]);
    assert!(number(&found[1]) < 0.5 * without, "{} {without}", found[1]);
}

/// A start of relief as roll angle is the length of roll r_b ξ.
#[test]
fn exact_relief_from_a_roll_angle() {
    let folder = tempfile::tempdir().unwrap();
    let base = 0.5 * 40.0 * 20f64.to_radians().cos();
    let te = |from: String| {
        let text = format!(
            "pair = {{ kind = \"cylindrical\", module = \"2 mm\" }}\npinion = {{ teeth = 20, tip_relief = \"10 µm\", relief_from = \"{from}\" }}\ngear = {{ teeth = 40 }}\n"
        );
        let path = put(folder.path(), "pair.toml", &text);
        let found = document(&["gear", path.to_str().unwrap(), "--torque", "50", "--json"]);
        number(&found["mesh"]["peak_to_peak_um"][0])
    };
    let by_angle = te("28 deg".into());
    let by_length = te(format!("{} mm", base * 28f64.to_radians()));
    within("peak to peak", (by_angle / by_length - 1.0).abs(), 1e-9);
}

/// Loads that no tooth bears, teeth that do not touch, an offset beyond the path and backlash below zero are refused or warned
/// of with a value that works when it is followed.
#[test]
fn law_values_of_refusals_work() {
    let folder = tempfile::tempdir().unwrap();
    let file = |text: &str| {
        put(folder.path(), "pair.toml", text)
            .to_str()
            .unwrap()
            .to_string()
    };
    let value = |all: &str, before: &str| -> f64 {
        let rest = &all[all.find(before).unwrap_or_else(|| panic!("{all}")) + before.len()..];
        let end = rest.find(|c: char| !(c.is_ascii_digit() || ".-e".contains(c)));
        rest[..end.unwrap_or(rest.len())]
            .parse()
            .unwrap_or_else(|_| panic!("{all}"))
    };
    let all = refused(&["gear", FZG, "--torque", "1e12"]);
    let torque = value(&all, "at most ");
    assert_eq!(
        said(&["gear", FZG, "--torque", &torque.to_string()]).0,
        Some(0)
    );
    let pair = "pair = { kind = \"cylindrical\", module = \"3 mm\" }\npinion = { teeth = 20 }\ngear = { teeth = 40 }\n";
    let path = file(&format!("{pair}assembly = {{ offset = \"20 mm\" }}\n"));
    let all = refused(&["gear", &path]);
    assert!(all.contains("do not touch"), "{all}");
    let offset = value(&all, "at most ");
    let path = file(&format!(
        "{pair}assembly = {{ offset = \"{offset} mm\" }}\n"
    ));
    assert_eq!(said(&["gear", &path]).0, Some(0));
    let tight = pair.replace(
        "module = \"3 mm\"",
        "module = \"3 mm\", centre_distance = \"89.7 mm\"",
    );
    let found = document(&["gear", &file(&tight), "--json"]);
    let hints = found["warnings"].to_string();
    assert!(hints.contains("no-backlash"), "{hints}");
    let distance = value(&hints, "centre_distance = \\\"");
    let loose = tight.replace("89.7 mm", &format!("{distance} mm"));
    let found = document(&["gear", &file(&loose), "--json"]);
    assert!(
        !found["warnings"].to_string().contains("no-backlash"),
        "{}",
        found["warnings"]
    );
    // The shaper of fewest changes cuts the ring.
    let ring = "pair = { kind = \"cylindrical\", module = \"2 mm\" }\npinion = { teeth = 20 }\ngear = { teeth = 60, internal = true, shaper_teeth = 3 }\n";
    let all = refused(&["gear", &file(ring)]);
    let teeth = value(&all[all.find("hint").unwrap()..], "shaper_teeth = ");
    let cut = ring.replace("shaper_teeth = 3", &format!("shaper_teeth = {teeth}"));
    assert_eq!(said(&["gear", &file(&cut)]).0, Some(0));
}

/// B and D, between which pairs touch alone, are points of contact ratios from 1 to 2; what the file leaves out is named.
#[test]
fn law_points_and_defaults_of_the_answer() {
    let folder = tempfile::tempdir().unwrap();
    let letters = |addendum: f64| {
        let text = format!(
            "pair = {{ kind = \"cylindrical\", module = \"2 mm\" }}\nrack = {{ addendum = {addendum}, dedendum = 1.7, tip_radius = 0.2 }}\npinion = {{ teeth = 60 }}\ngear = {{ teeth = 60 }}\n"
        );
        let path = put(folder.path(), "pair.toml", &text);
        let found = document(&["gear", path.to_str().unwrap(), "--torque", "50", "--json"]);
        let path = found["path"].as_array().unwrap();
        let letters: String = path.iter().map(|p| p["point"].as_str().unwrap()).collect();
        (letters, found["plan"].to_string() + &found.to_string())
    };
    let (all, text) = letters(1.0);
    assert_eq!(all, "ABCDE");
    for default in [
        "mesh.positions: 60",
        "mesh.slices: 11",
        "mesh.method: energy",
        "mesh.body: half-plane",
        "protuberance 0",
    ] {
        assert!(text.contains(default), "{default} in {text}");
    }
    assert!(text.contains("base tangent"), "{text}");
    assert_eq!(letters(0.4).0, "ACE");
    assert_eq!(letters(1.4).0, "ACE");
}

/// A pair with its keys on lines of their own.
fn on_lines(pair: &str, pinion: &str, gear: &str, rest: &str) -> String {
    format!(
        "pair = {{ kind = \"cylindrical\", module = \"3 mm\"{pair} }}\n{rest}\n[pinion]\nteeth = 20\n{pinion}\n[gear]\nteeth = 40\n{gear}\n"
    )
}

/// What the geometry or the load refuses is refused at the line of its key, with a remedy.
#[test]
fn refuses_values_at_their_keys() {
    let folder = tempfile::tempdir().unwrap();
    let ring = "body = \"ring\"";
    let wide = ", helix_angle = \"30 deg\"";
    let width = "face_width = \"100 m\"";
    let cases = [
        ("", "tip_diameter = \"40 mm\"", "", "", "tip_diameter"),
        (
            "",
            "tip_relief = \"5 mm\"\nrelief_from = \"14 mm\"",
            "",
            "",
            "tip_relief",
        ),
        (
            "",
            "tip_relief = \"5 µm\"\nrelief_from = \"40 mm\"",
            "",
            "",
            "relief_from",
        ),
        (
            "",
            "tip_relief = \"9 µm\"\nrelief_from = \"8 mm\"\nroot_relief = \"9 µm\"\nroot_relief_from = \"12 mm\"",
            "",
            "",
            "root_relief_from",
        ),
        ("", "crowning = \"3 mm\"", "", "", "crowning"),
        ("", "ball_diameter = \"50 mm\"", "", "", "ball_diameter"),
        ("", "ball_diameter = \"0.1 mm\"", "", "", "ball_diameter"),
        (
            "",
            "thickness = [\"-9 mm\", \"-8 mm\"]",
            "",
            "",
            "thickness",
        ),
        (
            "",
            "",
            "internal = true\nshaper_teeth = 200",
            "",
            "shaper_teeth",
        ),
        ("", "", "", "[mesh]\ntorque = \"1e9 N·m\"", "torque"),
        ("", "", "", "[rack]\ntip_radius = 2.0", "tip_radius"),
        (
            "",
            "",
            "",
            "[assembly]\nshaft_angle_error = \"1 rad\"",
            "shaft_angle_error",
        ),
        (
            wide,
            width,
            width,
            "[mesh]\ntorque = \"200 N·m\"",
            "face_width",
        ),
        (
            "",
            "bore_diameter = \"70 mm\"",
            "bore_diameter = \"70 mm\"",
            &format!("[mesh]\ntorque = \"9 N·m\"\n{ring}"),
            "bore_diameter",
        ),
    ];
    for (pair, pinion, gear, rest, key) in cases {
        let text = on_lines(pair, pinion, gear, rest);
        let path = put(folder.path(), "pair.toml", &text);
        let all = refused(&["gear", path.to_str().unwrap()]);
        let line = 1 + text.lines().position(|line| line.starts_with(key)).unwrap();
        assert!(all.contains(&format!("pair.toml:{line}:")), "{key}: {all}");
        assert!(all.contains("hint:"), "{key}: {all}");
    }
    let path = put(folder.path(), "pair.toml", "pair = {");
    let all = refused(&["gear", path.to_str().unwrap()]);
    assert!(
        all.contains("[syntax]") && !all.contains("no `pair`"),
        "{all}"
    );
}

/// Remedies of heights and distances work at the first attempt.
#[test]
fn law_remedies_of_racks_and_distances() {
    let folder = tempfile::tempdir().unwrap();
    let run = |text: &str| {
        let path = put(folder.path(), "pair.toml", text);
        said(&["gear", path.to_str().unwrap()])
    };
    let rack = |pair: &str, rack: &str| on_lines(pair, "", "", rack);
    let steep = ", pressure_angle = \"35 deg\"";
    for (pair, given) in [
        ("", "rack = { addendum = 1.0, dedendum = 0.0 }"),
        (steep, "rack = { tip_radius = 0.38 }"),
        ("", "rack = { addendum = 3.0, dedendum = 3.25 }"),
    ] {
        let (code, text, notes) = run(&rack(pair, given));
        assert_eq!(code, Some(2), "{given}: {text}{notes}");
        let from = notes
            .find("give rack = {")
            .unwrap_or_else(|| panic!("{notes}"))
            + 5;
        let end = from + notes[from..].find('}').unwrap() + 1;
        let (code, _, after) = run(&rack(pair, &notes[from..end]));
        assert_eq!(code, Some(0), "{}: {after}", &notes[from..end]);
    }
    let (_, _, notes) = run(&rack(", centre_distance = \"84 mm\"", ""));
    assert!(
        notes.contains("without backlash it is 90.0000 mm"),
        "{notes}"
    );
}

/// What a helical face wider than slices resolve costs is bounded; the stiffness by ISO 6336-1 names loads below its range.
#[test]
fn law_answers_name_their_range() {
    let folder = tempfile::tempdir().unwrap();
    let text = on_lines(
        "",
        "face_width = \"30 mm\"",
        "face_width = \"30 mm\"",
        "[mesh]\ntorque = \"20 N·m\"",
    );
    let path = put(folder.path(), "pair.toml", &text);
    let found = document(&["gear", path.to_str().unwrap(), "--json"]);
    let rows = found["stiffness"].as_array().unwrap();
    let iso = rows.iter().find(|row| row["method"] == "iso-6336").unwrap();
    assert!(
        iso["outside_range"].to_string().contains("below 100 N/mm"),
        "{iso}"
    );
    let geometry = &found["geometry"];
    for key in [
        "tip_pressure_angle_deg",
        "root_form_pressure_angle_deg",
        "mean_normal_tooth_thickness_mm",
    ] {
        assert!(geometry[key][0].is_number(), "{key}");
    }
    assert!(found["backlash"]["mean"]["normal_um"].is_number());
}
