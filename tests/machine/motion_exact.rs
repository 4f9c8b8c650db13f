//! Exact motion of linear machines and from switch to switch: closed forms, published cases, 90 digits, brute force.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::ControlFlow;

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Error;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::machine::characteristic::Characteristic;
use geardyn::internals::machine::direction::Direction;
use geardyn::internals::motion::contact::{ActiveFlanks, ContactDamping, ContactLaw};
use geardyn::internals::motion::curve::TorqueSpeedCurve;
use geardyn::internals::motion::dynamic_model::{
    AppliedForce, DynamicModel, ElementState, ForceElement, ForceLaw, MassMatrix,
};
use geardyn::internals::motion::friction::FrictionLaw;
use geardyn::internals::motion::methods;
use geardyn::internals::motion::problem::{
    IntegrationOptions, IntegrationStats, Observer, OdeProblem, StepSize,
};
use geardyn::internals::motion::segment::{regime_cache, run};
use geardyn::internals::motion::signal::Signal;
use geardyn::internals::motion::wave::{PeriodicFunction, WavePhase, Waveform};
use geardyn::internals::numeric::{Matrix, expm::expm};
use serde_json::Value;

// machines

fn train(mass: &[f64], branches: Vec<ForceElement>, drives: Vec<AppliedForce>) -> DynamicModel {
    DynamicModel {
        coordinates: (0..mass.len()).map(|i| format!("disc_{i}.theta")).collect(),
        mass: MassMatrix::Diagonal(mass.to_vec()),
        elements: branches,
        forces: drives,
        mass_damping: 0.0,
        global_matrices: None,
    }
}

fn branch(terms: &[(usize, f64)], law: ForceLaw) -> ForceElement {
    ForceElement {
        name: format!("branch of {terms:?}"),
        direction: Direction::new(1.0, terms.iter().copied()),
        force_direction: None,
        law,
        stiffness_wave: None,
        imposed_displacement: None,
        angle_waves: Vec::new(),
    }
}

fn spring(terms: &[(usize, f64)], stiffness: f64, damping: f64) -> ForceElement {
    branch(terms, ForceLaw::Linear { stiffness, damping })
}

