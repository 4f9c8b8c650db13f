//! Periodic motions over speed: the gear pair with play and its folds, parametric resonance, friction, powers.

use std::f64::consts::TAU;

use crate::support::moving::{apart, branch, brute, contact, cosine, inertias, push, spring, wave};
use crate::support::{number, numbers, reference, within};
use geardyn::internals::base::code::Code;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::machine::characteristic::Characteristic;
use geardyn::internals::motion::contact::ContactDamping;
use geardyn::internals::motion::dynamic_model::{DynamicModel, ForceLaw};
use geardyn::internals::motion::floquet::orbit::find_orbit;
use geardyn::internals::motion::floquet::stability_chart::instability_tongues;
use geardyn::internals::motion::friction::FrictionLaw;
use geardyn::internals::motion::methods;
use geardyn::internals::motion::outputs::{MotionOutput, MotionOutputs, OutputQuantity};
use geardyn::internals::motion::problem::{IntegrationOptions, Observer, StepSize};
use geardyn::internals::motion::regime::Regime;
use geardyn::internals::motion::signal::Signal;
use geardyn::internals::response::harmonic_balance::bifurcation::BifurcationKind;
use geardyn::internals::response::harmonic_balance::curve::{
    ContinuationOptions, DEFAULT_TOLERANCE, SolutionCurve, continue_curve,
};
use geardyn::internals::response::harmonic_balance::family::SpeedFamily;
use geardyn::internals::response::harmonic_balance::point::{PointOptions, Refinement};

/// Case S1 and its like: `δ″ + 2ζ δ′ + (1 + ε cos Ωt) g(δ) = Fm − e″`, e = Fah cos Ωt, on a free pair of inertias 2.
fn pair(set: &str) -> DynamicModel {
    let all = reference("floquet");
    let of = |key: &str| number(&all["sets"][set][key]);
    let mut model = inertias(&[2.0, 2.0]);
    let law = contact(1.0, 2.0 * of("zeta"), 1.0, ContactDamping::ActsInGap);
    let mut mesh = branch("mesh", &[(0, 1.0), (1, -1.0)], law);
    mesh.stiffness_wave = wave(cosine(of("eps")), 1.0, 0.0);
    mesh.imposed_displacement = Some(Signal::harmonic(of("Fah"), 1.0, 0.0));
    model.elements.push(mesh);
    model.forces.push(push(0, Signal::constant(of("Fm"))));
    model.forces.push(push(1, Signal::constant(-of("Fm"))));
    model
}

/// The deflection of the first branch.
fn deflection() -> MotionOutputs {
    MotionOutputs {
        list: vec![MotionOutput {
            name: "mesh.deflection".into(),
            quantity: OutputQuantity::Deflection(0),
            unit: "m",
        }],
        ..MotionOutputs::default()
    }
}

fn course(from: f64, to: f64, step: f64) -> ContinuationOptions {
    ContinuationOptions {
        from,
        to,
        step,
        tolerance: DEFAULT_TOLERANCE,
        orders: None,
        max_points: 2000,
    }
}

fn curve(family: &SpeedFamily, course: ContinuationOptions, events: bool) -> SolutionCurve {
    let outputs = deflection();
    let options = PointOptions {
        outputs: &outputs,
        events,
    };
    continue_curve(family, options, course, &mut |_| {}).unwrap()
}

