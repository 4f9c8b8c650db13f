//! From scene files to motion: loads, motors, brakes, waves, starts; what is read off; what is refused.

use std::path::Path;

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Error;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::motion::dynamic_model::ForceLaw;
use geardyn::internals::motion::step_response::step_response;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene::study::SimulateStudy;
use geardyn::internals::scene::{self, Scene};

/// A model as a scene without studies.
fn scene_of(text: &str) -> Scene {
    scene::read_text(
        "test.toml",
        &format!("title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n{text}"),
    )
    .unwrap()
}

fn study(until: f64, outputs: &[&str]) -> SimulateStudy {
    SimulateStudy {
        end_time: Some(until),
        outputs: outputs.iter().map(|s| s.to_string()).collect(),
        samples: Some(2000),
        ..SimulateStudy::default()
    }
}

fn ready(scene: &Scene, study: &SimulateStudy) -> Result<SimulationSetup, Error> {
    SimulationSetup::new(&PreparedMachine::new(&scene.model)?, &scene.start, study)
}

fn moved(scene: &Scene, study: &SimulateStudy) -> (SimulationSetup, MotionResult) {
    let ready = ready(scene, study).unwrap();
    let choice = method_choice::choose_method(&ready.model.model, study).unwrap();
    let history = run::run(&ready, &choice, study.energy, &CancelToken::default()).unwrap();
    (ready, history)
}

fn shipped(name: &str) -> Scene {
    scene::read(
        &Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("examples")
            .join(name),
    )
    .unwrap()
}

/// One disc on a damped spring: ω = 10 rad/s, ζ = 0.1.
const ONE: &str = r#"
inertia = [{ name = "disc", J = 2.0 }]
shaft = [{ name = "bar", between = ["ground", "disc"], k = 200.0, c = 4.0 }]
"#;

