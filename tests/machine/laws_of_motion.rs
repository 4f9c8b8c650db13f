//! Laws of motion in scenes: motions known in time, and what follows.

use std::f64::consts::TAU;

use crate::support::verification::within;
use geardyn::internals::base::error::Error;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene::laws::InitialState;
use geardyn::internals::scene::study::SimulateStudy;
use geardyn::internals::scene::{self, Scene};

/// A model in SI as a scene without studies.
fn scene_of(text: &str) -> Scene {
    let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
    scene::read_text("test.toml", &format!("{head}{text}")).unwrap()
}

fn study(until: f64, outputs: &[&str], method: Option<&str>) -> SimulateStudy {
    SimulateStudy {
        end_time: Some(until),
        outputs: outputs.iter().map(|s| s.to_string()).collect(),
        samples: Some(200),
        energy: true,
        method: method.map(str::to_string),
        tolerance: method.filter(|m| !EXACT.contains(m)).map(|_| 1e-11),
        ..SimulateStudy::default()
    }
}

/// Methods that take no tolerance.
const EXACT: [&str; 3] = ["exact", "switched", "periodic"];

fn ready(scene: &Scene, study: &SimulateStudy) -> Result<SimulationSetup, Error> {
    SimulationSetup::new(&PreparedMachine::new(&scene.model)?, &scene.start, study)
}

/// The motion and the method that was taken.
fn moved(scene: &Scene, study: &SimulateStudy) -> (&'static str, MotionResult) {
    let ready = ready(scene, study).unwrap();
    let choice = method_choice::choose_method(&ready.model.model, study).unwrap();
    let history = run::run(&ready, &choice, study.energy, &CancelToken::default()).unwrap();
    (choice.method.name, history)
}

fn refused(text: &str) -> String {
    let error = ready(&scene_of(text), &study(1.0, &[], None))
        .err()
        .unwrap();
    format!("{} {}", error.message, error.hint.unwrap_or_default())
}

/// The largest difference of an output as a share of its largest value.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let size = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let gap = a
        .iter()
        .zip(b)
        .fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
    gap / size
}

/// Every output by two methods that step, against `name`, which must be the one taken by itself.
fn agree(text: &str, until: f64, outputs: &[&str], name: &str) -> MotionResult {
    let scene = scene_of(text);
    let (taken, history) = moved(&scene, &study(until, outputs, None));
    assert_eq!(taken, name);
    for other in ["radau5", "dop853-events"] {
        let mut by_steps = study(until, outputs, Some(other));
        by_steps.energy = false;
        let (_, stepped) = moved(&scene, &by_steps);
        for (at, output) in outputs.iter().enumerate() {
            let gap = apart(&history.values[at], &stepped.values[at]);
            assert!(gap < 1e-9, "{other}: {output} {gap:e}");
        }
    }
    history
}

fn gap(history: &MotionResult) -> f64 {
    history.balance.unwrap().relative_error().abs()
}

/// A shaft whose far end is turned at a constant speed at once: J b̈ = k (Ωt − b), T = J_a·0 + k (Ωt − b).
#[test]
fn exact_constant_speed() {
    let text = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "b", J = 2.0 }]
shaft = [{ name = "s", between = ["a", "b"], k = 50.0 }]
motor = [{ name = "m", at = "a", kind = "speed", speed = "3 rad/s" }]
"#;
    let outputs = ["a", "b", "b.speed", "s.force", "m.torque"];
    let history = agree(text, 4.0, &outputs, "exact");
    for (k, t) in history.time.iter().enumerate() {
        let lag = 3.0 / 5.0 * (5.0 * t).sin();
        let exact = [
            3.0 * t,
            3.0 * t - lag,
            3.0 * (1.0 - (5.0 * t).cos()),
            -50.0 * lag,
            50.0 * lag,
        ];
        for (at, exact) in exact.iter().enumerate() {
            let found = history.values[at][k];
            within("states and torque", (found - exact).abs(), 1e-12);
        }
    }
    assert!(gap(&history) < 1e-12, "{}", gap(&history));
}

