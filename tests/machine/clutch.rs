//! What clutches carry beside bodies that move as prescribed: closed forms, an integration written by hand, the shipped engagement.

use std::f64::consts::PI;
use std::path::Path;

use crate::support::{numbers, reference, within};
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene::study::{SimulateStudy, StudyKind};
use geardyn::internals::scene::{self, Scene};

fn moved(scene: &Scene, study: &SimulateStudy) -> (&'static str, MotionResult) {
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let ready = SimulationSetup::new(&machine, &scene.start, study).unwrap();
    let choice = method_choice::choose_method(&ready.model.model, study).unwrap();
    let history = run::run(&ready, &choice, study.energy, &CancelToken::default()).unwrap();
    (choice.method.name, history)
}

fn scene_of(text: &str) -> Scene {
    let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
    scene::read_text("test.toml", &format!("{head}{text}")).unwrap()
}

fn study(until: f64, samples: u32, outputs: &[&str], method: Option<&str>) -> SimulateStudy {
    SimulateStudy {
        end_time: Some(until),
        outputs: outputs.iter().map(|s| s.to_string()).collect(),
        samples: Some(samples),
        energy: true,
        tolerance: Some(1e-10),
        method: method.map(str::to_string),
        ..SimulateStudy::default()
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// A disc under a swinging load taken along by a body of known speed: until they are in step the clutch bears what it can, then
/// the load and no more.
#[test]
fn exact_engagement_beside_a_prescribed_speed() {
    let (inertia, omega) = (2.0, 30.0);
    let text = |clutch: &str| {
        format!(
            r#"
inertia = [{{ name = "a", J = 0.7 }}, {{ name = "b", J = {inertia} }}]
motor = [{{ name = "m", at = "a", kind = "speed", speed = {omega} }}]
clutch = [{{ name = "k", between = ["a", "b"], {clutch} }}]
load = [{{ at = "b", kind = "harmonic", torque = 6.0, frequency = "1 Hz" }}]
"#
        )
    };
    let swing = |t: f64| 6.0 * (2.0 * PI * t).cos();
    let outputs = ["b.speed", "k.torque", "k.loss", "m.torque"];
    // 15 N·m always, or pressed to 40 N·m within 4 s.
    let cases = [
        ("torque = 15.0", "switched", 15.0, 1.0),
        (
            "torque = 15.0, breakaway_ratio = 1.3, stribeck_speed = 0.5",
            "radau5",
            15.0,
            1.3,
        ),
        (
            "times = [0.0, 4.0], torques = [0.0, 40.0]",
            "radau5",
            40.0,
            1.0,
        ),
        (
            "times = [0.0, 4.0], torques = [0.0, 40.0]",
            "dop853-events",
            40.0,
            1.0,
        ),
    ];
    for (clutch, name, limit, ratio) in cases {
        let asked = (name != "switched").then_some(name);
        let mut study = study(8.0, 800, &outputs, asked);
        study.energy = name == "switched";
        let (method, history) = moved(&scene_of(&text(clutch)), &study);
        assert_eq!(method, name);
        let [speed, torque, loss, drive] = &history.values[..] else {
            panic!()
        };
        assert!(
            largest(torque) <= limit * ratio * (1.0 + 1e-12),
            "{clutch}: {}",
            largest(torque)
        );
        let locked = (0..800).find(|&k| (speed[k] - omega).abs() < 1e-6).unwrap();
        assert!((200..600).contains(&locked), "{clutch}: {locked}");
        for k in locked + 1..=800 {
            let t = history.time[k];
            within("speed once locked, rad/s", (speed[k] - omega).abs(), 1e-8);
            within(
                "torque once locked, N·m",
                (torque[k] - swing(t)).abs(),
                1e-6,
            );
            within(
                "torque of the drive, N·m",
                (drive[k] + swing(t)).abs(),
                1e-6,
            );
            assert!(loss[k].abs() < 1e-6, "{clutch} {t}: {}", loss[k]);
        }
        if let Some(balance) = history.balance {
            let speed = |t: f64| 7.5 * t + 3.0 / (2.0 * PI) * (2.0 * PI * t).sin();
            for (k, found) in history.values[0].iter().enumerate().take(400) {
                within(
                    "speed while slipping, rad/s",
                    (found - speed(history.time[k])).abs(),
                    1e-11,
                );
            }
            // 4 s of slipping: the way between both, ω t − ½ 7.5 t², the swing having come round.
            let slipped: f64 = 15.0 * (omega * 4.0 - 60.0);
            let lost = balance.dissipated;
            within("heat", (lost / slipped - 1.0).abs(), 1e-5);
            assert!(
                balance.relative_error().abs() < 1e-4,
                "{clutch}: {:e}",
                balance.relative_error()
            );
        }
    }
}

/// Three discs of which the first is run up and a clutch holds the last to it.
const LOCK_UP: &str = r#"
inertia = [{ name = "disc_1", J = 5.0 }, { name = "disc_2", J = 11.0 }, { name = "disc_3", J = 22.0 }]
shaft = [{ name = "s1", between = ["disc_1", "disc_2"], k = 1e5 }, { name = "s2", between = ["disc_2", "disc_3"], k = 2e5 }]
motor = [{ name = "drive", at = "disc_1", kind = "speed", times = [0.0, 1.0], speeds = ["0 rpm", "50 rpm"] }]
"#;

fn lock_up(creep: &str) -> Scene {
    scene_of(&format!(
        "{LOCK_UP}clutch = [{{ name = \"lock\", between = [\"disc_1\", \"disc_3\"], times = [0.5, 0.8], torques = [0.0, 400.0], breakaway_ratio = 1.2, stribeck_speed = \"2 rpm\", {creep} }}]\n"
    ))
}

const SEEN: [&str; 3] = ["disc_3.theta.speed", "lock.torque", "drive.torque"];

/// Slipping, sticking and what it takes, against a program that goes from switch to switch by hand (tools/reference_clutch.py).
/// Source: SciPy 1.17.1 (tools/reference_clutch.py).
#[test]
fn ref_lock_up_while_running_up() {
    let expected = reference("clutch");
    for method in [None, Some("dop853-events")] {
        let mut asked = study(1.2, 59, &SEEN, method);
        asked.energy = false;
        asked.tolerance = Some(1e-9);
        let (_, history) = moved(&lock_up("creep_speed = 1e-4"), &asked);
        for (at, (key, near)) in [
            ("speed_rad_s", 1e-6),
            ("clutch_nm", 5e-3),
            ("drive_nm", 5e-3),
        ]
        .into_iter()
        .enumerate()
        {
            let exact = numbers(&expected[key]);
            for (found, exact) in history.values[at].iter().zip(&exact).skip(1) {
                let off = (found - exact).abs();
                within("outputs", off, near);
            }
        }
    }
}

/// A method that spreads the step over the creep speed shows the torque it works with: what sticks creeps, and carries no more.
#[test]
fn law_spread_friction_shows_what_it_carries() {
    let expected = numbers(&reference("clutch")["drive_nm"]);
    let (_, history) = moved(
        &lock_up("creep_speed = 1e-2"),
        &study(1.2, 59, &SEEN, Some("dopri5")),
    );
    assert!(
        largest(&history.values[1]) < 260.0,
        "{}",
        largest(&history.values[1])
    );
    let mean = |list: &[f64]| list[1..48].iter().sum::<f64>() / 47.0;
    let (found, exact) = (mean(&history.values[2]), mean(&expected));
    assert!((found / exact - 1.0).abs() < 0.05, "{found} {exact}");
    let gap = history.balance.unwrap().relative_error().abs();
    assert!(gap < 1e-4, "{gap:e}");
}

/// Speeds that are equal but for rounding are equal: the pair sticks from the first instant and carries its share of the load.
#[test]
fn law_rounding_is_no_sliding() {
    let text = r#"
inertia = [{ name = "a", J = 2.0 }, { name = "b", J = 3.0 }]
clutch = [{ name = "k", between = ["a", "b"], torque = 8.0 }]
load = [{ at = "b", torque = 5.0 }]
"#;
    let mut scene = scene_of(text);
    let names: Vec<_> = scene
        .model
        .inertias
        .iter()
        .map(|i| i.name.clone())
        .collect();
    let together = 0.1 + 0.2;
    assert_ne!(together, 0.3);
    scene.start.speeds = vec![(names[0].clone(), together), (names[1].clone(), 0.3)];
    for method in [None, Some("radau5"), Some("dop853-events")] {
        let (_, history) = moved(&scene, &study(1.0, 10, &["k.torque", "a.speed"], method));
        for (k, t) in history.time.iter().enumerate() {
            let (torque, speed) = (history.values[0][k], history.values[1][k]);
            assert!(
                (torque.abs() - 2.0).abs() < 1e-12,
                "{method:?} {t}: {torque}"
            );
            assert!((speed - 0.3 - t).abs() < 1e-12, "{method:?} {t}: {speed}");
        }
    }
}

/// The shipped engagement: the plates slip, bear no more than they can, lock, and the energy adds up.
#[test]
fn law_shipped_engagement() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/clutch_engagement.toml");
    let scene = scene::read(&path).unwrap();
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Simulate(study) => Some(study.clone()),
        _ => None,
    });
    let (method, history) = moved(&scene, &listed.unwrap());
    assert_eq!(method, "radau5");
    let [flywheel, hub, torque, loss, ..] = &history.values[..] else {
        panic!()
    };
    let apart = |k: usize| (flywheel[k] - hub[k]).abs();
    assert!(apart(0) > 70.0);
    let locked = (0..4000).find(|&k| apart(k) < 1e-9).unwrap();
    assert!((locked..=4000).all(|k| apart(k) < 1e-6), "it stays locked");
    for (k, t) in history.time.iter().enumerate() {
        let pressed = 90.0 * ((t - 0.05) / 0.2).clamp(0.0, 1.0);
        assert!(
            torque[k].abs() <= 1.2 * pressed + 1e-9,
            "{t}: {}",
            torque[k]
        );
        assert!(loss[k] >= -1e-9, "{t}: {}", loss[k]);
    }
    // The spindle's friction is what is left to carry: 12 N·m at 26/50.
    let last = torque[3600..].iter().sum::<f64>() / 401.0;
    assert!(
        (last.abs() / (12.0 * 26.0 / 50.0) - 1.0).abs() < 0.2,
        "{last}"
    );
    let gap = history.balance.unwrap().relative_error().abs();
    assert!(gap < 1e-5, "{gap:e}");
}