/// The step answer of one freedom: overshoot exp(−πζ/√(1 − ζ²)), reached after π/ω_d; final value T/k.
#[test]
fn exact_step_of_one_freedom() {
    let scene = scene_of(&format!(
        "{ONE}\nload = [{{ at = \"disc\", kind = \"step\", torque = 5.0, time = 0.5 }}]"
    ));
    let mut study = study(8.0, &["disc", "bar.force"]);
    study.samples = Some(16_000);
    let (_, history) = moved(&scene, &study);
    let zeta: f64 = 0.1;
    let damped = 10.0 * (1.0 - zeta * zeta).sqrt();
    let answer = step_response(&history.time, &history.values[0], 0.5).unwrap();
    let overshoot = (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
    within(
        "overshoot",
        (answer.overshoot.0 / overshoot - 1.0).abs(),
        1e-3,
    );
    within(
        "time of the overshoot, s",
        (answer.overshoot.1 - std::f64::consts::PI / damped).abs(),
        1e-3,
    );
    within(
        "final value",
        (answer.final_value / 0.025 - 1.0).abs(),
        2e-3,
    );
    // The envelope exp(−ζωt)/√(1 − ζ²) bounds the settling; the last swing beyond 2 % lies within half a period of it.
    let envelope = -(0.02 * (1.0 - zeta * zeta).sqrt()).ln() / (zeta * 10.0);
    assert!(
        answer.settling_s < envelope
            && answer.settling_s > envelope - std::f64::consts::PI / damped,
        "{answer:?}"
    );
    // Fifteen samples a period give the same, and where the step lies between two samples.
    for (samples, time) in [(192, 0.5), (187, 0.511)] {
        let scene = scene_of(&format!(
            "{ONE}\nload = [{{ at = \"disc\", kind = \"step\", torque = 5.0, time = {time} }}]"
        ));
        let rough = SimulateStudy {
            samples: Some(samples),
            ..study.clone()
        };
        let (_, history) = moved(&scene, &rough);
        let found = step_response(&history.time, &history.values[0], time).unwrap();
        let off = [
            found.overshoot.0 / answer.overshoot.0 - 1.0,
            found.overshoot.1 / answer.overshoot.1 - 1.0,
            found.settling_s / answer.settling_s - 1.0,
            found.rise_s / answer.rise_s - 1.0,
        ];
        assert!(off.iter().all(|x| x.abs() < 0.02), "{off:?}");
        assert_eq!(found.oscillations, answer.oscillations);
    }
    // Every value in closed form.
    for (t, x) in history.time.iter().zip(&history.values[0]) {
        let s = t - 0.5;
        let exact = match s > 0.0 {
            false => 0.0,
            true => 0.025 * (1.0 - (-s).exp() * ((damped * s).cos() + (damped * s).sin() / damped)),
        };
        within("angle, rad", (x - exact).abs(), 1e-14);
    }
}

/// Ramps, tables, harmonics and orders against closed forms of a free disc: J φ̈ = T(t).
#[test]
fn exact_loads_on_a_free_disc() {
    let cases = [
        ("kind = \"constant\", torque = 3.0", 3.0 * 2.0 * 2.0 / 2.0),
        (
            "kind = \"ramp\", torque = 4.0, between = [0.0, 2.0]",
            4.0 / 2.0 * 8.0 / 6.0,
        ),
        (
            "kind = \"table\", times = [0.0, 1.0, 1.0, 2.0], torques = [2.0, 2.0, 0.0, 0.0]",
            2.0 * 0.5 + 2.0 * 1.0,
        ),
        // ∫∫ cos(3t) = (1 − cos 3t)/9.
        (
            "kind = \"harmonic\", torque = 2.0, frequency = 3.0",
            2.0 * (1.0 - 6.0f64.cos()) / 9.0,
        ),
    ];
    for (load, position) in cases {
        let frequency = load.replace("frequency = 3.0", "frequency = \"3 rad/s\"");
        let text = format!(
            "inertia = [{{ name = \"disc\", J = 1.0 }}]\nload = [{{ at = \"disc\", {frequency} }}]\n[speed]\ndisc = \"2 rad/s\""
        );
        let (_, history) = moved(&scene_of(&text), &study(2.0, &["disc"]));
        let end = history.values[0].last().unwrap();
        assert!(
            (end - position).abs() < 1e-12 * position.abs().max(1.0),
            "{load}: {end} {position}"
        );
    }
}

/// A disc on a brake: sliding with T/J until it stands, then held; its energy goes into the brake.
#[test]
fn exact_brake_stops_and_holds() {
    let text = "inertia = [{ name = \"disc\", J = 2.0 }]\nbrake = [{ name = \"b\", at = \"disc\", torque = 4.0 }]\n[speed]\ndisc = \"6 rad/s\"";
    let mut scene = scene_of(text);
    scene.start.at = scene::laws::InitialState::Steady;
    let (_, history) = moved(&scene, &study(5.0, &["disc", "disc.speed", "b.force"]));
    for (k, t) in history.time.iter().enumerate() {
        let speed = (6.0 - 2.0 * t).max(0.0);
        within("speed, rad/s", (history.values[1][k] - speed).abs(), 1e-11);
    }
    within(
        "angle at standstill, rad",
        (history.values[0].last().unwrap() - 9.0).abs(),
        1e-11,
    );
    assert!(
        history.values[2].last().unwrap().abs() < 1e-9,
        "at rest without a load it holds nothing"
    );
}

/// Run-up of a motor with a straight curve: ω = ω₀ (1 − exp(−t T₀/(J ω₀))); with Kloss's curve the time to a slip is an integral.
#[test]
fn exact_motors_run_up() {
    let text = "inertia = [{ name = \"disc\", J = 2.0 }]\nmotor = [{ name = \"m\", at = \"disc\", kind = \"dc\", stall = 10.0, idle = \"100 rad/s\" }]";
    let (_, history) = moved(&scene_of(text), &study(30.0, &["disc.speed"]));
    for (t, x) in history.time.iter().zip(&history.values[0]) {
        within(
            "speed of a straight motor, rad/s",
            (x - 100.0 * (1.0 - (-t / 20.0).exp())).abs(),
            1e-9,
        );
    }
    // t(s) = J ω_s/(2 T_k) [(1 − s²)/(2 s_k) + s_k ln(1/s)].
    let text = "inertia = [{ name = \"disc\", J = 0.5 }]\nmotor = [{ name = \"m\", at = \"disc\", kind = \"induction\", pull_out = 60.0, pull_out_slip = 0.2, synchronous = \"150 rad/s\" }]";
    let (_, history) = moved(&scene_of(text), &study(2.5, &["disc.speed", "m.force"]));
    for (t, x) in history
        .time
        .iter()
        .zip(&history.values[0])
        .filter(|p| *p.1 > 1.0 && *p.1 < 149.0)
    {
        let s = 1.0 - x / 150.0;
        let exact = 0.5 * 150.0 / 120.0 * ((1.0 - s * s) / 0.4 + 0.2 * (1.0 / s).ln());
        within(
            "time to a slip of Kloss's motor",
            (t / exact - 1.0).abs(),
            1e-6,
        );
    }
    // The motor's branch carries what the machine receives, with the opposite sign.
    let (s, pushed) = (
        1.0 - history.values[0][1000] / 150.0,
        history.values[1][1000],
    );
    assert!((pushed + 120.0 * s * 0.2 / (s * s + 0.04)).abs() < 1e-6);
}

/// A node of prescribed speed moves so whatever acts on it, and drags its neighbour along.
#[test]
fn exact_prescribed_speed() {
    let text = "inertia = [{ name = \"a\", J = 1.0 }, { name = \"b\", J = 2.0 }]\nshaft = [{ name = \"s\", between = [\"a\", \"b\"], k = 50.0 }]\nload = [{ at = \"a\", torque = 7.0 }]\n\
        motor = [{ name = \"m\", at = \"a\", kind = \"speed\", times = [0.0, 2.0], speeds = [\"0 rad/s\", \"4 rad/s\"] }]";
    let (_, history) = moved(&scene_of(text), &study(2.0, &["a.speed", "b", "s.force"]));
    for (k, t) in history.time.iter().enumerate() {
        within(
            "speed prescribed, rad/s",
            (history.values[0][k] - 2.0 * t).abs(),
            1e-13,
        );
        // J b̈ = k (t² − b): b = t² − 2/25 (1 − cos 5t).
        let exact = t * t - 2.0 / 25.0 * (1.0 - (5.0 * t).cos());
        within(
            "neighbour, rad",
            (history.values[1][k] - exact).abs(),
            1e-13,
        );
    }
}

/// Started steadily under balanced loads nothing but turning happens: deflections stay to rounding, through gears and play.
#[test]
fn law_steady_start_stays() {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("models/gear_pair.toml"),
    )
    .unwrap();
    let mut scene = scene::read_text("m.toml", &text).unwrap();
    scene.start.at = scene::laws::InitialState::Steady;
    let (_, history) = moved(
        &scene,
        &study(0.05, &["pair.deflection", "pair.force", "pinion.speed"]),
    );
    let force = 93.97 / (0.5 * 25.0 * 4e-3 * 20f64.to_radians().cos());
    for k in 0..history.time.len() {
        assert!(
            (history.values[1][k] / force - 1.0).abs() < 1e-9,
            "{}",
            history.values[1][k]
        );
        assert!((history.values[0][k] - (50e-6 + force / 4e8)).abs() < 1e-13);
    }
}