/// A ramp of speed, a load on the driven body and a damper to ground: the torque of the drive by hand.
#[test]
fn exact_torque_of_a_drive() {
    let text = r#"
inertia = [{ name = "a", J = 1.5 }, { name = "b", J = 2.0 }, { name = "c", J = 0.5 }]
shaft = [{ name = "s", between = ["a", "b"] }, { name = "far", between = ["b", "c"], k = 1e4, c = 40.0 }]
damper = [{ name = "d", at = "a", c = 0.25 }]
load = [{ at = "a", torque = 7.0 }]
motor = [{ name = "m", at = "b", kind = "speed", times = [0.0, 2.0], speeds = [1.0, 5.0] }]
"#;
    let scene = scene_of(text);
    let (name, history) = moved(
        &scene,
        &study(1.9, &["m.torque", "far.force", "c.speed"], None),
    );
    assert_eq!(name, "exact");
    for (k, t) in history.time.iter().enumerate() {
        let exact = 3.5 * 2.0 + 0.25 * (1.0 + 2.0 * t) - 7.0 - history.values[1][k];
        let found = history.values[0][k];
        within("torque of the drive, N·m", (found - exact).abs(), 1e-9);
    }
    assert!(gap(&history) < 1e-9, "{}", gap(&history));
}

/// A driven gear pair with play and a ground damper: exact between switches and by steps, its speed swinging, or constant
/// beside a brake; and as if a body of a thousand million times the inertia drove it.
#[test]
fn law_driven_pair_with_play() {
    let text = |drive: &str, inertia: f64| {
        format!(
            r#"
inertia = [{{ name = "p", J = {inertia} }}, {{ name = "w", J = 0.02 }}, {{ name = "z", J = 0.05 }}]
shaft = [{{ name = "s", between = ["w", "z"], k = 900.0, c = 0.2 }}]
gear_pair = [{{ name = "g", between = ["p", "w"], teeth = [20, 31], module = 0.004, k = 1e6, c = 200.0, backlash = 2e-4, contact_damping = "no-pull" }}]
damper = [{{ name = "d", at = "z", c = 0.01 }}]
load = [{{ at = "z", kind = "harmonic", torque = 3.0, frequency = "17 rad/s" }}]
{drive}
"#
        )
    };
    let motor = |swing: &str| {
        format!(
            "motor = [{{ name = \"m\", at = \"p\", kind = \"speed\", speed = \"12 rad/s\"{swing} }}]\n"
        )
    };
    let brake = "brake = [{ name = \"r\", at = \"z\", torque = 0.4 }]\n";
    let outputs = ["w.speed", "z.speed", "g.force"];
    let swing = motor(", amplitude = \"2 rad/s\", frequency = \"9 rad/s\", phase = \"0.3 rad\"");
    for drive in [swing, motor("") + brake] {
        let history = agree(&text(&drive, 0.01), 0.3, &outputs, "switched");
        assert!(history.stats.events > 2, "{:?}", history.stats);
        assert!(gap(&history) < 1e-4, "{}", gap(&history));
    }
    let (_, steady) = moved(
        &scene_of(&text(&(motor("") + brake), 0.01)),
        &study(0.5, &outputs, None),
    );
    let mut heavy = scene_of(&text(brake, 1e13));
    heavy.start.speeds = vec![(heavy.model.inertias[0].name.clone(), 12.0)];
    let (_, heavy) = moved(&heavy, &study(0.5, &outputs, None));
    for at in 0..3 {
        let gap = apart(&steady.values[at], &heavy.values[at]);
        assert!(gap < 1e-8, "{}: {gap:e}", outputs[at]);
    }
}

/// A body dragged by dry friction up to the speed of its drive: J ω̇ = T, then both turn as one; the heat is ½ J Ω².
#[test]
fn exact_dragged_along() {
    let text = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "b", J = 2.0 }, { name = "c", J = 1.0 }]
