//! `geardyn gear cut` as it is called.

use std::fmt::Write;

use serde_json::Value;

use crate::support::command::{document, geardyn, put, refusal, said};
use crate::support::verification::within;
use crate::support::{number, numbers};

const NASA: &str = "models/gears/bevel_12_36.toml";
/// Few positions and stations; few nodes, among them the places of the reference files.
const COARSE: &str = "[mesh]\npositions = 12\nstations = 12\n\n[cut]\nmember = \"pinion\"\nrows = 11\ncolumns = 11\n";

/// The shipped file with coarse maps of the pinion and one text in place of another.
fn changed(from: &str, to: &str) -> (tempfile::TempDir, String) {
    let text = std::fs::read_to_string(NASA)
        .unwrap()
        .replacen("[cut]\n", COARSE, 1);
    assert!(text.contains(from), "{from}");
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "pair.toml", &text.replacen(from, to, 1));
    let path = path.to_str().unwrap().to_string();
    (folder, path)
}

fn coarse() -> (tempfile::TempDir, String) {
    changed("[cut]", "[cut]")
}

/// The text from the first `[[cut.error]]` to the end of the shipped file.
fn chain_errors() -> String {
    let text = std::fs::read_to_string(NASA).unwrap();
    text[text.find("[[cut.error]]").unwrap()..].to_string()
}

fn flank<'a>(found: &'a Value, side: &str) -> &'a Value {
    let flanks = found["cut"]["flanks"].as_array().unwrap();
    flanks.iter().find(|f| f["side"] == side).unwrap()
}

fn cause<'a>(flank: &'a Value, start: &str) -> &'a Value {
    let causes = flank["causes"].as_array().unwrap();
    let mut named = causes
        .iter()
        .filter(|c| c["cause"].as_str().unwrap().starts_with(start));
    named.next().unwrap()
}

/// Scallops of the shipped file by law and on rays at 0.5° of the cradle from blade to blade.
/// Source: data/reference/gear/c26_discrete_blades_nasa.json, tools/gear_blade_peer.py.
#[test]
fn ref_scallops_of_the_file() {
    let (_folder, file) = coarse();
    let found = document(&["gear", "cut", &file, "--json"]);
    let concave = flank(&found, "concave");
    assert_eq!(concave["member"], "pinion");
    within(
        "cradle from blade to blade, deg",
        (number(&concave["cradle_deg_per_blade"]) - 0.5).abs(),
        1e-14,
    );
    let law = numbers(&concave["scallops_by_law"]["deviations_um"]);
    let rays = numbers(&concave["scallops_on_rays"]["deviations_um"]);
    let reference = |name: &str| -> Value {
        let path = format!("data/reference/gear/{name}.json");
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    };
    let (mut by_law, mut on_rays) = (0f64, 0f64);
    for (name, column, values, worst) in [
        ("c26_discrete_blades_nasa", 6, &law, &mut by_law),
        ("blade_scallops", 5, &rays, &mut on_rays),
    ] {
        for row in reference(name)["rows"].as_array().unwrap() {
            let is_same = row[0] == "pinion_concave" && row[1] == 16 && row[2] == 8;
            if is_same {
                let place = |k: usize| (10.0 * number(&row[k])).round() as usize;
                let value = values[place(4) * 11 + place(3)];
                *worst = worst.max((value - number(&row[column])).abs());
            }
        }
    }
    within("law, µm", by_law, 5.1e-6);
    within("on rays, µm", on_rays, 1e-6);
    assert!(number(&concave["law_error"]) < 0.01);
}

