//! The state-space form: against openTorsion's numbers (`data/reference/geared_damped.json`), closed forms and laws.

use std::path::Path;

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::machine::{
    build::build, components::Machine, kinematics::Kinematics, linear::LinearModel,
    operating_point::OperatingPoint,
};
use geardyn::internals::modes::modal_basis::{self, ModalBasis, UndampedSolver};
use geardyn::internals::modes::state_space::StateSpace;
use geardyn::internals::modes::state_space::participation::participation;
use geardyn::internals::modes::system_matrices::{AnalysisContext, SystemMatrices};
use geardyn::internals::numeric::{Complex, Matrix};
use geardyn::internals::scene::study::InputHold;
use serde_json::Value;

/// A machine with what its equations need.
struct Ready {
    machine: Machine,
    linear: LinearModel,
    basis: ModalBasis,
    speeds: Option<Vec<f64>>,
}

impl Ready {
    fn case(&self) -> AnalysisContext<'_> {
        AnalysisContext {
            machine: &self.machine,
            model: &self.linear,
            basis: &self.basis,
            speeds: self.speeds.as_deref(),
        }
    }

    fn physical(&self, inputs: &[&str], outputs: &[&str]) -> StateSpace {
        StateSpace::physical(&self.case(), &names(inputs), &names(outputs)).unwrap()
    }

    fn modal(&self, inputs: &[&str], outputs: &[&str]) -> StateSpace {
        StateSpace::modal(&self.case(), &names(inputs), &names(outputs)).unwrap()
    }
}

fn names(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| w.to_string()).collect()
}

fn ready(model: &geardyn::internals::scene::model::Model) -> Ready {
    let machine = build(model).unwrap();
    let kinematics = Kinematics::new(&machine).unwrap();
    let operating = OperatingPoint::solve(&machine, &kinematics).unwrap();
    let linear_model = LinearModel::new(&machine, &kinematics, &operating).unwrap();
    let basis = modal_basis::solve(&linear_model, UndampedSolver::Factored).unwrap();
    Ready {
        machine,
        linear: linear_model,
        basis,
        speeds: None,
    }
}

fn shipped(name: &str) -> Ready {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models")
        .join(name);
    ready(&geardyn::internals::scene::read(&path).unwrap().model)
}

fn written(text: &str) -> Ready {
    let head = "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n";
    ready(
        &geardyn::internals::scene::read_text("test.toml", &format!("{head}{text}"))
            .unwrap()
            .model,
    )
}

fn reference() -> Value {
    serde_json::from_str(include_str!("../../data/reference/geared_damped.json")).unwrap()
}

fn table(value: &Value) -> Vec<Vec<f64>> {
    let row = |r: &Value| {
        r.as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect()
    };
    value.as_array().unwrap().iter().map(row).collect()
}

/// Largest error of any entry, relative to that entry, or to `floor` where it is smaller.
fn worst(found: &Matrix, exact: &[Vec<f64>], floor: f64) -> f64 {
    assert_eq!(
        (found.nrows(), found.ncols()),
        (exact.len(), exact[0].len())
    );
    let at =
        |i: usize, j: usize| (found[(i, j)] - exact[i][j]).abs() / exact[i][j].abs().max(floor);
    (0..exact.len())
        .flat_map(|i| (0..exact[0].len()).map(move |j| (i, j)))
        .map(|(i, j)| at(i, j))
        .fold(0.0, f64::max)
}

fn difference(
    a: &geardyn::internals::numeric::ComplexMatrix,
    b: &geardyn::internals::numeric::ComplexMatrix,
) -> f64 {
    (a - b).norm_max() / a.norm_max()
}

const I: Complex = Complex::new(0.0, 1.0);

