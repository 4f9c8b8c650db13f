//! `geardyn spectrum` as a person uses it: lines of known tones, levels of noise, orders of a run-up, wrong input.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::command::{document, geardyn, refusal};
use crate::support::noise::normal;
use crate::support::verification::within;

/// A log of some columns at a rate, each a function of time.
fn log(
    folder: &Path,
    heads: &str,
    rate: f64,
    samples: usize,
    row: impl FnMut(f64) -> Vec<f64>,
) -> PathBuf {
    let mut row = row;
    let mut text = format!("time [s],{heads}\n");
    for j in 0..samples {
        let t = j as f64 / rate;
        text += &format!("{t:.9}");
        row(t).iter().for_each(|x| text += &format!(",{x:.9e}"));
        text.push('\n');
    }
    let path = folder.join("log.csv");
    std::fs::write(&path, text).unwrap();
    path
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

/// A tone between two lines in weak noise: its frequency to a part of a line, its amplitude, and its velocity by 1/ω.
#[test]
fn exact_tone() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(1);
    let path = log(folder.path(), "ax [m/s²],ay [g]", 1000.0, 20_000, |t| {
        let tone = 3.0 * (TAU * 123.4 * t).sin();
        vec![
            tone + 0.01 * normal(&mut rng),
            2.0 * (TAU * 50.0 * t).cos() + 0.01 * normal(&mut rng),
        ]
    });
    let file = path.to_str().unwrap();
    let found = document(&[
        "spectrum",
        file,
        "--channel",
        "ax,ay [g]",
        "--kind",
        "amplitude",
        "--window",
        "flat-top",
        "--json",
    ]);
    let peak = &found["channels"][0]["peaks"][0];
    within(
        "frequency, Hz",
        (peak["frequency_hz"].as_f64().unwrap() - 123.4).abs(),
        0.05,
    );
    within(
        "amplitude",
        (peak["amplitude"].as_f64().unwrap() - 3.0).abs(),
        0.02,
    );
    assert_eq!(peak["amplitude_unit"], "m/s²");
    assert_eq!(found["channels"][1]["channel"], "ay");
    let rms = document(&[
        "spectrum",
        file,
        "--channel",
        "ay",
        "--kind",
        "rms",
        "--window",
        "flat-top",
        "--json",
    ]);
    let peak = &rms["channels"][0]["peaks"][0];
    within(
        "amplitude of the second tone",
        (peak["amplitude"].as_f64().unwrap() - 2f64.sqrt()).abs(),
        0.01,
    );
    let speed = document(&[
        "spectrum",
        file,
        "--channel",
        "ay",
        "--kind",
        "amplitude",
        "--window",
        "flat-top",
        "--as",
        "velocity",
        "--json",
    ]);
    let channel = &speed["channels"][0];
    let expected = 2.0 * 9.80665 / (TAU * 50.0);
    let amplitude = channel["peaks"][0]["amplitude"].as_f64().unwrap();
    within("velocity", (amplitude / expected - 1.0).abs(), 0.01);
    assert_eq!(channel["unit"], "m/s");
    assert!(
        speed["method_text"]
            .as_str()
            .unwrap()
            .contains("nothing below")
    );
}

/// White noise of variance σ² at rate f has the density 2σ²/f; its χ² interval holds 1.
#[test]
fn law_level_of_white_noise() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(2);
    let path = log(folder.path(), "v [V]", 500.0, 40_000, |_| {
        vec![3.0 * normal(&mut rng)]
    });
    let file = path.to_str().unwrap();
    for flags in [
        &["--resolution", "1"][..],
        &["--kind", "multitaper"],
        &["--kind", "spectrogram"],
    ] {
        let found = document(&[&["spectrum", file, "--channel", "v", "--json"], flags].concat());
        let density = numbers(&found["channels"][0]["value"]);
        let inner = &density[5..density.len() - 5];
        let mean = inner.iter().sum::<f64>() / inner.len() as f64;
        assert!(
            (mean / (2.0 * 9.0 / 500.0) - 1.0).abs() < 0.03,
            "{flags:?}: {mean}"
        );
        assert_eq!(found["channels"][0]["unit"], "V²/Hz");
        let interval = &found["interval"];
        assert!(
            interval["lower"].as_f64().unwrap() < 1.0 && interval["upper"].as_f64().unwrap() > 1.0
        );
    }
    let held = document(&[
        "spectrum",
        file,
        "--channel",
        "v",
        "--resolution",
        "1",
        "--average",
        "peak-hold",
        "--json",
    ]);
    assert!(held["averages"].is_null() && held["interval"].is_null());
}

