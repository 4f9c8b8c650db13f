//! Logs that cannot be used: each is refused with a word, a place where there is one, and exit code 2; nothing panics.
#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Runs `command` on a file with these bytes and returns code, message and line of its first error.
fn refused(name: &str, bytes: &[u8], command: &[&str]) -> (String, String, Option<u64>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    refused_at(&path, command)
}

fn refused_at(path: &Path, command: &[&str]) -> (String, String, Option<u64>) {
    let output = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .arg(command[0])
        .arg(path)
        .args(&command[1..])
        .arg("--json")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(
        output.status.code(),
        Some(2),
        "{command:?}: {said}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found: Value = serde_json::from_str(&said).unwrap();
    let error = &found["errors"][0];
    (
        error["code"].as_str().unwrap().to_string(),
        error["message"].as_str().unwrap().to_string(),
        error["line"].as_u64(),
    )
}

/// `time,force,a` at 1 kHz, with whatever a test makes of row `at`.
fn rows(count: usize, at: usize, wrong: &str) -> String {
    let mut text = String::from("time [s],force [N],a [m/s²]\n");
    for k in 0..count {
        if k == at {
            text += wrong;
            text.push('\n');
        } else {
            let t = k as f64 * 1e-3;
            writeln!(
                text,
                "{t:.3},{:.4},{:.4}",
                (91.0 * t).sin(),
                (77.0 * t).cos()
            )
            .unwrap();
        }
    }
    text
}

const IDENTIFY: &[&str] = &["identify", "--input", "force", "--output", "a"];

#[test]
fn refuses_what_holds_no_samples() {
    for (bytes, code) in [
        (&b""[..], "empty-log"),
        (b"\n\n\n", "empty-log"),
        (b"time,force,a\n", "empty-log"),
        (b"\x00\x01\x02\xff\xfe\xfd junk \x00\x00", "unknown-format"),
    ] {
        let (found, message, _) = refused("log.csv", bytes, &["check"]);
        assert_eq!(found, code, "{message}");
    }
    let (code, message, _) = refused("log.csv.gz", b"", &["check"]);
    assert!(
        ["broken-file", "empty-log"].contains(&code.as_str()),
        "{message}"
    );
    let (code, message, _) = refused("log.csv.gz", b"\x1f\x8b\x08\x00", &["check"]);
    assert_eq!(code, "broken-file", "{message}");
}

#[test]
fn refuses_rows_that_do_not_fit() {
    let (code, message, line) =
        refused("log.csv", rows(60, 30, "0.030,1.0").as_bytes(), &["check"]);
    assert_eq!((code.as_str(), line), ("ragged-row", Some(32)), "{message}");
    let (code, message, line) = refused(
        "log.csv",
        rows(60, 30, "0.030,1.0,2.0,3.0").as_bytes(),
        &["check"],
    );
    assert_eq!((code.as_str(), line), ("ragged-row", Some(32)), "{message}");
    let (code, message, line) = refused(
        "log.csv",
        rows(60, 30, "0.030,twelve,2.0").as_bytes(),
        &["check"],
    );
    assert_eq!(
        (code.as_str(), line),
        ("not-a-number", Some(32)),
        "{message}"
    );
}

#[test]
fn refuses_time_that_does_not_run_on() {
    for wrong in ["0.029,1.0,2.0", "0.010,1.0,2.0"] {
        let (code, message, _) = refused("log.csv", rows(60, 30, wrong).as_bytes(), &["check"]);
        assert_eq!(code, "bad-time");
        assert!(message.contains("line 32"), "{message}");
    }
}

#[test]
fn refuses_too_little() {
    let (code, message, _) = refused("log.csv", rows(1, 9, "").as_bytes(), &["check"]);
    assert!(
        ["too-short", "rate-unknown"].contains(&code.as_str()),
        "{message}"
    );
    let (code, message, _) = refused("log.csv", rows(5, 9, "").as_bytes(), IDENTIFY);
    assert_eq!(code, "too-short", "{message}");
    let (code, message, _) = refused("log.csv", b"1.0\n2.0\n3.0\n1.5\n", &["check"]);
    assert_eq!(code, "rate-unknown", "{message}");
}

#[test]
fn refuses_channels_without_signal() {
    let constant = |text: &str| -> String {
        let mut all = String::from("time [s],force [N],a [m/s²]\n");
        for k in 0..4000 {
            let t = f64::from(k) * 1e-3;
            writeln!(all, "{t:.3},{text},{:.4}", (77.0 * t).cos()).unwrap();
        }
        all
    };
    for silent in ["0", "2.5", "NaN", ""] {
        let (code, message, _) = refused("log.csv", constant(silent).as_bytes(), IDENTIFY);
        assert_eq!(code, "no-signal", "force \"{silent}\": {message}");
        assert!(message.contains("force"), "{message}");
        if silent == "NaN" {
            assert!(message.contains("holds no number"), "{message}");
        }
    }
}

/// What is asked for cannot be done, or would do nothing: said at once, with the remedy.
#[test]
fn refuses_what_is_asked_in_vain() {
    let mut text = String::from("time [s],force [N],a [m/s²]\n");
    let mut large = text.clone();
    let mut rng = fastrand::Rng::with_seed(3);
    for k in 0..2000 {
        let (t, f, a) = (f64::from(k) * 1e-3, rng.f64() - 0.5, rng.f64() - 0.5);
        writeln!(text, "{t:.3},{f:.5},{a:.5}").unwrap();
        writeln!(large, "{t:.3},{f:.5}e290,{a:.5}").unwrap();
    }
    let alone: &[&str] = &["identify", "--output", "a"];
    let with: &[&str] = IDENTIFY;
    let cases: [(&[&str], &[&str], &str, &str); 7] = [
        (with, &["--order", "9999"], "out-of-range", "500"),
        (
            with,
            &["--method", "plscf", "--delay", "common"],
            "usage",
            "--delay",
        ),
        (
            with,
            &["--method", "lsce", "--allow-unstable"],
            "usage",
            "--allow-unstable",
        ),
        (alone, &["--kind", "mobility"], "usage", "--kind"),
        (with, &["--rate", "1e300"], "out-of-range", "sample rate"),
        (with, &["--rate", "0"], "out-of-range", "sample rate"),
        (with, &["--band", "600:900"], "out-of-range", "500 Hz"),
    ];
    for (command, more, expected, word) in cases {
        let (code, message, _) = refused("log.csv", text.as_bytes(), &[command, more].concat());
        assert_eq!(code, expected, "{more:?}: {message}");
        assert!(message.contains(word), "{more:?}: {message}");
    }
    let (code, message, _) = refused("log.csv", large.as_bytes(), IDENTIFY);
    assert_eq!(code, "out-of-range", "{message}");
    assert!(
        message.contains("force") && message.contains("e28"),
        "{message}"
    );
}

/// Files of bytes have no line to point at; which file is meant is said all the same, for the terminal and in JSON.
#[test]
fn refuses_broken_bytes_by_the_name_of_the_file() {
    let mut wav = b"RIFF\x24\x00\x00\x00WAVEfmt \x10\x00\x00\x00\x01\x00\x01\x00".to_vec();
    wav.extend(b"\x40\x1f\x00\x00\x80\x3e\x00\x00\x02\x00\x10\x00data\xff\x00\x00\x00\x01");
    let mut mat = b"MATLAB 5.0 MAT-file".to_vec();
    mat.resize(100, b' ');
    for (name, bytes) in [("hall.wav", wav), ("rig.mat", mat)] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), bytes).unwrap();
        for json in [false, true] {
            let output = Command::new(env!("CARGO_BIN_EXE_geardyn"))
                .args(["check", name])
                .args(json.then_some("--json"))
                .current_dir(folder.path())
                .output()
                .unwrap();
            assert_eq!(output.status.code(), Some(2), "{name}");
            let said = [output.stdout, output.stderr].concat();
            let said = String::from_utf8(said).unwrap();
            let expected = match json {
                true => format!("\"file\": \"{name}\""),
                false => format!("--> {name}\n"),
            };
            assert!(
                said.contains(&expected) && said.contains("broken-file"),
                "{said}"
            );
        }
    }
}