shaft = [{ name = "s", between = ["b", "c"] }]
brake = [{ name = "clutch", between = ["a", "b"], torque = 6.0 }]
motor = [{ name = "m", at = "a", kind = "speed", speed = "4 rad/s" }]
"#;
    // Joined by nothing but friction, which the machine's check wants to see as a joint: a damper of no size would do as well.
    let text = format!("{text}damper = [{{ name = \"d\", between = [\"a\", \"b\"], c = 0.0 }}]\n");
    let history = agree(
        &text,
        3.0,
        &["b.speed", "clutch.force", "m.torque"],
        "switched",
    );
    for (k, t) in history.time.iter().enumerate() {
        let exact = (2.0 * t).min(4.0);
        within("speed, rad/s", (history.values[0][k] - exact).abs(), 1e-12);
        if *t < 1.99 {
            assert!((history.values[2][k] - 6.0).abs() < 1e-12, "{t}");
        } else if *t > 2.01 {
            assert!(history.values[2][k].abs() < 1e-12, "{t}");
        }
    }
    let balance = history.balance.unwrap();
    within(
        "heat, J",
        (balance.dissipated - 0.5 * 3.0 * 16.0).abs(),
        1e-3,
    );
}

/// The waves of a pinion of prescribed speed are known in time, so that machines of rectangular stiffness stay piecewise linear.
#[test]
fn law_mesh_of_a_driven_pinion() {
    let text = r#"
inertia = [{ name = "p", J = 0.01 }, { name = "w", J = 0.01 }]
gear_pair = [{ name = "g", between = ["w", "p"], teeth = [30, 20], module = 0.004, k = 1e7, c = 100.0, k_wave = { kind = "rectangular", high = 1.2, low = 0.7, share = 0.4 } }]
motor = [{ name = "m", at = "p", kind = "speed", speed = "-40 rad/s" }]
load = [{ at = "w", torque = 3.0 }]
error = [{ on = "p", amplitude = 1e-5 }]
"#;
    let history = agree(text, 0.05, &["g.deflection", "w.speed"], "switched");
    assert!(gap(&history) < 1e-3, "{}", gap(&history));
}

/// The wave is known from the second gear where that is the one whose motion is prescribed; turning backward it carries the first gear, and
/// the wave, forward.
/// Against Runge and Kutta's method on `J θ̈ = T − r (k(t) δ + c δ̇)`, written out here, piece by piece of the wave.
/// Source: Runge and Kutta's classical method written in the test.
#[test]
fn ref_wave_by_the_second_gear() {
    let text = r#"
inertia = [{ name = "p", J = 0.01 }, { name = "w", J = 0.01 }]
gear_pair = [{ name = "g", between = ["w", "p"], teeth = [30, 20], module = 0.004, pressure_angle = "20 deg", k = 1e7, c = 100.0, k_wave = { kind = "rectangular", high = 1.2, low = 0.7, share = 0.4 } }]
motor = [{ name = "m", at = "p", kind = "speed", speed = "-40 rad/s" }]
load = [{ at = "w", torque = 3.0 }]
"#;
    let history = agree(text, 0.05, &["w.speed"], "switched");
    let base = |teeth: f64| 0.5 * 0.004 * teeth * 20f64.to_radians().cos();
    let (wheel, pinion) = (base(30.0), base(20.0));
    let cycle = TAU / (20.0 * 40.0);
    let slope = |factor: f64, t: f64, [angle, speed]: [f64; 2]| {
        let (delta, rate) = (
            wheel * angle - pinion * 40.0 * t,
            wheel * speed - pinion * 40.0,
        );
        [
            speed,
            (3.0 - wheel * (1e7 * factor * delta + 100.0 * rate)) / 0.01,
        ]
    };
    let on = |[x, v]: [f64; 2], h: f64, [dx, dv]: [f64; 2]| [x + h * dx, v + h * dv];
    let (mut now, mut y) = (0.0, [0.0, 0.0]);
    for (k, &t) in history.time.iter().enumerate() {
        while now < t {
            // Four tenths of a cycle high, then six low.
            let passed = (now / cycle + 1e-9).floor();
            let jump = (passed + 0.4) * cycle;
            let (factor, end) = match now < jump - 1e-9 * cycle {
                true => (1.2, jump),
                false => (0.7, (passed + 1.0) * cycle),
            };
            let end = end.min(t);
            let steps = ((end - now) / 2e-6).ceil();
            let h = (end - now) / steps;
            for at in 0..steps as usize {
                let t = now + h * at as f64;
                let a = slope(factor, t, y);
                let b = slope(factor, t + 0.5 * h, on(y, 0.5 * h, a));
                let c = slope(factor, t + 0.5 * h, on(y, 0.5 * h, b));
                let d = slope(factor, t + h, on(y, h, c));
                y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
            }
            now = end;
        }
        let off = (history.values[0][k] - y[1]).abs();
        within("angle", off / 40.0, 1e-8);
    }
}

