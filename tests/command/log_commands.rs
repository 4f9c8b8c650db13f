//! What `check` and `convert` keep of a log: its gaps, its times, the sidecar somebody wrote.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn geardyn(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Standard output and what is said beside; the exit code is as expected.
fn said(folder: &Path, arguments: &[&str], code: i32) -> (String, String) {
    let output = geardyn(folder, arguments);
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(
        output.status.code(),
        Some(code),
        "{arguments:?}\n{out}{err}"
    );
    (out, err)
}

fn document(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&said(folder, arguments, 0).0).unwrap()
}

/// `time [s],a [V]` at 1 kHz with three decimals, without the rows that `lost` names.
fn log(folder: &Path, name: &str, lost: impl Fn(usize) -> bool) {
    let mut text = String::from("time [s],a [V]\n");
    for k in (0..4000).filter(|&k| !lost(k)) {
        let t = k as f64 * 1e-3;
        writeln!(text, "{t:.3},{:.4}", (77.0 * t).sin()).unwrap();
    }
    fs::write(folder.join(name), text).unwrap();
}

fn times(path: &Path) -> Vec<f64> {
    let text = fs::read_to_string(path).unwrap();
    let rows = text.lines().skip(1);
    rows.map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect()
}

/// Gaps of many samples and of one are kept where the log is written again, and refused where they have no place.
#[test]
fn exact_times_are_kept_over_gaps() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder, "g.csv", |k| (1000..1500).contains(&k) || k == 2500);
    let found = document(folder, &["check", "g.csv", "--json"]);
    assert_eq!(found["rate_hz"], 1000.0);
    let begins: Vec<&Value> = found["segments"].as_array().unwrap().iter().collect();
    let begins: Vec<f64> = begins
        .iter()
        .map(|s| s["from_s"].as_f64().unwrap())
        .collect();
    assert_eq!(begins, [0.0, 1.5, 2.501]);
    said(folder, &["convert", "g.csv", "--to", "h.csv"], 0);
    assert_eq!(times(&folder.join("h.csv")), times(&folder.join("g.csv")));
    let again = document(folder, &["check", "h.csv", "--json"]);
    assert_eq!(again["segments"], found["segments"]);
    said(folder, &["convert", "g.csv", "--to", "h.json"], 0);
    let json: Value = serde_json::from_slice(&fs::read(folder.join("h.json")).unwrap()).unwrap();
    assert_eq!(json["segments"], found["segments"]);
    let (_, err) = said(folder, &["convert", "g.csv", "--to", "h.uff"], 2);
    assert!(
        err.contains("3 segments") && err.contains("--fill-gaps"),
        "{err}"
    );
    said(
        folder,
        &["convert", "g.csv", "--to", "h.uff", "--fill-gaps"],
        0,
    );
    assert_eq!(
        document(folder, &["check", "h.uff", "--json"])["samples"],
        4000
    );
}

/// A part of a log keeps the times it has in the whole, also behind a gap.
#[test]
fn exact_times_of_a_part() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder, "g.csv", |k| (1000..1500).contains(&k));
    let part = [
        "convert", "g.csv", "--to", "p.csv", "--after", "2", "--before", "3",
    ];
    said(folder, &part, 0);
    let times = times(&folder.join("p.csv"));
    assert_eq!((times.len(), times[0], times[999]), (1000, 2.0, 2.999));
}

/// The date of the first sample is said, and kept where there is a place for it.
#[test]
fn exact_start_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut text = String::from("time,a [g]\n");
    for k in 0..200 {
        writeln!(
            text,
            "2022-11-04T08:36:{:02}.{:02},{}",
            k / 100,
            k % 100,
            k % 7
        )
        .unwrap();
    }
    fs::write(folder.join("d.csv"), text).unwrap();
    let start = "2022-11-04T08:36:00.00";
    let (_, err) = said(folder, &["convert", "d.csv", "--to", "e.csv"], 0);
    assert!(err.contains(start), "{err}");
    said(folder, &["convert", "d.csv", "--to", "e.uff"], 0);
    assert_eq!(
        document(folder, &["check", "e.uff", "--json"])["start"],
        start
    );
}

/// Filling a gap a thousand times as long as the log is refused.
#[test]
fn refuses_to_fill_what_is_nearly_all_gap() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("time [s],a\n");
    for k in 0..200 {
        let t = k as f64 * 1e-3 + if k < 100 { 0.0 } else { 3e7 };
        writeln!(text, "{t:.3},{k}").unwrap();
    }
    fs::write(folder.path().join("y.csv"), text).unwrap();
    said(folder.path(), &["check", "y.csv"], 0);
    let (_, err) = said(folder.path(), &["check", "y.csv", "--fill-gaps"], 2);
    assert!(err.contains("[out-of-range]"), "{err}");
}

