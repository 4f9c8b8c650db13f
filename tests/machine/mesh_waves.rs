//! One rule for the sense of a mesh cycle (docs/signs.md), held over every element, every way to know its phase, errors and `te`.

use std::f64::consts::{PI, TAU};

use geardyn::internals::motion::dynamic_model::{DynamicModel, ForceElement};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::transmission::run::run;
use geardyn::internals::response::harmonic_balance::family::SpeedFamily;
use geardyn::internals::scene;
use geardyn::internals::scene::initial_conditions::InitialConditions;
use geardyn::internals::scene::laws::{InitialState, MeshPhase};
use geardyn::internals::scene::study::{SimulateStudy, TransmissionStudy};
use geardyn::internals::transmission::order_lines::LineOrigin;

/// A toothed pair: its elements, the shaft that carries its cycle forward, that shaft's speed per speed of `a`, and the teeth of the cycle.
struct Mesh {
    text: &'static str,
    mesh: &'static str,
    output: &'static str,
    /// Cycles per turn of `a`, above zero where the cycle goes forward with it.
    cycles: f64,
    /// Speed of the other shaft per speed of `a`.
    ratio: f64,
}

const WAVE: &str = "{ kind = \"rectangular\", high = 1.2, low = 0.8, share = 0.25 }";

const BODIES: &str = "inertia = [{ name = \"a\", J = 0.01 }, { name = \"b\", J = 0.02 }]\n";

const STAGE: &str = "inertia = [{ name = \"a\", J = 0.01 }, { name = \"b\", J = 0.02 }]\n\
    planetary = [{ name = \"g\", sun = \"a\", RING, planets = 3, teeth = [20, 25, 70], module = 0.002, planet_J = 1e-4, k_sun = 1e8, k_ring = 1e8, WAVES }]\n";

/// Every kind of toothed pair, and a stage by the mesh of its sun and of a ring that stands or turns.
const MESHES: &[Mesh] = &[
    Mesh {
        text: "gear_pair = [{ name = \"g\", between = [\"a\", \"b\"], teeth = [20, 40], module = 0.002, k = 1e8, k_wave = WAVE }]\n",
        mesh: "g",
        output: "b",
        cycles: 20.0,
        ratio: -0.5,
    },
    Mesh {
        text: "gear_pair = [{ name = \"g\", between = [\"b\", \"a\"], teeth = [40, 20], module = 0.002, k = 1e8, k_wave = WAVE }]\n",
        mesh: "g",
        output: "b",
        cycles: -20.0,
        ratio: -0.5,
    },
    Mesh {
        text: "gear_pair = [{ name = \"g\", between = [\"a\", \"b\"], teeth = [20, 40], module = 0.002, internal = true, k = 1e8, k_wave = WAVE }]\n",
        mesh: "g",
        output: "b",
        cycles: 20.0,
        ratio: 0.5,
    },
    Mesh {
        text: "worm_pair = [{ name = \"g\", between = [\"a\", \"b\"], teeth = [2, 40], module = 0.002, lead_angle = \"10 deg\", hand = \"right\", k = 1e8, k_wave = WAVE }]\n",
        mesh: "g",
        output: "b",
        cycles: 2.0,
        ratio: -0.05,
    },
    Mesh {
        text: "worm_pair = [{ name = \"g\", between = [\"a\", \"b\"], teeth = [2, 40], module = 0.002, lead_angle = \"10 deg\", hand = \"left\", k = 1e8, k_wave = WAVE }]\n",
        mesh: "g",
        output: "b",
        cycles: 2.0,
        ratio: 0.05,
    },
    // Sun forward against its carrier: 1 − 20/90 of a turn.
    Mesh {
        text: "RING ring = \"ground\", carrier = \"b\" WAVES k_wave_sun = WAVE",
        mesh: "g sun to planet 1",
        output: "b",
        cycles: 20.0 * 70.0 / 90.0,
        ratio: 20.0 / 90.0,
    },
    // A ring that stands: forward with the carrier.
    Mesh {
        text: "RING ring = \"ground\", carrier = \"b\" WAVES k_wave_ring = WAVE",
        mesh: "g ring to planet 1",
        output: "b",
        cycles: 70.0 * 20.0 / 90.0,
        ratio: 20.0 / 90.0,
    },
    // A ring that turns backward as the sun turns forward.
    Mesh {
        text: "RING ring = \"b\", carrier = \"ground\" WAVES k_wave_ring = WAVE",
        mesh: "g ring to planet 1",
        output: "b",
        cycles: -20.0,
        ratio: -20.0 / 70.0,
    },
];