/// Both ends of a shaft prescribed; the angle of one swings.
#[test]
fn exact_two_prescribed_ends() {
    let text = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "b", J = 2.0 }, { name = "c", J = 1.0 }]
shaft = [{ name = "s", between = ["a", "b"], k = 100.0 }, { name = "u", between = ["b", "c"], k = 100.0 }]
motor = [
  { name = "m", at = "a", kind = "angle", amplitude = 0.1, frequency = "6 rad/s" },
  { name = "h", at = "c", kind = "speed", speed = "0 rad/s" },
]
"#;
    let history = agree(text, 3.0, &["b", "m.torque", "h.torque"], "exact");
    for (k, t) in history.time.iter().enumerate() {
        // 2 b̈ + 200 b = 10 cos 6t: the forced part 10/(200 − 72) cos 6t.
        let forced = 10.0 / (200.0 - 72.0);
        let b = forced * ((6.0 * t).cos() - (10.0 * t).cos());
        within("angle, rad", (history.values[0][k] - b).abs(), 1e-13);
        let a = 0.1 * (6.0 * t).cos();
        within(
            "torque of the first drive, N·m",
            (history.values[1][k] - (-36.0 * a + 100.0 * (a - b))).abs(),
            1e-11,
        );
        within(
            "torque of the second drive, N·m",
            (history.values[2][k] + 100.0 * b).abs(),
            1e-11,
        );
    }
}

/// A speed that jumps jolts its own body only; the work of the jolt is booked.
#[test]
fn law_jumping_speed() {
    let text = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "b", J = 2.0 }]
shaft = [{ name = "s", between = ["a", "b"], k = 50.0, c = 1.0 }]
motor = [{ name = "m", at = "a", kind = "speed", times = [0, 0.5, 0.5, 1, 1], speeds = [1, 1, 4, 4, 2] }]
"#;
    let history = agree(text, 2.0, &["a.speed", "b", "s.force"], "exact");
    assert!(gap(&history) < 1e-3, "{}", gap(&history));
}

/// Started steadily a driven train stays so: wound up by what lasts of the loads.
#[test]
fn law_steady_start_of_a_driven_train() {
    let text = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "b", J = 2.0 }]
shaft = [{ name = "s", between = ["a", "b"], k = 50.0, c = 1.0 }]
motor = [{ name = "m", at = "a", kind = "speed", speed = "8 rad/s" }]
load = [{ at = "b", torque = -5.0 }]
[speed]
a = "8 rad/s"
"#;
    let mut scene = scene_of(text);
    scene.start.at = InitialState::Steady;
    let (_, history) = moved(&scene, &study(2.0, &["s.force", "m.torque"], None));
    for k in 0..history.time.len() {
        assert!((history.values[0][k] + 5.0).abs() < 1e-12);
        assert!((history.values[1][k] - 5.0).abs() < 1e-12);
    }
}