/// Every cause has a map; a blade that stands out by more than N² h finishes the flank alone, and shares of blades add up to one.
#[test]
fn law_causes_of_the_file() {
    let (_folder, file) = changed("\"0.4 µm\"", "\"900 µm\"");
    let found = document(&["gear", "cut", &file, "--json"]);
    let concave = flank(&found, "concave");
    let names: Vec<&str> = (concave["causes"].as_array().unwrap().iter())
        .map(|c| c["cause"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "regular blades",
            "run-out",
            "error 1: work, 1 a revolution",
            "error 2: work, 60 a revolution",
            "all causes"
        ]
    );
    for of in concave["causes"].as_array().unwrap() {
        let shares = numbers(&of["blade_shares"]);
        assert_eq!(shares.len(), 16);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    let finishing = |start: &str| {
        let shares = numbers(&cause(concave, start)["blade_shares"]);
        shares.iter().filter(|s| **s > 0.0).count()
    };
    assert!(finishing("regular") > 4);
    assert_eq!(finishing("run-out"), 1);
    // Regular blades leave metal; a blade that stands out cuts below the ideal flank.
    let lowest = |start: &str| number(&cause(concave, start)["lowest_um"]);
    assert!(lowest("regular") >= 0.0 && lowest("run-out") < -0.5);
    let contact = &found["cut"]["contact"];
    let ideal = number(&contact["ideal"]["peak_to_peak_arcsec"]);
    let tca = document(&["gear", &file, "--json"]);
    assert_eq!(ideal, number(&tca["tca"]["peak_to_peak_arcsec"]));
}

/// The changed envelope of a wave once a revolution moves the transmission error by first order: `te = Δε (z₁/z₂)`-like shares stay below the
/// wave itself, and a wave of 400 a revolution leaves edges, which the contact says.
#[test]
fn law_contact_with_errors() {
    let (_folder, file) = changed("cycles = 60", "cycles = 2");
    let found = document(&["gear", "cut", &file, "--json"]);
    let contact = &found["cut"]["contact"];
    let te = |of: &str| number(&contact[of]["peak_to_peak_arcsec"]);
    let apart = (te("with_chain_errors") - te("ideal")).abs();
    assert!(apart > 1e-3 && apart < 20.0, "{apart}");
    let (_folder, file) = changed("cycles = 60", "cycles = 400");
    let found = document(&["gear", "cut", &file, "--json"]);
    assert!(found["cut"]["contact"]["with_chain_errors"].is_null());
    let (_, text, _) = said(&["gear", "cut", &file]);
    assert!(!text.contains("with errors of the chain"), "{text}");
}

/// The shipped pair under 40 N·m, its pinion cut by true blades close together on a generator with one error of the work.
fn one_error(error: &str, positions: usize) -> Value {
    let text = std::fs::read_to_string(NASA).unwrap();
    let cut = COARSE.replacen("[mesh]\n", "[mesh]\ntorque = \"40 N·m\"\n", 1);
    let cut = cut.replacen("positions = 12", &format!("positions = {positions}"), 1);
    let text = text
        .replacen("[cut]\n", &cut, 1)
        .replacen("\"8 deg/s\"", "\"0.8 deg/s\"", 1);
    let start = text.find("radial_run_out").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let error = format!(
        "{}\n[[cut.error]]\ntarget = \"work\"\n{error}",
        &text[..start]
    );
    let path = put(folder.path(), "pair.toml", &error);
    document(&["gear", "cut", path.to_str().unwrap(), "--json"])["cut"]["contact"].clone()
}

fn mesh<'a>(contact: &'a Value, cause: Option<&str>) -> &'a Value {
    let mut meshes = contact["meshes"].as_array().unwrap().iter();
    let is_of = |m: &&Value| match (m["cause"].as_str(), cause) {
        (Some(name), Some(start)) => name.starts_with(start),
        (name, start) => name.is_none() && start.is_none(),
    };
    meshes.find(is_of).unwrap()
}