/// Waves of a mesh: rectangular and Fourier at imposed speed agree with the same machine whose phase follows its steady angle.
#[test]
fn law_phases_agree_at_steady_speed() {
    let with = |wave: &str, phase: &str| {
        let text = format!(
            r#"
inertia = [{{ name = "p", J = 10.0 }}, {{ name = "w", J = 0.01 }}]
motor = [{{ name = "m", at = "p", kind = "speed", speed = "40 rad/s" }}]
gear_pair = [{{ name = "g", between = ["p", "w"], teeth = [20, 30], module = 0.004, k = 1e8, c = 400.0, k_wave = {wave} }}]
load = [{{ at = "w", torque = 3.0 }}]
[speed]
p = "40 rad/s"
"#
        );
        let mut scene = scene_of(&text);
        scene.start.at = scene::laws::InitialState::Steady;
        scene.start.phase = if phase == "speed" {
            scene::laws::MeshPhase::Speed
        } else {
            scene::laws::MeshPhase::Angle
        };
        let mut study = study(0.05, &["g.deflection"]);
        study.method = Some("radau5".to_string());
        study.tolerance = Some(1e-10);
        moved(&scene, &study).1.values.remove(0)
    };
    // Two sines of which one leads: only equal if leads and senses are read alike.
    let wave = "{ kind = \"fourier\", amplitudes = [0.2, 0.1], phases = [\"30 deg\", \"80 deg\"], phase = \"20 deg\" }";
    let (a, b) = (with(wave, "speed"), with(wave, "angle"));
    let size = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let apart = a
        .iter()
        .zip(&b)
        .fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
    assert!(apart < 1e-4 * size, "{apart} of {size}");
    let plain = with("{ kind = \"fourier\", amplitudes = [0.0] }", "speed");
    assert!(
        a.iter()
            .zip(&plain)
            .any(|(x, y)| (x - y).abs() > 0.05 * size),
        "the wave acts"
    );
}

