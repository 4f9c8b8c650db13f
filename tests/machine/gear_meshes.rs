//! Meshes of gear files in machines: against stated keys, closed forms, the loaded mesh of the file, and each other over every way to use them.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use geardyn::internals::base::error::Errors;
use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::load;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::load::mesh::LoadedMesh;
use geardyn::internals::gear::load::mesh_result::MeshResult;
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::simulate::SimulationResult;
use geardyn::internals::plan::stages::StageDecision;
use geardyn::internals::plan::transmission::{result::TransmissionResult, run::run};
use geardyn::internals::response::excitation::excitations;
use geardyn::internals::scene::gear_file::{self, GearFile};
use geardyn::internals::scene::initial_conditions::InitialConditions;
use geardyn::internals::scene::laws::{InitialState, Waveform};
use geardyn::internals::scene::model::MeshSprings;
use geardyn::internals::scene::study::{SimulateStudy, StudyKind, TransmissionStudy};
use geardyn::internals::scene::{self, Scene};

use crate::support::verification::within;

const PLAIN: &str = "models/gears/stage_28_56.toml";
const RELIEVED: &str = "models/gears/stage_28_56_relieved.toml";
/// Base radii of 28 and 56 teeth of module 3 mm, m.
const BASE: [f64; 2] = [0.042, 0.084];

fn base_radius(gear: usize) -> f64 {
    BASE[gear] * 20f64.to_radians().cos()
}

/// A folder of a test's own.
fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("gear_meshes")
        .join(test);
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// A model of `text` in the folder of the shipped models.
fn scene_of(text: &str) -> Result<Scene, Errors> {
    let text = format!("title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n{text}");
    scene::read_text("models/test.toml", &text)
}