/// A wave of the work on the flank: its transmission error through the ridges of least gap against the exact contact of the changed
/// envelope.
#[test]
fn exact_mesh_of_a_wave() {
    let contact = one_error(
        "amplitude = \"4 arcsec\"\ncycles = 60\nphase = \"140 deg\"\n",
        48,
    );
    let te = |cause: Option<&str>| number(&mesh(&contact, cause)["unloaded_te_arcsec"]);
    let exact = number(&contact["with_chain_errors"]["peak_to_peak_arcsec"])
        - number(&contact["ideal"]["peak_to_peak_arcsec"]);
    let found = te(Some("error 1")) - te(Some("regular"));
    assert!(exact.abs() > 1.0, "{exact}");
    within(
        "change of the transmission error, arcsec",
        (found - exact).abs(),
        0.2,
    );
    // Blades that close leave scallops of 0.02 µm.
    assert!((te(Some("regular")) - te(None)).abs() < 0.05);
}

/// A constant error of the work turns the flank about its axis: micrometres of deviation, the same transmission error and pattern; without
/// load and blades apart the mesh is that of the gear file.
#[test]
fn law_mesh_of_a_turned_flank() {
    let contact = one_error("amplitude = \"20 arcsec\"\ncycles = 0\n", 12);
    let of = |cause: Option<&str>, key: &str| number(&mesh(&contact, cause)[key]);
    for key in ["unloaded_te_arcsec", "loaded_te_arcsec"] {
        let apart = of(Some("error 1"), key) - of(Some("regular"), key);
        assert!(apart.abs() < 0.1, "{key} {apart}");
    }
    let centre = |cause: Option<&str>| number(&mesh(&contact, cause)["centre"]["face"]);
    assert!((centre(Some("error 1")) - centre(Some("regular"))).abs() < 2e-3);
    assert_eq!(of(None, "torque_nm"), 40.0);
    let text = std::fs::read_to_string(NASA).unwrap();
    let torque = "[mesh]\ntorque = \"40 N·m\"\npositions = 12\nstations = 12\n\n[cut]\n";
    let folder = tempfile::tempdir().unwrap();
    let path = put(
        folder.path(),
        "pair.toml",
        &text.replacen("[cut]\n", torque, 1),
    );
    let gear = document(&["gear", path.to_str().unwrap(), "--json"]);
    let same = number(&gear["mesh"]["peak_to_peak_arcsec"][0]) / of(None, "loaded_te_arcsec");
    assert!((same - 1.0).abs() < 1e-9, "{same}");
}

/// A history of a spindle that oscillates as a chain error leaves the same flank.
#[test]
fn law_history_of_a_harmonic() {
    let ratio = 1.0 / 0.30838512709;
    let frequency = 60.0 * 8.0 / 360.0 * ratio;
    let (cycles, samples) = (30.0, 9000);
    let duration = cycles / frequency;
    // The nominal turn, so many times as fast, goes off again with the straight line.
    let history_of = |times: f64| {
        let mut table = "time [s],work.theta [arcsec]\n".to_string();
        for i in 0..=samples {
            let t = duration * f64::from(i) / f64::from(samples);
            let turn = std::f64::consts::TAU * frequency * (t - 0.5 * duration);
            let ahead = 4.0 * turn.cos() * if times < 0.0 { -1.0 } else { 1.0 };
            writeln!(table, "{t},{}", ahead + times * 8.0 * 3600.0 * ratio * t).unwrap();
        }
        table
    };
    let table = history_of(1.0);
    let history = "[cut.spindle_history]\nfile = \"history.csv\"\ncolumn = \"work.theta\"\n";
    let (folder, file) = changed(&chain_errors(), history);
    put(folder.path(), "history.csv", &table);
    let by_history = document(&["gear", "cut", &file, "--json"]);
    put(folder.path(), "history.csv", &history_of(-1.0));
    let backwards = document(&["gear", "cut", &file, "--json"]);
    assert_eq!(backwards["cut"]["flanks"], by_history["cut"]["flanks"]);
    put(folder.path(), "history.csv", &history_of(2.0));
    let (_, message) = refusal(&["gear", "cut", &file]);
    assert!(
        message.contains("turns at 51.8832 deg/s, and the work at 25.9416"),
        "{message}"
    );
    let (_folder, file) = coarse();
    let by_error = document(&["gear", "cut", &file, "--json"]);
    let map = |found: &Value, start: &str| {
        numbers(&cause(flank(found, "concave"), start)["deviations_um"])
    };
    let pairs = (map(&by_history, "history").into_iter()).zip(map(&by_error, "error 2"));
    let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 2e-3, "{apart}");
    let te = |found: &Value, cause: &str| {
        number(&mesh(&found["cut"]["contact"], Some(cause))["unloaded_te_arcsec"])
    };
    let apart = te(&by_history, "history") - te(&by_error, "error 2");
    assert!(apart.abs() < 0.05, "{apart}");
    let short = table.lines().take(2000).collect::<Vec<_>>().join("\n");
    put(folder.path(), "history.csv", &short);
    let file = folder.path().join("pair.toml");
    let (code, message) = refusal(&["gear", "cut", file.to_str().unwrap()]);
    assert_eq!(code, "out-of-range");
    assert!(message.contains("the history lasts"), "{message}");
    put(
        folder.path(),
        "history.csv",
        &table.replace("work.theta", "spindle.theta"),
    );
    let (code, _) = refusal(&["gear", "cut", file.to_str().unwrap()]);
    assert_eq!(code, "missing-key");
}

