//! `geardyn measure` as it is called.

use crate::support::command;
use std::path::Path;

use serde_json::Value;

use crate::support::command::{document, geardyn};

/// A file in a folder of its own.
fn put(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

const GEAR: &str = "[measured_gear]\nteeth = 18\nmodule = \"3 mm\"\nface_width = \"20 mm\"\n";

const READINGS: [i32; 18] = [3, -2, 1, 0, -4, 2, 5, -1, -3, 2, 0, 1, -2, 4, -1, -3, 0, -2];

fn readings() -> String {
    let rows: Vec<String> = READINGS
        .iter()
        .enumerate()
        .map(|(i, r)| format!("{},{r}", i + 1))
        .collect();
    format!("tooth,left [µm]\n{}\n", rows.join("\n"))
}

fn chart(more: &str) -> String {
    format!(
        "[[chart]]\nkind = \"pitch\"\nmethod = \"comparator\"\nfile = \"p.csv\"\nleft = \"left\"\n{more}"
    )
}

/// The measured deviation of a name.
fn of<'d>(found: &'d Value, name: &str, side: &str) -> &'d Value {
    let is = |d: &&Value| d["name"] == name && d["side"] == side && d["predicted"] == false;
    let list = found["deviations"].as_array().unwrap();
    list.iter()
        .find(is)
        .unwrap_or_else(|| panic!("{name}: {found}"))
}

fn micro(found: &Value, name: &str, side: &str) -> f64 {
    of(found, name, side)["value_um"].as_f64().unwrap()
}

/// Eighteen readings whose answers are known, through file, table and every format; the limit is kept at one grade, missed at a finer.
/// Source: worked example of 18 pitch readings.
#[test]
fn ref_pitch_readings_through_the_command() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "p.csv", &readings());
    let asked = |grade: u32| {
        let text = format!(
            "title = \"t\"\n{GEAR}standard = \"ISO 1328-1:2013\"\naccuracy = {grade}\n{}",
            chart("uncertainty = \"0.1 µm\"\n")
        );
        put(folder.path(), "gear.toml", &text)
    };
    // f_pT is 6.254 µm at grade 5, F_pT 18.2: f_p 5.0 reaches grade 5 (6.5 allowed), F_p 8.0 grade 3.
    let gear = asked(5);
    let output = geardyn(&["measure", &gear, "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (name, value, grade) in [
        ("fp", 5.0, 5),
        ("Fp", 8.0, 3),
        ("Fpk", 7.0, 4),
        ("fu", 6.0, 4),
    ] {
        let row = of(&found, name, "left");
        assert!(
            (row["value_um"].as_f64().unwrap() - value).abs() < 1e-9,
            "{row}"
        );
        assert_eq!(row["grade_2013"], grade, "{row}");
        assert_eq!(row["grade"], row["grade_2013"]);
        assert_eq!(row["limiting"], name == "fp");
    }
    assert_eq!(of(&found, "Fp", "left")["old_name"], "Δt_Σ");
    assert_eq!(of(&found, "fp", "left")["upper_limit_um"], 6.5);
    assert_eq!(
        (&found["within"], &found["required"]["meaning"]),
        (&Value::Bool(true), &Value::from("grade 5"))
    );
    let csv = folder.path().join("out.csv").to_str().unwrap().to_string();
    let output = geardyn(&["measure", &asked(4), "--csv", &csv]);
    assert_eq!(output.status.code(), Some(1), "out of grade 4");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("OUT of tolerance: f_p left"), "{text}");
    assert!(text.contains("determines the grade"), "{text}");
    let rows = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(rows.lines().count(), 5, "{rows}");
    assert!(
        rows.lines()
            .nth(1)
            .unwrap()
            .starts_with("fp,,left,pitch 7,false,5"),
        "{rows}"
    );
}

