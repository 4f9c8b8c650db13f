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
        beside.contains("a second run from a perturbed initial state"),
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

/// Where motions part for good, no extreme stands later than the first parting, but of an output that keeps four digits to the end.
#[test]
fn law_no_extreme_stands_beyond_the_first_parting() {
    let found = document(&[
        "simulate",
        "examples/y2250_rattle.toml",
        "--until",
        "0.1",
        "--samples",
        "1000",
        "--json",
    ]);
    let until = found["sensitivity"]["predictable_until_s"]
        .as_f64()
        .unwrap();
    let outputs = found["sensitivity"]["outputs"].as_object().unwrap();
    assert!(
        outputs
            .values()
            .any(|o| o["predictable_until_s"].as_f64() > Some(until))
    );
    for (key, output) in outputs {
        let readings = &found["readings"][key];
        let number = |name: &str| readings[name].as_f64();
        let sizes = [number("least"), number("greatest")].into_iter().flatten();
        let size = sizes.map(f64::abs).fold(0.0, f64::max);
        for (name, value) in [("least_at_s", "least"), ("greatest_at_s", "greatest")] {
            let Some(at) = number(name).filter(|at| *at > until) else {
                continue;
            };
            let off = output["uncertainty"][value].as_f64().unwrap();
            assert!(output["predictable_until_s"].is_null(), "{key} {name} {at}");
            assert!(off <= 1e-4 * size, "{key} {value} {off}");
        }
    }
}

/// A motion that parts from its changed start and meets it again is said to, however long it lasts.
#[test]
fn law_a_temporary_parting_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let model = r#"
inertia = [{ name = "a", J = "0.01 kg·m²" }, { name = "b", J = "0.012 kg·m²" }, { name = "c", J = "0.05 kg·m²" }]
shaft = [{ name = "s", between = ["b", "c"], k = "20 kN·m/rad", damping_ratio = 0.01 }]
load = [{ at = "a", torque = "5.15 N·m" }, { at = "c", torque = "6.181 N·m" }]
error = [{ on = "a", cause = "profile", harmonic = 1, amplitude = "10.59 µm" }, { on = "b", cause = "eccentricity", amplitude = "21.17 µm" }]
[[gear_pair]]
name = "g"
between = ["a", "b"]
teeth = [25, 30]
module = "4 mm"
k = "400 N/µm"
backlash = "100 µm"
damping_ratio = 0.0112
contact_damping = "continuous"
k_wave = { kind = "rectangular", high = 1.063, low = 0.937, share = 0.5 }
[speed]
a = "2070.1 rpm"
"#;
    put(folder.path(), "m.toml", model);
    let scene = "model = \"m.toml\"\n[start]\nat = \"steady\"\nmesh_phase = \"speed\"\nangle = { a = \"0.5 mrad\" }\n[[study]]\nkind = \"simulate\"\nuntil = \"0.2 s\"\nsamples = 4000\noutput = [\"g.force\"]\n";
    let scene = put(folder.path(), "s.toml", scene);
    let scene = scene.to_str().unwrap();
    let from = |until: &str, key: &str| {
        let found = by(scene, &["--until", until]);
        let at = &found["sensitivity"][key];
        at.as_f64()
            .or(at[0].as_f64())
            .unwrap_or_else(|| panic!("{key}: {at}"))
    };
    let lasting = from("0.05", "predictable_until_s");
    let temporary = from("0.2", "not_predictable_s");
    assert!((lasting - temporary).abs() < 2e-3, "{lasting} {temporary}");
    let (_, text, _) = said(&["simulate", scene, "--until", "0.2"]);
    assert!(text.contains("not predictable between t = "), "{text}");
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

/// A pair with play and bearings starts steadily on the flank that its loads press: its force is the torque over the base radius of
/// 28.19 mm and stays, which is predictable; bearings change nothing of it.
#[test]
fn exact_steady_start_on_either_flank() {
    let folder = tempfile::tempdir().unwrap();
    let lateral = ", mass = \"2 kg\"";
    let bearing = "bearing = [{ name = \"ba\", at = \"a\", k_radial = \"100 N/µm\", damping_ratio = 0.05 }]\n";
    for (mass, bearing) in [("", ""), (lateral, bearing)] {
        for torque in [20.0, -20.0] {
            let text = format!(
                "title = \"m\"\nsource = \"t\"\n\
                 inertia = [{{ name = \"a\", J = \"0.001 kg·m²\"{mass} }}, {{ name = \"b\", J = \"0.01 kg·m²\" }}]\n{bearing}\
                 gear_pair = [{{ name = \"p\", between = [\"a\", \"b\"], teeth = [20, 40], module = \"3 mm\", k = \"300 N/µm\", damping_ratio = 0.03, backlash = \"0.1 mm\", contact_damping = \"no-pull\" }}]\n\
                 load = [{{ at = \"a\", torque = \"{torque} N·m\" }}, {{ at = \"b\", torque = \"{} N·m\" }}]\n\
                 speed = {{ a = \"1000 rpm\" }}\n",
                2.0 * torque
            );
            put(folder.path(), "m.toml", &text);
            let scene = "model = \"m.toml\"\nstart = { at = \"steady\" }\n[[study]]\nkind = \"simulate\"\nuntil = \"0.02 s\"\noutput = [\"p.force\"]\n";
            let scene = put(folder.path(), "s.toml", scene);
            let found = document(&["simulate", scene.to_str().unwrap(), "--json"]);
            let readings = &found["readings"]["p.force_n"];
            let exact = torque / (0.03 * 20_f64.to_radians().cos());
            for key in ["least", "greatest"] {
                let force = readings[key].as_f64().unwrap();
                assert!(
                    (force / exact - 1.0).abs() < 1e-6,
                    "{torque} {mass}: {force} {exact}"
                );
            }
            assert_eq!(found["warnings"], serde_json::json!([]), "{torque} {mass}");
        }
    }
}