/// A file that lies where the sidecar would go is left alone.
#[test]
fn refuses_to_overwrite_what_lies_beside() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder, "a.csv", |_| false);
    said(folder, &["check", "a.csv", "--write"], 0);
    let written = fs::read_to_string(folder.join("a.toml")).unwrap();
    for key in ["time_unit", "time", "decimal", "delimiter"] {
        assert!(written.contains(&format!("\n{key} = ")), "{key}\n{written}");
    }
    let mine = format!("title = \"mine\"\n{written}");
    fs::write(folder.join("a.toml"), &mine).unwrap();
    let (_, err) = said(folder, &["check", "a.csv", "--write"], 2);
    assert!(err.contains("a.toml exists"), "{err}");
    assert_eq!(fs::read_to_string(folder.join("a.toml")).unwrap(), mine);
}

/// A sidecar counts with [[channel]] alone, a broken one is an error with its place, and any other file is said to be none.
#[test]
fn law_what_lies_beside_is_read_or_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder, "a.csv", |_| false);
    let beside = |text: &str| fs::write(folder.join("a.toml"), text).unwrap();
    beside("[[channel]]\nname = \"a\"\nsensitivity = \"100 mV/g\"\n");
    let found = document(folder, &["check", "a.csv", "--json"]);
    assert_eq!(found["channels"][0]["unit"], "g");
    for command in [
        &["check", "a.csv"][..],
        &["spectrum", "a.csv", "--channel", "a"],
        &["convert", "a.csv", "--to", "b.csv"],
    ] {
        let (_, err) = said(folder, command, 0);
        assert!(err.contains("read a.toml"), "{command:?}: {err}");
    }
    beside("[log\n");
    let output = geardyn(folder, &["check", "a.csv", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let error = &found["errors"][0];
    assert_eq!(
        (&error["code"], &error["line"]),
        (&"syntax".into(), &1.into())
    );
    beside("foo = 1\n");
    let (_, err) = said(folder, &["check", "a.csv"], 0);
    assert!(err.contains("a.toml contains neither"), "{err}");
}

/// Of several files each error names its own.
#[test]
fn exact_file_of_each_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["a.csv", "b.csv"] {
        fs::write(folder.join(name), "x,y\n1,2\n3,5\n2,7\n").unwrap();
    }
    let (_, err) = said(folder, &["check", "a.csv", "b.csv"], 2);
    assert!(
        err.contains("--> a.csv") && err.contains("--> b.csv"),
        "{err}"
    );
    let output = geardyn(folder, &["check", "a.csv", "b.csv", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["files"][1]["errors"][0]["file"], "b.csv");
    assert!(found["geardyn"]["version"].is_string());
    let names = ["a.csv", "b.csv"].map(Value::from);
    assert_eq!(
        [&found["files"][0]["file"], &found["files"][1]["file"]],
        [&names[0], &names[1]]
    );
    let (_, err) = said(
        folder,
        &["spectrum", "a.csv", "--channel", "z", "--rate", "10"],
        2,
    );
    assert!(err.contains("--> a.csv") && !err.contains("1 |"), "{err}");
}

/// Files of spectra are listed and their peaks found; nothing else is made of them.
#[test]
fn exact_peaks_of_spectra_in_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut text = String::from(
        "LabVIEW Measurement\t\nSeparator\tTab\nMulti_Headings\tYes\nX_Columns\tOne\n***End_of_Header***\t\n\t\n\
         Channels\t1\t\nSamples\t1000\t\nY_Unit_Label\tg\t\nX_Dimension\tFrequency\t\nX0\t0.0E+0\t\nDelta_X\t0.100000\t\n\
         ***End_of_Header***\t\t\nX_Value\tacc (FFT - (RMS))\tComment\n",
    );
    for k in 0..1000 {
        let level = if k == 415 {
            -20.0
        } else {
            -90.0 - 3.0 * ((k * k) as f64).sin()
        };
        writeln!(text, "{:.6}\t{level:.6}", k as f64 * 0.1).unwrap();
    }
    fs::write(folder.join("s.lvm"), text).unwrap();
    let found = document(folder, &["check", "s.lvm", "--json"]);
    assert_eq!(found["spectra"][0]["lines"], 1000);
    let name = found["spectra"][0]["name"].as_str().unwrap().to_string();
    let found = document(folder, &["spectrum", "s.lvm", "--channel", &name, "--json"]);
    let peak = &found["channels"][0]["peaks"][0];
    assert!(
        (peak["frequency_hz"].as_f64().unwrap() - 41.5).abs() < 0.05,
        "{peak}"
    );
    assert!(
        (peak["amplitude"].as_f64().unwrap() - 0.1).abs() < 0.01,
        "{peak}"
    );
    let (_, err) = said(
        folder,
        &["spectrum", "s.lvm", "--channel", &name, "--kind", "rms"],
        2,
    );
    assert!(err.contains("contains spectra"), "{err}");
    let (_, err) = said(folder, &["convert", "s.lvm", "--to", "s.csv"], 2);
    assert!(
        err.contains("contains spectra") && err.contains("geardyn spectrum"),
        "{err}"
    );
}

