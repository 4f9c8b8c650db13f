//! Friction of bearings and teeth: closed forms, an integration written pair by pair, energy, symmetry.

use std::f64::consts::{PI, TAU};

use crate::support::{numbers, reference, within};
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::machine::components::{FrictionCapacity, ToothFrictionPath};
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene::study::SimulateStudy;
use geardyn::internals::scene::{self, Scene};

fn scene_of(text: &str) -> Scene {
    let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
    scene::read_text("test.toml", &format!("{head}{text}")).unwrap()
}

/// Angles and speeds of the bodies `a` and `b` at the start.
type Begin = [f64; 4];

const STILL: Begin = [0.0; 4];
const RUNNING: Begin = [0.0, 0.0, 40.0, -40.0 / 3.0];

fn moved(
    text: &str,
    begin: Begin,
    (until, samples): (f64, u32),
    outputs: &[&str],
    method: Option<&str>,
) -> MotionResult {
    let mut scene = scene_of(text);
    let [a, b, va, vb] = begin;
    let named = |node: &str, x: f64| {
        let bodies = scene.model.inertias.iter();
        let body = bodies
            .map(|body| body.name.clone())
            .find(|name| name.text == node);
        body.filter(|_| x != 0.0).map(|name| (name, x))
    };
    let angles = [("a", a), ("b", b)]
        .into_iter()
        .filter_map(|(node, x)| named(node, x));
    let angles: Vec<_> = angles.collect();
    let speeds = [("a", va), ("b", vb)]
        .into_iter()
        .filter_map(|(node, x)| named(node, x));
    let speeds: Vec<_> = speeds.collect();
    (scene.start.angles, scene.start.speeds) = (angles, speeds);
    let study = SimulateStudy {
        end_time: Some(until),
        outputs: outputs.iter().map(|s| s.to_string()).collect(),
        samples: Some(samples),
        energy: true,
        tolerance: method.map(|_| 1e-12),
        method: method.map(str::to_string),
        ..SimulateStudy::default()
    };
    let ready = SimulationSetup::new(
        &PreparedMachine::new(&scene.model).unwrap(),
        &scene.start,
        &study,
    );
    let ready = ready.unwrap();
    let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
    run::run(&ready, &choice, true, &CancelToken::default()).unwrap()
}

fn gap(history: &MotionResult) -> f64 {
    history.balance.unwrap().relative_error().abs()
}

/// The pair of the reference; positive turns of the two are opposite.
fn pair(friction: &str) -> String {
    format!(
        r#"
inertia = [{{ name = "a", J = 2e-3 }}, {{ name = "b", J = 0.08 }}]
gear_pair = [{{ name = "mesh", between = ["a", "b"], teeth = [20, 60], module = 2e-3, k = 2e8, c = 400.0, {friction} }}]
damper = [{{ name = "drag", at = "b", c = 2.0 }}]
load = [{{ at = "a", torque = 30.0 }}, {{ at = "b", torque = 40.0 }}]
"#
    )
}

/// A disc on a spring in a bearing that rubs: every swing is shorter by 2 T/k, every cycle by 4 T/k, and inside ±T/k it sticks.
#[test]
fn exact_coulomb_decay() {
    let (k, torque, start): (f64, f64, f64) = (100.0, 0.8 + 0.004 * 0.05 * 1000.0, 0.3);
    let text = format!(
        r#"
inertia = [{{ name = "a", J = 1.0 }}]
shaft = [{{ name = "s", between = ["ground", "a"], k = {k} }}]
bearing = [{{ name = "b", at = "a", friction_torque = 0.8, friction = 0.004, friction_radius = 0.05, radial_load = 1000.0 }}]
"#
    );
    let half = PI / 10.0;
    // The least swing that still leaves ±T/k: 0.3 → −0.28 → 0.26 → …
    let swings = (start / (2.0 * torque / k)).round() as usize;
    for method in [None, Some("radau5"), Some("dop853-events")] {
        let history = moved(
            &text,
            [start, 0.0, 0.0, 0.0],
            (half * 16.0, 16),
            &["a", "b.friction", "b.loss"],
            method,
        );
        for (n, found) in history.values[0].iter().enumerate() {
            let left = start - n.min(swings) as f64 * 2.0 * torque / k;
            let exact = if n % 2 == 0 { left } else { -left };
            // At rest wherever the last swing ended.
            let exact = if n > swings {
                history.values[0][swings]
            } else {
                exact
            };
            within("amplitude, rad", (found - exact).abs(), 1e-10);
        }
        assert!(history.values[0][16].abs() <= torque / k + 1e-12);
        let spring = -k * history.values[0][16];
        assert!(
            (history.values[1][16] + spring).abs() < 1e-9,
            "holds the spring"
        );
        assert!(gap(&history) < 1e-5, "{method:?} {:e}", gap(&history));
    }
}