/// The two folds of the gear pair with play, good to 5e-6 in the reference; and its stable orbits, from the nearest point of the
/// curve.
/// Source: Newton shooting on DOP853 of SciPy with located events; equation of A. Kahraman and R. Singh, J. Sound Vib. 142 (1990) 49.
#[test]
fn ref_folds_and_orbits_of_the_gear_pair() {
    let all = reference("floquet");
    let family = SpeedFamily::new(&pair("S1"), &[0.0, 0.0]).unwrap();
    let found = curve(
        &family,
        ContinuationOptions {
            tolerance: 1e-5,
            ..course(0.6, 1.2, 0.06)
        },
        true,
    );
    assert!(found.stopped_by.is_none());
    assert!(
        found
            .points
            .iter()
            .all(|p| p.refinement == Refinement::Shooting)
    );
    let folds: Vec<f64> = found.bifurcations.iter().map(|s| s.point.omega).collect();
    assert!(
        found
            .bifurcations
            .iter()
            .all(|s| s.kind == BifurcationKind::Fold)
    );
    assert_eq!(folds.len(), 2);
    for (fold, expected) in folds.iter().zip(numbers(&all["folds_S1"])) {
        within("speeds of folds", (fold - expected).abs(), 2e-5);
    }
    let mut compared = 0;
    for row in all["orbits"].as_array().unwrap() {
        let [omega, x, v, largest] = [1, 2, 3, 4].map(|i| number(&row[i]));
        if row[0].as_str() != Some("S1") || !(0.62..1.18).contains(&omega) {
            continue;
        }
        let model = family.relative_at(omega);
        let stable = found.points.windows(2).filter(|pair| {
            let spans = (pair[0].omega - omega) * (pair[1].omega - omega) <= 0.0;
            spans && pair.iter().all(|p| p.unstable_count() == 0)
        });
        let off = stable.filter_map(|pair| {
            let found = find_orbit(&model, &pair[0].start, 1).ok()?;
            let (q, v0) = found.start.split_at(1);
            let (delta, rate) =
                model.elements[0].deflection(0.0, q, v0, model.elements[0].pieces_at(0.0));
            let multiplier = found.multipliers[0].norm() - largest;
            Some(((delta - x).abs().max((rate - v).abs()), multiplier.abs()))
        });
        let (state, multiplier) = off.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        within("states", state, 1e-8);
        within("multipliers", multiplier, 1e-6);
        compared += 1;
    }
    assert!(compared > 15, "{compared}");
}

/// With one order the folds come out where the describing function has them, and that is not where they are.
/// Source: describing function of play, evaluated by mpmath.
#[test]
fn ref_folds_of_one_order() {
    let family = SpeedFamily::new(&pair("S1"), &[0.0, 0.0]).unwrap();
    let one = ContinuationOptions {
        orders: Some(1),
        ..course(0.6, 1.0, 0.03)
    };
    let found = curve(&family, one, false);
    let folds: Vec<f64> = found
        .bifurcations
        .iter()
        .filter(|s| s.kind == BifurcationKind::Fold)
        .map(|s| s.point.omega)
        .collect();
    assert_eq!(folds.len(), 2, "{folds:?}");
    for (fold, expected) in folds.iter().zip([0.826070049838, 0.68013692186]) {
        within("speeds of folds", (fold - expected).abs(), 1e-5);
    }
}

/// Orders alone, at places of the curve that the steps choose, against shooting with every switch located.
#[test]
fn law_orders_agree_with_events() {
    for set in ["S1", "S2"] {
        let family = SpeedFamily::new(&pair(set), &[0.0, 0.0]).unwrap();
        let many = ContinuationOptions {
            orders: Some(80),
            ..course(1.13, 0.74, 0.13)
        };
        let found = curve(&family, many, false);
        let mut worst = 0.0f64;
        let mut lost = 0;
        for p in found.points.iter().filter(|p| p.unstable_count() == 0) {
            let exact = find_orbit(&family.relative_at(p.omega), &p.start, 1).unwrap();
            lost += exact.events;
            let apart = p.start.iter().zip(&exact.start).map(|(a, b)| (a - b).abs());
            worst = worst.max(apart.fold(0.0, f64::max));
            // The multipliers of 512 exponentials are good to the square of a step.
            let off = p.multipliers[0].norm() - exact.multipliers[0].norm();
            assert!(off.abs() < 1e-3, "{}: {off:.1e}", p.omega);
        }
        println!(
            "{set}: {} motions, {lost} switches, apart {worst:.1e}",
            found.points.len()
        );
        assert!(lost > 8 || set == "S2");
        assert!(worst < 1e-6, "{set}: {worst:.1e}");
    }
}