impl Mesh {
    fn text(&self) -> String {
        let text = match self.text.strip_prefix("RING ") {
            None => format!("{BODIES}{}", self.text),
            Some(words) => {
                let (ring, waves) = words.split_once(" WAVES ").unwrap();
                STAGE.replace("RING", ring).replace("WAVES", waves)
            }
        };
        text.replace("WAVE", WAVE)
    }
}

fn prepared(text: &str) -> PreparedMachine {
    let model = format!("title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n{text}");
    let scene = scene::read_text("test.toml", &model).unwrap_or_else(|e| panic!("{e}\n{text}"));
    PreparedMachine::new(&scene.model).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The machine in motion from a steady start.
fn moving(ready: &PreparedMachine, phase: MeshPhase) -> SimulationSetup {
    let begin = InitialConditions {
        at: InitialState::Steady,
        phase,
        ..InitialConditions::default()
    };
    let study = SimulateStudy {
        end_time: Some(1.0),
        ..SimulateStudy::default()
    };
    SimulationSetup::new(ready, &begin, &study).unwrap_or_else(|e| panic!("{e}"))
}

fn branch<'a>(model: &'a DynamicModel, name: &str) -> &'a ForceElement {
    let found = model.elements.iter().find(|b| b.name == name);
    found.unwrap_or_else(|| {
        panic!(
            "{name} is not among {:?}",
            model.elements.iter().map(|b| &b.name).collect::<Vec<_>>()
        )
    })
}

/// How the phase of a cycle is known.
const WAYS: [(&str, MeshPhase); 5] = [
    ("", MeshPhase::Angle),
    ("", MeshPhase::Speed),
    (FIRST, MeshPhase::Angle),
    (SECOND, MeshPhase::Angle),
    (SECOND, MeshPhase::Speed),
];

const FIRST: &str =
    "motor = [{ name = \"m\", at = \"a\", kind = \"speed\", speed = \"OMEGA rad/s\" }]\n";

const SECOND: &str =
    "motor = [{ name = \"m\", at = \"b\", kind = \"speed\", speed = \"OTHER rad/s\" }]\n";

/// `text` with the prescribed motion, at these speeds of both shafts.
fn driven(text: &str, motor: &str, [a, b]: [f64; 2]) -> String {
    let motor = motor
        .replace("OMEGA", &format!("{a:?}"))
        .replace("OTHER", &format!("{b:?}"));
    format!("{text}{motor}[speed]\na = \"{a:?} rad/s\"\n")
}

/// Rectangular, the high quarter first: it comes first wherever the cycle goes forward, and last where it goes backward, whether the
/// phase follows an angle, is imposed by a speed, or is known from the prescribed motion of either gear.
#[test]
fn law_every_wave_runs_by_one_rule() {
    for (number, mesh) in MESHES.iter().enumerate() {
        for omega in [30.0, -30.0] {
            for (at, (motor, phase)) in WAYS.into_iter().enumerate() {
                let text = driven(&mesh.text(), motor, [omega, omega * mesh.ratio]);
                let moving = moving(&prepared(&text), phase);
                let model = &moving.model.model;
                let wave = branch(model, mesh.mesh).stiffness_wave.clone().unwrap();
                let speeds =
                    &moving.initial_state[model.coordinate_count()..2 * model.coordinate_count()];
                for share in [0.1, 0.3, 0.7, 0.9] {
                    let t = share * TAU / (mesh.cycles * omega).abs();
                    let q: Vec<f64> = speeds.iter().map(|v| v * t).collect();
                    let high = match mesh.cycles * omega > 0.0 {
                        true => share < 0.25,
                        false => share > 0.75,
                    };
                    let found = wave.waveform.value(wave.phase.phase_at(t, &q));
                    let wanted = if high { 1.2 } else { 0.8 };
                    assert_eq!(
                        found, wanted,
                        "mesh {number}, {omega} rad/s, way {at}, {share} of a cycle"
                    );
                }
            }
        }
    }
}

