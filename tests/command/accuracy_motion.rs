//! `accuracy` of motions: what errors are measured against, rungs that were not run, what is recommended.

use crate::support::command::said;
use geardyn::internals::base::code::Code;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::motion::methods::{METHODS, MethodFamily, method_by_name};
use geardyn::internals::motion::problem::StepSize;
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene;
use geardyn::internals::scene::initial_conditions::InitialConditions;
use geardyn::internals::scene::laws::InitialState;
use geardyn::internals::scene::study::SimulateStudy;
use geardyn::internals::study::monitor::Monitor;
use geardyn::internals::study::work_precision::{
    self, Recommendation, RunOutcome, WorkPrecisionResult,
};
use serde_json::Value;

fn study(text: &str, asked: SimulateStudy, methods: &[&str], patience: f64) -> WorkPrecisionResult {
    let scene = scene::read_text("x.toml", text).unwrap();
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let ready = SimulationSetup::new(&machine, &scene.start, &asked).unwrap();
    let methods: Vec<String> = methods.iter().map(|m| m.to_string()).collect();
    let mut monitor = Monitor {
        cancel: &CancelToken::default(),
        on_progress: &mut |_| {},
    };
    work_precision::work_precision(&ready, &methods, patience, &mut monitor).unwrap()
}

fn asked(until: f64, output: &str) -> SimulateStudy {
    SimulateStudy {
        end_time: Some(until),
        outputs: vec![output.to_string()],
        samples: Some(100),
        ..SimulateStudy::default()
    }
}

fn kin(method: &str) -> MethodFamily {
    method_by_name(method).unwrap().family
}

const TWO_DISCS: &str = r#"
title = "two discs"
source = "closed form"
[[inertia]]
name = "a"
J = "1 kg·m²"
[[inertia]]
name = "b"
J = "1 kg·m²"
[[shaft]]
name = "ab"
between = ["a", "b"]
k = "50 N·m/rad"
"#;

/// Struck by a step.
fn struck() -> String {
    format!(
        "{TWO_DISCS}[[load]]\nat = \"a\"\nkind = \"step\"\ntorque = \"1 N·m\"\ntime = \"0 s\"\n"
    )
}

/// From rest, struck by a step: the closed form is confirmed by a method of another kin, with a distance that is not nothing, and
/// a change of the start shows.
#[test]
fn law_linear_references_are_confirmed_by_strangers() {
    let found = study(
        &struck(),
        asked(2.0, "b.theta"),
        &["exact", "switched"],
        10.0,
    );
    let reference = &found.reference;
    assert_eq!(reference.method, "exact");
    for witness in &reference.cross_checks {
        assert!(kin(witness.method) != MethodFamily::Propagation && !witness.related);
        assert!(witness.step_size.is_some() && witness.distance > 0.0);
    }
    let known = reference.agreement().unwrap();
    assert!(known < 1e-11, "{known}");
    assert!(reference.amplification.unwrap().factor > 0.1);
    // Whatever is nearer to the reference than its witness is not called better than that.
    assert!(found.runs.iter().all(|r| r.error() == Some(known)));
}

/// The two that agree best are the reference, whoever stands between: no distance of unrelated methods is smaller.
#[test]
fn law_witnesses_stand_in_order() {
    let pair = std::fs::read_to_string("examples/backlash_pair.toml").unwrap();
    let pair = pair.replace("../models/", "models/");
    let found = study(&pair, asked(2e-3, "pair.deflection"), &["switched"], 10.0);
    let all = &found.reference.cross_checks;
    assert!(!all.is_empty() && all.is_sorted_by(|a, b| a.distance <= b.distance));
    let strangers = all
        .iter()
        .all(|w| kin(w.method) != kin(found.reference.method));
    assert!(strangers && found.reference.agreement().unwrap() < 1e-9);
}

/// Every rung of every method is listed, with an error or with the reason why there is none.
#[test]
fn law_no_rung_is_missing() {
    let chain = std::fs::read_to_string("examples/linear_chain.toml").unwrap();
    let chain = chain.replace("../models/", "models/");
    let methods = ["exact", "radau5", "rk4", "newmark"];
    let found = study(&chain, asked(0.02, "chain.20.theta"), &methods, 0.2);
    for (method, rungs) in methods.iter().zip([1, 6, 4, 4]) {
        let own: Vec<_> = found.runs.iter().filter(|r| r.method == *method).collect();
        assert_eq!(own.len(), rungs, "{method}");
        let begun = own.iter().take_while(|r| r.error().is_some()).count();
        for run in &own[begun..] {
            assert!(!run.reason().unwrap().is_empty(), "{method}");
        }
    }
    let last = |method: &str| found.runs.iter().rfind(|r| r.method == method).unwrap();
    // A million steps of forty states are not done in a fifth of a second.
    for method in ["rk4", "newmark"] {
        assert!(matches!(last(method).step_size, Some(StepSize::Fixed(_))));
        let RunOutcome::Skipped(why) = &last(method).outcome else {
            panic!("{method} ran to the end")
        };
        assert!(why.contains("not run"), "{why}");
    }
}

