//! Loaded meshes of bevel gear files in machines: against the loaded contact of the file, over every way to use them.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::load;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::gear::bevel;
use geardyn::internals::plan::gear::bevel_mesh::BevelMeshResult;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::simulate::SimulationResult;
use geardyn::internals::plan::stages::StageDecision;
use geardyn::internals::plan::transmission::run::run;
use geardyn::internals::scene::bevel_file;
use geardyn::internals::scene::laws::{InitialState, LoadHistory};
use geardyn::internals::scene::study::{SimulateStudy, TransmissionStudy};
use geardyn::internals::scene::{self, Scene};

use crate::support::verification::within;

const NASA: &str = "models/gears/bevel_12_36.toml";
/// Torque of the pinion, N·m.
const TORQUE: f64 = 40.0;

/// The shipped pair with a coarse mesh; `extra` before the table of the gear.
pub fn file(name: &str, mesh: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bevel_meshes");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    let text = std::fs::read_to_string(NASA).unwrap();
    std::fs::write(
        &path,
        text.replace("[gear]\n", &format!("{mesh}\n[gear]\n")),
    )
    .unwrap();
    path
}

/// The mesh of a file, and the sense in which its pinion drives.
pub fn mesh_of(path: &Path) -> (BevelMeshResult, f64) {
    let source = load::load(path).unwrap();
    let flags = Flags::default();
    let file = bevel_file::read(&source, &flags).unwrap();
    let result = bevel::run(&file).unwrap();
    let turn = result.contact.unwrap().forces.pinion_turn;
    (result.mesh.unwrap(), turn)
}

/// The mesh of `positions` at [`TORQUE`], by its file.
fn pitch(positions: usize) -> (PathBuf, BevelMeshResult, f64) {
    let mesh =
        format!("[mesh]\ntorque = \"{TORQUE} N·m\"\npositions = {positions}\nstations = 12\n");
    let path = file(&format!("torque_{positions}.toml"), &mesh);
    let (result, turn) = mesh_of(&path);
    (path, result, turn)
}

fn coarse() -> &'static (PathBuf, BevelMeshResult, f64) {
    static COARSE: OnceLock<(PathBuf, BevelMeshResult, f64)> = OnceLock::new();
    COARSE.get_or_init(|| pitch(12))
}

/// Two bodies and the pair; the torque of the pinion's drive flanks in N·m where there is one, which turns a left-hand pinion backwards.
pub fn two_bodies(path: &Path, keys: &str, torque: Option<f64>) -> Scene {
    let load = torque.map_or(String::new(), |t| {
        format!(
            "load = [{{ at = \"a\", torque = {} }}, {{ at = \"b\", torque = {} }}]\n",
            -t,
            -3.0 * t
        )
    });
    let text = format!(
        "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n\
         inertia = [{{ name = \"a\", J = 0.01 }}, {{ name = \"b\", J = 0.2 }}]\n\
         gear_pair = [{{ name = \"g\", between = [\"a\", \"b\"], gear = \"{}\", {keys} }}]\n{load}\
         [speed]\na = 1.0\n",
        path.display()
    );
    scene::read_text("models/test.toml", &text).unwrap_or_else(|e| panic!("{e}"))
}