/// A run-up with a tacho of two pulses a turn: 3.5 orders of amplitude 2 come out as one line, its name that of a bearing.
#[test]
fn exact_orders_of_a_run_up() {
    let folder = tempfile::tempdir().unwrap();
    // 5 to 25 turns a second in 20 s
    let turns = |t: f64| 5.0 * t + 0.5 * t * t;
    let path = log(folder.path(), "ax [g],tacho [V]", 2000.0, 40_000, |t| {
        let angle = TAU * turns(t);
        let pulse = (0.5 + 4.0 * (2.0 * angle).sin()).clamp(0.0, 1.0);
        vec![
            2.0 * (3.5 * angle + 0.4).cos() + 0.02 * (8.0 * angle).cos(),
            pulse,
        ]
    });
    let file = path.to_str().unwrap();
    let base = [
        "spectrum",
        file,
        "--channel",
        "ax",
        "--kind",
        "order",
        "--tacho",
        "tacho",
        "--pulses",
        "2",
        "--turns",
        "20",
        "--json",
    ];
    let found = document(&base);
    let peak = &found["channels"][0]["peaks"][0];
    within("order", (peak["order"].as_f64().unwrap() - 3.5).abs(), 0.02);
    within(
        "amplitude at the order",
        (peak["amplitude"].as_f64().unwrap() - 2.0).abs(),
        0.1,
    );
    let order = numbers(&found["order"]);
    assert!((order[1] - 0.05).abs() < 1e-12);
    // n/2 (1 − d/D) = 3.5 for eight balls, d/D = 1/8
    let named = document(&[&base[..], &["--bearing", "8,1,8,0"]].concat());
    let names = named["channels"][0]["peaks"][0]["names"].to_string();
    assert!(names.contains("BPFO"), "{names}");
}

/// A shaft at a steady speed, named by a machine; its mean over turns repeats the wave.
#[test]
fn exact_steady_shaft() {
    let folder = tempfile::tempdir().unwrap();
    let path = log(folder.path(), "ax [g]", 1000.0, 10_000, |t| {
        vec![(TAU * 20.0 * t).cos() + 0.3 * (TAU * 40.0 * t).sin() + 0.1 * (TAU * 27.3 * t).cos()]
    });
    let file = path.to_str().unwrap();
    let found = document(&[
        "spectrum",
        file,
        "--channel",
        "ax",
        "--speed",
        "1200",
        "--json",
    ]);
    let peaks = found["channels"][0]["peaks"].as_array().unwrap();
    assert_eq!(peaks[0]["names"][0], "rotation");
    assert_eq!(peaks[1]["names"][0], "2 × rotation");
    assert!(peaks[2]["names"].as_array().unwrap().is_empty());
    let mean = document(&[
        "spectrum",
        file,
        "--channel",
        "ax",
        "--speed",
        "1200",
        "--kind",
        "average",
        "--json",
    ]);
    let (angle, turn) = (
        numbers(&mean["angle_deg"]),
        numbers(&mean["channels"][0]["value"]),
    );
    for (a, x) in angle.iter().zip(turn) {
        let a = a.to_radians();
        within(
            "mean turn",
            (x - a.cos() - 0.3 * (2.0 * a).sin()).abs(),
            0.01,
        );
    }
}

