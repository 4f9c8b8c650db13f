//! `accuracy` of natural frequencies and responses: errors of ways to them against closed forms.

use std::f64::consts::PI;

use crate::support::command::said;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene;
use geardyn::internals::scene::study::ResponseStudy;
use geardyn::internals::study::comparison::{ComparedMethod, ComparisonResult, ModelSize};
use geardyn::internals::study::monitor::Monitor;
use geardyn::internals::study::{frequencies, responses};
use serde_json::Value;

/// Nobody watches.
macro_rules! quiet {
    () => {
        Monitor {
            cancel: &CancelToken::default(),
            on_progress: &mut |_| {},
        }
    };
}

fn study(text: &str, count: usize) -> ComparisonResult {
    let scene = scene::read_text("x.toml", text).unwrap();
    let machine = PreparedMachine::new(&scene.model).unwrap();
    frequencies::compare_eigensolvers(&machine, &scene.model, count, &mut quiet!()).unwrap()
}

fn error(found: &ComparisonResult, method: &str, size: Option<ModelSize>) -> f64 {
    let of = |w: &&ComparedMethod| w.method == method && w.size == size;
    let compared_method = found.methods.iter().find(of).unwrap();
    compared_method
        .error
        .unwrap_or_else(|| panic!("{method}: {:?}", compared_method.failure))
}

const ROD: &str = r#"
title = "rod"
source = "closed form"
[[inertia]]
name = "end"
J = "0 kg·m²"
[[shaft]]
name = "rod"
between = ["ground", "end"]
length = "2 m"
diameter = "50 mm"
material = "steel"
segments = 40
mass = "lumped"
"#;

/// A rod held at one end, half of each length's inertia at its ends: `ω_n = 2 s c/L sin((2n − 1) π/4s)` beside `(2n − 1) π c/2L`.
#[test]
fn case_lengths_of_a_held_rod() {
    let found = study(ROD, 3);
    let exact = |s: f64, n: f64| {
        let quarter = (2.0 * n - 1.0) * PI / 4.0;
        1.0 - (quarter / s).sin() / (quarter / s)
    };
    for lengths in [4, 8, 16, 32, 64] {
        let want = exact(lengths as f64, 3.0);
        let got = error(
            &found,
            "shafts in lengths",
            Some(ModelSize::ShaftElements(lengths)),
        );
        assert!(
            (got / want - 1.0).abs() < 1e-3,
            "{lengths}: {got} for {want}"
        );
    }
    let few = |w: &&ComparedMethod| w.size == Some(ModelSize::ShaftElements(2));
    let two = found.methods.iter().find(few).unwrap();
    assert_eq!(two.failure.as_deref(), Some("gives 2 of 3 modes"));
}

/// Fixed-interface modes converge much faster than static condensation.
#[test]
fn law_reductions_of_a_held_rod() {
    let found = study(ROD, 3);
    for kept in [5, 10, 20] {
        let size = Some(ModelSize::Coordinates(kept));
        let (condensed, modes) = (
            error(&found, "static condensation", size),
            error(&found, "fixed-interface modes", size),
        );
        assert!(modes < 0.3 * condensed, "{kept}: {modes}, {condensed}");
    }
    assert!(error(&found, "lowest modes only", None) <= 1e-12);
}

/// Stiffnesses over fourteen decades: the assembled matrix loses the small frequencies, factored ways do not.
#[test]
fn case_assembled_matrix_loses_digits() {
    let text = std::fs::read_to_string("models/stiff_chain.toml").unwrap();
    let found = study(&text, 5);
    assert!(error(&found, "lowest modes only", None) < 1e-11);
    let assembled = error(&found, "all modes, assembled K", None);
    assert!(assembled > 1e-11, "{assembled}");
}

#[test]
fn law_outputs_of_accuracy_of_modes_agree() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, svg) = (folder.path().join("x.csv"), folder.path().join("x.svg"));
    let (csv, svg) = (csv.to_str().unwrap(), svg.to_str().unwrap());
    let model = "models/geared_motor_rolls.toml";
    let (code, json, _) = said(&[
        "accuracy", model, "--of", "modes", "--lowest", "2", "--json", "--csv", csv, "--svg", svg,
    ]);
    assert_eq!(code, Some(0));
    let found: Value = serde_json::from_str(&json).unwrap();
    assert!(
        found["compared"]
            .as_str()
            .unwrap()
            .contains("2 elastic modes")
    );
    let runs = found["runs"].as_array().unwrap();
    let rows = std::fs::read_to_string(csv).unwrap();
    assert_eq!(rows.lines().count(), runs.len() + 1);
    for (run, row) in runs.iter().zip(rows.lines().skip(1)) {
        let error = run["error"]
            .as_f64()
            .map_or(String::new(), |e| format!("{e:e}"));
        assert!(row.contains(&error), "{row}");
    }
    assert!(std::fs::read_to_string(svg).unwrap().contains("run time"));
}