/// A time that counts in whole numbers without a unit is in doubt, and a unit that is none of time is refused.
#[test]
fn law_units_of_time_are_not_guessed_in_silence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let rows: String = (0..50).map(|k| format!("{k},{}\n", k * k % 7)).collect();
    fs::write(folder.join("t.csv"), format!("t,a\n{rows}")).unwrap();
    let codes = |arguments: &[&str]| -> Vec<String> {
        let found = document(folder, arguments);
        let all = found["warnings"].as_array().unwrap().iter();
        all.map(|w| w["code"].as_str().unwrap().to_string())
            .collect()
    };
    assert_eq!(codes(&["check", "t.csv", "--json"]), ["time-guessed"]);
    let stated = ["check", "t.csv", "--json", "--time-unit", "ms"];
    assert_eq!(codes(&stated), [""; 0]);
    assert_eq!(document(folder, &stated)["rate_hz"], 1000.0);
    let (_, err) = said(folder, &["check", "t.csv", "--time-unit", "kg"], 2);
    assert!(err.contains("no unit of time"), "{err}");
    fs::write(folder.join("u.csv"), format!("time [kg],a\n{rows}")).unwrap();
    assert_eq!(codes(&["check", "u.csv", "--json"]), ["time-guessed"]);
}

/// What is said twice or of a name that is taken is refused.
#[test]
fn refuses_names_that_cannot_be_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(
        folder.join("a.csv"),
        "t [s],ax,ay\n0.0,1,2\n0.1,2,1\n0.2,1,1\n",
    )
    .unwrap();
    for (sidecar, code) in [
        ("[[channel]]\nname = \"ax\"\nrename = \"ay\"\n", "conflict"),
        (
            "[[channel]]\nname = \"ax\"\nrename = \" \"\n",
            "out-of-range",
        ),
        (
            "[[channel]]\nname = \"ax\"\n[[channel]]\nname = \"ax\"\n",
            "conflict",
        ),
    ] {
        fs::write(folder.join("a.toml"), sidecar).unwrap();
        let (_, err) = said(folder, &["check", "a.csv"], 2);
        assert!(err.contains(&format!("[{code}]")), "{sidecar}\n{err}");
    }
    let swap = "[[channel]]\nname = \"ax\"\nrename = \"ay\"\n[[channel]]\nname = \"ay\"\nrename = \"ax\"\n";
    fs::write(folder.join("a.toml"), swap).unwrap();
    said(folder, &["check", "a.csv"], 0);
}

/// Outputs are tried before anything is computed: their folder, and that no two are one file.
#[test]
fn refuses_outputs_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder, "a.csv", |_| false);
    fs::write(folder.join("kept.csv"), "mine").unwrap();
    let spectrum = ["spectrum", "a.csv", "--channel", "a", "--csv"];
    for svg in [
        &["kept.csv", "--svg", "none/b.svg"][..],
        &["new.svg", "--svg", "./new.svg"],
    ] {
        said(folder, &[&spectrum[..], svg].concat(), 2);
    }
    assert_eq!(fs::read_to_string(folder.join("kept.csv")).unwrap(), "mine");
    assert!(!folder.join("new.svg").exists());
}