/// Bursts at 13 Hz that ring at 300 Hz: the envelope of the band shows 13 Hz.
#[test]
fn exact_envelope_of_bursts() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(4);
    let path = log(folder.path(), "ax [g]", 1000.0, 8000, |t| {
        let since = (t * 13.0).fract() / 13.0;
        vec![(-80.0 * since).exp() * (TAU * 300.0 * since).sin() + 0.02 * normal(&mut rng)]
    });
    let file = path.to_str().unwrap();
    let found = document(&[
        "spectrum",
        file,
        "--channel",
        "ax",
        "--kind",
        "envelope",
        "--band",
        "200:400",
        "--json",
    ]);
    let peak = &found["channels"][0]["peaks"][0];
    within(
        "frequency of bursts, Hz",
        (peak["frequency_hz"].as_f64().unwrap() - 13.0).abs(),
        0.1,
    );
    let cepstrum = document(&[
        "spectrum",
        file,
        "--channel",
        "ax",
        "--kind",
        "cepstrum",
        "--band",
        "5:50",
        "--json",
    ]);
    let peak = &cepstrum["channels"][0]["peaks"][0];
    within(
        "quefrency of bursts",
        (peak["quefrency_s"].as_f64().unwrap() * 13.0 - 1.0).abs(),
        0.02,
    );
}

#[test]
fn refuses_wrong_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = log(
        folder.path(),
        "ax [g],nothing [g],p [Pa]",
        1000.0,
        4000,
        |t| vec![(TAU * 20.0 * t).cos(), 0.0, (TAU * 30.0 * t).sin()],
    );
    let file = path.to_str().unwrap();
    let code = |flags: &[&str]| refusal(&[&["spectrum", file], flags].concat()).0;
    assert_eq!(code(&["--channel", "az"]), "no-channel");
    assert_eq!(code(&["--channel", "ax,ax"]), "usage");
    assert_eq!(code(&["--channel", "nothing"]), "no-signal");
    assert_eq!(code(&["--channel", "ax", "--kind", "order"]), "usage");
    assert_eq!(
        code(&["--channel", "ax", "--band", "600:700"]),
        "out-of-range"
    );
    assert_eq!(
        code(&["--channel", "ax", "--band", "20.01:20.02"]),
        "out-of-range"
    );
    assert_eq!(code(&["--channel", "ax", "--overlap", "1"]), "out-of-range");
    assert_eq!(
        code(&["--channel", "ax", "--resolution", "0.01"]),
        "out-of-range"
    );
    assert_eq!(code(&["--channel", "ax", "--average", "median"]), "usage");
    assert_eq!(
        code(&["--channel", "ax", "--kind", "envelope", "--window", "hann"]),
        "usage"
    );
    assert_eq!(code(&["--channel", "ax", "--bearing", "9,8,40,0"]), "usage");
    assert_eq!(
        code(&["--channel", "ax", "--kind", "order", "--speed", "1e6"]),
        "out-of-range"
    );
    assert_eq!(code(&["--channel", "p", "--as", "velocity"]), "wrong-unit");
}

/// Files are written and say so; a picture is one.
#[test]
fn survives_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = log(folder.path(), "ax [g]", 1000.0, 9000, |t| {
        vec![(TAU * 20.0 * t).cos()]
    });
    let (csv, svg) = (folder.path().join("out.csv"), folder.path().join("out.svg"));
    let output = geardyn(&[
        "spectrum",
        path.to_str().unwrap(),
        "--channel",
        "ax",
        "--csv",
        csv.to_str().unwrap(),
        "--svg",
        svg.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(0));
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("20.0000") && table.contains("Hz"), "{table}");
    let csv = std::fs::read_to_string(csv).unwrap();
    assert!(csv.starts_with("frequency_hz,ax [g²/Hz]\n"), "{csv:.60}");
    assert!(std::fs::read_to_string(svg).unwrap().contains("<svg"));
}

