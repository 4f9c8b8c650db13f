//! Found while a motion runs: the same as from its written history, in memory that its duration does not move.

use crate::support::command;
use std::path::PathBuf;

use crate::support::command::{document, put, refusal};
use crate::support::verification::within;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::online::{OnlineAnalysis, OnlineResult};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene::study::{OnlineStudy, OrderTrackingStudy, SimulateStudy};
use geardyn::internals::scene::{self};
use geardyn::internals::spectrum::welch::{WelchEstimator, WelchOptions};
use serde_json::Value;

/// A motor at a constant speed turns a wheel by a shaft; on the wheel a load of one order and one of a frequency.
const DRIVE: &str = r#"
inertia = [{ name = "motor", J = 0.1 }, { name = "wheel", J = 0.5 }]
shaft = [{ name = "s", between = ["motor", "wheel"], k = 2e4, c = 5.0 }]
motor = [{ name = "m", at = "motor", kind = "speed", speed = 30.0 }]
load = [{ at = "wheel", kind = "harmonic", mean = -3.0, torque = 2.0, frequency = "14.323944878270580 Hz" }, { at = "wheel", kind = "harmonic", torque = 1.0, frequency = "2.75 Hz" }]
"#;

const HEAD: &str = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";

/// The motion, what was found, and the most numbers held.
fn moved(until: f64, samples: u32, running: OnlineStudy) -> (MotionResult, OnlineResult, usize) {
    let scene = scene::read_text("test.toml", &format!("{HEAD}{DRIVE}")).unwrap();
    let study = SimulateStudy {
        end_time: Some(until),
        outputs: vec!["wheel.theta.speed".into(), "s.force".into(), "wheel".into()],
        samples: Some(samples),
        running,
        ..SimulateStudy::default()
    };
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let ready = SimulationSetup::new(&machine, &scene.start, &study).unwrap();
    let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
    let mut seen = OnlineAnalysis::new(&machine, &ready, &study.running).unwrap();
    if !study.running.history {
        seen.set_limits(1000, 8);
    }
    let mut watch = |at: (f64, &[f64]), values: &[f64]| seen.push(&ready, at, values);
    let kept = (study.running.history, &mut watch as &mut run::StepObserver);
    let history = run::run_observed(&ready, &choice, false, &CancelToken::default(), kept).unwrap();
    let most = seen.peak_stored_values();
    (history, seen.finish(false).unwrap(), most)
}

fn track(node: &str, orders: &[f64]) -> Option<OrderTrackingStudy> {
    Some(OrderTrackingStudy {
        node: node.into(),
        orders: orders.to_vec(),
    })
}

/// To the last bit the spectrum of the history.
#[test]
fn exact_spectrum_of_the_history() {
    let running = OnlineStudy {
        spectrum: Some(500),
        ..OnlineStudy::default()
    };
    let (motion, result, _) = moved(3.0, 6000, running);
    let spectra = result.spectra.unwrap();
    let options = WelchOptions {
        block: 500,
        ..WelchOptions::default()
    };
    let mut estimator = WelchEstimator::new(2000.0, 3, &[], &options).unwrap();
    let views: Vec<&[f64]> = motion.values.iter().map(Vec::as_slice).collect();
    estimator.push(&views);
    let history = estimator.finish().unwrap();
    assert_eq!(spectra.psd, history.psd);
    assert_eq!(spectra.frequency_hz, history.frequency_hz);
    assert!(spectra.blocks > 20);
}

/// A torque of order 3 answers with its transfer function: amplitude and phase against the angle of the motor.
#[test]
fn exact_order_of_a_linear_machine() {
    let running = OnlineStudy {
        track: track("motor", &[3.0]),
        turns: 20,
        ..OnlineStudy::default()
    };
    let (_, result, _) = moved(40.0, 80_000, running);
    let (node, tracks) = result.tracks.unwrap();
    assert_eq!(node, "motor");
    // J ω̇ = 2 cos 90t − k δ − c δ̇: the torque of the shaft holds the wheel back with δ = wheel − motor.
    let (w, k, c, j) = (90.0, 2e4, 5.0, 0.5);
    let (re, im) = (k - w * w * j, w * c);
    let size = 2.0 / f64::hypot(re, im);
    // The start has died away in the last half: c/2J = 5/s.
    for point in &tracks.points[tracks.points.len() / 2..] {
        let value = point.values[0][0];
        assert!((point.speed - 30.0).abs() < 1e-9);
        within("amplitude", (value.norm() / (w * size) - 1.0).abs(), 1e-3);
        let phase = std::f64::consts::FRAC_PI_2 - im.atan2(re);
        assert!(
            (value.arg() - phase).abs() < 2e-3,
            "{} {phase}",
            value.arg()
        );
    }
    assert!(tracks.points.len() > 10);
}

