//! `geardyn gear correct` as it is called.

use std::fmt::Write;

use serde_json::Value;

use crate::support::command::{document, geardyn, put, refusal, said};
use crate::support::verification::within;
use crate::support::{number, numbers};

const NASA: &str = "models/gears/bevel_12_36.toml";
const GRID: &str = "data/bevel_12_36_grid.csv";

fn correct(grid: &str, more: &[&str]) -> Value {
    let command = ["gear", "correct", NASA, "--measured", grid, "--json"];
    document(&[&command[..], more].concat())
}

/// Change of a setting, in the unit of the document.
fn change(found: &Value, key: &str) -> f64 {
    let settings = found["correct"]["settings"].as_array().unwrap();
    let setting = settings.iter().find(|s| s["setting"] == key);
    number(&setting.unwrap_or_else(|| panic!("{key}"))["change"])
}

/// A grid cut with three wrong settings, read with errors of 0.2 µm: the settings come back within what these errors allow, and 0.2 µm are left.
/// Source: envelope by differences and SciPy's fsolve, tools/measured_bevel_grid.py, which states the settings.
#[test]
fn ref_scipy_grid_of_wrong_settings() {
    let found = correct(
        GRID,
        &[
            "--settings",
            "radial_distance,machine_root_angle,cradle_over_work",
            "--length-step",
            "1e-6 mm",
            "--angle-step",
            "1e-6 deg",
            "--ratio-step",
            "1e-9",
        ],
    );
    let differs = |key: &str, expected: f64| (change(&found, key) - expected).abs();
    within(
        "radial distance, mm",
        differs("radial_distance", -0.06),
        2e-2,
    );
    within(
        "root angle, arcmin",
        60.0 * differs("machine_root_angle", 4.0 / 60.0),
        1.0,
    );
    within("cradle over work", differs("cradle_over_work", -3e-4), 1e-4);
    let flank = &found["correct"]["flanks"][0];
    assert_eq!(flank["nodes"], 45);
    assert!(number(&flank["rms_before_um"]) > 5.0);
    assert!((0.1..0.25).contains(&number(&flank["rms_after_um"])));
}

/// By default all settings of the machine are free: the flank does not show them apart, and the readings' errors are all that is left.
#[test]
fn law_default_settings_correct_the_flank() {
    let found = correct(GRID, &[]);
    let of = &found["correct"];
    let directions = of["directions"].as_array().unwrap();
    let used = directions.iter().filter(|d| d["used"] == true).count();
    assert!((3..7).contains(&used), "{used}");
    assert!(number(&of["flanks"][0]["rms_after_um"]) < 0.5);
    let shapes = of["not_corrected"].as_array().unwrap();
    let left = |name: &str| {
        let shape = shapes.iter().find(|s| s["shape"] == name).unwrap();
        number(&shape["share_left"])
    };
    assert!(left("slope along the face") < 0.05);
    assert!(left("three waves along the face") > 0.9);
    let (_, text, _) = said(&["gear", "correct", NASA, "--measured", GRID]);
    assert!(text.contains("settings of the next cut") && text.contains("not corrected"));
}

/// Deviations, measured points, measured points with normals into the metal, and decimal commas are one grid.
#[test]
fn law_forms_of_a_grid_agree() {
    let folder = tempfile::tempdir().unwrap();
    let flanks = folder.path().join("flanks.csv");
    let done = geardyn(&["gear", NASA, "--flank", flanks.to_str().unwrap(), "--quiet"]);
    assert!(done.status.success());
    let mut deviations = String::from("x [mm],y [mm],z [mm],deviation [µm]\n");
    let head = "x [mm],y [mm],z [mm],n_x,n_y,n_z,x_measured [mm],y_measured [mm],z_measured [mm]\n";
    let mut points = [head.to_string(), head.to_string()];
    for row in std::fs::read_to_string(&flanks).unwrap().lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        if cells[..2] != ["pinion", "concave"] || cells[10] != "no" || cells[2] == "1" {
            continue;
        }
        let x: Vec<f64> = cells[4..10].iter().map(|c| c.parse().unwrap()).collect();
        let deviation = 3.0 * (x[2] - 70.0) + 0.2 * (x[0].hypot(x[1]) - 25.0);
        writeln!(deviations, "{},{},{},{deviation}", x[0], x[1], x[2]).unwrap();
        for (text, sign) in points.iter_mut().zip([1.0, -1.0]) {
            let n = [3, 4, 5].map(|k| sign * x[k]);
            let at = [0, 1, 2].map(|k| x[k] + 1e-3 * deviation * x[k + 3]);
            let numbers = [&x[..3], &n, &at]
                .concat()
                .iter()
                .map(f64::to_string)
                .collect::<Vec<_>>();
            writeln!(text, "{}", numbers.join(",")).unwrap();
        }
    }
    let answer = |name: &str, text: &str| {
        let path = put(folder.path(), name, text);
        let found = correct(path.to_str().unwrap(), &["--flank", "concave"]);
        ["radial_distance", "machine_root_angle", "cradle_over_work"].map(|key| change(&found, key))
    };
    let expected = answer("a.csv", &deviations);
    let [outward, inward] = points;
    let semicolons = deviations.replace(',', ";").replace('.', ",");
    for (name, text) in [("b.csv", outward), ("c.csv", inward), ("d.csv", semicolons)] {
        let found = answer(name, &text);
        for (a, b) in expected.iter().zip(&found) {
            assert!((a - b).abs() <= 1e-9 * a.abs(), "{expected:?} {found:?}");
        }
    }
}

