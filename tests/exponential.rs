//! The exponential integrator: what is linear exact whatever the step, what is not by its order; where it needs fewer evaluations.

mod support;

use geardyn::machine::characteristic::Characteristic;
use geardyn::motion::contact::Losses;
use geardyn::motion::problem::Wanted;
use geardyn::motion::signal::Signal;
use geardyn::motion::train::{Law, Train};
use support::moving::{apart, branch, contact, inertias, push, run, run_with, spring};

/// A light and stiff chain, its last disc held by a soft spring that hardens.
fn stiff(damping: f64) -> Train {
    let mut train = inertias(&[1.0, 1e-2, 0.5, 1e-2, 2.0]);
    for (i, k) in [1e5, 1e4, 3e5, 1e3].into_iter().enumerate() {
        let law = spring(k, damping * k);
        train
            .branches
            .push(branch(&format!("s{i}"), &[(i, -1.0), (i + 1, 1.0)], law));
    }
    let hard = Law::Nonlinear {
        characteristic: Characteristic::Power {
            factor: 40.0,
            exponent: 3.0,
            rated: 1.0,
        },
        damping: 0.02,
    };
    train.branches.push(branch("hard", &[(4, 1.0)], hard));
    train
        .branches
        .push(branch("soft", &[(4, 1.0)], spring(5.0, 0.0)));
    train.drives.push(push(0, Signal::harmonic(3.0, 2.0, 0.3)));
    train
}

/// Free, pushed steadily and damped in proportion it is exact in one step over many periods.
#[test]
fn exact_linear_in_one_step() {
    let mut train = stiff(1e-6);
    train
        .branches
        .retain(|b| !matches!(b.law, Law::Nonlinear { .. }));
    train.branches.last_mut().unwrap().law = spring(5.0, 5e-6);
    train.drives = vec![push(0, Signal::constant(2.0))];
    let start = [0.1, -0.2, 0.0, 0.05, 0.3, 0.0, 1.0, 0.0, 0.0, -1.0];
    let (_, exact, _) = run("exact", &train, &start, 0.5, 40).unwrap();
    let (_, found, effort) =
        run_with("etdrk4", &train, &start, 0.5, 40, Wanted::Step(1.0)).unwrap();
    assert_eq!(effort.steps, 1);
    let gap = apart(&found, &exact);
    assert!(gap < 1e-9, "{gap:e}");
}

/// Stiff and not linear: the same motion as of the explicit method, with far fewer evaluations.
#[test]
fn law_stiff_chain_with_a_hard_spring() {
    for damping in [0.0, 1e-5] {
        let train = stiff(damping);
        let mut start = vec![0.2; 5];
        start.extend([0.0; 5]);
        let by = |name: &str, tolerance: f64| {
            run_with(name, &train, &start, 1.0, 50, Wanted::Tolerance(tolerance)).unwrap()
        };
        let (_, exact, _) = by("dop853-events", 1e-13);
        let (_, found, effort) = by("etdrk4", 1e-10);
        let (_, other, explicit) = by("dop853-events", 1e-9);
        let (_, third, implicit) = by("radau5", 1e-8);
        let places = |s: &[Vec<f64>]| s.iter().map(|y| y[..5].to_vec()).collect::<Vec<_>>();
        let gap = |s: &[Vec<f64>]| apart(&places(s), &places(&exact));
        eprintln!(
            "damping {damping}: etdrk4 {:.1e} with {} evaluations; dop853-events {:.1e}, {}; radau5 {:.1e}, {} and {} factorisations",
            gap(&found),
            effort.evaluations,
            gap(&other),
            explicit.evaluations,
            gap(&third),
            implicit.evaluations,
            implicit.factorisations
        );
        assert!(gap(&found) < 1e-7, "{:e}", gap(&found));
        assert!(10 * effort.evaluations < explicit.evaluations);
    }
}

/// Switches are located: a disc that rattles in its play, against the method that is exact between them.
#[test]
fn law_switches_are_located() {
    let mut train = inertias(&[1.0]);
    train.branches.push(branch(
        "play",
        &[(0, 1.0)],
        contact(100.0, 0.4, 0.02, Losses::NoPull),
    ));
    train.drives.push(push(0, Signal::harmonic(3.0, 4.0, 0.0)));
    let (_, exact, events) = run("switched", &train, &[0.05, 0.0], 10.0, 60).unwrap();
    let (_, found, effort) = run("etdrk4", &train, &[0.05, 0.0], 10.0, 60).unwrap();
    assert!(events.events > 10 && effort.events == events.events);
    let gap = apart(&found, &exact);
    assert!(gap < 1e-8, "{gap:e}");
}

/// The error follows the tolerance.
#[test]
fn law_error_follows_the_tolerance() {
    let train = stiff(1e-6);
    let start = [0.2, 0.2, 0.2, 0.2, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (_, exact, _) = run("etdrk4", &train, &start, 2.0, 20).unwrap();
    let error = |tolerance: f64| {
        let (_, found, _) = run_with(
            "etdrk4",
            &train,
            &start,
            2.0,
            20,
            Wanted::Tolerance(tolerance),
        )
        .unwrap();
        let places = |s: &[Vec<f64>]| s.iter().map(|y| y[..5].to_vec()).collect::<Vec<_>>();
        apart(&places(&found), &places(&exact))
    };
    let errors = [1e-4, 1e-6, 1e-8].map(error);
    eprintln!("{errors:?}");
    assert!(
        errors[0] < 1e-2 && errors[1] < 1e-4 && errors[2] < 1e-6,
        "{errors:?}"
    );
    assert!(errors[2] < 0.1 * errors[1] && errors[1] < 0.1 * errors[0]);
}
