//! The method `periodic`: machines whose stiffness and loads repeat in time, with play.

use std::f64::consts::TAU;

use crate::support::moving::{
    apart, branch, brute, contact, cosine, gear_pair, inertias, push, run, spring, wave,
};
use crate::support::{numbers, reference, within};
use geardyn::internals::motion::contact::{ActiveFlanks, ContactDamping, ContactLaw};
use geardyn::internals::motion::curve::TorqueSpeedCurve;
use geardyn::internals::motion::dynamic_model::{DynamicModel, ElementState, ForceLaw};
use geardyn::internals::motion::friction::FrictionLaw;
use geardyn::internals::motion::methods;
use geardyn::internals::motion::methods::periodic::run::PeriodicRun;
use geardyn::internals::motion::signal::Signal;
use geardyn::internals::motion::wave::{PeriodicFunction, WavePhase, Waveform};
use serde_json::Value;

fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

/// 1 000 periods and 2 000 contact losses against Taylor series in 40 digits.
/// Source: Taylor series with 40 digits by mpmath (tools/reference_periodic.py).
#[test]
fn ref_gear_pair_over_thousand_periods() {
    let expected = rows(&reference("periodic")["bench"]);
    let mut model = gear_pair(0.85, 0.05, 0.2, 0.1, 0.05);
    model.forces[0].signal.harmonics[0].amplitude = 0.05 * 0.85 * 0.85;
    let end = 1000.0 * (TAU / 0.85);
    let (times, states, effort) = run("periodic", &model, &[1.4, 0.0], end, 1000).unwrap();
    let timed = |_| {
        let clock = std::time::Instant::now();
        run("periodic", &model, &[1.4, 0.0], end, 1000).unwrap();
        clock.elapsed().as_secs_f64() * 1e3
    };
    let fastest = (0..9).map(timed).fold(f64::INFINITY, f64::min);
    println!("{fastest:.2} ms, {effort:?}");
    let mut worst: f64 = 0.0;
    for row in &expected {
        let at = row[0] as usize;
        assert!((times[at] - row[1]).abs() <= 4.0 * f64::EPSILON * row[1]);
        worst = worst.max((states[at][0] - row[2]).abs());
        worst = worst.max((states[at][1] - row[3]).abs());
    }
    within("states over 1 000 periods", worst, 5e-12);
    assert_eq!(effort.events, 2000);
}

/// Three inertias, two meshes with play, one at twice the frequency of the other.
fn trio(shapes: [Waveform; 2]) -> DynamicModel {
    let mut model = inertias(&[1.0, 0.5, 2.0]);
    let sizes = [(40.0, 0.3, 0.05), (25.0, 0.2, 0.03)];
    for (at, (waveform, (k, c, half))) in shapes.into_iter().zip(sizes).enumerate() {
        let law = contact(k, c, half, ContactDamping::Adhesive);
        let mut mesh = branch("mesh", &[(at, 1.0), (at + 1, -1.0)], law);
        mesh.stiffness_wave = wave(waveform, [3.0, 6.0][at], [0.3, 1.1][at]);
        model.elements.push(mesh);
    }
    model
        .elements
        .push(branch("drag", &[(0, 1.0)], spring(0.0, 0.2)));
    model
        .elements
        .push(branch("ground", &[(2, 1.0)], spring(3.0, 0.2)));
    let shaking = Signal::harmonic(2.5, 3.0, 0.0);
    model
        .forces
        .push(push(0, Signal::constant(1.5).plus(&shaking)));
    model.forces.push(push(2, Signal::constant(-1.5)));
    model
}

const TRIO: [f64; 6] = [0.06, 0.0, -0.04, 0.0, 0.1, 0.0];

fn check_trio(name: &str, shapes: [Waveform; 2]) {
    let expected = &reference("periodic")[name];
    let samples: Vec<Vec<f64>> = rows(&expected["samples"])
        .into_iter()
        .map(|row| row[1..].to_vec())
        .collect();
    let (_, states, effort) = run("periodic", &trio(shapes), &TRIO, 40.0, 40).unwrap();
    let off = apart(&states, &samples);
    within("states over 40 s", off, 1e-9);
    assert_eq!(effort.events, expected["events"].as_u64().unwrap());
}

/// Two meshes in a row whose stiffness changes smoothly.
/// Source: SciPy 1.17.1 (tools/reference_periodic.py).
#[test]
fn ref_two_meshes_smooth() {
    check_trio("trio_smooth", [cosine(0.25), cosine(0.2)]);
}

/// Two meshes in a row whose stiffness changes in steps.
/// Source: SciPy 1.17.1 (tools/reference_periodic.py).
#[test]
fn ref_two_meshes_in_steps() {
    let steps = |low, duty| Waveform::Rectangular {
        high: 1.0,
        low,
        duty,
    };
    check_trio("trio_steps", [steps(0.6, 0.6), steps(0.7, 0.45)]);
}