#[test]
fn refused_flags_that_do_nothing() {
    for (flags, words) in [
        (
            &["--of", "modes", "--until", "1"][..],
            "--until has no effect here",
        ),
        (&["--lowest", "3"], "--lowest has no effect here"),
        (
            &["--of", "modes", "--error", "0"],
            "`error` must be above zero, and is 0",
        ),
    ] {
        let (code, _, error) =
            said(&[&["accuracy", "examples/linear_chain.toml"][..], flags].concat());
        assert_eq!(code, Some(2), "{error}");
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn refused_machines_without_elastic_modes() {
    let text = "title = \"x\"\nsource = \"x\"\n[[inertia]]\nname = \"a\"\nJ = \"1 kg·m²\"\n";
    let scene = scene::read_text("x.toml", text).unwrap();
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let error = frequencies::compare_eigensolvers(&machine, &scene.model, 3, &mut quiet!())
        .err()
        .unwrap();
    assert!(
        error.message.contains("no elastic mode"),
        "{}",
        error.message
    );
}

/// Two discs on a damped shaft, free: a rigid motion and one mode, so that one mode alone is exact and rigid motion alone is
/// off by that mode; a third disc's mode is missed by `2 ω²/|…|` as its closed form says.
#[test]
fn case_truncated_response_of_three_discs() {
    let text = r#"
title = "three discs"
source = "closed form"
[[inertia]]
name = "a"
J = "1 kg·m²"
[[inertia]]
name = "b"
J = "1 kg·m²"
[[inertia]]
name = "c"
J = "1 kg·m²"
[[shaft]]
name = "ab"
between = ["a", "b"]
k = "1 N·m/rad"
[[shaft]]
name = "bc"
between = ["b", "c"]
k = "1 N·m/rad"
[damping]
modal = [0.01, 0.01]
"#;
    let scene = scene::read_text("x.toml", text).unwrap();
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let study = ResponseStudy {
        inputs: vec!["a".into()],
        outputs: vec!["c".into()],
        band: Some((0.2, 0.5)),
        lines: Some(7),
        ..ResponseStudy::default()
    };
    let found = responses::compare_responses(&machine, &study, &mut quiet!()).unwrap();
    // Modes of three equal discs: ω² = 0, 1, 3 with shapes (1,1,1)/√3, (1,0,−1)/√2, (1,−2,1)/√6.
    let term = |square: f64, product: f64, w: f64| {
        let (re, im) = (square - w * w, 0.02 * square.sqrt() * w);
        let size = re * re + im * im;
        (product * re / size, -product * im / size)
    };
    let lines = || (0..7).map(|k| 0.2 + 0.05 * f64::from(k));
    let add = |terms: &[(f64, f64)]| terms.iter().fold((0.0, 0.0), |s, t| (s.0 + t.0, s.1 + t.1));
    let whole = |w| {
        let all = add(&[
            term(0.0, 1.0 / 3.0, w),
            term(1.0, -0.5, w),
            term(3.0, 1.0 / 6.0, w),
        ]);
        all.0.hypot(all.1)
    };
    let missed = |w| {
        let t = term(3.0, 1.0 / 6.0, w);
        t.0.hypot(t.1)
    };
    let want = lines().map(missed).fold(0.0, f64::max) / lines().map(whole).fold(0.0, f64::max);
    let got = error(&found, "modes alone", Some(ModelSize::Modes(1)));
    assert!((got / want - 1.0).abs() < 1e-9, "{got} for {want}");
    assert!(
        error(
            &found,
            "modes and static residual",
            Some(ModelSize::Modes(1))
        ) < 0.2 * want
    );
    assert!(error(&found, "all modes", None) < 1e-12);
}

#[test]
fn refused_undamped_responses() {
    let scene = scene::read_text("x.toml", ROD).unwrap();
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let study = ResponseStudy {
        inputs: vec!["end".into()],
        outputs: vec!["end".into()],
        band: Some((1.0, 2.0)),
        ..ResponseStudy::default()
    };
    let error = responses::compare_responses(&machine, &study, &mut quiet!())
        .err()
        .unwrap();
    assert!(error.message.contains("is undamped"), "{}", error.message);
}