/// Names of a log cannot command the terminal; a usage error in JSON names what is missing.
#[test]
fn law_what_is_printed_is_whole_and_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let rows: String = (0..90).map(|k| format!("{}.0,{}\n", k, k % 7)).collect();
    fs::write(folder.join("e.csv"), format!("t [s],\u{1b}[31mred\n{rows}")).unwrap();
    assert!(!said(folder, &["check", "e.csv"], 0).0.contains('\u{1b}'));
    let output = geardyn(folder, &["spectrum", "e.csv", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let message = found["errors"][0]["message"].as_str().unwrap();
    assert!(message.contains("--channel"), "{message}");
    assert!(
        said(folder, &["explain", "few-averages"], 0)
            .0
            .contains("Variance")
    );
}

/// Every word of a warning or a repair in the sources has its explanation.
#[test]
fn law_every_remark_is_explained() {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    let mut unknown = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = fs::read_to_string(&path).unwrap();
            let dense: String = text.split_whitespace().collect();
            for mark in [
                "code:\"",
                "Repair{kind:\"",
                "say(\"",
                "warn(\"",
                "warning(\"",
                "note(raw,\"",
                "repair(\"",
            ] {
                for rest in dense.split(mark).skip(1) {
                    let word = rest.split('"').next().unwrap();
                    let plain = word.bytes().all(|b| b.is_ascii_lowercase() || b == b'-');
                    // A kind of what a file holds, not of a remark.
                    let known = word == "spectrum"
                        || geardyn::internals::base::diagnostic::DIAGNOSTICS
                            .iter()
                            .any(|r| r.0 == word);
                    if plain && !word.is_empty() && !known {
                        unknown.push(format!("{}: {word}", path.display()));
                    }
                }
            }
        }
    }
    assert_eq!(unknown, [""; 0]);
}

/// A sidecar holds what was understood of its log, and the log reads with it as it did without.
#[test]
fn keeps_what_was_understood_in_the_sidecar() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut text = String::from("Zeit [ms];Kraft [N];x\n");
    for k in 0..200 {
        writeln!(text, "{k},5;{},25;{}", k % 7, k % 5).unwrap();
    }
    fs::write(at.join("a.csv"), text).unwrap();
    let before = document(at, &["check", "a.csv", "--json"]);
    said(at, &["check", "a.csv", "--write"], 0);
    let sidecar = fs::read_to_string(at.join("a.toml")).unwrap();
    for line in [
        "delimiter = \";\"",
        "decimal = \",\"",
        "time = \"Zeit\"",
        "time_unit = \"ms\"",
        "rate_from = \"time\"",
        "header_lines = 1",
        "unit = \"N\"",
    ] {
        assert!(sidecar.contains(line), "{line}\n{sidecar}");
    }
    assert!(
        !sidecar.contains("mV/g") && !sidecar.contains("latin1"),
        "{sidecar}"
    );
    let after = document(at, &["check", "a.csv", "--json"]);
    for key in ["rate_hz", "samples", "channels"] {
        assert_eq!(before[key], after[key], "{key}");
    }
    said(at, &["check", "a.csv", "--write"], 2);
}

/// Where stamps run back, the line is named.
#[test]
fn refuses_stamps_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("a.csv"),
        "t [s],a\n0.0,1\n0.1,2\n0.2,3\n0.1,4\n",
    )
    .unwrap();
    let (_, err) = said(folder.path(), &["check", "a.csv"], 2);
    assert!(err.contains("a.csv:5"), "{err}");
    let output = geardyn(folder.path(), &["check", "a.csv", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["errors"][0]["line"], 5);
}

/// A pipe that nobody reads is no output.
#[cfg(unix)]
#[test]
fn refuses_a_pipe_as_output() {
    let folder = tempfile::tempdir().unwrap();
    log(folder.path(), "a.csv", |_| false);
    let made = Command::new("mkfifo")
        .arg(folder.path().join("o.csv"))
        .status();
    if made.is_ok_and(|s| s.success()) {
        said(folder.path(), &["convert", "a.csv", "--to", "o.csv"], 2);
    }
}

/// The part used begins at the trigger less the pre-trigger, also where another channel is converted; a level never reached is said.
#[test]
fn exact_trigger() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut text = String::from("t [s],force [N],a [g]\n");
    for k in 0..2000 {
        let force = if k >= 1234 { -7.5 } else { 0.1 };
        writeln!(text, "{:.3},{force},{}", f64::from(k) * 1e-3, k % 9).unwrap();
    }
    fs::write(at.join("a.csv"), text).unwrap();
    let (_, err) = said(
        at,
        &[
            "convert",
            "a.csv",
            "--to",
            "o.csv",
            "--channel",
            "a",
            "--trigger",
            "force=5",
            "--pre-trigger",
            "0.034",
        ],
        0,
    );
    assert!(err.contains("triggered"), "{err}");
    let kept = times(&at.join("o.csv"));
    assert_eq!((kept.len(), kept[0]), (800, 1.2));
    let head = fs::read_to_string(at.join("o.csv")).unwrap();
    assert!(!head.lines().next().unwrap().contains("force"), "{head}");
    said(at, &["check", "a.csv", "--trigger", "force=9"], 2);
}
