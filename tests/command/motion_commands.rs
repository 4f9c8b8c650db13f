//! `simulate`, `run`, `accuracy`, `stability` and `plan` of scenes, as they are called.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::command::{document, geardyn, printed, put, said};

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// JSON, CSV and picture of one motion hold the same numbers; the table ends with them.
#[test]
fn law_outputs_of_simulate_agree() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, svg) = (folder.path().join("x.csv"), folder.path().join("x.svg"));
    let (csv, svg) = (csv.to_str().unwrap(), svg.to_str().unwrap());
    let arguments = [
        "simulate",
        "examples/linear_chain.toml",
        "--until",
        "50 ms",
        "--samples",
        "50",
        "--energy",
        "--json",
        "--csv",
        csv,
        "--svg",
        svg,
    ];
    let found = document(&arguments);
    assert_eq!(found["method"], "exact");
    let (time, values) = (
        found["time_s"].as_array().unwrap(),
        found["outputs"]["chain.20.theta_rad"].as_array().unwrap(),
    );
    assert_eq!((time.len(), values.len()), (51, 51));
    assert_eq!(time[50], 0.05);
    let rows: Vec<String> = std::fs::read_to_string(csv)
        .unwrap()
        .lines()
        .map(str::to_string)
        .collect();
    assert_eq!(rows.len(), 52);
    assert!(
        rows[0].starts_with("time [s],chain.20.theta [rad]"),
        "{}",
        rows[0]
    );
    let cells: Vec<f64> = rows[51].split(',').map(|c| c.parse().unwrap()).collect();
    assert_eq!(cells[1], values[50].as_f64().unwrap());
    assert!(found["energy_balance"]["gap"].as_f64().unwrap().abs() < 1e-6);
    assert!(
        std::fs::read_to_string(svg)
            .unwrap()
            .contains("chain.20.theta.speed")
    );
    assert_eq!(found["effort"]["linear_machines"], 1);
}

/// A method by its word gives what the exact one gives, to what its tolerance promises; a step is for those that take one.
#[test]
fn law_methods_agree_from_the_command() {
    let end = |method: &str, how: [&str; 2]| {
        let found = document(&[
            "simulate",
            "examples/geared_chain.toml",
            "--until",
            "0.02",
            "--samples",
            "20",
            "--method",
            method,
            how[0],
            how[1],
            "--json",
        ]);
        found["outputs"]["b20.theta.speed_rad_s"][20]
            .as_f64()
            .unwrap_or_else(|| panic!("{method}: {found}"))
    };
    let exact = end("switched", ["--tolerance", "1e-8"]);
    for (method, how, close) in [
        ("radau5", ["--tolerance", "1e-9"], 1e-7),
        ("dop853-events", ["--tolerance", "1e-10"], 1e-7),
        ("newmark", ["--step", "1 us"], 1e-4),
    ] {
        let other = end(method, how);
        assert!(
            (other / exact - 1.0).abs() < close,
            "{method}: {other} {exact}"
        );
    }
}

/// The study of accuracy: an exact reference confirmed by another method, errors that fall with the tolerance, every failure told.
#[test]
fn law_accuracy_orders_errors() {
    let folder = tempfile::tempdir().unwrap();
    let svg = folder.path().join("a.svg");
    let arguments = [
        "accuracy",
        "examples/backlash_pair.toml",
        "--until",
        "2 ms",
        "--samples",
        "100",
        "--methods",
        "exact,switched,radau5",
        "--json",
        "--svg",
        svg.to_str().unwrap(),
    ];
    let found = document(&arguments);
    assert!(
        found["reference"]["error"].as_f64().unwrap() < 1e-9,
        "{}",
        found["reference"]
    );
    let runs = found["runs"].as_array().unwrap();
    let refused = runs.iter().find(|r| r["method"] == "exact").unwrap();
    assert!(refused["error"].is_null() && refused["status"].as_str().unwrap().contains("linear"));
    let errors: Vec<f64> = runs
        .iter()
        .filter(|r| r["method"] == "radau5")
        .map(|r| r["error"].as_f64().unwrap())
        .collect();
    assert_eq!(errors.len(), 6);
    assert!(
        errors[5] < 1e-8 && errors[0] > 1e3 * errors[5],
        "{errors:?}"
    );
    assert!(
        runs.iter()
            .all(|r| r["method"] == "exact" || r["run_time_s"].as_f64().unwrap() > 0.0)
    );
    assert!(found["recommendation"]["method"].is_string());
    assert!(std::fs::read_to_string(svg).unwrap().contains("radau5"));
    let table = text(&geardyn(&[
        "accuracy",
        "examples/backlash_pair.toml",
        "--until",
        "2 ms",
        "--samples",
        "100",
        "--methods",
        "switched",
    ]));
    assert!(
        table.contains("reference: switched; ") && table.contains("for 1e-8"),
        "{table}"
    );
}

