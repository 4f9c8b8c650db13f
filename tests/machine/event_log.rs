//! Events of a motion by kind: instants in closed form, thinning of many.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use crate::support::verification::within;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::machine::direction::Direction;
use geardyn::internals::motion::contact::{ActiveFlanks, ContactDamping, ContactLaw};
use geardyn::internals::motion::dynamic_model::{DynamicModel, ForceElement, ForceLaw, MassMatrix};
use geardyn::internals::motion::event_log::{EventKind, EventLog, EventRecord, MAX_EVENTS};
use geardyn::internals::motion::friction::FrictionLaw;
use geardyn::internals::motion::methods;
use geardyn::internals::motion::problem::{IntegrationOptions, Observer, StepSize};

/// A disc of 1 kg·m² on elements to the ground.
fn disc(laws: Vec<ForceLaw>) -> DynamicModel {
    let element = |law| ForceElement {
        name: "element".into(),
        direction: Direction::unit(0),
        force_direction: None,
        law,
        stiffness_wave: None,
        imposed_displacement: None,
        angle_waves: Vec::new(),
    };
    DynamicModel {
        coordinates: vec!["disc.theta".into()],
        mass: MassMatrix::Diagonal(vec![1.0]),
        elements: laws.into_iter().map(element).collect(),
        forces: Vec::new(),
        mass_damping: 0.0,
        global_matrices: None,
    }
}

fn events(method: &str, model: &DynamicModel, start: [f64; 2], to: f64) -> Vec<EventRecord> {
    let method = methods::method_by_name(method).unwrap();
    let mut options = IntegrationOptions {
        from: 0.0,
        to,
        initial_state: start.to_vec(),
        samples: 3,
        step_size: match method.name {
            "switched" => StepSize::Fixed(1.0),
            _ => StepSize::Adaptive(1e-11),
        },
        max_work: 100_000_000,
        cancel: CancelToken::default(),
        observer: Observer::default(),
    };
    let log = EventLog::observe(model, &mut options.observer);
    (method.run)(model, &options, &mut |_, _, _| ControlFlow::Continue(())).unwrap();
    log.borrow().records()
}

/// The instants of a kind against those of a closed form, and its count.
fn assert_instants(records: &[EventRecord], kind: EventKind, exact: &[f64]) {
    let found = records.iter().find(|r| r.kind == kind).unwrap();
    assert_eq!((found.count, found.stride), (exact.len() as u64, 1));
    assert_eq!(found.events.len(), exact.len());
    let gaps = found.events.iter().zip(exact).map(|(a, b)| (a.0 - b).abs());
    within("instants, s", gaps.fold(0.0, f64::max), 1e-8);
}

/// A disc flies through a gap of 2 b at speed v and swings back in π/ω from each side: impacts at b/v + n (π/ω + 2 b/v), losses of contact π/ω later.
#[test]
fn exact_instants_of_impacts() {
    let (omega, half, speed) = (50.0, 0.01, 0.4);
    let model = disc(vec![ForceLaw::Contact(ContactLaw {
        stiffness: omega * omega,
        damping: 0.0,
        half_play: half,
        contact_damping: ContactDamping::ActsInGap,
        flanks: ActiveFlanks::Both,
    })]);
    let (first, touch) = (half / speed, PI / omega);
    let impact = |n: usize| first + n as f64 * (touch + 2.0 * half / speed);
    for method in ["switched", "dop853-events", "radau5"] {
        let records = events(method, &model, [0.0, speed], impact(9) + 0.5 * touch);
        let made: Vec<f64> = (0..10).map(impact).collect();
        let lost: Vec<f64> = made[..9].iter().map(|t| t + touch).collect();
        assert_eq!(records.len(), 2);
        assert_instants(&records, EventKind::Impact, &made);
        assert_instants(&records, EventKind::ContactLoss, &lost);
    }
    // Many: one of so many, evenly over the whole run, and all of them counted.
    let wanted = 2 * MAX_EVENTS + 1;
    let to = impact(wanted - 1) + 0.5 * touch;
    let records = events("switched", &model, [0.0, speed], to);
    let found = records
        .iter()
        .find(|r| r.kind == EventKind::Impact)
        .unwrap();
    assert_eq!(found.count, wanted as u64);
    assert_eq!(found.stride, 4);
    assert_eq!(found.events.len(), wanted.div_ceil(4));
    for (k, (t, _)) in found.events.iter().enumerate() {
        assert!((t - impact(4 * k)).abs() < 1e-8, "{k}: {t}");
    }
}

/// Coulomb friction T on a spring k: the disc reverses at each half period and sticks when the swing, shorter by 2 T/k each time, is within T/k.
#[test]
fn exact_instants_of_stick() {
    let (stiffness, torque, swing) = (100.0, 1.0, 0.293);
    let model = disc(vec![
        ForceLaw::Linear {
            stiffness,
            damping: 0.0,
        },
        ForceLaw::Friction(FrictionLaw {
            sliding: torque,
            breakaway: torque,
            stribeck_velocity: 0.0,
            regularisation_velocity: 1e-6,
        }),
    ]);
    let half = TAU / 20.0;
    // 0.293 → 0.273 → … → 0.013 → −0.007 after 15 swings.
    let turns: Vec<f64> = (1..15).map(|n| f64::from(n) * half).collect();
    for method in ["switched", "dop853-events", "radau5"] {
        let records = events(method, &model, [swing, 0.0], 17.0 * half);
        assert_instants(&records, EventKind::SlipReversal, &turns);
        assert_instants(&records, EventKind::Stick, &[15.0 * half]);
    }
}