/// Flanks, figures and tables are written.
#[test]
fn keeps_files_of_a_cut() {
    let (folder, file) = coarse();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (csv, svg, nodes, stl) = (at("p.csv"), at("m.svg"), at("f.csv"), at("f.stl"));
    let (code, text, _) = said(&[
        "gear", "cut", &file, "--csv", &csv, "--svg", &svg, "--flank", &nodes,
    ]);
    assert_eq!(code, Some(0));
    for word in [
        "scallops",
        "run-out",
        "all causes",
        "unloaded contact",
        "mesh as cut",
    ] {
        assert!(text.contains(word), "{word}\n{text}");
    }
    for name in ["m.svg", "m-causes.svg", "m-profile.svg", "m-blades.svg"] {
        assert!(std::fs::read_to_string(at(name)).unwrap().contains("<svg"));
    }
    let lines = |path: &str| std::fs::read_to_string(path).unwrap().lines().count();
    assert_eq!(lines(&nodes), 1 + 2 * 5 * 121);
    assert!(lines(&csv) > 400);
    let output = geardyn(&["gear", "cut", &file, "--flank", &stl, "--quiet"]);
    assert!(output.status.success());
    let bytes = std::fs::read(&stl).unwrap();
    assert_eq!(bytes.len(), 84 + 50 * 2 * 2 * 100);
}

/// What cannot be cut, with the key that is wrong.
#[test]
fn refuses_cuts() {
    let cut = |from: &str, to: &str| {
        let (_folder, file) = changed(from, to);
        refusal(&["gear", "cut", &file])
    };
    let (code, message) = cut("\"8 deg/s\"", "\"200 deg/s\"");
    assert_eq!(code, "out-of-range");
    assert!(message.contains("from blade to blade"), "{message}");
    assert_eq!(cut("cradle_speed = \"8 deg/s\"\n", "").0, "missing-key");
    assert_eq!(cut("blades = 16", "blades = 15").0, "wrong-type");
    assert_eq!(cut("\"0.4 µm\"", "\"4 mm\"").0, "out-of-range");
    assert_eq!(
        cut("target = \"work\"", "target = \"wrok\"").0,
        "out-of-range"
    );
    assert_eq!(cut("amplitude = \"20 arcsec\"\n", "").0, "missing-key");
    let text = std::fs::read_to_string(NASA).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let bare = put(
        folder.path(),
        "bare.toml",
        text.split("[cut]").next().unwrap(),
    );
    let (code, message) = refusal(&["gear", "cut", bare.to_str().unwrap()]);
    assert_eq!(
        (code.as_str(), message.as_str()),
        ("missing-key", "the file has no [cut]")
    );
    assert_eq!(
        refusal(&["gear", "cut", "models/gears/fzg_c.toml"]).0,
        "usage"
    );
}