/// The cheapest that reaches the error; where none does, the nearest; where none ended, that is said.
#[test]
fn law_recommendations_are_never_empty() {
    let found = study(&struck(), asked(2.0, "b.theta"), &["dopri5", "rk4"], 0.5);
    let of = |error: f64| match found.recommend(error) {
        Recommendation::Cheapest(run, _) => (true, run),
        Recommendation::Nearest(run) => (false, run),
        Recommendation::Unavailable => panic!("nothing for {error}"),
    };
    let ended: Vec<_> = found.runs.iter().filter(|r| r.error().is_some()).collect();
    for error in [1e-2, 1e-5, 1e-8] {
        let (reached, best) = of(error);
        assert!(reached && best.error().unwrap() <= error);
        let cheaper = |r: &&&work_precision::WorkPrecisionRun| {
            r.error().unwrap() <= error && r.seconds() < best.seconds()
        };
        assert!(!ended.iter().any(|r| cheaper(&r)));
    }
    let (reached, nearest) = of(1e-30);
    assert!(!reached && ended.iter().all(|r| r.error() >= nearest.error()));
    let all = study(&struck(), asked(1.0, "b.theta"), &[], 0.05);
    assert_eq!(
        all.runs
            .iter()
            .map(|r| r.method)
            .collect::<std::collections::BTreeSet<_>>()
            .len(),
        METHODS.len()
    );
}

/// What is said is what the document holds.
#[test]
fn law_documents_recommend() {
    let pair = ["accuracy", "examples/backlash_pair.toml", "--until", "1 ms"];
    for (flags, reached, words) in [
        (
            &["--methods", "switched"][..],
            true,
            "for 1e-8 only switched",
        ),
        (
            &["--methods", "switched", "--error", "1e-20"],
            false,
            "no run reaches 1e-20; nearest is switched",
        ),
        (
            &["--methods", "exact"],
            false,
            "no run completed, so that none can be recommended",
        ),
    ] {
        let (code, text, error) = said(&[&pair, flags].concat());
        assert_eq!(code, Some(0), "{error}");
        assert!(text.contains(words), "{text}");
        let (_, json, _) = said(&[&pair, flags, &["--json"]].concat());
        let found: Value = serde_json::from_str(&json).unwrap();
        let advice = &found["recommendation"];
        assert_eq!(advice["reached"], reached, "{advice}");
        assert!(
            advice["text"].as_str().unwrap().contains(&words[..20]),
            "{advice}"
        );
        let near = &found["reference"]["witnesses"][0];
        assert_eq!(near["method"], found["reference"]["witness"]);
        assert_eq!(near["distance"], found["reference"]["error"]);
    }
}

/// A rattling pair at rest in the mean and the same turning at 1 000 rad/s: what a change of the start grows to is the same to a power of ten,
/// since the start is changed by a share of what deforms, not of the angle turned (which had shown no growth).
#[test]
fn law_growth_goes_by_deformations() {
    let growth = |speed: f64| {
        let text = format!(
            "title = \"x\"\nsource = \"x\"\nunits = \"SI\"\n\
             inertia = [{{ name = \"a\", J = 0.01 }}, {{ name = \"b\", J = 0.01 }}]\n\
             gear_pair = [{{ name = \"g\", between = [\"a\", \"b\"], teeth = [20, 20], module = 0.004, k = 1e8, backlash = 1e-4 }}]\n\
             load = [{{ at = \"a\", kind = \"harmonic\", mean = 10.0, torque = 60.0, frequency = \"1500 rad/s\" }}, {{ at = \"b\", torque = 10.0 }}]\n\
             [speed]\na = \"{speed:?} rad/s\"\n"
        );
        let scene = scene::read_text("x.toml", &text).unwrap_or_else(|e| panic!("{e}"));
        let machine = PreparedMachine::new(&scene.model).unwrap();
        let begin = InitialConditions {
            at: InitialState::Steady,
            ..InitialConditions::default()
        };
        let ready = SimulationSetup::new(&machine, &begin, &asked(0.04, "g.deflection")).unwrap();
        let mut monitor = Monitor {
            cancel: &CancelToken::default(),
            on_progress: &mut |_| {},
        };
        let methods = ["switched".to_string()];
        let found = work_precision::work_precision(&ready, &methods, 10.0, &mut monitor).unwrap();
        found.reference.amplification.unwrap().factor
    };
    let (slow, fast) = (growth(1.0), growth(1000.0));
    println!("{slow:e} {fast:e}");
    assert!(
        slow > 10.0 && fast / slow < 10.0 && slow / fast < 10.0,
        "{slow:e} {fast:e}"
    );
}

/// An oscillation of 7e11 Hz over 10 s: one method alone ends, by 14 steps at any tolerance, and its agreement with itself is no reference.
#[test]
fn refuses_a_reference_that_does_not_resolve_the_motion() {
    let text = r#"
title = "two gears almost without inertia"
source = "made up"
[[inertia]]
name = "pinion"
J = "1e-12 kg·m²"
[[inertia]]
name = "wheel"
J = "1e-12 kg·m²"
[[gear_pair]]
name = "pair"
between = ["pinion", "wheel"]
teeth = [25, 25]
module = "4 mm"
pressure_angle = "20 deg"
k = "4e9 N/µm"
backlash = "100 µm"
damping_ratio = 0.0
contact_damping = "throughout"
[[load]]
at = "pinion"
torque = "93.97 N·m"
[[load]]
at = "wheel"
torque = "93.97 N·m"
[speed]
pinion = "4314.7 rpm"
"#;
    let scene = scene::read_text("x.toml", text).unwrap();
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let request = asked(10.0, "pair.deflection");
    let ready = SimulationSetup::new(&machine, &scene.start, &request).unwrap();
    let mut monitor = Monitor {
        cancel: &CancelToken::default(),
        on_progress: &mut |_| {},
    };
    let Err(error) =
        work_precision::work_precision(&ready, &[], work_precision::TIME_LIMIT, &mut monitor)
    else {
        panic!("a reference that nothing checks");
    };
    assert_eq!(error.code, Code::BudgetExceeded);
    assert!(
        error.message.contains("does not resolve the motion"),
        "{error}"
    );
}
