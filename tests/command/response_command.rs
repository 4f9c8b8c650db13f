//! `geardyn response` as it is called.

use serde_json::Value;

use crate::support::command::{document, geardyn, put};
use crate::support::verification::within;

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
    within(
        "frequency of the peak",
        (peak["frequency_hz"].as_f64().unwrap() / natural - 1.0).abs(),
        2e-4,
    );
    within(
        "amplification",
        (peak["amplification"].as_f64().unwrap() * 0.02 - 1.0).abs(),
        1e-4,
    );
    within(
        "damping ratio",
        (peak["damping_ratio"].as_f64().unwrap() / 0.01 - 1.0).abs(),
        1e-3,
    );
    assert_eq!(peak["dominant_element"], "bar");
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
    let answer = &shown["studies"][0]["result"];
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
        (&["--band", "0:10"][..], "can turn freely"),
        (&[], "`band ="),
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
        (
            &["--band", "1:10", "--input", "shaft.force"],
            "an output only",
        ),
        (
            &["--band", "1:10", "--input", "ground.x"],
            "no element of this machine is connected",
        ),
        (&["--band", "1:10", "--input", "ground.up"], "`x`"),
    ] {
        let (code, text) = of(more);
        assert_eq!(code, Some(2), "{more:?}: {text}");
        assert!(text.contains(word), "{more:?}: {text}");
    }
}

/// Folds of the shipped pair: 0.828462 and 0.708032 of its natural frequency, by command and by file.
/// Source: Newton shooting on DOP853 of SciPy with located events; equation of A. Kahraman and R. Singh, J. Sound Vib. 142 (1990) 49.
#[test]
fn ref_folds_by_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (csv, svg) = (path("curve.csv"), path("curve.svg"));
    let found = document(&[
        "response",
        "examples/backlash_jumps.toml",
        "--harmonic-balance",
        "4000:4400:6",
        "--tolerance",
        "1e-4",
        "--json",
        "--csv",
        &csv,
        "--svg",
        &svg,
    ]);
    let natural = 2115.0 * 60.0 / 25.0;
    let fold = &found["bifurcations"][0];
    assert_eq!(fold["kind"], "fold");
    within(
        "speed of the fold",
        (fold["speed_rpm"].as_f64().unwrap() / natural - 0.82846).abs(),
        1e-4,
    );
    let points = found["points"].as_array().unwrap();
    assert!(points.iter().any(|p| p["stable"] == false));
    assert_eq!(
        std::fs::read_to_string(&csv).unwrap().lines().count(),
        points.len() + 1
    );
    assert!(std::fs::read_to_string(&svg).unwrap().contains("fold"));
}