/// The study of stability: a step limit in closed form, verdicts for every case, exit code 1 where one failed and only there.
#[test]
fn law_stability_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let svg = folder.path().join("r.svg");
    let arguments = [
        "stability",
        "examples/linear_chain.toml",
        "--until",
        "0.001",
        "--methods",
        "exact",
        "--json",
        "--svg",
        svg.to_str().unwrap(),
    ];
    let output = geardyn(&arguments);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let omega = 2.0 * (8000.0f64 / 0.02).sqrt() * (39.0 * std::f64::consts::PI / 82.0).sin();
    assert!((found["linear"]["fastest_rad_s"].as_f64().unwrap() / omega - 1.0).abs() < 1e-9);
    // Runge–Kutta of order 4 reaches 2√2 on the imaginary axis; light damping moves it by little.
    let limit = found["linear"]["step_limits_s"]["rk4"].as_f64().unwrap();
    assert!(
        (limit * omega / 8.0f64.sqrt() - 1.0).abs() < 0.02,
        "{limit}"
    );
    let cases = found["cases"].as_array().unwrap();
    assert!(cases.len() + found["left_out"].as_array().unwrap().len() >= 14);
    let failed = cases.iter().any(|c| c["verdict"] == "fail");
    assert_eq!(output.status.code(), Some(i32::from(failed)));
    assert!(
        cases
            .iter()
            .all(|c| c["verdict"] == "pass" || c["reason"].is_string()),
        "{cases:?}"
    );
    assert!(
        cases
            .iter()
            .any(|c| c["case"] == "stiffness × 1e6" && c["verdict"] == "pass")
    );
    assert!(std::fs::read_to_string(svg).unwrap().contains("dop853"));
}

