//! Machines of hundreds and thousands of freedoms: closed forms of uniform chains, sparse against dense, refusals with an estimate.

use std::cell::Cell;
use std::f64::consts::PI;

use crate::support::command::said;
use crate::support::verification::within;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::modes::modal_basis::ModalBasis;
use geardyn::internals::modes::system_matrices::{AnalysisContext, SystemMatrices};
use geardyn::internals::numeric::{Complex, ComplexMatrix, symmetric};
use geardyn::internals::plan::motion::method_choice::choose_method;
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::simulate::SimulationResult;
use geardyn::internals::response::frf::{FrfMatrix, ResponseMethod, SolverKind, frf_matrix};
use geardyn::internals::response::ports::Ports;
use geardyn::internals::scene::study::SimulateStudy;
use geardyn::internals::scene::{self, Scene};
use geardyn::internals::study::stability::perturbations::{MAX_WORK, work_limit};

const INERTIA: f64 = 1.0;
const STIFFNESS: f64 = 1e6;
const DAMPING: f64 = 30.0;

fn chain(count: usize, held: &str, damping: f64) -> String {
    format!(
        "title = \"chain\"\nsource = \"made for a test\"\nunits = \"SI\"\n[[chain]]\nname = \"disc\"\ncount = {count}\nJ = {INERTIA}\nk = {STIFFNESS}\nheld = \"{held}\"\nc = {damping}\n"
    )
}

/// A step of 1 N·m at the last disc.
fn struck(count: usize, damping: f64) -> String {
    let load = format!(
        "[[load]]\nat = \"disc.{count}\"\nkind = \"step\"\ntorque = 1.0\ntime = {STRUCK}\n"
    );
    chain(count, "start", damping) + &load
}

/// s.
const STRUCK: f64 = 1e-3;

fn read(text: &str) -> Scene {
    scene::read_text("chain.toml", text).unwrap()
}

fn prepared(text: &str) -> PreparedMachine {
    PreparedMachine::new(&read(text).model).unwrap()
}

fn answer(machine: &PreparedMachine, input: &str, output: &str, omega: &[f64]) -> FrfMatrix {
    let names = |word: &str| [word.to_string()];
    let ports = Ports::parse(&machine.machine, &names(input), &names(output), &[]).unwrap();
    frf_matrix(
        &machine.operating_model(None),
        &ports,
        omega,
        ResponseMethod::Direct,
    )
    .unwrap()
}

/// z of a shaft and e^μ of the chain: `z = k + s c`, `2 cosh μ = 2 + s² J / z`, Re μ ≥ 0.
fn travelling(omega: f64) -> (Complex, Complex) {
    let s = Complex::new(0.0, omega);
    let z = s * DAMPING + STIFFNESS;
    let half = s * s * INERTIA / z * 0.5 + 1.0;
    let root = (half * half - 1.0).sqrt();
    let (one, other) = (half + root, half - root);
    let larger = if one.norm() > other.norm() {
        one
    } else {
        other
    };
    (z, larger)
}

fn power(x: Complex, n: usize) -> Complex {
    (0..n).fold(Complex::new(1.0, 0.0), |product, _| product * x)
}

fn assert_close(found: Complex, exact: Complex, relative: f64, what: &str) {
    let off = (found - exact).norm() / exact.norm();
    within(what, off, relative);
}

const LINES: [f64; 5] = [3.0, 47.0, 400.0, 1300.0, 2600.0];

/// Three thousand discs held at one end and driven at the other: `θ_i ∝ sinh iμ`, so
/// `θ_N / T = sinh Nμ / (z (sinh (N + 1)μ − sinh Nμ))`.
#[test]
fn exact_response_of_a_long_chain() {
    const N: usize = 3000;
    let own = prepared(&chain(N, "start", DAMPING));
    let found = answer(&own, "disc.3000.theta", "disc.3000.theta", &LINES);
    assert_eq!(found.solver, SolverKind::Sparse);
    for (k, &omega) in LINES.iter().enumerate() {
        let (z, step) = travelling(omega);
        let back = power(step.inv(), N);
        let two = back * back;
        let exact = (Complex::new(1.0, 0.0) - two) / (z * (step - two * step.inv() - 1.0 + two));
        assert_close(found.values[k][(0, 0)], exact, 1e-10, "held");
    }
}