/// One pair between two shafts: the mesh meets its natural frequency where teeth times speed is that.
#[test]
fn exact_critical_speed_of_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("map.csv").to_str().unwrap().to_string();
    let found = document(&[
        "response",
        "models/gear_pair.toml",
        "--run-up",
        "0:6000:61",
        "--json",
        "--csv",
        &csv,
    ]);
    let critical = found["critical"].as_array().unwrap();
    let modes = document(&["modes", "models/gear_pair.toml", "--json"]);
    let natural = modes["modes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|m| m["rigid"] == false)
        .unwrap();
    let natural = natural["frequency_hz"].as_f64().unwrap();
    let mesh = critical
        .iter()
        .find(|c| c["source"] == "pair: mesh")
        .unwrap();
    assert_eq!(mesh["order"], "25");
    within(
        "critical speed",
        (mesh["speed_rpm"].as_f64().unwrap() * 25.0 / 60.0 / natural - 1.0).abs(),
        1e-9,
    );
    assert_eq!(mesh["highest_strain_energy"], "pair");
    // At resonance 1 µm moves the force by k (1 + 2iζ)/(2iζ) · 1 µm and the mean stays: k = 400 N/µm, ζ = 0.05.
    let exact = 400.0 * (1.0f64 + 0.01).sqrt() / 0.1;
    within(
        "amplitude",
        (mesh["amplitude"].as_f64().unwrap() / exact - 1.0).abs(),
        1e-9,
    );
    let orders: Vec<&str> = critical
        .iter()
        .map(|c| c["order"].as_str().unwrap())
        .collect();
    assert!(
        ["24", "25", "26", "50", "75"]
            .iter()
            .all(|o| orders.contains(o)),
        "{orders:?}"
    );
    assert_eq!(std::fs::read_to_string(&csv).unwrap().lines().count(), 62);
    // Declared errors take the place of assumed ones.
    let declared = document(&[
        "response",
        "examples/backlash_jumps.toml",
        "--run-up",
        "0:6000:4",
        "--json",
    ]);
    let first = declared["excitations"]
        .as_array()
        .unwrap()
        .iter()
        .find(|e| e["order"] == "25")
        .unwrap();
    assert_eq!(
        (first["declared"].as_bool(), first["amplitude"].as_f64()),
        (Some(true), Some(2.5e-6))
    );
    // and nothing else has a size then; without any declared error all have the assumed one.
    assert_eq!(declared["assumed_amplitude_m"], Value::Null);
    let excitations = declared["excitations"].as_array().unwrap();
    for (k, e) in excitations.iter().enumerate() {
        let is_declared = e["declared"].as_bool().unwrap();
        assert_eq!(e["amplitude"].is_null(), !is_declared, "{e}");
        let column = &declared["outputs"][0]["by_excitation"][k];
        assert_eq!(column.is_null(), !is_declared);
    }
    assert!(excitations.iter().any(|e| e["declared"] == false));
    assert_eq!(found["assumed_amplitude_m"], 1e-6);
    let said = |more: &[&str]| {
        let asked = [
            "response",
            "examples/backlash_jumps.toml",
            "--run-up",
            "0:6000:4",
        ];
        String::from_utf8(geardyn(&[&asked[..], more].concat()).stdout).unwrap()
    };
    assert!(said(&[]).contains("the driver is free"), "{}", said(&[]));
    let held = said(&["--hold", "pinion.theta"]);
    assert!(held.contains("pinion.theta is prescribed"), "{held}");
}

/// Pictures have lines on every peak's circle, however far apart the lines asked for are; the CSV keeps to these.
#[test]
fn exact_pictures_follow_narrow_peaks() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (svg, csv) = (file("bode.svg"), file("lines.csv"));
    let asked = [
        "response",
        "models/y2250.toml",
        "--input",
        "motor.theta",
        "--output",
        "work_spindle.theta",
        "--band",
        "1:200",
        "--lines",
        "21",
        "--svg",
        &svg,
        "--csv",
        &csv,
    ];
    assert_eq!(geardyn(&asked).status.code(), Some(0));
    assert_eq!(std::fs::read_to_string(&csv).unwrap().lines().count(), 22);
    let points = |path: &str| {
        let text = std::fs::read_to_string(path).unwrap();
        let longest = text
            .split("<path")
            .map(|p| p.split("/>").next().unwrap_or(""));
        let longest = longest.chain(
            text.split("<polyline")
                .map(|p| p.split("/>").next().unwrap_or("")),
        );
        longest
            .map(|p| p.matches(',').count().max(p.matches('L').count()))
            .max()
            .unwrap()
    };
    for picture in [svg.clone(), file("bode-nyquist.svg")] {
        assert!(points(&picture) > 100, "{picture}: {}", points(&picture));
    }
}

#[test]
fn refuses_speeds_that_cannot_be() {
    let pair = "examples/backlash_jumps.toml";
    for (arguments, word) in [
        (&["--harmonic-balance", "0:3000:10"][..], "standstill"),
        (&["--harmonic-balance", "-100:3000:10"], "standstill"),
        (
            &["--harmonic-balance", "3000:1000:10"],
            "range of speeds: its first speed is not below its last",
        ),
        (&["--harmonic-balance", "nan:1000:10"], ""),
        (&["--harmonic-balance", "1000:3000:1"], "range of speeds"),
        (
            &["--harmonic-balance", "1000:3000", "--orders", "0"],
            "orders",
        ),
        (
            &["--harmonic-balance", "1000:3000", "--orders", "100000"],
            "orders",
        ),
        (
            &["--harmonic-balance", "1000:3000", "--tolerance", "nan"],
            "tolerance",
        ),
        (
            &["--harmonic-balance", "1000:3000", "--output", "nobody"],
            "nobody",
        ),
        (
            &["--harmonic-balance", "1000:3000", "--band", "1:2"],
            "--band",
        ),
        (&["--run-up", "3000:0:10"], "range of speeds"),
        (&["--run-up", "0:3000:10", "--output", "nobody"], "nobody"),
        (&["--orders", "3"], "--orders has no effect here"),
    ] {
        let arguments = [&["response", pair][..], arguments].concat();
        let output = geardyn(&arguments);
        let text = String::from_utf8(output.stderr).unwrap();
        let code = output.status.code();
        assert!(matches!(code, Some(2)), "{arguments:?}: {code:?} {text}");
        assert!(text.contains(word), "{arguments:?}: {text}");
    }
}