/// What cannot be prescribed.
#[test]
fn refuses_impossible_motions() {
    let all = refused(
        "inertia = [{ name = \"a\", J = 1.0 }]\nmotor = [{ name = \"m\", at = \"a\", kind = \"speed\", speed = 1.0 }]",
    );
    assert!(all.contains("every motion is prescribed"), "{all}");
    let two = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "b", J = 1.0 }, { name = "c", J = 1.0 }]
gear_pair = [{ name = "g", between = ["a", "b"], teeth = [20, 30] }]
shaft = [{ name = "s", between = ["b", "c"], k = 1.0 }]
motor = [{ name = "m", at = "a", kind = "speed", speed = 1.0 }, { name = "n", at = "b", kind = "angle", amplitude = 1.0, frequency = 1.0 }]
"#;
    let two = refused(two);
    assert!(two.contains("`m` and `n`"), "{two}");
    let curve = refused(
        "inertia = [{ name = \"a\", J = 1.0 }, { name = \"b\", J = 1.0 }]\nshaft = [{ name = \"s\", between = [\"a\", \"b\"], k = 1.0 }]\nmotor = [{ name = \"m\", at = \"a\", kind = \"speed\", speed = 1.0 }, { name = \"n\", at = \"a\", kind = \"dc\", stall = 1.0, idle = 1.0 }]",
    );
    assert!(curve.contains("both act on a.theta"), "{curve}");
}

/// Springs in series are one spring, through a gear pair too; what lies between follows exactly.
#[test]
fn exact_springs_in_series() {
    let text = |middle: f64| {
        format!(
            r#"
inertia = [{{ name = "a", J = 2.0 }}, {{ name = "b", J = {middle} }}, {{ name = "c", J = {middle} }}, {{ name = "d", J = 3.0 }}]
shaft = [{{ name = "s", between = ["a", "b"], k = 300.0 }}, {{ name = "u", between = ["c", "d"], k = 700.0 }}]
gear_pair = [{{ name = "g", between = ["b", "c"], teeth = [20, 30], module = 0.01, k = 1e5 }}]
load = [{{ at = "d", kind = "harmonic", torque = 5.0, frequency = "7 rad/s" }}, {{ at = "b", kind = "step", torque = 2.0, time = 0.3 }}]
"#
        )
    };
    let outputs = [
        "a",
        "b",
        "c.speed",
        "d",
        "s.force",
        "g.force",
        "u.deflection",
    ];
    let history = agree(&text(0.0), 2.0, &outputs, "exact");
    assert!(gap(&history) < 1e-9, "{}", gap(&history));
    let mut alone = study(2.0, &outputs, Some("exact"));
    alone.energy = false;
    let (_, light) = moved(&scene_of(&text(1e-13)), &alone);
    // What is light rings about what has no inertia, at a frequency beyond a million per second.
    for at in [0, 3] {
        let gap = apart(&history.values[at], &light.values[at]);
        within("outputs", gap, 1e-7);
    }
    // In the mesh F = s_force over the pitch radius and the load beside it; K₁K₂/ΣK thrice by hand.
    let radius = 0.5 * 20.0 * 0.01 * 20f64.to_radians().cos();
    for k in 0..history.time.len() {
        let load = if history.time[k] >= 0.3 { 2.0 } else { 0.0 };
        let balance = history.values[4][k] + radius * history.values[5][k] - load;
        assert!(balance.abs() < 1e-11, "{balance}");
        let turned = history.values[6][k] * 700.0 - 1.5 * radius * history.values[5][k];
        assert!(turned.abs() < 1e-11, "{turned}");
    }
}