/// A stiffness that varies doubles the period at the edges of its first tongue.
#[test]
fn law_period_doubles_at_the_edges_of_the_tongue() {
    let family = SpeedFamily::new(&pair("S3"), &[0.0, 0.0]).unwrap();
    let expected = instability_tongues(
        &family.relative.model,
        [1.7, 2.3],
        60,
        &CancelToken::default(),
    )
    .unwrap();
    let [tongue] = &expected[..] else {
        unreachable!("{expected:?}")
    };
    let found = curve(&family, course(1.75, 2.25, 0.06), true);
    let kinds: Vec<BifurcationKind> = found.bifurcations.iter().map(|s| s.kind).collect();
    assert_eq!(kinds, [BifurcationKind::PeriodDoubling; 2]);
    for (special, edge) in found.bifurcations.iter().zip([tongue.from, tongue.to]) {
        let off = special.point.omega / edge - 1.0;
        assert!(off.abs() < 1e-5, "{} for {edge}", special.point.omega);
    }
}

/// A resonance of the sum of two modes: a pair of multipliers leaves the circle.
#[test]
fn law_pair_leaves_the_circle_at_a_sum_of_modes() {
    let mut model = inertias(&[1.0, 1.0]);
    let law = contact(1.0, 0.0, 0.0, ContactDamping::Adhesive);
    let mut mesh = branch("mesh", &[(0, 1.0), (1, 1.0)], law);
    mesh.stiffness_wave = wave(cosine(0.6), 1.0, 0.0);
    model.elements.push(mesh);
    model
        .elements
        .push(branch("a", &[(0, 1.0)], spring(1.0, 0.01)));
    model
        .elements
        .push(branch("b", &[(1, 1.0)], spring(8.0, 0.01)));
    model.forces.push(push(0, Signal::constant(0.1)));
    let family = SpeedFamily::new(&model, &[0.0, 0.0]).unwrap();
    let charted = instability_tongues(
        &family.relative.model,
        [3.8, 5.0],
        60,
        &CancelToken::default(),
    )
    .unwrap();
    let tongue = charted.iter().find(|t| t.name == "ω1 + ω2").unwrap();
    let found = curve(
        &family,
        course(0.98 * tongue.from, 1.02 * tongue.to, 0.04),
        true,
    );
    let kinds: Vec<BifurcationKind> = found.bifurcations.iter().map(|s| s.kind).collect();
    assert_eq!(kinds, [BifurcationKind::NeimarkSacker; 2]);
    for (special, edge) in found.bifurcations.iter().zip([tongue.from, tongue.to]) {
        let off = special.point.omega / edge - 1.0;
        assert!(off.abs() < 1e-5, "{} for {edge}", special.point.omega);
    }
}

/// Dry friction over its creep speed, a Hertzian contact and a spring behind a damper against integration until it is steady.
#[test]
fn law_smooth_laws_agree_with_integration() {
    let friction = FrictionLaw {
        sliding: 0.1,
        breakaway: 0.13,
        stribeck_velocity: 0.2,
        regularisation_velocity: 0.05,
    };
    let laws = [
        ("friction", ForceLaw::Friction(friction), 0.0),
        (
            "power",
            ForceLaw::Nonlinear {
                characteristic: Characteristic::Power {
                    factor: 1.0,
                    exponent: 1.5,
                    rated: 1.0,
                },
                damping: 0.05,
            },
            1.0,
        ),
    ];
    for (name, law, mean) in laws {
        let mut model = inertias(&[1.0]);
        model.elements.push(branch("mesh", &[(0, 1.0)], law));
        model
            .elements
            .push(branch("spring", &[(0, 1.0)], spring(1.0, 0.1)));
        let maxwell = ForceLaw::Maxwell {
            stiffness: 0.5,
            damping: 0.4,
        };
        model.elements.push(branch("late", &[(0, 1.0)], maxwell));
        let shaking = Signal::harmonic(0.3, 0.9, 0.4);
        model
            .forces
            .push(push(0, Signal::constant(mean).plus(&shaking)));
        let family = SpeedFamily::new(&model, &[0.0]).unwrap();
        let few = ContinuationOptions {
            tolerance: 1e-8,
            max_points: 2,
            ..course(0.9, 1.0, 0.05)
        };
        let found = curve(&family, few, true);
        let p = &found.points[0];
        assert!(
            (p.omega - 0.9).abs() < 1e-12,
            "the curve begins where it was told to"
        );
        assert_eq!(
            (p.refinement, p.unstable_count()),
            (Refinement::HarmonicBalance, 0),
            "{name}"
        );
        let period = TAU / p.omega;
        let model = family.relative_at(p.omega);
        let steady = brute(&model, &p.start, period, 1, 4000);
        let off = apart(&steady[1..], std::slice::from_ref(&p.start));
        println!("{name}: {} orders, comes back to {off:.1e}", p.orders);
        assert!(off < 1e-6, "{name}: {off:.1e}");
        // From elsewhere it ends there as well.
        let settled = brute(&model, &[0.0, 0.0, 0.0], 40.0 * period, 1, 20_000);
        assert!(
            apart(&settled[1..], std::slice::from_ref(&p.start)) < 1e-5,
            "{name}"
        );
    }
}