/// While contact lasts, and slowly, a pair with play driven at a prescribed speed does what a linear response says.
#[test]
fn law_balance_of_a_closed_pair_is_linear() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder
        .path()
        .join("driven.toml")
        .to_str()
        .unwrap()
        .to_string();
    let root = env!("CARGO_MANIFEST_DIR");
    let text = format!(
        "title = \"t\"\nmodel = \"{root}/models/gear_pair.toml\"\n[[motor]]\nname = \"drive\"\nat = \"pinion\"\nkind = \"speed\"\nspeed = \"4314.7 rpm\"\n[[error]]\non = \"pinion\"\ncause = \"profile\"\norder = 25\namplitude = \"1 µm\"\n"
    );
    std::fs::write(&scene, text).unwrap();
    let found = document(&[
        "response",
        &scene,
        "--harmonic-balance",
        "1200:1400:2",
        "--tolerance",
        "1e-4",
        "--json",
    ]);
    let point = &found["points"][0];
    let hertz = point["frequency_hz"].as_f64().unwrap();
    assert!((hertz - 1200.0 * 25.0 / 60.0).abs() < 1e-6, "{point}");
    let band = format!("{hertz}:{}", 2.0 * hertz);
    let linear = document(&[
        "response",
        "models/gear_pair.toml",
        "--input",
        "pair.te",
        "--output",
        "pair.deflection",
        "--hold",
        "pinion",
        "--band",
        &band,
        "--lines",
        "2",
        "--json",
    ]);
    let value = &linear["value"][0];
    let size = value["re"]
        .as_f64()
        .unwrap()
        .hypot(value["im"].as_f64().unwrap())
        * 1e-6;
    let ours = point["outputs"][0]["amplitude"].as_f64().unwrap();
    assert!((ours / size - 1.0).abs() < 1e-6, "{ours} for {size}");
}

/// What all orders make together is no less than what one of them makes at a critical speed between the speeds asked for.
#[test]
fn law_run_up_together_is_the_most() {
    let found = document(&[
        "response",
        "models/gear_pair.toml",
        "--run-up",
        "0:6000:13",
        "--json",
    ]);
    let critical = found["critical"].as_array().unwrap();
    let single = critical
        .iter()
        .filter_map(|c| c["amplitude"].as_f64())
        .fold(0.0, f64::max);
    let most = &found["outputs"][0]["most"];
    assert!(most["value"].as_f64().unwrap() >= single, "{most} {single}");
    let total = found["outputs"][0]["total"].as_array().unwrap();
    let grid = total.iter().filter_map(|t| t.as_f64()).fold(0.0, f64::max);
    assert!(most["value"].as_f64().unwrap() > grid);
}

