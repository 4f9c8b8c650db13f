//! Roots that grow are called unstable with their rate; terms of speeds are counted, or their leaving out is said.

use crate::support;
use std::f64::consts::TAU;

use geardyn::internals::base::error::Diagnostic;
use geardyn::internals::plan::modes_run::{ModesResult, run};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::response::run as response;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::scene;
use geardyn::internals::scene::study::{ModesStudy, ResponseStudy};
use geardyn::internals::study::stability::linear::linear_stability;

fn prepared(text: &str) -> PreparedMachine {
    let head = "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n";
    let scene =
        scene::read_text("test.toml", &format!("{head}{text}")).unwrap_or_else(|e| panic!("{e}"));
    PreparedMachine::new(&scene.model).unwrap()
}

fn modes(machine: &PreparedMachine, study: &ModesStudy) -> ModesResult {
    run(machine, study, &ModesPlan::plan_modes(machine, study)).unwrap()
}

fn of<'a>(diagnostics: &'a [Diagnostic], code: &str) -> Option<&'a str> {
    let found = diagnostics.iter().find(|w| w.code == code);
    found.map(|w| w.message.as_str())
}

/// An oil film without damping, `λ² = −k ± i κ` of a mass of one: the whirl grows by `κ/2√k`, to (κ/k)².
#[test]
fn exact_growth_of_a_whirl_in_an_oil_film() {
    let (k, cross) = (1e6f64, 1e3f64);
    let ready = prepared(&format!(
        "inertia = [{{ name = \"disc\", J = 1.0, mass = 1.0 }}]\n\
         bearing = [{{ name = \"film\", at = \"disc\", k_x = {k:?}, k_y = {k:?}, k_x_y = {cross:?}, k_y_x = -{cross:?} }}]\n"
    ));
    let rate = cross / (2.0 * k.sqrt());
    let found = linear_stability(&ready, None).unwrap();
    assert!(
        (found.spectral_abscissa / rate - 1.0).abs() < 1e-6,
        "{}",
        found.spectral_abscissa
    );
    let said = format!("grows by {rate:.4} 1/s");
    for diagnostics in [
        &found.diagnostics,
        &modes(&ready, &ModesStudy::default()).diagnostics,
    ] {
        let message = of(diagnostics, "unstable").unwrap();
        assert!(
            message.starts_with("unstable: ") && message.contains(&said),
            "{message}"
        );
    }
    let study = ResponseStudy {
        inputs: vec!["disc.x".to_string()],
        outputs: vec!["disc.x".to_string()],
        band: Some((10.0, 2000.0)),
        lines: Some(11),
        ..ResponseStudy::default()
    };
    let result = response::run(&ready, &study, false).unwrap();
    assert!(of(&result.diagnostics, "unstable").unwrap().contains(&said));
}

/// The linear facts of `stability` are the damped modes at the speed of the file, not those at rest; `plan_modes` says what it leaves out.
#[test]
fn law_stability_counts_the_terms_of_speed() {
    let text = std::fs::read_to_string("models/overhung_rotor.toml").unwrap();
    let scene = scene::read_text("test.toml", &text).unwrap();
    let ready = PreparedMachine::new(&scene.model).unwrap();
    let speed = 6000.0 * TAU / 60.0;
    let found = linear_stability(&ready, None).unwrap();
    assert_eq!(found.speed, Some(speed));
    let damped = ModesStudy {
        damped: true,
        ..ModesStudy::default()
    };
    let turning = ModesStudy {
        speed: Some(speed),
        ..damped.clone()
    };
    let roots = |study| {
        modes(&ready, study)
            .modes
            .iter()
            .filter(|m| !m.rigid)
            .map(|m| m.eigenvalue)
            .collect::<Vec<_>>()
    };
    assert_eq!(found.eigenvalues, roots(&turning));
    assert_ne!(found.eigenvalues, roots(&damped));
    let at_rest = modes(&ready, &damped);
    let left_out = of(&at_rest.diagnostics, "speed-terms").unwrap();
    assert!(
        left_out.contains("at the 6000 rpm stated for wheel.theta") && left_out.contains('%'),
        "{left_out}"
    );
    assert!(of(&modes(&ready, &turning).diagnostics, "speed-terms").is_none());
}

/// `stability` has no flag for one speed: where the file states none, the hint says how to state it there.
#[test]
fn law_stability_hints_at_the_speed_of_the_model() {
    let ready = prepared(
        "inertia = [{ name = \"disc\", J = 2.0, J_diametral = 1.0, mass = 10.0 }]\n\
         bearing = [{ name = \"b\", at = \"disc\", k_radial = 1e6, k_rx = 1e5, k_ry = 1e5 }]\n",
    );
    let found = linear_stability(&ready, None).unwrap();
    let left_out = found.diagnostics.iter().find(|w| w.code == "speed-terms");
    let hint = left_out.unwrap().hint.as_deref().unwrap();
    assert!(
        hint.contains("[speed]") && !hint.contains("--speed"),
        "{hint}"
    );
}

/// What a torsional support holds may be given a speed: the support turns along, and gyroscopic terms are those of a rotor without it.
#[test]
fn law_torsional_supports_take_a_speed() {
    let rotor = |support: &str| {
        prepared(&format!(
            "inertia = [{{ name = \"disc\", J = 2.0, J_diametral = 1.0, mass = 10.0 }}]\n\
             bearing = [{{ name = \"b\", at = \"disc\", k_radial = 1e6, k_rx = 1e5, k_ry = 1e5{support} }}]\n"
        ))
    };
    let study = ModesStudy {
        speed: Some(200.0),
        ..ModesStudy::default()
    };
    let [free, held] = ["", ", k_theta = 5e3"].map(|support| modes(&rotor(support), &study));
    let tilts = |result: &ModesResult| -> Vec<f64> {
        let all = result.modes.iter().filter(|m| !m.rigid).map(|m| m.omega());
        all.filter(|w| (w - 50.0).abs() > 1e-6 && (w - 1e5f64.sqrt()).abs() > 1e-6)
            .collect()
    };
    let (free, held) = (tilts(&free), tilts(&held));
    assert_eq!(free.len(), 2);
    assert!(support::worst(&held, &free) < 1e-12, "{held:?} {free:?}");
    // λ = i ω: ω² ∓ (J/J_d) Ω ω − k/J_d = 0.
    let (g, k) = (2.0 * 200.0, 1e5f64);
    let exact = [
        -0.5 * g + (0.25 * g * g + k).sqrt(),
        0.5 * g + (0.25 * g * g + k).sqrt(),
    ];
    assert!(support::worst(&free, &exact) < 1e-12, "{free:?} {exact:?}");
}
