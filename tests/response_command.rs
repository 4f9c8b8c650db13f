//! `geardyn response` as it is called.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot go on has failed"
)]

use std::process::{Command, Output};

use serde_json::Value;

fn geardyn(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .output()
        .unwrap()
}

fn document(arguments: &[&str]) -> Value {
    let output = geardyn(arguments);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| {
        panic!(
            "{arguments:?}: {e}\n{}",
            String::from_utf8_lossy(&output.stderr)
        )
    })
}

const ONE: &str = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\ninertia = [{ name = \"disc\", J = 2.0 }]\nshaft = [{ name = \"bar\", between = [\"ground\", \"disc\"], k = 800.0, damping_ratio = 0.01 }]\n";

/// The peak of one freedom: 1/(2ζ) times the answer at rest, half power ζ wide; the same in every format.
#[test]
fn exact_peak_of_one_freedom() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (model, csv, svg) = (path("one.toml"), path("one.csv"), path("one.svg"));
    std::fs::write(&model, ONE).unwrap();
    let arguments = [
        "response", &model, "--input", "disc", "--output", "disc", "--band", "0:8", "--lines",
        "41", "--json", "--csv", &csv, "--svg", &svg,
    ];
    let found = document(&arguments);
    let peak = &found["peaks"][0];
    let natural = 20.0 / std::f64::consts::TAU;
    assert!((peak["frequency_hz"].as_f64().unwrap() / natural - 1.0).abs() < 2e-4);
    assert!((peak["amplification"].as_f64().unwrap() * 0.02 - 1.0).abs() < 1e-4);
    assert!((peak["damping_ratio"].as_f64().unwrap() / 0.01 - 1.0).abs() < 1e-3);
    assert_eq!(peak["mostly"], "bar");
    assert_eq!(found["peaks"].as_array().unwrap().len(), 1);
    let first = &found["responses"][0];
    assert_eq!(
        (first["unit"].as_str(), first["at_rest"].as_f64()),
        (Some("rad/(N·m)"), Some(1.0 / 800.0))
    );
    let rows: Vec<String> = std::fs::read_to_string(&csv)
        .unwrap()
        .lines()
        .map(str::to_string)
        .collect();
    assert_eq!(rows.len(), 42);
    let (line, value) = (&rows[18], &found["value"][17]);
    let cells: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
    assert_eq!(
        cells,
        [
            found["frequency_hz"][17].as_f64().unwrap(),
            value["re"].as_f64().unwrap(),
            value["im"].as_f64().unwrap()
        ]
    );
    for picture in [svg.clone(), svg.replace(".svg", "-nyquist.svg")] {
        assert!(
            std::fs::read_to_string(picture)
                .unwrap()
                .contains("disc by disc")
        );
    }
    // As acceleration the same is larger by ω².
    let scene = path("scene.toml");
    let text = "model = \"one.toml\"\n[[study]]\nkind = \"response\"\ninputs = [\"disc\"]\noutputs = [\"disc\"]\nshown = \"accelerance\"\nband = \"1:8\"\nlines = 8\n";
    std::fs::write(&scene, text).unwrap();
    let shown = document(&["run", &scene, "--json"]);
    let answer = &shown["studies"][0]["answer"];
    assert_eq!(answer["responses"][0]["unit"], "rad/s²/(N·m)");
    let omega = 2.0 * std::f64::consts::TAU;
    let exact = -omega * omega / (800.0 - 2.0 * omega * omega);
    assert!((answer["value"][1]["re"].as_f64().unwrap() / exact - 1.0).abs() < 1e-3);
    let plan = String::from_utf8(geardyn(&["plan", &scene]).stdout).unwrap();
    assert!(plan.contains("dynamic stiffness"), "{plan}");
}

/// One way and the other, from the command; the error of the modes is stated.
#[test]
fn law_ways_agree() {
    let of = |way: &str| {
        document(&[
            "response",
            "models/y2250.toml",
            "--input",
            "index_drive.te",
            "--output",
            "workpiece,index_drive.force",
            "--hold",
            "motor",
            "--band",
            "0:400",
            "--lines",
            "101",
            "--method",
            way,
            "--json",
        ])
    };
    let (direct, modal) = (of("direct"), of("modal"));
    assert_eq!(
        (direct["method"].as_str(), modal["method"].as_str()),
        (Some("direct"), Some("complex modes"))
    );
    assert!(modal["error"].as_f64().unwrap() < 1e-10);
    assert!(direct["error"].is_null());
    for pair in 0..2 {
        let values = |d: &Value| -> Vec<(f64, f64)> {
            let list = d["responses"][pair]["value"].as_array().unwrap();
            list.iter()
                .map(|z| (z["re"].as_f64().unwrap(), z["im"].as_f64().unwrap()))
                .collect()
        };
        let (d, m) = (values(&direct), values(&modal));
        let largest = d.iter().fold(0.0f64, |s, z| s.max(z.0.hypot(z.1)));
        assert!(
            d.iter()
                .zip(&m)
                .all(|(a, b)| (a.0 - b.0).hypot(a.1 - b.1) < 1e-10 * largest)
        );
    }
    // At rest the driven angle follows the imposed error by the ratio alone: 1/(r of the wheel) on a tree.
    let rest = direct["responses"][0]["at_rest"].as_f64().unwrap();
    let radius = 0.5 * 0.555 / 555.0 * 540.0 * 20f64.to_radians().cos();
    assert!(
        rest > 0.9 / radius && rest < 1.2 / radius,
        "{rest} {radius}"
    );
}

#[test]
fn refuses_with_exit_two() {
    let free = [
        "response",
        "models/two_disc.toml",
        "--input",
        "disc_1",
        "--output",
        "disc_2",
    ];
    let of = |more: &[&str]| {
        let output = geardyn(&[&free[..], more].concat());
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    for (more, word) in [
        (&["--band", "0:10"][..], "free to turn away"),
        (&[], "--band"),
        (&["--band", "10:1"], "is not a band"),
        (&["--band", "nan:1"], "nan"),
        (&["--band", "1:1e400"], ""),
        (&["--band", "1:10", "--lines", "1"], "--lines"),
        (&["--band", "1:10", "--hold", "disc_7"], "disc_7"),
        (
            &[
                "--band",
                "1:10",
                "--hold",
                "disc_2",
                "--input",
                "shaft.motion",
            ],
            "shaft",
        ),
        (&["--band", "1:10", "--input", "shaft.force"], "driven"),
        (
            &["--band", "1:10", "--input", "ground.x"],
            "nothing of this machine",
        ),
        (&["--band", "1:10", "--input", "ground.up"], "`x`"),
    ] {
        let (code, text) = of(more);
        assert_eq!(code, Some(2), "{more:?}: {text}");
        assert!(text.contains(word), "{more:?}: {text}");
    }
}
