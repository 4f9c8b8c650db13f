//! Couplings and teeth that are not linear: their tangents under load, their motion, what is refused.

use geardyn::internals::base::time_budget::CancelToken;

use crate::support::verification::within;
use geardyn::internals::plan::modes_run::run as modes_of;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::motion::{method_choice, method_choice::MethodChoice};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::scene::laws::InitialState;
use geardyn::internals::scene::study::{ModesStudy, SimulateStudy};
use geardyn::internals::scene::{self, Scene};

fn scene_of(text: &str) -> Scene {
    scene::read_text(
        "test.toml",
        &format!("title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n{text}"),
    )
    .unwrap_or_else(|e| panic!("{e}"))
}

fn frequencies(scene: &Scene) -> Vec<f64> {
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let study = ModesStudy::default();
    let answer = modes_of(&machine, &study, &ModesPlan::plan_modes(&machine, &study)).unwrap();
    answer.modes.iter().map(|m| m.frequency_hz()).collect()
}

fn moved(
    scene: &Scene,
    until: f64,
    outputs: &[&str],
    method: Option<&str>,
) -> (MethodChoice, MotionResult) {
    let study = SimulateStudy {
        end_time: Some(until),
        outputs: outputs.iter().map(|s| s.to_string()).collect(),
        samples: Some(2000),
        tolerance: Some(1e-11),
        method: method.map(str::to_string),
        energy: true,
        ..SimulateStudy::default()
    };
    let ready = SimulationSetup::new(
        &PreparedMachine::new(&scene.model).unwrap(),
        &scene.start,
        &study,
    )
    .unwrap();
    let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
    let history = run::run(&ready, &choice, study.energy, &CancelToken::default()).unwrap();
    (choice, history)
}

