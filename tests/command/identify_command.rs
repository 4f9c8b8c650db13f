//! `identify` and `convert` as a person uses them, on a machine of two modes that is known.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::support::noise::normal;

/// Natural frequencies, Hz, and damping ratios.
const TRUTH: [(f64, f64); 2] = [(60.0, 0.02), (140.0, 0.015)];

const RATE: f64 = 1000.0;

fn geardyn(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

fn document(folder: &Path, arguments: &[&str]) -> Value {
    let output = geardyn(folder, arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{text}");
    serde_json::from_str(&text).unwrap()
}

/// The word of the error a call ends in.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = geardyn(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    let text = String::from_utf8(output.stderr).unwrap();
    text.split(['[', ']']).nth(1).unwrap_or(&text).to_string()
}

/// Two modes driven by a force that stays between samples, exactly sampled: each pole `x ← z x + (z − 1)/p · u`, `y = 2 Re Σ R x`.
fn log(folder: &Path) -> PathBuf {
    let mut rng = fastrand::Rng::with_seed(7);
    let signs = [[1.0, 0.6], [0.7, -1.0]];
    let mut states = [(0.0, 0.0); 2];
    let mut text = String::from("time [s],force [N],X1 [m],X2 [m],nothing [m],copy [N]\n");
    for t in 0..40_000 {
        let u = normal(&mut rng);
        let mut y = [0.0; 2];
        for (m, (re, im)) in states.iter_mut().enumerate() {
            let (f, d) = TRUTH[m];
            let omega = TAU * f;
            let (a, b) = (-d * omega, omega * (1.0 - d * d).sqrt());
            // The residue of 1/(s² + 2dωs + ω²) is 1/(2ib).
            for (out, sign) in y.iter_mut().zip(&signs[m]) {
                *out += sign * *im / b;
            }
            let size = (a / RATE).exp();
            let (zr, zi) = (size * (b / RATE).cos(), size * (b / RATE).sin());
            let (nr, ni) = (zr - 1.0, zi);
            let power = a * a + b * b;
            let (gr, gi) = ((nr * a + ni * b) / power, (ni * a - nr * b) / power);
            (*re, *im) = (zr * *re - zi * *im + gr * u, zr * *im + zi * *re + gi * u);
        }
        let [y1, y2] = y.map(|y| y + 1e-7 * normal(&mut rng));
        text += &format!(
            "{:.3},{u:.9e},{y1:.9e},{y2:.9e},0,{u:.9e}\n",
            t as f64 / RATE
        );
    }
    let path = folder.join("two.csv");
    std::fs::write(&path, text).unwrap();
    path
}

/// Every true mode is found, within so many stated deviations, or within a share where none is stated.
fn assert_modes(found: &Value, what: &str, share: f64) {
    let modes = found["modes"].as_array().unwrap();
    for (f, d) in TRUTH {
        let apart = |m: &&Value| (m["frequency_hz"].as_f64().unwrap() - f).abs();
        let mode = modes.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let mode = mode.unwrap_or_else(|| panic!("{what}: no mode"));
        // Five deviations, and what a hold between samples bends: its rounding alone is far below.
        let bound = |key: &str, size: f64| {
            mode[key]
                .as_f64()
                .map_or(share * size, |s| 5.0 * s + 1e-4 * size)
        };
        assert!(
            apart(&mode) < bound("frequency_std_hz", f),
            "{what}: {mode}"
        );
        let damping = mode["damping_ratio"].as_f64().unwrap();
        assert!(
            (damping - d).abs() < bound("damping_std", 20.0 * d),
            "{what}: {mode}"
        );
    }
}

const KEYS: [&str; 26] = [
    "mode",
    "frequency_hz",
    "frequency_std_hz",
    "damped_frequency_hz",
    "damping_ratio",
    "damping_std",
    "window_damping",
    "pole_rad_s",
    "coherence",
    "presence",
    "scatter_hz",
    "weak",
    "model_error",
    "frequency_spread_hz",
    "damping_spread",
    "envelope_kurtosis",
    "on_order",
    "on_mains",
    "phase_collinearity",
    "mean_phase_rad",
    "mean_phase_deviation_rad",
    "complexity",
    "shape",
    "shape_on_points",
    "modal_mass",
    "participation",
];

/// Each method finds both modes and answers with the same keys.
#[test]
fn exact_two_modes_by_every_method() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder);
    let driven = [
        "identify", "two.csv", "--input", "force", "--output", "X1", "--json", "--method",
    ];
    let alone = [
        "identify", "two.csv", "--output", "X1,X2", "--json", "--method",
    ];
    let one = [
        "identify", "two.csv", "--output", "X1", "--json", "--method",
    ];
    // The hold delays the response by half a sample, which a fit without delay puts into its terms: 1 % at most.
    let cases: [(&[&str], &str, f64); 6] = [
        (&driven, "plscf", 0.01),
        (&driven, "arx", 0.01),
        (&driven, "vector-fitting", 0.01),
        (&alone, "ssi-cov", 0.01),
        (&alone, "ssi-data", 0.01),
        (&one, "ar", 0.01),
    ];
    for (arguments, method, share) in cases {
        let found = document(folder, &[arguments, &[method]].concat());
        assert_eq!(found["method"], method);
        assert!(found["rule"].as_str().unwrap().len() > 20);
        for mode in found["modes"].as_array().unwrap() {
            let keys: Vec<&String> = mode.as_object().unwrap().keys().collect();
            assert_eq!(keys, KEYS, "{method}");
        }
        assert_modes(&found, method, share);
    }
    let found = document(
        folder,
        &["identify", "two.csv", "--output", "X1,X2", "--json"],
    );
    assert_eq!(found["method"], "ssi-cov");
    let found = document(
        folder,
        &[
            "identify", "two.csv", "--input", "force", "--output", "x1", "--delay", "common",
            "--band", "20:300", "--json",
        ],
    );
    assert_eq!(found["method"], "rational");
    // The hold is half a sample late; what the responses hold of noise and leakage leaves the estimate within as much.
    let delay = found["delay_s"][0].as_f64().unwrap();
    assert!((delay - 0.5 / RATE).abs() < 0.5 / RATE, "{delay}");
    assert_eq!(found["modes"].as_array().unwrap().len(), TRUTH.len());
}