/// State, input and sampled matrices of four discs with a rigid pair and dampers.
/// Source: openTorsion (commit 88ab7893, tests/tests.py, test_state_space, test_continuous_2_discrete); SciPy matrix exponential.
#[test]
fn ref_opentorsion_geared_damped() {
    let reference = reference();
    let found = shipped("geared_damped.toml").physical(&[], &[]);
    assert_eq!(
        found.states[..3],
        names(&["disc_1.theta", "disc_2.theta", "disc_4.theta"])
    );
    assert_eq!(found.states[3], "disc_1.theta.speed");
    assert_eq!(
        found.inputs,
        names(&["disc_1.theta", "disc_2.theta", "disc_4.theta"])
    );
    let a = worst(&found.a, &table(&reference["recomputed_A"]), 1e-300);
    let sampled = found
        .discretise(reference["time_step_s"].as_f64().unwrap(), InputHold::Zero)
        .unwrap();
    let ad = worst(&sampled.a, &table(&reference["Ad"]), 1e-300);
    let bd = worst(&sampled.b, &table(&reference["Bd"]), 1e-300);
    within("state matrix", a, 1e-9);
    within("sampled state matrix", ad, 1e-9);
    within("sampled input matrix", bd, 1e-9);
}

const OSCILLATOR: &str = "
[[inertia]]
name = \"mass\"
J = 2.0
[[shaft]]
name = \"spring\"
between = [\"ground\", \"mass\"]
k = 800.0
c = 8.0
";

/// `1 / (m s² + c s + k)`, its rates, and the force in the spring; `x = [θ, θ̇]`.
#[test]
fn exact_oscillator() {
    let found = written(OSCILLATOR).physical(
        &["mass"],
        &[
            "mass",
            "mass.speed",
            "mass.theta.acceleration",
            "spring.torque",
        ],
    );
    for s in [I * 3.0, I * 20.0, Complex::new(-1.0, 5.0)] {
        let h = found.transfer(s).unwrap();
        let exact = Complex::new(1.0, 0.0) / (s * s * 2.0 + s * 8.0 + 800.0);
        for (k, factor) in [Complex::new(1.0, 0.0), s, s * s, s * 8.0 + 800.0]
            .into_iter()
            .enumerate()
        {
            let exact = exact * factor;
            let error = (h[(k, 0)] - exact).norm() / exact.norm().max(1e-3);
            within("transfer functions", error, 1e-14);
        }
    }
}

/// A torque step held between samples reaches the static twist; ω_d and decay as in theory, at any step.
#[test]
fn exact_step_response_sampled() {
    let continuous = written(OSCILLATOR).physical(&["mass"], &["mass"]);
    let (sigma, omega) = (2.0f64, (400.0f64 - 4.0).sqrt());
    for h in [1e-3, 0.05, 0.3] {
        let found = continuous.discretise(h, InputHold::Zero).unwrap();
        let mut x = Matrix::zeros(2, 1);
        for n in 0..20 {
            let t = h * n as f64;
            let exact = (1.0
                - (-sigma * t).exp() * ((omega * t).cos() + sigma / omega * (omega * t).sin()))
                / 800.0;
            within(
                "of 1/800 rad/(N·m)",
                (x[(0, 0)] - exact).abs() * 800.0,
                8e-13,
            );
            x = &found.a * &x + &found.b;
        }
    }
}

/// A ramp of torque, which first-order hold follows exactly, and zero-order hold does not.
#[test]
fn exact_ramp_response_sampled() {
    let continuous = written(OSCILLATOR).physical(&["mass"], &["mass"]);
    let h = 0.05;
    let (sigma, omega) = (2.0f64, (400.0f64 - 4.0).sqrt());
    // y = (t − 2ζ/ω₀ + e^(−σt)(2ζ/ω₀ cos ω t + (σ·2ζ/ω₀ − 1)/ω sin ω t)) / k, with 2ζ/ω₀ = c/k.
    let lag = 8.0 / 800.0;
    let exact = |t: f64| {
        let swing = lag * (omega * t).cos() + (sigma * lag - 1.0) / omega * (omega * t).sin();
        (t - lag + (-sigma * t).exp() * swing) / 800.0
    };
    let follow = |method: InputHold| -> f64 {
        let found = continuous.discretise(h, method).unwrap();
        let mut x = Matrix::zeros(2, 1);
        (0..20).fold(0.0f64, |error, n| {
            let u = h * n as f64;
            let y = (&found.c * &x)[(0, 0)] + found.d[(0, 0)] * u;
            x = &found.a * &x + Matrix::from_fn(2, 1, |i, _| found.b[(i, 0)] * u);
            error.max((y - exact(u)).abs())
        })
    };
    within(
        "of 1/800 rad/(N·m)",
        follow(InputHold::First) * 800.0,
        8e-14,
    );
    assert!(
        follow(InputHold::Zero) > 1e-5,
        "{}",
        follow(InputHold::Zero)
    );
}

/// `H_d(z) = H(2/h (z − 1)/(z + 1))`.
#[test]
fn exact_bilinear_is_a_substitution() {
    let continuous =
        shipped("geared_damped.toml").physical(&["disc_1"], &["disc_4.speed", "shaft_a.force"]);
    let h = 0.01;
    let sampled = continuous.discretise(h, InputHold::Bilinear).unwrap();
    for angle in [0.1, 0.5, 2.0] {
        let z = Complex::new(f64::cos(angle), f64::sin(angle));
        let s = (z - 1.0) / (z + 1.0) * (2.0 / h);
        let error = difference(
            &continuous.transfer(s).unwrap(),
            &sampled.transfer(z).unwrap(),
        );
        within("transfer functions", error, 1e-12);
    }
}

/// Physical and modal states are two ways to say one thing, for every shipped model of moderate size without loss factors.
#[test]
fn law_physical_is_modal() {
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("models")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if !name.ends_with(".toml") || name == "extreme_chain.toml" {
            continue; // the extreme chain keeps no digit in physical states, which is what the modal ones are for
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("models")
            .join(&name);
        let scene = geardyn::internals::scene::read(&path).unwrap();
        let ready = ready(&scene.model);
        // An assembled K cannot hold stiffness over ten decades, which is why modes are not found from one.
        if ready.linear.n > 60 || name == "stiff_chain.toml" {
            continue;
        }
        let first = ready.machine.dof_name(ready.linear.independent_dofs[0]);
        let last = ready
            .machine
            .dof_name(*ready.linear.independent_dofs.last().unwrap());
        let speed = format!("{last}.speed");
        let (inputs, outputs) = (names(&[&first, &last]), names(&[&first, &last, &speed]));
        let Ok(physical) = StateSpace::physical(&ready.case(), &inputs, &outputs) else {
            assert!(
                SystemMatrices::physical(&ready.case()).hysteretic.is_some(),
                "{name}"
            );
            continue;
        };
        let modal = StateSpace::modal(&ready.case(), &inputs, &outputs).unwrap();
        let highest = ready.basis.omega.last().unwrap();
        let lowest = ready.basis.omega[ready.basis.n_rigid];
        for s in [lowest * 0.3, lowest * 1.3, highest * 0.7].map(|w| Complex::new(0.02 * w, w)) {
            let error = difference(&physical.transfer(s).unwrap(), &modal.transfer(s).unwrap());
            println!("{name} {error:.1e}");
            assert!(error < 1e-8, "{name} {s}: {error}");
        }
    }
}

/// Gyroscopic terms at speed: physical and modal states agree, differ from rest, and `H_ab = H_ba` holds no longer.
#[test]
fn law_gyroscopic_terms_at_speed() {
    let mut rotor = shipped("overhung_rotor.toml");
    let spun = rotor
        .machine
        .gyroscopic
        .iter()
        .find(|s| !s.gyroscopic.is_empty())
        .unwrap()
        .clone();
    let (a, b, _) = spun.gyroscopic[0];
    let (a, b) = (rotor.machine.dof_name(a), rotor.machine.dof_name(b));
    let ports = [a.as_str(), b.as_str()];
    let s = Complex::new(0.0, 0.8 * rotor.basis.omega[rotor.basis.n_rigid + 1]);
    let at_rest = rotor.physical(&ports, &ports).transfer(s).unwrap();
    rotor.speeds = Some(vec![500.0; rotor.machine.dofs.len()]);
    let physical = rotor.physical(&ports, &ports).transfer(s).unwrap();
    let modal = rotor.modal(&ports, &ports).transfer(s).unwrap();
    assert!(difference(&physical, &modal) < 1e-10 && difference(&physical, &at_rest) > 1e-4);
    assert!((physical[(0, 1)] + physical[(1, 0)]).norm() < 1e-9 * physical.norm_max());
}

/// A freedom behind a rigid gear is driven and measured through the ratio.
#[test]
fn exact_eliminated_freedoms() {
    let ready = shipped("geared_damped.toml");
    let found = ready.physical(&["disc_2", "disc_3"], &["disc_2.speed", "disc_3.speed"]);
    let b = &found.b;
    for i in 0..b.nrows() {
        assert!(
            (b[(i, 1)] + b[(i, 0)] / 6.0).abs() <= 1e-15 * b[(i, 0)].abs(),
            "{i}"
        );
        assert!(
            (found.c[(1, i)] + found.c[(0, i)] / 6.0).abs() <= 1e-15,
            "{i}"
        );
    }
}

/// mass – k₁ – joint – k₂ – ground, the joint without inertia: springs in series, and its own twist follows at once.
#[test]
fn exact_massless_joint_follows() {
    let ready = written(
        "
[[inertia]]
name = \"mass\"
J = 1.0
[[inertia]]
name = \"joint\"
J = 0.0
[[shaft]]
name = \"one\"
between = [\"mass\", \"joint\"]
k = 300.0
[[shaft]]
name = \"two\"
between = [\"joint\", \"ground\"]
k = 100.0
",
    );
    let found = ready.physical(&["mass", "joint"], &["joint", "two.force"]);
    assert_eq!(found.states, names(&["mass.theta", "mass.theta.speed"]));
    assert!((found.a[(1, 0)] + 75.0).abs() < 1e-12);
    assert!(
        (found.b[(1, 1)] - 0.75).abs() < 1e-15 && (found.d[(0, 1)] - 1.0 / 400.0).abs() < 1e-18
    );
    // `two` is from joint to ground: positive when ground is ahead.
    assert!((found.d[(1, 1)] + 0.25).abs() < 1e-15 && (found.c[(1, 0)] + 75.0).abs() < 1e-12);
    let refused = StateSpace::physical(&ready.case(), &names(&["joint"]), &names(&["joint.speed"]))
        .unwrap_err();
    assert_eq!(refused.code, Code::Conflict);
    assert!(ready.physical(&["mass"], &["joint.speed"]).d[(0, 0)] == 0.0);
}

/// mass – k – joint – damper – ground: the joint creeps, `c ẏ = k (θ − y)`, a state of first order.
#[test]
fn exact_massless_joint_creeps() {
    let ready = written(
        "
[[inertia]]
name = \"mass\"
J = 1.0
[[inertia]]
name = \"joint\"
J = 0.0
[[shaft]]
name = \"one\"
between = [\"mass\", \"joint\"]
k = 300.0
[[shaft]]
name = \"two\"
between = [\"mass\", \"ground\"]
k = 100.0
[[damper]]
name = \"pot\"
at = \"joint\"
c = 20.0
",
    );
    for found in [
        ready.physical(&["mass", "joint"], &["mass", "joint"]),
        ready.modal(&["mass", "joint"], &["mass", "joint"]),
    ] {
        assert_eq!(found.a.nrows(), 3);
        for s in [I * 2.0, I * 30.0] {
            let (k, c) = (Complex::new(300.0, 0.0), s * 20.0);
            let series = k * c / (k + c);
            let exact = Complex::new(1.0, 0.0) / (s * s + series + 100.0);
            let h = found.transfer(s).unwrap();
            assert!((h[(0, 0)] - exact).norm() < 1e-14, "{s}");
            assert!((h[(1, 0)] - exact * k / (k + c)).norm() < 1e-14, "{s}");
            assert!((h[(0, 1)] - h[(1, 0)]).norm() < 1e-15, "{s}");
        }
    }
    assert_eq!(ready.physical(&[], &[]).states[2], "joint.theta");
}

/// Two massless joints with a damper between them and springs outside: only their difference creeps.
#[test]
fn exact_relative_creep() {
    let ready = written(
        "
[[inertia]]
name = \"mass\"
J = 1.0
[[inertia]]
name = \"a\"
J = 0.0
[[inertia]]
name = \"b\"
J = 0.0
[[shaft]]
name = \"one\"
between = [\"mass\", \"a\"]
k = 300.0
[[shaft]]
name = \"two\"
between = [\"b\", \"ground\"]
k = 100.0
[[damper]]
name = \"pot\"
between = [\"a\", \"b\"]
c = 20.0
",
    );
    let found = ready.physical(&["mass"], &["mass", "a", "b"]);
    assert_eq!(found.states[2], "a.theta - b.theta");
    for s in [I * 2.0, I * 30.0] {
        let c = s * 20.0;
        let series = Complex::new(1.0, 0.0)
            / (Complex::new(1.0 / 300.0 + 0.01, 0.0) + Complex::new(1.0, 0.0) / c);
        let exact = Complex::new(1.0, 0.0) / (s * s + series);
        let h = found.transfer(s).unwrap();
        assert!((h[(0, 0)] - exact).norm() < 1e-13 * exact.norm(), "{s}");
        assert!(
            (h[(2, 0)] - exact * series / 100.0).norm() < 1e-13 * exact.norm(),
            "{s}"
        );
    }
}

/// Three equal discs held at both ends: the middle one stands still in the second mode.
#[test]
fn exact_unreachable_mode() {
    let ready = written(
        "
[[chain]]
name = \"row\"
count = 3
J = 1.0
k = 100.0
held = \"both\"
",
    );
    let found = participation(
        &ready.case(),
        &names(&["row.2"]),
        &names(&["row.1", "row.2.acceleration"]),
    )
    .unwrap();
    let reach: Vec<f64> = found.iter().map(|m| m.controllability[0]).collect();
    // Shapes (1, √2, 1)/2, (1, 0, −1)/√2, (1, −√2, 1)/2.
    assert!(
        (reach[0] - 0.5f64.sqrt()).abs() < 1e-13
            && reach[1] < 1e-13
            && (reach[2] - 0.5f64.sqrt()).abs() < 1e-13,
        "{reach:?}"
    );
    assert_eq!(
        found.iter().map(|m| m.controllable).collect::<Vec<_>>(),
        [true, false, true]
    );
    assert!(found.iter().all(|m| m.observable && m.multiplicity == 1));
    assert!(
        (found[1].observability[0] - 0.5f64.sqrt()).abs() < 1e-13
            && found[1].observability[1] < 1e-13
    );
}

/// Without damping the squares over all modes sum to one: the energy of a blow is shared out. Rigid motions count too.
#[test]
fn law_participation_sums_to_one() {
    for model in [
        "five_disc_chain.toml",
        "ieee_first_benchmark.toml",
        "lin_parker_n3.toml",
    ] {
        let ready = shipped(model);
        let first = ready.machine.dof_name(ready.linear.independent_dofs[0]);
        let found = participation(
            &ready.case(),
            std::slice::from_ref(&first),
            std::slice::from_ref(&first),
        )
        .unwrap();
        if found
            .iter()
            .any(|m| m.eigenvalue.re != 0.0 && m.eigenvalue.re.abs() > 1e-9 * m.eigenvalue.im.abs())
        {
            continue; // damped
        }
        let sum = |of: fn(
            &geardyn::internals::modes::state_space::participation::ModalParticipation,
        ) -> f64| { found.iter().map(|m| of(m).powi(2)).sum::<f64>() };
        let (reach, show) = (sum(|m| m.controllability[0]), sum(|m| m.observability[0]));
        println!("{model}: {reach} {show}");
        assert!(
            (reach - 1.0).abs() < 1e-9 && (show - 1.0).abs() < 1e-9,
            "{model}: {reach} {show}"
        );
    }
}

/// One input cannot reach both of two modes at one frequency, wherever it acts; two inputs can.
#[test]
fn exact_double_mode_needs_two_inputs() {
    let ready = written(
        "
[[inertia]]
name = \"left\"
J = 1.0
[[inertia]]
name = \"right\"
J = 1.0
[[shaft]]
name = \"one\"
between = [\"ground\", \"left\"]
k = 100.0
[[shaft]]
name = \"two\"
between = [\"ground\", \"right\"]
k = 100.0
",
    );
    let reach = |inputs: &[&str]| {
        let found = participation(&ready.case(), &names(inputs), &names(&["left"])).unwrap();
        found
            .iter()
            .map(|m| (m.multiplicity, m.controllable))
            .collect::<Vec<_>>()
    };
    assert_eq!(reach(&["left"]), [(2, false), (2, false)]);
    assert_eq!(reach(&["left", "right"]), [(2, true), (2, true)]);
}

#[test]
fn refuses_loss_factors() {
    let ready = written(&OSCILLATOR.replace("c = 8.0", "loss_factor = 0.02"));
    let error = StateSpace::physical(&ready.case(), &[], &[]).unwrap_err();
    assert_eq!(error.code, Code::Conflict);
    assert!(error.hint.unwrap().contains("damping_ratio"));
}

#[test]
fn refuses_wrong_names() {
    let ready = shipped("geared_damped.toml");
    let context = ready.case();
    let refused = |input: &str, output: &str| {
        StateSpace::physical(&context, &names(&[input]), &names(&[output])).unwrap_err()
    };
    let wrong = refused("disk_1", "disc_1");
    assert_eq!(wrong.code, Code::UnknownNode);
    assert!(wrong.hint.unwrap().contains("`disc_1`"));
    let wrong = refused("disc_1.x", "disc_1");
    assert_eq!(wrong.code, Code::UnknownDof);
    assert!(wrong.hint.unwrap().contains("disc_1.theta"));
    let wrong = refused("disc_1", "disc_1.sped");
    assert!(wrong.hint.unwrap().contains("disc_1.theta.speed"));
    assert_eq!(refused("disc_1.speed", "disc_1").code, Code::Conflict);
    let wrong = refused("disc_1", "shaft_c.force");
    assert!(wrong.hint.unwrap().contains("shaft_"));
    assert_eq!(refused("disc_1", "pair.force").code, Code::Conflict);
    let sampled = ready
        .physical(&[], &[])
        .discretise(0.0, InputHold::Zero)
        .unwrap_err();
    assert_eq!(sampled.code, Code::OutOfRange);
}

/// The matrices as JSON and CSV come back.
#[test]
fn exact_json_and_csv() {
    let found = written(OSCILLATOR)
        .physical(&["mass"], &["mass.speed"])
        .discretise(0.01, InputHold::Bilinear)
        .unwrap();
    let json = found.to_json();
    assert_eq!(json["a"][1][0].as_f64().unwrap(), found.a[(1, 0)]);
    assert_eq!(
        (json["sample_time_s"].as_f64(), json["hold"].as_str()),
        (Some(0.01), Some("bilinear"))
    );
    let mut csv = Vec::new();
    found.write_csv(&mut csv).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let row = csv
        .lines()
        .find(|l| l.starts_with("mass.theta.speed,") && l.matches(',').count() == 2)
        .unwrap();
    let back: f64 = row.rsplit(',').next().unwrap().parse().unwrap();
    assert_eq!(back, found.a[(1, 1)]);
    assert!(
        csv.starts_with("sample_time_s,0.01\nhold,bilinear\n\na,mass.theta,mass.theta.speed\n"),
        "{csv}"
    );
}

/// Header, tags and padding of a MATLAB file, byte by byte.
#[test]
fn exact_mat_bytes() {
    let found = written(OSCILLATOR).physical(&["mass"], &["mass"]);
    let mut bytes = Vec::new();
    found.write_mat(&mut bytes).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert!(bytes.starts_with(b"MATLAB 5.0 MAT-file") && &bytes[124..128] == b"\x00\x01IM");
    // A: matrix tag, flags (double), dimensions 2×2, name, numbers by column.
    assert_eq!([word(128), word(136), word(140), word(144)], [14, 6, 8, 6]);
    assert_eq!([word(152), word(156), word(160), word(164)], [5, 8, 2, 2]);
    assert_eq!([word(168), word(172)], [1, 1]);
    assert_eq!(bytes[176], b'A');
    assert_eq!([word(184), word(188)], [9, 32]);
    let second = f64::from_le_bytes(bytes[200..208].try_into().unwrap());
    assert_eq!(second, found.a[(1, 0)]);
    // Every element ends where the next begins.
    let mut at = 128;
    let mut count = 0;
    while at < bytes.len() {
        assert_eq!(word(at), 14);
        at += 8 + word(at + 4) as usize;
        count += 1;
    }
    assert_eq!((at, count), (bytes.len(), 9));
}

/// Equal but for the last digit, which serde_json's reader of numbers does not promise.
fn alike(a: &Value, b: &Value) -> bool {
    match (a.as_array(), b.as_array(), a.as_f64(), b.as_f64()) {
        (Some(x), Some(y), _, _) => x.len() == y.len() && x.iter().zip(y).all(|(x, y)| alike(x, y)),
        (_, _, Some(x), Some(y)) => (x - y).abs() <= 4.0 * f64::EPSILON * y.abs(),
        _ => a == b,
    }
}

/// scipy reads the file back; without python3 and scipy there is nothing to ask, and the bytes are tested above.
/// Source: SciPy, loadmat.
#[test]
fn ref_scipy_reads_mat() {
    let found = shipped("geared_damped.toml")
        .physical(&[], &["disc_1.speed", "shaft_b.force"])
        .discretise(1e-4, InputHold::First)
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("space.mat");
    found
        .write_mat(&mut std::fs::File::create(&path).unwrap())
        .unwrap();
    let script = "
import sys, json
try:
    import scipy.io
except ImportError:
    sys.exit(77)
m = scipy.io.loadmat(sys.argv[1])
cells = lambda v: [str(c[0][0]) for c in v]
out = {k: m[k].tolist() for k in 'ABCD'}
out.update(Ts=float(m['Ts'][0, 0]), hold=str(m['hold'][0]), **{k: cells(m[k]) for k in ('states', 'inputs', 'outputs')})
print(json.dumps(out))";
    let Ok(ran) = std::process::Command::new("python3")
        .args(["-c", script])
        .arg(&path)
        .output()
    else {
        return;
    };
    if ran.status.code() == Some(77) {
        return;
    }
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let read: Value = serde_json::from_slice(&ran.stdout).unwrap();
    let own = found.to_json();
    for (theirs, ours) in [
        ("A", "a"),
        ("B", "b"),
        ("C", "c"),
        ("D", "d"),
        ("states", "states"),
        ("inputs", "inputs"),
        ("outputs", "outputs"),
    ] {
        assert!(
            alike(&read[theirs], &own[ours]),
            "{theirs}: {} {}",
            read[theirs],
            own[ours]
        );
    }
    assert_eq!(
        (read["Ts"].as_f64(), read["hold"].as_str()),
        (Some(1e-4), Some("first-order"))
    );
}