/// Strongest lines of measured logs, as established tools find them.
/// Source: measured logs, tones as published with them.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_measured_logs() {
    let folder = PathBuf::from(std::env::var("GEARDYN_RECORDINGS").unwrap());
    let lines = |file: &str, flags: &[&str]| -> Vec<Vec<f64>> {
        let path = folder.join(file);
        let found = document(&[&["spectrum", path.to_str().unwrap(), "--json"], flags].concat());
        let channels = found["channels"].as_array().unwrap().iter();
        channels
            .map(|c| {
                let peaks = c["peaks"].as_array().unwrap().iter();
                peaks.map(|p| p["frequency_hz"].as_f64().unwrap()).collect()
            })
            .collect()
    };
    // The taps repeat every half second: below 5 Hz stands their own comb.
    let tap = lines(
        "pimodal_cnc_tap/tap_20260622_163222.csv",
        &[
            "--channel",
            "accel_x_g,accel_y_g,accel_z_g",
            "--band",
            "5:160",
        ],
    );
    for (found, expected) in tap.iter().zip([26.6, 64.35, 82.0]) {
        assert!(
            (found[0] / expected - 1.0).abs() < 5e-3,
            "{found:?} {expected}"
        );
    }
    let beam = lines(
        "arts_beam_lvm/data_set_1_downsampled_by_16.lvm",
        &["--channel", "Acceleratio", "--rate-from", "time"],
    );
    for expected in [100.0, 120.0, 150.0] {
        assert!(
            beam[0].iter().any(|f| (f / expected - 1.0).abs() < 5e-3),
            "{beam:?}"
        );
    }
    let stored = lines(
        "arts_beam_lvm/FFT_data.lvm",
        &["--channel", "Acceleration (FFT - (RMS))"],
    );
    for expected in [6.57, 41.47, 117.93] {
        assert!(
            stored[0].iter().any(|f| (f / expected - 1.0).abs() < 5e-3),
            "{stored:?}"
        );
    }
    let bridge = lines("munich_bridge/AllM100Hz.csv.zip", &["--channel", "ACC01_z"]);
    for expected in [10.79, 12.65, 13.62, 16.26] {
        assert!(
            bridge[0].iter().any(|f| (f / expected - 1.0).abs() < 5e-3),
            "{bridge:?}"
        );
    }
}

/// Lines of a pair of gears 17/53 whose pinion turns at 25 Hz get their names from the machine: rotations, meshes, sidebands of both.
#[test]
fn exact_lines_named_by_a_machine() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("pair.toml");
    let text = "[[inertia]]\nname = \"pinion\"\nJ = \"1 kg·m²\"\n[[inertia]]\nname = \"wheel\"\nJ = \"9 kg·m²\"\n[[gear_pair]]\nname = \"stage\"\nbetween = [\"pinion\", \"wheel\"]\nteeth = [17, 53]\n";
    std::fs::write(&model, text).unwrap();
    let (pinion, mesh) = (25.0, 425.0);
    let wheel = mesh / 53.0;
    let tones = [
        (pinion, 1.0, "rotation of pinion"),
        (wheel, 0.5, "rotation of wheel"),
        (mesh, 2.0, "mesh stage"),
        (2.0 * mesh, 0.7, "2 × mesh stage"),
        (mesh + pinion, 0.3, "mesh stage + rotation of pinion"),
        (mesh - pinion, 0.25, "mesh stage − rotation of pinion"),
        (mesh + wheel, 0.2, "mesh stage + rotation of wheel"),
        (123.4, 0.6, ""),
    ];
    let mut rng = fastrand::Rng::with_seed(5);
    let path = log(folder.path(), "ax [m/s²]", 2000.0, 80_000, |t| {
        let tone = |(f, a, _): &(f64, f64, &str)| a * (TAU * f * t).cos();
        vec![tones.iter().map(tone).sum::<f64>() + 0.1 * normal(&mut rng)]
    });
    let (file, model) = (path.to_str().unwrap(), model.to_str().unwrap());
    let base = [
        "spectrum",
        file,
        "--channel",
        "ax",
        "--model",
        model,
        "--json",
        "--speed",
    ];
    // The wheel turns at 481.13 rpm while the pinion turns at 1500.
    for (node, speed) in [("pinion", "1500"), ("wheel", "481.132075 rpm")] {
        let found = document(&[&base[..], &[speed, "--at", node]].concat());
        let peaks = found["channels"][0]["peaks"].as_array().unwrap();
        for (f, a, name) in tones {
            let apart = |p: &&Value| (p["frequency_hz"].as_f64().unwrap() - f).abs();
            let nearest = peaks.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
            let peak = nearest.unwrap();
            assert!(apart(&peak) < 0.05, "{node} {f}: {peak}");
            assert!(
                (peak["amplitude"].as_f64().unwrap() / a - 1.0).abs() < 0.1,
                "{f}: {peak}"
            );
            let names: Vec<&str> = peak["names"]
                .as_array()
                .unwrap()
                .iter()
                .map(|n| n.as_str().unwrap())
                .collect();
            match name {
                "" => assert!(names.is_empty(), "{node} {f}: {peak}"),
                name => assert_eq!(names.first(), Some(&name), "{node} {f}: {peak}"),
            }
        }
    }
    let refused = |flags: &[&str]| {
        refusal(
            &[
                &["spectrum", file, "--channel", "ax", "--model", model],
                flags,
            ]
            .concat(),
        )
        .0
    };
    assert_eq!(
        refused(&["--speed", "1500", "--at", "pignon"]),
        "unknown-node"
    );
    assert_eq!(refused(&["--at", "pinion"]), "usage");
}