/// The shipped gear: every true value inside twice the stated uncertainty and what noise adds to extremes; nothing out of grade 6.
#[test]
fn law_shipped_gear_tells_its_true_values() {
    let found = document(&["measure", "data/index_gear.toml", "--json"]);
    assert_eq!(found["within"], true);
    let truth =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("data/index_gear.toml"))
            .unwrap();
    let truth = |key: &str| -> f64 {
        let line = truth.lines().find(|line| line.starts_with(key)).unwrap();
        line.split('=').nth(1).unwrap().trim().parse().unwrap()
    };
    // Noise makes a range larger by about two of its own uncertainties where many readings compete for the extremes.
    for (name, side, key, allowed) in [
        ("fp", "left", "fp_left_um", 1.0),
        ("fp", "right", "fp_right_um", 1.0),
        ("Fp", "left", "Fp_left_um", 1.2),
        ("Fp", "right", "Fp_right_um", 1.2),
        ("Fis", "left", "Fis_um", 0.6),
        ("fis", "left", "fis_um", 0.6),
    ] {
        let value = micro(&found, name, side).abs();
        let true_value = truth(key);
        assert!(
            (value - true_value).abs() < allowed,
            "{name} {side}: {value}, truly {true_value}"
        );
    }
    let list = found["deviations"].as_array().unwrap();
    for row in list.iter().filter(|d| d["name"] == "fe") {
        let off = row["value_um"].as_f64().unwrap() - truth("eccentricity_um");
        let std = row["std_um"].as_f64().unwrap();
        // The difference of both sides' cut has an order 1 of its own, some tenths of a µm.
        assert!(off.abs() < 2.0 * std + 0.6, "{row}");
    }
    for row in list.iter().filter(|d| d["name"] == "Ca") {
        let off = row["value_um"].as_f64().unwrap() - truth("tip_relief_um");
        // The form wave is part of what stands beyond the line.
        assert!(off.abs() < 0.8, "{row}");
    }
    // Expected from pitch and four profiles a side, and the pitch told back by the record.
    let predicted = |name: &str| {
        let is = |d: &&Value| d["name"] == name && d["side"] == "left" && d["predicted"] == true;
        list.iter().find(is).unwrap()["value_um"].as_f64().unwrap()
    };
    assert!(
        (predicted("Fis") - truth("Fis_um")).abs() < 2.0,
        "{}",
        predicted("Fis")
    );
    assert!(
        (predicted("Fp") - truth("Fp_left_um")).abs() < 1.5,
        "{}",
        predicted("Fp")
    );
    let thickness: Vec<f64> = list
        .iter()
        .filter(|d| d["name"] == "Esn")
        .map(|d| d["value_um"].as_f64().unwrap())
        .collect();
    assert_eq!(thickness.len(), 2);
    assert!(
        thickness.iter().all(|t| (-96.0..-84.0).contains(t)),
        "{thickness:?}"
    );
}

/// The charts are drawn, unrolled and round; what is not there is not drawn.
#[test]
fn keeps_pictures_whole() {
    let folder = tempfile::tempdir().unwrap();
    let svg = folder.path().join("g.svg").to_str().unwrap().to_string();
    let output = geardyn(&["measure", "data/index_gear.toml", "--svg", &svg]);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = std::fs::read_to_string(&svg).unwrap();
    for said in [
        "pitch, left flanks",
        "profile, right flanks",
        "helix, left flanks",
        "expected from pitch",
        "double-flank",
    ] {
        assert!(text.contains(said), "{said}");
    }
    let polar = std::fs::read_to_string(folder.path().join("g-polar.svg")).unwrap();
    assert!(polar.contains("run-out by ball") && polar.contains("270°"));
    assert!(!text.contains("NaN") && !polar.contains("NaN"));
}

/// Grades of JB 179-60 with limits out of a table; without a table they are refused, never made up.
#[test]
fn exact_limits_out_of_a_table() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "p.csv", &readings());
    put(
        folder.path(),
        "limits.csv",
        "quantity,grade,module_from,module_to,diameter_from,diameter_to,limit\n# mm and µm\ndt_sum,8,1,10,50,80,9\ndt_sum,7,1,10,50,80,7\ndt,7,1,10,,,6\n",
    );
    let gear = |limits: &str| {
        let text = format!(
            "title = \"t\"\n{GEAR}standard = \"JB 179-60\"\naccuracy = \"8-7-7 Dc\"\n{limits}{}",
            chart("")
        );
        put(folder.path(), "gear.toml", &text)
    };
    let found = document(&["measure", &gear("limits = \"limits.csv\"\n"), "--json"]);
    let total = of(&found, "Fp", "left");
    assert_eq!(
        (total["upper_limit_um"].as_f64(), &total["grade"]),
        (Some(9.0), &Value::from(8))
    );
    assert_eq!(total["within"], true);
    let adjacent = of(&found, "fu", "left");
    assert_eq!(
        (adjacent["grade_requested"].as_u64(), &adjacent["within"]),
        (Some(7), &Value::Bool(true))
    );
    assert_eq!(of(&found, "fp", "left")["upper_limit_um"], Value::Null);
    assert!(
        found["required"]["meaning"]
            .as_str()
            .unwrap()
            .contains("normal backlash")
    );
    let output = geardyn(&["measure", &gear("")]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("table of limits") && said.contains("limits"),
        "{said}"
    );
}