/// Parametric stability from the command: the principal region of a lightly damped mesh lies about twice its natural frequency.
#[test]
fn law_stability_finds_the_principal_region() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("s.toml");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/gear_pair.toml");
    let text = format!(
        "model = {:?}\n[set]\n\"pair.k_wave\" = {{ kind = \"fourier\", amplitudes = [0.4] }}\n\"pair.damping_ratio\" = 0.02\n[start]\nat = \"steady\"\nmesh_phase = \"speed\"\n[[study]]\nkind = \"stability\"\nuntil = \"1 ms\"\nmethods = [\"periodic\"]\nspeeds = \"8000:12000:41\"\n",
        model.to_str().unwrap()
    );
    std::fs::write(&scene, text).unwrap();
    let found = document(&["stability", scene.to_str().unwrap(), "--json"]);
    let tongues = found["floquet"]["tongues"].as_array().unwrap();
    // x″ + 2ζx′ + (1 + 0.4 cos Wt) x = 0 at ζ = 0.02: W from 1.79960885906 to 2.19017468393 (Floquet's theory, DOP853 at 1e-13).
    let natural = (4e8f64 / (0.01 / (2.0 * (0.05 * 20f64.to_radians().cos()).powi(2)))).sqrt()
        / std::f64::consts::TAU;
    let edge = |key: &str| tongues[0][key].as_f64().unwrap() / natural;
    assert_eq!(tongues.len(), 1, "{tongues:?}");
    assert!(
        (edge("from_hz") - 1.79960885906).abs() < 1e-5
            && (edge("to_hz") - 2.19017468393).abs() < 1e-5,
        "{} {}",
        edge("from_hz"),
        edge("to_hz")
    );
    // Over a second axis: the same where the factor is one, first-order theory at half the depth, no region beyond ζ = ε/4.
    let rows = |over: &str| {
        let found = document(&[
            "stability",
            scene.to_str().unwrap(),
            "--over",
            over,
            "--json",
        ]);
        found["floquet"]["chart"]["rows"]
            .as_array()
            .unwrap()
            .clone()
    };
    let depth = rows("depth=0.5:1:2");
    assert_eq!(depth[1]["tongues"][0]["from_hz"], tongues[0]["from_hz"]);
    let half = (depth[0]["tongues"][0]["to_hz"].as_f64().unwrap()
        - depth[0]["tongues"][0]["from_hz"].as_f64().unwrap())
        / (2.0 * natural);
    // First order in ε (Nayfeh and Mook 1979, sec. 5.2.2): W = 2 ± √(ε²/4 − 4 ζ²).
    assert!(
        (half / (0.01f64 - 0.0016).sqrt() - 1.0).abs() < 0.01,
        "{half}"
    );
    let damping = rows("damping=1:6:2");
    assert_eq!(damping[0]["tongues"].as_array().unwrap().len(), 1);
    assert!(damping[1]["tongues"].as_array().unwrap().is_empty());
    for (over, said) in [
        ("depth=1:0:3", "not a second axis"),
        ("width=0:1:3", "not a second axis"),
        ("depth=0:3:4", "falls to zero or below"),
        ("depth=0:1e300:3", "at 5e299 times its depth"),
    ] {
        let output = geardyn(&["stability", scene.to_str().unwrap(), "--over", over]);
        assert_eq!(output.status.code(), Some(2));
        assert!(
            String::from_utf8_lossy(&output.stderr).contains(said),
            "{over}"
        );
    }
}

/// `run` carries out the studies in their order; `plan` announces the methods they take.
#[test]
fn law_run_and_plan_of_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("s.toml");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/chain_20.toml");
    let text = format!(
        "model = {:?}\n[[load]]\nat = \"chain.20\"\nkind = \"step\"\ntorque = \"5 N·m\"\ntime = \"1 ms\"\n[[study]]\nkind = \"modes\"\nlowest = 3\n[[study]]\nkind = \"simulate\"\nuntil = \"20 ms\"\noutputs = [\"chain.20.theta\"]\n",
        model.to_str().unwrap()
    );
    std::fs::write(&scene, text).unwrap();
    let path = scene.to_str().unwrap();
    let found = document(&["run", path, "--json"]);
    let studies = found["studies"].as_array().unwrap();
    assert_eq!(studies[0]["result"]["modes"].as_array().unwrap().len(), 3);
    assert_eq!(studies[1]["result"]["method"], "exact");
    let printed = text_of(&["run", path]);
    assert!(
        printed.find("── modes").unwrap() < printed.find("── simulate").unwrap(),
        "{printed}"
    );
    let plan = document(&["plan", path, "--json"]);
    let stages = plan["motions"][0]["stages"].as_array().unwrap();
    let method = stages.iter().find(|s| s["stage"] == "method").unwrap();
    assert!(
        method["what"].as_str().unwrap().starts_with("exact"),
        "{method}"
    );
    assert!(text_of(&["plan", path]).contains("── simulate"));
    assert_eq!(
        geardyn(&["run", "models/two_disc.toml"]).status.code(),
        Some(2)
    );
}

fn text_of(arguments: &[&str]) -> String {
    text(&geardyn(arguments))
}