/// The force acts at X1, where the modes have residues 1 and 0.7 over `2iω`, and 0.6 and −1 at X2: with the largest component one, masses
/// of 1 kg and 0.7² / 0.7 kg. At X2 it does not act: the second mass would be negative.
#[test]
fn exact_modal_mass_at_driving_point() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder);
    let call = [
        "identify",
        "two.csv",
        "--input",
        "force",
        "--output",
        "X1,X2",
        "--band",
        "20:300",
        "--json",
        "--driving-point",
    ];
    let found = document(folder, &[&call[..], &["X1"]].concat());
    assert_eq!(found["driving_point"]["modal_mass_unit"], "kg");
    for (mode, mass) in found["modes"].as_array().unwrap().iter().zip([1.0, 0.7]) {
        // The hold turns the phase by half a sample, 25° at 140 Hz, and leaves the size.
        let part = |key| mode["modal_mass"][key].as_f64().unwrap();
        let got: f64 = part("re");
        assert!(
            (got.hypot(part("im")) - mass).abs() < 0.03 * mass && got > 0.0,
            "{mode}"
        );
    }
    let found = document(folder, &[&call[..], &["force=x2"]].concat());
    let warned = found["warnings"].as_array().unwrap();
    assert!(
        warned.iter().any(|w| w["code"] == "driving-point"),
        "{warned:?}"
    );
    let refusals: [(&[&str], &str); 4] = [
        (
            &[
                "--input",
                "force",
                "--output",
                "X1",
                "--driving-point",
                "X3",
            ],
            "no-channel",
        ),
        (
            &[
                "--input",
                "force",
                "--output",
                "X1",
                "--driving-point",
                "copy=X1",
            ],
            "no-channel",
        ),
        (&["--output", "X1", "--driving-point", "X1"], "usage"),
        (
            &[
                "--input",
                "force",
                "--output",
                "X1",
                "--driving-point",
                "X1",
                "--unit",
                "X1=rad",
            ],
            "conflict",
        ),
    ];
    for (arguments, word) in refusals {
        let all = [&["identify", "two.csv"], arguments].concat();
        assert_eq!(refused(folder, &all), word, "{arguments:?}");
    }
}