/// A star of three shafts at a node without inertia, with dampers in proportion, as β K is.
#[test]
fn law_star_without_inertia() {
    let text = r#"
inertia = [{ name = "a", J = 2.0 }, { name = "b", J = 1.0 }, { name = "c", J = 0.5 }, { name = "hub", J = 0.0 }]
shaft = [{ name = "s", between = ["a", "hub"], k = 300.0 }, { name = "u", between = ["hub", "b"], k = 700.0 }, { name = "v", between = ["hub", "c"], k = 100.0 }]
load = [{ at = "c", kind = "step", torque = 2.0, time = 0.3 }]
damping = { rayleigh_stiffness = 1e-3 }
"#;
    let history = agree(
        text,
        2.0,
        &["a", "hub", "s.force", "u.force", "v.force"],
        "exact",
    );
    for k in 0..history.time.len() {
        let sum = history.values[2][k] - history.values[3][k] - history.values[4][k];
        assert!(sum.abs() < 1e-11, "{sum}");
    }
}

/// A damper and springs at a node without inertia: the limit of a small one, by an unrelated method.
#[test]
fn law_damper_behind_a_spring() {
    let text = |light: f64| {
        format!(
            r#"
inertia = [{{ name = "a", J = 2.0 }}, {{ name = "e", J = {light} }}, {{ name = "b", J = 1.0 }}]
shaft = [{{ name = "s", between = ["a", "e"], k = 300.0, c = 0.5 }}, {{ name = "u", between = ["e", "b"], k = 100.0 }}]
damper = [{{ name = "d", at = "e", c = 4.0 }}]
bearing = []
load = [{{ at = "b", kind = "step", torque = 2.0, time = 0.3 }}]
"#
        )
        .replace("bearing = []\n", "")
    };
    let outputs = ["a", "b", "b.speed"];
    let history = agree(&text(0.0), 3.0, &outputs, "exact");
    let (_, light) = moved(
        &scene_of(&text(1e-9)),
        &study(3.0, &outputs, Some("radau5")),
    );
    for at in 0..3 {
        let gap = apart(&history.values[at], &light.values[at]);
        assert!(gap < 1e-7, "{}: {gap:e}", outputs[at]);
    }
}

/// Nodes without inertia beside what is no spring and no damper, named with the remedy.
#[test]
fn refuses_massless_nodes_elsewhere() {
    let rubs = refused(
        r#"
inertia = [{ name = "a", J = 2.0 }, { name = "e", J = 0.0 }, { name = "b", J = 1.0 }]
shaft = [{ name = "s", between = ["a", "e"], k = 300.0 }, { name = "t", between = ["e", "b"], k = 100.0 }]
brake = [{ name = "r", at = "e", torque = 2.0 }]
"#,
    );
    assert!(
        rubs.contains("e.theta has no inertia, and `r`, no plain spring or damper, acts there"),
        "{rubs}"
    );
    assert!(rubs.contains("give the node a (small) inertia"), "{rubs}");
    let kept = ready(
        &scene_of(
            r#"
inertia = [{ name = "a", J = 2.0 }, { name = "e", J = 0.0 }, { name = "b", J = 1.0 }]
shaft = [{ name = "s", between = ["a", "e"], k = 300.0, c = 1.0 }, { name = "u", between = ["e", "b"], k = 100.0 }]
"#,
        ),
        &study(1.0, &["e"], None),
    );
    assert!(kept.err().unwrap().message.contains("`e` is undefined"));
}