/// The flags of motion say what is planned as they say what is simulated; of a model alone they plan a motion.
#[test]
fn law_plan_takes_the_flags_of_motion() {
    let method = |arguments: &[&str]| {
        let plan = document(&[&["plan"], arguments, &["--json"]].concat());
        let stages = plan["motions"][0]["stages"].as_array().unwrap().clone();
        let method = stages.into_iter().find(|s| s["stage"] == "method");
        method.unwrap()["what"].as_str().unwrap().to_string()
    };
    let chain = "examples/linear_chain.toml";
    assert!(method(&[chain]).starts_with("exact"));
    assert!(method(&[chain, "--step", "1 ms", "--method", "newmark"]).starts_with("newmark"));
    assert!(method(&[chain, "--tolerance", "1e-6", "--method", "radau5"]).starts_with("radau5"));
    assert!(method(&["models/two_disc.toml", "--until", "1"]).starts_with("exact"));
    let plan = document(&["plan", "models/two_disc.toml", "--json"]);
    assert!(plan["motions"].as_array().unwrap().is_empty());
}

/// A model alone, and a scene that says nothing of time: linear facts and multipliers need none, the extremes are left out by name.
#[test]
fn law_stability_without_a_duration() {
    for file in [
        "models/y2250.toml",
        "models/two_disc.toml",
        "examples/backlash_jumps.toml",
    ] {
        let found = document(&["stability", file, "--json"]);
        assert!(found["linear"]["fastest_rad_s"].as_f64().unwrap() > 0.0);
        assert!(found["cases"].as_array().unwrap().is_empty());
        let left = &found["left_out"][0];
        assert_eq!(left["case"], "all extremes");
        assert!(left["reason"].as_str().unwrap().contains("--until"));
    }
    let found = document(&["stability", "examples/backlash_jumps.toml", "--json"]);
    let largest = &found["floquet"]["largest_multiplier"];
    assert!(largest.is_number() || found["floquet"]["left_out"].is_string());
}

/// Wrong words end with 2 and say what would be right; a hopeless request ends with 3.
#[test]
fn refused_with_words() {
    let cases: [(&[&str], i32, &str); 7] = [
        (&["simulate", "models/two_disc.toml"], 2, "--until"),
        (
            &["simulate", "examples/linear_chain.toml", "--until", "0 s"],
            2,
            "above zero",
        ),
        (
            &[
                "simulate",
                "examples/linear_chain.toml",
                "--method",
                "exakt",
            ],
            2,
            "did you mean `exact`",
        ),
        (
            &[
                "simulate",
                "examples/linear_chain.toml",
                "--output",
                "chain.99",
            ],
            2,
            "chain.99",
        ),
        (
            &["simulate", "examples/linear_chain.toml", "--tolerance", "2"],
            2,
            "below 1",
        ),
        (
            &[
                "simulate",
                "examples/backlash_pair.toml",
                "--method",
                "exact",
            ],
            2,
            "linear",
        ),
        (
            &["simulate", "models/y2250.toml", "--until", "1 s"],
            2,
            "contact_damping",
        ),
    ];
    for (arguments, code, word) in cases {
        let output = geardyn(arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(word), "{arguments:?}: {said}");
    }
    let hopeless = geardyn(&[
        "simulate",
        "examples/stiff_chain.toml",
        "--method",
        "rk4",
        "--step",
        "1e-12",
        "--until",
        "1e6",
        "--json",
    ]);
    assert_eq!(hopeless.status.code(), Some(3));
    let found: Value = serde_json::from_slice(&hopeless.stdout).unwrap();
    assert_eq!(found["errors"][0]["code"], "budget-exceeded", "{found}");
}