fn prepared(text: &str) -> PreparedMachine {
    let scene = scene_of(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    PreparedMachine::new(&scene.model).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn file_of(path: &str) -> GearFile {
    let source = load::load(Path::new(path)).unwrap();
    gear_file::read(&source, &Flags::default()).unwrap()
}

/// The pitch of a gear file at a torque, computed without a machine.
fn pitch_of(path: &str, torque: f64) -> MeshResult {
    let file = file_of(path);
    let pair = Pair::new(file.members, file.centre_distance).unwrap();
    let mesh = LoadedMesh::new(&pair, file.mesh_options(&pair)).unwrap();
    mesh.map(&[torque]).unwrap()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Amplitude and phase of the n-th harmonic of one period.
fn harmonic(values: &[f64], n: usize) -> Complex {
    let count = values.len() as f64;
    let term = |(i, v): (usize, &f64)| {
        let angle = -TAU * n as f64 * i as f64 / count;
        Complex::new(angle.cos(), angle.sin()) * (2.0 * v / count)
    };
    values
        .iter()
        .enumerate()
        .map(term)
        .fold(Complex::ZERO, |sum, z| sum + z)
}

/// Two bodies and a pair of keys `pair` under 300 N·m, or so many times as much.
fn two_bodies(pair: &str, load: f64) -> String {
    format!(
        "inertia = [{{ name = \"a\", J = 0.01 }}, {{ name = \"b\", J = 0.02 }}]\n\
         gear_pair = [{{ name = \"g\", between = [\"a\", \"b\"], contact_damping = \"no-pull\", {pair} }}]\n\
         load = [{{ at = \"a\", torque = {} }}, {{ at = \"b\", torque = {} }}]\n\
         [speed]\na = 20.0\n",
        300.0 * load,
        600.0 * load
    )
}

fn named(path: &str) -> String {
    let file = path.strip_prefix("models/").unwrap();
    format!("gear = \"{file}\", damping_ratio = 0.05")
}

fn te_of(machine: &PreparedMachine, speed: Option<f64>) -> TransmissionResult {
    let study = TransmissionStudy {
        output: Some("b".into()),
        driver: Some("a".into()),
        speed,
        ..TransmissionStudy::default()
    };
    run(machine, &study).unwrap_or_else(|e| panic!("{e}"))
}

/// Sums of the lines of an order per turn of the output: loaded, and at speed where there is one.
fn at_order(result: &TransmissionResult, order: f64) -> [Complex; 2] {
    let mut sums = [Complex::ZERO; 2];
    for row in &result.lines {
        if (row.line.order.to_f64() - order).abs() < 1e-9 {
            sums[0] += row.loaded;
            sums[1] += row.dynamic.unwrap_or(Complex::ZERO);
        }
    }
    sums
}

fn list(values: &[f64]) -> String {
    let all: Vec<String> = values.iter().map(|v| format!("{v:e}")).collect();
    format!("[{}]", all.join(", "))
}

/// A machine with the keys that a gear file determines written out: modes, lines of the transmission error and forces are the same.
#[test]
fn exact_stated_keys() {
    let result = pitch_of(RELIEVED, 300.0);
    let cycle = &result.cycles[0];
    let k = mean(&cycle.tangent);
    let factors: Vec<f64> = cycle.secant.iter().map(|s| s / k).collect();
    // Spur gears at their reference centre distance, each tooth 60 µm thinner in the mean.
    let backlash = 2.0 * 60e-6 * 20f64.to_radians().cos();
    let keys = format!(
        "teeth = [28, 56], module = 0.003, pressure_angle = {}, damping_ratio = 0.05, k = {k:e}, backlash = {backlash:e}, k_wave = {{ kind = \"table\", values = {} }}",
        20f64.to_radians(),
        list(&factors)
    );
    let turn: Vec<f64> = (0..28).flat_map(|_| result.unloaded_te.clone()).collect();
    let error = format!(
        "[[error]]\non = \"a\"\ncause = \"profile\"\nvalues = {}\n",
        list(&turn)
    );
    let stated = prepared(&(two_bodies(&keys, 1.0) + &error));
    let by_file = prepared(&two_bodies(&named(RELIEVED), 1.0));
    let [one, other] = [&by_file, &stated].map(|m| &m.machine.branches[0]);
    within(
        "backlash",
        (one.backlash / other.backlash - 1.0).abs(),
        1e-9,
    );
    let [one, other] = [&by_file, &stated].map(|m| m.model.branches[0].stiffness);
    within("stiffness", (one / other - 1.0).abs(), 1e-14);
    let [one, other] = [&by_file, &stated].map(|m| te_of(m, Some(20.0)));
    let size = at_order(&other, 56.0)[0].norm().max(1e-6);
    let mut worst = 0.0f64;
    for n in 1..=16 {
        let [a, b] = [&one, &other].map(|r| at_order(r, 56.0 * f64::from(n)));
        worst = worst.max((a[0] - b[0]).norm() / size);
        worst = worst.max((a[1] - b[1]).norm() / size);
    }
    within("lines, loaded and at speed", worst, 1e-9);
    let study = SimulateStudy {
        end_time: Some(1.0),
        outputs: vec!["g.force".into()],
        ..SimulateStudy::default()
    };
    let begin = InitialConditions {
        at: InitialState::Steady,
        ..InitialConditions::default()
    };
    let one = SimulationSetup::with_single_spring_meshes(&by_file, &begin, &study).unwrap();
    let other = SimulationSetup::new(&stated, &begin, &study).unwrap();
    let mut worst = 0.0f64;
    for step in 0..200 {
        let turned = 0.013 * f64::from(step);
        let y = [
            turned,
            -0.5 * turned + 2e-3 + 1e-6 * f64::from(step),
            20.0,
            -10.0,
        ];
        let [a, b] = [&one, &other].map(|s| s.model.model.element_force(0, None, 0.0, &y, 0.0).0);
        worst = worst.max((a - b).abs() / b.abs().max(1.0));
    }
    within("force over two turns of the cycle", worst, 1e-8);
}

/// Constant pair stiffness c′ b (ISO 6336-1) and no relief: the least stiffness over the mesh cycle is that of one pair, the mean under a
/// small load that of ε_α pairs; FZG gears type C.
#[test]
fn exact_constant_pair_stiffness() {
    let place = folder("constant");
    let fzg = std::fs::read_to_string("models/gears/fzg_c.toml").unwrap();
    std::fs::write(
        place.join("iso.toml"),
        format!("{fzg}\n[mesh]\nmethod = \"iso-6336\"\npositions = 2000\n"),
    )
    .unwrap();
    let pair = format!("gear = \"{}\"", place.join("iso.toml").display());
    let machine = prepared(&two_bodies(&pair, 1e-8));
    let branch = &machine.machine.branches[0];
    let file = file_of("models/gears/fzg_c.toml");
    let pair = Pair::new(file.members, file.centre_distance).unwrap();
    let material = Default::default();
    let iso = geardyn::internals::gear::load::iso6336::IsoStiffness::new(
        &pair,
        &[material; 2],
        [None; 2],
    );
    let single = iso.single * 0.014;
    let k = machine.model.branches[0].stiffness;
    let Some(Waveform::Table(factors)) = branch
        .stiffness_variation
        .as_ref()
        .map(|w| w.waveform.clone())
    else {
        panic!("no table");
    };
    let least = factors.iter().fold(f64::INFINITY, |m, f| m.min(*f));
    within("one pair", (k * least / single - 1.0).abs(), 1e-12);
    let ratio = pair.contact_ratios().transverse;
    within(
        "mean of ε_α pairs",
        (k / (ratio * single) - 1.0).abs(),
        2e-3,
    );
}

/// Tooth pairs as one-sided springs carry the design torque at the approach of the whole mesh, on either flank.
#[test]
fn law_pairs_carry_what_the_mesh_carries() {
    for (path, load) in [(PLAIN, 1.0), (RELIEVED, 1.0), (RELIEVED, -0.6)] {
        let machine = prepared(&two_bodies(&named(path), load));
        let branch = &machine.machine.branches[0];
        let Some(MeshSprings::ToothPairs(pairs)) = &branch.mesh_springs else {
            panic!("no tooth pairs");
        };
        assert_eq!(pairs.count, 3, "ε_α = 1.71");
        let torque = 300.0 * load.abs();
        let result = pitch_of(path, torque);
        let cycle = &result.cycles[0];
        let spring = &pairs.flanks[usize::from(load < 0.0)];
        let k = machine.model.branches[0].stiffness;
        let (Waveform::Table(stiffness), Waveform::Table(gap)) = (&spring.stiffness, &spring.gap)
        else {
            panic!("no tables");
        };
        let per_pitch = cycle.te.len();
        assert_eq!(gap.len(), 3 * per_pitch);
        let mut worst = 0.0f64;
        for i in 0..per_pitch {
            // Coast flanks run through the table backward.
            let at = if load < 0.0 {
                (gap.len() - i) % gap.len()
            } else {
                i
            };
            let approach = -cycle.te[i];
            let force = |j: usize| {
                let at = (at + j * per_pitch) % gap.len();
                k * stiffness[at] * (approach - gap[at]).max(0.0)
            };
            let sum: f64 = (0..3).map(force).sum();
            worst = worst.max((sum * base_radius(0) / torque - 1.0).abs());
        }
        within(
            &format!("torque of the pairs, load {load}, {path}"),
            worst,
            1e-9,
        );
    }
}

/// Three routes to e(φ, T) at slow speed: quasi-static lines, the displacement that responses take, a slow motion with events.
#[test]
fn law_three_routes_to_loaded_error() {
    let range = pitch_of(PLAIN, 300.0).cycles[0].peak_to_peak();
    for path in [PLAIN, RELIEVED] {
        let result = pitch_of(path, 300.0);
        let te = &result.cycles[0].te;
        let size = result.cycles[0].peak_to_peak();
        let machine = prepared(&two_bodies(&named(path), 1.0));
        let lines = te_of(&machine, Some(0.05));
        let all = excitations(&machine.machine, &machine.kinematics, &machine.operating).unwrap();
        let (mut slow, mut dynamic, mut taken) = (0.0f64, 0.0f64, 0.0f64);
        for n in 1..=4 {
            let exact = harmonic(te, n).norm();
            let [loaded, at_speed] =
                at_order(&lines, 56.0 * n as f64).map(|z| z.norm() * base_radius(1));
            slow = slow.max((loaded - exact).abs() / size);
            dynamic = dynamic.max((at_speed - loaded).abs() / size);
            let order = 28.0 * n as f64;
            let own = all
                .iter()
                .find(|e| e.declared && (e.order - order).abs() < 1e-9);
            taken = taken.max((own.map_or(0.0, |e| e.amplitude) - exact).abs() / size);
        }
        // Straight lines between 60 values of k(φ).
        within(&format!("quasi-static lines, {path}"), slow, 5e-3);
        within(&format!("lines at 0.5 rpm, {path}"), dynamic, 1e-6);
        within(&format!("displacement of responses, {path}"), taken, 1e-12);
        let [deflection, angle] = slow_motion(path, 1.0);
        let step = TAU / 28.0 / te.len() as f64;
        let mut worst = 0.0f64;
        for (x, theta) in deflection.iter().zip(&angle) {
            let at = (theta / step).rem_euclid(te.len() as f64);
            let (i, share) = (at.floor() as usize % te.len(), at.fract());
            let e = te[i] + share * (te[(i + 1) % te.len()] - te[i]);
            worst = worst.max((x - 0.5 * 112.763_114_494e-6 + e).abs());
        }
        within(
            &format!("slow motion with events, of the range of the plain pair, {path}"),
            worst / range,
            0.01,
        );
    }
}

/// Deflection of the pair and angle of the pinion over a pitch at 9.5 rpm, after a tenth of one; `sense` −1 on the coast flanks.
fn slow_motion(path: &str, sense: f64) -> [Vec<f64>; 2] {
    const SLOW: f64 = 1.0; // rad/s
    let pitch_time = TAU / 28.0 / SLOW;
    let text = two_bodies(&named(path), sense)
        .replace("a = 20.0", &format!("a = {}", SLOW * sense))
        + &format!(
            "[[motor]]\nname = \"m\"\nat = \"a\"\nkind = \"speed\"\nspeed = \"{} rad/s\"\n",
            SLOW * sense
        );
    let mut scene = scene_of(&text).unwrap_or_else(|e| panic!("{e}"));
    scene.start.at = InitialState::Steady;
    let study = SimulateStudy {
        end_time: Some(1.1 * pitch_time),
        outputs: ["g.deflection", "a.theta"].map(String::from).to_vec(),
        // At the positions of the table, between which it is straight.
        samples: Some(66),
        no_sensitivity: true,
        ..SimulateStudy::default()
    };
    let machine = PreparedMachine::new(&scene.model).unwrap_or_else(|e| panic!("{e}"));
    let motion =
        SimulationResult::simulate(&scene, &machine, &study, &CancelToken::default(), &|_| ())
            .unwrap_or_else(|e| panic!("{e}"));
    [0, 1].map(|i| motion.history.values[i][6..].to_vec())
}

/// A pair turned backward on its other flanks, and a pair of the other hand: the same stiffness, range and amplitudes.
#[test]
fn law_coast_flanks_and_other_hand() {
    let drive = prepared(&two_bodies(&named(RELIEVED), 1.0));
    let coast = prepared(&two_bodies(&named(RELIEVED), -1.0));
    let stiffness = |m: &PreparedMachine| m.model.branches[0].stiffness;
    assert_eq!(stiffness(&drive), stiffness(&coast));
    let [one, other] = [&drive, &coast].map(|m| te_of(m, None));
    let mut worst = 0.0f64;
    for n in 1..=8 {
        let [a, b] = [&one, &other].map(|r| at_order(r, 56.0 * f64::from(n))[0].norm());
        worst = worst.max((a / b - 1.0).abs());
    }
    within("amplitudes on coast flanks", worst, 1e-9);
    // A tooth of the pinion is 60 µm thinner than half a pitch at the pitch circle.
    let phase = |m: &PreparedMachine| {
        m.machine.branches[0]
            .stiffness_variation
            .as_ref()
            .unwrap()
            .phase
    };
    let tooth = 0.5 - 60e-6 / (TAU * 0.0015);
    within(
        "tooth thickness in pitches",
        (phase(&coast) / TAU + tooth).abs(),
        1e-6,
    );
    let place = folder("hands");
    let text = std::fs::read_to_string(PLAIN).unwrap();
    let helical = text
        .replace("centre_distance = \"126 mm\"", "helix_angle = \"12 deg\"")
        .replace("teeth = 28,", "teeth = 28, hand = \"HAND\",");
    let machines = ["right", "left"].map(|hand| {
        let path = place.join(format!("{hand}.toml"));
        std::fs::write(&path, helical.replace("HAND", hand)).unwrap();
        prepared(&two_bodies(
            &format!("gear = \"{}\", damping_ratio = 0.05", path.display()),
            1.0,
        ))
    });
    let [right, left] = &machines;
    assert_eq!(stiffness(right), stiffness(left));
    let [one, other] = [right, left].map(|m| te_of(m, None));
    let lines = one.lines.len();
    assert!(lines > 0 && lines == other.lines.len());
    for (a, b) in one.lines.iter().zip(&other.lines) {
        assert_eq!(a.loaded, b.loaded);
    }
    // Along the normal in space the stiffness is that of the transverse section over cos² β_b.
    let file = file_of(place.join("right.toml").to_str().unwrap());
    let pair = Pair::new(file.members, file.centre_distance).unwrap();
    let mesh = LoadedMesh::new(&pair, file.mesh_options(&pair)).unwrap();
    let transverse = mean(&mesh.map(&[300.0]).unwrap().cycles[0].tangent);
    let base = (12f64.to_radians().sin() * 20f64.to_radians().cos()).asin();
    let normal = transverse / base.cos().powi(2);
    within(
        "stiffness along the normal",
        (stiffness(right) / normal - 1.0).abs(),
        1e-9,
    );
}

/// A slow motion on the coast flanks is the mirror image of that on the drive flanks.
#[test]
fn law_motion_on_coast_flanks_is_mirrored() {
    let te = pitch_of(RELIEVED, 300.0).cycles[0].te.clone();
    let [deflection, angle] = slow_motion(RELIEVED, -1.0);
    let step = TAU / 28.0 / te.len() as f64;
    let tooth = (0.5 - 60e-6 / (TAU * 0.0015)) * te.len() as f64;
    let range = pitch_of(PLAIN, 300.0).cycles[0].peak_to_peak();
    let mut worst = 0.0f64;
    for (x, theta) in deflection.iter().zip(&angle) {
        let at = (tooth - theta / step).rem_euclid(te.len() as f64);
        let (i, share) = (at.floor() as usize % te.len(), at.fract());
        let e = te[i] + share * (te[(i + 1) % te.len()] - te[i]);
        worst = worst.max((-x - 0.5 * 112.763_114_494e-6 + e).abs());
    }
    // Coast flanks are between the positions of the table, where it is straight and e is not.
    within("slow motion on coast flanks", worst / range, 0.03);
}

const SUN: &str = "title = \"sun and planet\"\nsource = \"made for a test\"\n\
    pair = { kind = \"cylindrical\", module = \"2 mm\", centre_distance = \"48 mm\" }\n\
    pinion = { teeth = 24, face_width = \"20 mm\" }\n\
    gear = { teeth = 24, face_width = \"20 mm\", tip_diameter = \"52 mm\" }\n";

const RING: &str = "title = \"planet and ring\"\nsource = \"made for a test\"\n\
    pair = { kind = \"cylindrical\", module = \"2 mm\", centre_distance = \"48 mm\" }\n\
    pinion = { teeth = 24, face_width = \"20 mm\", tip_diameter = \"52 mm\" }\n\
    gear = { teeth = 72, internal = true, face_width = \"20 mm\" }\n";

fn stage(place: &Path, members: &str, extra: &str) -> String {
    let bodies = ["s", "r", "c"].map(|name| match members.contains(&format!("= \"{name}\"")) {
        true => format!("{{ name = \"{name}\", J = 1e-2 }}, "),
        false => String::new(),
    });
    let bodies = bodies.concat();
    format!(
        "inertia = [{bodies}]\n\
         planetary = [{{ name = \"p\", {members}, planets = 3, planet_J = 1e-4, gear_sun = \"{}\", gear_ring = \"{}\" {extra} }}]\n",
        place.join("sun.toml").display(),
        place.join("ring.toml").display()
    )
}

/// Planets of an even tooth number without backlash: the ring's mesh is half a pitch ahead of the sun's (Parker and Lin 2004, eq. 12), at
/// every planet, whichever member stands and wherever the stage has turned.
#[test]
fn exact_phases_of_planets() {
    let place = folder("stage");
    for (name, text) in [("sun", SUN), ("ring", RING)] {
        let text = format!("{text}mesh = {{ torque = \"100 N·m\" }}\n");
        std::fs::write(place.join(format!("{name}.toml")), text).unwrap();
    }
    let [sun, ring] = ["sun", "ring"]
        .map(|name| pitch_of(place.join(format!("{name}.toml")).to_str().unwrap(), 100.0));
    let factor = |result: &MeshResult, cycle: f64| {
        let tangent = mean(&result.cycles[0].tangent);
        let table = &result.cycles[0].secant;
        let at = cycle.rem_euclid(1.0) * table.len() as f64;
        let (i, share) = (at.floor() as usize % table.len(), at.fract());
        (table[i] + share * (table[(i + 1) % table.len()] - table[i])) / tangent
    };
    for (members, standing) in [
        ("sun = \"s\", ring = \"ground\", carrier = \"c\"", "r"),
        ("sun = \"s\", ring = \"r\", carrier = \"ground\"", "c"),
        ("sun = \"ground\", ring = \"r\", carrier = \"c\"", "s"),
        ("sun = \"s\", ring = \"r\", carrier = \"c\"", ""),
    ] {
        let machine = prepared(&stage(&place, members, ""));
        let study = SimulateStudy {
            end_time: Some(1.0),
            outputs: vec!["p.planet_1".into()],
            ..SimulateStudy::default()
        };
        let setup = SimulationSetup::with_single_spring_meshes(
            &machine,
            &InitialConditions::default(),
            &study,
        )
        .unwrap();
        let model = &setup.model.model;
        let mut worst = 0.0f64;
        for step in 0..40 {
            let turn = |name: &str, angle: f64| if name == standing { 0.0 } else { angle };
            let at = 0.0123 * f64::from(step);
            // Rolling without strain: 24 (θ_s − θ_c) = −24 (θ_p − θ_c) = −72 (θ_r − θ_c).
            let (s, c) = match standing {
                "r" => (4.0 * at, at),
                "c" => (at, 0.0),
                "s" => (0.0, at),
                _ => (at, -0.37 * at),
            };
            let p = c - (s - c);
            let r = c - (s - c) / 3.0;
            assert!(turn("r", r) == r || r.abs() < 1e-15);
            let q: Vec<f64> = model
                .coordinates
                .iter()
                .map(|name| match name.as_str() {
                    "s.theta" => s,
                    "r.theta" => r,
                    "c.theta" => c,
                    _ => p,
                })
                .collect();
            for element in &model.elements {
                let Some(wave) = &element.stiffness_wave else {
                    continue;
                };
                let number: f64 = element.name.rsplit(' ').next().unwrap().parse().unwrap();
                let position = TAU * (number - 1.0) / 3.0;
                let cycle = 24.0 * (s - c - position) / TAU;
                let (result, cycle) = match element.name.contains("sun") {
                    true => (&sun, cycle),
                    false => (&ring, cycle + 0.5),
                };
                let found = wave.waveform.value(wave.phase.phase_at(0.0, &q));
                worst = worst.max((found - factor(result, cycle)).abs());
            }
        }
        within(
            &format!("stiffness of planets' meshes, {members}"),
            worst,
            1e-9,
        );
    }
}

/// A stage of gear files is the stage of its tooth numbers, module and stiffnesses, lateral as well.
#[test]
fn exact_stage_of_stated_keys() {
    let place = folder("stated_stage");
    for (name, text) in [("sun", SUN), ("ring", RING)] {
        let text = format!("{text}mesh = {{ torque = \"100 N·m\" }}\n");
        std::fs::write(place.join(format!("{name}.toml")), text).unwrap();
    }
    let k = ["sun", "ring"].map(|name| {
        let path = place.join(format!("{name}.toml"));
        mean(&pitch_of(path.to_str().unwrap(), 100.0).cycles[0].tangent)
    });
    let members = "sun = \"s\", ring = \"r\", carrier = \"c\"";
    let lateral = ", lateral = true, planet_mass = 0.3, k_bearing = 1e8";
    let by_file = prepared(&stage(&place, members, lateral));
    let stated = stage(&place, members, lateral);
    let (before, _) = stated.split_once("gear_sun").unwrap();
    let stated = format!(
        "{before}teeth = [24, 24, 72], module = 0.002, k_sun = {:e}, k_ring = {:e} {lateral} }}]\n",
        k[0], k[1]
    );
    let stated = prepared(&stated);
    let frequencies = [&by_file, &stated].map(|machine| {
        let basis = geardyn::internals::modes::modal_basis::solve(
            &machine.model,
            geardyn::internals::modes::modal_basis::UndampedSolver::Factored,
        );
        basis.unwrap().omega
    });
    assert_eq!(frequencies[0].len(), frequencies[1].len());
    let largest = frequencies[1].iter().fold(0.0f64, |m, w| m.max(*w));
    let worst = frequencies[0]
        .iter()
        .zip(&frequencies[1])
        .fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    within("natural frequencies of a stage", worst / largest, 1e-9);
}

fn scene_at(path: &str) -> (Scene, PreparedMachine) {
    let scene = scene::read(Path::new(path)).unwrap_or_else(|e| panic!("{e}"));
    let machine = PreparedMachine::new(&scene.model).unwrap();
    (scene, machine)
}

/// The shipped scenes differ in tip relief alone: at the design torque the first mesh orders fall as e(φ, T) of the gear files does.
#[test]
fn law_relief_lowers_the_mesh_orders() {
    let lines = ["plain", "relieved"].map(|name| {
        let (scene, machine) = scene_at(&format!("examples/tip_relief_{name}.toml"));
        let StudyKind::Transmission(study) = &scene.studies[0].kind else {
            panic!("a study of te");
        };
        run(&machine, study).unwrap()
    });
    let pitches = [PLAIN, RELIEVED].map(|path| pitch_of(path, 300.0));
    let mut worst = 0.0f64;
    for n in 1..=3 {
        let [plain, relieved] = [0, 1].map(|i| {
            let found = at_order(&lines[i], 56.0 * n as f64)[0].norm() * base_radius(1);
            let exact = harmonic(&pitches[i].cycles[0].te, n).norm();
            worst = worst.max((found - exact).abs() / pitches[0].cycles[0].peak_to_peak());
            found
        });
        assert!(
            relieved < 0.5 * plain,
            "order {n}: {relieved:e} of {plain:e} m"
        );
    }
    within("orders against e(φ, T) of the files", worst, 5e-3);
    let [plain, relieved] = pitches.map(|p| p.cycles[0].peak_to_peak());
    assert!(relieved < 0.25 * plain, "{relieved:e} of {plain:e} m");
}

/// A motor at constant speed and a load at the far end: the mesh carries the whole load, as in steady running.
#[test]
fn law_motors_hold_against_the_loads() {
    let text = two_bodies(&named(RELIEVED), 1.0);
    let (before, after) = text.split_once("load = [").unwrap();
    let (_, after) = after.split_once("]\n").unwrap();
    let text = format!(
        "{before}load = [{{ at = \"b\", torque = 600 }}]\nmotor = [{{ name = \"m\", at = \"a\", kind = \"speed\", speed = 20.0 }}]\n{after}"
    );
    let held = prepared(&text);
    let balanced = prepared(&two_bodies(&named(RELIEVED), 1.0));
    let [a, b] = [&held, &balanced].map(|m| m.model.branches[0].stiffness);
    within(
        "stiffness at the torque that the motor holds",
        (a / b - 1.0).abs(),
        1e-9,
    );
}

/// Meshes in a loop share a load by their stiffnesses: the torques settle, and both halves carry the same.
#[test]
fn law_torques_in_a_loop() {
    let pair = |name: &str, a: &str| {
        let file = RELIEVED.strip_prefix("models/").unwrap();
        format!("{{ name = \"{name}\", between = [\"{a}\", \"w\"], gear = \"{file}\" }}")
    };
    let text = format!(
        "inertia = [{{ name = \"m\", J = 0.01 }}, {{ name = \"p\", J = 0.001 }}, {{ name = \"q\", J = 0.001 }}, {{ name = \"w\", J = 0.05 }}]\n\
         shaft = [{{ name = \"one\", between = [\"m\", \"p\"], k = 5e4 }}, {{ name = \"two\", between = [\"m\", \"q\"], k = 5e4 }}]\n\
         gear_pair = [{}, {}]\n\
         load = [{{ at = \"m\", torque = 600 }}, {{ at = \"w\", torque = 1200 }}]\n",
        pair("g", "p"),
        pair("h", "q")
    );
    let looped = prepared(&text);
    let single = prepared(&two_bodies(&named(RELIEVED), 1.0));
    for branch in looped.model.branches.iter().filter(|b| b.stiffness > 1e7) {
        let off = (branch.stiffness / single.model.branches[0].stiffness - 1.0).abs();
        within("stiffness of half the load", off, 1e-9);
    }
    assert!(
        matches!(&looped.meshes.decision, StageDecision::Runs(text) if text.contains("g by") && text.contains("h by"))
    );
}

/// Keys that the file determines are refused with both places; so are a file that is missing, and one that is wrong.
#[test]
fn refuses_what_contradicts_the_file() {
    let told = |pair: &str| match scene_of(&two_bodies(pair, 1.0)) {
        Ok(scene) => PreparedMachine::new(&scene.model)
            .err()
            .map_or(String::new(), |e| e.to_string()),
        Err(errors) => errors.to_string(),
    };
    let file = RELIEVED.strip_prefix("models/").unwrap();
    for (key, line) in [
        ("teeth = [28, 56]", 4 + 1),
        ("module = 0.003", 4),
        ("pressure_angle = 0.35", 4),
        ("helix_angle = 0.1", 4),
        ("hand = \"left\"", 4),
        ("internal = false", 4),
        ("backlash = 1e-4", 4),
        ("k = 1e8", 4),
        ("k_wave = { kind = \"fourier\", amplitudes = [0.1] }", 4),
    ] {
        let said = told(&format!("gear = \"{file}\", {key}"));
        let name = key.split(' ').next().unwrap();
        assert!(
            said.contains(&format!(
                "`{name}` is determined by the gear file {RELIEVED}, line {line}"
            )),
            "{key}: {said}"
        );
        assert!(said.starts_with("models/test.toml:"), "{said}");
    }
    let said = told("gear = \"gears/none.toml\"");
    assert!(
        said.contains("models/gears/none.toml cannot be read")
            && said.starts_with("models/test.toml:5:"),
        "{said}"
    );
    let place = folder("wrong");
    let text = std::fs::read_to_string(PLAIN)
        .unwrap()
        .replace("126 mm", "110 mm");
    std::fs::write(place.join("near.toml"), text).unwrap();
    let said = told(&format!("gear = \"{}\"", place.join("near.toml").display()));
    assert!(
        said.contains("near.toml:4:") && said.contains("110"),
        "{said}"
    );
    // Without a torque the file has the geometry alone.
    let fzg = |extra: &str| {
        let text = two_bodies(&format!("gear = \"gears/fzg_c.toml\" {extra}"), 1.0);
        let (before, after) = text.split_once("load = [").unwrap();
        let (_, after) = after.split_once("]\n").unwrap();
        format!("{before}{after}")
    };
    assert_eq!(prepared(&fzg(", k = 1e8")).model.branches[0].stiffness, 1e8);
    let said = scene_of(&fzg(", damping_ratio = 0.1"))
        .unwrap_err()
        .to_string();
    assert!(said.contains("has losses but no stiffness"), "{said}");
    let machine = prepared(&fzg(""));
    assert!(
        matches!(&machine.meshes.decision, StageDecision::LeftOut(why) if why.contains("geometry alone"))
    );
}

/// Files of random bytes, cut, doubled and altered lines: an error or a machine, never a panic.
#[test]
fn survives_random_files() {
    let place = folder("random");
    let text = std::fs::read_to_string(RELIEVED).unwrap();
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % n as u64) as usize
    };
    let words = [
        "0",
        "-1",
        "1e300",
        "\"\"",
        "nan",
        "\"20 deg\"",
        "true",
        "[1, 2]",
        "{}",
        "\"1e9 mm\"",
        "3",
        "\"-3 µm\"",
    ];
    let (mut made, mut refused) = (0, 0);
    for _ in 0..300 {
        let mut bytes: Vec<char> = text.chars().collect();
        match random(4) {
            0 => bytes.truncate(random(bytes.len())),
            1 => {
                let at = random(bytes.len());
                bytes[at] = char::from(32 + random(90) as u8);
            }
            2 => {
                let at = random(bytes.len());
                bytes.drain(at..(at + random(30)).min(bytes.len()));
            }
            _ => {
                let whole: String = bytes.iter().collect();
                let values: Vec<(usize, usize)> = whole
                    .match_indices(" = ")
                    .map(|(i, _)| {
                        let begin = i + 3;
                        let end = whole[begin..]
                            .find([',', '}', '\n'])
                            .map_or(whole.len(), |j| begin + j);
                        (begin, end)
                    })
                    .collect();
                let (begin, end) = values[random(values.len())];
                let word = words[random(words.len())];
                bytes = format!("{}{word}{}", &whole[..begin], &whole[end..])
                    .chars()
                    .collect();
            }
        }
        let path = place.join("random.toml");
        std::fs::write(&path, bytes.iter().collect::<String>()).unwrap();
        let pair = format!("gear = \"{}\"", path.display());
        match scene_of(&two_bodies(&pair, 1.0)) {
            Ok(scene) => match PreparedMachine::new(&scene.model) {
                Ok(_) => made += 1,
                Err(error) => {
                    assert!(!error.message.is_empty());
                    refused += 1;
                }
            },
            Err(errors) => {
                assert!(
                    errors.as_slice().iter().all(|e| e.span.is_some()),
                    "{errors}"
                );
                refused += 1;
            }
        }
    }
    assert!(made > 10 && refused > 100, "{made} made, {refused} refused");
}