/// Every convention of losses, tables, loads that rise and fall, errors imposed in time, late motors and Maxwell elements: against
/// small steps of a method that locates nothing.
#[test]
fn law_agrees_with_small_steps() {
    let table = Waveform::Table(vec![1.0, 1.3, 1.2, 0.8, 0.7]);
    for contact_damping in [
        ContactDamping::ActsInGap,
        ContactDamping::Adhesive,
        ContactDamping::NoPull,
        ContactDamping::Continuous,
    ] {
        for (waveform, flanks) in [
            (cosine(0.3), ActiveFlanks::Both),
            (table.clone(), ActiveFlanks::Drive),
        ] {
            let mut model = inertias(&[1.0, 2.0]);
            let law = ForceLaw::Contact(ContactLaw {
                stiffness: 30.0,
                damping: 1.5,
                half_play: 0.02,
                contact_damping,
                flanks,
            });
            let mut mesh = branch("mesh", &[(0, 1.0), (1, -0.8)], law);
            mesh.stiffness_wave = wave(waveform, 4.0, 0.7);
            mesh.imposed_displacement = Some(Signal::harmonic(0.03, 2.0, 0.4));
            mesh.angle_waves = wave(
                Waveform::Fourier {
                    mean: 0.0,
                    terms: vec![(1, 0.02, 0.2), (3, 0.005, 1.0)],
                },
                2.0,
                0.1,
            )
            .into_iter()
            .collect();
            model.elements.push(mesh);
            model
                .elements
                .push(branch("ground", &[(1, 1.0)], spring(5.0, 0.1)));
            let lagged = ForceLaw::LaggedTorque {
                curve: TorqueSpeedCurve::Linear {
                    stall: 1.0,
                    idle: 3.0,
                },
                lag: 0.2,
            };
            model.elements.push(branch("motor", &[(0, 1.0)], lagged));
            let maxwell = ForceLaw::Maxwell {
                stiffness: 4.0,
                damping: 0.5,
            };
            model.elements.push(branch("mount", &[(0, 1.0)], maxwell));
            model
                .elements
                .push(branch("hold", &[(0, 1.0)], spring(2.0, 0.0)));
            model.mass_damping = 0.05;
            let load = Signal::ramp(-1.0, 2.0, [1.3, 4.1]);
            model
                .forces
                .push(push(0, load.plus(&Signal::step(-3.0, 6.0))));
            model.forces.push(push(1, Signal::harmonic(2.0, 6.0, 0.0)));
            let start = [0.1, 0.0, 0.0, 0.3, 0.2, -0.1];
            let (_, states, effort) = run("periodic", &model, &start, 10.0, 10).unwrap();
            let coarse = brute(&model, &start, 10.0, 10, 1_000);
            let fine = brute(&model, &start, 10.0, 10, 4_000);
            let (off, own) = (apart(&states, &fine), apart(&coarse, &fine));
            println!(
                "{contact_damping:?} {flanks:?}: {off:.1e} of the finest steps, which are {own:.1e} of coarser ones; {} events",
                effort.events
            );
            assert!(off < 8e-4, "{contact_damping:?} {flanks:?}: {off:.1e}");
            assert!(
                off < 2.0 * own.max(1e-9),
                "{contact_damping:?} {flanks:?}: {off:.1e}"
            );
            assert!(effort.events > 3);
        }
    }
}

/// A run gives the same states whatever samples are asked for, and from wherever it starts in the period.
#[test]
fn law_samples_change_nothing() {
    let model = trio([cosine(0.25), cosine(0.2)]);
    let (_, few, _) = run("periodic", &model, &TRIO, 40.0, 4).unwrap();
    let (_, many, _) = run("periodic", &model, &TRIO, 40.0, 4_000).unwrap();
    let thinned: Vec<Vec<f64>> = many.into_iter().step_by(1_000).collect();
    let off = apart(&few, &thinned);
    assert!(off < 1e-10, "{off:.1e}");
}

/// A random machine of one freedom with play, and a state of it.
fn random_scene(random: &mut fastrand::Rng, scene: usize) -> (DynamicModel, [f64; 2], f64) {
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let omega = between(0.3, 3.0);
    let half = 10f64.powf(between(-3.0, 0.3));
    let depth = between(0.0, 0.7);
    let waveform = match scene % 3 {
        0 => cosine(depth),
        1 => Waveform::Rectangular {
            high: 1.0 + depth,
            low: 1.0 - depth,
            duty: between(0.1, 0.9),
        },
        _ => Waveform::Table((0..6).map(|_| between(1.0 - depth, 1.0 + depth)).collect()),
    };
    let contact_damping = [
        ContactDamping::ActsInGap,
        ContactDamping::Adhesive,
        ContactDamping::NoPull,
        ContactDamping::Continuous,
    ][scene / 3 % 4];
    let mut model = inertias(&[1.0]);
    let law = contact(1.0, between(0.01, 0.3), half, contact_damping);
    let mut mesh = branch("mesh", &[(0, 1.0)], law);
    mesh.stiffness_wave = wave(waveform, omega, between(0.0, TAU));
    model.elements.push(mesh);
    let load = Signal::constant(between(-0.3, 0.3));
    let shaking = Signal::harmonic(between(0.0, 0.8), omega, between(0.0, TAU));
    model.forces.push(push(0, load.plus(&shaking)));
    model.mass_damping = 0.02;
    (model, [between(-2.0, 2.0), between(-1.0, 1.0)], TAU / omega)
}