/// What a command prints that Ctrl-C ends after so many milliseconds.
#[cfg(unix)]
fn interrupted(arguments: &[&str], after: u64) -> Value {
    let child = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(after));
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    let raised = Instant::now();
    let output = child.wait_with_output().unwrap();
    assert!(raised.elapsed() < Duration::from_secs(10), "not heard");
    assert_eq!(
        output.status.code(),
        Some(130),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Ctrl-C ends a long run with 130 and prints what was finished, whole.
#[cfg(unix)]
#[test]
fn law_interrupted_run_is_whole() {
    let output = "b1.theta.speed";
    let chain = ["simulate", "examples/geared_chain.toml", "--json"];
    let long = ["--until", "300", "--output", output, "--method", "radau5"];
    let found = interrupted(
        &[&chain[..], &long[..], &["--samples", "300000"]].concat(),
        1500,
    );
    assert_eq!(found["interrupted"], true);
    let time = found["time_s"].as_array().unwrap().len();
    let values = found["outputs"]["b1.theta.speed_rad_s"].as_array().unwrap();
    assert!(time > 1 && time == values.len());
}

/// It is heard between two steps of a method where no sample is near.
#[cfg(unix)]
#[test]
fn law_interrupted_between_samples() {
    // Long, and within what is allowed.
    for (method, until) in [
        ("radau5", "300"),
        ("switched", "1000"),
        ("dopri5", "100"),
        ("newmark", "10"),
    ] {
        let mut arguments = vec![
            "simulate",
            "examples/geared_chain.toml",
            "--json",
            "--until",
            until,
            "--samples",
            "2",
            "--method",
            method,
        ];
        if method == "newmark" {
            arguments.extend(["--step", "1 µs"]);
        }
        let found = interrupted(&arguments, 1000);
        assert_eq!(found["interrupted"], true, "{method}");
        assert!(found["time_s"].as_array().unwrap().len() < 2, "{method}");
    }
}

/// A run that Ctrl-C ends shows the studies finished before, and that it was ended.
#[cfg(unix)]
#[test]
fn law_interrupted_scenes_keep_finished_studies() {
    let folder = tempfile::tempdir().unwrap();
    let pair = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/backlash_pair.toml");
    let pair = std::fs::read_to_string(pair).unwrap();
    let (scene, _) = pair.split_once("[[study]]").unwrap();
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/");
    let scene = scene.replace("../models/", models.to_str().unwrap());
    let studies = "[[study]]\nkind = \"modes\"\n[[study]]\nkind = \"accuracy\"\nuntil = \"0.5 s\"\nerror = 1e-9\n";
    let path = put(folder.path(), "two.toml", &format!("{scene}{studies}"));
    let path = path.to_str().unwrap();
    // A slow machine may not have finished the first study yet.
    let found = [500, 2000, 8000, 30_000]
        .into_iter()
        .map(|wait| interrupted(&["run", path, "--json"], wait))
        .find(|found| found["studies"].is_array())
        .unwrap();
    assert_eq!(found["studies"][0]["study"], "modes");
    assert_eq!(found["interrupted"], true);
    assert!(found["studies"][0]["result"]["modes"].is_array());
}

/// Studies show what was finished: rungs of a ladder, cases of the extremes.
#[cfg(unix)]
#[test]
fn law_interrupted_studies_are_whole() {
    // A reference in a blink, and then the fixed steps of the ladder.
    let pair = "examples/backlash_pair.toml";
    let found = interrupted(&["accuracy", pair, "--json", "--until", "0.002"], 3000);
    let runs = found["runs"].as_array().unwrap();
    assert!(runs.iter().any(|run| run["method"] == "switched"));
    assert_eq!(found["interrupted"], true);
    let found = interrupted(&["stability", pair, "--json"], 2500);
    assert_eq!(found["interrupted"], true);
    assert!(found["cases"].is_array());
    assert!(found["linear"]["fastest_rad_s"].as_f64().unwrap() > 0.0);
}

/// What a study asks in vain is said with its place; cases that change nothing are left out by name.
#[test]
fn refused_studies_name_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("s.toml");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/two_disc.toml");
    let model = model.to_str().unwrap();
    let study = "[[study]]\nkind = \"simulate\"\n";
    for (text, flags, said) in [
        (
            format!("model = {model:?}\n{study}until = \"1 ms\"\nmethod = \"foo\"\n"),
            &[][..],
            "s.toml:2",
        ),
        (
            format!("model = {model:?}\n{study}until = \"1 ms\"\noutputs = [\"q.force\"]\n"),
            &[],
            "s.toml:2",
        ),
        (format!("model = {model:?}\n{study}"), &[], "s.toml:2"),
        (study.to_string(), &[], "a scene must name its model"),
        (
            format!("model = {model:?}\n[[load]]\nat = \"disc_1\"\nkind = \"dance\"\ntempo = 3\n"),
            &[],
            "cannot be \"dance\"",
        ),
        (
            format!("model = {model:?}\n"),
            &["--until", "1e-3", "--method", "rk4", "--step", "1"],
            "exceeds the duration",
        ),
        (
            format!("model = {model:?}\n"),
            &["--until", "1e-3", "--csv", "-"],
            "`-` is not a file name",
        ),
    ] {
        std::fs::write(&scene, text).unwrap();
        let output = geardyn(&[&["simulate", scene.to_str().unwrap()][..], flags].concat());
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(said), "{error}");
        assert!(!error.contains("tempo"), "{error}");
    }
    std::fs::write(&scene, format!("model = {model:?}\n")).unwrap();
    let found = document(&[
        "stability",
        scene.to_str().unwrap(),
        "--until",
        "1e-3",
        "--methods",
        "exact",
        "--json",
    ]);
    let left: Vec<&str> = found["left_out"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["case"].as_str().unwrap())
        .collect();
    assert_eq!(
        left,
        ["backlash 0", "backlash × 1e4", "speed 0", "speed × 100"]
    );
    let cases = found["cases"].as_array().unwrap();
    assert!(
        cases
            .iter()
            .all(|c| !left.contains(&c["case"].as_str().unwrap()))
    );
}