/// A mode whose frequency falls from 60 to 50 Hz in the middle of the record: the course is in JSON, CSV and the picture, the modes are
/// those at the end.
#[test]
fn law_course_by_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut rng = fastrand::Rng::with_seed(3);
    let (mut y1, mut y2) = (0.0, 0.0);
    let mut text = String::from("time [s],f [N],a [m/s^2]\n");
    for t in 0..8000 {
        let w = TAU * if t < 4000 { 60.0 } else { 50.0 } / 400.0;
        let r = (-0.02 * w).exp();
        let u = normal(&mut rng);
        let y = 2.0 * r * w.cos() * y1 - r * r * y2 + u + 0.1 * normal(&mut rng);
        (y2, y1) = (y1, y);
        text += &format!("{:.4},{u:.6e},{y:.6e}\n", f64::from(t) / 400.0);
    }
    std::fs::write(folder.join("cut.csv"), text).unwrap();
    let call = ["identify", "cut.csv", "--output", "a", "--method", "rls"];
    let files = ["--json", "--csv", "course.csv", "--svg", "course.svg"];
    let found = document(folder, &[&call[..], &files].concat());
    let near = |mode: &Value, f: f64| {
        let std = mode["frequency_std_hz"].as_f64().unwrap();
        (mode["frequency_hz"].as_f64().unwrap() - f).abs() < 4.0 * std + 0.02
    };
    let modes = found["modes"].as_array().unwrap();
    assert!(near(&modes[0], 50.0), "{modes:?}");
    let tracks = found["tracking"].as_array().unwrap();
    let points = |k: usize| tracks[k]["points"].as_array().unwrap();
    assert!(near(&points(0)[10], 60.0), "{}", points(0)[10]);
    let rows: usize = (0..tracks.len()).map(|k| points(k).len()).sum();
    let csv = std::fs::read_to_string(folder.join("course.csv")).unwrap();
    assert_eq!(csv.lines().count(), rows + 1);
    let svg = std::fs::read_to_string(folder.join("course.svg")).unwrap();
    assert!(svg.contains("damping, %"));
    let text = String::from_utf8(geardyn(folder, &call).stdout).unwrap();
    assert!(
        text.contains("error of prediction") && text.contains("taken"),
        "{text}"
    );
    let driven = ["--input", "f", "--order", "1", "--memory", "1 s", "--json"];
    let found = document(folder, &[&call[..], &driven].concat());
    let modes = found["modes"].as_array().unwrap();
    assert!(modes.len() == 1 && near(&modes[0], 50.0), "{modes:?}");
    assert!(
        modes[0]["frequency_std_hz"].as_f64().unwrap() < 0.1,
        "{modes:?}"
    );
    let memory = |time| refused(folder, &[&call[..], &["--memory", time]].concat());
    assert_eq!(memory("0.01 s"), "too-short");
    assert_eq!(memory("0 s"), "out-of-range");
    let other = ["identify", "cut.csv", "--output", "a", "--memory", "1"];
    assert_eq!(refused(folder, &other), "usage");
}

/// An output with noise of its own follows no AR model: that the recursion's errors are not white is said, and of the same output
/// without noise it is not.
#[test]
fn law_errors_of_a_recursion_are_tested() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (noise, told) in [(0.0, 0), (3.0, 1)] {
        let mut rng = fastrand::Rng::with_seed(5);
        let (mut y1, mut y2) = (0.0, 0.0);
        let mut text = String::from("time [s],a [m/s^2]\n");
        for t in 0..8000 {
            let w = TAU * 60.0 / 400.0;
            let r = (-0.02 * w).exp();
            let y = 2.0 * r * w.cos() * y1 - r * r * y2 + normal(&mut rng);
            (y2, y1) = (y1, y);
            let seen = y + noise * normal(&mut rng);
            text += &format!("{:.4},{seen:.6e}\n", f64::from(t) / 400.0);
        }
        std::fs::write(folder.join("noisy.csv"), text).unwrap();
        let call = ["identify", "noisy.csv", "--output", "a", "--method", "rls"];
        let found = document(folder, &[&call[..], &["--order", "1", "--json"]].concat());
        let warnings = found["warnings"].as_array().unwrap();
        let of_residuals = warnings.iter().filter(|w| w["code"] == "residuals");
        assert_eq!(of_residuals.count(), told, "{warnings:?}");
    }
}