/// The same chain free at both ends, whose turning as a whole is a coordinate that meets every other: `θ_i ∝ cosh (i − ½)μ`. At rest it
/// winds up by `T (N − 1) / 2k`, as the torque falls evenly along it.
#[test]
fn exact_response_of_a_long_free_chain() {
    const N: usize = 2000;
    let own = prepared(&chain(N, "none", DAMPING));
    let found = answer(&own, "disc.2000.theta", "disc.2000.theta", &LINES);
    assert_eq!(found.solver, SolverKind::Sparse);
    for (k, &omega) in LINES.iter().enumerate() {
        let (z, step) = travelling(omega);
        let back = power(step.inv(), 2 * N - 1);
        let exact = (back + 1.0) / (z * (step - 1.0 + back * (step.inv() - 1.0)));
        assert_close(found.values[k][(0, 0)], exact, 1e-9, "free");
    }
    let wound = answer(
        &own,
        "disc.2000.theta",
        "disc.2000.theta - disc.1.theta",
        &[0.0],
    );
    let exact = Complex::new((N - 1) as f64 / (2.0 * STIFFNESS), 0.0);
    assert_close(wound.values[0][(0, 0)], exact, 1e-10, "wound up");
}

/// Two chains joined by five elastic pairs of gears, in loops, with dampers, loss factors and Rayleigh damping: the sparse solution is
/// that of the dense matrices of the modes' equations.
#[test]
fn law_sparse_is_dense() {
    let mut text = chain(40, "start", DAMPING).replace("c = 30\n", "loss_factor = 0.02\n");
    text += "[[chain]]\nname = \"other\"\ncount = 40\nJ = 0.3\nk = 4e5\nheld = \"end\"\ndamping_ratio = 0.02\n";
    text += "[damping]\nrayleigh_mass = 1.5\nrayleigh_stiffness = 1e-5\n";
    for i in 1..=5 {
        let at = 8 * i - 3;
        text += &format!(
            "[[gear_pair]]\nname = \"pair_{i}\"\nbetween = [\"disc.{at}\", \"other.{at}\"]\nteeth = [{}, 40]\nmodule = 0.003\npressure_angle = \"20 deg\"\nk = 3e8\ndamping_ratio = 0.03\n",
            19 + i
        );
    }
    let own = prepared(&text);
    let found = answer(&own, "disc.3.theta", "other.27.theta", &LINES);
    assert_eq!(found.solver, SolverKind::Sparse);
    let none = ModalBasis::empty(own.model.n);
    let matrices = SystemMatrices::physical(&AnalysisContext {
        machine: &own.machine,
        model: &own.model,
        basis: &none,
        speeds: None,
    });
    let seen = |name: &str| {
        let dof = own.machine.dof(name).unwrap();
        matrices.project(&own.model.transform[dof])
    };
    let (load, read) = (seen("disc.3.theta"), seen("other.27.theta"));
    let load = ComplexMatrix::from_fn(load.len(), 1, |i, _| Complex::new(load[i], 0.0));
    for (k, &omega) in LINES.iter().enumerate() {
        let full = matrices.dynamic_stiffness(Complex::new(0.0, omega));
        let x = symmetric::lu_solve_complex(&full, &load).unwrap();
        let terms = read.iter().enumerate().map(|(i, c)| x[(i, 0)] * *c);
        let exact = terms.fold(Complex::new(0.0, 0.0), |sum, term| sum + term);
        assert_close(found.values[k][(0, 0)], exact, 1e-10, "in loops");
    }
}

fn until(end: f64, output: &str) -> SimulateStudy {
    SimulateStudy {
        end_time: Some(end),
        outputs: vec![output.to_string()],
        samples: Some(20),
        ..SimulateStudy::default()
    }
}