/// The cutting torque against a plain sum over the blades at random instants, and its mean against quadrature.
#[test]
fn exact_face_mill_torque() {
    let text = r#"
inertia = [{ name = "head", J = 1.0 }]
[speed]
head = "-6 rad/s"
[[load]]
at = "head"
kind = "face-mill"
sense = "backward"
blade_groups = 16
radius = 0.11
arc = "30 deg"
specific_force = 2.1e9
exponent = 0.26
chip_width = 0.008
chip_thickness = 0.8e-4
runout = 5e-6
roll = [0.2, 2.2]
"#;
    let scene = scene_of(text);
    let ready = ready(&scene, &study(2.5, &["head.speed"])).unwrap();
    let signal = &ready.model.model.forces[0].signal;
    let exact = |t: f64| {
        let depth = (std::f64::consts::PI * (t - 0.2) / 2.0).sin().powi(2);
        let mut sum = 0.0;
        for blade in 0..16 {
            let place = std::f64::consts::TAU * f64::from(blade) / 16.0;
            let psi = (6.0 * t + place).rem_euclid(std::f64::consts::TAU);
            if psi < 30f64.to_radians() {
                let chip_mm = 1e3
                    * (0.8e-4 * depth + 5e-6 * place.cos() * depth.sqrt())
                    * (std::f64::consts::PI * psi / 30f64.to_radians()).sin();
                sum -= 0.11 * 2100.0 * 8.0 * chip_mm.max(0.0).powf(0.74);
            }
        }
        sum
    };
    let largest = (0..4000)
        .map(|k| exact(0.2 + 0.0005 * f64::from(k)).abs())
        .fold(0.0, f64::max);
    let mut worst = 0.0f64;
    for k in 0..4000 {
        let t = 0.2 + 0.0005 * f64::from(k) + 0.0001;
        worst = worst.max((signal.value(t, signal.piece(t)) - exact(t)).abs());
    }
    within("torque, of the largest", worst / largest, 0.01);
    assert!(
        signal.value(0.1, signal.piece(0.1)) == 0.0 && signal.value(2.3, signal.piece(2.3)) == 0.0
    );
    assert!(largest > 50.0);
}