/// Responses written are responses read: the same modes from the file of them.
#[test]
fn law_responses_written_are_responses_read() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder);
    let first = [
        "identify", "two.csv", "--input", "force", "--output", "X1,X2", "--json", "--method",
        "plscf", "--frf", "frf.csv",
    ];
    let one = document(folder, &first);
    let two = document(
        folder,
        &[
            "identify", "frf.csv", "--json", "--method", "plscf", "--band", "1:475",
        ],
    );
    assert_modes(&one, "signals", 0.01);
    assert_modes(&two, "responses", 0.01);
}

/// A universal file of responses also holds what their uncertainty and their band rest on, so that the default fit of it is that of the
/// signals of steady noise. Of a hammer it holds the average and not the hits: the same modes, within their intervals.
#[test]
fn law_universal_responses_give_the_same_modes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder);
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/data/spindle_impact.csv");
    type Tolerances = &'static [(&'static str, f64)];
    // Three hits: their scatter gives intervals, averages of three do not.
    let by_hit: Tolerances = &[("frequency_hz", 1e-4), ("damping_ratio", 1e-2)];
    let average: Tolerances = &[
        ("frequency_hz", 1e-6),
        ("damping_ratio", 1e-4),
        ("frequency_std_hz", 0.05),
    ];
    let tests: [(&str, &[&str], usize, Tolerances); 2] = [
        (shipped, &["--output", "ax,ay"], 6, by_hit),
        ("two.csv", &["--output", "X1,X2"], TRUTH.len(), average),
    ];
    for (file, outputs, count, tolerances) in tests {
        let flags = ["--input", "force", "--json", "--frf", "frf.uff"];
        let one = document(folder, &[&["identify", file], outputs, &flags[..]].concat());
        let two = document(folder, &["identify", "frf.uff", "--json"]);
        let numbers = |found: &Value, key: &str| -> Vec<f64> {
            let modes = found["modes"].as_array().unwrap().iter();
            modes.map(|m| m[key].as_f64().unwrap()).collect()
        };
        for (key, tolerance) in tolerances {
            let (a, b) = (numbers(&one, key), numbers(&two, key));
            assert_eq!(
                (a.len(), b.len()),
                (count, count),
                "{file} {key}: {a:?} {b:?}"
            );
            for (a, b) in a.iter().zip(&b) {
                assert!(
                    (a / b - 1.0).abs() < *tolerance,
                    "{file} {key}: {a} and {b}"
                );
            }
        }
        assert_eq!(one["window_decay_1_s"], two["window_decay_1_s"]);
    }
}

#[test]
fn refuses_channels_that_tell_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder);
    let cases: [(&[&str], &str); 8] = [
        (&["--input", "force", "--output", "force"], "conflict"),
        (&["--input", "force", "--output", "copy"], "conflict"),
        (&["--input", "nothing", "--output", "X1"], "no-signal"),
        (&["--output", "X1,X1"], "conflict"),
        (&["--input", "force"], "usage"),
        (&["--output", "X9"], "no-channel"),
        (&["--output", "X1", "--method", "arx"], "usage"),
        (
            &["--input", "force", "--output", "X1", "--method", "ssi-cov"],
            "usage",
        ),
    ];
    for (flags, word) in cases {
        let arguments = [&["identify", "two.csv"], flags].concat();
        assert_eq!(refused(folder, &arguments), word, "{flags:?}");
    }
}

/// CSV to UFF in bytes and back keeps names, rate and every value.
#[test]
fn law_convert_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(
        folder.join("a.csv"),
        "time [s],x [m],y [N]\n0,1.5,-2\n0.5,0.1,3e-7\n1,2,4\n1.5,7,5\n",
    )
    .unwrap();
    for arguments in [
        ["convert", "a.csv", "--to", "b.uff", "--binary", "--quiet"],
        ["convert", "b.uff", "--to", "c.csv", "--channel", "x,y"],
    ] {
        let output = geardyn(folder, &arguments);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let text = std::fs::read_to_string(folder.join("c.csv")).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|c| c.parse().unwrap()).collect())
        .collect();
    assert_eq!(
        rows,
        [
            [0.0, 1.5, -2.0],
            [0.5, 0.1, 3e-7],
            [1.0, 2.0, 4.0],
            [1.5, 7.0, 5.0]
        ]
    );
}