fn drive(at: usize, signal: Signal) -> AppliedForce {
    AppliedForce {
        name: "torque".into(),
        direction: Direction::unit(at),
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

fn chain(inertia: &[f64], stiffness: &[f64], damping: &[f64]) -> Vec<ForceElement> {
    (0..inertia.len() - 1)
        .map(|i| spring(&[(i, -1.0), (i + 1, 1.0)], stiffness[i], damping[i]))
        .collect()
}

// runs

type Samples = Vec<(f64, Vec<f64>)>;

fn try_run(
    method: &str,
    model: &DynamicModel,
    options: &IntegrationOptions,
) -> Result<(Samples, IntegrationStats), Error> {
    let method = methods::method_by_name(method).unwrap();
    assert_eq!((method.unsupported_reason)(model), None);
    let mut samples = Vec::new();
    let stats = (method.run)(model, options, &mut |t, y, _| {
        samples.push((t, y.to_vec()));
        ControlFlow::Continue(())
    })?;
    assert_eq!(samples.len(), options.samples + 1);
    Ok((samples, stats))
}

fn ask(start: &[f64], to: f64, samples: usize) -> IntegrationOptions {
    IntegrationOptions {
        from: 0.0,
        to,
        initial_state: start.to_vec(),
        samples,
        step_size: StepSize::Fixed(1.0),
        max_work: 100_000_000,
        cancel: CancelToken::default(),
        observer: Observer::default(),
    }
}

fn run(
    model: &DynamicModel,
    start: &[f64],
    to: f64,
    samples: usize,
) -> (Samples, IntegrationStats) {
    let method = if model.is_linear() {
        "exact"
    } else {
        "switched"
    };
    try_run(method, model, &ask(start, to, samples)).unwrap()
}

fn end(model: &DynamicModel, start: &[f64], to: f64) -> Vec<f64> {
    run(model, start, to, 1).0.pop().unwrap().1
}

fn assert_near(found: &[f64], exact: &[f64], tolerance: f64) {
    let gaps = found.iter().zip(exact).map(|(a, b)| (a - b).abs());
    within("states", gaps.fold(0.0, f64::max), tolerance);
}

fn reference(name: &str) -> Value {
    let path = format!("{}/data/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

// closed forms of one freedom

/// Free motion: light, critical, a hair beside critical, heavy, and with no spring at all.
#[test]
fn exact_free_motion() {
    let (w, x, v) = (3.0f64, 0.7, -1.1);
    for zeta in [
        0.0,
        0.02,
        0.86,
        0.999_999_999,
        1.0,
        1.000_000_001,
        1.13,
        50.0,
    ] {
        let machine = train(&[2.0], vec![spring(&[(0, 1.0)], 18.0, 12.0 * zeta)], vec![]);
        for (t, y) in run(&machine, &[x, v], 4.0, 7).0 {
            let a = zeta * w;
            let gap: f64 = 1.0 - zeta * zeta;
            let (c, s) = match gap {
                gap if gap.abs() < 1e-6 => {
                    // cos √g and sin √g / √g of g = gap (wt)², by series
                    let g = gap * (w * t) * (w * t);
                    (
                        1.0 - g / 2.0 + g * g / 24.0,
                        t * (1.0 - g / 6.0 + g * g / 120.0),
                    )
                }
                gap if gap > 0.0 => {
                    let nu = w * gap.sqrt();
                    ((nu * t).cos(), (nu * t).sin() / nu)
                }
                gap => {
                    let nu = w * (-gap).sqrt();
                    ((nu * t).cosh(), (nu * t).sinh() / nu)
                }
            };
            let e = (-a * t).exp();
            let place = e * (x * c + (v + a * x) * s);
            let rate = e * (v * c - (w * w * x + a * v) * s);
            // cosh overflows nothing here, but loses what e takes back.
            let lost = if zeta > 2.0 { 1e-11 } else { 1e-14 };
            if zeta > 2.0 && t > 0.1 {
                let slow = w * (zeta - (zeta * zeta - 1.0).sqrt());
                let fast = w * w / slow;
                let share = (v + fast * x) / (fast - slow);
                assert_near(
                    &y,
                    &[share * (-slow * t).exp(), -slow * share * (-slow * t).exp()],
                    1e-14,
                );
                continue;
            }
            assert_near(&y, &[place, rate], lost);
        }
    }
}

/// Harmonic force from rest, far from, near and exactly at resonance, without damping.
#[test]
fn exact_resonance() {
    let w = 2.0;
    for (omega, tolerance) in [
        (0.3, 1e-13),
        (1.9, 2e-13),
        (2.0 * (1.0 + 1e-9), 1e-11),
        (2.0, 1e-11),
    ] {
        let force = Signal::harmonic(3.0, omega, 0.4);
        let machine = train(
            &[1.0],
            vec![spring(&[(0, 1.0)], w * w, 0.0)],
            vec![drive(0, force)],
        );
        for (t, y) in run(&machine, &[0.0, 0.0], 300.0, 31).0 {
            // ∫ sin w(t − s)/w · 3 cos(Ω s + φ) ds by the half angles, which survives Ω = w.
            let (sum, gap) = (omega + w, omega - w);
            let sinc = |x: f64| if x.abs() < 1e-8 { 1.0 } else { x.sin() / x };
            let part = |k: f64, sign: f64| {
                // ∫ sin(wt − ws + sign (Ωs + φ)) ds, k = sign Ω − w
                t * sinc(k * t / 2.0) * (w * t + k * t / 2.0 + sign * 0.4).sin()
            };
            let x = 3.0 / (2.0 * w) * (part(gap, 1.0) + part(-sum, -1.0));
            within(
                "deflection, over 1 + t",
                (y[0] - x).abs() / (1.0 + t),
                tolerance,
            );
        }
    }
}

/// A resonance long after every start has died out, `e^(−value_at)` beyond the range of numbers: the answer is the steady one.
#[test]
fn survives_resonance_for_ever() {
    let (w2, a, omega) = (1.0e4, 1.0, 100.5);
    let force = Signal::harmonic(10.0, omega, 0.0);
    let machine = train(
        &[1.0],
        vec![spring(&[(0, 1.0)], w2, 2.0 * a)],
        vec![drive(0, force)],
    );
    let steady = |t: f64| {
        let (real, imaginary) = (w2 - omega * omega, 2.0 * a * omega);
        let size = real * real + imaginary * imaginary;
        10.0 * (real * (omega * t).cos() + imaginary * (omega * t).sin()) / size
    };
    let found = run(&machine, &[0.0, 0.0], 2000.0, 41).0;
    for (t, y) in found.into_iter().filter(|(t, _)| *t > 100.0) {
        assert!((y[0] - steady(t)).abs() < 1e-11, "t = {t}: {}", y[0]);
    }
}

/// A step of force, then a ramp to nothing: knots with jumps.
#[test]
fn exact_step_and_ramp() {
    let force =
        Signal::table(&[(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (2.0, 2.0), (5.0, 0.0)]).unwrap();
    let machine = train(
        &[1.0],
        vec![spring(&[(0, 1.0)], 4.0, 0.0)],
        vec![drive(0, force)],
    );
    for (t, y) in run(&machine, &[0.0, 0.0], 8.0, 64).0 {
        let w = 2.0;
        let step = |t: f64| {
            if t < 0.0 {
                0.0
            } else {
                (1.0 - (w * t).cos()) / 4.0
            }
        };
        let ramp = |t: f64| {
            if t < 0.0 {
                0.0
            } else {
                (t - (w * t).sin() / w) / 4.0
            }
        };
        let x = 2.0 * step(t - 1.0) - 2.0 / 3.0 * (ramp(t - 2.0) - ramp(t - 5.0));
        within("deflection", (y[0] - x).abs(), 4e-15);
    }
}

/// Nothing holds it: constant, ramped and harmonic torque, with every drag.
#[test]
fn exact_rigid_motion() {
    for drag in [0.0, 1e-12, 1e-4, 0.3, 40.0] {
        let force = Signal {
            harmonics: Signal::harmonic(2.0, 5.0, 0.0).harmonics,
            ..Signal::table(&[(0.0, 1.0), (10.0, 2.0)]).unwrap()
        };
        let mut machine = train(&[2.0], vec![], vec![drive(0, force)]);
        machine.mass_damping = drag;
        for (t, y) in run(&machine, &[1.0, -1.0], 8.0, 9).0 {
            // v' = −a v + (1 + t/10)/2 + cos 5t, power series of the smooth part in a t where a is small
            let a: f64 = drag;
            let (e1, e2, e3) = if a * t < 1e-3 {
                let x = a * t;
                (
                    t * (1.0 - x / 2.0 + x * x / 6.0 - x.powi(3) / 24.0),
                    t * t * (0.5 - x / 6.0 + x * x / 24.0 - x.powi(3) / 120.0),
                    t.powi(3) * (1.0 / 6.0 - x / 24.0 + x * x / 120.0 - x.powi(3) / 720.0),
                )
            } else {
                let e1 = -(-a * t).exp_m1() / a;
                let e2 = (t - e1) / a;
                (e1, e2, (t * t / 2.0 - e2) / a)
            };
            let w = 5.0;
            let bottom = a * a + w * w;
            // v_p = (a cos wt + w sin wt)/(a² + w²)
            let vp = |t: f64| (a * (w * t).cos() + w * (w * t).sin()) / bottom;
            let xp = |t: f64| (a * (w * t).sin() / w - (w * t).cos()) / bottom;
            let v0 = -1.0 - vp(0.0);
            let v = v0 * (1.0 - a * e1) + 0.5 * e1 + 0.05 * e2 + vp(t);
            let x = 1.0 + v0 * e1 + 0.5 * e2 + 0.05 * e3 + xp(t) - xp(0.0);
            let tolerance = if a == 0.3 { 1e-13 } else { 2e-14 };
            assert_near(&y, &[x, v], tolerance * (1.0 + x.abs()));
        }
    }
}

/// A torque far slower than the run pushes a free disc.
#[test]
fn exact_slow_torque_on_a_free_disc() {
    let machine = train(
        &[1.0],
        vec![],
        vec![drive(0, Signal::harmonic(1.0, 1e-6, 0.0))],
    );
    let y = end(&machine, &[0.0, 0.0], 10.0);
    // t²/2 − ω² t⁴/24
    let exact = 50.0 - 1e-12 * 1e4 / 24.0;
    within("angle", (y[0] / exact - 1.0).abs(), 1e-15);
}

/// A moved wall, `k e + c ė`.
#[test]
fn exact_imposed_motion() {
    let mut wall = spring(&[(0, 1.0)], 9.0, 0.6);
    wall.imposed_displacement = Some(Signal::harmonic(0.2, 2.5, 0.3));
    let machine = train(&[1.0], vec![wall], vec![]);
    let (_, y) = run(&machine, &[0.0, 0.0], 200.0, 1).0.pop().unwrap();
    // after 200 s only the steady answer is left, e^{−60}
    let (re, im) = (9.0 - 6.25, 0.6 * 2.5);
    let (top, bottom) = ((9.0f64).hypot(1.5), f64::hypot(re, im));
    let phase = 2.5 * 200.0 + 0.3 + f64::atan2(1.5, 9.0) - f64::atan2(im, re);
    let exact = 0.2 * top / bottom * phase.cos();
    within("deflection", (y[0] - exact).abs(), 1e-14);
}

// published cases and many digits

/// Motor, gear, spring, load.
/// Source: equations of the Modelica Standard Library (commit b756f9de); numbers by matrix exponential and DOP853 of SciPy, which agree to 6e-13.
#[test]
fn ref_first() {
    let case = reference("motion_first");
    let mut discs = chain(&[12.0, 2.0], &[1e4], &[0.0]);
    discs.push(spring(&[(0, 1.0)], 0.0, 10.0));
    let torque = Signal::harmonic(100.0, 10.0 * PI, -FRAC_PI_2);
    let machine = train(&[12.0, 2.0], discs, vec![drive(0, torque)]);
    for (time, state) in case["at"].as_object().unwrap() {
        let t: f64 = time.trim_start_matches("t=").parse().unwrap();
        let y = end(&machine, &[0.0; 4], t);
        let exact = ["phi2", "phi3", "w2", "w3"].map(|key| state[key].as_f64().unwrap());
        assert_near(&y, &exact, 2e-12);
    }
}

/// Eight discs, stiffness over 15 decades: the three that really move.
/// Source: modal superposition with 80 digits by mpmath.
#[test]
fn ref_extreme_chain() {
    let case = reference("extreme_chain");
    let inertia = [1000.0, 1e-9, 1.0, 1e-6, 100.0, 0.001, 1e-9, 10.0];
    let stiffness = [1e12, 0.001, 1e6, 1e9, 1.0, 1000.0, 0.01];
    let machine = train(&inertia, chain(&inertia, &stiffness, &[0.0; 7]), vec![]);
    let mut start = [0.0; 16];
    start[7] = 0.01;
    for t in [1.0, 10.0] {
        let y = end(&machine, &start, t);
        let exact = numbers(&case["theta_rad_at_s"][format!("{t:.0}")]);
        for disc in 5..8 {
            let error = (y[disc] / exact[disc] - 1.0).abs();
            within(
                &format!("angle of disc {} after {t} s", disc + 1),
                error,
                1e-9,
            );
        }
    }
}

/// Six discs, stiffness over ten decades, without damping, with drag, with dampers that mix the modes.
/// Source: matrix exponential with 90 digits by mpmath.
#[test]
fn ref_stiff_chain() {
    let case = reference("motion_stiff_chain");
    let (inertia, stiffness) = (numbers(&case["J_kg_m2"]), numbers(&case["k_Nm_per_rad"]));
    let start = [numbers(&case["start_q"]), numbers(&case["start_v"])].concat();
    for run in case["cases"].as_array().unwrap() {
        let branches = chain(&inertia, &stiffness, &numbers(&run["c_Nms_per_rad"]));
        let torque = Signal::harmonic(3.0, 2.5, 0.5);
        let mut machine = train(&inertia, branches, vec![drive(0, torque)]);
        machine.mass_damping = run["drag_per_s"].as_f64().unwrap();
        for (t, y) in run["y_at_s"].as_object().unwrap() {
            let exact = numbers(y);
            let time: f64 = t.parse().unwrap();
            let found = end(&machine, &start, time);
            // the fastest mode, 1e6 rad/s, may lose 10 ε ω t of its phase, and has all the rate
            let phase = 10.0 * f64::EPSILON * 1e6 * time;
            let most = |y: &[f64]| y.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let off: Vec<f64> = found.iter().zip(&exact).map(|(a, b)| a - b).collect();
            let (q, v) = (
                most(&off[..6]) / most(&exact[..6]),
                most(&off[6..]) / most(&exact[6..]),
            );
            within("angles", q, 1e-12);
            within(
                "rates, over the phase of the fastest mode",
                v / (1e6 * time),
                2.3e-15,
            );
            assert!(v < phase, "{} at {t} s: {v:.1e}", run["name"]);
        }
    }
}

/// 1e5 periods of the slowest mode of an undamped chain: every mode keeps its amplitude and its phase.
#[test]
fn law_undamped_chain_keeps_its_energy() {
    let n = 10;
    let machine = train(
        &vec![1.0; n],
        chain(&vec![1.0; n], &vec![1.0; n], &vec![0.0; n]),
        vec![],
    );
    let shape = |mode: usize, i: usize| (PI * mode as f64 * (i as f64 + 0.5) / n as f64).cos();
    let omega = |mode: usize| 2.0 * (PI * mode as f64 / (2.0 * n as f64)).sin();
    let size = (n as f64 / 2.0).sqrt();
    let mut start = vec![0.0; 2 * n];
    for mode in 1..n {
        (0..n).for_each(|i| start[i] += shape(mode, i) / size);
    }
    let t = 1e5 * TAU / omega(1);
    for (t, y) in run(&machine, &start, t, 3).0 {
        for mode in 1..n {
            let along = |y: &[f64]| (0..n).map(|i| y[i] * shape(mode, i) / size).sum::<f64>();
            let (a, b) = (along(&y[..n]), along(&y[n..]) / omega(mode));
            assert!(
                (a.hypot(b) - 1.0).abs() < 1e-12,
                "mode {mode}: amplitude off by {:.1e}",
                a.hypot(b) - 1.0
            );
            let phase = omega(mode) * t;
            let off = (a - phase.cos()).hypot(b + phase.sin());
            assert!(
                off < 10.0 * f64::EPSILON * phase + 1e-13,
                "mode {mode}: phase off by {off:.1e}"
            );
        }
    }
}

/// ẏ = A y + b + Re(c e^{iωt}) from the machine's own right-hand side, by one exponential with the forces as further states.
fn by_exponential(
    machine: &DynamicModel,
    stand: Option<&[ElementState]>,
    omega: f64,
    h: f64,
) -> Matrix {
    let n = machine.len();
    let slope = |t: f64, y: &[f64]| {
        let mut dy = vec![0.0; n];
        let mut regime = machine.regime(0.0, &vec![0.0; n]);
        if let Some(stand) = stand {
            regime.states = stand.to_vec();
        }
        machine.derivative_in(Some(&regime), t, y, &mut dy);
        dy
    };
    let zero = vec![0.0; n];
    let (whole, half) = (slope(0.0, &zero), slope(PI / omega, &zero));
    let quarter = slope(PI / 2.0 / omega, &zero);
    let mut a = Matrix::zeros(n + 3, n + 3);
    for i in 0..n {
        let still = 0.5 * (whole[i] + half[i]);
        a[(i, n)] = still;
        a[(i, n + 1)] = 0.5 * (whole[i] - half[i]);
        a[(i, n + 2)] = quarter[i] - still;
    }
    a[(n + 1, n + 2)] = -omega;
    a[(n + 2, n + 1)] = omega;
    for j in 0..n {
        let mut unit = zero.clone();
        unit[j] = 1.0;
        let column = slope(0.0, &unit);
        (0..n).for_each(|i| a[(i, j)] = column[i] - whole[i]);
    }
    expm(&Matrix::from_fn(n + 3, n + 3, |i, j| h * a[(i, j)])).unwrap()
}

fn apply(e: &Matrix, y: &[f64]) -> Vec<f64> {
    let row = |i: usize| (0..y.len()).map(|j| e[(i, j)] * y[j]).sum();
    (0..y.len()).map(row).collect()
}

/// Everything a linear machine can hold at once: inner states, lagged and plain motor, a damper to ground, a force that does
/// not act where it is seen, gyroscopic and centrifugal terms, coupled inertia, drag.
#[test]
fn law_general_machine_against_an_exponential() {
    let mut branches = chain(&[1.0; 4], &[40.0, 90.0, 15.0], &[0.1, 0.0, 0.5]);
    branches.push(branch(
        &[(0, -1.0), (2, 2.0)],
        ForceLaw::Maxwell {
            stiffness: 30.0,
            damping: 4.0,
        },
    ));
    branches.push(branch(
        &[(0, 1.0)],
        ForceLaw::LaggedTorque {
            curve: TorqueSpeedCurve::Linear {
                stall: 8.0,
                idle: 20.0,
            },
            lag: 0.2,
        },
    ));
    branches.push(branch(
        &[(3, 1.0)],
        ForceLaw::TorqueSpeed(TorqueSpeedCurve::Linear {
            stall: -2.0,
            idle: 30.0,
        }),
    ));
    branches.push(spring(&[(1, 1.0)], 0.0, 0.3));
    let mut skew = spring(&[(1, 1.0), (2, -1.0)], 5.0, 0.2);
    skew.force_direction = Some(Direction::new(1.0, [(1, 1.0), (3, -0.5)]));
    branches.push(skew);
    let mut machine = train(
        &[1.0; 4],
        branches,
        vec![
            drive(2, Signal::harmonic(2.0, 3.0, 0.0)),
            drive(0, Signal::constant(0.7)),
        ],
    );
    let matrix = Matrix::from_fn(4, 4, |i, j| if i == j { 1.0 + i as f64 } else { 0.2 });
    let inverse =
        geardyn::internals::numeric::symmetric::lu_solve(&matrix, &Matrix::identity(4, 4)).unwrap();
    for variant in 0..3 {
        let mut machine = machine.clone();
        if variant > 0 {
            machine.mass = MassMatrix::Full {
                matrix: matrix.clone(),
                inverse: inverse.clone(),
            };
            machine.mass_damping = 0.05;
        }
        if variant > 1 {
            let k = Matrix::from_fn(4, 4, |i, j| if i == j && i == 1 { -3.0 } else { 0.0 });
            let c = Matrix::from_fn(4, 4, |i, j| {
                [[0.0, 1.0], [-1.0, 0.0]]
                    .get(i)
                    .and_then(|r| r.get(j))
                    .copied()
                    .unwrap_or(0.0)
            });
            machine.global_matrices = Some((k, c));
        }
        let start: Vec<f64> = (0..machine.len()).map(|i| 0.3 * (i as f64).sin()).collect();
        let y = end(&machine, &start, 3.0);
        let exact = apply(
            &by_exponential(&machine, None, 3.0, 3.0),
            &[&start[..], &[1.0, 1.0, 0.0]].concat(),
        );
        println!(
            "variant {variant}: {:.1e}",
            y.iter()
                .zip(&exact)
                .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
        );
        assert_near(&y, &exact, 5e-13);
    }
    machine.elements.truncate(3);
}

/// A mass on a spring and a spring with damper in series, so chosen that all three roots are −1.5: no eigenvectors to speak of.
#[test]
fn exact_triple_root() {
    let a: f64 = 1.5;
    let (k0, k) = (a * a / 3.0, 8.0 * a * a / 3.0);
    let branches = vec![
        spring(&[(0, 1.0)], k0, 0.0),
        branch(
            &[(0, 1.0)],
            ForceLaw::Maxwell {
                stiffness: k,
                damping: 8.0 * a / 9.0,
            },
        ),
    ];
    let machine = train(&[1.0], branches, vec![drive(0, Signal::constant(k0))]);
    // x = 1 + (c₀ + c₁ t + c₂ t²) e^{−at} with x = 0, v = 0, z = 0: ẍ(0) = k0
    let (c0, c1) = (-1.0, -a);
    let c2 = 0.5 * (k0 + 2.0 * a * c1 - a * a * c0);
    for (t, y) in run(&machine, &[0.0; 3], 6.0, 12).0 {
        let x = 1.0 + (c0 + c1 * t + c2 * t * t) * (-a * t).exp();
        within("deflection", (y[0] - x).abs(), 1e-13);
    }
}

// play

/// The period of free motion through a gap, `2π/ω + 4b/(ω (A − b))`, after a hundred of them.
#[test]
fn exact_clearance_period() {
    for (b, w) in [(1.0, 1.0), (1.0, 3.0), (0.2, 1.0), (0.2, 3.0)] {
        for over in [1.01, 1.1, 1.5, 2.0, 5.0, 20.0] {
            let a = over * b;
            let machine = train(
                &[1.0],
                vec![branch(
                    &[(0, 1.0)],
                    play(w * w, 0.0, b, ContactDamping::Adhesive),
                )],
                vec![],
            );
            let period = TAU / w + 4.0 * b / (w * (a - b));
            let (samples, stats) = run(&machine, &[a, 0.0], 100.25 * period, 1);
            assert_eq!(stats.events, 401, "A/b = {over}");
            assert_eq!(stats.regimes, 3);
            // a quarter of a period in, it passes zero at its full rate: what is off there is the period
            let y = &samples[1].1;
            let late = (y[0] / y[1]) / (100.25 * period);
            within("period", late.abs(), 1e-13);
            assert!((y[1] / (-w * (a - b)) - 1.0).abs() < 1e-12);
        }
    }
}

/// Three conventions of what the damper does, with every switch.
/// Source: equations of the Modelica Standard Library (commit b756f9de); numbers by DOP853 of SciPy with located events, rtol 1e-13.
#[test]
fn ref_backlash() {
    let case = reference("motion_backlash");
    let half = PI / 8.0;
    let laws = [
        (
            "springDamper",
            ForceLaw::Linear {
                stiffness: 2e4,
                damping: 50.0,
            },
        ),
        (
            "elastoBacklash",
            play(2e4, 50.0, half, ContactDamping::Continuous),
        ),
        (
            "elastoBacklash2",
            play(2e4, 50.0, half, ContactDamping::NoPull),
        ),
    ];
    for (name, law) in laws {
        let machine = train(&[5.0], vec![branch(&[(0, 1.0)], law)], vec![]);
        let start = [FRAC_PI_2, 0.0];
        let known = &case["runs"][name];
        for (time, state) in known["states"].as_object().unwrap() {
            let y = end(
                &machine,
                &start,
                time.trim_start_matches("t=").parse().unwrap(),
            );
            assert_near(
                &y,
                &[state["phi"].as_f64().unwrap(), state["w"].as_f64().unwrap()],
                1e-9,
            );
        }
        let events = known["events_t_phi_w"].as_array().unwrap();
        let (_, stats) = run(&machine, &start, 1.0, 1);
        assert_eq!(stats.events as usize, events.len(), "{name}");
        for event in events {
            let [t, phi, w] = numbers(event)[..] else {
                panic!()
            };
            let y = end(&machine, &start, t);
            assert_near(&y, &[phi, w], 1e-9);
        }
    }
}

fn gear_pair(omega: f64) -> DynamicModel {
    let mesh = branch(&[(0, 1.0)], play(1.0, 0.1, 1.0, ContactDamping::ActsInGap));
    let drives = vec![
        drive(0, Signal::constant(0.1)),
        drive(0, Signal::harmonic(0.05 * omega * omega, omega, 0.0)),
    ];
    train(&[1.0], vec![mesh], drives)
}

/// Orbits with contact loss come back to where they began, and stay for a hundred periods.
/// Source: Newton shooting on DOP853 of SciPy with located events; equation of A. Kahraman and R. Singh, J. Sound Vib. 142 (1990) 49.
#[test]
fn ref_gear_pair_orbits() {
    let case = reference("motion_gear_pair");
    for orbit in ["up", "down"]
        .iter()
        .flat_map(|side| case["orbits"][side].as_array().unwrap())
    {
        let [omega, x, v] = ["Omega", "x0", "v0"].map(|key| orbit[key].as_f64().unwrap());
        let machine = gear_pair(omega);
        let (samples, stats) = run(&machine, &[x, v], 100.0 * TAU / omega, 100);
        for (_, y) in &samples {
            assert_near(y, &[x, v], 1e-11);
        }
        assert_eq!(
            stats.events,
            100 * orbit["side_changes_per_period"].as_u64().unwrap()
        );
    }
}

/// Stiffness in steps: Meissner's equation against products of turns, and the mean rate of growth where it is unstable.
#[test]
fn exact_rectangular_stiffness() {
    for (omega, start, duty) in [(1.7, 0.4, 0.3), (-1.7, 0.4, 0.3), (2.0, 0.0, 0.5)] {
        let mut mesh = branch(&[(0, 1.0)], play(1.0, 0.0, 0.0, ContactDamping::Adhesive));
        mesh.stiffness_wave = Some(PeriodicFunction {
            load_table: None,
            waveform: Waveform::Rectangular {
                high: 1.4,
                low: 0.6,
                duty,
            },
            phase: WavePhase::Imposed { omega, start },
        });
        let machine = train(&[1.0], vec![mesh], vec![]);
        let periods = 40;
        let (samples, _) = run(
            &machine,
            &[1.0, 0.0],
            f64::from(periods) * TAU / f64::abs(omega),
            8,
        );
        let (mut y, mut t) = ([1.0, 0.0], 0.0);
        let turn = |y: [f64; 2], k: f64, h: f64| {
            let w = k.sqrt();
            let (s, c) = (w * h).sin_cos();
            [y[0] * c + y[1] * s / w, y[1] * c - y[0] * s * w]
        };
        for (at, found) in samples {
            // by pieces, each to its end, found by the phase alone
            while t < at {
                let psi = (omega * t + start) / TAU;
                let into = (psi + 1e-12 * omega.signum()).rem_euclid(1.0);
                let k = if into < duty { 1.4 } else { 0.6 };
                let edge = match (omega > 0.0, into < duty) {
                    (true, true) => duty - into,
                    (true, false) => 1.0 - into,
                    (false, true) => into,
                    (false, false) => into - duty,
                };
                let h = ((edge + 1e-12) * TAU / omega.abs()).min(at - t);
                y = turn(y, k, h);
                t += h;
            }
            let size = 1.0 + y[0].hypot(y[1]);
            assert_near(&found, &y, 1e-9 * size);
        }
    }
}

/// Thrown up it just touches the tooth and falls back: the state does not care whether that counts.
#[test]
fn survives_an_exact_touch() {
    let mesh = branch(&[(0, 1.0)], play(100.0, 0.0, 1.0, ContactDamping::Adhesive));
    let machine = train(&[1.0], vec![mesh], vec![drive(0, Signal::constant(-1.0))]);
    for off in [-1e-9, -1e-15, -1e-16, 0.0, 1e-16, 1e-15, 1e-9] {
        let (samples, stats) = run(&machine, &[0.5 + off, 1.0], 1.9, 1);
        assert!(stats.evaluations < 300, "{stats:?}");
        assert!(stats.events == 0 || stats.events == 2, "{stats:?}");
        let slack = if off > 1e-12 { 2e-4 } else { 1e-7 };
        assert_near(&samples[1].1, &[0.595 + off, -0.9], slack);
        if off <= 0.0 {
            assert_near(&samples[1].1, &[0.595 + off, -0.9], 1e-14);
        }
    }
}

/// A chain of discs with two meshes that have play, one with stiffness in steps; damping on shafts and meshes.
fn two_meshes(seed: u64, n: usize, wave: bool) -> (DynamicModel, Vec<f64>) {
    let mut random = fastrand::Rng::with_seed(seed);
    let inertia: Vec<f64> = (0..n).map(|_| 0.5 + random.f64()).collect();
    let stiffness: Vec<f64> = (0..n).map(|_| 200.0 + 800.0 * random.f64()).collect();
    let damping: Vec<f64> = (0..n).map(|_| 0.2 + 0.5 * random.f64()).collect();
    let mut branches = chain(&inertia, &stiffness, &damping);
    let contact_damping = [
        ContactDamping::ActsInGap,
        ContactDamping::Adhesive,
        ContactDamping::NoPull,
        ContactDamping::Continuous,
    ];
    for at in [n / 4, 2 * n / 3] {
        let half = 0.002 + 0.01 * random.f64();
        branches[at].law = play(
            stiffness[at],
            2.0 * damping[at],
            half,
            contact_damping[random.usize(0..4)],
        );
    }
    if wave {
        branches[n / 2].law = play(
            stiffness[n / 2],
            damping[n / 2],
            0.0,
            ContactDamping::Adhesive,
        );
        branches[n / 2].stiffness_wave = Some(PeriodicFunction {
            load_table: None,
            waveform: Waveform::Rectangular {
                high: 1.2,
                low: 0.8,
                duty: 0.6,
            },
            phase: WavePhase::Imposed {
                omega: 8.0 * TAU,
                start: 0.0,
            },
        });
    }
    branches.push(spring(&[(n - 1, 1.0)], 50.0, 0.5));
    let drives = vec![
        drive(0, Signal::constant(0.3)),
        drive(1, Signal::harmonic(6.0, 4.0 + 8.0 * random.f64(), 0.0)),
    ];
    let mut start = vec![0.0; 2 * n];
    (0..n).for_each(|i| start[n + i] = 0.2 * (random.f64() - 0.5));
    (train(&inertia, branches, drives), start)
}

/// States at samples and the number of switches by short steps of matrix exponentials, borders looked at after every step.
fn brute_force(
    machine: &DynamicModel,
    start: &[f64],
    to: f64,
    samples: usize,
    h: f64,
) -> (Vec<Vec<f64>>, u64) {
    let n = machine.coordinate_count();
    let omega = machine.forces[1].signal.harmonics[0].omega;
    let stands_at = |y: &[f64]| machine.regime(0.0, y).states;
    let mut steps: Vec<(Vec<ElementState>, Matrix)> = Vec::new();
    let mut stands = stands_at(&start[..2 * n]);
    let mut y = [start, &[1.0, 1.0, 0.0]].concat();
    let (mut out, mut events) = (vec![start.to_vec()], 0);
    // the first border that is not above zero, and how far p is
    let worst = |stands: &[ElementState], y: &[f64]| -> Option<(usize, f64, ElementState)> {
        let mut found: Option<(usize, f64, ElementState)> = None;
        for (at, b) in machine.elements.iter().enumerate() {
            let (ForceLaw::Contact(contact), ElementState::Contact(stand, piece)) =
                (&b.law, stands[at])
            else {
                continue;
            };
            let (delta, rate) = b.deflection(0.0, &y[..n], &y[n..2 * n], b.pieces_at(0.0));
            for (border, to) in contact.switching_functions(stand, 1.0) {
                let p = border.value_at(delta, rate);
                let scale = border.deflection.abs() + border.rate.abs();
                if p < -1e-13 * scale && found.as_ref().is_none_or(|f| p / scale < f.1) {
                    found = Some((at, p / scale, ElementState::Contact(to, piece)));
                }
            }
        }
        found
    };
    let per_sample = (to / samples as f64 / h).round() as usize;
    for _ in 0..samples {
        for _ in 0..per_sample {
            let mut left = h;
            while left > 0.0 {
                let next = if left == h {
                    let known = steps.iter().position(|(s, _)| *s == stands);
                    let at = known.unwrap_or_else(|| {
                        steps.push((
                            stands.clone(),
                            by_exponential(machine, Some(&stands), omega, h),
                        ));
                        steps.len() - 1
                    });
                    apply(&steps[at].1, &y)
                } else {
                    apply(&by_exponential(machine, Some(&stands), omega, left), &y)
                };
                let Some((_, _, _)) = worst(&stands, &next) else {
                    y = next;
                    break;
                };
                // halve until the instant is known to 1e-13 s
                let (mut low, mut high) = (0.0, left);
                let mut there = next;
                while high - low > 1e-13 {
                    let middle = 0.5 * (low + high);
                    let state = apply(&by_exponential(machine, Some(&stands), omega, middle), &y);
                    if worst(&stands, &state).is_some() {
                        (high, there) = (middle, state);
                    } else {
                        low = middle;
                    }
                }
                let (at, _, to) = worst(&stands, &there).unwrap();
                stands[at] = to;
                events += 1;
                y = there;
                left -= high;
            }
        }
        out.push(y[..2 * n].to_vec());
    }
    (out, events)
}

fn compare_with_brute_force(seed: u64, n: usize, to: f64, h: f64) -> (f64, u64, u64) {
    let (machine, start) = two_meshes(seed, n, false);
    let (exact, stats) = run(&machine, &start, to, 16);
    let (brute, events) = brute_force(&machine, &start, to, 16, h);
    let mut off: f64 = 0.0;
    for ((_, a), b) in exact.iter().zip(&brute) {
        off = a.iter().zip(b).fold(off, |m, (a, b)| m.max((a - b).abs()));
    }
    (off, stats.events, events)
}

/// Twenty discs, two meshes with play, every convention, dampers that mix modes: states and number of switches.
#[test]
fn law_twenty_discs_against_brute_force() {
    // 26: two borders near each other in time
    for (seed, n, to) in [(1, 20, 2.0), (2, 20, 2.0), (3, 20, 2.0), (26, 12, 4.0)] {
        let (off, found, brute) = compare_with_brute_force(seed, n, to, 0.5f64.powi(12));
        println!("seed {seed}: off {off:.1e}, {found} switches against {brute}");
        assert_eq!(found, brute, "seed {seed}");
        assert!(found > 4 && off < 1e-8, "seed {seed}: {off:.1e}");
    }
}

#[test]
#[ignore = "study: minutes"]
fn study_many_scenes_against_brute_force() {
    let mut lost = Vec::new();
    for seed in 10..60 {
        let (off, found, brute) = compare_with_brute_force(seed, 12, 4.0, 0.5f64.powi(14));
        println!("seed {seed}: off {off:.1e}, {found} switches against {brute}");
        if found != brute || off > 1e-6 {
            lost.push(seed);
        }
    }
    assert!(lost.is_empty(), "{lost:?}");
}

/// However many samples are taken, the end is the same; and energy that leaves must be what dampers took.
#[test]
fn law_samples_do_not_matter() {
    let (machine, start) = two_meshes(7, 20, true);
    let (few, stats) = run(&machine, &start, 5.0, 7);
    let (many, again) = run(&machine, &start, 5.0, 400);
    assert_near(&few[7].1, &many[400].1, 1e-13);
    assert_eq!(stats.events, again.events);
    println!("{stats:?}");
}

/// However few machines are kept of the regimes that were met, the end is the same; where there is no room for any, nearly every switch
/// makes one anew.
#[test]
fn law_room_for_machines_does_not_matter() {
    let (machine, start) = two_meshes(7, 20, true);
    let options = ask(&start, 5.0, 1);
    let ends = [regime_cache::MAX_BYTES, 0].map(|room| {
        let mut end = Vec::new();
        let effort = run::run(&machine, &options, room, &mut |_, y, _| {
            end = y.to_vec();
            ControlFlow::Continue(())
        });
        (end, effort.unwrap())
    });
    let [(roomy, kept), (narrow, anew)] = ends;
    assert_near(&narrow, &roomy, 1e-13);
    assert_eq!(kept.events, anew.events);
    assert!(kept.regimes < 20, "{kept:?}");
    assert!(anew.regimes > anew.events / 2, "{anew:?}");
}

// dry friction

fn rubbing(force: f64) -> ForceElement {
    branch(
        &[(0, 1.0)],
        ForceLaw::Friction(FrictionLaw {
            sliding: force,
            breakaway: force,
            stribeck_velocity: 1.0,
            regularisation_velocity: 1e-3,
        }),
    )
}

/// The amplitude falls by 2F/k every half turn, until the spring no longer moves it.
#[test]
fn exact_coulomb_decay() {
    let machine = train(
        &[1.0],
        vec![spring(&[(0, 1.0)], 4.0, 0.0), rubbing(1.0)],
        vec![],
    );
    let half = FRAC_PI_2;
    let (samples, stats) = run(&machine, &[2.1, 0.0], 6.0 * half, 6);
    let exact = [2.1, -1.6, 1.1, -0.6, 0.1, 0.1, 0.1];
    for ((_, y), x) in samples.iter().zip(exact) {
        assert_near(y, &[x, 0.0], 1e-14);
    }
    assert_eq!(stats.events, 4);
}

/// A ramp of force breaks it loose at the breakaway force; a step that is too small does not.
#[test]
fn exact_breakaway() {
    let ramp = Signal::table(&[(0.0, 0.0), (10.0, 5.0)]).unwrap();
    let machine = train(&[2.0], vec![rubbing(1.0)], vec![drive(0, ramp)]);
    let (samples, stats) = run(&machine, &[0.3, 0.0], 8.0, 8);
    for (t, y) in samples {
        let over = f64::max(0.0, t - 2.0);
        assert_near(
            &y,
            &[0.3 + 0.25 * over.powi(3) / 6.0, 0.125 * over * over],
            1e-14,
        );
    }
    assert_eq!(stats.events, 1);
    println!("breakaway: {stats:?}");

    let steps = Signal::step(0.9, 1.0).plus(&Signal::step(0.6, 2.0));
    let machine = train(&[2.0], vec![rubbing(1.0)], vec![drive(0, steps)]);
    for (t, y) in run(&machine, &[0.3, 0.0], 4.0, 16).0 {
        let over = f64::max(0.0, t - 2.0);
        assert_near(&y, &[0.3 + 0.125 * over * over, 0.25 * over], 1e-14);
    }
}

/// A block on a belt that starts: it is carried, and left behind when its spring has the force.
#[test]
fn exact_block_on_a_belt() {
    let mut belt = rubbing(1.0);
    belt.imposed_displacement = Some(Signal::ramp(0.0, 20.0, [1.0, 21.0]));
    let machine = train(&[1.0], vec![spring(&[(0, 1.0)], 4.0, 0.0), belt], vec![]);
    // The belt starts at 1 m/s at t = 1: friction pulls with 1 N, x = (1 − cos 2τ)/4, which never reaches the belt's speed.
    for (t, y) in run(&machine, &[0.0, 0.0], 6.0, 12).0 {
        let tau = 2.0 * f64::max(0.0, t - 1.0);
        assert_near(&y, &[0.25 * (1.0 - tau.cos()), 0.5 * tau.sin()], 1e-14);
    }
    // At 0.3 m/s it catches up, is carried until the spring has 1 N, and swings about that.
    let mut belt = rubbing(1.0);
    belt.imposed_displacement = Some(Signal::ramp(0.0, 6.0, [1.0, 21.0]));
    let machine = train(&[1.0], vec![spring(&[(0, 1.0)], 4.0, 0.0), belt], vec![]);
    let caught = 0.5 * 0.6f64.asin();
    let place = 0.25 * (1.0 - 0.8);
    let carried = (0.25 - place) / 0.3;
    let (samples, stats) = run(&machine, &[0.0, 0.0], 1.0 + caught + carried + 0.4, 1);
    let x = 0.25 + 0.15 * (0.8f64).sin();
    assert_near(&samples[1].1, &[x, 0.3 * (0.8f64).cos()], 1e-13);
    println!("belt: {stats:?}");
}

/// Two discs that stick to each other turn as one, and the spring behind them knows it.
#[test]
fn exact_two_stick_together() {
    let clutch = ForceElement {
        direction: Direction::new(1.0, [(0, -1.0), (1, 1.0)]),
        ..rubbing(10.0)
    };
    let machine = train(
        &[1.0, 3.0],
        vec![spring(&[(0, 1.0)], 16.0, 0.0), clutch],
        vec![],
    );
    for (t, y) in run(&machine, &[0.5, 0.2, 0.0, 0.0], 5.0, 10).0 {
        let (x, v) = (0.5 * (2.0 * t).cos(), -(2.0 * t).sin());
        assert_near(&y, &[x, x - 0.3, v, v], 2e-14);
    }
}

// refusals

#[test]
fn refuses_more_than_the_budget() {
    let machine = gear_pair(0.85);
    let mut options = ask(&[0.841, 0.0987], 1e4, 1);
    options.max_work = 1000;
    let error = try_run("switched", &machine, &options).unwrap_err();
    assert_eq!(error.code, Code::BudgetExceeded);
    assert!(
        error.message.contains("branch of") && error.message.contains("switched most"),
        "{error}"
    );
}

#[test]
fn refuses_what_is_not_linear() {
    let exact = methods::method_by_name("exact").unwrap();
    assert!((exact.unsupported_reason)(&gear_pair(1.0)).is_some());
    let power = branch(
        &[(0, 1.0)],
        ForceLaw::Nonlinear {
            characteristic: Characteristic::Power {
                factor: 1.0,
                exponent: 1.5,
                rated: 1.0,
            },
            damping: 0.0,
        },
    );
    let machine = train(&[1.0], vec![power], vec![]);
    assert!(
        (methods::method_by_name("switched")
            .unwrap()
            .unsupported_reason)(&machine)
        .is_some()
    );
}

/// The caller may end a run early.
#[test]
fn survives_a_break() {
    let machine = gear_pair(0.85);
    let method = methods::method_by_name("switched").unwrap();
    let mut seen = 0;
    let effort = (method.run)(
        &machine,
        &ask(&[0.841, 0.0987], 100.0, 50),
        &mut |_, _, _| {
            seen += 1;
            if seen == 3 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        },
    );
    assert!(seen == 3 && effort.is_ok());
}

/// A spring so stiff, or a time so long, that no phase is left is refused at once; so is a pace that would never end.
#[test]
fn refuses_hopeless_motion() {
    let refused = |method: &str, model: &DynamicModel, to: f64| {
        let mut start = vec![0.0; model.len()];
        start[0] = 1e-3;
        let mut options = ask(&start, to, 2);
        options.step_size = StepSize::Adaptive(1e-8);
        options.max_work = 400_000_000;
        try_run(method, model, &options).unwrap_err().code
    };
    let stiff = train(&[1.0, 1.0], chain(&[1.0, 1.0], &[1e300], &[0.0]), vec![]);
    assert_eq!(refused("exact", &stiff, 1.0), Code::BudgetExceeded);
    let plain = train(&[1.0, 2.0], chain(&[1.0, 2.0], &[100.0], &[0.0]), vec![]);
    assert_eq!(refused("exact", &plain, 1e14), Code::BudgetExceeded);
    assert_eq!(refused("dop853-events", &plain, 1e12), Code::BudgetExceeded);
    let rattle = branch(
        &[(0, 1.0)],
        play(100.0, 0.1, 1e-3, ContactDamping::ActsInGap),
    );
    let push = drive(0, Signal::harmonic(1.0, 9.0, 0.0));
    let driven = train(&[1.0], vec![rattle], vec![push]);
    assert_eq!(refused("switched", &driven, 1e13), Code::BudgetExceeded);
}