/// The chips of a gear's slot as a face-mill load: with Kienzle's m = 0 the force is k_c1 times the area, so that the impulse on a heavy
/// head is `k_c1 r ∫ A dθ/Ω`, the integral taken from the file.
#[test]
fn exact_impulse_of_chips() {
    let (folder, file) = coarse();
    let text = std::fs::read_to_string(&file).unwrap();
    let text = text.replacen("member = \"pinion\"", "member = \"gear\"", 1);
    let text = text.replacen("blades = 16", "blades = 8", 1);
    let start = text.find("radial_run_out").unwrap();
    put(folder.path(), "pair.toml", &text[..start]);
    let chips = folder.path().join("chips.csv");
    let chips = chips.to_str().unwrap();
    let found = document(&["gear", "cut", &file, "--chips", chips, "--json"]);
    let of = &found["cut"]["chips"][0];
    assert_eq!(of["member"], "gear");
    let written = std::fs::read_to_string(chips).unwrap();
    let rows: Vec<Vec<f64>> = written
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let greatest = rows.iter().map(|row| row[5]).fold(0.0, f64::max);
    assert_eq!(greatest, number(&of["greatest"]["area_mm2"]));
    let step = (rows.windows(2).filter(|pair| pair[0][0] == pair[1][0]))
        .map(|pair| pair[1][3] - pair[0][3])
        .fold(f64::INFINITY, f64::min);
    let area: f64 = rows.iter().map(|row| row[5]).sum();
    let (speed, force, radius, inertia) = (6.0, 2e9, 0.1, 1e6);
    let exact = force * radius * area * 1e-6 * step.to_radians() / speed / inertia;
    let head = |chips: &str| {
        let text = format!(
            "inertia = [{{ name = \"head\", J = \"{inertia:e} kg·m²\" }}]\n[speed]\nhead = \"{speed} rad/s\"\n[[load]]\nat = \"head\"\nkind = \"face-mill\"\nsense = \"backward\"\nradius = \"{radius} m\"\nspecific_force = \"{force:e} Pa\"\nexponent = 0.0\nchips = \"{chips}"
        );
        let path = put(folder.path(), "head.toml", &text);
        path.to_str().unwrap().to_string()
    };
    let machine = head("chips.csv\"\nstart = \"0.1 s\"\n");
    let simulate = [
        "simulate",
        &machine,
        "--until",
        "30",
        "--output",
        "head.theta.speed",
        "--json",
    ];
    let speeds = numbers(&document(&simulate)["outputs"]["head.theta.speed_rad_s"]);
    let lost = speeds[0] - speeds[speeds.len() - 1];
    within(
        "impulse of all chips, relative",
        (lost / exact - 1.0).abs(),
        1e-5,
    );

    let (code, message) = refusal(&["check", &head("chips.csv\"\narc = \"5 deg\"\n")]);
    assert!(
        code == "conflict" && message.contains("`arc` and `chips`"),
        "{message}"
    );
    assert_eq!(refusal(&["check", &head("none.csv\"\n")]).0, "file-missing");
    put(
        folder.path(),
        "bare.csv",
        &written.replacen("edge [mm]", "edge", 1),
    );
    assert_eq!(refusal(&["check", &head("bare.csv\"\n")]).0, "missing-unit");
    let wrong = written.lines().take(2).collect::<Vec<_>>().join("\n") + "\n1,1,0,1,0,1,1,-1\n";
    put(folder.path(), "wrong.csv", &wrong);
    assert_eq!(
        refusal(&["check", &head("wrong.csv\"\n")]).0,
        "out-of-range"
    );
    let (_folder, pinion) = coarse();
    let (code, message) = refusal(&["gear", "cut", &pinion, "--chips", chips]);
    assert!(
        code == "usage" && message.contains("separate settings"),
        "{message}"
    );
}
