//! Meshes whose stiffness follows their load: the law by itself, and gears that rattle against SciPy.

use std::f64::consts::TAU;
use std::sync::Arc;

use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::gear::load::load_table::LoadTable;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::simulate::SimulationResult;
use geardyn::internals::scene::laws::{MeshPhase, Waveform};
use geardyn::internals::scene::model::{MeshSprings, StiffnessVariation};
use geardyn::internals::scene::study::SimulateStudy;
use geardyn::internals::scene::{self, Scene};

use crate::bevel_meshes::prepared;
use crate::support::verification::within;

/// Loads over k, m, of the table that tools/reference_load_table.py has.
const LOADS: [f64; 4] = [2e-6, 5e-6, 1e-5, 2e-5];

/// Its table: a spring that varies over six positions, and Hertz's point contact.
fn made_table() -> LoadTable {
    let position = |i: usize| {
        let shape = 1.0 + 0.2 * (TAU * i as f64 / 6.0).cos();
        let at = |load: &f64| {
            let hertz = 2e-6 * (load / 1e-5).powf(2.0 / 3.0);
            [shape * load + hertz, shape + hertz * 2.0 / 3.0 / load]
        };
        LOADS.iter().map(at).collect()
    };
    LoadTable::new(LOADS.to_vec(), (0..6).map(position).collect())
}

/// Loads come back from their deflections, and tangent and energy are derivative and integral, on every piece.
#[test]
fn law_of_a_load_table() {
    let table = made_table();
    let curve = |share: f64| table.curve(1, share);
    let mut worst = [0.0f64; 4];
    for k in 1..400 {
        let load = 6e-8 * f64::from(k);
        let here = curve(0.3);
        let [deflection, compliance] = here.at_load(load);
        let point = here.at_deflection(deflection);
        let h = 1e-4 * deflection;
        let [low, high] = [-h, h].map(|h| here.energy(deflection + h)[0]);
        let s = 1e-4;
        let [before, after] = [0.3 - s, 0.3 + s].map(|s| curve(s).energy(deflection)[0]);
        let [energy, energy_slope] = here.energy(deflection);
        let scale = load * deflection;
        for (most, apart) in worst.iter_mut().zip([
            point.load / load - 1.0,
            point.tangent * compliance - 1.0,
            (high - low) / (2.0 * h) / load - 1.0,
            ((after - before) / (2.0 * s) - energy_slope) / scale,
        ]) {
            *most = most.max(apart.abs());
        }
        assert_eq!(here.at_deflection(-deflection).load, -point.load);
        assert_eq!(here.energy(-deflection)[0], energy);
    }
    let [load, tangent, force, slope] = worst;
    assert!(load < 1e-13 && tangent < 1e-13, "{load} {tangent}");
    assert!(force < 1e-7 && slope < 1e-7, "{force} {slope}");
}

/// A point contact under any load from its table: below the first load it is Hertz's power itself.
#[test]
fn exact_point_contact() {
    let hertz = |load: f64| 2e-6 * (load / 1e-5).powf(2.0 / 3.0);
    let node = |load: &f64| [hertz(*load), hertz(*load) * 2.0 / 3.0 / load];
    let table = LoadTable::new(LOADS.to_vec(), vec![LOADS.iter().map(node).collect()]);
    let curve = table.curve(0, 0.0);
    let off = |load: f64| (curve.at_deflection(hertz(load)).load / load - 1.0).abs();
    within("below the first load", off(3e-7), 1e-13);
    let between = (20..=200).map(|k| off(1e-7 * f64::from(k)));
    let worst = between.fold(0.0, f64::max);
    within("between loads that double", worst, 2e-3);
    let energy = curve.energy(hertz(3e-7))[0];
    let exact = 0.4 * 3e-7 * hertz(3e-7);
    within("energy, 2/5 F δ", (energy / exact - 1.0).abs(), 1e-13);
    // Every second load left out states more than what is off.
    let stated = table.interpolation();
    assert!(
        worst < stated.secant && stated.secant < 30.0 * worst,
        "{worst} {stated:?}"
    );
}