/// Outputs that would end in one file, lie in no folder or do not say their format are refused before anything is written.
#[test]
fn refuses_outputs_before_work() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder);
    let cases: [(&[&str], &str); 4] = [
        (&["--frf", "q.csv", "--csv", "./q.csv"], "usage"),
        (
            &["--csv", "kept.csv", "--svg", "nowhere/x.svg"],
            "output-failed",
        ),
        (&["--csv", "modes.toml"], "usage"),
        (&["--csv", "two.csv"], "usage"),
    ];
    for (flags, word) in cases {
        let base = ["identify", "two.csv", "--input", "force", "--output", "X1"];
        assert_eq!(
            refused(folder, &[&base[..], flags].concat()),
            word,
            "{flags:?}"
        );
    }
    assert!(!folder.join("kept.csv").exists());
}

/// An order beyond what the record carries is refused or answered, never a panic.
#[test]
fn survives_high_orders() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder);
    for (method, order) in [("arma", "30"), ("armax", "200")] {
        let mut arguments = vec![
            "identify", "two.csv", "--output", "X1", "--method", method, "--order", order,
            "--before", "1.5",
        ];
        if method == "armax" {
            arguments.extend(["--input", "force"]);
        }
        let code = geardyn(folder, &arguments).status.code();
        assert!(matches!(code, Some(0 | 2 | 3)), "{method}: {code:?}");
    }
}

/// Poles that are no modes are named with their reason.
#[test]
fn law_left_out_poles() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/spindle_impact.csv");
    let data = data.to_str().unwrap();
    let output = geardyn(
        folder,
        &[
            "identify", data, "--input", "force", "--output", "ax", "--quiet",
        ],
    );
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("no mode at "), "{text}");
}

/// A fit that misses a response by half its size is said to be poor, whatever the method.
#[test]
fn exact_poor_fit() {
    use geardyn::internals::numeric::Complex;
    use geardyn::internals::plan::logs::diagnostics::check_fit;
    use geardyn::internals::recording::frequency_responses::{
        ChannelLabel, FrequencyResponse, FrequencyResponses,
    };
    let function = |name: &str| FrequencyResponse {
        output: ChannelLabel {
            name: name.into(),
            unit: String::new(),
        },
        values: [1.0, 1.0, 50.0].map(Complex::from).to_vec(),
        // Nothing drives the last line.
        variance: Some(vec![0.01, 0.01, 2500.0]),
        ..FrequencyResponse::default()
    };
    let responses = FrequencyResponses {
        frequency_hz: vec![10.0, 20.0, 30.0],
        responses: vec![function("ax"), function("ay")],
        ..FrequencyResponses::default()
    };
    let fit = |ay: f64| {
        check_fit(&responses, (1.0, 100.0), move |_| {
            [1.2, ay].map(Complex::from).to_vec()
        })
    };
    assert!(fit(1.49).is_none());
    let found = fit(18.0).unwrap();
    assert_eq!(found.code, "poor-fit");
    assert!(
        found.message.contains("ay by 1700 %") && !found.message.contains("ax"),
        "{}",
        found.message
    );
}

/// Local parabolas take blocks of one length from every stretch, here of the shortest, and say what they leave out. Gaps shorten no averaged block as
/// long as the stretches between them hold enough blocks together.
#[test]
fn exact_blocks_over_gaps() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(log(folder.path())).unwrap();
    let is_kept = |at: usize| {
        ![9500, 20_500, 29_500]
            .iter()
            .any(|g| (*g..g + 500).contains(&at))
    };
    let kept: Vec<&str> = (text.lines().enumerate())
        .filter(|(at, _)| is_kept(*at))
        .map(|(_, line)| line)
        .collect();
    std::fs::write(folder.path().join("gaps.csv"), kept.join("\n")).unwrap();
    let arguments = [
        "identify", "gaps.csv", "--input", "force", "--output", "X1,X2", "--json",
    ];
    let found = document(folder.path(), &arguments);
    let how = found["method_text"].as_str().unwrap();
    // The largest product of powers of 2, 3 and 5 in 8500 samples.
    let said = ["4 blocks of 8.1920 s", "5.7320 s of 38.5000 s not used"];
    assert!(said.iter().all(|s| how.contains(s)), "{how}");
    assert_modes(&found, "over gaps", 0.0);
    let averaged = document(
        folder.path(),
        &[&arguments[..], &["--window", "hann"]].concat(),
    );
    let how = averaged["method_text"].as_str().unwrap();
    assert!(how.contains("blocks of 2.0480 s"), "{how}");
    assert_modes(&averaged, "over gaps, averaged", 0.0);
}