/// A hundred times the duration holds no number more, and no history.
#[test]
fn law_memory_goes_by_the_analysis() {
    let most = |times: u32| {
        let running = OnlineStudy {
            history: false,
            spectrum: Some(64),
            track: track("motor", &[1.0, 3.0]),
            turns: 2,
            te: Some(["motor".into(), "wheel".into()]),
            teeth: Some("1:1".into()),
        };
        let samples = 200 * times;
        let until = 0.4 * f64::from(times);
        let (motion, result, most) = moved(until, samples, running);
        assert!(motion.time.is_empty() && motion.values.iter().all(Vec::is_empty));
        assert!(motion.statistics.iter().all(Option::is_some));
        assert!(result.spectra.is_some() && result.te.is_some());
        most
    };
    assert_eq!(most(10), most(1000));
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("geardyn_fly_{name}_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The same transmission error as of the log that the motion was written to.
#[test]
fn exact_te_of_the_written_history() {
    let folder = folder("te");
    let model = format!(
        r#"{HEAD}
[[inertia]]
name = "motor"
J = 0.01
[[inertia]]
name = "spindle"
J = 0.2
[[gear_pair]]
name = "pair"
between = ["motor", "spindle"]
teeth = [21, 63]
module = 2e-3
k = 2e8
c = 2e4
[[motor]]
name = "drive"
at = "motor"
kind = "speed"
speed = 60.0
[[load]]
at = "spindle"
torque = 20.0
[speed]
motor = 60.0
[[error]]
on = "spindle"
cause = "eccentricity"
amplitude = 12e-6
phase = 0.5
[[error]]
on = "motor"
cause = "eccentricity"
amplitude = 7e-6
phase = 0.0
"#
    );
    put(&folder, "pair.toml", &model);
    let scene = put(
        &folder,
        "scene.toml",
        "model = \"pair.toml\"\n[start]\nat = \"steady\"\n",
    );
    let (scene, csv) = (
        scene.display().to_string(),
        folder.join("log.csv").display().to_string(),
    );
    let asked = [
        "--until",
        "2",
        "--samples",
        "30000",
        "--output",
        "motor,spindle",
    ];
    let te = ["--te", "motor:spindle", "--teeth", "21:63", "--json"];
    let run = document(&[&["simulate", &scene, "--csv", &csv], &asked[..], &te[..]].concat());
    let log = document(&[
        "te", &csv, "--input", "motor", "--output", "spindle", "--teeth", "21:63", "--json",
    ]);
    let own = &run["transmission_error"];
    let total = log["total_arcsec"].as_f64().unwrap();
    assert!(total > 10.0 && (own["total_arcsec"].as_f64().unwrap() / total - 1.0).abs() < 1e-6);
    let lines = |of: &Value| -> Vec<(f64, f64)> {
        let orders = of["orders"].as_array().unwrap().iter();
        let number = |line: &Value, key: &str| line[key].as_f64().unwrap();
        orders
            .map(|l| (number(l, "order_value"), number(l, "amplitude_arcsec")))
            .collect()
    };
    let (one, two) = (lines(own), lines(&log));
    assert!(one.len() > 1 && one.len() == two.len());
    for (a, b) in one.iter().zip(&two) {
        assert!(
            a.0 == b.0 && (a.1 - b.1).abs() < 1e-6 * total,
            "{a:?} {b:?}"
        );
    }
    // The eccentricity of the wheel is there once a turn of the spindle, e/r_b of it.
    let first = one.iter().find(|l| l.0 == 1.0).unwrap().1;
    let exact =
        12e-6 / (63e-3 * f64::to_radians(20.0).cos()) * 180.0 * 3600.0 / std::f64::consts::PI;
    within("first order", (first / exact - 1.0).abs(), 0.02);
    // Without the history the answer is the same.
    let bare = document(&[&["simulate", &scene, "--no-history"], &asked[..], &te[..]].concat());
    assert_eq!(
        bare["transmission_error"]["total_arcsec"],
        own["total_arcsec"]
    );
    assert!(bare["time_s"].is_null() && bare["outputs"].is_null());
    assert_eq!(bare["readings"], run["readings"]);
    std::fs::remove_dir_all(folder).unwrap();
}

/// From a study of a scene as by flags, in words and as JSON.
#[test]
fn keeps_studies_and_flags_alike() {
    let folder = folder("study");
    let listed = "\n[[study]]\nkind = \"simulate\"\nuntil = \"4 s\"\nsamples = 4000\noutputs = [\"s.force\"]\nhistory = \"none\"\nspectrum = 256\ntrack = \"motor:3\"\nturns = 4\n";
    put(&folder, "model.toml", &format!("{HEAD}{DRIVE}"));
    let scene = put(
        &folder,
        "scene.toml",
        &format!("model = \"model.toml\"\n{listed}"),
    );
    let bare = put(&folder, "bare.toml", "model = \"model.toml\"\n");
    let (scene, bare) = (scene.display().to_string(), bare.display().to_string());
    let one = document(&["simulate", &scene, "--json"]);
    let flags = [
        "--until",
        "4",
        "--samples",
        "4000",
        "--output",
        "s.force",
        "--no-history",
        "--spectrum",
        "256",
        "--track",
        "motor:3",
        "--turns",
        "4",
        "--json",
    ];
    let two = document(&[&["simulate", &bare], &flags[..]].concat());
    for key in ["spectra", "orders", "readings"] {
        assert!(!one[key].is_null() && one[key] == two[key], "{key}");
    }
    let run = command::geardyn(&["run", &scene]);
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(
        text.contains("peaks of") && text.contains("orders of motor"),
        "{text}"
    );
    for (flags, said) in [
        (&["--spectrum", "3"][..], "`spectrum`"),
        (&["--spectrum", "100000"], "block"),
        (&["--track", "motor"], "orders"),
        (&["--track", "motor:0"], "orders"),
        (&["--track", "nobody:3"], "nobody"),
        (&["--track", "motor:3,3.1"], "not separated"),
        (&["--te", "motor"], "two nodes"),
        (&["--te", "motor:wheel"], "teeth"),
        (&["--te", "motor:wheel", "--teeth", "x"], "tooth numbers"),
    ] {
        let asked = [&["simulate", bare.as_str(), "--until", "1"], flags].concat();
        let (_, message) = refusal(&asked);
        assert!(message.contains(said), "{flags:?} {message}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}