/// What is wrong is said with the file, the line and what to do; nothing panics, the exit code is 2.
#[test]
fn refuses_bad_gears() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "p.csv", &readings());
    put(folder.path(), "short.csv", "left [µm]\n1\n2\n3\n");
    put(folder.path(), "bare.csv", "left\n1\n2\n3\n");
    put(
        folder.path(),
        "holes.csv",
        &readings().replace("5,-4\n", "5,NaN\n"),
    );
    put(folder.path(), "volts.csv", &readings().replace("µm", "V"));
    let pitch = |file: &str| chart("").replace("p.csv", file);
    let cases = [
        (
            format!("{GEAR}{}", pitch("short.csv")),
            "3 pitch readings for 18 teeth",
        ),
        (format!("{GEAR}{}", pitch("bare.csv")), "no unit"),
        (format!("{GEAR}{}", pitch("holes.csv")), "reading 5"),
        (format!("{GEAR}{}", pitch("volts.csv")), "V"),
        (format!("{GEAR}{}", pitch("none.csv")), "cannot be read"),
        (
            format!("{GEAR}{}", chart("").replace("= \"left\"", "= \"lft\"")),
            "did you mean",
        ),
        (format!("{GEAR}{}", chart("k = 18\n")), "`k` is 18"),
        (
            format!("{GEAR}{}", chart("method = \"guess\"\n")),
            "duplicate",
        ),
        (GEAR.to_string(), "nothing is measured"),
        (
            format!("{GEAR}accuracy = 6\n{}", chart("")),
            "has no `standard`",
        ),
        (
            format!(
                "{GEAR}accuracy = \"8-5-5\"\nstandard = \"JB 179-60\"\n{}",
                chart("")
            ),
            "smoothness",
        ),
        (format!("{}{}", GEAR.replace("18", "2"), chart("")), "teeth"),
        (
            format!("{}{}", GEAR.replace("3 mm", "-3 mm"), chart("")),
            "module",
        ),
        (
            format!("{GEAR}thickness = [\"-1 µm\", \"-2 µm\"]\n{}", chart("")),
            "falls",
        ),
        ("[measured_gear]\n".to_string(), "has no `teeth`"),
        (
            format!("{GEAR}[[chart]]\nkind = \"chord\"\nfile = \"p.csv\"\ncolumn = \"left\"\n"),
            "tip_diameter",
        ),
        (
            format!(
                "{GEAR}[[chart]]\nkind = \"single_flank\"\nfile = \"p.csv\"\nleft = \"left\"\n"
            ),
            "abscissa",
        ),
        (
            format!(
                "{GEAR}[[chart]]\nkind = \"double_flank\"\nfile = \"p.csv\"\ncolumn = \"left\"\n"
            ),
            "pitch",
        ),
        (
            format!(
                "{GEAR}[[chart]]\nkind = \"span\"\nteeth = 3\nfile = \"p.csv\"\ncolumn = \"left\"\n"
            ),
            "more than a module",
        ),
        (
            format!("{GEAR}[[chart]]\nkind = \"runout\"\nfile = \"p.csv\"\nleft = \"left\"\n"),
            "neither side",
        ),
        ("title = \"t\"\n".to_string(), "no [measured_gear]"),
        (format!("{GEAR}teeth = 3\n"), "duplicate"),
    ];
    for (text, said) in cases {
        let gear = put(folder.path(), "gear.toml", &text);
        let output = geardyn(&["measure", &gear]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}\n{told}");
        assert!(told.contains(said), "{said} not in: {told}");
        assert!(!told.contains("panicked"), "{told}");
        assert!(
            told.contains("gear.toml") || told.contains("none.csv"),
            "{told}"
        );
    }
    let output = geardyn(&["measure", "data/index_gear_pitch.csv"]);
    assert_eq!(output.status.code(), Some(2));
    let gear = put(folder.path(), "gear.toml", &format!("{GEAR}{}", chart("")));
    let over = folder.path().join("p.csv").to_str().unwrap().to_string();
    let output = geardyn(&["measure", &gear, "--csv", &over]);
    assert_eq!(
        output.status.code(),
        Some(2),
        "what is read is not overwritten"
    );
}

