//! The methods that step: their orders as measured, published and closed-form motions, switches, refusals.

use crate::support::verification;
use std::f64::consts::PI;
use std::ops::ControlFlow;

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Error;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::machine::characteristic::Characteristic;
use geardyn::internals::machine::direction::Direction;
use geardyn::internals::motion::contact::{ActiveFlanks, ContactDamping, ContactLaw};
use geardyn::internals::motion::dynamic_model::{
    AppliedForce, DynamicModel, ForceElement, ForceLaw, MassMatrix,
};
use geardyn::internals::motion::friction::FrictionLaw;
use geardyn::internals::motion::methods::alpha::{self, weights::GeneralizedAlpha};
use geardyn::internals::motion::methods::explicit_runge_kutta::{self, ExplicitMethod};
use geardyn::internals::motion::methods::{METHODS, StepControl, method_by_name, with_events};
use geardyn::internals::motion::problem::{
    IntegrateFn, IntegrationOptions, IntegrationStats, Observer, OdeProblem, StepSize,
};
use geardyn::internals::motion::signal::{Harmonic, Knot, Signal};
use geardyn::internals::motion::wave::{PeriodicFunction, WavePhase, Waveform};
use geardyn::internals::numeric::{Matrix, symmetric};
use serde_json::Value;

/// Samples of a run: time and state.
type Samples = Vec<(f64, Vec<f64>)>;

fn gather<P>(
    run: IntegrateFn<P>,
    problem: &P,
    options: &IntegrationOptions,
) -> Result<(Samples, IntegrationStats), Error> {
    let mut samples = Vec::new();
    let stats = run(problem, options, &mut |t, y, _| {
        samples.push((t, y.to_vec()));
        ControlFlow::Continue(())
    })?;
    assert_eq!(samples.len(), options.samples + 1, "every sample once");
    for (at, (t, _)) in samples.iter().enumerate() {
        assert_eq!(*t, options.time(at), "in order");
    }
    Ok((samples, stats))
}