/// The forces on a head in bearings by vectors: each blade's force at its place, its moments by `r × F`; the power of the
/// cut is that of the torque, and what the bearings do not hold is not loaded.
#[test]
fn exact_face_mill_forces() {
    let scene = |slot: &str, bearing: &str| {
        scene_of(&format!(
            r#"
inertia = [{{ name = "head", J = 1.0, mass = 20.0, J_diametral = 0.6 }}]
[speed]
head = "-6 rad/s"
[[bearing]]
name = "spindle"
at = "head"
{bearing}
[[load]]
at = "head"
kind = "face-mill"
sense = "forward"
blade_groups = 5
radius = 0.11
arc = "100 deg"
specific_force = 2.1e9
exponent = 0.26
chip_width = 0.008
chip_thickness = 0.8e-4
{slot}
radial_share = 0.4
axial_share = -0.25
roll = [0.0, 1.0]
"#
        ))
    };
    let whole = "k_radial = 1e8\nk_z = 1e8\nk_tilt = 1e6";
    let axes = ["theta", "x", "y", "z", "rx", "ry"];
    let names = axes.map(|axis| format!("head.{axis}.load"));
    let names = names.each_ref().map(String::as_str);
    let ready_whole = ready(&scene("slot = \"35 deg\"", whole), &study(1.0, &names)).unwrap();
    let loads: Vec<_> = ready_whole.outputs.loads.iter().map(|l| &l.0).collect();
    assert_eq!(loads.len(), 6);
    let (r, arc) = (0.11, 100f64.to_radians());
    let exact = |t: f64| {
        let deep = (std::f64::consts::PI * t).sin();
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for blade in 0..5 {
            let psi = (6.0 * t + std::f64::consts::TAU * f64::from(blade) / 5.0)
                .rem_euclid(std::f64::consts::TAU);
            if psi < arc {
                let chip = 0.08 * deep * deep * (std::f64::consts::PI * psi / arc).sin();
                let along = 2100.0 * 8.0 * chip.powf(0.74);
                // The head turns backward: blades wander from y to x.
                let beta = 35f64.to_radians() - (psi - arc / 2.0);
                let out = [beta.cos(), beta.sin(), 0.0];
                let aside = [-beta.sin(), beta.cos(), 0.0];
                let push: [f64; 3] = std::array::from_fn(|i| {
                    along * (aside[i] + 0.4 * out[i] + [0.0, 0.0, -0.25][i])
                });
                let arm = out.map(|x| r * x);
                for i in 0..3 {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    force[i] += push[i];
                    moment[i] += arm[j] * push[k] - arm[k] * push[j];
                }
            }
        }
        [
            moment[2], force[0], force[1], force[2], moment[0], moment[1],
        ]
    };
    let mut worst = [0.0f64; 6];
    let mut size = [0.0f64; 6];
    for k in 1..2000 {
        let t = f64::from(k) / 2000.0;
        for (i, want) in exact(t).into_iter().enumerate() {
            let have = loads[i].value(t, loads[i].piece(t));
            worst[i] = worst[i].max((have - want).abs());
            size[i] = size[i].max(want.abs());
        }
    }
    for i in 0..6 {
        assert!(
            size[i] > 1.0 && worst[i] < 0.01 * size[i],
            "{worst:?} of {size:?}"
        );
    }
    let units: Vec<&str> = ready_whole.outputs.list.iter().map(|o| o.unit).collect();
    assert_eq!(units, ["N·m", "N", "N", "N", "N·m", "N·m"]);
    // Each axis is driven once; where there is none, nothing is.
    let drives = |ready: &SimulationSetup| ready.model.model.forces.len();
    assert_eq!(drives(&ready_whole), 6);
    let axial = ready(&scene("", "k_z = 1e8"), &study(1.0, &["head.z.load"])).unwrap();
    assert_eq!(drives(&axial), 2);
    let without = geardyn::internals::machine::build::build(&scene("", whole).model)
        .err()
        .unwrap();
    assert_eq!(without.code, Code::Conflict);
    assert!(without.message.contains("slot"), "{}", without.message);
    let idle = ready(&scene("", "k_z = 1e8"), &study(1.0, &["head.x.load"]));
    assert!(idle.is_err());
}

/// The tolerance decides with the limit of stability which method is taken, and the plan says so by name.
#[test]
fn law_tolerance_decides() {
    let scene = shipped("y2250_step.toml");
    let chosen = |tolerance: f64| {
        let study = SimulateStudy {
            tolerance: Some(tolerance),
            ..study(4.0, &[])
        };
        let ready = ready(&scene, &study).unwrap();
        method_choice::choose_method(&ready.model.model, &study).unwrap()
    };
    let (tight, loose) = (chosen(1e-9), chosen(1e-4));
    assert_eq!(tight.method.name, "dop853-events", "{}", tight.reason);
    assert_eq!(loose.method.name, "radau5", "{}", loose.reason);
    for choice in [tight, loose] {
        assert!(choice.reason.contains("`drive`"), "{}", choice.reason);
    }
}

/// What loads exert is an output, of orders that follow the angle as well.
#[test]
fn law_loads_are_outputs() {
    let text = r#"
inertia = [{ name = "a", J = 2.0 }, { name = "b", J = 3.0 }]
shaft = [{ name = "bar", between = ["a", "b"], k = 50.0 }]
load = [
  { at = "a", kind = "orders", orders = [2.0], torques = [4.0], mean = 1.0 },
  { at = "a", kind = "step", torque = 3.0, time = 0.5 },
]
"#;
    let scene = scene_of(text);
    let ready = ready(
        &scene,
        &study(1.0, &["a.load", "a", "a.acceleration", "bar.force"]),
    )
    .unwrap();
    let model = &ready.model.model;
    let y = [0.7, 0.2, 1.0, -1.0];
    for t in [0.2, 0.8] {
        let found = ready.outputs.evaluate(model, None, t, &y);
        let late = if t > 0.5 { 3.0 } else { 0.0 };
        let want = 1.0 + 4.0 * (2.0 * 0.7f64).cos() + late;
        assert!((found[0] - want).abs() < 1e-12, "{found:?} {want}");
        assert!(
            (2.0 * found[2] - found[0] - found[3]).abs() < 1e-12,
            "Newton's second law"
        );
    }
}