/// Grids that do not belong to the flank, settings that do not exist.
#[test]
fn refuses_grids_of_another_flank() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, text: &str, more: &[&str]| {
        let path = put(folder.path(), name, text);
        let command = [
            "gear",
            "correct",
            NASA,
            "--measured",
            path.to_str().unwrap(),
        ];
        let (code, _, text) = said(&[&command[..], more].concat());
        assert!(matches!(code, Some(2 | 3)), "{text}");
        text
    };
    let bare = "z [mm],radius [mm],deviation [µm]\n66.28,22.12,1\n";
    assert!(refused("bare.csv", bare, &[]).contains("the grid does not name them"));
    let far = "z [mm],radius [mm],deviation [µm]\n16.28,22.12,1\n26.28,22.12,1\n";
    let text = refused("far.csv", far, &["--flank", "concave"]);
    assert!(
        text.contains("are not on the concave flank of the pinion") && text.contains("far.csv:2"),
        "{text}"
    );
    let few = "z [mm],radius [mm],deviation [µm]\n66.2828,22.1213,15.2\n65.9842,23.1061,16.4\n";
    assert!(refused("few.csv", few, &["--flank", "concave"]).contains("free fewer settings"));
    let text = refused("few.csv", few, &["--settings", "radial_distanc"]);
    assert!(text.contains("did you mean \"radial_distance\""), "{text}");
    let straight = ["--flank", "concave", "--settings", "profile_radius"];
    let text = refused("few.csv", few, &straight);
    assert!(text.contains("a straight blade, which has no"), "{text}");
    let side = "flank,z [mm],radius [mm],deviation [µm]\nleft,66.28,22.12,1\n";
    assert!(refused("side.csv", side, &[]).contains("write concave or convex"));
    let units = "flank,z,radius [mm],deviation [µm]\nconcave,66.28,22.12,1\n";
    assert!(refused("units.csv", units, &[]).contains("units.csv:1"));
    let empty = "z [mm],radius [mm],deviation [µm]\n";
    assert!(refused("empty.csv", empty, &[]).contains("no row"));
    let (_, helical) = refusal(&[
        "gear",
        "correct",
        "models/gears/helical.toml",
        "--measured",
        GRID,
    ]);
    assert!(
        helical.contains("only settings of bevel gears"),
        "{helical}"
    );
}

/// A wanted ease-off: the settings found leave a rest that is small against it, and the transmission error follows.
#[test]
fn law_target_changes_the_contact() {
    let target = "data/bevel_12_36_target.toml";
    let settings =
        "blade_angle,point_radius,radial_distance,blank_offset,machine_root_angle,cradle_over_work";
    let command = [
        "gear",
        "correct",
        NASA,
        "--target",
        target,
        "--settings",
        settings,
    ];
    let found = document(&[&command[..], &["--json"]].concat());
    let of = &found["correct"];
    let flank = &of["flanks"][0];
    let [before, after] = ["rms_before_um", "rms_after_um"].map(|key| number(&flank[key]));
    assert!(before > 5.0 && after < 0.3 * before, "{before} {after}");
    let contact = |when: &str, key: &str| of["contact"][when][key].clone();
    assert!(contact("now", "peak_to_peak_arcsec").is_number());
    let place = numbers(&contact("next", "face_height_pinion"));
    assert!(
        (place[0] - 0.5).abs() < 0.1 && (place[1] - 0.5).abs() < 0.25,
        "{place:?}"
    );
    let (_, text, _) = said(&command);
    assert!(text.contains("unloaded contact"));
    let (_, gear) = refusal(&[&command[..], &["--member", "gear"]].concat());
    assert!(gear.contains("the gear is not changed"), "{gear}");
}