/// A step of torque at the free end of 1000 undamped discs goes by steps, as all modes would take longer; the end follows
/// `Σ φ² (1 − cos ω t) / ω²`, `ω = 2 √(k/J) sin((2m − 1)π / (4N + 2))`, `φ = 2/√((2N + 1) J) sin((2m − 1) N π / (2N + 1))`. Whoever
/// watches hears how far it is, up to the end.
#[test]
fn exact_motion_of_a_long_chain() {
    const N: usize = 1000;
    let scene = read(&struck(N, 0.0));
    let (last, told) = (Cell::new(0.0), Cell::new(0));
    let hear = |share: f64| {
        assert!(share >= last.get());
        last.set(share);
        told.set(told.get() + 1);
    };
    let study = until(0.05, "disc.1000.theta");
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let result =
        SimulationResult::simulate(&scene, &machine, &study, &CancelToken::default(), &hear)
            .unwrap();
    assert_eq!(result.choice.method.name, "dop853-events");
    assert!(
        result
            .choice
            .reason
            .contains("all modes of 1000 coordinates")
    );
    assert_eq!((last.get(), told.get()), (1.0, 21));
    let all = (2 * N + 1) as f64;
    let exact = |t: f64| -> f64 {
        let mode = |m: usize| {
            let odd = (2 * m - 1) as f64;
            let omega = 2.0 * (STIFFNESS / INERTIA).sqrt() * (odd * PI / (2.0 * all)).sin();
            let shape = 2.0 / (all * INERTIA).sqrt() * (odd * N as f64 * PI / all).sin();
            let half = (0.5 * omega * t).sin();
            2.0 * (shape * half / omega).powi(2)
        };
        (1..=N).map(mode).sum()
    };
    let largest = exact(0.05 - STRUCK);
    for (t, value) in result.history.time.iter().zip(&result.history.values[0]) {
        let exact = exact((t - STRUCK).max(0.0));
        within(
            "angle of the end, of the largest",
            (value - exact).abs() / largest,
            1e-9,
        );
    }
}

/// For a second.
fn ready(text: &str) -> SimulationSetup {
    let study = until(1.0, "disc.1.theta");
    SimulationSetup::new(&prepared(text), &read(text).start, &study).unwrap()
}

/// Few discs go by all modes; many too where a stiff shaft would hold steps short.
#[test]
fn case_steps_only_where_they_are_quicker() {
    let method = |text: &str| {
        let model = ready(text).model.model;
        let study = until(1.0, "disc.1.theta");
        choose_method(&model, &study).unwrap().method.name
    };
    assert_eq!(method(&struck(100, 30.0)), "exact");
    assert_eq!(method(&struck(2000, 30.0)), "dop853-events");
    let stiff = struck(2000, 30.0).replace("k = 1000000", "k = 1e18");
    assert_eq!(method(&stiff), "exact");
}

/// A case of stability of a hundred times as many freedoms may be a hundredth of the evaluations, each of which costs as many times more.
#[test]
fn law_budget_goes_by_size() {
    let of = |count: usize| work_limit(&ready(&struck(count, 30.0)));
    assert_eq!(
        (of(2), of(20), of(2000)),
        (MAX_WORK, MAX_WORK, MAX_WORK / 100)
    );
}

/// What full matrices of thousands of coordinates would take is known before the work.
#[test]
fn refused_before_full_matrices() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let large = file("large.toml", &struck(20_000, 30.0));
    let modal = struck(3000, 0.0) + "[damping]\nmodal = [0.01]\n";
    let modal = file("modal.toml", &modal);
    let middle = file("middle.toml", &struck(1500, 30.0));
    let band = ["--band", "1:100"];
    let port = |n: usize| format!("disc.{n}.theta");
    let cases: &[(&[&str], &[&str])] = &[
        (
            &["simulate", &large, "--until", "1", "--method", "exact"],
            &[
                "all modes of 20000 coordinates",
                "GB",
                "(limit ",
                "dop853-events",
            ],
        ),
        (
            &["simulate", &large, "--until", "1", "--method", "radau5"],
            &["factors of 20000 coordinates", "GB", "dop853-events"],
        ),
        (
            &[
                "response",
                &large,
                "--input",
                &port(1),
                "--output",
                &port(1),
                band[0],
                band[1],
                "--method",
                "modal",
            ],
            &[
                "all modes of 20000 coordinates",
                "GB",
                "omit --method modal",
            ],
        ),
        (
            &[
                "response",
                &modal,
                "--input",
                &port(1),
                "--output",
                &port(1),
                band[0],
                band[1],
            ],
            &["modal damping", "of 3000 coordinates", "damping_ratio"],
        ),
        (
            &["stability", &middle, "--until", "1"],
            &[
                "complex modes of 1500 degrees of freedom",
                "about",
                "(limit",
            ],
        ),
        (
            &["modes", &middle, "--damped"],
            &["complex modes of 1500 degrees of freedom", "omit --damped"],
        ),
    ];
    for (arguments, words) in cases {
        let (code, _, said) = said(arguments);
        assert_eq!(code, Some(3), "{arguments:?}: {said}");
        for word in *words {
            assert!(said.contains(word), "{word}: {said}");
        }
    }
}
