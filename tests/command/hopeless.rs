//! Requests that are hopeless: refused before the work where their cost is known, while it runs where it is seen.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use crate::support::command::said;
use geardyn::internals::base::code::Code;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::motion::diagnostics::fastest_mode;
use geardyn::internals::motion::methods::{METHODS, method_by_name};
use geardyn::internals::motion::problem::{IntegrationOptions, Observer, StepSize};
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::motion::cost::CostModel;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run;
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene;
use geardyn::internals::scene::study::SimulateStudy;
use geardyn::internals::study::monitor::Monitor;
use geardyn::internals::study::stability::amplification::{
    amplification_factor, stability_polynomial,
};
use geardyn::internals::study::work_precision::{self, RunOutcome};

fn ready(example: &str, until: f64, output: &str) -> SimulationSetup {
    let text = std::fs::read_to_string(format!("examples/{example}.toml")).unwrap();
    let text = text.replace("../models/", "models/");
    let scene = scene::read_text("x.toml", &text).unwrap();
    let study = SimulateStudy {
        end_time: Some(until),
        outputs: vec![output.to_string()],
        samples: Some(50),
        ..SimulateStudy::default()
    };
    SimulationSetup::new(
        &PreparedMachine::new(&scene.model).unwrap(),
        &scene.start,
        &study,
    )
    .unwrap()
}

/// No hλ in the left half-plane beyond the radius of a method is stable along its ray, and some just within is.
#[test]
fn law_bounds_are_the_radii_of_stability() {
    for method in METHODS {
        let Some(coefficients) = stability_polynomial(method.name) else {
            continue;
        };
        let bound = method.bound.unwrap();
        let ends = (0..=400).map(|k| {
            let angle = PI * (0.5 + 0.5 * f64::from(k) / 400.0);
            let stable = |r: f64| {
                let z = Complex::new(r * angle.cos(), r * angle.sin());
                amplification_factor(&coefficients, z) <= 1.0 + 1e-6
            };
            let ray = (1..=1000).map(|k| 0.01 * f64::from(k));
            ray.take_while(|&r| stable(r)).last().unwrap_or(0.0)
        });
        let farthest = ends.fold(0.0, f64::max);
        let ratio = bound.radius / farthest;
        assert!((1.0..1.02).contains(&ratio), "{}: {farthest}", method.name);
    }
}