/// `check` understands the kind by its top key; errors come as JSON where JSON was asked for.
#[test]
fn keeps_check_and_json_errors() {
    let output = geardyn(&["check", "data/index_gear.toml"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("measured gear of 40 teeth, 7 charts"),
        "{text}"
    );
    let folder = tempfile::tempdir().unwrap();
    let gear = put(folder.path(), "gear.toml", "[measured_gear]\nteeth = 0\n");
    let output = geardyn(&["measure", &gear, "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found["errors"][0]["line"].is_number(), "{found}");
    assert_eq!(output.status.code(), Some(2));
}

/// A gear beyond the standard's sizes has values and no limits, and is told so.
#[test]
fn survives_sizes_outside_the_standard() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "p.csv", &readings());
    let small = GEAR.replace("3 mm", "0.1 mm");
    let text = format!(
        "title = \"t\"\n{small}standard = \"ISO 1328-1:2013\"\naccuracy = 6\n{}",
        chart("")
    );
    let gear = put(folder.path(), "gear.toml", &text);
    let found = document(&["measure", &gear, "--json"]);
    assert_eq!(found["within"], Value::Null);
    assert_eq!(of(&found, "fp", "left")["grade"], Value::Null);
    assert_eq!(found["warnings"][0]["code"], "outside-standard");
}

/// Commands of machines say which command a measured gear belongs to.
#[test]
fn refuses_to_take_a_gear_for_a_machine() {
    let output = geardyn(&["modes", "data/index_gear.toml"]);
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        told.contains("geardyn measure data/index_gear.toml"),
        "{told}"
    );
}

/// The examples of its help run, and end it.
#[test]
fn law_examples_of_help_run() {
    let help = String::from_utf8(geardyn(&["measure", "--help"]).stdout).unwrap();
    let examples: Vec<&str> = help
        .lines()
        .rev()
        .map_while(|line| line.strip_prefix("  geardyn "))
        .filter(|line| !line.contains("--svg"))
        .collect();
    assert_eq!(examples.len(), 2, "{help}");
    for example in examples {
        let output = geardyn(&example.split_whitespace().collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(0), "{example}");
    }
}