pub fn prepared(scene: &Scene) -> PreparedMachine {
    PreparedMachine::new(&scene.model).unwrap_or_else(|e| panic!("{e}"))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn harmonic(values: &[f64], n: usize) -> f64 {
    let count = values.len() as f64;
    let term = |(i, v): (usize, &f64)| {
        let angle = -TAU * n as f64 * i as f64 / count;
        Complex::new(angle.cos(), angle.sin()) * (2.0 * v / count)
    };
    let terms = values.iter().enumerate().map(term);
    terms.fold(Complex::ZERO, |sum, z| sum + z).norm()
}

/// Small motions take the mean tangent stiffness along the normal: `K r₂⁻²`.
#[test]
fn exact_mean_tangent_stiffness() {
    let (path, result, _) = coarse();
    let machine = prepared(&two_bodies(path, "damping_ratio = 0.05", Some(TORQUE)));
    let tangent = mean(&result.mesh.cycles[0].of(|p| p.tangent));
    let along = tangent * result.lever.powi(-2);
    within(
        "stiffness of modes over the mean tangent",
        (machine.model.branches[0].stiffness / along - 1.0).abs(),
        1e-12,
    );
    assert!(
        matches!(&machine.meshes.decision, StageDecision::Runs(text) if text.contains("at 40 N·m of the pinion: along the normal") && text.contains("straight lines between 12 positions")),
        "{:?}",
        machine.meshes.decision
    );
}

/// Two routes to e(φ, T): order lines at rest of a loaded and of an unloaded model, and a slow motion, each with and without play.
#[test]
fn law_routes_to_loaded_bevel_error() {
    let (path, result, sense) = coarse();
    let cycle = &result.mesh.cycles[0];
    let te = cycle.of(|p| p.te);
    let [low, high] = [f64::min, f64::max].map(|pick| te.iter().copied().fold(te[0], pick));
    let study = TransmissionStudy {
        output: Some("b".into()),
        driver: Some("a".into()),
        ..TransmissionStudy::default()
    };
    for (torque, label, limit) in [
        (None, "averaged", 1e-9),
        (Some(TORQUE), "k(φ) and e(φ)", 0.03),
    ] {
        let machine = prepared(&two_bodies(path, "damping_ratio = 0.05", torque));
        let lines = run(&machine, &study).unwrap_or_else(|e| panic!("{e}"));
        let mut worst = 0.0f64;
        for n in 1..=4 {
            let at = |row: &&_| order(row) == 36.0 * n as f64;
            let sum = lines.lines.iter().filter(at).map(|row| row.loaded);
            let sum = sum.fold(Complex::ZERO, |a, b| a + b).norm();
            worst = worst.max((sum - harmonic(&te, n)).abs() / (high - low));
        }
        within(
            &format!("orders of the gear, {label}, of the range"),
            worst,
            limit,
        );
    }
    for keys in [
        "damping_ratio = 0.05",
        "damping_ratio = 0.05, contact_damping = \"no-pull\", backlash = 1e-4",
    ] {
        let worst = off_in_slow_motion(path, keys, [TORQUE; 2], (result, *sense));
        within(
            &format!("slow motion, {keys}, of the range"),
            worst / (result.lever * (high - low)),
            5e-3,
        );
    }
}

fn order(row: &geardyn::internals::plan::transmission::result::OrderLineResult) -> f64 {
    row.line.order.to_f64()
}

/// How far the transmission error of a slow motion under a load is off e(φ, T) of a mesh at its only torque, m: at its positions.
pub fn off_in_slow_motion(
    path: &Path,
    keys: &str,
    torques: [f64; 2],
    (result, sense): (&BevelMeshResult, f64),
) -> f64 {
    let te = result.mesh.cycles[0].of(|p| p.te);
    let [pinion, gear] = slow_motion(path, keys, torques);
    let step = TAU / 12.0 / te.len() as f64;
    let play = if keys.contains("backlash") {
        0.5e-4
    } else {
        0.0
    };
    let (mut worst, mut compared) = (0.0f64, 0);
    for (theta, turned) in pinion.iter().zip(&gear) {
        // The gear is ahead by te in the sense in which the pinion pushes; play leaves it behind by half.
        let ahead = -sense * (turned + theta / 3.0) * result.lever;
        let at = (theta / step).rem_euclid(te.len() as f64);
        // Between the positions k(φ) and e(φ) are straight, and e(φ, T) is not.
        if (at - at.round()).abs() > 0.05 {
            continue;
        }
        let e = te[at.round() as usize % te.len()];
        compared += 1;
        worst = worst.max((ahead + play - result.lever * e).abs());
    }
    assert_eq!(compared, te.len(), "{keys}");
    worst
}

/// The machine of a scene, under other loads than those that determine its meshes.
pub fn reloaded(scene: &Scene, factor: f64) -> PreparedMachine {
    let mut machine = prepared(scene);
    for (_, history, _) in &mut machine.machine.histories {
        if let LoadHistory::Constant(torque) = history {
            *torque *= factor;
        }
    }
    machine
}

/// Angles of pinion and gear over a pitch at 1 rad/s: meshes at the first torque, loads of the second.
fn slow_motion(path: &Path, keys: &str, [design, torque]: [f64; 2]) -> [Vec<f64>; 2] {
    let mut scene = two_bodies(path, keys, Some(design));
    let text = "title = \"m\"\nsource = \"t\"\nunits = \"SI\"\ninertia = [{ name = \"a\", J = 1.0 }]\n\
        [[motor]]\nname = \"m\"\nat = \"a\"\nkind = \"speed\"\nspeed = \"1 rad/s\"\n";
    let motor = scene::read_text("models/motor.toml", text).unwrap_or_else(|e| panic!("{e}"));
    scene.model.motors = motor.model.motors;
    scene.start.at = InitialState::Steady;
    let study = SimulateStudy {
        end_time: Some(1.1 * TAU / 12.0),
        outputs: ["a.theta", "b.theta"].map(String::from).to_vec(),
        samples: Some(66),
        no_sensitivity: true,
        ..SimulateStudy::default()
    };
    let machine = reloaded(&scene, torque / design);
    let motion =
        SimulationResult::simulate(&scene, &machine, &study, &CancelToken::default(), &|_| ())
            .unwrap_or_else(|e| panic!("{e}"));
    [0, 1].map(|i| motion.history.values[i][6..].to_vec())
}

/// The stated error of straight lines holds between the positions.
#[test]
fn law_stated_interpolation_error() {
    let (path, result, _) = coarse();
    let (_, fine, _) = pitch(24);
    let te = |r: &BevelMeshResult| r.mesh.cycles[0].of(|p| r.lever * p.te);
    let (rough, fine) = (te(result), te(&fine));
    let off = |i: usize| fine[2 * i + 1] - 0.5 * (rough[i] + rough[(i + 1) % rough.len()]);
    let worst = (0..rough.len()).fold(0.0f64, |m, i| m.max(off(i).abs()));
    let machine = prepared(&two_bodies(path, "damping_ratio = 0.05", Some(TORQUE)));
    let StageDecision::Runs(text) = &machine.meshes.decision else {
        panic!("no mesh");
    };
    let stated = text.split("off by at most ").nth(1).unwrap();
    let stated: f64 = stated.split(' ').next().unwrap().parse().unwrap();
    assert!(
        1e6 * worst <= stated && 1e6 * worst > 0.02 * stated,
        "{worst} {stated}"
    );
}

/// `k` next to a file with a torque, and loads that carry the other flanks.
#[test]
fn refuses_what_contradicts_a_bevel_file() {
    let (path, ..) = coarse();
    let text = format!(
        "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n\
         inertia = [{{ name = \"a\", J = 0.01 }}, {{ name = \"b\", J = 0.2 }}]\n\
         gear_pair = [{{ name = \"g\", between = [\"a\", \"b\"], gear = \"{}\", k = 1e8 }}]\n",
        path.display()
    );
    let refused = scene::read_text("models/test.toml", &text)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("`k` is determined by the gear file")
            && refused.contains("states a torque"),
        "{refused}"
    );
    let scene = two_bodies(path, "damping_ratio = 0.05", Some(-TORQUE));
    let refused = PreparedMachine::new(&scene.model)
        .err()
        .unwrap()
        .to_string();
    assert!(
        refused.contains("loads its coast flanks") && refused.contains("side = \"coast\""),
        "{refused}"
    );
}