/// The energy balance closes for every shipped scene that a test can afford.
#[test]
fn law_energy_closes() {
    for (name, until) in [
        ("linear_chain.toml", 0.3),
        ("stiff_chain.toml", 0.1),
        ("backlash_pair.toml", 0.02),
        ("smooth_mesh.toml", 0.02),
        ("geared_chain.toml", 0.1),
    ] {
        let scene = shipped(name);
        let study = SimulateStudy {
            energy: true,
            samples: Some(4000),
            ..study(until, &[])
        };
        let (_, history) = moved(&scene, &study);
        let fine = history.balance.unwrap();
        assert!(fine.work_in.abs() > 0.0, "{name}: something is put in");
        assert!(
            fine.relative_error().abs() < 2e-5,
            "{name}: {} of {fine:?}",
            fine.relative_error()
        );
    }
}

/// Every shipped scene assembles, starts and finds a method; contacts say what their dampers do.
#[test]
fn law_shipped_scenes_start() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let scene = scene::read(&path).unwrap();
        assert!(!scene.studies.is_empty(), "{}", path.display());
        for listed in &scene.studies {
            if let scene::study::StudyKind::Simulate(study) = &listed.kind {
                let short = SimulateStudy {
                    end_time: Some(2e-4),
                    samples: Some(10),
                    ..study.clone()
                };
                let (ready, history) = moved(&scene, &short);
                assert_eq!(history.time.len(), 11, "{}", path.display());
                assert!(
                    history.values.iter().flatten().all(|x| x.is_finite()),
                    "{}",
                    path.display()
                );
                assert!(
                    !ready
                        .model
                        .model
                        .elements
                        .iter()
                        .any(|b| matches!(b.law, ForceLaw::Nonlinear { .. }))
                );
                count += 1;
            }
        }
    }
    assert!(count >= 10, "{count} scenes");
}

/// Two gears with play, swinging against each other, the second braked: at the breakaway force a pair begins to slide without
/// acceleration, and rounding must not bring it to rest again. The stiff method, which meets no such border, agrees.
#[test]
fn law_pairs_break_away_under_a_swinging_load() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.toml");
    let braked = |conduct: &str, ratio: f64, torque: f64| {
        let text = format!(
            r#"title = "t"
source = "t"
units = "SI"
inertia = [{{ name = "a", J = 3.577e-6 }}, {{ name = "b", J = 3.121e-5 }}]
brake = [{{ name = "brake", at = "b", torque = {torque} }}]
[[gear_pair]]
name = "pair"
between = ["a", "b"]
teeth = [20, 30]
module = 0.004
pressure_angle = 0.35
k = 1.613e8
backlash = 2.646e-5
damping_ratio = {ratio}
contact_damping = "{conduct}"
"#
        );
        std::fs::write(&model, text).unwrap();
        let start = "[start]\nspeed = { a = \"7.406 rad/s\", b = \"7.160 rad/s\" }\n";
        scene::read_text("scene.toml", &format!("model = {model:?}\n{start}")).unwrap()
    };
    for (conduct, ratio, torque) in [
        ("continuous", 0.0, 6.025e-2),
        ("continuous", 0.0, 0.3),
        ("no-pull", 0.0, 6.025e-2),
        ("no-pull", 0.05, 0.02),
    ] {
        let scene = braked(conduct, ratio, torque);
        let mut study = study(0.01, &["pair.deflection"]);
        let (_, exact) = moved(&scene, &study);
        study.method = Some("dop853-events".to_string());
        study.tolerance = Some(1e-12);
        let (_, other) = moved(&scene, &study);
        let size = exact.values[0].iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let off = exact.values[0].iter().zip(&other.values[0]);
        let off = off.fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
        assert!(off < 1e-6 * size, "{conduct} {ratio} {torque}: {off:e}");
    }
}