/// Stribeck's fall and breakaway belong to bearings as they do to brakes: the same motion.
#[test]
fn law_bearing_is_a_brake() {
    let text = |rubs: &str| {
        format!(
            r#"
inertia = [{{ name = "a", J = 1.0 }}, {{ name = "d", J = 2.0 }}]
shaft = [{{ name = "s", between = ["d", "a"], k = 60.0 }}]
motor = [{{ name = "m", at = "d", kind = "speed", speed = 0.4 }}]
{rubs}
"#
        )
    };
    let brake = "brake = [{ name = \"b\", at = \"a\", torque = 2.0, breakaway = 3.0, stribeck_speed = 0.2 }]";
    let bearing = "bearing = [{ name = \"b\", at = \"a\", friction_torque = 2.0, breakaway_ratio = 1.5, stribeck_speed = 0.2 }]";
    let one = moved(
        &text(brake),
        STILL,
        (6.0, 100),
        &["a", "b.torque", "b.loss"],
        None,
    );
    let two = moved(
        &text(bearing),
        STILL,
        (6.0, 100),
        &["a", "b.friction", "b.loss"],
        None,
    );
    assert!(one.stats.events > 3, "sticks and slips");
    assert_eq!(one.values, two.values);
}

/// A brake that holds 3 N·m and rubs with 2 as soon as it slides, under a torque of t N·m on 1 kg·m²: it lets go after 3 s, and
/// ω(5 s) = ∫ (t − 2) dt = 4 rad/s. No speed is needed over which one falls to the other.
#[test]
fn exact_breakaway_without_a_fall_over_speed() {
    let text = r#"
inertia = [{ name = "a", J = 1.0 }]
brake = [{ name = "b", at = "a", torque = 2.0, breakaway = 3.0 }]
load = [{ at = "a", kind = "ramp", torque = 10.0, between = [0.0, 10.0] }]
"#;
    for (method, digits) in [
        (None, 1e-12),
        (Some("dop853-events"), 1e-9),
        // Creeps until 0.97 of the breakaway torque, and lets go so much earlier.
        (Some("dop853"), 3e-2),
    ] {
        let history = moved(text, STILL, (5.0, 5), &["a.theta.speed"], method);
        let speed = &history.values[0];
        let exact = [0.0, 0.0, 0.0, 0.0, 1.5, 4.0];
        for (x, y) in speed.iter().zip(exact) {
            assert!((x - y).abs() < digits * 4.0, "{method:?} {speed:?}");
        }
    }
}

/// A bearing that carries a belt's force: sticking where k |x| falls below T₀ + μ r |F|; against the integration swing by swing.
/// Source: SciPy 1.17.1 (tools/reference_friction.py).
#[test]
fn ref_bearing_by_load() {
    let text = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "b", J = 5.0 }]
