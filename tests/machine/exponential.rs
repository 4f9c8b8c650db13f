//! The exponential method: its kernels, its order where the linear part is stiff, what it costs beside others, its extremes.

use crate::support::moving::{apart, branch, contact, inertias, push, run, run_with, spring};
use crate::support::verification::{order, within};
use geardyn::internals::machine::characteristic::Characteristic;
use geardyn::internals::motion::contact::ContactDamping;
use geardyn::internals::motion::dynamic_model::{DynamicModel, ForceLaw};
use geardyn::internals::motion::methods::{self, exponential::PhiKernel};
use geardyn::internals::motion::problem::StepSize;
use geardyn::internals::motion::signal::Signal;

/// `K δ³`.
fn cube(factor: f64) -> ForceLaw {
    let characteristic = Characteristic::Power {
        factor,
        exponent: 3.0,
        rated: 1.0,
    };
    ForceLaw::Nonlinear {
        characteristic,
        damping: 0.0,
    }
}

/// `ṡ + d s + ω² ∫s = 1` and its integrals hold from every branch of the kernels, and s is what it must be.
#[test]
fn exact_kernels() {
    for (square, damping, tau) in [
        (1.0, 0.0, 0.1),
        (1.0, 0.0, 0.9999999),
        (1.0, 0.0, 1.0000001),
        (100.0, 0.1, 3.0),
        (0.0, 0.0, 2.0),
        (0.0, 5.0, 3.0),
        (1e-3, 50.0, 1.0),
        (25.0, 10.0, 1.0),
        (4.0, 10.0, 2.0),
        (-4.0, 1.0, 1.5),
        (1e12, 0.0, 1.0),
    ] {
        let PhiKernel {
            rate,
            integrals: [s, first, second, third],
        } = PhiKernel::new((square, damping), tau);
        let near = |sum: f64, exact: f64, size: f64| {
            let off = (sum - exact).abs();
            within("kernels", off / size.max(exact.abs()), 1e-13);
        };
        let size = |x: f64, y: f64, z: f64| x.abs() + (damping * y).abs() + (square * z).abs();
        near(
            rate + damping * s + square * first,
            1.0,
            size(rate, s, first),
        );
        near(
            s + damping * first + square * second,
            tau,
            size(s, first, second),
        );
        near(
            first + damping * second + square * third,
            0.5 * tau * tau,
            size(first, second, third),
        );
        let swing: f64 = square - 0.25 * damping * damping;
        let shape = match swing {
            x if x > 0.0 => (x.sqrt() * tau).sin() / x.sqrt(),
            x if x < 0.0 => ((-x).sqrt() * tau).sinh() / (-x).sqrt(),
            _ => tau,
        };
        let exact = (-0.5 * damping * tau).exp() * shape;
        let of_phase = 1e-13 + 4.0 * f64::EPSILON * swing.abs().sqrt() * tau;
        assert!(
            (s - exact).abs() <= of_phase * exact.abs().max(square.abs().sqrt().recip().min(tau)),
            "{square} {damping} {tau}: {s} {exact}"
        );
    }
}

/// Of a linear machine the stages see no difference whatever the torque does: the tolerance still holds the error.
#[test]
fn law_tolerance_holds_linear_machines() {
    let mut model = inertias(&[1.0, 0.5, 2.0]);
    for (a, b, k) in [(0, 1, 3e4), (1, 2, 1e4)] {
        model
            .elements
            .push(branch("shaft", &[(a, -1.0), (b, 1.0)], spring(k, 0.5)));
    }
    model
        .forces
        .push(push(2, Signal::harmonic(10.0, 345.0, 0.3)));
    let start = [0.0; 6];
    let (_, exact, _) = run("exact", &model, &start, 1.0, 40).unwrap();
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let size = StepSize::Adaptive(tolerance);
        let (_, found, effort) = run_with("exponential", &model, &start, 1.0, 40, size).unwrap();
        let error = apart(&found, &exact);
        eprintln!("{tolerance}: {error:e}, {effort:?}");
        assert!(error < 30.0 * tolerance, "{tolerance}: {error:e}");
    }
}

/// A linear chain, free to turn, under a steady torque is exact in one step, however long.
#[test]
fn exact_linear_in_one_step() {
    let mut model = inertias(&[1.0, 1e-2, 2.0]);
    model
        .elements
        .push(branch("a", &[(0, -1.0), (1, 1.0)], spring(1e5, 0.01)));
    model
        .elements
        .push(branch("b", &[(1, -1.0), (2, 1.0)], spring(1e3, 1e-4)));
    model.forces.push(push(0, Signal::constant(2.0)));
    let start = [0.1, -0.2, 0.0, 1.0, 0.0, -1.0];
    let (_, exact, _) = run("exact", &model, &start, 20.0, 40).unwrap();
    let (_, found, effort) = run_with(
        "exponential",
        &model,
        &start,
        20.0,
        40,
        StepSize::Fixed(20.0),
    )
    .unwrap();
    assert_eq!(effort.steps, 1);
    within("states", apart(&found, &exact), 1e-9);
}