/// Two spur gears with backlash whose mesh has the made table.
fn pair(phase: MeshPhase, loads: &str) -> (Scene, PreparedMachine) {
    let text = format!(
        "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n\
         inertia = [{{ name = \"a\", J = 0.01 }}, {{ name = \"b\", J = 0.02 }}]\n\
         gear_pair = [{{ name = \"g\", between = [\"a\", \"b\"], teeth = [20, 40], module = 0.002, pressure_angle = \"20 deg\", k = 1e8, backlash = 1e-4 }}]\n\
         {loads}[speed]\na = 50.0\n"
    );
    let mut scene = scene::read_text("test.toml", &text).unwrap_or_else(|e| panic!("{e}"));
    scene.start.phase = phase;
    let names = scene.model.inertias.iter().map(|body| body.name.clone());
    scene.start.speeds = names.zip([52.0, -25.0]).collect();
    let mut machine = prepared(&scene);
    let branch = &mut machine.machine.branches[0];
    branch.stiffness_variation = Some(StiffnessVariation {
        waveform: Waveform::Table(vec![1.0; 6]),
        phase: 0.0,
    });
    branch.mesh_springs = Some(MeshSprings::LoadTable(Arc::new(made_table())));
    (scene, machine)
}

fn moved(scene: &Scene, machine: &PreparedMachine, study: &SimulateStudy) -> MotionResult {
    let ready = SimulationSetup::new(machine, &scene.start, study).unwrap();
    let choice = method_choice::choose_method(&ready.model.model, study).unwrap();
    run::run(&ready, &choice, study.energy, &CancelToken::default()).unwrap()
}

/// Gears that rattle between their flanks: free, with the phase by the angle, and loaded beyond the table, with the phase by the mean speed.
///
/// Source: computed, tools/reference_load_table.py with SciPy.
#[test]
fn ref_rattling_pair() {
    let text = std::fs::read_to_string("data/reference/load_table.json").unwrap();
    let reference: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (name, phase, loads) in [
        ("free", MeshPhase::Angle, ""),
        (
            "loaded",
            MeshPhase::Speed,
            "load = [{ at = \"a\", torque = 30.0 }, { at = \"b\", torque = 60.0 }]\n",
        ),
    ] {
        let (scene, machine) = pair(phase, loads);
        // Where teeth meet, F ~ gⁿ with n between 1 and 1.5 holds an explicit method of order 8 to a lower one.
        for (method, limit) in [("dop853-events", 1e-6), ("radau5", 1e-8)] {
            let study = SimulateStudy {
                end_time: Some(0.02),
                outputs: ["a.theta", "b.theta", "a.theta.speed", "b.theta.speed"]
                    .map(String::from)
                    .to_vec(),
                samples: Some(200),
                tolerance: Some(1e-11),
                method: Some(method.into()),
                energy: true,
                ..SimulateStudy::default()
            };
            let history = moved(&scene, &machine, &study);
            let last = history.time.len() - 1;
            let state = history.values.iter().map(|values| values[last]);
            let wanted = reference[name].as_array().unwrap();
            let off = state
                .zip(wanted)
                .map(|(got, wanted)| (got / wanted.as_f64().unwrap() - 1.0).abs());
            within(
                &format!("angles and speeds after 0.02 s, {name}, {method}"),
                off.fold(0.0, f64::max),
                limit,
            );
            let balance = history.balance.unwrap().relative_error().abs();
            assert!(balance < 1e-8, "{name} {method}: {balance}");
        }
    }
}

/// A mesh that carries more than its table warns of it, and one within it does not.
#[test]
fn survives_loads_beyond_the_table() {
    for (torque, warns) in [(30.0, true), (2.0, false)] {
        let loads = format!(
            "load = [{{ at = \"a\", torque = {torque} }}, {{ at = \"b\", torque = {} }}]\n",
            2.0 * torque
        );
        let (mut scene, machine) = pair(MeshPhase::Speed, &loads);
        scene.start.speeds.clear();
        let study = SimulateStudy {
            end_time: Some(0.005),
            outputs: vec!["g.force".into()],
            no_sensitivity: true,
            ..SimulateStudy::default()
        };
        let found = simulate(&scene, &machine, &study);
        let most = found.history.values[0]
            .iter()
            .fold(0.0, |m: f64, f| m.max(*f));
        let beyond = found
            .diagnostics
            .iter()
            .find(|d| d.code == "beyond-load-table");
        assert_eq!(beyond.is_some(), warns, "{most}");
        assert_eq!(most > 1e8 * LOADS[3], warns, "{most}");
        if let Some(beyond) = beyond {
            let share = format!("up to {:.3}", most / (1e8 * LOADS[3]));
            assert!(
                beyond.message.contains(&share),
                "{} {share}",
                beyond.message
            );
        }
    }
}

fn simulate(scene: &Scene, machine: &PreparedMachine, study: &SimulateStudy) -> SimulationResult {
    SimulationResult::simulate(scene, machine, study, &CancelToken::default(), &|_| ())
        .unwrap_or_else(|e| panic!("{e}"))
}