/// Bearings hold the contact force of the file: both hands, drive and coast flanks, with and without play. Radial and axial forces go by
/// tangential ones, along the normal at the reference contact.
#[test]
fn law_bearings_hold_the_contact_force() {
    let text = std::fs::read_to_string(coarse().0.as_path()).unwrap();
    let mirrored = text
        .replace("\"left\"", "\"middle\"")
        .replace("\"right\"", "\"left\"")
        .replace("\"middle\"", "\"right\"");
    for (hand, text) in [("left", &text), ("right", &mirrored)] {
        for (side, concave_turn) in [("drive", 1.0), ("coast", -1.0)] {
            let contact = format!("contact = {{ side = \"{side}\" }}\n\n[pinion]\n");
            let path = coarse().0.with_file_name(format!("{hand}_{side}.toml"));
            std::fs::write(&path, text.replacen("[pinion]\n", &contact, 1)).unwrap();
            let file = bevel_file::read(&load::load(&path).unwrap(), &Flags::default()).unwrap();
            let forces = bevel::run(&file).unwrap().contact.unwrap().forces;
            let turn = if hand == "right" {
                concave_turn
            } else {
                -concave_turn
            };
            assert_eq!(forces.pinion_turn, turn, "{hand} {side}");
            let size = TORQUE / forces.levers[0];
            let [_, radial, axial] = forces.directions[0];
            for play in ["", ", backlash = 1e-4, contact_damping = \"no-pull\""] {
                let [x, z] = held(&path, play, turn * TORQUE);
                let off = (x - size * radial).abs().max((z - size * axial).abs());
                within(
                    &format!("bearing forces, {hand} hand, {side}{play}, of the contact force"),
                    off / size,
                    2e-3,
                );
            }
        }
    }
}

/// Radial and axial force of the pinion's bearing at a steady start under a torque of the pinion.
fn held(path: &Path, play: &str, torque: f64) -> [f64; 2] {
    let bearing = |at: &str| {
        format!(
            "{{ name = \"b{at}\", at = \"{at}\", k_radial = 1e8, k_z = 1e8, k_tilt = 1e6, damping_ratio = 0.03 }}"
        )
    };
    let body =
        |at: &str| format!("{{ name = \"{at}\", J = 0.01, mass = 2.0, J_diametral = 0.006 }}");
    let text = format!(
        "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n\
         inertia = [{}, {}]\nbearing = [{}, {}]\n\
         gear_pair = [{{ name = \"g\", between = [\"a\", \"b\"], gear = \"{}\", mesh_angles = [0.0, 0.0], damping_ratio = 0.03{play} }}]\n\
         load = [{{ at = \"a\", torque = {torque} }}, {{ at = \"b\", torque = {} }}]\n\
         [speed]\na = {}\n",
        body("a"),
        body("b"),
        bearing("a"),
        bearing("b"),
        path.display(),
        3.0 * torque,
        1e-6 * torque.signum(),
    );
    let mut scene = scene::read_text("models/test.toml", &text).unwrap_or_else(|e| panic!("{e}"));
    scene.start.at = InitialState::Steady;
    let study = SimulateStudy {
        end_time: Some(1e-4),
        outputs: ["ba x.force", "ba z.force"].map(String::from).to_vec(),
        samples: Some(11),
        no_sensitivity: true,
        ..SimulateStudy::default()
    };
    let machine = prepared(&scene);
    let motion =
        SimulationResult::simulate(&scene, &machine, &study, &CancelToken::default(), &|_| ())
            .unwrap_or_else(|e| panic!("{e}"));
    [0, 1].map(|i| motion.history.values[i][0])
}