/// An error goes by the turn of its own gear, `cos(coordinate_count φ + phase)`, forward and backward, however that turn is known.
#[test]
fn law_every_error_goes_by_its_own_gear() {
    const PHASE: f64 = 0.7;
    for (on, turns) in [("a", 1.0), ("b", -0.5)] {
        for omega in [30.0, -30.0] {
            for (at, (motor, phase)) in WAYS.into_iter().enumerate() {
                let error = format!(
                    "error = [{{ on = \"{on}\", cause = \"form\", order = 3, amplitude = 1e-6, phase = {PHASE} }}]\n"
                );
                let text = format!("{}{error}", MESHES[0].text());
                let moving = moving(
                    &prepared(&driven(&text, motor, [omega, -0.5 * omega])),
                    phase,
                );
                let model = &moving.model.model;
                let branch = branch(model, "g");
                let speeds =
                    &moving.initial_state[model.coordinate_count()..2 * model.coordinate_count()];
                let still = vec![0.0; model.coordinate_count()];
                let e = |t: f64| {
                    let q: Vec<f64> = speeds.iter().map(|v| v * t).collect();
                    let known = branch.deflection(t, &q, &still, branch.pieces_at(t)).0;
                    known - branch.direction.dot(&q)
                };
                let wanted = |t: f64| (3.0 * turns * omega * t + PHASE).cos();
                // What prescribed motions add is straight in time: second differences see the error alone. The start adds what keeps the mesh
                // wound up, a share of 1e-3 of the turn.
                let h = 0.02;
                let bend = |f: &dyn Fn(f64) -> f64, t: f64| f(t) - 2.0 * f(t + h) + f(t + 2.0 * h);
                let factor = bend(&e, 0.0) / bend(&wanted, 0.0);
                assert!(
                    (factor.abs() / 1e-6 - 1.0).abs() < 1e-2,
                    "{on} {omega} {at}: {factor}"
                );
                for t in [0.013, 0.11, 0.37] {
                    let off = bend(&e, t) - factor * bend(&wanted, t);
                    assert!(off.abs() < 3e-8, "{on} {omega} {at}: {off}");
                }
            }
        }
    }
}

/// Harmonic balance takes every wave in the same sense, at every speed of its range.
#[test]
fn law_harmonic_balance_runs_with_the_wave() {
    for (number, mesh) in MESHES.iter().enumerate() {
        for omega in [30.0, -30.0] {
            let text = driven(&mesh.text(), "", [omega, omega * mesh.ratio]);
            let moving = moving(&prepared(&text), MeshPhase::Speed);
            let n = moving.model.model.coordinate_count();
            let family = SpeedFamily::new(&moving.model.model, &moving.initial_state[n..2 * n])
                .unwrap_or_else(|e| panic!("mesh {number}: {e}"));
            for factor in [0.5, 2.0] {
                let model = family.relative_at(factor * family.base);
                let wave = branch(&model, mesh.mesh).stiffness_wave.clone().unwrap();
                let still = vec![0.0; model.coordinate_count()];
                for share in [0.1, 0.3, 0.7, 0.9] {
                    let t = share * TAU / (factor * mesh.cycles * omega).abs();
                    let high = match mesh.cycles * omega > 0.0 {
                        true => share < 0.25,
                        false => share > 0.75,
                    };
                    let wanted = if high { 1.2 } else { 0.8 };
                    let found = wave.waveform.value(wave.phase.phase_at(t, &still));
                    assert_eq!(
                        found, wanted,
                        "mesh {number}, {omega} rad/s × {factor}, {share}"
                    );
                }
            }
        }
    }
}

/// Under torque the slow transmission error of a mesh is that of the same cycle: of the high quarter `arg(e₂/e₁) = −π/4` where the cycle
/// goes forward with the driver, `π/4` where backward.
#[test]
fn law_transmission_error_runs_with_the_wave() {
    for (number, mesh) in MESHES.iter().enumerate() {
        let load = "load = [{ at = \"b\", torque = 5.0 }]\nerror = [{ on = \"a\", cause = \"form\", order = 1, amplitude = 1e-6 }]\n";
        let ready = prepared(&format!("{}{load}", mesh.text()));
        let study = TransmissionStudy {
            driver: Some("a".to_string()),
            output: Some(mesh.output.to_string()),
            ..TransmissionStudy::default()
        };
        let answer = run(&ready, &study).unwrap_or_else(|e| panic!("mesh {number}: {e}"));
        let at = ready
            .machine
            .branches
            .iter()
            .position(|b| b.stiffness_variation.is_some())
            .unwrap();
        let of = |n: u32| {
            let line = answer
                .lines
                .iter()
                .map(|r| &r.line)
                .filter(|l| matches!(l.origin, LineOrigin::Stiffness(_)));
            let own = line
                .filter(|l| l.harmonic == n)
                .find_map(|l| l.displacements.iter().find(|d| d.0 == at));
            own.unwrap_or_else(|| panic!("mesh {number}: no harmonic {n}"))
                .1
        };
        let turned = (of(2) / of(1)).arg();
        let wanted = if mesh.cycles > 0.0 {
            -PI / 4.0
        } else {
            PI / 4.0
        };
        assert!(
            (turned - wanted).abs() < 1e-9,
            "mesh {number}: {turned} for {wanted}"
        );
    }
}