/// Every way to tooth thickness tells the same thinning; columns of angles become lengths on the reference circle.
#[test]
fn law_every_gauge_and_angles() {
    use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
    let gear = InvoluteGear {
        teeth: 18,
        module: 3e-3,
        pressure_angle: 20f64.to_radians(),
        helix: 0.0,
        profile_shift: 0.1,
        internal: false,
    };
    let (tip, thin) = (61e-3, -80e-6);
    let s = gear.nominal_thickness() + thin;
    let folder = tempfile::tempdir().unwrap();
    let sizes = [
        gear.span(3, s),
        gear.dimension_over_balls(5.5e-3, s),
        gear.chordal_thickness(tip, s).0,
        gear.constant_chord(tip, s).0,
    ];
    let cells: Vec<String> = sizes.iter().map(|x| format!("{:.9}", 1e3 * x)).collect();
    put(
        folder.path(),
        "sizes.csv",
        &format!("w [mm],m [mm],c [mm],cc [mm]\n{0}\n{0}\n", cells.join(",")),
    );
    let arc = 206_264.806_247 / (0.5 * 54e3);
    let angles: Vec<String> = READINGS
        .iter()
        .map(|r| format!("{:.9}", f64::from(*r) * arc))
        .collect();
    put(
        folder.path(),
        "angles.csv",
        &format!("right [arcsec]\n{}\n", angles.join("\n")),
    );
    put(folder.path(), "base.csv", "left [µm]\n3\n-7\n2\n");
    let chart = |kind: &str, more: &str, column: &str| {
        format!("[[chart]]\nkind = \"{kind}\"\nfile = \"sizes.csv\"\ncolumn = \"{column}\"\n{more}")
    };
    let text = format!(
        "{GEAR}profile_shift = 0.1\ntip_diameter = \"61 mm\"\nthickness = [\"-100 µm\", \"-60 µm\"]\n{}{}{}{}{}{}",
        chart("span", "", "w"),
        chart("balls", "diameter = \"5.5 mm\"\n", "m"),
        chart("chord", "", "c"),
        chart("constant_chord", "", "cc"),
        "[[chart]]\nkind = \"pitch\"\nmethod = \"comparator\"\nfile = \"angles.csv\"\nright = \"right\"\n",
        "[[chart]]\nkind = \"base_pitch\"\nfile = \"base.csv\"\nleft = \"left\"\n",
    );
    let found = document(&["measure", &put(folder.path(), "gear.toml", &text), "--json"]);
    let list = found["deviations"].as_array().unwrap();
    let told: Vec<f64> = list
        .iter()
        .filter(|d| d["name"] == "Esn")
        .map(|d| d["value_um"].as_f64().unwrap())
        .collect();
    assert_eq!(told.len(), 8);
    // A chord is set at the nominal height: right to the second order.
    assert!(told.iter().all(|t| (t + 80.0).abs() < 0.05), "{told:?}");
    assert_eq!(found["within"], true);
    assert!((micro(&found, "Fp", "right") - 8.0).abs() < 1e-6);
    assert!((micro(&found, "fpb", "left") + 7.0).abs() < 1e-9);
}

/// Mistakes in a table of limits are told by line.
#[test]
fn refuses_bad_tables_of_limits() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "p.csv", &readings());
    let head = "quantity,grade,module_from,module_to,diameter_from,diameter_to,limit\n";
    let text = format!(
        "{GEAR}standard = \"JB 179-60\"\naccuracy = 7\nlimits = \"limits.csv\"\n{}",
        chart("")
    );
    let gear = put(folder.path(), "gear.toml", &text);
    for (table, said) in [
        ("", "no column `quantity`"),
        (head, "has no rows"),
        (&format!("{head}dt_sun,7,1,10,50,80,9\n"), "dt_sum"),
        (
            &format!("{head}dt_sum,seven,1,10,50,80,9\n"),
            "whole number",
        ),
        (&format!("{head}dt_sum,7,10,1,50,80,9\n"), "not below"),
        (&format!("{head}dt_sum,7,1,10,50,80,-9\n"), "above zero"),
        (&format!("{head}dt_sum,7,1,10,50,80,9 µm\n"), "not a number"),
        (&format!("{head}dt_sum,7,1,NaN,50,80,9\n"), "not a number"),
    ] {
        put(folder.path(), "limits.csv", table);
        let output = geardyn(&["measure", &gear]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{table}\n{told}");
        assert!(
            told.contains(said) && told.contains("limits.csv"),
            "{said} not in: {told}"
        );
    }
}

/// Gears at the edge of sense: answered or refused, never a panic and never a value that is no number.
#[test]
fn survives_extreme_gears() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "p.csv", &readings());
    put(
        folder.path(),
        "zero.csv",
        &format!("left [µm]\n{}", "0\n".repeat(18)),
    );
    put(
        folder.path(),
        "huge.csv",
        &format!("left [µm]\n{}", "1e300\n-1e300\n".repeat(9)),
    );
    for (file, from, to) in [
        ("p.csv", "3 mm", "1e-200 m"),
        ("p.csv", "3 mm", "1e200 m"),
        ("zero.csv", "3 mm", "3 mm"),
        ("huge.csv", "3 mm", "3 mm"),
        ("p.csv", "20 mm", "1e9 km"),
    ] {
        let text = format!(
            "{}standard = \"ISO 1328-1:1995\"\naccuracy = 6\n{}",
            GEAR.replace(from, to),
            chart("uncertainty = \"1 µm\"\n").replace("p.csv", file)
        );
        let gear = put(folder.path(), "gear.toml", &text);
        let svg = folder.path().join("g.svg").to_str().unwrap().to_string();
        let output = geardyn(&["measure", &gear, "--svg", &svg]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            matches!(output.status.code(), Some(0..=2)),
            "{text}\n{told}"
        );
        assert!(!told.contains("panicked"), "{told}");
        let table = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(!table.contains("NaN"), "{table}");
    }
}