/// Dials in steps of 0.05 mm make up for each other's rounding: of 0.2 µm that all settings together leave, less than three times as much; each by itself
/// rounded they leave micrometres.
#[test]
fn law_coarse_dials_are_set_together() {
    let [fine, coarse] = ["0.0001 mm", "0.05 mm"].map(|step| {
        let found = correct(GRID, &["--length-step", step]);
        for row in found["correct"]["settings"].as_array().unwrap() {
            let steps = number(&row["change"]) / number(&row["step"]);
            assert!((steps - steps.round()).abs() < 1e-6, "{row}");
        }
        let flank = &found["correct"]["flanks"][0];
        (number(&flank["rms_after_um"]), numbers(&flank["deeper_um"]))
    });
    assert!(
        fine.0 < 0.25 && coarse.0 < 3.0 * fine.0,
        "{fine:?} {coarse:?}"
    );
    for (a, b) in fine.1.iter().zip(&coarse.1) {
        assert!((a - b).abs() < 30.0, "{fine:?} {coarse:?}");
    }
}

/// The slot keeps its depth where an ease-off is wanted that the settings can give; one that they cannot give says how the slot changes.
#[test]
fn law_target_keeps_the_slot() {
    let folder = tempfile::tempdir().unwrap();
    let found = |crowning: &str| {
        let text = format!(
            "[ease_off]\nlengthwise_crowning = \"{crowning}\"\nprofile_crowning = \"12 µm\"\n"
        );
        let target = put(folder.path(), "target.toml", &text);
        document(&[
            "gear",
            "correct",
            NASA,
            "--target",
            target.to_str().unwrap(),
            "--json",
        ])
    };
    let of = found("60 µm");
    let flank = &of["correct"]["flanks"][0];
    for depth in numbers(&flank["deeper_um"]) {
        assert!(depth.abs() < 40.0, "{}", flank["deeper_um"]);
    }
    // What these settings cannot give is named.
    let warns = |found: &Value, code: &str| {
        let warnings = found["warnings"].as_array().unwrap();
        warnings.iter().any(|w| w["code"] == code)
    };
    let far = found("-60 µm");
    assert!(!warns(&of, "slot-depth") && warns(&far, "slot-depth"));
}

/// What a grid or a target does not say is not guessed.
#[test]
fn refuses_what_a_grid_does_not_say() {
    let folder = tempfile::tempdir().unwrap();
    let read = std::fs::read_to_string(GRID).unwrap();
    let run = |name: &str, text: &str, flag: &str| {
        let path = put(folder.path(), name, text);
        let (code, out, error) = said(&["gear", "correct", NASA, flag, path.to_str().unwrap()]);
        (code, format!("{out}{error}"))
    };
    let (code, text) = run(
        "mm.csv",
        &read.replace("deviation [µm]", "deviation [mm]"),
        "--measured",
    );
    assert!(
        code == Some(2) && text.contains("mm.csv:3") && text.contains("check the unit"),
        "{text}"
    );
    let wrong = read.replace("66.2828,22.1213,15.2", "66.2828,22.1213,515.2");
    let (code, text) = run("dirt.csv", &wrong, "--measured");
    assert!(
        code == Some(0) && text.contains("line 3: a deviation of 515.2 µm"),
        "{text}"
    );
    let (code, text) = run("none.toml", "[ease_off]\n", "--target");
    assert!(
        code == Some(2) && text.contains("none.toml:1") && text.contains("te_parabola"),
        "{text}"
    );
}

/// Deviations of the other sign ask for a radial distance beyond the eccentric's: a refusal, no search without end.
#[test]
fn refuses_a_radial_distance_beyond_the_eccentric() {
    let folder = tempfile::tempdir().unwrap();
    let read = std::fs::read_to_string(NASA).unwrap();
    let eccentric = "eccentric_angle = \"179.6 deg\", machine_constant = \"37.4373139 mm\"";
    let text = read.replace("radial_distance = \"2.94780202969 in\"", eccentric);
    assert_ne!(text, read);
    let file = put(folder.path(), "pair.toml", &text);
    let grid = std::fs::read_to_string(GRID).unwrap();
    let reversed = |line: &str| match line.rsplit_once(',') {
        Some((place, deviation)) if line.starts_with("concave") => {
            format!("{place},-{deviation}\n")
        }
        _ => format!("{line}\n"),
    };
    let grid: String = grid.lines().map(reversed).collect();
    let grid = put(folder.path(), "grid.csv", &grid.replace("--", ""));
    let command = [
        "gear",
        "correct",
        file.to_str().unwrap(),
        "--measured",
        grid.to_str().unwrap(),
    ];
    let (code, _, error) = said(&command);
    assert!(
        code == Some(2) && error.contains("twice the machine constant"),
        "{error}"
    );
}