belt = [{ name = "belt", between = ["a", "b"], diameters = [0.2, 0.2], k = 1e4 }]
motor = [{ name = "hold", at = "b", kind = "speed", speed = 0.0 }]
bearing = [{ name = "bear", at = "a", friction_torque = 0.6, friction = 0.15, friction_radius = 0.1, carries = "belt" }]
"#;
    let known = &reference("friction")["bearing"];
    let states = known["states"].as_array().unwrap();
    for method in [None, Some("dop853-events")] {
        let history = moved(
            text,
            [0.3, 0.0, 0.0, 0.0],
            (4.0, 80),
            &["a", "a.speed"],
            method,
        );
        for (n, state) in states.iter().enumerate() {
            let exact = numbers(state);
            for (at, size) in [(0, 0.3), (1, 3.0)] {
                let error = (history.values[at][n] - exact[at]).abs() / size;
                let allowed = if method.is_some() { 1e-9 } else { 1e-6 };
                within("angle and speed", error, allowed);
            }
        }
        assert!(gap(&history) < 1e-5, "{:e}", gap(&history));
    }
}

/// Teeth that rub pair by pair along the path of contact, vibrating under load.
/// Source: SciPy 1.17.1 (tools/reference_friction.py).
#[test]
fn ref_teeth_along_the_path() {
    let known = &reference("friction")["teeth"];
    let states: Vec<Vec<f64>> = known["states"]
        .as_array()
        .unwrap()
        .iter()
        .map(numbers)
        .collect();
    let text = pair("friction = 0.08, sliding = \"path\"");
    for method in ["radau5", "dop853-events"] {
        let outputs = ["a", "b", "a.speed", "b.speed"];
        let history = moved(&text, RUNNING, (0.05, 50), &outputs, Some(method));
        for (at, size) in [(0, 2.0), (1, 0.7), (2, 40.0), (3, 13.0)] {
            let error = states.iter().zip(&history.values[at]);
            let error = error.map(|(y, x)| (x - y[at]).abs()).fold(0.0, f64::max) / size;
            within("outputs", error, 1e-8);
        }
        assert!(history.stats.events == 0 && history.stats.steps > 50);
    }
}

/// Whatever friction takes is booked: with paths, with means, with play and reversal, beside a prescribed speed.
#[test]
fn law_energy_closes() {
    let play = "friction = 0.08, backlash = 1e-5, contact_damping = \"no-pull\"";
    for (friction, start, bound) in [
        ("friction = 0.08", RUNNING, 1e-8),
        ("friction = 0.08, sliding = \"path\"", RUNNING, 1e-4),
        (play, STILL, 1e-4),
        (&format!("{play}, sliding = \"path\""), STILL, 1e-4),
    ] {
        let history = moved(
            &pair(friction),
            start,
            (0.02, 500),
            &["a.speed", "mesh.loss"],
            None,
        );
        let balance = history.balance.unwrap();
        let sum: f64 = history.values[1].iter().sum::<f64>() * 0.02 / 500.0;
        assert!(sum > 0.0 && sum < balance.dissipated, "{sum} {balance:?}");
        assert!(gap(&history) < bound, "{friction} {:e}", gap(&history));
    }
}