/// Two discs on a stiff shaft, the second on a cubic spring; where the fast swing stands as its load asks, and at the rest.
fn pair(stiffness: f64) -> (DynamicModel, [f64; 4]) {
    let mut model = inertias(&[1.0, 1.0]);
    model.elements.push(branch(
        "stiff",
        &[(0, -1.0), (1, 1.0)],
        spring(stiffness, 0.0),
    ));
    model
        .elements
        .push(branch("soft", &[(0, 1.0)], spring(5.0, 0.0)));
    model.elements.push(branch("cube", &[(1, 1.0)], cube(40.0)));
    let load = Signal::harmonic(3.0, 2.0, 0.3);
    model.forces.push(push(0, load));
    // Both accelerate alike where the shaft carries half the difference of what acts on them; its rate changes as that does.
    let carried =
        |t: f64| 0.5 * (-40.0 * 0.2f64.powi(3) - (3.0 * (2.0 * t + 0.3).cos() - 5.0 * 0.2));
    let twist = carried(0.0) / stiffness;
    let rate = (carried(1e-5) - carried(-1e-5)) / 2e-5 / stiffness;
    (
        model,
        [
            0.2 - 0.5 * twist,
            0.2 + 0.5 * twist,
            -0.5 * rate,
            0.5 * rate,
        ],
    )
}

/// Order 4 with steps of 25 to 200 radians of the fast swing: stiffness takes none of it away where the motion is smooth.
#[test]
fn order_is_kept_where_it_is_stiff() {
    let (model, start) = pair(1e6);
    let (_, exact, _) = run("dop853-events", &model, &start, 1.0, 1).unwrap();
    let error = |step: f64| {
        let (_, found, _) =
            run_with("exponential", &model, &start, 1.0, 1, StepSize::Fixed(step)).unwrap();
        (found[1][1] - exact[1][1]).abs()
    };
    let errors = [0.1, 0.05, 0.025].map(error);
    let orders = [0, 1].map(|k| (errors[k] / errors[k + 1]).log2());
    eprintln!("errors {errors:?}");
    assert!((orders[0] - 4.0).abs() < 0.3, "{orders:?}");
    order("exponential, stiff shaft", 4.0, orders[1]);
}

/// What it costs beside the others: far fewer evaluations than explicit steps on a stiff shaft whose fast swing is not excited.
#[test]
fn law_pays_where_it_is_stiff_and_smooth() {
    let (model, smooth) = pair(1e6);
    let (_, exact, _) = run("dop853-events", &model, &smooth, 1.0, 20).unwrap();
    let cost = |method: &str, tolerance: f64| {
        let effort = StepSize::Adaptive(tolerance);
        let (_, found, effort) = run_with(method, &model, &smooth, 1.0, 20, effort).unwrap();
        let gap = apart(
            &found.iter().map(|y| y[..2].to_vec()).collect::<Vec<_>>(),
            &exact.iter().map(|y| y[..2].to_vec()).collect::<Vec<_>>(),
        );
        eprintln!(
            "{method} {tolerance:e}: {gap:.1e}, {} evaluations, {} factorisations",
            effort.evaluations, effort.factorisations
        );
        (gap, effort.evaluations)
    };
    let (gap, ours) = cost("exponential", 1e-7);
    let (explicit_gap, explicit) = cost("dop853-events", 1e-6);
    cost("radau5", 1e-7);
    assert!(
        gap < 1e-6 && explicit_gap < 1e-4,
        "{gap:e} {explicit_gap:e}"
    );
    assert!(10 * ours < explicit, "{ours} {explicit}");
}

/// The error follows the tolerance.
#[test]
fn law_error_follows_the_tolerance() {
    let (model, start) = pair(100.0);
    let (_, exact, _) = run("dop853-events", &model, &start, 3.0, 20).unwrap();
    let error = |tolerance: f64| {
        let effort = StepSize::Adaptive(tolerance);
        let (_, found, _) = run_with("exponential", &model, &start, 3.0, 20, effort).unwrap();
        apart(&found, &exact)
    };
    let errors = [1e-4, 1e-6, 1e-8].map(error);
    eprintln!("{errors:?}");
    assert!(
        errors[0] < 1e-2 && errors[1] < 1e-4 && errors[2] < 1e-6,
        "{errors:?}"
    );
    assert!(errors[2] < 0.1 * errors[1] && errors[1] < 0.1 * errors[0]);
}