#[test]
fn refuses_names_that_are_not_there() {
    let text = rows(4000, 9000, "");
    let (code, message, _) = refused(
        "log.csv",
        text.as_bytes(),
        &["identify", "--input", "forse", "--output", "a"],
    );
    assert_eq!(code, "no-channel", "{message}");
    let (code, message, _) = refused(
        "log.csv",
        text.as_bytes(),
        &["identify", "--input", "force", "--output", "force"],
    );
    assert!(["conflict", "usage"].contains(&code.as_str()), "{message}");
    let (code, _, _) = refused_at(Path::new("nowhere/at/all.csv"), &["check"]);
    assert_eq!(code, "file-missing");
}

#[test]
fn refuses_an_input_that_is_the_output() {
    let mut text = String::from("time [s],force [N],a [m/s²]\n");
    let mut random = fastrand::Rng::with_seed(1);
    for k in 0..4000 {
        let x = random.f64() - 0.5;
        writeln!(text, "{:.3},{x},{x}", f64::from(k) * 1e-3).unwrap();
    }
    let (code, message, _) = refused("log.csv", text.as_bytes(), IDENTIFY);
    assert_eq!(code, "conflict", "{message}");
}

/// A log whose last number may have been cut short is refused.
#[test]
fn refuses_a_universal_file_cut_within_its_last_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    fs::write(&path, rows(99, usize::MAX, "")).unwrap();
    let whole = folder.path().join("a.uff");
    let done = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args([
            "convert".as_ref(),
            path.as_os_str(),
            "--to".as_ref(),
            whole.as_os_str(),
        ])
        .output()
        .unwrap();
    assert!(done.status.success());
    let bytes = fs::read(&whole).unwrap();
    let cut = &bytes[..bytes.len() - 11];
    let (code, message, _) = refused("cut.uff", cut, &["check"]);
    assert!(
        code == "broken-file" && message.contains("cut short"),
        "{message}"
    );
}