/// `J ω̇ = stall (1 − ω/idle) + T`: a constant load against the motor slows it to `idle (1 + T/stall)`; one that pushes its way stood
/// for it.
#[test]
fn exact_loads_on_the_node_of_a_motor() {
    let folder = tempfile::tempdir().unwrap();
    for (torque, share) in [(-10.0, 0.8), (10.0, 1.0)] {
        let text = format!(
            "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\ninertia = [{{ name = \"a\", J = 0.5 }}]\n\
             motor = [{{ name = \"m\", at = \"a\", kind = \"dc\", stall = 50.0, idle = 150.0 }}]\n\
             load = [{{ at = \"a\", torque = {torque} }}]\n"
        );
        let scene = put(folder.path(), "motor.toml", &text);
        let scene = scene.to_str().unwrap();
        let found = printed(&[
            "simulate",
            scene,
            "--until",
            "60",
            "--output",
            "a.theta.speed",
            "--json",
        ]);
        let speed = found["readings"]["a.theta.speed_rad_s"]["end"]
            .as_f64()
            .unwrap();
        assert!((speed - 150.0 * share).abs() < 1e-8, "{torque}: {speed}");
    }
}

/// The structure of equations that nothing but their loads makes nonlinear names those loads.
#[test]
fn law_structure_names_loads_in_bursts() {
    let folder = tempfile::tempdir().unwrap();
    let text = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\ninertia = [{ name = \"a\", J = 0.5 }]\n\
         load = [{ at = \"a\", kind = \"product\", torque = 5.0, factors = [{ kind = \"step\", time = 0.5 }, { kind = \"harmonic\", frequency = 30.0 }] }]\n";
    let scene = put(folder.path(), "burst.toml", text);
    let (code, _, words) = said(&["simulate", scene.to_str().unwrap(), "--until", "1"]);
    assert_eq!(code, Some(0), "{words}");
    assert!(
        words.contains("(1 piecewise quadratic or burst load or motion)"),
        "{words}"
    );
}

/// A time beyond the range of numbers is refused before the work.
#[test]
fn refused_where_numbers_end() {
    let arguments = ["simulate", "examples/linear_chain.toml", "--until", "1e300"];
    let (code, _, words) = said(&arguments);
    assert_eq!(code, Some(2), "{words}");
    assert!(
        words.contains("[out-of-range]") && words.contains("--until 1e300"),
        "{words}"
    );
}

/// Samples a whole period of the mesh apart see one phase of it: that is said, and how many would do.
#[test]
fn law_coarse_samples_are_told() {
    let pair = ["simulate", "examples/backlash_pair.toml", "--until", "0.02"];
    let codes = |samples: &str| {
        let found = printed(&[&pair[..], &["--samples", samples, "--json"]].concat());
        let warnings = found["warnings"].as_array().unwrap().clone();
        let coarse = warnings.iter().filter(|w| w["code"] == "coarse-samples");
        coarse.count()
    };
    assert_eq!((codes("50"), codes("2000")), (1, 0));
}

/// Two discs of 1 kg·m² on a shaft that swings at 10 Hz, wound up.
fn swinging(folder: &Path) -> String {
    let k = 0.5 * (20.0 * std::f64::consts::PI).powi(2);
    let text = format!(
        "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\ninertia = [{{ name = \"a\", J = 1.0 }}, {{ name = \"b\", J = 1.0 }}]\n\
         shaft = [{{ name = \"s\", between = [\"a\", \"b\"], k = {k} }}]\n"
    );
    put(folder, "swing.toml", &text);
    let scene = "model = \"swing.toml\"\n[start]\nangle = { a = \"0.1 rad\" }\n";
    put(folder, "swings.toml", scene)
        .to_str()
        .unwrap()
        .to_string()
}

/// The warnings of a code in a run.
fn told(arguments: &[&str], code: &str) -> Vec<String> {
    let found = printed(&[arguments, &["--json"]].concat());
    let warnings = found["warnings"].as_array().unwrap().clone();
    let of = warnings.iter().filter(|w| w["code"] == code);
    of.map(|w| format!("{} {}", w["message"], w["hint"]))
        .collect()
}

/// Free vibration at 10 Hz read from fewer than five samples in a period, and from far fewer than one: said of every quantity, with
/// how many lie in it; from ten and more it is not.
#[test]
fn law_coarse_samples_of_free_vibration_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = swinging(folder.path());
    for output in [
        "s.deflection",
        "s.force",
        "a.theta.speed",
        "b.theta.acceleration",
    ] {
        for (samples, per_period) in [
            ("997", None),
            ("4999", None),
            ("347", Some(3.47)),
            ("97", Some(0.97)),
            ("13", Some(0.13)),
        ] {
            let said = told(
                &[
                    "simulate",
                    &scene,
                    "--until",
                    "10",
                    "--output",
                    output,
                    "--samples",
                    samples,
                ],
                "coarse-samples",
            );
            match per_period {
                None => assert!(said.is_empty(), "{output} {samples}: {said:?}"),
                Some(expected) => {
                    let number = said[0].split("oscillates with ").nth(1).unwrap();
                    let number: f64 = number.split(' ').next().unwrap().parse().unwrap();
                    // The mean over fourteen samples or more of a sine's size.
                    assert!((number / expected - 1.0).abs() < 0.2, "{output}: {said:?}");
                }
            }
        }
    }
}

/// What advice says of samples and times can be followed: with it nothing is said any more.
#[test]
fn law_advice_on_samples_can_be_followed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = swinging(folder.path());
    let output = ["simulate", &scene, "--output", "s.deflection"];
    // 347 samples of 100 periods; 97 of 1e9 periods, of which 20 each are more than can be asked for.
    for (until, samples, by) in [("10", "347", "--samples"), ("1e8", "97", "--until")] {
        let asked = [&output[..], &["--until", until, "--samples", samples]].concat();
        let said = told(&asked, "coarse-samples");
        let advice = said[0].split(by).nth(1).unwrap().replace(['\\', '"'], "");
        let advice = advice.split(" gives").next().unwrap().trim().to_string();
        let followed = match by {
            "--samples" => ["--until", until, "--samples", &advice],
            _ => ["--until", &advice, "--samples", samples],
        };
        let quiet = told(&[&output[..], &followed].concat(), "coarse-samples");
        assert!(quiet.is_empty(), "{said:?} {quiet:?}");
    }
}

