//! Periodic motions over speed: the gear pair with play and its folds, parametric resonance, friction, powers.
#![allow(
    clippy::unwrap_used,
    reason = "a helper of tests may fail as a test does"
)]

mod support;

use geardyn::motion::contact::Losses;
use geardyn::motion::floquet::orbit::orbit;
use geardyn::motion::outputs::{Output, Outputs, Quantity};
use geardyn::motion::signal::Signal;
use geardyn::motion::train::Train;
use geardyn::response::harmonic::curve::{Course, Curve, TOLERANCE, follow};
use geardyn::response::harmonic::family::Family;
use geardyn::response::harmonic::point::{Asked, Found};
use geardyn::response::harmonic::special::Kind;
use support::moving::{branch, contact, cosine, inertias, push, wave};
use support::{number, numbers, reference};

/// Case S1 and its like: `δ″ + 2ζ δ′ + (1 + ε cos Ωt) g(δ) = Fm − e″`, e = Fah cos Ωt, on a free pair of inertias 2.
fn pair(set: &str) -> Train {
    let all = reference("floquet");
    let of = |key: &str| number(&all["sets"][set][key]);
    let mut train = inertias(&[2.0, 2.0]);
    let law = contact(1.0, 2.0 * of("zeta"), 1.0, Losses::Throughout);
    let mut mesh = branch("mesh", &[(0, 1.0), (1, -1.0)], law);
    mesh.variation = wave(cosine(of("eps")), 1.0, 0.0);
    mesh.imposed = Some(Signal::harmonic(of("Fah"), 1.0, 0.0));
    train.branches.push(mesh);
    train.drives.push(push(0, Signal::constant(of("Fm"))));
    train.drives.push(push(1, Signal::constant(-of("Fm"))));
    train
}

/// The deflection of the first branch.
fn deflection() -> Outputs {
    Outputs {
        list: vec![Output {
            name: "mesh.deflection".into(),
            quantity: Quantity::Deflection(0),
            unit: "m",
        }],
        rows: Vec::new(),
    }
}

fn course(from: f64, to: f64, step: f64) -> Course {
    Course {
        from,
        to,
        step,
        tolerance: TOLERANCE,
        orders: None,
        most: 2000,
    }
}

fn curve(family: &Family, course: Course, events: bool) -> Curve {
    let outputs = deflection();
    let asked = Asked {
        outputs: &outputs,
        events,
    };
    follow(family, asked, course, &mut |_| {}).unwrap()
}

/// The two folds of the gear pair with play, good to 5e-6 in the reference; and its orbits.
#[test]
fn ref_folds_and_orbits_of_the_gear_pair() {
    let all = reference("floquet");
    let family = Family::new(&pair("S1"), &[0.0, 0.0]).unwrap();
    let start = std::time::Instant::now();
    let found = curve(&family, course(0.4, 1.5, 0.05), true);
    println!("{} points in {:?}", found.points.len(), start.elapsed());
    for p in &found.points {
        println!(
            "{:.6} {:.6} K={} {:.1e} {:?} {} {:.4?}",
            p.omega,
            p.outputs[0].amplitude(),
            p.orders,
            p.left_out,
            p.found,
            p.unstable(),
            p.multipliers
        );
    }
    for s in &found.specials {
        println!("{:?} {} {:?}", s.kind, s.point.omega, s.point.found);
    }
    assert!(found.ended.is_none());
    let folds: Vec<f64> = found.specials.iter().map(|s| s.point.omega).collect();
    assert!(found.specials.iter().all(|s| s.kind == Kind::Fold));
    assert_eq!(folds.len(), 2);
    for (fold, expected) in folds.iter().zip(numbers(&all["folds_S1"])) {
        assert!((fold - expected).abs() < 2e-5, "{fold} for {expected}");
    }
}