/// An internal gear from its file: spans over spaces and between balls tell the same thinning, the profile's slope and relief count toward
/// the tip, run-out from both sides' pitch is what its excentric ring was made with.
#[test]
fn exact_internal_gear() {
    use geardyn::internals::gear::cylindrical::involute::InvoluteGear;
    let gear = InvoluteGear {
        teeth: 60,
        module: 3e-3,
        pressure_angle: 20f64.to_radians(),
        helix: 0.0,
        profile_shift: 0.1,
        internal: true,
    };
    let s = gear.nominal_thickness() - 60e-6;
    let k = gear.default_span_teeth();
    let folder = tempfile::tempdir().unwrap();
    let sizes = format!(
        "w [mm],m [mm]\n{0:.9},{1:.9}\n{0:.9},{1:.9}\n",
        1e3 * gear.span(k, s),
        1e3 * gear.dimension_over_balls(5e-3, s)
    );
    put(folder.path(), "sizes.csv", &sizes);
    // The ring sits 5 µm off: on both sides' places 5 µm · sin(φ ∓ α)/cos α, spaces shift and widen.
    let (alpha, e) = (gear.transverse_pressure_angle(), 5.0);
    let mut pitch = String::from("left [µm],right [µm]\n");
    for i in 0..60 {
        let phi = std::f64::consts::TAU * f64::from(i) / 60.0;
        // outward where φ is 0; a wider space lets the ball go outward: S = right − left = 2 e tan α cos φ
        let half = e * alpha.tan() * phi.cos();
        pitch += &format!("{:.9},{:.9}\n", -half, half);
    }
    put(folder.path(), "pitch.csv", &pitch);
    // Roll from the tip on: 6 µm of relief over the first 2 mm, material rising by 0.5 µm a millimetre of roll, so falling to the tip.
    let from = 1e3 * gear.roll_length(gear.reference_diameter() - 2.0 * 2.7e-3);
    let mut profile = String::from("roll [mm],right [µm]\n");
    for i in 0..=160 {
        let x = 0.1 * f64::from(i);
        let relief = 3.0 * (2.0 - x).max(0.0);
        profile += &format!("{:.9},{:.9}\n", from + x, 0.5 * x - relief);
    }
    put(folder.path(), "profile.csv", &profile);
    let text = format!(
        "title = \"ring\"\n[measured_gear]\nteeth = 60\nmodule = \"3 mm\"\ninternal = true\nprofile_shift = 0.1\n\
         [[chart]]\nkind = \"span\"\nfile = \"sizes.csv\"\ncolumn = \"w\"\n\
         [[chart]]\nkind = \"balls\"\nfile = \"sizes.csv\"\ncolumn = \"m\"\ndiameter = \"5 mm\"\n\
         [[chart]]\nkind = \"pitch\"\nmethod = \"index\"\nfile = \"pitch.csv\"\nleft = \"left\"\nright = \"right\"\n\
         [[chart]]\nkind = \"profile\"\nfile = \"profile.csv\"\nalong = \"roll\"\nright = \"right\"\n\
         evaluation = [\"{:.9} mm\", \"{:.9} mm\"]\nrelief_from = \"{:.9} mm\"\nactive = [\"{:.9} mm\", \"{:.9} mm\"]\n",
        from + 2.0,
        from + 16.0,
        from + 2.0,
        from,
        from + 16.0
    );
    let file = put(folder.path(), "ring.toml", &text);
    let found = document(&["measure", &file, "--json"]);
    let value = |name: &str| {
        let list = found["deviations"].as_array().unwrap();
        let row = list
            .iter()
            .find(|d| d["name"] == name && d["predicted"] == false);
        row.unwrap_or_else(|| panic!("{name}"))["value_um"]
            .as_f64()
            .unwrap()
    };
    for row in found["deviations"].as_array().unwrap() {
        if row["name"] == "Esn" {
            assert!(
                (row["value_um"].as_f64().unwrap() + 60.0).abs() < 1e-3,
                "{row}"
            );
            let how = row["location"].as_str().unwrap();
            assert!(
                how.contains("spaces") || how.contains("between balls"),
                "{how}"
            );
        }
    }
    assert!((value("fe") - 5.0).abs() < 1e-6, "{}", value("fe"));
    assert!((value("Ca") - 6.0).abs() < 1e-6);
    assert!((value("fHa") + 8.0).abs() < 1e-6, "{}", value("fHa"));
}