/// Two inertias that a clutch synchronises: t = J₁J₂Δω/((J₁+J₂)T), heat ½ J₁J₂/(J₁+J₂) Δω²; joined by nothing else.
#[test]
fn exact_clutch_synchronises() {
    let text = |clutch: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 2.0 }}, {{ name = \"b\", J = 3.0 }}]\nclutch = [{{ name = \"k\", between = [\"a\", \"b\"], {clutch} }}]\n"
        )
    };
    let run = |clutch: &str, until: f64, method: Option<&str>| {
        let mut scene = scene_of(&text(clutch));
        scene.start.speeds = vec![(scene.model.inertias[0].name.clone(), 10.0)];
        let mut study = study(until, &["a.speed", "b.speed", "k.torque"], method);
        study.energy = method.is_none();
        moved(&scene, &study)
    };
    // J = 1.2, T = 6: in step after 2 s at 4 rad/s, 60 J lost.
    let (name, history) = run("torque = 6.0", 3.0, None);
    assert_eq!(name, "switched");
    for (k, t) in history.time.iter().enumerate() {
        let (a, b) = match *t < 2.0 {
            true => (10.0 - 3.0 * t, 2.0 * t),
            false => (4.0, 4.0),
        };
        within(
            "first speed, rad/s",
            (history.values[0][k] - a).abs(),
            1e-12,
        );
        within(
            "second speed, rad/s",
            (history.values[1][k] - b).abs(),
            1e-12,
        );
    }
    let lost = history.balance.unwrap().dissipated;
    within("heat", (lost / 60.0 - 1.0).abs(), 1e-4);

    // Pressed from nothing to 12 N·m within 2 s: Δω = 10 − 3t² /1.2, in step after 2 s exactly.
    for method in [None, Some("dop853-events")] {
        let (name, history) = run("times = [0.0, 2.5], torques = [0.0, 15.0]", 3.0, method);
        assert_eq!(name, method.unwrap_or("radau5"));
        for (k, t) in history.time.iter().enumerate() {
            let apart = (10.0 - 3.0 * t * t / 1.2).max(0.0);
            let found = history.values[0][k] - history.values[1][k];
            assert!((found - apart).abs() < 1e-8, "{name} {t}: {found} {apart}");
        }
    }
}

/// A clutch that has stuck lets go where its capacity falls below what it carries.
#[test]
fn exact_clutch_lets_go() {
    let text = r#"
inertia = [{ name = "a", J = 2.0 }, { name = "b", J = 3.0 }]
clutch = [{ name = "k", between = ["a", "b"], times = [0.0, 4.0], torques = [8.0, 0.0] }]
load = [{ at = "b", torque = 5.0 }]
"#;
    // It carries 2 N·m up to 3 s; from then on 2 ȧ = 8 − 2t, a = 3 + 4 (t − 3) − (t² − 9)/2.
    let history = agree(text, 3.9, &["a.speed", "b.speed", "k.torque"], "radau5");
    for (k, t) in history.time.iter().enumerate() {
        let a = match *t < 3.0 {
            true => *t,
            false => 3.0 + 4.0 * (t - 3.0) - (t * t - 9.0) / 2.0,
        };
        within("angle, rad", (history.values[0][k] - a).abs(), 1e-8);
    }
    assert!(gap(&history) < 1e-4, "{}", gap(&history));
}

/// A load of one order locked to the angle: ½ J ω² grows by its work a/n sin nθ.
#[test]
fn exact_orders_follow_the_angle() {
    let text = "inertia = [{ name = \"d\", J = 2.0 }]\nload = [{ at = \"d\", kind = \"orders\", orders = [1.5], torques = [3.0] }]\n";
    let mut scene = scene_of(text);
    scene.start.speeds = vec![(scene.model.inertias[0].name.clone(), 2.0)];
    let (name, history) = moved(&scene, &study(8.0, &["d", "d.speed"], None));
    assert_eq!(name, "dop853-events");
    for k in 0..history.time.len() {
        let (angle, speed) = (history.values[0][k], history.values[1][k]);
        let square = 4.0 + 2.0 * (1.5 * angle).sin();
        within(
            "square of the speed, rad²/s²",
            (speed * speed - square).abs(),
            1e-6,
        );
    }
    assert!(gap(&history) < 1e-8, "{}", gap(&history));
    // At imposed speed the same load is a known torque.
    scene.model.speeds = scene_of(&format!("{text}[speed]\nd = \"2 rad/s\""))
        .model
        .speeds;
    scene.start.phase = scene::laws::MeshPhase::Speed;
    let (name, history) = moved(&scene, &study(8.0, &["d.speed"], None));
    assert_eq!(name, "exact");
    for (k, t) in history.time.iter().enumerate() {
        let speed = 2.0 + 3.0 / 2.0 * (3.0 * t).sin() / 3.0;
        within("speed, rad/s", (history.values[0][k] - speed).abs(), 1e-12);
    }
}