/// At one speed under load the mean of what teeth lose is μ H_v of what the teeth carry; H_v by Ohlendorf's formula.
#[test]
fn exact_mean_loss() {
    // 20 and 60 teeth, 20°, tips one module high.
    let (z1, i, alpha, m) = (20.0, 3.0, 20f64.to_radians(), 2e-3);
    let share = |z: f64| {
        let (r, b) = (0.5 * z * m, 0.5 * z * m * alpha.cos());
        (((r + m).powi(2) - b * b).sqrt() - b * alpha.tan()) / (PI * m * alpha.cos())
    };
    let (e1, e2) = (share(20.0), share(60.0));
    let factor = PI * (i + 1.0) / (z1 * i) * (1.0 - e1 - e2 + e1 * e1 + e2 * e2);
    let speed = 50.0;
    // The path's hand-overs fall between samples.
    for (sliding, mu, samples, bound) in [("mean", 0.08, 400, 1e-6), ("path", 1e-3, 10_000, 2e-3)] {
        let text = format!(
            r#"
inertia = [{{ name = "a", J = 2e-3 }}, {{ name = "b", J = 0.5 }}]
gear_pair = [{{ name = "mesh", between = ["a", "b"], teeth = [20, 60], module = 2e-3, k = 2e8, c = 4e5, friction = {mu}, sliding = "{sliding}" }}]
motor = [{{ name = "drive", at = "a", kind = "speed", speed = {speed} }}]
load = [{{ at = "b", torque = 60.0 }}]
damper = [{{ name = "d", at = "b", c = 20.0 }}]
"#
        );
        // Whole mesh cycles.
        let until = 20.0 * TAU / (20.0 * speed);
        let outputs = ["mesh.loss", "mesh.force", "b.speed"];
        let history = moved(
            &text,
            [0.0, 0.0, 0.0, -speed / 3.0],
            (until, samples),
            &outputs,
            None,
        );
        let (half, whole) = (samples as usize / 2, samples as usize);
        let mean = |at: usize| history.values[at][half..whole].iter().sum::<f64>() / half as f64;
        let carried = mean(1).abs() * 0.5 * z1 * m * alpha.cos() * speed;
        let found = mean(0) / (mu * carried);
        within("mean loss", (found / factor - 1.0).abs(), bound);
    }
}

/// Turned the other way round, coast flanks do what drive flanks did.
#[test]
fn law_coast_mirrors_drive() {
    let (z1, alpha) = (20.0, 20f64.to_radians());
    let (b2, m) = (60e-3 * alpha.cos(), 2e-3);
    let approach =
        ((62e-3f64.powi(2) - b2 * b2).sqrt() - b2 * alpha.tan()) / (PI * m * alpha.cos());
    let friction = |phase: f64| {
        format!(
            "friction = 0.08, sliding = \"path\", path_phase = \"{} deg\"",
            phase * 360.0
        )
    };
    let text = pair(&friction(0.2));
    let mirrored = pair(&friction(2.0 * approach - 0.5 - 0.2));
    let mirrored = mirrored.replace("torque = ", "torque = -");
    let outputs = ["a", "b", "mesh.loss"];
    let one = moved(&text, RUNNING, (0.02, 100), &outputs, Some("dop853-events"));
    let two = moved(
        &mirrored,
        RUNNING.map(|x| -x),
        (0.02, 100),
        &outputs,
        Some("dop853-events"),
    );
    assert!(
        one.values[0][100] * z1 / TAU > 1.0,
        "more than a mesh cycle"
    );
    for (at, sign) in [(0, -1.0), (1, -1.0), (2, 1.0)] {
        let size = one.values[at].iter().fold(0.0f64, |m, x| m.max(x.abs()));
        for (x, y) in one.values[at].iter().zip(&two.values[at]) {
            assert!(
                (x - sign * y).abs() < 1e-8 * size,
                "{} {x} {y}",
                outputs[at]
            );
        }
    }
}

/// Both gears turned as one body about the first axis slide nowhere: the forces of friction add up to none.
#[test]
fn law_turned_as_one() {
    let (m, alpha) = (2e-3, 20f64.to_radians());
    for (kind, inside, beta) in [
        ("", false, 0.0),
        ("internal = true, ", true, 0.0),
        ("helix_angle = \"15 deg\", ", false, 15.0),
    ] {
        let text = format!(
            r#"
inertia = [{{ name = "a", J = 2e-3, mass = 1.0 }}, {{ name = "b", J = 0.08, mass = 3.0 }}]
gear_pair = [{{ name = "mesh", between = ["a", "b"], teeth = [20, 60], {kind}module = 2e-3, k = 2e8, friction = 0.1 }}]
bearing = [{{ name = "one", at = "a", k_radial = 1e8 }}, {{ name = "two", at = "b", k_radial = 1e8 }}]
"#
        );
        let machine = PreparedMachine::new(&scene_of(&text).model)
            .unwrap()
            .machine;
        let FrictionCapacity::Pressed(pressed) = &machine.friction_elements[0].capacity else {
            panic!("{:?}", machine.friction_elements)
        };
        let Some(ToothFrictionPath {
            pitch_point_sliding: aside,
            ..
        }) = &pressed.path
        else {
            panic!("{pressed:?}")
        };
        let radius = |z: f64| 0.5 * z * m / f64::to_radians(beta).cos();
        let far = if inside {
            radius(20.0) - radius(60.0)
        } else {
            radius(20.0) + radius(60.0)
        };
        let mut motion = vec![0.0; machine.dofs.len()];
        for (name, x) in [("a.theta", 1.0), ("b.theta", 1.0), ("b.y", far)] {
            motion[machine.dof(name).unwrap()] = x;
        }
        assert!(machine.friction_elements[0].direction.dot(&motion).abs() < 1e-15);
        for aside in aside {
            let size: f64 = aside.entries().map(|(i, a)| (a * motion[i]).abs()).sum();
            assert!(
                size > 0.5 * m * alpha.sin() && aside.dot(&motion).abs() < 1e-14 * size.max(1.0),
                "{kind}{}",
                aside.dot(&motion)
            );
        }
    }
}