/// Readings longer than any gear are refused with their place.
#[test]
fn refuses_readings_beyond_any_gear() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..18)
        .map(|i| format!("{}e308\n", if i % 2 == 0 { 1 } else { -1 }))
        .collect();
    put(folder.path(), "p.csv", &format!("left [m]\n{rows}"));
    for kind in [
        "kind = \"pitch\"\nmethod = \"index\"\nleft = \"left\"",
        "kind = \"runout\"\ncolumn = \"left\"",
        "kind = \"base_pitch\"\nleft = \"left\"",
    ] {
        let text = format!(
            "title = \"g\"\n[measured_gear]\nteeth = 18\nmodule = \"3 mm\"\n[[chart]]\nfile = \"p.csv\"\n{kind}\n"
        );
        let file = put(folder.path(), "g.toml", &text);
        let (code, message) = command::refusal(&["measure", &file]);
        assert_eq!(code, "out-of-range", "{message}");
        assert!(message.contains("reading 1"), "{message}");
    }
}

/// Rows in another order give the same deviations, by the column that numbers the teeth; two rows of one tooth are refused.
#[test]
fn exact_readings_go_by_their_tooth_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let gear = put(
        folder.path(),
        "gear.toml",
        &format!("title = \"t\"\n{GEAR}{}", chart("")),
    );
    let deviations = |order: &dyn Fn(usize) -> usize| {
        let rows = (0..18).map(|k| (order(k) + 1, READINGS[order(k)]));
        let rows: String = rows.map(|(tooth, r)| format!("{tooth},{r}\n")).collect();
        put(folder.path(), "p.csv", &format!("tooth,left [µm]\n{rows}"));
        document(&["measure", &gear, "--json"])["deviations"].clone()
    };
    let straight = deviations(&|k| k);
    assert_eq!(deviations(&|k| 17 - k), straight);
    assert_eq!(deviations(&|k| (7 * k + 5) % 18), straight);
    let twice = "tooth,left [µm]\n".to_string() + &"3,1\n".repeat(18);
    put(folder.path(), "p.csv", &twice);
    let (code, message) = command::refusal(&["measure", &gear]);
    assert_eq!(code, "conflict");
    assert!(message.contains("rows 1 and 2"), "{message}");
}

/// Readings in mm whose unit says µm: far below the finest grade, with a warning.
#[test]
fn survives_readings_a_thousand_times_too_small() {
    let folder = tempfile::tempdir().unwrap();
    let gear = put(
        folder.path(),
        "gear.toml",
        &format!("title = \"t\"\n{GEAR}{}", chart("")),
    );
    let warned = |unit: f64| {
        let rows = READINGS.iter().enumerate();
        let rows: String = rows
            .map(|(i, r)| format!("{},{}\n", i + 1, f64::from(*r) * unit))
            .collect();
        put(folder.path(), "p.csv", &format!("tooth,left [µm]\n{rows}"));
        let found = document(&["measure", &gear, "--json"]);
        let warnings = found["warnings"].as_array().unwrap();
        warnings.iter().any(|w| w["code"] == "readings-small")
    };
    assert!(warned(1e-3) && warned(0.0));
    assert!(!warned(1.0) && !warned(0.2));
}