/// Eccentricity of both gears and a table, together: at even speed the same whether they follow angles or time; and a steady
/// start is steady with them: the force stays what the load makes it.
#[test]
fn law_several_errors_in_one_mesh() {
    let text = r#"
inertia = [{ name = "p", J = 0.01 }, { name = "w", J = 0.02 }]
gear_pair = [{ name = "g", between = ["p", "w"], teeth = [20, 30], module = 0.004, k = 1e8, c = 100.0 }]
error = [{ on = "p", amplitude = 1e-5 }, { on = "w", amplitude = 2e-5, phase = "40 deg" }, { on = "w", cause = "profile", amplitude = 1e-6 }]
load = [{ at = "p", torque = 3.0 }, { at = "w", torque = 4.5 }]
[speed]
p = "5 rad/s"
"#;
    let run = |phase| {
        let mut scene = scene_of(text);
        scene.start.at = InitialState::Steady;
        scene.start.phase = phase;
        moved(&scene, &study(1.0, &["g.force", "w.speed"], None))
    };
    let (known, time) = run(scene::laws::MeshPhase::Speed);
    let (followed, angle) = run(scene::laws::MeshPhase::Angle);
    assert_eq!((known, followed), ("exact", "dop853-events"));
    assert!(gap(&angle) < 1e-6, "{}", gap(&angle));
    let force = 3.0 / (0.5 * 20.0 * 0.004 * 20f64.to_radians().cos());
    // Inertia of what the errors shake, m ë = 0.03 N, and its ring; without the speeds of the errors k ė/ω would be 2 N. Where e
    // follows the angle the start takes it at angle zero: k e′ q = 1 N.
    for (history, most) in [(&time, 0.1), (&angle, 1.0)] {
        let worst = history.values[0].iter();
        let worst = worst.fold(0.0f64, |m, f| m.max((f - force).abs()));
        assert!(worst < most && worst > 1e-4, "{worst}");
    }
    // The load works on errors that follow the angle: F e = 3e-3 J of 0.24 J, which changes the speed by half a percent.
    let gap = apart(&time.values[1], &angle.values[1]);
    assert!(gap < 1e-2, "{gap:e}");
}

/// Two motors on one node add up.
#[test]
fn law_two_motors_on_one_node() {
    let run = |motors: &str| {
        let text = format!("inertia = [{{ name = \"d\", J = 2.0 }}]\nmotor = [{motors}]\n");
        moved(&scene_of(&text), &study(3.0, &["d.speed"], None)).1
    };
    let one = run("{ name = \"m\", at = \"d\", kind = \"dc\", stall = 8.0, idle = 10.0 }");
    let two = run(
        "{ name = \"m\", at = \"d\", kind = \"dc\", stall = 3.0, idle = 10.0 }, { name = \"n\", at = \"d\", kind = \"dc\", stall = 5.0, idle = 10.0 }",
    );
    assert!(apart(&one.values[0], &two.values[0]) < 1e-13);
}

/// A wrong key is blamed, and not its neighbour.
#[test]
fn refuses_orders_by_their_own_key() {
    let text = |orders: &str| {
        format!(
            "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\ninertia = [{{ name = \"d\", J = 2.0 }}]\nload = [{{ at = \"d\", kind = \"orders\", {orders}torques = [3.0, 1.0] }}]\n"
        )
    };
    for orders in ["orders = [-1.0, 2.0], ", "orders = \"1\", ", ""] {
        let errors = scene::read_text("t.toml", &text(orders)).err().unwrap();
        let all: Vec<String> = errors
            .as_slice()
            .iter()
            .map(|e| e.message.clone())
            .collect();
        assert_eq!(all.len(), 1, "{all:?}");
        assert!(all[0].contains("orders"), "{all:?}");
    }
}