/// Two bodies that turn freely, a mesh with play between them, swung by its error.
fn swinging() -> DynamicModel {
    let mut model = inertias(&[1.0, 2.0]);
    let mut mesh = branch(
        "mesh",
        &[(0, 1.0), (1, -1.0)],
        contact(1.0, 0.1, 1.0, ContactDamping::ActsInGap),
    );
    mesh.imposed_displacement = Some(Signal::harmonic(0.05, 1.0, 0.0));
    model.elements.push(mesh);
    model
}

/// A machine that turns against a fan: its angle is nobody's business, and its motion is that of the whole machine in time.
#[test]
fn law_turning_against_a_damper_keeps_no_angle() {
    let mut model = swinging();
    model
        .elements
        .push(branch("fan", &[(1, 1.0)], spring(0.0, 0.02)));
    model.forces.push(push(0, Signal::constant(0.1)));
    let family = SpeedFamily::new(&model, &[5.0, 5.0]).unwrap();
    assert!(!family.is_periodic());
    let found = curve(&family, course(0.8, 1.0, 0.1), true);
    assert!(
        found
            .points
            .iter()
            .all(|p| p.refinement == Refinement::HarmonicBalance && p.unstable_count() == 0)
    );
    let p = &found.points[0];
    let mut model = family.relative_at(p.omega);
    // At that frequency the fan turns at 4 rad/s and takes 0.08 of the torque of 0.1; the rest accelerates both, and is taken off.
    let rest = 0.02 / 3.0;
    model.forces.push(push(1, Signal::constant(-0.08)));
    model.forces.push(push(0, Signal::constant(-rest)));
    model.forces.push(push(1, Signal::constant(-2.0 * rest)));
    let steady = brute(&model, &p.start, TAU / p.omega, 1, 4000);
    let off = apart(&steady[1..], std::slice::from_ref(&p.start));
    println!("comes back to {off:.1e}");
    assert!(off < 1e-5, "{off:.1e}");
}

/// A constant friction that slides changes no motion against the turning: the multipliers of angle and speed are one and say nothing.
#[test]
fn law_sliding_friction_takes_no_stability() {
    let multipliers = |torque: f64| {
        let mut model = swinging();
        if torque > 0.0 {
            let friction = FrictionLaw {
                sliding: torque,
                breakaway: torque,
                stribeck_velocity: 1.0,
                regularisation_velocity: 1e-3,
            };
            let law = ForceLaw::Friction(friction);
            model.elements.push(branch("bearing", &[(1, 1.0)], law));
        }
        model.forces.push(push(0, Signal::constant(0.1)));
        model.forces.push(push(1, Signal::constant(torque - 0.1)));
        let family = SpeedFamily::new(&model, &[5.0, 5.0]).unwrap();
        let found = curve(&family, course(0.8, 1.0, 0.1), false);
        assert!(found.bifurcations.is_empty());
        let points = found.points.iter();
        points
            .map(|p| (p.unstable_count(), p.multipliers.clone()))
            .collect::<Vec<_>>()
    };
    // The first motions have the same speed.
    for (with, without) in multipliers(0.02).iter().zip(multipliers(0.0)).take(1) {
        println!("{with:?} {without:?}");
        assert_eq!((with.0, without.0), (0, 0));
        assert_eq!(with.1.len(), without.1.len());
        let off = with.1.iter().zip(&without.1).map(|(a, b)| (a - b).norm());
        assert!(off.fold(0.0, f64::max) < 1e-6);
    }
}