/// A design modification fills the deviation of readings that are a thousand times too small: the readings themselves tell.
#[test]
fn survives_small_readings_of_a_modified_profile() {
    let folder = tempfile::tempdir().unwrap();
    let profile = std::fs::read_to_string("data/index_gear_profile.csv").unwrap();
    let gear = "[measured_gear]\nteeth = 40\nmodule = \"3 mm\"\nface_width = \"30 mm\"\n[[chart]]\nkind = \"profile\"\nfile = \"profile.csv\"\nalong = \"roll\"\nleft = [\"left_1\", \"left_11\"]\nactive = [\"12.6 mm\", \"28.1 mm\"]\ntip_relief = \"6 µm\"\nrelief_from = \"25 mm\"\n";
    let gear = put(folder.path(), "gear.toml", gear);
    for (unit, expected) in [("µm", 0), ("nm", 1)] {
        put(folder.path(), "profile.csv", &profile.replace("µm", unit));
        let found = document(&["measure", &gear, "--json"]);
        let warnings = found["warnings"].as_array().unwrap().iter();
        let small: Vec<&Value> = warnings.filter(|w| w["code"] == "readings-small").collect();
        assert_eq!(small.len(), expected, "{unit}: {small:?}");
        for warning in small {
            let message = warning["message"].as_str().unwrap();
            assert!(
                message.contains("left: the profile readings span"),
                "{message}"
            );
        }
    }
}

/// Teeth numbered from 0 are counted from 1, and that is said.
#[test]
fn law_teeth_numbered_from_zero_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let gear = put(
        folder.path(),
        "gear.toml",
        &format!("title = \"t\"\n{GEAR}{}", chart("")),
    );
    for (first, expected) in [(0, true), (1, false)] {
        let rows = READINGS.iter().enumerate();
        let rows: String = rows.map(|(i, r)| format!("{},{r}\n", i + first)).collect();
        put(folder.path(), "p.csv", &format!("tooth,left [µm]\n{rows}"));
        let (_, text, notes) = command::said(&["measure", &gear]);
        let said = (text + &notes).contains("tooth 0 of the file is tooth 1");
        assert_eq!(said, expected, "from {first}");
    }
}

/// A measured gear that names its gear file is evaluated as one that states the same data: range of the active profile, relief, contact ratio.
#[test]
fn law_gear_file_gives_the_evaluation_range() {
    let folder = tempfile::tempdir().unwrap();
    let pair = "pair = { kind = \"cylindrical\", module = \"3 mm\" }\npinion = { teeth = 40, face_width = \"30 mm\", tip_relief = \"6 µm\", relief_from = \"25 mm\" }\ngear = { teeth = 60, face_width = \"30 mm\" }\n";
    let pair = put(folder.path(), "pair.toml", pair);
    let found = document(&["gear", &pair, "--json"]);
    let roll = |point: usize| found["path"][point]["roll_mm"][0].as_f64().unwrap();
    let ratio = &found["geometry"]["total_contact_ratio"];
    std::fs::copy(
        "data/index_gear_profile.csv",
        folder.path().join("profile.csv"),
    )
    .unwrap();
    let chart = "[[chart]]\nkind = \"profile\"\nfile = \"profile.csv\"\nalong = \"roll\"\nleft = [\"left_1\", \"left_11\"]\n";
    let named = "[measured_gear]\ngear = \"pair.toml\"\nmember = \"pinion\"\nstandard = \"ISO 1328-1:2013\"\naccuracy = 6\n";
    let stated = format!(
        "[measured_gear]\nteeth = 40\nmodule = \"3 mm\"\nface_width = \"30 mm\"\ntip_diameter = \"126 mm\"\ncontact_ratio = {ratio}\nstandard = \"ISO 1328-1:2013\"\naccuracy = 6\n{chart}active = [\"{0} mm\", \"{1} mm\"]\nevaluation = [\"{0} mm\", \"{1} mm\"]\ntip_relief = \"6 µm\"\nrelief_from = \"25 mm\"\n",
        roll(0),
        roll(4)
    );
    let evaluate = |name: &str, text: &str| {
        let path = put(folder.path(), name, text);
        document(&["measure", &path, "--json"])["deviations"].clone()
    };
    let by_file = evaluate("named.toml", &format!("{named}{chart}"));
    assert_eq!(by_file, evaluate("stated.toml", &stated));
    assert!(by_file.as_array().unwrap().len() > 3);
    let both = put(
        folder.path(),
        "both.toml",
        &format!("{named}teeth = 40\n{chart}"),
    );
    let (code, message) = command::refusal(&["measure", &both]);
    assert!(
        code == "conflict" && message.contains("`teeth` is determined"),
        "{message}"
    );
}
