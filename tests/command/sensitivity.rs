//! Digits that hold: a motion that amplifies perturbations is shown as far as two methods and two tolerances agree.

use std::path::Path;

use serde_json::Value;

use crate::support::command::{document, put, said};

/// Impacts on both flanks of a gear pair without a mean load, lightly damped: chaotic.
fn rattling(folder: &Path) -> String {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/gear_pair.toml");
    let text = format!(
        r#"model = {model:?}
model_loads = "left out"
title = "A pair that rattles"
set = {{ "pair.damping_ratio" = 0.03, "pair.contact_damping" = "no-pull" }}

[[load]]
at = "pinion"
kind = "harmonic"
torque = "60 N·m"
mean = "4 N·m"
frequency = "200 Hz"

[[load]]
at = "wheel"
torque = "4 N·m"

[[study]]
kind = "simulate"
until = "0.15 s"
outputs = ["pair.deflection", "pair.force"]
samples = 3000
"#
    );
    let path = put(folder, "rattling.toml", &text);
    path.to_str().unwrap().to_string()
}

const READINGS: [&str; 7] = [
    "end",
    "least",
    "least_at_s",
    "greatest",
    "greatest_at_s",
    "mean",
    "rms_about_mean",
];

/// Of two answers to one scene: what both show of each reading lies within what both may be off by.
fn assert_agree(a: &Value, b: &Value, what: &str) {
    for (key, one) in a["readings"].as_object().unwrap() {
        for name in READINGS {
            let off = |x: &Value| x["sensitivity"]["outputs"][key]["uncertainty"][name].as_f64();
            let pair = (one[name].as_f64(), b["readings"][key][name].as_f64());
            let (Some(x), Some(y)) = pair else { continue };
            // A unit of the fourth digit shown beside.
            let room = off(a).unwrap() + off(b).unwrap() + 1e-3 * x.abs().max(y.abs());
            assert!(
                (x - y).abs() <= room,
                "{what}: {key} {name} {x} {y} ± {room}"
            );
        }
    }
}

fn by(scene: &str, flags: &[&str]) -> Value {
    document(&[&["simulate", scene, "--json"], flags].concat())
}

/// Beyond some instant no method predicts the history: peaks are not shown, and the statistics of every method and tolerance agree
/// within their intervals.
#[test]
fn law_what_is_shown_of_a_rattling_pair_is_what_methods_agree_on() {
    let folder = tempfile::tempdir().unwrap();
    let scene = rattling(folder.path());
    let runs = [
        by(&scene, &[]),
        by(&scene, &["--method", "radau5", "--tolerance", "1e-6"]),
        by(&scene, &["--method", "radau5", "--tolerance", "1e-7"]),
    ];
    for run in &runs {
        let found = &run["sensitivity"];
        assert!(found["factor"].as_f64().unwrap() > 1e3, "{found:#}");
        assert_eq!(found["is_lower_bound"], true);
        let until = found["predictable_until_s"].as_f64().unwrap();
        assert!((0.001..0.1).contains(&until), "{until}");
        assert!(run["readings"]["pair.force_n"]["end"].is_null());
        assert!(run["readings"]["pair.force_n"]["greatest"].is_null());
        let words: Vec<&str> = run["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|w| w["code"].as_str().unwrap())
            .collect();
        assert!(words.contains(&"not-predictable"), "{words:?}");
    }
    for (at, a) in runs.iter().enumerate() {
        for b in &runs[at + 1..] {
            assert_agree(a, b, "rattling");
            for key in ["pair.force_n", "pair.deflection_m"] {
                let of = |run: &Value, what: &str| {
                    let known = &run["sensitivity"]["outputs"][key]["second_half"][what];
                    let number = |key: &str| known[key].as_f64().unwrap();
                    (number("value"), number("uncertainty"))
                };
                for what in ["mean", "rms_about_mean"] {
                    let (x, y) = (of(a, what), of(b, what));
                    // 95 % intervals: twice each covers both in all but one case of ten thousand.
                    let apart = (x.0 - y.0).abs();
                    assert!(apart <= 2.0 * (x.1 + y.1), "{key} {what} {x:?} {y:?}");
                }
            }
        }
    }
    // The exact method predicts longest.
    let until = |run: &Value| run["sensitivity"]["predictable_until_s"].as_f64().unwrap();
    assert!(until(&runs[0]) >= until(&runs[1]));
}

/// A rhythm that no change of the start disturbs: the pair that loses contact in every mesh cycle. Coarse tolerances show fewer
/// digits, and those are right.
#[test]
fn law_coarse_tolerances_show_the_digits_that_hold() {
    let scene = "examples/backlash_pair.toml";
    let short = ["--until", "0.02", "--samples", "700"];
    let run = |flags: &[&str]| by(scene, &[&short, flags].concat());
    let exact = run(&[]);
    assert!(exact["sensitivity"]["factor"].as_f64().unwrap() < 10.0);
    assert_eq!(exact["sensitivity"]["predictable_until_s"], Value::Null);
    for (method, tolerance) in [("radau5", "1e-5"), ("radau5", "1e-8"), ("dopri5", "1e-7")] {
        let other = run(&["--method", method, "--tolerance", tolerance]);
        assert_agree(&exact, &other, &format!("{method} {tolerance}"));
    }
}

/// The table tells it in words; what was not asked for costs no second run.
#[test]
fn law_the_table_shows_how_far_the_motion_is_predictable() {
    let folder = tempfile::tempdir().unwrap();
    let scene = rattling(folder.path());
    let (code, text, beside) = said(&["simulate", &scene]);
    assert_eq!(code, Some(0), "{beside}");
    for words in [
        "sensitivity to initial conditions more than ×",
        "not predictable beyond t = ",
        "second half",
        "99 % below",
        "±",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    assert!(
        beside.contains("a second run from a changed start"),
        "{beside}"
    );
    let (_, text, beside) = said(&["simulate", &scene, "--no-sensitivity"]);
    assert!(!text.contains("sensitivity"), "{text}");
    assert!(
        beside.contains("left out sensitivity: not requested"),
        "{beside}"
    );
    let own = std::fs::read_to_string(&scene).unwrap() + "sensitivity = false\n";
    let off = put(folder.path(), "off.toml", &own);
    assert_eq!(by(off.to_str().unwrap(), &[])["sensitivity"], Value::Null);
}

/// What is linear cannot amplify, and does not pay.
#[test]
fn law_linear_motions_are_not_run_twice() {
    let (_, _, beside) = said(&["simulate", "examples/linear_chain.toml", "--until", "10 ms"]);
    assert!(
        beside.contains("left out sensitivity: the equations are linear"),
        "{beside}"
    );
}

/// `accuracy` had compared with the growth in the first tenth of the time, which saturates; it gives what `simulate` gives.
#[test]
fn law_accuracy_and_simulate_measure_one_sensitivity() {
    let folder = tempfile::tempdir().unwrap();
    let scene = rattling(folder.path());
    let flags = ["--until", "0.015 s", "--output", "pair.deflection"];
    let simulated = by(&scene, &flags);
    let flags = [&["accuracy", &scene, "--json"], &flags[..]].concat();
    let reference = &document(&flags)["reference"];
    let factor = simulated["sensitivity"]["factor"].as_f64().unwrap();
    let found = reference["amplification"].as_f64().unwrap();
    assert!(factor > 30.0, "{factor}");
    assert!((found / factor - 1.0).abs() < 0.1, "{found} {factor}");
    assert_eq!(reference["is_lower_bound"], false);
}
