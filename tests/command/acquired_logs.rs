//! Frequency responses from logs as labs take them: several files of one test, clipped and stuck sensors, steps, run-ups.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::command::{document, geardyn, refusal};

fn shipped(name: &str) -> String {
    format!("{}/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The shipped impact test in a file for each hit, 50 ms before it; paths of the files.
fn in_files(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(shipped("spindle_impact.csv")).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let call = ["identify", &shipped("spindle_impact.csv"), "--json"];
    let found = document(&[&call[..], &["--input", "force", "--output", "ax,ay"]].concat());
    let hits = found["hits"].as_array().unwrap();
    let start = |hit: &Value| ((hit["time_s"].as_f64().unwrap() - 0.05) * 5000.0) as usize;
    let mut starts: Vec<usize> = hits.iter().map(start).collect();
    starts.push(rows.len());
    let part = |(k, ends): (usize, &[usize])| {
        let path = folder.join(format!("hit_{}.csv", k + 1));
        let text = format!("{head}\n{}\n", rows[ends[0]..ends[1]].join("\n"));
        fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    starts.windows(2).enumerate().map(part).collect()
}

fn frequencies(found: &Value) -> Vec<(f64, f64)> {
    let number = |m: &Value, key: &str| m[key].as_f64().unwrap();
    let modes = found["modes"].as_array().unwrap();
    let pair = |m: &Value| (number(m, "frequency_hz"), number(m, "frequency_std_hz"));
    modes.iter().map(pair).collect()
}

/// A file a hit, named one by one or by a list, is the test in one file: each hit counts, at the time that the stamps of its file give.
#[test]
fn law_a_test_in_files_is_the_test_in_one() {
    let folder = tempfile::tempdir().unwrap();
    let files = in_files(folder.path());
    let names: Vec<&str> = files.iter().map(String::as_str).collect();
    let what = ["--input", "force", "--output", "ax,ay", "--json"];
    let over = ["--overload", "force=2000"];
    let found = document(&[&["identify"], &names[..], &what, &over].concat());
    let hits = found["hits"].as_array().unwrap();
    assert_eq!(hits.len(), 5);
    let whole = document(&[&["identify"], &[&*shipped("spindle_impact.csv")][..], &what].concat());
    let time = |hit: &Value| hit["time_s"].as_f64().unwrap();
    for (k, (hit, name)) in hits.iter().zip(&names).enumerate() {
        assert_eq!(hit["file"].as_str(), Some(*name));
        assert!((time(hit) - time(&whole["hits"][k])).abs() < 1e-3);
    }
    assert_eq!(found["repairs"][0]["kind"], "files-joined");
    let (one, all) = (frequencies(&found), frequencies(&whole));
    assert_eq!(one.len(), all.len());
    for (a, b) in one.iter().zip(&all) {
        assert!((a.0 - b.0).abs() < 4.0 * a.1.hypot(b.1), "{a:?} {b:?}");
    }
    // The same by a list, whose keys hold for each file.
    let list = folder.path().join("test.toml");
    let quoted: Vec<String> = (1..=5).map(|k| format!("\"hit_{k}.csv\"")).collect();
    let text = format!(
        "[log]\nfiles = [{}]\n\n[[channel]]\nname = \"force\"\noverload = 2000.0\n",
        quoted.join(", ")
    );
    fs::write(&list, text).unwrap();
    let list = list.display().to_string();
    let listed = document(&[&["identify", &list], &what[..]].concat());
    assert_eq!(listed["modes"], found["modes"]);
}

/// A list of logs is checked for their existence: every one that is missing is named, by `check` and by `identify`.
#[test]
fn refuses_a_list_with_missing_logs() {
    let folder = tempfile::tempdir().unwrap();
    let files = in_files(folder.path());
    let list = folder.path().join("test.toml");
    let write = |names: &str| fs::write(&list, format!("[log]\nfiles = [{names}]\n")).unwrap();
    let path = list.display().to_string();
    write("\"hit_1.csv\", \"hit_2.csv\"");
    let whole = document(&["check", &path, "--json"]);
    assert_eq!(
        whole["files"].as_array().map(Vec::len),
        Some(2),
        "{files:?}"
    );
    write("\"hit_1.csv\", \"hit_6.csv\", \"hit_7.csv\"");
    for call in [
        vec!["check", &path],
        vec!["identify", &path, "--input", "force", "--output", "ax"],
    ] {
        let refused = geardyn(&call);
        assert_eq!(refused.status.code(), Some(2), "{call:?}");
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            said.contains("hit_6.csv") && said.contains("hit_7.csv") && said.contains("test.toml"),
            "{said}"
        );
    }
}

/// Files that are not of one test: what differs is named with the file.
#[test]
fn refuses_files_that_are_no_test() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, head: &str, step: f64| {
        let mut text = format!("{head}\n");
        for k in 0..600 {
            let (t, pulse) = (f64::from(k) * step, if k == 100 { 10.0 } else { 0.0 });
            let ring = (0.3 * f64::from(k)).sin() * (-0.01 * f64::from(k)).exp();
            text += &format!("{t:.4},{pulse},{ring:.6}\n");
        }
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let first = write("one.csv", "time [s],f [N],a [m/s²]", 1e-3);
    let cases = [
        (
            write("copy.csv", "time [s],f [N],a [m/s²]", 1e-3),
            "conflict",
            "same samples",
        ),
        (
            write("unit.csv", "time [s],f [N],a [g]", 1e-3),
            "conflict",
            "a has g",
        ),
        (
            write("rate.csv", "time [s],f [N],a [m/s²]", 2e-3),
            "rate-disagrees",
            "500",
        ),
        (
            write("name.csv", "time [s],f [N],b [m/s²]", 1e-3),
            "no-channel",
            "\"a\"",
        ),
    ];
    for (other, code, names) in cases {
        let call = ["identify", &first, &other, "--input", "f", "--output", "a"];
        let (found, message) = refusal(&call);
        assert_eq!(found, code, "{other}: {message}");
        assert!(message.contains(names), "{other}: {message}");
    }
}

/// Five files of a plate are five hits.
/// Source: measured spruce plates of Data-driven-characterization-of-spruce-tonewood-plates (commit 897fe345).
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_five_files_of_a_plate_are_five_hits() {
    let folder = std::env::var("GEARDYN_RECORDINGS").unwrap();
    let hit = |k: i32| format!("{folder}/tonewood_plates/plate_1_hit_{k}.csv.gz");
    let files: Vec<String> = (1..=5).map(hit).collect();
    let names: Vec<&str> = files.iter().map(String::as_str).collect();
    let what = [
        "--input",
        "force",
        "--output",
        "acceleration",
        "--rate",
        "48000",
    ];
    let found = document(
        &[
            &["identify"],
            &names[..],
            &what,
            &["--band", "40:700", "--json"],
        ]
        .concat(),
    );
    let hits = found["hits"].as_array().unwrap();
    assert_eq!(hits.len(), 5);
    assert!(hits.iter().all(|h| h["used"] == true), "{hits:?}");
    assert_eq!(found["averages"], 5.0);
    assert!(found["modes"].as_array().unwrap().len() >= 8);
}

const RATE: f64 = 1000.0;

/// Natural frequencies, Hz, and damping ratios of a simulated structure.
const TRUTH: [(f64, f64); 2] = [(60.0, 0.018), (140.0, 0.015)];

/// Its displacement, N times 10⁻⁴ m, under a force that stays between samples, exactly sampled: `x ← z x + (z − 1)/p · u`, `y = 2 Re Σ x/(2 i ω_d)`.
fn moved(force: &[f64]) -> Vec<f64> {
    let mut states = [(0.0, 0.0); 2];
    let mut next = |u: f64| {
        let mut y = 0.0;
        for ((re, im), (f, d)) in states.iter_mut().zip(TRUTH) {
            let (a, b) = (-d * TAU * f, TAU * f * (1.0 - d * d).sqrt());
            y += 1e4 * *im / b;
            let (grow, turn) = ((a / RATE).exp(), b / RATE);
            let (zr, zi) = (grow * turn.cos(), grow * turn.sin());
            let (gr, gi) = (((zr - 1.0) * a + zi * b), (zi * a - (zr - 1.0) * b));
            let size = a * a + b * b;
            let old = (*re, *im);
            *re = zr * old.0 - zi * old.1 + gr / size * u;
            *im = zr * old.1 + zi * old.0 + gi / size * u;
        }
        y
    };
    force.iter().map(|&u| next(u)).collect()
}

fn normal(random: &mut fastrand::Rng) -> f64 {
    // The sum of twelve uniform numbers is nearly normal with variance 1.
    (0..12).map(|_| random.f64()).sum::<f64>() - 6.0
}

/// A log of force and response with white noise of 0.02 on the response, which `sensor` changes.
fn logged(folder: &Path, force: &[f64], sensor: impl Fn(usize, f64) -> f64) -> String {
    let mut random = fastrand::Rng::with_seed(18);
    let mut text = String::from("time [s],force [N],a [m]\n");
    for (k, (u, y)) in force.iter().zip(moved(force)).enumerate() {
        let y = sensor(k, y + 0.02 * normal(&mut random));
        text += &format!("{:.3},{u:.5},{y:.4}\n", k as f64 / RATE);
    }
    let path = folder.join("log.csv");
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

fn identified(log: &str) -> Value {
    document(&[
        "identify", log, "--input", "force", "--output", "a", "--json",
    ])
}

fn warned(found: &Value, code: &str) -> Option<String> {
    let all = found["warnings"].as_array().unwrap();
    let one = all.iter().find(|w| w["code"] == code)?;
    Some(one["message"].as_str().unwrap().to_string())
}

/// Every mode of the structure within `deviations` of its standard deviations, and no other.
fn assert_truth(found: &Value, deviations: f64) {
    let modes = found["modes"].as_array().unwrap();
    assert_eq!(modes.len(), TRUTH.len(), "{modes:?}");
    for (mode, (f, d)) in modes.iter().zip(TRUTH) {
        let number = |key: &str| mode[key].as_f64().unwrap();
        let off = (number("frequency_hz") - f) / number("frequency_std_hz");
        assert!(off.abs() < deviations, "{f} Hz: {off} of {mode}");
        let off = (number("damping_ratio") - d) / number("damping_std");
        assert!(off.abs() < deviations, "damping {d}: {off} of {mode}");
    }
}

/// A second of noise twenty times as strong, whose response clips: the clipped samples are left out, and it is said. With them no number of
/// poles explained the response, and no mode was found.
#[test]
fn exact_clipped_second_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = fastrand::Rng::with_seed(5);
    let gain = |k: usize| {
        if (10_000..11_000).contains(&k) {
            20.0
        } else {
            1.0
        }
    };
    let force: Vec<f64> = (0..40_000).map(|k| gain(k) * normal(&mut random)).collect();
    let calm = &moved(&force)[..10_000];
    let limit = 5.0 * (calm.iter().map(|y| y * y).sum::<f64>() / 1e4).sqrt();
    let log = logged(folder.path(), &force, |_, y| y.clamp(-limit, limit));
    let found = identified(&log);
    let message = warned(&found, "clipped").unwrap();
    assert!(
        message.contains("a clipped") && message.contains("removed"),
        "{message}"
    );
    assert_truth(&found, 4.0);
    let lines = document(&["spectrum", &log, "--channel", "a", "--json"]);
    assert!(warned(&lines, "clipped").unwrap().contains("levels"));
}

/// A response stuck for a third of the record: the time is named and left out. With it no mode was found.
#[test]
fn exact_stuck_sensor_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = fastrand::Rng::with_seed(7);
    let force: Vec<f64> = (0..40_000).map(|_| normal(&mut random)).collect();
    let log = logged(folder.path(), &force, |k, y| match k {
        12_000..26_000 => 0.5,
        _ => y,
    });
    let found = identified(&log);
    let message = warned(&found, "stuck").unwrap();
    assert!(message.contains("12.0000 to 25.9990 s"), "{message}");
    assert!(message.contains("left out"), "{message}");
    assert_truth(&found, 4.0);
    for command in [&["check", &*log][..], &["spectrum", &log, "--channel", "a"]] {
        let found = document(&[command, &["--json"]].concat());
        assert!(warned(&found, "stuck").unwrap().contains("35.0 %"));
    }
}

/// A run-up from 300 to 1 500 rpm with one pulse a turn: order 3 of amplitude 2 and phase 0.4, order 1 that grows with the speed.
fn run_up(folder: &Path) -> String {
    let mut text = String::from("time [s],ax [g],tacho [V]\n");
    for k in 0..40_000 {
        let t = f64::from(k) / 2000.0;
        // 5 to 25 turns a second in 20 s.
        let (angle, speed) = (TAU * (5.0 * t + 0.5 * t * t), 5.0 + t);
        let ax = 2.0 * (3.0 * angle + 0.4).cos() + 0.04 * speed * angle.sin();
        let pulse = (0.5 + 8.0 * angle.sin()).clamp(0.0, 1.0);
        text += &format!("{t:.4},{ax:.6},{pulse:.4}\n");
    }
    let path = folder.join("run.csv");
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

fn numbers(list: &Value) -> Vec<f64> {
    let all = list.as_array().unwrap().iter();
    all.map(|x| x.as_f64().unwrap()).collect()
}

/// Amplitude and phase of an order over the speed; the zero of the angle is the rising edge of the tacho.
#[test]
fn exact_order_cuts_of_a_run_up() {
    let folder = tempfile::tempdir().unwrap();
    let log = run_up(folder.path());
    let call = ["spectrum", &log, "--channel", "ax", "--tacho", "tacho"];
    let what = ["--kind", "order-cut", "--orders", "3,1"];
    let (csv, svg) = (folder.path().join("c.csv"), folder.path().join("c.svg"));
    let files = [
        "--csv",
        csv.to_str().unwrap(),
        "--svg",
        svg.to_str().unwrap(),
    ];
    let found = document(&[&call[..], &what, &files, &["--json"]].concat());
    let speed = numbers(&found["speed_rpm"]);
    assert!(speed.windows(2).all(|w| w[0] < w[1]));
    assert!(
        speed[0] < 500.0 && speed[speed.len() - 1] > 1400.0,
        "{speed:?}"
    );
    let cut = &found["cuts"][0];
    for amplitude in numbers(&cut["amplitude"]) {
        assert!((amplitude - 2.0).abs() < 0.01, "{amplitude}");
    }
    for phase in numbers(&cut["phase_rad"]) {
        assert!((phase - 0.4).abs() < 0.02, "{phase}");
    }
    // Order 1 grows with the speed and follows by a quarter turn.
    let first = &found["cuts"][1];
    let both = numbers(&first["amplitude"])
        .into_iter()
        .zip(numbers(&first["phase_rad"]));
    for ((amplitude, phase), speed) in both.zip(&speed) {
        assert!(
            (amplitude / (0.04 * speed / 60.0) - 1.0).abs() < 0.02,
            "{amplitude}"
        );
        assert!((phase + 0.5 * std::f64::consts::PI).abs() < 0.05, "{phase}");
    }
    let largest = first["largest"]["speed_rpm"].as_f64().unwrap();
    assert!(largest > 1400.0, "{largest}");
    let text = fs::read_to_string(&csv).unwrap();
    assert!(text.starts_with("time_s,speed_rpm,"), "{text:.90}");
    assert_eq!(text.lines().count(), speed.len() + 1);
    assert!(fs::read_to_string(&svg).unwrap().contains("speed, rpm"));
    let (code, message) =
        refusal(&[&call[..], &["--kind", "order-cut", "--orders", "60"]].concat());
    assert!(
        code == "out-of-range" && message.contains("order 60"),
        "{message}"
    );
}

/// The speed–frequency map of a run-up: each row has its speed, and its strongest line lies on the order.
#[test]
fn exact_map_over_speed() {
    let folder = tempfile::tempdir().unwrap();
    let log = run_up(folder.path());
    let svg = folder.path().join("map.svg");
    let found = document(&[
        "spectrum",
        &log,
        "--channel",
        "ax",
        "--tacho",
        "tacho",
        "--kind",
        "spectrogram",
        "--resolution",
        "4",
        "--svg",
        svg.to_str().unwrap(),
        "--json",
    ]);
    let lines = numbers(&found["frequency_hz"]);
    let rows = found["channels"][0]["rows"].as_array().unwrap();
    assert!(rows.len() > 50);
    for row in rows {
        let value = numbers(&row["value"]);
        let top = (0..value.len())
            .max_by(|&a, &b| value[a].total_cmp(&value[b]))
            .unwrap();
        let order = lines[top] / (row["speed_rpm"].as_f64().unwrap() / 60.0);
        assert!((order - 3.0).abs() < 0.4, "order {order}");
    }
    assert!(fs::read_to_string(&svg).unwrap().contains("speed, rpm"));
}

/// A force that steps up, and one released soon after the record begins, are no hammers: the responses come from the steps.
#[test]
fn exact_steps_and_releases() {
    let folder = tempfile::tempdir().unwrap();
    let ramp = |k: usize, at: usize| ((k as f64 - at as f64) / 3.0).clamp(0.0, 1.0);
    let step: Vec<f64> = (0..8000).map(|k| 50.0 * ramp(k, 2000)).collect();
    let both: Vec<f64> = (0..12_000)
        .map(|k| 50.0 * (ramp(k, 2000) - ramp(k, 7000)))
        .collect();
    // Loaded for long before the record begins, released after 0.3 s.
    let released: Vec<f64> = (0..28_000)
        .map(|k| 50.0 * (ramp(k, 100) - ramp(k, 20_300)))
        .collect();
    for (force, from, steps) in [(step, 0, 1), (both, 0, 2), (released, 20_000, 1)] {
        let log = logged(folder.path(), &force, |_, y| y);
        let text = fs::read_to_string(&log).unwrap();
        let (head, rows) = text.split_once('\n').unwrap();
        let kept: Vec<&str> = rows.lines().skip(from).collect();
        fs::write(&log, format!("{head}\n{}\n", kept.join("\n"))).unwrap();
        let found = identified(&log);
        let how = found["method_text"].as_str().unwrap();
        assert!(how.contains(&format!("{steps} step")), "{how}");
        match steps {
            1 => assert_truth(&found, 5.0),
            // Two records tell too little of their scatter for a count of modes.
            _ => {
                let modes = frequencies(&found);
                let near = |f: f64| modes.iter().any(|m| (m.0 / f - 1.0).abs() < 1e-3);
                assert!(TRUTH.iter().all(|t| near(t.0)), "{modes:?}");
            }
        }
    }
}

/// A grid at 49.97 Hz with its third multiple, beside a line that is none.
#[test]
fn exact_mains_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = fastrand::Rng::with_seed(50);
    let mut text = String::from("time [s],a [m/s²]\n");
    for k in 0..20_000 {
        let t = f64::from(k) / RATE;
        let tone = |f: f64| (TAU * f * t).sin();
        let a = 0.3 * tone(49.97) + 0.2 * tone(149.91) + 0.5 * tone(123.4);
        text += &format!("{t:.3},{:.4}\n", a + 0.1 * normal(&mut random));
    }
    let path = folder.path().join("pick_up.csv");
    fs::write(&path, text).unwrap();
    let call = [
        "spectrum",
        path.to_str().unwrap(),
        "--channel",
        "a",
        "--json",
    ];
    let found = document(&call);
    let peaks = found["channels"][0]["peaks"].as_array().unwrap();
    let names: Vec<String> = peaks.iter().map(|p| p["names"].to_string()).collect();
    assert_eq!(
        names[..3],
        ["[]", "[\"mains 50 Hz\"]", "[\"3 × mains 50 Hz\"]"]
    );
}