/// Commas that part cells and stand in numbers, stamps that are all equal or leap, rows that only seem to be a footer.
#[test]
fn refuses_what_reads_as_something_else() {
    let doubled: String = (0..40)
        .map(|k| format!("0,{k:03},12,{k},3,{k}\n"))
        .collect();
    let equal: String = (0..40).map(|k| format!("1.5,{k}\n")).collect();
    let leaping: String = (0..300)
        .map(|k| format!("{:.6},{}\n", 10f64.powf(0.05 * f64::from(k)), k % 7))
        .collect();
    let mut broken = rows(100, usize::MAX, "");
    (0..50).for_each(|k| broken += &format!("x,{k},{k}\n"));
    for (name, text, code) in [
        (
            "cc.csv",
            format!("Zeit [s],Kraft [N],a [g]\n{doubled}"),
            "ragged-row",
        ),
        ("eq.csv", format!("t [s],a\n{equal}"), "bad-time"),
        ("log.csv", format!("t [s],a\n{leaping}"), "bad-time"),
        ("foot.csv", broken, "not-a-number"),
        (
            "back.csv",
            "{\"rate_hz\": 5}\n".to_string(),
            "unknown-format",
        ),
    ] {
        let (found, message, _) = refused(name, text.as_bytes(), &["check"]);
        assert_eq!(found, code, "{name}: {message}");
    }
}

/// Pulses that do not make one turn ask whether their number a turn is right.
#[test]
fn refuses_fewer_pulses_than_a_turn() {
    let mut text = String::from("time [s],tacho [V],a [g]\n");
    for k in 0..4000 {
        let on = if k % 200 < 20 { 5.0 } else { 0.0 };
        writeln!(text, "{:.3},{on},{}", f64::from(k) * 1e-3, k % 7).unwrap();
    }
    let order = [
        "spectrum",
        "--channel",
        "a",
        "--kind",
        "order",
        "--tacho",
        "tacho",
        "--pulses",
        "60",
    ];
    let (code, message, _) = refused("t.csv", text.as_bytes(), &order);
    assert!(
        code == "too-short" && message.contains("less than one turn"),
        "{message}"
    );
}

/// A sample rate that is there and cannot be read is shown, not passed over; nor is one taken without the unit that follows it.
#[test]
fn refuses_unreadable_rates_with_their_line() {
    for text in ["5 kHz/ch", "-5 Hz", "5 rpm", "1/5000 s"] {
        let mut log = format!("Device: x\nSample rate: {text}\na,b\n");
        (0..50).for_each(|k| writeln!(log, "{}.5,{}", k % 7, k % 5).unwrap());
        let (code, message, line) = refused("log.csv", log.as_bytes(), &["check"]);
        assert_eq!(
            (code.as_str(), line),
            ("rate-unknown", Some(2)),
            "{message}"
        );
        assert!(message.contains("Sample rate"), "{message}");
    }
}

/// Stamps that leap further than any recorder runs, and rates that none has.
#[test]
fn refuses_leaps_and_rates_beyond_all_recorders() {
    let mut log = String::from("t [s],a\n");
    (0..200).for_each(|k| writeln!(log, "{k}.5,{}", k % 7).unwrap());
    log += "1e300,3\n";
    assert_eq!(refused("log.csv", log.as_bytes(), &["check"]).0, "bad-time");
    let mut log = String::from("t [s],a\n");
    (0..200).for_each(|k| writeln!(log, "{k}e-300,{}", k % 7).unwrap());
    assert_eq!(
        refused("log.csv", log.as_bytes(), &["check"]).0,
        "out-of-range"
    );
}

/// A response whose abscissa is no number.
#[test]
fn refuses_uff_without_frequencies() {
    for word in ["NaN", "inf"] {
        let text = format!(
            "    -1\n    58\nax / force\nNONE\nNONE\nNONE\nNONE\n    4         0    0         0 ax                 0   0 force              0   0\n         6         3         0 0.000000E+00 0.000000E+00 0.000000E+00\n        18    0    0    0 Frequency            Hz                  \n        12    0    0    0 ax                   m/s2                \n        13    0    0    0 force                N                   \n         0    0    0    0 NONE                 NONE                \n 1.000000E+00  1.000000000000E+00  0.000000000000E+00\n {word}  1.000000000000E+00  0.000000000000E+00\n 3.000000E+00  1.000000000000E+00  0.000000000000E+00\n    -1\n"
        );
        let (code, message, line) = refused("log.uff", text.as_bytes(), &["check"]);
        assert_eq!(
            (code.as_str(), line),
            ("broken-file", Some(15)),
            "{message}"
        );
    }
}