/// Tones are taken off and noise stays: the level of the noise between, no tone above it.
#[test]
fn law_separation_leaves_the_noise() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(6);
    let tones = [37.0, 91.3, 222.2];
    let path = log(folder.path(), "ax [m/s²]", 1000.0, 100_000, |t| {
        let tone = |f: &f64| 2.0 * (TAU * f * t).sin();
        vec![tones.iter().map(tone).sum::<f64>() + normal(&mut rng)]
    });
    let base = [
        "spectrum",
        path.to_str().unwrap(),
        "--channel",
        "ax",
        "--resolution",
        "1",
        "--json",
    ];
    let (whole, rest) = (
        document(&base),
        document(&[&base[..], &["--separate"]].concat()),
    );
    assert!(
        rest["method_text"]
            .as_str()
            .unwrap()
            .contains("of the random part"),
        "{}",
        rest["method_text"]
    );
    let (lines, before, after) = (
        numbers(&whole["frequency_hz"]),
        numbers(&whole["channels"][0]["value"]),
        numbers(&rest["channels"][0]["value"]),
    );
    let noise = 2.0 / 1000.0;
    let away = |f: f64| tones.iter().all(|t| (t - f).abs() > 4.0) && f > 3.0;
    let between: Vec<f64> = lines
        .iter()
        .zip(&after)
        .filter(|(f, _)| away(**f))
        .map(|(_, x)| *x)
        .collect();
    let mean = between.iter().sum::<f64>() / between.len() as f64;
    assert!((mean / noise - 1.0).abs() < 0.05, "{mean}");
    for tone in tones {
        let near = |all: &[f64]| {
            let inside = lines
                .iter()
                .zip(all)
                .filter(|(f, _)| (**f - tone).abs() < 1.6);
            inside.map(|(_, x)| *x).fold(0.0, f64::max)
        };
        // A tone of amplitude 2 stands 4/(2 · 1.5 Hz) high.
        assert!(near(&before) > 0.8, "{tone}: {}", near(&before));
        assert!(near(&after) < 3.0 * noise, "{tone}: {}", near(&after));
    }
}

/// Sidebands 25 Hz apart about a mesh and its multiples in noise: the family that a cepstrum names.
#[test]
fn exact_family_of_sidebands() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(3);
    let path = log(folder.path(), "acc [g]", 6400.0, 60_000, |t| {
        let swing: f64 = (1..10)
            .map(f64::from)
            .map(|k| 0.25 * (TAU * 25.0 * k * t + 0.3 * k).cos())
            .sum();
        let mesh: f64 = (1..4)
            .map(f64::from)
            .map(|h| (1.0 + swing) * (TAU * 525.0 * h * t + h).cos() / h)
            .sum();
        vec![mesh + 0.05 * normal(&mut rng)]
    });
    let file = path.to_str().unwrap();
    let flags = [
        "spectrum",
        file,
        "--channel",
        "acc",
        "--kind",
        "cepstrum",
        "--json",
    ];
    for more in [&[][..], &["--window", "blackman-harris"]] {
        let found = document(&[&flags, more].concat());
        let peak = &found["channels"][0]["peaks"][0];
        let spacing = 1.0 / peak["quefrency_s"].as_f64().unwrap();
        within("spacing of sidebands", (spacing / 25.0 - 1.0).abs(), 1e-3);
        assert_eq!(peak["significant"], true);
        assert!(
            peak["names"][0].as_str().unwrap().starts_with("lines 25.0"),
            "{peak}"
        );
    }
}