/// Along every leg, looked at in many places, the contact stands as the walk has it.
fn check_no_event_lost(seed: u64, scenes: usize, places: usize) {
    let mut random = fastrand::Rng::with_seed(seed);
    let (mut events, mut grazed) = (0, 0);
    for scene in 0..scenes {
        let (model, start, period) = random_scene(&mut random, scene);
        let ForceLaw::Contact(contact) = &model.elements[0].law else {
            unreachable!()
        };
        let mut walk = PeriodicRun::new(&model, 0.0, &start).unwrap();
        let end = walk.cache.grid.instant(60.0 * period);
        loop {
            let (from, segment) = (walk.position(), walk.next_segment(end));
            // At a jump of the stiffness a stand may give way at once.
            let places = if segment.to > from { places } else { 0 };
            let regime = walk.full_regime();
            let ElementState::Contact(state, piece) = regime.states[0] else {
                unreachable!()
            };
            for at in 0..places {
                let place = from + (segment.to - from) * (at as f64 + 0.5) / places as f64;
                let mut y = [0.0; 2];
                walk.value(place, &mut y);
                let factor = model.elements[0].factor(walk.elapsed(place), &[], piece).0;
                for (border, next) in contact.switching_functions(state, factor) {
                    let value = border.value_at(y[0], y[1]);
                    assert!(
                        value > -1e-13 * (1.0 + y[0].abs()),
                        "scene {scene} of seed {seed}: {state:?} lasts {value:.1e} beyond its border to {next:?}"
                    );
                }
            }
            if segment.limit.is_none() && segment.to >= walk.position_of(end) {
                break;
            }
            // An unstable machine soon makes rounding of its play.
            let mut y = [0.0; 2];
            walk.value(segment.to, &mut y);
            if y[0].abs() > 100.0 {
                break;
            }
            walk.advance(segment).unwrap();
        }
        events += walk.stats.events;
        grazed += walk.stats.grazings;
    }
    println!("{scenes} scenes, {events} events, {grazed} grazed");
    assert!(events > 20 * scenes as u64);
}

#[test]
fn law_no_event_is_lost() {
    check_no_event_lost(1, 36, 40);
}

#[test]
#[ignore = "study: minutes"]
fn law_no_event_is_lost_in_many_scenes() {
    check_no_event_lost(2, 3_000, 400);
}

/// What the tables cannot hold is refused, with the name of what it is.
#[test]
fn refuses_what_does_not_repeat() {
    let refuses = methods::method_by_name("periodic")
        .unwrap()
        .unsupported_reason;
    let reason = |change: &dyn Fn(&mut DynamicModel)| {
        let mut model = gear_pair(0.85, 0.05, 0.2, 0.1, 0.05);
        change(&mut model);
        refuses(&model).unwrap_or_default()
    };
    assert_eq!(reason(&|_| {}), "");
    let friction = ForceLaw::Friction(FrictionLaw {
        sliding: 1.0,
        breakaway: 1.0,
        stribeck_velocity: 1.0,
        regularisation_velocity: 1e-3,
    });
    let with_brake = |model: &mut DynamicModel| {
        model
            .elements
            .push(branch("brake", &[(0, 1.0)], friction.clone()));
    };
    assert!(reason(&with_brake).contains("brake"));
    let angle = |model: &mut DynamicModel| {
        let phase = WavePhase::FollowsAngle {
            angle: geardyn::internals::machine::direction::Direction::unit(0),
            start: 0.0,
            known: None,
        };
        let waveform = cosine(0.1);
        model.elements[0].stiffness_wave = Some(PeriodicFunction {
            waveform,
            load_table: None,
            phase,
        });
    };
    assert!(reason(&angle).contains("angle"));
    let golden = |model: &mut DynamicModel| {
        model.forces[0].signal.harmonics[0].omega = 0.85 * 0.5 * (1.0 + 5f64.sqrt());
    };
    assert!(reason(&golden).contains("have no common period"));
    let stiff = |model: &mut DynamicModel| {
        model
            .elements
            .push(branch("anvil", &[(0, 1.0)], spring(1e14, 0.0)));
    };
    assert!(reason(&stiff).contains("segments of a period"));
}