/// Stiffness, damping and errors beyond reason end with a word, not in an overflow.
#[test]
fn survives_extreme_pairs() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (model, svg) = (file("pair.toml"), file("pair.svg"));
    let pair = |k: &str, ratio: &str, error: &str| {
        format!(
            "title = \"pair\"\nsource = \"made up\"\nunits = \"SI\"\ninertia = [{{ name = \"a\", J = 0.004 }}, {{ name = \"b\", J = 0.5 }}]\n\
             gear_pair = [{{ name = \"mesh\", between = [\"a\", \"b\"], teeth = [21, 64], module = 0.003, k = {k}, damping_ratio = {ratio} }}]\n\
             error = [{{ on = \"b\", cause = \"eccentricity\", amplitude = {error} }}]\n[speed]\na = 6.0\n"
        )
    };
    for (text, run_up, balance) in [
        (pair("1e50", "0.05", "1e-5"), 0, 3),
        (pair("1e-50", "0.05", "1e-5"), 0, 0),
        (pair("2.8e8", "1e50", "1e-5"), 0, 3),
        (pair("1e300", "0.05", "1e-5"), 2, 2),
        (pair("2.8e8", "0.05", "1e300"), 2, 2),
        (pair("2.8e8", "0.05", "nan"), 2, 2),
    ] {
        std::fs::write(&model, text).unwrap();
        let shown = geardyn(&["response", &model, "--run-up", "0:3000:7", "--svg", &svg]);
        let said = String::from_utf8_lossy(&shown.stderr).to_string();
        assert_eq!(shown.status.code(), Some(run_up), "{said}");
        let asked = ["--harmonic-balance", "100:3000:20", "--output", "b.theta"];
        let shown = geardyn(&[&["response", &model][..], &asked].concat());
        let said = String::from_utf8_lossy(&shown.stderr).to_string();
        assert_eq!(shown.status.code(), Some(balance), "{said}");
    }
}

/// Figures of the first section of a page.
fn figures_of_page(path: &str) -> Value {
    let page = std::fs::read_to_string(path).unwrap();
    let (_, data) = page
        .split_once("<script type=\"application/json\" id=\"data\">")
        .unwrap();
    let mut data: Value = serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap();
    data["sections"][0]["figures"].take()
}

/// A page alone, and the figures of `run`, once held no curve.
#[test]
fn keeps_curves_in_pages_and_in_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (scene, page, svg) = (path("scene.toml"), path("one.html"), path("one.svg"));
    let study = "model = \"one.toml\"\n[[study]]\nkind = \"response\"\nband = \"0:8\"\ninput = [\"disc\"]\noutput = [\"disc\"]\n";
    std::fs::write(path("one.toml"), ONE).unwrap();
    std::fs::write(&scene, study).unwrap();
    let (both, run) = (path("both.html"), path("run.html"));
    geardyn(&["response", &scene, "--html", &page]);
    geardyn(&["response", &scene, "--html", &both, "--svg", &svg]);
    std::fs::create_dir(path("figures")).unwrap();
    geardyn(&["run", &scene, "--html", &run, "--svg", &path("figures")]);
    let figures = figures_of_page(&both);
    assert!(figures[0]["plots"][0]["y"]["range"].is_array(), "{figures}");
    assert_eq!(figures_of_page(&page), figures);
    assert_eq!(figures_of_page(&run), figures);
    let figures = path("figures/1-response.svg");
    assert_eq!(
        std::fs::read_to_string(svg).unwrap(),
        std::fs::read_to_string(figures).unwrap()
    );
}

/// A pair driven at a prescribed speed runs at one speed on both sides, whatever its tooth numbers: speeds that differ by rounding do not.
#[test]
fn law_balance_takes_any_tooth_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let pair = |z: [u32; 2]| {
        format!(
            "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n\
             inertia = [{{ name = \"a\", J = 0.01 }}, {{ name = \"b\", J = 0.02 }}, {{ name = \"c\", J = 0.03 }}]\n\
             shaft = [{{ name = \"s\", between = [\"b\", \"c\"], k = 2e4, c = 5.0 }}]\n\
             gear_pair = [{{ name = \"g\", between = [\"a\", \"b\"], teeth = {z:?}, module = 3e-3, k = 3e8, c = 2e3, \
             k_wave = {{ kind = \"fourier\", amplitudes = [0.1] }} }}]\n\
             motor = [{{ name = \"m\", at = \"a\", kind = \"speed\", speed = \"1450 rpm\" }}]\n\
             load = [{{ at = \"c\", torque = 50.0 }}]\nspeed = {{ a = \"1450 rpm\" }}\n"
        )
    };
    for teeth in [[17, 53], [29, 31], [23, 71], [13, 47], [19, 97]] {
        let path = put(folder.path(), "pair.toml", &pair(teeth));
        let path = path.to_str().unwrap();
        let found = document(&[
            "response",
            path,
            "--harmonic-balance",
            "1400:1500:3",
            "--json",
        ]);
        assert!(found["points"].as_array().unwrap().len() >= 3, "{teeth:?}");
    }
}