/// A method that was chosen and did not converge hands over to one that locates no switches; one that was asked for does not.
#[test]
fn law_who_takes_over() {
    let scene = shipped("backlash_pair.toml");
    let mut study = study(1e-3, &["pair.deflection"]);
    let model = ready(&scene, &study).unwrap().model.model;
    let first = method_choice::choose_method(&model, &study).unwrap();
    assert_eq!(first.method.name, "switched");
    let endless = Error::new(Code::NoConvergence, "endless");
    let next = method_choice::fallback(&model, &study, &first, &endless).unwrap();
    assert_eq!(next.method.name, "radau5");
    assert!(method_choice::fallback(&model, &study, &next, &endless).is_none());
    let hopeless = Error::new(Code::BudgetExceeded, "budget-exceeded");
    assert!(method_choice::fallback(&model, &study, &first, &hopeless).is_none());
    study.method = Some("switched".to_string());
    assert!(method_choice::fallback(&model, &study, &first, &endless).is_none());
}

/// What has no motion in time, or none without a word more, is refused with the code that explains it.
#[test]
fn refused_machines_and_studies() {
    let pair = |keys: &str| {
        format!(
            "inertia = [{{ name = \"p\", J = 1.0 }}, {{ name = \"w\", J = 1.0 }}]\ngear_pair = [{{ name = \"g\", between = [\"p\", \"w\"], teeth = [20, 30], module = 0.004, k = 1e6{keys} }}]"
        )
    };
    let error = |text: &str, study: SimulateStudy| ready(&scene_of(text), &study).err().unwrap();
    let one = || study(1.0, &[]);
    let undecided = error(&pair(", c = 4.0, backlash = 1e-4"), one());
    assert_eq!(undecided.code, Code::MissingKey);
    assert!(undecided.hint.unwrap().contains("no-pull"));
    assert!(
        ready(&scene_of(&pair(", backlash = 1e-4")), &one()).is_ok(),
        "without a damper all conventions are one"
    );
    assert!(
        ready(
            &scene_of(&pair(
                ", c = 4.0, backlash = 1e-4, contact_damping = \"adhesive\""
            )),
            &one()
        )
        .is_ok()
    );
    assert_eq!(
        error(&pair(", loss_factor = 0.1"), one()).code,
        Code::Conflict
    );
    let massless = "inertia = [{ name = \"a\", J = 1.0 }, { name = \"n\", J = 0.0 }]\nshaft = [{ name = \"s\", between = [\"a\", \"n\"], k = 5.0 }]\nbrake = [{ name = \"t\", at = \"n\", torque = 5.0 }]";
    assert_eq!(error(massless, one()).code, Code::Conflict);
    assert_eq!(
        error(
            ONE,
            SimulateStudy {
                end_time: None,
                ..one()
            }
        )
        .code,
        Code::MissingKey
    );
    assert_eq!(
        error(ONE, study(1.0, &["bar.torsion"])).code,
        Code::UnknownNode
    );
    let mut imposed = scene_of(&pair(
        ", k_wave = { kind = \"fourier\", amplitudes = [0.1] }",
    ));
    imposed.start.phase = scene::laws::MeshPhase::Speed;
    assert_eq!(
        ready(&imposed, &one()).err().unwrap().code,
        Code::UndeterminedSpeed
    );
    let cutter = "inertia = [{ name = \"h\", J = 1.0 }]\nload = [{ at = \"h\", kind = \"face-mill\", sense = \"forward\", blade_groups = 4, radius = 0.1, arc = 0.5, specific_force = 1e9, chip_width = 0.01, chip_thickness = 1e-4, roll = [0.0, 1.0] }]";
    assert_eq!(error(cutter, one()).code, Code::UndeterminedSpeed);
    let ready = ready(&scene_of(ONE), &one()).unwrap();
    let choose = |method: &str, step: Option<f64>| {
        method_choice::choose_method(
            &ready.model.model,
            &SimulateStudy {
                method: Some(method.into()),
                step,
                ..one()
            },
        )
        .err()
        .unwrap()
        .code
    };
    assert_eq!(choose("radua5", None), Code::OutOfRange);
    assert_eq!(choose("newmark", None), Code::Usage);
    assert_eq!(choose("radau5", Some(1e-3)), Code::Usage);
}