/// Friction of teeth at rest holds as a brake would, and gears in their gap feel none.
#[test]
fn law_teeth_at_rest() {
    let text = pair("friction = 0.3").replace("torque = 30.0", "torque = 13.2");
    let text = text.replace("c = 400.0", "c = 4e4");
    // 13.2 N·m on 20 teeth hold 39.6 on 60 without friction; 40 are there, and friction bears the difference.
    let history = moved(&text, STILL, (0.1, 50), &["a", "b", "mesh.loss"], None);
    let end = history.values[0][50];
    assert!(
        (end - history.values[0][40]).abs() < 1e-9 * end.abs().max(1e-6),
        "{:?}",
        &history.values[0][40..]
    );
    assert!(history.values[2][50].abs() < 1e-9);
}

#[test]
fn refuses_what_makes_no_sense() {
    let pair = |keys: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 1.0 }}, {{ name = \"b\", J = 1.0 }}]\ngear_pair = [{{ name = \"mesh\", between = [\"a\", \"b\"], teeth = [20, 60], {keys} }}]"
        )
    };
    let bearing = |keys: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 1.0 }}]\nbearing = [{{ name = \"r\", at = \"a\", {keys} }}]"
        )
    };
    for (text, said) in [
        (pair("friction = 0.1"), "`k`"),
        (
            pair("module = 2e-3, k = 1e8, shaft_angle = \"90 deg\", friction = 0.1"),
            "parallel axes",
        ),
        (
            pair(
                "module = 2e-3, k = 1e8, helix_angle = \"20 deg\", friction = 0.1, sliding = \"path\"",
            ),
            "gradually",
        ),
        (
            pair("module = 2e-3, k = 1e8, sliding = \"path\""),
            "`friction`",
        ),
        (
            pair("module = 2e-3, k = 1e8, friction = 0.1, path_phase = \"3 deg\""),
            "path_phase",
        ),
        (
            pair("module = 2e-3, k = 1e8, friction = 0.1, tip_diameters = [0.0402, 0.1202]"),
            "contact ratio",
        ),
        (pair("module = 2e-3, k = 1e8, friction = -0.1"), "friction"),
        (bearing("friction = 0.1"), "friction_radius"),
        (
            bearing("friction = 0.1, friction_radius = 0.02"),
            "radial_load",
        ),
        (
            bearing("friction = 0.1, friction_radius = 0.02, carries = \"mesh\""),
            "not an elastic pair",
        ),
        (
            bearing("friction_torque = 0.1, radial_load = 5.0"),
            "`friction`",
        ),
        (bearing("friction_torque = -0.1"), "friction_torque"),
    ] {
        let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
        let read = scene::read_text("test.toml", &format!("{head}{text}"));
        let errors = match read {
            Err(errors) => format!("{errors:?}"),
            Ok(scene) => format!("{:?}", PreparedMachine::new(&scene.model).err()),
        };
        assert!(errors.contains(said), "{text}\n{errors}");
    }
}