#[test]
fn refuses_what_has_no_curve() {
    let family = SpeedFamily::new(&pair("S1"), &[0.0, 0.0]).unwrap();
    let outputs = deflection();
    let options = PointOptions {
        outputs: &outputs,
        events: true,
    };
    for (from, to, step) in [
        (0.0, 1.0, 0.1),
        (-1.0, 1.0, 0.1),
        (1.0, 1.0, 0.1),
        (f64::NAN, 1.0, 0.1),
        (0.5, f64::INFINITY, 0.1),
        (0.5, 1.0, 0.0),
    ] {
        let error =
            continue_curve(&family, options, course(from, to, step), &mut |_| {}).unwrap_err();
        assert_eq!(error.code, Code::OutOfRange, "{from} {to} {step}");
    }
    // Nothing repeats.
    let mut still = pair("S1");
    still.elements[0].imposed_displacement = None;
    still.elements[0].stiffness_wave = None;
    assert!(SpeedFamily::new(&still, &[0.0, 0.0]).is_err());
    // A load that steps is no steady one.
    let mut stepping = pair("S1");
    stepping.forces.push(push(0, Signal::step(1.0, 2.0)));
    assert!(SpeedFamily::new(&stepping, &[0.0, 0.0]).is_err());
    // The two sides of a mesh at different speeds.
    assert!(SpeedFamily::new(&pair("S1"), &[1.0, 2.0]).is_err());
    // Orders of 1 and 1000 together.
    let mut slow = pair("S1");
    slow.forces.push(push(0, Signal::harmonic(0.1, 1e-3, 0.0)));
    assert!(SpeedFamily::new(&slow, &[0.0, 0.0]).is_err());
}

/// A pair whose stiffness swings by 0.3 about twice its frequency: within Mathieu's tongue the motion of one period repels, and the one of
/// two periods, held by loss of contact, is where an integration in time settles.
#[test]
fn exact_motions_of_two_periods() {
    let family = SpeedFamily::new(&pair("S3"), &[0.0, 0.0]).unwrap();
    let found = curve(
        &family,
        ContinuationOptions {
            tolerance: 1e-5,
            ..course(1.7, 2.3, 0.05)
        },
        true,
    );
    let doublings = found
        .bifurcations
        .iter()
        .filter(|s| s.kind == BifurcationKind::PeriodDoubling);
    assert_eq!(doublings.count(), 2);
    assert_eq!(found.period_doubled.len(), 1);
    let doubled = &found.period_doubled[0].points;
    assert!(doubled.len() > 3);
    let mut compared = 0;
    for point in doubled
        .iter()
        .filter(|p| p.unstable_count() == 0)
        .step_by(2)
    {
        let model = family.relative_at(point.omega);
        // From beside the motion of one period, until 400 periods have passed.
        let options = IntegrationOptions {
            from: 0.0,
            to: 400.0 * TAU / point.omega,
            initial_state: vec![1.2, 0.05],
            samples: 400,
            step_size: StepSize::Adaptive(1e-11),
            max_work: 100_000_000,
            cancel: CancelToken::default(),
            observer: Observer::default(),
        };
        let mut states: Vec<Vec<f64>> = Vec::new();
        let mut sink = |_: f64, y: &[f64], _: Option<&Regime>| {
            states.push(y.to_vec());
            std::ops::ControlFlow::Continue(())
        };
        let method = methods::method_by_name("dop853-events").unwrap();
        (method.run)(&model, &options, &mut sink).unwrap();
        let last = &states[states.len() - 2..];
        let off = |y: &Vec<f64>| {
            y.iter()
                .zip(&point.start)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        let nearest = last.iter().map(off).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-7, "{}: {nearest:e}", point.omega);
        assert!(off(&last[0]).max(off(&last[1])) > 1e-3);
        compared += 1;
    }
    assert!(compared > 1);
}