/// A torque that turns seven times between two outputs of a linear machine: no step goes over it unseen.
#[test]
fn law_fast_drives_are_followed() {
    let mut model = inertias(&[1.0, 2.0]);
    let joint = spring(100.0, 0.1);
    model
        .elements
        .push(branch("s", &[(0, -1.0), (1, 1.0)], joint));
    model
        .elements
        .push(branch("held", &[(0, 1.0)], spring(50.0, 0.0)));
    model
        .forces
        .push(push(1, Signal::harmonic(1.0, 350.0, 0.3)));
    let (_, exact, _) = run("exact", &model, &[0.0; 4], 2.0, 16).unwrap();
    for tolerance in [1e-4, 1e-8] {
        let effort = StepSize::Adaptive(tolerance);
        let (_, found, _) = run_with("exponential", &model, &[0.0; 4], 2.0, 16, effort).unwrap();
        let off = apart(&found, &exact);
        println!("{tolerance}: {off}");
        assert!(off < 1e3 * tolerance, "{tolerance}: {off}");
    }
}

/// Stiffness × 1e12, none at all, dampers far overcritical, inertia of 1e-12 with a damper and without: near what radau5 says of the
/// slow motion.
#[test]
fn survives_extremes() {
    let build = |inertia: f64, k: f64, c: f64| {
        let mut model = inertias(&[1.0, inertia]);
        model
            .elements
            .push(branch("s", &[(0, -1.0), (1, 1.0)], spring(k, c)));
        model.elements.push(branch("cube", &[(0, 1.0)], cube(3.0)));
        model.forces.push(push(0, Signal::harmonic(1.0, 2.0, 0.0)));
        model
    };
    for (inertia, k, c, to, slow) in [
        (1.0, 1e12, 0.0, 1.0, (1.0, 1e4)),
        (1.0, 0.0, 0.0, 1.0, (1.0, 0.0)),
        (1.0, 1.0, 1e6, 0.1, (1.0, 1e4)),
        (1e-12, 100.0, 0.0, 1e-3, (1e-6, 100.0)),
        (1e-12, 100.0, 1.0, 1e-3, (1e-6, 100.0)),
    ] {
        let by = |method: &str, model: &DynamicModel| {
            run_with(
                method,
                model,
                &[0.1, 0.1, 0.0, 0.0],
                to,
                10,
                StepSize::Adaptive(1e-6),
            )
            .unwrap()
            .1
        };
        let found = by("exponential", &build(inertia, k, c));
        let other = by("radau5", &build(slow.0, slow.1, c));
        for (y, x) in found.iter().zip(&other) {
            assert!(y.iter().all(|y| y.is_finite()));
            assert!((y[0] - x[0]).abs() < 2e-3, "{inertia} {k} {c}: {y:?} {x:?}");
        }
    }
}

/// Without losses the energy of a hardening swing stays.
#[test]
fn law_energy_stays() {
    let mut model = inertias(&[1.0, 2.0]);
    model
        .elements
        .push(branch("s", &[(0, -1.0), (1, 1.0)], spring(1e4, 0.0)));
    model.elements.push(branch("cube", &[(0, 1.0)], cube(3.0)));
    let (_, states, _) = run_with(
        "exponential",
        &model,
        &[0.5, 0.5, 0.0, 0.0],
        10.0,
        50,
        StepSize::Adaptive(1e-8),
    )
    .unwrap();
    let energy = |y: &Vec<f64>| {
        0.5 * (y[2] * y[2] + 2.0 * y[3] * y[3])
            + 0.5e4 * (y[1] - y[0]).powi(2)
            + 0.75 * y[0].powi(4)
    };
    let first = energy(&states[0]);
    for y in &states {
        assert!(
            (energy(y) / first - 1.0).abs() < 1e-5,
            "{}",
            energy(y) / first - 1.0
        );
    }
}

#[test]
fn refuses_inner_states_and_switches() {
    let refuses = methods::method_by_name("exponential")
        .unwrap()
        .unsupported_reason;
    let mut model = inertias(&[1.0]);
    assert!(refuses(&model).is_none());
    let law = ForceLaw::Maxwell {
        stiffness: 1.0,
        damping: 1.0,
    };
    model.elements.push(branch("b", &[(0, 1.0)], law));
    assert!(refuses(&model).unwrap().contains("inner state"));
    model.elements[0].law = contact(1.0, 0.0, 0.1, ContactDamping::Adhesive);
    assert!(refuses(&model).unwrap().contains("switch"));
    let light = inertias(&[1.0, 0.0]);
    assert!(refuses(&light).unwrap().contains("no inertia"));
}