/// Twenty equal discs on equal shafts, the first held: `ω = 2 √(k/J) sin(39π/82)`.
#[test]
fn case_fastest_motion_of_a_chain() {
    let scene = ready("linear_chain", 1.0, "chain.20.theta");
    let omega = 2.0 * (8000.0f64 / 0.02).sqrt() * (39.0 * PI / 82.0).sin();
    let found = fastest_mode(&scene.model.model).unwrap();
    let ratio = found.rate / omega;
    assert!((0.98..=1.0 + 1e-12).contains(&ratio), "{ratio}");
    // Steps at the edge of stability: `ω T` over the radius.
    let method = method_by_name("dop853-events").unwrap();
    let least = CostModel::new(&scene)
        .lower_bound(method, StepSize::Adaptive(1e-3))
        .unwrap();
    assert!((least.steps * 6.8 / found.rate - 1.0).abs() < 1e-12 && least.seconds > 0.0);
    let mut seen = 0;
    let options = IntegrationOptions {
        from: 0.0,
        to: 1.0,
        initial_state: scene.initial_state.clone(),
        samples: 1,
        step_size: StepSize::Adaptive(1e-3),
        max_work: u64::MAX,
        cancel: CancelToken::default(),
        observer: Observer::default(),
    };
    let effort = (method.run)(&scene.model.model, &options, &mut |_, _, _| {
        seen += 1;
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(effort.steps as f64 >= least.steps, "{effort:?}");
}

/// Known before any work: said with the estimate, the element that costs, and what to try.
#[test]
fn refused_before_the_work() {
    let chain = "examples/stiff_chain.toml";
    let cases: &[(&[&str], &[&str])] = &[
        (
            &["--method", "dop853-events", "--until", "1e6"],
            &["steps", "years", "MHz", "`shaft_6`", "the plan takes exact"],
        ),
        (
            &["--method", "newmark", "--step", "1e-15"],
            &["1.0e15 steps", "take a longer step"],
        ),
        (&["--samples", "100000000"], &["--no-history"]),
        (&["--samples", "1e8"], &["--no-history"]),
    ];
    for (flags, words) in cases {
        let (code, _, said) = said(&[&["simulate", chain], *flags].concat());
        assert_eq!(code, Some(3), "{said}");
        for word in *words {
            assert!(said.contains(word), "{word}: {said}");
        }
    }
}

/// What is allowed is said by a flag, and the refusal names it; a count is a whole number.
#[test]
fn refused_beyond_what_is_allowed() {
    let chain = ["simulate", "examples/linear_chain.toml", "--until", "0.1"];
    let steps = ["--method", "newmark", "--step", "1 us"];
    let (code, _, words) = said(&[&chain[..], &steps, &["--allow", "1 us"]].concat());
    assert_eq!(code, Some(3), "{words}");
    assert!(
        words.contains("(limit 1.00 µs)") && words.contains("--allow 1h"),
        "{words}"
    );
    let (code, _, words) = said(&[&chain[..], &["--allow", "0 s"]].concat());
    assert!(
        code == Some(2) && words.contains("`allow` must be above zero"),
        "{words}"
    );
    let (code, _, words) = said(&[&chain[..], &["--samples", "1.5"]].concat());
    assert!(
        code == Some(2) && words.contains("`samples` cannot be 1.5"),
        "{words}"
    );
}

/// A study that holds several histories at a time allows each less.
#[test]
fn refused_histories_of_accuracy() {
    let chain = ["accuracy", "examples/linear_chain.toml"];
    let (code, _, said) = said(&[&chain[..], &["--samples", "100000000"]].concat());
    assert_eq!(code, Some(3), "{said}");
    assert!(
        said.contains("(limit ") && said.contains("fewer --samples"),
        "{said}"
    );
}

/// Seen while it runs: switches bring it on, so that the pace tells, and the contact that switched most is named.
#[test]
fn refused_by_the_pace() {
    let scene = ready("backlash_pair", 1e9, "pair.deflection");
    for method in ["switched", "dop853-events"] {
        let options = IntegrationOptions {
            from: 0.0,
            to: 1e9,
            initial_state: scene.initial_state.clone(),
            samples: 2,
            step_size: StepSize::Adaptive(1e-6),
            max_work: u64::MAX,
            cancel: CancelToken::default().with_budget(10.0),
            observer: Observer::default(),
        };
        let run = method_by_name(method).unwrap().run;
        let error = run(&scene.model.model, &options, &mut |_, _, _| {
            ControlFlow::Continue(())
        });
        let error = error.unwrap_err();
        assert_eq!(error.code, Code::BudgetExceeded);
        for word in [
            "of 1.0e9 s",
            "estimated total",
            "(limit 10.0 s)",
            "`pair` switched most",
        ] {
            assert!(error.message.contains(word), "{method}: {word}: {error}");
        }
    }
}

/// A stiff machine: explicit methods are listed with what they would cost, and the closed form is confirmed as tightly as an
/// unrelated method can in the time.
#[test]
fn law_accuracy_refuses_what_cannot() {
    let scene = ready("stiff_chain", 100.0, "body_20.theta");
    let methods = ["exact", "dop853-events", "dopri5"].map(String::from);
    let mut monitor = Monitor {
        cancel: &CancelToken::default(),
        on_progress: &mut |_| {},
    };
    let found = work_precision::work_precision(&scene, &methods, 2.0, &mut monitor).unwrap();
    for run in found.runs.iter().filter(|r| r.method != "exact") {
        let RunOutcome::Skipped(why) = &run.outcome else {
            panic!("{} ran", run.method)
        };
        assert!(
            why.contains("stability") && why.contains("`shaft_6`"),
            "{why}"
        );
    }
    assert_eq!(found.reference.method, "exact");
    let kin = |name: &str| method_by_name(name).unwrap().family;
    let witness = &found.reference.cross_checks[0];
    assert!(kin(witness.method) != kin("exact") && witness.distance > 0.0);
}

/// What makes no sense ends with 2 and says what would.
#[test]
fn refused_senseless_flags() {
    let chain = "examples/linear_chain.toml";
    for (flags, word) in [
        (
            &["--until", "-1"][..],
            "`until` must be above zero, and is -1",
        ),
        (
            &["--until", "-1 s"],
            "`until` must be above zero, and is -1 s",
        ),
        (&["--step", "-1"], "`step` must be above zero"),
        (&["--tolerance", "-1"], "above 0 and below 1"),
    ] {
        let (code, _, said) = said(&[&["simulate", chain], flags].concat());
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains(word), "{said}");
    }
    let (code, _, said) = said(&["accuracy", chain, "--error", "-1"]);
    assert!(
        code == Some(2) && said.contains("`error` must be above zero"),
        "{said}"
    );
}

/// A step where a method without one would be exact: said in the plan and as a warning; one of a thing is one.
#[test]
fn law_steps_for_exact_are_told() {
    let chain = ["simulate", "examples/linear_chain.toml", "--until", "0.01"];
    let (code, _, words) = said(&[&chain[..], &["--step", "1 ms"]].concat());
    assert_eq!(code, Some(0), "{words}");
    for word in [
        "the method exact is exact here",
        "[step-for-exact]",
        "1 factorisation,",
    ] {
        assert!(words.contains(word), "{word}: {words}");
    }
    let (_, _, words) = said(&[&chain[..], &["--method", "newmark", "--step", "1 ms"]].concat());
    assert!(!words.contains("step-for-exact"), "{words}");
    let (_, _, words) = said(&chain);
    assert!(words.contains("effort: 1 step, "), "{words}");
}

/// A swing so fast that looking for one switch takes longer than is allowed is refused within the search, which hears of no sample.
#[test]
fn refused_within_one_search() {
    let text = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n
inertia = [{ name = \"a\", J = 1e-19 }, { name = \"b\", J = 0.01 }]
shaft = [{ name = \"s\", between = [\"ground\", \"a\"], k = 1e3 }]
coupling = [{ name = \"c\", between = [\"a\", \"b\"], k = 1e4, backlash = 0.02, contact_damping = \"adhesive\" }]
load = [{ at = \"a\", kind = \"harmonic\", torque = 5.0, frequency = 7.0 }]
";
    let scene = scene::read_text("x.toml", text).unwrap();
    let study = SimulateStudy {
        end_time: Some(10.0),
        method: Some("switched".to_string()),
        time_limit: Some(0.2),
        ..SimulateStudy::default()
    };
    let ready = SimulationSetup::new(
        &PreparedMachine::new(&scene.model).unwrap(),
        &scene.start,
        &study,
    )
    .unwrap();
    let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
    let error = run::run(&ready, &choice, false, &CancelToken::default()).unwrap_err();
    assert_eq!(error.code, Code::BudgetExceeded, "{}", error.message);
    assert!(error.message.contains("(limit "), "{}", error.message);
}
