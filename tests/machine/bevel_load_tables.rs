//! Meshes of bevel files that follow their load, against the loaded contact of the file.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::gear::load::load_table::LoadTable;
use geardyn::internals::motion::methods::METHODS;
use geardyn::internals::plan::gear::bevel_mesh::BevelMeshResult;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run;
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::StageDecision;
use geardyn::internals::scene::Scene;
use geardyn::internals::scene::initial_conditions::InitialConditions;
use geardyn::internals::scene::laws::{InitialState, MeshPhase};
use geardyn::internals::scene::model::MeshSprings;
use geardyn::internals::scene::study::SimulateStudy;

use crate::bevel_meshes::{file, mesh_of, off_in_slow_motion, prepared, reloaded, two_bodies};
use crate::support::verification::within;

/// The shipped pair at five torques, with its mesh.
fn several() -> &'static (PathBuf, BevelMeshResult, f64) {
    static SEVERAL: OnceLock<(PathBuf, BevelMeshResult, f64)> = OnceLock::new();
    SEVERAL.get_or_init(|| {
        let mesh = "[mesh]\ntorques = \"10:80:5\"\npositions = 12\nstations = 12\n";
        let path = file("torques_12.toml", mesh);
        let (result, turn) = mesh_of(&path);
        (path, result, turn)
    })
}

/// The shipped pair at one torque.
fn at(torque: f64) -> BevelMeshResult {
    let mesh = format!("[mesh]\ntorque = \"{torque} N·m\"\npositions = 12\nstations = 12\n");
    mesh_of(&file(&format!("torque_{torque}_12.toml"), &mesh)).0
}

/// The table that a machine takes of the file, and N per N·m of the pinion over k.
fn table_of(machine: &PreparedMachine) -> (Arc<LoadTable>, f64) {
    let branch = &machine.machine.branches[0];
    let Some(MeshSprings::LoadTable(table)) = &branch.mesh_springs else {
        panic!("no table");
    };
    (table.clone(), table.loads()[0] / 10.0)
}

/// What the stage states between the torques holds there: deflection, secant and, in the mean over the pitch, tangent.
#[test]
fn law_stated_error_over_torque() {
    let (path, ..) = several();
    let machine = prepared(&two_bodies(path, "damping_ratio = 0.05", Some(40.0)));
    let (table, per_torque) = table_of(&machine);
    let stated = table.interpolation();
    let n = table.position_count();
    let mut worst = [0.0f64; 3];
    for torque in [12.0, 20.0, 36.0, 54.0, 71.0] {
        let exact = at(torque);
        let cycle = &exact.mesh.cycles[0];
        let mut tangents = 0.0;
        for i in 0..n {
            let load = &cycle.positions[i];
            let given_way = exact.lever * (exact.mesh.unloaded_te[i] - load.te);
            let [deflection, compliance] = table.curve(i, 0.0).at_load(per_torque * torque);
            let off = (deflection - given_way).abs();
            worst[0] = worst[0].max(off);
            worst[1] = worst[1].max(off / deflection);
            let softness = exact.lever.powi(2) / load.tangent * machine.model.branches[0].stiffness;
            tangents += (compliance / softness - 1.0).abs() / n as f64;
        }
        worst[2] = worst[2].max(tangents);
    }
    let stated = [stated.deflection, stated.secant, stated.tangent];

    for (worst, stated) in worst.into_iter().zip(stated) {
        assert!(worst <= stated && worst > 0.01 * stated, "{worst} {stated}");
    }
}

/// A slow motion under torques that the table does not have goes by e(φ, T) of the file at these torques, within the stated error.
#[test]
fn law_slow_motion_between_torques() {
    let (path, result, sense) = several();
    let scene = two_bodies(path, "damping_ratio = 0.05", Some(40.0));
    let stated = table_of(&prepared(&scene)).0.interpolation().deflection;
    for torque in [20.0, 71.0] {
        let exact = at(torque);
        let keys = "damping_ratio = 0.05, contact_damping = \"no-pull\", backlash = 1e-4";
        let off = off_in_slow_motion(path, keys, [40.0, torque], (&exact, *sense));
        let te = exact.mesh.cycles[0].of(|p| p.te);
        let [low, high] = [f64::min, f64::max].map(|pick| te.iter().copied().fold(te[0], pick));
        let range = result.lever * (high - low);
        // The motion itself is within 5e-3 of the range of e.
        assert!(off < stated + 5e-3 * range, "{torque}: {off} {stated}");
        within(
            &format!("e(φ, T) at {torque} N·m, of its range"),
            off / range,
            0.03,
        );
    }
}

