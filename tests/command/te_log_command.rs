//! `geardyn te LOG` as a person uses it: the shipped record, angles, pulses, tracks, simulated motion, wrong input.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::command::{document, geardyn, put, refusal};
use crate::support::verification::within;

/// The motion of a scene as CSV.
fn simulated(folder: &Path, scene: &str) -> PathBuf {
    let csv = folder.join("motion.csv");
    let done = geardyn(&["simulate", scene, "--csv", csv.to_str().unwrap(), "--quiet"]);
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(0), "{said}");
    csv
}

/// A temporary folder of this test.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("geardyn-te-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    path
}

const SHIPPED: [&str; 10] = [
    "te",
    "data/y2250_te.csv",
    "--input",
    "index_gear_1",
    "--output",
    "work_spindle",
    "--teeth",
    "30:37,54:36,1:90",
    "--lines",
    "10000,36000",
];

/// The record that is shipped gives its answers back: what its model declares, through the dynamics, lies inside the intervals.
#[test]
fn exact_shipped_record() {
    let folder = folder("shipped");
    let (csv, svg) = (folder.join("te.csv"), folder.join("te.svg"));
    let files = [csv.to_str().unwrap(), svg.to_str().unwrap()];
    let more = [
        "--json", "--radius", "270mm", "--csv", files[0], "--svg", files[1],
    ];
    let found = document(&[&SHIPPED[..], &more].concat());
    let truth = std::fs::read_to_string("data/y2250_te.toml").unwrap();
    let list = |key: &str| -> Vec<f64> {
        let line = truth.lines().find(|l| l.starts_with(key)).unwrap();
        let inner = line.split(['[', ']']).nth(1).unwrap();
        inner
            .split(',')
            .map(|x| x.trim().parse().unwrap())
            .collect()
    };
    let (orders, amplitudes) = (list("order"), list("amplitude_arcsec"));
    let lines = found["orders"].as_array().unwrap();
    let mut inside = 0;
    for (order, amplitude) in orders.iter().zip(&amplitudes) {
        let line = lines.iter().find(|l| l["order_value"] == *order);
        let line = line.unwrap_or_else(|| panic!("order {order}"));
        let interval = line["interval_arcsec"].as_array().unwrap();
        let (low, high) = (interval[0].as_f64().unwrap(), interval[1].as_f64().unwrap());
        inside += usize::from(low <= *amplitude && *amplitude <= high);
        let std = line["std_arcsec"].as_f64().unwrap();
        let off = (line["amplitude_arcsec"].as_f64().unwrap() - amplitude).abs();
        assert!(off < 4.0 * std, "{order}: {amplitude} {line}");
        assert!(line["significant"].as_bool().unwrap());
        let um = line["amplitude_um"].as_f64().unwrap();
        let arcsec = line["amplitude_arcsec"].as_f64().unwrap();
        within(
            "amplitude in µm over arcsec",
            (um / arcsec * 206_264.806 / 270e3 - 1.0).abs(),
            1e-6,
        );
    }
    // One in twenty lies outside its interval of 95 %.
    assert!(orders.len() == 5 && inside >= 4, "{inside}");
    let worm = lines.iter().find(|l| l["order_value"] == 90.0).unwrap();
    assert_eq!(worm["shared"], true);
    assert!(worm["sources"].as_array().unwrap().len() > 1);
    let total = found["total_arcsec"].as_f64().unwrap();
    let sum: f64 = 2.0 * amplitudes.iter().sum::<f64>();
    assert!(
        total > 2.0 * amplitudes[0] && total < 1.2 * sum,
        "{total} {sum}"
    );
    assert!(found["warnings"].to_string().contains("mesh-above-band"));
    let rows = std::fs::read_to_string(&csv).unwrap();
    assert!(rows.starts_with("direction,angle_deg,te_arcsec,long_wave_arcsec,te_um\nforward,"));
    assert!(
        rows.lines()
            .nth(1)
            .unwrap()
            .split(',')
            .skip(1)
            .all(|x| x.parse::<f64>().is_ok())
    );
    assert!(std::fs::read_to_string(&svg).unwrap().contains("</svg>"));
    let text = geardyn(&SHIPPED);
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(
        text.contains("F_i′") && text.contains("not separated"),
        "{text}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}

/// The error of a made-up pair 21:64 at an angle of the output, turns: 8 arcsec of order 1, 2 of the mesh.
fn error(turns: f64) -> f64 {
    let arcsec = TAU / 1_296_000.0;
    8.0 * arcsec * (TAU * turns + 0.4).cos() + 2.0 * arcsec * (TAU * 64.0 * turns).sin()
}

fn amplitude(found: &Value, order: f64) -> f64 {
    let lines = found["orders"].as_array().unwrap();
    let line = lines.iter().find(|l| l["order_value"] == order);
    line.unwrap_or_else(|| panic!("order {order}"))["amplitude_arcsec"]
        .as_f64()
        .unwrap()
}

/// Angles in degrees that begin again, at even times and at uneven ones, and without any time.
#[test]
fn exact_angles() {
    let folder = folder("angles");
    let table = |heads: &str, row: &dyn Fn(f64) -> String| {
        let rows: String = (0..6000).map(|k| row(f64::from(k) / 2500.0)).collect();
        put(&folder, "angles.csv", &format!("{heads}\n{rows}"))
    };
    let degrees = |turns: f64| 360.0 * turns.rem_euclid(1.0);
    let both = |turns: f64| {
        let (a, b) = (turns * 64.0 / 21.0, turns + error(turns) / TAU);
        format!("{:.9},{:.9}\n", degrees(a), degrees(b))
    };
    let asked = |path: &Path, more: &[&str]| {
        let path = path.to_str().unwrap().to_string();
        let flags = [
            "--input", "a", "--output", "b", "--teeth", "21:64", "--json",
        ];
        document(&[&["te", &path][..], &flags, more].concat())
    };
    let even = table("time [s],a [deg],b [deg]", &|t| {
        format!("{t:.6},{}", both(0.9 * t))
    });
    let found = asked(&even, &[]);
    within(
        "order 1 of even angles, arcsec",
        (amplitude(&found, 1.0) - 8.0).abs(),
        2e-3,
    );
    within(
        "order 64 of even angles, arcsec",
        (amplitude(&found, 64.0) - 2.0).abs(),
        2e-3,
    );
    assert!((found["speed"]["mean_rpm"].as_f64().unwrap() - 54.0).abs() < 0.05);
    let uneven = table("time [s],a [deg],b [deg]", &|t| {
        format!("{:.9},{}", t + 5e-5 * (300.0 * t).sin(), both(0.9 * t))
    });
    within(
        "order 64 of uneven angles, arcsec",
        (amplitude(&asked(&uneven, &[]), 64.0) - 2.0).abs(),
        2e-3,
    );
    let bare = table("a [deg],b [deg]", &|t| both(0.9 * t));
    let found = asked(&bare, &["--angle-base"]);
    within(
        "order 1 without time, arcsec",
        (amplitude(&found, 1.0) - 8.0).abs(),
        2e-3,
    );
    assert_eq!(found["speed"], Value::Null);
    std::fs::remove_dir_all(folder).unwrap();
}

/// Instants of pulses in columns of different length; a line that is missing each turn is found, and put right where asked for.
#[test]
fn exact_pulses() {
    let folder = folder("pulses");
    let (a, b) = (720.0, 1800.0);
    // the instant at which the output has turned so far: the error is small, one step of Newton is exact enough
    let instant = |turns: f64| turns - error(turns) / TAU;
    let input: Vec<f64> = (0..(2.3 * 64.0 / 21.0 * a) as usize)
        .map(|k| k as f64 / a * 21.0 / 64.0)
        .collect();
    let output: Vec<f64> = (0..(2.3 * b) as usize)
        .map(|k| instant(k as f64 / b))
        .collect();
    let write = |skip: &dyn Fn(usize) -> bool| {
        let kept: Vec<f64> = (0..output.len())
            .filter(|k| !skip(*k))
            .map(|k| output[k])
            .collect();
        let mut text = String::from("motor [s],wheel [s]\n");
        for k in 0..input.len().max(kept.len()) {
            let cell = |list: &[f64]| {
                list.get(k)
                    .map_or(String::new(), |t| format!("{:.12}", t + 1.0))
            };
            text += &format!("{},{}\n", cell(&input), cell(&kept));
        }
        put(&folder, "pulses.csv", &text)
    };
    let flags = [
        "--input", "motor", "--output", "wheel", "--teeth", "21:64", "--stamps", "--lines",
        "720,1800",
    ];
    let path = write(&|_| false);
    let path = path.to_str().unwrap();
    let arguments = [&["te", path][..], &flags].concat();
    let found = document(&[&arguments[..], &["--json"]].concat());
    within(
        "order 1 of pulses, arcsec",
        (amplitude(&found, 1.0) - 8.0).abs(),
        0.02,
    );
    within(
        "order 64 of pulses, arcsec",
        (amplitude(&found, 64.0) - 2.0).abs(),
        0.05,
    );
    write(&|k| k % 1800 == 700);
    let (code, message) = refusal(&arguments);
    assert_eq!(code, "lost-counts");
    assert!(
        message.contains("wheel has 2 missing and 0 extra pulses")
            && message.contains("always behind line 700"),
        "{message}"
    );
    let found = document(&[&arguments[..], &["--repair", "--json"]].concat());
    assert!((amplitude(&found, 1.0) - 8.0).abs() < 0.05);
    std::fs::remove_dir_all(folder).unwrap();
}

/// Two tracks in quadrature for each shaft.
#[test]
fn exact_tracks() {
    let folder = folder("tracks");
    let mut text = String::from("time [s],a1 [V],b1 [V],a2 [V],b2 [V]\n");
    for k in 0..40_000 {
        let turns = 2.2 * f64::from(k) / 40_000.0 + 0.003;
        let pair = |angle: f64, lines: f64| [0.0, 0.25].map(|s| (TAU * (lines * angle - s)).sin());
        let (a, b) = (
            pair(turns * 64.0 / 21.0, 600.0),
            pair(turns + error(turns) / TAU, 1500.0),
        );
        text += &format!(
            "{:.5},{:.6},{:.6},{:.6},{:.6}\n",
            f64::from(k) * 1e-4,
            a[0],
            a[1],
            b[0],
            b[1]
        );
    }
    let path = put(&folder, "tracks.csv", &text);
    let found = document(&[
        "te",
        path.to_str().unwrap(),
        "--input",
        "a1,b1",
        "--output",
        "a2,b2",
        "--teeth",
        "21:64",
        "--lines",
        "600,1500",
        "--json",
    ]);
    within(
        "order 1 of tracks, arcsec",
        (amplitude(&found, 1.0) - 8.0).abs(),
        0.3,
    );
    std::fs::remove_dir_all(folder).unwrap();
}

/// Every wrong input ends with 2 and says what to do.
#[test]
fn refuses_wrong_input() {
    let with = |from: &str, to: &str| -> Vec<String> {
        let one = |a: &&str| {
            if *a == from {
                to.to_string()
            } else {
                (*a).to_string()
            }
        };
        SHIPPED.iter().map(one).collect()
    };
    let code = |list: &[String], more: &[&str]| {
        let mut all: Vec<&str> = list.iter().map(String::as_str).collect();
        all.extend(more);
        refusal(&all)
    };
    let same = with("", "");
    let (word, message) = code(&with("30:37,54:36,1:90", "30:37,54:36,1:91"), &[]);
    assert_eq!(word, "ratio-mismatch");
    assert!(message.contains("0.0135135"), "{message}");
    assert_eq!(code(&with("30:37,54:36,1:90", "30-37"), &[]).0, "usage");
    assert_eq!(
        code(&with("30:37,54:36,1:90", "0:37"), &[]).0,
        "out-of-range"
    );
    assert_eq!(
        code(&with("work_spindle", "spindle_x"), &[]).0,
        "no-channel"
    );
    assert_eq!(code(&with("work_spindle", "index_gear_1"), &[]).0, "usage");
    assert_eq!(code(&with("10000,36000", "10000,x"), &[]).0, "usage");
    assert_eq!(
        code(&with("10000,36000", "10000,36005"), &[]).0,
        "ratio-mismatch"
    );
    assert_eq!(code(&same, &["--harmonics", "40"]).0, "out-of-range");
    assert_eq!(code(&same, &["--harmonics", "0"]).0, "out-of-range");
    assert_eq!(code(&same, &["--radius", "nan"]).0, "out-of-range");
    assert_eq!(code(&same, &["--radius", "-3"]).0, "out-of-range");
    assert_eq!(code(&same, &["--speed", "100"]).0, "usage");
    assert_eq!(code(&same, &["--before", "60"]).0, "too-short");
    let none = [
        "te",
        "data/y2250_te.csv",
        "--input",
        "index_gear_1",
        "--output",
        "work_spindle",
    ];
    assert_eq!(refusal(&none).0, "usage");
    let bare = [&none[..], &["--teeth", "30:37,54:36,1:90"]].concat();
    let (word, message) = refusal(&bare);
    assert_eq!(word, "usage");
    assert!(message.contains("lines"), "{message}");
    let folder = folder("wrong");
    let text = std::fs::read_to_string("data/y2250_te.csv").unwrap();
    let mut rows: Vec<String> = text.lines().map(str::to_string).collect();
    let place = rows[500].rfind(',').unwrap();
    rows[500].truncate(place + 1);
    let path = put(&folder, "hole.csv", &(rows.join("\n") + "\n"));
    let (word, message) = code(&with("data/y2250_te.csv", path.to_str().unwrap()), &[]);
    assert_eq!(word, "not-a-number", "{message}");
    std::fs::remove_dir_all(folder).unwrap();
}

/// Motion in time of a machine with a declared error, its two angles written by `simulate`, gives the error back as the chain has it.
#[test]
fn exact_simulated_motion() {
    let folder = folder("simulated");
    put(
        &folder,
        "pair.toml",
        "title = \"pair\"\nsource = \"made up\"\ninertia = [{ name = \"a\", J = \"0.004 kg·m²\" }, { name = \"b\", J = \"0.5 kg·m²\" }]\ngear_pair = [{ name = \"mesh\", between = [\"a\", \"b\"], teeth = [21, 64], module = \"3 mm\", k = \"280 N/µm\", damping_ratio = 0.05 }]\nerror = [{ on = \"b\", cause = \"eccentricity\", amplitude = \"10 µm\", phase = \"30 deg\" }]\n[speed]\na = \"60 rpm\"\n",
    );
    let scene = put(
        &folder,
        "scene.toml",
        "title = \"turning\"\nmodel = \"pair.toml\"\n[start]\nat = \"steady\"\n[[study]]\nkind = \"simulate\"\nuntil = \"8 s\"\nsamples = 8000\noutputs = [\"a.theta\", \"b.theta\"]\n",
    );
    let scene = scene.to_str().unwrap();
    let csv = simulated(&folder, scene);
    let csv = csv.to_str().unwrap();
    let chain = document(&["te", scene, "--driver", "a", "--output", "b", "--json"]);
    let expected = chain["orders"][0]["amplitude_arcsec"].as_f64().unwrap();
    let found = document(&[
        "te", csv, "--input", "a.theta", "--output", "b.theta", "--teeth", "21:64", "--json",
    ]);
    within(
        "amplitude",
        (amplitude(&found, 1.0) / expected - 1.0).abs(),
        1e-3,
    );
    let line = &found["orders"][0];
    let phase = |v: &Value| v["phase_deg"].as_f64().unwrap();
    let off = (phase(line) - phase(&chain["orders"][0]) + 180.0).rem_euclid(360.0) - 180.0;
    within("phase, degrees", off.abs(), 0.1);
    std::fs::remove_dir_all(folder).unwrap();
}

/// The circle closes: of the shipped record the model tells which declared error makes each line, and how large each is comes back.
#[test]
fn exact_declared_errors_come_back() {
    let model = [
        "--model",
        "examples/y2250_index_te.toml",
        "--at",
        "index_gear_1,work_spindle",
    ];
    let found = document(&[&SHIPPED[..], &model, &["--json"]].concat());
    let all = &found["attribution"];
    assert_eq!((&all["sources"], &all["rank"]), (&5.into(), &5.into()));
    let orders = all["orders"].as_array().unwrap();
    let mut inside = 0;
    for (row, (order, name, declared)) in orders.iter().zip([
        (1.0, "index_wheel", 14.0),
        (60.0, "index_gear_3", 18.0),
        (74.0, "index_gear_1", 15.0),
        (90.0, "index_worm", 6.0),
        (180.0, "index_worm", 1.2),
    ]) {
        assert_eq!(row["order_value"], order);
        let source = &row["sources"][0];
        assert!(
            source["source"].as_str().unwrap().starts_with(name),
            "{source}"
        );
        assert!((source["declared"].as_f64().unwrap() - declared).abs() < 1e-9);
        let range = source["identified_interval"].as_array().unwrap();
        let (low, high) = (range[0].as_f64().unwrap(), range[1].as_f64().unwrap());
        inside += usize::from(low <= declared && declared <= high);
        // a deviation is about a quarter of an interval
        let off = (source["identified"].as_f64().unwrap() - declared).abs();
        assert!(off < 1.2 * (high - low), "{source}");
    }
    assert!(inside >= 4, "{inside}");
    let text = geardyn(&[&SHIPPED[..], &model].concat());
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains("5 values of 5 declared"), "{text}");
    assert!(
        text.contains("dominant: order 1, index_wheel cumulative-pitch = output"),
        "{text}"
    );
    assert!(text.contains("mean turn of input"), "{text}");
    let wrong = [
        &SHIPPED[..],
        &["--model", "models/y2250.toml", "--at", "motor,work_spindle"],
    ]
    .concat();
    assert_eq!(refusal(&wrong).0, "ratio-mismatch");
    let wrong = [
        &SHIPPED[..],
        &["--model", "models/y2250.toml", "--at", "motr,work_spindle"],
    ]
    .concat();
    assert_eq!(refusal(&wrong).0, "unknown-node");
}

/// A free driver answers the meshes: its angle as recorded tells how far, and the declared profile comes back all the same.
#[test]
fn exact_errors_behind_a_free_driver() {
    let folder = folder("free");
    put(
        &folder,
        "pair.toml",
        "title = \"pair\"\nsource = \"made up\"\ninertia = [{ name = \"m\", J = \"0.01 kg·m²\" }, { name = \"t\", J = \"0.1 kg·m²\" }]\ngear_pair = [{ name = \"g\", between = [\"m\", \"t\"], teeth = [13, 40], module = \"3 mm\", k = \"200 N/µm\", damping_ratio = 0.02 }]\nerror = [{ on = \"t\", cause = \"eccentricity\", amplitude = \"9 µm\" }, { on = \"t\", cause = \"profile\", amplitude = \"0.4 µm\" }]\n[speed]\nm = \"1200 rpm\"\n",
    );
    let scene = put(
        &folder,
        "scene.toml",
        "title = \"turning\"\nmodel = \"pair.toml\"\n[start]\nat = \"steady\"\nmesh_phase = \"speed\"\n[[study]]\nkind = \"simulate\"\nuntil = \"1 s\"\nsamples = 20000\noutputs = [\"m.theta\", \"t.theta\"]\n",
    );
    let scene = scene.to_str().unwrap();
    let csv = simulated(&folder, scene);
    let csv = csv.to_str().unwrap();
    let arguments = [
        "te", csv, "--input", "m.theta", "--output", "t.theta", "--teeth", "13:40", "--model",
        scene, "--at", "m,t", "--after", "0.2 s", "--json",
    ];
    let found = document(&arguments);
    let orders = found["attribution"]["orders"].as_array().unwrap();
    let row = orders.iter().find(|o| o["order"] == "40").unwrap();
    let source = &row["sources"][0];
    let bound = found["interpolation_error_relative"].as_f64().unwrap();
    let size = source["identified"].as_f64().unwrap();
    assert!((size / 0.4 - 1.0).abs() < bound, "{row}");
    let range = source["identified_interval"].as_array().unwrap();
    assert!(range[0].as_f64().unwrap() < 0.4 && 0.4 < range[1].as_f64().unwrap());
    let warnings = found["warnings"].as_array().unwrap();
    assert!(
        warnings.iter().any(|w| w["code"] == "input-uneven"),
        "{warnings:?}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}

/// Counts of both encoders with a mark each, there and back: phases from the marks in both directions, counts between marks, and both
/// directions attributed to the model's error.
#[test]
fn exact_marks_and_both_directions() {
    let folder = folder("marks");
    let model = put(
        &folder,
        "pair.toml",
        "title = \"pair\"\nsource = \"made up\"\ninertia = [{ name = \"a\", J = \"0.004 kg·m²\" }, { name = \"b\", J = \"0.5 kg·m²\" }]\ngear_pair = [{ name = \"mesh\", between = [\"a\", \"b\"], teeth = [21, 64], module = \"3 mm\", k = \"280 N/µm\" }]\nerror = [{ on = \"b\", cause = \"eccentricity\", amplitude = \"10 µm\", phase = \"30 deg\" }]\n[speed]\na = \"60 rpm\"\n",
    );
    let rows = 14_000;
    let mut text = String::from("time [s],a,b,az,bz\n");
    for k in 0..rows {
        // half a second at rest in the middle, through a play of 200 arcsec
        let there = 2.6 * f64::from(k.min(rows - k)) / f64::from(rows / 2);
        let play = if k > rows / 2 {
            200.0 / 1_296_000.0
        } else {
            0.0
        };
        let (a, b) = (there * 64.0 / 21.0, there + play + error(there) / TAU);
        let high = |x: f64, at: f64| u8::from((x - at).rem_euclid(1.0) < 0.04);
        text += &format!(
            "{:.4},{:.0},{:.0},{},{}\n",
            f64::from(k) * 1e-3,
            (a * 40_000.0 + 777.0).floor(),
            (b * 144_000.0 - 99_000.0).floor(),
            high(a, 0.25),
            1 - high(b, 0.6)
        );
    }
    let path = put(&folder, "marks.csv", &text);
    let arguments = [
        "te",
        path.to_str().unwrap(),
        "--input",
        "a",
        "--output",
        "b",
        "--teeth",
        "21:64",
        "--lines",
        "10000,36000",
        "--input-index",
        "az",
        "--output-index",
        "bz",
        "--model",
        model.to_str().unwrap(),
        "--at",
        "a,b",
    ];
    let svg = folder.join("marks.svg");
    let found = document(&[&arguments[..], &["--json", "--svg", svg.to_str().unwrap()]].concat());
    assert_eq!(found["runs"].as_array().unwrap().len(), 2);
    let play = &found["play"];
    let number = |key: &str| play[key].as_f64().unwrap();
    within("play, arcsec", (number("mean_arcsec") - 200.0).abs(), 0.5);
    // The play is the same everywhere: its course is no more than noise, and steps of the encoders are 9 and 11 arcsec.
    assert!(number("most_arcsec") - number("least_arcsec") < 2.0);
    assert!(number("std_arcsec") < 1.0);
    let course = play["arcsec"].as_array().unwrap();
    assert_eq!(course.len(), play["angle_deg"].as_array().unwrap().len());
    let drawn = std::fs::read_to_string(&svg).unwrap();
    assert!(drawn.contains("play, arcsec"), "no panel of the play");
    let flanks = found["flanks"].as_array().unwrap();
    assert_eq!(flanks.len(), 2);
    for flank in flanks {
        within(
            "order 1 of each flank, arcsec",
            (amplitude(flank, 1.0) - 8.0).abs(),
            0.1,
        );
        within(
            "order 64 of each flank, arcsec",
            (amplitude(flank, 64.0) - 2.0).abs(),
            0.1,
        );
        let line = &flank["orders"][0];
        assert_eq!(line["mark"], "output");
        // the highest point stands at −ψ: error() has its own at −0.4 rad, and the mark is 0.6 turns on
        let expected = (0.4 + 0.6 * TAU).to_degrees();
        let off = line["phase_from_mark_deg"].as_f64().unwrap() - expected;
        assert!(
            ((off + 180.0).rem_euclid(360.0) - 180.0).abs() < 1.0,
            "{off}"
        );
        let source = &flank["attribution"]["orders"][0]["sources"][0];
        assert!(
            (source["declared"].as_f64().unwrap() - 10.0).abs() < 1e-9,
            "{source}"
        );
        let shafts: Vec<&Value> = flank["mean_turns"].as_array().unwrap().iter().collect();
        assert_eq!(shafts.len(), 2, "{shafts:?}");
    }
    assert_eq!(found["attribution"], flanks[0]["attribution"]);
    for index in found["index"].as_array().unwrap() {
        assert_eq!(index["missing"], 0);
        let a_turn = if index["shaft"] == "input" {
            40_000.0
        } else {
            144_000.0
        };
        assert!(
            (index["counts_apart"].as_f64().unwrap() / a_turn - 1.0).abs() < 1e-3,
            "{index}"
        );
    }
    let text = geardyn(&arguments);
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(
        text.contains("index of the output: passed") && text.contains("from mark of"),
        "{text}"
    );
    let (word, message) = refusal(
        &[
            &arguments[..13],
            &["--output-index", "bz", "--input-index", "bz"],
        ]
        .concat(),
    );
    assert_eq!(word, "usage", "{message}");
    let halved = ["--lines", "20000,72000"];
    let mut wrong = arguments.to_vec();
    wrong.splice(8..10, halved);
    assert_eq!(refusal(&wrong[..14]).0, "ratio-mismatch");
    let (word, _) = refusal(&[&arguments[..10], &["--output-index", "nothing"]].concat());
    assert_eq!(word, "no-channel");
    std::fs::remove_dir_all(folder).unwrap();
}

/// Counters that stand still before and after the motion, where a count goes back and forth, tell what they tell of the motion alone.
#[test]
fn exact_record_that_stands_still_at_its_ends() {
    let folder = folder("still");
    let mut random = fastrand::Rng::with_seed(4);
    let mut counters = |still: [u32; 2], jitter: f64, name: &str| {
        let moving = 20_000;
        let mut text = String::from("time [s],a,b\n");
        for k in 0..still[0] + moving + still[1] {
            let turned = f64::from(k.clamp(still[0], still[0] + moving) - still[0]);
            let turns = 2.2 * turned / f64::from(moving) + 0.0031;
            let rests = k < still[0] || k > still[0] + moving;
            let mut count = |angle: f64, counts: f64| {
                let noise = if rests {
                    jitter * (2.0 * random.f64() - 1.0)
                } else {
                    0.0
                };
                (angle * counts + noise).floor()
            };
            let a = count(turns * 64.0 / 21.0, 40_000.0);
            let b = count(turns + error(turns) / TAU, 144_000.0);
            text += &format!("{:.4},{a},{b}\n", f64::from(k) * 1e-3);
        }
        let path = put(&folder, name, &text);
        document(&[
            "te",
            path.to_str().unwrap(),
            "--input",
            "a",
            "--output",
            "b",
            "--teeth",
            "21:64",
            "--lines",
            "10000,36000",
            "--json",
        ])
    };
    let whole = counters([0, 0], 0.0, "moving.csv");
    assert!(!whole["method_text"].to_string().contains("is at rest"));
    for jitter in [0.5, 0.6] {
        let rested = counters([3000, 5000], jitter, "rested.csv");
        assert_eq!(rested["runs"].as_array().unwrap().len(), 1, "{jitter}");
        let runs = &rested["runs"][0];
        let rows = |key: &str| runs[key].as_f64().unwrap();
        assert!((rows("first_row") - 3000.0).abs() < 20.0, "{runs}");
        assert!((rows("last_row") - 23_000.0).abs() < 20.0, "{runs}");
        let how = rested["method_text"].to_string();
        assert!(
            how.contains("is at rest") && how.contains("counts of the input"),
            "{how}"
        );
        for order in [1.0, 64.0] {
            let (one, other) = (amplitude(&whole, order), amplitude(&rested, order));
            assert!((one - other).abs() < 0.05, "{order}: {one} {other}");
        }
    }
}

/// Tracks at rest, where an edge goes back and forth, had been taken for a shaft that turns back.
#[test]
fn exact_tracks_at_rest() {
    let folder = folder("tracks_at_rest");
    let mut random = fastrand::Rng::with_seed(5);
    let mut text = String::from("time [s],a1 [V],b1 [V],a2 [V],b2 [V]\n");
    for k in 0..50_000_u32 {
        let turned = f64::from(k.clamp(5000, 45_000) - 5000) / 40_000.0;
        let rests = !(5000..=45_000).contains(&k);
        let noise = if rests {
            0.2 * (random.f64() - 0.5)
        } else {
            0.0
        };
        let turns = 2.2 * turned + 0.003;
        let pair = |angle: f64, lines: f64| {
            [0.0, 0.25].map(|s| f64::from((TAU * (lines * angle - s) + noise).sin() > 0.0))
        };
        let a = pair(turns * 64.0 / 21.0, 600.0);
        let b = pair(turns + error(turns) / TAU, 1500.0);
        text += &format!(
            "{:.5},{},{},{},{}\n",
            f64::from(k) * 1e-4,
            a[0],
            a[1],
            b[0],
            b[1]
        );
    }
    let path = put(&folder, "tracks.csv", &text);
    let found = document(&[
        "te",
        path.to_str().unwrap(),
        "--input",
        "a1,b1",
        "--output",
        "a2,b2",
        "--teeth",
        "21:64",
        "--lines",
        "600,1500",
        "--json",
    ]);
    assert!(
        (amplitude(&found, 1.0) - 8.0).abs() < 1.0,
        "{}",
        amplitude(&found, 1.0)
    );
}