/// A fixed step beyond the limit of an explicit method, or of a few to a period of 10 Hz, is told with the limit and the branch.
#[test]
fn law_long_steps_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = swinging(folder.path());
    for (method, step, words) in [
        // 2.97 over 62.8 rad/s.
        ("rk4", "50 ms", Some("stability limit of 47.3 ms")),
        ("rk4", "25 ms", Some("4.00 steps per period")),
        ("rk4", "15 ms", None),
        ("newmark", "25 ms", Some("4.00 steps per period")),
        ("generalized-alpha", "0.1 s", Some("1.00 steps per period")),
        ("hht", "8 ms", None),
    ] {
        let said = told(
            &[
                "simulate", &scene, "--until", "0.3", "--method", method, "--step", step,
            ],
            "long-step",
        );
        match words {
            None => assert!(said.is_empty(), "{method} {step}: {said:?}"),
            Some(words) => assert!(
                said[0].contains(words) && said[0].contains("10.0 Hz, has"),
                "{method} {step}: {said:?}"
            ),
        }
    }
}

/// A method named twice is one.
#[test]
fn law_methods_named_twice_run_once() {
    let found = printed(&[
        "accuracy",
        "examples/linear_chain.toml",
        "--until",
        "0.001",
        "--methods",
        "newmark,newmark",
        "--methods",
        "newmark",
        "--json",
    ]);
    let runs = found["runs"].as_array().unwrap();
    let steps: Vec<f64> = runs.iter().filter_map(|r| r["step_s"].as_f64()).collect();
    assert_eq!(steps.len(), runs.len());
    assert!(
        steps.len() > 1 && steps.windows(2).all(|p| p[1] < p[0]),
        "{steps:?}"
    );
}