/// A steady start at standstill, by the law of a load table or by that of one torque.
fn standstill(scene: &Scene, machine: &PreparedMachine, whole: bool) -> SimulationSetup {
    let begin = InitialConditions {
        at: InitialState::Steady,
        phase: MeshPhase::Speed,
        ..scene.start.clone()
    };
    let study = SimulateStudy {
        end_time: Some(0.01),
        speed: Some(1e-6),
        outputs: vec!["g.deflection".into()],
        samples: Some(2000),
        tolerance: Some(1e-10),
        ..SimulateStudy::default()
    };
    match whole {
        true => SimulationSetup::with_single_spring_meshes(machine, &begin, &study),
        false => SimulationSetup::new(machine, &begin, &study),
    }
    .unwrap_or_else(|e| panic!("{e}"))
}

/// Size of the deflection of the mesh at the start, m.
fn deflection(ready: &SimulationSetup) -> f64 {
    let (model, y) = (&ready.model.model, &ready.initial_state);
    let n = model.coordinate_count();
    let b = &model.elements[0];
    b.deflection(0.0, &y[..n], &y[n..2 * n], b.pieces_at(0.0))
        .0
        .abs()
}

/// Static deflections: the law of one torque and the table are one at that torque; under twice the load the table alone has that of the file.
#[test]
fn law_load_doubles() {
    let (path, result, _) = several();
    let scene = two_bodies(path, "damping_ratio = 0.05", Some(40.0));
    let exact = |torque: f64| {
        let mesh = at(torque).mesh;
        result.lever * (mesh.unloaded_te[0] - mesh.cycles[0].positions[0].te)
    };
    for (factor, one_torque) in [(1.0, 1e-6), (2.0, 0.25)] {
        let machine = reloaded(&scene, factor);
        let [table, one] =
            [false, true].map(|whole| deflection(&standstill(&scene, &machine, whole)));
        let exact = exact(40.0 * factor);
        within(
            &format!("deflection by the table at {} N·m", 40.0 * factor),
            (table / exact - 1.0).abs(),
            1e-6,
        );
        let off = (one / exact - 1.0).abs();
        within(
            &format!("by the stiffness at 40 N·m, at {} N·m", 40.0 * factor),
            off,
            one_torque,
        );
        assert!(factor == 1.0 || off > 0.01, "{off}");
    }
}

/// Small oscillations about a load have the tangent stiffness there: at the torque of the mesh and between torques of the table.
#[test]
fn law_small_oscillation_about_a_load() {
    let (path, result, _) = several();
    let mut scene = two_bodies(path, "backlash = 1e-4", Some(40.0));
    let name = scene.model.inertias[1].name.clone();
    scene.start.speeds = vec![(name, 5e-4)];
    for (torque, limit) in [(40.0, 1e-4), (80.0, 1e-3), (71.0, 0.02)] {
        let machine = reloaded(&scene, torque / 40.0);
        let ready = standstill(&scene, &machine, false);
        let study = SimulateStudy {
            tolerance: Some(1e-10),
            ..SimulateStudy::default()
        };
        let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
        let history = run::run(&ready, &choice, false, &CancelToken::default()).unwrap();
        let values: Vec<f64> = history.values[0]
            .iter()
            .map(|v| v - history.values[0][0])
            .collect();
        let upward = |i: &usize| values[*i] < 0.0 && values[i + 1] >= 0.0;
        let crossing = |i: usize| i as f64 + values[i] / (values[i] - values[i + 1]);
        let all: Vec<f64> = (1..values.len() - 1).filter(upward).map(crossing).collect();
        let step = history.time[1] - history.time[0];
        let period = step * (all[all.len() - 1] - all[0]) / (all.len() - 1) as f64;
        let tangent = at(torque).mesh.cycles[0].positions[0].tangent / result.lever.powi(2);
        let model = &ready.model.model;
        let direction = model.elements[0].direction.entries();
        let mobility: f64 = direction.map(|(i, a)| a * a / model.mass.entry(i, i)).sum();
        let exact = TAU / (tangent * mobility).sqrt();
        within(
            &format!("period about {torque} N·m by the tangent of the file"),
            (period / exact - 1.0).abs(),
            limit,
        );
    }
}

/// The stage names both laws and states the errors between the torques, and `periodic` refuses a load-dependent stiffness.
#[test]
fn survives_in_words() {
    let (path, ..) = several();
    let scene = two_bodies(path, "damping_ratio = 0.05", Some(40.0));
    let machine = prepared(&scene);
    let StageDecision::Runs(text) = &machine.meshes.decision else {
        panic!("no mesh");
    };
    for words in [
        "e(φ, T) of 6 torques from 10 to 80 N·m",
        "secant k by",
        "tangent k by",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let exact_over_a_period = METHODS
        .iter()
        .find(|m| m.name.starts_with("period"))
        .unwrap();
    let study = SimulateStudy {
        method: Some(exact_over_a_period.name.into()),
        ..SimulateStudy::default()
    };
    let model = &standstill(&scene, &machine, false).model.model;
    let refused = method_choice::choose_method(model, &study)
        .err()
        .unwrap()
        .to_string();
    assert!(
        refused.contains("the stiffness of g depends on its load"),
        "{refused}"
    );
}