/// A log of named columns over time at 1 kHz.
fn written(folder: &Path, name: &str, heads: &str, columns: &[Vec<f64>]) {
    let mut text = format!("time [s],{heads}\n");
    for t in 0..columns[0].len() {
        text += &format!("{:.3}", t as f64 / RATE);
        for column in columns {
            text += &format!(",{:.9e}", column[t]);
        }
        text.push('\n');
    }
    std::fs::write(folder.join(name), text).unwrap();
}

fn noise(samples: usize, seed: u64) -> Vec<f64> {
    let mut rng = fastrand::Rng::with_seed(seed);
    (0..samples).map(|_| normal(&mut rng)).collect()
}

/// What resonates at 80 Hz with a damping of 2 %, driven by samples.
fn resonant(input: &[f64]) -> Vec<f64> {
    oscillator(input, 80.0)
}

fn oscillator(input: &[f64], frequency_hz: f64) -> Vec<f64> {
    let omega = TAU * frequency_hz / RATE;
    let size = (-0.02 * omega).exp();
    let (a, b) = (2.0 * size * omega.cos(), -size * size);
    let (mut last, mut older) = (0.0, 0.0);
    let step = |u: &f64| {
        let y = a * last + b * older + u;
        (last, older) = (y, last);
        y
    };
    input.iter().map(step).collect()
}

fn words(found: &Value) -> Vec<&str> {
    let all = found["warnings"].as_array().unwrap();
    all.iter().map(|w| w["code"].as_str().unwrap()).collect()
}

/// An output that has nothing to do with the input holds no mode, whatever the method.
#[test]
fn refuses_modes_of_noise() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let columns = [noise(6000, 1), noise(6000, 2)];
    written(folder, "noise.csv", "f [N],a [m/s^2]", &columns);
    let driven = ["identify", "noise.csv", "--input", "f", "--output", "a"];
    let alone = ["identify", "noise.csv", "--output", "a"];
    let methods = ["circle", "lsce", "armax", "output-error"].map(|m| (&driven[..], m));
    for (call, method) in methods
        .into_iter()
        .chain(["fdd", "efdd", "ssi-data", "arma"].map(|m| (&alone[..], m)))
    {
        let call = [call, &["--json", "--method", method]].concat();
        let found = document(folder, &call);
        assert!(
            found["modes"].as_array().unwrap().is_empty(),
            "{method}: {}",
            found["modes"]
        );
        assert!(words(&found).contains(&"no-mode"), "{method}");
    }
}

/// `--order` of the circle fit keeps the modes of the highest peaks, not those of the lowest frequencies.
#[test]
fn law_circle_keeps_the_highest_peaks() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let force = noise(40_000, 5);
    let [low, high] = [40.0, 110.0].map(|f| oscillator(&force, f));
    let sum = low.iter().zip(&high).map(|(a, b)| a + 20.0 * b).collect();
    written(folder, "two.csv", "f [N],a [m]", &[force, sum]);
    let call = [
        "identify", "two.csv", "--input", "f", "--output", "a", "--json",
    ];
    let found = |more: &[&str]| {
        let found = document(folder, &[&call[..], &["--method", "circle"], more].concat());
        let modes = found["modes"].as_array().unwrap().iter();
        modes
            .map(|m| m["frequency_hz"].as_f64().unwrap())
            .collect::<Vec<f64>>()
    };
    assert_eq!(found(&[]).len(), 2);
    let kept = found(&["--order", "1"]);
    assert!(kept.len() == 1 && (kept[0] - 110.0).abs() < 2.0, "{kept:?}");
}