/// A squared envelope at six times the passing of the outer ring is called so, though four times that of the inner one is near.
#[test]
fn exact_high_multiple_of_a_bearing() {
    let folder = tempfile::tempdir().unwrap();
    let outer = 25.0 * 4.5 * (1.0 - 7.94 / 39.04);
    let path = log(folder.path(), "acc [g]", 8000.0, 40_000, |t| {
        let burst: f64 = (1..8)
            .map(f64::from)
            .map(|k| 0.1 * (TAU * k * outer * 0.9999 * t).cos())
            .sum();
        vec![(1.0 + burst) * (TAU * 3000.0 * t).cos()]
    });
    let file = path.to_str().unwrap();
    let found = document(&[
        "spectrum",
        file,
        "--channel",
        "acc",
        "--kind",
        "envelope",
        "--band",
        "2000:3900",
        "--speed",
        "1500",
        "--bearing",
        "9,7.94,39.04,0",
        "--json",
    ]);
    let peaks = found["channels"][0]["peaks"].as_array().unwrap();
    let near = |p: &&Value| (p["frequency_hz"].as_f64().unwrap() - 6.0 * outer).abs() < 1.0;
    assert_eq!(peaks.iter().find(near).unwrap()["names"][0], "6 × BPFO");
}

/// The order spectrum of the shipped run-up.
fn orders_of_run_up(flags: &[&str]) -> Value {
    let of = [
        "spectrum",
        "data/run_up.csv",
        "--channel",
        "ax",
        "--kind",
        "order",
    ];
    document(&[&of[..], &["--tacho", "tacho", "--json"], flags].concat())
}

/// Orders end where half the sample rate does at the highest speed.
#[test]
fn law_orders_end_with_the_rate() {
    let found = orders_of_run_up(&[]);
    let orders = numbers(&found["order"]);
    let highest = 1000.0 / (400.0 / 60.0);
    assert!(orders.iter().all(|o| *o < highest), "{:?}", orders.last());
    let known = found["resolution"].as_f64().unwrap();
    for (peak, order) in found["channels"][0]["peaks"]
        .as_array()
        .unwrap()
        .iter()
        .zip([60.0, 30.0])
    {
        assert!(
            (peak["order"].as_f64().unwrap() - order).abs() < known,
            "{peak}"
        );
    }
}

/// Too few samples, too narrow a band, numbers without squares: each with a word of its own.
#[test]
fn refuses_what_no_spectrum_holds() {
    let folder = tempfile::tempdir().unwrap();
    let run = |samples: usize, size: f64, flags: &[&str]| {
        let path = log(folder.path(), "a [g]", 1000.0, samples, |t| {
            vec![size * ((TAU * 50.0 * t).sin() + 1e-3 * (TAU * 77.0 * t).cos())]
        });
        let file = path.to_str().unwrap().to_string();
        refusal(&[&["spectrum", &file, "--channel", "a"], flags].concat()).0
    };
    assert_eq!(run(3, 1.0, &["--kind", "spectrogram"]), "too-short");
    let envelope = ["--kind", "envelope"];
    assert_eq!(run(500, 1e100, &envelope), "out-of-range");
    assert_eq!(run(500, 1e-100, &envelope), "out-of-range");
    assert_eq!(run(500, 1e200, &[]), "out-of-range");
    let narrow = ["--kind", "envelope", "--band", "100:101"];
    assert_eq!(run(500, 1.0, &narrow), "too-short");
}

/// The shipped drive names the two orders of the shipped run-up, each once.
#[test]
fn exact_names_of_the_run_up() {
    let found = orders_of_run_up(&["--model", "models/spindle_drive.toml", "--at", "spindle"]);
    let names = |at: usize| found["channels"][0]["peaks"][at]["names"].clone();
    assert_eq!(names(0), serde_json::json!(["mesh index_drive"]));
    assert_eq!(names(1), serde_json::json!(["rotation of worm"]));
}