/// One disc held by a hard coupling: about a torque T it swings with `k = n T/δ(T)`.
#[test]
fn exact_tangent_under_load() {
    let scene = scene_of(
        "inertia = [{ name = \"disc\", J = 2.0 }]
coupling = [{ name = \"hard\", between = [\"ground\", \"disc\"], characteristic = { kind = \"power\", torque = 100.0, deflection = 0.05, exponent = 1.5 } }]
load = [{ at = \"disc\", torque = 40.0 }]",
    );
    let delta = 0.05 * (0.4f64).powf(2.0 / 3.0);
    let exact = (1.5 * 40.0 / delta / 2.0).sqrt() / std::f64::consts::TAU;
    let found = frequencies(&scene)[0];
    within("frequency", (found / exact - 1.0).abs(), 1e-12);
}

/// A hard and a straight coupling side by side share a torque so that both twist alike: the cubic's root in closed form.
#[test]
fn exact_share_in_a_loop() {
    let scene = scene_of(
        "inertia = [{ name = \"disc\", J = 1.0 }]
coupling = [
  { name = \"hard\", between = [\"ground\", \"disc\"], characteristic = { kind = \"power\", torque = 1.0, deflection = 1.0, exponent = 3.0 } },
  { name = \"straight\", between = [\"ground\", \"disc\"], k = 3.0 },
]
load = [{ at = \"disc\", torque = 14.0 }]",
    );
    // x³ + 3 x = 14 at x = 2: Cardano's (7 + √50)^⅓ + (7 − √50)^⅓.
    let x = (7.0 + 50f64.sqrt()).cbrt() + (7.0 - 50f64.sqrt()).cbrt();
    let exact = (3.0 * x * x + 3.0).sqrt() / std::f64::consts::TAU;
    let found = frequencies(&scene)[0];
    within("frequency", (found / exact - 1.0).abs(), 1e-11);
    let machine = PreparedMachine::new(&scene.model).unwrap();
    assert!((machine.operating.tangents[0].force - x.powi(3)).abs() < 1e-9);
    assert!(machine.warnings().iter().any(|w| w.code == "linearised"));
}

/// `J θ̈ + K θ³ = 0` from θ = a: the period is 4 K(1/√2)/(a √(K/J)), 7.416298709205487 over that (Lyapunov's cosine).
#[test]
fn exact_period_of_a_cubic_spring() {
    let mut scene = scene_of(
        "inertia = [{ name = \"disc\", J = 0.5 }]
coupling = [{ name = \"hard\", between = [\"ground\", \"disc\"], characteristic = { kind = \"power\", torque = 8.0, deflection = 0.2, exponent = 3.0 } }]",
    );
    scene.start.angles = vec![(scene.model.inertias[0].name.clone(), 0.3)];
    let omega = (8.0 / 0.2f64.powi(3) / 0.5).sqrt();
    let period = 7.416_298_709_205_487 / (0.3 * omega);
    for method in [None, Some("radau5"), Some("dop853")] {
        let (choice, history) = moved(&scene, 4.0 * period, &["disc", "disc.theta.speed"], method);
        let last = history.time.len() - 1;
        let (angle, speed) = (history.values[0][last], history.values[1][last]);
        let name = choice.method.name;
        within(
            &format!("angle after four periods, {name}"),
            (angle / 0.3 - 1.0).abs(),
            1e-7,
        );
        assert!(speed.abs() < 1e-6 * omega * 0.09, "{name}: {speed}");
        assert!(
            history.balance.unwrap().relative_error().abs() < 1e-6,
            "{name}"
        );
    }
}

/// A steady start rests where the curve balances the load, inside a table's play as well as beyond it.
#[test]
fn law_steady_start_rests() {
    let mut scene = scene_of(
        "speed = { motor = 0.0 }
inertia = [{ name = \"motor\", J = 0.01 }, { name = \"roll\", J = 0.4 }]
coupling = [{ name = \"rubber\", between = [\"motor\", \"roll\"], c = 0.1, characteristic = { kind = \"table\", deflections = [0.0, 0.01, 0.05, 0.1], torques = [0.0, 0.0, 20.0, 120.0] } }]
load = [{ at = \"motor\", torque = 30.0 }, { at = \"roll\", torque = -30.0 }]",
    );
    scene.start.at = InitialState::Steady;
    let (_, history) = moved(
        &scene,
        0.5,
        &["rubber.deflection", "rubber.force", "roll"],
        None,
    );
    let span = |v: &[f64]| {
        v.iter()
            .fold((f64::MAX, f64::MIN), |(a, b), &x| (a.min(x), b.max(x)))
    };
    let (low, high) = span(&history.values[0]);
    assert!(
        high - low < 1e-9 && (0.05..0.1).contains(&high.abs()),
        "{low} {high}"
    );
    let (low, high) = span(&history.values[1]);
    assert!(
        (low.abs() - 30.0).abs() < 1e-7 && high - low < 1e-7,
        "{low} {high}"
    );
}

/// Teeth that press by Hertz's power give the mesh its tangent in N/m.
#[test]
fn exact_tangent_of_teeth() {
    let scene = scene_of(
        "inertia = [{ name = \"pinion\", J = 0.001 }, { name = \"wheel\", J = 0.01 }]
gear_pair = [{ name = \"pair\", between = [\"pinion\", \"wheel\"], teeth = [20, 40], module = 0.003, characteristic = { kind = \"power\", force = 1000.0, deflection = 1e-5, exponent = 1.11 } }]
load = [{ at = \"pinion\", torque = 10.0 }, { at = \"wheel\", torque = 20.0 }]",
    );
    let base = 0.03 * 20f64.to_radians().cos();
    let force: f64 = 10.0 / base;
    let k = 1.11 * force / (1e-5 * (force / 1000.0).powf(1.0 / 1.11));
    let exact =
        (k * (base * base / 0.001 + 4.0 * base * base / 0.01)).sqrt() / std::f64::consts::TAU;
    let found = *frequencies(&scene).last().unwrap();
    within("frequency", (found / exact - 1.0).abs(), 1e-10);
}

/// What makes no curve is refused where it stands.
#[test]
fn refuses_what_is_no_characteristic() {
    for (keys, word) in [
        (
            "k = 10.0, characteristic = { kind = \"power\", torque = 1.0, deflection = 1.0, exponent = 2.0 }",
            "exclude",
        ),
        (
            "characteristic = { kind = \"power\", torque = 1.0, deflection = 1.0 }",
            "exponent",
        ),
        (
            "characteristic = { kind = \"power\", torque = 1.0, deflection = 1.0, exponent = 0.5 }",
            "exponent",
        ),
        (
            "characteristic = { kind = \"power\", torque = 1e300, deflection = 1e-300, exponent = 3.0 }",
            "overflow",
        ),
        (
            "characteristic = { kind = \"power\", torque = nan, deflection = 1.0, exponent = 2.0 }",
            "torque",
        ),
        (
            "characteristic = { kind = \"tabel\", torques = [0.0, 1.0], deflections = [0.0, 1.0] }",
            "table",
        ),
        (
            "characteristic = { kind = \"table\", torques = [0.0, 1.0], deflections = [0.0] }",
            "1 deflections and 2",
        ),
        (
            "characteristic = { kind = \"table\", torques = [1.0, 2.0], deflections = [0.0, 1.0] }",
            "origin",
        ),
        (
            "characteristic = { kind = \"table\", torques = [0.0, 2.0, 1.0], deflections = [0.0, 1.0, 2.0] }",
            "decrease",
        ),
        (
            "characteristic = { kind = \"table\", torques = [0.0, 2.0, 2.0], deflections = [0.0, 1.0, 2.0] }",
            "flat",
        ),
        (
            "characteristic = { kind = \"table\", torques = [0.0, 2.0, 3.0], deflections = [0.0, 1.0, 1.0] }",
            "increasing",
        ),
        (
            "damping_ratio = 0.1, characteristic = { kind = \"table\", torques = [0.0, 2.0], deflections = [0.0, 1.0] }",
            "damping_ratio",
        ),
        (
            "backlash = 0.1, characteristic = { kind = \"table\", torques = [0.0, 2.0], deflections = [0.0, 1.0] }",
            "play",
        ),
    ] {
        let text = format!(
            "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\ninertia = [{{ name = \"a\", J = 1.0 }}]\ncoupling = [{{ name = \"c\", between = [\"ground\", \"a\"], {keys} }}]"
        );
        let error = scene::read_text("bad.toml", &text)
            .err()
            .unwrap_or_else(|| panic!("{keys}"));
        let words = error.to_string();
        assert!(words.contains(word), "{keys}: {words}");
    }
}

/// A disc on a spring with a Maxwell element beside it, the standard linear solid: its poles are the roots of
/// `J s³ + J (k₁/c₁) s² + (k + k₁) s + k k₁/c₁`.
#[test]
fn exact_poles_of_a_standard_solid() {
    let (j, k, k1, c1) = (0.5, 800.0, 600.0, 9.0);
    let scene = scene_of(&format!(
        "inertia = [{{ name = \"disc\", J = {j} }}]
coupling = [{{ name = \"rubber\", between = [\"ground\", \"disc\"], k = {k:?}, maxwell = [{{ k = {k1:?}, c = {c1:?} }}] }}]"
    ));
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let study = ModesStudy {
        damped: true,
        ..ModesStudy::default()
    };
    let answer = modes_of(&machine, &study, &ModesPlan::plan_modes(&machine, &study)).unwrap();
    let poles: Vec<_> = answer.modes.iter().map(|m| m.eigenvalue).collect();
    assert!(!poles.is_empty());
    for s in poles {
        let rate = k1 / c1;
        let terms = [s * s * s * j, s * s * (j * rate), s * (k + k1)];
        let sum = terms[0] + terms[1] + terms[2] + k * rate;
        let size = terms.iter().map(|t| t.norm()).sum::<f64>();
        within("residual of the polynomial", sum.norm() / size, 1e-12);
    }
}

/// A pure Maxwell element between two bodies carries what its damper lets through: after a step of torque on both, the twist
/// grows as `T/c₁` while the spring holds `T/k₁`. The exact method and Radau's agree.
#[test]
fn law_maxwell_in_motion() {
    let mut scene = scene_of(
        "inertia = [{ name = \"a\", J = 1.0 }, { name = \"b\", J = 1.0 }]
coupling = [{ name = \"oil\", between = [\"a\", \"b\"], maxwell = [{ k = 400.0, c = 3.0 }] }]
load = [{ at = \"a\", torque = -2.0 }, { at = \"b\", torque = 2.0 }]",
    );
    scene.start.at = InitialState::Rest;
    let outputs = ["a", "b", "b.theta.speed"];
    let (exact, by_exact) = moved(&scene, 10.0, &outputs, None);
    assert_eq!(exact.method.name, "exact");
    let (_, by_radau) = moved(&scene, 10.0, &outputs, Some("radau5"));
    for (one, other) in by_exact.values.iter().zip(&by_radau.values) {
        let largest = one.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let off = one
            .iter()
            .zip(other)
            .fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
        assert!(off < 1e-8 * largest, "{off} of {largest}");
    }
    // In the end the damper alone yields: 2 N·m over 3 N·m·s/rad between the halves, each body taking half.
    let speed = by_exact.values[2].last().unwrap();
    assert!((speed - 1.0 / 3.0).abs() < 1e-6, "{speed}");
}