/// The band is where the input has power, and a mode above it is not looked for.
#[test]
fn law_band_is_that_of_the_input() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // A sweep from 20 to 150 Hz over 16 s.
    let sweep: Vec<f64> = (0..16_000)
        .map(|t| t as f64 / RATE)
        .map(|t| (TAU * (20.0 * t + 65.0 * t * t / 16.0)).sin())
        .collect();
    let mut answer = resonant(&sweep);
    (answer.iter_mut().zip(noise(16_000, 4))).for_each(|(y, e)| *y += 0.01 * e);
    written(folder, "sweep.csv", "f [N],a [m]", &[sweep, answer]);
    let call = [
        "identify",
        "sweep.csv",
        "--input",
        "f",
        "--output",
        "a",
        "--json",
    ];
    let found = document(folder, &call);
    let end = |k: usize| found["band_hz"][k].as_f64().unwrap();
    assert!(end(0) > 5.0 && end(0) < 25.0, "{}", end(0));
    assert!(end(1) > 145.0 && end(1) < 200.0, "{}", end(1));
    let modes = found["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 1);
    let f = modes[0]["frequency_hz"].as_f64().unwrap();
    assert!((f - 80.0).abs() < 0.05, "{f}");
}

/// Roots that only fill up a long polynomial are no modes; a root that is one stays.
#[test]
fn keeps_only_resonances_of_a_polynomial() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    written(folder, "one.csv", "a [m]", &[resonant(&noise(6000, 5))]);
    let call = [
        "identify", "one.csv", "--output", "a", "--method", "ar", "--order", "12", "--json",
    ];
    let found = document(folder, &call);
    let modes = found["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 1, "{}", found["modes"]);
    assert!((modes[0]["frequency_hz"].as_f64().unwrap() - 80.0).abs() < 1.0);
    assert!(found["omitted"].as_array().unwrap().len() > 4);
}

/// Channels tied to each other, orders beyond sense, an estimator for hits: each refused by name.
#[test]
fn refuses_what_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let u = noise(4000, 6);
    let twice: Vec<f64> = u.iter().map(|u| 2.0 * u + 5.0).collect();
    let answer = resonant(&u);
    written(
        folder,
        "log.csv",
        "f [N],twice [m],a [m]",
        &[u, twice, answer],
    );
    let call = ["identify", "log.csv", "--input", "f", "--output"];
    assert_eq!(
        refused(folder, &[&call[..], &["twice"]].concat()),
        "conflict"
    );
    let order = ["a", "--order", "18446744073709551615", "--method", "plscf"];
    assert_eq!(
        refused(folder, &[&call[..], &order].concat()),
        "out-of-range"
    );
    let order = ["a", "--order", "400", "--method", "armax"];
    assert_eq!(refused(folder, &[&call[..], &order].concat()), "too-short");
    let impact = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/spindle_impact.csv");
    let impact = impact.to_str().unwrap();
    let call = [
        "identify",
        impact,
        "--input",
        "force",
        "--output",
        "ax",
        "--estimator",
        "h2",
    ];
    let said = geardyn(folder, &call);
    let text = String::from_utf8(said.stderr).unwrap();
    assert!(text.contains("uses H1"), "{text}");
}

/// Units that say another kind than the flag are heard.
#[test]
fn keeps_units_beside_kind() {
    use geardyn::internals::plan::logs::diagnostics::check_stated_kind;
    use geardyn::internals::recording::frequency_responses::{
        ChannelLabel, FrequencyResponse, FrequencyResponses,
    };
    let terminal = |name: &str, unit: &str| ChannelLabel {
        name: name.into(),
        unit: unit.into(),
    };
    let responses = FrequencyResponses {
        responses: vec![FrequencyResponse {
            input: Some(terminal("f", "N")),
            output: terminal("x", "m"),
            ..FrequencyResponse::default()
        }],
        ..FrequencyResponses::default()
    };
    assert!(check_stated_kind(&responses, None).is_none());
    assert!(check_stated_kind(&responses, Some(0)).is_none());
    let said = check_stated_kind(&responses, Some(2)).unwrap();
    assert_eq!(said.code, "kind-differs");
    assert!(said.message.contains("receptance"), "{}", said.message);
}

/// A channel that is asked for and holds no number is an error that names it, not a smaller test.
#[test]
fn refuses_an_output_without_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(log(folder.path())).unwrap();
    let emptied = |line: &str| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if !line.starts_with("time") {
            cells[2] = "nan";
        }
        cells.join(",")
    };
    let lines: Vec<String> = text.lines().map(emptied).collect();
    std::fs::write(folder.path().join("nan.csv"), lines.join("\n")).unwrap();
    let output = geardyn(
        folder.path(),
        &[
            "identify", "nan.csv", "--input", "force", "--output", "X1,X2",
        ],
    );
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("X1"), "{said}");
}