/// Numbers of hundreds of digits are told by a power of ten.
#[test]
fn law_large_numbers_are_short() {
    let chain = [
        "response",
        "examples/linear_chain.toml",
        "--input",
        "chain.1.theta",
    ];
    let asked = ["--output", "chain.20.theta", "--band", "10:1e300"];
    let (code, _, words) = said(&[&chain[..], &asked].concat());
    assert_eq!(code, Some(3), "{words}");
    assert!(words.contains("at 1e299 Hz the inertia forces"), "{words}");
}

/// Tooth pairs by 60 points a pitch: the kinks of their tables, on drive and coast flanks, are passed once each. They had been passed
/// once for every pair and table, 10 735 steps in 14 pitches, and trial steps had run over them, 3 981 of which were rejected.
#[test]
fn law_kinks_of_tooth_pairs_are_passed_once() {
    let folder = tempfile::tempdir().unwrap();
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/noise_rig.toml");
    let text = format!("title = \"x\"\nmodel = {model:?}\n[start]\nat = \"steady\"\n");
    let scene = put(folder.path(), "rig.toml", &text);
    let flags = [
        "--until",
        "0.02 s",
        "--output",
        "pair.force",
        "--no-sensitivity",
        "--json",
    ];
    let by = |method: &str| {
        let scene = ["simulate", scene.to_str().unwrap(), "--method", method];
        document(&[&scene[..], &flags[..]].concat())
    };
    let found = by("dop853-events");
    let kinks = 14.0 * 60.0 * 2.0;
    let steps = found["effort"]["steps"].as_f64().unwrap();
    assert!((kinks..1.1 * kinks).contains(&steps), "{steps}");
    assert!(found["effort"]["rejected"].as_f64().unwrap() < 0.02 * steps);
    let other = by("radau5");
    for name in ["end", "greatest", "least", "mean", "rms_about_mean"] {
        let [a, b] =
            [&found, &other].map(|x| x["readings"]["pair.force_n"][name].as_f64().unwrap());
        assert!((a / b - 1.0).abs() < 1e-6, "{name} {a} {b}");
    }
}