fn run(
    name: &str,
    model: &DynamicModel,
    options: &IntegrationOptions,
) -> (Samples, IntegrationStats) {
    gather(method_by_name(name).unwrap().run, model, options)
        .unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn ask(to: f64, start: &[f64], samples: usize, effort: StepSize) -> IntegrationOptions {
    IntegrationOptions {
        from: 0.0,
        to,
        initial_state: start.to_vec(),
        samples,
        step_size: effort,
        max_work: 5_000_000,
        cancel: CancelToken::default(),
        observer: Observer::default(),
    }
}

fn train(mass: &[f64], branches: Vec<ForceElement>, drives: Vec<AppliedForce>) -> DynamicModel {
    DynamicModel {
        coordinates: (0..mass.len()).map(|i| format!("n{i}.theta")).collect(),
        mass: MassMatrix::Diagonal(mass.to_vec()),
        elements: branches,
        forces: drives,
        mass_damping: 0.0,
        global_matrices: None,
    }
}

fn branch(name: &str, direction: Direction, law: ForceLaw) -> ForceElement {
    ForceElement {
        name: name.to_string(),
        direction,
        force_direction: None,
        law,
        stiffness_wave: None,
        imposed_displacement: None,
        angle_waves: Vec::new(),
    }
}

fn spring(i: usize, j: usize, stiffness: f64, damping: f64) -> ForceElement {
    let direction = Direction::new(1.0, [(i, -1.0), (j, 1.0)]);
    branch(
        &format!("shaft {i}"),
        direction,
        ForceLaw::Linear { stiffness, damping },
    )
}

fn ground(i: usize, stiffness: f64, damping: f64) -> ForceElement {
    branch(
        "ground",
        Direction::unit(i),
        ForceLaw::Linear { stiffness, damping },
    )
}

fn drive(i: usize, signal: Signal) -> AppliedForce {
    AppliedForce {
        name: "drive".to_string(),
        direction: Direction::unit(i),
        signal,
    }
}

fn play(stiffness: f64, damping: f64, half: f64, contact_damping: ContactDamping) -> ForceLaw {
    ForceLaw::Contact(ContactLaw {
        stiffness,
        damping,
        half_play: half,
        contact_damping,
        flanks: ActiveFlanks::Both,
    })
}

fn reference(name: &str) -> Value {
    let path = format!("{}/data/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    let row = |r: &Value| {
        r.as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect()
    };
    value.as_array().unwrap().iter().map(row).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

/// `q̈ + q³ = (cos 3t − cos t)/4` with q = cos t.
fn cubic() -> DynamicModel {
    let law = ForceLaw::Nonlinear {
        characteristic: Characteristic::Power {
            factor: 1.0,
            exponent: 3.0,
            rated: 1.0,
        },
        damping: 0.0,
    };
    let part = |amplitude, omega| Harmonic {
        amplitude,
        omega,
        phase: 0.0,
    };
    let signal = Signal {
        knots: Vec::new(),
        harmonics: vec![part(-0.25, 1.0), part(0.25, 3.0)],
        ..Signal::default()
    };
    train(
        &[1.0],
        vec![branch("hard", Direction::unit(0), law)],
        vec![drive(0, signal)],
    )
}

/// The largest error against cos t of the samples, without or with the end alone.
fn cubic_error(name: &str, step: f64, samples: usize) -> f64 {
    let (samples, _) = run(
        name,
        &cubic(),
        &ask(4.0, &[1.0, 0.0], samples, StepSize::Fixed(step)),
    );
    let error = |(t, y): &(f64, Vec<f64>)| (y[0] - t.cos()).abs().max((y[1] + t.sin()).abs());
    samples.iter().map(error).fold(0.0, f64::max)
}

/// Errors fall with the step as theory says, at the end and at samples between the steps.
#[test]
fn law_orders_are_those_of_theory() {
    for (name, coarse, parts, end_order, inner_order) in [
        ("rk4", 0.05, 37, 4.0, 4.0),
        ("dopri5", 0.05, 37, 5.0, 5.0),
        ("dop853", 0.25, 37, 8.0, 8.0),
        ("dop853-events", 0.25, 37, 8.0, 8.0),
        ("radau5", 0.1, 37, 5.0, 4.0),
        ("exponential", 0.05, 37, 4.0, 4.0),
        ("newmark", 0.02, 37, 2.0, 2.0),
        ("hht", 0.02, 37, 2.0, 2.0),
        ("generalized-alpha", 0.02, 37, 2.0, 2.0),
    ] {
        let order = |samples: usize| {
            let (a, b) = (
                cubic_error(name, coarse, samples),
                cubic_error(name, 0.5 * coarse, samples),
            );
            (a, b, (a / b).log2())
        };
        let (end, inner) = (order(1), order(parts));
        eprintln!(
            "{name}: order {:.2} at the end ({:.1e}, {:.1e}), {:.2} inside",
            end.2, end.0, end.1, inner.2
        );
        assert!(
            (end.2 - end_order).abs() < 0.2,
            "{name} at the end: {end:?}"
        );
        assert!(
            (inner.2 - inner_order).abs() < 0.2,
            "{name} inside: {inner:?}"
        );
        verification::order(&format!("{name}, at the end of steps"), end_order, end.2);
        verification::order(&format!("{name}, between them"), inner_order, inner.2);
    }
}

/// A step is the one asked for however many samples are read off between, and nothing of the motion goes by them.
#[test]
fn law_fixed_steps_do_not_go_by_samples() {
    for method in METHODS
        .iter()
        .filter(|m| m.step_control == StepControl::Fixed)
    {
        let motion = |step: f64, samples: usize| {
            let options = ask(1.0, &[1.0, 0.0], samples, StepSize::Fixed(step));
            let (samples, stats) = run(method.name, &cubic(), &options);
            (samples.last().unwrap().1.clone(), stats.steps)
        };
        for (step, steps) in [(0.05, 20), (0.3, 4)] {
            let [rare, dense] = [3, 1000].map(|samples| motion(step, samples));
            assert_eq!((rare.1, dense.1), (steps, steps), "{}", method.name);
            for (a, b) in rare.0.iter().zip(&dense.0) {
                assert!((a - b).abs() < 1e-14, "{}: {a} {b}", method.name);
            }
        }
    }
}

/// Samples at the ends of steps cost no evaluation of their own.
#[test]
fn law_samples_at_steps_are_free() {
    let options = ask(0.01, &[1.0, 0.0], 1000, StepSize::Fixed(1e-5));
    let (_, stats) = run("rk4", &cubic(), &options);
    assert_eq!((stats.steps, stats.evaluations), (1000, 4000));
}

/// Where a tolerance chooses its steps, the error of generalised α falls with the square of their number.
#[test]
fn law_order_by_tolerance() {
    let [rough, fine] = [1e-7, 1e-12].map(|tolerance| {
        let options = ask(20.0, &[1.0, 0.0], 1, StepSize::Adaptive(tolerance));
        let (samples, stats) = run("generalized-alpha-controlled", &cubic(), &options);
        let error = (samples[1].1[0] - 20f64.cos()).hypot(samples[1].1[1] + 20f64.sin());
        (error, stats.steps as f64)
    });
    let found = (rough.0 / fine.0).ln() / (fine.1 / rough.1).ln();
    eprintln!("{rough:?}, {fine:?}");
    assert!((found - 2.0).abs() < 0.2, "{found}");
    verification::order("generalized-alpha-controlled, by tolerance", 2.0, found);
}

mod naive {
    use ode_solvers::dop_shared::OutputType;
    use ode_solvers::{Dop853, System, Vector2};

    /// `ÿ + y = cos 3t` with time as the package passes it.
    pub struct Forced;

    impl System<f64, Vector2<f64>> for Forced {
        fn system(&self, t: f64, y: &Vector2<f64>, dy: &mut Vector2<f64>) {
            dy[0] = y[1];
            dy[1] = (3.0 * t).cos() - y[0];
        }
    }

    /// The same without force: time plays no part.
    pub struct Free;

    impl System<f64, Vector2<f64>> for Free {
        fn system(&self, _t: f64, y: &Vector2<f64>, dy: &mut Vector2<f64>) {
            dy[0] = y[1];
            dy[1] = -y[0];
        }
    }

    pub fn last<S: System<f64, Vector2<f64>>>(
        system: S,
        to: f64,
        dense: bool,
    ) -> Vec<Vector2<f64>> {
        let mut solver = Dop853::new(system, 0.0, to, 1.0, Vector2::new(1.0, 0.0), 1e-12, 1e-12);
        if !dense {
            solver.set_output(OutputType::Sparse);
        }
        let _ = solver.integrate();
        solver.y_out().clone()
    }
}

/// `ÿ + y = cos 3t`, y(0) = 1, ẏ(0) = 0.
fn forced_exact(t: f64) -> f64 {
    1.125 * t.cos() - 0.125 * (3.0 * t).cos()
}

/// ode_solvers used as it offers itself is wrong twice, and the adapter is not.
#[test]
fn law_ode_solvers_right_only_through_the_adapter() {
    let naive = naive::last(naive::Forced, 2.0, false);
    let off = (naive.last().unwrap()[0] - forced_exact(2.0)).abs();
    eprintln!("explicit time: {off:.2e} after {} steps", naive.len());
    assert!(off > 1e-8, "the package has mended its nodes: {off}");
    let dense = naive::last(naive::Free, 20.0, true);
    let error = |at: usize| (dense[at][0] - (at as f64).cos()).abs();
    let before = (0..20).map(error).fold(0.0, f64::max);
    eprintln!(
        "dense output: {before:.2e} before the last point, {:.2e} there",
        error(20)
    );
    assert!(before < 1e-10, "{before}");
    assert!(error(20) > 1e-6, "the package has mended its last point");

    let machine = train(
        &[1.0],
        vec![ground(0, 1.0, 0.0)],
        vec![drive(0, Signal::harmonic(1.0, 3.0, 0.0))],
    );
    for samples in [1, 10, 1000] {
        let options = ask(20.0, &[1.0, 0.0], samples, StepSize::Adaptive(1e-12));
        let (samples, stats) = run("dop853", &machine, &options);
        let error = samples
            .iter()
            .map(|(t, y)| (y[0] - forced_exact(*t)).abs())
            .fold(0.0, f64::max);
        eprintln!(
            "adapter, {} samples: {error:.2e}, {stats:?}",
            options.samples
        );
        assert!(error < 2e-12, "{error}");
    }
}

struct Stiff {
    n: usize,
    f: fn(&[f64], &mut [f64]),
}

impl OdeProblem for Stiff {
    fn len(&self) -> usize {
        self.n
    }

    fn derivative(&self, _t: f64, y: &[f64], dy: &mut [f64]) {
        (self.f)(y, dy);
    }
}

/// Published end states of three stiff problems.
/// Source: F. Mazzia and C. Magherini, Test Set for Initial Value Problem Solvers, problems vdpol, HIRES, ROBER.
#[test]
fn ref_mazzia_stiff_problems() {
    let published = reference("stiff_problems");
    let vdp = Stiff {
        n: 2,
        f: |y, dy| {
            dy[0] = y[1];
            dy[1] = ((1.0 - y[0] * y[0]) * y[1] - y[0]) / 1e-6;
        },
    };
    let hires = Stiff {
        n: 8,
        f: |y, dy| {
            dy[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007;
            dy[1] = 1.71 * y[0] - 8.75 * y[1];
            dy[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4];
            dy[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3];
            dy[4] = -1.745 * y[4] + 0.43 * y[5] + 0.43 * y[6];
            dy[5] = -280.0 * y[5] * y[7] + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6];
            dy[6] = 280.0 * y[5] * y[7] - 1.81 * y[6];
            dy[7] = -dy[6];
        },
    };
    let rober = Stiff {
        n: 3,
        f: |y, dy| {
            dy[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
            dy[2] = 3e7 * y[1] * y[1];
            dy[1] = -dy[0] - dy[2];
        },
    };
    let hires_start = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0057];
    for (name, problem, start, to) in [
        ("vdp", &vdp, &[2.0, 0.0][..], 2.0),
        ("hires", &hires, &hires_start[..], 321.8122),
        ("rober", &rober, &[1.0, 0.0, 0.0][..], 1e11),
    ] {
        let expected = numbers(&published[name]["end"]);
        let options = ask(to, start, 1, StepSize::Adaptive(1e-11));
        by_explicit(name, problem, &options, &expected);
        let begun = std::time::Instant::now();
        let (samples, stats) = gather(with_events::radau5_ode, problem, &options).unwrap();
        let time = begun.elapsed();
        let error = samples[1]
            .1
            .iter()
            .zip(&expected)
            .map(|(y, e)| ((y - e) / e).abs())
            .fold(0.0, f64::max);
        eprintln!("{name}: {time:.1?}, {stats:?}");
        within(&format!("{name} by radau5"), error, 1e-8);
    }
}

/// The same by explicit methods: HIRES is mildly stiff, though too much so for the stiffness test of ode_solvers' order 8;
/// the others are refused within a tenth of a million evaluations.
fn by_explicit(name: &str, problem: &Stiff, options: &IntegrationOptions, expected: &[f64]) {
    let options = IntegrationOptions {
        max_work: if name == "hires" { 10_000_000 } else { 100_000 },
        ..options.clone()
    };
    let dopri5: IntegrateFn<Stiff> =
        |p, options, sink| explicit_runge_kutta::run(ExplicitMethod::Dopri5, p, options, sink);
    let dop853: IntegrateFn<Stiff> =
        |p, options, sink| explicit_runge_kutta::run(ExplicitMethod::Dop853, p, options, sink);
    for (method, run) in [
        (
            "dop853-events",
            with_events::dop853_ode as IntegrateFn<Stiff>,
        ),
        ("dopri5", dopri5),
        ("dop853", dop853),
    ] {
        let able = name == "hires" && method != "dop853";
        match gather(run, problem, &options) {
            Ok((samples, stats)) if able => {
                let state = samples[1].1.iter().zip(expected);
                let error = state.map(|(y, e)| ((y - e) / e).abs()).fold(0.0, f64::max);
                eprintln!("{name} by {method}: {stats:?}");
                within(&format!("{name} by {method}"), error, 1e-8);
            }
            Err(error) => {
                eprintln!("{name} by {method}: {error}");
                assert!(!able && matches!(error.code, Code::BudgetExceeded | Code::NoConvergence));
            }
            Ok((_, stats)) => panic!("{name} by {method} within the budget: {stats:?}"),
        }
    }
}

/// Modelica's example of a motor, a gear, a spring and a load.
/// Source: equations of the Modelica Standard Library (commit b756f9de); numbers by matrix exponential and DOP853 of SciPy, which agree to 6e-13.
#[test]
fn ref_modelica_first_example() {
    let machine = train(
        &[12.0, 2.0],
        vec![spring(0, 1, 1e4, 0.0), ground(0, 0.0, 10.0)],
        vec![drive(0, Signal::harmonic(100.0, 10.0 * PI, -0.5 * PI))],
    );
    let expected = rows(&reference("msl_first")["states"]);
    for name in ["dop853-events", "radau5", "dop853", "dopri5"] {
        let options = ask(1.0, &[0.0; 4], 20, StepSize::Adaptive(1e-12));
        let (samples, stats) = run(name, &machine, &options);
        let mut worst: f64 = 0.0;
        for row in &expected {
            let (_, y) = &samples[(20.0 * row[0]).round() as usize];
            for i in 0..4 {
                worst = worst.max((y[i] - row[1 + i]).abs());
            }
        }
        eprintln!("{name}: {stats:?}");
        within(&format!("states by {name}"), worst, 1e-9);
    }
}

/// Modelica's example of play in three conventions, states and number of switches.
/// Source: equations of the Modelica Standard Library (commit b756f9de); numbers by DOP853 of SciPy with located events, rtol 1e-13.
#[test]
fn ref_modelica_backlash_in_three_conventions() {
    let published = reference("msl_backlash");
    let (c, d) = (20000.0, 50.0);
    let half = 0.5 * published["play"].as_f64().unwrap();
    let start = [published["phi0"].as_f64().unwrap(), 0.0];
    for (key, law) in [
        (
            "springDamper",
            ForceLaw::Linear {
                stiffness: c,
                damping: d,
            },
        ),
        (
            "elastoBacklash",
            play(c, d, half, ContactDamping::Continuous),
        ),
        ("elastoBacklash2", play(c, d, half, ContactDamping::NoPull)),
    ] {
        let machine = train(
            &[5.0],
            vec![branch("play", Direction::unit(0), law)],
            Vec::new(),
        );
        let events = published[key]["events"].as_array().unwrap().len() as u64;
        for (name, tolerance) in [("dop853-events", 1e-12), ("radau5", 1e-11)] {
            let options = ask(1.0, &start, 20, StepSize::Adaptive(tolerance));
            let begun = std::time::Instant::now();
            let (samples, stats) = run(name, &machine, &options);
            let time = begun.elapsed();
            let mut worst: f64 = 0.0;
            for row in rows(&published[key]["states"]) {
                let (_, y) = &samples[(20.0 * row[0]).round() as usize];
                worst = worst.max((y[0] - row[1]).abs()).max((y[1] - row[2]).abs());
            }
            eprintln!("{key} by {name}: {time:.1?}, {stats:?}");
            within(&format!("{key} by {name}"), worst, 1e-8);
            assert_eq!(stats.events, events, "{key} by {name}");
        }
    }
}

/// `T = 2π/ω + 4b/(ω (A − b))`: after a period the oscillator with play is where it began, and at rest.
#[test]
fn law_period_with_play() {
    for (b, w, a) in [
        (1.0, 1.0, 1.01),
        (1.0, 3.0, 1.5),
        (0.2, 3.0, 4.0),
        (0.2, 1.0, 0.202),
    ] {
        let law = play(w * w, 0.0, b, ContactDamping::Adhesive);
        let machine = train(
            &[1.0],
            vec![branch("play", Direction::unit(0), law)],
            Vec::new(),
        );
        let period = 2.0 * PI / w + 4.0 * b / (w * (a - b));
        for (name, tolerance) in [("dop853-events", 1e-13), ("radau5", 1e-12)] {
            let options = ask(period, &[a, 0.0], 1, StepSize::Adaptive(tolerance));
            let (samples, stats) = run(name, &machine, &options);
            let y = &samples[1].1;
            // At the end the speed is −ω²(A − b) times what is missing of the period.
            let missing = y[1].abs() / (w * w * (a - b)) / period;
            eprintln!("{name} b={b} w={w} A={a}: {missing:.2e} {stats:?}");
            assert!(missing < 1e-11, "{name}: {missing}");
            assert_eq!(stats.events, 4);
        }
    }
}

fn rubbing(sliding: f64, breakaway: f64) -> ForceElement {
    let law = ForceLaw::Friction(FrictionLaw {
        sliding,
        breakaway,
        stribeck_velocity: 1e-9,
        regularisation_velocity: 1e-3,
    });
    branch("rubbing", Direction::unit(0), law)
}

/// An oscillator with Coulomb friction loses 2F/k of amplitude every half period and stops where the spring is too weak.
#[test]
fn law_coulomb_decay() {
    let machine = train(
        &[2.0],
        vec![ground(0, 8.0, 0.0), rubbing(8.0, 8.0)],
        Vec::new(),
    );
    for (name, tolerance) in [("dop853-events", 1e-12), ("radau5", 1e-11)] {
        // ω = 2: half a period is π/2.
        let options = ask(5.0 * PI, &[10.3, 0.0], 10, StepSize::Adaptive(tolerance));
        let (samples, stats) = run(name, &machine, &options);
        let turns = [10.3, -8.3, 6.3, -4.3, 2.3, -0.3, -0.3, -0.3];
        for (at, turn) in turns.iter().enumerate() {
            let y = &samples[at].1;
            assert!((y[0] - turn).abs() < 1e-9, "{name}: {at} {y:?}");
            assert!(y[1].abs() < 1e-8, "{name}: {at} {y:?}");
        }
        assert!(samples[10].1[1].abs() < 1e-14, "{name}: at rest");
        eprintln!("{name}: {stats:?}");
    }
}

/// A block pulled through a spring sticks and slips: a periodic motion, the same by both methods.
#[test]
fn law_stick_slip() {
    let mut pull = ground(0, 4.0, 0.0);
    pull.imposed_displacement = Some(Signal {
        knots: vec![Knot::line(0.0, 0.0, 0.1)],
        harmonics: Vec::new(),
        ..Signal::default()
    });
    let law = ForceLaw::Friction(FrictionLaw {
        sliding: 1.0,
        breakaway: 2.0,
        stribeck_velocity: 0.1,
        regularisation_velocity: 1e-3,
    });
    let rubbing = branch("rubbing", Direction::unit(0), law);
    let machine = train(&[1.0], vec![pull, rubbing], Vec::new());
    let mut ends = Vec::new();
    for (name, tolerance) in [("dop853-events", 1e-12), ("radau5", 1e-11)] {
        let options = ask(60.0, &[0.0, 0.0], 600, StepSize::Adaptive(tolerance));
        let (samples, stats) = run(name, &machine, &options);
        // It sticks until the spring holds 2 N, which takes 5 s.
        assert_eq!(samples[49].1, [0.0, 0.0], "{name}");
        assert!(samples[51].1[1] > 0.0, "{name}");
        eprintln!("{name}: {:?} {stats:?}", samples[600].1);
        ends.push((samples[600].1.clone(), stats.events));
    }
    assert!((ends[0].0[0] - ends[1].0[0]).abs() < 1e-8, "{ends:?}");
    assert_eq!(ends[0].1, ends[1].1);
    assert!(ends[0].1 > 8, "{ends:?}");
}

/// Touches much shorter than a step are not missed: two freedoms, a stiff stop just inside the amplitude.
#[test]
fn law_short_touches_are_seen() {
    let stop = play(10.0, 0.0, 0.9999, ContactDamping::Adhesive);
    let machine = train(
        &[1.0],
        vec![
            ground(0, 1.0, 0.0),
            branch("stop", Direction::unit(0), stop),
        ],
        Vec::new(),
    );
    for name in ["dop853-events", "radau5"] {
        let options = ask(20.0 * PI - 1.0, &[0.0, 1.0], 3, StepSize::Adaptive(1e-6));
        let (_, stats) = run(name, &machine, &options);
        eprintln!("{name}: {stats:?}");
        // Two touches a period, each a closing and an opening.
        assert_eq!(stats.events, 40, "{name}");
    }
}

/// A stiffness that follows the angle of a rotor too heavy to be slowed is the stiffness of an imposed speed.
#[test]
fn law_followed_angle_at_constant_speed() {
    let shape = || Waveform::Rectangular {
        high: 1.2,
        low: 0.7,
        duty: 0.6,
    };
    let wave = |phase| PeriodicFunction {
        load_table: None,
        waveform: shape(),
        phase,
    };
    let machine = |phase| {
        let mut mesh = branch(
            "mesh",
            Direction::unit(1),
            play(4.0, 0.05, 0.1, ContactDamping::Adhesive),
        );
        mesh.stiffness_wave = Some(wave(phase));
        let push = AppliedForce {
            name: "push".to_string(),
            direction: Direction::unit(1),
            signal: Signal::constant(0.3),
        };
        train(&[1e15, 1.0], vec![mesh], vec![push])
    };
    let imposed = machine(WavePhase::Imposed {
        omega: 3.0,
        start: 0.2,
    });
    let followed = machine(WavePhase::FollowsAngle {
        angle: Direction::unit(0),
        start: 0.2,
        known: None,
    });
    let start = [0.0, 0.5, 3.0, 0.0];
    let mut ends = Vec::new();
    for (name, tolerance) in [("dop853-events", 1e-12), ("radau5", 1e-11)] {
        for machine in [&imposed, &followed] {
            let options = ask(30.0, &start, 10, StepSize::Adaptive(tolerance));
            let (samples, stats) = run(name, machine, &options);
            eprintln!("{name}: {:?} {stats:?}", samples[10].1);
            ends.push(samples[10].1.clone());
        }
    }
    for end in &ends {
        assert!((end[1] - ends[0][1]).abs() < 1e-8, "{ends:?}");
    }
}

/// Undamped, for 1 000 periods: the drift of the energy.
#[test]
fn law_energy_drift() {
    let machine = train(&[1.0], vec![ground(0, 1.0, 0.0)], Vec::new());
    for (name, stats, bound) in [
        ("dop853-events", StepSize::Adaptive(1e-10), 2e-6),
        ("radau5", StepSize::Adaptive(1e-8), 2e-4),
        ("dop853", StepSize::Adaptive(1e-10), 2e-6),
        ("newmark", StepSize::Fixed(0.1), 1e-10),
    ] {
        let options = ask(2000.0 * PI, &[1.0, 0.0], 4, stats);
        let (samples, stats) = run(name, &machine, &options);
        let y = &samples[4].1;
        let drift = (y[0] * y[0] + y[1] * y[1] - 1.0).abs();
        eprintln!("{name}: energy {drift:.2e}, {stats:?}");
        assert!(drift < bound, "{name}: {drift}");
    }
}

/// Average acceleration keeps the amplitude and turns by `2 atan(ωh/2)` a step.
#[test]
fn law_newmark_amplitude_and_period() {
    let machine = train(&[1.0], vec![ground(0, 9.0, 0.0)], Vec::new());
    for h in [0.01, 0.1, 1.0] {
        let steps = 500;
        let options = ask(h * 500.0, &[1.0, 0.0], steps, StepSize::Fixed(h));
        let (samples, _) = run("newmark", &machine, &options);
        let turn = 2.0 * (1.5 * h).atan();
        let worst = samples
            .iter()
            .enumerate()
            .map(|(at, (_, y))| (y[0] - (turn * at as f64).cos()).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-10, "{h}: {worst}");
    }
}

/// At steps far longer than the period the amplitude falls by ρ∞ a step (times the count, the root being double).
#[test]
fn law_damping_at_infinity() {
    let machine = train(&[1.0], vec![ground(0, 1e12, 0.0)], Vec::new());
    for (weights, radius, double) in [
        (GeneralizedAlpha::hht(0.8), 0.8, false),
        (GeneralizedAlpha::hht(0.6), 0.6, false),
        (GeneralizedAlpha::generalized(0.8), 0.8, true),
        (GeneralizedAlpha::generalized(0.5), 0.5, true),
        (GeneralizedAlpha::newmark(), 1.0, false),
    ] {
        let options = ask(80.0, &[1.0, 0.0], 80, StepSize::Fixed(1.0));
        let mut size = Vec::new();
        alpha::run(&weights, &machine, &options, &mut |_, y, _| {
            size.push(y[0].abs());
            ControlFlow::Continue(())
        })
        .unwrap();
        let doubled = if double { 2f64.powf(1.0 / 40.0) } else { 1.0 };
        let measured = (size[80] / size[40]).powf(1.0 / 40.0) / doubled;
        eprintln!("{weights:?}: {measured}");
        assert!(
            (measured - radius).abs() < 0.02 * radius,
            "{radius}: {measured}"
        );
    }
}

/// A chain whose stiffnesses lie ten powers of ten apart, in its slowest elastic mode.
#[test]
fn law_stiff_chain() {
    let mass = [1.0, 0.1, 2.0, 0.5, 1.0];
    let stiffness = [1e8, 1.0, 1e4, 1e-2];
    let springs = (0..4)
        .map(|i| spring(i, i + 1, stiffness[i], 0.0))
        .collect();
    let machine = train(&mass, springs, Vec::new());
    let k = Matrix::from_fn(5, 5, |i, j| {
        let at = |i: usize| stiffness.get(i).copied().unwrap_or(0.0);
        let before = if i > 0 { at(i - 1) } else { 0.0 };
        match j as i64 - i as i64 {
            0 => before + at(i),
            1 => -at(i),
            -1 => -before,
            _ => 0.0,
        }
    });
    let m = Matrix::from_fn(5, 5, |i, j| if i == j { mass[i] } else { 0.0 });
    let modes = symmetric::generalised_symmetric_eigen(&k, &m).unwrap();
    let (square, shape) = (modes.values[1], modes.vectors.col_as_slice(1).to_vec());
    let omega = square.sqrt();
    // Digits of the eigenvector the solver left behind excite fast modes by 1e-12 of it or so.
    let start = [shape.clone(), vec![0.0; 5]].concat();
    let options = ask(10.0, &start, 5, StepSize::Adaptive(1e-8));
    let begun = std::time::Instant::now();
    let (samples, stats) = run("radau5", &machine, &options);
    let worst = samples
        .iter()
        .flat_map(|(t, y)| {
            (0..5)
                .map(|i| (y[i] - shape[i] * (omega * t).cos()).abs())
                .collect::<Vec<_>>()
        })
        .fold(0.0, f64::max);
    eprintln!("radau5: {worst:.2e} in {:.1?}, {stats:?}", begun.elapsed());
    assert!(worst < 1e-6, "{worst}");
    let mut cheap = options.clone();
    cheap.max_work = 100_000;
    for name in ["dop853-events", "dop853", "dopri5"] {
        let error = gather(method_by_name(name).unwrap().run, &machine, &cheap).unwrap_err();
        eprintln!("{name}: {error}");
        assert!(
            matches!(error.code, Code::BudgetExceeded | Code::NoConvergence),
            "{error}"
        );
    }
}

/// Every method gives the same motion of a linear machine.
#[test]
fn law_methods_agree() {
    let machine = train(
        &[2.0, 1.0, 0.5],
        vec![
            ground(0, 3.0, 0.1),
            spring(0, 1, 20.0, 0.2),
            spring(1, 2, 50.0, 0.1),
        ],
        vec![
            drive(2, Signal::harmonic(1.0, 2.0, 0.3)),
            drive(0, Signal::step(0.7, 1.234)),
        ],
    );
    let start = [0.1, 0.2, -0.1, 0.0, 1.0, 0.0];
    let base = run(
        "radau5",
        &machine,
        &ask(5.0, &start, 13, StepSize::Adaptive(1e-11)),
    )
    .0;
    for method in METHODS {
        let (stats, bound) = match (method.step_control, method.order) {
            (StepControl::Adaptive, Some(2)) => (StepSize::Adaptive(1e-8), 1e-3),
            // Thousands of steps of order five and below, whose errors add up.
            (StepControl::Adaptive, None) => (StepSize::Adaptive(1e-10), 1e-6),
            (StepControl::Adaptive | StepControl::Exact, _) => (StepSize::Adaptive(1e-10), 1e-8),
            (StepControl::Fixed, Some(2)) => (StepSize::Fixed(1e-3), 2e-3),
            (StepControl::Fixed, _) => (StepSize::Fixed(1e-3), 1e-7),
        };
        assert!((method.unsupported_reason)(&machine).is_none());
        let begun = std::time::Instant::now();
        let (samples, stats) = run(method.name, &machine, &ask(5.0, &start, 13, stats));
        let time = begun.elapsed();
        let worst = samples
            .iter()
            .zip(&base)
            .flat_map(|(a, b)| {
                a.1.iter()
                    .zip(&b.1)
                    .map(|(x, y)| (x - y).abs())
                    .collect::<Vec<_>>()
            })
            .fold(0.0, f64::max);
        eprintln!("{}: {worst:.2e} in {time:.1?}, {stats:?}", method.name);
        assert!(worst < bound, "{}: {worst}", method.name);
    }
}

/// Newmark's kin with play: as fine as their order lets them.
#[test]
fn law_fixed_steps_with_play() {
    let law = play(9.0, 0.2, 0.3, ContactDamping::Continuous);
    let machine = train(
        &[1.0, 2.0],
        vec![
            branch("play", Direction::new(1.0, [(0, -1.0), (1, 1.0)]), law),
            ground(0, 4.0, 0.1),
        ],
        vec![drive(1, Signal::harmonic(1.0, 1.3, 0.0))],
    );
    let start = [0.0; 4];
    let base = run(
        "dop853-events",
        &machine,
        &ask(10.0, &start, 5, StepSize::Adaptive(1e-12)),
    )
    .0;
    for name in [
        "newmark",
        "hht",
        "generalized-alpha",
        "generalized-alpha-controlled",
    ] {
        let stats = match method_by_name(name).unwrap().step_control {
            StepControl::Adaptive => StepSize::Adaptive(1e-8),
            _ => StepSize::Fixed(1e-3),
        };
        let (samples, stats) = run(name, &machine, &ask(10.0, &start, 5, stats));
        let worst = samples
            .iter()
            .zip(&base)
            .flat_map(|(a, b)| {
                a.1.iter()
                    .zip(&b.1)
                    .map(|(x, y)| (x - y).abs())
                    .collect::<Vec<_>>()
            })
            .fold(0.0, f64::max);
        eprintln!("{name}: {worst:.2e}, {stats:?}");
        assert!(worst < 2e-3, "{name}: {worst}");
    }
}

/// What cannot be asked, or would cost too much, is refused; nothing that is no number is handed over.
#[test]
fn law_refusals() {
    let machine = train(&[1.0], vec![ground(0, 1.0, 0.0)], Vec::new());
    for method in METHODS {
        let effort = match method.step_control {
            StepControl::Fixed => StepSize::Fixed(1e-4),
            _ => StepSize::Adaptive(1e-10),
        };
        let refused = |options: &IntegrationOptions| {
            gather(method.run, &machine, options)
                .expect_err(method.name)
                .code
        };
        let nan = ask(1.0, &[f64::NAN, 0.0], 3, effort);
        assert_eq!(refused(&nan), Code::OutOfRange, "{}", method.name);
        let short = ask(1.0, &[1.0], 3, effort);
        assert_eq!(refused(&short), Code::OutOfRange, "{}", method.name);
        let mut dear = ask(1e3, &[1.0, 0.0], 3, effort);
        dear.max_work = 300;
        // What is exact pays for switches, the exponential method for what is not linear, and here is neither.
        if method.step_control != StepControl::Exact && method.name != "exponential" {
            assert_eq!(refused(&dear), Code::BudgetExceeded, "{}", method.name);
        }
        let mut ended = 0;
        let effort = (method.run)(
            &machine,
            &ask(1.0, &[1.0, 0.0], 9, effort),
            &mut |_, _, _| {
                ended += 1;
                if ended == 4 {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            },
        );
        assert!(effort.is_ok() && ended == 4, "{}", method.name);
    }
    let late = train(
        &[1.0],
        vec![branch(
            "late",
            Direction::unit(0),
            ForceLaw::Maxwell {
                stiffness: 1.0,
                damping: 1.0,
            },
        )],
        Vec::new(),
    );
    assert!((method_by_name("newmark").unwrap().unsupported_reason)(&late).is_some());
    let wild = Stiff {
        n: 1,
        f: |y, dy| dy[0] = y[0] * y[0],
    };
    let blow = ask(2.0, &[1.0], 4, StepSize::Adaptive(1e-8));
    for run in [
        with_events::dop853_ode as IntegrateFn<Stiff>,
        with_events::radau5_ode,
        |p, a, s| explicit_runge_kutta::run(ExplicitMethod::Dop853, p, a, s),
        |p, a, s| explicit_runge_kutta::run(ExplicitMethod::Dopri5, p, a, s),
    ] {
        let error = gather(run, &wild, &blow).unwrap_err();
        eprintln!("{error}");
        assert!(
            matches!(error.code, Code::NoConvergence | Code::Overflow),
            "{error}"
        );
    }
}
